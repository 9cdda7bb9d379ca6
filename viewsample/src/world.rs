//! The sampler's own picture of the map and the frontiers: one bit a cell, words along z.
//!
//! A column of 64 cells is one word, so a ray asks a whole run of cells with one mask, and all
//! frontier cells of a column share one walk through the plane.

use crate::map::{Cell, Map};
use crate::sight::{self, ColumnWalk};
use crate::{Error, dirty::Dirty, totals::Totals};

/// Margin added around boxes beyond the present extent, cells, so that growth is rare.
const MARGIN: i32 = 16;
/// Faces that look down or up; bits as in [`Map::faces`].
const LEVEL: u8 = 0b11_0000;
/// Most cells stored.
const MOST_CELLS: u64 = 1 << 31;

/// Bits of the map and of the frontiers.
#[derive(Clone, Debug, Default)]
pub(crate) struct World {
    /// Lowest cell stored.
    pub(crate) low: Cell,
    /// Number of columns in x and y.
    pub(crate) size: [usize; 2],
    /// Lowest and highest z of any frontier cell so far; empty at first.
    span: Option<[i32; 2]>,
    /// Words a column.
    pub(crate) words: usize,
    /// Edge of a cell, m; 0 until the first update.
    pub(crate) cell_size: f64,
    /// Centre of cell (0, 0, 0), m.
    pub(crate) zero: [f64; 3],
    free: Vec<u64>,
    occupied: Vec<u64>,
    /// Exploration frontier cells.
    pub(crate) exploration: Vec<u64>,
    /// Inspection frontier cells.
    pub(crate) inspection: Vec<u64>,
    /// Columns that hold frontier cells: a bit each, rows of whole words.
    settled: Vec<u64>,
    /// Inspection frontier cells, and others, with a level face to inspect.
    level: Vec<u64>,
    /// How many times an inspection frontier cell with a level face counts.
    level_weight: u32,
    /// Whether level faces came or went in this update.
    releveled: bool,
    /// Open and exposed faces of inspection frontier cells; other entries mean nothing.
    faces: Vec<(u8, u8)>,
    /// Words of the frontiers as they were before this update.
    touched: Vec<(u32, u64, u64)>,
    is_touched: Vec<bool>,
    /// Where something changed in the last update.
    pub(crate) dirty: Dirty,
    /// Frontier cells in any rectangle of columns.
    pub(crate) totals: Totals,
}

/// A sensor's position, prepared for many rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Eye {
    /// In the world, m.
    pub(crate) world: [f64; 3],
    /// In cell units.
    cells: [f64; 3],
    /// Index of the column's first word; none if outside of what is stored.
    column: Option<usize>,
}

impl World {
    /// First index past the stored cells.
    pub(crate) fn high(&self) -> Cell {
        let [nx, ny] = self.size;
        [
            self.low[0] + nx as i32,
            self.low[1] + ny as i32,
            self.low[2] + 64 * self.words as i32,
        ]
    }

    /// Index of the word of a cell and its bit; none outside.
    #[inline]
    pub(crate) fn index(&self, c: Cell) -> Option<(usize, u32)> {
        let d = [0, 1, 2].map(|a| i64::from(c[a]) - i64::from(self.low[a]));
        let [nx, ny] = self.size;
        if d.iter().any(|v| *v < 0)
            || d[0] >= nx as i64
            || d[1] >= ny as i64
            || d[2] >= 64 * self.words as i64
        {
            return None;
        }
        let column = (d[1] as usize * nx + d[0] as usize) * self.words;
        Some((column + (d[2] >> 6) as usize, (d[2] & 63) as u32))
    }

    /// Cell of bit 0 of a word.
    #[inline]
    pub(crate) fn cell(&self, word: usize) -> Cell {
        let (column, w) = (word / self.words, word % self.words);
        let (i, j) = (column % self.size[0], column / self.size[0]);
        [
            self.low[0] + i as i32,
            self.low[1] + j as i32,
            self.low[2] + 64 * w as i32,
        ]
    }

    /// Centre of a cell, m.
    #[inline]
    pub(crate) fn center(&self, c: Cell) -> [f64; 3] {
        [0, 1, 2].map(|a| self.zero[a] + f64::from(c[a]) * self.cell_size)
    }

