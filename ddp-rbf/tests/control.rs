//! Receding horizon, real-time iterations and the safety layer.
#![allow(missing_docs, clippy::unwrap_used)]

use ddp_rbf::nalgebra::{SVector, vector};
use ddp_rbf::{
    Accelerated, Barrier, Constraint, DriveArm, Error, GuardParams, HalfSpaces, InputBox, Mpc,
    Options, Robot, SafetyLayer, SafetyParams, Solver, StateBox, Status, Tracking, Verdict,
    check_step, ode,
};
use proptest::prelude::*;

type X = SVector<f64, 3>;
type U = SVector<f64, 2>;

fn along(n: usize, from: f64, heading: f64) -> Tracking<3, 2> {
    let (s, c) = heading.sin_cos();
    // 0.5 m/s along a line through the origin, 0.1 s per knot.
    let at = |k: usize| 0.05 * k as f64 + from;
    Tracking::new(
        (0..=n)
            .map(|k| vector![at(k) * c, at(k) * s, heading])
            .collect(),
        vec![vector![0.5, 0.0]; n],
        0.1,
        vector![5.0, 5.0, 1.0],
        vector![0.5, 0.3],
        vector![20.0, 20.0, 5.0],
    )
}

fn limits() -> InputBox<2> {
    InputBox::new(vector![-0.8, -1.5], vector![0.8, 1.5], Barrier::default())
}

fn layer(margin: f64) -> SafetyLayer<3, 2> {
    SafetyLayer::new(SafetyParams {
        guard: GuardParams {
            acceleration: vector![0.8, 2.0],
            period: 0.04,
            look: 0.02,
            margin,
        },
        low: vector![-0.8, -1.5],
        high: vector![0.8, 1.5],
        decrease: 4.0,
    })
    .unwrap()
}

/// The square room |x|, |y| < 1 as half-spaces.
fn room(margin: f64) -> HalfSpaces<3, 2> {
    let side = |x: f64, y: f64| (vector![x, y, 0.0], U::zeros(), 1.0 - margin);
    let sides = vec![
        side(1.0, 0.0),
        side(-1.0, 0.0),
        side(0.0, 1.0),
        side(0.0, -1.0),
    ];
    HalfSpaces::new(sides, Barrier::default()).unwrap()
}

