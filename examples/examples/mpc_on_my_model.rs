//! Can I run the controller on a model of my own? A pendulum on a motor swings up: `cargo run --example mpc_on_my_model`.
#![allow(clippy::print_stdout)]

use ddp_rbf::nalgebra::{SMatrix, SVector, matrix, vector};
use ddp_rbf::{Barrier, Error, InputBox, Mpc, Options, Robot, Tracking};
use std::f64::consts::PI;

/// 1 kg on a rod of 0.5 m; the state is angle (0 hangs down) and rate, the input the motor's torque, Nm.
struct Pendulum;

impl Robot<2, 1> for Pendulum {
    fn flow(&self, x: &SVector<f64, 2>, u: &SVector<f64, 1>) -> SVector<f64, 2> {
        vector![x[1], u[0] / 0.25 - 9.81 / 0.5 * x[0].sin()]
    }
    fn jacobians(
        &self,
        x: &SVector<f64, 2>,
        _: &SVector<f64, 1>,
    ) -> (SMatrix<f64, 2, 2>, SMatrix<f64, 2, 1>) {
        (
            matrix![0.0, 1.0; -9.81 / 0.5 * x[0].cos(), 0.0],
            matrix![0.0; 4.0],
        )
    }
}

fn main() -> Result<(), Error> {
    let (knots, dt) = (40, 0.05);
    let upright = vector![PI, 0.0];
    let cost = Tracking::new(
        vec![upright; knots + 1],
        vec![SVector::zeros(); knots],
        dt,
        vector![2.0, 0.1],
        vector![0.05],
        vector![100.0, 10.0],
    );
    // Too weak to lift it at once (4.9 Nm), so it has to swing.
    let torque = InputBox::new(vector![-3.0], vector![3.0], Barrier::default());
    let mut mpc = Mpc::new(knots, dt)?;
    let mut x: SVector<f64, 2> = vector![0.0, 0.0];
    for step in 0..120 {
        mpc.shift(dt);
        mpc.step(&Pendulum, &cost, &[&torque], &x, &Options::default())?;
        // Relaxed barriers bend before they hold: what leaves for the motor is clamped.
        let u = mpc.inputs()[0].map(|torque| torque.clamp(-3.0, 3.0));
        if step % 12 == 0 {
            println!(
                "{:.1} s  {:4.0} degrees  {:5.2} Nm",
                dt * f64::from(step),
                x[0].to_degrees(),
                u[0]
            );
        }
        x = Pendulum.step(&x, &u, dt);
    }
    println!("at the end {:.1} degrees", x[0].to_degrees());
    Ok(())
}
