//! Properties that hold for any costs.
#![allow(missing_docs, clippy::unwrap_used)]

use atsp::{
    CostMatrix, CostModel, Decision, FromFn, Params, Place, Problem, Proof, Solver, solve,
    solve_from, two_level,
};
use proptest::prelude::*;

/// Square matrices with about `forbidden` per cent infinite arcs.
fn matrices(nodes: std::ops::Range<usize>, forbidden: u32) -> impl Strategy<Value = CostMatrix> {
    nodes
        .prop_flat_map(move |n| {
            let cost = (0.0..100.0f64, 0..100u32)
                .prop_map(move |(c, roll)| if roll < forbidden { f64::INFINITY } else { c });
            prop::collection::vec(prop::collection::vec(cost, n), n)
        })
        .prop_map(|rows| CostMatrix::from_rows(&rows).unwrap())
}

fn problem(n: usize, form: u32, start: usize, end: usize) -> Problem {
    match form {
        0 => Problem::Closed,
        1 => Problem::Open { start: start % n },
        _ => Problem::Path {
            start: start % n,
            end: end % n,
        },
    }
}

fn cost_of(costs: &CostMatrix, problem: Problem, order: &[usize]) -> f64 {
    let closes = match problem {
        Problem::Closed => true,
        Problem::Open { .. } => false,
        Problem::Path { start, end } => start == end,
    };
    let back = if closes && order.len() > 1 {
        costs.cost(order[order.len() - 1], order[0])
    } else {
        0.0
    };
    costs.along(order) + back
}

