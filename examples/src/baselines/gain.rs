//! The unknown volume that a camera would see, by sparse rays in spherical coordinates, with the yaw that shows most of it.
//!
//! Selin, Tiger, Duberg, Heintz and Jensfelt, "Efficient Autonomous Exploration Planning of Large-Scale 3-D Environments" (RA-L
//! 2019): one sweep of rays around a point gives the gain of every yaw. WG-NBVP (Naazare, Garcia Rosas and Schulz, RA-L 2022)
//! integrates the same way. The yaw window is exact to a degree here, where the published code mixes whole degrees with bins of ten.

use std::f64::consts::{PI, TAU};
use std::ops::Range;
use voxmap::{State, VoxelMap};

/// Yaws are compared degree by degree.
const DEGREES: usize = 360;

/// How the rays lie.
#[derive(Clone, Debug, PartialEq)]
pub struct RayParams {
    /// Horizontal and vertical field of view, rad.
    pub field: [f64; 2],
    /// Volume counts from and to so far from the camera, m.
    pub range: (f64, f64),
    /// Radial step, m.
    pub radial_step: f64,
    /// Step of azimuth and elevation, rad; rounded so that whole steps make a turn and the vertical field.
    pub angle_step: f64,
    /// Elevations at which the camera may be held, rad; up is positive. Rounded to whole steps.
    pub pitches: Vec<f64>,
}

/// Where a camera looks from a point, and what it would see.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BestView {
    /// Unknown volume in sight, m3.
    pub volume: f64,
    /// Yaw of the camera, rad, in -pi..pi.
    pub yaw: f64,
    /// Elevation of the camera, rad.
    pub pitch: f64,
}

/// The rays of a sweep, made once.
#[derive(Clone, Debug)]
pub struct Rays {
    /// Direction, azimuth and row of each.
    rays: Vec<([f64; 3], usize, usize)>,
    azimuths: usize,
    rows: usize,
    /// For each elevation of the camera the rows that its image shows.
    pitches: Vec<(f64, Range<usize>)>,
    /// Distances at which rays are looked at, and the volume of a cell there over the cosine of its elevation.
    steps: Vec<(f64, f64)>,
    half_field: f64,
}

impl Rays {
    /// The rays of these parameters.
    pub fn new(params: &RayParams) -> Self {
        let [wide, high] = params.field;
        let azimuths = ((TAU / params.angle_step).round() as usize).clamp(4, DEGREES);
        let image = ((high / params.angle_step).round() as usize).max(1);
        let row_step = high / image as f64;
        // All elevations share one grid of rows, counted downwards from the upper edge of the highest image.
        let shift = |pitch: f64| (pitch / row_step).round() as i64;
        let shifts = || params.pitches.iter().map(|&p| shift(p));
        let (top, bottom) = (shifts().max().unwrap_or(0), shifts().min().unwrap_or(0));
        let rows = image + (top - bottom) as usize;
        let upper = 0.5 * high + top as f64 * row_step;
        let pitches = shifts()
            .map(|s| {
                let first = (top - s) as usize;
                (s as f64 * row_step, first..first + image)
            })
            .collect();
        let mut rays = Vec::with_capacity(azimuths * rows);
        for azimuth in 0..azimuths {
            let (s, c) = ((azimuth as f64 + 0.5) / azimuths as f64 * TAU - PI).sin_cos();
            for row in 0..rows {
                let (up, level) = (upper - (row as f64 + 0.5) * row_step).sin_cos();
                if level > 0.0 {
                    rays.push(([level * c, level * s, up], azimuth, row));
                }
            }
        }
        let (near, far) = params.range;
        let count = ((far - near) / params.radial_step).round().max(1.0);
        let dr = (far - near) / count;
        let solid = TAU / azimuths as f64 * (0.5 * row_step).sin();
        let steps = (0..count as usize)
            .map(|k| {
                let r = near + (k as f64 + 0.5) * dr;
                (r, (2.0 * r * r * dr + dr.powi(3) / 6.0) * solid)
            })
            .collect();
        Self {
            rays,
            azimuths,
            rows,
            pitches,
            steps,
            half_field: 0.5 * wide,
        }
    }

    /// Volume of a whole view of nothing but unknown space, m3.
    pub fn full_view(&self) -> f64 {
        let cells: f64 = self.steps.iter().map(|s| s.1).sum();
        let first = self.pitches.first().map_or(0..0, |p| p.1.clone());
        let column: f64 = self
            .rays
            .iter()
            .filter(|(_, azimuth, row)| *azimuth == 0 && first.contains(row))
            .map(|(d, ..)| d[0].hypot(d[1]))
            .sum();
        column * cells * self.azimuths as f64 * self.half_field / PI
    }

