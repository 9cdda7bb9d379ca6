//! Properties of barriers, integrators, the solver and the guard.
#![allow(missing_docs, clippy::unwrap_used)]

use ddp_rbf::nalgebra::{SMatrix, SVector, vector};
use ddp_rbf::{
    Barrier, Constraint, GuardParams, InputBox, Mpc, Options, Robot, Solver, Status, Tracking,
    Verdict, check_jacobians, guard, ode,
};
use proptest::prelude::*;

/// A differential drive: x, y, yaw; v, omega.
struct Drive;

impl Robot<3, 2> for Drive {
    fn flow(&self, x: &SVector<f64, 3>, u: &SVector<f64, 2>) -> SVector<f64, 3> {
        vector![u[0] * x[2].cos(), u[0] * x[2].sin(), u[1]]
    }
    fn jacobians(
        &self,
        x: &SVector<f64, 3>,
        u: &SVector<f64, 2>,
    ) -> (SMatrix<f64, 3, 3>, SMatrix<f64, 3, 2>) {
        let (s, c) = x[2].sin_cos();
        let mut a = SMatrix::zeros();
        a[(0, 2)] = -u[0] * s;
        a[(1, 2)] = u[0] * c;
        let mut b = SMatrix::zeros();
        b[(0, 0)] = c;
        b[(1, 0)] = s;
        b[(2, 1)] = 1.0;
        (a, b)
    }
}

