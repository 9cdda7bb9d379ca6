//! Maps without bounds: they grow to hold what scans touch, and can be cropped to a window that follows the robot.

use crate::changes::Dirty;
use crate::error::Error;
use crate::geometry::{Cell, CellBox};
use crate::insert::Scan;
use crate::map::{MOST_CELLS, VoxelMap, checked_cell_size, fits};
use crate::sensor::{Odds, SensorModel};

/// Bounds of growing maps are multiples of pages.
const PAGE: [i32; 3] = [64, 8, 8];
/// Farthest cell from the anchor.
const FARTHEST: f64 = (1 << 29) as f64;

impl VoxelMap {
    /// A map that grows with its scans, to at most `most` cells (and never more than 2^30); cell 0 has its lower corner at
    /// the world's origin, and cells keep their indices while the map grows. Bit planes are dense over the bounds: a quarter of
    /// a byte a cell, and the log-odds where something was seen. Only scans grow it; before states are set by hand,
    /// [`grow`](Self::grow) makes room.
    ///
    /// When [`bounds`](Self::bounds) have changed, distance fields, cost maps and frontiers start over by themselves at
    /// their next update; growth is generous, so that this is rare.
    ///
    /// # Errors
    /// [`Error`] for a cell size or probabilities that make no map, or a limit below one page of 4096 cells.
    pub fn growing(cell_size: f64, sensor: &SensorModel, most: usize) -> Result<Self, Error> {
        let h = checked_cell_size(cell_size)?;
        let page = PAGE.iter().product::<i32>();
        if most < page as usize {
            return Err(Error::TooLarge {
                cells: f64::from(page),
                most,
            });
        }
        let odds = Odds::new(sensor)?;
        let mut map = Self::blank(h, [0.0; 3], [0; 3], PAGE.map(|n| n as usize), odds);
        map.limit = Some(most.min(MOST_CELLS));
        Ok(map)
    }

    /// Makes sure that a growing map holds these cells. Returns whether its bounds changed.
    ///
    /// # Errors
    /// [`Error::Fixed`] for a bounded map that does not hold them, [`Error::TooLarge`] if the map would have more cells
    /// than it may.
    pub fn grow(&mut self, cells: CellBox) -> Result<bool, Error> {
        let now = self.bounds();
        if (0..3).all(|a| cells.low[a] >= now.low[a] && cells.high[a] <= now.high[a]) {
            return Ok(false);
        }
        let Some(most) = self.limit else {
            return Err(Error::Fixed { bounds: now });
        };
        // An empty map need not hold the place where it was made.
        let empty = self
            .free
            .iter()
            .chain(&self.occupied)
            .all(|word| *word == 0);
        let wanted = if empty { cells } else { now.joined(&cells) };
        // A quarter more than needed on sides that move, so that growth costs little in the long run.
        let generous = CellBox {
            low: [0, 1, 2].map(|a| {
                let more = if wanted.low[a] < now.low[a] {
                    self.size[a] as i32 / 4
                } else {
                    0
                };
                wanted.low[a].saturating_sub(more)
            }),
            high: [0, 1, 2].map(|a| {
                let more = if wanted.high[a] > now.high[a] {
                    self.size[a] as i32 / 4
                } else {
                    0
                };
                wanted.high[a].saturating_add(more)
            }),
        };
        let (generous, exact) = (paged(&generous), paged(&wanted));
        for bounds in [generous, exact] {
            if cells_of(&bounds) <= most as f64 && fits(edges(&bounds)) {
                self.lay_out(bounds);
                return Ok(true);
            }
        }
        Err(Error::TooLarge {
            cells: cells_of(&exact),
            most,
        })
    }

    /// Forgets everything outside a box, rounded outwards to pages of 64 x 8 x 8 cells, and gives its memory back: a window
    /// that follows the robot.
    ///
    /// # Errors
    /// [`Error::Fixed`] for a bounded map, [`Error::TooLarge`] if the box has more cells than the map may or none.
    pub fn crop(&mut self, cells: CellBox) -> Result<(), Error> {
        let Some(most) = self.limit else {
            return Err(Error::Fixed {
                bounds: self.bounds(),
            });
        };
        let bounds = paged(&cells);
        let count = cells_of(&bounds);
        let empty = (0..3).any(|a| cells.low[a] >= cells.high[a]);
        if empty || count > most as f64 || !fits(edges(&bounds)) {
            return Err(Error::TooLarge { cells: count, most });
        }
        self.lay_out(bounds);
        Ok(())
    }

    /// True for a map that grows.
    pub fn is_growing(&self) -> bool {
        self.limit.is_some()
    }

