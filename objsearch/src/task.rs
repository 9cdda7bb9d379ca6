//! A search task: cells, views, travel times, and what a sequence of views is worth (FLAP eq. 4, 5, 8, 9).

use std::collections::HashMap;

use crate::belief::{inside_unit, probability_of};
use crate::{CostModel, Error};

/// The cells that one view shows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct View {
    cells: Vec<usize>,
}

impl View {
    /// Cell indices in any order; repeats count once.
    pub fn new(cells: impl IntoIterator<Item = usize>) -> Self {
        let mut cells: Vec<usize> = cells.into_iter().collect();
        cells.sort_unstable();
        cells.dedup();
        Self { cells }
    }

    /// The cells, sorted.
    pub fn cells(&self) -> &[usize] {
        &self.cells
    }
}

/// What a task asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// A sequence is complete when the probability that remains to be found with all views falls below it (omega).
    /// FLAP: 0.05.
    pub threshold: f64,
    /// Probability to notice a target that is in view, each look for itself, above 0 to 1. FLAP: 1, one look decides.
    pub detection: f64,
}

impl Default for Goal {
    fn default() -> Self {
        Self {
            threshold: 0.05,
            detection: 1.0,
        }
    }
}

/// A task, checked once.
///
/// Cells that exactly the same views show are merged into one class, since no sequence can tell them apart: some
/// 15 000 cells of a room become some 4 000 classes. Classes and views refer to each other by flat index lists.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    views: usize,
    cells: usize,
    /// Classes of view v: `class_of[class_from[v]..class_from[v + 1]]`.
    class_from: Vec<u32>,
    class_of: Vec<u32>,
    /// Views of class c: `view_of[view_from[c]..view_from[c + 1]]`, and beside them in `levels` the weight that the
    /// first, second, ... look at the class adds.
    view_from: Vec<u32>,
    view_of: Vec<u32>,
    levels: Vec<f64>,
    /// The first of each class's levels, by itself.
    weights: Vec<f64>,
    single_look: bool,
    first: Vec<f64>,
    between: Vec<f64>,
    /// For each view, the views it can be reached from, nearest first.
    sources: Vec<Vec<u32>>,
    total: f64,
    goal: f64,
}

/// What a sequence is worth.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Expected time until the target is seen or the sequence ends, s (FLAP eq. 4).
    pub expected_time: f64,
    /// Weight covered.
    pub weight: f64,
    /// Probability that the sequence sees the target (FLAP eq. 8).
    pub probability: f64,
    /// Whether less than the threshold remains to be seen (FLAP eq. 9).
    pub complete: bool,
    /// The views that showed something new before completion.
    pub used: Vec<usize>,
}

