//! Rays through the map: exact 6-connected traversal, casts and lines of sight.

use crate::geometry::Cell;
use crate::map::VoxelMap;
use std::ops::ControlFlow;

/// What a cast does at unknown cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnknownPolicy {
    /// Passes through them.
    Pass,
    /// Stops at the first.
    Stop,
}

/// Where a cast ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The last cell looked at.
    pub cell: Cell,
    /// True if that cell is occupied.
    pub occupied: bool,
    /// Length of the ray up to the border of that cell, or the whole length if nothing stopped it, m.
    pub distance: f64,
    /// Unknown cells passed or stopped at.
    pub unknown: u32,
}

/// The cells between two points, one step along one axis at a time. Ends by count in the cell of the second point, so it
/// can neither miss it nor run on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Walk {
    pub cell: Cell,
    pub step: Cell,
    left: [u32; 3],
    next: [f64; 3],
    delta: [f64; 3],
    /// Parameter 0..1 at which the current cell was entered.
    pub entered: f64,
}

impl Walk {
    /// `from` and `to` in cell units relative to the map's corner.
    #[inline]
    pub(crate) fn new(from: [f64; 3], to: [f64; 3]) -> Self {
        let cell = from.map(|v| v.floor() as i32);
        let end = to.map(|v| v.floor() as i32);
        let mut walk = Self {
            cell,
            step: [0; 3],
            left: [0; 3],
            next: [f64::INFINITY; 3],
            delta: [f64::INFINITY; 3],
            entered: 0.0,
        };
        for a in 0..3 {
            let cells = end[a].wrapping_sub(cell[a]);
            walk.left[a] = cells.unsigned_abs();
            if cells != 0 {
                walk.step[a] = cells.signum();
                walk.delta[a] = 1.0 / (to[a] - from[a]).abs();
                let border = f64::from(cell[a]) + if cells > 0 { 1.0 } else { 0.0 };
                walk.next[a] = (border - from[a]).abs() * walk.delta[a];
            }
        }
        walk
    }

    /// The axis of the next step, or `None` in the last cell.
    #[inline]
    pub(crate) fn advance(&mut self) -> Option<usize> {
        let axis = if self.next[0] <= self.next[1] {
            if self.next[0] <= self.next[2] { 0 } else { 2 }
        } else if self.next[1] <= self.next[2] {
            1
        } else {
            2
        };
        if self.left[axis] == 0 {
            return None;
        }
        self.left[axis] -= 1;
        self.cell[axis] += self.step[axis];
        self.entered = self.next[axis];
        if self.left[axis] == 0 {
            self.next[axis] = f64::INFINITY;
        } else {
            self.next[axis] += self.delta[axis];
        }
        Some(axis)
    }
}

impl VoxelMap {
    /// A point in cell units.
    #[inline]
    pub(crate) fn scaled(&self, point: [f64; 3]) -> [f64; 3] {
        let inverse = 1.0 / self.cell_size;
        [0, 1, 2].map(|a| (point[a] - self.low[a]) * inverse)
    }

    /// Visits the cells from one point to another in order, both ends included, until the visitor breaks; also cells
    /// outside the map. Nothing is visited for points that are not finite.
    pub fn walk(
        &self,
        from: [f64; 3],
        to: [f64; 3],
        mut visit: impl FnMut(Cell) -> ControlFlow<()>,
    ) {
        if !from.iter().chain(&to).all(|v| v.is_finite()) {
            return;
        }
        let mut walk = Walk::new(self.scaled(from), self.scaled(to));
        loop {
            if visit(walk.cell).is_break() || walk.advance().is_none() {
                return;
            }
        }
    }

    /// Casts a ray until it meets an occupied cell, leaves the map, or has gone `max` m. The direction need not be unit.
    pub fn cast(
        &self,
        origin: [f64; 3],
        direction: [f64; 3],
        max: f64,
        unknown: UnknownPolicy,
    ) -> Hit {
        let norm = direction.iter().map(|v| v * v).sum::<f64>().sqrt();
        let mut hit = Hit {
            cell: self.cell_at(origin),
            occupied: false,
            distance: 0.0,
            unknown: 0,
        };
        let end = [0, 1, 2].map(|a| origin[a] + direction[a] / norm * max);
        if !origin.iter().chain(&end).all(|v| v.is_finite()) {
            return hit;
        }
        let mut walk = Walk::new(self.scaled(origin), self.scaled(end));
        loop {
            hit.cell = walk.cell;
            hit.distance = walk.entered * max;
            if !self.contains(walk.cell) {
                return hit;
            }
            let address = self.address(walk.cell);
            if Self::bit(&self.occupied, address) {
                hit.occupied = true;
                return hit;
            }
            if !Self::bit(&self.free, address) {
                hit.unknown += 1;
                if unknown == UnknownPolicy::Stop {
                    return hit;
                }
            }
            if walk.advance().is_none() {
                hit.distance = max;
                return hit;
            }
        }
    }

    /// True if the straight line from a point to the centre of a cell meets no other occupied cell and at most
    /// `unknown_allowance` unknown ones. The end cell itself may be anything.
    pub fn line_of_sight(&self, from: [f64; 3], to: Cell, unknown_allowance: u32) -> bool {
        let start = self.scaled(from);
        if !start.iter().all(|v| v.is_finite()) {
            return false;
        }
        let end = to.map(|v| f64::from(v) + 0.5);
        let mut walk = Walk::new(start, end);
        if !self.contains(walk.cell) || !self.contains(to) {
            return self.line_of_sight_outside(walk, to, unknown_allowance);
        }
        // Both ends inside: so is the line, and addresses change by a constant along each axis.
        let row = self.words * 64;
        let steps = [
            walk.step[0] as isize,
            walk.step[1] as isize * row as isize,
            walk.step[2] as isize * (row * self.size[1]) as isize,
        ];
        let mut address = self.address(walk.cell) as isize;
        let mut unknown = 0;
        while walk.cell != to {
            let (word, bit) = (address as usize >> 6, address as usize & 63);
            if self.occupied[word] >> bit & 1 != 0 {
                return false;
            }
            if self.free[word] >> bit & 1 == 0 {
                unknown += 1;
                if unknown > unknown_allowance {
                    return false;
                }
            }
            match walk.advance() {
                Some(axis) => address += steps[axis],
                None => break,
            }
        }
        true
    }

    fn line_of_sight_outside(&self, mut walk: Walk, to: Cell, unknown_allowance: u32) -> bool {
        let mut unknown = 0;
        while walk.cell != to {
            if self.is_occupied(walk.cell) {
                return false;
            }
            if !self.is_known(walk.cell) {
                unknown += 1;
                if unknown > unknown_allowance {
                    return false;
                }
            }
            if walk.advance().is_none() {
                break;
            }
        }
        true
    }
}
