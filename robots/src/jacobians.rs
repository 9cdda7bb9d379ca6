//! Derivatives of the sphere centres, for whole-body optimisation.

use crate::body::ARM_SPHERES;
use crate::frame::{Frame, cross, sub};
use crate::manipulator::{BodyState, MobileManipulator};
use crate::shapes::Sphere;

/// d(centre)/d(state): row = world axis, columns x, y, yaw, q1 to q6.
pub type SphereJacobian = [[f64; 9]; 3];

impl MobileManipulator {
    /// Spheres of the arm in the world and the derivative of each centre by (x, y, yaw, q1..q6).
    ///
    /// Columns of joints beyond a sphere's link are zero.
    #[must_use]
    pub fn sphere_jacobians(
        &self,
        state: &BodyState,
    ) -> ([Sphere; ARM_SPHERES], [SphereJacobian; ARM_SPHERES]) {
        let frames = self.arm_frames(state);
        let mut spheres = self.body.spheres;
        let mut jacobians = [[[0.0; 9]; 3]; ARM_SPHERES];
        for (s, j) in spheres.iter_mut().zip(jacobians.iter_mut()) {
            s.center = frames[usize::from(s.link.min(6))].apply(s.center);
            *j = point_jacobian(&frames, state.base, s.center, usize::from(s.link.min(6)));
        }
        (spheres, jacobians)
    }

    /// Pose of the camera in the world, the derivative of its origin as in [`sphere_jacobians`](Self::sphere_jacobians),
    /// and that of its attitude: the angular velocity (world, rad) per unit of each state.
    #[must_use]
    pub fn camera_jacobian(&self, state: &BodyState) -> (Frame, SphereJacobian, SphereJacobian) {
        let frames = self.arm_frames(state);
        let camera = frames[6].then(&Frame::from(&self.camera.flange_from_camera));
        let linear = point_jacobian(&frames, state.base, camera.p, 6);
        let mut angular = [[0.0; 9]; 3];
        angular[2][2] = 1.0;
        for joint in 0..6 {
            for i in 0..3 {
                angular[i][3 + joint] = frames[joint].z[i];
            }
        }
        (camera, linear, angular)
    }
}

/// The same by the inputs of a differential drive: columns v (m/s along x of the base), omega, joint speeds.
#[must_use]
pub fn by_inputs(jacobian: &SphereJacobian, yaw: f64) -> [[f64; 8]; 3] {
    let (s, c) = yaw.sin_cos();
    [0, 1, 2].map(|i| {
        let row = &jacobian[i];
        [
            row[0] * c + row[1] * s,
            row[2],
            row[3],
            row[4],
            row[5],
            row[6],
            row[7],
            row[8],
        ]
    })
}

pub(crate) fn point_jacobian(
    frames: &[Frame; 7],
    base: [f64; 3],
    point: [f64; 3],
    joints: usize,
) -> SphereJacobian {
    let mut j = [[0.0; 9]; 3];
    j[0][0] = 1.0;
    j[1][1] = 1.0;
    j[0][2] = base[1] - point[1];
    j[1][2] = point[0] - base[0];
    for joint in 0..joints {
        let column = cross(frames[joint].z, sub(point, frames[joint].p));
        for i in 0..3 {
            j[i][3 + joint] = column[i];
        }
    }
    j
}
