//! Ways straight to the goal, tried on the way.

use crate::moves::{Motion, Move};
use crate::search::Task;
use crate::steer::{self, Way};
use crate::{GoalYaw, Map};

/// The cheapest free way straight to the goal, if it costs less than `limit`.
pub(crate) fn shot<M: Map>(
    task: &Task<'_, M>,
    pose: [f64; 3],
    motion: Option<Motion>,
    missing: f64,
    limit: f64,
) -> Option<(Way, f64)> {
    let mut list: Vec<(f64, Way)> = Vec::new();
    for way in ways_to_goal(task, pose) {
        if way.iter().map(|m| task.price.steady(m)).sum::<f64>() >= limit {
            continue;
        }
        let cost = task.price.way(motion, &way);
        if cost < limit {
            list.push((cost, way));
        }
    }
    list.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (cost, way) in list.into_iter().take(3) {
        let mut p = pose;
        let mut short = Some(missing);
        let mut near = 0.0;
        let mut room = None;
        for m in &way {
            let swept = short.and_then(|s| task.body.sweep(task.map, p, m, s, room));
            short = swept.map(|s| s.missing);
            room = swept.map(|s| s.room);
            let Some(swept) = swept else {
                break;
            };
            near += task.price.closeness(task.map, p, m) + task.price.trouble(m, swept.share);
            p = m.end(p);
        }
        if short == Some(0.0) && cost + near < limit {
            return Some((way, cost + near));
        }
    }
    None
}

/// Radii tried for curves, as multiples of the smallest one: driven at full speed, or the car's.
const RADII: [f64; 3] = [1.02, 1.8, 3.2];

impl<M> Task<'_, M> {
    /// Radii tried for curves, m.
    pub(crate) fn radii(&self) -> [f64; 3] {
        match self.params.drive.radius() {
            Some(radius) => [radius, RADII[1] * radius, RADII[2] * radius],
            None => RADII.map(|r| r * self.price.limits.v / self.price.limits.w),
        }
    }
}

/// All the ways from a pose to the goal that ignore obstacles and that the base can drive.
pub(crate) fn ways_to_goal<M>(task: &Task<'_, M>, pose: [f64; 3]) -> Vec<Way> {
    let drive = task.params.drive;
    let tight = task.price.limits.v / task.price.limits.w;
    let radii = task.radii();
    let settle = |yaw: f64| task.yaw.nearest(yaw);
    let mut list = vec![steer::rotate_line(pose, task.goal, Motion::Forward, settle)];
    let far = (task.goal[0] - pose[0]).hypot(task.goal[1] - pose[1]);
    if far <= task.params.reverse_reach {
        list.push(steer::rotate_line(pose, task.goal, Motion::Reverse, settle));
    }
    let targets = task.yaw.targets();
    if targets.is_empty() || matches!(task.yaw, GoalYaw::Within { .. }) {
        let mut add = |way: Option<Way>| {
            if let Some(mut way) = way {
                let end = steer::end(pose, &way);
                let last = settle(end[2]) - end[2];
                if last.abs() > 1e-9 {
                    way.push(Move::turn(last));
                }
                list.push(way);
            }
        };
        let arc = steer::single_arc(pose, task.goal, Motion::Forward);
        add(arc
            .filter(|a| a.curvature.abs() * tight <= 1.0)
            .map(|a| vec![a]));
        for r in radii {
            for side in [1.0, -1.0] {
                add(steer::arc_line(pose, task.goal, r, side, Motion::Forward));
            }
        }
    }
    for yaw in targets {
        let to = [task.goal[0], task.goal[1], yaw];
        steer::between(pose, to, &radii, drive, &mut list);
        if far <= 3.0 * task.params.reverse_reach {
            steer::dubins(pose, to, radii[0], Motion::Reverse, |way| list.push(way));
        }
    }
    list.retain(|way| way.iter().all(|m| drive.allows(m)));
    list
}
