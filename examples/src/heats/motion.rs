//! Whole-body paths: base path with free goal yaw, compensation by the arm, arm path in time (HEATS sect. V-A).

use super::body::{Joints, Whole};
use super::pace::trapezoid;
use hybrid_astar::{Footprint, GoalYaw, Limits, Planner};
use robots::{BodyState, Frame};
use std::f64::consts::PI;
use strrt::{Status, steps_needed};

/// Time between states of a path, s.
pub(crate) const STEP: f64 = 0.1;
/// States of base and arm at equal times.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyPath {
    /// Base poses, yaw without jumps.
    pub base: Vec<[f64; 3]>,
    /// Joints at the same times.
    pub joints: Vec<Joints>,
}

impl BodyPath {
    /// Duration, s.
    pub fn seconds(&self) -> f64 {
        STEP * self.base.len().saturating_sub(1) as f64
    }

    /// State at a time: linear between the samples, held at both ends.
    pub fn at(&self, t: f64) -> ([f64; 3], Joints) {
        let last = self.base.len() - 1;
        let u = (t / STEP).clamp(0.0, last as f64);
        let k = (u as usize).min(last.saturating_sub(1));
        let (f, next) = (u - k as f64, (k + 1).min(last));
        (
            std::array::from_fn(|i| self.base[k][i] + f * (self.base[next][i] - self.base[k][i])),
            std::array::from_fn(|j| {
                self.joints[k][j] + f * (self.joints[next][j] - self.joints[k][j])
            }),
        )
    }

    /// Last state.
    pub fn end(&self) -> ([f64; 3], Joints) {
        (
            self.base[self.base.len() - 1],
            self.joints[self.joints.len() - 1],
        )
    }
}

/// Why there is no whole-body path, in words.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure(pub String);

/// Limits and effort of the whole-body planner.
#[derive(Clone, Debug)]
pub struct MotionParams {
    /// Base limits that reference paths use.
    pub base: Limits,
    /// Joint speed that reference paths use, rad/s.
    pub joint_speed: f64,
    /// Joint ranges, rad.
    pub joint_range: [(f64, f64); 6],
    /// Samples of the arm planner.
    pub arm_iterations: usize,
}

/// The arm on a base that moves as planned.
struct ArmOnBase<'a> {
    whole: &'a Whole<'a>,
    base: &'a [[f64; 3]],
    params: &'a MotionParams,
}

impl strrt::Robot<6> for ArmOnBase<'_> {
    fn limits(&self) -> [(f64, f64); 6] {
        self.params.joint_range
    }
    fn max_speed(&self) -> [f64; 6] {
        [self.params.joint_speed; 6]
    }
    fn is_valid(&self, q: &Joints, step: usize) -> bool {
        self.whole.arm_is_free(self.base[step], q)
    }
}

/// The base path, planned once and timed.
#[derive(Clone, Debug)]
pub(crate) struct BasePath {
    /// Poses at equal times.
    pub poses: Vec<[f64; 3]>,
    /// Nodes expanded for it.
    pub expansions: usize,
}

/// Plans the base from a pose (and speed along x, m/s) to a position.
///
/// # Errors
/// The planner's reason in words.
pub(crate) fn plan_base(
    planner: &mut Planner,
    whole: &Whole<'_>,
    params: &MotionParams,
    from: [f64; 3],
    speed: f64,
    goal: [f64; 2],
    yaw: &GoalYaw,
) -> Result<BasePath, Failure> {
    let aligned = match yaw {
        GoalYaw::Fixed(yaw) => (yaw - from[2]).sin().abs() < 0.02 && (yaw - from[2]).cos() > 0.0,
        _ => true,
    };
    if aligned && (from[0] - goal[0]).hypot(from[1] - goal[1]) < 0.03 {
        return Ok(BasePath {
            poses: vec![from],
            expansions: 0,
        });
    }
    let footprint = Footprint::circles(whole.robot.base_circles());
    let plan = planner
        .plan(&whole.mapper.ground, &footprint, from, goal, yaw)
        .map_err(|e| Failure(format!("base path: {e}")))?;
    if !plan.is_solved() {
        let reason = plan
            .reason
            .as_ref()
            .map_or_else(|| format!("{:?}", plan.status), ToString::to_string);
        return Err(Failure(format!("base path: {reason}")));
    }
    let timed = plan
        .time_from(&params.base, STEP, speed)
        .or_else(|_| plan.time(&params.base, STEP))
        .map_err(|e| Failure(format!("base timing: {e}")))?;
    let poses = if timed.poses.is_empty() {
        vec![from]
    } else {
        timed.poses
    };
    Ok(BasePath {
        poses,
        expansions: plan.expansions,
    })
}

