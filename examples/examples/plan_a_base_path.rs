//! How does my base get there? A path on a map of your own, with poses at equal times: `cargo run --example plan_a_base_path`.
#![allow(clippy::print_stdout)]

use hybrid_astar::{Error, Footprint, GoalYaw, Limits, Map, Params, plan};

/// A room of 6 m by 4 m with a round table. The planner asks for nothing but clearances.
struct Room;

impl Map for Room {
    fn clearance(&self, p: [f64; 2]) -> f64 {
        let walls = p[0].min(6.0 - p[0]).min(p[1]).min(4.0 - p[1]);
        let table = (p[0] - 3.0).hypot(p[1] - 2.0) - 0.8;
        walls.min(table)
    }
    fn bounds(&self) -> ([f64; 2], [f64; 2]) {
        ([0.0, 0.0], [6.0, 4.0])
    }
}

fn main() -> Result<(), Error> {
    let robot = Footprint::rectangle(0.75, 0.55, 3);
    let start = [1.0, 2.0, 0.0];
    // Any heading will do at the goal; `GoalYaw::Fixed` wants a certain one.
    let found = plan(
        &Room,
        &robot,
        start,
        [5.0, 2.0],
        &GoalYaw::Free,
        &Params::default(),
    )?;
    if let Some(reason) = &found.reason {
        println!("no path: {reason}");
        return Ok(());
    }
    let timed = found.time(&Limits::default(), 0.1)?;
    println!(
        "{:.2} m in {:.1} s, {} nodes",
        found.length,
        timed.seconds(),
        found.expansions
    );
    for (k, [x, y, yaw]) in timed.poses.iter().enumerate().step_by(10) {
        println!(
            "{:4.1} s  ({x:.2}, {y:.2}) m  {:4.0} degrees",
            0.1 * k as f64,
            yaw.to_degrees()
        );
    }
    Ok(())
}
