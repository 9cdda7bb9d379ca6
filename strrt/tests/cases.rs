//! One named case for each thing that goes wrong, and for each thing promised.
#![allow(missing_docs, clippy::unwrap_used)]

use std::cell::Cell;
use strrt::{
    Error, Params, Plan, Planner, Reason, Robot, Status, Variant, from_batch_fn, from_fn,
    peak_acceleration, plan, smooth, straight,
};

fn free() -> impl Robot<2> {
    from_fn([(-3.0, 3.0); 2], [1.0; 2], |_: &[f64; 2], _| true)
}

fn defaults() -> Params {
    Params::default()
}

fn error<const N: usize>(result: Result<Plan<N>, Error>) -> Error {
    result.unwrap_err()
}

#[test]
fn no_steps() {
    let found = plan(&free(), [0.0; 2], [1.0; 2], 0, 0.1, &defaults(), 0);
    assert_eq!(error(found), Error::NoSteps);
}

#[test]
fn bad_time_steps() {
    for dt in [0.0, -0.1, f64::INFINITY] {
        let found = plan(&free(), [0.0; 2], [1.0; 2], 9, dt, &defaults(), 0);
        assert_eq!(error(found), Error::TimeStep(dt));
    }
    let found = plan(&free(), [0.0; 2], [1.0; 2], 9, f64::NAN, &defaults(), 0);
    assert!(matches!(error(found), Error::TimeStep(_)));
}

#[test]
fn limits_the_wrong_way_round() {
    let arm = from_fn([(1.0, -1.0)], [1.0], |_: &[f64; 1], _| true);
    let found = plan(&arm, [0.0], [0.0], 9, 0.1, &defaults(), 0);
    assert_eq!(
        error(found),
        Error::Limits {
            joint: 0,
            low: 1.0,
            high: -1.0
        }
    );
}

#[test]
fn joints_that_cannot_move() {
    let arm = from_fn([(-1.0, 1.0)], [0.0], |_: &[f64; 1], _| true);
    let found = plan(&arm, [0.0], [0.0], 9, 0.1, &defaults(), 0);
    assert_eq!(
        error(found),
        Error::Speed {
            joint: 0,
            speed: 0.0
        }
    );
}

#[test]
fn ends_outside_the_limits() {
    let found = plan(&free(), [0.0, 4.0], [0.0; 2], 9, 0.1, &defaults(), 0);
    assert!(matches!(
        error(found),
        Error::OutsideLimits {
            which: "start",
            joint: 1,
            ..
        }
    ));
    let found = plan(&free(), [0.0; 2], [f64::NAN, 0.0], 9, 0.1, &defaults(), 0);
    assert!(matches!(
        error(found),
        Error::OutsideLimits {
            which: "goal",
            joint: 0,
            ..
        }
    ));
}

#[test]
fn bad_parameters_are_named() {
    let cases = [
        (
            "goal_bias",
            Params {
                goal_bias: 1.5,
                ..defaults()
            },
        ),
        (
            "slack",
            Params {
                slack: f64::NAN,
                ..defaults()
            },
        ),
        (
            "max_wait",
            Params {
                max_wait: usize::MAX,
                ..defaults()
            },
        ),
        (
            "acceleration",
            Params {
                acceleration: Some(0.0),
                ..defaults()
            },
        ),
    ];
    for (name, params) in cases {
        let found = plan(&free(), [0.0; 2], [1.0; 2], 9, 0.1, &params, 0);
        let Error::Param { field, .. } = error(found) else {
            panic!("{name} was taken");
        };
        assert_eq!(field, name);
    }
}

fn reason<const N: usize>(
    arm: &impl Robot<N>,
    start: [f64; N],
    goal: [f64; N],
    params: &Params,
) -> (Status, Option<Reason>) {
    let found = plan(arm, start, goal, 10, 0.1, params, 0).unwrap();
    assert!(found.path.is_empty());
    (found.status, found.reason)
}

#[test]
fn blocked_ends() {
    let arm = from_fn([(-3.0, 3.0)], [1.0], |q: &[f64; 1], _| q[0].abs() > 0.5);
    let blocked = reason(&arm, [0.0], [1.0], &defaults());
    assert_eq!(blocked, (Status::Infeasible, Some(Reason::StartInvalid)));
    let blocked = reason(&arm, [1.0], [0.0], &defaults());
    assert_eq!(blocked, (Status::Infeasible, Some(Reason::GoalInvalid)));
}

