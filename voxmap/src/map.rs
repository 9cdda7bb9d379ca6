//! The voxel map: log-odds beside bit planes of free, occupied and inspected, in rows of 64 cells along x.

use crate::changes::Dirty;
use crate::error::Error;
use crate::geometry::{Cell, CellBox, State};
use crate::sensor::{Odds, SensorModel};
use crate::store::{LogPage, Pages, SeenPage};

/// Most cells of a map, rows padded to 64: 256 MiB of bit planes, and log-odds where something was seen.
pub(crate) const MOST_CELLS: usize = 1 << 30;
/// Most cells along an axis: whole-number crossing times stay exact so far.
const LONGEST_AXIS: f64 = (1 << 22) as f64;

/// Size, place and sensor model of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Edge of a cell, m. HEATS: 0.15.
    pub cell_size: f64,
    /// Lower corner of the mapped volume in the world frame, m.
    pub low: [f64; 3],
    /// Upper corner, m; rounded up to whole cells.
    pub high: [f64; 3],
    /// Sensor model.
    pub sensor: SensorModel,
}

/// How many cells are in which state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Free or occupied.
    pub known: usize,
    /// Free.
    pub free: usize,
    /// Occupied.
    pub occupied: usize,
    /// Occupied, open to free space, and inspected on every open face.
    pub inspected: usize,
}

/// An occupancy map with an inspected layer, bounded or growing.
///
/// Free and occupied are dense bit planes: a cell's bit stands at `((z * ny) + y) * row + x` with rows padded to whole 64-bit
/// words, so that neighbours along y and z stand at the same bit of other words, and one word operation serves 64 cells.
/// Log-odds and inspected faces stand in pages of 64 x 8 x 8 cells that exist where something was observed.
///
/// Clones share pages until one of them writes, so that a copy costs little more than its bit planes;
/// [`snapshot`](Self::snapshot) makes a read-only one.
#[derive(Clone, Debug)]
pub struct VoxelMap {
    pub(crate) cell_size: f64,
    /// World position of the lower corner of cell 0, m.
    pub(crate) anchor: [f64; 3],
    /// Lowest stored cell; cell 0 in bounded maps.
    pub(crate) first: Cell,
    /// World position of its lower corner, m.
    pub(crate) low: [f64; 3],
    pub(crate) size: [usize; 3],
    /// Words of a row.
    pub(crate) words: usize,
    pub(crate) odds: Odds,
    pub(crate) free: Vec<u64>,
    pub(crate) occupied: Vec<u64>,
    pub(crate) log: Pages<LogPage>,
    /// Inspected faces of occupied cells, in the order of [`FACES`].
    pub(crate) seen: Pages<SeenPage>,
    pub(crate) skip_narrow: bool,
    pub(crate) skip_strips: bool,
    /// Occupied cells of each block of 8 x 8 x 8.
    pub(crate) blocks: Vec<u16>,
    pub(crate) dirty: Dirty,
    pub(crate) scan: crate::insert::Window,
    /// Scans integrated so far.
    pub(crate) scans: u64,
    /// Most cells, for a map that grows.
    pub(crate) limit: Option<usize>,
}

impl VoxelMap {
    /// A map of unknown cells, cell 0 at its lower corner.
    ///
    /// # Errors
    /// [`Error`] for a cell size, bounds or probabilities that make no map, or more than 2^30 cells, or 2^22 along an
    /// axis.
    pub fn new(config: &Config) -> Result<Self, Error> {
        let h = checked_cell_size(config.cell_size)?;
        let (low, high) = (config.low, config.high);
        let ordered = (0..3).all(|a| low[a].is_finite() && high[a].is_finite() && low[a] < high[a]);
        if !ordered {
            return Err(Error::Bounds { low, high });
        }
        // A millionth of a cell forgives bounds that are a whole number of cells up to rounding.
        let cells = [0, 1, 2].map(|a| ((high[a] - low[a]) / h - 1e-6).ceil().max(1.0));
        let padded = (cells[0] / 64.0).ceil() * 64.0 * cells[1] * cells[2];
        if padded > MOST_CELLS as f64 || !fits(cells) {
            return Err(Error::TooLarge {
                cells: padded,
                most: MOST_CELLS,
            });
        }
        let odds = Odds::new(&config.sensor)?;
        Ok(Self::blank(h, low, [0; 3], cells.map(|c| c as usize), odds))
    }

