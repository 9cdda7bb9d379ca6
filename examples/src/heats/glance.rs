//! Looking on the way: where the camera points while the base drives.
//!
//! The arm planner of HEATS brings the arm to its goal as soon as it can. The camera then sees where the next view happens to
//! look, for as long as the drive takes. Here the arm passes through a third posture on its way, the one from which the
//! cameras see most of what is left along the base's path.

use super::body::{Joints, Whole};
use super::motion::{BodyPath, MotionParams, STEP};
use robots::{BodyState, Frame};
use std::f64::consts::TAU;
use strrt::steps_needed;
use viewsample::Pose;

/// Steps of a path between two looks: when many postures are compared, and when the best are.
const COARSE: usize = 8;
/// See [`COARSE`].
const FINE: usize = 3;
/// Ways, with one posture or with several, that are compared finely.
const FINALISTS: usize = 5;
/// Steps of a path for each posture after the first that is tried.
const LONG: usize = 40;
/// Postures, the best alone, that are tried after the second one.
const CHOICE: usize = 10;
/// Turn of the base from which on it matters whether the camera keeps its heading, rad.
const TURN: f64 = 0.5;
/// Bearings of the shoulder pan that are tried with each posture.
const BEARINGS: usize = 12;
/// Turning rate of the camera up to which a look counts, rad/s: a little below what blurs images, for the controller's sake.
const STEADY: f64 = 0.9;
/// Least share of the arm's speed to which it slows down for sharp images.
const SLOWEST: f64 = 0.1;
/// Quarters of the time that the arm needs at full speed for its last move, when there is time.
const HOMING: usize = 5;

/// A pose of the base and one of the camera, at the same time.
pub(super) type Look = ([f64; 3], Pose);

fn frame_at(whole: &Whole<'_>, base: [f64; 3], joints: &Joints) -> Frame {
    whole.robot.camera_frame(&BodyState {
        base,
        joints: *joints,
    })
}

/// Angle between two rotations, rad.
fn turn(a: &Frame, b: &Frame) -> f64 {
    let (a, b) = (a.rows(), b.rows());
    let trace: f64 = (0..3)
        .flat_map(|i| (0..3).map(move |j| (i, j)))
        .map(|(i, j)| a[i][j] * b[i][j])
        .sum();
    (0.5 * (trace - 1.0)).clamp(-1.0, 1.0).acos()
}

/// The looks of a path that count.
pub(super) fn looks(whole: &Whole<'_>, path: &BodyPath) -> Vec<Look> {
    looks_every(whole, path, FINE)
}

/// The looks of a path: its camera every few steps where it turns slowly enough, and at the end.
fn looks_every(whole: &Whole<'_>, path: &BodyPath, stride: usize) -> Vec<Look> {
    let last = path.base.len() - 1;
    let look = |k: usize| {
        let frame = frame_at(whole, path.base[k], &path.joints[k]);
        let pose = Pose {
            rotation: frame.rows(),
            translation: frame.p,
        };
        (frame, pose)
    };
    let mut out = Vec::new();
    for k in (stride..last).step_by(stride) {
        let (now, pose) = look(k);
        let (before, _) = look(k - 2);
        if turn(&before, &now) <= STEADY * 2.0 * STEP {
            out.push((path.base[k], pose));
        }
    }
    out.push((path.base[last], look(last).1));
    out
}

/// Where the arm stays for a while on its way.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Via {
    joints: Joints,
    /// Whether the shoulder pan makes up for the base's turns, so that the camera goes on looking the same way.
    holds_heading: bool,
}

