//! `viewsample::Map` for [`VoxelMap`].

use crate::VoxelMap;
use std::ops::ControlFlow;
use viewsample::{Cell, Map};

impl Map for VoxelMap {
    fn cell_size(&self) -> f64 {
        Self::cell_size(self)
    }
    fn cell_at(&self, point: [f64; 3]) -> Cell {
        Self::cell_at(self, point)
    }
    fn center(&self, cell: Cell) -> [f64; 3] {
        Self::center(self, cell)
    }
    fn is_free(&self, cell: Cell) -> bool {
        Self::is_free(self, cell)
    }
    fn is_occupied(&self, cell: Cell) -> bool {
        Self::is_occupied(self, cell)
    }
    fn faces(&self, cell: Cell) -> (u8, u8) {
        (self.open_faces(cell), self.exposed_faces(cell))
    }
    fn walk(&self, from: [f64; 3], to: [f64; 3], visit: &mut dyn FnMut(Cell) -> ControlFlow<()>) {
        Self::walk(self, from, to, visit);
    }
    fn line_of_sight(&self, from: [f64; 3], to: Cell, unknown_allowance: u32) -> bool {
        Self::line_of_sight(self, from, to, unknown_allowance)
    }
}
