//! FLAP's planner: utility-greedy construction (eq. 6) inside a depth-first branch and bound with a depth limit psi, a
//! branch limit phi and optional pruning of dominated views (eq. 7), and its two ways to use up a budget.

use crate::Error;
use crate::belief::probability_of;
use crate::bound::{Bound, lower_bound};
use crate::budget::Budget;
use crate::cover::Cover;
use crate::dominance::{Dominance, Pairs};
use crate::memo::Memo;
use crate::plan::{Plan, Status};
use crate::task::Task;

/// Limits of the branch and bound.
#[derive(Clone, Debug, PartialEq)]
pub struct BranchParams {
    /// Depth above which every node has one child (psi); 0 is greedy, `usize::MAX` no limit.
    pub depth_limit: usize,
    /// Views whose inverse utility exceeds the best one's by more than this factor are not branched on (phi), 1 or more;
    /// 1 is greedy, infinite no limit.
    pub branch_limit: f64,
    /// Which views are dropped for a better one (xi).
    pub dominance: Dominance,
    /// Prune branches whose lower bound is above the best sequence. The published planner has no such bound.
    pub bound: bool,
}

impl Default for BranchParams {
    /// psi = 2, phi = 1.3, xi = 0: the defaults of FLAP's program.
    fn default() -> Self {
        Self {
            depth_limit: 2,
            branch_limit: 1.3,
            dominance: Dominance::Off,
            bound: false,
        }
    }
}

