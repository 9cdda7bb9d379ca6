//! Where a ray crosses the borders of cells and of blocks, in whole numbers, so that many steps at once give the same bits as one
//! at a time.

use crate::geometry::Cell;

/// Time at which a ray ends.
const ONE: f64 = (1u64 << 52) as f64;
/// Crossings after it do not count: a billionth of the ray, more than rounding can move a crossing in 2^22 cells. A ray that
/// ends on the border of the map stays inside.
pub(crate) const END: i64 = (1 << 52) - (1 << 22);
/// After every end; also the longest time between crossings, so that no sum overflows.
const NEVER: i64 = 1 << 53;
/// Cells along the edge of a block.
pub(crate) const BLOCK: i32 = 8;

/// The next crossings on the three axes.
#[derive(Clone, Copy)]
pub(crate) struct Crossings {
    pub(crate) next: [i64; 3],
    pub(crate) delta: [i64; 3],
}

impl Crossings {
    /// Time of the first one, and its axis as masks: all bits of one of three. Ties go to the lower axis. Without branches:
    /// which axis is next is as good as random.
    #[inline(always)]
    pub(crate) fn first(&self) -> (i64, [i64; 3]) {
        let [x, y, z] = self.next;
        let is_x = -i64::from((x <= y) & (x <= z));
        let is_y = -i64::from((y < x) & (y <= z));
        (x.min(y).min(z), [is_x, is_y, !(is_x | is_y)])
    }

    /// Past the crossing on the axis of a mask.
    #[inline(always)]
    pub(crate) fn pass(&mut self, axis: [i64; 3]) {
        for a in 0..3 {
            self.next[a] += self.delta[a] & axis[a];
        }
    }
}

/// The value of the axis of a mask.
#[inline(always)]
pub(crate) fn along(axis: [i64; 3], values: [i64; 3]) -> i64 {
    (values[0] & axis[0]) | (values[1] & axis[1]) | (values[2] & axis[2])
}

/// Cells of a ray inside the map, in stored cells.
pub(crate) struct Steps {
    pub(crate) cell: Cell,
    pub(crate) cells: Crossings,
    pub(crate) step: [i64; 3],
    /// About one over `cells.delta`.
    rate: [f64; 3],
    /// Steps left.
    pub(crate) left: u32,
    /// Whether the ray would leave the map by rounding, so that only counting its steps keeps it inside.
    pub(crate) tight: bool,
}

impl Steps {
    /// From a point inside a map of `size` cells on a way that does not leave it; cell units.
    #[inline]
    pub(crate) fn new(from: [f64; 3], way: [f64; 3], size: [usize; 3]) -> Self {
        let mut steps = Self {
            cell: [0; 3],
            cells: Crossings {
                next: [NEVER; 3],
                delta: [NEVER; 3],
            },
            step: [0; 3],
            rate: [0.0; 3],
            left: 0,
            tight: false,
        };
        for a in 0..3 {
            let top = size[a] as i32 - 1;
            let first = (from[a] as i32).min(top);
            steps.cell[a] = first;
            if way[a] == 0.0 {
                continue;
            }
            let up = way[a] > 0.0;
            let behind = from[a] - f64::from(first);
            let (border, room) = if up {
                (1.0 - behind, top - first)
            } else {
                (behind, first)
            };
            let length = way[a].abs();
            let inverse = ONE / length;
            // Saturates for ways that are far below a cell.
            let next = ((border * inverse + 0.5) as i64).min(NEVER);
            let delta = ((inverse + 0.5) as i64).min(NEVER);
            if next <= END {
                let room = i64::from(room);
                // A crossing past the border is the one that would leave the map.
                steps.tight |= next + room * delta <= END;
                steps.left += ((END - next) / delta + 1).min(room) as u32;
            }
            steps.cells.next[a] = next;
            steps.cells.delta[a] = delta;
            steps.step[a] = if up { 1 } else { -1 };
            steps.rate[a] = length / ONE;
        }
        steps
    }

    /// Crossings of the borders of blocks: some of those of cells.
    #[inline]
    pub(crate) fn blocks(&self) -> Crossings {
        let mut out = self.cells;
        for a in 0..3 {
            let inside = i64::from(self.cell[a] & (BLOCK - 1));
            let before = match self.step[a] {
                0 => 0,
                1 => i64::from(BLOCK) - 1 - inside,
                _ => inside,
            };
            out.next[a] += before * out.delta[a];
            out.delta[a] *= i64::from(BLOCK);
        }
        out
    }

    /// Cell and next crossings of cells right after the crossing of an axis (a mask) at some time.
    #[inline]
    pub(crate) fn after(&self, time: i64, axis: [i64; 3]) -> (Cell, Crossings) {
        // At that very time the lower axes go first.
        let until = [time, time + axis[0], time + (axis[0] | axis[1])];
        let (mut cell, mut cells) = (self.cell, self.cells);
        for a in 0..3 {
            let (span, delta) = (until[a] - cells.next[a], cells.delta[a]);
            // The quotient by a product, which may be one off: rounded down, less than -1 only for a crossing at time 0.
            let mut whole = (span as f64 * self.rate[a]) as i64;
            let rest = span - whole * delta;
            whole += i64::from(rest >= delta) - i64::from(rest < 0);
            let passed = (whole + 1).max(0);
            cells.next[a] += passed * delta;
            cell[a] += (passed * self.step[a]) as i32;
        }
        (cell, cells)
    }
}
