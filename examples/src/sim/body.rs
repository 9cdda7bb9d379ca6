//! The robot as the simulator needs it: convex parts and a camera.

use super::step::JOINTS;

/// A convex part of the robot in the world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PartShape {
    /// A ball swept along a segment.
    Capsule {
        /// One end of the segment, m.
        a: [f64; 3],
        /// Other end, m.
        b: [f64; 3],
        /// Radius, m.
        radius: f64,
    },
    /// A box.
    Box {
        /// Centre, m.
        center: [f64; 3],
        /// world_from_box, rows.
        rotation: [[f64; 3]; 3],
        /// Half the edges, m.
        half: [f64; 3],
    },
    /// A cylinder along its local z.
    Cylinder {
        /// Centre, m.
        center: [f64; 3],
        /// world_from_cylinder, rows.
        rotation: [[f64; 3]; 3],
        /// Radius, m.
        radius: f64,
        /// Half the length, m.
        half_height: f64,
    },
}

/// A part and what it may touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// The shape in the world frame.
    pub shape: PartShape,
    /// It stands on the floor, so the floor does not count as an obstacle for it.
    pub stands: bool,
    /// Name for messages.
    pub name: &'static str,
}

/// All parts of the robot in one configuration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Body {
    /// The parts, in a fixed order.
    pub parts: Vec<Part>,
}

/// Rotation (rows, world_from_camera) and position of a camera; z forward, x right, y down.
pub type CameraPose = ([[f64; 3]; 3], [f64; 3]);

/// Forward kinematics of the simulated robot.
///
/// Laws: the number and order of parts never changes; every part moves continuously with its arguments.
pub trait Kinematics {
    /// Fills `out` (after clearing it) with all parts at a base pose x, y, yaw and joint angles.
    fn body(&self, base: [f64; 3], joints: &[f64; JOINTS], out: &mut Body);
    /// Pose of the camera.
    fn camera(&self, base: [f64; 3], joints: &[f64; JOINTS]) -> CameraPose;
}

impl<K: Kinematics + ?Sized> Kinematics for &K {
    fn body(&self, base: [f64; 3], joints: &[f64; JOINTS], out: &mut Body) {
        (**self).body(base, joints, out);
    }
    fn camera(&self, base: [f64; 3], joints: &[f64; JOINTS]) -> CameraPose {
        (**self).camera(base, joints)
    }
}
