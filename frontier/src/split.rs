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

/// Centres in the order of one coordinate, the one they spread along most, so that a search can stop early.
struct Along {
    axis: usize,
    /// Coordinate, index and centre.
    sorted: Vec<(f64, usize, [f64; 3])>,
}

impl Along {
    fn new(centers: &[[f64; 3]]) -> Self {
        let spread = |a: usize| {
            let (low, high) = centers
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| {
                    (l.min(c[a]), h.max(c[a]))
                });
            high - low
        };
        let axis = (1..3).fold(0, |best, a| if spread(a) > spread(best) { a } else { best });
        let mut sorted: Vec<_> = centers
            .iter()
            .enumerate()
            .map(|(i, &c)| (c[axis], i, c))
            .collect();
        sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        Self { axis, sorted }
    }

    /// Index of the nearest centre, the lower one of equally near ones.
    fn nearest(&self, p: [f64; 3]) -> usize {
        let here = p[self.axis];
        let start = self.sorted.partition_point(|c| c.0 < here);
        let mut best = (f64::INFINITY, usize::MAX);
        let mut look = |&(x, i, c): &(f64, usize, [f64; 3])| {
            // Nothing further out can be nearer, nor as near.
            if (x - here).powi(2) > best.0 {
                return false;
            }
            let d = square(p, c);
            if d < best.0 || (d == best.0 && i < best.1) {
                best = (d, i);
            }
            true
        };
        let (mut left, mut right) = (
            self.sorted[..start].iter().rev(),
            self.sorted[start..].iter(),
        );
        let (mut go_left, mut go_right) = (true, true);
        while go_left || go_right {
            go_right = go_right && right.next().is_some_and(&mut look);
            go_left = go_left && left.next().is_some_and(&mut look);
        }
        best.1
    }
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
        let along = Along::new(&centers);
        for (slot, &p) in owner.iter_mut().zip(&points) {
            let at = along.nearest(p);
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
    fn the_nearest_centre_is_found_and_ties_go_to_the_lower_index() {
        let centers: Vec<[f64; 3]> = (0..60)
            .map(|k| [k * 7 % 13, k * 5 % 11, k * 3 % 7].map(f64::from))
            .collect();
        let along = Along::new(&centers);
        for k in 0..500 {
            let p = [k * 3 % 29, k * 5 % 23, k * 7 % 17].map(|v| f64::from(v) * 0.5);
            let mut slow = 0;
            for i in 1..centers.len() {
                if square(p, centers[i]) < square(p, centers[slow]) {
                    slow = i;
                }
            }
            assert_eq!(along.nearest(p), slow);
        }
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
