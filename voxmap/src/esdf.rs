//! Euclidean distance field: exact squared integers, whole or in changed boxes, trilinear value and gradient.

use crate::changes::Changes;
use crate::error::Error;
use crate::geometry::{Cell, CellBox};
use crate::map::VoxelMap;

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
    size: [usize; 3],
    /// Reach of the search, cells.
    reach: usize,
    /// Squared cell distances, x fastest, capped at `(reach + 1)^2`.
    square: Vec<u16>,
    /// Distance of each square, m.
    table: Vec<f32>,
    /// Distances, m, same order as `square`.
    value: Vec<f32>,
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
            size,
            reach,
            square: vec![0; total],
            table: (0..=cap)
                .map(|s| ((s as f64).sqrt() * h - 0.5 * h) as f32)
                .collect(),
            value: vec![0.0; total],
        };
        field.rebuild(map, map.bounds());
        Ok(field)
    }

    /// Brings the field up to date with a map after `changes`. Equal to a whole rebuild, bit for bit.
    pub fn update(&mut self, map: &VoxelMap, changes: &Changes) {
        let reach = self.reach as i32;
        let whole = map.bounds();
        let grown: Vec<CellBox> = changes
            .state_boxes
            .iter()
            .map(|b| {
                let g = b.grown(reach);
                CellBox {
                    low: [0, 1, 2].map(|a| g.low[a].max(0)),
                    high: [0, 1, 2].map(|a| g.high[a].min(whole.high[a])),
                }
            })
            .collect();
        // A box costs its own volume once more grown by the reach; past half the map the whole is cheaper.
        let cost: usize = grown
            .iter()
            .map(|b| b.grown(reach).volume().min(whole.volume()))
            .sum();
        if 2 * cost > whole.volume() {
            self.rebuild(map, whole);
        } else {
            for region in grown {
                self.rebuild(map, region);
            }
        }
    }

    /// Recomputes the cells of a box from the map: along x by two sweeps, along y and z by minima over shifts.
    fn rebuild(&mut self, map: &VoxelMap, region: CellBox) {
        let cap = ((self.reach + 1) * (self.reach + 1)) as u16;
        let low = region.low.map(|v| v as usize);
        let high = region.high.map(|v| v as usize);
        if (0..3).any(|a| low[a] >= high[a]) {
            return;
        }
        let nx = high[0] - low[0];
        // Rows that can reach the region.
        let rows = [1, 2].map(|a| {
            (
                low[a].saturating_sub(self.reach),
                (high[a] + self.reach).min(self.size[a]),
            )
        });
        let [(y0, y1), (z0, z1)] = rows;
        let ny = y1 - y0;
        let mut along_x = vec![cap; nx * ny * (z1 - z0)];
        for z in z0..z1 {
            for y in y0..y1 {
                let out = &mut along_x[((z - z0) * ny + (y - y0)) * nx..][..nx];
                self.sweep(map, y, z, low[0], out, cap);
            }
        }
        let inner = high[1] - low[1];
        let mut along_y = vec![cap; nx * inner * (z1 - z0)];
        for z in 0..z1 - z0 {
            for y in 0..inner {
                let out = &mut along_y[(z * inner + y) * nx..][..nx];
                let here = y + low[1] - y0;
                nearest(out, here, ny, self.reach, |k| {
                    &along_x[(z * ny + k) * nx..][..nx]
                });
            }
        }
        for z in low[2]..high[2] {
            for y in 0..inner {
                let start = (z * self.size[1] + y + low[1]) * self.size[0] + low[0];
                let out = &mut self.square[start..start + nx];
                out.fill(cap);
                nearest(out, z - z0, z1 - z0, self.reach, |k| {
                    &along_y[(k * inner + y) * nx..][..nx]
                });
                for (value, &square) in self.value[start..start + nx].iter_mut().zip(&*out) {
                    *value = self.table[usize::from(square)];
                }
            }
        }
    }

    /// Squared distances along x of cells `x0..x0 + out.len()` of row (y, z).
    fn sweep(&self, map: &VoxelMap, y: usize, z: usize, x0: usize, out: &mut [u16], cap: u16) {
        let first = map.word(0, y, z);
        let blocked = |x: usize| {
            let (word, bit) = (first + x / 64, x % 64);
            let bits = if self.params.unknown_is_occupied {
                !map.free[word]
            } else {
                map.occupied[word]
            };
            bits >> bit & 1 != 0
        };
        let from = x0.saturating_sub(self.reach);
        let until = (x0 + out.len() + self.reach).min(self.size[0]);
        let far = self.reach + 1;
        let mut steps = far;
        for x in from..x0 + out.len() {
            steps = if blocked(x) { 0 } else { (steps + 1).min(far) };
            if x >= x0 {
                out[x - x0] = ((steps * steps) as u16).min(cap);
            }
        }
        steps = far;
        for x in (x0..until).rev() {
            steps = if blocked(x) { 0 } else { (steps + 1).min(far) };
            if x < x0 + out.len() {
                let slot = &mut out[x - x0];
                *slot = (*slot).min((steps * steps) as u16);
            }
        }
    }

    /// Distance of a cell, m; outside the map that of the nearest cell inside.
    pub fn cell_distance(&self, cell: Cell) -> f64 {
        let c = [0, 1, 2].map(|a| (cell[a].max(0) as usize).min(self.size[a] - 1));
        f64::from(self.value[(c[2] * self.size[1] + c[1]) * self.size[0] + c[0]])
    }

    /// Largest value of the field, m.
    pub fn cap(&self) -> f64 {
        f64::from(self.table[self.table.len() - 1])
    }

    /// Trilinear distance at a point, m; outside the map that of the nearest point between cell centres.
    pub fn distance(&self, point: [f64; 3]) -> f64 {
        self.distance_gradient(point).0
    }

    /// Trilinear distance, m, and the gradient of the same interpolant; the gradient is zero along axes on which the point
    /// was clamped into the map. Points that are not finite are far inside an obstacle.
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
        let v = |i: usize, j: usize, k: usize| {
            f64::from(self.value[at + i * step[0] + j * step[1] + k * step[2]])
        };
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

/// `out[x] = min over k of row(k)[x] + (k - here)^2` for rows within reach, nearest first, until no row can win.
fn nearest<'a>(
    out: &mut [u16],
    here: usize,
    rows: usize,
    reach: usize,
    row: impl Fn(usize) -> &'a [u16],
) {
    for shift in 0..=reach {
        let add = (shift * shift) as u16;
        if out.iter().copied().max().is_none_or(|worst| worst <= add) {
            return;
        }
        let mut take = |k: usize| {
            for (slot, &value) in out.iter_mut().zip(row(k)) {
                *slot = (*slot).min(value.saturating_add(add));
            }
        };
        if shift <= here {
            take(here - shift);
        }
        if shift > 0 && here + shift < rows {
            take(here + shift);
        }
    }
}
