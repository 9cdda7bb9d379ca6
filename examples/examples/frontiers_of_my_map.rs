//! Where does what I know end? Frontiers of a map of your own: `cargo run --example frontiers_of_my_map`.
#![allow(clippy::print_stdout)]

use frontier::{Cell, Error, Frontiers, Map, Params};

/// An occupancy grid as many robots have one: a byte for each cell, 255 where nothing is known.
struct Costs {
    width: usize,
    cells: Vec<u8>,
}

impl Costs {
    fn at(&self, [x, y, z]: Cell) -> Option<u8> {
        let inside = z == 0 && x >= 0 && (x as usize) < self.width && y >= 0;
        let cell = inside.then(|| x as usize + self.width * y as usize)?;
        self.cells.get(cell).copied()
    }
}

impl Map for Costs {
    fn bounds(&self) -> (Cell, Cell) {
        let height = self.cells.len() / self.width;
        ([0, 0, 0], [self.width as i32, height as i32, 1])
    }
    fn is_free(&self, cell: Cell) -> bool {
        self.at(cell).is_some_and(|c| c < 100)
    }
    fn is_occupied(&self, cell: Cell) -> bool {
        self.at(cell).is_some_and(|c| (100..255).contains(&c))
    }
}

fn main() -> Result<(), Error> {
    let mut map = Costs {
        width: 40,
        cells: vec![255; 40 * 20],
    };
    for y in 5..15 {
        map.cells[y * 40 + 3..y * 40 + 25].fill(0);
    }
    let mut frontiers = Frontiers::new(Params::default())?;
    frontiers.update(&map, &[]);
    for c in frontiers.clusters() {
        println!(
            "{} cells to explore from around {:.1?}",
            c.cells.len(),
            c.centroid
        );
    }

    // The robot sees more: only the box that changed is looked at again.
    for y in 5..15 {
        map.cells[y * 40 + 25..y * 40 + 30].fill(0);
    }
    let update = frontiers.update(&map, &[([25, 5, 0], [30, 15, 1])]);
    println!(
        "{} clusters went, {} came, {} changed",
        update.removed.len(),
        update.added.len(),
        update.changed.len()
    );
    frontier::conformance::check(&map);
    Ok(())
}
