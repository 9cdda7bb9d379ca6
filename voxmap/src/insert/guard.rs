//! The grazing guard: keeps flat rays from erasing the surfaces they scrape along.
//!
//! A ray that meets a surface at a flat angle first passes through cells that the surface itself lies in, and a scan has far
//! more passes than returns there; OctoMap frees a quarter of a building's surface cells that way. Two rules help:
//!
//! 1. The *tail* of such a ray passes nothing: where the scan and the map show a sheet at the ray's end (cells beside the end are
//!    hit or occupied, none above or below it along one axis), the last cells in the sheet's layer are left as they are. A
//!    *thorough* guard asks only that none is in the layer that the ray would have gone on to, so that a floor is a sheet up to
//!    the foot of a wall, and looks for cells beside the end a little farther away where the scan is so coarse that none touch.
//! 2. An occupied cell that has a hit cell among its 26 neighbours in the same scan is *protected*: the surface is still
//!    there, so that only every so many scans may a pass count against it.

use super::Window;
use super::rays::{Batch, ONE};
use crate::geometry::Cell;
use crate::map::VoxelMap;

/// Options of the grazing guard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrazingGuard {
    /// Longest tail of a ray that passes nothing, m; 0 switches the rule off.
    pub tail: f64,
    /// A protected cell loses in one scan of this many; 1 switches the rule off. The larger, the longer stay the outermost
    /// cells of things that moved away from a wall or stood on the floor.
    pub patience: u32,
    /// Sheets are also seen in coarse scans and at the feet of walls. Leaves fewer surface cells free, and here and there
    /// space unknown that a ray has passed.
    pub thorough: bool,
}

impl GrazingGuard {
    /// For maps of coarse scans: half as many surface cells count as free as without a guard (measured: `bench_scans`); tails of
    /// up to 2 m, thorough, nothing protected. At most 2 % more empty cells count as occupied: noise puts returns in front of a
    /// surface, and passes are withheld that would have spoken against them. [`hit_depth`](super::Scan::hit_depth) takes far more
    /// of them away.
    pub fn thorough() -> Self {
        Self {
            tail: 2.0,
            patience: 1,
            thorough: true,
        }
    }
}

impl Default for GrazingGuard {
    /// Tails of up to 1.5 m, one scan in 16.
    fn default() -> Self {
        Self {
            tail: 1.5,
            patience: 16,
            thorough: false,
        }
    }
}

/// Bits of the cells of a 3 x 3 x 3 block around a cell: x + 3 y + 9 z.
const CENTER: u32 = 1 << 13;
/// The layers on both sides of the cell's own, across each axis: lower, higher.
const NEXT: [[u32; 2]; 3] = [
    [0o111_111_111, 0o444_444_444],
    [0o007_007_007, 0o700_700_700],
    [0o000_000_777, 0o777_000_000],
];
/// The cell's own layer across each axis, without the cell.
const BESIDE: [u32; 3] = [
    0o222_222_222 & !CENTER,
    0o070_070_070 & !CENTER,
    0o000_777_000 & !CENTER,
];
/// Cells within which neighbours of a lonely end are looked for.
const FAR: i32 = 3;

impl VoxelMap {
    /// Brings the end of a ray's passes, a time in the lanes' units, before the tail.
    pub(super) fn cut_tail(
        &self,
        window: &Window,
        batch: &mut Batch,
        ray: usize,
        guard: GrazingGuard,
    ) {
        let from = [0, 1, 2].map(|a| batch.from[a][ray]);
        let to = [0, 1, 2].map(|a| batch.to[a][ray]);
        let way = [0, 1, 2].map(|a| (to[a] - from[a]).abs());
        let end: Cell = to.map(|v| v as i32);
        let longest = (0..3).fold(0, |best, a| if way[a] > way[best] { a } else { best });
        let block = self.block(window, end);
        let (beside, beyond) = if guard.thorough {
            let ahead = [0, 1, 2].map(|a| usize::from(to[a] > from[a]));
            if block & !CENTER == 0 {
                self.far_sheets(window, end, ahead)
            } else {
                (
                    BESIDE.map(|layer| block & layer != 0),
                    [0, 1, 2].map(|a| block & NEXT[a][ahead[a]] != 0),
                )
            }
        } else {
            (
                BESIDE.map(|layer| block & layer != 0),
                NEXT.map(|[low, high]| block & (low | high) != 0),
            )
        };
        let flat = |a: &usize| *a != longest && beside[*a] && !beyond[*a];
        let mut flat = (0..3).filter(flat);
        // The one axis across which the surface lies flat.
        let (Some(a), None) = (flat.next(), flat.next()) else {
            return;
        };
        // A ray that comes in through an upper face starts in the last cell.
        let start = (from[a] as i32).min(self.size[a] as i32 - 1);
        let crossings = start.abs_diff(end[a]) as i32;
        let last = match crossings {
            0 => 0,
            n => batch.next[a][ray] + (n - 1) * batch.delta[a][ray],
        };
        let length = way.iter().map(|v| v * v).sum::<f64>().sqrt() * self.cell_size;
        let limit = ((1.0 - guard.tail / length).max(0.0) * f64::from(ONE)) as i32;
        batch.end[ray] = last.max(limit).min(ONE) - 1;
    }