/// The path with its arm led through the postures, so many at `most`, from which most is seen on the way; as it was if none are
/// better. `worth` is the information of looks, `price` the information that a second of delay must bring. Also returns how
/// many looks were asked for.
pub(super) fn improve(
    whole: &Whole<'_>,
    params: &MotionParams,
    postures: &[Joints],
    path: BodyPath,
    (price, most): (f64, usize),
    worth: impl Fn(&[Look]) -> f64 + Sync,
) -> (BodyPath, usize) {
    if path.base.len() < FINE || !whole.arm_is_free(path.base[0], &path.joints[0]) {
        return (path, 0);
    }
    let vias = vias(params, postures, &path);
    let duration = path.seconds();
    let value = |path: &BodyPath, stride: usize| {
        let seen = looks_every(whole, path, stride);
        (
            worth(&seen) - price * (path.seconds() - duration),
            seen.len(),
        )
    };
    let mut asked = 0;
    // First one posture, then one more before, between or after the best, and again.
    let mut led: Vec<Led> = Vec::new();
    let mut rank = |led: &mut Vec<Led>, ways: &[Vec<Via>]| {
        let found = side_by_side(ways, |vias| {
            let path = lead(whole, params, &path, vias)?;
            Some((value(&path, COARSE), path))
        });
        for (vias, found) in ways.iter().zip(found) {
            if let Some(((value, looks), path)) = found {
                asked += looks;
                led.push((value, vias.clone(), path));
            }
        }
        led.sort_by(|a, b| b.0.total_cmp(&a.0));
    };
    let single: Vec<Vec<Via>> = vias.iter().map(|&v| vec![v]).collect();
    rank(&mut led, &single);
    let choice: Vec<Via> = led.iter().take(CHOICE).map(|l| l.1[0]).collect();
    led.truncate(FINALISTS);
    for count in 1..most {
        let Some((_, best, _)) = led.first().filter(|l| l.1.len() == count) else {
            break;
        };
        if path.base.len() <= count * LONG {
            break;
        }
        let more = if count == 1 { &vias } else { &choice };
        let ways: Vec<Vec<Via>> = more
            .iter()
            .flat_map(|&via| (0..=count).map(move |at| (via, at)))
            .map(|(via, at)| {
                let mut way = best.clone();
                way.insert(at, via);
                way
            })
            .collect();
        rank(&mut led, &ways);
        led.truncate(FINALISTS);
    }
    let (first, looks) = value(&path, FINE);
    asked += looks;
    let mut best = (first, path);
    let last = side_by_side(&led, |l| value(&l.2, FINE));
    for ((_, _, path), (value, looks)) in led.into_iter().zip(last) {
        asked += looks;
        if value > best.0 + 1e-9 {
            best = (value, path);
        }
    }
    (best.1, asked)
}

/// A value, the postures on the way, and the path that leads through them.
type Led = (f64, Vec<Via>, BodyPath);

/// Applies a function to each item, on as many threads as the machine has, at most four; results in the items' order.
fn side_by_side<T: Sync, R: Send>(items: &[T], apply: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get().min(4));
    let chunk = items.len().div_ceil(threads).max(1);
    if threads == 1 || items.len() < 2 * threads {
        return items.iter().map(apply).collect();
    }
    std::thread::scope(|scope| {
        let apply = &apply;
        let parts: Vec<_> = items
            .chunks(chunk)
            .map(|part| scope.spawn(move || part.iter().map(apply).collect::<Vec<R>>()))
            .collect();
        parts
            .into_iter()
            .flat_map(|part| match part.join() {
                Ok(results) => results,
                Err(panic) => std::panic::resume_unwind(panic),
            })
            .collect()
    })
}

/// The postures of the library at all bearings, each at the turn of the pan nearest to where the arm comes from and goes to.
fn vias(params: &MotionParams, postures: &[Joints], path: &BodyPath) -> Vec<Via> {
    let (low, high) = params.joint_range[0];
    let middle = 0.5 * (path.joints[0][0] + path.end().1[0]);
    let first = path.base[0][2];
    let turns = path.base.iter().any(|b| (b[2] - first).abs() > TURN);
    let mut vias = Vec::new();
    for posture in postures {
        for k in 0..BEARINGS {
            let pan = posture[0] + TAU * k as f64 / BEARINGS as f64;
            let pan = pan + TAU * ((middle - pan) / TAU).round();
            if pan < low || pan > high {
                continue;
            }
            let mut joints = *posture;
            joints[0] = pan;
            for holds_heading in [false, true] {
                if turns || !holds_heading {
                    vias.push(Via {
                        joints,
                        holds_heading,
                    });
                }
            }
        }
    }
    vias
}