    /// The cell of a coordinate (m) on one axis.
    pub(crate) fn coordinate(&self, axis: usize, v: f64) -> i32 {
        sight::floor(((v - self.zero[axis]) / self.cell_size + 0.5).clamp(-1e9, 1e9))
    }

    /// Rectangle of columns (low and high, both inclusive, clipped to what is stored) around a
    /// rectangle in metres; none if empty.
    pub(crate) fn rectangle(&self, low: [f64; 2], high: [f64; 2]) -> Option<[i32; 4]> {
        let top = self.high();
        let a = [0, 1].map(|n| self.coordinate(n, low[n]).max(self.low[n]));
        let b = [0, 1].map(|n| self.coordinate(n, high[n]).min(top[n] - 1));
        (a[0] <= b[0] && a[1] <= b[1]).then_some([a[0], a[1], b[0], b[1]])
    }

    /// True if something changed in a clipped rectangle of columns in the last update.
    #[inline]
    pub(crate) fn is_dirty(&self, [x0, y0, x1, y1]: [i32; 4]) -> bool {
        let [a, b, _] = self.low;
        let low = [(x0 - a) as usize, (y0 - b) as usize];
        self.dirty
            .touches(low, [(x1 - a) as usize, (y1 - b) as usize])
    }

    /// True if a point (m) lies in a free cell.
    pub(crate) fn is_free_at(&self, p: [f64; 3]) -> bool {
        let c = [0, 1, 2].map(|a| self.coordinate(a, p[a]));
        self.index(c)
            .is_some_and(|(word, bit)| self.free[word] >> bit & 1 != 0)
    }

    /// Heights between which all frontier cells lie, m.
    pub(crate) fn heights(&self) -> [f64; 2] {
        let [low, high] = self.span.unwrap_or([0, 0]);
        [low, high.saturating_add(1)].map(|k| self.zero[2] + (f64::from(k) - 0.5) * self.cell_size)
    }

    /// Takes the heights of new frontier cells into account; true if that widens the span.
    pub(crate) fn widen(&mut self, cells: impl Iterator<Item = Cell>) -> bool {
        let old = self.span;
        for [_, _, z] in cells {
            self.span = Some(self.span.map_or([z, z], |[a, b]| [a.min(z), b.max(z)]));
        }
        self.span != old
    }

    /// Makes room for a half-open box of cells; reads what is new from the map. True if the
    /// layout changed.
    pub(crate) fn grow<M: Map + ?Sized>(
        &mut self,
        map: &M,
        low: Cell,
        high: Cell,
    ) -> Result<bool, Error> {
        let (old_low, old_high) = (self.low, self.high());
        let empty = self.free.is_empty();
        let inside = |a: usize| low[a] >= old_low[a] && high[a] <= old_high[a];
        if !empty && inside(0) && inside(1) && inside(2) {
            return Ok(false);
        }
        let margin = if empty { 0 } else { MARGIN };
        let mut new_low = low;
        let mut new_high = high;
        for a in 0..3 {
            if !empty {
                let grown = |out: bool, v: i32, by: i32| if out { v.saturating_add(by) } else { v };
                let side = if a < 2 { margin } else { 0 };
                new_low[a] = old_low[a].min(grown(low[a] < old_low[a], low[a], -side));
                new_high[a] = old_high[a].max(grown(high[a] > old_high[a], high[a], side));
            }
        }
        // Rounded out to whole bricks, so that a map's brick-sized boxes do not grow it again.
        for a in 0..2 {
            new_low[a] = new_low[a].saturating_sub(new_low[a].rem_euclid(MARGIN));
            new_high[a] = new_high[a]
                .saturating_add((-i64::from(new_high[a])).rem_euclid(i64::from(MARGIN)) as i32);
        }
        let span = |a: usize| (i64::from(new_high[a]) - i64::from(new_low[a])).max(1) as u64;
        let words = span(2).div_ceil(64);
        let cells = span(0).saturating_mul(span(1)).saturating_mul(words * 64);
        if cells > MOST_CELLS {
            return Err(Error::TooLarge(cells));
        }
        let (nx, ny, words) = (span(0) as usize, span(1) as usize, words as usize);
        let total = nx * ny * words;
        let mut new = Self {
            settled: vec![0; nx.div_ceil(64) * ny],
            faces: Vec::new(),
            level: Vec::new(),
            level_weight: self.level_weight,
            releveled: true,
            low: new_low,
            size: [nx, ny],
            span: self.span,
            words,
            cell_size: map.cell_size(),
            zero: map.center([0; 3]),
            free: vec![0; total],
            occupied: vec![0; total],
            exploration: vec![0; total],
            inspection: vec![0; total],
            touched: Vec::new(),
            is_touched: vec![false; total],
            dirty: Dirty::new([nx, ny]),
            totals: Totals::default(),
        };
        for word in 0..total {
            let (free, occupied) = map.column(new.cell(word), 64);
            new.free[word] = free;
            new.occupied[word] = occupied & !free;
        }
        for word in 0..self.free.len() {
            for (from, to) in [
                (&self.exploration, &mut new.exploration),
                (&self.inspection, &mut new.inspection),
            ] {
                let mut bits = from[word];
                while bits != 0 {
                    let bit = bits.trailing_zeros();
                    bits &= bits - 1;
                    let mut c = self.cell(word);
                    c[2] += bit as i32;
                    // The new extent holds the old one.
                    let [a, b, z] = [0, 1, 2].map(|n| (c[n] - new_low[n]) as usize);
                    to[(b * nx + a) * words + z / 64] |= 1 << (z % 64);
                }
            }
        }
        new.dirty.mark_all();
        for column in 0..nx * ny {
            new.settle(column);
        }
        *self = new;
        Ok(true)
    }

