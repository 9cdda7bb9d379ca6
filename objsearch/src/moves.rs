//! All changes "take one view out, put another in anywhere" of a sequence, evaluated in bulk.
//!
//! What a view adds to a sequence depends only on which of the views before it cover its classes. One pass over the
//! classes of a candidate therefore tells its gain at every place, and, with the second place that covers a class, its
//! gain at every place of the sequence with any one view taken out.

use crate::task::Task;

/// A change of a sequence and what it is expected to give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Move {
    /// Expected time after it, s.
    pub(crate) expected: f64,
    /// Position taken out.
    pub(crate) out: Option<usize>,
    /// View put in, before the view that stood at this position.
    pub(crate) into: Option<(usize, usize)>,
}

/// No position.
const NONE: u16 = u16::MAX;

/// The sequence as the bulk evaluation needs it; all tables have rows "position r taken out", the last row "none".
#[derive(Clone, Debug, Default)]
pub(crate) struct Moves {
    sequence: Vec<usize>,
    /// Position of each view in the sequence.
    place: Vec<u16>,
    /// First and second position that cover each class.
    covers: Vec<[u16; 2]>,
    /// The same as an index of `shift`, which has a row for each first position and a column for each second one.
    pairs: Vec<u32>,
    /// All positions per class in order, kept only where looks may miss.
    every: Vec<Vec<u16>>,
    /// Weight that each position adds, and what it adds more with position r out: rows r, columns position.
    more: Vec<f64>,
    gains: Vec<f64>,
    /// Weight before each position, survival before it, expected time up to its start; rows r, K + 1 columns.
    weight: Vec<f64>,
    survival: Vec<f64>,
    expected: Vec<f64>,
    /// Times between positions: rows from, K columns; the last row is from the start.
    times: Vec<f64>,
    // Of one candidate: weight that it adds where the class is first covered at f (K: never), and what it adds more there
    // with position r out.
    base: Vec<f64>,
    shift: Vec<f64>,
    from: Vec<f64>,
    to: Vec<f64>,
    // Of one candidate and one r.
    after: Vec<f64>,
}

impl Moves {
    /// Takes in a sequence of distinct reachable views; returns its steps.
    pub(crate) fn set(&mut self, task: &Task, sequence: &[usize]) -> usize {
        let k = sequence.len();
        self.sequence.clear();
        self.sequence.extend_from_slice(sequence);
        self.place.clear();
        self.place.resize(task.len(), NONE);
        self.covers.clear();
        self.covers.resize(task.class_count(), [NONE; 2]);
        reset(&mut self.gains, k);
        reset(&mut self.more, k * k);
        let mut steps = task.class_count() / 8;
        if task.single_look() {
            for (position, &v) in sequence.iter().enumerate() {
                self.place[v] = position as u16;
                for &class in task.classes(v) {
                    let cover = &mut self.covers[class as usize];
                    if cover[0] == NONE {
                        cover[0] = position as u16;
                        self.gains[position] += task.weight(class);
                    } else if cover[1] == NONE {
                        cover[1] = position as u16;
                        self.more[usize::from(cover[0]) * k + position] += task.weight(class);
                    }
                }
                steps += task.classes(v).len();
            }
            let (k, columns) = (k as u16, k as u32 + 1);
            self.pairs.clear();
            self.pairs.extend(self.covers.iter().map(|cover| {
                let [first, second] = cover.map(|p| u32::from(p.min(k)));
                first * columns + second
            }));
        } else {
            self.every.iter_mut().for_each(Vec::clear);
            self.every.resize(task.class_count(), Vec::new());
            for (position, &v) in sequence.iter().enumerate() {
                self.place[v] = position as u16;
                for &class in task.classes(v) {
                    let earlier = &mut self.every[class as usize];
                    let levels = task.levels(class);
                    let look = earlier.len();
                    self.gains[position] += levels[look];
                    for &out in earlier.iter() {
                        // One look fewer before this one.
                        self.more[usize::from(out) * k + position] +=
                            levels[look - 1] - levels[look];
                    }
                    earlier.push(position as u16);
                    steps += look + 1;
                }
            }
        }
        self.tables(task);
        steps + k * k * 6
    }

