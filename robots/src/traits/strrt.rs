//! Arm paths over a base that follows a schedule.

use crate::batch::{BatchField, BatchOnSchedule, LANES};
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

impl<F: BatchField> strrt::Robot<6> for BatchOnSchedule<'_, F> {
    fn limits(&self) -> [(f64, f64); 6] {
        self.robot.arm.limits
    }
    fn max_speed(&self) -> [f64; 6] {
        self.robot.limits.joint_speed
    }
    fn is_valid(&self, q: &[f64; 6], step: usize) -> bool {
        self.states_are_free(&[*q], &[step])
    }
    fn is_motion_valid(&self, a: &[f64; 6], b: &[f64; 6], from: usize, to: usize) -> bool {
        self.motions_are_free(&[*a, *b], &[from, to])
    }
    fn are_valid(&self, states: &[[f64; 6]], steps: &[usize]) -> bool {
        self.states_are_free(states, steps)
    }
    fn are_motions_valid(&self, states: &[[f64; 6]], steps: &[usize]) -> bool {
        self.motions_are_free(states, steps)
    }
    fn batch(&self) -> usize {
        LANES
    }
}
