//! Problem forms, parameters, and the choice between proof and search.

use crate::assignment::assignment;
use crate::cost::{CostMatrix, CostModel};
use crate::error::Error;
use crate::exact::held_karp;
use crate::local::Search;
use crate::reduction::Reduced;
use crate::rng::Rng;

/// What is to be ordered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Problem {
    /// A tour through all nodes that returns to where it began; reported from node 0 on.
    Closed,
    /// A path through all nodes from `start`; the end is free.
    Open {
        /// First node.
        start: usize,
    },
    /// A path through all nodes from `start` to `end`; a closed tour through `start` when both are the same node.
    Path {
        /// First node.
        start: usize,
        /// Last node.
        end: usize,
    },
}

/// Effort and randomness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Params {
    /// Largest closed problem solved to proved optimality by dynamic programming, nodes.
    pub exact_nodes: usize,
    /// Kicks of the iterated local search above that.
    pub kicks: u64,
    /// Seed of the kicks.
    pub seed: u64,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            exact_nodes: 12,
            kicks: 2000,
            seed: 1,
        }
    }
}

/// An order of all nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Every node once; the first is the start, the last the end where the form fixes it.
    pub order: Vec<usize>,
    /// Sum of the arcs, with the arc back to the start for closed tours; summed from the given costs.
    pub cost: f64,
    /// True only when proved.
    pub optimal: bool,
    /// A proved lower bound of every order's cost, where one was computed.
    pub lower_bound: Option<f64>,
    /// Kicks that were tried.
    pub kicks: u64,
}

/// Orders the nodes.
///
/// # Errors
/// [`Error::Empty`], [`Error::OutOfRange`] for a start or end that is no node, [`Error::BadCost`] for NaN,
/// [`Error::Overflow`], [`Error::Infeasible`] when proved, [`Error::NotFound`] when not.
pub fn solve(costs: &impl CostModel, problem: Problem, params: &Params) -> Result<Solution, Error> {
    solve_from(costs, problem, &[], params)
}

/// Orders the nodes, starting the search from an earlier order in which nodes may be missing, unknown or repeated.
/// The result never costs more than that order with its missing nodes put where they cost least.
///
/// # Errors
/// As [`solve`].
pub fn solve_from(
    costs: &impl CostModel,
    problem: Problem,
    hint: &[usize],
    params: &Params,
) -> Result<Solution, Error> {
    let n = costs.len();
    if n == 0 {
        return Err(Error::Empty);
    }
    let in_range = |what, index| {
        if index < n {
            Ok(())
        } else {
            Err(Error::OutOfRange {
                what,
                index,
                len: n,
            })
        }
    };
    match problem {
        Problem::Closed => {}
        Problem::Open { start } => in_range("start", start)?,
        Problem::Path { start, end } => {
            in_range("start", start)?;
            in_range("end", end)?;
        }
    }
    let matrix = CostMatrix::copy_of(costs)?;
    let reduced = Reduced::new(&matrix, problem);
    let closed = reduced.costs.len();

    let (tour, optimal, lower_bound, kicks) = if closed <= params.exact_nodes.clamp(3, 20) {
        let (tour, cost) = held_karp(&reduced.costs);
        if cost == f64::INFINITY {
            return Err(if has_overflow(&reduced.costs) {
                Error::Overflow
            } else {
                Error::Infeasible
            });
        }
        (tour, true, Some(cost), 0)
    } else {
        let Some((successor, bound)) = assignment(&reduced.costs) else {
            return Err(Error::Infeasible);
        };
        let (finite, penalty) = without_infinities(&reduced.costs)?;
        let start = if hint.is_empty() {
            patched(&finite, &successor)
        } else {
            repaired(&finite, &reduced, hint)
        };
        let (tour, cost, kicks) =
            Search::new(&finite, start).run(params.kicks, bound, &mut Rng::new(params.seed));
        if cost >= penalty {
            return Err(Error::NotFound);
        }
        // The bound and the cost are sums of the same arcs when the assignment is one cycle.
        let optimal = cost <= bound + 1e-12 * bound.abs();
        (tour, optimal, Some(bound.min(cost)), kicks)
    };
    let order = reduced.read_back(&tour);
    let mut cost = matrix.along(&order);
    let closes = match problem {
        Problem::Closed => true,
        Problem::Path { start, end } => start == end,
        Problem::Open { .. } => false,
    };
    if closes && n > 1 {
        cost += matrix.cost(order[n - 1], order[0]);
    }
    if cost.is_nan() || cost == f64::INFINITY {
        return Err(if has_overflow(&reduced.costs) {
            Error::Overflow
        } else {
            Error::Infeasible
        });
    }
    Ok(Solution {
        order,
        cost,
        optimal,
        lower_bound: lower_bound.map(|b| b.min(cost)),
        kicks,
    })
}

