//! Rays through the map: exact 6-connected traversal, casts and lines of sight.

use crate::geometry::Cell;
use crate::map::VoxelMap;
use std::ops::ControlFlow;

/// What a cast does at unknown cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnknownPolicy {
    /// Passes through them and counts them.
    Pass,
    /// Passes through them without counting, which lets a cast skip empty blocks of 8 x 8 x 8 cells at once.
    Ignore,
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
    /// Unknown cells passed or stopped at; 0 if they are ignored.
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
    /// outside the map. Nothing is visited if a point is not finite or farther than 2^22 cells from the map's corner.
    pub fn walk(
        &self,
        from: [f64; 3],
        to: [f64; 3],
        mut visit: impl FnMut(Cell) -> ControlFlow<()>,
    ) {
        let (from, to) = (self.scaled(from), self.scaled(to));
        if !(is_near(from) && is_near(to)) {
            return;
        }
        let mut walk = Walk::new(from, to);
        loop {
            let cell = [0, 1, 2].map(|a| walk.cell[a] + self.first[a]);
            if visit(cell).is_break() || walk.advance().is_none() {
                return;
            }
        }
    }

    /// The part of a segment (start and way in cells) inside the map, as parameters in 0..1.
    pub(crate) fn crossing(&self, start: [f64; 3], way: [f64; 3]) -> Option<(f64, f64)> {
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for a in 0..3 {
            let size = self.size[a] as f64;
            if way[a] == 0.0 {
                if start[a] < 0.0 || start[a] >= size {
                    return None;
                }
            } else {
                let (t0, t1) = (-start[a] / way[a], (size - start[a]) / way[a]);
                enter = enter.max(t0.min(t1));
                leave = leave.min(t0.max(t1));
            }
        }
        (enter < leave).then_some((enter, leave))
    }

    /// True if the straight line from a point to the centre of a cell meets no other occupied cell and at most
    /// `unknown_allowance` unknown ones. The point's own cell counts, the end cell does not; cells outside the map are
    /// unknown. False from points that are not finite or farther than 2^22 cells away.
    pub fn line_of_sight(&self, from: [f64; 3], to: Cell, unknown_allowance: u32) -> bool {
        let start = self.scaled(from);
        let to = self.stored(to);
        let end = to.map(|v| f64::from(v) + 0.5);
        if !(is_near(start) && is_near(end)) {
            return false;
        }
        let cell = start.map(|v| v.floor() as i32);
        let inside = |c: Cell| (0..3).all(|a| (c[a] as u32 as usize) < self.size[a]);
        if !inside(cell) || !inside(to) {
            return self.line_of_sight_outside(Walk::new(start, end), to, unknown_allowance);
        }
        // Both ends inside: so is the line. Times of crossings as in the traversal of scans, but one ray at a time: whole
        // numbers, ONE at the end, which is half a cell from any border, so that rounding cannot add or lose a step.
        const ONE: f64 = (1 << 30) as f64;
        let row = self.words * 64;
        let stride = [1, row as isize, (row * self.size[1]) as isize];
        let (mut next, mut delta, mut step) = ([i32::MAX; 3], [0; 3], [0; 3]);
        let mut steps = 0;
        for a in 0..3 {
            let cells = to[a] - cell[a];
            if cells != 0 {
                let border = f64::from(cell[a]) + if cells > 0 { 1.0 } else { 0.0 };
                let inverse = ONE / (end[a] - start[a]).abs();
                next[a] = ((border - start[a]).abs() * inverse + 0.5) as i32;
                delta[a] = (inverse + 0.5) as i32;
                step[a] = cells.signum() as isize * stride[a];
                steps += cells.unsigned_abs();
            }
        }
        let mut address = self.inner(cell) as isize;
        let mut unknown = 0;
        for _ in 0..steps {
            let (word, bit) = (address as usize >> 6, address as usize & 63);
            if self.occupied[word] >> bit & 1 != 0 {
                return false;
            }
            unknown += !(self.free[word] >> bit) as u32 & 1;
            if unknown > unknown_allowance {
                return false;
            }
            // Without branches: which axis is next is as good as random.
            let first = next[0].min(next[1]).min(next[2]);
            let x = next[0] == first;
            let y = !x & (next[1] == first);
            let z = !(x | y);
            for (a, along) in [x, y, z].into_iter().enumerate() {
                next[a] = next[a].saturating_add(delta[a] & -i32::from(along));
                address += step[a] & -isize::from(along);
            }
        }
        true
    }

    fn line_of_sight_outside(&self, mut walk: Walk, to: Cell, unknown_allowance: u32) -> bool {
        let mut unknown = 0;
        while walk.cell != to {
            let cell = [0, 1, 2].map(|a| walk.cell[a].wrapping_add(self.first[a]));
            if self.is_occupied(cell) {
                return false;
            }
            if !self.is_known(cell) {
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

/// True for a point (cells) near enough for a walk to end soon.
fn is_near(point: [f64; 3]) -> bool {
    // Also false for NaN.
    point.iter().all(|v| v.abs() <= f64::from(1 << 22))
}
