//! What every planner returns.

use crate::belief::probability_of;
use crate::cover::Cover;
use crate::task::{Evaluation, Task};

/// How a planning call ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The planner did all that its parameters ask for.
    Finished,
    /// No sequence has a smaller expected time.
    Optimal,
    /// The budget ran out; the plan is the best so far.
    BudgetExhausted,
    /// Less than the threshold is left to see with all reachable views: the search is over, the plan is empty.
    NothingToSee,
    /// Travel times are infinite between views so that no order found sees enough; the plan is the best beginning.
    DeadEnd,
}

/// An order of views.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Views in order, none twice, each showing something new.
    pub sequence: Vec<usize>,
    /// Expected time of the sequence, s (FLAP eq. 4).
    pub expected_time: f64,
    /// Probability that the sequence sees the target (FLAP eq. 8).
    pub probability: f64,
    /// Whether less than the threshold remains to be seen (FLAP eq. 9).
    pub complete: bool,
    /// A value that no complete sequence can be below, s, where the planner knows one better than 0.
    pub lower_bound: f64,
    /// How the call ended.
    pub status: Status,
    /// Nodes expanded or sequences changed.
    pub expansions: u64,
}

impl Plan {
    /// How far above the optimum the plan can be at most, as a share: `expected_time / lower_bound - 1`; infinite where
    /// nothing is known.
    pub fn gap(&self) -> f64 {
        if self.expected_time <= self.lower_bound {
            0.0
        } else {
            self.expected_time / self.lower_bound - 1.0
        }
    }

    /// The finished plan of a sequence.
    pub(crate) fn of(task: &Task, sequence: &[usize], status: Status, expansions: u64) -> Self {
        let value = value_of(task, sequence);
        Self {
            status: if task.goal_weight() < 0.0 || task.class_count() == 0 {
                Status::NothingToSee
            } else if !value.complete {
                Status::DeadEnd
            } else {
                status
            },
            lower_bound: if status == Status::Optimal {
                value.expected_time
            } else {
                0.0
            },
            sequence: value.used,
            expected_time: value.expected_time,
            probability: value.probability,
            complete: value.complete,
            expansions,
        }
    }
}

/// Evaluates a sequence, completing it greedily where it is not complete.
///
/// A planner adds gains in another order than [`Task::evaluate`], so a sequence that just passed the goal for it may, by
/// rounding, just miss it there.
pub(crate) fn value_of(task: &Task, sequence: &[usize]) -> Evaluation {
    let mut value = task.evaluate(sequence);
    let mut cover: Option<Cover> = None;
    while !value.complete {
        let state = cover.get_or_insert_with(|| {
            let mut state = Cover::new(task);
            for &v in &value.used {
                state.take(task, v);
            }
            state
        });
        let Some(next) = best_next(task, state, value.used.last().copied()) else {
            break;
        };
        state.take(task, next);
        let mut longer = value.used.clone();
        longer.push(next);
        value = task.evaluate(&longer);
        if value.used.len() < longer.len() {
            break; // what seemed new was rounding
        }
    }
    value
}

/// The view of largest utility (FLAP eq. 6), the lowest index among equals.
pub(crate) fn best_next(task: &Task, cover: &Cover, last: Option<usize>) -> Option<usize> {
    let mut best: Option<(f64, usize)> = None;
    for v in 0..task.len() {
        let gain = cover.gain(v);
        let seconds = task.seconds(last, v);
        if gain > 0.0 && seconds.is_finite() {
            let key = seconds / probability_of(gain);
            if best.is_none_or(|(least, _)| key < least) {
                best = Some((key, v));
            }
        }
    }
    best.map(|(_, v)| v)
}