fn tracking(n: usize, goal: [f64; 3]) -> Tracking<3, 2> {
    Tracking::new(
        vec![SVector::from(goal); n + 1],
        vec![SVector::zeros(); n],
        0.1,
        vector![5.0, 5.0, 1.0],
        vector![0.5, 0.3],
        vector![20.0, 20.0, 5.0],
    )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(128) })]

    /// Eq. 9: value, slope and curvature agree on both sides of delta, and at a cut-off they vanish.
    #[test]
    fn barriers_are_twice_continuous(mu in 1e-4..1.0f64, delta in 1e-5..1e-2f64, factor in 2.0..1e3f64) {
        for barrier in [Barrier { mu, delta, cutoff: None }, Barrier { mu, delta, cutoff: None }.until(delta * factor)] {
            for at in [Some(delta), barrier.cutoff].into_iter().flatten() {
                let h = at * 1e-9;
                let (a, b) = (barrier.eval(at - h), barrier.eval(at + h));
                let scale = mu * (1.0 + 1.0 / (at * at));
                prop_assert!((a.0 - b.0).abs() < 1e-6 * mu * (1.0 + delta.ln().abs()));
                prop_assert!((a.1 - b.1).abs() < 1e-6 * scale);
                prop_assert!((a.2 - b.2).abs() < 1e-6 * scale);
            }
        }
    }

    /// The printed formula, the derivatives by differences, monotone and convex.
    #[test]
    fn barriers_follow_equation_9(z in -0.01..2.0f64, mu in 1e-4..1.0f64, delta in 1e-4..1e-2f64) {
        let barrier = Barrier { mu, delta, cutoff: None };
        let printed = if z > delta {
            -mu * z.ln()
        } else {
            mu * (-delta.ln() + ((z - 2.0 * delta) / (2f64.sqrt() * delta)).powi(2) - 0.5)
        };
        let (value, slope, curvature) = barrier.eval(z);
        prop_assert!((value - printed).abs() < 1e-9 * (1.0 + printed.abs()));
        let h = 1e-7 * (z.abs() + delta);
        let difference = (barrier.value(z + h) - barrier.value(z - h)) / (2.0 * h);
        prop_assert!((slope - difference).abs() < 1e-4 * (1.0 + slope.abs()));
        prop_assert!(slope < 0.0 && curvature > 0.0);
        let ended = barrier.until(1.0);
        prop_assert!(ended.value(z) >= 0.0 && ended.eval(z).1 <= 0.0 && ended.eval(z).2 >= 0.0);
    }

    /// The model's Jacobians, and the exact sensitivities of the discrete step.
    #[test]
    fn sensitivities_match_differences(x in prop::array::uniform3(-3.0..3.0f64), u in prop::array::uniform2(-1.0..1.0f64)) {
        let (x, u) = (SVector::from(x), SVector::from(u));
        prop_assert!(check_jacobians(&Drive, &x, &u, 1e-6).is_ok());
        let (a, b) = Drive.linearize(&x, &u, 0.1);
        let h = 1e-6;
        for i in 0..3 {
            let mut d = SVector::zeros();
            d[i] = h;
            let slope = (Drive.step(&(x + d), &u, 0.1) - Drive.step(&(x - d), &u, 0.1)) / (2.0 * h);
            prop_assert!((slope - a.column(i)).amax() < 1e-7);
        }
        for i in 0..2 {
            let mut d = SVector::zeros();
            d[i] = h;
            let slope = (Drive.step(&x, &(u + d), 0.1) - Drive.step(&x, &(u - d), 0.1)) / (2.0 * h);
            prop_assert!((slope - b.column(i)).amax() < 1e-7);
        }
    }

    /// Halving the step of Runge-Kutta divides its error by about 16, and Dormand-Prince keeps its tolerance.
    #[test]
    fn integrators_keep_their_order(v in 0.5..1.0f64, w in 0.8..1.5f64) {
        let (x, u) = (vector![0.0, 0.0, 0.3], vector![v, w]);
        // The exact arc.
        let t = 2.0;
        let exact = vector![
            v / w * ((0.3 + w * t).sin() - 0.3f64.sin()),
            v / w * (0.3f64.cos() - (0.3 + w * t).cos()),
            0.3 + w * t
        ];
        let error = |n: usize| {
            let mut at = x;
            for _ in 0..n {
                at = ode::rk4(&Drive, &at, &u, t / n as f64);
            }
            (at - exact).norm()
        };
        let order = (error(8) / error(16)).log2();
        prop_assert!((3.7..4.3).contains(&order), "order {order}");
        let adaptive = ode::dormand_prince(&Drive, &x, &u, t, 1e-8, 1000);
        prop_assert!(adaptive.finished);
        prop_assert!((adaptive.x - exact).norm() < 1e-6);
    }

    /// A solve from any start closes its gaps, keeps the input limits, and ends no worse than it began.
    #[test]
    fn solves_improve_and_stay_within_limits(
        x0 in prop::array::uniform3(-1.0..1.0f64),
        goal in prop::array::uniform3(-1.0..1.0f64),
    ) {
        let n = 30;
        let cost = tracking(n, goal);
        let limits = InputBox::new(vector![-0.8, -1.5], vector![0.8, 1.5], Barrier::default());
        let constraints: [&dyn Constraint<3, 2>; 1] = [&limits];
        let mut solver = Solver::new(n, 0.1).unwrap();
        let start = SVector::from(x0);
        solver.set_guess(&vec![start; n + 1], &vec![SVector::zeros(); n]).unwrap();
        let none = Options { iterations: 0, ..Options::default() };
        let before = solver.solve(&Drive, &cost, &constraints, &start, &none).unwrap().cost;
        let report = solver.solve(&Drive, &cost, &constraints, &start, &Options::default()).unwrap();
        prop_assert!(report.cost <= before + 1e-9);
        prop_assert!(report.gap < 1e-9);
        // A relaxed barrier gives way a little where the cost pushes hard: by centimetres at most with these weights.
        prop_assert!(solver.groups()[0].least > -3e-2, "{}", solver.groups()[0].least);
        for (k, u) in solver.inputs().iter().enumerate() {
            let next = Drive.step(&solver.states()[k], u, 0.1);
            prop_assert!((next - solver.states()[k + 1]).amax() < 1e-9);
        }
        // Solved again from its own solution it has nothing to do, and the same input gives the same bits.
        let again = solver.clone().solve(&Drive, &cost, &constraints, &start, &Options::default()).unwrap();
        prop_assert!(again.cost <= report.cost + 1e-9);
        let mut twin = solver.clone();
        twin.solve(&Drive, &cost, &constraints, &start, &Options::default()).unwrap();
        let mut other = solver.clone();
        other.solve(&Drive, &cost, &constraints, &start, &Options::default()).unwrap();
        prop_assert_eq!(twin.inputs(), other.inputs());
    }

    /// A mirrored problem has a mirrored answer.
    #[test]
    fn mirrored_problems_have_mirrored_answers(goal in prop::array::uniform3(-1.0..1.0f64)) {
        let n = 20;
        let run = |goal: [f64; 3]| {
            let mut solver = Solver::new(n, 0.1).unwrap();
            let none: [&dyn Constraint<3, 2>; 0] = [];
            solver.solve(&Drive, &tracking(n, goal), &none, &SVector::zeros(), &Options::default()).unwrap();
            solver.inputs().to_vec()
        };
        for (a, b) in run(goal).iter().zip(run([goal[0], -goal[1], -goal[2]])) {
            prop_assert!((a[0] - b[0]).abs() < 1e-6 && (a[1] + b[1]).abs() < 1e-6);
        }
    }

    /// From rest in a safe place, whatever is commanded at each step, obeying the guard never loses the margin to a wall.
    #[test]
    fn guarded_robots_never_touch_the_wall(commands in prop::collection::vec(prop::array::uniform2(-3.0..3.0f64), 60)) {
        let clearance = |x: &SVector<f64, 3>| 1.0 - x[0].abs().max(x[1].abs());
        let params =
            GuardParams { acceleration: vector![0.8, 2.0], period: 0.04, look: 0.02, margin: 0.1 };
        let (mut x, mut u) = (SVector::zeros(), SVector::zeros());
        for command in commands {
            let command = SVector::from(command).map(|v: f64| v.clamp(-1.5, 1.5));
            let (target, _) = guard(&x, &u, &command, &params, |x, u, dt| Drive.step(x, u, dt), clearance);
            for _ in 0..2 {
                u = SVector::from_fn(|i, _| {
                    let room: f64 = params.acceleration[i] * params.look;
                    u[i] + (target[i] - u[i]).clamp(-room, room)
                });
                x = Drive.step(&x, &u, params.look);
                prop_assert!(clearance(&x) >= 0.1 - 1e-6, "{}", clearance(&x));
            }
        }
    }
}

