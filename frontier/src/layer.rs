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
    side: Side,
    pub(crate) low: Cell,
    pub(crate) size: [usize; 3],
    /// Words of a row.
    words: usize,
    bits: Vec<u64>,
    /// Low 32 bits of the owning cluster's id; words that never held a frontier cell have none.
    owner: Vec<Option<Box<[u32; 64]>>>,
    /// Cells that wait for a cluster; clear between updates.
    loose: Vec<u64>,
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

    pub(crate) fn owner(&self, cell: Cell) -> u32 {
        self.address(cell)
            .and_then(|a| Some(self.owner[a >> 6].as_ref()?[a & 63]))
            .unwrap_or(NONE)
    }

    pub(crate) fn set_owner(&mut self, cell: Cell, id: u32) {
        if let Some(a) = self.address(cell) {
            let word = &mut self.owner[a >> 6];
            if id != NONE || word.is_some() {
                word.get_or_insert_with(|| Box::new([NONE; 64]))[a & 63] = id;
            }
        }
    }

    /// Lets cells wait for a cluster.
    pub(crate) fn loosen(&mut self, cells: &[Cell]) {
        for &cell in cells {
            if let Some(a) = self.address(cell) {
                self.loose[a >> 6] |= 1 << (a & 63);
            }
        }
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
    pub(crate) fn waiting(&self, cell: Cell) -> u64 {
        self.three(&self.loose, cell)
    }

    /// The frontier cells x - 1, x and x + 1 of a row, as bits 0, 1 and 2.
    pub(crate) fn held(&self, cell: Cell) -> u64 {
        self.three(&self.bits, cell)
    }

    fn three(&self, plane: &[u64], [x, y, z]: Cell) -> u64 {
        let [x, y, z] = [x - self.low[0], y - self.low[1], z - self.low[2]];
        if y < 0 || z < 0 || y as usize >= self.size[1] || z as usize >= self.size[2] {
            return 0;
        }
        let row = (z as usize * self.size[1] + y as usize) * self.words;
        let (w, bit) = (x as usize / 64, x & 63);
        let here = plane[row + w];
        let mut bits = if bit == 0 {
            here << 1
        } else {
            here >> (bit - 1)
        } & 7;
        if bit == 0 && w > 0 {
            bits |= plane[row + w - 1] >> 63;
        }
        if bit == 63 && w + 1 < self.words {
            bits |= (plane[row + w + 1] & 1) << 2;
        }
        bits
    }

    /// Looks at the boxes again; appends the cells that became frontier and that ceased to be.
    pub(crate) fn refresh(
        &mut self,
        map: &impl Map,
        boxes: &[CellBox],
        band: (i32, i32),
        gained: &mut Vec<Cell>,
        lost: &mut Vec<Cell>,
    ) {
        let mut now = Vec::new();
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
                    let before = &mut self.bits[line * self.words + first_word..][..row];
                    for (w, (&now, before)) in now.iter().zip(before).enumerate() {
                        if now == *before {
                            continue;
                        }
                        let before = std::mem::replace(before, now);
                        let x = x + (w * 64) as i32;
                        for (mut bits, list) in
                            [(now & !before, &mut *gained), (before & !now, &mut *lost)]
                        {
                            while bits != 0 {
                                list.push([x + bits.trailing_zeros() as i32, y, z]);
                                bits &= bits - 1;
                            }
                        }
                    }
                }
            }
        }
    }
}