fn clearance(x: &X) -> f64 {
    1.0 - x[0].abs().max(x[1].abs())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) })]

    /// Rigid motion of start and reference leaves the inputs unchanged.
    #[test]
    fn answers_do_not_depend_on_the_frame(turn in -3.0..3.0f64, x0 in prop::array::uniform3(-0.3..0.3f64)) {
        let n = 20;
        let run = |turn: f64| {
            let (s, c) = turn.sin_cos();
            let start = vector![c * x0[0] - s * x0[1], s * x0[0] + c * x0[1], x0[2] + turn];
            let mut cost = along(n, 0.0, turn);
            // Position weights are equal, so that turning them changes nothing.
            cost.state_weight = vector![5.0, 5.0, 1.0];
            let mut mpc = Mpc::new(n, 0.1).unwrap();
            mpc.step(&DriveArm, &cost, &[&limits()], &start, &Options { tolerance: 1e-12, ..Options::default() }).unwrap();
            mpc.inputs().to_vec()
        };
        for (a, b) in run(0.0).iter().zip(run(turn)) {
            prop_assert!((a - b).amax() < 1e-6, "{a} {b}");
        }
    }

    /// Shifting the clock shifts the plan: on a reference without end, the plan one knot later is the plan moved by a knot.
    #[test]
    fn shifting_the_clock_shifts_the_plan(offset in prop::array::uniform2(-0.1..0.1f64)) {
        let n = 40;
        let options = Options { tolerance: 1e-14, ..Options::default() };
        let start = vector![offset[0], offset[1], 0.0];
        let mut mpc = Mpc::new(n, 0.1).unwrap();
        mpc.step(&DriveArm, &along(n, 0.0, 0.0), &[&limits()], &start, &options).unwrap();
        let (next, plan) = (mpc.states()[1], mpc.inputs().to_vec());
        mpc.shift(0.1);
        let report = mpc.step(&DriveArm, &along(n, 0.05, 0.0), &[&limits()], &next, &options).unwrap();
        prop_assert!(report.iterations <= 4, "{}", report.iterations);
        // The horizon's end has moved on, which the first inputs hardly feel.
        prop_assert!((mpc.inputs()[0] - plan[1]).amax() < 1e-3);
    }

    /// Preparing before the measurement and reacting to it is one full iteration.
    #[test]
    fn reactions_are_iterations(x0 in prop::array::uniform3(-0.2..0.2f64)) {
        let n = 20;
        let cost = along(n, 0.0, 0.0);
        let start = X::from(x0);
        let groups: [&dyn Constraint<3, 2>; 1] = [&limits()];
        let mut mpc = Mpc::new(n, 0.1).unwrap();
        mpc.prepare(&DriveArm, &cost, &groups).unwrap();
        let u = mpc.react(&start);
        mpc.commit(&DriveArm, &start).unwrap();
        prop_assert!((mpc.inputs()[0] - u).amax() < 1e-12);
        prop_assert_eq!(mpc.states()[0], start);
        for k in 0..n {
            let next = DriveArm.step(&mpc.states()[k], &mpc.inputs()[k], 0.1);
            prop_assert!((next - mpc.states()[k + 1]).amax() < 1e-12);
        }
    }

    /// The gain of the first knot predicts what a slightly different start would have been told.
    #[test]
    fn gains_predict_other_starts(d in prop::array::uniform3(-1e-4..1e-4f64)) {
        let n = 20;
        let cost = along(n, 0.0, 0.0);
        let options = Options { tolerance: 1e-15, iterations: 30, ..Options::default() };
        let solve = |x0: X| {
            let mut solver = Solver::new(n, 0.1).unwrap();
            solver.set_guess(&cost.states, &cost.inputs).unwrap();
            solver.solve(&DriveArm, &cost, &[&limits()], &x0, &options).unwrap();
            solver
        };
        let here = solve(vector![0.02, 0.05, 0.1]);
        let there = solve(vector![0.02, 0.05, 0.1] + X::from(d));
        let predicted = here.inputs()[0] + here.gain() * X::from(d);
        // Gauss-Newton leaves out the curvature of the dynamics.
        prop_assert!((predicted - there.inputs()[0]).amax() < 1e-4, "{predicted} {}", there.inputs()[0]);
    }

    /// Whatever is commanded at each step, a robot that obeys the layer keeps the margin to the walls and its input limits.
    #[test]
    fn layers_keep_the_margin(commands in prop::collection::vec(prop::array::uniform2(-3.0..3.0f64), 60)) {
        let mut layer = layer(0.1);
        let hard = room(0.1);
        let (mut x, mut u) = (X::zeros(), U::zeros());
        for command in &commands {
            let (target, _) = layer.check(&DriveArm, &x, &u, &U::from(*command), &[&hard], clearance);
            prop_assert!(target[0].abs() <= 0.8 && target[1].abs() <= 1.5);
            for _ in 0..2 {
                u = U::from_fn(|i, _| {
                    let room: f64 = layer.params().guard.acceleration[i] * 0.02;
                    u[i] + (target[i] - u[i]).clamp(-room, room)
                });
                x = DriveArm.step(&x, &u, 0.02);
                prop_assert!(clearance(&x) >= 0.1 - 1e-6, "{}", clearance(&x));
            }
        }
        let c = layer.counts();
        prop_assert_eq!(c.accepted + c.projected + c.scaled + c.braked, commands.len());
    }

    /// A heading reference that wraps is followed the short way, without jumps.
    #[test]
    fn headings_are_unwrapped(near in -20.0..20.0f64, steps in prop::collection::vec(-0.5..0.5f64, 10)) {
        let wrap = |a: f64| (a + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
        let mut angle: f64 = near + 0.3;
        let states = steps.iter().map(|s| { angle += s; vector![0.0, 0.0, wrap(angle)] }).collect();
        let cost = Tracking::<3, 2>::new(states, vec![U::zeros(); 9], 0.1, X::zeros(), U::zeros(), X::zeros()).unwrapped(2, near);
        let mut angle = near + 0.3;
        for (x, s) in cost.states.iter().zip(&steps) {
            angle += s;
            prop_assert!((x[2] - angle).abs() < 1e-9, "{} {angle}", x[2]);
        }
    }

    /// Both integrators and the accelerated robot have the derivatives of their own steps.
    #[test]
    fn steps_have_their_derivatives(x in prop::array::uniform3(-2.0..2.0f64), u in prop::array::uniform2(-1.0..1.0f64)) {
        let adaptive = ode::Adaptive { robot: DriveArm, control: ode::StepControl::default() };
        check_step(&adaptive, &X::from(x), &U::from(u), 0.3, 1e-6).unwrap();
        let z = SVector::<f64, 5>::from_fn(|i, _| if i < 3 { x[i] } else { u[i - 3] });
        check_step(&Accelerated::<_, 3>(DriveArm), &z, &vector![0.3, -0.7], 0.2, 1e-6).unwrap();
    }
}

