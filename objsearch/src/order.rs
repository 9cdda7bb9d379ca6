//! Better orders of the views of a sequence: exact in a sliding window, and reversals and block moves beyond it.

use crate::budget::Budget;
use crate::task::Task;

/// Views of a window that is ordered exactly.
pub(crate) const WINDOW: usize = 8;

/// Views of a span that is turned as a whole; the number of spans grows with it, and each is evaluated for itself.
const LONGEST: usize = 24;

/// Workspace of [`improve`](Order::improve).
#[derive(Clone, Debug, Default)]
pub(crate) struct Order {
    /// Window positions that show a class, 0 for those covered before or not touched.
    mask: Vec<u16>,
    touched: Vec<u32>,
    seen: Vec<u32>,
    epoch: u32,
    hidden: Vec<f64>,
    best: Vec<f64>,
    before: Vec<u8>,
}

impl Order {
    /// Reorders `sequence` to a smaller expected time, in place, until nothing helps or the budget is used up; returns
    /// whether it did. `expected` is its value and is kept up to date.
    pub(crate) fn improve(
        &mut self,
        task: &Task,
        sequence: &mut Vec<usize>,
        expected: &mut f64,
        budget: &mut Budget,
    ) -> bool {
        let mut improved = false;
        if task.single_look() {
            for from in 0..=sequence.len().saturating_sub(WINDOW) {
                if budget.is_over() {
                    return improved;
                }
                // A better order may complete earlier, and so be shorter.
                let to = (from + WINDOW).min(sequence.len()).max(from);
                let mut steps = 0;
                let order = self.window(task, sequence, from, to, &mut steps);
                budget.spend(steps);
                if let Some(order) = order {
                    let mut changed = sequence.clone();
                    changed[from..to].copy_from_slice(&order);
                    improved |= replace(task, sequence, expected, &changed, budget);
                }
            }
        }
        // Shorter spans are part of a window.
        let least = if task.single_look() { WINDOW + 1 } else { 2 };
        let mut changed = Vec::new();
        // Spans tried since the last change, against all there are.
        let (mut from, mut vain) = (0, 0);
        while vain < sequence.len() {
            let mut better = false;
            for to in from + least..=sequence.len().min(from + LONGEST) {
                for turn in turns(to - from) {
                    if budget.is_over() {
                        return improved;
                    }
                    if to > sequence.len() {
                        break; // a change before has made it shorter
                    }
                    changed.clone_from(sequence);
                    match turn {
                        0 => changed[from..to].reverse(),
                        by => changed[from..to].rotate_left(by),
                    }
                    better |= replace(task, sequence, expected, &changed, budget);
                }
            }
            improved |= better;
            vain = if better { 0 } else { vain + 1 };
            from = (from + 1) % sequence.len().max(1);
        }
        improved
    }

