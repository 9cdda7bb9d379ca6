//! The solver against exhaustive search, and against published optima.
#![allow(missing_docs, clippy::unwrap_used)]

use atsp::{CostMatrix, CostModel, Error, Params, Problem, solve};
use proptest::prelude::*;

/// The cheapest order over all permutations, by recursion.
fn exhaustive(costs: &CostMatrix, problem: Problem) -> f64 {
    fn visit(
        costs: &CostMatrix,
        problem: Problem,
        order: &mut Vec<usize>,
        cost: f64,
        best: &mut f64,
    ) {
        let n = costs.len();
        if order.len() == n {
            let last = order[n - 1];
            let total = match problem {
                Problem::Open { .. } => cost,
                Problem::Path { start, end } if start != end => {
                    if last == end {
                        cost
                    } else {
                        f64::INFINITY
                    }
                }
                _ if n == 1 => cost,
                _ => cost + costs.cost(last, order[0]),
            };
            *best = best.min(total);
            return;
        }
        for next in 0..n {
            if !order.contains(&next) {
                let step = costs.cost(order[order.len() - 1], next);
                order.push(next);
                visit(costs, problem, order, cost + step, best);
                order.pop();
            }
        }
    }
    let start = match problem {
        Problem::Closed => 0,
        Problem::Open { start } | Problem::Path { start, .. } => start,
    };
    let mut best = f64::INFINITY;
    visit(costs, problem, &mut vec![start], 0.0, &mut best);
    best
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// Dynamic programming and local search both reach the exhaustive optimum of up to eight nodes, in every form, with
    /// and without forbidden arcs; infeasible is said exactly when no order is finite.
    #[test]
    fn small_problems_are_optimal(
        n in 1..9usize,
        rolls in prop::collection::vec((0..50i32, 0..100u32), 64),
        forbidden in 0..40u32,
        form in 0..3usize,
        start in 0..8usize,
        end in 0..8usize,
    ) {
        let rows: Vec<Vec<f64>> = (0..n)
            .map(|i| (0..n).map(|j| {
                let (cost, roll) = rolls[i * 8 + j];
                if roll < forbidden { f64::INFINITY } else { f64::from(cost) }
            }).collect())
            .collect();
        let costs = CostMatrix::from_rows(&rows).unwrap();
        let problem = [
            Problem::Closed,
            Problem::Open { start: start % n },
            Problem::Path { start: start % n, end: end % n },
        ][form];
        let best = exhaustive(&costs, problem);
        match solve(&costs, problem, &Params::default()) {
            Ok(found) => {
                prop_assert!((found.cost - best).abs() < 1e-9, "{} against {}", found.cost, best);
                prop_assert!(found.optimal);
            }
            Err(Error::Infeasible) => prop_assert_eq!(best, f64::INFINITY),
            Err(other) => prop_assert!(false, "{other}"),
        }
    }

    /// The heuristic alone, kept from dynamic programming, finds the optimum of ten nodes.
    #[test]
    fn local_search_matches_dynamic_programming(
        rows in prop::collection::vec(prop::collection::vec(0.0..10.0f64, 10), 10),
        seed in 0..4u64,
    ) {
        let costs = CostMatrix::from_rows(&rows).unwrap();
        let exact = solve(&costs, Problem::Closed, &Params::default()).unwrap();
        let params = Params { exact_nodes: 3, kicks: 500, seed };
        let found = solve(&costs, Problem::Closed, &params).unwrap();
        prop_assert!(found.cost <= exact.cost + 1e-9);
    }
}

/// br17 of TSPLIB: 17 nodes, optimum 39 (Reinelt, TSPLIB 95).
#[test]
fn br17_is_solved() {
    let text = include_str!("br17.txt");
    let values: Vec<f64> = text
        .split_whitespace()
        .map(|t| t.parse().unwrap())
        .collect();
    let rows: Vec<&[f64]> = values.chunks(17).collect();
    let costs = CostMatrix::from_rows(&rows).unwrap();
    for seed in 0..5 {
        let found = solve(
            &costs,
            Problem::Closed,
            &Params {
                seed,
                ..Params::default()
            },
        )
        .unwrap();
        assert_eq!(found.cost, 39.0);
    }
}
