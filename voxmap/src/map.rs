//! The voxel map: log-odds beside bit planes of free, occupied and inspected, in rows of 64 cells along x.

use crate::changes::Dirty;
use crate::error::Error;
use crate::geometry::{Ball, Cell, CellBox, State};

/// Most cells of a map, rows padded to 64: 2 GiB of log-odds and planes.
const MOST_CELLS: usize = 1 << 30;
/// Log-odds of one unit of the stored byte.
pub(crate) const UNIT: f64 = 0.05;

/// Probabilities of the sensor model.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorModel {
    /// Occupancy of a cell that a ray ended in.
    pub hit: f64,
    /// Occupancy of a cell that rays only passed.
    pub miss: f64,
    /// Lower clamp.
    pub min: f64,
    /// Upper clamp.
    pub max: f64,
    /// A cell at or above it is occupied.
    pub occupied: f64,
}

impl Default for SensorModel {
    /// OctoMap's model: 0.7, 0.4, clamped to 0.1192..0.971, occupied from 0.5 on.
    fn default() -> Self {
        Self {
            hit: 0.7,
            miss: 0.4,
            min: 0.1192,
            max: 0.971,
            occupied: 0.5,
        }
    }
}

impl SensorModel {
    /// FUEL's launch files: 0.65, 0.35, clamped to 0.12..0.90, occupied from 0.80 on.
    pub fn fuel() -> Self {
        Self {
            hit: 0.65,
            miss: 0.35,
            min: 0.12,
            max: 0.90,
            occupied: 0.80,
        }
    }
}

/// The model in stored units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Odds {
    pub hit: i8,
    pub miss: i8,
    pub min: i8,
    pub max: i8,
    pub occupied: i8,
}

impl Odds {
    fn new(model: &SensorModel) -> Result<Self, Error> {
        let unit = |field, p: f64| {
            if p > 0.0 && p < 1.0 {
                Ok(((p / (1.0 - p)).ln() / UNIT).round().clamp(-127.0, 127.0) as i8)
            } else {
                Err(Error::Probability {
                    field,
                    value: p,
                    wanted: "above 0 and below 1",
                })
            }
        };
        let odds = Self {
            hit: unit("hit", model.hit)?,
            miss: unit("miss", model.miss)?,
            min: unit("min", model.min)?,
            max: unit("max", model.max)?,
            occupied: unit("occupied", model.occupied)?,
        };
        let check = |ok, field, value, wanted| {
            if ok {
                Ok(())
            } else {
                Err(Error::Probability {
                    field,
                    value,
                    wanted,
                })
            }
        };
        check(odds.hit > 0, "hit", model.hit, "clearly above 0.5")?;
        check(odds.miss < 0, "miss", model.miss, "clearly below 0.5")?;
        check(
            odds.min < odds.occupied,
            "min",
            model.min,
            "below `occupied`",
        )?;
        check(
            odds.max >= odds.occupied,
            "max",
            model.max,
            "at or above `occupied`",
        )?;
        Ok(odds)
    }
}

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

/// A bounded occupancy map with an inspected layer.
///
/// A cell's address is `((z * ny) + y) * row + x` with rows padded to whole 64-bit words, so that neighbours along y and
/// z stand at the same bit of other words, and one word operation serves 64 cells.
#[derive(Clone, Debug)]
pub struct VoxelMap {
    pub(crate) cell_size: f64,
    pub(crate) low: [f64; 3],
    pub(crate) size: [usize; 3],
    /// Words of a row.
    pub(crate) words: usize,
    pub(crate) odds: Odds,
    pub(crate) log: Vec<i8>,
    pub(crate) free: Vec<u64>,
    pub(crate) occupied: Vec<u64>,
    /// Inspected faces of occupied cells, in the order of [`FACES`].
    pub(crate) seen: [Vec<u64>; 6],
    pub(crate) dirty: Dirty,
    pub(crate) scan: crate::insert::Window,
}