#[test]
fn blocked_base() {
    struct Stuck;
    impl Robot<1> for Stuck {
        fn limits(&self) -> [(f64, f64); 1] {
            [(-1.0, 1.0)]
        }
        fn max_speed(&self) -> [f64; 1] {
            [1.0]
        }
        fn is_valid(&self, _: &[f64; 1], step: usize) -> bool {
            step != 4
        }
        fn base_is_valid(&self, step: usize) -> bool {
            step != 4
        }
    }
    let blocked = reason(&Stuck, [0.0], [0.5], &defaults());
    assert_eq!(
        blocked,
        (Status::Infeasible, Some(Reason::BaseBlocked { step: 4 }))
    );
}

#[test]
fn too_far_without_waiting() {
    let params = Params {
        max_wait: 0,
        ..defaults()
    };
    let far = reason(&free(), [-2.0; 2], [2.0; 2], &params);
    let expected = Reason::TooFar {
        needed: 40,
        available: 9,
    };
    assert_eq!(far, (Status::Infeasible, Some(expected)));
}

#[test]
fn a_wall_exhausts_the_samples() {
    let arm = from_fn([(-3.0, 3.0)], [1.0], |q: &[f64; 1], _| q[0].abs() > 0.5);
    for variant in [
        Variant::Published,
        Variant::MultiStep,
        Variant::Bidirectional,
    ] {
        let params = Params {
            variant,
            iterations: 200,
            ..defaults()
        };
        let found = plan(&arm, [-1.0], [1.0], 40, 0.1, &params, 0).unwrap();
        assert_eq!(found.status, Status::BudgetExhausted);
        assert!(matches!(found.reason, Some(Reason::NotFound { .. })));
        assert_eq!(found.iterations, 200);
    }
}

#[test]
fn no_samples_still_drive_straight() {
    let params = Params {
        iterations: 0,
        ..defaults()
    };
    let found = plan(&free(), [0.0; 2], [0.5; 2], 10, 0.1, &params, 0).unwrap();
    assert_eq!(found.status, Status::Solved);
}

#[test]
fn one_step_is_enough_to_stay() {
    let found = plan(&free(), [0.3; 2], [0.3; 2], 1, 0.1, &defaults(), 0).unwrap();
    assert_eq!(found.path, [[0.3; 2]]);
    assert_eq!(found.cost, 0.0);
}

#[test]
fn a_short_drive_waits_at_its_end() {
    let found = plan(&free(), [0.0; 2], [2.0, 0.0], 5, 0.1, &defaults(), 0).unwrap();
    assert_eq!(found.status, Status::Solved);
    assert_eq!(found.waited_before, 0);
    assert_eq!(
        found.waited_after,
        22 - 4,
        "20 steps of motion and a tenth more"
    );
    assert_eq!(found.path.len(), 5 + found.waited_after);
}

#[test]
fn who_must_fold_first_waits_at_the_start() {
    // From the second pose on, only folded arms fit.
    let arm = from_fn([(0.0, 3.0)], [1.0], |q: &[f64; 1], step| {
        step == 0 || q[0] < 0.5
    });
    let found = plan(&arm, [2.0], [0.2], 30, 0.1, &defaults(), 0).unwrap();
    assert_eq!(found.status, Status::Solved);
    assert!(found.waited_before >= 15, "{found:?}");
}

#[test]
fn early_and_late_straight_motions_cost_no_samples() {
    for gate in [5..9, 28..34] {
        // Either nobody above 1.0 or nobody below it passes the gate.
        let early = gate.start > 20;
        let arm = from_fn([(0.0, 3.0)], [1.0], move |q: &[f64; 1], step| {
            !gate.contains(&step) || (q[0] > 1.5) == early
        });
        let found = plan(&arm, [0.5], [2.0], 40, 0.1, &defaults(), 0).unwrap();
        assert_eq!((found.status, found.iterations), (Status::Solved, 0));
        assert!((found.cost - 1.5).abs() < 1e-9);
    }
}

#[test]
fn a_start_that_the_map_overran_may_leave() {
    let arm = from_fn([(-3.0, 3.0)], [1.0], |q: &[f64; 1], _| q[0] > 0.25);
    let params = Params {
        start_grace: 8,
        ..defaults()
    };
    let found = plan(&arm, [0.0], [1.0], 30, 0.1, &params, 0).unwrap();
    assert_eq!(found.status, Status::Solved);
    assert!(found.path[8..].iter().all(|q| q[0] > 0.25));
    let calm = smooth(&arm, &found, 0.1, 2.0).unwrap();
    assert!(calm.path[8..].iter().all(|q| q[0] > 0.25));
}

