//! The planner: waits, variants, and what comes out.

use crate::error::Error;
use crate::line::{Task, cost, distance, steps_needed};
use crate::refine::{round, shortcut};
use crate::rng::Rng;
use crate::robot::Robot;
use crate::tree::Tree;

/// How the search tree grows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Variant {
    /// HEATS as published: one time step per sample, choice of parent and rewiring over neighbouring layers.
    Published,
    /// The same, but each sample is followed until it is reached or blocked, and every new node tries the timed straight line
    /// to the goal.
    MultiStep,
    /// Two trees, from the start forwards and from the goal backwards in time, then shortcuts.
    #[default]
    Bidirectional,
}

/// Effort and variant.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// How the tree grows.
    pub variant: Variant,
    /// Samples per number of waiting steps tried.
    pub iterations: usize,
    /// Share of samples that are the goal itself.
    pub goal_bias: f64,
    /// Attempts to shorten the path found (all variants but the published one).
    pub shortcuts: usize,
    /// Passes of corner rounding at the end.
    pub rounding: usize,
    /// Room for waiting beyond the least time the arm needs, as a factor.
    pub slack: f64,
    /// Most steps of waiting.
    pub max_wait: usize,
    /// First steps whose states need not be valid: for a start that the map overran.
    pub start_grace: usize,
    /// Keep the first path found (after shortcuts) instead of using all samples to improve it.
    pub first_path: bool,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            variant: Variant::Bidirectional,
            iterations: 2000,
            goal_bias: 0.1,
            shortcuts: 100,
            rounding: 4,
            slack: 1.1,
            max_wait: 200,
            start_grace: 0,
            first_path: true,
        }
    }
}

/// How planning ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// A path was found.
    Solved,
    /// The start or goal is not valid; no path exists.
    Infeasible,
    /// No path within the samples.
    BudgetExhausted,
}

/// Why there is no path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reason {
    /// The start state is not valid at the first step.
    StartInvalid,
    /// The goal state is not valid at the last step.
    GoalInvalid,
    /// The arm would have to wait longer than [`Params::max_wait`] allows.
    TooFar {
        /// Steps the joints need.
        needed: usize,
        /// Steps there are, waits included.
        available: usize,
    },
    /// The samples ran out.
    NotFound {
        /// Latest step that the tree from the start reached.
        reached: usize,
    },
}

/// A timed path of the arm.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan<const N: usize> {
    /// How planning ended.
    pub status: Status,
    /// Why there is no path.
    pub reason: Option<Reason>,
    /// One state per step: first `waited_before` with the base at its first pose, then one per pose, then `waited_after` with
    /// the base at its last. Empty without a path.
    pub path: Vec<[f64; N]>,
    /// Steps the base has to wait before it leaves.
    pub waited_before: usize,
    /// Steps the base waits at its end.
    pub waited_after: usize,
    /// Sum of Euclidean joint distances, rad; infinite without a path.
    pub cost: f64,
    /// Samples drawn.
    pub iterations: usize,
}

impl<const N: usize> Plan<N> {
    fn failed(status: Status, reason: Reason, iterations: usize) -> Self {
        Self {
            status,
            reason: Some(reason),
            path: Vec::new(),
            waited_before: 0,
            waited_after: 0,
            cost: f64::INFINITY,
            iterations,
        }
    }
}

