//! A copy of a map made for casting rays: one byte a cell.

use super::fan::{Fan, FanPose};
use crate::map::{Cell, Map};

/// What a cell is to a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellState {
    /// Not known: shown by a ray, which goes on.
    Unknown,
    /// Free: a ray goes on.
    Free,
    /// Occupied: a ray ends.
    Occupied,
}

const OCCUPIED: u8 = 1;
const UNKNOWN: u8 = 2;
const OF_INTEREST: u8 = 4;
const SHOWN: u8 = UNKNOWN | OF_INTEREST;

/// A box of a map as rays need it. Outside the box nothing is of interest and nothing stops a ray.
#[derive(Clone, Debug)]
pub struct SightGrid {
    low: Cell,
    size: [usize; 3],
    cell_size: f64,
    /// World position of the box's lower corner, m.
    corner: [f64; 3],
    /// The box and one layer of occupied cells around it, at which rays end without being counted.
    cells: Vec<u8>,
    /// Cells shown by the view under way.
    shown: Vec<u64>,
    list: Vec<u32>,
    /// Cells met by rays of the view under way, with the opacity before them.
    met: Vec<(u32, f32)>,
}

/// How unknown space is expected to hide what lies behind it: a ray of length l (m) through it goes on with a chance of
/// `exp(-density l)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Haze {
    /// Density of unknown cells of interest, 1/m.
    pub of_interest: f64,
    /// Density of other unknown cells, 1/m.
    pub elsewhere: f64,
}

impl SightGrid {
    /// Copies the cells from `bounds.0` to below `bounds.1`; `of_interest` are the cells that views should show.
    pub fn new(map: &impl Map, bounds: (Cell, Cell), of_interest: impl Fn(Cell) -> bool) -> Self {
        let (low, high) = bounds;
        let size = [0, 1, 2].map(|a| (i64::from(high[a]) - i64::from(low[a])).max(0) as usize);
        let h = map.cell_size();
        let total = size.iter().map(|n| n + 2).product();
        let mut grid = Self {
            low,
            size,
            cell_size: h,
            corner: map.center(low).map(|v| v - 0.5 * h),
            cells: vec![OCCUPIED; total],
            shown: vec![0; usize::div_ceil(total, 64)],
            list: Vec::new(),
            met: Vec::new(),
        };
        for z in low[2]..high[2] {
            for y in low[1]..high[1] {
                for x in low[0]..high[0] {
                    let cell = [x, y, z];
                    let state = if map.is_occupied(cell) {
                        OCCUPIED
                    } else if map.is_free(cell) {
                        0
                    } else {
                        UNKNOWN
                    };
                    let interest = if of_interest(cell) { OF_INTEREST } else { 0 };
                    if let Some(i) = grid.index(cell) {
                        grid.cells[i] = state | interest;
                    }
                }
            }
        }
        grid
    }

    /// Sets what a cell is to rays; outside the box nothing happens. Whether it is of interest stays.
    pub fn set(&mut self, cell: Cell, state: CellState) {
        if let Some(i) = self.index(cell) {
            self.cells[i] = self.cells[i] & OF_INTEREST
                | match state {
                    CellState::Unknown => UNKNOWN,
                    CellState::Free => 0,
                    CellState::Occupied => OCCUPIED,
                };
        }
    }

    /// Whether an index (of [`view`](Self::view)) is a cell that a view could show now: unknown and of interest.
    pub fn is_open(&self, index: u32) -> bool {
        self.cells[index as usize] == SHOWN
    }

    /// Whether a cell stops rays.
    pub fn is_occupied(&self, index: u32) -> bool {
        self.cells[index as usize] & OCCUPIED != 0
    }

    /// The index of a cell; none outside the box.
    pub fn index_of(&self, cell: Cell) -> Option<u32> {
        self.index(cell).and_then(|i| u32::try_from(i).ok())
    }

    /// Number of cells of the box.
    pub fn len(&self) -> usize {
        self.size.iter().product()
    }

    /// True if the box holds no cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Indices from a cell to the next along each axis.
    fn strides(&self) -> [usize; 3] {
        let [nx, ny, _] = self.size.map(|n| n + 2);
        [1, nx, nx * ny]
    }

    fn index(&self, cell: Cell) -> Option<usize> {
        let [x, y, z] = [0, 1, 2].map(|a| {
            usize::try_from(i64::from(cell[a]) - i64::from(self.low[a]))
                .ok()
                .filter(|v| *v < self.size[a])
        });
        let [_, row, layer] = self.strides();
        Some((z? + 1) * layer + (y? + 1) * row + x? + 1)
    }

    /// The cell of an index.
    pub fn cell(&self, index: u32) -> Cell {
        let i = index as usize;
        let [_, row, layer] = self.strides();
        let at = [i % row, i % layer / row, i / layer];
        [0, 1, 2].map(|a| self.low[a] + at[a] as i32 - 1)
    }

