//! One named case for each thing that goes wrong.
#![allow(missing_docs, clippy::unwrap_used)]

use ddp_rbf::nalgebra::{SMatrix, SVector, vector};
use ddp_rbf::{
    Barrier, Constraint, Error, GuardParams, InputBox, Mpc, Options, Robot, Solver, Tracking,
    Verdict, check_jacobians, guard, ode,
};

/// One integrator; `wrong` spoils its Jacobian.
struct Integrator {
    wrong: f64,
}

impl Robot<1, 1> for Integrator {
    fn flow(&self, _: &SVector<f64, 1>, u: &SVector<f64, 1>) -> SVector<f64, 1> {
        *u
    }
    fn jacobians(
        &self,
        _: &SVector<f64, 1>,
        _: &SVector<f64, 1>,
    ) -> (SMatrix<f64, 1, 1>, SMatrix<f64, 1, 1>) {
        (SMatrix::zeros(), SMatrix::from_element(1.0 + self.wrong))
    }
}

const GOOD: Integrator = Integrator { wrong: 0.0 };

fn cost(n: usize) -> Tracking<1, 1> {
    Tracking::new(
        vec![vector![1.0]; n + 1],
        vec![vector![0.0]; n],
        0.1,
        vector![1.0],
        vector![0.1],
        vector![1.0],
    )
}

fn none<'a>() -> [&'a dyn Constraint<1, 1>; 0] {
    []
}

#[test]
fn horizons_and_steps_must_make_sense() {
    assert_eq!(Solver::<1, 1>::new(0, 0.1).err(), Some(Error::NoKnots));
    assert_eq!(
        Solver::<1, 1>::new(5, 0.0).err(),
        Some(Error::Param {
            field: "dt",
            value: 0.0
        })
    );
    assert!(matches!(
        Solver::<1, 1>::new(5, f64::NAN).err(),
        Some(Error::Param { field: "dt", .. })
    ));
}

#[test]
fn nan_in_the_state_is_named_and_the_plan_survives() {
    let mut mpc = Mpc::new(5, 0.1).unwrap();
    mpc.step(&GOOD, &cost(5), &none(), &vector![0.0], &Options::default())
        .unwrap();
    let plan = mpc.inputs().to_vec();
    let error = mpc.step(
        &GOOD,
        &cost(5),
        &none(),
        &vector![f64::NAN],
        &Options::default(),
    );
    assert_eq!(
        error.err(),
        Some(Error::NotFinite {
            what: "x0",
            knot: 0,
            entry: 0
        })
    );
    assert_eq!(mpc.inputs(), plan);
}

#[test]
fn short_references_are_refused() {
    let mut mpc = Mpc::new(8, 0.1).unwrap();
    let error = mpc.step(&GOOD, &cost(5), &none(), &vector![0.0], &Options::default());
    assert_eq!(
        error.err(),
        Some(Error::TooShort {
            what: "reference",
            given: 5,
            needed: 8
        })
    );
}

#[test]
fn bad_guesses_are_refused() {
    let mut solver = Solver::<1, 1>::new(3, 0.1).unwrap();
    assert!(matches!(
        solver.set_guess(&[vector![0.0]; 3], &[vector![0.0]; 3]),
        Err(Error::TooShort { .. })
    ));
    let states = [
        vector![0.0],
        vector![f64::INFINITY],
        vector![0.0],
        vector![0.0],
    ];
    assert_eq!(
        solver.set_guess(&states, &[vector![0.0]; 3]),
        Err(Error::NotFinite {
            what: "guess of states",
            knot: 1,
            entry: 0
        })
    );
}

