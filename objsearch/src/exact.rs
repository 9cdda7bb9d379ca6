//! Dynamic programming over sets of visited views: the optimum of small tasks.

use crate::Error;
use crate::search::{Plan, Status};
use crate::task::Task;

/// Most views that [`optimal`] takes.
pub const EXACT_VIEWS: usize = 16;

/// The sequence of least expected time; 2^n n^2 steps.
///
/// # Errors
/// [`Error::TooManyViews`] above [`EXACT_VIEWS`].
pub fn optimal(task: &Task) -> Result<Plan, Error> {
    let n = task.len();
    if n > EXACT_VIEWS {
        return Err(Error::TooManyViews {
            views: n,
            most: EXACT_VIEWS,
        });
    }
    let sets = 1usize << n;
    // hidden[s]: weight of cells shown only by views in s, by a sum over subsets.
    // Counted too, so that a view that shows nothing new is told from one whose gain is rounding.
    let mut hidden = vec![(0.0, 0u32); sets];
    for (cell, views) in task.shown_by.iter().enumerate() {
        let mask: usize = views.iter().map(|&v| 1 << v).sum();
        if mask != 0 {
            hidden[mask].0 += task.weights[cell];
            hidden[mask].1 += 1;
        }
    }
    for bit in 0..n {
        for set in 0..sets {
            if set & (1 << bit) != 0 {
                let part = hidden[set ^ (1 << bit)];
                hidden[set].0 += part.0;
                hidden[set].1 += part.1;
            }
        }
    }
    let covered = |set: usize| hidden[sets - 1].0 - hidden[sets - 1 - set].0;
    let cells = |set: usize| hidden[sets - 1].1 - hidden[sets - 1 - set].1;
    let reachable: usize = (0..n)
        .filter(|&v| task.seconds(None, v).is_finite())
        .map(|v| 1 << v)
        .sum();
    let most = cells(reachable);
    let mut best = vec![f64::INFINITY; sets * n];
    let mut before = vec![u8::MAX; sets * n];
    let mut finish: Option<(f64, usize, usize)> = None;
    for v in (0..n).filter(|&v| cells(1 << v) > 0) {
        best[(1 << v) * n + v] = task.seconds(None, v);
    }
    for set in 1..sets {
        let weight = covered(set);
        let complete = weight > task.goal_weight() || cells(set) >= most;
        for last in 0..n {
            let here = best[set * n + last];
            if here == f64::INFINITY {
                continue;
            }
            if complete {
                if finish.is_none_or(|f| here < f.0) {
                    finish = Some((here, set, last));
                }
                continue;
            }
            let survival = f64::exp(-weight);
            for next in (0..n).filter(|&v| set & (1 << v) == 0) {
                if cells(set | 1 << next) == cells(set) {
                    continue; // shows nothing new: passed over at no cost
                }
                let slot = (set | 1 << next) * n + next;
                let cost = here + survival * task.seconds(Some(last), next);
                if cost < best[slot] {
                    best[slot] = cost;
                    before[slot] = last as u8;
                }
            }
        }
    }
    let mut sequence = Vec::new();
    if let Some((_, mut set, mut last)) = finish.filter(|_| most > 0) {
        loop {
            sequence.push(last);
            let previous = before[set * n + last];
            set ^= 1 << last;
            if set == 0 {
                break;
            }
            last = usize::from(previous);
        }
        sequence.reverse();
    }
    let value = task.evaluate(&sequence);
    Ok(Plan {
        sequence: value.used.clone(),
        expected_time: value.expected_time,
        probability: value.probability,
        status: Status::Finished,
        expansions: sets as u64,
    })
}
