//! K-means that looks only at what is near: time grows with the number of cells, not with its product with that of clusters.

use crate::Cell;
use crate::cluster::mean;
use crate::params::Params;
use crate::split::{center, square};

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
    let (mut centers, mut owner) = seeds(&points, mean(cells), k);
    for _ in 0..params.kmeans_iterations {
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
        let near = Buckets::new(&centers);
        let mut moved = false;
        for (slot, &p) in owner.iter_mut().zip(&points) {
            let at = near.nearest(p, (square(p, centers[*slot]), *slot));
            moved |= *slot != at;
            *slot = at;
        }
        if !moved {
            break;
        }
    }
    let mut clusters = vec![Vec::new(); k];
    for (&o, &cell) in owner.iter().zip(cells) {
        clusters[o].push(cell);
    }
    clusters.retain(|c| !c.is_empty());
    clusters
}

/// `k` seeds, each the point farthest from those before it (the first from the mean; the first in order of equally far ones),
/// and for each point its nearest seed, the lower one of equally near ones.
fn seeds(points: &[[f64; 3]], middle: [f64; 3], k: usize) -> (Vec<[f64; 3]>, Vec<usize>) {
    let mut first = 0;
    for i in 1..points.len() {
        if square(points[i], middle) > square(points[first], middle) {
            first = i;
        }
    }
    let mut seeds = vec![points[first]];
    let mut owner = vec![0; points.len()];
    let mut reach: Vec<f64> = points.iter().map(|&p| square(p, points[first])).collect();
    let buckets = Buckets::new(points);
    let mut farthest = Farthest::new(&buckets, &reach);
    while seeds.len() < k {
        let (far, at) = farthest.top();
        let seed = points[at];
        // No point is farther from its seed than this one, so a new seed changes nothing that is farther from it.
        for bucket in buckets
            .within(seed, far)
            .flat_map(|(first, last)| first..=last)
        {
            let mut changed = false;
            for &(i, p) in buckets.members(bucket) {
                let d = square(p, seed);
                if d < reach[i] {
                    (reach[i], owner[i]) = (d, seeds.len());
                    changed = true;
                }
            }
            if changed {
                farthest.renew(&buckets, bucket, &reach);
            }
        }
        seeds.push(seed);
    }
    (seeds, owner)
}

/// Points by equal cubes, in the order of their indices within each.
struct Buckets {
    low: [f64; 3],
    edge: f64,
    size: [usize; 3],
    /// Where each bucket begins in `items`, and the end.
    starts: Vec<usize>,
    /// Index and place of each point.
    items: Vec<(usize, [f64; 3])>,
}

/// Least edge of a bucket, cells.
const EDGE: f64 = 8.0;

impl Buckets {
    fn new(points: &[[f64; 3]]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in points {
            for a in 0..3 {
                low[a] = low[a].min(p[a]);
                high[a] = high[a].max(p[a]);
            }
        }
        let sides = |edge: f64| [0, 1, 2].map(|a| ((high[a] - low[a]) / edge) as usize + 1);
        let mut edge = EDGE;
        // Few points far apart need no more buckets than points.
        while sides(edge).iter().map(|&n| n as f64).product::<f64>() > (8 + 8 * points.len()) as f64
        {
            edge *= 2.0;
        }
        let size = sides(edge);
        let mut out = Self {
            low,
            edge,
            size,
            starts: vec![0; size.iter().product::<usize>() + 1],
            items: vec![(0, [0.0; 3]); points.len()],
        };
        for p in points {
            let bucket = out.bucket(*p);
            out.starts[bucket + 1] += 1;
        }
        for b in 1..out.starts.len() {
            out.starts[b] += out.starts[b - 1];
        }
        let mut next = out.starts.clone();
        for (i, p) in points.iter().enumerate() {
            let slot = &mut next[out.bucket(*p)];
            out.items[*slot] = (i, *p);
            *slot += 1;
        }
        out
    }

    /// Number of the bucket along an axis that holds a coordinate, the nearest one for those outside.
    fn along(&self, a: usize, v: f64) -> usize {
        // Saturates at 0.
        (((v - self.low[a]) / self.edge) as usize).min(self.size[a] - 1)
    }

    fn bucket(&self, p: [f64; 3]) -> usize {
        let [x, y, z] = [0, 1, 2].map(|a| self.along(a, p[a]));
        (z * self.size[1] + y) * self.size[0] + x
    }

    fn members(&self, bucket: usize) -> &[(usize, [f64; 3])] {
        &self.items[self.starts[bucket]..self.starts[bucket + 1]]
    }

    /// Rows of buckets, each as its first and last one, that may hold points not farther from `p` than the root of `square`.
    fn within(&self, p: [f64; 3], square: f64) -> impl Iterator<Item = (usize, usize)> + use<> {
        // A hair more, for rounding.
        let radius = square.sqrt() + 1e-6;
        let low = [0, 1, 2].map(|a| self.along(a, p[a] - radius));
        let high = [0, 1, 2].map(|a| self.along(a, p[a] + radius));
        let size = self.size;
        (low[2]..=high[2]).flat_map(move |z| {
            (low[1]..=high[1]).map(move |y| {
                let row = (z * size[1] + y) * size[0];
                (row + low[0], row + high[0])
            })
        })
    }

    /// Index of the nearest of the points, the lower one of equally near ones, given how near any of them is.
    fn nearest(&self, p: [f64; 3], known: (f64, usize)) -> usize {
        let mut best = known;
        for (first, last) in self.within(p, known.0) {
            for &(i, at) in &self.items[self.starts[first]..self.starts[last + 1]] {
                let d = square(p, at);
                if d < best.0 || (d == best.0 && i < best.1) {
                    best = (d, i);
                }
            }
        }
        best.1
    }
}

