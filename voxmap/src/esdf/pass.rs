//! The exact squared distance transform of a box of cells: two sweeps along z, then minima over shifts along x and y.
//!
//! `d^2(x, y, z) = min over (i, j) of (i^2 + (j^2 + sweep^2(x + i, y + j, z)))`, all in whole numbers, so the order of the
//! minima and the box they are computed in cannot change a bit. Values are capped at `(reach + 1)^2`.
//!
//! Cells go together in blocks across the shifts: along y for the sweeps and for x, then, turned over, along x for y.

use super::column::{Block, Column, LANES, counting};
use super::turn::{Tile, turn, turn_bits};
use crate::geometry::CellBox;
use crate::map::VoxelMap;
use crate::simd::Kernel;

/// Steps along z to the nearest obstacle, of a block of cells.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Steps([u8; LANES]);

/// Buffers kept between passes.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// For 64 cells along x each, in every layer: bits of 64 cells along y.
    bits: Vec<[u64; LANES]>,
    /// All layers of one block: steps along z to the nearest obstacle.
    slice: Vec<Steps>,
    /// Layer by layer, block row by block row, along x.
    sweep: Vec<Steps>,
    /// For the minima along x.
    along: Column,
    /// For the minima along y, a column for every 64 cells along x.
    across: Vec<Column>,
    tile: Tile,
    spare: Tile,
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
    3 * x * y * z + 6 * own[0] * y * own[2] + 6 * own[0] * own[1] * own[2]
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
        let low = region.low.map(|v| v as usize);
        let high = region.high.map(|v| v as usize);
        if (0..3).any(|a| low[a] >= high[a]) {
            return;
        }
        // Cells that can reach the region.
        let from = [0, 1, 2].map(|a| low[a].saturating_sub(reach));
        let until = [0, 1, 2].map(|a| (high[a] + reach).min(size[a]));
        let [nx, ny, nz] = [0, 1, 2].map(|a| until[a] - from[a]);
        let inner = [0, 1, 2].map(|a| high[a] - low[a]);
        let bands = ny.div_ceil(LANES);
        let Scratch {
            bits,
            slice,
            sweep,
            along,
            across,
            tile,
            spare,
        } = scratch;

        sweep.resize(inner[2] * bands * nx, Steps([0; LANES]));
        bits.resize(nz, [0; LANES]);
        slice.resize(nz, Steps([0; LANES]));
        for band in 0..bands {
            let y0 = from[1] + band * LANES;
            for x in (0..nx).step_by(LANES) {
                for (z, bits) in (from[2]..).zip(bits.iter_mut()) {
                    for (y, bits) in (y0..until[1]).zip(bits.iter_mut()) {
                        let row = map.word(0, y, z)..map.word(0, y, z) + map.words;
                        *bits = if unknown_is_occupied {
                            bits_from(&map.free[row], from[0] + x)
                        } else {
                            !bits_from(&map.occupied[row], from[0] + x)
                        };
                    }
                    turn_bits(bits);
                }
                for x in x..nx.min(x + LANES) {
                    for (cells, bits) in slice.iter_mut().zip(&*bits) {
                        let bits = bits[x % LANES];
                        for (i, cell) in cells.0.iter_mut().enumerate() {
                            *cell = 0u8.wrapping_sub((bits >> i & 1) as u8);
                        }
                    }
                    sweep_along(slice, reach as u8 + 1);
                    let to = sweep[band * nx + x..].iter_mut().step_by(bands * nx);
                    for (to, steps) in to.zip(&slice[low[2] - from[2]..]) {
                        *to = *steps;
                    }
                }
            }
        }

        along.reset(reach, inner[0]);
        across.resize_with(inner[0].div_ceil(LANES), Column::default);
        for column in &mut *across {
            column.reset(reach, inner[1]);
        }
        for (z, layer) in (low[2]..high[2]).zip(sweep.chunks_exact(bands * nx)) {
            for (band, steps) in layer.chunks_exact(nx).enumerate() {
                let lanes = (ny - band * LANES).min(LANES);
                let counts = counting(lanes);
                for (x, steps) in (from[0]..).zip(steps) {
                    let block = Block(steps.0.map(|n| u16::from(n) * u16::from(n)));
                    along.set(x as isize - low[0] as isize, block, &counts);
                }
                along.plan();
                for (i, column) in across.iter_mut().enumerate() {
                    let cells = (inner[0] - i * LANES).min(LANES);
                    for (x, block) in tile.0[..cells].iter_mut().enumerate() {
                        *block = along.least(i * LANES + x, &counts);
                    }
                    turn(tile, spare);
                    let counts = counting(cells);
                    let y0 = (from[1] + band * LANES) as isize - low[1] as isize;
                    for (y, block) in (y0..).zip(&tile.0[..lanes]) {
                        column.set(y, *block, &counts);
                    }
                }
            }
            for (i, column) in across.iter_mut().enumerate() {
                column.plan();
                let (x0, cells) = (low[0] + i * LANES, (inner[0] - i * LANES).min(LANES));
                let counts = counting(cells);
                for y in 0..inner[1] {
                    let block = column.least(y, &counts);
                    let out = &mut square[(z * size[1] + low[1] + y) * size[0] + x0..][..cells];
                    if let Ok(out) = <&mut [u16; LANES]>::try_from(&mut *out) {
                        *out = block.0;
                    } else {
                        out.copy_from_slice(&block.0[..cells]);
                    }
                }
            }
        }
    }
}

/// 64 bits of a row from bit `x` on; zero beyond its end.
#[inline(always)]
fn bits_from(row: &[u64], x: usize) -> u64 {
    let word = |w: usize| row.get(w).copied().unwrap_or(0);
    match x % 64 {
        0 => word(x / 64),
        shift => word(x / 64) >> shift | word(x / 64 + 1) << (64 - shift),
    }
}

/// Turns open (255) and blocked (0) into steps along z to the nearest blocked cell, at most `far`.
#[inline(always)]
fn sweep_along(layers: &mut [Steps], far: u8) {
    let mut before = Steps([far; LANES]);
    for layer in &mut *layers {
        before = nearer(layer, &before, far);
        *layer = before;
    }
    for layer in layers.iter_mut().rev() {
        before = nearer(layer, &before, far);
        *layer = before;
    }
}

/// The less of the own steps, one more than the others, and `far`.
#[inline(always)]
fn nearer(own: &Steps, others: &Steps, far: u8) -> Steps {
    let mut out = *own;
    for i in 0..LANES {
        out.0[i] = own.0[i].min(others.0[i].saturating_add(1)).min(far);
    }
    out
}
