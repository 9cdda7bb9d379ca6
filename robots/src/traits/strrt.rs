//! Arm paths over a base that follows a schedule.

use crate::world::OnSchedule;

impl<B: Fn([f64; 3], f64) -> bool> strrt::Robot<6> for OnSchedule<'_, B> {
    fn limits(&self) -> [(f64, f64); 6] {
        self.robot.arm.limits
    }
    fn max_speed(&self) -> [f64; 6] {
        self.robot.limits.joint_speed
    }
    fn is_valid(&self, q: &[f64; 6], step: usize) -> bool {
        self.state_is_free(q, step)
    }
    fn is_motion_valid(&self, a: &[f64; 6], b: &[f64; 6], from: usize, to: usize) -> bool {
        self.motion_is_free(a, b, from, to)
    }
}