/// The point of largest reach, by a tournament between buckets.
struct Farthest {
    /// Largest reach and its point's index: the winner of all first, then each round's, buckets last.
    rounds: Vec<(f64, usize)>,
    leaves: usize,
}

/// The larger reach; the lower index of equal ones.
fn farther(a: (f64, usize), b: (f64, usize)) -> (f64, usize) {
    if b.0 > a.0 || (b.0 == a.0 && b.1 < a.1) {
        b
    } else {
        a
    }
}

impl Farthest {
    const NOBODY: (f64, usize) = (f64::NEG_INFINITY, usize::MAX);

    fn new(buckets: &Buckets, reach: &[f64]) -> Self {
        let leaves = (buckets.starts.len() - 1).next_power_of_two();
        let mut out = Self {
            rounds: vec![Self::NOBODY; 2 * leaves],
            leaves,
        };
        for bucket in 0..buckets.starts.len() - 1 {
            out.rounds[leaves + bucket] = Self::of(buckets, bucket, reach);
        }
        for i in (1..leaves).rev() {
            out.rounds[i] = farther(out.rounds[2 * i], out.rounds[2 * i + 1]);
        }
        out
    }

    fn of(buckets: &Buckets, bucket: usize, reach: &[f64]) -> (f64, usize) {
        let members = buckets.members(bucket).iter();
        members.fold(Self::NOBODY, |best, &(i, _)| farther(best, (reach[i], i)))
    }

    fn renew(&mut self, buckets: &Buckets, bucket: usize, reach: &[f64]) {
        let mut i = self.leaves + bucket;
        self.rounds[i] = Self::of(buckets, bucket, reach);
        while i > 1 {
            i /= 2;
            self.rounds[i] = farther(self.rounds[2 * i], self.rounds[2 * i + 1]);
        }
    }

    fn top(&self) -> (f64, usize) {
        self.rounds[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition: every point against every seed and every centre.
    fn slow(cells: &[Cell], params: &Params, k: usize) -> Vec<Vec<Cell>> {
        let points: Vec<[f64; 3]> = cells.iter().map(|&c| center(c)).collect();
        let nearest = |centers: &[[f64; 3]], p: [f64; 3]| {
            (1..centers.len()).fold(0, |best, i| {
                if square(p, centers[i]) < square(p, centers[best]) {
                    i
                } else {
                    best
                }
            })
        };
        let mut centers: Vec<[f64; 3]> = Vec::new();
        while centers.len() < k {
            let reach = |p: [f64; 3]| match centers.len() {
                0 => square(p, mean(cells)),
                _ => square(p, centers[nearest(&centers, p)]),
            };
            let far = (1..points.len()).fold(0, |far, i| {
                if reach(points[i]) > reach(points[far]) {
                    i
                } else {
                    far
                }
            });
            centers.push(points[far]);
        }
        let assign = |centers: &[[f64; 3]]| -> Vec<usize> {
            points.iter().map(|&p| nearest(centers, p)).collect()
        };
        let mut owner = assign(&centers);
        for _ in 0..params.kmeans_iterations {
            for (o, c) in centers.iter_mut().enumerate() {
                let own: Vec<Cell> = (0..cells.len())
                    .filter(|&i| owner[i] == o)
                    .map(|i| cells[i])
                    .collect();
                if !own.is_empty() {
                    *c = mean(&own);
                }
            }
            owner = assign(&centers);
        }
        (0..k)
            .map(|o| {
                let own = (0..cells.len()).filter(|&i| owner[i] == o);
                own.map(|i| cells[i]).collect::<Vec<Cell>>()
            })
            .filter(|c| !c.is_empty())
            .collect()
    }

    /// Cells of a random sheet with holes, a line, a few far apart: each in order.
    fn sets() -> Vec<Vec<Cell>> {
        let mut random = 1u64;
        let mut below = move |n: u64| {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            ((random >> 33) % n) as i32
        };
        let mut out: Vec<Vec<Cell>> = vec![
            (0..900).map(|i| [i, 0, 3]).collect(),
            (0..40)
                .map(|i| [i * 1000 % 7919, i * 37, -i * 911])
                .collect(),
            (0..30)
                .flat_map(|x| (0..30).map(move |y| [x, y, 0]))
                .collect(),
        ];
        for side in [9, 25, 60] {
            out.push(
                (0..800)
                    .map(|_| [below(side), below(side), below(5)])
                    .collect(),
            );
        }
        for set in &mut out {
            set.sort_unstable();
            set.dedup();
        }
        out
    }

    #[test]
    fn looking_only_nearby_gives_the_same_clusters() {
        for cells in sets() {
            for size in [7.0, 60.0, 1000.0] {
                let params = Params {
                    exploration_size: size,
                    exploration_extent: 1e6,
                    ..Params::default()
                };
                let k = (cells.len() as f64 / size).ceil() as usize;
                assert_eq!(kmeans(&cells, &params), slow(&cells, &params, k));
            }
        }
    }

    #[test]
    fn more_clusters_than_cells_are_never_asked_for() {
        let cells = vec![[0, 0, 0], [100_000, 0, 0]];
        let params = Params {
            exploration_extent: 1.0,
            ..Params::default()
        };
        assert_eq!(kmeans(&cells, &params).len(), 2);
    }

    #[test]
    fn every_cell_is_kept_once() {
        let cells: Vec<Cell> = (0..40)
            .flat_map(|x| (0..10).map(move |y| [x, y, 0]))
            .collect();
        let mut all: Vec<Cell> = kmeans(&cells, &Params::default()).concat();
        all.sort_unstable();
        assert_eq!(all, cells);
        assert!(kmeans(&cells, &Params::default()).len() >= 7);
    }
}