    /// Reads a half-open box of cells from the map and marks what changed.
    pub(crate) fn read<M: Map + ?Sized>(&mut self, map: &M, low: Cell, high: Cell) {
        let (from, to) = (self.low, self.high());
        let a = [0, 1, 2].map(|n| low[n].max(from[n]));
        let b = [0, 1, 2].map(|n| high[n].min(to[n]));
        if (0..3).any(|n| a[n] >= b[n]) {
            return;
        }
        for w in (a[2] - from[2]) >> 6..=(b[2] - 1 - from[2]) >> 6 {
            let bottom = (from[2] + 64 * w).max(a[2]);
            let count = (from[2] + 64 * (w + 1)).min(b[2]) - bottom;
            let shift = bottom - from[2] - 64 * w;
            let mask = (u64::MAX >> (64 - count)) << shift;
            for j in a[1]..b[1] {
                for i in a[0]..b[0] {
                    let (free, occupied) = map.column([i, j, bottom], count as u32);
                    let (x, y) = ((i - from[0]) as usize, (j - from[1]) as usize);
                    let word = (y * self.size[0] + x) * self.words + w as usize;
                    let free = self.free[word] & !mask | (free << shift & mask);
                    let occupied = self.occupied[word] & !mask | (occupied << shift & mask & !free);
                    if free != self.free[word] || occupied != self.occupied[word] {
                        self.free[word] = free;
                        self.occupied[word] = occupied;
                        self.dirty.mark([x, y]);
                    }
                }
            }
        }
    }

    /// Sets or clears one frontier cell inside the extent.
    pub(crate) fn set_frontier(&mut self, c: Cell, inspection: bool, on: bool) {
        let Some((word, bit)) = self.index(c) else {
            return;
        };
        if !self.is_touched[word] {
            self.is_touched[word] = true;
            self.touched
                .push((word as u32, self.exploration[word], self.inspection[word]));
        }
        let layer = if inspection {
            &mut self.inspection
        } else {
            &mut self.exploration
        };
        if on {
            layer[word] |= 1 << bit;
        } else {
            layer[word] &= !(1 << bit);
        }
    }

    /// Looks up the faces of the inspection frontier cells in a box and one cell around it.
    pub(crate) fn read_faces<M: Map + ?Sized>(&mut self, map: &M, low: Cell, high: Cell) {
        self.faces.resize(self.inspection.len() * 64, (0, 0));
        self.level.resize(self.inspection.len(), 0);
        let (from, to) = (self.low, self.high());
        let a = [0, 1].map(|n| low[n].saturating_sub(1).max(from[n]));
        let b = [0, 1].map(|n| high[n].saturating_add(1).min(to[n]));
        for j in a[1]..b[1] {
            for i in a[0]..b[0] {
                let (x, y) = ((i - from[0]) as usize, (j - from[1]) as usize);
                let column = (y * self.size[0] + x) * self.words;
                for word in column..column + self.words {
                    let mut rest = self.inspection[word];
                    while rest != 0 {
                        let bit = rest.trailing_zeros() as i32;
                        rest &= rest - 1;
                        let k = from[2] + 64 * (word - column) as i32 + bit;
                        let faces = map.faces([i, j, k]);
                        let slot = &mut self.faces[word * 64 + bit as usize];
                        if *slot != faces {
                            *slot = faces;
                            self.dirty.mark([x, y]);
                            let level = faces.0 & LEVEL != 0;
                            self.releveled |= level != (self.level[word] >> bit & 1 != 0);
                            self.level[word] =
                                self.level[word] & !(1 << bit) | u64::from(level) << bit;
                        }
                    }
                }
            }
        }
    }

