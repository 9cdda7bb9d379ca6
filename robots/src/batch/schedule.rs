//! The arm over a scheduled base, checked sixteen states at a time.

use super::field::BatchField;
use super::lanes::LANES;
use super::model::BatchBody;
use crate::ik::wrap;
use crate::manipulator::{BodyState, MobileManipulator};

/// What [`OnSchedule`](crate::OnSchedule) is for one state, for sixteen at once against a distance field; implements
/// `strrt::Robot` with its batch methods behind the feature `strrt`.
#[derive(Clone, Debug)]
pub struct BatchOnSchedule<'a, F> {
    /// The robot.
    pub robot: &'a MobileManipulator,
    /// Pose of the base (x m, y m, yaw rad) at each step; a later step finds it at the last.
    pub base: &'a [[f64; 3]],
    /// Distances to obstacles.
    pub field: F,
    /// Room kept between the arm's spheres and obstacles, m.
    pub margin: f64,
    /// Longest motion between two checked states: of a joint (rad) or of the base (m or rad).
    pub resolution: f64,
    body: BatchBody,
}

impl<'a, F: BatchField> BatchOnSchedule<'a, F> {
    /// The arm over the base poses `base`, keeping `margin` (m), checked every 0.05 rad or m of motion.
    pub fn new(robot: &'a MobileManipulator, base: &'a [[f64; 3]], margin: f64, field: F) -> Self {
        Self {
            robot,
            base,
            field,
            margin,
            resolution: 0.05,
            body: BatchBody::new(robot),
        }
    }

    /// Pose of the base at `step`; the origin if the schedule is empty.
    #[must_use]
    pub fn base_at(&self, step: usize) -> [f64; 3] {
        let pose = self.base.get(step).or(self.base.last());
        pose.copied().unwrap_or_default()
    }

    /// True if the arm is inside its limits, clear of the robot and of the world at every state and its step.
    pub fn states_are_free(&self, joints: &[[f64; 6]], steps: &[usize]) -> bool {
        let inside = |q: &[f64; 6]| self.robot.arm.limit_violation(q).is_none();
        let states = joints.iter().zip(steps).map(|(q, &step)| BodyState {
            base: self.base_at(step),
            joints: *q,
        });
        let states: Vec<BodyState> = states.collect();
        joints.iter().all(inside) && self.body.all_free(&states, &self.field, self.margin)
    }

    /// True if the straight motions between consecutive states are free between their ends. A batch is checked as soon
    /// as it is full.
    pub fn motions_are_free(&self, joints: &[[f64; 6]], steps: &[usize]) -> bool {
        let mut batch: Vec<BodyState> = Vec::with_capacity(LANES);
        for (pair, when) in joints.windows(2).zip(steps.windows(2)) {
            let (a, b) = (&pair[0], &pair[1]);
            let (start, end) = (self.base_at(when[0]), self.base_at(when[1]));
            let turn = wrap(end[2] - start[2]);
            let arm = (0..6).map(|j| (b[j] - a[j]).abs()).fold(0.0, f64::max);
            let drive = (end[0] - start[0]).hypot(end[1] - start[1]);
            let most = arm.max(drive).max(turn.abs());
            // NaN and absurd motions are refused by the state check or by the limits.
            let n = (most / self.resolution.max(1e-3)).ceil().clamp(1.0, 1000.0) as usize;
            for i in 1..n {
                let t = i as f64 / n as f64;
                batch.push(BodyState {
                    base: [
                        start[0] + t * (end[0] - start[0]),
                        start[1] + t * (end[1] - start[1]),
                        start[2] + t * turn,
                    ],
                    joints: std::array::from_fn(|j| a[j] + t * (b[j] - a[j])),
                });
                if batch.len() == LANES {
                    if !self.body.all_free(&batch, &self.field, self.margin) {
                        return false;
                    }
                    batch.clear();
                }
            }
        }
        self.body.all_free(&batch, &self.field, self.margin)
    }
}
