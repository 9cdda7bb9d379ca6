//! Cutting a set of cells by halving along its principal axis.

use crate::Cell;

pub(crate) fn square(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum()
}

pub(crate) fn center(cell: Cell) -> [f64; 3] {
    cell.map(|v| f64::from(v) + 0.5)
}

/// Sorts cells, the first coordinate first.
pub(crate) fn sort(cells: &mut [Cell]) {
    // One number a cell, which compares without branches.
    let [x, y, z] = [64, 32, 0];
    let key = |v: i32, shift: u32| u128::from(v as u32 ^ 1 << 31) << shift;
    cells.sort_unstable_by_key(|c| key(c[0], x) | key(c[1], y) | key(c[2], z));
}

/// Halves a set perpendicular to its first principal axis until no cell is farther than `radius` from its part's mean. The order
/// of the cells does not matter.
pub(crate) fn halve(mut cells: Vec<Cell>, radius: f64, out: &mut Vec<Vec<Cell>>) {
    halve_in_place(&mut cells, radius, out);
}

fn halve_in_place(cells: &mut [Cell], radius: f64, out: &mut Vec<Vec<Cell>>) {
    let Some(&origin) = cells.first() else {
        return;
    };
    let moments = Moments::new(cells, origin);
    if moments.near(cells, radius) {
        return out.push(cells.to_vec());
    }
    let axis = principal_axis(&moments.covariance());
    let middle = moments.middle();
    let side = |c: Cell| {
        (0..3)
            .map(|a| (center(c)[a] - middle[a]) * axis[a])
            .sum::<f64>()
            < 0.0
    };
    let mut left = 0;
    for i in 0..cells.len() {
        // Swapped in any case, so that there is no branch to guess.
        let cell = cells[i];
        cells.swap(i, left);
        left += usize::from(side(cell));
    }
    if left == 0 || left == cells.len() {
        return out.push(cells.to_vec());
    }
    let (left, right) = cells.split_at_mut(left);
    halve_in_place(left, radius, out);
    halve_in_place(right, radius, out);
}

/// Sums over the cells of a set, relative to one of them: whole numbers, so that their order does not matter as long as they are
/// below 2^53.
struct Moments {
    origin: Cell,
    count: f64,
    sum: [f64; 3],
    /// Of xx, yy, zz, xy, xz, yz.
    squares: [f64; 6],
    low: Cell,
    high: Cell,
}

impl Moments {
    fn new(cells: &[Cell], origin: Cell) -> Self {
        let mut out = Self {
            origin,
            count: cells.len() as f64,
            sum: [0.0; 3],
            squares: [0.0; 6],
            low: origin,
            high: origin,
        };
        for &cell in cells {
            let [x, y, z] = [0, 1, 2].map(|a| f64::from(cell[a]) - f64::from(origin[a]));
            for (sum, v) in out.sum.iter_mut().zip([x, y, z]) {
                *sum += v;
            }
            for (sum, v) in out
                .squares
                .iter_mut()
                .zip([x * x, y * y, z * z, x * y, x * z, y * z])
            {
                *sum += v;
            }
            for a in 0..3 {
                out.low[a] = out.low[a].min(cell[a]);
                out.high[a] = out.high[a].max(cell[a]);
            }
        }
        out
    }

    fn middle(&self) -> [f64; 3] {
        [0, 1, 2].map(|a| f64::from(self.origin[a]) + self.sum[a] / self.count + 0.5)
    }

    /// True if no cell is farther than `radius` from the mean.
    fn near(&self, cells: &[Cell], radius: f64) -> bool {
        let middle = self.middle();
        let (low, high) = (center(self.low), center(self.high));
        // The box around the cells mostly tells: one of them lies on each of its faces, none beyond.
        let reach = [0, 1, 2].map(|a| (middle[a] - low[a]).max(high[a] - middle[a]));
        if reach.iter().any(|&r| r > radius) {
            return cells.len() < 2;
        }
        square(reach, [0.0; 3]) <= radius * radius
            || cells
                .iter()
                .all(|&c| square(center(c), middle) <= radius * radius)
    }

    fn covariance(&self) -> [[f64; 3]; 3] {
        let [xx, yy, zz, xy, xz, yz] = self.squares;
        let mut out = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        for i in 0..3 {
            for j in 0..3 {
                out[i][j] -= self.sum[i] * self.sum[j] / self.count;
            }
        }
        out
    }
}

/// Direction of largest spread, by power iteration on the covariance.
fn principal_axis(cov: &[[f64; 3]; 3]) -> [f64; 3] {
    // The axis of largest variance has a part along the wanted direction, unless that part is exactly zero.
    let mut longest = 0;
    for a in 1..3 {
        if cov[a][a] > cov[longest][longest] {
            longest = a;
        }
    }
    let mut axis = [0.0; 3];
    axis[longest] = 1.0;
    for _ in 0..32 {
        let next = [0, 1, 2].map(|i| (0..3).map(|j| cov[i][j] * axis[j]).sum::<f64>());
        let norm = next.iter().map(|v| v * v).sum::<f64>().sqrt();
        if norm <= 0.0 {
            break;
        }
        axis = next.map(|v| v / norm);
    }
    axis
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_wall_is_halved_into_short_pieces() {
        let wall: Vec<Cell> = (0..64)
            .flat_map(|x| (0..4).map(move |z| [x, 0, z]))
            .collect();
        let mut parts = Vec::new();
        halve(wall.clone(), 8.0, &mut parts);
        assert!(parts.len() >= 4);
        let mut all: Vec<Cell> = parts.concat();
        all.sort_unstable();
        assert_eq!(all, wall);
    }
}
