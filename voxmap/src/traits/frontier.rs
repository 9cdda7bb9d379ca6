//! `frontier::Map` for [`VoxelMap`], word by word.

use crate::VoxelMap;
use frontier::{Cell, Map};

impl VoxelMap {
    /// A word of a predicate from cell `first` on: two aligned words, shifted.
    fn unaligned(&self, first: Cell, word: impl Fn(usize, usize, usize) -> u64) -> u64 {
        let [x, y, z] = self.stored(first);
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
        let free = self.free[self.word(w, y, z)];
        if free == 0 {
            return 0;
        }
        free & self.beside(w, y, z, |word, w| {
            !(self.free[word] | self.occupied[word]) & self.inside_mask(w)
        })
    }

    /// Unknown cells of a word with a free neighbour.
    fn unknown_bits(&self, w: usize, y: usize, z: usize) -> u64 {
        let word = self.word(w, y, z);
        let unknown = !(self.free[word] | self.occupied[word]) & self.inside_mask(w);
        if unknown == 0 {
            return 0;
        }
        unknown & self.beside(w, y, z, |word, _| self.free[word])
    }

    /// Cells of a word of which a neighbour across a face is in a set, given word by word (index, word of its row).
    #[inline(always)]
    fn beside(&self, w: usize, y: usize, z: usize, set: impl Fn(usize, usize) -> u64) -> u64 {
        let word = self.word(w, y, z);
        let layer = self.words * self.size[1];
        let here = set(word, w);
        let mut beside = here << 1 | here >> 1;
        if w > 0 {
            beside |= set(word - 1, w - 1) >> 63;
        }
        if w + 1 < self.words {
            beside |= set(word + 1, w + 1) << 63;
        }
        if y > 0 {
            beside |= set(word - self.words, w);
        }
        if y + 1 < self.size[1] {
            beside |= set(word + self.words, w);
        }
        if z > 0 {
            beside |= set(word - layer, w);
        }
        if z + 1 < self.size[2] {
            beside |= set(word + layer, w);
        }
        beside
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
        // What is narrow and left out need not have been seen.
        self.exposed_faces(cell) != 0 && self.open_faces(cell) == 0
    }
    fn exploration_word(&self, first: Cell) -> u64 {
        self.unaligned(first, |w, y, z| self.exploration_bits(w, y, z))
    }
    fn unknown_word(&self, first: Cell) -> u64 {
        self.unaligned(first, |w, y, z| self.unknown_bits(w, y, z))
    }
    fn inspection_word(&self, first: Cell) -> u64 {
        self.unaligned(first, |w, y, z| self.open_word(w, y, z))
    }
}
