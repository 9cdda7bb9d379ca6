//! The frontier cells of one kind as bits, and which cluster owns each.

use crate::cluster::Kind;
use crate::detect::words_of;
use crate::map::Map;
use crate::params::Side;
use crate::{Cell, CellBox};

/// No cluster.
pub(crate) const NONE: u32 = u32::MAX;

/// Frontier cells of one kind, dense over the map's bounds.
#[derive(Clone, Debug)]
pub(crate) struct Layer {
    pub(crate) kind: Kind,
    pub(crate) side: Side,
    pub(crate) low: Cell,
    pub(crate) size: [usize; 3],
    /// Words of a row.
    pub(crate) words: usize,
    pub(crate) bits: Vec<u64>,
    /// Low 32 bits of the owning cluster's id; words that never held a frontier cell have none.
    owner: Vec<Option<Box<[u32; 64]>>>,
    /// Cells that wait for a cluster; clear between updates.
    pub(crate) loose: Vec<u64>,
}

/// What became of the cells of one word.
pub(crate) struct Change {
    pub(crate) word: usize,
    /// Cells that became frontier.
    pub(crate) gained: u64,
    /// Cells that ceased to be.
    pub(crate) lost: u64,
}

/// The set bits of a word, lowest first.
pub(crate) fn ones(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = (bits != 0).then(|| bits.trailing_zeros() as usize);
        bits &= bits.wrapping_sub(1);
        bit
    })
}

impl Layer {
    pub(crate) fn new(kind: Kind, side: Side, (low, high): CellBox) -> Self {
        let size = [0, 1, 2].map(|a| (high[a] - low[a]).max(0) as usize);
        let words = size[0].div_ceil(64);
        let total = words * size[1] * size[2];
        Self {
            kind,
            side,
            low,
            size,
            words,
            bits: vec![0; total],
            owner: vec![None; total],
            loose: vec![0; total],
        }
    }

    fn address(&self, cell: Cell) -> Option<usize> {
        let [x, y, z] = [0, 1, 2].map(|a| cell[a].wrapping_sub(self.low[a]) as usize);
        (x < self.size[0] && y < self.size[1] && z < self.size[2])
            .then(|| (z * self.size[1] + y) * self.words * 64 + x)
    }

    pub(crate) fn holds(&self, cell: Cell) -> bool {
        self.address(cell)
            .is_some_and(|a| self.bits[a >> 6] >> (a & 63) & 1 != 0)
    }

    /// Cells of a word, appended to a list.
    pub(crate) fn append(&self, word: usize, bits: u64, cells: &mut Vec<Cell>) {
        let (line, w) = (word / self.words, word % self.words);
        let x = self.low[0] + (w * 64) as i32;
        let y = self.low[1] + (line % self.size[1]) as i32;
        let z = self.low[2] + (line / self.size[1]) as i32;
        cells.extend(ones(bits).map(|bit| [x + bit as i32, y, z]));
    }

    /// Whether a word is the first and the last of its row.
    pub(crate) fn ends(&self, word: usize) -> (bool, bool) {
        let w = word % self.words;
        (w == 0, w + 1 == self.words)
    }

    /// A word and those at its place in the eight rows around its own.
    pub(crate) fn rows_beside(&self, word: usize) -> impl Iterator<Item = usize> + use<> {
        let line = word / self.words;
        let (y, z) = (line % self.size[1], line / self.size[1]);
        let (row, layer) = (self.words, self.words * self.size[1]);
        let around = |at: usize, size: usize| [at > 0, true, at + 1 < size];
        let (ys, zs) = (around(y, self.size[1]), around(z, self.size[2]));
        (0..9)
            .filter(move |i| ys[i % 3] && zs[i / 3])
            .map(move |i| word + i % 3 * row + i / 3 * layer - row - layer)
    }

    /// Gives a cell to a cluster.
    pub(crate) fn set_owner(&mut self, cell: Cell, id: u32) {
        if let Some(a) = self.address(cell) {
            self.owner[a >> 6].get_or_insert_with(|| Box::new([NONE; 64]))[a & 63] = id;
        }
    }

    /// Takes cells of a word from their clusters, whose ids it tells, equal ones in a row once.
    pub(crate) fn disown(&mut self, word: usize, bits: u64, mut tell: impl FnMut(u32)) {
        let Some(owner) = &mut self.owner[word] else {
            return;
        };
        let mut last = NONE;
        for bit in ones(bits) {
            let id = std::mem::replace(&mut owner[bit], NONE);
            if id != last && id != NONE {
                tell(id);
                last = id;
            }
        }
    }

