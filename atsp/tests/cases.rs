//! One named case for each thing that goes wrong.
#![allow(missing_docs, clippy::unwrap_used)]

use atsp::{
    CostMatrix, Decision, Error, FromFn, Params, Place, Problem, Proof, Solver, Watch, solve,
    solve_from, two_level,
};

const P: Params = Params {
    exact_nodes: 12,
    kicks: 100,
    seed: 1,
    proof: Proof::Quick,
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

#[test]
fn minus_infinity_is_named() {
    let costs = FromFn::new(9, |a, b| {
        if (a, b) == (4, 0) {
            f64::NEG_INFINITY
        } else {
            1.0
        }
    });
    let wanted = Error::BadCost {
        from: 4,
        to: 0,
        cost: f64::NEG_INFINITY,
    };
    assert_eq!(solve(&costs, Problem::Closed, &P), Err(wanted.clone()));
    // Into the fixed end, which is no closed node of its own.
    assert_eq!(
        solve(&costs, Problem::Path { start: 2, end: 0 }, &P),
        Err(wanted)
    );
    // The way back to the start of an open path is never driven.
    assert!(solve(&costs, Problem::Open { start: 0 }, &P).is_ok());
}

#[test]
fn a_nan_of_thirty_nodes_is_named_whatever_the_form() {
    let costs = FromFn::new(30, |a, b| if (a, b) == (7, 9) { f64::NAN } else { 1.0 });
    for problem in [
        Problem::Closed,
        Problem::Open { start: 3 },
        Problem::Path { start: 1, end: 2 },
    ] {
        match solve(&costs, problem, &P) {
            Err(Error::BadCost { from: 7, to: 9, .. }) => {}
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn negative_costs_are_allowed() {
    // Against the only cheap direction round: -1 each step, 20 nodes.
    let costs = FromFn::new(20, |a, b| if b == (a + 1) % 20 { -1.0 } else { 5.0 });
    let found = solve(&costs, Problem::Closed, &P).unwrap();
    assert_eq!((found.cost, found.optimal), (-20.0, true));
    assert_eq!(found.lower_bound, Some(-20.0));
}

#[test]
fn negative_and_nan_times_of_a_decision_are_named() {
    let decision = Decision {
        current: 0,
        regions: 1,
        region_of: &[0, 0],
    };
    for bad in [-1.0, f64::NAN] {
        let seconds = |a, b| {
            if (a, b) == (Place::Candidate(1), Place::Candidate(0)) {
                bad
            } else {
                1.0
            }
        };
        match two_level(&decision, seconds, &P) {
            Err(Error::BadTime { from, to, .. }) => {
                assert_eq!((from, to), (Place::Candidate(1), Place::Candidate(0)));
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn no_time_still_answers() {
    let costs = FromFn::new(300, |a, b| ((a * 7 + b * 13) % 101) as f64);
    for problem in [
        Problem::Closed,
        Problem::Open { start: 5 },
        Problem::Path { start: 5, end: 9 },
    ] {
        let found = Solver::new()
            .solve_watched(&costs, problem, &[], &P, &mut || true)
            .unwrap();
        let mut sorted = found.order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..300).collect::<Vec<_>>());
        assert!(!found.optimal);
        assert_eq!(found.lower_bound, None);
    }
}

#[test]
fn no_time_still_finds_the_only_order() {
    // Backwards along a chain: the first orders at hand all use forbidden arcs.
    let costs = FromFn::new(60, |a, b| if a == b + 1 { 1.0 } else { f64::INFINITY });
    let found = Solver::new()
        .solve_watched(&costs, Problem::Open { start: 59 }, &[], &P, &mut || true)
        .unwrap();
    assert_eq!(found.order, (0..60).rev().collect::<Vec<_>>());
}

#[test]
fn no_time_and_no_order_is_infeasible() {
    let costs = FromFn::new(40, |_, b| if b == 2 { f64::INFINITY } else { 1.0 });
    let found = Solver::new().solve_watched(&costs, Problem::Closed, &[], &P, &mut || true);
    assert_eq!(found, Err(Error::Infeasible));
}

#[test]
fn two_islands_are_never_a_tour() {
    // Every node has arcs in and out, and the assignment problem is feasible: only a tour is not.
    for n in [6, 12, 30] {
        let costs = FromFn::new(n, |a, b| {
            if (a < n / 2) == (b < n / 2) {
                1.0
            } else {
                f64::INFINITY
            }
        });
        assert_eq!(
            solve(&costs, Problem::Closed, &P),
            Err(Error::Infeasible),
            "{n}"
        );
    }
}

#[test]
fn zero_and_equal_costs_are_proved() {
    for cost in [0.0, 7.5] {
        let costs = FromFn::new(40, |_, _| cost);
        let found = solve(&costs, Problem::Closed, &P).unwrap();
        assert_eq!((found.cost, found.optimal), (40.0 * cost, true));
        assert_eq!(found.gap(), Some(0.0));
    }
}

#[test]
fn improvements_are_told_in_order() {
    struct Steps(Vec<f64>);
    impl Watch for Steps {
        fn stop(&mut self) -> bool {
            false
        }
        fn improved(&mut self, cost: f64) {
            self.0.push(cost);
        }
    }
    let costs = FromFn::new(80, |a, b| ((a * 37 + b * 91) % 127) as f64 - 10.0);
    let mut steps = Steps(Vec::new());
    let found = Solver::new()
        .solve_watched(&costs, Problem::Closed, &[], &P, &mut steps)
        .unwrap();
    assert!(steps.0.windows(2).all(|pair| pair[1] < pair[0]));
    assert!((steps.0[steps.0.len() - 1] - found.cost).abs() < 1e-9);
}

#[test]
fn a_closed_hint_keeps_its_turn() {
    // The hint goes round from node 3; read from node 0 it must stay the same round.
    let n = 40;
    let costs = FromFn::new(n, |a, b| if b == (a + n - 1) % n { 1.0 } else { 50.0 });
    let hint: Vec<usize> = (0..n).map(|k| (n + 3 - k) % n).collect();
    let found = Solver::new()
        .solve_watched(&costs, Problem::Closed, &hint, &P, &mut || true)
        .unwrap();
    assert_eq!(found.cost, n as f64);
}

#[cfg(feature = "tsplib")]
mod tsplib {
    use atsp::tsplib::{ParseError, parse};

    const HEAD: &str = "NAME: x\nTYPE: ATSP\nDIMENSION: 2\nEDGE_WEIGHT_TYPE: EXPLICIT\nEDGE_WEIGHT_FORMAT: FULL_MATRIX\n";

    fn with(matrix: &str) -> Result<atsp::tsplib::Instance, ParseError> {
        parse(&format!("{HEAD}EDGE_WEIGHT_SECTION\n{matrix}"))
    }

    #[test]
    fn rows_may_wrap_and_the_end_mark_may_be_missing() {
        let wrapped = with("0\n 5 6\n\n0").unwrap();
        assert_eq!(wrapped, with("0 5\n6 0\nEOF\n").unwrap());
    }

    #[test]
    fn wrong_counts_are_named() {
        let wrong = |found| Err(ParseError::WrongCount { found, wanted: 4 });
        assert_eq!(with("0 1 2\nEOF"), wrong(3));
        assert_eq!(with("0 1 2 3 4"), wrong(5));
    }

    #[test]
    fn words_and_nans_are_named_with_their_line() {
        for word in ["x", "nan", "inf"] {
            assert_eq!(
                with(&format!("0 1\n{word} 0\n")),
                Err(ParseError::BadWeight {
                    line: 8,
                    text: word.to_owned()
                })
            );
        }
    }

    #[test]
    fn missing_and_unknown_heads_are_named() {
        assert_eq!(parse(""), Err(ParseError::Missing { key: "TYPE" }));
        assert_eq!(
            parse(HEAD),
            Err(ParseError::Missing {
                key: "EDGE_WEIGHT_SECTION"
            })
        );
        for (from, to, key) in [
            ("ATSP", "CVRP", "TYPE"),
            ("EXPLICIT", "EUC_2D", "EDGE_WEIGHT_TYPE"),
            ("FULL_MATRIX", "UPPER_ROW", "EDGE_WEIGHT_FORMAT"),
            ("DIMENSION: 2", "DIMENSION: -2", "DIMENSION"),
            ("DIMENSION: 2", "DIMENSION: 99999999", "DIMENSION"),
        ] {
            match parse(&HEAD.replace(from, to)) {
                Err(ParseError::Unsupported { key: named, .. }) => assert_eq!(named, key),
                other => panic!("{to}: {other:?}"),
            }
        }
    }
}
