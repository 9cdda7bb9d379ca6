//! The LiDAR on the base: a regular grid of azimuths and elevations about a vertical axis.
//!
//! All rays of one azimuth lie in one vertical half plane, and the base stays upright. An upright box or cylinder
//! cuts that half plane in a rectangle `[near, far] x [low, high]` of horizontal distance and height, the same for
//! all elevations. A scan thus costs one horizontal intersection per solid and azimuth, and a few operations per
//! solid and ray, in lanes the compiler vectorises. Other solids are cast ray by ray where their outline lies.

use super::PointScan;
use super::noise::{Disturbance, Noise};
use super::world::World;
use crate::scene::{Form, Solid};
use rayon::prelude::*;

/// Azimuths handed to one worker at a time.
const COLUMNS: usize = 50;
/// Rows are padded to a multiple of this.
const LANES: usize = 8;

/// Geometry of the LiDAR. Default: G items 3 and 4 of the HEATS defaults (Livox Mid-360).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LidarModel {
    /// Position in the base frame, m.
    pub offset: [f64; 3],
    /// Lowest ray, rad.
    pub low: f64,
    /// No ray is above this, rad.
    pub high: f64,
    /// Angle between neighbouring rays, both ways, rad; rounded so that a turn holds a whole number.
    pub step: f64,
    /// Returns nearer than this are dropped, m.
    pub min_range: f64,
    /// Longest range, m.
    pub max_range: f64,
    /// Scans a second.
    pub rate: f64,
}

impl Default for LidarModel {
    fn default() -> Self {
        Self {
            offset: [0.25, 0.0, 0.45],
            low: (-7.0_f64).to_radians(),
            high: 52.0_f64.to_radians(),
            step: 0.8_f64.to_radians(),
            min_range: 0.1,
            max_range: 10.0,
            rate: 10.0,
        }
    }
}

/// A rectangle of the vertical half plane of one azimuth.
#[derive(Clone, Copy, Debug)]
struct Slice {
    near: f32,
    far: f32,
    low: f32,
    high: f32,
}

/// The sensor with its tables and buffers.
#[derive(Clone, Debug)]
pub struct Lidar {
    model: LidarModel,
    columns: usize,
    rows: usize,
    stride: usize,
    /// Tangent of each elevation, its reciprocal, and 1/cos; padded.
    slope: Vec<f32>,
    inverse: Vec<f32>,
    secant: Vec<f32>,
    /// Horizontal distance of each return, columns of `stride`.
    reach: Vec<f32>,
    slices: Vec<Vec<Slice>>,
    /// Solids that are not upright, with their columns.
    others: Vec<Vec<u32>>,
    disturbance: Disturbance,
    /// Measured ranges, rings of one elevation, where there are outliers.
    measured: Vec<f32>,
    scan: PointScan,
}

impl Lidar {
    /// A LiDAR of the given geometry; steps and ranges that make no sense are brought into range.
    pub fn new(model: LidarModel, noise: Noise) -> Self {
        let step = model.step.clamp(1e-3, 1.0);
        let columns = (std::f64::consts::TAU / step).round().max(1.0) as usize;
        let rows = ((model.high - model.low) / step + 1e-9).floor().max(0.0) as usize + 1;
        let stride = rows.next_multiple_of(LANES);
        let elevation = |i: usize| (model.low + i.min(rows - 1) as f64 * step).clamp(-1.55, 1.55);
        let table = |f: &dyn Fn(f64) -> f64| (0..stride).map(|i| f(elevation(i)) as f32).collect();
        Self {
            columns,
            rows,
            stride,
            slope: table(&|e| e.tan()),
            // A level ray leaves a slab only at infinity.
            inverse: table(&|e| if e.abs() < 1e-12 { 1e30 } else { 1.0 / e.tan() }),
            secant: table(&|e| 1.0 / e.cos()),
            reach: vec![0.0; columns * stride],
            slices: vec![Vec::new(); columns],
            others: vec![Vec::new(); columns],
            disturbance: Disturbance::new(noise, 1),
            measured: Vec::new(),
            scan: PointScan {
                max_range: model.max_range,
                ..PointScan::default()
            },
            model,
        }
    }

    /// The geometry it was made with.
    pub fn model(&self) -> &LidarModel {
        &self.model
    }

    /// Numbers of azimuths and elevations.
    pub fn size(&self) -> (usize, usize) {
        (self.columns, self.rows)
    }

    /// Origin of the rays for a base pose x, y, yaw over the given floor, m.
    pub fn origin(&self, base: [f64; 3], floor: f64) -> [f64; 3] {
        let ((s, c), o) = (base[2].sin_cos(), self.model.offset);
        [
            base[0] + c * o[0] - s * o[1],
            base[1] + s * o[0] + c * o[1],
            floor + o[2],
        ]
    }

