//! One named case for each thing that goes wrong.
#![allow(missing_docs, clippy::unwrap_used)]

use ddp_rbf::nalgebra::{SMatrix, SVector, vector};
use ddp_rbf::{
    Barrier, BoxField, Chain, Constraint, Error, Field, GridField, GuardParams, HalfSpaces,
    InputBox, Joint, LinkSphere, Mpc, Options, PairClearance, Robot, Solver, Tracking, Verdict,
    check_constraint, check_cost, check_jacobians, guard, ode,
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

#[test]
fn models_that_are_not_finite_are_refused() {
    struct Broken;
    impl Robot<1, 1> for Broken {
        fn flow(&self, _: &SVector<f64, 1>, _: &SVector<f64, 1>) -> SVector<f64, 1> {
            vector![f64::NAN]
        }
        fn jacobians(
            &self,
            _: &SVector<f64, 1>,
            _: &SVector<f64, 1>,
        ) -> (SMatrix<f64, 1, 1>, SMatrix<f64, 1, 1>) {
            (SMatrix::zeros(), SMatrix::zeros())
        }
    }
    let mut solver = Solver::new(3, 0.1).unwrap();
    let error = solver.solve(
        &Broken,
        &cost(3),
        &none(),
        &vector![0.5],
        &Options::default(),
    );
    assert!(matches!(error, Err(Error::NotFinite { .. })), "{error:?}");
    // The guess is as it was.
    assert_eq!(solver.states()[0], vector![0.0]);
}

#[test]
fn chains_that_do_not_fit_together_are_refused() {
    let joint = Joint {
        d: 0.1,
        a: 0.0,
        alpha: 0.0,
    };
    let sphere = LinkSphere {
        link: 1,
        center: [0.0; 3],
        radius: 0.1,
    };
    let root = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let make = |joints: Vec<Joint>, spheres: Vec<LinkSphere>| match Chain::new(
        true, root, [0.0; 3], joints, spheres,
    ) {
        Err(Error::Chain { what, index }) => (what, index),
        other => panic!("{other:?}"),
    };
    assert_eq!(
        make(vec![joint; 13], vec![]),
        ("there are more joints than 12", 13)
    );
    assert_eq!(
        make(vec![joint], vec![sphere; 65]),
        ("there are more spheres than 64", 65)
    );
    assert_eq!(
        make(
            vec![joint; 2],
            vec![sphere, LinkSphere { link: 3, ..sphere }]
        ),
        ("a sphere stands on a link that is not there", 1)
    );
    assert_eq!(
        make(
            vec![joint],
            vec![LinkSphere {
                radius: -0.1,
                ..sphere
            }]
        )
        .1,
        0
    );
    assert_eq!(
        make(
            vec![
                joint,
                Joint {
                    d: f64::NAN,
                    ..joint
                }
            ],
            vec![]
        ),
        ("a joint is not finite", 1)
    );
    // A chain of four states does not fit a state of one, and there is no sphere 7.
    let chain = Chain::new(true, root, [0.0; 3], vec![joint], vec![sphere]).unwrap();
    assert!(chain.centers(&[0.0; 2]).is_err());
    let pairs = PairClearance {
        chain: &chain,
        pairs: &[(0, 7)],
        margin: 0.0,
        barrier: Barrier::default(),
        name: "pairs",
    };
    assert!(matches!(
        Constraint::<1, 1>::validate(&pairs),
        Err(Error::Chain { index: 1, .. })
    ));
    assert!(matches!(
        Constraint::<4, 3>::validate(&pairs),
        Err(Error::Chain { index: 7, .. })
    ));
    let mut solver = Solver::new(5, 0.1).unwrap();
    let error = solver.solve(
        &GOOD,
        &cost(5),
        &[&pairs],
        &vector![0.0],
        &Options::default(),
    );
    assert!(matches!(error, Err(Error::Chain { .. })), "{error:?}");
}

#[test]
fn fields_that_make_no_sense_are_refused() {
    assert!(BoxField::new(vec![], None, 50.0).is_err());
    assert!(BoxField::new(vec![[0.0, 0.0, 0.0, 1.0, -1.0, 1.0]], None, 50.0).is_err());
    assert_eq!(
        BoxField::new(vec![], Some(0.0), 0.0).err(),
        Some(Error::Param {
            field: "beta",
            value: 0.0
        })
    );
    assert!(GridField::new([0.0; 3], 0.1, [2, 2, 1], vec![0.0; 4]).is_err());
    assert!(GridField::new([0.0; 3], 0.1, [2, 2, 2], vec![0.0; 7]).is_err());
    assert!(GridField::new([0.0; 3], 0.0, [2, 2, 2], vec![0.0; 8]).is_err());
    assert!(GridField::new([0.0; 3], 0.1, [2, 2, 2], vec![f32::NAN; 8]).is_err());
}

#[test]
fn queries_outside_the_map_lead_back_to_it() {
    let grid = GridField::new([0.0; 3], 0.5, [2, 2, 2], vec![1.0; 8]).unwrap();
    let (distance, gradient) = grid.distance_gradient([2.5, 0.2, 0.2]);
    assert!((distance - (1.0 - 2.0)).abs() < 1e-12);
    assert_eq!(gradient, [-1.0, 0.0, 0.0]);
    assert!(grid.distance([f64::NAN, 0.0, 0.0]).is_nan());
}

#[test]
fn half_spaces_must_be_finite() {
    let bad = vec![(vector![1.0], vector![f64::INFINITY], 0.0)];
    assert_eq!(
        HalfSpaces::new(bad, Barrier::default()).err(),
        Some(Error::NotFinite {
            what: "half-space",
            knot: 0,
            entry: 1
        })
    );
}

#[test]
fn wrong_gradients_of_constraints_are_named() {
    /// z = 2 - x, told with a slope of 1.
    struct Wrong;
    impl Constraint<1, 1> for Wrong {
        fn name(&self) -> &'static str {
            "wrong"
        }
        fn barrier(&self) -> Barrier {
            Barrier::default()
        }
        fn values(
            &self,
            _: usize,
            x: &SVector<f64, 1>,
            _: Option<&SVector<f64, 1>>,
            visit: &mut dyn FnMut(f64),
        ) {
            visit(2.0 - x[0]);
        }
        fn rows(
            &self,
            _: usize,
            x: &SVector<f64, 1>,
            _: Option<&SVector<f64, 1>>,
            visit: &mut dyn FnMut(f64, &SVector<f64, 1>, &SVector<f64, 1>),
        ) {
            visit(2.0 - x[0], &vector![1.0], &vector![0.0]);
        }
    }
    let error = check_constraint(&Wrong, 1, &vector![0.3], None, 1e-6);
    assert!(
        matches!(
            error,
            Err(Error::Jacobian {
                row: 0,
                column: 0,
                given: 1.0,
                ..
            })
        ),
        "{error:?}"
    );
    assert!(check_cost(&cost(5), 2, &vector![0.4], &vector![-0.2], 1e-6).is_ok());
}

