//! The searches: one tree (published and multi-step) or two (bidirectional). One call of `iterate` is one sample.

use crate::plan::{Params, Variant};
use crate::rng::Rng;
use crate::robot::Robot;
use crate::still::Still;
use crate::task::{Timed, distance};
use crate::tree::Tree;

/// Weight of what lies beyond the joints' speeds in the choice of the nearest node.
const SPEED_WEIGHT: f64 = 10.0;
/// Share of samples near nodes that are far in time.
const LOCAL: f64 = 0.3;
/// Share of samples at steps where growth is often blocked.
const NARROW: f64 = 0.3;
/// Draws for one such sample.
const TRIES: usize = 32;
/// Share of samples that are reached as quickly as possible and then held, instead of at even speed.
const QUICK: f64 = 0.5;

/// A search under way.
pub(crate) enum Search<const N: usize> {
    /// A tree from the start, and its nodes from which a timed line leads to the goal.
    One {
        tree: Box<Tree<N>>,
        ends: Vec<usize>,
        reported: f64,
    },
    /// Trees from the start and the goal, and samples drawn so far: they take turns.
    Two {
        trees: Box<[Tree<N>; 2]>,
        samples: usize,
    },
    /// Two trees without time, where nothing moves.
    Still(Box<Still<N>>),
}

impl<const N: usize> Search<N> {
    /// Where nothing moves, `still` is the most steps that a path may take.
    pub(crate) fn new<R: Robot<N>>(
        timed: &Timed<'_, '_, N, R>,
        variant: Variant,
        still: Option<usize>,
    ) -> Self {
        let (start, goal, last) = (timed.task.start, timed.task.goal, timed.last());
        if let Some(most) = still {
            return Self::Still(Box::new(Still::new(timed.task, most)));
        }
        match variant {
            Variant::Published | Variant::MultiStep => Self::One {
                tree: Box::new(Tree::new(true, start, last)),
                ends: Vec::new(),
                reported: f64::INFINITY,
            },
            Variant::Bidirectional => Self::Two {
                trees: Box::new([Tree::new(true, start, last), Tree::new(false, goal, last)]),
                samples: 0,
            },
        }
    }

    /// Samples drawn by two trees.
    pub(crate) fn samples(&self) -> usize {
        match self {
            Self::One { .. } => 0,
            Self::Two { samples, .. } => *samples,
            Self::Still(search) => search.samples,
        }
    }

    /// Draws one sample; returns a path if a better one than before comes of it (better than `bound`, for two trees), and the
    /// latest step that the tree from the start reached with it.
    pub(crate) fn iterate<R: Robot<N>>(
        &mut self,
        timed: &Timed<'_, '_, N, R>,
        params: &Params,
        bound: f64,
        rng: &mut Rng,
    ) -> (Option<Vec<[f64; N]>>, usize) {
        match self {
            Self::One {
                tree,
                ends,
                reported,
            } => one(timed, params, tree, ends, reported, bound, rng),
            Self::Two { trees, samples } => two(timed, trees, samples, bound, rng),
            Self::Still(search) => (search.iterate(timed, bound, rng), timed.last()),
        }
    }
}