    /// The open faces of an inspection cell; bits as in [`Map::faces`]. All of them where no faces are kept.
    pub(crate) fn open_faces(&self, word: usize, bit: u32) -> u8 {
        self.faces
            .get(word * 64 + bit as usize)
            .map_or(0b11_1111, |faces| faces.0)
    }

    /// The open faces of an inspection cell that an eye at `from_cell` (m, relative to the cell's centre) looks at from
    /// outside, at an angle to the surface's normal whose cosine is at least `least`, in the middle of an upright face, or of the
    /// cell for those that look up or down: a level plate lies anywhere in its cells; bits as in
    /// [`Map::faces`]. The normal is the face's own, or for upright faces the mean of those exposed, since a wall at an angle to
    /// the grid is a staircase of such cells.
    #[inline]
    pub(crate) fn faces_eye(&self, word: usize, bit: u32, from_cell: [f64; 3], least: f64) -> u8 {
        let (open, exposed) = self.faces[word * 64 + bit as usize];
        let sign = |face: usize| if face.is_multiple_of(2) { -1.0 } else { 1.0 };
        let half = 0.5 * self.cell_size;
        let facing = (0..6).fold(0u8, |faces, face| {
            faces | u8::from(sign(face) * from_cell[face / 2] > half) << face
        });
        let mut rest = open & facing;
        if rest == 0 {
            return 0;
        }
        let square = from_cell.iter().map(|v| v * v).sum::<f64>();
        let by_mean = || {
            let mut mean = [0.0_f64; 2];
            for face in 0..4 {
                if exposed >> face & 1 != 0 {
                    mean[face / 2] += sign(face);
                }
            }
            let norm = (mean[0] * mean[0] + mean[1] * mean[1]).sqrt();
            norm > 0.0
                && mean[0] * from_cell[0] + mean[1] * from_cell[1] >= least * square.sqrt() * norm
        };
        let mut seen = 0;
        while rest != 0 {
            let face = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let along = sign(face) * from_cell[face / 2];
            let depth = if face < 4 { half } else { 0.0 };
            let above = along - depth;
            let steep = above >= least * (square - depth * (along + above)).max(0.0).sqrt();
            seen |= u8::from(steep || (face < 4 && by_mean())) << face;
        }
        seen
    }

    /// Those of the cells `mask` of a word whose neighbour across `face` is in sight of `eye`.
    ///
    /// The line to the middle of a cell inside a surface runs through its neighbours in the surface once it is flatter than 45
    /// degrees; the line to the free cell in front of the face does not.
    pub(crate) fn visible_across(
        &self,
        eye: &Eye,
        word: usize,
        mask: u64,
        face: usize,
        allowance: u32,
    ) -> u64 {
        if mask == 0 {
            return 0;
        }
        let [x, y, _] = self.cell(word);
        let (nx, ny) = (self.size[0] as i32, self.size[1] as i32);
        let (x, y) = (x - self.low[0], y - self.low[1]);
        let row = self.size[0] * self.words;
        let beside = match face {
            0 => (x > 0).then(|| word - self.words),
            1 => (x + 1 < nx).then(|| word + self.words),
            2 => (y > 0).then(|| word - row),
            3 => (y + 1 < ny).then(|| word + row),
            _ => Some(word),
        };
        let Some(beside) = beside else { return 0 };
        let storey = word % self.words;
        match face {
            4 => {
                let inside = self.visible(eye, beside, mask >> 1, allowance) << 1;
                let below = mask & 1 != 0
                    && storey > 0
                    && self.visible(eye, word - 1, 1 << 63, allowance) != 0;
                inside | u64::from(below)
            }
            5 => {
                let inside = self.visible(eye, beside, mask << 1, allowance) >> 1;
                let above = mask >> 63 != 0
                    && storey + 1 < self.words
                    && self.visible(eye, word + 1, 1, allowance) != 0;
                inside | u64::from(above) << 63
            }
            _ => self.visible(eye, beside, mask, allowance),
        }
    }

