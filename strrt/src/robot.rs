//! What the planner must know about an arm on a moving base.

/// An arm with `N` joints whose base stands at a known pose at each step.
///
/// Laws: the answers depend on the arguments alone; `limits` and `max_speed` never change. Steps run from 0 to the `steps - 1`
/// given to [`plan`](crate::plan); while the base waits, the planner asks about the first or last step again.
pub trait Robot<const N: usize> {
    /// Lowest and highest angle of each joint, rad.
    fn limits(&self) -> [(f64, f64); N];
    /// Top speed of each joint, rad/s.
    fn max_speed(&self) -> [f64; N];
    /// True if the whole body is free with the arm at `q` and the base where it is at `step`.
    fn is_valid(&self, q: &[f64; N], step: usize) -> bool;
    /// True if the motion from `a` at step `from` to `b` at step `to` (the same or the next) is free between its ends, which
    /// are known to be free. The default looks at the middle of the arm's motion with the base at either step;
    /// [`motion_is_clear`](crate::motion_is_clear) is a certain test for robots that know their clearance.
    fn is_motion_valid(&self, a: &[f64; N], b: &[f64; N], from: usize, to: usize) -> bool {
        let middle = std::array::from_fn(|j| 0.5 * (a[j] + b[j]));
        self.is_valid(&middle, from) && (from == to || self.is_valid(&middle, to))
    }
    /// Checks states of several steps at once, `states[i]` at `steps[i]`: true if all are valid. A robot with a vectorised
    /// check overrides this together with [`batch`](Self::batch).
    fn are_valid(&self, states: &[[f64; N]], steps: &[usize]) -> bool {
        states
            .iter()
            .zip(steps)
            .all(|(q, &step)| self.is_valid(q, step))
    }
    /// Checks the motions between consecutive `states` at `steps`: true if all are free.
    fn are_motions_valid(&self, states: &[[f64; N]], steps: &[usize]) -> bool {
        (1..states.len().min(steps.len()))
            .all(|i| self.is_motion_valid(&states[i - 1], &states[i], steps[i - 1], steps[i]))
    }
    /// How many states are worth one call of [`are_valid`](Self::are_valid); 1 for a scalar check.
    fn batch(&self) -> usize {
        1
    }
    /// How deep `q` is in violation at `step`: 0 if valid, more the deeper. Only asked during
    /// [`start_grace`](crate::Params::start_grace), where it must never grow; the default knows valid from not.
    fn depth(&self, q: &[f64; N], step: usize) -> f64 {
        if self.is_valid(q, step) { 0.0 } else { 1.0 }
    }
    /// True if nothing but the arm moves: no answer depends on a step, and a motion is as free one way as the other. The search
    /// then leaves time out, which is much quicker, and the arm moves at once and as fast as its joints can. Not used by
    /// [`Variant::Published`](crate::Variant::Published), nor with [`start_grace`](crate::Params::start_grace) or
    /// [`acceleration`](crate::Params::acceleration), which are about time.
    fn is_static(&self) -> bool {
        false
    }
    /// False if no joint state can be free at `step` because the base itself is not. Asked once for each step.
    fn base_is_valid(&self, step: usize) -> bool {
        let _ = step;
        true
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
    fn are_motions_valid(&self, states: &[[f64; N]], steps: &[usize]) -> bool {
        (**self).are_motions_valid(states, steps)
    }
    fn batch(&self) -> usize {
        (**self).batch()
    }
    fn depth(&self, q: &[f64; N], step: usize) -> f64 {
        (**self).depth(q, step)
    }
    fn is_static(&self) -> bool {
        (**self).is_static()
    }
    fn base_is_valid(&self, step: usize) -> bool {
        (**self).base_is_valid(step)
    }
}
