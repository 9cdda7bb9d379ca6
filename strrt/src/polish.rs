//! Improvement of a path: shortcuts in space-time, whole, in part or in some joints; other timings; detours.

use crate::rng::Rng;
use crate::robot::Robot;
use crate::task::{Timed, between, cost, distance};

/// Attempts in vain after which a path counts as polished.
const PATIENCE: usize = 60;
/// Gains below this share of the cost do not count as progress.
const PROGRESS: f64 = 5e-4;

/// A path being improved.
pub(crate) struct Polish<const N: usize> {
    pub path: Vec<[f64; N]>,
    pub cost: f64,
    in_vain: usize,
}

impl<const N: usize> Polish<N> {
    pub(crate) fn new(path: Vec<[f64; N]>) -> Self {
        Self {
            cost: cost(&path),
            path,
            in_vain: 0,
        }
    }

    /// True when more attempts are not worth it.
    pub(crate) fn is_done(&self) -> bool {
        self.in_vain >= PATIENCE || self.path.len() < 3
    }

    /// One attempt. The cost never rises.
    pub(crate) fn attempt<R: Robot<N>>(
        &mut self,
        timed: &Timed<'_, '_, N, R>,
        still: bool,
        rng: &mut Rng,
    ) {
        self.in_vain += 1;
        let n = self.path.len();
        if n < 3 {
            return;
        }
        let (a, b) = stretch(n, 2, rng);
        let old = &self.path[a..=b];
        let kind = rng.unit();
        let new: Vec<[f64; N]> = if still && kind < 0.55 {
            // Time does not matter: the straight motion may take less of it.
            let swift = timed.swift(&old[0], &old[b - a]);
            if swift.len() > old.len() {
                return;
            }
            swift
        } else if kind < 0.15 {
            warp(old, rng)
        } else {
            // Towards the straight timed motion: speeds stay within the limits, since they are averages.
            let share = if kind < 0.55 { 1.0 } else { rng.unit().powi(2) };
            let some = kind > 0.8;
            let mask: [f64; N] =
                std::array::from_fn(|_| if some && rng.unit() < 0.5 { 0.0 } else { share });
            let last = b - a;
            (0..=last)
                .map(|i| {
                    let line = between(&old[0], &old[last], i as f64 / last as f64);
                    std::array::from_fn(|j| old[i][j] + mask[j] * (line[j] - old[i][j]))
                })
                .collect()
        };
        let (before, after) = (cost(old), cost(&new));
        let gain = before - after;
        // A mere change of timing is welcome too: it opens ways for what follows.
        let wanted = if kind < 0.15 {
            gain > -1e-12
        } else {
            gain > 1e-9
        };
        if !wanted || !fast_enough(timed, &new) || !timed.path_is_free(&new, a) {
            return;
        }
        // The stretch's ends stay as they are, bit for bit.
        let inner = new[1..new.len() - 1].iter().copied();
        self.path.splice(a + 1..b, inner);
        if gain > PROGRESS * self.cost {
            self.in_vain = 0;
        }
        self.cost = cost(&self.path);
    }

    /// A detour over a random state near the path, to leave a local optimum; `None` if it is not free.
    pub(crate) fn detour<R: Robot<N>>(
        path: &[[f64; N]],
        timed: &Timed<'_, '_, N, R>,
        rng: &mut Rng,
    ) -> Option<Self> {
        let n = path.len();
        if n < 5 {
            return None;
        }
        let (a, b) = stretch(n, 4, rng);
        let via = a + 1 + rng.below(b - a - 1);
        let size = 0.1 + 1.2 * rng.unit() * rng.unit();
        let task = timed.task;
        let q: [f64; N] = std::array::from_fn(|j| {
            let (low, high) = task.limits[j];
            let (ahead, behind) = (
                task.reach[j] * (via - a) as f64,
                task.reach[j] * (b - via) as f64,
            );
            let low = low.max(path[a][j] - ahead).max(path[b][j] - behind);
            let high = high.min(path[a][j] + ahead).min(path[b][j] + behind);
            let wish = path[via][j] + size * (2.0 * rng.unit() - 1.0);
            wish.max(low).min(high)
        });
        if !timed.is_valid(&q, via) {
            return None;
        }
        let to = timed.line(&path[a], a, &q, via)?;
        let back = timed.line(&q, via, &path[b], b)?;
        let mut new = path.to_vec();
        new[a..via].copy_from_slice(&to[..via - a]);
        new[via..b].copy_from_slice(&back[..b - via]);
        Some(Self::new(new))
    }
}

/// Two indices at least `least` apart, long and short stretches alike.
fn stretch(n: usize, least: usize, rng: &mut Rng) -> (usize, usize) {
    let most = n - 1 - least;
    let longest = if rng.unit() < 0.5 { most } else { most / 4 };
    let length = least + rng.below(longest + 1);
    let a = rng.below(n - length);
    (a, a + length)
}

/// The same way with another timing: what was passed in the middle is passed earlier or later.
fn warp<const N: usize>(old: &[[f64; N]], rng: &mut Rng) -> Vec<[f64; N]> {
    let last = (old.len() - 1) as f64;
    let was = (0.1 + 0.8 * rng.unit()) * last;
    let will = (was + (2.0 * rng.unit() - 1.0) * 0.3 * last).clamp(0.05 * last, 0.95 * last);
    (0..old.len())
        .map(|i| {
            let t = i as f64;
            let u = if t <= will {
                t * was / will
            } else {
                was + (t - will) * (last - was) / (last - will)
            };
            at(old, u)
        })
        .collect()
}

/// The state at a fractional index, clamped to the path.
pub(crate) fn at<const N: usize>(path: &[[f64; N]], u: f64) -> [f64; N] {
    let last = path.len() - 1;
    let i = (u.max(0.0) as usize).min(last);
    if i == last {
        return path[last];
    }
    between(&path[i], &path[i + 1], (u - i as f64).max(0.0))
}

/// True if every step is within the joints' speeds.
pub(crate) fn fast_enough<const N: usize, R: Robot<N>>(
    timed: &Timed<'_, '_, N, R>,
    path: &[[f64; N]],
) -> bool {
    path.windows(2).all(|w| timed.within_reach(&w[0], &w[1], 1))
}

/// True if the motion spends no joint distance at all.
pub(crate) fn is_straight<const N: usize>(cost: f64, start: &[f64; N], goal: &[f64; N]) -> bool {
    cost <= distance(start, goal) + 1e-9
}
