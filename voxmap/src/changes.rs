//! What changed since the last look: words of 64 cells with the changed bits, and boxes that cover them.

use crate::geometry::{Cell, CellBox};
use crate::map::VoxelMap;

/// Edge of a brick, cells; boxes are unions of bricks, shrunk to what changed in them.
const BRICK: usize = 8;

/// Marks of changed cells.
#[derive(Clone, Debug)]
pub(crate) struct Dirty {
    /// Words of the map; the marks below are empty until the first change.
    total: usize,
    state: Vec<u64>,
    inspected: Vec<u64>,
    /// Words with marks, each once, in the order of the first mark.
    words: Vec<u32>,
}

impl Dirty {
    pub(crate) fn new(total: usize) -> Self {
        Self {
            total,
            state: Vec::new(),
            inspected: Vec::new(),
            words: Vec::new(),
        }
    }

    /// Bytes in use.
    pub(crate) fn memory(&self) -> usize {
        (self.state.capacity() + self.inspected.capacity()) * 8 + self.words.capacity() * 4
    }

    /// Notes changes of free or occupied; `bits` is not 0.
    #[inline]
    pub(crate) fn state(&mut self, word: usize, bits: u64) {
        if self.state.is_empty() {
            self.state.resize(self.total, 0);
        }
        if self.state[word] | self.inspected.get(word).map_or(0, |w| *w) == 0 {
            self.words.push(word as u32);
        }
        self.state[word] |= bits;
    }

    /// Notes changes of inspected.
    #[inline]
    pub(crate) fn inspected(&mut self, word: usize, bits: u64) {
        if bits == 0 {
            return;
        }
        if self.inspected.is_empty() {
            self.inspected.resize(self.total, 0);
        }
        if self.state.get(word).map_or(0, |w| *w) | self.inspected[word] == 0 {
            self.words.push(word as u32);
        }
        self.inspected[word] |= bits;
    }

    /// Words with marks, their state and inspected bits, in the order of the first mark.
    pub(crate) fn pending(&self) -> impl Iterator<Item = (usize, u64, u64)> {
        let bits = |plane: &[u64], word: usize| plane.get(word).map_or(0, |w| *w);
        self.words.iter().map(move |&word| {
            let word = word as usize;
            (word, bits(&self.state, word), bits(&self.inspected, word))
        })
    }
}

/// Up to 64 cells along x of which some changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChangedWord {
    /// Cell of bit 0; its x is a multiple of 64 away from the map's lowest cell.
    pub cell: Cell,
    /// Cells whose free or occupied bit changed.
    pub state: u64,
    /// Cells of which a face was inspected.
    pub inspected: u64,
}

/// Everything that changed between two looks. A cell that changed and changed back may be listed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Disjoint boxes that hold every changed cell (free, occupied or inspected), in index order.
    pub boxes: Vec<CellBox>,
    /// Disjoint boxes that hold every cell whose free or occupied bit changed, in index order.
    pub state_boxes: Vec<CellBox>,
    /// The changed cells themselves, in index order.
    pub words: Vec<ChangedWord>,
}

impl Changes {
    /// True if nothing changed.
    pub fn is_empty(&self) -> bool {
        self.words.is_empty()
    }

    /// The changed cells, in index order.
    pub fn cells(&self) -> impl Iterator<Item = Cell> {
        self.words.iter().flat_map(|word| {
            let bits = word.state | word.inspected;
            (0..64).filter(move |x| bits >> x & 1 != 0).map(|x| {
                let [x0, y, z] = word.cell;
                [x0 + x, y, z]
            })
        })
    }
}

impl VoxelMap {
    /// Boxes of changed cells, in the map's cells.
    fn boxes(&self, list: &[ChangedWord], bits: impl Fn(&ChangedWord) -> u64) -> Vec<CellBox> {
        let stored: Vec<ChangedWord> = list
            .iter()
            .map(|word| ChangedWord {
                cell: self.stored(word.cell),
                ..*word
            })
            .collect();
        let back = |cell: Cell| [0, 1, 2].map(|a| cell[a] + self.first[a]);
        boxes(&stored, bits, self.size)
            .into_iter()
            .map(|b| CellBox {
                low: back(b.low),
                high: back(b.high),
            })
            .collect()
    }

