//! The 2-D cost map of the base: columns of the voxel map, and exact clearance to what is not known free.

use crate::error::Error;
use crate::geometry::CellBox;
use crate::map::VoxelMap;
use crate::rings::rings;

/// Clearance is exact up to here and a lower bound beyond, m.
const EXACT: f64 = 1.0;

/// Which heights count.
#[derive(Clone, Debug, PartialEq)]
pub struct CostMapParams {
    /// A column with an occupied cell whose height range meets this band above cell 0's lower side is an obstacle, m. That is
    /// the lower bound of a bounded map, and z = 0 in a growing one.
    pub occupied_band: (f64, f64),
    /// A column is free if all its cells that meet this band are known free, m.
    pub free_band: (f64, f64),
}

impl Default for CostMapParams {
    fn default() -> Self {
        Self {
            occupied_band: (0.0, 1.5),
            free_band: (0.0, 0.6),
        }
    }
}

/// What is known of a ground cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ground {
    /// Not wholly known in the free band, and no obstacle.
    Unknown,
    /// Known free.
    Free,
    /// Holds something occupied.
    Obstacle,
}

/// A grid of ground cells with clearances.
#[derive(Clone, Debug)]
pub struct CostMap {
    params: CostMapParams,
    cell_size: f64,
    low: [f64; 2],
    /// The voxel map's cells when projected; ground cell (0, 0) lies below its lowest.
    bounds: CellBox,
    size: [usize; 2],
    ground: Vec<Ground>,
    /// Steps of the king to the nearest blocked cell (not free, or outside), 0 for blocked ones, capped.
    blocked_rings: Vec<u8>,
    /// The same to the nearest obstacle.
    obstacle_rings: Vec<u8>,
    revision: u64,
    free: usize,
}

impl CostMap {
    /// Projects a voxel map.
    ///
    /// # Errors
    /// [`Error::Length`] for a band that is empty or not finite.
    pub fn project(map: &VoxelMap, params: &CostMapParams) -> Result<Self, Error> {
        for (field, (low, high)) in [
            ("occupied_band", params.occupied_band),
            ("free_band", params.free_band),
        ] {
            if !(low.is_finite() && high.is_finite() && low < high) {
                return Err(Error::Length {
                    field,
                    value: high - low,
                });
            }
        }
        let size = [map.size()[0], map.size()[1]];
        let mut grid = Self {
            params: params.clone(),
            cell_size: map.cell_size(),
            low: [map.low()[0], map.low()[1]],
            bounds: map.bounds(),
            size,
            ground: vec![Ground::Unknown; size[0] * size[1]],
            blocked_rings: Vec::new(),
            obstacle_rings: Vec::new(),
            revision: 0,
            free: 0,
        };
        grid.update(map, &[map.bounds()]);
        Ok(grid)
    }

    /// A map of checked ground that comes from elsewhere.
    pub(crate) fn of_ground(
        cell_size: f64,
        low: [f64; 2],
        size: [usize; 2],
        ground: Vec<Ground>,
        params: CostMapParams,
    ) -> Self {
        let mut grid = Self {
            params,
            cell_size,
            low,
            bounds: CellBox {
                low: [0; 3],
                high: [size[0] as i32, size[1] as i32, 0],
            },
            size,
            ground,
            blocked_rings: Vec::new(),
            obstacle_rings: Vec::new(),
            revision: 0,
            free: 0,
        };
        grid.measure();
        grid
    }

    /// Recomputes what follows from the ground.
    fn measure(&mut self) {
        self.revision += 1;
        self.free = self.ground.iter().filter(|&&g| g == Ground::Free).count();
        let is = |wanted: Ground| self.ground.iter().map(move |&g| g == wanted);
        self.blocked_rings = rings(is(Ground::Free).map(|free| !free), self.size[0], true);
        self.obstacle_rings = rings(is(Ground::Obstacle), self.size[0], false);
    }