impl BranchParams {
    /// No limit: with enough budget the optimum.
    pub fn exhaustive() -> Self {
        Self {
            depth_limit: usize::MAX,
            branch_limit: f64::INFINITY,
            dominance: Dominance::Off,
            bound: true,
        }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// [`Error::Param`] for a branch limit below 1 or NaN.
    pub fn validate(&self) -> Result<(), Error> {
        if self.branch_limit >= 1.0 {
            Ok(())
        } else {
            Err(Error::Param {
                field: "branch_limit",
                value: self.branch_limit,
                wanted: "1 or more",
            })
        }
    }
}

/// The greedy sequence: always the view with the largest probability of new cells per second (FLAP eq. 6).
pub fn greedy(task: &Task) -> Plan {
    let params = BranchParams {
        depth_limit: 0,
        branch_limit: 1.0,
        ..BranchParams::default()
    };
    branch_and_bound(task, &params, &mut Budget::unlimited())
}

/// FLAP's depth-first branch and bound. Without budget it is [`greedy`].
///
/// Children are tried in order of time over probability and cut off at phi times the least; a child is skipped if its
/// expected time so far is above the best sequence's, or if it is dominated; from depth psi on only one child is tried.
/// A branch limit that is no number of 1 or more counts as 1; [`BranchParams::validate`] tells.
pub fn branch_and_bound(task: &Task, params: &BranchParams, budget: &mut Budget) -> Plan {
    let mut search = Search::new(task, params);
    search.run(budget);
    search.plan()
}

/// Iterative deepening, iter_psi of FLAP's experiments: psi = 0, 1, 2, ... with the other limits fixed, until the plan is no
/// longer than psi, or less budget is left than the last round took.
pub fn deepen(task: &Task, params: &BranchParams, budget: &mut Budget) -> Plan {
    iterate(task, budget, |round, best, _| {
        (best.is_none_or(|b| b.sequence.len() > round)).then(|| BranchParams {
            depth_limit: round,
            ..params.clone()
        })
    })
}

/// Iterative widening, iter_phi of FLAP's experiments: phi = 1.0, 1.1, ..., 2.0 with the other limits fixed, until nothing
/// was cut off, or less budget is left than the last round took.
pub fn widen(task: &Task, params: &BranchParams, budget: &mut Budget) -> Plan {
    iterate(task, budget, |round, _, cut| {
        (round <= 10 && (round == 0 || cut)).then(|| BranchParams {
            branch_limit: (10 + round) as f64 / 10.0,
            ..params.clone()
        })
    })
}

/// Rounds of branch and bound, each with the best value of the rounds before as its bound.
fn iterate(
    task: &Task,
    budget: &mut Budget,
    mut next: impl FnMut(usize, Option<&Plan>, bool) -> Option<BranchParams>,
) -> Plan {
    let mut best: Option<Plan> = None;
    let (mut expansions, mut last_round, mut cut, mut round) = (0, 0, false, 0);
    while let Some(params) = next(round, best.as_ref(), cut) {
        if round > 0 && (budget.is_over() || budget.left() < last_round) {
            if let Some(plan) = &mut best {
                plan.status = match plan.status {
                    Status::Finished => Status::BudgetExhausted,
                    other => other,
                };
            }
            break;
        }
        let before = budget.spent();
        let mut search = Search::new(task, &params);
        if let Some(plan) = best.as_ref().filter(|p| p.complete) {
            search.limit = plan.expected_time;
        }
        search.run(budget);
        last_round = budget.spent() - before;
        cut = search.cut;
        expansions += search.expansions;
        let exhausted = search.exhausted;
        let found = search.plan();
        if best.as_ref().is_none_or(|b| {
            found.complete && !(b.complete && b.expected_time <= found.expected_time)
        }) {
            best = Some(found);
        }
        if exhausted {
            if let Some(plan) = best.as_mut().filter(|p| p.status == Status::Finished) {
                plan.status = Status::BudgetExhausted;
            }
            break;
        }
        round += 1;
    }
    let mut plan = best.unwrap_or_else(|| greedy(task));
    plan.expansions = expansions;
    plan
}

/// Proves that a sequence is optimal or finds a better one: branch and bound without limits, with the lower bound and
/// a memory of sets of views already reached faster. `start` is a sequence to beat, best a good one; may be empty.
///
/// The plan's status is [`Status::Optimal`] if the whole tree was searched or cut by proof, else
/// [`Status::BudgetExhausted`] with the bound of the root.
pub fn prove(task: &Task, start: &[usize], budget: &mut Budget) -> Plan {
    let params = BranchParams::exhaustive();
    let mut search = Search::new(task, &params);
    let value = task.evaluate(start);
    if value.complete {
        search.limit = value.expected_time;
        search.best = Some(value.used);
    }
    search.memo = Some(Memo::new(task.len()));
    search.run(budget);
    let mut plan = search.plan();
    if plan.complete && plan.status == Status::Finished {
        plan.status = Status::Optimal;
        plan.lower_bound = plan.expected_time;
    } else if plan.complete {
        plan.lower_bound = lower_bound(task).min(plan.expected_time);
    }
    plan
}

/// What is known at one depth.
#[derive(Debug, Default)]
struct Level {
    cover: Cover,
    children: Vec<Child>,
}

/// A way to go on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Child {
    /// Inverse utility, s.
    pub(crate) key: f64,
    pub(crate) probability: f64,
    pub(crate) seconds: f64,
    pub(crate) view: usize,
}

struct Search<'a> {
    task: &'a Task,
    params: &'a BranchParams,
    pairs: Pairs,
    bound: Option<Bound>,
    memo: Option<Memo>,
    levels: Vec<Level>,
    sequence: Vec<usize>,
    /// Expected time to beat.
    limit: f64,
    best: Option<Vec<usize>>,
    /// The longest way into a dead end: covered weight, sequence.
    dead_end: Option<(f64, Vec<usize>)>,
    expansions: u64,
    exhausted: bool,
    /// Whether phi cut a branch.
    cut: bool,
}

impl<'a> Search<'a> {
    fn new(task: &'a Task, params: &'a BranchParams) -> Self {
        Self {
            task,
            params,
            pairs: Pairs::new(task, params.dominance),
            bound: params.bound.then(|| Bound::new(task)),
            memo: None,
            levels: Vec::new(),
            sequence: Vec::new(),
            limit: f64::INFINITY,
            best: None,
            dead_end: None,
            expansions: 0,
            exhausted: false,
            cut: false,
        }
    }

