//! Iterated local search: FLAP's objective by small changes of whole sequences.

use crate::Error;
use crate::bound::lower_bound;
use crate::branch::{BranchParams, branch_and_bound, greedy};
use crate::budget::Budget;
use crate::cover::Cover;
use crate::moves::Moves;
use crate::order::Order;
use crate::plan::{Plan, Status, best_next};
use crate::rng::Rng;
use crate::task::Task;

/// Steps of [`Budget`] that take about 0.1 s of one core of 2020's.
pub const STEPS_PER_TENTH_SECOND: u64 = 32_000_000;

/// Parameters of [`local`].
#[derive(Clone, Debug, PartialEq)]
pub struct LocalParams {
    /// Seed of the perturbations.
    pub seed: u64,
    /// Start also from FLAP's branch and bound (psi = 2, phi = 1.3, xi = 0), as far as half the budget reaches: the plan is
    /// then never worse than that.
    pub branch_start: bool,
    /// Worsening that is accepted with a chance of 1/e at the beginning, as a share of the expected time; falls to 0.
    pub temperature: f64,
    /// Worsening against the best, as a share, from which the search goes back to the best.
    pub drift: f64,
    /// Perturbations at most; 0 descends from the starts only.
    pub perturbations: u64,
}

impl Default for LocalParams {
    fn default() -> Self {
        Self {
            seed: 0,
            branch_start: true,
            temperature: 0.003,
            drift: 0.02,
            perturbations: u64::MAX,
        }
    }
}

impl LocalParams {
    /// Checks every field.
    ///
    /// # Errors
    /// [`Error::Param`] for a negative or infinite share.
    pub fn validate(&self) -> Result<(), Error> {
        for (field, value) in [("temperature", self.temperature), ("drift", self.drift)] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Error::Param {
                    field,
                    value,
                    wanted: "zero or more and finite",
                });
            }
        }
        Ok(())
    }
}

/// Local search with perturbations, anytime: the plan is never worse than `start` completed, nor than greedy, and with
/// enough budget never worse than FLAP's branch and bound.
///
/// `start` is a sequence to improve, such as the rest of the last plan; may be empty. A descent takes any view out and
/// puts any view in anywhere, as long as that helps, and reorders; the search then takes views out, or exchanges blocks,
/// at random, and descends again until the budget is used up. Without a limit it ends after 1000 perturbations in vain.
pub fn local(task: &Task, params: &LocalParams, start: &[usize], budget: &mut Budget) -> Plan {
    let mut search = Search::new(task, params);
    let mut starts = vec![greedy(task).sequence];
    budget.spend(2 * task.incidence());
    if !start.is_empty() {
        // The rest of a plan is nearly right: first in line, and the one to keep among equals.
        starts.insert(0, search.completed(start.to_vec(), budget));
    }
    if params.branch_start && !budget.is_over() {
        let mut half = Budget::steps(budget.left() / 2).until(|| budget.is_over());
        let plan = branch_and_bound(task, &BranchParams::default(), &mut half);
        let spent = half.spent();
        drop(half);
        budget.spend(spent as usize);
        if !starts.contains(&plan.sequence) {
            starts.push(plan.sequence);
        }
    }
    let mut best: Option<Solution> = None;
    for sequence in &starts {
        search.offer(&mut best, search.solution(sequence));
    }
    let Some(mut best) = best else {
        return Plan::of(task, &starts[0], Status::Finished, 0);
    };
    for sequence in &starts {
        if budget.is_over() {
            break;
        }
        if let Some(from) = search.solution(sequence) {
            let found = search.descend(from, budget);
            if found.expected < best.expected {
                best = found;
            }
        }
    }
    let exhausted = search.iterate(&mut best, budget);
    let status = if exhausted {
        Status::BudgetExhausted
    } else {
        Status::Finished
    };
    let mut plan = Plan::of(task, &best.sequence, status, search.changes);
    plan.lower_bound = lower_bound(task).min(plan.expected_time);
    plan
}

/// A complete sequence and its value.
#[derive(Clone, Debug)]
struct Solution {
    sequence: Vec<usize>,
    expected: f64,
}

/// Perturbations in vain after which a search without a limit ends.
const PATIENCE: u64 = 1000;

struct Search<'a> {
    task: &'a Task,
    params: &'a LocalParams,
    rng: Rng,
    moves: Moves,
    order: Order,
    /// Nothing covered, to begin a completion with.
    nothing: Cover,
    cover: Cover,
    /// Views that show something, in the order in which descents try them.
    useful: Vec<usize>,
    changes: u64,
}

impl<'a> Search<'a> {
    fn new(task: &'a Task, params: &'a LocalParams) -> Self {
        let nothing = Cover::new(task);
        Self {
            task,
            params,
            rng: Rng::new(params.seed),
            moves: Moves::default(),
            order: Order::default(),
            cover: nothing.clone(),
            useful: (0..task.len()).filter(|&v| nothing.gain(v) > 0.0).collect(),
            nothing,
            changes: 0,
        }
    }

    /// A complete sequence as a solution.
    fn solution(&self, sequence: &[usize]) -> Option<Solution> {
        let value = self.task.evaluate(sequence);
        (value.complete && value.expected_time.is_finite()).then_some(Solution {
            sequence: value.used,
            expected: value.expected_time,
        })
    }

