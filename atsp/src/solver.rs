//! The solver: which method answers which problem, and the workspace that lives across calls.

use crate::assignment::Assignment;
use crate::branch::{Branch, ROUNDING};
use crate::closed::Closed;
use crate::cost::CostModel;
use crate::error::Error;
use crate::exact::Table;
use crate::pace::Pace;
use crate::problem::{Params, Problem, Proof, Solution, Watch};
use crate::rng::Rng;
use crate::search::Search;
use crate::start::Starts;

/// A solver that keeps its memory between calls.
#[derive(Debug, Default)]
pub struct Solver {
    closed: Closed,
    assignment: Assignment,
    starts: Starts,
    search: Search,
    table: Table,
    branch: Branch,
}

/// Closed problems up to this size are solved by dynamic programming at once: its table is small there.
const SMALLEST: usize = 8;
/// Largest table.
const LARGEST: usize = 20;
/// Largest closed problem that [`Proof::Quick`] tries.
const QUICK: usize = 128;

/// Orders the nodes; [`Solver::solve`] with a workspace of its own.
///
/// # Errors
/// As [`Solver::solve`].
pub fn solve(costs: &impl CostModel, problem: Problem, params: &Params) -> Result<Solution, Error> {
    Solver::new().solve(costs, problem, params)
}

/// Orders the nodes from an earlier order; [`Solver::solve_from`] with a workspace of its own.
///
/// # Errors
/// As [`Solver::solve`].
pub fn solve_from(
    costs: &impl CostModel,
    problem: Problem,
    hint: &[usize],
    params: &Params,
) -> Result<Solution, Error> {
    Solver::new().solve_from(costs, problem, hint, params)
}

impl Solver {
    /// A solver without memory yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Orders the nodes.
    ///
    /// # Errors
    /// [`Error::Empty`], [`Error::OutOfRange`] for a start or end that is no node, [`Error::BadCost`] for NaN,
    /// [`Error::Overflow`], [`Error::Infeasible`] when proved, [`Error::NotFound`] when not.
    pub fn solve(
        &mut self,
        costs: &impl CostModel,
        problem: Problem,
        params: &Params,
    ) -> Result<Solution, Error> {
        self.solve_watched(costs, problem, &[], params, &mut || false)
    }