/// Plans the arm's motion over `steps` poses of the base, `dt` s apart.
///
/// If the arm needs longer than the base, the base waits: at its end, and if that fails, at its start. Equal seeds give equal
/// plans.
///
/// # Errors
/// [`Error`] for no steps, a bad `dt`, limits or speeds, or ends outside the joint limits.
pub fn plan<const N: usize>(
    robot: &impl Robot<N>,
    start: [f64; N],
    goal: [f64; N],
    steps: usize,
    dt: f64,
    params: &Params,
    seed: u64,
) -> Result<Plan<N>, Error> {
    let mut task = Task::new(robot, start, goal, steps, dt)?;
    task.grace = params.start_grace;
    if task.grace == 0 && !robot.is_valid(&start, 0) {
        return Ok(Plan::failed(Status::Infeasible, Reason::StartInvalid, 0));
    }
    if !robot.is_valid(&goal, steps - 1) {
        return Ok(Plan::failed(Status::Infeasible, Reason::GoalInvalid, 0));
    }
    let least = steps_needed(&start, &goal, &robot.max_speed(), dt);
    let short = least.saturating_sub(steps - 1);
    if short > params.max_wait {
        let available = steps - 1 + params.max_wait;
        return Ok(Plan::failed(
            Status::Infeasible,
            Reason::TooFar {
                needed: least,
                available,
            },
            0,
        ));
    }
    // Straight lines first, with the least waiting: they solve most problems.
    let wanted = ((least as f64 * params.slack).ceil() as usize).saturating_sub(steps - 1);
    let room = wanted.max(short).min(params.max_wait);
    for (before, after) in [(0, room), (room, 0)] {
        (task.before, task.after) = (before, after);
        if let Some(path) = task.line(&start, 0, &goal, task.last()) {
            return Ok(solved(&task, path, 0));
        }
        if room == 0 {
            break;
        }
    }
    // Then trees, with more and more time.
    let extra = (room + least / 2 + 5).min(params.max_wait);
    let mut tried = vec![(0, room)];
    for wait in [(0, extra), (extra, 0), (extra, extra)] {
        if !tried.contains(&wait) {
            tried.push(wait);
        }
    }
    let mut rng = Rng::new(seed);
    let (mut iterations, mut reached) = (0, 0);
    for (before, after) in tried {
        (task.before, task.after) = (before, after);
        let (path, used, latest) = match params.variant {
            Variant::Bidirectional => connect(&task, &start, &goal, params, &mut rng),
            Variant::Published | Variant::MultiStep => grow(&task, &start, &goal, params, &mut rng),
        };
        iterations += used;
        reached = reached.max(latest.saturating_sub(before).min(steps - 1));
        if let Some(mut path) = path {
            if params.variant != Variant::Published {
                shortcut(&task, &mut path, params.shortcuts, &mut rng);
                round(&task, &mut path, params.rounding);
            }
            return Ok(solved(&task, path, iterations));
        }
    }
    Ok(Plan::failed(
        Status::BudgetExhausted,
        Reason::NotFound { reached },
        iterations,
    ))
}

fn solved<const N: usize, R: Robot<N>>(
    task: &Task<'_, N, R>,
    path: Vec<[f64; N]>,
    iterations: usize,
) -> Plan<N> {
    Plan {
        status: Status::Solved,
        reason: None,
        cost: cost(&path),
        path,
        waited_before: task.before,
        waited_after: task.after,
        iterations,
    }
}

/// A random state at a random step, from which both ends can be reached within the joints' speeds.
fn sample<const N: usize, R: Robot<N>>(
    task: &Task<'_, N, R>,
    start: &[f64; N],
    goal: &[f64; N],
    rng: &mut Rng,
) -> ([f64; N], usize) {
    let last = task.last();
    let step = 1 + rng.below(last.max(1));
    let q = std::array::from_fn(|j| {
        let (low, high) = task.limits[j];
        let (ahead, behind) = (
            task.reach[j] * step as f64,
            task.reach[j] * (last - step) as f64,
        );
        let low = low.max(start[j] - ahead).max(goal[j] - behind);
        let high = high.min(start[j] + ahead).min(goal[j] + behind);
        low + rng.unit() * (high - low).max(0.0)
    });
    (q, step)
}

