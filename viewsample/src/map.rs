//! What view planning must know about a voxel map.

use std::ops::ControlFlow;

use crate::sight;

/// Index of a voxel: cell (i, j, k) covers `[low + i h, low + (i + 1) h)` on each axis.
pub type Cell = [i32; 3];

/// What view planning must know about a voxel map.
///
/// Laws, tested for your type by [`conformance::check_map`](crate::conformance::check_map):
/// no cell is both free and occupied; a cell outside the map is neither; `cell_at(center(c)) == c`;
/// centres of neighbours are `cell_size` apart; the provided methods agree with the required ones.
pub trait Map {
    /// Edge of a voxel, m.
    fn cell_size(&self) -> f64;
    /// The cell that holds a world point (m). Points outside the map have cells too.
    fn cell_at(&self, point: [f64; 3]) -> Cell;
    /// Centre of a cell in the world, m.
    fn center(&self, cell: Cell) -> [f64; 3];
    /// Observed, and below the occupancy threshold.
    fn is_free(&self, cell: Cell) -> bool;
    /// Observed, and at or above the occupancy threshold.
    fn is_occupied(&self, cell: Cell) -> bool;

    /// The faces of an occupied cell that are open to free space: those not inspected yet, and all of them, as bits in the
    /// order -x, +x, -y, +y, -z, +z. A map that inspects whole voxels says "all".
    ///
    /// With [`Params::max_incidence`](crate::Params::max_incidence) an inspection voxel counts as seen only if one of its open
    /// faces is: the eye is on its outer side, steep enough (from a top or an underside as if it lay in the middle of
    /// its voxel), and has the free cell in front of it in sight.
    fn faces(&self, _cell: Cell) -> (u8, u8) {
        (0b11_1111, 0b11_1111)
    }

    /// Visits the voxels pierced by the segment between two world points in order, the first
    /// and the last included, until `visit` breaks.
    fn walk(&self, from: [f64; 3], to: [f64; 3], visit: &mut dyn FnMut(Cell) -> ControlFlow<()>) {
        if let (Some(a), Some(b)) = (sight::to_cells(self, from), sight::to_cells(self, to)) {
            let _ = sight::walk(a, b, visit);
        }
    }

    /// True if the segment from a world point to the centre of `to` meets no occupied voxel
    /// before `to` and at most `unknown_allowance` unknown ones. The voxel of `from` counts,
    /// the voxel `to` does not.
    fn line_of_sight(&self, from: [f64; 3], to: Cell, unknown_allowance: u32) -> bool {
        sight::line_of_sight(self, from, to, unknown_allowance)
    }

    /// Free and occupied bits of up to 64 cells above `cell`: bit `n` is cell `(i, j, k + n)`.
    /// Bits from `count` on are zero. A map that stores words overrides this.
    fn column(&self, cell: Cell, count: u32) -> (u64, u64) {
        let (mut free, mut occupied) = (0, 0);
        for n in 0..count.min(64) {
            let c = [cell[0], cell[1], cell[2] + n as i32];
            free |= u64::from(self.is_free(c)) << n;
            occupied |= u64::from(self.is_occupied(c)) << n;
        }
        (free, occupied)
    }
}

impl<M: Map + ?Sized> Map for &M {
    fn cell_size(&self) -> f64 {
        (**self).cell_size()
    }
    fn cell_at(&self, point: [f64; 3]) -> Cell {
        (**self).cell_at(point)
    }
    fn center(&self, cell: Cell) -> [f64; 3] {
        (**self).center(cell)
    }
    fn is_free(&self, cell: Cell) -> bool {
        (**self).is_free(cell)
    }
    fn is_occupied(&self, cell: Cell) -> bool {
        (**self).is_occupied(cell)
    }
    fn walk(&self, from: [f64; 3], to: [f64; 3], visit: &mut dyn FnMut(Cell) -> ControlFlow<()>) {
        (**self).walk(from, to, visit);
    }
    fn line_of_sight(&self, from: [f64; 3], to: Cell, unknown_allowance: u32) -> bool {
        (**self).line_of_sight(from, to, unknown_allowance)
    }
    fn column(&self, cell: Cell, count: u32) -> (u64, u64) {
        (**self).column(cell, count)
    }
    fn faces(&self, cell: Cell) -> (u8, u8) {
        (**self).faces(cell)
    }
}