    /// Elevations, rad, lowest first.
    pub fn elevation(&self, row: usize) -> f64 {
        f64::from(self.slope[row.min(self.rows - 1)]).atan()
    }

    /// Azimuth of a column for a base yaw, rad.
    pub fn azimuth(&self, column: usize, yaw: f64) -> f64 {
        yaw + column as f64 * std::f64::consts::TAU / self.columns as f64
    }

    /// Scans the world from a base pose x, y, yaw.
    pub fn scan(&mut self, world: &World, base: [f64; 3]) -> &PointScan {
        self.cast(world, base);
        self.collect(base);
        &self.scan
    }

    /// Horizontal distance of the last scan's return, m; at or beyond `max_range * cos(elevation)` for a miss.
    pub fn reach(&self, column: usize, row: usize) -> f32 {
        self.reach[column * self.stride + row]
    }

    fn cast(&mut self, world: &World, base: [f64; 3]) {
        let origin = self.origin(base, world.floor);
        self.scan.origin = origin;
        self.slices.iter_mut().for_each(Vec::clear);
        self.others.iter_mut().for_each(Vec::clear);
        for (i, solid) in world.solids.iter().enumerate() {
            self.add(i, solid, origin, base[2]);
        }
        let floor = (world.floor - origin[2]) as f32;
        let ceiling = (world.ceiling - origin[2]) as f32;
        let azimuths: Vec<(f64, f64)> = (0..self.columns)
            .map(|i| self.azimuth(i, base[2]).sin_cos())
            .collect();
        let max = self.model.max_range as f32;
        let (slope, inverse, secant) = (&self.slope, &self.inverse, &self.secant);
        let (stride, rows, others) = (self.stride, self.rows, &self.others);
        let work = self
            .reach
            .par_chunks_mut(COLUMNS * stride)
            .zip(self.slices.par_chunks_mut(COLUMNS));
        work.enumerate().for_each(|(chunk, (reach, slices))| {
            for (i, (reach, slices)) in reach.chunks_mut(stride).zip(slices).enumerate() {
                for k in 0..stride {
                    // The floor for falling rays, the ceiling for rising ones.
                    let plane = if slope[k] < 0.0 { floor } else { ceiling } * inverse[k];
                    reach[k] = (max / secant[k]).min(plane.max(0.0));
                }
                for slice in slices.iter() {
                    cut(slice, inverse, reach);
                }
                let column = chunk * COLUMNS + i;
                let (sin, cos) = azimuths[column];
                for &solid in &others[column] {
                    for k in 0..rows {
                        let direction = [cos, sin, f64::from(slope[k])];
                        let limit = f64::from(reach[k]);
                        if let Some(t) = world.solids[solid as usize].cast(origin, direction, limit)
                        {
                            reach[k] = t as f32;
                        }
                    }
                }
            }
        });
    }

    /// Enters a solid into the columns its outline covers.
    fn add(&mut self, index: usize, solid: &Solid, origin: [f64; 3], yaw: f64) {
        let max = self.model.max_range;
        let d = [0, 1].map(|k| {
            (solid.low[k] - origin[k])
                .max(origin[k] - solid.high[k])
                .max(0.0)
        });
        if d[0] * d[0] + d[1] * d[1] > max * max {
            return;
        }
        let Some((first, count)) = self.covered(solid, origin, yaw) else {
            return;
        };
        let (low, high) = (
            (solid.low[2] - origin[2]) as f32,
            (solid.high[2] - origin[2]) as f32,
        );
        let local = solid.to_local(origin);
        let step = std::f64::consts::TAU / self.columns as f64;
        // Local direction of the first column, turned by one step per column.
        let start = self.azimuth(first, yaw) - solid.axes[0][1].atan2(solid.axes[0][0]);
        for n in 0..count {
            let column = (first + n) % self.columns;
            if !solid.upright {
                self.others[column].push(index as u32);
                continue;
            }
            let (sin, cos) = (start + n as f64 * step).sin_cos();
            let (near, far) = match solid.form {
                Form::Box(half) => {
                    let mut span = (0.0_f64, f64::INFINITY);
                    for (o, d, h) in [(local[0], cos, half[0]), (local[1], sin, half[1])] {
                        let (a, b) = ((-h - o) / d, (h - o) / d);
                        span = (span.0.max(a.min(b)), span.1.min(a.max(b)));
                    }
                    span
                }
                Form::Cylinder(radius, _) => {
                    let along = -(local[0] * cos + local[1] * sin);
                    let aside = local[0] * sin - local[1] * cos;
                    // NaN when the ray passes outside; the comparison below then drops it.
                    let half = (radius * radius - aside * aside).sqrt();
                    (
                        (along - half).max(0.0),
                        along + half + if half.is_nan() { f64::NAN } else { 0.0 },
                    )
                }
                Form::Mesh(_) => continue,
            };
            if near <= far && near <= max {
                self.slices[column].push(Slice {
                    near: near as f32,
                    far: far as f32,
                    low,
                    high,
                });
            }
        }
    }