    /// Projects the columns of the changed boxes again. Equal to a whole projection; is one if the map's bounds changed.
    pub fn update(&mut self, map: &VoxelMap, boxes: &[CellBox]) {
        if map.bounds() != self.bounds {
            let size = [map.size()[0], map.size()[1]];
            self.low = [map.low()[0], map.low()[1]];
            self.bounds = map.bounds();
            self.size = size;
            self.ground = vec![Ground::Unknown; size[0] * size[1]];
            let revision = std::mem::take(&mut self.revision);
            self.update(map, &[map.bounds()]);
            self.revision += revision;
            return;
        }
        let first = self.bounds.low;
        // Stored layers that meet a band, and whether the map holds all of them. Heights count from cell 0.
        let layers = |(low, high): (f64, f64)| {
            let h = self.cell_size;
            let top = map.size()[2] as i32;
            let from = ((low / h + 1e-9).floor() as i32).saturating_sub(first[2]);
            let to = ((high / h - 1e-9).ceil() as i32).saturating_sub(first[2]);
            let inside = from.clamp(0, top) as usize..to.clamp(0, top) as usize;
            (inside, from >= 0 && to <= top)
        };
        let (occupied, _) = layers(self.params.occupied_band);
        let (free, whole) = layers(self.params.free_band);
        // Layers that a growing map does not hold yet are unknown; a bounded map has nothing beyond its bounds.
        let hopeless = !whole && map.is_growing();
        let mut changed = self.revision == 0;
        for b in boxes {
            let cells = b.common(&self.bounds);
            if cells.volume() == 0 {
                continue;
            }
            let [x0, x1] = [cells.low[0] - first[0], cells.high[0] - first[0]].map(|v| v as usize);
            for y in (cells.low[1] - first[1]) as usize..(cells.high[1] - first[1]) as usize {
                for w in x0 / 64..=(x1 - 1) / 64 {
                    // 64 columns at once.
                    let obstacle = occupied
                        .clone()
                        .fold(0, |any, z| any | map.occupied[map.word(w, y, z)]);
                    let open = if hopeless {
                        0
                    } else {
                        free.clone()
                            .fold(u64::MAX, |all, z| all & map.free[map.word(w, y, z)])
                    };
                    for x in (w * 64).max(x0)..(w * 64 + 64).min(x1) {
                        let ground = if obstacle >> (x % 64) & 1 != 0 {
                            Ground::Obstacle
                        } else if open >> (x % 64) & 1 != 0 {
                            Ground::Free
                        } else {
                            Ground::Unknown
                        };
                        let slot = &mut self.ground[y * self.size[0] + x];
                        if *slot != ground {
                            *slot = ground;
                            changed = true;
                        }
                    }
                }
            }
        }
        if changed {
            self.measure();
        }
    }

    /// Edge of a cell, m.
    pub fn cell_size(&self) -> f64 {
        self.cell_size
    }

    /// Cells along x and y.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Lower corner in the world frame, m.
    pub fn low(&self) -> [f64; 2] {
        self.low
    }

    /// Counts up whenever a cell changed.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Number of free cells.
    pub fn free_count(&self) -> usize {
        self.free
    }

    /// The cell that holds a point; also outside.
    pub fn cell_at(&self, point: [f64; 2]) -> [i32; 2] {
        [0, 1].map(|a| ((point[a] - self.low[a]) / self.cell_size).floor() as i32)
    }

    /// Centre of a cell, m.
    pub fn center(&self, cell: [i32; 2]) -> [f64; 2] {
        [0, 1].map(|a| self.low[a] + (f64::from(cell[a]) + 0.5) * self.cell_size)
    }

    /// The map as a robot of that radius sees it: cells whose centre has an obstacle nearer than `radius` m are obstacles.
    ///
    /// # Errors
    /// [`Error::Length`] for a radius that is negative or above 1 m, up to which clearances are exact.
    pub fn inflated(&self, radius: f64) -> Result<Self, Error> {
        if !(0.0..=EXACT).contains(&radius) {
            return Err(Error::Length {
                field: "radius",
                value: radius,
            });
        }
        let mut ground = self.ground.clone();
        for (i, slot) in ground.iter_mut().enumerate() {
            let center = self.center([(i % self.size[0]) as i32, (i / self.size[0]) as i32]);
            if self.obstacle_clearance(center) < radius {
                *slot = Ground::Obstacle;
            }
        }
        let params = self.params.clone();
        Ok(Self::of_ground(
            self.cell_size,
            self.low,
            self.size,
            ground,
            params,
        ))
    }