    /// A map of unknown cells of checked size.
    pub(crate) fn blank(
        cell_size: f64,
        anchor: [f64; 3],
        first: Cell,
        size: [usize; 3],
        odds: Odds,
    ) -> Self {
        let words = size[0].div_ceil(64);
        let total = words * size[1] * size[2];
        Self {
            cell_size,
            anchor,
            first,
            low: [0, 1, 2].map(|a| anchor[a] + f64::from(first[a]) * cell_size),
            size,
            words,
            odds,
            free: vec![0; total],
            occupied: vec![0; total],
            log: Pages::new(words, size),
            seen: Pages::new(words, size),
            skip_narrow: false,
            skip_strips: false,
            blocks: vec![0; words * 8 * size[1].div_ceil(8) * size[2].div_ceil(8)],
            dirty: Dirty::new(total),
            scan: crate::insert::Window::default(),
            scans: 0,
            limit: None,
        }
    }

    /// Edge of a cell, m.
    pub fn cell_size(&self) -> f64 {
        self.cell_size
    }

    /// Number of cells on each axis.
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// Lower corner in the world frame, m.
    pub fn low(&self) -> [f64; 3] {
        self.low
    }

    /// Bytes in use, scratch planes included; pages shared with clones count.
    pub fn memory(&self) -> usize {
        (self.free.capacity() + self.occupied.capacity()) * 8
            + self.blocks.capacity() * 2
            + self.log.memory()
            + self.seen.memory()
            + self.dirty.memory()
            + self.scan.memory()
    }

    /// All cells of the map.
    pub fn bounds(&self) -> CellBox {
        CellBox {
            low: self.first,
            high: [0, 1, 2].map(|a| self.first[a] + self.size[a] as i32),
        }
    }

    /// The cell that holds a point; also outside the map, saturating far away and for NaN.
    #[inline]
    pub fn cell_at(&self, point: [f64; 3]) -> Cell {
        let inverse = 1.0 / self.cell_size;
        [0, 1, 2].map(|a| whole((point[a] - self.low[a]) * inverse).saturating_add(self.first[a]))
    }

    /// Centre of a cell in the world frame, m.
    #[inline]
    pub fn center(&self, cell: Cell) -> [f64; 3] {
        [0, 1, 2].map(|a| self.anchor[a] + (f64::from(cell[a]) + 0.5) * self.cell_size)
    }

    /// A cell relative to the lowest stored one. Far outside it wraps, but never into the map.
    #[inline]
    pub(crate) fn stored(&self, cell: Cell) -> Cell {
        [0, 1, 2].map(|a| cell[a].wrapping_sub(self.first[a]))
    }

    /// True if the cell lies inside the map.
    #[inline]
    pub fn contains(&self, cell: Cell) -> bool {
        let s = self.stored(cell);
        (0..3).all(|a| (s[a] as u32 as usize) < self.size[a])
    }

    /// Address of a cell inside the map.
    #[inline]
    pub(crate) fn address(&self, cell: Cell) -> usize {
        self.inner(self.stored(cell))
    }

    /// Address of a stored cell.
    #[inline]
    pub(crate) fn inner(&self, s: Cell) -> usize {
        (s[2] as usize * self.size[1] + s[1] as usize) * (self.words * 64) + s[0] as usize
    }

    /// Cell of bit 0 of a word.
    pub(crate) fn cell_of_word(&self, word: usize) -> Cell {
        let (line, w) = (word / self.words, word % self.words);
        [
            (w * 64) as i32 + self.first[0],
            (line % self.size[1]) as i32 + self.first[1],
            (line / self.size[1]) as i32 + self.first[2],
        ]
    }

    /// State of a cell; unknown outside the map.
    #[inline]
    pub fn state(&self, cell: Cell) -> State {
        if !self.contains(cell) {
            return State::Unknown;
        }
        // By table: where states are mixed, branches on them would often be foretold wrong.
        const STATES: [State; 4] = [
            State::Unknown,
            State::Free,
            State::Occupied,
            State::Occupied,
        ];
        let address = self.address(cell);
        let bit = |plane: &[u64]| usize::from(Self::bit(plane, address));
        STATES[bit(&self.free) | bit(&self.occupied) << 1]
    }

