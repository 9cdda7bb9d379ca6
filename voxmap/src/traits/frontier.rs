//! `frontier::Map` for [`VoxelMap`], row by row, 64 cells at a time.

use crate::map::{FACES, VoxelMap};
use crate::simd::{self, Kernel};
use frontier::{Cell, Map};

/// Words of the map's planes at the same place of rows beside each other: of the row itself, -y, +y, -z, +z. At the map's faces
/// the row stands in for its neighbour, which changes nothing: no cell is in two states.
type Beside = [usize; 5];

/// The second half of detection, over many words at once: what neighbours across y and z add to those along x, and which cells
/// can be a frontier at all.
struct Across<'a> {
    map: &'a VoxelMap,
    beside: Beside,
    /// Whether the frontier's cells are the unknown ones, beside free ones; otherwise the other way round.
    unknown: bool,
    /// Cells with a neighbour along x.
    words: &'a mut [u64],
}

impl Kernel for Across<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.words.len();
        let words = self.words;
        let (free, occupied) = (&self.map.free[..], &self.map.occupied[..]);
        let [own, a, b, c, d] = self.beside;
        let [f, fa, fb, fc, fd] = [
            &free[own..][..n],
            &free[a..][..n],
            &free[b..][..n],
            &free[c..][..n],
            &free[d..][..n],
        ];
        let o = &occupied[own..][..n];
        if self.unknown {
            for i in 0..n {
                words[i] = !(f[i] | o[i]) & (words[i] | fa[i] | fb[i] | fc[i] | fd[i]);
            }
            return;
        }
        let [oa, ob, oc, od] = [
            &occupied[a..][..n],
            &occupied[b..][..n],
            &occupied[c..][..n],
            &occupied[d..][..n],
        ];
        for i in 0..n {
            let known = (fa[i] | oa[i]) & (fb[i] | ob[i]) & (fc[i] | oc[i]) & (fd[i] | od[i]);
            words[i] = f[i] & (words[i] | !known);
        }
    }
}

/// Words for which it pays to ask what the processor can do.
const MANY: usize = 16;

impl VoxelMap {
    /// Faces of a cell across which its neighbour has a property, which is read at the neighbour's address; `None` for cells at
    /// the map's faces and outside.
    #[inline]
    fn faces_inside(&self, cell: Cell, is: impl Fn(usize) -> bool) -> Option<u8> {
        let s = self.stored(cell).map(|v| v as u32 as usize);
        let inside = |a: usize| s[a] > 0 && s[a] + 1 < self.size[a];
        if !(inside(0) && inside(1) && inside(2)) {
            return None;
        }
        let row = self.words * 64;
        let layer = row * self.size[1];
        let at = s[2] * layer + s[1] * row + s[0];
        let beside = [at - 1, at + 1, at - row, at + row, at - layer, at + layer];
        let faces = beside.iter().enumerate();
        Some(faces.fold(0, |bits, (i, &at)| bits | u8::from(is(at)) << i))
    }

