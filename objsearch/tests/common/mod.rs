//! Tasks for tests.
#![allow(missing_docs, dead_code, clippy::unwrap_used)]

use objsearch::{Goal, Task, Times, View};
use proptest::prelude::*;

/// An instance of the project's format.
pub(crate) struct Instance {
    pub(crate) task: Task,
    pub(crate) json: serde_json::Value,
}

impl Instance {
    pub(crate) fn parse(text: &str) -> Self {
        let json: serde_json::Value = serde_json::from_str(text).unwrap();
        let list = |key: &str| json[key].as_array().unwrap();
        let numbers =
            |key: &str| -> Vec<f64> { list(key).iter().map(|x| x.as_f64().unwrap()).collect() };
        let views: Vec<View> = list("views")
            .iter()
            .map(|v| {
                View::new(
                    v.as_array()
                        .unwrap()
                        .iter()
                        .map(|c| c.as_u64().unwrap() as usize),
                )
            })
            .collect();
        let goal = Goal {
            threshold: json["omega"].as_f64().unwrap(),
            ..Goal::default()
        };
        let times = Times::from_lower(numbers("t0"), &numbers("t_lower")).unwrap();
        let task = Task::new(&numbers("cell_weight"), &views, &times, &goal).unwrap();
        Self { task, json }
    }

    pub(crate) fn reference(&self, key: &str) -> f64 {
        self.json["reference"][key].as_f64().unwrap()
    }

    pub(crate) fn best(&self) -> f64 {
        self.json["best"]["expected_time"].as_f64().unwrap()
    }

    /// The project's definition of the objective (`evaluate.py`), on the file's cells: expected time, complete.
    pub(crate) fn expected_time(&self, sequence: &[usize]) -> (f64, bool) {
        let json = &self.json;
        let n = json["n_views"].as_u64().unwrap() as usize;
        let time = |from: Option<usize>, to: usize| match from {
            None => json["t0"][to].as_f64().unwrap(),
            Some(from) => {
                let (i, j) = (from.max(to), from.min(to));
                json["t_lower"][i * (i - 1) / 2 + j].as_f64().unwrap()
            }
        };
        let cells = |v: usize| {
            let list = json["views"][v].as_array().unwrap();
            list.iter()
                .map(|c| c.as_u64().unwrap() as usize)
                .collect::<Vec<_>>()
        };
        let weight = |c: usize| json["cell_weight"][c].as_f64().unwrap();
        let mut all: Vec<usize> = (0..n).flat_map(cells).collect();
        all.sort_unstable();
        all.dedup();
        let total: f64 = all.iter().map(|&c| weight(c)).sum();
        let goal = total + (1.0 - json["omega"].as_f64().unwrap()).ln();
        let mut seen = std::collections::BTreeSet::new();
        let (mut covered, mut expected, mut last) = (0.0f64, 0.0, None);
        for &v in sequence {
            if covered > goal {
                break;
            }
            let new: Vec<usize> = cells(v).into_iter().filter(|c| !seen.contains(c)).collect();
            if new.is_empty() {
                continue;
            }
            expected += (-covered).exp() * time(last, v);
            covered += new.iter().map(|&c| weight(c)).sum::<f64>();
            seen.extend(new);
            last = Some(v);
        }
        (expected, covered > goal)
    }
}

/// Small tasks with any times.
pub(crate) fn tasks() -> impl Strategy<Value = Task> {
    any_tasks(Just(1.0))
}

/// Small tasks whose looks may miss.
pub(crate) fn unreliable_tasks() -> impl Strategy<Value = Task> {
    any_tasks(0.3..1.0f64)
}

fn any_tasks(detection: impl Strategy<Value = f64>) -> impl Strategy<Value = Task> {
    (2..6usize, 2..8usize, detection).prop_flat_map(|(views, cells, detection)| {
        (
            prop::collection::vec(0.01..0.8f64, cells),
            prop::collection::vec(prop::collection::vec(0..cells, 1..=cells), views),
            prop::collection::vec(1.0..40.0f64, views),
            prop::collection::vec(1.0..40.0f64, views * views),
            0.02..0.5f64,
        )
            .prop_map(move |(weights, shown, first, between, threshold)| {
                let views: Vec<View> = shown.into_iter().map(View::new).collect();
                let goal = Goal {
                    threshold,
                    detection,
                };
                Task::new(
                    &weights,
                    &views,
                    &Times::new(first, between).unwrap(),
                    &goal,
                )
                .unwrap()
            })
    })
}

/// Small tasks on a plane with coarse coordinates: no detour is shorter than the direct way, and many views share a place.
pub(crate) fn plane_tasks() -> impl Strategy<Value = Task> {
    (2..7usize, 2..8usize).prop_flat_map(|(views, cells)| {
        (
            prop::collection::vec(0.01..0.8f64, cells),
            prop::collection::vec(prop::collection::vec(0..cells, 1..=4), views),
            prop::collection::vec((0..3u8, 0..3u8), views + 1),
        )
            .prop_map(|(weights, shown, at)| {
                let n = shown.len();
                let time = |a: usize, b: usize| {
                    let ([ax, ay], [bx, by]) = ([at[a].0, at[a].1], [at[b].0, at[b].1]);
                    5.0 + 8.0
                        * f64::hypot(f64::from(ax) - f64::from(bx), f64::from(ay) - f64::from(by))
                };
                let first = (0..n).map(|v| time(n, v)).collect();
                let between = (0..n * n).map(|i| time(i / n, i % n)).collect();
                let views: Vec<View> = shown.into_iter().map(View::new).collect();
                let times = Times::new(first, between).unwrap();
                Task::new(&weights, &views, &times, &Goal::default()).unwrap()
            })
    })
}

/// Least expected time over every order that completes, by trying all.
pub(crate) fn exhaustive(task: &Task) -> f64 {
    fn visit(task: &Task, order: &mut Vec<usize>, best: &mut f64) {
        let value = task.evaluate(order);
        if value.complete {
            *best = best.min(value.expected_time);
            return; // what follows does not count
        }
        for v in 0..task.len() {
            if !order.contains(&v) {
                order.push(v);
                visit(task, order, best);
                order.pop();
            }
        }
    }
    let mut best = f64::INFINITY;
    visit(task, &mut Vec::new(), &mut best);
    best
}
