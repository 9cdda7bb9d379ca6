//! What failed, how often, and what is given up for it: no goal is retried for ever (G item 49).

use crate::record::GivenUp;
use std::collections::BTreeSet;

/// Radius around a failed goal that shares its exclusion, m.
const RADIUS: f64 = 0.5;

/// Distance up to which two cameras are the same view, m.
const SAME_VIEW: f64 = 0.05;

/// A base goal that failed.
#[derive(Clone, Debug)]
struct Exclusion {
    base: [f64; 2],
    failures: u32,
    until: f64,
}

/// Memory of failed goals and given-up places.
#[derive(Clone, Debug, Default)]
pub struct Failures {
    exclusions: Vec<Exclusion>,
    /// Views that were reached in vain, and how often.
    vain: Vec<([f64; 3], u32)>,
    cells: BTreeSet<[i32; 3]>,
    /// Places that are no longer tried, in order.
    pub given_up: Vec<GivenUp>,
}

impl Failures {
    /// True while goals around `base` are excluded.
    pub fn excludes(&self, base: [f64; 2], now: f64) -> bool {
        self.exclusions
            .iter()
            .any(|e| now < e.until && near(e.base, base))
    }

    /// Notes a failure at a base goal; it stays excluded for `first` seconds, twice as long each further time.
    /// Returns how often goals around it have failed.
    pub fn strike(&mut self, base: [f64; 2], now: f64, first: f64) -> u32 {
        let index = self
            .exclusions
            .iter()
            .position(|e| near(e.base, base))
            .unwrap_or_else(|| {
                self.exclusions.push(Exclusion {
                    base,
                    failures: 0,
                    until: now,
                });
                self.exclusions.len() - 1
            });
        let exclusion = &mut self.exclusions[index];
        exclusion.failures += 1;
        exclusion.until = now + first * f64::from(1 << (exclusion.failures - 1).min(10));
        exclusion.failures
    }

    /// Notes that a view was reached and did not show what it promises; `camera` is its position, m. Returns how often that
    /// happened there.
    pub fn reach_in_vain(&mut self, camera: [f64; 3]) -> u32 {
        let same = |other: &[f64; 3]| {
            let square: f64 = (0..3).map(|a| (camera[a] - other[a]).powi(2)).sum();
            square.sqrt() <= SAME_VIEW
        };
        match self.vain.iter_mut().find(|(other, _)| same(other)) {
            Some((_, times)) => {
                *times += 1;
                *times
            }
            None => {
                self.vain.push((camera, 1));
                1
            }
        }
    }

    /// Ends every running exclusion, for the last round before the search is declared complete. True if there were any.
    pub fn lift(&mut self, now: f64) -> bool {
        let mut any = false;
        for exclusion in &mut self.exclusions {
            any |= now < exclusion.until;
            exclusion.until = exclusion.until.min(now);
        }
        any
    }

    /// Gives up frontier voxels for good; they are listed in the result.
    pub fn give_up(&mut self, cells: &[[i32; 3]], place: [f64; 3], reason: &str, now: f64) {
        let before = self.cells.len();
        self.cells.extend(cells.iter().copied());
        let voxels = self.cells.len() - before;
        if voxels > 0 {
            self.given_up.push(GivenUp {
                place,
                voxels,
                reason: reason.to_owned(),
                time_s: now,
            });
        }
    }

    /// True for a voxel that was given up.
    pub fn is_given_up(&self, cell: [i32; 3]) -> bool {
        self.cells.contains(&cell)
    }
}

fn near(a: [f64; 2], b: [f64; 2]) -> bool {
    (a[0] - b[0]).hypot(a[1] - b[1]) <= RADIUS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exclusions_double_and_end() {
        let mut failures = Failures::default();
        assert_eq!(failures.strike([1.0, 1.0], 0.0, 10.0), 1);
        assert!(failures.excludes([1.3, 1.0], 9.9));
        assert!(!failures.excludes([1.3, 1.0], 10.0));
        assert!(!failures.excludes([2.0, 1.0], 5.0));
        assert_eq!(failures.strike([1.2, 1.0], 20.0, 10.0), 2);
        assert!(failures.excludes([1.0, 1.0], 39.9));
        assert!(failures.lift(39.9));
        assert!(!failures.excludes([1.0, 1.0], 39.9));
    }

    #[test]
    fn views_reached_in_vain_are_counted_one_by_one() {
        let mut failures = Failures::default();
        assert_eq!(failures.reach_in_vain([1.0, 2.0, 0.5]), 1);
        assert_eq!(failures.reach_in_vain([1.0, 2.0, 1.5]), 1);
        assert_eq!(failures.reach_in_vain([1.02, 2.0, 0.5]), 2);
    }

    #[test]
    fn a_place_is_listed_once() {
        let mut failures = Failures::default();
        failures.give_up(&[[1, 2, 3]], [0.0; 3], "no view", 5.0);
        failures.give_up(&[[1, 2, 3]], [0.0; 3], "no view", 6.0);
        assert_eq!(failures.given_up.len(), 1);
        assert!(failures.is_given_up([1, 2, 3]));
    }
}
