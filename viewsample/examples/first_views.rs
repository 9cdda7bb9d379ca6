//! Where to stand to look through a door: `cargo run -p viewsample --example first_views`.
#![allow(clippy::print_stdout)]

use viewsample::grid::{Grid, Mast};
use viewsample::{Changes, Cluster, Error, Kind, Params, Sampler, Straight, postures};

fn main() -> Result<(), Error> {
    let plan = "
        ####################
        #.......#??????????#
        #.......#??????????#
        #..........????????#
        #..........????????#
        #.......#??????????#
        #.......#??????????#
        ####################";
    let map = Grid::parse(plan, 10, 0.3);
    let robot = Mast {
        map: &map,
        radius: 0.3,
        height: 0.4,
        lift: (0.4, 1.5),
    };
    let params = Params {
        lidar: None,
        ahead: vec![0.1],
        ..Params::default()
    };
    let mut sampler = Sampler::new(&params, postures(&robot, &params)?)?;
    let cells = map.exploration();
    let door = Cluster {
        id: 1,
        kind: Kind::Exploration,
        cells: &cells,
        centroid: [3.2, 1.2, 1.5],
    };
    sampler.update(
        &map,
        &Changes {
            added: &[door],
            boxes: &[map.bounds()],
            ..Changes::default()
        },
    )?;
    let costs = Straight {
        base_speed: 0.8,
        joint_speed: [0.5, 0.8],
    };
    let found = sampler.candidates(&robot, &costs, [0.8, 1.2, 0.0], &[1.0, 0.0])?;
    for view in &found.views {
        println!("stand at {:.2?}, mast at {:.2?}", view.base, view.state);
        println!(
            "sees {} of {} frontier voxels, {:.1} s away",
            view.gain.exploration,
            cells.len(),
            view.seconds
        );
    }
    println!("{:?}", found.effort);
    Ok(())
}