    /// The cells that a fan of rays shows (FLAP sect. 3.1), as ascending indices: every unknown cell of interest that a ray
    /// leaves before its range ends and before it comes to an occupied cell.
    ///
    /// The camera may stand outside the box. A pose that is not finite shows nothing.
    pub fn view(&mut self, fan: &Fan, pose: &FanPose) -> &[u32] {
        self.list.clear();
        self.cast_all::<false>(fan, pose, Haze::default());
        for &i in &self.list {
            self.shown[i as usize / 64] = 0;
        }
        self.list.sort_unstable();
        &self.list
    }

    /// As [`view`](Self::view), with the chance that each cell is shown if unknown space hides what lies behind it: that
    /// of the clearest ray that meets it, 1 where no unknown cell stands before it. The published view is that of no haze.
    pub fn view_through(&mut self, fan: &Fan, pose: &FanPose, haze: Haze) -> Vec<(u32, f64)> {
        self.met.clear();
        self.cast_all::<true>(fan, pose, haze);
        self.met
            .sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        self.met.dedup_by_key(|met| met.0);
        let chance = |&(i, opacity): &(u32, f32)| (i, f64::from(-opacity).exp());
        self.met.iter().map(chance).collect()
    }

    fn cast_all<const HAZE: bool>(&mut self, fan: &Fan, pose: &FanPose, haze: Haze) {
        let finite = pose.position.iter().all(|v| v.is_finite());
        if !finite || !pose.yaw.is_finite() || !pose.pitch.is_finite() || self.is_empty() {
            return;
        }
        let from = [0, 1, 2].map(|a| (pose.position[a] - self.corner[a]) / self.cell_size);
        let range = fan.range() / self.cell_size;
        let density = [haze.elsewhere, haze.of_interest].map(|d| d * self.cell_size);
        for direction in fan.directions(pose) {
            self.cast::<HAZE>(from, direction, range, density);
        }
    }

    /// One ray, in cells from the box's corner.
    #[inline]
    fn cast<const HAZE: bool>(
        &mut self,
        from: [f64; 3],
        direction: [f64; 3],
        range: f64,
        density: [f64; 2],
    ) {
        // The part of the ray inside the box.
        let (mut enter, mut leave) = (0.0f64, range);
        for a in 0..3 {
            let inverse = 1.0 / direction[a];
            let (t0, t1) = (
                -from[a] * inverse,
                (self.size[a] as f64 - from[a]) * inverse,
            );
            if direction[a] != 0.0 {
                enter = enter.max(t0.min(t1));
                leave = leave.min(t0.max(t1));
            } else if !(0.0..self.size[a] as f64).contains(&from[a]) {
                return;
            }
        }
        if enter >= leave {
            return;
        }
        let strides = self.strides().map(|s| s as isize);
        let mut index: isize = strides.iter().sum();
        let (mut next, mut delta, mut step) = ([f64::INFINITY; 3], [f64::INFINITY; 3], [0isize; 3]);
        for a in 0..3 {
            let at = (from[a] + enter * direction[a]).floor();
            let at = at.clamp(0.0, self.size[a] as f64 - 1.0);
            index += at as isize * strides[a];
            if direction[a] > 0.0 {
                delta[a] = 1.0 / direction[a];
                next[a] = (at + 1.0 - from[a]) * delta[a];
                step[a] = strides[a];
            } else if direction[a] < 0.0 {
                delta[a] = -1.0 / direction[a];
                next[a] = (from[a] - at) * delta[a];
                step[a] = -strides[a];
            }
        }
        let (mut entered, mut opacity) = (enter, 0.0);
        // Which border comes next is as good as random, so it is chosen without a branch: of equal ones the lowest axis.
        let [mut next_x, mut next_y, mut next_z] = next;
        let [delta_x, delta_y, delta_z] = delta.map(f64::to_bits);
        loop {
            let leave = next_x.min(next_y).min(next_z);
            let state = self.cells[index as usize];
            // A cell that the range cuts is not shown.
            if state & OCCUPIED != 0 || leave >= range {
                return;
            }
            if HAZE {
                if state == SHOWN {
                    self.met.push((index as u32, opacity as f32));
                }
                if state & UNKNOWN != 0 {
                    let kind = usize::from(state & OF_INTEREST != 0);
                    opacity += density[kind] * (leave - entered);
                }
                entered = leave;
            } else if state == SHOWN {
                let (word, bit) = (index as usize / 64, 1u64 << (index as usize % 64));
                if self.shown[word] & bit == 0 {
                    self.shown[word] |= bit;
                    self.list.push(index as u32);
                }
            }
            let x = next_x == leave;
            let y = !x & (next_y == leave);
            let z = !x & !y;
            // All ones for the axis that is crossed.
            let [x, y, z] = [x, y, z].map(|crossed| u64::from(crossed).wrapping_neg());
            next_x += f64::from_bits(delta_x & x);
            next_y += f64::from_bits(delta_y & y);
            next_z += f64::from_bits(delta_z & z);
            index += step[0] & x as isize | step[1] & y as isize | step[2] & z as isize;
        }
    }
}