    /// The view of most unknown volume from a point. Rays end at occupied voxels and at the map's border, and where `ends` says so.
    /// `lookups` counts the voxels asked for.
    pub fn best(
        &self,
        map: &VoxelMap,
        from: [f64; 3],
        ends: impl Fn([f64; 3]) -> bool,
        lookups: &mut usize,
    ) -> BestView {
        let mut volume = vec![0.0; self.azimuths * self.rows];
        for (direction, azimuth, row) in &self.rays {
            let level = direction[0].hypot(direction[1]);
            let mut seen = 0.0;
            for (r, cell) in &self.steps {
                let p = [0, 1, 2].map(|a| from[a] + r * direction[a]);
                *lookups += 1;
                let voxel = map.cell_at(p);
                match map.state(voxel) {
                    State::Free => {}
                    State::Occupied => break,
                    State::Unknown if !map.contains(voxel) || ends(p) => break,
                    State::Unknown => seen += cell,
                }
            }
            volume[azimuth * self.rows + row] = seen * level;
        }
        let mut best: Option<BestView> = None;
        for (pitch, rows) in &self.pitches {
            let column = |azimuth: usize| -> f64 {
                volume[azimuth * self.rows..][rows.clone()].iter().sum()
            };
            let columns: Vec<f64> = (0..self.azimuths).map(column).collect();
            let (yaw, volume) = best_window(&columns, self.half_field);
            if best.is_none_or(|b| volume > b.volume) {
                best = Some(BestView {
                    volume,
                    yaw,
                    pitch: *pitch,
                });
            }
        }
        best.unwrap_or_default()
    }
}

