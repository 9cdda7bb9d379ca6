//! The robot: its exact parts for the simulator, and what of it the planner holds against its map.

use super::mapping::Mapper;
use crate::sim::{Body, CameraPose, Kinematics, Part, PartShape};
use robots::{BodyState, Capsule, Cuboid, MobileManipulator};
use std::f64::consts::TAU;

/// Yaws at which a turn on the spot is looked at.
const TURNS: u32 = 36;

/// Joint angles, rad.
pub type Joints = [f64; 6];

/// The simulated robot is the one the planner knows, with exact parts.
#[derive(Clone, Debug)]
pub struct Exact(pub MobileManipulator);

impl Exact {
    /// Joint capsules, the camera's box and the base: in a fixed order.
    fn parts(&self, state: &BodyState, out: &mut Body) {
        let capsule = |c: &Capsule, name, stands| Part {
            shape: PartShape::Capsule {
                a: c.a,
                b: c.b,
                radius: c.radius,
            },
            stands,
            name,
        };
        let cuboid = |c: &Cuboid, name, stands| Part {
            shape: PartShape::Box {
                center: c.frame.p,
                rotation: c.frame.rows(),
                half: c.half,
            },
            stands,
            name,
        };
        out.parts.clear();
        out.parts
            .push(cuboid(&self.0.base_box(state.base), "base", true));
        let base = robots::Frame::planar(state.base);
        out.parts.push(capsule(
            &self.0.base.pedestal_capsule(&base),
            "pedestal",
            true,
        ));
        for link in &self.0.link_capsules(state) {
            out.parts.push(capsule(link, "arm", false));
        }
        out.parts
            .push(cuboid(&self.0.camera_box(state), "camera", false));
    }
}

impl Kinematics for Exact {
    fn body(&self, base: [f64; 3], joints: &Joints, out: &mut Body) {
        self.parts(
            &BodyState {
                base,
                joints: *joints,
            },
            out,
        );
    }
    fn camera(&self, base: [f64; 3], joints: &Joints) -> CameraPose {
        let frame = self.0.camera_frame(&BodyState {
            base,
            joints: *joints,
        });
        (frame.rows(), frame.p)
    }
}

/// The planner's view of the robot in its map.
#[derive(Clone, Copy)]
pub struct Whole<'a> {
    /// The robot.
    pub robot: &'a MobileManipulator,
    /// The map.
    pub mapper: &'a Mapper,
    /// Room kept around the base's circles, m.
    pub base_clearance: f64,
    /// Room kept around the arm's spheres, m.
    pub arm_clearance: f64,
}

impl Whole<'_> {
    /// The base's circles: middle in the world and radius, m.
    fn base_circles(&self, base: [f64; 3]) -> impl Iterator<Item = ([f64; 2], f64)> {
        let (s, c) = base[2].sin_cos();
        self.robot
            .base_circles()
            .iter()
            .map(move |&([x, y], radius)| {
                ([base[0] + c * x - s * y, base[1] + s * x + c * y], radius)
            })
    }

    /// Least room of the base's footprint on known free ground, m.
    pub fn base_room(&self, base: [f64; 3]) -> f64 {
        self.base_circles(base)
            .map(|(p, radius)| self.mapper.ground.clearance(p) - radius)
            .fold(f64::INFINITY, f64::min)
    }

    /// Whether the base can turn on the spot with at least `room` m between its circles and known obstacles.
    pub fn turns_clear(&self, base: [f64; 3], room: f64) -> bool {
        (0..TURNS).all(|k| {
            let yaw = base[2] + f64::from(k) * TAU / f64::from(TURNS);
            self.base_circles([base[0], base[1], yaw])
                .all(|(p, radius)| self.mapper.ground.obstacle_clearance(p) >= radius + room)
        })
    }

    /// Room of a sphere to mapped or unknown space, the floor and the map's border, m.
    #[inline]
    fn room_of(&self, sphere: &robots::Sphere) -> f64 {
        let map = &self.mapper.map;
        let (low, size, h) = (map.low(), map.size(), map.cell_size());
        let center = sphere.center;
        let mut room = self
            .mapper
            .distance
            .distance(center)
            .min(center[2] - low[2]);
        for a in 0..2 {
            let high = low[a] + size[a] as f64 * h;
            room = room.min(center[a] - low[a]).min(high - center[a]);
        }
        room - sphere.radius
    }

    fn arm_spheres(
        &self,
        base: [f64; 3],
        joints: &Joints,
    ) -> impl DoubleEndedIterator<Item = robots::Sphere> {
        let state = BodyState {
            base,
            joints: *joints,
        };
        self.robot.arm_spheres(&state).into_iter()
    }

    /// Least room of the arm's spheres to mapped or unknown space, the floor and the map's border, m.
    pub fn arm_room(&self, base: [f64; 3], joints: &Joints) -> f64 {
        self.arm_spheres(base, joints)
            .map(|s| self.room_of(&s))
            .fold(f64::INFINITY, f64::min)
    }

    /// Whether [`arm_room`](Self::arm_room) is at least the arm's clearance.
    fn arm_keeps_clear(&self, base: [f64; 3], joints: &Joints) -> bool {
        // The camera's end touches something first.
        self.arm_spheres(base, joints)
            .rev()
            .all(|s| self.room_of(&s) >= self.arm_clearance)
    }

    /// Least room of the whole body, m.
    pub fn room(&self, base: [f64; 3], joints: &Joints) -> f64 {
        self.base_room(base).min(self.arm_room(base, joints))
    }

    /// True if the arm keeps its clearance to the map and to the robot itself.
    pub fn arm_is_free(&self, base: [f64; 3], joints: &Joints) -> bool {
        self.arm_keeps_clear(base, joints) && self.robot.self_is_free(joints, 0.005)
    }
}

impl viewsample::Robot for Whole<'_> {
    type State = Joints;
    fn reach(&self, base_from_camera: &viewsample::Pose) -> Option<Joints> {
        let frame =
            robots::Frame::from_rows(&base_from_camera.rotation, base_from_camera.translation);
        self.robot
            .ik_camera_frame([0.0; 3], &frame, &[0.0; 6])
            .best()
            .map(|s| s.joints)
    }
    fn take_up(
        &self,
        base: [f64; 3],
        world_from_camera: &viewsample::Pose,
        near: &Joints,
    ) -> Option<Joints> {
        if !self.base_is_free(base) {
            return None;
        }
        let frame =
            robots::Frame::from_rows(&world_from_camera.rotation, world_from_camera.translation);
        let found = self.robot.ik_camera_frame(base, &frame, near);
        let first = found
            .as_slice()
            .iter()
            .find(|s| self.arm_keeps_clear(base, &s.joints))?;
        Some(first.joints)
    }
    fn is_free(&self, base: [f64; 3], joints: &Joints) -> bool {
        self.base_is_free(base) && self.arm_keeps_clear(base, joints)
    }
    fn is_free_on_base(&self, base: [f64; 3], joints: &Joints) -> bool {
        self.arm_keeps_clear(base, joints)
    }
    fn base_is_free(&self, base: [f64; 3]) -> bool {
        self.base_circles(base).all(|(p, radius)| {
            self.mapper
                .ground
                .has_clearance(p, radius + self.base_clearance)
        })
    }
}