/// A random state at a random step, by one of three ways.
fn draw<const N: usize, R: Robot<N>>(
    timed: &Timed<'_, '_, N, R>,
    tree: &Tree<N>,
    forward: bool,
    bound: f64,
    rng: &mut Rng,
) -> ([f64; N], usize) {
    let (kind, last) = (rng.unit(), timed.last());
    if kind < LOCAL {
        return sample_near(timed, tree, forward, rng);
    }
    if kind < LOCAL + NARROW
        && let Some(step) = tree.some_blocked(rng)
    {
        // Where growth is often blocked, free states are rare and worth looking for: such that stay free for a while.
        let mut drawn = (timed.task.start, step);
        for _ in 0..TRIES {
            drawn.0 = within_reach_of_both(timed, step, rng);
            if (-1..=1).all(|k| {
                let near = (step as isize + 3 * k).clamp(0, last as isize);
                timed.is_valid(&drawn.0, near as usize)
            }) {
                break;
            }
        }
        return drawn;
    }
    let mut drawn = (timed.task.start, 0);
    for _ in 0..8 {
        // Steps with a state on either side; there is none when the horizon has a single step.
        let step = if last < 2 {
            last
        } else {
            1 + rng.below(last - 1)
        };
        drawn = (within_reach_of_both(timed, step, rng), step);
        if distance(&drawn.0, &timed.task.start) + distance(&drawn.0, &timed.task.goal) < bound {
            break; // a path through here may still be shorter
        }
    }
    drawn
}

/// A random state from which both ends can be reached within the joints' speeds.
fn within_reach_of_both<const N: usize, R: Robot<N>>(
    timed: &Timed<'_, '_, N, R>,
    step: usize,
    rng: &mut Rng,
) -> [f64; N] {
    let (task, left) = (timed.task, timed.last() - step);
    std::array::from_fn(|j| {
        let (low, high) = task.limits[j];
        let (ahead, behind) = (task.reach[j] * step as f64, task.reach[j] * left as f64);
        let low = low.max(task.start[j] - ahead).max(task.goal[j] - behind);
        let high = high.min(task.start[j] + ahead).min(task.goal[j] + behind);
        low + rng.unit() * (high - low).max(0.0)
    })
}

/// A random state near a tree's node that is far in time, a little further on: finds ways through narrow places.
fn sample_near<const N: usize, R: Robot<N>>(
    timed: &Timed<'_, '_, N, R>,
    tree: &Tree<N>,
    forward: bool,
    rng: &mut Rng,
) -> ([f64; N], usize) {
    let (from, step) = tree.at(tree.some_far(rng));
    let (task, ahead) = (timed.task, 1 + rng.below(20));
    let size = (1.5 * rng.unit() - 0.5).max(0.0).powi(2);
    let q = std::array::from_fn(|j| {
        let (low, high) = task.limits[j];
        let most = size * task.reach[j] * ahead as f64;
        (from[j] + most * (2.0 * rng.unit() - 1.0)).clamp(low, high)
    });
    let step = if forward {
        (step + ahead).min(timed.last())
    } else {
        step.saturating_sub(ahead)
    };
    (q, step)
}

/// A random state at a random step, anywhere within the joint limits: as published.
fn sample_anywhere<const N: usize, R: Robot<N>>(
    timed: &Timed<'_, '_, N, R>,
    rng: &mut Rng,
) -> ([f64; N], usize) {
    let step = 1 + rng.below(timed.last());
    let q = std::array::from_fn(|j| {
        let (low, high) = timed.task.limits[j];
        low + rng.unit() * (high - low)
    });
    (q, step)
}

/// What a step of time counts in the choice of the nearest node: nothing, or up to some times the joints' motion in it. Without time,
/// early nodes would always win, however many obstacles come and go since; with it, distant ones near in time.
fn step_weight<const N: usize, R: Robot<N>>(timed: &Timed<'_, '_, N, R>, rng: &mut Rng) -> f64 {
    [0.0, 0.3, 1.0, 3.0][rng.below(4)] * mean_reach(timed)
}

fn mean_reach<const N: usize, R: Robot<N>>(timed: &Timed<'_, '_, N, R>) -> f64 {
    timed.task.reach.iter().sum::<f64>() / N.max(1) as f64
}