/// The yaw (rad) around which a window of `half` either way holds most of what lies in equal columns of azimuth from -pi on, and
/// what it holds. The first of equals.
pub(super) fn best_window(columns: &[f64], half: f64) -> (f64, f64) {
    let n = columns.len();
    let mut sums = Vec::with_capacity(2 * n + 1);
    sums.push(0.0);
    for k in 0..2 * n {
        sums.push(sums[k] + columns[k % n]);
    }
    let width = TAU / n as f64;
    // What lies between the start of the first column and an angle behind it, each column spread evenly.
    let until = |angle: f64| {
        let place = (angle / width).clamp(0.0, (2 * n) as f64);
        let k = (place as usize).min(2 * n - 1);
        sums[k] + (place - k as f64) * columns[k % n]
    };
    let (mut yaw, mut most) = (0.0, f64::NEG_INFINITY);
    for degree in 0..DEGREES {
        let from = degree as f64 / DEGREES as f64 * TAU;
        let held = until(from + 2.0 * half) - until(from);
        // Rounding must not decide between windows that hold the same.
        if held > most + 1e-9 {
            (yaw, most) = (from + half - PI, held);
        }
    }
    ((yaw + PI).rem_euclid(TAU) - PI, most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use voxmap::Config;

    fn params(angle: f64, radial: f64) -> RayParams {
        RayParams {
            field: [87.0_f64.to_radians(), 58.0_f64.to_radians()],
            range: (0.0, 3.0),
            radial_step: radial,
            angle_step: angle.to_radians(),
            pitches: vec![0.0],
        }
    }

    fn map(boxes: &[([f64; 3], [f64; 3])], free: &[([f64; 3], f64)]) -> VoxelMap {
        let mut map = VoxelMap::new(&Config {
            cell_size: 0.15,
            low: [0.0; 3],
            high: [8.1, 8.1, 3.0],
            sensor: voxmap::SensorModel::default(),
        })
        .expect("a small map");
        for (center, radius) in free {
            map.set_free_sphere(*center, *radius);
        }
        for (low, high) in boxes {
            let (a, b) = (map.cell_at(*low), map.cell_at(*high));
            for x in a[0]..b[0] {
                for y in a[1]..b[1] {
                    for z in a[2]..b[2] {
                        map.set_state([x, y, z], State::Occupied);
                    }
                }
            }
        }
        map
    }

    /// Voxel by voxel: the unknown ones whose middle the view shows, with no occupied voxel on a finely sampled line to it.
    fn brute(map: &VoxelMap, from: [f64; 3], yaw: f64, params: &RayParams) -> f64 {
        let size = map.size().map(|n| n as i32);
        let mut seen = 0;
        for x in 0..size[0] {
            for y in 0..size[1] {
                for z in 0..size[2] {
                    let cell = [x, y, z];
                    if map.is_known(cell) {
                        continue;
                    }
                    let c = map.center(cell);
                    let d = [0, 1, 2].map(|a| c[a] - from[a]);
                    let flat = d[0].hypot(d[1]);
                    let r = flat.hypot(d[2]);
                    let side = (d[1].atan2(d[0]) - yaw + PI).rem_euclid(TAU) - PI;
                    if r > params.range.1
                        || side.abs() > 0.5 * params.field[0]
                        || d[2].atan2(flat).abs() > 0.5 * params.field[1]
                    {
                        continue;
                    }
                    let n = (r / 0.01).ceil() as usize;
                    seen += usize::from((0..n).all(|k| {
                        let t = k as f64 / n as f64;
                        !map.is_occupied(map.cell_at([0, 1, 2].map(|a| from[a] + t * d[a])))
                    }));
                }
            }
        }
        seen as f64 * 0.15_f64.powi(3)
    }

    #[test]
    fn a_full_view_is_the_sector_of_a_ball() {
        let (field, far) = (params(10.0, 0.1).field, 3.0_f64);
        let exact = field[0] * 2.0 * (0.5 * field[1]).sin() * far.powi(3) / 3.0;
        for (angle, radial) in [(10.0, 0.1), (2.0, 0.05), (29.0, 1.0)] {
            let view = Rays::new(&params(angle, radial)).full_view();
            assert!((view - exact).abs() < 1e-9 * exact, "{view} {exact}");
        }
    }

    #[test]
    fn the_published_view_has_the_published_volume() {
        let rays = Rays::new(&RayParams {
            field: [85.0_f64.to_radians(), 58.0_f64.to_radians()],
            range: (0.0, 5.0),
            ..params(10.0, 0.1)
        });
        assert!((rays.full_view() - 59.9).abs() < 0.1);
    }

    #[test]
    fn windows_wrap_and_count_parts_of_columns() {
        let mut columns = vec![0.0; 36];
        columns[0] = 1.0;
        columns[35] = 1.0;
        let (yaw, held) = best_window(&columns, 10.0_f64.to_radians());
        assert!((held - 2.0).abs() < 1e-9);
        assert!((yaw.abs() - PI).abs() < 1e-9, "{yaw}");
        let (_, held) = best_window(&columns, 5.0_f64.to_radians());
        assert!((held - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_raised_camera_sees_what_is_above() {
        // All known but a slab below the ceiling; a wall hides nothing of it.
        let mut map = map(&[], &[([4.0, 4.0, 0.0], 9.0)]);
        map.reset_box([2.0, 2.0, 2.6], [6.0, 6.0, 3.0]);
        let rays = Rays::new(&RayParams {
            pitches: vec![-0.5, 0.0, 0.5],
            ..params(10.0, 0.1)
        });
        let best = rays.best(&map, [4.0, 4.0, 1.2], |_| false, &mut 0);
        assert!(best.pitch > 0.4 && best.volume > 0.0, "{best:?}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        /// Ten-degree rays find the volume of the exact count within a tenth of a full view; that is what they are stated for.
        #[test]
        fn sparse_rays_agree_with_every_voxel(
            blocks in prop::collection::vec(((0.5..7.0f64, 0.5..7.0f64, 0.0..2.0f64), (0.3..1.5f64, 0.3..1.5f64, 0.3..1.5f64)), 0..5),
            hole in 0.4..2.0f64,
        ) {
            let from = [4.03, 4.01, 1.21];
            let boxes: Vec<_> = blocks
                .iter()
                .map(|((x, y, z), (a, b, c))| ([*x, *y, *z], [x + a, y + b, z + c]))
                .filter(|(low, high)| (0..3).any(|a| from[a] < low[a] - 0.3 || from[a] > high[a] + 0.3))
                .collect();
            let map = map(&boxes, &[(from, hole)]);
            let params = params(10.0, 0.1);
            let rays = Rays::new(&params);
            let mut lookups = 0;
            let best = rays.best(&map, from, |_| false, &mut lookups);
            let exact = brute(&map, from, best.yaw, &params);
            prop_assert!((best.volume - exact).abs() < 0.1 * rays.full_view(), "{best:?} {exact}");
            prop_assert!(best.volume <= rays.full_view() + 1e-9);
            prop_assert!(lookups <= 36 * 6 * 30);
            // No other yaw shows much more.
            let elsewhere = brute(&map, from, best.yaw + 2.0, &params);
            prop_assert!(elsewhere < exact + 0.15 * rays.full_view(), "{best:?} {exact} {elsewhere}");
        }
    }
}
