//! Whole-body paths: base path with free goal yaw, compensation by the arm, arm path in time (HEATS sect. V-A).

use super::body::{Joints, Whole};
use hybrid_astar::{Footprint, GoalYaw, Limits, Planner};
use robots::{BodyState, Frame};
use strrt::{Status, steps_needed};

/// Time between states of a path, s.
pub(super) const STEP: f64 = 0.1;
/// Camera errors that count as the wanted view when no exact one exists: m and rad.
const NEAR: (f64, f64) = (0.15, 0.0873);

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
pub(super) struct BasePath {
    /// Poses at equal times.
    pub poses: Vec<[f64; 3]>,
    /// Nodes expanded for it.
    pub expansions: usize,
}

/// Plans the base from a pose (and speed along x, m/s) to a position.
///
/// # Errors
/// The planner's reason in words.
pub(super) fn plan_base(
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

/// Joints that give the wanted camera pose with the base where it will stand, free of collision; the quickest first.
pub(super) fn compensate(
    whole: &Whole<'_>,
    goal: &BodyState,
    base: [f64; 3],
    from: &Joints,
) -> Option<Joints> {
    let wanted: Frame = whole.robot.camera_frame(goal);
    let exact = whole.robot.ik_camera_frame(base, &wanted, from);
    if let Some(found) = exact
        .as_slice()
        .iter()
        .find(|s| whole.arm_is_free(base, &s.joints))
    {
        return Some(found.joints);
    }
    let near = whole.robot.compensate_yaw(goal, base, from).ok()?;
    (near.position_error <= NEAR.0
        && near.angle_error <= NEAR.1
        && whole.arm_is_free(base, &near.joints))
    .then_some(near.joints)
}

/// Plans the arm over the base's path; the base waits where the arm needs longer.
///
/// # Errors
/// The planner's reason in words.
pub(super) fn plan_arm(
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
pub(super) fn is_clear(whole: &Whole<'_>, path: &BodyPath, from: f64, margin: f64) -> bool {
    let first = (from / STEP) as usize;
    let last = path.base.len() - 1;
    (first..=last)
        .step_by(2)
        .chain([last])
        .all(|i| whole.room(path.base[i.min(last)], &path.joints[i.min(last)]) >= margin)
}