    /// Closes an update: marks the columns whose frontiers differ, counts anew.
    pub(crate) fn close_update(&mut self) {
        let mut changed = self.totals.is_empty() || std::mem::take(&mut self.releveled);
        for (word, exploration, inspection) in std::mem::take(&mut self.touched) {
            let word = word as usize;
            self.is_touched[word] = false;
            if self.exploration[word] != exploration || self.inspection[word] != inspection {
                let column = word / self.words;
                self.dirty
                    .mark([column % self.size[0], column / self.size[0]]);
                self.settle(column);
                changed = true;
            }
        }
        self.dirty.close();
        if changed {
            let count = |word: usize| {
                [
                    self.exploration[word].count_ones(),
                    self.worth(word, self.inspection[word]),
                ]
            };
            self.totals = Totals::of(self.size, self.words, count);
        }
    }

    /// Notes whether a column holds frontier cells.
    fn settle(&mut self, column: usize) {
        let words = column * self.words..(column + 1) * self.words;
        let any = words
            .into_iter()
            .any(|word| self.exploration[word] | self.inspection[word] != 0);
        let (x, y) = (column % self.size[0], column / self.size[0]);
        let slot = &mut self.settled[y * self.size[0].div_ceil(64) + x / 64];
        *slot = *slot & !(1 << (x % 64)) | u64::from(any) << (x % 64);
    }

    /// Calls `visit` with the words that hold frontier cells in a clipped rectangle of columns, ascending, and the centre of each
    /// word's bit 0, m.
    #[inline]
    pub(crate) fn each_settled(
        &self,
        [x0, y0, x1, y1]: [i32; 4],
        mut visit: impl FnMut(usize, [f64; 3]),
    ) {
        let stride = self.size[0].div_ceil(64);
        let (a, b) = ((x0 - self.low[0]) as usize, (x1 - self.low[0]) as usize);
        for y in y0..=y1 {
            let row = (y - self.low[1]) as usize;
            for block in a / 64..=b / 64 {
                let mut rest = self.settled[row * stride + block];
                if block == a / 64 {
                    rest &= u64::MAX << (a % 64);
                }
                if block == b / 64 {
                    rest &= u64::MAX >> (63 - b % 64);
                }
                while rest != 0 {
                    let x = 64 * block + rest.trailing_zeros() as usize;
                    rest &= rest - 1;
                    let first = (row * self.size[0] + x) * self.words;
                    for w in 0..self.words {
                        if self.exploration[first + w] | self.inspection[first + w] != 0 {
                            let z = self.low[2] + 64 * w as i32;
                            visit(first + w, self.center([self.low[0] + x as i32, y, z]));
                        }
                    }
                }
            }
        }
    }

    /// Number of inspection cells in `mask` of a word, those with a level face counted as often as that weighs.
    #[inline]
    pub(crate) fn worth(&self, word: usize, mask: u64) -> u32 {
        let level = self.level.get(word).copied().unwrap_or(0);
        mask.count_ones() + (self.level_weight.max(1) - 1) * (mask & level).count_ones()
    }

    /// An empty world in which cells with a level face count so often.
    pub(crate) fn weighing(level_weight: u32) -> Self {
        Self {
            level_weight,
            ..Self::default()
        }
    }

    /// Prepares a sensor position (m).
    pub(crate) fn eye(&self, world: [f64; 3]) -> Eye {
        let cells = [0, 1, 2].map(|a| (world[a] - self.zero[a]) / self.cell_size + 0.5);
        let at = cells.map(sight::floor);
        let column = self.index(at).map(|_| self.column_of([at[0], at[1]]));
        Eye {
            world,
            cells,
            column,
        }
    }

    /// First word of a column inside the extent.
    #[inline]
    fn column_of(&self, c: [i32; 2]) -> usize {
        let (x, y) = ((c[0] - self.low[0]) as usize, (c[1] - self.low[1]) as usize);
        (y * self.size[0] + x) * self.words
    }

    /// Those of the cells `mask` of a word that are in sight of `eye`.
    #[inline]
    pub(crate) fn visible(&self, eye: &Eye, word: usize, mask: u64, allowance: u32) -> u64 {
        if mask == 0 {
            return 0;
        }
        match (eye.column, self.words) {
            (Some(column), 1) => self.visible_flat(eye, column, word, mask, allowance),
            _ => self.visible_tall(eye, word, mask, allowance),
        }
    }