impl Task {
    /// `weights[c]` is `-ln(1 - p(c))` of cell `c` ([`Belief::weight`](crate::Belief::weight)); `costs` speaks of the views
    /// by their index. A view whose time from the robot is infinite is kept as an index but never used.
    ///
    /// # Errors
    /// [`Error::Weight`], [`Error::Cell`], [`Error::Time`], [`Error::Probability`], each naming its value.
    pub fn new(
        weights: &[f64],
        views: &[View],
        costs: &impl CostModel,
        goal: &Goal,
    ) -> Result<Self, Error> {
        inside_unit("threshold", goal.threshold)?;
        if !(goal.detection > 0.0 && goal.detection <= 1.0) {
            return Err(Error::Probability {
                what: "detection",
                value: goal.detection,
                wanted: "above 0 and at most 1",
            });
        }
        for (cell, &value) in weights.iter().enumerate() {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Error::Weight { cell, value });
            }
        }
        let n = views.len();
        for (view, shown) in views.iter().enumerate() {
            if let Some(&cell) = shown.cells.last().filter(|&&c| c >= weights.len()) {
                return Err(Error::Cell {
                    view,
                    cell,
                    cells: weights.len(),
                });
            }
        }
        let (first, between) = times(n, costs)?;
        let sources = (0..n)
            .map(|to| {
                let time = |from: u32| between[from as usize * n + to];
                let mut from: Vec<u32> = (0..n as u32)
                    .filter(|&f| first[f as usize].is_finite() && time(f).is_finite())
                    .collect();
                from.sort_by(|&a, &b| time(a).total_cmp(&time(b)).then(a.cmp(&b)));
                from
            })
            .collect();
        let mut task = Self {
            views: n,
            cells: weights.len(),
            class_from: Vec::new(),
            class_of: Vec::new(),
            view_from: vec![0],
            view_of: Vec::new(),
            levels: Vec::new(),
            weights: Vec::new(),
            single_look: goal.detection >= 1.0,
            first,
            between,
            sources,
            total: 0.0,
            goal: 0.0,
        };
        task.merge(weights, views, goal.detection);
        task.total = task.levels.iter().sum();
        task.goal = task.total + (-goal.threshold).ln_1p();
        Ok(task)
    }

    /// Builds the classes and both index lists.
    fn merge(&mut self, weights: &[f64], views: &[View], detection: f64) {
        let mut shown_by: Vec<Vec<u32>> = vec![Vec::new(); weights.len()];
        for (v, view) in views.iter().enumerate() {
            if self.first[v].is_finite() {
                for &cell in &view.cells {
                    shown_by[cell].push(v as u32);
                }
            }
        }
        // Classes are numbered in the order of their first cell, so nothing depends on the order of the hash map.
        let mut number: HashMap<(&[u32], u64), usize> = HashMap::new();
        let mut classes: Vec<(&[u32], f64, f64)> = Vec::new();
        for (cell, by) in shown_by.iter().enumerate() {
            if by.is_empty() || weights[cell] == 0.0 {
                continue;
            }
            // With looks that may miss, cells of different weight do not fade alike.
            let kind = if self.single_look {
                0
            } else {
                weights[cell].to_bits()
            };
            let class = *number.entry((by, kind)).or_insert_with(|| {
                classes.push((by, weights[cell], 0.0));
                classes.len() - 1
            });
            classes[class].2 += if self.single_look { weights[cell] } else { 1.0 };
        }
        let mut lists = vec![Vec::new(); views.len()];
        for (class, &(by, weight, sum)) in classes.iter().enumerate() {
            let mut before = f64::INFINITY;
            let start = self.levels.len();
            for (look, &v) in by.iter().enumerate() {
                lists[v as usize].push(class as u32);
                self.view_of.push(v);
                let level = if self.single_look {
                    if look == 0 { sum } else { 0.0 }
                } else {
                    sum * (faded(weight, detection, look + 1) - faded(weight, detection, look))
                };
                // Each look adds less than the one before; rounding must not make it otherwise.
                before = level.clamp(0.0, before);
                self.levels.push(before);
            }
            self.weights.push(self.levels[start]);
            self.view_from.push(self.view_of.len() as u32);
        }
        self.class_from.push(0);
        for list in lists {
            self.class_of.extend(list);
            self.class_from.push(self.class_of.len() as u32);
        }
    }

    /// Number of views.
    pub fn len(&self) -> usize {
        self.views
    }

    /// True if there is no view.
    pub fn is_empty(&self) -> bool {
        self.views == 0
    }

    /// Number of cells given.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// Number of classes that the cells in view were merged into.
    pub fn class_count(&self) -> usize {
        self.view_from.len() - 1
    }

    /// Weight that the reachable views show together (FLAP eq. 2).
    pub fn total_weight(&self) -> f64 {
        self.total
    }

    /// Covered weight above which a sequence is complete.
    pub fn goal_weight(&self) -> f64 {
        self.goal
    }

    /// True if there is a way from the robot's state to the view.
    pub fn is_reachable(&self, view: usize) -> bool {
        self.first.get(view).is_some_and(|t| t.is_finite())
    }

    /// Seconds from `from` (the robot's state when `None`) to a view.
    ///
    /// # Panics
    /// If an index is no view.
    pub fn seconds(&self, from: Option<usize>, to: usize) -> f64 {
        match from {
            None => self.first[to],
            Some(from) => self.between[from * self.views + to],
        }
    }

    /// Views from which another can be reached, nearest first.
    pub(crate) fn sources(&self, to: usize) -> &[u32] {
        &self.sources[to]
    }

    /// True if the first look at a class shows all of it.
    pub(crate) fn single_look(&self) -> bool {
        self.single_look
    }

    /// Classes that a view shows.
    pub(crate) fn classes(&self, view: usize) -> &[u32] {
        &self.class_of[self.class_from[view] as usize..self.class_from[view + 1] as usize]
    }

    /// Views that show a class.
    pub(crate) fn views_of(&self, class: u32) -> &[u32] {
        let class = class as usize;
        &self.view_of[self.view_from[class] as usize..self.view_from[class + 1] as usize]
    }

    /// Weight that each look in turn adds to a class, as many as views show it.
    pub(crate) fn levels(&self, class: u32) -> &[f64] {
        let class = class as usize;
        &self.levels[self.view_from[class] as usize..self.view_from[class + 1] as usize]
    }

    /// Weight of the first look at a class.
    #[inline]
    pub(crate) fn weight(&self, class: u32) -> f64 {
        self.weights[class as usize]
    }

    /// Number of view-class pairs.
    pub(crate) fn incidence(&self) -> usize {
        self.class_of.len()
    }

    /// Evaluates a sequence; views that show nothing new are passed over at no cost, and nothing counts after
    /// completion. Indices that are no view, views already taken and unreachable views are passed over too.
    pub fn evaluate(&self, sequence: &[usize]) -> Evaluation {
        let mut looks = vec![0u32; self.class_count()];
        let (mut weight, mut expected_time, mut used) = (0.0, 0.0, Vec::new());
        for &v in sequence {
            if weight > self.goal {
                break;
            }
            if v >= self.views || used.contains(&v) {
                continue;
            }
            let mut gain = 0.0;
            for &class in self.classes(v) {
                let look = &mut looks[class as usize];
                if *look == 0 {
                    gain += self.weight(class);
                } else if !self.single_look {
                    gain += self.levels(class)[*look as usize];
                }
                *look += 1;
            }
            if gain > 0.0 {
                expected_time += f64::exp(-weight) * self.seconds(used.last().copied(), v);
                weight += gain;
                used.push(v);
            }
        }
        Evaluation {
            expected_time,
            weight,
            probability: probability_of(weight),
            complete: weight > self.goal,
            used,
        }
    }
}

/// `-ln(1 - p (1 - (1 - q)^k))`: what is covered of a cell after k looks that notice the target with probability q each.
fn faded(weight: f64, detection: f64, looks: usize) -> f64 {
    -(-probability_of(weight) * (1.0 - (1.0 - detection).powf(looks as f64))).ln_1p()
}

fn times(n: usize, costs: &impl CostModel) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let checked = |to, value: f64| {
        if value > 0.0 {
            Ok(value)
        } else {
            Err(Error::Time { to, value })
        }
    };
    let first = (0..n)
        .map(|v| checked(v, costs.first(v)))
        .collect::<Result<Vec<_>, _>>()?;
    let mut between = vec![f64::INFINITY; n * n];
    for from in 0..n {
        for to in 0..n {
            if from != to {
                between[from * n + to] = checked(to, costs.between(from, to))?;
            }
        }
    }
    Ok((first, between))
}
