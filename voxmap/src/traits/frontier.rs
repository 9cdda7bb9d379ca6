//! `frontier::Map` for [`VoxelMap`], word by word.

use crate::VoxelMap;
use frontier::{Cell, Map};

impl VoxelMap {
    /// A word of a predicate from cell `first` on: two aligned words, shifted.
    fn unaligned(&self, first: Cell, word: impl Fn(usize, usize, usize) -> u64) -> u64 {
        let [x, y, z] = first;
        let inside = y >= 0 && z >= 0 && (y as usize) < self.size[1] && (z as usize) < self.size[2];
        if !inside {
            return 0;
        }
        let aligned = |w: i32| {
            if w >= 0 && (w as usize) < self.words {
                word(w as usize, y as usize, z as usize)
            } else {
                0
            }
        };
        let (w, shift) = (x.div_euclid(64), x.rem_euclid(64));
        if shift == 0 {
            aligned(w)
        } else {
            aligned(w) >> shift | aligned(w + 1) << (64 - shift)
        }
    }

    /// Free cells of a word with an unknown neighbour inside the map.
    fn exploration_bits(&self, w: usize, y: usize, z: usize) -> u64 {
        let word = self.word(w, y, z);
        let free = self.free[word];
        if free == 0 {
            return 0;
        }
        let unknown = |w: usize, y: usize, z: usize| {
            let word = self.word(w, y, z);
            !(self.free[word] | self.occupied[word]) & self.inside_mask(w)
        };
        let (row, layers) = (self.size[1], self.size[2]);
        let here = unknown(w, y, z);
        let mut beside = here << 1 | here >> 1;
        if w > 0 {
            beside |= unknown(w - 1, y, z) >> 63;
        }
        if w + 1 < self.words {
            beside |= unknown(w + 1, y, z) << 63;
        }
        if y > 0 {
            beside |= unknown(w, y - 1, z);
        }
        if y + 1 < row {
            beside |= unknown(w, y + 1, z);
        }
        if z > 0 {
            beside |= unknown(w, y, z - 1);
        }
        if z + 1 < layers {
            beside |= unknown(w, y, z + 1);
        }
        free & beside
    }

    /// Bits of word `w` of a row that stand for cells of the map.
    fn inside_mask(&self, w: usize) -> u64 {
        let cells = self.size[0] - w * 64;
        if cells >= 64 {
            u64::MAX
        } else {
            (1 << cells) - 1
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
        Self::is_inspected(self, cell)
    }
    fn exploration_word(&self, first: Cell) -> u64 {
        self.unaligned(first, |w, y, z| self.exploration_bits(w, y, z))
    }
    fn inspection_word(&self, first: Cell) -> u64 {
        self.unaligned(first, |w, y, z| self.open_word(w, y, z))
    }
}
