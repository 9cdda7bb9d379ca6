//! One problem in time: steps, waits, speeds, validity, and the timed straight line.

use std::cell::Cell;

use crate::error::Error;
use crate::robot::Robot;

/// Slack on speed limits against rounding, rad.
const SLACK: f64 = 1e-9;

/// Steps that the base waits before its first pose is left, and after its last is reached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Waits {
    pub before: usize,
    pub after: usize,
}

/// The problem: everything that does not depend on the waits.
pub(crate) struct Task<'a, const N: usize, R> {
    pub robot: &'a R,
    pub start: [f64; N],
    pub goal: [f64; N],
    pub limits: [(f64, f64); N],
    /// Largest joint motion of one step, rad.
    pub reach: [f64; N],
    /// Poses of the base.
    pub steps: usize,
    pub dt: f64,
    /// First steps whose states need not be valid.
    pub grace: usize,
    /// States that the robot was asked about.
    pub checks: Cell<u64>,
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
            start,
            goal,
            limits,
            reach: speeds.map(|v| v * dt),
            steps,
            dt,
            grace: 0,
            checks: Cell::new(0),
        })
    }
}

/// A task with its waits: the clock of one search.
#[derive(Clone, Copy)]
pub(crate) struct Timed<'t, 'a, const N: usize, R> {
    pub task: &'t Task<'a, N, R>,
    pub waits: Waits,
}

