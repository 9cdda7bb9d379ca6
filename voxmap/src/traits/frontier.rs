//! `frontier::Map` for [`VoxelMap`], row by row, 64 cells at a time.

use crate::VoxelMap;
use frontier::{Cell, Map};

/// Words of the rows around a row: first word of the row itself, and of those at -y, +y, -z, +z. At the map's faces the row
/// stands in for its neighbour, which changes nothing: no cell is in two states.
struct Rows {
    own: usize,
    beside: [usize; 4],
}

impl VoxelMap {
    /// Words of the rows around a row of stored cells.
    #[inline]
    fn rows(&self, y: usize, z: usize) -> Rows {
        let own = self.word(0, y, z);
        let (row, layer) = (self.words, self.words * self.size[1]);
        Rows {
            own,
            beside: [
                own - if y > 0 { row } else { 0 },
                own + if y + 1 < self.size[1] { row } else { 0 },
                own - if z > 0 { layer } else { 0 },
                own + if z + 1 < self.size[2] { layer } else { 0 },
            ],
        }
    }

    /// Bits of word `w` of a row that stand for cells of the map.
    #[inline]
    fn cells_of(&self, w: usize) -> u64 {
        if w + 1 == self.words {
            u64::MAX >> (self.words * 64 - self.size[0])
        } else {
            u64::MAX
        }
    }

    /// Unknown cells of word `w` of a row that begins at word `own`; none before and behind it.
    #[inline]
    fn unknown_in(&self, own: usize, w: usize) -> u64 {
        if w < self.words {
            !(self.free[own + w] | self.occupied[own + w]) & self.cells_of(w)
        } else {
            0
        }
    }

    /// Free cells with an unknown neighbour inside the map, from word `from` of a row on.
    fn exploration(&self, (y, z): (usize, usize), from: usize, words: &mut [u64]) {
        let Rows { own, beside } = self.rows(y, z);
        let mut before = self.unknown_in(own, from.wrapping_sub(1));
        let mut here = self.unknown_in(own, from);
        for (w, to) in (from..).zip(words) {
            let after = self.unknown_in(own, w + 1);
            let known = |row: usize| self.free[row + w] | self.occupied[row + w];
            let [a, b, c, d] = beside;
            let across = !(known(a) & known(b) & known(c) & known(d));
            let along = here << 1 | here >> 1 | before >> 63 | after << 63;
            *to = self.free[own + w] & (along | across);
            (before, here) = (here, after);
        }
    }

    /// Unknown cells with a free neighbour, from word `from` of a row on.
    fn beyond(&self, (y, z): (usize, usize), from: usize, words: &mut [u64]) {
        let Rows { own, beside } = self.rows(y, z);
        let free = |row: usize, w: usize| {
            if w < self.words {
                self.free[row + w]
            } else {
                0
            }
        };
        let mut before = free(own, from.wrapping_sub(1));
        let mut here = free(own, from);
        for (w, to) in (from..).zip(words) {
            let after = free(own, w + 1);
            let [a, b, c, d] = beside;
            let across = free(a, w) | free(b, w) | free(c, w) | free(d, w);
            let along = here << 1 | here >> 1 | before >> 63 | after << 63;
            *to = self.unknown_in(own, w) & (along | across);
            (before, here) = (here, after);
        }
    }

    /// Occupied cells with a face that is open to free space and still to be inspected, from word `from` of a row on.
    fn inspection(&self, (y, z): (usize, usize), from: usize, words: &mut [u64]) {
        for (w, to) in (from..).zip(words) {
            *to = self.open_word(w, y, z);
        }
    }

    /// Fills words with cells of a predicate from cell `first` on; none outside the map. `row` gives aligned words inside it.
    fn fill(
        &self,
        first: Cell,
        words: &mut [u64],
        row: impl Fn(&Self, (usize, usize), usize, &mut [u64]),
    ) {
        let [x, y, z] = self.stored(first);
        if y < 0 || z < 0 || y as usize >= self.size[1] || z as usize >= self.size[2] {
            return words.fill(0);
        }
        let at = (y as usize, z as usize);
        let (from, shift) = (i64::from(x).div_euclid(64), x.rem_euclid(64));
        let aligned = |from: i64, words: &mut [u64]| {
            let (count, last) = (words.len() as i64, self.words as i64);
            if from >= 0 && from + count <= last {
                return row(self, at, from as usize, words);
            }
            words.fill(0);
            // What lies inside the map.
            let start = (-from).clamp(0, count);
            let end = (last - from).clamp(start, count);
            if start < end {
                let inside = &mut words[start as usize..end as usize];
                row(self, at, (from + start) as usize, inside);
            }
        };
        if shift == 0 {
            return aligned(from, words);
        }
        let mut buffer = [0; 9];
        for (chunk, from) in words.chunks_mut(8).zip((from..).step_by(8)) {
            let buffer = &mut buffer[..=chunk.len()];
            aligned(from, buffer);
            for (pair, to) in buffer.windows(2).zip(chunk) {
                *to = pair[0] >> shift | pair[1] << (64 - shift);
            }
        }
    }
}

impl Map for VoxelMap {
    fn bounds(&self) -> (Cell, Cell) {
        let b = Self::bounds(self);
        (b.low, b.high)
    }
    fn is_free(&self, cell: Cell) -> bool {
        Self::is_free(self, cell)
    }
    fn is_occupied(&self, cell: Cell) -> bool {
        Self::is_occupied(self, cell)
    }
    fn is_inspected(&self, cell: Cell) -> bool {
        // What is narrow and left out need not have been seen.
        self.exposed_faces(cell) != 0 && self.open_faces(cell) == 0
    }
    fn exploration_words(&self, first: Cell, words: &mut [u64]) {
        self.fill(first, words, Self::exploration);
    }
    fn unknown_words(&self, first: Cell, words: &mut [u64]) {
        self.fill(first, words, Self::beyond);
    }
    fn inspection_words(&self, first: Cell, words: &mut [u64]) {
        self.fill(first, words, Self::inspection);
    }
}