#[test]
fn leaving_never_goes_deeper() {
    // Out of the slab is near on the left; the goal is on the right, farther than the grace lasts.
    struct Slab;
    impl Robot<1> for Slab {
        fn limits(&self) -> [(f64, f64); 1] {
            [(-3.0, 3.0)]
        }
        fn max_speed(&self) -> [f64; 1] {
            [1.0]
        }
        fn is_valid(&self, q: &[f64; 1], step: usize) -> bool {
            self.depth(q, step) == 0.0
        }
        fn depth(&self, q: &[f64; 1], step: usize) -> f64 {
            // The slab goes away after step 20.
            if step > 20 {
                0.0
            } else {
                (0.5 - (q[0] - 0.4).abs()).max(0.0)
            }
        }
    }
    let params = Params {
        start_grace: 6,
        ..defaults()
    };
    let found = plan(&Slab, [0.0], [1.0], 60, 0.1, &params, 0).unwrap();
    assert_eq!(found.status, Status::Solved);
    let mut before = f64::INFINITY;
    for (step, q) in found.path.iter().enumerate() {
        let depth = Slab.depth(q, step.saturating_sub(found.waited_before).min(59));
        assert!(depth <= before);
        before = depth;
    }
    assert_eq!(before, 0.0);
}

#[test]
fn batches_are_asked_for_and_change_nothing() {
    let gate = |q: &[f64; 2], step: usize| !(15..25).contains(&step) || q[0].hypot(q[1]) > 1.0;
    let one = from_fn([(-3.0, 3.0); 2], [1.0; 2], gate);
    let widest = Cell::new(0);
    let many = from_batch_fn(
        [(-3.0, 3.0); 2],
        [1.0; 2],
        8,
        |states: &[[f64; 2]], steps: &[usize]| {
            assert_eq!(states.len(), steps.len());
            widest.set(widest.get().max(states.len()));
            states.iter().zip(steps).all(|(q, &s)| gate(q, s))
        },
    );
    let run = |arm: &dyn Robot<2>| {
        let mut found = plan(&arm, [-1.5, 0.0], [1.5, 0.1], 41, 0.1, &defaults(), 5).unwrap();
        found.checks = 0;
        found
    };
    assert_eq!(run(&one), run(&many));
    assert!(widest.get() >= 8);
}

#[test]
fn straight_is_none_when_too_fast_or_blocked() {
    assert_eq!(
        straight(&free(), [0.0; 2], [2.0; 2], 10, 0.1).unwrap(),
        None
    );
    let arm = from_fn([(-3.0, 3.0)], [1.0], |_: &[f64; 1], step| step != 5);
    assert_eq!(straight(&arm, [0.0], [0.5], 10, 0.1).unwrap(), None);
}

#[test]
fn accelerations_are_kept_where_there_is_time() {
    let params = Params {
        acceleration: Some(2.0),
        ..defaults()
    };
    let arm = from_fn([(-3.0, 3.0); 6], [0.8; 6], |_: &[f64; 6], _| true);
    let found = plan(&arm, [0.0; 6], [1.6; 6], 3, 0.1, &params, 0).unwrap();
    // 2.0 s at top speed, and 0.4 s to speed up and slow down.
    assert_eq!(found.path.len() - 1, 24);
    assert!(peak_acceleration(&found.path, 0.1) <= 2.0 + 1e-6);
}

#[test]
fn nothing_to_smooth_is_refused() {
    let none = plan(
        &from_fn([(-3.0, 3.0)], [1.0], |_: &[f64; 1], s| s != 0),
        [0.0],
        [1.0],
        5,
        0.1,
        &defaults(),
        0,
    )
    .unwrap();
    assert_eq!(
        smooth(
            &from_fn([(-3.0, 3.0)], [1.0], |_: &[f64; 1], _| true),
            &none,
            0.1,
            2.0
        ),
        Err(Error::Path)
    );
}

#[test]
fn a_finished_planner_does_nothing_more() {
    let arm = free();
    let mut planner = Planner::new(&arm, [0.0; 2], [0.5; 2], 10, 0.1, &defaults(), 0).unwrap();
    assert_eq!(planner.step(100), 0);
    assert_eq!(planner.iterations(), 0);
}

/// Tests run in debug and in release: both must find these very numbers.
#[test]
fn debug_and_release_plan_the_same() {
    let arm = from_fn([(-2.0, 2.0); 2], [0.8; 2], |q: &[f64; 2], _| {
        q[0].abs() > 0.4 || q[1] > 0.9
    });
    let mut seen = Vec::new();
    for variant in [
        Variant::Published,
        Variant::MultiStep,
        Variant::Bidirectional,
    ] {
        let params = Params {
            variant,
            ..defaults()
        };
        let p = plan(&arm, [-1.2, 0.3], [1.2, -0.2], 60, 0.1, &params, 5).unwrap();
        seen.push((p.iterations, p.checks, (p.cost * 1e9).round() / 1e9));
    }
    // One step at a time does not get round within 2000 samples.
    assert_eq!(
        seen,
        [
            (2000, 3433, f64::INFINITY),
            (423, 4939, 3.223825407),
            (204, 2702, 3.190382057)
        ]
    );
}