/// How a view is taken up at the end of a base path: how far the base turns on there, and the arm's posture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stance {
    /// Turn on the spot at the end, rad.
    pub turn: f64,
    /// Joints that show the view from there.
    pub joints: Joints,
    /// Time from setting out, about, s.
    pub seconds: f64,
}

/// Turns on the spot that are tried at the end of a path, rad: multiples of this up to half a turn either way.
const TURN_STEP: f64 = PI / 12.0;

/// The ways to take up a view where a base path ends, the quickest first.
///
/// HEATS leaves the yaw to the path and lets the shoulder pan make up for it. Base and shoulder turn the camera faster
/// together than either alone, and some views are in the arm's reach only from some yaws.
pub(super) fn stances(
    whole: &Whole<'_>,
    params: &MotionParams,
    goal: &BodyState,
    base: &[[f64; 3]],
    from: &Joints,
) -> Vec<Stance> {
    let end = base[base.len() - 1];
    let driven = STEP * (base.len() - 1) as f64;
    let wanted: Frame = whole.robot.camera_frame(goal);
    let mut found = Vec::new();
    for side in [1.0, -1.0] {
        for k in 0..=12 {
            let turn = side * TURN_STEP * f64::from(k);
            let pose = [end[0], end[1], end[2] + turn];
            if k > 0 && whole.base_room(pose) < whole.base_clearance - 0.01 {
                break;
            }
            if k == 0 && side < 0.0 {
                continue;
            }
            let until = driven + trapezoid(turn.abs(), params.base.w, params.base.alpha);
            for solution in whole.robot.ik_camera_frame(pose, &wanted, from).as_slice() {
                let steps = steps_needed(from, &solution.joints, &[params.joint_speed; 6], STEP);
                found.push(Stance {
                    turn,
                    joints: solution.joints,
                    seconds: until.max(STEP * steps as f64),
                });
            }
        }
    }
    found.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    found
}

/// Turns on the spot at the end of a path.
pub(super) fn turn_on(base: &mut Vec<[f64; 3]>, turn: f64, limits: &Limits) {
    let end = base[base.len() - 1];
    let (angle, total) = (turn.abs(), trapezoid(turn.abs(), limits.w, limits.alpha));
    let ramp = (limits.w / limits.alpha).min((angle / limits.alpha).sqrt());
    let steps = (total / STEP - 1e-9).ceil() as usize;
    for k in 1..=steps {
        let t = (STEP * k as f64).min(total);
        let done = if t < ramp {
            0.5 * limits.alpha * t * t
        } else if t < total - ramp {
            limits.alpha * ramp * (t - 0.5 * ramp)
        } else {
            angle - 0.5 * limits.alpha * (total - t).powi(2)
        };
        base.push([end[0], end[1], end[2] + done.copysign(turn)]);
    }
}

/// Plans the arm over the base's path; the base waits where the arm needs longer.
///
/// # Errors
/// The planner's reason in words.
pub(crate) fn plan_arm(
    whole: &Whole<'_>,
    params: &MotionParams,
    base: &[[f64; 3]],
    from: Joints,
    goal: Joints,
    seed: u64,
) -> Result<(BodyPath, usize), Failure> {
    let arm = ArmOnBase {
        whole,
        base,
        params,
    };
    let clamped: Joints =
        std::array::from_fn(|j| from[j].clamp(params.joint_range[j].0, params.joint_range[j].1));
    let blocked = !whole.arm_is_free(base[0], &clamped);
    let need = steps_needed(&clamped, &goal, &[params.joint_speed; 6], STEP);
    let settings = strrt::Params {
        iterations: params.arm_iterations,
        max_wait: need + 100,
        // A map update may have overrun the arm: let it leave.
        start_grace: if blocked { 8 } else { 0 },
        ..strrt::Params::default()
    };
    let plan = strrt::plan(&arm, clamped, goal, base.len(), STEP, &settings, seed)
        .map_err(|e| Failure(format!("arm path: {e}")))?;
    if plan.status != Status::Solved {
        return Err(Failure(format!("arm path: {:?}", plan.reason)));
    }
    let last = base.len() - 1;
    let poses = (0..plan.path.len())
        .map(|i| base[i.saturating_sub(plan.waited_before).min(last)])
        .collect();
    Ok((
        BodyPath {
            base: poses,
            joints: plan.path,
        },
        plan.iterations,
    ))
}

