//! Prints the frontier clusters of a small floor plan.
#![allow(clippy::print_stdout)]

use frontier::grid::Grid;
use frontier::{Error, Frontiers, Params};

fn main() -> Result<(), Error> {
    let map = Grid::parse(
        "############\n\
         #......#????\n\
         #..........?\n\
         #......#????\n\
         ###.####????\n\
         ???.????????",
    );
    let mut frontiers = Frontiers::new(Params::default())?;
    frontiers.update(&map, &[]);
    for c in frontiers.clusters() {
        let [x, y, _] = c.centroid;
        println!(
            "{:?} cluster {} of {} cells around ({x:.1}, {y:.1}), small: {}",
            c.kind,
            c.id,
            c.cells.len(),
            c.small
        );
    }
    Ok(())
}