    #[inline]
    pub(crate) fn bit(plane: &[u64], address: usize) -> bool {
        plane[address >> 6] >> (address & 63) & 1 != 0
    }

    /// True for an observed cell below the occupancy threshold.
    #[inline]
    pub fn is_free(&self, cell: Cell) -> bool {
        self.contains(cell) && Self::bit(&self.free, self.address(cell))
    }

    /// True for an observed cell at or above the occupancy threshold.
    #[inline]
    pub fn is_occupied(&self, cell: Cell) -> bool {
        self.contains(cell) && Self::bit(&self.occupied, self.address(cell))
    }

    /// True for an observed cell.
    #[inline]
    pub fn is_known(&self, cell: Cell) -> bool {
        if !self.contains(cell) {
            return false;
        }
        let a = self.address(cell);
        (self.free[a >> 6] | self.occupied[a >> 6]) >> (a & 63) & 1 != 0
    }

    /// Whether narrow faces are left out of what is still to be inspected; off at first.
    ///
    /// A face is narrow where both neighbours of its cell along the face are free, across one direction: the edge of a board, a
    /// table's leg. What stands there is thinner than a cell, so it cannot carry a target as wide as one. Nor can a face that
    /// stands alone: one that looks up or down counts inside a square of two by two such faces, an upright one if the
    /// surface goes on beside it and above or below it.
    ///
    /// Call it before the first scan, or the changes of the map do not tell. Whether a face is narrow depends on cells up to two
    /// away, so who follows changes looks one cell beyond their boxes.
    pub fn skip_narrow_faces(&mut self, skip: bool) {
        self.skip_narrow = skip;
    }

    /// Whether what is left between inspected faces counts as narrow too, where [narrow faces are left out](Self::skip_narrow_faces);
    /// off at first.
    ///
    /// A strip one cell wide between inspected faces, or between them and the surface's edge, holds the middle of a target only if
    /// the target reaches well into what was seen on one side of it: with
    /// [`mark_inspected_twice`](Self::mark_inspected_twice) and a `target` of at least its half side and half a cell, one of the images
    /// on both sides showed it whole.
    pub fn skip_inspected_strips(&mut self, skip: bool) {
        self.skip_strips = skip;
    }

    /// True for an occupied cell that is open to free space, with a face that was inspected since the cell became occupied
    /// and none that still [is to be](Self::open_faces).
    pub fn is_inspected(&self, cell: Cell) -> bool {
        let exposed = self.exposed_faces(cell);
        exposed != 0 && self.open_faces(cell) == 0 && self.seen_faces(cell) & exposed != 0
    }

    /// The faces of an occupied cell that are open to a free cell, inspected or not, as bits in the order -x, +x, -y, +y,
    /// -z, +z; 0 for cells that are not occupied.
    pub fn exposed_faces(&self, cell: Cell) -> u8 {
        if !self.is_occupied(cell) {
            return 0;
        }
        let mut faces = 0;
        for (face, offset) in FACES.iter().enumerate() {
            if self.is_free([0, 1, 2].map(|a| cell[a] + offset[a])) {
                faces |= 1 << face;
            }
        }
        faces
    }

    /// The faces of an occupied cell that are open to a free cell and not inspected, without those that
    /// [are left out](Self::skip_narrow_faces); bits as [`exposed_faces`](Self::exposed_faces).
    pub fn open_faces(&self, cell: Cell) -> u8 {
        let exposed = self.exposed_faces(cell);
        let mut faces = exposed;
        if faces != 0 {
            faces &= !self.seen_faces(cell);
        }
        if faces != 0 && self.skip_narrow {
            for axis in 0..3 {
                if exposed >> (2 * axis) & 3 == 3 {
                    // Free on both sides along this axis: only the two faces across it are wide enough.
                    faces &= 3 << (2 * axis);
                }
            }
            faces = self.wide_faces(cell, faces);
        }
        faces
    }

    /// The inspected faces of a cell inside the map.
    pub(crate) fn seen_faces(&self, cell: Cell) -> u8 {
        let [x, y, z] = self.stored(cell).map(|v| v as usize);
        self.seen.get(x / 64, y, z).map_or(0, |seen| {
            seen.iter().enumerate().fold(0, |faces, (face, plane)| {
                faces | ((plane >> (x % 64) & 1) as u8) << face
            })
        })
    }

