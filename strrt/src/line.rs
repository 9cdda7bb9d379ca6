//! Straight motions: how long they take and whether they are free.

use crate::error::Error;
use crate::robot::Robot;
use crate::task::{Task, Timed, Waits, between};

/// Least number of time steps of `dt` s that a straight motion needs within the joints' speeds (rad/s). Saturates where a
/// value is not finite or a speed is zero.
pub fn steps_needed<const N: usize>(
    from: &[f64; N],
    to: &[f64; N],
    max_speed: &[f64; N],
    dt: f64,
) -> usize {
    (0..N)
        .map(|j| to_steps((to[j] - from[j]).abs() / max_speed[j], dt))
        .max()
        .unwrap_or(0)
}

/// The same from rest to rest with joints that change their speed by at most `acceleration` rad/s^2: a trapezoid of speed, or
/// a triangle where top speed is not reached.
pub fn steps_needed_from_rest<const N: usize>(
    from: &[f64; N],
    to: &[f64; N],
    max_speed: &[f64; N],
    acceleration: f64,
    dt: f64,
) -> usize {
    (0..N)
        .map(|j| {
            let (way, v) = ((to[j] - from[j]).abs(), max_speed[j]);
            // Whole steps of both parts, so that a motion on the time grid can do it.
            if way * acceleration >= v * v {
                to_steps(way / v, dt).saturating_add(to_steps(v / acceleration, dt))
            } else {
                to_steps((way / acceleration).sqrt(), dt).saturating_mul(2)
            }
        })
        .max()
        .unwrap_or(0)
}

fn to_steps(seconds: f64, dt: f64) -> usize {
    let steps = seconds / dt;
    if steps.is_nan() {
        return usize::MAX;
    }
    (steps - 1e-9).ceil().max(0.0) as usize
}

/// The straight motion at even speed, one state per step, if it is within the joints' speeds and free; `None` otherwise.
///
/// # Errors
/// [`Error`] for no steps, a bad `dt`, limits or speeds, or ends outside the limits.
pub fn straight<const N: usize>(
    robot: &impl Robot<N>,
    start: [f64; N],
    goal: [f64; N],
    steps: usize,
    dt: f64,
) -> Result<Option<Vec<[f64; N]>>, Error> {
    let task = Task::new(robot, start, goal, steps, dt)?;
    let timed = Timed {
        task: &task,
        waits: Waits {
            before: 0,
            after: 0,
        },
    };
    if !timed.is_valid(&start, 0) || !timed.is_valid(&goal, steps - 1) {
        return Ok(None);
    }
    Ok(timed.line(&start, 0, &goal, timed.last()))
}

/// The straight motion with four timings: evenly, as soon as possible, as late as possible, in the middle. All have the least
/// cost there is.
pub(crate) fn straight_somehow<const N: usize, R: Robot<N>>(
    timed: &Timed<'_, '_, N, R>,
) -> Option<Vec<[f64; N]>> {
    let (start, goal, last) = (timed.task.start, timed.task.goal, timed.last());
    if let Some(path) = timed.line(&start, 0, &goal, last) {
        return Some(path);
    }
    let quick = (0..N)
        .map(|j| to_steps((goal[j] - start[j]).abs() / timed.task.reach[j], 1.0))
        .max()
        .unwrap_or(0)
        .max(1);
    let slack = last.checked_sub(quick).filter(|&s| s > 0)?;
    [0, slack, slack / 2].into_iter().find_map(|leave| {
        let path: Vec<[f64; N]> = (0..=last)
            .map(|i| {
                let done = i.saturating_sub(leave).min(quick);
                if done == quick {
                    goal
                } else {
                    between(&start, &goal, done as f64 / quick as f64)
                }
            })
            .collect();
        timed.path_is_free(&path, 0).then_some(path)
    })
}