    fn offer(&self, best: &mut Option<Solution>, found: Option<Solution>) {
        if let Some(found) = found
            && best.as_ref().is_none_or(|b| found.expected < b.expected)
        {
            *best = Some(found);
        }
    }

    /// A sequence with greedy additions until it is complete.
    fn completed(&mut self, sequence: Vec<usize>, budget: &mut Budget) -> Vec<usize> {
        self.cover.clone_from(&self.nothing);
        let mut taken = Vec::with_capacity(sequence.len() + 4);
        for v in sequence {
            if v < self.task.len() && self.cover.gain(v) > 0.0 {
                budget.spend(self.cover.take(self.task, v));
                taken.push(v);
            }
        }
        while self.cover.weight() <= self.task.goal_weight() {
            let Some(v) = best_next(self.task, &self.cover, taken.last().copied()) else {
                break;
            };
            budget.spend(self.cover.take(self.task, v) + self.task.len());
            taken.push(v);
        }
        taken
    }

    /// Goes down to a sequence that no change of the neighbourhoods improves, or until the budget is used up.
    fn descend(&mut self, mut at: Solution, budget: &mut Budget) -> Solution {
        let mut steps = self.moves.set(self.task, &at.sequence);
        // Views tried since the last improvement.
        let mut vain = 0;
        let mut next = self.rng.below(self.useful.len());
        loop {
            while vain < self.useful.len() {
                budget.spend(steps);
                steps = 0;
                if budget.is_over() {
                    return at;
                }
                let v = self.useful[next];
                next = (next + 1) % self.useful.len();
                vain += 1;
                let change = self.moves.best_with(self.task, v, &mut steps);
                if self.adopt(&mut at, change, &mut steps) {
                    vain = 0;
                }
            }
            let removal = self.moves.best_removal(self.task);
            let mut improved = self.adopt(&mut at, removal, &mut steps);
            budget.spend(steps);
            steps = 0;
            let mut expected = at.expected;
            if self
                .order
                .improve(self.task, &mut at.sequence, &mut expected, budget)
            {
                at.expected = expected;
                self.changes += 1;
                steps += self.moves.set(self.task, &at.sequence);
                improved = true;
            }
            if !improved {
                budget.spend(steps);
                return at;
            }
            vain = 0;
        }
    }

    /// Makes a change if it helps.
    fn adopt(
        &mut self,
        at: &mut Solution,
        change: Option<crate::moves::Move>,
        steps: &mut usize,
    ) -> bool {
        // A millionth of a second is no gain, but may be rounding without end.
        let worth = |expected: f64| expected < at.expected - 1e-6;
        let Some(change) = change.filter(|c| worth(c.expected)) else {
            return false;
        };
        let value = self.task.evaluate(&self.moves.apply(&change));
        *steps += self.task.class_count();
        if !value.complete || !worth(value.expected_time) {
            return false;
        }
        at.sequence = value.used;
        at.expected = value.expected_time;
        self.changes += 1;
        *steps += self.moves.set(self.task, &at.sequence);
        true
    }

    /// Perturbs and descends; returns true if the budget ended it.
    fn iterate(&mut self, best: &mut Solution, budget: &mut Budget) -> bool {
        let mut at = best.clone();
        let mut vain = 0;
        for round in 0..self.params.perturbations {
            if budget.is_over() {
                return true;
            }
            if self.useful.len() < 2 || vain >= PATIENCE {
                return false;
            }
            let changed = self.perturb(&at.sequence);
            let changed = self.completed(changed, budget);
            let Some(from) = self.solution(&changed) else {
                vain += 1;
                continue;
            };
            let found = self.descend(from, budget);
            vain += 1;
            if found.expected < best.expected - 1e-9 {
                *best = found.clone();
                vain = 0;
            }
            let used = budget
                .share()
                .max(round as f64 / self.params.perturbations as f64);
            let temperature = self.params.temperature * best.expected * (1.0 - used);
            let worse = found.expected - at.expected;
            if worse <= 0.0 || self.rng.unit() < f64::exp(-worse / temperature) {
                at = found;
            }
            if at.expected > best.expected * (1.0 + self.params.drift) {
                at = best.clone();
            }
        }
        false
    }

    /// A sequence that differs from `sequence` in a few views; it may be incomplete.
    fn perturb(&mut self, sequence: &[usize]) -> Vec<usize> {
        let mut changed = sequence.to_vec();
        let k = changed.len();
        match self.rng.below(4) {
            0 => {
                for _ in 0..=self.rng.below(4) {
                    if !changed.is_empty() {
                        changed.remove(self.rng.below(changed.len()));
                    }
                }
            }
            1 => {
                let block = (2 + self.rng.below(4)).min(k);
                let from = self.rng.below(k - block + 1);
                changed.drain(from..from + block);
            }
            2 => {
                let v = self.useful[self.rng.below(self.useful.len())];
                if !changed.contains(&v) {
                    changed.insert(self.rng.below(k + 1), v);
                }
                for _ in 0..2 {
                    if changed.len() > 1 {
                        changed.remove(self.rng.below(changed.len()));
                    }
                }
            }
            _ => {
                // Two blocks side by side change places.
                let mut cuts = [0; 3].map(|_: usize| self.rng.below(k + 1));
                cuts.sort_unstable();
                changed[cuts[0]..cuts[2]].rotate_left(cuts[1] - cuts[0]);
            }
        }
        changed
    }
}