    /// What is known of a cell; unknown outside.
    pub fn ground(&self, cell: [i32; 2]) -> Ground {
        self.index(cell).map_or(Ground::Unknown, |i| self.ground[i])
    }

    fn index(&self, [x, y]: [i32; 2]) -> Option<usize> {
        (x >= 0 && y >= 0 && (x as usize) < self.size[0] && (y as usize) < self.size[1])
            .then(|| y as usize * self.size[0] + x as usize)
    }

    /// Distance from a point to the nearest cell square that is not known free, m; outside the map counts as such. Exact up
    /// to 1 m and a lower bound beyond; negative inside such a square, minus the distance to its border.
    pub fn clearance(&self, point: [f64; 2]) -> f64 {
        self.distance(point, &self.blocked_rings, |g| g != Ground::Free, true)
    }

    /// Whether [`clearance`](Self::clearance) is at least `wanted` m, at most 1 m: quicker than to measure it.
    pub fn has_clearance(&self, point: [f64; 2], wanted: f64) -> bool {
        if let Some(index) = self.index(self.cell_at(point))
            && wanted <= EXACT
        {
            let ring = f64::from(self.blocked_rings[index]);
            // A blocked cell that many king's steps away is no farther than its nearest corner can be, and no nearer than its rows.
            if (ring - 1.0) * self.cell_size >= wanted {
                return true;
            }
            if ring * std::f64::consts::SQRT_2 * self.cell_size < wanted {
                return false;
            }
        }
        self.clearance(point) >= wanted
    }

    /// [`clearance`](Self::clearance) to obstacles alone: unknown ground and the outside do not count.
    pub fn obstacle_clearance(&self, point: [f64; 2]) -> f64 {
        self.distance(
            point,
            &self.obstacle_rings,
            |g| g == Ground::Obstacle,
            false,
        )
    }

    fn distance(
        &self,
        point: [f64; 2],
        rings: &[u8],
        blocks: impl Fn(Ground) -> bool,
        outside: bool,
    ) -> f64 {
        if !point.iter().all(|v| v.is_finite()) {
            return -self.cell_size;
        }
        let h = self.cell_size;
        let at = self.cell_at(point);
        let Some(index) = self.index(at) else {
            return if outside { -self.cell_size } else { EXACT };
        };
        // All cells closer than this many king's steps are unblocked.
        let ring = i32::from(rings[index]);
        // Distance from the point to the border of its own cell, the nearest side.
        let border = [0, 1].map(|a| {
            let t = (point[a] - self.low[a]) / h - f64::from(at[a]);
            t.min(1.0 - t) * h
        });
        if ring == 0 {
            return -border[0].min(border[1]).max(0.0);
        }
        let at_least = f64::from(ring - 1) * h + border[0].min(border[1]);
        if at_least >= EXACT {
            return at_least;
        }
        // No blocked cell lies in the rings below; none beyond the diagonal can be nearer than one on this ring.
        let last = (f64::from(ring + 1) * std::f64::consts::SQRT_2).ceil() as i32 + 1;
        let mut best = f64::INFINITY;
        for r in ring..=last {
            if ((f64::from(r) - 1.0) * h).powi(2) >= best {
                break;
            }
            for (dx, dy) in ring_cells(r) {
                let cell = [at[0] + dx, at[1] + dy];
                let blocked = match self.index(cell) {
                    Some(i) => blocks(self.ground[i]),
                    None => outside,
                };
                if blocked {
                    let gap = [0, 1].map(|a| {
                        let low = self.low[a] + f64::from(cell[a]) * h;
                        (low - point[a]).max(point[a] - low - h).max(0.0)
                    });
                    best = best.min(gap[0] * gap[0] + gap[1] * gap[1]);
                }
            }
        }
        best.sqrt().min(f64::from(last) * h)
    }
}

/// The cells exactly `r` king's steps away.
fn ring_cells(r: i32) -> impl Iterator<Item = (i32, i32)> {
    (-r..=r)
        .flat_map(move |d| [(d, -r), (d, r)])
        .chain((1 - r..r).flat_map(move |d| [(-r, d), (r, d)]))
}
