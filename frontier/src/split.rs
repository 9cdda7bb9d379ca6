//! Ways to cut a set of cells into clusters: k-means, region growing by normals, and halving along the principal axis.

use crate::Cell;
use crate::cluster::mean;
use crate::params::Params;

fn square(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum()
}

fn center(cell: Cell) -> [f64; 3] {
    cell.map(|v| f64::from(v) + 0.5)
}

/// K-means with K = ceil(max(n / size, extent / wanted extent)), seeded by farthest points from the mean, so that equal input
/// gives equal clusters. Empty clusters vanish.
pub(crate) fn kmeans(cells: &[Cell], params: &Params) -> Vec<Vec<Cell>> {
    let extent = (0..3)
        .map(|a| {
            let (low, high) = cells
                .iter()
                .fold((i32::MAX, i32::MIN), |(l, h), c| (l.min(c[a]), h.max(c[a])));
            f64::from(high - low) + 1.0
        })
        .fold(0.0, f64::max);
    let wanted =
        (cells.len() as f64 / params.exploration_size).max(extent / params.exploration_extent);
    let k = (wanted.ceil() as usize).clamp(1, cells.len());
    if k == 1 {
        return vec![cells.to_vec()];
    }
    let points: Vec<[f64; 3]> = cells.iter().map(|&c| center(c)).collect();
    // Farthest-point seeding: the first seed is the point farthest from the mean.
    let mut centers: Vec<[f64; 3]> = Vec::with_capacity(k);
    let mut reach: Vec<f64> = {
        let middle = mean(cells);
        points.iter().map(|&p| square(p, middle)).collect()
    };
    for _ in 0..k {
        let mut far = 0;
        for i in 1..points.len() {
            if reach[i] > reach[far] {
                far = i;
            }
        }
        let seed = points[far];
        if centers.is_empty() {
            reach.fill(f64::INFINITY);
        }
        centers.push(seed);
        for (r, &p) in reach.iter_mut().zip(&points) {
            *r = r.min(square(p, seed));
        }
    }
    let mut owner = vec![0usize; points.len()];
    for round in 0..=params.kmeans_iterations {
        let mut moved = false;
        for (slot, &p) in owner.iter_mut().zip(&points) {
            let (mut best, mut at) = (f64::INFINITY, 0);
            for (i, &c) in centers.iter().enumerate() {
                let d = square(p, c);
                if d < best {
                    (best, at) = (d, i);
                }
            }
            moved |= *slot != at;
            *slot = at;
        }
        if (!moved && round > 0) || round == params.kmeans_iterations {
            break;
        }
        let mut sums = vec![([0.0; 3], 0.0f64); k];
        for (&o, &p) in owner.iter().zip(&points) {
            for a in 0..3 {
                sums[o].0[a] += p[a];
            }
            sums[o].1 += 1.0;
        }
        for (c, (sum, n)) in centers.iter_mut().zip(sums) {
            if n > 0.0 {
                *c = sum.map(|v| v / n);
            }
        }
    }
    let mut clusters = vec![Vec::new(); k];
    for (&o, &cell) in owner.iter().zip(cells) {
        clusters[o].push(cell);
    }
    clusters.retain(|c| !c.is_empty());
    clusters
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

    #[test]
    fn kmeans_keeps_every_cell_once() {
        let cells: Vec<Cell> = (0..40)
            .flat_map(|x| (0..10).map(move |y| [x, y, 0]))
            .collect();
        let mut all: Vec<Cell> = kmeans(&cells, &Params::default()).concat();
        all.sort_unstable();
        assert_eq!(all, cells);
        assert!(kmeans(&cells, &Params::default()).len() >= 7);
    }
}