/// One tree from the start (published and multi-step).
fn grow<const N: usize, R: Robot<N>>(
    task: &Task<'_, N, R>,
    start: &[f64; N],
    goal: &[f64; N],
    params: &Params,
    rng: &mut Rng,
) -> (Option<Vec<[f64; N]>>, usize, usize) {
    let last = task.last();
    let mut tree = Tree::new(true, *start, last);
    let published = params.variant == Variant::Published;
    let most = if published { 1 } else { usize::MAX };
    // (parent of the goal, step at which it is left)
    let mut ends: Vec<usize> = Vec::new();
    let mut latest = 0;
    let mut used = 0;
    if last == 0 {
        return ((distance(start, goal) < 1e-9).then(|| vec![*start]), 0, 0);
    }
    let best = |tree: &Tree<N>, ends: &[usize]| {
        let mut best: Option<(f64, usize)> = None;
        for &id in ends {
            let total = tree.nodes[id].cost + distance(&tree.nodes[id].q, goal);
            if best.is_none_or(|b| total < b.0) {
                best = Some((total, id));
            }
        }
        best
    };
    for _ in 0..params.iterations {
        used += 1;
        let (q, step) = if rng.unit() < params.goal_bias {
            (*goal, last)
        } else {
            sample(task, start, goal, rng)
        };
        let Some(near) = tree.nearest(task, &q, step) else {
            continue;
        };
        for id in tree.extend(task, near, &q, step, most, true) {
            let node = &tree.nodes[id];
            latest = latest.max(node.step);
            let cheaper = best(&tree, &ends)
                .is_none_or(|(total, _)| node.cost + distance(&node.q, goal) < total);
            // The published planner joins the goal from the step before the last; ours from anywhere by a timed line.
            let tries = if published {
                node.step + 1 == last
            } else {
                cheaper
            };
            if tries && node.step < last && task.line(&node.q, node.step, goal, last).is_some() {
                ends.push(id);
            }
        }
        if params.first_path && !published && !ends.is_empty() {
            break;
        }
    }
    let path = best(&tree, &ends).and_then(|(_, id)| {
        let mut path = tree.path_to(id);
        let node = &tree.nodes[id];
        path.extend_from_slice(&task.line(&node.q, node.step, goal, last)?[1..]);
        Some(path)
    });
    (path, used, latest)
}

/// Two trees that grow towards each other.
fn connect<const N: usize, R: Robot<N>>(
    task: &Task<'_, N, R>,
    start: &[f64; N],
    goal: &[f64; N],
    params: &Params,
    rng: &mut Rng,
) -> (Option<Vec<[f64; N]>>, usize, usize) {
    let last = task.last();
    if last == 0 {
        return ((distance(start, goal) < 1e-9).then(|| vec![*start]), 0, 0);
    }
    let mut trees = [Tree::new(true, *start, last), Tree::new(false, *goal, last)];
    let mut latest = 0;
    let mut best: Option<(f64, Vec<[f64; N]>)> = None;
    let mut used = 0;
    for i in 0..params.iterations {
        used += 1;
        let (here, there) = (i % 2, 1 - i % 2);
        let (q, step) = sample(task, start, goal, rng);
        let Some(near) = trees[here].nearest(task, &q, step) else {
            continue;
        };
        let Some(&tip) = trees[here]
            .extend(task, near, &q, step, usize::MAX, false)
            .last()
        else {
            continue;
        };
        let (q, step) = (trees[here].nodes[tip].q, trees[here].nodes[tip].step);
        if here == 0 {
            latest = latest.max(step);
        }
        let Some(near) = trees[there].nearest(task, &q, step) else {
            continue;
        };
        let met = trees[there]
            .extend(task, near, &q, step, usize::MAX, false)
            .last()
            .copied();
        let Some(met) = met.filter(|&m| {
            let node = &trees[there].nodes[m];
            node.step == step && distance(&node.q, &q) < 1e-9
        }) else {
            continue;
        };
        let (forward, backward) = if here == 0 { (tip, met) } else { (met, tip) };
        let mut path = trees[0].path_to(forward);
        let mut rest = trees[1].path_to(backward);
        rest.reverse();
        path.extend_from_slice(&rest[1..]);
        let total = cost(&path);
        if best.as_ref().is_none_or(|b| total < b.0) {
            best = Some((total, path));
        }
        if params.first_path {
            break;
        }
    }
    (best.map(|b| b.1), used, latest)
}