impl<'a, const N: usize, R: Robot<N>> Timed<'_, 'a, N, R> {
    /// Index of the last step, waits included.
    pub(crate) fn last(&self) -> usize {
        self.waits.before + self.task.steps + self.waits.after - 1
    }

    /// The base's step at a step of the whole motion.
    pub(crate) fn base_step(&self, step: usize) -> usize {
        step.saturating_sub(self.waits.before)
            .min(self.task.steps - 1)
    }

    fn count(&self, states: usize) {
        let checks = &self.task.checks;
        checks.set(checks.get() + states as u64);
    }

    pub(crate) fn is_valid(&self, q: &[f64; N], step: usize) -> bool {
        if step < self.task.grace {
            return true;
        }
        self.count(1);
        self.task.robot.is_valid(q, self.base_step(step))
    }

    /// True if the motion from `a` at step `from` to `b` one step later is free between its ends, which are.
    pub(crate) fn is_motion_valid(&self, a: &[f64; N], b: &[f64; N], from: usize) -> bool {
        let (here, next) = (self.base_step(from), self.base_step(from + 1));
        if from < self.task.grace {
            // Leaving: never deeper; once out, stay out.
            let depth = self.task.robot.depth(a, here);
            if depth > 0.0 {
                return self.task.robot.depth(b, next) <= depth;
            }
            if !self.task.robot.is_valid(b, next) {
                return false;
            }
        }
        self.count(1);
        self.task.robot.is_motion_valid(a, b, here, next)
    }

    /// True if `b` can follow `a` one step later: within speed, and free on the way; both are free.
    pub(crate) fn can_step(&self, a: &[f64; N], b: &[f64; N], from: usize) -> bool {
        self.within_reach(a, b, 1) && self.is_motion_valid(a, b, from)
    }

    pub(crate) fn within_reach(&self, a: &[f64; N], b: &[f64; N], steps: usize) -> bool {
        (0..N).all(|j| (b[j] - a[j]).abs() <= self.task.reach[j] * steps as f64 + SLACK)
    }

    /// True if the path that starts at step `from` is free between its ends, which are known to be free. Speeds are the
    /// caller's concern. Looked at from coarse to fine, so that a blocked path is refused soon.
    pub(crate) fn path_is_free(&self, path: &[[f64; N]], from: usize) -> bool {
        let n = path.len().saturating_sub(1);
        if n == 0 {
            return true;
        }
        let (robot, batch) = (self.task.robot, self.task.robot.batch().max(1));
        let (mut states, mut steps) = (Vec::with_capacity(batch), Vec::with_capacity(batch));
        // Odd multiples of falling powers of two meet every inner index once.
        let mut stride = n.next_power_of_two();
        while stride > 0 {
            for i in (stride..n).step_by(2 * stride) {
                if from + i < self.task.grace {
                    continue;
                }
                if batch == 1 {
                    if !self.is_valid(&path[i], from + i) {
                        return false;
                    }
                    continue;
                }
                states.push(path[i]);
                steps.push(self.base_step(from + i));
                if states.len() == batch {
                    self.count(batch);
                    if !robot.are_valid(&states, &steps) {
                        return false;
                    }
                    states.clear();
                    steps.clear();
                }
            }
            stride /= 2;
        }
        if !states.is_empty() {
            self.count(states.len());
            if !robot.are_valid(&states, &steps) {
                return false;
            }
        }
        // Motions in the grace one by one, the rest together.
        let leaving = self.task.grace.saturating_sub(from).min(n);
        for i in 0..leaving {
            if !self.is_motion_valid(&path[i], &path[i + 1], from + i) {
                return false;
            }
        }
        if batch == 1 {
            return (leaving..n).all(|i| self.is_motion_valid(&path[i], &path[i + 1], from + i));
        }
        let steps: Vec<usize> = (leaving..=n).map(|i| self.base_step(from + i)).collect();
        self.count(n - leaving);
        robot.are_motions_valid(&path[leaving..], &steps)
    }

    /// The straight motion from `a` to `b`, as quick as the joints are: one state per step, both ends included.
    pub(crate) fn swift(&self, a: &[f64; N], b: &[f64; N]) -> Vec<[f64; N]> {
        let steps = (0..N)
            .map(|j| ((b[j] - a[j]).abs() / self.task.reach[j] - SLACK).ceil() as usize)
            .max()
            .unwrap_or(0);
        even(a, b, steps.max(1))
    }

    /// True if a path where nothing moves is free, one end included: the last if `forward`, else the first.
    pub(crate) fn edge_is_free(&self, path: &[[f64; N]], forward: bool) -> bool {
        let (robot, last) = (self.task.robot, path.len() - 1);
        if robot.batch() <= 1 {
            let end = if forward { last } else { 0 };
            return self.is_valid(&path[end], 0) && self.path_is_free(path, 0);
        }
        let states = if forward { &path[1..] } else { &path[..last] };
        let steps = vec![0; path.len()];
        self.count(2 * last);
        robot.are_valid(states, &steps[1..]) && robot.are_motions_valid(path, &steps)
    }

    /// The states of the straight motion at even speed from `a` at step `from` to `b` at step `to`, both ends included, if it
    /// is fast enough and free. The ends are known to be free.
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
        let path = even(a, b, to - from);
        self.path_is_free(&path, from).then_some(path)
    }
}

/// `n + 1` states at even distances; both ends exact.
pub(crate) fn even<const N: usize>(a: &[f64; N], b: &[f64; N], n: usize) -> Vec<[f64; N]> {
    (0..=n)
        .map(|i| {
            if i == n {
                *b
            } else {
                between(a, b, i as f64 / n as f64)
            }
        })
        .collect()
}

/// The state at `t` of the way from `a` to `b`.
pub(crate) fn between<const N: usize>(a: &[f64; N], b: &[f64; N], t: f64) -> [f64; N] {
    std::array::from_fn(|j| a[j] + t * (b[j] - a[j]))
}

/// Euclidean joint distance.
pub(crate) fn distance<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    (0..N)
        .map(|j| (a[j] - b[j]) * (a[j] - b[j]))
        .sum::<f64>()
        .sqrt()
}

/// Sum of joint distances along a path: HEATS's cost.
pub(crate) fn cost<const N: usize>(path: &[[f64; N]]) -> f64 {
    path.windows(2).map(|w| distance(&w[0], &w[1])).sum()
}
