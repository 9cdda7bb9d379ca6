//! Euclidean distance field: exact squared integers, whole or in changed boxes, trilinear value and gradient.

mod column;
mod pass;
mod turn;

use crate::changes::Changes;
use crate::error::Error;
use crate::geometry::{Cell, CellBox};
use crate::map::VoxelMap;
use crate::simd;
use pass::{Pass, Scratch};

/// Options of a distance field.
#[derive(Clone, Debug, PartialEq)]
pub struct EsdfParams {
    /// Distances are exact up to here and capped a little beyond, m.
    pub truncation: f64,
    /// Whether unknown cells are obstacles.
    pub unknown_is_occupied: bool,
}

impl Default for EsdfParams {
    fn default() -> Self {
        Self {
            truncation: 2.0,
            unknown_is_occupied: true,
        }
    }
}

/// Distance from a cell's centre to the surface of the nearest obstacle cell: centre distance less half a cell, so it is
/// negative inside (down to minus half a cell).
#[derive(Clone, Debug)]
pub struct Esdf {
    params: EsdfParams,
    cell_size: f64,
    low: [f64; 3],
    /// The map's cells when last looked at.
    bounds: CellBox,
    size: [usize; 3],
    /// Reach of the search, cells.
    reach: usize,
    /// Squared cell distances, x fastest, capped at `(reach + 1)^2`.
    square: Vec<u16>,
    /// Distance of each square, m.
    table: Vec<f32>,
    scratch: Scratch,
}

impl Esdf {
    /// The field of a map.
    ///
    /// # Errors
    /// [`Error::Length`] for a truncation that is not positive or above 250 cells.
    pub fn new(map: &VoxelMap, params: EsdfParams) -> Result<Self, Error> {
        let reach = (params.truncation / map.cell_size()).ceil() + 1.0;
        if !(params.truncation > 0.0 && reach <= 250.0) {
            return Err(Error::Length {
                field: "truncation",
                value: params.truncation,
            });
        }
        let reach = reach as usize;
        let size = map.size();
        let total = size.iter().product();
        let cap = (reach + 1) * (reach + 1);
        let h = map.cell_size();
        let mut field = Self {
            params,
            cell_size: h,
            low: map.low(),
            bounds: map.bounds(),
            size,
            reach,
            square: vec![0; total],
            table: (0..=cap)
                .map(|s| ((s as f64).sqrt() * h - 0.5 * h) as f32)
                .collect(),
            scratch: Scratch::default(),
        };
        field.rebuild(map, map.bounds());
        Ok(field)
    }

    /// Brings the field up to date with a map after `changes`. Equal to a whole rebuild, bit for bit; is one if the map's
    /// bounds changed.
    pub fn update(&mut self, map: &VoxelMap, changes: &Changes) {
        if map.bounds() != self.bounds {
            self.low = map.low();
            self.bounds = map.bounds();
            self.size = map.size();
            self.square = vec![0; self.size.iter().product()];
            return self.rebuild(map, map.bounds());
        }
        let reach = self.reach as i32;
        let whole = map.bounds();
        let price = |region: &CellBox| pass::cost(region, self.reach, self.size);
        let limit = price(&whole);
        // Where a change can be felt; boxes join while one pass over both is no dearer than two.
        let mut regions: Vec<(CellBox, usize)> = Vec::new();
        for changed in &changes.state_boxes {
            let mut region = changed.grown(reach).common(&whole);
            let mut cost = price(&region);
            while let Some(i) = regions
                .iter()
                .position(|(other, their_cost)| price(&other.joined(&region)) <= their_cost + cost)
            {
                region = regions.swap_remove(i).0.joined(&region);
                cost = price(&region);
            }
            regions.push((region, cost));
            if regions.iter().map(|(_, cost)| cost).sum::<usize>() >= limit {
                return self.rebuild(map, whole);
            }
        }
        for (region, _) in regions {
            self.rebuild(map, region);
        }
    }

