//! The robot in a world that answers one question: is this ball free?

use crate::frame::Frame;
use crate::ik::wrap;
use crate::manipulator::{BodyState, MobileManipulator};
use crate::posture::PostureWeights;
use crate::shapes::Sphere;
use crate::view::SELF_MARGIN;

/// A robot among obstacles known through two closures; implements the traits of the planners behind the features
/// named after them.
///
/// The arm's spheres are tested by `ball_is_free`; the base by `base_is_free`, which may use a planar map.
#[derive(Clone, Debug)]
pub struct InWorld<'a, B, F> {
    /// The robot.
    pub robot: &'a MobileManipulator,
    /// True if a ball (centre in the world and radius, m) touches nothing.
    pub ball_is_free: B,
    /// True if the base touches nothing at (x m, y m, yaw rad).
    pub base_is_free: F,
    /// Added to the radius of each sphere of the arm, m.
    pub margin: f64,
    /// Joints that postures should be quick to reach from: [`Posture`](crate::Posture) number 0, say.
    pub home: [f64; 6],
    /// Preferences among the arm states that reach a camera pose.
    pub weights: PostureWeights,
}

impl<'a, B, F> InWorld<'a, B, F>
where
    B: Fn([f64; 3], f64) -> bool,
    F: Fn([f64; 3]) -> bool,
{
    /// A robot whose arm keeps `margin` (m) from obstacles.
    pub fn new(
        robot: &'a MobileManipulator,
        home: [f64; 6],
        margin: f64,
        ball_is_free: B,
        base_is_free: F,
    ) -> Self {
        Self {
            robot,
            ball_is_free,
            base_is_free,
            margin,
            home,
            weights: PostureWeights::default(),
        }
    }

    /// True if the arm, the camera and the base touch nothing and the arm does not touch the robot.
    pub fn is_free(&self, state: &BodyState) -> bool {
        (self.base_is_free)(state.base) && self.arm_is_free(state)
    }

    /// [`is_free`](Self::is_free) without the base's own test.
    pub fn arm_is_free(&self, state: &BodyState) -> bool {
        arm_is_free(
            self.robot,
            &Frame::planar(state.base),
            &state.joints,
            self.margin,
            &self.ball_is_free,
        )
    }
}

/// An arm on a base that follows a schedule: the base's pose at each step of a time grid.
///
/// The base itself is not tested: that was the business of whoever planned its path.
#[derive(Clone, Debug)]
pub struct OnSchedule<'a, B> {
    /// The robot.
    pub robot: &'a MobileManipulator,
    /// Pose of the base (x m, y m, yaw rad) at each step; a later step finds it at the last.
    pub base: &'a [[f64; 3]],
    /// True if a ball (centre in the world and radius, m) touches nothing.
    pub ball_is_free: B,
    /// Added to the radius of each sphere of the arm, m.
    pub margin: f64,
    /// Longest motion between two checked states: of a joint (rad) or of the base (m or rad).
    pub resolution: f64,
}

impl<'a, B: Fn([f64; 3], f64) -> bool> OnSchedule<'a, B> {
    /// The arm over the base poses `base`, keeping `margin` (m), checked every 0.05 rad or m of motion.
    pub fn new(
        robot: &'a MobileManipulator,
        base: &'a [[f64; 3]],
        margin: f64,
        ball_is_free: B,
    ) -> Self {
        Self {
            robot,
            base,
            ball_is_free,
            margin,
            resolution: 0.05,
        }
    }

    /// Pose of the base at `step`; the origin if the schedule is empty.
    #[must_use]
    pub fn base_at(&self, step: usize) -> [f64; 3] {
        self.base
            .get(step)
            .or(self.base.last())
            .copied()
            .unwrap_or_default()
    }

    /// True if the arm is inside its limits, clear of the robot and of the world at `step`.
    pub fn state_is_free(&self, joints: &[f64; 6], step: usize) -> bool {
        self.is_free_at(joints, self.base_at(step))
    }

    /// True if the straight motion from `a` at step `from` to `b` at step `to` is free between its ends.
    pub fn motion_is_free(&self, a: &[f64; 6], b: &[f64; 6], from: usize, to: usize) -> bool {
        let (start, end) = (self.base_at(from), self.base_at(to));
        let turn = wrap(end[2] - start[2]);
        let arm = (0..6).map(|j| (b[j] - a[j]).abs()).fold(0.0, f64::max);
        let drive = (end[0] - start[0]).hypot(end[1] - start[1]);
        let most = arm.max(drive).max(turn.abs());
        // NaN and absurd motions are refused by the state check or by the limits.
        let n = (most / self.resolution.max(1e-3)).ceil().clamp(1.0, 1000.0) as usize;
        (1..n).all(|i| {
            let t = i as f64 / n as f64;
            let q = [0, 1, 2, 3, 4, 5].map(|j| a[j] + t * (b[j] - a[j]));
            let base = [
                start[0] + t * (end[0] - start[0]),
                start[1] + t * (end[1] - start[1]),
                start[2] + t * turn,
            ];
            self.is_free_at(&q, base)
        })
    }

    fn is_free_at(&self, joints: &[f64; 6], base: [f64; 3]) -> bool {
        self.robot.arm.limit_violation(joints).is_none()
            && arm_is_free(
                self.robot,
                &Frame::planar(base),
                joints,
                self.margin,
                &self.ball_is_free,
            )
    }
}

fn arm_is_free(
    robot: &MobileManipulator,
    base: &Frame,
    joints: &[f64; 6],
    margin: f64,
    ball_is_free: &impl Fn([f64; 3], f64) -> bool,
) -> bool {
    if !base.is_finite() || joints.iter().any(|q| !q.is_finite()) {
        return false;
    }
    let spheres = robot.spheres_in_base(joints);
    // The camera end hits first: from the tip to the shoulder.
    let outside = |s: &Sphere| ball_is_free(base.apply(s.center), s.radius + margin);
    robot.spheres_are_free(&spheres, SELF_MARGIN) && spheres.iter().rev().all(outside)
}
