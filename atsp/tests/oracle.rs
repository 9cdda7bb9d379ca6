//! The solver against exhaustive search, and against published optima.
#![allow(missing_docs, clippy::unwrap_used)]

use atsp::{CostMatrix, CostModel, Error, Params, Problem, Proof, solve};
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
        let params = Params { exact_nodes: 8, kicks: 500, seed, proof: Proof::Assignment };
        let found = solve(&costs, Problem::Closed, &params).unwrap();
        prop_assert!(found.cost <= exact.cost + 1e-9);
    }
}

/// Held and Karp's program over subsets, written apart from the library's: forward, by hash-free recursion on bit sets.
fn dynamic(costs: &CostMatrix) -> f64 {
    let n = costs.len();
    let mut best = vec![vec![f64::INFINITY; n]; 1 << n];
    best[1][0] = 0.0;
    for set in 1..1usize << n {
        for last in 0..n {
            for next in 0..n {
                if set >> next & 1 == 0 {
                    let cost = best[set][last] + costs.cost(last, next);
                    let slot = &mut best[set | 1 << next][next];
                    *slot = slot.min(cost);
                }
            }
        }
    }
    (1..n)
        .map(|last| best[(1 << n) - 1][last] + costs.cost(last, 0))
        .fold(f64::INFINITY, f64::min)
}