/// Sizes beyond the vectorised recursion take the dense one.
#[test]
fn many_states_are_solved_too() {
    struct Many;
    impl Robot<33, 2> for Many {
        fn flow(&self, x: &SVector<f64, 33>, u: &SVector<f64, 2>) -> SVector<f64, 33> {
            let mut out = -x;
            out[0] += u[0];
            out[32] += u[1];
            out
        }
        fn jacobians(
            &self,
            _: &SVector<f64, 33>,
            _: &SVector<f64, 2>,
        ) -> (SMatrix<f64, 33, 33>, SMatrix<f64, 33, 2>) {
            let mut b = SMatrix::zeros();
            (b[(0, 0)], b[(32, 1)]) = (1.0, 1.0);
            (-SMatrix::identity(), b)
        }
    }
    let goal = SVector::<f64, 33>::from_fn(|i, _| if i == 32 { 1.0 } else { 0.0 });
    let cost = Tracking::new(
        vec![goal; 21],
        vec![SVector::zeros(); 20],
        0.1,
        SVector::from_element(1.0),
        vector![0.01, 0.01],
        SVector::from_element(5.0),
    );
    let mut solver = Solver::new(20, 0.1).unwrap();
    let nothing: [&dyn Constraint<33, 2>; 0] = [];
    let report = solver
        .solve(
            &Many,
            &cost,
            &nothing,
            &SVector::zeros(),
            &Options::default(),
        )
        .unwrap();
    assert_eq!(report.status, ddp_rbf::Status::Converged);
    assert!(report.iterations <= 2);
    assert!((solver.states()[20][32] - 1.0).abs() < 0.1);
}