/// The path with the arm led through postures, staying at each for an equal share of the time that is left; `None` if that is not
/// free.
fn lead(
    whole: &Whole<'_>,
    params: &MotionParams,
    path: &BodyPath,
    vias: &[Via],
) -> Option<BodyPath> {
    let to = path.end().1;
    let speed = [params.joint_speed; 6];
    let steps = |a: &Joints, b: &Joints| steps_needed(a, b, &speed, STEP);
    let mut q = path.joints[0];
    let mut moves = Vec::with_capacity(vias.len());
    for via in vias {
        moves.push(steps(&q, &via.joints));
        q = via.joints;
    }
    let last = path.base.len() - 1;
    let spare = last.saturating_sub(moves.iter().sum::<usize>() + steps(&q, &to));
    let share = spare / vias.len();
    let (low, high) = params.joint_range[0];
    let most = params.joint_speed * STEP;
    let mut q = path.joints[0];
    let mut out = BodyPath {
        base: vec![path.base[0]],
        joints: vec![q],
    };
    let mut eye = frame_at(whole, path.base[0], &q);
    let mut via = 0;
    let mut left = moves[0] + share;
    // Chasing moving goals takes longer than the sum of the moves, but not without end.
    for k in 1..=2 * last + 400 {
        while via < vias.len() && left == 0 {
            via += 1;
            left = moves.get(via).map_or(0, |m| m + share);
        }
        left = left.saturating_sub(1);
        let base = path.base[k.min(last)];
        let goal = match vias.get(via) {
            // Back in time for the end.
            Some(_) if k + HOMING * steps(&q, &to) / 4 > last && spare > 0 => {
                via = vias.len();
                to
            }
            Some(v) => {
                let mut goal = v.joints;
                if v.holds_heading {
                    goal[0] = (goal[0] - (base[2] - path.base[0][2])).clamp(low, high);
                }
                goal
            }
            None => to,
        };
        let homing = via == vias.len();
        let was = q;
        for j in 0..6 {
            q[j] += (goal[j] - q[j]).clamp(-most, most);
        }
        // No faster than what gives sharp images, where the arm can see to that.
        let frame = frame_at(whole, base, &q);
        let angle = turn(&eye, &frame);
        if angle > STEADY * STEP {
            let share = (STEADY * STEP / angle).max(SLOWEST);
            let slowed: Joints = std::array::from_fn(|j| was[j] + share * (q[j] - was[j]));
            let slower = frame_at(whole, base, &slowed);
            if turn(&eye, &slower) < angle {
                q = slowed;
                eye = slower;
            } else {
                eye = frame;
            }
        } else {
            eye = frame;
        }
        if !whole.arm_is_free(base, &q) {
            return None;
        }
        out.base.push(base);
        out.joints.push(q);
        if homing && k >= last && q == to {
            return Some(out);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heats::fixture::{free_closet, looking};
    use crate::heats::mapping::Mapper;
    use hybrid_astar::Limits;
    use robots::MobileManipulator;

    /// A free hall, a base that drives and turns, an arm that goes somewhere else meanwhile.
    fn hall() -> (MobileManipulator, Mapper, MotionParams, BodyPath) {
        let mapper = free_closet();
        let robot = MobileManipulator::default();
        let home = looking(&robot, 0.0);
        let mut end = home;
        end[0] += 0.4;
        let params = MotionParams {
            base: Limits::default(),
            joint_speed: 0.76,
            joint_range: [(-TAU, TAU); 6],
            arm_iterations: 100,
        };
        let steps = 60;
        let path = BodyPath {
            base: (0..=steps)
                .map(|k| {
                    let t = k as f64 / steps as f64;
                    [1.5 + 0.8 * t, 2.0, 1.2 * t]
                })
                .collect(),
            joints: (0..=steps)
                .map(|k| {
                    let t = (k as f64 / 6.0).min(1.0);
                    std::array::from_fn(|j| home[j] + t * (end[j] - home[j]))
                })
                .collect(),
        };
        (robot, mapper, params, path)
    }

    #[test]
    fn led_paths_keep_ends_speed_and_base() {
        let (robot, mapper, params, path) = hall();
        let whole = Whole {
            robot: &robot,
            mapper: &mapper,
            base_clearance: 0.0,
            arm_clearance: 0.0,
        };
        let postures = [path.joints[0]];
        // What is worth seeing lies to the right, while the base turns to the left.
        let right = |looks: &[Look]| {
            looks
                .iter()
                .map(|(_, camera)| (-camera.rotation[1][2]).max(0.0))
                .sum::<f64>()
        };
        let (led, asked) = improve(&whole, &params, &postures, path.clone(), (0.1, 2), right);
        assert!(asked > 0);
        assert_eq!(led.joints[0], path.joints[0]);
        assert_eq!(led.end(), path.end());
        assert_eq!(led.base[..path.base.len()], path.base[..]);
        assert!(
            led.base[path.base.len()..]
                .iter()
                .all(|b| *b == path.end().0)
        );
        for pair in led.joints.windows(2) {
            for j in 0..6 {
                assert!((pair[1][j] - pair[0][j]).abs() <= params.joint_speed * STEP + 1e-9);
            }
        }
        let value = |path: &BodyPath| right(&looks(&whole, path));
        assert!(
            value(&led) > value(&path) + 1.0,
            "{} {}",
            value(&led),
            value(&path)
        );
        let (again, _) = improve(&whole, &params, &postures, path, (0.1, 2), right);
        assert_eq!(again, led);
    }

    #[test]
    fn nothing_to_see_changes_nothing() {
        let (robot, mapper, params, path) = hall();
        let whole = Whole {
            robot: &robot,
            mapper: &mapper,
            base_clearance: 0.0,
            arm_clearance: 0.0,
        };
        let (led, _) = improve(
            &whole,
            &params,
            &[path.joints[0]],
            path.clone(),
            (1.0, 2),
            |_| 0.0,
        );
        assert_eq!(led, path);
    }
}