    /// Tells the clusters of the cells beside some of a word's, in the order of their cells, equal ones in a row once.
    pub(crate) fn owners_beside(&self, word: usize, bits: u64, mut tell: impl FnMut(u32)) {
        let (first, last) = self.ends(word);
        let wide = bits | bits << 1 | bits >> 1;
        let mut known = NONE;
        let mut look = |at: usize, bits: u64| {
            // What waits has no cluster.
            let bits = bits & self.bits[at] & !self.loose[at];
            if let (false, Some(owner)) = (bits == 0, &self.owner[at]) {
                for id in ones(bits).map(|bit| owner[bit]) {
                    if id != known && id != NONE {
                        tell(id);
                        known = id;
                    }
                }
            }
        };
        for beside in self.rows_beside(word) {
            look(beside, wide);
            if !first && bits & 1 != 0 {
                look(beside - 1, 1 << 63);
            }
            if !last && bits >> 63 != 0 {
                look(beside + 1, 1);
            }
        }
    }

    /// Takes a cell from its cluster to let it wait for another one: the word that holds it. `None` if it is no longer a
    /// frontier cell.
    pub(crate) fn release(&mut self, cell: Cell) -> Option<usize> {
        let a = self.address(cell)?;
        let (word, bit) = (a >> 6, 1 << (a & 63));
        if self.bits[word] & bit == 0 {
            return None;
        }
        self.loose[word] |= bit;
        if let Some(owner) = &mut self.owner[word] {
            owner[a & 63] = NONE;
        }
        Some(word)
    }

    /// Takes a cell out of those that wait; false if it was not among them.
    pub(crate) fn take(&mut self, cell: Cell) -> bool {
        let Some(a) = self.address(cell) else {
            return false;
        };
        let (word, bit) = (&mut self.loose[a >> 6], 1 << (a & 63));
        let waited = *word & bit != 0;
        *word &= !bit;
        waited
    }

    /// The waiting cells x - 1, x and x + 1 of a row, as bits 0, 1 and 2.
    pub(crate) fn waiting(&self, [x, y, z]: Cell) -> u64 {
        let [x, y, z] = [x - self.low[0], y - self.low[1], z - self.low[2]];
        if y < 0 || z < 0 || y as usize >= self.size[1] || z as usize >= self.size[2] {
            return 0;
        }
        let row = (z as usize * self.size[1] + y as usize) * self.words;
        let (w, bit) = (x as usize / 64, x & 63);
        let here = self.loose[row + w];
        let mut bits = if bit == 0 {
            here << 1
        } else {
            here >> (bit - 1)
        } & 7;
        if bit == 0 && w > 0 {
            bits |= self.loose[row + w - 1] >> 63;
        }
        if bit == 63 && w + 1 < self.words {
            bits |= (self.loose[row + w + 1] & 1) << 2;
        }
        bits
    }

    /// Looks at the boxes again: the words that changed.
    pub(crate) fn refresh(
        &mut self,
        map: &impl Map,
        boxes: &[CellBox],
        band: (i32, i32),
    ) -> Vec<Change> {
        let (mut now, mut changes) = (Vec::new(), Vec::new());
        for (low, high) in boxes {
            // A cell's kind depends on its neighbours, so the box grows by one.
            let from = [0, 1, 2].map(|a| (low[a].saturating_sub(1)).max(self.low[a]));
            let to = [0, 1, 2]
                .map(|a| (high[a].saturating_add(1)).min(self.low[a] + self.size[a] as i32));
            if (0..3).any(|a| from[a] >= to[a]) {
                continue;
            }
            let first_word = (from[0] - self.low[0]) as usize / 64;
            let last_word = (to[0] - 1 - self.low[0]) as usize / 64;
            let row = last_word - first_word + 1;
            now.resize(row * (to[1] - from[1]) as usize, 0);
            let x = self.low[0] + (first_word * 64) as i32;
            for z in from[2].max(band.0)..to[2].min(band.1) {
                words_of(map, self.kind, self.side, [x, from[1], z], row, &mut now);
                for (y, now) in (from[1]..to[1]).zip(now.chunks(row)) {
                    let line =
                        (z - self.low[2]) as usize * self.size[1] + (y - self.low[1]) as usize;
                    let first = line * self.words + first_word;
                    let before = &mut self.bits[first..][..row];
                    for ((&now, before), word) in now.iter().zip(before).zip(first..) {
                        if now != *before {
                            changes.push(Change {
                                word,
                                gained: now & !*before,
                                lost: *before & !now,
                            });
                            *before = now;
                        }
                    }
                }
            }
        }
        changes
    }
}
