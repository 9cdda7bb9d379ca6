//! Plans a path through a small room and prints where the base is at every half second.
#![allow(missing_docs, clippy::print_stdout)]

use hybrid_astar::{Footprint, GoalYaw, Limits, Params, grid::Grid, plan};

fn main() -> Result<(), hybrid_astar::Error> {
    let room = "\
................
................
................
###########.....
................
................
................
................";
    let map = Grid::parse(room, 0.5);
    let robot = Footprint::rectangle(0.75, 0.55, 3);
    let path = plan(
        &map,
        &robot,
        [1.0, 1.0, 0.0],
        [2.0, 3.5],
        &GoalYaw::Free,
        &Params::default(),
    )?;
    match &path.reason {
        Some(reason) => println!("no path: {reason}"),
        None => println!(
            "{:.2} m, {:.2} s, {} expansions",
            path.length, path.seconds, path.expansions
        ),
    }
    let timed = path.time(&Limits::default(), 0.5)?;
    for (k, p) in timed.poses.iter().enumerate() {
        let motion = timed
            .motions
            .get(k)
            .map_or("stop".to_owned(), |m| format!("{m:?}"));
        println!(
            "{:4.1} s  x {:5.2}  y {:5.2}  yaw {:5.2}  {motion}",
            k as f64 * timed.dt,
            p[0],
            p[1],
            p[2]
        );
    }
    Ok(())
}
