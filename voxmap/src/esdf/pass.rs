//! The exact squared distance transform of a box of cells: two sweeps along z, then minima over shifts along y and x.
//!
//! `d^2(x, y, z) = min over (i, j) of (i^2 + (j^2 + sweep^2(x + i, y + j, z)))`, all in whole numbers, so the order of the
//! minima and the box they are computed in cannot change a bit. Values are capped at `(reach + 1)^2`.

use crate::geometry::CellBox;
use crate::map::VoxelMap;
use crate::simd::Kernel;

/// Buffers kept between passes.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    sweep: Vec<u8>,
    plane: Vec<u16>,
    row: Vec<u16>,
}

/// Recomputes the squares of a box inside the map.
pub(super) struct Pass<'a> {
    pub map: &'a VoxelMap,
    pub unknown_is_occupied: bool,
    /// Cells within this distance along an axis count.
    pub reach: usize,
    pub region: CellBox,
    /// All squares of the map, x fastest.
    pub square: &'a mut [u16],
    pub scratch: &'a mut Scratch,
}

/// Work of a box of this size, in units of one cell in one shift; `reach` cells around it take part.
pub(super) fn cost(region: &CellBox, reach: usize, size: [usize; 3]) -> usize {
    let own = [0, 1, 2].map(|a| (region.high[a] - region.low[a]).max(0) as usize);
    let [x, y, z] = [0, 1, 2].map(|a| (own[a] + 2 * reach).min(size[a]));
    // A cell of the sweep costs about 3 units; shifts end early, after about 6.
    3 * x * y * z + 6 * x * own[1] * own[2] + 6 * own[0] * own[1] * own[2]
}

impl Kernel for Pass<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            map,
            unknown_is_occupied,
            reach,
            region,
            square,
            scratch,
        } = self;
        let size = map.size();
        let (low, high) = (
            region.low.map(|v| v as usize),
            region.high.map(|v| v as usize),
        );
        if (0..3).any(|a| low[a] >= high[a]) {
            return;
        }
        // Cells that can reach the region.
        let from = [0, 1, 2].map(|a| low[a].saturating_sub(reach));
        let until = [0, 1, 2].map(|a| (high[a] + reach).min(size[a]));
        let (nx, ny, nz) = (until[0] - from[0], until[1] - from[1], until[2] - from[2]);
        let Scratch { sweep, plane, row } = scratch;

        sweep.resize(nx * ny * nz, 0);
        for z in 0..nz {
            for y in 0..ny {
                let first = map.word(0, y + from[1], z + from[2]);
                let words = first..first + map.words;
                let (free, occupied) = (&map.free[words.clone()], &map.occupied[words]);
                let out = &mut sweep[(z * ny + y) * nx..][..nx];
                open_cells(out, from[0], |w| {
                    if unknown_is_occupied {
                        free[w]
                    } else {
                        !occupied[w]
                    }
                });
            }
        }
        sweep_along(sweep, nx * ny, reach as u8 + 1);

        let cap = ((reach + 1) * (reach + 1)) as u16;
        let inner = high[0] - low[0];
        plane.resize(nx * ny, 0);
        // The row with `reach` cells on both sides.
        row.resize(inner + 2 * reach, cap);
        for z in low[2]..high[2] {
            let layer = &sweep[(z - from[2]) * nx * ny..][..nx * ny];
            for (square, &steps) in plane.iter_mut().zip(layer) {
                *square = u16::from(steps) * u16::from(steps);
            }
            for y in low[1]..high[1] {
                row.fill(cap);
                let start = reach + from[0] - low[0];
                let middle = &mut row[start..start + nx];
                let here = y - from[1];
                middle.copy_from_slice(&plane[here * nx..][..nx]);
                along_y(middle, plane, here, ny, reach);
                let out = &mut square[(z * size[1] + y) * size[0]..][low[0]..high[0]];
                along_x(out, row, reach);
            }
        }
    }
}

/// 255 where a cell is open, 0 where it blocks, for the cells from `x0` on of a row of bits.
#[inline(always)]
fn open_cells(out: &mut [u8], x0: usize, word: impl Fn(usize) -> u64) {
    let mut x = x0;
    let mut rest = out;
    while !rest.is_empty() {
        let n = (64 - x % 64).min(rest.len());
        let bits = word(x / 64) >> (x % 64);
        let (part, after) = rest.split_at_mut(n);
        for (i, cell) in part.iter_mut().enumerate() {
            *cell = 0u8.wrapping_sub((bits >> i & 1) as u8);
        }
        rest = after;
        x += n;
    }
}

/// Turns open (255) and blocked (0) into steps along z to the nearest blocked cell, at most `far`.
#[inline(always)]
fn sweep_along(cells: &mut [u8], layer: usize, far: u8) {
    for cell in &mut cells[..layer] {
        *cell = (*cell).min(far);
    }
    let layers = cells.len() / layer;
    for z in 1..layers {
        let (below, here) = cells[(z - 1) * layer..][..2 * layer].split_at_mut(layer);
        for (cell, &before) in here.iter_mut().zip(&*below) {
            *cell = (*cell).min(before + 1).min(far);
        }
    }
    for z in (1..layers).rev() {
        let (here, above) = cells[(z - 1) * layer..][..2 * layer].split_at_mut(layer);
        for (cell, &after) in here.iter_mut().zip(&*above) {
            *cell = (*cell).min(after + 1);
        }
    }
}

/// `row = min over j of plane[here + j] + j^2`, nearest first, until nothing can improve.
#[inline(always)]
fn along_y(row: &mut [u16], plane: &[u16], here: usize, rows: usize, reach: usize) {
    let nx = row.len();
    let mut worst = row.iter().copied().max().unwrap_or(0);
    for shift in 1..=reach {
        let add = (shift * shift) as u16;
        if worst <= add {
            return;
        }
        let below = here.checked_sub(shift).map(|k| &plane[k * nx..][..nx]);
        let above = (here + shift < rows).then(|| &plane[(here + shift) * nx..][..nx]);
        let (one, other) = match (below, above) {
            (Some(a), Some(b)) => (a, b),
            (Some(a), None) | (None, Some(a)) => (a, a),
            (None, None) => return,
        };
        worst = 0;
        for ((value, &a), &b) in row.iter_mut().zip(one).zip(other) {
            *value = (*value).min(a.min(b).saturating_add(add));
            worst = worst.max(*value);
        }
    }
}

/// `out[x] = min over i of row[reach + x + i] + i^2`, nearest first, until nothing can improve.
#[inline(always)]
fn along_x(out: &mut [u16], row: &[u16], reach: usize) {
    let n = out.len();
    out.copy_from_slice(&row[reach..reach + n]);
    let mut worst = out.iter().copied().max().unwrap_or(0);
    for shift in 1..=reach {
        let add = (shift * shift) as u16;
        if worst <= add {
            return;
        }
        let (left, right) = (&row[reach - shift..][..n], &row[reach + shift..][..n]);
        worst = 0;
        for ((value, &a), &b) in out.iter_mut().zip(left).zip(right) {
            *value = (*value).min(a.min(b).saturating_add(add));
            worst = worst.max(*value);
        }
    }
}