    /// First column and number of columns whose half plane may meet the solid.
    fn covered(&self, solid: &Solid, origin: [f64; 3], yaw: f64) -> Option<(usize, usize)> {
        let corners: [[f64; 2]; 4] = if let (true, Form::Box(h)) = (solid.upright, &solid.form) {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(a, b)| {
                [0, 1].map(|k| {
                    solid.center[k] + a * h[0] * solid.axes[0][k] + b * h[1] * solid.axes[1][k]
                        - origin[k]
                })
            })
        } else {
            let (l, h) = (solid.low, solid.high);
            [(l[0], l[1]), (h[0], l[1]), (h[0], h[1]), (l[0], h[1])]
                .map(|(x, y)| [x - origin[0], y - origin[1]])
        };
        // Inside the outline, or so near that angles mean little: all columns.
        let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        if (0..4).all(|i| cross(corners[i], corners[(i + 1) % 4]) >= -1e-9) {
            return Some((0, self.columns));
        }
        let middle = [0, 1].map(|k| corners.iter().map(|c| c[k]).sum::<f64>());
        let (mut least, mut most) = (0.0_f64, 0.0_f64);
        for corner in corners {
            let angle = cross(middle, corner).atan2(middle[0] * corner[0] + middle[1] * corner[1]);
            least = least.min(angle);
            most = most.max(angle);
        }
        let step = std::f64::consts::TAU / self.columns as f64;
        let center = middle[1].atan2(middle[0]) - yaw;
        let first = ((center + least) / step).floor();
        let last = ((center + most) / step).ceil();
        let count = ((last - first) as usize + 1).min(self.columns);
        Some((
            first.rem_euclid(self.columns as f64) as usize % self.columns,
            count,
        ))
    }

    fn collect(&mut self, base: [f64; 3]) {
        let (min, max) = (self.model.min_range as f32, self.model.max_range as f32);
        let origin = self.scan.origin;
        self.scan.hits.clear();
        self.scan.misses.clear();
        let perfect = self.disturbance.is_off();
        let wild = self.disturbance.has_outliers();
        if wild {
            self.measured.clear();
            for row in 0..self.rows {
                self.measured.extend(
                    (0..self.columns).map(|c| self.reach[c * self.stride + row] * self.secant[row]),
                );
            }
            self.disturbance
                .falsify(&mut self.measured, (min, max), self.columns, true);
        }
        for column in 0..self.columns {
            let (sin, cos) = self.azimuth(column, base[2]).sin_cos();
            let reach = &self.reach[column * self.stride..][..self.rows];
            for row in 0..self.rows {
                let mut range = reach[row] * self.secant[row];
                let mut along = f64::from(reach[row]);
                if wild {
                    let measured = self.measured[row * self.columns + column];
                    if measured.is_nan() {
                        continue;
                    }
                    range = measured;
                    along = f64::from(measured / self.secant[row]);
                } else if !perfect {
                    let Some(factor) = self.disturbance.factor() else {
                        continue;
                    };
                    if range < max * (1.0 - 1e-6) {
                        range *= factor as f32;
                        along *= factor;
                    }
                }
                if range < min {
                    continue;
                }
                let missed = range >= max * (1.0 - 1e-6);
                if missed {
                    along = f64::from(max / self.secant[row]);
                }
                let point = [
                    (origin[0] + along * cos) as f32,
                    (origin[1] + along * sin) as f32,
                    (origin[2] + along * f64::from(self.slope[row])) as f32,
                ];
                if missed {
                    self.scan.misses.push(point)
                } else {
                    self.scan.hits.push(point)
                }
            }
        }
    }
}

/// Shortens every ray of a column that enters the slice.
#[inline]
fn cut(slice: &Slice, inverse: &[f32], reach: &mut [f32]) {
    let Slice {
        near,
        far,
        low,
        high,
    } = *slice;
    for (reach, &inverse) in reach.iter_mut().zip(inverse) {
        let (a, b) = (low * inverse, high * inverse);
        let (enter, leave) = if a < b { (a, b) } else { (b, a) };
        let enter = if enter > near { enter } else { near };
        let leave = if leave < far { leave } else { far };
        let hit = enter <= leave && enter < *reach;
        *reach = if hit { enter } else { *reach };
    }
}