    /// Orders the nodes, starting the search from an earlier order in which nodes may be missing, unknown or repeated.
    /// The result never costs more than that order with its missing nodes put where they cost least.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn solve_from(
        &mut self,
        costs: &impl CostModel,
        problem: Problem,
        hint: &[usize],
        params: &Params,
    ) -> Result<Solution, Error> {
        self.solve_watched(costs, problem, hint, params, &mut || false)
    }

    /// Orders the nodes until the effort is spent or `watch` says stop.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn solve_watched(
        &mut self,
        costs: &impl CostModel,
        problem: Problem,
        hint: &[usize],
        params: &Params,
        watch: &mut dyn Watch,
    ) -> Result<Solution, Error> {
        check(problem, costs.len())?;
        self.closed.map(problem, costs.len());
        let mut pace = Pace::new(watch);
        if pace.is_late() || !self.closed.load(costs, &mut || pace.is_late())? {
            if let Some(found) = self.hurried(costs, hint) {
                return Ok(found);
            }
            // Forbidden arcs are in the way: take the time to find an order that can be driven.
            self.closed.load(costs, &mut || false)?;
        }
        pace.raised = self.closed.raised;
        let answer = self.answer(hint, params, &mut pace)?;
        let order = match answer.source {
            Source::Table => self.closed.read_back(self.table.tour()),
            Source::Search => self.closed.read_back(self.search.best().0),
        };
        let cost = sum(costs, &self.closed, &order);
        if cost == f64::INFINITY {
            // From start to end and nothing between: the closed tour has no arc that could say so.
            return Err(Error::Infeasible);
        }
        Ok(Solution {
            order,
            cost,
            optimal: answer.optimal,
            lower_bound: if answer.optimal {
                Some(cost)
            } else {
                answer.bound.map(|b| (b - self.closed.raised).min(cost))
            },
            kicks: answer.kicks,
        })
    }

    /// An order made without a copy of the costs; `None` if it is not finite.
    fn hurried(&mut self, costs: &impl CostModel, hint: &[usize]) -> Option<Solution> {
        let ask = |from, to| self.closed.ask(costs, from, to);
        let tour = if hint.is_empty() {
            self.starts.nearest(self.closed.n, ask)
        } else {
            self.starts.repaired(&self.closed, hint, ask)
        };
        let order = self.closed.read_back(tour);
        let cost = sum(costs, &self.closed, &order);
        cost.is_finite().then(|| Solution {
            // The only order there is.
            optimal: self.closed.n <= 2,
            lower_bound: (self.closed.n <= 2).then_some(cost),
            order,
            cost,
            kicks: 0,
        })
    }

    fn answer(
        &mut self,
        hint: &[usize],
        params: &Params,
        pace: &mut Pace<'_>,
    ) -> Result<Answer, Error> {
        let closed = &self.closed;
        let n = closed.n;
        if n <= SMALLEST {
            // Too small for `pace` to stop it: no order is known yet.
            return self.by_table(pace).unwrap_or(Err(Error::Infeasible));
        }
        // An order to hand back if time runs out.
        let first = if hint.is_empty() {
            self.starts.nearest(n, |a, b| closed.cost(a, b))
        } else {
            self.starts.repaired(closed, hint, |a, b| closed.cost(a, b))
        };
        self.search.reset(closed, first, pace);
        let mut answer = Answer {
            source: Source::Search,
            bound: None,
            optimal: false,
            kicks: 0,
        };
        let bound = self
            .assignment
            .solve(n, &closed.costs, &mut |steps| pace.spend(steps));
        let Some(bound) = bound else {
            return Ok(answer);
        };
        if !closed.is_allowed(bound) {
            return Err(Error::Infeasible);
        }
        answer.bound = Some(bound * (1.0 - ROUNDING));
        let Some(patched) = self.starts.patched(closed, &self.assignment.next, pace) else {
            return Ok(answer);
        };
        self.search.begin(closed, patched, pace);
        // As dear as its bound, but for the rounding of the two sums.
        answer.optimal = self.search.best().1 - bound <= ROUNDING * bound;
        if answer.optimal || pace.stop() {
            return Ok(answer);
        }
        let (u, v) = (&self.assignment.u, &self.assignment.v);
        if !self.search.candidates.pick(closed, u, v, pace) {
            return Ok(answer);
        }
        self.search.settle(closed, pace);
        if !hint.is_empty() {
            // Neither start is always the better one: down from both, on from the better.
            self.search.begin(closed, self.starts.last_repaired(), pace);
            self.search.settle(closed, pace);
            self.search.back();
        }
        let mut rng = Rng::new(params.seed);
        let is_small = n <= params.exact_nodes.clamp(SMALLEST, LARGEST);
        let (steps, branches) = match params.proof {
            _ if is_small => (30, 20),
            // With fewer kicks none are left for it: so more kicks never end higher.
            Proof::Quick if n <= QUICK && params.kicks >= before_proof(n) => (100, 200),
            Proof::Effort { steps, branches } => (steps, branches),
            _ => (0, 0),
        };
        if steps > 0 {
            // A good order first: the better it is, the less is left to look at.
            let few = if is_small { n as u64 } else { before_proof(n) };
            let few = params.kicks.min(few);
            answer.kicks = self.search.kicks(closed, few, bound, &mut rng, pace);
            let (tour, cost) = self.search.best();
            let verdict = self
                .branch
                .prove(closed, u, tour, cost, steps, branches, &mut || pace.stop());
            let (tour, better) = self.branch.best();
            if better < cost {
                self.search.begin(closed, tour, pace);
                self.search.settle(closed, pace);
            }
            answer.bound = answer.bound.map(|b| b.max(verdict.bound));
            answer.optimal = verdict.is_complete && closed.is_allowed(self.search.best().1);
            if !closed.is_allowed(verdict.bound) || (verdict.is_complete && !answer.optimal) {
                return Err(Error::Infeasible);
            }
            if answer.optimal || pace.is_stopped() {
                return Ok(answer);
            }
            if is_small {
                return self.by_table(pace).unwrap_or(Ok(answer));
            }
        }
        let rest = params.kicks - answer.kicks;
        let goal = answer.bound.unwrap_or(bound);
        answer.kicks += self.search.kicks(closed, rest, goal, &mut rng, pace);
        let cost = self.search.best().1;
        if !closed.is_allowed(cost) {
            return Err(if closed.is_connected() {
                Error::NotFound
            } else {
                Error::Infeasible
            });
        }
        answer.optimal = cost - goal <= ROUNDING * cost;
        Ok(answer)
    }

    /// Dynamic programming; `None` when the caller stopped it.
    fn by_table(&mut self, pace: &mut Pace<'_>) -> Option<Result<Answer, Error>> {
        let cost = self.table.solve(&self.closed, pace)?;
        if !self.closed.is_allowed(cost) {
            return Some(Err(Error::Infeasible));
        }
        pace.improved(cost);
        Some(Ok(Answer {
            source: Source::Table,
            bound: Some(cost),
            optimal: true,
            kicks: 0,
        }))
    }
}

/// Kicks before a proof is tried: about so many find the optimum in most sets, which leaves the proof least to do.
fn before_proof(n: usize) -> u64 {
    (n * (n / 2).min(32)) as u64
}

/// Where the order stands.
enum Source {
    Table,
    Search,
}

struct Answer {
    source: Source,
    /// Of the closed tour.
    bound: Option<f64>,
    optimal: bool,
    kicks: u64,
}

/// The cost of an order as the caller counts it.
fn sum(costs: &impl CostModel, closed: &Closed, order: &[usize]) -> f64 {
    let path: f64 = order.windows(2).map(|arc| costs.cost(arc[0], arc[1])).sum();
    if closed.is_path || order.len() < 2 {
        path
    } else {
        path + costs.cost(order[order.len() - 1], order[0])
    }
}

fn check(problem: Problem, len: usize) -> Result<(), Error> {
    if len == 0 {
        return Err(Error::Empty);
    }
    let in_range = |what, index| {
        if index < len {
            Ok(())
        } else {
            Err(Error::OutOfRange { what, index, len })
        }
    };
    match problem {
        Problem::Closed => Ok(()),
        Problem::Open { start } => in_range("start", start),
        Problem::Path { start, end } => in_range("start", start).and(in_range("end", end)),
    }
}
