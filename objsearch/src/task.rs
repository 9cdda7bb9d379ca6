//! A search task: cells, views, travel times, and what a sequence of views is worth (FLAP eq. 4, 5, 9).

use crate::Error;

/// Travel times, sensing included.
///
/// Laws: times are positive, `+infinity` where there is no way, never NaN.
pub trait CostModel {
    /// Seconds from the robot's state to a view.
    fn first(&self, view: usize) -> f64;
    /// Seconds from one view to another.
    fn between(&self, from: usize, to: usize) -> f64;
}

impl<C: CostModel + ?Sized> CostModel for &C {
    fn first(&self, view: usize) -> f64 {
        (**self).first(view)
    }
    fn between(&self, from: usize, to: usize) -> f64 {
        (**self).between(from, to)
    }
}

/// The cells that one view shows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct View {
    pub(crate) cells: Vec<usize>,
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

/// A task, checked once, with travel times copied into a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    pub(crate) weights: Vec<f64>,
    pub(crate) views: Vec<View>,
    /// Views that show each cell.
    pub(crate) shown_by: Vec<Vec<usize>>,
    first: Vec<f64>,
    between: Vec<f64>,
    total: f64,
    goal: f64,
}

/// What a sequence is worth.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Expected time until the target is seen or the sequence ends, s (FLAP eq. 4).
    pub expected_time: f64,
    /// Probability that the sequence sees the target (FLAP eq. 8).
    pub probability: f64,
    /// Whether no more than the threshold remains to be seen (FLAP eq. 9).
    pub complete: bool,
    /// The views that showed something new before completion.
    pub used: Vec<usize>,
}

impl Task {
    /// `weights[c]` is `-ln(1 - p(c))` of cell `c` ([`cell_weight`](crate::cell_weight)); a search is complete when the
    /// remaining probability is below `threshold` (omega).
    ///
    /// # Errors
    /// [`Error::Weight`], [`Error::Cell`], [`Error::Time`], [`Error::Probability`], each naming its value.
    pub fn new(
        weights: &[f64],
        views: &[View],
        costs: &impl CostModel,
        threshold: f64,
    ) -> Result<Self, Error> {
        if !(0.0..1.0).contains(&threshold) {
            return Err(Error::Probability {
                what: "threshold",
                value: threshold,
            });
        }
        for (cell, &value) in weights.iter().enumerate() {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Error::Weight { cell, value });
            }
        }
        let n = views.len();
        let mut shown_by = vec![Vec::new(); weights.len()];
        for (v, view) in views.iter().enumerate() {
            for &cell in &view.cells {
                shown_by
                    .get_mut(cell)
                    .ok_or(Error::Cell {
                        view: v,
                        cell,
                        cells: weights.len(),
                    })?
                    .push(v);
            }
        }
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
        let mut between = vec![0.0; n * n];
        for from in 0..n {
            for to in 0..n {
                if from != to {
                    between[from * n + to] = checked(to, costs.between(from, to))?;
                }
            }
        }
        let seen = |c: &usize| {
            first
                .iter()
                .enumerate()
                .any(|(v, t)| t.is_finite() && shown_by[*c].contains(&v))
        };
        let total = (0..weights.len()).filter(seen).map(|c| weights[c]).sum();
        let goal = total + (-threshold).ln_1p();
        Ok(Self {
            weights: weights.to_vec(),
            views: views.to_vec(),
            shown_by,
            first,
            between,
            total,
            goal,
        })
    }

    /// Number of views.
    pub fn len(&self) -> usize {
        self.views.len()
    }

    /// True if there is no view.
    pub fn is_empty(&self) -> bool {
        self.views.is_empty()
    }

    /// Weight that the reachable views show together (FLAP eq. 2).
    pub fn total_weight(&self) -> f64 {
        self.total
    }

    /// Covered weight above which a sequence is complete.
    pub fn goal_weight(&self) -> f64 {
        self.goal
    }

    /// Seconds from `from` (the robot's state when `None`) to a view.
    pub fn seconds(&self, from: Option<usize>, to: usize) -> f64 {
        match from {
            None => self.first[to],
            Some(from) => self.between[from * self.views.len() + to],
        }
    }

    /// Evaluates a sequence; views that show nothing new are passed over at no cost, and nothing counts after
    /// completion. Indices that are no view are passed over too.
    pub fn evaluate(&self, sequence: &[usize]) -> Evaluation {
        let mut seen = vec![false; self.weights.len()];
        let (mut covered, mut expected_time, mut used) = (0.0, 0.0, Vec::new());
        for &v in sequence {
            if covered > self.goal {
                break;
            }
            let Some(view) = self.views.get(v) else {
                continue;
            };
            let mut gain = 0.0;
            let mut any = false;
            for &cell in &view.cells {
                if !seen[cell] {
                    seen[cell] = true;
                    gain += self.weights[cell];
                    any = true;
                }
            }
            if any {
                expected_time += f64::exp(-covered) * self.seconds(used.last().copied(), v);
                covered += gain;
                used.push(v);
            }
        }
        Evaluation {
            expected_time,
            probability: crate::probability_of(covered),
            complete: covered > self.goal,
            used,
        }
    }
}
