//! The mobile manipulator: base, arm, camera and LiDAR put together.

use crate::base::{BASE_SPHERES, BaseShape};
use crate::body::{ARM_SPHERES, ArmBody};
use crate::camera::Camera;
use crate::frame::Frame;
use crate::shapes::{CAPSULES, Capsule, Cuboid, LinkSizes, Sphere};
use crate::ur5e::Ur5e;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::PI;

/// Spheres of the whole robot.
pub const SPHERES: usize = ARM_SPHERES + BASE_SPHERES;

/// Where the robot is and how its arm stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyState {
    /// x (m), y (m), yaw (rad) of the base in the world.
    pub base: [f64; 3],
    /// Angles of the arm's joints, rad.
    pub joints: [f64; 6],
}

/// Limits of speed and acceleration.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// Greatest forward and reverse speed of the base, m/s.
    pub speed: f64,
    /// Greatest turning speed of the base, rad/s.
    pub turn_speed: f64,
    /// Greatest acceleration of the base, m/s^2.
    pub acceleration: f64,
    /// Greatest angular acceleration of the base, rad/s^2.
    pub turn_acceleration: f64,
    /// Greatest speed of each joint, rad/s.
    pub joint_speed: [f64; 6],
    /// Greatest acceleration of each joint, rad/s^2.
    pub joint_acceleration: [f64; 6],
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            speed: 0.8,
            turn_speed: 1.5,
            acceleration: 0.8,
            turn_acceleration: 2.0,
            joint_speed: [0.8; 6],
            joint_acceleration: [2.0; 6],
        }
    }
}

/// A differential-drive base with a UR arm, a camera on its flange and a LiDAR on its top.
///
/// All fields are plain data. After a change to `arm`, `sizes` or `camera` call
/// [`rebuild_body`](Self::rebuild_body), so that the spheres follow.
#[derive(Clone, Debug, PartialEq)]
pub struct MobileManipulator {
    /// The base's solids.
    pub base: BaseShape,
    /// Pose of the arm's base frame in the base frame. The default turns it half around, so that the arm reaches
    /// forward at q1 = 0 (the maker's arm extends along -x).
    pub mount: Isometry3<f64>,
    /// The arm.
    pub arm: Ur5e,
    /// Thickness of the arm's links.
    pub sizes: LinkSizes,
    /// The camera on the flange.
    pub camera: Camera,
    /// Limits of speed and acceleration. Joint limits are in [`Ur5e::limits`].
    pub limits: Limits,
    /// Capsules, spheres and pairs of the arm, made from the fields above.
    pub body: ArmBody,
}

impl Default for MobileManipulator {
    fn default() -> Self {
        let (arm, sizes, camera) = (Ur5e::default(), LinkSizes::default(), Camera::default());
        let body = ArmBody::new(&arm, &sizes, &camera);
        let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), PI);
        let mount = Isometry3::from_parts(Translation3::new(0.10, 0.0, 0.50), turned);
        Self {
            base: BaseShape::default(),
            mount,
            arm,
            sizes,
            camera,
            limits: Limits::default(),
            body,
        }
    }
}

/// The spheres of the whole robot in the world: first the arm and camera, then the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereSet {
    /// All spheres; [`arm`](Self::arm) and [`base`](Self::base) are its parts.
    pub all: [Sphere; SPHERES],
}

impl SphereSet {
    /// Spheres of the arm and the camera, in the order of [`ArmBody::spheres`].
    #[must_use]
    pub fn arm(&self) -> &[Sphere] {
        &self.all[..ARM_SPHERES]
    }
    /// Spheres of the base, in the order of [`BaseShape::spheres`].
    #[must_use]
    pub fn base(&self) -> &[Sphere] {
        &self.all[ARM_SPHERES..]
    }
}

impl MobileManipulator {
    /// Makes the capsules, spheres and pairs anew from the arm, the link sizes and the camera.
    pub fn rebuild_body(&mut self) {
        self.body = ArmBody::new(&self.arm, &self.sizes, &self.camera);
    }