    /// Weights, survivals and expected times of the prefixes.
    fn tables(&mut self, task: &Task) {
        let k = self.sequence.len();
        self.times.clear();
        for from in (0..k).map(Some).chain([None]) {
            let view = from.map(|f| self.sequence[f]);
            self.times
                .extend(self.sequence.iter().enumerate().map(|(to, &v)| {
                    if from == Some(to) {
                        0.0
                    } else {
                        task.seconds(view, v)
                    }
                }));
        }
        let columns = k + 1;
        for table in [&mut self.weight, &mut self.survival, &mut self.expected] {
            reset(table, columns * columns);
        }
        for out in 0..=k {
            let (mut weight, mut expected, mut last) = (0.0, 0.0, k);
            for position in 0..=k {
                let cell = out * columns + position;
                self.weight[cell] = weight;
                self.survival[cell] = f64::exp(-weight);
                self.expected[cell] = expected;
                if position < k && position != out {
                    if weight <= task.goal_weight() {
                        expected += self.survival[cell] * self.times[last * k + position];
                    }
                    weight += self.gains[position];
                    if position > out {
                        weight += self.more[out * k + position];
                    }
                    last = position;
                }
            }
        }
    }

    /// The best way to leave one view out.
    pub(crate) fn best_removal(&self, task: &Task) -> Option<Move> {
        let k = self.sequence.len();
        let mut best: Option<Move> = None;
        for out in 0..k {
            let end = out * (k + 1) + k;
            let expected = self.expected[end];
            if self.weight[end] > task.goal_weight() && best.is_none_or(|b| expected < b.expected) {
                best = Some(Move {
                    expected,
                    out: Some(out),
                    into: None,
                });
            }
        }
        best
    }

    /// The best way to put view `v` in somewhere with at most one view taken out; for a view of the sequence, to put it
    /// elsewhere. Adds its steps to `steps`. Only sequences that stay complete count.
    pub(crate) fn best_with(&mut self, task: &Task, v: usize, steps: &mut usize) -> Option<Move> {
        let k = self.sequence.len();
        if !task.is_reachable(v) || task.classes(v).is_empty() {
            return None;
        }
        *steps += self.scan(task, v) + 4 * k;
        let own = self.place[v];
        self.from.clear();
        self.to.clear();
        for &other in &self.sequence {
            self.from.push(task.seconds(Some(other), v));
            self.to.push(task.seconds(Some(v), other));
        }
        self.from.push(task.seconds(None, v));
        let mut best: Option<Move> = None;
        let rows = if own == NONE {
            0..k + 1
        } else {
            usize::from(own)..usize::from(own) + 1
        };
        let goal = task.goal_weight();
        for out in rows {
            *steps += 2;
            // Weight of all with the candidate in: complete at all?
            let never = self.base[k]
                + if out < k {
                    self.shift[out * (k + 1) + k]
                } else {
                    0.0
                };
            if self.weight[out * (k + 1) + k] + never <= goal {
                continue;
            }
            *steps += 8 * k;
            self.insertions(v, out, goal, &mut best);
        }
        best
    }

    /// Fills `base` and `shift` for a candidate.
    fn scan(&mut self, task: &Task, v: usize) -> usize {
        let k = self.sequence.len();
        reset(&mut self.base, k + 1);
        reset(&mut self.shift, (k + 1) * (k + 1));
        if task.single_look() {
            for &class in task.classes(v) {
                self.shift[self.pairs[class as usize] as usize] += task.weight(class);
            }
            for (base, shifts) in self.base.iter_mut().zip(self.shift.chunks(k + 1)) {
                *base = shifts.iter().sum();
            }
            return task.classes(v).len();
        }
        let mut steps = 0;
        for &class in task.classes(v) {
            let places = &self.every[class as usize];
            let levels = task.levels(class);
            let level = |look: usize| levels.get(look).copied().unwrap_or(0.0);
            for (look, &p) in places.iter().enumerate() {
                // Behind position p a look is worth less by this much.
                self.base[usize::from(p)] += level(look) - level(look + 1);
                for &out in &places[..look] {
                    let drop = |at: usize| level(at) - level(at + 1);
                    self.shift[usize::from(out) * (k + 1) + usize::from(p)] +=
                        drop(look - 1) - drop(look);
                }
            }
            let m = places.len();
            self.base[k] += level(m);
            for &out in places {
                self.shift[usize::from(out) * (k + 1) + k] += level(m - 1) - level(m);
            }
            steps += (m + 1) * (m + 2) / 2;
        }
        steps
    }

