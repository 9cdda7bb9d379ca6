//! The problem in time: steps, waits, speeds, and the timed straight line.

use crate::error::Error;
use crate::robot::Robot;

/// Slack on speed limits against rounding.
const SLACK: f64 = 1e-9;

/// Least number of time steps of `dt` s that a straight motion needs within the joints' speeds.
pub fn steps_needed<const N: usize>(
    from: &[f64; N],
    to: &[f64; N],
    max_speed: &[f64; N],
    dt: f64,
) -> usize {
    (0..N)
        .map(|j| {
            ((to[j] - from[j]).abs() / (max_speed[j] * dt) - SLACK)
                .ceil()
                .max(0.0) as usize
        })
        .max()
        .unwrap_or(0)
}

/// The straight motion at even speed, one state per step, if it is within the joints' speeds and free; `None` otherwise.
///
/// # Errors
/// [`Error`] for no steps, a bad `dt`, limits or speeds, or ends outside the limits.
pub fn straight<const N: usize>(
    robot: &impl Robot<N>,
    start: [f64; N],
    goal: [f64; N],
    steps: usize,
    dt: f64,
) -> Result<Option<Vec<[f64; N]>>, Error> {
    let task = Task::new(robot, start, goal, steps, dt)?;
    Ok(task.line(&start, 0, &goal, task.last()))
}

/// One problem with a fixed number of steps, waits included.
pub(crate) struct Task<'a, const N: usize, R> {
    pub robot: &'a R,
    pub limits: [(f64, f64); N],
    /// Largest joint motion of one step, rad.
    pub reach: [f64; N],
    /// Poses of the base.
    pub steps: usize,
    /// Steps that the base waits before its first pose is left, and after the last is reached.
    pub before: usize,
    pub after: usize,
    /// First steps whose states need not be valid.
    pub grace: usize,
}

impl<'a, const N: usize, R: Robot<N>> Task<'a, N, R> {
    pub(crate) fn new(
        robot: &'a R,
        start: [f64; N],
        goal: [f64; N],
        steps: usize,
        dt: f64,
    ) -> Result<Self, Error> {
        if steps == 0 {
            return Err(Error::NoSteps);
        }
        if !(dt > 0.0 && dt.is_finite()) {
            return Err(Error::TimeStep(dt));
        }
        let (limits, speeds) = (robot.limits(), robot.max_speed());
        for joint in 0..N {
            let (low, high) = limits[joint];
            if !(low <= high && low.is_finite() && high.is_finite()) {
                return Err(Error::Limits { joint, low, high });
            }
            let speed = speeds[joint];
            if !(speed > 0.0 && speed.is_finite()) {
                return Err(Error::Speed { joint, speed });
            }
            for (which, q) in [("start", &start), ("goal", &goal)] {
                let angle = q[joint];
                if !(low..=high).contains(&angle) {
                    return Err(Error::OutsideLimits {
                        which,
                        joint,
                        angle,
                        low,
                        high,
                    });
                }
            }
        }
        Ok(Self {
            robot,
            limits,
            reach: speeds.map(|v| v * dt),
            steps,
            before: 0,
            after: 0,
            grace: 0,
        })
    }

    /// Index of the last step, waits included.
    pub(crate) fn last(&self) -> usize {
        self.before + self.steps + self.after - 1
    }

    /// The base's step at a step of the whole motion.
    pub(crate) fn base_step(&self, step: usize) -> usize {
        step.saturating_sub(self.before).min(self.steps - 1)
    }

    pub(crate) fn is_valid(&self, q: &[f64; N], step: usize) -> bool {
        step < self.grace || self.robot.is_valid(q, self.base_step(step))
    }

    /// True if `b` can follow `a` one step later: within speed, free at `b` and between.
    pub(crate) fn can_step(&self, a: &[f64; N], b: &[f64; N], from: usize) -> bool {
        self.within_reach(a, b, 1)
            && self.is_valid(b, from + 1)
            && (from < self.grace
                || self
                    .robot
                    .is_motion_valid(a, b, self.base_step(from), self.base_step(from + 1)))
    }

    pub(crate) fn within_reach(&self, a: &[f64; N], b: &[f64; N], steps: usize) -> bool {
        (0..N).all(|j| (b[j] - a[j]).abs() <= self.reach[j] * steps as f64 + SLACK)
    }

    /// The states of the straight motion from `a` at step `from` to `b` at step `to`, both ends included, if it is fast enough
    /// and free. `a` itself is taken to be free. Looked at from coarse to fine, so that a blocked line is refused soon.
    pub(crate) fn line(
        &self,
        a: &[f64; N],
        from: usize,
        b: &[f64; N],
        to: usize,
    ) -> Option<Vec<[f64; N]>> {
        if to < from || !self.within_reach(a, b, to - from) {
            return None;
        }
        if to == from {
            return Some(vec![*a]);
        }
        let n = to - from;
        let state = |i: usize| {
            let t = i as f64 / n as f64;
            if i == n {
                *b
            } else {
                std::array::from_fn(|j| a[j] + t * (b[j] - a[j]))
            }
        };
        let path: Vec<[f64; N]> = (0..=n).map(state).collect();
        let mut stride = n.next_power_of_two();
        let mut looked = vec![false; n + 1];
        while stride > 0 {
            for i in (stride..=n).step_by(stride).chain([n]) {
                if !looked[i] {
                    looked[i] = true;
                    if !self.is_valid(&path[i], from + i) {
                        return None;
                    }
                }
            }
            stride /= 2;
        }
        for i in 0..n {
            let step = from + i;
            let (here, next) = (self.base_step(step), self.base_step(step + 1));
            if step >= self.grace
                && !self
                    .robot
                    .is_motion_valid(&path[i], &path[i + 1], here, next)
            {
                return None;
            }
        }
        Some(path)
    }
}

/// Euclidean joint distance.
pub(crate) fn distance<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    (0..N).map(|j| (a[j] - b[j]).powi(2)).sum::<f64>().sqrt()
}

/// Sum of joint distances along a path: HEATS's cost.
pub(crate) fn cost<const N: usize>(path: &[[f64; N]]) -> f64 {
    path.windows(2).map(|w| distance(&w[0], &w[1])).sum()
}