impl VoxelMap {
    /// A map of unknown cells.
    ///
    /// # Errors
    /// [`Error`] for a cell size, bounds or probabilities that make no map, or more than 2^30 cells.
    pub fn new(config: &Config) -> Result<Self, Error> {
        let h = config.cell_size;
        if !(h > 0.0 && h.is_finite()) {
            return Err(Error::Length {
                field: "cell_size",
                value: h,
            });
        }
        let (low, high) = (config.low, config.high);
        let ordered = (0..3).all(|a| low[a].is_finite() && high[a].is_finite() && low[a] < high[a]);
        if !ordered {
            return Err(Error::Bounds { low, high });
        }
        // A millionth of a cell forgives bounds that are a whole number of cells up to rounding.
        let cells = [0, 1, 2].map(|a| ((high[a] - low[a]) / h - 1e-6).ceil().max(1.0));
        let padded = (cells[0] / 64.0).ceil() * 64.0 * cells[1] * cells[2];
        if padded > MOST_CELLS as f64 {
            return Err(Error::TooLarge {
                cells: padded,
                most: MOST_CELLS,
            });
        }
        let size = cells.map(|c| c as usize);
        let words = size[0].div_ceil(64);
        let total = words * size[1] * size[2];
        Ok(Self {
            cell_size: h,
            low,
            size,
            words,
            odds: Odds::new(&config.sensor)?,
            log: vec![0; total * 64],
            free: vec![0; total],
            occupied: vec![0; total],
            seen: std::array::from_fn(|_| vec![0; total]),
            dirty: Dirty::new(total),
            scan: crate::insert::Window::new(total),
        })
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

    /// Bytes in use, scratch planes included.
    pub fn memory(&self) -> usize {
        let planes = [&self.free, &self.occupied].into_iter().chain(&self.seen);
        self.log.capacity()
            + planes.map(|plane| plane.capacity() * 8).sum::<usize>()
            + self.dirty.memory()
            + self.scan.memory()
    }

    /// All cells of the map.
    pub fn bounds(&self) -> CellBox {
        CellBox {
            low: [0; 3],
            high: self.size.map(|n| n as i32),
        }
    }

    /// The cell that holds a point; also outside the map, saturating far away and for NaN.
    #[inline]
    pub fn cell_at(&self, point: [f64; 3]) -> Cell {
        let inverse = 1.0 / self.cell_size;
        [0, 1, 2].map(|a| ((point[a] - self.low[a]) * inverse).floor() as i32)
    }

    /// Centre of a cell in the world frame, m.
    #[inline]
    pub fn center(&self, cell: Cell) -> [f64; 3] {
        [0, 1, 2].map(|a| self.low[a] + (f64::from(cell[a]) + 0.5) * self.cell_size)
    }

    /// True if the cell lies inside the map.
    #[inline]
    pub fn contains(&self, cell: Cell) -> bool {
        (0..3).all(|a| cell[a] >= 0 && (cell[a] as usize) < self.size[a])
    }

    /// Address of a cell inside the map.
    #[inline]
    pub(crate) fn address(&self, cell: Cell) -> usize {
        (cell[2] as usize * self.size[1] + cell[1] as usize) * (self.words * 64) + cell[0] as usize
    }

    /// Cell of an address.
    pub(crate) fn cell_of(&self, address: usize) -> Cell {
        let row = self.words * 64;
        let (line, x) = (address / row, address % row);
        [
            x as i32,
            (line % self.size[1]) as i32,
            (line / self.size[1]) as i32,
        ]
    }

    /// State of a cell; unknown outside the map.
    #[inline]
    pub fn state(&self, cell: Cell) -> State {
        if self.is_free(cell) {
            State::Free
        } else if self.is_occupied(cell) {
            State::Occupied
        } else {
            State::Unknown
        }
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

    /// True for an occupied cell that is open to free space and of which every open face was inspected since it became
    /// occupied.
    pub fn is_inspected(&self, cell: Cell) -> bool {
        self.is_occupied(cell) && self.exposed_faces(cell) != 0 && self.open_faces(cell) == 0
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

    /// The faces of an occupied cell that are open to a free cell and not inspected; bits as
    /// [`exposed_faces`](Self::exposed_faces).
    pub fn open_faces(&self, cell: Cell) -> u8 {
        let mut faces = self.exposed_faces(cell);
        if faces != 0 {
            let address = self.address(cell);
            for (face, plane) in self.seen.iter().enumerate() {
                if Self::bit(plane, address) {
                    faces &= !(1 << face);
                }
            }
        }
        faces
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
                        let exposed = (0..6).fold(0, |all, f| all | self.free_beside(w, y, z, f));
                        inspected +=
                            (surface & exposed & !self.open_word(w, y, z)).count_ones() as usize;
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

    /// Occupied cells of word `w` of row (y, z) with a face that is open to free space and not inspected.
    pub(crate) fn open_word(&self, w: usize, y: usize, z: usize) -> u64 {
        let word = self.word(w, y, z);
        let occupied = self.occupied[word];
        if occupied == 0 {
            return 0;
        }
        (0..6).fold(0, |open, f| {
            open | (self.free_beside(w, y, z, f) & !self.seen[f][word])
        }) & occupied
    }

    /// Index of word `w` of row (y, z).
    #[inline]
    pub(crate) fn word(&self, w: usize, y: usize, z: usize) -> usize {
        (z * self.size[1] + y) * self.words + w
    }

    /// Sets the state of a cell, saturated; outside the map nothing happens.
    pub fn set_state(&mut self, cell: Cell, state: State) {
        if !self.contains(cell) {
            return;
        }
        let address = self.address(cell);
        self.log[address] = match state {
            State::Unknown => 0,
            State::Free => self.odds.min,
            State::Occupied => self.odds.max,
        };
        let (word, bit) = (address >> 6, 1u64 << (address & 63));
        let (was_free, was_occupied) = (self.free[word] & bit, self.occupied[word] & bit);
        self.free[word] &= !bit;
        self.occupied[word] &= !bit;
        match state {
            State::Unknown => {}
            State::Free => self.free[word] |= bit,
            State::Occupied => self.occupied[word] |= bit,
        }
        if state != State::Occupied {
            for plane in &mut self.seen {
                plane[word] &= !bit;
            }
        }
        if (was_free, was_occupied) != (self.free[word] & bit, self.occupied[word] & bit) {
            self.dirty.state(word, bit);
        }
    }

    /// A map of the cells `low..high`, cell 0 with its lower corner at the world's origin before they are counted from
    /// `low`.
    pub(crate) fn from_cells(
        cell_size: f64,
        low: Cell,
        high: Cell,
        sensor: &SensorModel,
    ) -> Result<Self, Error> {
        Self::new(&Config {
            cell_size,
            low: low.map(|v| f64::from(v) * cell_size),
            high: [0, 1, 2].map(|a| f64::from(high[a].max(low[a] + 1)) * cell_size),
            sensor: sensor.clone(),
        })
    }

    /// Log-odds of a cell inside the map, in units of 0.05.
    pub(crate) fn log(&self, cell: Cell) -> i8 {
        self.log[self.address(cell)]
    }

    /// Makes a cell inside the map known with these log-odds.
    pub(crate) fn set_log(&mut self, cell: Cell, log: i8) {
        let occupied = log >= self.odds.occupied;
        self.set_state(
            cell,
            if occupied {
                State::Occupied
            } else {
                State::Free
            },
        );
        let address = self.address(cell);
        self.log[address] = log;
    }

    /// Sets every cell whose centre lies in the ball free.
    pub fn set_free_sphere(&mut self, center: [f64; 3], radius: f64) {
        let ball = Ball { center, radius };
        self.for_cells_in(&ball, |map, cell| map.set_state(cell, State::Free));
    }

    /// Sets every cell whose centre lies in the box free, m.
    pub fn set_free_box(&mut self, low: [f64; 3], high: [f64; 3]) {
        self.set_box(low, high, State::Free);
    }

    /// Forgets every cell whose centre lies in the box, m.
    pub fn reset_box(&mut self, low: [f64; 3], high: [f64; 3]) {
        self.set_box(low, high, State::Unknown);
    }

    fn set_box(&mut self, low: [f64; 3], high: [f64; 3], state: State) {
        let (first, last) = (
            self.clamped(self.cell_at(low)),
            self.clamped(self.cell_at(high)),
        );
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let c = self.center([x, y, z]);
                    if (0..3).all(|a| low[a] <= c[a] && c[a] <= high[a]) {
                        self.set_state([x, y, z], state);
                    }
                }
            }
        }
    }

    /// The nearest cell inside the map.
    pub(crate) fn clamped(&self, cell: Cell) -> Cell {
        [0, 1, 2].map(|a| cell[a].clamp(0, self.size[a] as i32 - 1))
    }

    /// Calls `visit` for every cell inside the map whose centre lies in the ball.
    pub(crate) fn for_cells_in(&mut self, ball: &Ball, mut visit: impl FnMut(&mut Self, Cell)) {
        let Ball { center, radius } = *ball;
        if !(radius >= 0.0 && center.iter().all(|v| v.is_finite())) {
            return;
        }
        let first = self.clamped(self.cell_at(center.map(|v| v - radius)));
        let last = self.clamped(self.cell_at(center.map(|v| v + radius)));
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let c = self.center([x, y, z]);
                    let square: f64 = (0..3).map(|a| (c[a] - center[a]).powi(2)).sum();
                    if square <= radius * radius {
                        visit(self, [x, y, z]);
                    }
                }
            }
        }
    }
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
