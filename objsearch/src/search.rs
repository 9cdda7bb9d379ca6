//! The search itself: plan, go, look, and plan again.

use crate::belief::probability_of;
use crate::plan::{Plan, Status};
use crate::task::Task;

/// The world that a search happens in. Views have numbers that mean the same view for the whole search.
pub trait World {
    /// What may go wrong in it.
    type Error;

    /// What can be seen now, and what travel takes from here. `planned` are the views of the last plan not yet gone to, in
    /// order; a world that samples new views keeps these among them.
    ///
    /// # Errors
    /// The world's own.
    fn survey(&mut self, planned: &[usize]) -> Result<Survey, Self::Error>;

    /// Goes to a view of the last survey and looks.
    ///
    /// # Errors
    /// The world's own.
    fn look(&mut self, view: usize) -> Result<Look, Self::Error>;
}

/// What can be seen now.
#[derive(Clone, Debug, PartialEq)]
pub struct Survey {
    /// The planning problem.
    pub task: Task,
    /// Number of each of the task's views.
    pub views: Vec<usize>,
}

/// What going to a view and looking gave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Time of travel and looking, s.
    pub seconds: f64,
    /// Weight of the cells that became known: `-ln` of the probability that no target was there.
    pub weight: f64,
    /// Whether the target was seen.
    pub found: bool,
}

/// How often plans are made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Once, at the beginning.
    Offline,
    /// Anew after each look.
    #[default]
    Continual,
}

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The target was seen.
    Found,
    /// Less than the threshold remained to be seen.
    Exhausted,
    /// The offline plan was carried out.
    PlanDone,
    /// No view could be gone to, though more than the threshold remained to be seen.
    Stuck,
    /// The limit of looks was reached.
    LookLimit,
}

/// One look of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Number of the view.
    pub view: usize,
    /// Probability that the target had been seen before this look.
    pub probability_before: f64,
    /// Probability that it has been seen after it.
    pub probability: f64,
    /// Time since the start after this look, s.
    pub time: f64,
    /// Views of the plan whose first one this was.
    pub planned: usize,
    /// Expected time of that plan, s.
    pub planned_time: f64,
}

/// A search.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// How it ended.
    pub ended: Ended,
    /// The looks.
    pub steps: Vec<Step>,
    /// Expected time until the target is seen or the search ends, s: each leg counts with the probability that it is begun
    /// (FLAP eq. 4 with what the looks really gave).
    pub expected_time: f64,
    /// Time of all looks, s.
    pub execution_time: f64,
    /// Probability to have seen the target.
    pub probability: f64,
    /// Plans made.
    pub plans: usize,
}

/// Searches until the target is found or no more than the threshold is left to see.
///
/// `planner` gets the task and the rest of the last plan as indices of it, and may use it to start from. `limit` is the
/// most looks, against worlds whose promises never come true. `observe` is called after each look and says whether to go
/// on.
///
/// # Errors
/// The world's.
pub fn search<W: World>(
    world: &mut W,
    mode: Mode,
    limit: usize,
    planner: &mut dyn FnMut(&Task, &[usize]) -> Plan,
    observe: &mut dyn FnMut(&Step) -> bool,
) -> Result<Record, W::Error> {
    let mut record = Record {
        ended: Ended::LookLimit,
        steps: Vec::new(),
        expected_time: 0.0,
        execution_time: 0.0,
        probability: 0.0,
        plans: 0,
    };
    let mut weight = 0.0;
    let mut planned: Vec<usize> = Vec::new();
    let (mut length, mut planned_time) = (0, 0.0);
    while record.steps.len() < limit {
        if mode == Mode::Continual || record.plans == 0 {
            let survey = world.survey(&planned)?;
            let start: Vec<usize> = planned
                .iter()
                .filter_map(|id| survey.views.iter().position(|v| v == id))
                .collect();
            let plan = planner(&survey.task, &start);
            record.plans += 1;
            planned = plan.sequence.iter().map(|&v| survey.views[v]).collect();
            (length, planned_time) = (planned.len(), plan.expected_time);
            if planned.is_empty() {
                record.ended = if plan.status == Status::NothingToSee {
                    Ended::Exhausted
                } else {
                    Ended::Stuck
                };
                return Ok(record);
            }
        } else if planned.is_empty() {
            record.ended = Ended::PlanDone;
            return Ok(record);
        }
        let view = planned.remove(0);
        let look = world.look(view)?;
        record.expected_time += f64::exp(-weight) * look.seconds;
        record.execution_time += look.seconds;
        let before = probability_of(weight);
        weight += look.weight;
        record.probability = probability_of(weight);
        let step = Step {
            view,
            probability_before: before,
            probability: record.probability,
            time: record.execution_time,
            planned: length,
            planned_time,
        };
        let go_on = observe(&step);
        record.steps.push(step);
        if look.found {
            record.ended = Ended::Found;
            return Ok(record);
        }
        if !go_on {
            return Ok(record);
        }
    }
    Ok(record)
}
