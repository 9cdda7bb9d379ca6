//! An arm of two joints folds to pass under a bar while its base drives by: prints the path.
#![allow(missing_docs, clippy::print_stdout)]

use strrt::{Params, Status, from_fn, peak_acceleration, plan};

fn main() -> Result<(), strrt::Error> {
    // The hand's height, m, of a planar arm with links of 0.4 m on a shoulder at 0.6 m.
    let height = |q: &[f64; 2]| 0.6 + 0.4 * q[0].sin() + 0.4 * (q[0] + q[1]).sin();
    // Between steps 25 and 40 the base passes a bar at 1.0 m.
    let arm = from_fn([(-3.0, 3.0); 2], [0.8; 2], |q: &[f64; 2], step| {
        !(25..40).contains(&step) || height(q) < 1.0
    });
    let params = Params {
        acceleration: Some(2.0),
        ..Params::default()
    };
    let found = plan(&arm, [1.2, 0.2], [1.0, 0.5], 70, 0.1, &params, 1)?;
    if found.status != Status::Solved {
        println!("no path: {:?}", found.reason);
        return Ok(());
    }
    println!(
        "cost {:.2} rad, {} checks, peak {:.2} rad/s^2",
        found.cost,
        found.checks,
        peak_acceleration(&found.path, 0.1)
    );
    for (step, q) in found.path.iter().enumerate().step_by(5) {
        println!(
            "{:4.1} s  {:6.2} {:6.2}  hand at {:.2} m",
            step as f64 * 0.1,
            q[0],
            q[1],
            height(q)
        );
    }
    Ok(())
}
