//! What frontier extraction must know about a voxel map.

use crate::Cell;

/// The six neighbours across a face.
pub(crate) const FACES: [Cell; 6] = [
    [-1, 0, 0],
    [1, 0, 0],
    [0, -1, 0],
    [0, 1, 0],
    [0, 0, -1],
    [0, 0, 1],
];

/// A voxel map as this crate sees it.
///
/// Laws: no cell is both free and occupied; a cell outside [`bounds`](Self::bounds) is neither; the word methods agree with
/// the single-cell ones, whatever the words held before. [`conformance::check`](crate::conformance::check) tests them for your type.
pub trait Map {
    /// Half-open box `[low, high)` of the task volume. Cells outside are no frontier and make none.
    fn bounds(&self) -> (Cell, Cell);
    /// Observed, and below the occupancy threshold.
    fn is_free(&self, cell: Cell) -> bool;
    /// Observed, and at or above the occupancy threshold.
    fn is_occupied(&self, cell: Cell) -> bool;
    /// Occupied, and seen well enough that nothing of it is left to inspect.
    fn is_inspected(&self, _cell: Cell) -> bool {
        false
    }
    /// Faces of a cell across which its neighbour is free, as bits: -x, +x, -y, +y, -z, +z. A map with bit planes overrides this.
    fn free_faces(&self, cell: Cell) -> u8 {
        faces(cell, |n| self.is_free(n))
    }
    /// Faces of a cell across which its neighbour is neither free nor occupied, in the order of [`free_faces`](Self::free_faces);
    /// cells outside the bounds are that too. A map with bit planes overrides this.
    fn unknown_faces(&self, cell: Cell) -> u8 {
        faces(cell, |n| !self.is_free(n) && !self.is_occupied(n))
    }
    /// Exploration frontier cells, 64 along x in each word as bits: free with an unknown neighbour inside the bounds. The words
    /// are those of rows of `row` words each, the first from `first` along x, each next one cell further along y. A map with
    /// bit planes overrides this.
    fn exploration_words(&self, first: Cell, row: usize, words: &mut [u64]) {
        fill(first, self.bounds(), row, words, |cell| {
            self.is_free(cell)
                && neighbours(cell)
                    .any(|n| inside(n, self.bounds()) && !self.is_free(n) && !self.is_occupied(n))
        });
    }
    /// Unknown cells with a free neighbour, the exploration frontier of [`Side::Unknown`](crate::Side), in words as those of
    /// [`exploration_words`](Self::exploration_words). A map with bit planes overrides this.
    fn unknown_words(&self, first: Cell, row: usize, words: &mut [u64]) {
        fill(first, self.bounds(), row, words, |cell| {
            !self.is_free(cell)
                && !self.is_occupied(cell)
                && neighbours(cell).any(|n| self.is_free(n))
        });
    }
    /// Inspection frontier cells, occupied, not inspected, with a free neighbour, in words as those of
    /// [`exploration_words`](Self::exploration_words).
    fn inspection_words(&self, first: Cell, row: usize, words: &mut [u64]) {
        fill(first, self.bounds(), row, words, |cell| {
            self.is_occupied(cell)
                && !self.is_inspected(cell)
                && neighbours(cell).any(|n| self.is_free(n))
        });
    }
}

impl<M: Map + ?Sized> Map for &M {
    fn bounds(&self) -> (Cell, Cell) {
        (**self).bounds()
    }
    fn is_free(&self, cell: Cell) -> bool {
        (**self).is_free(cell)
    }
    fn is_occupied(&self, cell: Cell) -> bool {
        (**self).is_occupied(cell)
    }
    fn is_inspected(&self, cell: Cell) -> bool {
        (**self).is_inspected(cell)
    }
    fn free_faces(&self, cell: Cell) -> u8 {
        (**self).free_faces(cell)
    }
    fn unknown_faces(&self, cell: Cell) -> u8 {
        (**self).unknown_faces(cell)
    }
    fn exploration_words(&self, first: Cell, row: usize, words: &mut [u64]) {
        (**self).exploration_words(first, row, words);
    }
    fn unknown_words(&self, first: Cell, row: usize, words: &mut [u64]) {
        (**self).unknown_words(first, row, words);
    }
    fn inspection_words(&self, first: Cell, row: usize, words: &mut [u64]) {
        (**self).inspection_words(first, row, words);
    }
}

pub(crate) fn neighbours(cell: Cell) -> impl Iterator<Item = Cell> {
    FACES
        .iter()
        .map(move |f| [cell[0] + f[0], cell[1] + f[1], cell[2] + f[2]])
}

fn faces(cell: Cell, is: impl Fn(Cell) -> bool) -> u8 {
    neighbours(cell)
        .enumerate()
        .fold(0, |bits, (i, n)| bits | u8::from(is(n)) << i)
}

pub(crate) fn inside(cell: Cell, (low, high): (Cell, Cell)) -> bool {
    (0..3).all(|a| low[a] <= cell[a] && cell[a] < high[a])
}

fn fill(
    first: Cell,
    bounds: (Cell, Cell),
    row: usize,
    words: &mut [u64],
    is: impl Fn(Cell) -> bool,
) {
    let [x, y, z] = first;
    for (i, word) in words.iter_mut().enumerate() {
        let (w, line) = (i % row.max(1), i / row.max(1));
        *word = (0..64)
            .filter(|bit| {
                let cell = [x + (w * 64) as i32 + bit, y + line as i32, z];
                inside(cell, bounds) && is(cell)
            })
            .fold(0, |bits, bit| bits | 1 << bit);
    }
}