    /// One ray a cell: maps higher than 64 cells, and eyes outside the map.
    fn visible_tall(&self, eye: &Eye, word: usize, mask: u64, allowance: u32) -> u64 {
        let (base, mut rest, mut seen) = (self.cell(word), mask, 0);
        let state = |c| match self.index(c) {
            Some((word, bit)) => (
                self.free[word] >> bit & 1 != 0,
                self.occupied[word] >> bit & 1 != 0,
            ),
            None => (false, false),
        };
        while rest != 0 {
            let bit = rest.trailing_zeros();
            rest &= rest - 1;
            let to = [base[0], base[1], base[2] + bit as i32];
            if sight::sees(eye.cells, to, allowance, state) {
                seen |= 1 << bit;
            }
        }
        seen
    }

    /// One walk for all cells of a column, in a map of at most 64 cells height.
    fn visible_flat(
        &self,
        eye: &Eye,
        column: usize,
        word: usize,
        mask: u64,
        allowance: u32,
    ) -> u64 {
        let base = self.cell(word);
        let nx = self.size[0] as i32;
        let ground = sight::floor(eye.cells[2]);
        let start = ground - base[2];
        let z = sight::height(eye.cells[2] - f64::from(ground));
        // Rise to the centre of the cell of a bit, and the bit that ray is in at a parameter.
        let rise = |bit: i32| (i64::from(bit - start) << 20) + (1 << 19) - z;
        let at_bit = |dz: i64, t: i64| start + sight::cell_in_z(z, dz, t);
        let mut alive = mask;
        let mut unknown = [0u8; 64];
        // No ray leaves the run between the eye and the farthest cells.
        let ends = |alive: u64| {
            (
                alive.trailing_zeros() as i32,
                63 - alive.leading_zeros() as i32,
            )
        };
        let (mut lowest, mut highest) = ends(alive);
        let mut reach = bits(lowest.min(start), highest.max(start));
        let end = [f64::from(base[0]) + 0.5, f64::from(base[1]) + 0.5];
        let mut columns = ColumnWalk::new([eye.cells[0], eye.cells[1]], end);
        let mut at = column as i32;
        let mut t0 = 0;
        loop {
            let exit = columns.exit();
            let mut barrier = !self.free[at as usize] & reach;
            if barrier != 0 {
                let t1 = sight::parameter(exit.map_or(1.0, |e| e.0));
                // The rays in between stay between the outermost ones.
                let (low, high) = (rise(lowest), rise(highest));
                let a = at_bit(low, t0).min(at_bit(low, t1));
                let b = at_bit(high, t0).max(at_bit(high, t1));
                barrier &= bits(a, b);
                if barrier != 0 {
                    let occupied = self.occupied[at as usize] & barrier;
                    let before = alive;
                    let mut rest = alive;
                    while rest != 0 {
                        let bit = rest.trailing_zeros() as i32;
                        rest &= rest - 1;
                        let dz = rise(bit);
                        let (a, b) = (at_bit(dz, t0), at_bit(dz, t1));
                        let mut run = bits(a.min(b), a.max(b));
                        if exit.is_none() {
                            run &= !(1 << bit);
                        }
                        if run & occupied != 0 {
                            alive &= !(1 << bit);
                        } else if run & barrier != 0 {
                            let count = &mut unknown[bit as usize];
                            *count = count.saturating_add((run & barrier).count_ones() as u8);
                            if u32::from(*count) > allowance {
                                alive &= !(1 << bit);
                            }
                        }
                    }
                    if alive == 0 {
                        return 0;
                    }
                    if alive != before {
                        (lowest, highest) = ends(alive);
                        reach = bits(lowest.min(start), highest.max(start));
                    }
                }
            }
            let Some((t1, axis)) = exit else {
                return alive;
            };
            t0 = sight::parameter(t1);
            let step = columns.cross(axis);
            at += if axis == 0 { step } else { step * nx };
        }
    }
}

/// Bits `a..=b`, for `0 <= a <= b < 64`.
#[inline]
fn bits(a: i32, b: i32) -> u64 {
    (u64::MAX >> (63 - b)) & (u64::MAX << a)
}
