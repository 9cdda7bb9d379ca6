//! The camera on the flange.

use crate::frame::Frame;
use crate::shapes::Cuboid;
use nalgebra::Isometry3;

/// A camera fixed to the flange. Optical frame: z forward, x right, y down in the image.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Pose of the optical frame in the flange frame (DH frame 6). Its origin is the lens.
    pub flange_from_camera: Isometry3<f64>,
    /// Half of the housing's extents along the optical axes, m. The lens is in the middle of the front face.
    pub half: [f64; 3],
}

impl Default for Camera {
    /// Optical axis on the flange's z axis, lens 0.05 m ahead of the flange, image right = flange -y.
    ///
    /// A housing 0.09 m wide, 0.03 m high and 0.03 m deep.
    fn default() -> Self {
        Self::on_flange(0.05, CAMERA_ROLL, [0.045, 0.015, 0.015])
    }
}

/// Roll (rad) about the flange's z axis of the default camera: the image is upright near q6 = 0 in the default
/// postures.
pub const CAMERA_ROLL: f64 = 0.0;

impl Camera {
    /// A camera looking along the flange's z axis from `ahead` m in front of it, turned by `roll` rad about it.
    #[must_use]
    pub fn on_flange(ahead: f64, roll: f64, half: [f64; 3]) -> Self {
        let (s, c) = roll.sin_cos();
        let frame = Frame {
            x: [c, s, 0.0],
            y: [-s, c, 0.0],
            z: [0.0, 0.0, 1.0],
            p: [0.0, 0.0, ahead],
        };
        Self {
            flange_from_camera: (&frame).into(),
            half,
        }
    }

    /// The housing in the flange frame.
    #[must_use]
    pub fn body(&self) -> Cuboid {
        let camera = Frame::from(&self.flange_from_camera);
        let back = Frame {
            p: [0.0, 0.0, -self.half[2]],
            ..Frame::IDENTITY
        };
        Cuboid {
            frame: camera.then(&back),
            half: self.half,
        }
    }
}
