//! The straight line through voxels, column by column.
//!
//! A segment is cut where it changes its (i, j) column; inside one column it pierces a run of
//! cells in z. All sight tests of the crate share this arithmetic, so that the bit-parallel
//! version in `columns` gives the same answer as the one over single cells, bit for bit.

use std::ops::ControlFlow;

use crate::map::{Cell, Map};

/// Beyond this many cells from the origin, points count as outside any map.
const FAR: f64 = 1e7;

/// A world point in cell units: cell (i, j, k) covers `[i, i + 1)` and so on. None if not finite
/// or absurdly far away.
pub(crate) fn to_cells<M: Map + ?Sized>(map: &M, p: [f64; 3]) -> Option<[f64; 3]> {
    let (zero, h) = (map.center([0; 3]), map.cell_size());
    let g = [0, 1, 2].map(|a| (p[a] - zero[a]) / h + 0.5);
    g.iter().all(|v| v.abs() < FAR).then_some(g)
}

/// Floor without a call into the maths library.
#[inline]
pub(crate) fn floor(x: f64) -> i32 {
    let i = x as i32;
    // Saturated values wrap; callers keep away from them.
    i.wrapping_sub(i32::from(x < f64::from(i)))
}

/// The columns pierced by a segment in the plane, in order.
#[derive(Clone, Debug)]
pub(crate) struct ColumnWalk {
    from: [f64; 2],
    inverse: [f64; 2],
    step: [i32; 2],
    left: [u32; 2],
    edge: [f64; 2],
    next: [f64; 2],
    /// Current column.
    pub(crate) at: [i32; 2],
}

impl ColumnWalk {
    #[inline]
    pub(crate) fn new(from: [f64; 2], to: [f64; 2]) -> Self {
        let at = from.map(floor);
        let end = to.map(floor);
        let mut w = Self {
            from,
            inverse: [0.0; 2],
            step: [0; 2],
            left: [0; 2],
            edge: [0.0; 2],
            next: [f64::INFINITY; 2],
            at,
        };
        for a in 0..2 {
            w.left[a] = end[a].abs_diff(at[a]);
            if w.left[a] > 0 {
                w.inverse[a] = 1.0 / (to[a] - from[a]);
                w.step[a] = if end[a] > at[a] { 1 } else { -1 };
                w.edge[a] = f64::from(at[a] + i32::from(end[a] > at[a]));
                w.next[a] = (w.edge[a] - from[a]) * w.inverse[a];
            }
        }
        w
    }

    /// Where the segment leaves the current column: its parameter in [0, 1] and the axis
    /// crossed; None in the last column. Ties go to x.
    #[inline]
    pub(crate) fn exit(&self) -> Option<(f64, usize)> {
        let axis = usize::from(self.next[1] < self.next[0]);
        (self.left[axis] > 0).then_some((self.next[axis], axis))
    }

    /// Enters the next column across `axis`; returns the index step.
    #[inline]
    pub(crate) fn cross(&mut self, axis: usize) -> i32 {
        let step = self.step[axis];
        self.at[axis] += step;
        self.left[axis] -= 1;
        self.edge[axis] += f64::from(step);
        self.next[axis] = if self.left[axis] > 0 {
            (self.edge[axis] - self.from[axis]) * self.inverse[axis]
        } else {
            f64::INFINITY
        };
        step
    }
}

/// Binary digits behind the point of a height in cells, and of a parameter in [0, 1].
const HEIGHT: u32 = 20;
const PARAMETER: u32 = 30;

/// A height in cells as a whole number of 2^-20 cells.
#[inline]
pub(crate) fn height(z: f64) -> i64 {
    (z * f64::from(1 << HEIGHT)) as i64
}

/// A parameter in [0, 1] as a whole number of 2^-30.
#[inline]
pub(crate) fn parameter(t: f64) -> i64 {
    (t * f64::from(1 << PARAMETER)) as i64
}

/// The cell in z at a parameter of a segment that starts at height `z` and rises by `dz`, for
/// segments of less than 8000 cells. Whole numbers: cheap, and the same whoever asks.
#[inline]
pub(crate) fn cell_in_z(z: i64, dz: i64, t: i64) -> i32 {
    (((z << PARAMETER) + dz * t) >> (HEIGHT + PARAMETER)) as i32
}

/// [`cell_in_z`] for segments of any length.
fn far_cell_in_z(z: i64, dz: i64, t: i64) -> i32 {
    (((i128::from(z) << PARAMETER) + i128::from(dz) * i128::from(t)) >> (HEIGHT + PARAMETER)) as i32
}

pub(crate) fn walk(
    from: [f64; 3],
    to: [f64; 3],
    visit: &mut dyn FnMut(Cell) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let mut columns = ColumnWalk::new([from[0], from[1]], [to[0], to[1]]);
    // Seen from the cell of `from`, so that numbers stay small.
    let ground = floor(from[2]);
    let z = height(from[2] - f64::from(ground));
    let dz = height(to[2] - f64::from(ground)) - z;
    let near = dz.abs() < 8000 << HEIGHT;
    let at = |t: f64| {
        let t = parameter(t);
        ground
            + if near {
                cell_in_z(z, dz, t)
            } else {
                far_cell_in_z(z, dz, t)
            }
    };
    let mut k0 = ground;
    loop {
        let exit = columns.exit();
        let k1 = at(exit.map_or(1.0, |e| e.0));
        for n in 0..=(k1 - k0).abs() {
            let k = if k1 < k0 { k0 - n } else { k0 + n };
            visit([columns.at[0], columns.at[1], k])?;
        }
        let Some((_, axis)) = exit else {
            return ControlFlow::Continue(());
        };
        columns.cross(axis);
        k0 = k1;
    }
}

/// The definition of sight; see [`Map::line_of_sight`].
pub(crate) fn line_of_sight<M: Map + ?Sized>(
    map: &M,
    from: [f64; 3],
    to: Cell,
    allowance: u32,
) -> bool {
    let Some(from) = to_cells(map, from) else {
        return false;
    };
    let state = |c| (map.is_free(c), map.is_occupied(c));
    sees(from, to, allowance, state)
}

/// Sight from a point in cell units over a function cell -> (free, occupied).
pub(crate) fn sees(
    from: [f64; 3],
    to: Cell,
    allowance: u32,
    state: impl Fn(Cell) -> (bool, bool),
) -> bool {
    let mut unknown = 0;
    let end = to.map(|v| f64::from(v) + 0.5);
    walk(from, end, &mut |c| {
        if c == to {
            return ControlFlow::Continue(());
        }
        let (free, occupied) = state(c);
        if !free {
            unknown += 1;
            if occupied || unknown > allowance {
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    })
    .is_continue()
}