/// True if the finite costs alone can add up to infinity.
fn has_overflow(costs: &CostMatrix) -> bool {
    let n = costs.len();
    let largest = (0..n)
        .map(|i| {
            costs
                .row(i)
                .iter()
                .filter(|c| c.is_finite())
                .fold(0.0, |a: f64, c| a.max(c.abs()))
        })
        .sum::<f64>();
    !largest.is_finite()
}

/// Forbidden arcs get a finite penalty above every tour of finite arcs.
fn without_infinities(costs: &CostMatrix) -> Result<(CostMatrix, f64), Error> {
    let n = costs.len();
    let span = (0..n)
        .map(|i| {
            costs
                .row(i)
                .iter()
                .filter(|c| c.is_finite())
                .fold(0.0, |a: f64, c| a.max(c.abs()))
        })
        .sum::<f64>();
    let penalty = 3.0 * span + 1.0;
    if !(penalty * n as f64).is_finite() {
        return Err(Error::Overflow);
    }
    let mut finite = costs.clone();
    for from in 0..n {
        for to in 0..n {
            if from != to && costs.cost(from, to) == f64::INFINITY {
                finite.set(from, to, penalty);
            }
        }
    }
    Ok((finite, penalty - span))
}

/// Karp's patching: joins the two largest cycles where it costs least until one is left.
fn patched(costs: &CostMatrix, successor: &[usize]) -> Vec<usize> {
    let n = successor.len();
    let mut seen = vec![false; n];
    let mut cycles: Vec<Vec<usize>> = Vec::new();
    for first in 0..n {
        let mut cycle = Vec::new();
        let mut node = first;
        while !seen[node] {
            seen[node] = true;
            cycle.push(node);
            node = successor[node];
        }
        if !cycle.is_empty() {
            cycles.push(cycle);
        }
    }
    cycles.sort_by(|a, b| b.len().cmp(&a.len()).then(a[0].cmp(&b[0])));
    let mut cycles = cycles.into_iter();
    let mut tour = cycles.next().unwrap_or_default();
    for cycle in cycles {
        let (mut best, mut at) = (f64::INFINITY, (0, 0));
        for i in 0..tour.len() {
            let (a, b) = (tour[i], tour[(i + 1) % tour.len()]);
            for j in 0..cycle.len() {
                let (c, d) = (cycle[j], cycle[(j + 1) % cycle.len()]);
                let extra =
                    costs.cost(a, d) + costs.cost(c, b) - costs.cost(a, b) - costs.cost(c, d);
                if extra < best {
                    (best, at) = (extra, (i, j));
                }
            }
        }
        let (i, j) = at;
        let inserted = (1..=cycle.len()).map(|k| cycle[(j + k) % cycle.len()]);
        let tail = tour.split_off(i + 1);
        tour.extend(inserted);
        tour.extend(tail);
    }
    tour
}

/// The hint's order, its missing nodes put where they cost least.
fn repaired(costs: &CostMatrix, reduced: &Reduced, hint: &[usize]) -> Vec<usize> {
    let (mut tour, missing) = reduced.repair(hint);
    for node in missing {
        let (mut best, mut at) = (f64::INFINITY, 0);
        for i in 0..tour.len() {
            let (a, b) = (tour[i], tour[(i + 1) % tour.len()]);
            let extra = costs.cost(a, node) + costs.cost(node, b)
                - if a == b { 0.0 } else { costs.cost(a, b) };
            if extra < best {
                (best, at) = (extra, i);
            }
        }
        tour.insert(at + 1, node);
    }
    tour
}