    /// Every place for candidate `v` with position `out` left out (none if `out` is the length).
    fn insertions(&mut self, v: usize, out: usize, goal: f64, best: &mut Option<Move>) {
        let k = self.sequence.len();
        let columns = k + 1;
        let row = out * columns;
        // after[p]: weight before position p with the candidate somewhere before it.
        self.after.clear();
        self.after.resize(columns, 0.0);
        let mut gain = 0.0;
        for p in (0..columns).rev() {
            if p != out || out == k {
                gain += self.base[p];
            }
            if out < k && p > out {
                gain += self.shift[row + p];
            }
            self.after[p] = self.weight[row + p] + gain;
        }
        let mut consider = |expected: f64, place: usize| {
            if best.is_none_or(|b| expected < b.expected) {
                *best = Some(Move {
                    expected,
                    out: (out < k).then_some(out),
                    into: Some((v, place)),
                });
            }
        };
        let previous = |p: usize| match (p, out) {
            (0, _) | (1, 0) => k,
            _ if p - 1 == out => p - 2,
            _ => p - 1,
        };
        let arrive =
            |p: usize| self.expected[row + p] + self.survival[row + p] * self.from[previous(p)];
        if self.weight[row + k] <= goal {
            consider(arrive(k), k);
        }
        // From the end: the next position that is still gone to, the survival there, and the time spent after it.
        let mut next: Option<(usize, f64, f64)> = None;
        for p in (0..k).rev() {
            if p == out {
                continue;
            }
            if self.after[p] > goal {
                next = None;
            } else if self.after[p + 1] - self.after[p] > 1e-12 {
                let rest = next.map_or(0.0, |(q, survival, rest)| {
                    survival * self.times[p * k + q] + rest
                });
                next = Some((p, f64::exp(-self.after[p]), rest));
            } // else it would show nothing new and is passed over
            if self.weight[row + p] <= goal {
                let rest = next.map_or(0.0, |(q, survival, rest)| survival * self.to[q] + rest);
                consider(arrive(p) + rest, p);
            }
        }
    }

    /// The sequence after a move.
    pub(crate) fn apply(&self, change: &Move) -> Vec<usize> {
        let mut sequence = Vec::with_capacity(self.sequence.len() + 1);
        for (position, &view) in self.sequence.iter().enumerate() {
            if let Some((v, _)) = change.into.filter(|&(_, place)| place == position) {
                sequence.push(v);
            }
            if change.out != Some(position) {
                sequence.push(view);
            }
        }
        if let Some((v, place)) = change.into
            && place >= self.sequence.len()
        {
            sequence.push(v);
        }
        sequence
    }
}

fn reset(table: &mut Vec<f64>, size: usize) {
    table.clear();
    table.resize(size, 0.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Goal, Times, View};

    /// The bulk figures are those of evaluating every change for itself.
    #[test]
    fn bulk_evaluation_agrees_with_single_evaluation() {
        let mut rng = crate::rng::Rng::new(7);
        for detection in [1.0, 0.7] {
            for round in 0..40 {
                let n = 6 + round % 3;
                // Points in the plane: no detour is shorter than the direct way.
                let at: Vec<[f64; 2]> = (0..=n)
                    .map(|_| [rng.unit() * 30.0, rng.unit() * 30.0])
                    .collect();
                let t = |a: usize, b: usize| 5.0 + (at[a][0] - at[b][0]).hypot(at[a][1] - at[b][1]);
                let first = (0..n).map(|v| t(n, v)).collect();
                let between = (0..n * n).map(|i| t(i / n, i % n)).collect();
                let views: Vec<View> = (0..n)
                    .map(|_| View::new((0..4).map(|_| rng.below(9))))
                    .collect();
                let weights: Vec<f64> = (0..9).map(|_| 0.05 + rng.unit() * 0.4).collect();
                let goal = Goal {
                    threshold: 0.2,
                    detection,
                };
                let times = Times::new(first, between).unwrap();
                let task = Task::new(&weights, &views, &times, &goal).unwrap();
                let sequence = crate::greedy(&task).sequence;
                let mut moves = Moves::default();
                moves.set(&task, &sequence);
                for v in 0..n {
                    let found = moves.best_with(&task, v, &mut 0);
                    let mut best = f64::INFINITY;
                    for out in (0..sequence.len()).map(Some).chain([None]) {
                        if let Some(p) = sequence.iter().position(|&s| s == v)
                            && out != Some(p)
                        {
                            continue;
                        }
                        for place in 0..=sequence.len() {
                            let change = Move {
                                expected: 0.0,
                                out,
                                into: Some((v, place)),
                            };
                            let value = task.evaluate(&moves.apply(&change));
                            // The candidate itself may be passed over; then the change is a removal.
                            if value.complete && value.used.contains(&v) {
                                best = best.min(value.expected_time);
                            }
                        }
                    }
                    match found {
                        // A candidate that shows nothing new is charged by the bulk figures: never below.
                        Some(change) => {
                            let value = task.evaluate(&moves.apply(&change));
                            assert!(value.expected_time <= change.expected + 1e-9);
                            assert!(change.expected <= best + 1e-9, "{} {best}", change.expected);
                        }
                        None => assert_eq!(best, f64::INFINITY),
                    }
                }
            }
        }
    }
}