    /// Number of cells in each state.
    pub fn counts(&self) -> Counts {
        let ones = |plane: &[u64]| plane.iter().map(|w| w.count_ones() as usize).sum::<usize>();
        let (free, occupied) = (ones(&self.free), ones(&self.occupied));
        let mut inspected = 0;
        for z in 0..self.size[2] {
            for y in 0..self.size[1] {
                for w in 0..self.words {
                    let surface = self.occupied[self.word(w, y, z)];
                    if surface != 0 {
                        let planes = self.seen.get(w, y, z).copied().unwrap_or_default();
                        let seen = (0..6)
                            .fold(0, |all, f| all | (self.free_beside(w, y, z, f) & planes[f]));
                        inspected +=
                            (surface & seen & !self.open_word(w, y, z)).count_ones() as usize;
                    }
                }
            }
        }
        Counts {
            known: free + occupied,
            free,
            occupied,
            inspected,
        }
    }

    /// Bit x of word `w` of row (y, z) is set where the neighbour across `face` is free.
    pub(crate) fn free_beside(&self, w: usize, y: usize, z: usize, face: usize) -> u64 {
        let word = self.word(w, y, z);
        let (plane, layer) = (&self.free, self.words * self.size[1]);
        match face {
            0 => plane[word] << 1 | if w > 0 { plane[word - 1] >> 63 } else { 0 },
            1 => {
                plane[word] >> 1
                    | if w + 1 < self.words {
                        plane[word + 1] << 63
                    } else {
                        0
                    }
            }
            2 if y > 0 => plane[word - self.words],
            3 if y + 1 < self.size[1] => plane[word + self.words],
            4 if z > 0 => plane[word - layer],
            5 if z + 1 < self.size[2] => plane[word + layer],
            _ => 0,
        }
    }

    /// Occupied cells of word `w` of row (y, z) with a face that is open to free space and still to be inspected.
    pub(crate) fn open_word(&self, w: usize, y: usize, z: usize) -> u64 {
        self.unseen_word(w, y, z, self.skip_narrow)
    }

    /// Occupied cells of word `w` of row (y, z) with a face that is open to free space and not inspected, narrow faces or not.
    pub(crate) fn unseen_word(&self, w: usize, y: usize, z: usize, skip_narrow: bool) -> u64 {
        let word = self.word(w, y, z);
        let occupied = self.occupied[word];
        if occupied == 0 {
            return 0;
        }
        let seen = self.seen.get(w, y, z).copied().unwrap_or_default();
        let mut beside: [u64; 6] = std::array::from_fn(|f| self.free_beside(w, y, z, f));
        if skip_narrow {
            let thin = [0, 1, 2].map(|axis| beside[2 * axis] & beside[2 * axis + 1]);
            for (f, free) in beside.iter_mut().enumerate() {
                let axis = f / 2;
                *free &= !(thin[(axis + 1) % 3] | thin[(axis + 2) % 3]);
                if *free & !seen[f] & occupied != 0 {
                    *free &= self.wide_word(w, y, z, f);
                }
            }
        }
        (0..6).fold(0, |open, f| open | (beside[f] & !seen[f])) & occupied
    }

    /// Index of word `w` of row (y, z).
    #[inline]
    pub(crate) fn word(&self, w: usize, y: usize, z: usize) -> usize {
        (z * self.size[1] + y) * self.words + w
    }
}

/// The cell size, if it is one.
pub(crate) fn checked_cell_size(h: f64) -> Result<f64, Error> {
    if h > 0.0 && h.is_finite() {
        Ok(h)
    } else {
        Err(Error::Length {
            field: "cell_size",
            value: h,
        })
    }
}

/// True if no axis is longer than traversals can count.
pub(crate) fn fits(cells: [f64; 3]) -> bool {
    cells.iter().all(|&n| n <= LONGEST_AXIS)
}

/// Offset of the neighbour across each face.
pub(crate) const FACES: [Cell; 6] = [
    [-1, 0, 0],
    [1, 0, 0],
    [0, -1, 0],
    [0, 1, 0],
    [0, 0, -1],
    [0, 0, 1],
];

/// The whole number at or below, saturating; 0 for what is no number. The default build's `floor` is a call into a library.
#[inline]
fn whole(v: f64) -> i32 {
    let cut = v as i32;
    cut.saturating_sub(i32::from(f64::from(cut) > v))
}
