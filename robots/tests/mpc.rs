//! The robot as a model for predictive control: derivatives agree with central differences.
#![cfg(feature = "ddp-rbf")]
#![allow(clippy::unwrap_used)]

mod common;

use common::Random;
use ddp_rbf::{Barrier, Constraint, Expansion, Field, Horizon, Robot, check_jacobians};
use nalgebra::{SMatrix, SVector};
use robots::{BodyState, FieldClearance, MobileManipulator, SelfClearance};

type State = SVector<f64, 9>;
type Input = SVector<f64, 8>;

/// Distance to a ball, smooth everywhere but at its centre.
struct Ball;

impl Field for Ball {
    fn distance_gradient(&self, p: [f64; 3]) -> (f64, [f64; 3]) {
        let d = [p[0] - 6.0, p[1] + 5.0, p[2] - 4.0];
        let r = d.iter().map(|v| v * v).sum::<f64>().sqrt();
        (r - 1.0, d.map(|v| v / r))
    }
}

fn sample(random: &mut Random) -> (State, Input) {
    let x = State::from_fn(|i, _| random.within(-2.0, 2.0) * if i < 3 { 0.5 } else { 1.0 });
    (x, Input::from_fn(|_, _| random.within(-0.8, 0.8)))
}

#[test]
fn motion_derivatives_agree_with_differences() {
    let (robot, mut random) = (MobileManipulator::default(), Random(20));
    for _ in 0..200 {
        let (x, u) = sample(&mut random);
        check_jacobians(&robot, &x, &u, 1e-7).unwrap();
        let (a, b) = robot.linearize(&x, &u, 0.1);
        let h = 1e-5;
        for k in 0..17 {
            let step = |s: f64| {
                let (mut x, mut u) = (x, u);
                if k < 9 {
                    x[k] += s
                } else {
                    u[k - 9] += s
                }
                robot.step(&x, &u, 0.1)
            };
            let slope = (step(h) - step(-h)) / (2.0 * h);
            let column = if k < 9 {
                a.column(k).into_owned()
            } else {
                b.column(k - 9).into_owned()
            };
            assert!((slope - column).amax() < 1e-8);
        }
    }
}

fn values(c: &impl Constraint<9, 8>, x: &State) -> Vec<f64> {
    let mut out = Vec::new();
    c.values(0, x, None, &mut |z| out.push(z));
    out
}

fn rows_agree(c: &impl Constraint<9, 8>, x: &State, skip_kinks: bool) {
    let mut rows = Vec::new();
    c.rows(0, x, None, &mut |z, row, input| {
        assert_eq!(*input, Input::zeros());
        rows.push((z, *row));
    });
    let here = values(c, x);
    assert_eq!(here.len(), rows.len());
    let h = 1e-6;
    let mut kinks = 0;
    for k in 0..9 {
        let (mut high, mut low) = (*x, *x);
        high[k] += h;
        low[k] -= h;
        let (high, low) = (values(c, &high), values(c, &low));
        for (i, (z, row)) in rows.iter().enumerate() {
            assert!((z - here[i]).abs() < 1e-12);
            if (row[k] - (high[i] - low[i]) / (2.0 * h)).abs() > 1e-5 {
                kinks += 1;
            }
        }
    }
    // The distance to the base has corners, where one-sided slopes differ.
    assert!(kinks == 0 || (skip_kinks && kinks < 12), "{kinks}");
}

#[test]
fn constraint_rows_agree_with_differences() {
    let (robot, mut random) = (MobileManipulator::default(), Random(21));
    let field = FieldClearance::new(&robot, &Ball, 0.03, Barrier::default()).unwrap();
    let own = SelfClearance::new(&robot, 0.01, Barrier::default()).unwrap();
    for _ in 0..60 {
        let (x, _) = sample(&mut random);
        rows_agree(&field, &x, false);
        rows_agree(&own, &x, true);
        // The least self-constraint is the self-clearance less the margin.
        let joints = std::array::from_fn(|j| x[3 + j]);
        let least = values(&own, &x).into_iter().fold(f64::INFINITY, f64::min);
        assert!((least - robot.self_clearance(&joints) + 0.01).abs() < 1e-12);
        let state = BodyState {
            base: [x[0], x[1], x[2]],
            joints,
        };
        let arm = robot.arm_spheres(&state);
        let nearest = arm
            .iter()
            .map(|s| Ball.distance(s.center) - s.radius - 0.03)
            .fold(f64::INFINITY, f64::min);
        assert!(
            values(&field, &x)
                .iter()
                .any(|z| (z - nearest).abs() < 1e-12)
        );
    }
}

/// All knots at once give what one knot after the other gives.
#[test]
fn whole_horizons_agree_with_single_knots() {
    let (robot, mut random) = (MobileManipulator::default(), Random(22));
    for barrier in [Barrier::default(), Barrier::default().until(0.3)] {
        let field = FieldClearance::new(&robot, &Ball, 0.03, barrier).unwrap();
        let own = SelfClearance::new(&robot, 0.01, barrier).unwrap();
        let groups: [&dyn Constraint<9, 8>; 2] = [&field, &own];
        // Seven knots: the last group of four is not full.
        let states: Vec<State> = (0..8).map(|_| sample(&mut random).0).collect();
        let inputs = vec![Input::zeros(); 7];
        for group in groups {
            let mut models = vec![Expansion::zeros(); 8];
            let along = Horizon {
                states: &states,
                inputs: &inputs,
                weight: 0.1,
            };
            let found = group.penalize(&along, Some(&mut models));
            let mut sum = 0.0;
            for (k, x) in states.iter().enumerate().skip(1) {
                let (mut gradient, mut hessian) = (State::zeros(), SMatrix::<f64, 9, 9>::zeros());
                group.rows(k, x, None, &mut |z, row, _| {
                    let (value, slope, curvature) = barrier.eval(z);
                    sum += 0.1 * value;
                    gradient += row * (0.1 * slope);
                    hessian += row * row.transpose() * (0.1 * curvature);
                });
                let scale = 1.0 + hessian.amax();
                assert!((models[k].x - gradient).amax() < 1e-11 * scale);
                assert!((models[k].xx - hessian).amax() < 1e-11 * scale);
            }
            assert_eq!(models[0], Expansion::zeros());
            assert!(
                (found.sum - sum).abs() < 1e-11 * (1.0 + sum.abs()),
                "{} {sum}",
                found.sum
            );
        }
    }
}