    /// For each axis: whether cells in a cell's own layer are hit or occupied, and cells in the layer ahead (0: lower, 1:
    /// higher), within some cells.
    fn far_sheets(&self, window: &Window, cell: Cell, ahead: [usize; 3]) -> ([bool; 3], [bool; 3]) {
        let ahead = ahead.map(|up| 2 * up as i32 - 1);
        let (mut beside, mut beyond) = ([false; 3], [false; 3]);
        for dz in -FAR..=FAR {
            for dy in -FAR..=FAR {
                let (y, z) = (cell[1] + dy, cell[2] + dz);
                if y < 0 || z < 0 || y as usize >= self.size[1] || z as usize >= self.size[2] {
                    continue;
                }
                let row = self.word(0, y as usize, z as usize);
                let word = |w: i32| {
                    if (0..self.words as i32).contains(&w) {
                        let at = row + w as usize;
                        window.hit[at] | self.occupied[at]
                    } else {
                        0
                    }
                };
                // Bit FAR is the cell's own place along x.
                let (w, shift) = ((cell[0] - FAR).div_euclid(64), (cell[0] - FAR) & 63);
                let bits = match shift {
                    0 => word(w),
                    _ => word(w) >> shift | word(w + 1) << (64 - shift),
                };
                let mut bits = bits & ((2 << (2 * FAR)) - 1);
                if (dy, dz) == (0, 0) {
                    bits &= !(1 << FAR);
                }
                let in_row = bits != 0;
                beside[0] |= bits >> FAR & 1 != 0;
                beyond[0] |= bits >> (FAR + ahead[0]) & 1 != 0;
                beside[1] |= in_row && dy == 0;
                beyond[1] |= in_row && dy == ahead[1];
                beside[2] |= in_row && dz == 0;
                beyond[2] |= in_row && dz == ahead[2];
            }
        }
        (beside, beyond)
    }

    /// Hit or occupied cells of the block around a cell.
    fn block(&self, window: &Window, cell: Cell) -> u32 {
        let mut block = 0;
        for dz in -1..=1 {
            for dy in -1..=1 {
                let (y, z) = (cell[1] + dy, cell[2] + dz);
                if y < 0 || z < 0 || y as usize >= self.size[1] || z as usize >= self.size[2] {
                    continue;
                }
                let row = self.word(0, y as usize, z as usize);
                let word = |x: i32| {
                    let at = row + x as usize / 64;
                    window.hit[at] | self.occupied[at]
                };
                let x = cell[0];
                let bits = if x & 63 != 0 && x & 63 != 63 {
                    word(x) >> ((x & 63) - 1) & 7
                } else {
                    (-1..=1)
                        .filter(|dx| x + dx >= 0 && ((x + dx) as usize) < self.words * 64)
                        .fold(0, |bits, dx| {
                            bits | (word(x + dx) >> ((x + dx) & 63) & 1) << (dx + 1)
                        })
                };
                block |= (bits as u32) << (3 * (dy + 1) + 9 * (dz + 1));
            }
        }
        block
    }

    /// Takes back the passes through occupied cells beside hit ones.
    pub(super) fn protect(&self, window: &mut Window) {
        let [(y0, y1), (z0, z1)] = window.rows;
        for z in z0..z1 {
            for y in y0..y1 {
                let row = self.word(0, y, z);
                for w in 0..self.words {
                    let at = row + w;
                    let lost = window.passed[at] & !window.hit[at] & self.occupied[at];
                    if lost != 0 {
                        window.passed[at] &= !(lost & self.beside_hits(window, w, y, z));
                    }
                }
            }
        }
    }

    /// Cells of a word with a hit cell among their 26 neighbours.
    fn beside_hits(&self, window: &Window, w: usize, y: usize, z: usize) -> u64 {
        let mut beside = 0;
        for z in z.saturating_sub(1)..(z + 2).min(self.size[2]) {
            for y in y.saturating_sub(1)..(y + 2).min(self.size[1]) {
                let at = self.word(w, y, z);
                let hit = window.hit[at];
                beside |= hit | hit << 1 | hit >> 1;
                if w > 0 {
                    beside |= window.hit[at - 1] >> 63;
                }
                if w + 1 < self.words {
                    beside |= window.hit[at + 1] << 63;
                }
            }
        }
        beside
    }
}
