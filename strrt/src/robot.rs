//! What the planner must know about an arm on a moving base.

/// An arm with `N` joints whose base stands at a known pose at each step.
///
/// Laws: the answers depend on the arguments alone; `limits` and `max_speed` never change. Steps run from 0 to the `steps - 1`
/// given to [`plan`](crate::plan); while the planner waits, it asks about the first or last step again.
pub trait Robot<const N: usize> {
    /// Lowest and highest angle of each joint, rad.
    fn limits(&self) -> [(f64, f64); N];
    /// Top speed of each joint, rad/s.
    fn max_speed(&self) -> [f64; N];
    /// True if the whole body is free with the arm at `q` and the base where it is at `step`.
    fn is_valid(&self, q: &[f64; N], step: usize) -> bool;
    /// True if the motion from `a` at step `from` to `b` at step `to` (the same or the next) is free between its ends. The
    /// default looks at the middle, with the base at either step.
    fn is_motion_valid(&self, a: &[f64; N], b: &[f64; N], from: usize, to: usize) -> bool {
        let middle = std::array::from_fn(|j| 0.5 * (a[j] + b[j]));
        self.is_valid(&middle, from) && (from == to || self.is_valid(&middle, to))
    }
    /// Checks states of several steps at once, `states[i]` at `steps[i]`: true if all are valid. A robot with a vectorised check
    /// overrides this.
    fn are_valid(&self, states: &[[f64; N]], steps: &[usize]) -> bool {
        states
            .iter()
            .zip(steps)
            .all(|(q, &step)| self.is_valid(q, step))
    }
}

impl<const N: usize, R: Robot<N> + ?Sized> Robot<N> for &R {
    fn limits(&self) -> [(f64, f64); N] {
        (**self).limits()
    }
    fn max_speed(&self) -> [f64; N] {
        (**self).max_speed()
    }
    fn is_valid(&self, q: &[f64; N], step: usize) -> bool {
        (**self).is_valid(q, step)
    }
    fn is_motion_valid(&self, a: &[f64; N], b: &[f64; N], from: usize, to: usize) -> bool {
        (**self).is_motion_valid(a, b, from, to)
    }
    fn are_valid(&self, states: &[[f64; N]], steps: &[usize]) -> bool {
        (**self).are_valid(states, steps)
    }
}
