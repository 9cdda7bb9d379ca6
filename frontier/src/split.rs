//! Cutting a set of cells by halving along its principal axis.

use crate::Cell;
use crate::cluster::mean;

pub(crate) fn square(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum()
}

pub(crate) fn center(cell: Cell) -> [f64; 3] {
    cell.map(|v| f64::from(v) + 0.5)
}

/// Halves a set perpendicular to its first principal axis until no cell is farther than `radius` from its part's mean.
pub(crate) fn halve(cells: Vec<Cell>, radius: f64, out: &mut Vec<Vec<Cell>>) {
    let middle = mean(&cells);
    let far = cells
        .iter()
        .map(|&c| square(center(c), middle))
        .fold(0.0, f64::max);
    if far <= radius * radius || cells.len() < 2 {
        out.push(cells);
        return;
    }
    let axis = principal_axis(&cells, middle);
    let side = |c: &Cell| {
        (0..3)
            .map(|a| (center(*c)[a] - middle[a]) * axis[a])
            .sum::<f64>()
            < 0.0
    };
    let (left, right): (Vec<Cell>, Vec<Cell>) = cells.iter().partition(|c| side(c));
    if left.is_empty() || right.is_empty() {
        out.push(cells);
        return;
    }
    halve(left, radius, out);
    halve(right, radius, out);
}

/// Direction of largest spread, by power iteration on the covariance.
fn principal_axis(cells: &[Cell], middle: [f64; 3]) -> [f64; 3] {
    let mut cov = [[0.0; 3]; 3];
    for &cell in cells {
        let d = center(cell);
        for i in 0..3 {
            for j in 0..3 {
                cov[i][j] += (d[i] - middle[i]) * (d[j] - middle[j]);
            }
        }
    }
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
