//! How does my arm keep away from something that moves on a known way? `cargo run --example avoid_a_moving_obstacle`.
#![allow(clippy::print_stdout)]

use strrt::{Error, Params, Status, from_fn, plan};

fn main() -> Result<(), Error> {
    // A planar arm of two links of 0.4 m; a ball of 0.15 m crosses its reach at 0.3 m/s.
    let hand = |q: &[f64; 2]| {
        let (a, b) = (q[0], q[0] + q[1]);
        [
            [0.4 * a.cos(), 0.4 * a.sin()],
            [0.4 * (a.cos() + b.cos()), 0.4 * (a.sin() + b.sin())],
        ]
    };
    let ball = |step: usize| [0.5, -0.9 + 0.3 * 0.1 * step as f64];
    let distance = |q: &[f64; 2], step: usize| {
        let ([elbow, tip], c) = (hand(q), ball(step));
        let segment = |a: [f64; 2], b: [f64; 2]| {
            let (d, r) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
            let t = ((d[0] * r[0] + d[1] * r[1]) / (d[0] * d[0] + d[1] * d[1])).clamp(0.0, 1.0);
            (r[0] - t * d[0]).hypot(r[1] - t * d[1])
        };
        segment([0.0, 0.0], elbow).min(segment(elbow, tip)) - 0.15
    };
    let arm = from_fn([(-3.0, 3.0); 2], [1.5; 2], |q: &[f64; 2], step| {
        distance(q, step) > 0.03
    });
    let found = plan(
        &arm,
        [0.6, 0.3],
        [-0.6, 0.3],
        60,
        0.1,
        &Params::default(),
        1,
    )?;
    if found.status != Status::Solved {
        println!("no path: {:?}", found.reason);
        return Ok(());
    }
    for (step, q) in found.path.iter().enumerate().step_by(5) {
        println!(
            "{:.1} s  {q:6.2?} rad  {:.2} m from the ball",
            0.1 * step as f64,
            distance(q, step)
        );
    }
    Ok(())
}
