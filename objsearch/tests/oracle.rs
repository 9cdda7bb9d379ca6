//! The planners against exhaustive search and against stored reference values.
#![allow(missing_docs, clippy::unwrap_used)]

use objsearch::{CostModel, Params, Task, View, greedy, optimal, plan};
use proptest::prelude::*;

struct Table {
    first: Vec<f64>,
    between: Vec<Vec<f64>>,
}

impl CostModel for Table {
    fn first(&self, view: usize) -> f64 {
        self.first[view]
    }
    fn between(&self, from: usize, to: usize) -> f64 {
        self.between[from][to]
    }
}

/// `synth-014`: 14 views, generated for this project; greedy and branch-and-bound values and the optimum are known.
fn synth_014() -> (Task, serde_json::Value) {
    let instance: serde_json::Value = serde_json::from_str(include_str!("synth-014.json")).unwrap();
    let numbers = |v: &serde_json::Value| -> Vec<f64> {
        v.as_array()
            .unwrap()
            .iter()
            .map(|x| x.as_f64().unwrap())
            .collect()
    };
    let first = numbers(&instance["t0"]);
    let n = first.len();
    let lower = numbers(&instance["t_lower"]);
    let mut between = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..i {
            between[i][j] = lower[i * (i - 1) / 2 + j];
            between[j][i] = between[i][j];
        }
    }
    let views: Vec<View> = instance["views"]
        .as_array()
        .unwrap()
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
    let omega = instance["omega"].as_f64().unwrap();
    let task = Task::new(
        &numbers(&instance["cell_weight"]),
        &views,
        &Table { first, between },
        omega,
    );
    (task.unwrap(), instance)
}

#[test]
fn reference_values_are_met() {
    let (task, instance) = synth_014();
    let reference = &instance["reference"];
    let near = |a: f64, b: &serde_json::Value| {
        assert!((a - b.as_f64().unwrap()).abs() < 2e-3, "{a} against {b}")
    };
    near(greedy(&task).expected_time, &reference["greedy"]);
    near(
        plan(
            &task,
            &Params {
                prune_dominated: false,
                ..Params::default()
            },
        )
        .expected_time,
        &reference["flap_psi2_phi1.3_xi0"],
    );
    near(
        plan(&task, &Params::default()).expected_time,
        &reference["flap_psi2_phi1.3_xi1"],
    );
    near(
        optimal(&task).unwrap().expected_time,
        &instance["best"]["expected_time"],
    );
}

/// Least expected time over every order that completes.
fn exhaustive(task: &Task) -> f64 {
    fn visit(task: &Task, order: &mut Vec<usize>, best: &mut f64) {
        let value = task.evaluate(order);
        if value.complete || order.len() == task.len() {
            *best = best.min(value.expected_time);
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

fn tasks() -> impl Strategy<Value = Task> {
    (2..6usize, 2..8usize).prop_flat_map(|(views, cells)| {
        (
            prop::collection::vec(0.01..0.8f64, cells),
            prop::collection::vec(prop::collection::vec(0..cells, 1..=cells), views),
            prop::collection::vec(1.0..40.0f64, views),
            prop::collection::vec(prop::collection::vec(1.0..40.0f64, views), views),
        )
            .prop_map(|(weights, shown, first, between)| {
                let views: Vec<View> = shown.into_iter().map(View::new).collect();
                Task::new(&weights, &views, &Table { first, between }, 0.05).unwrap()
            })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// The subset program equals exhaustive search; the others never beat it.
    #[test]
    fn the_exact_planner_is_optimal(task in tasks()) {
        let best = exhaustive(&task);
        let exact = optimal(&task).unwrap();
        prop_assert!((exact.expected_time - best).abs() < 1e-9, "{} against {}", exact.expected_time, best);
        for found in [greedy(&task), plan(&task, &Params::default())] {
            prop_assert!(found.expected_time >= best - 1e-9);
        }
    }

    /// Without limits, branch and bound is exact.
    #[test]
    fn unlimited_branching_is_optimal(task in tasks()) {
        let params = Params { depth_limit: 99, branch_limit: f64::INFINITY, prune_dominated: false, ..Params::default() };
        let found = plan(&task, &params);
        prop_assert!((found.expected_time - optimal(&task).unwrap().expected_time).abs() < 1e-9);
    }

    /// More branching never costs, and the reported value is that of the sequence.
    #[test]
    fn branching_never_hurts(task in tasks()) {
        let base = greedy(&task);
        let more = plan(&task, &Params { prune_dominated: false, ..Params::default() });
        prop_assert!(more.expected_time <= base.expected_time + 1e-9);
        let value = task.evaluate(&more.sequence);
        prop_assert_eq!(value.expected_time, more.expected_time);
        prop_assert!(value.probability <= 1.0);
    }
}