    /// Words at the place of word `w` of a row of stored cells, in it and in the rows around it.
    fn beside(&self, w: usize, y: usize, z: usize) -> Beside {
        let own = self.word(w, y, z);
        let (row, layer) = (self.words, self.words * self.size[1]);
        [
            own,
            own - if y > 0 { row } else { 0 },
            own + if y + 1 < self.size[1] { row } else { 0 },
            own - if z > 0 { layer } else { 0 },
            own + if z + 1 < self.size[2] { layer } else { 0 },
        ]
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

    /// Exploration frontier cells on one side, in rows of `row` aligned words from word `from` of row (y, z) on, all inside
    /// the map.
    fn detect(
        &self,
        unknown: bool,
        (y, z): (usize, usize),
        from: usize,
        row: usize,
        words: &mut [u64],
    ) {
        // Cells beside one that makes a frontier, along x.
        for (y, words) in (y..).zip(words.chunks_mut(row)) {
            let own = self.word(0, y, z);
            let source = |w: usize| {
                if w >= self.words {
                    0
                } else if unknown {
                    self.free[own + w]
                } else {
                    !(self.free[own + w] | self.occupied[own + w]) & self.cells_of(w)
                }
            };
            let mut before = source(from.wrapping_sub(1));
            let mut here = source(from);
            for (w, to) in (from..).zip(words) {
                let after = source(w + 1);
                *to = (here << 1 | here >> 1 | before >> 63 | after << 63) & self.cells_of(w);
                (before, here) = (here, after);
            }
        }
        // Whole rows follow each other; those at the map's faces have other neighbours.
        let rows = words.len().div_ceil(row);
        let mut done = 0;
        while done < rows {
            let at = y + done;
            let inner = at > 0 && at + 1 < self.size[1] && row == self.words;
            let run = if inner {
                (rows - done).min(self.size[1] - 1 - at)
            } else {
                1
            };
            let end = words.len().min((done + run) * row);
            let across = Across {
                map: self,
                beside: self.beside(from, at, z),
                unknown,
                words: &mut words[done * row..end],
            };
            if across.words.len() < MANY {
                across.run();
            } else {
                simd::run(across);
            }
            done += run;
        }
    }

    /// Occupied cells with a face that is open to free space and still to be inspected, in rows as those of `detect`.
    fn inspect(&self, (y, z): (usize, usize), from: usize, row: usize, words: &mut [u64]) {
        for (y, words) in (y..).zip(words.chunks_mut(row)) {
            for (w, to) in (from..).zip(words) {
                *to = self.open_word(w, y, z);
            }
        }
    }

    /// Fills rows of words with cells of a predicate from cell `first` on; none outside the map. `aligned` gives rows of
    /// aligned words inside it.
    fn fill(
        &self,
        first: Cell,
        row: usize,
        words: &mut [u64],
        aligned: impl Fn((usize, usize), usize, usize, &mut [u64]),
    ) {
        let [x, y, z] = self.stored(first).map(i64::from);
        let (from, shift) = (x.div_euclid(64), x.rem_euclid(64));
        if row == 0 {
            return words.fill(0);
        }
        let rows = words.len().div_ceil(row) as i64;
        let size = self.size.map(|n| n as i64);
        let fits = from >= 0 && from + row as i64 <= self.words as i64 && shift == 0;
        if fits && y >= 0 && y + rows <= size[1] && z >= 0 && z < size[2] {
            return aligned((y as usize, z as usize), from as usize, row, words);
        }
        words.fill(0);
        if z < 0 || z >= size[2] {
            return;
        }
        // Row by row: those words that lie inside the map, shifted by less than one.
        let mut inside = vec![0; row + 1];
        for (y, words) in (y..).zip(words.chunks_mut(row)) {
            if y < 0 || y >= size[1] {
                continue;
            }
            let start = (-from).clamp(0, row as i64 + 1);
            let end = (self.words as i64 - from).clamp(start, row as i64 + 1);
            let (start, end) = (start as usize, end as usize);
            if start == end {
                continue;
            }
            let at = (y as usize, z as usize);
            let part = &mut inside[start..end];
            aligned(at, (from + start as i64) as usize, end - start, part);
            for (pair, to) in inside.windows(2).zip(words) {
                *to = if shift == 0 {
                    pair[0]
                } else {
                    pair[0] >> shift | pair[1] << (64 - shift)
                };
            }
        }
    }
}

/// Faces of a cell across which its neighbour has a property.
fn faces(cell: Cell, is: impl Fn(Cell) -> bool) -> u8 {
    FACES.iter().enumerate().fold(0, |bits, (i, face)| {
        let beside = [0, 1, 2].map(|a| cell[a].wrapping_add(face[a]));
        bits | u8::from(is(beside)) << i
    })
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
    fn free_faces(&self, cell: Cell) -> u8 {
        let inside = self.faces_inside(cell, |at| Self::bit(&self.free, at));
        inside.unwrap_or_else(|| faces(cell, |n| Self::is_free(self, n)))
    }
    fn unknown_faces(&self, cell: Cell) -> u8 {
        let unknown = |at| !Self::bit(&self.free, at) && !Self::bit(&self.occupied, at);
        let inside = self.faces_inside(cell, unknown);
        inside.unwrap_or_else(|| faces(cell, |n| !self.is_known(n)))
    }
    fn exploration_words(&self, first: Cell, row: usize, words: &mut [u64]) {
        self.fill(first, row, words, |at, from, row, words| {
            self.detect(false, at, from, row, words);
        });
    }
    fn unknown_words(&self, first: Cell, row: usize, words: &mut [u64]) {
        self.fill(first, row, words, |at, from, row, words| {
            self.detect(true, at, from, row, words);
        });
    }
    fn inspection_words(&self, first: Cell, row: usize, words: &mut [u64]) {
        self.fill(first, row, words, |at, from, row, words| {
            self.inspect(at, from, row, words);
        });
    }
}