    /// The best order of positions `from..to` by dynamic programming over subsets, the others staying; `None` if it is the
    /// present one.
    fn window(
        &mut self,
        task: &Task,
        sequence: &[usize],
        from: usize,
        to: usize,
        steps: &mut usize,
    ) -> Option<Vec<usize>> {
        let w = to.saturating_sub(from);
        if w < 2 {
            return None;
        }
        let window = &sequence[from..to];
        let sets = 1usize << w;
        let covered = self.hide(task, sequence, from, to, steps);
        let all = self.hidden[sets - 1];
        let weight = |hidden: &[f64], set: usize| covered + all - hidden[sets - 1 - set];
        let start = from.checked_sub(1).map(|p| sequence[p]);
        let next = sequence.get(to).copied();
        self.best.clear();
        self.best.resize(sets * w, f64::INFINITY);
        self.before.clear();
        self.before.resize(sets * w, u8::MAX);
        for v in 0..w {
            self.best[(1 << v) * w + v] = f64::exp(-covered) * task.seconds(start, window[v]);
        }
        *steps += sets * w * w / 2 + sets * w / 2;
        let goal = task.goal_weight();
        // Value, set and last of the best end: an end is the full set, or a set that completes.
        let mut end: Option<(f64, usize, usize)> = None;
        for set in 1..sets {
            let here = weight(&self.hidden, set);
            let complete = here > goal;
            let survival = f64::exp(-here);
            for last in (0..w).filter(|last| set & (1 << last) != 0) {
                let value = self.best[set * w + last];
                if value == f64::INFINITY {
                    continue;
                }
                if complete || set == sets - 1 {
                    let onward = match next {
                        Some(next) if !complete => {
                            survival * task.seconds(Some(window[last]), next)
                        }
                        _ => 0.0,
                    };
                    if end.is_none_or(|(least, ..)| value + onward < least) {
                        end = Some((value + onward, set, last));
                    }
                    continue;
                }
                for v in (0..w).filter(|v| set & (1 << v) == 0) {
                    let slot = (set | 1 << v) * w + v;
                    let then = value + survival * task.seconds(Some(window[last]), window[v]);
                    if then < self.best[slot] {
                        self.best[slot] = then;
                        self.before[slot] = last as u8;
                    }
                }
            }
        }
        let (_, mut set, mut last) = end?;
        let mut order: Vec<usize> = (0..w)
            .filter(|v| set & (1 << v) == 0)
            .map(|v| window[v])
            .collect();
        // Backwards: those never gone to stand last.
        order.reverse();
        while set != 0 {
            order.push(window[last]);
            let previous = self.before[set * w + last];
            set ^= 1 << last;
            last = usize::from(previous);
        }
        order.reverse();
        (order != window).then_some(order)
    }

    /// Fills `hidden[s]`: weight that only window views of set s show, nothing before the window; returns the weight
    /// covered before it.
    fn hide(
        &mut self,
        task: &Task,
        sequence: &[usize],
        from: usize,
        to: usize,
        steps: &mut usize,
    ) -> f64 {
        self.mask.resize(task.class_count(), 0);
        self.seen.resize(task.class_count(), 0);
        self.epoch += 1;
        let mut covered = 0.0;
        for &v in &sequence[..from] {
            for &class in task.classes(v) {
                if self.seen[class as usize] != self.epoch {
                    self.seen[class as usize] = self.epoch;
                    covered += task.weight(class);
                }
            }
            *steps += task.classes(v).len();
        }
        self.touched.clear();
        for (bit, &v) in sequence[from..to].iter().enumerate() {
            for &class in task.classes(v) {
                if self.seen[class as usize] != self.epoch {
                    let mask = &mut self.mask[class as usize];
                    if *mask == 0 {
                        self.touched.push(class);
                    }
                    *mask |= 1 << bit;
                }
            }
            *steps += task.classes(v).len();
        }
        let sets = 1usize << (to - from);
        self.hidden.clear();
        self.hidden.resize(sets, 0.0);
        for &class in &self.touched {
            let mask = &mut self.mask[class as usize];
            self.hidden[usize::from(*mask)] += task.weight(class);
            *mask = 0;
        }
        for bit in 0..to - from {
            for set in 0..sets {
                if set & (1 << bit) != 0 {
                    self.hidden[set] += self.hidden[set ^ (1 << bit)];
                }
            }
        }
        covered
    }
}

/// What is tried on a span of so many views: 0 its reversal, else its rotation, by which a block of one to three views goes
/// from one end to the other.
fn turns(span: usize) -> impl Iterator<Item = usize> {
    std::iter::once(0).chain((1..=3.min(span - 1)).flat_map(move |block| [block, span - block]))
}

/// Puts `changed` in the place of `sequence` if its expected time is smaller.
fn replace(
    task: &Task,
    sequence: &mut Vec<usize>,
    expected: &mut f64,
    changed: &[usize],
    budget: &mut Budget,
) -> bool {
    budget.spend(changed.iter().map(|&v| task.classes(v).len()).sum());
    let value = task.evaluate(changed);
    let better = value.complete && value.expected_time < *expected - 1e-9;
    if better {
        *expected = value.expected_time;
        *sequence = value.used;
    }
    better
}