    fn run(&mut self, budget: &mut Budget) {
        self.levels.push(Level {
            cover: Cover::new(self.task),
            children: Vec::new(),
        });
        budget.spend(self.task.incidence());
        self.expand(0.0, budget);
    }

    fn plan(self) -> Plan {
        let status = if self.exhausted {
            Status::BudgetExhausted
        } else {
            Status::Finished
        };
        let sequence = self
            .best
            .or(self.dead_end.map(|(_, sequence)| sequence))
            .unwrap_or_default();
        Plan::of(self.task, &sequence, status, self.expansions)
    }

    fn accept(&mut self, expected: f64) {
        if self.best.is_none() && expected <= self.limit || expected < self.limit {
            self.limit = expected;
            self.best = Some(self.sequence.clone());
        }
    }

    /// Fills the children of the deepest level in order of inverse utility.
    fn children(&mut self, depth: usize) {
        let last = self.sequence.last().copied();
        let Level { cover, children } = &mut self.levels[depth];
        children.clear();
        for view in 0..self.task.len() {
            let gain = cover.gain(view);
            let seconds = self.task.seconds(last, view);
            if gain > 0.0 && seconds.is_finite() {
                let probability = probability_of(gain);
                children.push(Child {
                    key: seconds / probability,
                    probability,
                    seconds,
                    view,
                });
            }
        }
        children.sort_by(|a, b| a.key.total_cmp(&b.key).then(a.view.cmp(&b.view)));
    }

    /// Depth is bounded by the number of views, since every step covers something new.
    fn expand(&mut self, expected: f64, budget: &mut Budget) {
        let depth = self.sequence.len();
        if budget.is_over() && self.limit < f64::INFINITY {
            self.exhausted = true;
            return;
        }
        self.expansions += 1;
        let weight = self.levels[depth].cover.weight();
        if weight > self.task.goal_weight() {
            return self.accept(expected);
        }
        let last = self.sequence.last().copied();
        if let Some(bound) = &mut self.bound {
            let rest = bound.rest(self.task, &self.levels[depth].cover, last);
            budget.spend(bound.steps);
            // Infinite: no way to complete from here, but the way into the dead end may be all there is.
            if rest.is_finite() && expected + rest >= self.limit {
                return;
            }
        }
        self.children(depth);
        budget.spend(self.task.len());
        if self.levels[depth].children.is_empty() {
            if self
                .dead_end
                .as_ref()
                .is_none_or(|(most, _)| weight > *most)
            {
                self.dead_end = Some((weight, self.sequence.clone()));
            }
            return;
        }
        if self.levels.len() == depth + 1 {
            self.levels.push(Level::default());
        }
        let cutoff = self.params.branch_limit.max(1.0) * self.levels[depth].children[0].key;
        let survival = f64::exp(-weight);
        let mut expanded = 0;
        for index in 0..self.levels[depth].children.len() {
            let child = self.levels[depth].children[index];
            if child.key > cutoff {
                self.cut = true;
                break;
            }
            let below = expected + survival * child.seconds;
            if below > self.limit {
                continue;
            }
            let here = &self.levels[depth];
            if self
                .pairs
                .dominated(self.task, &here.cover, &here.children, index, expanded)
            {
                continue;
            }
            // Those followed stand first; those skipped move back by one, those not yet tried stay.
            self.levels[depth].children[expanded..=index].rotate_right(1);
            expanded += 1;
            let (above, deeper) = self.levels.split_at_mut(depth + 1);
            deeper[0].cover.clone_from(&above[depth].cover);
            budget.spend(deeper[0].cover.take(self.task, child.view));
            self.sequence.push(child.view);
            let known = match &mut self.memo {
                Some(memo) => memo.reached_before(&self.sequence, below),
                None => false,
            };
            if !known {
                self.expand(below, budget);
            }
            self.sequence.pop();
            if depth >= self.params.depth_limit || self.exhausted {
                break;
            }
        }
    }
}
