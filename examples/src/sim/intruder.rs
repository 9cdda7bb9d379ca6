//! Solids that come and go while a run is under way, never where the robot could not stop before them.

use super::body::{Kinematics, PartShape};
use super::step::{JOINTS, MotionLimits, Simulator, State};
use super::tree::Tree;
use super::world::World;
use crate::scene::{BoxShape, Shape, Solid};

/// Time from when something appears until a robot that sees it brakes, s: two scans for the map to believe it against what it
/// saw before, one that was missed, and a control step.
const REACTION: f64 = 0.4;
/// Room beyond what braking takes, m: a voxel.
const SPARE: f64 = 0.15;
/// Farthest that a part of the robot is from an axis that turns it, m.
const LEVER: f64 = 1.2;

/// Distance from the robot within which something that appears may be hit although the robot brakes as soon as it can, m. An
/// upper bound: all axes at once move the same point.
fn stopping_room(state: &State, limits: &MotionLimits) -> f64 {
    let travel = |speed: f64, a: f64| {
        let speed = speed.abs();
        let brake = if a > 0.0 {
            speed * speed / (2.0 * a)
        } else {
            0.0
        };
        speed * REACTION + brake
    };
    let turns = (0..JOINTS)
        .map(|j| travel(state.qd[j], limits.joint_a[j]))
        .sum::<f64>()
        + travel(state.w, limits.alpha);
    SPARE + travel(state.v, limits.a) + LEVER * turns
}

impl World {
    /// Adds a solid.
    pub(crate) fn insert(&mut self, solid: Solid) {
        self.solids.push(solid);
        self.plant();
    }

    /// Takes all solids of a name away; true if there were any.
    pub(crate) fn remove(&mut self, name: &str) -> bool {
        let before = self.solids.len();
        self.solids.retain(|s| s.name != name);
        self.plant();
        self.solids.len() < before
    }

    fn plant(&mut self) {
        let boxes: Vec<_> = self.solids.iter().map(|s| (s.low, s.high)).collect();
        self.tree = Tree::new(&boxes);
    }

    /// Whether an upright box meets no solid, floor or ceiling.
    pub fn is_vacant(&self, shape: &BoxShape) -> bool {
        let (sin, cos) = shape.yaw.unwrap_or(0.0).sin_cos();
        let part = PartShape::Box {
            center: shape.center,
            rotation: [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]],
            half: shape.half_extents,
        };
        self.distance(&part, 1e-3) > 0.0
    }
}

impl<K: Kinematics> Simulator<K> {
    /// Puts a box into the world: from now on sensors see it, tags hide behind it, and the robot can hit it. False, and nothing
    /// changes, while it would touch the robot or stand within the way that the robot needs to stop; with `any_speed` within
    /// the way that it would need at its top speed.
    pub fn place(&mut self, shape: &BoxShape, any_speed: bool) -> bool {
        let solid = Solid::new(&Shape::Box(shape.clone()));
        let mut state = *self.state();
        if any_speed {
            state.v = self.limits().v;
        }
        let room = stopping_room(&state, self.limits());
        let alone = World {
            tree: Tree::new(&[(solid.low, solid.high)]),
            solids: vec![solid.clone()],
            floor: f64::NEG_INFINITY,
            ceiling: f64::INFINITY,
        };
        if self.room_in(&alone, room) < room {
            return false;
        }
        self.change(|world| world.insert(solid));
        true
    }

    /// Takes what was placed under a name away again; true if it was there.
    pub fn take_away(&mut self, name: &str) -> bool {
        self.change(|world| world.remove(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(v: f64) -> State {
        State {
            base: [0.0; 3],
            joints: [0.0; JOINTS],
            v,
            w: 0.0,
            qd: [0.0; JOINTS],
        }
    }

    #[test]
    fn the_room_holds_reaction_and_braking() {
        let limits = MotionLimits::default();
        assert!((stopping_room(&state(0.0), &limits) - SPARE).abs() < 1e-12);
        // 0.8 m/s: 0.32 m until the brake, 0.4 m of braking at 0.8 m/s2.
        assert!((stopping_room(&state(-0.8), &limits) - 0.87).abs() < 1e-12);
    }
}