/// Costs of three kinds: independent, nearly symmetric in the plane, and few distinct ones with many ties.
fn kinds(n: usize) -> impl Strategy<Value = CostMatrix> {
    let points = prop::collection::vec((0.0..10.0f64, 0.0..10.0f64), n);
    let rolls = prop::collection::vec((0..1000i32, 0..100u32), n * n);
    (0..3, 0..30u32, points, rolls).prop_map(move |(kind, forbidden, points, rolls)| {
        let rows: Vec<Vec<f64>> = (0..n)
            .map(|a| {
                (0..n)
                    .map(|b| {
                        let (roll, chance) = rolls[a * n + b];
                        let ((ax, ay), (bx, by)) = (points[a], points[b]);
                        if chance < forbidden {
                            return f64::INFINITY;
                        }
                        match kind {
                            0 => f64::from(roll),
                            1 => (ax - bx).hypot(ay - by) + 0.0005 * f64::from(roll),
                            _ => f64::from(roll % 4),
                        }
                    })
                    .collect()
            })
            .collect();
        CostMatrix::from_rows(&rows).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Nine to thirteen nodes are optimal and said to be, or infeasible exactly when they are.
    #[test]
    fn sets_within_the_promise_are_proved(costs in (9..13usize).prop_flat_map(kinds)) {
        let best = dynamic(&costs);
        match solve(&costs, Problem::Closed, &Params::default()) {
            Ok(found) => {
                prop_assert!(found.optimal);
                prop_assert!((found.cost - best).abs() < 1e-9, "{} against {}", found.cost, best);
            }
            Err(Error::Infeasible) => prop_assert_eq!(best, f64::INFINITY),
            Err(other) => prop_assert!(false, "{other}"),
        }
    }

    /// Above the promise: bounds are below the optimum at every effort, and `optimal` is never said wrongly.
    #[test]
    fn bounds_and_proofs_hold(costs in kinds(12), seed in 0..9u64, steps in 1..40u32, branches in 0..60u64) {
        let best = dynamic(&costs);
        for proof in [Proof::Assignment, Proof::Quick, Proof::Effort { steps, branches }] {
            let params = Params { exact_nodes: 8, kicks: 3, seed, proof };
            match solve(&costs, Problem::Closed, &params) {
                Ok(found) => {
                    prop_assert!(found.cost >= best - 1e-9);
                    let bound = found.lower_bound.unwrap();
                    prop_assert!(bound <= best + 1e-9, "{bound} above {best}");
                    prop_assert!(!found.optimal || found.cost <= best + 1e-9);
                    let share = found.gap().unwrap();
                    prop_assert!(share >= 0.0 && (share == 0.0 || (share - (found.cost - bound) / found.cost).abs() < 1e-12));
                }
                Err(Error::Infeasible) => prop_assert_eq!(best, f64::INFINITY),
                Err(Error::NotFound) => {}
                Err(other) => prop_assert!(false, "{other}"),
            }
        }
    }
}

/// The bound of the linear program with all subtour inequalities, by clarabel, cuts found by minimum cuts (brute force over
/// the sets of a small instance): assignment bound <= ascent <= LP <= optimum.
mod linear {
    use super::*;
    use clarabel::algebra::CscMatrix;
    use clarabel::solver::{
        DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT,
    };

    /// Minimise the arc costs: degrees one, at least one arc out of each listed set.
    fn program(costs: &CostMatrix, sets: &[usize]) -> (f64, Vec<f64>) {
        let n = costs.len();
        let arcs: Vec<(usize, usize)> = (0..n)
            .flat_map(|a| (0..n).filter(move |&b| b != a).map(move |b| (a, b)))
            .collect();
        let q: Vec<f64> = arcs.iter().map(|&(a, b)| costs.cost(a, b)).collect();
        let (m, cuts) = (arcs.len(), sets.len());
        let rows = 2 * n + cuts + m;
        let (mut is, mut js, mut vs) = (Vec::new(), Vec::new(), Vec::new());
        let mut put = |i: usize, j: usize, v: f64| {
            is.push(i);
            js.push(j);
            vs.push(v);
        };
        for (j, &(a, b)) in arcs.iter().enumerate() {
            put(a, j, 1.0);
            put(n + b, j, 1.0);
            for (k, set) in sets.iter().enumerate() {
                if set >> a & 1 == 1 && set >> b & 1 == 0 {
                    put(2 * n + k, j, -1.0);
                }
            }
            put(2 * n + cuts + j, j, -1.0);
        }
        let matrix = CscMatrix::new_from_triplets(rows, m, is, js, vs);
        let mut b = vec![1.0; 2 * n];
        b.extend(vec![-1.0; cuts]);
        b.extend(vec![0.0; m]);
        let cones = [ZeroConeT(2 * n), NonnegativeConeT(cuts + m)];
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .build()
            .unwrap();
        let p = CscMatrix::zeros((m, m));
        let mut solver = DefaultSolver::new(&p, &q, &matrix, &b, &cones, settings).unwrap();
        solver.solve();
        assert!(matches!(
            solver.solution.status,
            SolverStatus::Solved | SolverStatus::AlmostSolved
        ));
        let mut flow = vec![0.0; n * n];
        for (x, &(a, b)) in solver.solution.x.iter().zip(&arcs) {
            flow[a * n + b] = *x;
        }
        (solver.solution.obj_val, flow)
    }

    /// Adds the most violated set until none is.
    fn subtour_bound(costs: &CostMatrix) -> f64 {
        let n = costs.len();
        let mut sets = Vec::new();
        loop {
            let (value, flow) = program(costs, &sets);
            let out = |set: usize| -> f64 {
                (0..n * n)
                    .filter(|&k| set >> (k / n) & 1 == 1 && set >> (k % n) & 1 == 0)
                    .map(|k| flow[k])
                    .sum()
            };
            // Sets without node 0: for equal degrees as much leaves a set as leaves the rest.
            let worst = (2..1usize << n)
                .step_by(2)
                .filter(|s| s.count_ones() >= 2)
                .min_by(|&a, &b| out(a).total_cmp(&out(b)))
                .unwrap();
            if out(worst) > 1.0 - 1e-6 {
                return value;
            }
            sets.push(worst);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]

        #[test]
        fn bounds_stand_in_their_order(
            points in prop::collection::vec((0.0..10.0f64, 0.0..10.0f64), 9),
            extra in prop::collection::vec(0.0..3.0f64, 81),
        ) {
            let rows: Vec<Vec<f64>> = (0..9).map(|a| (0..9).map(|b| {
                let ((ax, ay), (bx, by)): ((f64, f64), (f64, f64)) = (points[a], points[b]);
                (ax - bx).hypot(ay - by) + extra[a * 9 + b]
            }).collect()).collect();
            let costs = CostMatrix::from_rows(&rows).unwrap();
            let bound = |proof| {
                let params = Params { exact_nodes: 8, kicks: 200, seed: 1, proof };
                solve(&costs, Problem::Closed, &params).unwrap()
            };
            let plain = bound(Proof::Assignment);
            let ascent = bound(Proof::Effort { steps: 2000, branches: 0 });
            let linear = subtour_bound(&costs);
            let best = dynamic(&costs);
            prop_assert!(linear <= best + 1e-6);
            prop_assert!(plain.lower_bound.unwrap() <= linear + 1e-6);
            prop_assert!(plain.lower_bound.unwrap() <= ascent.lower_bound.unwrap() + 1e-9);
            prop_assert!(ascent.lower_bound.unwrap() <= linear + 1e-6);
            // The ascent's limit is the program's value: two per cent is what a stalled ascent may leave.
            prop_assert!(ascent.lower_bound.unwrap() >= 0.98 * linear, "{:?} {linear}", ascent.lower_bound);
        }
    }
}

/// Optima of TSPLIB, where the data are.
#[cfg(feature = "tsplib")]
#[test]
fn published_optima_are_reached() {
    let folder =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/tsplib-atsp");
    let Ok(known) = std::fs::read_to_string(folder.join("optima.json")) else {
        println!("skipped: no {}", folder.display());
        return;
    };
    let known: serde_json::Value = serde_json::from_str(&known).unwrap();
    for (name, optimum) in known.as_object().unwrap() {
        let text = std::fs::read_to_string(folder.join(format!("{name}.atsp"))).unwrap();
        let costs = atsp::tsplib::parse(&text).unwrap().costs;
        let params = Params {
            kicks: 20_000,
            ..Params::default()
        };
        let found = solve(&costs, Problem::Closed, &params).unwrap();
        assert_eq!(found.cost, optimum.as_f64().unwrap(), "{name}");
        assert!(found.lower_bound.unwrap() <= found.cost);
        assert_eq!(found.optimal, found.gap() == Some(0.0));
        assert!(
            found.optimal || !name.starts_with("rbg"),
            "{name} is proved by its assignment"
        );
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
