//! FLAP's frontiers: unknown cells next to free ones, kept up to date, with normals.

use crate::map::{Map, inside, neighbours};
use crate::{Cell, CellBox};

/// All unknown cells with a free one among their six neighbours (FLAP sect. 3.1), one bit a cell.
///
/// ```
/// use frontier::{Fringe, grid::Grid};
///
/// // One row: free, never seen, never seen, wall.
/// let map = Grid::parse(".??#");
/// let fringe = Fringe::new(&map);
/// assert_eq!(fringe.cells().collect::<Vec<_>>(), [[1, 0, 0]]);
/// // Looked at as a volume, the cell beside it is on the volume's faces too, with unknown space above and below.
/// assert_eq!(fringe.targets(&map, ([1, 0, 0], [3, 1, 1])), [[1, 0, 0], [2, 0, 0]]);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fringe {
    low: Cell,
    high: Cell,
    bits: Vec<u64>,
    count: usize,
}

impl Fringe {
    /// The frontier of a map, from scratch.
    pub fn new(map: &impl Map) -> Self {
        let (low, high) = map.bounds();
        let size = [0, 1, 2].map(|a| i64::from(high[a]).saturating_sub(i64::from(low[a])).max(0));
        let cells = size.iter().product::<i64>() as usize;
        let mut fringe = Self {
            low,
            high,
            bits: vec![0; cells.div_ceil(64)],
            count: 0,
        };
        let (nx, ny) = (size[0] as usize, size[1] as usize);
        let row = nx.div_ceil(64);
        let mut words = vec![0; row * ny];
        for z in low[2]..high[2] {
            map.unknown_words([low[0], low[1], z], row, &mut words);
            let layer = (z - low[2]) as usize * ny;
            for (i, &word) in words.iter().enumerate() {
                let (x, y) = (i % row * 64, i / row);
                fringe.put((layer + y) * nx + x, word);
                fringe.count += word.count_ones() as usize;
            }
        }
        fringe
    }

    /// Sets the bits of a word from an address on.
    fn put(&mut self, at: usize, word: u64) {
        if word == 0 {
            return;
        }
        let (first, shift) = (at / 64, at % 64);
        self.bits[first] |= word << shift;
        if shift > 0 && word >> (64 - shift) != 0 {
            self.bits[first + 1] |= word >> (64 - shift);
        }
    }

    /// Looks again at cells whose state may have changed, and at their neighbours. The map's bounds must not have changed.
    pub fn update(&mut self, map: &impl Map, changed: impl IntoIterator<Item = Cell>) {
        for cell in changed {
            self.test(map, cell);
            for beside in neighbours(cell) {
                self.test(map, beside);
            }
        }
    }

    fn test(&mut self, map: &impl Map, cell: Cell) {
        let Some(index) = self.index(cell) else {
            return;
        };
        let is = is_unknown(map, cell) && neighbours(cell).any(|n| map.is_free(n));
        let (word, bit) = (&mut self.bits[index / 64], 1u64 << (index % 64));
        match (is, *word & bit != 0) {
            (true, false) => self.count += 1,
            (false, true) => self.count -= 1,
            _ => return,
        }
        *word ^= bit;
    }

    fn index(&self, cell: Cell) -> Option<usize> {
        inside(cell, (self.low, self.high)).then(|| {
            let [x, y, z] = [0, 1, 2].map(|a| (cell[a] - self.low[a]) as usize);
            let [nx, ny] = [0, 1].map(|a| (self.high[a] - self.low[a]) as usize);
            (z * ny + y) * nx + x
        })
    }

    /// Number of frontier cells.
    pub fn len(&self) -> usize {
        self.count
    }

    /// True if there is no frontier.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether a cell is a frontier.
    pub fn contains(&self, cell: Cell) -> bool {
        self.index(cell)
            .is_some_and(|i| self.bits[i / 64] >> (i % 64) & 1 != 0)
    }

    /// All frontier cells in index order (x fastest).
    pub fn cells(&self) -> impl Iterator<Item = Cell> + '_ {
        let [nx, ny] = [0, 1].map(|a| (self.high[a] - self.low[a]).max(1) as usize);
        let set = |word: u64| (0..64).filter(move |bit| word >> bit & 1 != 0);
        self.bits
            .iter()
            .enumerate()
            .flat_map(move |(w, &word)| set(word).map(move |bit| w * 64 + bit))
            .map(move |i| {
                let at = [i % nx, i / nx % ny, i / (nx * ny)];
                [0, 1, 2].map(|a| self.low[a] + at[a] as i32)
            })
    }

    /// The cells of a volume at which views should aim, in index order: its frontier cells, and those unknown cells on its
    /// faces that have an unknown neighbour outside, so that a volume enclosed in unknown space has targets too.
    pub fn targets(&self, map: &impl Map, volume: CellBox) -> Vec<Cell> {
        let (low, high) = volume;
        let mut found = Vec::new();
        for z in low[2]..high[2] {
            for y in low[1]..high[1] {
                for x in low[0]..high[0] {
                    let cell = [x, y, z];
                    let on_face = (0..3).any(|a| cell[a] == low[a] || cell[a] + 1 == high[a]);
                    let boundary = || {
                        on_face
                            && is_unknown(map, cell)
                            && neighbours(cell).any(|n| !inside(n, volume) && is_unknown(map, n))
                    };
                    if self.contains(cell) || boundary() {
                        found.push(cell);
                    }
                }
            }
        }
        found
    }

    /// The direction from the unknown to where a camera should be, at a target cell, in cells (FLAP sect. 3.1): from the
    /// mean of the cell and the unknown cells around it that `of_interest` holds, to the mean of the free cells around it
    /// and of the unknown ones that `of_interest` does not hold; 26 neighbours. `None` where the two means coincide or the
    /// latter is of no cell.
    pub fn normal(
        map: &impl Map,
        cell: Cell,
        of_interest: impl Fn(Cell) -> bool,
    ) -> Option<[f64; 3]> {
        // Offsets from the cell; the cell itself is the first of the inner ones.
        let (mut inner, mut inner_count) = ([0.0; 3], 1.0);
        let (mut outer, mut outer_count) = ([0.0; 3], 0.0);
        for n in 0..27 {
            let offset = [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1];
            if offset == [0; 3] {
                continue;
            }
            let beside = [0, 1, 2].map(|a| cell[a] + offset[a]);
            if map.is_occupied(beside) {
                continue;
            }
            let (sum, count) = if !map.is_free(beside) && of_interest(beside) {
                (&mut inner, &mut inner_count)
            } else {
                (&mut outer, &mut outer_count)
            };
            for a in 0..3 {
                sum[a] += f64::from(offset[a]);
            }
            *count += 1.0;
        }
        if outer_count == 0.0 {
            return None;
        }
        let normal = [0, 1, 2].map(|a| outer[a] / outer_count - inner[a] / inner_count);
        let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
        (length >= 1e-3).then_some(normal)
    }
}

fn is_unknown(map: &impl Map, cell: Cell) -> bool {
    !map.is_free(cell) && !map.is_occupied(cell)
}