    /// world_from_arm-base.
    #[inline]
    pub(crate) fn arm_root(&self, base: [f64; 3]) -> Frame {
        Frame::planar(base).then(&Frame::from(&self.mount))
    }

    /// The arm's base frame and its six DH frames in the world.
    #[must_use]
    pub fn arm_frames(&self, state: &BodyState) -> [Frame; 7] {
        self.arm.chain(&self.arm_root(state.base), &state.joints)
    }

    /// world_from_camera; optical frame (z forward, x right, y down).
    #[must_use]
    pub fn camera_pose(&self, state: &BodyState) -> Isometry3<f64> {
        (&self.camera_frame(state)).into()
    }

    /// [`camera_pose`](Self::camera_pose) as plain arrays.
    #[must_use]
    pub fn camera_frame(&self, state: &BodyState) -> Frame {
        self.arm_frames(state)[6].then(&Frame::from(&self.camera.flange_from_camera))
    }

    /// Origin of the LiDAR in the world, m.
    #[must_use]
    pub fn lidar_position(&self, base: [f64; 3]) -> [f64; 3] {
        Frame::planar(base).apply(self.base.lidar)
    }

    /// Spheres that contain the whole robot, in the world.
    #[must_use]
    pub fn spheres(&self, state: &BodyState) -> SphereSet {
        let mut all = [Sphere::default(); SPHERES];
        let frames = self.arm_frames(state);
        place(&self.body.spheres, &frames, &mut all[..ARM_SPHERES]);
        let base = Frame::planar(state.base);
        for (out, s) in all[ARM_SPHERES..].iter_mut().zip(self.base.spheres()) {
            *out = Sphere {
                center: base.apply(s.center),
                ..s
            };
        }
        SphereSet { all }
    }

    /// Spheres of the arm and the camera in the world: the hot path of arm planning.
    #[inline]
    #[must_use]
    pub fn arm_spheres(&self, state: &BodyState) -> [Sphere; ARM_SPHERES] {
        let mut out = [Sphere::default(); ARM_SPHERES];
        place(&self.body.spheres, &self.arm_frames(state), &mut out);
        out
    }

    /// The arm's links as capsules in the world: exact shapes for a simulator, inside the spheres.
    #[must_use]
    pub fn link_capsules(&self, state: &BodyState) -> [Capsule; CAPSULES] {
        let frames = self.arm_frames(state);
        self.body
            .capsules
            .map(|c| c.moved(&frames[usize::from(c.link)]))
    }

    /// The camera's housing in the world.
    #[must_use]
    pub fn camera_box(&self, state: &BodyState) -> Cuboid {
        self.camera.body().moved(&self.arm_frames(state)[6])
    }

    /// The base's box in the world.
    #[must_use]
    pub fn base_box(&self, base: [f64; 3]) -> Cuboid {
        self.base.cuboid(&Frame::planar(base))
    }

    /// Circles (centre in the base frame, radius; m) that cover the base's rectangle.
    #[must_use]
    pub fn base_circles(&self) -> &[([f64; 2], f64)] {
        &self.base.circles
    }

    /// Seconds that the slowest joint needs between two joint vectors at full speed (HEATS eq. 2).
    #[must_use]
    pub fn arm_seconds(&self, from: &[f64; 6], to: &[f64; 6]) -> f64 {
        (0..6)
            .map(|j| (to[j] - from[j]).abs() / self.limits.joint_speed[j])
            .fold(0.0, f64::max)
    }
}

#[inline]
fn place(table: &[Sphere; ARM_SPHERES], frames: &[Frame; 7], out: &mut [Sphere]) {
    for (o, s) in out.iter_mut().zip(table) {
        let frame = &frames[usize::from(s.link.min(6))];
        *o = Sphere {
            center: frame.apply(s.center),
            ..*s
        };
    }
}
