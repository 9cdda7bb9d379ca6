//! View planning: which arm state shows a view, and is the body free there.

use crate::frame::Frame;
use crate::manipulator::{BodyState, MobileManipulator};
use crate::posture::Posture;
use crate::world::InWorld;
use viewsample::Pose;

impl From<&Pose> for Frame {
    fn from(pose: &Pose) -> Self {
        Frame::from_rows(&pose.rotation, pose.translation)
    }
}

impl From<&Frame> for Pose {
    fn from(frame: &Frame) -> Self {
        Pose {
            rotation: frame.rows(),
            translation: frame.p,
        }
    }
}

impl<B, F> viewsample::Robot for InWorld<'_, B, F>
where
    B: Fn([f64; 3], f64) -> bool,
    F: Fn([f64; 3]) -> bool,
{
    type State = [f64; 6];

    fn reach(&self, base_from_camera: &Pose) -> Option<[f64; 6]> {
        self.robot
            .reach(&Frame::from(base_from_camera), &self.home, &self.weights)
    }

    fn is_free(&self, base: [f64; 3], state: &[f64; 6]) -> bool {
        InWorld::is_free(
            self,
            &BodyState {
                base,
                joints: *state,
            },
        )
    }

    fn base_is_free(&self, base: [f64; 3]) -> bool {
        (self.base_is_free)(base)
    }
}

/// The library's postures for a view planner: `view` counts them in the order given.
#[must_use]
pub fn library(postures: &[Posture]) -> Vec<viewsample::Posture<[f64; 6]>> {
    let one = |(view, p): (usize, &Posture)| viewsample::Posture {
        view,
        camera: Pose::from(&p.camera),
        state: p.joints,
    };
    postures.iter().enumerate().map(one).collect()
}

/// HEATS eq. 2 with this robot's speeds.
impl viewsample::CostModel<[f64; 6]> for MobileManipulator {
    fn seconds(&self, from: (&[f64; 3], &[f64; 6]), to: (&[f64; 3], &[f64; 6])) -> f64 {
        let drive = (to.0[0] - from.0[0]).hypot(to.0[1] - from.0[1]) / self.limits.speed;
        drive.max(self.arm_seconds(from.1, to.1))
    }
}
