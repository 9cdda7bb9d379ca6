//! One named case for each thing that goes wrong.
#![allow(missing_docs, clippy::unwrap_used)]

use atsp::{
    CostMatrix, Decision, Error, FromFn, Params, Place, Problem, solve, solve_from, two_level,
};

const P: Params = Params {
    exact_nodes: 12,
    kicks: 100,
    seed: 1,
};

#[test]
fn no_nodes() {
    let none = FromFn::new(0, |_, _| 0.0);
    assert_eq!(solve(&none, Problem::Closed, &P), Err(Error::Empty));
}

#[test]
fn one_and_two_nodes() {
    let one = FromFn::new(1, |_, _| f64::NAN);
    let found = solve(&one, Problem::Path { start: 0, end: 0 }, &P).unwrap();
    assert_eq!(
        (found.order, found.cost, found.optimal),
        (vec![0], 0.0, true)
    );
    let two = FromFn::new(2, |a, _| [3.0, 4.0][a]);
    assert_eq!(solve(&two, Problem::Closed, &P).unwrap().cost, 7.0);
    assert_eq!(
        solve(&two, Problem::Open { start: 1 }, &P).unwrap().cost,
        4.0
    );
    assert_eq!(
        solve(&two, Problem::Path { start: 1, end: 0 }, &P)
            .unwrap()
            .order,
        [1, 0]
    );
}

#[test]
fn nan_is_named() {
    let costs = FromFn::new(3, |a, b| if (a, b) == (1, 2) { f64::NAN } else { 1.0 });
    match solve(&costs, Problem::Closed, &P) {
        Err(Error::BadCost { from: 1, to: 2, .. }) => {}
        other => panic!("{other:?}"),
    }
}

#[test]
fn ragged_rows_are_named() {
    let rows: [&[f64]; 2] = [&[0.0, 1.0], &[1.0]];
    assert_eq!(
        CostMatrix::from_rows(&rows),
        Err(Error::NotSquare {
            row: 1,
            len: 1,
            nodes: 2
        })
    );
}

#[test]
fn ends_outside_are_named() {
    let costs = FromFn::new(3, |_, _| 1.0);
    assert_eq!(
        solve(&costs, Problem::Path { start: 0, end: 3 }, &P),
        Err(Error::OutOfRange {
            what: "end",
            index: 3,
            len: 3
        })
    );
}

#[test]
fn isolated_nodes_are_infeasible_at_every_size() {
    for n in [5, 30] {
        let costs = FromFn::new(n, |_, b| if b == 2 { f64::INFINITY } else { 1.0 });
        assert_eq!(solve(&costs, Problem::Closed, &P), Err(Error::Infeasible));
    }
}

#[test]
fn one_feasible_order_of_thirty_is_found() {
    let costs = FromFn::new(30, |a, b| if b == a + 1 { 1.0 } else { f64::INFINITY });
    let found = solve(&costs, Problem::Open { start: 0 }, &P).unwrap();
    assert_eq!(found.order, (0..30).collect::<Vec<_>>());
    assert!(found.optimal);
}

#[test]
fn zero_effort_still_answers() {
    let costs = FromFn::new(40, |a, b| ((a * 7 + b * 13) % 17) as f64);
    let found = solve(&costs, Problem::Closed, &Params { kicks: 0, ..P }).unwrap();
    assert_eq!(found.order.len(), 40);
}

#[test]
fn huge_and_tiny_costs_keep_their_scale() {
    for scale in [1e-300, 1e300] {
        let costs = FromFn::new(4, |a, b| scale * (1.0 + ((a + 2 * b) % 5) as f64));
        assert!(solve(&costs, Problem::Closed, &P).unwrap().cost > 0.0);
    }
    let costs = FromFn::new(20, |_, _| f64::MAX);
    assert_eq!(solve(&costs, Problem::Closed, &P), Err(Error::Overflow));
}

#[test]
fn hints_may_hold_strangers_and_gaps() {
    let costs = FromFn::new(20, |a, b| (a as f64 - b as f64).abs());
    let found = solve_from(&costs, Problem::Open { start: 0 }, &[99, 4, 4, 2, 0], &P).unwrap();
    assert_eq!(found.cost, 19.0);
}

#[test]
fn unreachable_candidates_are_passed_over() {
    let decision = Decision {
        current: 0,
        regions: 2,
        region_of: &[0, 1, 1],
    };
    let seconds = |a: Place, b: Place| match (a, b) {
        (Place::Robot, Place::Candidate(0)) => f64::INFINITY,
        (Place::Robot, Place::Candidate(c)) => 10.0 - c as f64,
        _ => 1.0,
    };
    let choice = two_level(&decision, seconds, &P).unwrap().unwrap();
    assert_eq!(choice.candidate, 2);
    assert_eq!(choice.target_region, Some(1));
    let nowhere = two_level(&decision, |_, _| f64::INFINITY, &P).unwrap();
    assert_eq!(nowhere, None);
}

#[test]
fn no_candidates_is_no_choice() {
    let decision = Decision {
        current: 0,
        regions: 1,
        region_of: &[],
    };
    assert_eq!(two_level(&decision, |_, _| 1.0, &P), Ok(None));
    let outside = Decision {
        current: 3,
        regions: 1,
        region_of: &[],
    };
    assert!(matches!(
        two_level(&outside, |_, _| 1.0, &P),
        Err(Error::OutOfRange { .. })
    ));
}