    /// Grows to hold what a scan may touch.
    pub(crate) fn grow_for(&mut self, scan: &Scan<'_>) -> Result<(), Error> {
        if self.limit.is_none() {
            return Ok(());
        }
        let (mut low, mut high) = (scan.origin, scan.origin);
        for points in [scan.hits, scan.misses] {
            for point in points {
                let way = [0, 1, 2].map(|a| f64::from(point[a]) - scan.origin[a]);
                let length = way.iter().map(|v| v * v).sum::<f64>().sqrt();
                if !(length > 0.0 && length.is_finite()) {
                    continue;
                }
                let share = (scan.max_range / length).min(1.0 + scan.hit_depth / length);
                for a in 0..3 {
                    let end = scan.origin[a] + share * way[a];
                    low[a] = low[a].min(end);
                    high[a] = high[a].max(end);
                }
            }
        }
        let cell = |v: f64| (v / self.cell_size).floor();
        let far = low
            .iter()
            .chain(&high)
            .fold(0.0, |far: f64, &v| far.max(cell(v).abs()));
        if far > FARTHEST {
            let cells = (0..3).map(|a| cell(high[a]) - cell(low[a]) + 1.0).product();
            return Err(Error::TooLarge {
                cells,
                most: self.limit.unwrap_or(MOST_CELLS),
            });
        }
        self.grow(CellBox {
            low: low.map(|v| cell(v) as i32 - 1),
            high: high.map(|v| cell(v) as i32 + 2),
        })?;
        Ok(())
    }

    /// Moves everything to other bounds (multiples of pages); what lies outside is dropped.
    fn lay_out(&mut self, bounds: CellBox) {
        let size = [0, 1, 2].map(|a| (bounds.high[a] - bounds.low[a]) as usize);
        let mut new = Self::blank(self.cell_size, self.anchor, bounds.low, size, self.odds);
        let by = [0, 1, 2].map(|a| (self.first[a] - bounds.low[a]) as isize);
        let both = self.bounds().common(&bounds);
        let pages = [by[0] / 64, by[1] / 8, by[2] / 8];
        new.log = self.log.moved(new.words, size, pages);
        new.seen = self.seen.moved(new.words, size, pages);
        new.skip_narrow = self.skip_narrow;
        new.skip_strips = self.skip_strips;
        // Of an empty box of common cells nothing is copied.
        let layers = if both.volume() > 0 {
            both.low[2]..both.high[2]
        } else {
            0..0
        };
        for z in layers {
            for y in both.low[1]..both.high[1] {
                let row = |map: &Self, x: i32| {
                    let s = map.stored([x, y, z]).map(|v| v as usize);
                    map.word(s[0] / 64, s[1], s[2])
                };
                let n = ((both.high[0] - both.low[0]).max(0) / 64) as usize;
                let (from, to) = (row(self, both.low[0]), row(&new, both.low[0]));
                new.free[to..to + n].copy_from_slice(&self.free[from..from + n]);
                new.occupied[to..to + n].copy_from_slice(&self.occupied[from..from + n]);
            }
        }
        let bytes = |map: &Self, word: usize| {
            map.occupied[word]
                .to_le_bytes()
                .map(|b| b.count_ones() as u16)
        };
        for z in 0..size[2] {
            for y in 0..size[1] {
                for w in 0..new.words {
                    let counts = bytes(&new, new.word(w, y, z));
                    let at = (z / 8 * size[1].div_ceil(8) + y / 8) * new.words * 8 + w * 8;
                    for (count, more) in new.blocks[at..at + 8].iter_mut().zip(counts) {
                        *count += more;
                    }
                }
            }
        }
        // Changes not yet taken move along.
        let mut dirty = Dirty::new(new.free.len());
        for (word, state, inspected) in self.dirty.pending() {
            let cell: Cell = self.cell_of_word(word);
            if new.contains(cell) {
                let to = new.address(cell) / 64;
                dirty.state(to, state);
                dirty.inspected(to, inspected);
            }
        }
        new.dirty = dirty;
        new.scans = self.scans;
        new.limit = self.limit;
        *self = new;
    }
}

/// A box rounded outwards to pages.
fn paged(cells: &CellBox) -> CellBox {
    CellBox {
        low: [0, 1, 2].map(|a| cells.low[a].div_euclid(PAGE[a]).saturating_mul(PAGE[a])),
        high: [0, 1, 2].map(|a| {
            let pages = cells.high[a]
                .saturating_sub(1)
                .div_euclid(PAGE[a])
                .saturating_add(1);
            pages.saturating_mul(PAGE[a])
        }),
    }
}

fn edges(bounds: &CellBox) -> [f64; 3] {
    [0, 1, 2].map(|a| (f64::from(bounds.high[a]) - f64::from(bounds.low[a])).max(0.0))
}

fn cells_of(bounds: &CellBox) -> f64 {
    edges(bounds).iter().product()
}
