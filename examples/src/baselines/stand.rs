//! Where the base stands and how the arm is held so that the camera is at a view; and the decoupled way there: the arm is drawn in if
//! it must, the base drives, the arm reaches out.

use super::settings::StandSettings;
use super::view::View;
use crate::heats::{
    BodyPath, Failure, Joints, MotionParams, Ways, Whole, plan_arm, plan_base, trapezoid,
};
use hybrid_astar::{GoalYaw, Planner};
use std::f64::consts::{PI, TAU};

/// Room of a base pose at the end of a path beyond what paths need, m.
const GOAL_ROOM: f64 = 0.04;
/// A base that is so near to where it should be stays, m.
const STAYS: f64 = 0.03;
/// Room of the base below which the controller's guard lets nothing but the base move, m.
const STUCK: f64 = 0.03;
/// Ends of ways that are planned for one view.
const STANDS: usize = 3;
/// Room that a held arm needs along a base path, m.
const CARRIED: f64 = 0.02;

/// A whole-body state that shows a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stand {
    /// Base pose, m and rad.
    pub base: [f64; 3],
    /// Arm posture, rad.
    pub joints: Joints,
    /// Time from where the robot is, about: base, then arm, s.
    pub seconds: f64,
}

fn between(a: f64, b: f64) -> f64 {
    let d = (a - b).rem_euclid(TAU);
    d.min(TAU - d)
}

fn arm_seconds(params: &MotionParams, from: &Joints, to: &Joints) -> f64 {
    (0..6)
        .map(|j| (from[j] - to[j]).abs() / params.joint_speed)
        .fold(0.0, f64::max)
}

/// Turn, drive and turn, forwards or backwards, each from rest to rest.
fn base_seconds(params: &MotionParams, way: f64, from: [f64; 3], to: [f64; 3]) -> f64 {
    let turn = |angle: f64| trapezoid(angle, params.base.w, params.base.alpha);
    if way < STAYS {
        return turn(between(from[2], to[2]));
    }
    let heading = (to[1] - from[1]).atan2(to[0] - from[0]);
    [heading, heading + PI]
        .into_iter()
        .map(|yaw| {
            turn(between(yaw, from[2]))
                + trapezoid(way, params.base.v, params.base.a)
                + turn(between(yaw, to[2]))
        })
        .fold(f64::INFINITY, f64::min)
}

/// The arm's way to a view from where the base stands, if there is one.
pub(super) fn in_reach(
    whole: &Whole<'_>,
    params: &MotionParams,
    from: ([f64; 3], Joints),
    view: &View,
) -> Option<Stand> {
    // A base that is too near to something must move before anything else may.
    if whole.base_room(from.0) < STUCK {
        return None;
    }
    let found = whole.robot.ik_camera_frame(from.0, &view.frame(), &from.1);
    found
        .as_slice()
        .iter()
        .find(|s| whole.arm_is_free(from.0, &s.joints))
        .map(|s| Stand {
            base: from.0,
            joints: s.joints,
            seconds: arm_seconds(params, &from.1, &s.joints),
        })
}

