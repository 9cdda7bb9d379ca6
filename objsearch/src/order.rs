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
    /// Views of the sequence that show each class, as a set of their places at first; 0 when not in use.
    shown_by: Vec<u64>,
    touched: Vec<u32>,
    /// Classes that the same views show are one: an order is then evaluated without a look at single classes.
    groups: Vec<(u64, f64)>,
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
        if !task.single_look() || sequence.len() > 64 {
            let value = |order: &[usize], budget: &mut Budget| {
                budget.spend(order.iter().map(|&v| task.classes(v).len()).sum());
                let value = task.evaluate(order);
                (value.complete, value.expected_time, value.used)
            };
            return turn(sequence, expected, 2, &value, budget);
        }
        budget.spend(self.group(task, sequence));
        let views = sequence.clone();
        let mut places: Vec<usize> = (0..views.len()).collect();
        let mut reached = *expected;
        let groups = std::mem::take(&mut self.groups);
        let value = |order: &[usize], budget: &mut Budget| {
            budget.spend(order.len() * groups.len() / 4);
            value_of(task, &views, &groups, order)
        };
        for from in 0..=places.len().saturating_sub(WINDOW) {
            if budget.is_over() {
                break;
            }
            // A better order may complete earlier, and so be shorter.
            let to = (from + WINDOW).min(places.len()).max(from);
            let mut steps = 0;
            let order = self.window(task, &views, &groups, &places, from, to, &mut steps);
            budget.spend(steps);
            if let Some(order) = order {
                let mut changed = places.clone();
                changed[from..to].copy_from_slice(&order);
                replace(&mut places, &mut reached, &changed, &value, budget);
            }
        }
        // Shorter spans are part of a window.
        turn(&mut places, &mut reached, WINDOW + 1, &value, budget);
        self.groups = groups;
        // Sums of groups are rounded in another order than those of classes.
        let found = task.evaluate(&places.iter().map(|&p| views[p]).collect::<Vec<_>>());
        let better = found.complete && found.expected_time < *expected - 1e-9;
        if better {
            *expected = found.expected_time;
            *sequence = found.used;
        }
        better
    }

    /// Fills `groups`; returns the steps it took.
    fn group(&mut self, task: &Task, sequence: &[usize]) -> usize {
        self.shown_by.resize(task.class_count(), 0);
        self.touched.clear();
        let mut steps = 0;
        for (place, &v) in sequence.iter().enumerate() {
            steps += 2 * task.classes(v).len();
            for &class in task.classes(v) {
                let shown_by = &mut self.shown_by[class as usize];
                if *shown_by == 0 {
                    self.touched.push(class);
                }
                *shown_by |= 1 << place;
            }
        }
        self.groups.clear();
        for &class in &self.touched {
            let shown_by = std::mem::take(&mut self.shown_by[class as usize]);
            self.groups.push((shown_by, task.weight(class)));
        }
        // A stable sort, so that sums do not depend on how it works.
        self.groups.sort_by_key(|group| group.0);
        self.groups.dedup_by(|next, group| {
            let same = next.0 == group.0;
            if same {
                group.1 += next.1;
            }
            same
        });
        steps
    }

    /// The best order of positions `from..to` by dynamic programming over subsets, the others staying; `None` if it is the
    /// present one.
    fn window(
        &mut self,
        task: &Task,
        views: &[usize],
        groups: &[(u64, f64)],
        places: &[usize],
        from: usize,
        to: usize,
        steps: &mut usize,
    ) -> Option<Vec<usize>> {
        let w = to.saturating_sub(from);
        if w < 2 {
            return None;
        }
        let window = &places[from..to];
        let sets = 1usize << w;
        let covered = self.hide(groups, places, from, to);
        let all = self.hidden[sets - 1];
        let weight = |hidden: &[f64], set: usize| covered + all - hidden[sets - 1 - set];
        let seconds = |a: usize, b: usize| task.seconds(Some(views[a]), views[b]);
        let start = from.checked_sub(1).map(|p| views[places[p]]);
        let next = places.get(to).copied();
        self.best.clear();
        self.best.resize(sets * w, f64::INFINITY);
        self.before.clear();
        self.before.resize(sets * w, u8::MAX);
        for v in 0..w {
            self.best[(1 << v) * w + v] =
                f64::exp(-covered) * task.seconds(start, views[window[v]]);
        }
        *steps += sets * w * w / 2 + groups.len() * (w + from);
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
                        Some(next) if !complete => survival * seconds(window[last], next),
                        _ => 0.0,
                    };
                    if end.is_none_or(|(least, ..)| value + onward < least) {
                        end = Some((value + onward, set, last));
                    }
                    continue;
                }
                for v in (0..w).filter(|v| set & (1 << v) == 0) {
                    let slot = (set | 1 << v) * w + v;
                    let then = value + survival * seconds(window[last], window[v]);
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

    /// Fills `hidden[s]`: weight that only window places of set s show, nothing before the window; returns the weight
    /// covered before it.
    fn hide(&mut self, groups: &[(u64, f64)], places: &[usize], from: usize, to: usize) -> f64 {
        let before = places[..from].iter().fold(0u64, |set, p| set | 1 << p);
        let sets = 1usize << (to - from);
        self.hidden.clear();
        self.hidden.resize(sets, 0.0);
        let mut covered = 0.0;
        for &(shown_by, weight) in groups {
            if shown_by & before != 0 {
                covered += weight;
                continue;
            }
            let mut set = 0;
            for (bit, p) in places[from..to].iter().enumerate() {
                set |= ((shown_by >> p & 1) as usize) << bit;
            }
            // The empty set: shown behind the window only.
            if set != 0 {
                self.hidden[set] += weight;
            }
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

/// Whether an order of places is complete, its expected time, and the places gone to.
fn value_of(
    task: &Task,
    views: &[usize],
    groups: &[(u64, f64)],
    order: &[usize],
) -> (bool, f64, Vec<usize>) {
    let goal = task.goal_weight();
    let (mut weight, mut expected, mut seen) = (0.0, 0.0, 0u64);
    let mut used: Vec<usize> = Vec::with_capacity(order.len());
    for &p in order {
        if weight > goal {
            break;
        }
        let mut gain = 0.0;
        for &(shown_by, more) in groups {
            let new = shown_by >> p & 1 != 0 && shown_by & seen == 0;
            gain += if new { more } else { 0.0 };
        }
        if gain > 0.0 {
            let last = used.last().map(|&l| views[l]);
            expected += f64::exp(-weight) * task.seconds(last, views[p]);
            weight += gain;
            seen |= 1 << p;
            used.push(p);
        }
    }
    (weight > goal, expected, used)
}

/// Whether an order is complete, its expected time, and what of it is gone to.
type Value<'a> = dyn Fn(&[usize], &mut Budget) -> (bool, f64, Vec<usize>) + 'a;

/// Turns spans of at least `least` until none helps or the budget is used up; returns whether one did.
fn turn(
    order: &mut Vec<usize>,
    expected: &mut f64,
    least: usize,
    value: &Value,
    budget: &mut Budget,
) -> bool {
    let mut improved = false;
    let mut changed = Vec::new();
    // Starts of spans tried since the last change, against all there are.
    let (mut from, mut vain) = (0, 0);
    while vain < order.len() {
        let mut better = false;
        for to in from + least..=order.len().min(from + LONGEST) {
            for way in ways(to - from) {
                if budget.is_over() {
                    return improved | better;
                }
                if to > order.len() {
                    break; // a change before has made it shorter
                }
                changed.clone_from(order);
                match way {
                    0 => changed[from..to].reverse(),
                    by => changed[from..to].rotate_left(by),
                }
                better |= replace(order, expected, &changed, value, budget);
            }
        }
        improved |= better;
        vain = if better { 0 } else { vain + 1 };
        from = (from + 1) % order.len().max(1);
    }
    improved
}

/// What is tried on a span of so many views: 0 its reversal, else its rotation, by which a block of one to three views goes
/// from one end to the other.
fn ways(span: usize) -> impl Iterator<Item = usize> {
    std::iter::once(0).chain((1..=3.min(span - 1)).flat_map(move |block| [block, span - block]))
}

/// Puts `changed` in the place of `order` if its expected time is smaller.
fn replace(
    order: &mut Vec<usize>,
    expected: &mut f64,
    changed: &[usize],
    value: &Value,
    budget: &mut Budget,
) -> bool {
    let (complete, then, used) = value(changed, budget);
    let better = complete && then < *expected - 1e-9;
    if better {
        *expected = then;
        *order = used;
    }
    better
}