#[test]
fn costs_never_rise_from_iteration_to_iteration() {
    let n = 30;
    let cost = along(n, 0.0, 0.0);
    let wall = HalfSpaces::new(
        vec![(vector![-1.0, 0.0, 0.0], U::zeros(), 0.7)],
        Barrier::default(),
    )
    .unwrap();
    let start = vector![0.0, 0.2, 1.0];
    let mut last = f64::INFINITY;
    for iterations in 0..12 {
        let mut solver = Solver::new(n, 0.1).unwrap();
        // A guess without gaps: standing still.
        solver
            .set_guess(&vec![start; n + 1], &vec![U::zeros(); n])
            .unwrap();
        let options = Options {
            iterations,
            ..Options::default()
        };
        let report = solver
            .solve(&DriveArm, &cost, &[&limits(), &wall], &start, &options)
            .unwrap();
        assert!(
            report.cost <= last + 1e-12,
            "{iterations}: {} {last}",
            report.cost
        );
        last = report.cost;
    }
}

#[test]
fn the_clock_ends_a_solve_with_a_usable_plan() {
    let n = 20;
    let mut mpc = Mpc::new(n, 0.1).unwrap();
    let start = vector![0.3, -0.4, 2.0];
    let mut asked = 0;
    let report = mpc
        .step_until(
            &DriveArm,
            &along(n, 0.0, 0.0),
            &[&limits()],
            &start,
            &Options::default(),
            &mut || {
                asked += 1;
                asked > 1
            },
        )
        .unwrap();
    assert_eq!((report.status, report.iterations), (Status::OutOfTime, 2));
    assert_eq!(mpc.statistics().out_of_time, 1);
    assert!(mpc.inputs().iter().all(|u| u.iter().all(|v| v.is_finite())));
}

#[test]
fn two_starts_keep_the_cheaper() {
    let n = 20;
    let mut mpc = Mpc::new(n, 0.1).unwrap();
    let start = X::zeros();
    let options = Options::real_time();
    mpc.step(
        &DriveArm,
        &along(n, 0.0, 0.0),
        &[&limits()],
        &start,
        &options,
    )
    .unwrap();
    // The reference turns round: from itself the solve is at once where the old plan does not get in three iterations.
    let back = along(n, 0.0, std::f64::consts::PI);
    let start = vector![0.0, 0.0, std::f64::consts::PI];
    let (report, from_reference) = mpc
        .step_from_both(&DriveArm, &back, &[&limits()], &start, &options)
        .unwrap();
    assert!(from_reference);
    let mut alone = Mpc::new(n, 0.1).unwrap();
    let best = alone
        .step(&DriveArm, &back, &[&limits()], &start, &options)
        .unwrap();
    assert!((report.cost - best.cost).abs() < 1e-12);
}

#[test]
fn limits_on_acceleration_are_kept_by_the_accelerated_robot() {
    let n = 40;
    let goal = SVector::<f64, 5>::from([1.0, 0.0, 0.0, 0.0, 0.0]);
    let cost = Tracking::new(
        vec![goal; n + 1],
        vec![U::zeros(); n],
        0.1,
        SVector::<f64, 5>::from([5.0, 5.0, 1.0, 0.1, 0.1]),
        vector![0.05, 0.05],
        SVector::<f64, 5>::from([50.0, 50.0, 5.0, 10.0, 5.0]),
    );
    let speed = StateBox {
        limits: vec![(3, -0.5, 0.5), (4, -1.0, 1.0)],
        barrier: Barrier::default(),
    };
    let push = InputBox::new(vector![-0.4, -1.0], vector![0.4, 1.0], Barrier::default());
    let mut solver = Solver::new(n, 0.1).unwrap();
    let report = solver
        .solve(
            &Accelerated::<_, 3>(DriveArm),
            &cost,
            &[&speed, &push],
            &SVector::zeros(),
            &Options::default(),
        )
        .unwrap();
    assert_eq!(report.status, Status::Converged);
    assert!((solver.states()[n] - goal).norm() < 0.05);
    assert!(solver.states().iter().all(|x| x[3].abs() < 0.5));
    assert!(solver.inputs().iter().all(|u| u[0].abs() < 0.4));
}

