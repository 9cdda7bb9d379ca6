//! What a baseline planner is asked, and what it answers.

use super::view::View;
use crate::heats::{Joints, MotionParams, Ways, Whole};

/// What a planner sees of the run.
pub(super) struct Sight<'a> {
    /// Robot and map.
    pub whole: Whole<'a>,
    /// Ways over the ground.
    pub ways: &'a Ways,
    /// Limits of motion.
    pub params: &'a MotionParams,
    /// Base pose, m and rad.
    pub base: [f64; 3],
    /// Arm posture, rad.
    pub joints: Joints,
    /// Where the camera is.
    pub camera: View,
    /// Where the arm is mounted, m.
    pub turret: [f64; 3],
    /// Heights of surface to inspect, m.
    pub band: (f64, f64),
    /// Radius of the disc that ways are for, m.
    pub disc: f64,
    /// Simulated time, s.
    pub now: f64,
}

impl Sight<'_> {
    /// Whether a point is in the prism of the robot's base, up to where the arm is mounted.
    pub(super) fn is_own(&self, p: [f64; 3]) -> bool {
        let (s, c) = self.base[2].sin_cos();
        let d = [p[0] - self.base[0], p[1] - self.base[1]];
        let b = &self.whole.robot.base;
        p[2] <= self.turret[2]
            && (c * d[0] + s * d[1]).abs() <= 0.5 * b.length
            && (c * d[1] - s * d[0]).abs() <= 0.5 * b.width
    }
}

/// What to do next.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Next {
    /// One of these views, the first that can be taken up.
    First(Vec<View>),
    /// All of these views in order, with the base where it is.
    Sweep(Vec<View>),
    /// Nothing is left to see.
    Done,
}

/// A next-best-view planner.
pub(super) trait Planner {
    /// The next views.
    fn next(&mut self, sight: &Sight<'_>) -> Next;
    /// A way to this view was found and is taken.
    fn set_out(&mut self, view: &View);
    /// The camera was there.
    fn reached(&mut self, view: &View);
    /// There is no way to it, or the way is blocked.
    fn failed(&mut self, view: &View, now: f64);
    /// Time that planning took since the last call by what was counted, s.
    fn counted(&mut self) -> f64;
}