    /// Everything that changed since the last call.
    pub fn take_changes(&mut self) -> Changes {
        let mut words = std::mem::take(&mut self.dirty.words);
        words.sort_unstable();
        let list: Vec<ChangedWord> = words
            .iter()
            .map(|&word| {
                let at = word as usize;
                ChangedWord {
                    cell: self.cell_of_word(at),
                    state: self.dirty.state.get_mut(at).map_or(0, std::mem::take),
                    inspected: self.dirty.inspected.get_mut(at).map_or(0, std::mem::take),
                }
            })
            .collect();
        words.clear();
        self.dirty.words = words;
        Changes {
            boxes: self.boxes(&list, |w| w.state | w.inspected),
            state_boxes: self.boxes(&list, |w| w.state),
            words: list,
        }
    }
}

/// What changed in a brick: half-open cell ranges, empty at first.
#[derive(Clone, Copy)]
struct Extent {
    low: [u16; 3],
    high: [u16; 3],
}

/// Covers the changed cells by disjoint boxes: runs of bricks along x, merged along y and then along z where their bricks are
/// equal, each shrunk to the changed cells inside.
fn boxes(
    words: &[ChangedWord],
    bits: impl Fn(&ChangedWord) -> u64,
    size: [usize; 3],
) -> Vec<CellBox> {
    if words.is_empty() {
        return Vec::new();
    }
    let bricks = size.map(|n| n.div_ceil(BRICK));
    let index = |x: usize, y: usize, z: usize| (z * bricks[1] + y) * bricks[0] + x;
    let none = Extent {
        low: [u16::MAX; 3],
        high: [0; 3],
    };
    let mut extents = vec![none; bricks.iter().product()];
    for word in words {
        let mut rest = bits(word);
        let [x0, y, z] = word.cell.map(|v| v as usize);
        while rest != 0 {
            let byte = rest.trailing_zeros() as usize / 8;
            let row = rest >> (byte * 8) & 0xff;
            rest &= !(0xff << (byte * 8));
            let extent = &mut extents[index(x0 / 8 + byte, y / 8, z / 8)];
            let first = [row.trailing_zeros() as usize, y % 8, z % 8];
            let last = [63 - row.leading_zeros() as usize, y % 8, z % 8];
            for a in 0..3 {
                extent.low[a] = extent.low[a].min(first[a] as u16);
                extent.high[a] = extent.high[a].max(last[a] as u16 + 1);
            }
        }
    }
    let marked = |x: usize, y: usize, z: usize| extents[index(x, y, z)].high[0] > 0;
    // Boxes in bricks that the layer below ended with, and those that are complete.
    let mut below: Vec<[[usize; 2]; 3]> = Vec::new();
    let mut done: Vec<[[usize; 2]; 3]> = Vec::new();
    for z in 0..bricks[2] {
        let mut layer: Vec<[[usize; 2]; 3]> = Vec::new();
        for y in 0..bricks[1] {
            let mut x = 0;
            while x < bricks[0] {
                let start = x;
                while x < bricks[0] && marked(x, y, z) {
                    x += 1;
                }
                if x > start {
                    let run = [start, x];
                    match layer.iter_mut().rev().find(|b| b[0] == run && b[1][1] == y) {
                        Some(grown) => grown[1][1] = y + 1,
                        None => layer.push([run, [y, y + 1], [z, z + 1]]),
                    }
                } else {
                    x += 1;
                }
            }
        }
        for block in &mut layer {
            if let Some(i) = below
                .iter()
                .position(|b| b[0] == block[0] && b[1] == block[1])
            {
                block[2][0] = below.swap_remove(i)[2][0];
            }
        }
        done.append(&mut below);
        below = layer;
    }
    done.append(&mut below);
    let mut out: Vec<CellBox> = done
        .into_iter()
        .map(|[xs, ys, zs]| {
            let mut cells = CellBox {
                low: [i32::MAX; 3],
                high: [0; 3],
            };
            for z in zs[0]..zs[1] {
                for y in ys[0]..ys[1] {
                    for x in xs[0]..xs[1] {
                        let extent = &extents[index(x, y, z)];
                        for (a, brick) in [x, y, z].into_iter().enumerate() {
                            let corner = (brick * BRICK) as i32;
                            cells.low[a] = cells.low[a].min(corner + i32::from(extent.low[a]));
                            cells.high[a] = cells.high[a].max(corner + i32::from(extent.high[a]));
                        }
                    }
                }
            }
            cells
        })
        .collect();
    out.sort_unstable();
    out
}
