//! Robots from closures, and a certain test of motions for robots that know their clearance.

use std::collections::VecDeque;

use crate::robot::Robot;

/// Stretches of a motion that are kept to be looked at from coarse to fine.
const WIDEST: usize = 64;

/// A [`Robot`] from a predicate on one state; see [`from_fn`].
#[derive(Clone, Debug)]
pub struct FromFn<const N: usize, F> {
    limits: [(f64, f64); N],
    max_speed: [f64; N],
    valid: F,
}

/// A robot whose validity is `valid(q, step)`: limits in rad, speeds in rad/s.
///
/// ```
/// let arm = strrt::from_fn([(-3.0, 3.0)], [0.8], |q: &[f64; 1], step| q[0] < 0.1 * step as f64);
/// let found = strrt::plan(&arm, [-1.0], [1.0], 40, 0.1, &strrt::Params::default(), 7)?;
/// assert_eq!(found.status, strrt::Status::Solved);
/// # Ok::<(), strrt::Error>(())
/// ```
pub fn from_fn<const N: usize, F: Fn(&[f64; N], usize) -> bool>(
    limits: [(f64, f64); N],
    max_speed: [f64; N],
    valid: F,
) -> FromFn<N, F> {
    FromFn {
        limits,
        max_speed,
        valid,
    }
}

impl<const N: usize, F: Fn(&[f64; N], usize) -> bool> Robot<N> for FromFn<N, F> {
    fn limits(&self) -> [(f64, f64); N] {
        self.limits
    }
    fn max_speed(&self) -> [f64; N] {
        self.max_speed
    }
    fn is_valid(&self, q: &[f64; N], step: usize) -> bool {
        (self.valid)(q, step)
    }
}

/// A [`Robot`] from a predicate on many states; see [`from_batch_fn`].
#[derive(Clone, Debug)]
pub struct FromBatchFn<const N: usize, F> {
    limits: [(f64, f64); N],
    max_speed: [f64; N],
    batch: usize,
    valid: F,
}

/// A robot whose validity is `valid(states, steps)`, true if every state is free at its step. `batch` is the number of states
/// that one call likes best (the vector width); calls may hold fewer or more.
pub fn from_batch_fn<const N: usize, F: Fn(&[[f64; N]], &[usize]) -> bool>(
    limits: [(f64, f64); N],
    max_speed: [f64; N],
    batch: usize,
    valid: F,
) -> FromBatchFn<N, F> {
    FromBatchFn {
        limits,
        max_speed,
        batch: batch.max(1),
        valid,
    }
}

impl<const N: usize, F: Fn(&[[f64; N]], &[usize]) -> bool> Robot<N> for FromBatchFn<N, F> {
    fn limits(&self) -> [(f64, f64); N] {
        self.limits
    }
    fn max_speed(&self) -> [f64; N] {
        self.max_speed
    }
    fn is_valid(&self, q: &[f64; N], step: usize) -> bool {
        (self.valid)(&[*q], &[step])
    }
    fn are_valid(&self, states: &[[f64; N]], steps: &[usize]) -> bool {
        (self.valid)(states, steps)
    }
    fn are_motions_valid(&self, states: &[[f64; N]], steps: &[usize]) -> bool {
        let (mut middles, mut at) = (
            Vec::with_capacity(2 * self.batch),
            Vec::with_capacity(2 * self.batch),
        );
        for (pair, when) in states.windows(2).zip(steps.windows(2)) {
            let middle: [f64; N] = std::array::from_fn(|j| 0.5 * (pair[0][j] + pair[1][j]));
            for &step in &when[..if when[0] == when[1] { 1 } else { 2 }] {
                middles.push(middle);
                at.push(step);
            }
            if middles.len() >= self.batch {
                if !(self.valid)(&middles, &at) {
                    return false;
                }
                middles.clear();
                at.clear();
            }
        }
        middles.is_empty() || (self.valid)(&middles, &at)
    }
    fn batch(&self) -> usize {
        self.batch
    }
}

/// True if a motion over `[0, 1]` keeps clear of everything, by bisection: a stretch is clear when the clearance in its middle
/// is at least the travel of its half.
///
/// `clearance(t)` is the least distance, m, between any body point and what it must not touch; `travel` bounds, in m, how
/// much that distance can change over the whole motion (for a chain: base translation, plus base turn times reach, plus each
/// joint's motion times the reach beyond it). Stretches with less travel than `resolution` m count as clear when their middle
/// has positive clearance; what is left undetected is at most half that deep.
pub fn motion_is_clear(clearance: impl Fn(f64) -> f64, travel: f64, resolution: f64) -> bool {
    // Stretches to look at, each with its travel and how often it may still be halved, so that infinite travel ends.
    let mut open = VecDeque::from([(0.0, 1.0, travel, 24u32)]);
    loop {
        // Coarse before fine, so that a blocked motion is refused soon; but not too many at a time.
        let next = if open.len() < WIDEST {
            open.pop_front()
        } else {
            open.pop_back()
        };
        let Some((from, to, travel, halvings)) = next else {
            return true;
        };
        let middle = 0.5 * (from + to);
        let room = clearance(middle);
        // NaN is not clear.
        if room.is_nan() || room <= 0.0 {
            return false;
        }
        if room >= 0.5 * travel || travel <= resolution || halvings == 0 {
            continue;
        }
        // The middle part within `room` is clear already; look at what is left on either side.
        let (part, left) = ((room / travel) * (to - from), 0.5 * travel - room);
        open.push_back((from, middle - part, left, halvings - 1));
        open.push_back((middle + part, to, left, halvings - 1));
    }
}