/// Whether the rest of a path, from a time on, keeps at least `margin` of room, looked at every 0.2 s.
pub(crate) fn is_clear(whole: &Whole<'_>, path: &BodyPath, from: f64, margin: f64) -> bool {
    let first = (from / STEP) as usize;
    let last = path.base.len() - 1;
    (first..=last)
        .step_by(2)
        .chain([last])
        .all(|i| whole.room(path.base[i.min(last)], &path.joints[i.min(last)]) >= margin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heats::fixture::{free_closet, looking};
    use robots::MobileManipulator;

    const LIMITS: Limits = Limits {
        v: 0.8,
        w: 0.9,
        a: 0.8,
        alpha: 2.0,
    };

    #[test]
    fn turns_on_the_spot_keep_the_limits_and_end_where_they_should() {
        for turn in [-3.0_f64, -0.4, -0.01, 0.0, 0.2, 1.0, 3.1] {
            let mut base = vec![[1.0, 2.0, 0.3]];
            turn_on(&mut base, turn, &LIMITS);
            let end = base[base.len() - 1];
            assert_eq!([end[0], end[1]], [1.0, 2.0]);
            assert!((end[2] - 0.3 - turn).abs() < 1e-9, "{turn}: {}", end[2]);
            let speeds: Vec<f64> = base
                .windows(2)
                .map(|p| (p[1][2] - p[0][2]) / STEP)
                .collect();
            assert!(speeds.iter().all(|w| w.abs() <= LIMITS.w + 1e-9));
            assert!(speeds.iter().all(|w| w * turn >= 0.0));
            let rest = [0.0];
            let all: Vec<f64> = rest.iter().chain(&speeds).copied().collect();
            assert!(
                all.windows(2)
                    .all(|p| (p[1] - p[0]).abs() <= LIMITS.alpha * STEP + 1e-9)
            );
            let least = trapezoid(turn.abs(), LIMITS.w, LIMITS.alpha);
            assert!(STEP * speeds.len() as f64 <= least + STEP);
        }
    }

    #[test]
    fn stances_show_the_view_and_the_quickest_comes_first() {
        let mapper = free_closet();
        let robot = MobileManipulator::default();
        let whole = Whole {
            robot: &robot,
            mapper: &mapper,
            base_clearance: 0.0,
            arm_clearance: 0.0,
        };
        let joints = looking(&robot, -0.3);
        let params = MotionParams {
            base: LIMITS,
            joint_speed: 0.76,
            joint_range: [(-2.0 * PI, 2.0 * PI); 6],
            arm_iterations: 100,
        };
        let goal = BodyState {
            base: [2.0, 2.0, 2.5],
            joints,
        };
        let wanted = robot.camera_frame(&goal);
        let base = vec![[2.0, 2.0, 0.0]; 11];
        let found = stances(&whole, &params, &goal, &base, &joints);
        assert!(found.windows(2).all(|p| p[0].seconds <= p[1].seconds));
        for s in &found {
            let frame = robot.camera_frame(&BodyState {
                base: [2.0, 2.0, s.turn],
                joints: s.joints,
            });
            let off: f64 = (0..3).map(|a| (frame.p[a] - wanted.p[a]).powi(2)).sum();
            assert!(off.sqrt() < 1e-6);
        }
        // Quicker than turning the base alone: 1 s of waiting, then 2.5 rad.
        assert!(found[0].seconds < 1.0 + trapezoid(2.5, LIMITS.w, LIMITS.alpha) - 0.5);
    }
}