#[test]
fn the_papers_integrator_finds_the_same_plan() {
    let n = 20;
    let cost = along(n, 0.0, 0.0);
    let start = vector![0.1, -0.1, 0.3];
    let run = |robot: &dyn Robot<3, 2>| {
        let mut mpc = Mpc::new(n, 0.1).unwrap();
        mpc.step(robot, &cost, &[&limits()], &start, &Options::default())
            .unwrap();
        mpc.inputs().to_vec()
    };
    let adaptive = ode::Adaptive {
        robot: DriveArm,
        control: ode::StepControl::default(),
    };
    for (a, b) in run(&DriveArm).iter().zip(run(&adaptive)) {
        assert!((a - b).amax() < 1e-4);
    }
}

/// Heading for a wall at an angle: a projection slides along it where scaling can only slow down.
#[test]
fn unsafe_commands_are_replaced() {
    let mut layer = layer(0.1);
    let hard = room(0.1);
    // Half a millimetre before the margin.
    let x = vector![0.8995, 0.0, 0.3];
    let command = vector![0.6, 0.0];
    let (u, verdict) = layer.check(&DriveArm, &x, &U::zeros(), &command, &[&hard], clearance);
    assert_ne!(verdict, Verdict::Accepted);
    if cfg!(feature = "clarabel") {
        assert_eq!(verdict, Verdict::Projected);
        assert!(u[0] < 0.6);
    }
    let counts = layer.counts();
    assert_eq!(counts.accepted, 0);
    assert_eq!(counts.projected + counts.scaled + counts.braked, 1);
}

#[test]
fn braking_names_the_constraint() {
    let mut layer = layer(0.1);
    let hard = room(0.1);
    let x = vector![0.8999, 0.0, 0.0];
    // Already fast towards the wall: nothing but braking is left.
    let now = vector![0.8, 0.0];
    let (u, verdict) = layer.check(&DriveArm, &x, &now, &vector![0.8, 0.0], &[&hard], clearance);
    assert_eq!((u, verdict), (U::zeros(), Verdict::Braked));
    let braking = layer.braking().unwrap();
    assert_eq!(braking.group, "half-spaces");
    assert!((braking.room - 1e-4).abs() < 1e-9);
    assert_eq!(layer.counts().braked, 1);
}

#[test]
fn commands_that_are_not_finite_are_braked() {
    let mut layer = layer(0.1);
    let command = vector![f64::NAN, 0.0];
    let (u, verdict) = layer.check(
        &DriveArm,
        &X::zeros(),
        &U::zeros(),
        &command,
        &[],
        clearance,
    );
    assert_eq!((u, verdict), (U::zeros(), Verdict::Braked));
}

#[test]
fn clearances_that_are_not_finite_are_none() {
    let mut layer = layer(0.1);
    let command = vector![0.1, 0.0];
    let (_, verdict) = layer.check(&DriveArm, &X::zeros(), &U::zeros(), &command, &[], |_| {
        f64::NAN
    });
    assert_eq!(verdict, Verdict::Braked);
}

#[test]
fn bad_safety_parameters_are_refused() {
    let good = layer(0.1).params().clone();
    type Spoil = fn(&mut SafetyParams<2>);
    let spoils: [(&str, Spoil); 6] = [
        ("look", |p| p.guard.look = 0.0),
        ("period", |p| p.guard.period = f64::NAN),
        ("decrease", |p| p.decrease = -1.0),
        ("margin", |p| p.guard.margin = f64::INFINITY),
        ("acceleration", |p| p.guard.acceleration[1] = 0.0),
        ("room between the limits of an input", |p| p.low[0] = 1.0),
    ];
    for (name, spoil) in spoils {
        let mut params = good.clone();
        spoil(&mut params);
        match SafetyLayer::<3, 2>::new(params) {
            Err(Error::Param { field, .. }) => assert_eq!(field, name),
            other => panic!("{name}: {other:?}"),
        }
    }
}