/// A path from the first to the last node along a hint: strangers and repetitions dropped, what lacks put where it costs
/// least, lowest first.
fn repaired(costs: &CostMatrix, hint: &[usize]) -> Vec<usize> {
    let n = costs.len();
    let mut order = vec![0];
    for &node in hint {
        if (1..n - 1).contains(&node) && !order.contains(&node) {
            order.push(node);
        }
    }
    order.push(n - 1);
    for node in 1..n - 1 {
        if !order.contains(&node) {
            let at = (1..order.len())
                .min_by(|&a, &b| {
                    let extra = |i: usize| {
                        costs.cost(order[i - 1], node) + costs.cost(node, order[i])
                            - costs.cost(order[i - 1], order[i])
                    };
                    extra(a).total_cmp(&extra(b))
                })
                .unwrap();
            order.insert(at, node);
        }
    }
    order
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// Every answer is a permutation with the right ends, the cost of its arcs, and not below its bound.
    #[test]
    fn answers_are_valid(costs in matrices(1..40, 10), form in 0..3u32, s in 0..40usize, e in 0..40usize) {
        let n = costs.len();
        let problem = problem(n, form, s, e);
        let params = Params { kicks: 50, ..Params::default() };
        if let Ok(found) = solve(&costs, problem, &params) {
            let mut sorted = found.order.clone();
            sorted.sort_unstable();
            prop_assert_eq!(sorted, (0..n).collect::<Vec<_>>());
            match problem {
                Problem::Closed => prop_assert_eq!(found.order[0], 0),
                Problem::Open { start } => prop_assert_eq!(found.order[0], start),
                Problem::Path { start, end } => {
                    prop_assert_eq!(found.order[0], start);
                    if start != end { prop_assert_eq!(found.order[n - 1], end); }
                }
            }
            prop_assert_eq!(found.cost, cost_of(&costs, problem, &found.order));
            prop_assert!(found.cost.is_finite());
            prop_assert!(found.lower_bound.unwrap() <= found.cost);
            prop_assert_eq!(&solve(&costs, problem, &params).unwrap(), &found);
        }
    }

    /// A closed tour costs the same read from any node, and relabelled sets have the same optimum.
    #[test]
    fn labels_do_not_matter(costs in matrices(3..13, 15), keys in prop::collection::vec(0..1000u32, 13)) {
        let n = costs.len();
        let mut label: Vec<usize> = (0..n).collect();
        label.sort_by_key(|&i| keys[i]);
        let moved = FromFn::new(n, |a, b| costs.cost(label[a], label[b]));
        let p = Params::default();
        match (solve(&costs, Problem::Closed, &p), solve(&moved, Problem::Closed, &p)) {
            (Ok(a), Ok(b)) => {
                prop_assert!((a.cost - b.cost).abs() < 1e-9);
                for turn in 0..n {
                    let mut order = a.order.clone();
                    order.rotate_left(turn);
                    prop_assert!((cost_of(&costs, Problem::Closed, &order) - a.cost).abs() < 1e-9);
                }
            }
            (a, b) => prop_assert_eq!(a.err(), b.err()),
        }
    }

    /// A solver that has worked before answers as a new one does.
    #[test]
    fn reuse_leaves_no_trace(
        first in matrices(1..40, 20),
        second in matrices(1..40, 20),
        form in 0..3u32,
        s in 0..40usize,
        e in 0..40usize,
    ) {
        let params = Params { kicks: 60, proof: Proof::Effort { steps: 20, branches: 20 }, ..Params::default() };
        let mut used = Solver::new();
        let _ = used.solve(&first, problem(first.len(), form, s, e), &params);
        let form = problem(second.len(), form, e, s);
        prop_assert_eq!(used.solve(&second, form, &params), solve(&second, form, &params));
    }

    /// Costs times a power of two give the same order, bound and effort.
    #[test]
    fn scale_does_not_matter(costs in matrices(3..30, 10), power in -40..40i32) {
        let factor = 2f64.powi(power);
        let scaled = FromFn::new(costs.len(), |a, b| costs.cost(a, b) * factor);
        let p = Params { kicks: 80, ..Params::default() };
        match (solve(&costs, Problem::Closed, &p), solve(&scaled, Problem::Closed, &p)) {
            (Ok(a), Ok(b)) => {
                prop_assert_eq!(&a.order, &b.order);
                prop_assert_eq!(a.cost * factor, b.cost);
                prop_assert_eq!(a.lower_bound.map(|l| l * factor), b.lower_bound);
                prop_assert_eq!((a.kicks, a.optimal), (b.kicks, b.optimal));
            }
            (a, b) => prop_assert_eq!(a.err(), b.err()),
        }
    }

    /// Stopped after any number of questions, the answer is whole, and never worse than its repaired hint.
    #[test]
    fn stopped_at_any_time(costs in matrices(9..40, 0), hint in prop::collection::vec(0..60usize, 1..50), after in 0..12u32) {
        let n = costs.len();
        let mut asked = 0;
        let mut stop = || { asked += 1; asked > after };
        let problem = Problem::Path { start: 0, end: n - 1 };
        let params = Params { kicks: 100_000, ..Params::default() };
        let found = Solver::new().solve_watched(&costs, problem, &hint, &params, &mut stop).unwrap();
        prop_assert_eq!(found.cost, cost_of(&costs, problem, &found.order));
        prop_assert!(found.cost <= cost_of(&costs, problem, &repaired(&costs, &hint)) + 1e-9);
    }

    /// The search never ends above its repaired hint, and more kicks never cost more.
    #[test]
    fn effort_never_hurts(costs in matrices(14..40, 0), seed in 0..9u64) {
        let hint: Vec<usize> = (0..costs.len()).rev().collect();
        let few = Params { kicks: 20, seed, ..Params::default() };
        // Enough for restarts from scratch.
        let many = Params { kicks: 1000, ..few };
        let a = solve_from(&costs, Problem::Open { start: 3 }, &hint, &few).unwrap();
        let b = solve_from(&costs, Problem::Open { start: 3 }, &hint, &many).unwrap();
        let repaired: Vec<usize> = std::iter::once(3).chain(hint.into_iter().filter(|&n| n != 3)).collect();
        prop_assert!(a.cost <= costs.along(&repaired) + 1e-9);
        prop_assert!(b.cost <= a.cost + 1e-9);
    }

    /// Without a single kick an earlier order gives nothing dearer than starting cold, and nothing dearer than its repair.
    #[test]
    fn a_hint_never_hurts(costs in matrices(14..40, 0), hint in prop::collection::vec(0..60usize, 1..50)) {
        let problem = Problem::Path { start: 0, end: costs.len() - 1 };
        let params = Params { kicks: 0, proof: Proof::Assignment, ..Params::default() };
        let warm = solve_from(&costs, problem, &hint, &params).unwrap();
        let cold = solve(&costs, problem, &params).unwrap();
        prop_assert!(warm.cost <= cold.cost + 1e-9);
        prop_assert!(warm.cost <= cost_of(&costs, problem, &repaired(&costs, &hint)) + 1e-9);
    }

    /// Adding a constant to a row and to a column shifts the optimum of a closed tour by it.
    #[test]
    fn row_and_column_offsets_shift_the_cost(costs in matrices(3..11, 0), row in 0..11usize, by in -20.0..20.0f64) {
        let n = costs.len();
        let row = row % n;
        let shifted = FromFn::new(n, |a, b| {
            costs.cost(a, b) + if a == row { by } else { 0.0 } + if b == row { 2.0 * by } else { 0.0 }
        });
        let p = Params::default();
        let plain = solve(&costs, Problem::Closed, &p).unwrap().cost;
        let moved = solve(&shifted, Problem::Closed, &p).unwrap().cost;
        prop_assert!((moved - plain - 3.0 * by).abs() < 1e-9);
    }

    /// A path backwards over the transposed costs is as cheap.
    #[test]
    fn transposed_paths_are_equal(costs in matrices(3..11, 0)) {
        let n = costs.len();
        let back = FromFn::new(n, |a, b| costs.cost(b, a));
        let p = Params::default();
        let there = solve(&costs, Problem::Path { start: 0, end: n - 1 }, &p).unwrap().cost;
        let here = solve(&back, Problem::Path { start: n - 1, end: 0 }, &p).unwrap().cost;
        prop_assert!((there - here).abs() < 1e-9);
    }

    /// The decision names a reachable candidate of the current region if there is one, and visits each of them once.
    #[test]
    fn the_decision_stays_in_the_current_region(
        points in prop::collection::vec((0.0..30.0f64, 0.0..20.0f64), 1..20),
        robot in (0.0..30.0f64, 0.0..20.0f64),
    ) {
        // Four regions side by side, 7.5 m wide.
        let region_of: Vec<usize> = points.iter().map(|p| (p.0 / 7.5) as usize).collect();
        let current = (robot.0 / 7.5) as usize;
        let at = |place: Place| match place {
            Place::Robot => robot,
            Place::Candidate(c) => points[c],
            Place::Region(r) => (r as f64 * 7.5 + 3.75, 10.0),
        };
        let seconds = |a: Place, b: Place| {
            let ((ax, ay), (bx, by)) = (at(a), at(b));
            (ax - bx).hypot(ay - by)
        };
        let decision = Decision { current, regions: 4, region_of: &region_of };
        let choice = two_level(&decision, seconds, &Params::default()).unwrap().unwrap();
        let near = region_of.iter().filter(|&&r| r == current).count();
        prop_assert_eq!(choice.viewpoint_order.len(), near);
        if near > 0 {
            prop_assert_eq!(region_of[choice.candidate], current);
            prop_assert_eq!(choice.candidate, choice.viewpoint_order[0]);
        } else {
            prop_assert_eq!(Some(region_of[choice.candidate]), choice.target_region);
        }
        prop_assert_eq!(choice.region_order[0], current);
    }
}
