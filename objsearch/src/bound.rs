//! A value that no way to go on can be below.

use crate::belief::probability_of;
use crate::cover::Cover;
use crate::task::Task;

/// Workspace of the bound.
#[derive(Clone, Debug)]
pub(crate) struct Bound {
    claimed: Vec<u32>,
    epoch: u32,
    rates: Vec<(f64, u32)>,
    /// Class-view looks done by the last call.
    pub(crate) steps: usize,
}

impl Bound {
    pub(crate) fn new(task: &Task) -> Self {
        Self {
            claimed: vec![0; task.class_count()],
            epoch: 0,
            rates: Vec::new(),
            steps: 0,
        }
    }

    /// Least expected time, s, that is still to come once `cover` is taken and the robot is at `last`; infinite if the
    /// goal is out of reach.
    ///
    /// A step to view j with gain g' costs S' t at survival S' and lowers S' by S' (1 - exp(-g')). The gain is at most
    /// the present gain g_j, and t at least the least time tau_j from a place the robot may yet come from, so a step
    /// pays at least its drop over rho_j = (1 - exp(-g_j)) / tau_j. Charging every cell at the best rate of all views
    /// that show it, best rates first, up to the goal, is below every sequence.
    pub(crate) fn rest(&mut self, task: &Task, cover: &Cover, last: Option<usize>) -> f64 {
        self.steps = 0;
        let need = task.goal_weight() - cover.weight();
        if need < 0.0 {
            return 0.0;
        }
        self.rates.clear();
        for v in 0..task.len() {
            let gain = cover.gain(v);
            if gain > 0.0 {
                let mut tau = task.seconds(last, v);
                // Sources come nearest first; only those with a gain, or the robot's place, may come before.
                for &from in task.sources(v) {
                    let t = task.seconds(Some(from as usize), v);
                    self.steps += 1;
                    if t >= tau {
                        break;
                    }
                    if cover.gain(from as usize) > 0.0 {
                        tau = t;
                        break;
                    }
                }
                self.rates.push((probability_of(gain) / tau, v as u32));
            }
        }
        self.rates
            .sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        self.epoch += 1;
        let survival = f64::exp(-cover.weight());
        let (mut reached, mut before, mut sum) = (0.0, 1.0, 0.0);
        for &(rate, v) in &self.rates {
            let classes = task.classes(v as usize);
            self.steps += classes.len();
            for &class in classes {
                let stamp = &mut self.claimed[class as usize];
                if *stamp != self.epoch {
                    *stamp = self.epoch;
                    reached += cover.remaining(task, class);
                }
            }
            let after = f64::exp(-f64::min(reached, need));
            if after < before {
                sum += (before - after) / rate;
                before = after;
            }
            if reached > need {
                return survival * sum;
            }
        }
        // Rounding may leave the last bit of the goal unclaimed.
        if reached > need - 1e-9 {
            survival * sum
        } else {
            f64::INFINITY
        }
    }
}

/// A value, s, that no complete sequence of the task is below.
///
/// At the root it is typically a third to two thirds of the optimum: a proof of nothing, but a scale.
pub fn lower_bound(task: &Task) -> f64 {
    let bound = Bound::new(task).rest(task, &Cover::new(task), None);
    if bound.is_finite() { bound } else { 0.0 }
}
