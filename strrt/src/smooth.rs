//! Time smoothing, so that joints of limited acceleration can follow.

use crate::error::Error;
use crate::plan::Plan;
use crate::polish::{at, fast_enough};
use crate::robot::Robot;
use crate::task::{Task, Timed, Waits, cost};

/// Longest filter, in steps.
const WIDEST: usize = 16;
/// Passes over the corners that are left.
const PASSES: usize = 12;

/// Largest joint acceleration of a path with states `dt` s apart, rad/s^2, at rest before its start and after its end.
pub fn peak_acceleration<const N: usize>(path: &[[f64; N]], dt: f64) -> f64 {
    (0..path.len()).map(|i| bend(path, i)).fold(0.0, f64::max) / (dt * dt)
}

/// Largest second difference at index `i`, rad.
fn bend<const N: usize>(path: &[[f64; N]], i: usize) -> f64 {
    let (a, b) = (
        &path[i.saturating_sub(1)],
        &path[(i + 1).min(path.len() - 1)],
    );
    (0..N)
        .map(|j| (a[j] - 2.0 * path[i][j] + b[j]).abs())
        .fold(0.0, f64::max)
}

/// Smooths a path in time until every joint keeps to `acceleration` rad/s^2 from rest to rest, as far as validity and the
/// joints' speeds let it: [`peak_acceleration`] tells. Number of states, ends and waits stay; the cost does not rise.
///
/// The whole path is run a little faster and then averaged over a sliding window, which rounds its corners and starts and
/// ends it at rest; corners that this leaves are averaged one by one.
///
/// # Errors
/// [`Error`] for an empty path, a bad `dt` or `acceleration`, or states outside the joint limits.
pub fn smooth<const N: usize>(
    robot: &impl Robot<N>,
    plan: &Plan<N>,
    dt: f64,
    acceleration: f64,
) -> Result<Plan<N>, Error> {
    if !(acceleration > 0.0 && acceleration.is_finite()) {
        return Err(Error::Param {
            field: "acceleration",
            value: acceleration,
            needed: "positive and finite",
        });
    }
    let path = &plan.path;
    let (Some(&start), Some(&goal)) = (path.first(), path.last()) else {
        return Err(Error::Path);
    };
    if path.iter().flatten().any(|q| !q.is_finite()) {
        return Err(Error::Path);
    }
    let steps = path
        .len()
        .saturating_sub(plan.waited_before.saturating_add(plan.waited_after));
    let mut task = Task::new(robot, start, goal, steps, dt)?;
    let waits = Waits {
        before: plan.waited_before,
        after: plan.waited_after,
    };
    // A start in violation stays where it is in time: the states up to the first free one are the grace.
    let leaving = Timed { task: &task, waits };
    let grace = (0..path.len())
        .find(|&i| leaving.is_valid(&path[i], i))
        .unwrap_or(path.len());
    task.grace = grace;
    let timed = Timed { task: &task, waits };
    let limit = acceleration * dt * dt * (1.0 + 1e-9);
    let smoothed = round(&timed, average(&timed, path, limit), limit);
    Ok(Plan {
        cost: cost(&smoothed),
        path: smoothed,
        checks: plan.checks + task.checks.get(),
        ..plan.clone()
    })
}

fn peak<const N: usize>(path: &[[f64; N]]) -> f64 {
    (0..path.len()).map(|i| bend(path, i)).fold(0.0, f64::max)
}

/// The narrowest sliding average that keeps the limit, or the one nearest to it.
fn average<const N: usize, R: Robot<N>>(
    timed: &Timed<'_, '_, N, R>,
    path: &[[f64; N]],
    limit: f64,
) -> Vec<[f64; N]> {
    let last = path.len() - 1;
    let mut best = (peak(path), path.to_vec());
    for width in 1..=WIDEST.min(last.saturating_sub(1)) {
        if best.0 <= limit {
            break;
        }
        let short = last - width;
        let quick: Vec<[f64; N]> = (0..=short)
            .map(|i| at(path, i as f64 * last as f64 / short as f64))
            .collect();
        let new: Vec<[f64; N]> = (0..=last)
            .map(|i| {
                if i == 0 || i == last {
                    return path[i];
                }
                let mut sum = [0.0; N];
                for k in 0..=width {
                    let q = &quick[i.saturating_sub(k).min(short)];
                    for j in 0..N {
                        sum[j] += q[j];
                    }
                }
                sum.map(|s| s / (width + 1) as f64)
            })
            .collect();
        let bend = peak(&new);
        if bend < best.0 && fast_enough(timed, &new) && timed.path_is_free(&new, 0) {
            best = (bend, new);
        }
    }
    best.1
}

/// Averages around the corners that are too sharp, as long as that makes them less sharp and stays free.
fn round<const N: usize, R: Robot<N>>(
    timed: &Timed<'_, '_, N, R>,
    mut path: Vec<[f64; N]>,
    limit: f64,
) -> Vec<[f64; N]> {
    let last = path.len() - 1;
    for _ in 0..PASSES {
        let mut changed = false;
        for i in 1..last {
            if bend(&path, i) <= limit {
                continue;
            }
            for half in [6usize, 3, 1] {
                let (from, to) = (i.saturating_sub(half + 1), (i + half + 1).min(last));
                let new: Vec<[f64; N]> = (from..=to)
                    .map(|k| {
                        if k == from || k == to {
                            return path[k];
                        }
                        // Symmetric, and narrower towards the window's ends, so that they stay.
                        let reach = (k - from).min(to - k).min(half);
                        let mut sum = [0.0; N];
                        for q in &path[k - reach..=k + reach] {
                            for j in 0..N {
                                sum[j] += q[j];
                            }
                        }
                        sum.map(|s| s / (2 * reach + 1) as f64)
                    })
                    .collect();
                let old = path[from..=to].to_vec();
                let worst =
                    |path: &[[f64; N]]| (from..=to).map(|k| bend(path, k)).fold(0.0, f64::max);
                let before = worst(&path);
                if cost(&new) > cost(&old) || !fast_enough(timed, &new) {
                    continue;
                }
                path[from..=to].copy_from_slice(&new);
                if worst(&path) < before && timed.path_is_free(&new, from) {
                    changed = true;
                    break;
                }
                path[from..=to].copy_from_slice(&old);
            }
        }
        if !changed {
            break;
        }
    }
    path
}