/// The stands that show a view, the quickest first. `looked` counts those whose arm was asked for.
pub(super) fn stands(
    whole: &Whole<'_>,
    ways: &Ways,
    params: &MotionParams,
    settings: &StandSettings,
    from: ([f64; 3], Joints),
    view: &View,
    looked: &mut usize,
) -> Vec<Stand> {
    let frame = view.frame();
    let mut found: Vec<Stand> = in_reach(whole, params, from, view).into_iter().collect();
    for &distance in &settings.distances {
        for k in 0..settings.bearings {
            let bearing = view.yaw + PI + TAU * k as f64 / settings.bearings as f64;
            let place = [
                view.place[0] + distance * bearing.cos(),
                view.place[1] + distance * bearing.sin(),
            ];
            let heading = (place[1] - from.0[1]).atan2(place[0] - from.0[0]);
            let mut way = None;
            let turned = |k: usize| view.yaw + TAU * k as f64 / settings.yaws as f64;
            for yaw in [heading, heading + PI]
                .into_iter()
                .chain((0..settings.yaws).map(turned))
            {
                let base = [place[0], place[1], yaw];
                if whole.base_room(base) < whole.base_clearance + GOAL_ROOM {
                    continue;
                }
                let way = *way.get_or_insert_with(|| ways.meters([from.0[0], from.0[1]], place));
                if way.is_infinite() {
                    break;
                }
                let driven = base_seconds(params, way, from.0, base);
                // No stand that takes longer than the third best is asked for its arm.
                if found.len() > STANDS && found[STANDS].seconds < driven {
                    continue;
                }
                *looked += 1;
                let reach = whole.robot.ik_camera_frame(base, &frame, &from.1);
                let free = reach
                    .as_slice()
                    .iter()
                    .find(|s| whole.arm_is_free(base, &s.joints));
                if let Some(s) = free {
                    let seconds = driven + arm_seconds(params, &from.1, &s.joints);
                    let at = found.partition_point(|f| f.seconds <= seconds);
                    found.insert(
                        at,
                        Stand {
                            base,
                            joints: s.joints,
                            seconds,
                        },
                    );
                }
            }
        }
    }
    found.truncate(STANDS);
    found
}

/// Effort of planning: nodes expanded by base paths, samples of arm paths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Effort {
    /// Nodes.
    pub nodes: usize,
    /// Samples.
    pub samples: usize,
}

fn append(path: &mut BodyPath, more: BodyPath) {
    path.base.extend(more.base.into_iter().skip(1));
    path.joints.extend(more.joints.into_iter().skip(1));
}

/// Plans the decoupled way to a stand: base first, then arm. An arm that would touch something on the way is drawn in to `home` before.
///
/// # Errors
/// The planner's reason in words.
pub(super) fn plan_way(
    planner: &mut Planner,
    whole: &Whole<'_>,
    params: &MotionParams,
    from: ([f64; 3], Joints),
    stand: &Stand,
    home: &Joints,
    seed: u64,
    effort: &mut Effort,
) -> Result<BodyPath, Failure> {
    let (start, joints) = from;
    let moves = (start[0] - stand.base[0]).hypot(start[1] - stand.base[1]) >= STAYS
        || between(start[2], stand.base[2]) > 0.02;
    let mut path = BodyPath {
        base: vec![start],
        joints: vec![joints],
    };
    if moves {
        let goal = [stand.base[0], stand.base[1]];
        let yaw = GoalYaw::Fixed(stand.base[2]);
        let base = plan_base(planner, whole, params, start, 0.0, goal, &yaw)?;
        effort.nodes += base.expansions;
        let carried = |joints: &Joints| {
            let last = base.poses.len() - 1;
            let room = |i: usize| whole.arm_room(base.poses[i.min(last)], joints) >= CARRIED;
            (0..=last).step_by(2).chain([last]).all(room)
        };
        let mut held = joints;
        if !carried(&held) {
            if !carried(home) {
                return Err(Failure("the arm does not fit along the base path".into()));
            }
            let (drawn, samples) = plan_arm(whole, params, &[start], held, *home, seed)?;
            effort.samples += samples;
            append(&mut path, drawn);
            held = *home;
        }
        let joints = vec![held; base.poses.len()];
        append(
            &mut path,
            BodyPath {
                base: base.poses,
                joints,
            },
        );
    }
    let (end, held) = path.end();
    // The path's yaw may be whole turns away from the stand's.
    let goal = nearest_turns(&held, stand.joints, params);
    let (reached, samples) = plan_arm(whole, params, &[end], held, goal, seed ^ 1)?;
    effort.samples += samples;
    append(&mut path, reached);
    Ok(path)
}

/// The same posture with each joint's whole turns nearest to where it is, within its range.
fn nearest_turns(from: &Joints, to: Joints, params: &MotionParams) -> Joints {
    std::array::from_fn(|j| {
        let turns = ((from[j] - to[j]) / TAU).round();
        let near = to[j] + turns * TAU;
        let (low, high) = params.joint_range[j];
        if (low..=high).contains(&near) {
            near
        } else {
            to[j]
        }
    })
}