#[test]
fn a_linear_quadratic_problem_is_solved_in_one_step() {
    struct Cart;
    impl Robot<2, 1> for Cart {
        fn flow(&self, x: &SVector<f64, 2>, u: &SVector<f64, 1>) -> SVector<f64, 2> {
            vector![x[1], u[0]]
        }
        fn jacobians(
            &self,
            _: &SVector<f64, 2>,
            _: &SVector<f64, 1>,
        ) -> (SMatrix<f64, 2, 2>, SMatrix<f64, 2, 1>) {
            (
                SMatrix::from_row_slice(&[0.0, 1.0, 0.0, 0.0]),
                SMatrix::from_row_slice(&[0.0, 1.0]),
            )
        }
    }
    let cost = Tracking::new(
        vec![vector![1.0, 0.0]; 21],
        vec![vector![0.0]; 20],
        0.1,
        vector![1.0, 0.1],
        vector![0.1],
        vector![10.0, 1.0],
    );
    let mut solver = Solver::new(20, 0.1).unwrap();
    let none: [&dyn Constraint<2, 1>; 0] = [];
    // An infeasible guess: all states far from where the inputs lead.
    solver
        .set_guess(&[vector![5.0, -3.0]; 21], &[vector![0.4]; 20])
        .unwrap();
    let report = solver
        .solve(&Cart, &cost, &none, &vector![0.0, 0.0], &Options::default())
        .unwrap();
    assert_eq!(report.status, Status::Converged);
    assert!(report.iterations <= 2, "{} iterations", report.iterations);
    assert!(report.gap < 1e-9);
}

#[test]
fn shifting_moves_the_plan_in_time() {
    let mut mpc = Mpc::new(10, 0.1).unwrap();
    let none: [&dyn Constraint<3, 2>; 0] = [];
    mpc.step(
        &Drive,
        &tracking(10, [1.0, 0.2, 0.0]),
        &none,
        &SVector::zeros(),
        &Options::default(),
    )
    .unwrap();
    let before = mpc.inputs().to_vec();
    mpc.shift(0.1);
    assert!((mpc.inputs()[0] - before[1]).amax() < 1e-9);
    mpc.shift(0.05);
    assert!((mpc.inputs()[0] - (before[1] + before[2]) * 0.5).amax() < 1e-9);
    let same = mpc.inputs().to_vec();
    mpc.shift(0.0);
    assert_eq!(mpc.inputs(), same);
}

#[test]
fn a_safe_command_passes_the_guard() {
    let params = GuardParams {
        acceleration: vector![0.8, 2.0],
        period: 0.04,
        look: 0.02,
        margin: 0.1,
    };
    let command = vector![0.3, 0.1];
    let (u, verdict) = guard(
        &SVector::zeros(),
        &SVector::zeros(),
        &command,
        &params,
        |x, u, dt| Drive.step(x, u, dt),
        |_| 1.0,
    );
    assert_eq!((u, verdict), (command, Verdict::Accepted));
}
