//! Targets: on walls and furniture, where the robot can see them.

use super::furniture::{Piece, Spot};
use super::ground::Reach;
use super::layout::Plan;
use super::{Blueprint, Dice, Rect};
use crate::heats::Exact;
use crate::scene::{Scene, Tag};
use crate::sim::{Body, Kinematics, TagCamera, World};
use robots::{Frame, MobileManipulator};
use std::collections::BTreeMap;

/// Radius of the disc that reaches the ground a base may stand on, m.
const DISC: f64 = 0.35;
/// Camera poses tried for a target.
const TRIES: usize = 600;
/// Room between robot and everything, m.
const ROOM: f64 = 0.03;
/// Share of targets on walls.
const ON_WALLS: f64 = 0.25;
/// Distance of the camera from a target, m.
const DISTANCE: (f64, f64) = (0.3, 2.0);
/// Least distance between targets, m.
const APART: f64 = 0.5;
/// Largest angle between sight line and normal, rad.
const TILT: f64 = 0.9;

/// Who judges whether a target can be seen.
struct Judge<'a> {
    world: World,
    robot: Exact,
    camera: TagCamera,
    reach: &'a Reach,
}

impl Judge<'_> {
    /// Whether some collision-free pose of the whole robot shows the target.
    fn can_see(&self, tag: &Tag, dice: &mut Dice) -> bool {
        let robot: &MobileManipulator = &self.robot.0;
        let mut body = Body::default();
        for _ in 0..TRIES {
            let Some(camera) = aim(tag, dice) else {
                continue;
            };
            // The base within the arm's reach of the camera.
            let (bearing, off) = (std::f64::consts::TAU * dice.share(), dice.between(0.1, 0.9));
            let base = [
                camera.p[0] + off * bearing.cos(),
                camera.p[1] + off * bearing.sin(),
                std::f64::consts::TAU * dice.share(),
            ];
            if !self.reach.reaches([base[0], base[1]])
                || !self
                    .camera
                    .sees(&self.world, &(camera.rows(), camera.p), tag)
            {
                continue;
            }
            let found = robot.ik_camera_frame(base, &camera, &[0.0; 6]);
            let Some(state) = found.best() else {
                continue;
            };
            if !robot.self_is_free(&state.joints, 0.0) {
                continue;
            }
            self.robot.body(base, &state.joints, &mut body);
            if self.world.clearance(&body, 1.0).distance > ROOM {
                return true;
            }
        }
        false
    }
}

/// A camera that looks at a target from in front of it.
fn aim(tag: &Tag, dice: &mut Dice) -> Option<Frame> {
    let distance = dice.between(DISTANCE.0, DISTANCE.1);
    let (tilt, turn) = (TILT * dice.share(), std::f64::consts::TAU * dice.share());
    let (n, u) = (tag.normal, tag.up);
    let x = cross(u, n);
    let away =
        [0, 1, 2].map(|k| tilt.cos() * n[k] + tilt.sin() * (turn.cos() * u[k] + turn.sin() * x[k]));
    let p = [0, 1, 2].map(|k| tag.center[k] + distance * away[k]);
    let z = away.map(|v| -v);
    // Image rows run down; looking straight down or up any direction will do.
    let down = if z[2].abs() > 0.99 {
        [turn.cos(), turn.sin(), 0.0]
    } else {
        [0.0, 0.0, -1.0]
    };
    let right = unit(cross(down, z))?;
    let down = cross(z, right);
    let rows = [0, 1, 2].map(|k| [right[k], down[k], z[k]]);
    Some(Frame::from_rows(&rows, p))
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    (length > 1e-9).then(|| v.map(|c| c / length))
}

/// Draws targets, one kind of place after the other.
pub(super) fn place(
    scene: &Scene,
    plan: &Plan,
    pieces: &[Piece],
    blueprint: &Blueprint,
    dice: &mut Dice,
) -> Vec<Tag> {
    let reach = Reach::of(scene, DISC);
    let judge = Judge {
        world: World::new(scene),
        robot: Exact(MobileManipulator::default()),
        camera: TagCamera::new(scene.limits.d_ins),
        reach: &reach,
    };
    let mut by_category: BTreeMap<&str, Vec<(&str, Spot)>> = BTreeMap::new();
    for piece in pieces {
        for spot in &piece.spots {
            let list = by_category.entry(spot.category).or_default();
            list.push((&piece.name, spot.clone()));
        }
    }
    for list in by_category.values_mut() {
        dice.shuffle(list);
    }
    let mut categories: Vec<&str> = by_category.keys().copied().collect();
    dice.shuffle(&mut categories);
    let mut tags: Vec<Tag> = Vec::new();
    let mut turn = 0;
    // Each round tries a wall or the next place of the next kind; enough rounds for all places there are.
    let places: usize = by_category.values().map(Vec::len).sum();
    for _ in 0..places + 20 * blueprint.tags {
        if tags.len() >= blueprint.tags {
            break;
        }
        let drawn = if dice.share() < ON_WALLS || categories.is_empty() {
            on_wall(plan, dice).map(|spot| ("wall", spot))
        } else {
            turn += 1;
            by_category
                .get_mut(categories[turn % categories.len()])
                .and_then(Vec::pop)
        };
        let Some((on, spot)) = drawn else {
            continue;
        };
        let taken = tags.iter().any(|t| {
            let off = (0..3).map(|k| (t.center[k] - spot.center[k]).powi(2));
            off.sum::<f64>() < APART * APART
        });
        if taken {
            continue;
        }
        let tag = Tag {
            id: tags.len() as u32,
            center: spot.center,
            normal: spot.normal,
            up: spot.up,
            size: spot.size,
            attached_to: on.to_owned(),
            category: spot.category.to_owned(),
        };
        if judge.can_see(&tag, dice) {
            tags.push(tag);
        }
    }
    tags
}

/// A place on the wall of a room that is not closed.
fn on_wall(plan: &Plan, dice: &mut Dice) -> Option<Spot> {
    let index = dice.pick(plan.rooms.len());
    let room = plan.rooms[index];
    let (axis, far) = (dice.pick(2), dice.pick(2) == 1);
    let mut at = [0, 1].map(|k| dice.between(room.min[k] + 0.3, room.max[k] - 0.3));
    at[axis] = if far { room.max[axis] } else { room.min[axis] };
    let mut normal = [0.0; 3];
    normal[axis] = if far { -1.0 } else { 1.0 };
    // Not where there is no wall.
    let behind = Rect::about(
        [at[0] - 0.05 * normal[0], at[1] - 0.05 * normal[1]],
        [0.01; 2],
    );
    let across = 1 - axis;
    let mut print = behind;
    print.min[across] -= 0.15;
    print.max[across] += 0.15;
    let solid = plan.walls.iter().any(|w| w.contains(&print));
    (plan.closed != Some(index) && solid).then(|| Spot {
        category: "wall",
        center: [at[0], at[1], dice.between(0.5, 1.8)],
        normal,
        up: [0.0, 0.0, 1.0],
        size: 0.2,
    })
}
