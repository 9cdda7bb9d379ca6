//! Shortcuts in space-time, and rounding of corners so that limited joint accelerations can follow.

use crate::line::{Task, cost, distance};
use crate::rng::Rng;
use crate::robot::Robot;

/// Replaces stretches between random steps by straight timed motions where that is shorter, fast enough and free.
pub(crate) fn shortcut<const N: usize, R: Robot<N>>(
    task: &Task<'_, N, R>,
    path: &mut [[f64; N]],
    tries: usize,
    rng: &mut Rng,
) {
    let n = path.len();
    if n < 3 {
        return;
    }
    for _ in 0..tries {
        let a = rng.below(n - 2);
        let b = a + 2 + rng.below(n - a - 2);
        if cost(&path[a..=b]) <= distance(&path[a], &path[b]) + 1e-9 {
            continue;
        }
        if let Some(line) = task.line(&path[a], a, &path[b], b) {
            path[a..=b].copy_from_slice(&line);
        }
    }
}

/// Moves inner states towards the middle of their neighbours as long as everything stays fast enough and free; the cost never
/// rises, because the detour through a midpoint is no longer.
pub(crate) fn round<const N: usize, R: Robot<N>>(
    task: &Task<'_, N, R>,
    path: &mut [[f64; N]],
    passes: usize,
) {
    for _ in 0..passes {
        for i in 1..path.len().saturating_sub(1) {
            let (a, b) = (path[i - 1], path[i + 1]);
            let middle: [f64; N] = std::array::from_fn(|j| 0.5 * (a[j] + b[j]));
            if distance(&middle, &path[i]) < 1e-6 {
                continue;
            }
            if task.can_step(&a, &middle, i - 1) && task.can_step(&middle, &b, i) {
                path[i] = middle;
            }
        }
    }
}