#[test]
fn bad_barriers_are_refused() {
    for barrier in [
        Barrier {
            mu: 0.0,
            ..Barrier::default()
        },
        Barrier {
            delta: -1.0,
            ..Barrier::default()
        },
        Barrier::default().until(1e-9),
    ] {
        let limits = InputBox::new(vector![-1.0], vector![1.0], barrier);
        let constraints: [&dyn Constraint<1, 1>; 1] = [&limits];
        let mut solver = Solver::new(5, 0.1).unwrap();
        let error = solver.solve(
            &GOOD,
            &cost(5),
            &constraints,
            &vector![0.0],
            &Options::default(),
        );
        assert!(matches!(error, Err(Error::Param { .. })), "{barrier:?}");
    }
}

#[test]
fn wrong_jacobians_are_named() {
    let error = check_jacobians(
        &Integrator { wrong: 0.5 },
        &vector![0.0],
        &vector![0.0],
        1e-6,
    );
    assert!(
        matches!(
            error,
            Err(Error::Jacobian {
                row: 0,
                column: 1,
                ..
            })
        ),
        "{error:?}"
    );
}

#[test]
fn a_start_in_violation_recovers() {
    // The guess asks for twice the limit.
    let limits = InputBox::new(vector![-1.0], vector![1.0], Barrier::default());
    let constraints: [&dyn Constraint<1, 1>; 1] = [&limits];
    let mut solver = Solver::new(5, 0.1).unwrap();
    solver
        .set_guess(&[vector![0.0]; 6], &[vector![2.0]; 5])
        .unwrap();
    solver
        .solve(
            &GOOD,
            &cost(5),
            &constraints,
            &vector![0.0],
            &Options::default(),
        )
        .unwrap();
    assert!(solver.inputs().iter().all(|u| u[0].abs() < 1.0));
}

#[test]
fn no_iterations_keep_the_guess() {
    let mut solver = Solver::new(3, 0.1).unwrap();
    solver
        .set_guess(&[vector![0.0]; 4], &[vector![0.7]; 3])
        .unwrap();
    let options = Options {
        iterations: 0,
        ..Options::default()
    };
    solver
        .solve(&GOOD, &cost(3), &none(), &vector![0.0], &options)
        .unwrap();
    assert_eq!(solver.inputs(), [vector![0.7]; 3]);
}

#[test]
fn exploding_flows_end_the_integration() {
    struct Explodes;
    impl Robot<1, 1> for Explodes {
        fn flow(&self, x: &SVector<f64, 1>, _: &SVector<f64, 1>) -> SVector<f64, 1> {
            vector![x[0] * x[0]]
        }
        fn jacobians(
            &self,
            x: &SVector<f64, 1>,
            _: &SVector<f64, 1>,
        ) -> (SMatrix<f64, 1, 1>, SMatrix<f64, 1, 1>) {
            (SMatrix::from_element(2.0 * x[0]), SMatrix::zeros())
        }
    }
    // x' = x^2 from 1 is infinite at t = 1.
    assert!(
        !ode::dormand_prince(&Explodes, &vector![1.0], &vector![0.0], 2.0, 1e-6, 10_000).finished
    );
}

#[test]
fn commands_that_are_not_finite_are_braked() {
    let params = GuardParams {
        acceleration: vector![1.0],
        period: 0.1,
        look: 0.05,
        margin: 0.0,
    };
    let (u, verdict) = guard(
        &vector![0.0],
        &vector![0.5],
        &vector![f64::NAN],
        &params,
        |x: &SVector<f64, 1>, u, dt| x + u * dt,
        |_| 1.0,
    );
    assert_eq!((u, verdict), (vector![0.0], Verdict::Braked));
}

#[test]
fn a_state_below_the_margin_may_leave_but_not_get_closer() {
    let params = GuardParams {
        acceleration: vector![1.0],
        period: 0.1,
        look: 0.05,
        margin: 0.5,
    };
    let run = |command: f64| {
        guard(
            &vector![0.8],
            &vector![0.0],
            &vector![command],
            &params,
            |x: &SVector<f64, 1>, u, dt| x + u * dt,
            |x| 1.0 - x[0],
        )
        .1
    };
    assert_eq!(run(-0.5), Verdict::Accepted);
    assert_eq!(run(0.5), Verdict::Braked);
}