    /// Recomputes the cells of a box from the map.
    fn rebuild(&mut self, map: &VoxelMap, region: CellBox) {
        let stored = CellBox {
            low: map.stored(region.low),
            high: map.stored(region.high),
        };
        simd::run(Pass {
            map,
            unknown_is_occupied: self.params.unknown_is_occupied,
            reach: self.reach,
            region: stored,
            square: &mut self.square,
            scratch: &mut self.scratch,
        });
    }

    #[inline]
    fn value(&self, address: usize) -> f64 {
        f64::from(self.table[usize::from(self.square[address])])
    }

    /// Distance of a cell, m; outside the map that of the nearest cell inside.
    pub fn cell_distance(&self, cell: Cell) -> f64 {
        let low = self.bounds.low;
        let c = [0, 1, 2]
            .map(|a| (cell[a].saturating_sub(low[a]).max(0) as usize).min(self.size[a] - 1));
        self.value((c[2] * self.size[1] + c[1]) * self.size[0] + c[0])
    }

    /// Largest value of the field, m.
    pub fn cap(&self) -> f64 {
        f64::from(self.table[self.table.len() - 1])
    }

    /// Trilinear distance at a point, m; outside the map that of the nearest point between cell centres.
    pub fn distance(&self, point: [f64; 3]) -> f64 {
        self.distance_gradient(point).0
    }

    /// [`distance`](Self::distance) at many points.
    pub fn distances(&self, points: &[[f64; 3]]) -> Vec<f64> {
        points.iter().map(|&point| self.distance(point)).collect()
    }

    /// Trilinear distance, m, and the gradient of the same interpolant; the gradient is zero along axes on which the point
    /// was clamped into the map. A point that is not a number is inside an obstacle.
    pub fn distance_gradient(&self, point: [f64; 3]) -> (f64, [f64; 3]) {
        let inverse = 1.0 / self.cell_size;
        let mut base = [0usize; 3];
        let mut step = [0usize; 3];
        let mut t = [0.0f64; 3];
        let stride = [1, self.size[0], self.size[0] * self.size[1]];
        for a in 0..3 {
            let u = (point[a] - self.low[a]) * inverse - 0.5;
            if u.is_nan() {
                return (-self.cell_size, [0.0; 3]);
            }
            let top = (self.size[a] - 1) as f64;
            let clamped = u.clamp(0.0, top);
            let cell = (clamped as usize).min(self.size[a].saturating_sub(2));
            base[a] = cell;
            t[a] = clamped - cell as f64;
            step[a] = if self.size[a] > 1 && u > 0.0 && u < top {
                stride[a]
            } else {
                0
            };
            // On a clamped axis both corners are the same cell.
            if step[a] == 0 {
                base[a] = clamped.round() as usize;
                t[a] = 0.0;
            }
        }
        let at = base[0] + base[1] * stride[1] + base[2] * stride[2];
        let v =
            |i: usize, j: usize, k: usize| self.value(at + i * step[0] + j * step[1] + k * step[2]);
        let lerp = |a: f64, b: f64, t: f64| a + t * (b - a);
        // c[j][k]: interpolated along x; d: its slope.
        let mut c = [[0.0; 2]; 2];
        let mut d = [[0.0; 2]; 2];
        for j in 0..2 {
            for k in 0..2 {
                let (a, b) = (v(0, j, k), v(1, j, k));
                c[j][k] = lerp(a, b, t[0]);
                d[j][k] = b - a;
            }
        }
        let low = lerp(c[0][0], c[1][0], t[1]);
        let high = lerp(c[0][1], c[1][1], t[1]);
        let gradient = [
            lerp(
                lerp(d[0][0], d[1][0], t[1]),
                lerp(d[0][1], d[1][1], t[1]),
                t[2],
            ) * inverse,
            lerp(c[1][0] - c[0][0], c[1][1] - c[0][1], t[2]) * inverse,
            (high - low) * inverse,
        ];
        (lerp(low, high, t[2]), gradient)
    }
}
