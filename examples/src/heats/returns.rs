//! What the returns of a noisy range sensor are worth to a voxel map.
//!
//! A map that takes each return for a filled cell fills up: a floor seen at a flat angle stands in the way as soon as half its
//! returns lie a centimetre above it, and walls seen from afar grow inwards by a cell for each 7 m at 1 % of noise.

/// Returns that scatter by more than this share of a cell fill none: one in 20 would lie more than half a cell off.
const SHARPEST: f64 = 0.25;
/// Deviations by which a return may lie above the floor and still be its own: of thousands a second, on cells not seen before, none
/// may stand in the way.
const FLOOR: f64 = 5.0;
/// Deviations by which a ray that fills no cell ends short of its return.
const SHORT: f64 = 3.0;
/// Below the floor by this, a return counts as the floor's own, m.
const SUNK: f64 = 1e-4;

/// Sorts returns by what they are good for.
#[derive(Clone, Debug)]
pub(super) struct Returns {
    /// Standard deviation of a range as a share of it.
    sigma: f64,
    cell_size: f64,
    /// Height of the floor, on which the robot stands, m.
    floor: f64,
    hits: Vec<[f32; 3]>,
    misses: Vec<[f32; 3]>,
}

impl Returns {
    /// For a sensor whose ranges scatter by the share `sigma`.
    pub(super) fn new(sigma: f64, cell_size: f64, floor: f64) -> Self {
        Self {
            sigma,
            cell_size,
            floor,
            hits: Vec::new(),
            misses: Vec::new(),
        }
    }

    /// The returns to fill cells with and the ends of rays that only free: what may be the floor is the floor; what is too far to
    /// tell its cell frees the space before it.
    pub(super) fn sort(
        &mut self,
        origin: [f64; 3],
        hits: &[[f32; 3]],
        misses: &[[f32; 3]],
    ) -> (&[[f32; 3]], &[[f32; 3]]) {
        self.hits.clear();
        self.misses.clear();
        self.misses.extend_from_slice(misses);
        for hit in hits {
            let ray = [0, 1, 2].map(|k| f64::from(hit[k]) - origin[k]);
            let range = ray.iter().map(|v| v * v).sum::<f64>().sqrt();
            let at = |share: f64| [0, 1, 2].map(|k| (origin[k] + share * ray[k]) as f32);
            let fall = -ray[2];
            if fall > 0.0 && f64::from(hit[2]) - self.floor <= FLOOR * self.sigma * fall {
                self.hits.push(at((origin[2] - self.floor + SUNK) / fall));
            } else if self.sigma * range > SHARPEST * self.cell_size {
                self.misses.push(at(1.0 - (SHORT * self.sigma).min(1.0)));
            } else {
                self.hits.push(*hit);
            }
        }
        (&self.hits, &self.misses)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_return_is_sorted_by_where_it_may_come_from() {
        let mut returns = Returns::new(0.01, 0.1, 0.0);
        let origin = [0.0, 0.0, 0.5];
        // A wall 1 m away; the floor, 4 mm too near; a box 0.1 m high; a wall 4 m away.
        let hits = [
            [1.0, 0.0, 0.6],
            [1.98, 0.0, 0.004],
            [1.6, 0.0, 0.1],
            [4.0, 0.0, 0.5],
        ];
        let (hits, misses) = returns.sort(origin, &hits, &[[9.0, 0.0, 0.5]]);
        assert_eq!(hits.len(), 3);
        assert_eq!((hits[0], hits[2]), ([1.0, 0.0, 0.6], [1.6, 0.0, 0.1]));
        assert!(hits[1][2] < 0.0 && hits[1][2] > -2e-4, "{:?}", hits[1]);
        assert!((hits[1][0] - 1.9964).abs() < 1e-3, "{:?}", hits[1]);
        assert_eq!(misses, [[9.0, 0.0, 0.5], [3.88, 0.0, 0.5]]);
    }
}
