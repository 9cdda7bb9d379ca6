//! Dynamic programming over sets of visited views: the optimum of small tasks.

use crate::Error;
use crate::plan::{Plan, Status};
use crate::task::Task;

/// Most views that [`optimal`] takes; 18 views take 45 MB.
pub const EXACT_VIEWS: usize = 18;

/// The sequence of least expected time; 2^n n^2 steps. For more views see [`prove`](crate::prove).
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
    let covered = Covered::new(task);
    let mut best = vec![f64::INFINITY; sets * n];
    let mut before = vec![u8::MAX; sets * n];
    let mut finish: Option<(f64, usize, usize)> = None;
    for v in (0..n).filter(|&v| covered.gain(0, v) > 0.0) {
        best[(1 << v) * n + v] = task.seconds(None, v);
    }
    for set in 1..sets {
        let weight = covered.weight(set);
        let complete = weight > task.goal_weight();
        let survival = f64::exp(-weight);
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
            for next in (0..n).filter(|&v| set & (1 << v) == 0) {
                if covered.gain(set, next) <= 0.0 {
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
    if let Some((_, mut set, mut last)) = finish {
        while set != 0 {
            sequence.push(last);
            let previous = before[set * n + last];
            set ^= 1 << last;
            last = usize::from(previous);
        }
        sequence.reverse();
    }
    Ok(Plan::of(task, &sequence, Status::Optimal, sets as u64))
}

/// Weight covered by each set of views.
struct Covered {
    weight: Vec<f64>,
    /// Classes covered, so that a view that shows nothing new is told from one whose gain is rounding; empty where every
    /// look shows something.
    classes: Vec<u32>,
}

impl Covered {
    fn new(task: &Task) -> Self {
        let sets = 1usize << task.len();
        let masks = (0..task.class_count() as u32).map(|class| {
            let mask: usize = task.views_of(class).iter().map(|&v| 1 << v).sum();
            (class, mask)
        });
        if !task.single_look() {
            let masks: Vec<(u32, usize)> = masks.collect();
            let weight = |set: usize| {
                let part = |&(class, mask): &(u32, usize)| -> f64 {
                    let looks = (set & mask).count_ones() as usize;
                    task.levels(class)[..looks].iter().sum()
                };
                masks.iter().map(part).sum()
            };
            return Self {
                weight: (0..sets).map(weight).collect(),
                classes: Vec::new(),
            };
        }
        // hidden[s]: shown only by views of s, by a sum over subsets.
        let mut hidden = vec![(0.0, 0u32); sets];
        for (class, mask) in masks {
            hidden[mask].0 += task.weight(class);
            hidden[mask].1 += 1;
        }
        for bit in 0..task.len() {
            for set in 0..sets {
                if set & (1 << bit) != 0 {
                    let part = hidden[set ^ (1 << bit)];
                    hidden[set].0 += part.0;
                    hidden[set].1 += part.1;
                }
            }
        }
        let all = hidden[sets - 1];
        Self {
            weight: (0..sets).map(|s| all.0 - hidden[sets - 1 - s].0).collect(),
            classes: (0..sets).map(|s| all.1 - hidden[sets - 1 - s].1).collect(),
        }
    }

    fn weight(&self, set: usize) -> f64 {
        self.weight[set]
    }

    /// Weight that view `v` adds to a set; 0 if it shows nothing new.
    fn gain(&self, set: usize, v: usize) -> f64 {
        let more = set | 1 << v;
        match self.classes.get(set) {
            Some(&before) if before == self.classes[more] => 0.0,
            _ => self.weight[more] - self.weight[set],
        }
    }
}