fn one<const N: usize, R: Robot<N>>(
    timed: &Timed<'_, '_, N, R>,
    params: &Params,
    tree: &mut Tree<N>,
    ends: &mut Vec<usize>,
    reported: &mut f64,
    bound: f64,
    rng: &mut Rng,
) -> (Option<Vec<[f64; N]>>, usize) {
    let (goal, last) = (timed.task.goal, timed.last());
    let published = params.variant == Variant::Published;
    let (q, step) = if rng.unit() < params.goal_bias {
        (goal, last)
    } else if published {
        sample_anywhere(timed, rng)
    } else {
        draw(timed, tree, true, bound, rng)
    };
    // The paper does not say how joints and time are weighed; alone, the joints would always choose early nodes.
    let weight = if published {
        (0.0, 0.3 * mean_reach(timed))
    } else {
        (SPEED_WEIGHT, step_weight(timed, rng))
    };
    let Some(near) = tree.nearest(timed, &q, step, weight) else {
        return (None, 0);
    };
    let first = tree.len();
    let tip = if published {
        tree.extend(timed, near, &q, step, 1, true)
    } else {
        tree.reach(timed, near, &q, step, rng.unit() < QUICK, true)
    };
    let Some(tip) = tip else {
        return (None, 0);
    };
    let reached = tree.at(tip).1;
    // The published planner joins the goal from the step before the last; ours from the tip and the nodes halfway to it, by a
    // timed line.
    let mut from = tip;
    loop {
        let (q, step) = tree.at(from);
        let total = tree.cost(from) + distance(q, &goal);
        let joins = if step == last {
            distance(q, &goal) < 1e-9
        } else if published {
            step + 1 == last && timed.line(q, step, &goal, last).is_some()
        } else {
            total < *reported && timed.line(q, step, &goal, last).is_some()
        };
        if joins {
            ends.push(from);
        }
        if published || joins || from <= first {
            break;
        }
        from = first + (from - first) / 2;
    }
    // Rewiring may have made an old end cheaper, so all are looked at.
    let total = |&id: &usize| tree.cost(id) + distance(tree.at(id).0, &goal);
    let best = ends
        .iter()
        .map(|id| (total(id), *id))
        .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let path = best
        .filter(|b| b.0 + 1e-9 < *reported)
        .and_then(|(total, id)| {
            let mut path = tree.path_to(id);
            let (q, step) = tree.at(id);
            if step < last {
                path.extend_from_slice(&timed.line(q, step, &goal, last)?[1..]);
            }
            *reported = total;
            Some(path)
        });
    (path, reached)
}

fn two<const N: usize, R: Robot<N>>(
    timed: &Timed<'_, '_, N, R>,
    trees: &mut [Tree<N>; 2],
    samples: &mut usize,
    bound: f64,
    rng: &mut Rng,
) -> (Option<Vec<[f64; N]>>, usize) {
    let (here, there) = (*samples % 2, 1 - *samples % 2);
    *samples += 1;
    let (q, step) = draw(timed, &trees[here], here == 0, bound, rng);
    let Some(near) = trees[here].nearest(timed, &q, step, (SPEED_WEIGHT, step_weight(timed, rng)))
    else {
        return (None, 0);
    };
    let Some(tip) = trees[here].reach(timed, near, &q, step, rng.unit() < QUICK, false) else {
        return (None, 0);
    };
    let (&q, step) = trees[here].at(tip);
    let reached = if here == 0 { step } else { 0 };
    // Only a node that can be there in time can meet the tip.
    let Some(near) =
        trees[there].nearest(timed, &q, step, (f64::INFINITY, step_weight(timed, rng)))
    else {
        return (None, reached);
    };
    let Some(met) = trees[there].reach(timed, near, &q, step, rng.unit() < QUICK, false) else {
        return (None, reached);
    };
    let (at, when) = trees[there].at(met);
    if when != step || distance(at, &q) > 1e-9 {
        return (None, reached);
    }
    let (forward, backward) = if here == 0 { (tip, met) } else { (met, tip) };
    let mut path = trees[0].path_to(forward);
    let mut rest = trees[1].path_to(backward);
    rest.reverse();
    path.extend_from_slice(&rest[1..]);
    (Some(path), reached)
}
