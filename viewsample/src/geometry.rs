//! Poses and the volumes sensors cover.

use crate::Error;

/// A camera pose: the optical frame (z forward, x right, y down) in another frame, which the
/// holder names (`world_from_camera`, `base_from_camera`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rows of the rotation matrix; `rotation[i][j]` is row `i`, column `j`.
    pub rotation: [[f64; 3]; 3],
    /// Position of the optical centre, m.
    pub translation: [f64; 3],
}

impl Pose {
    /// A camera without roll at `position` (m) that looks along `yaw` and `pitch` (rad, pitch up
    /// positive).
    pub fn looking(position: [f64; 3], yaw: f64, pitch: f64) -> Self {
        let (sy, cy) = yaw.sin_cos();
        let (sp, cp) = pitch.sin_cos();
        // Columns: right, down, forward.
        Self {
            rotation: [
                [sy, sp * cy, cp * cy],
                [-cy, sp * sy, cp * sy],
                [0.0, -cp, sp],
            ],
            translation: position,
        }
    }

    /// `self` seen from the world when the frame it is given in stands at the planar pose
    /// `base` = x, y, yaw (m, rad) on the floor: `world_from_base * base_from_camera`.
    pub fn on(&self, base: [f64; 3]) -> Self {
        let (s, c) = base[2].sin_cos();
        let turn = |v: [f64; 3]| [c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]];
        let r = &self.rotation;
        let columns = [0, 1, 2].map(|j| turn([r[0][j], r[1][j], r[2][j]]));
        let t = turn(self.translation);
        Self {
            rotation: [0, 1, 2].map(|i| [columns[0][i], columns[1][i], columns[2][i]]),
            translation: [t[0] + base[0], t[1] + base[1], t[2]],
        }
    }

    /// The same camera turned by `roll` (rad) around its optical axis: a quarter turn brings what was at the lower edge
    /// of the image to its right.
    #[must_use]
    pub fn rolled(&self, roll: f64) -> Self {
        let (s, c) = roll.sin_cos();
        Self {
            rotation: self
                .rotation
                .map(|[x, y, z]| [c * x + s * y, c * y - s * x, z]),
            ..*self
        }
    }

    /// The camera turned so that what was straight ahead appears at `at` in the image plane (tangents, right and down), by the smallest
    /// turn that does it.
    #[must_use]
    pub fn showing_ahead_at(&self, at: [f64; 2]) -> Self {
        let [u, v] = at;
        let n = (u * u + v * v + 1.0).sqrt();
        let (x, y, z) = (u / n, v / n, 1.0 / n);
        // The turn that takes the ray (x, y, z) to the axis: around their common normal.
        let k = 1.0 / (1.0 + z);
        let turn = [
            [1.0 - k * x * x, -k * x * y, -x],
            [-k * x * y, 1.0 - k * y * y, -y],
            [x, y, z],
        ];
        let rotation = self
            .rotation
            .map(|row| [0, 1, 2].map(|j| (0..3).map(|i| row[i] * turn[i][j]).sum()));
        Self { rotation, ..*self }
    }

    /// base_from_camera of a camera given in the world, when the base stands at the planar pose `base` = x, y, yaw (m, rad): the
    /// inverse of [`on`](Self::on).
    #[must_use]
    pub fn seen_from(&self, base: [f64; 3]) -> Self {
        let (s, c) = base[2].sin_cos();
        let turn = |v: [f64; 3]| [c * v[0] + s * v[1], c * v[1] - s * v[0], v[2]];
        let r = &self.rotation;
        let columns = [0, 1, 2].map(|j| turn([r[0][j], r[1][j], r[2][j]]));
        let t = self.translation;
        Self {
            rotation: [0, 1, 2].map(|i| [columns[0][i], columns[1][i], columns[2][i]]),
            translation: turn([t[0] - base[0], t[1] - base[1], t[2]]),
        }
    }

    /// A point of the outer frame in the camera frame, m.
    #[inline]
    pub fn to_camera(&self, point: [f64; 3]) -> [f64; 3] {
        let t = self.translation;
        let d = [point[0] - t[0], point[1] - t[1], point[2] - t[2]];
        let r = &self.rotation;
        [0, 1, 2].map(|j| r[0][j] * d[0] + r[1][j] * d[1] + r[2][j] * d[2])
    }

    /// Unit vector of the optical axis in the outer frame.
    pub fn forward(&self) -> [f64; 3] {
        [
            self.rotation[0][2],
            self.rotation[1][2],
            self.rotation[2][2],
        ]
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.rotation
            .iter()
            .flatten()
            .chain(&self.translation)
            .all(|v| v.is_finite())
    }
}

/// What a pinhole camera covers: a pyramid around the optical axis, cut at a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    /// Tangent of half the horizontal field of view.
    pub tan_half_h: f64,
    /// Tangent of half the vertical field of view.
    pub tan_half_v: f64,
    /// Least depth along the optical axis, m.
    pub near: f64,
    /// Largest distance from the optical centre, m.
    pub far: f64,
}

impl Frustum {
    /// From the full opening angles in degrees, as data sheets print them.
    pub fn degrees(horizontal: f64, vertical: f64, near: f64, far: f64) -> Self {
        Self {
            tan_half_h: (horizontal / 2.0).to_radians().tan(),
            tan_half_v: (vertical / 2.0).to_radians().tan(),
            near,
            far,
        }
    }

    /// True if a point of the camera frame (m) is inside.
    #[inline]
    pub fn covers(&self, p: [f64; 3]) -> bool {
        p[2] >= self.near
            && p[0].abs() <= self.tan_half_h * p[2]
            && p[1].abs() <= self.tan_half_v * p[2]
            && p[0] * p[0] + p[1] * p[1] + p[2] * p[2] <= self.far * self.far
    }

    /// Box around the frustum and its apex for the camera at `pose`: low and high corner, m.
    pub fn bounds(&self, pose: &Pose) -> ([f64; 3], [f64; 3]) {
        let (mut low, mut high) = (pose.translation, pose.translation);
        for (sx, sy) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let corner = [
                sx * self.tan_half_h * self.far,
                sy * self.tan_half_v * self.far,
                self.far,
            ];
            for a in 0..3 {
                let r = &pose.rotation[a];
                let offset = r[0] * corner[0] + r[1] * corner[1] + r[2] * corner[2];
                // The pyramid is cut by the ball of radius `far`.
                let v = pose.translation[a] + offset.clamp(-self.far, self.far);
                low[a] = low[a].min(v);
                high[a] = high[a].max(v);
            }
        }
        (low, high)
    }

    /// Rectangle in the plane around the part of the frustum between two heights, m; none if that
    /// part is empty.
    pub(crate) fn footprint(
        &self,
        pose: &Pose,
        floor: f64,
        ceiling: f64,
    ) -> Option<([f64; 2], [f64; 2])> {
        let corner = |sx: f64, sy: f64| {
            let c = [
                sx * self.tan_half_h * self.far,
                sy * self.tan_half_v * self.far,
                self.far,
            ];
            [0, 1, 2].map(|a| {
                let r = &pose.rotation[a];
                pose.translation[a] + r[0] * c[0] + r[1] * c[1] + r[2] * c[2]
            })
        };
        let base = [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut add = |p: [f64; 3]| {
            for a in 0..2 {
                let v =
                    pose.translation[a] + (p[a] - pose.translation[a]).clamp(-self.far, self.far);
                low[a] = low[a].min(v);
                high[a] = high[a].max(v);
            }
        };
        // Corners of a convex body cut by two planes: its own between them, and its edges on them.
        for n in 0..4 {
            for (p, q) in [(pose.translation, base[n]), (base[n], base[(n + 1) % 4])] {
                for end in [p, q] {
                    if (floor..=ceiling).contains(&end[2]) {
                        add(end);
                    }
                }
                for plane in [floor, ceiling] {
                    let t = (plane - p[2]) / (q[2] - p[2]);
                    if (0.0..=1.0).contains(&t) {
                        add([0, 1, 2].map(|a| p[a] + t * (q[a] - p[a])));
                    }
                }
            }
        }
        (low[0] <= high[0]).then_some((low, high))
    }

    pub(crate) fn validate(&self, field: &'static str) -> Result<(), Error> {
        for value in [self.tan_half_h, self.tan_half_v, self.far] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Error::Param {
                    field,
                    value,
                    range: "positive and finite",
                });
            }
        }
        if !(self.near >= 0.0 && self.near < self.far) {
            return Err(Error::Param {
                field,
                value: self.near,
                range: "a near distance in [0, far)",
            });
        }
        Ok(())
    }
}

/// A frustum, prepared to tell which cells of a column it covers.
///
/// Along a column each border of the frustum is passed once, so that the covered cells are a run. Cells near an end of it are held
/// against the frustum itself: the answer is that of [`Frustum::covers`] for every cell.
#[derive(Clone, Debug)]
pub(crate) struct Risers<'a> {
    frustum: &'a Frustum,
    /// From one cell to the next in the camera frame, m.
    up: [f64; 3],
    /// How much farther inside each border the next cell is, and the cells that go on a metre of it; none along a border.
    slopes: [(f64, Option<f64>); 5],
    /// How much farther inside each border than cell 0 any cell is.
    most: [f64; 5],
}

/// Cells within which the end of a run is taken to be uncertain.
const BLUR: f64 = 1e-6;

impl<'a> Risers<'a> {
    pub(crate) fn new(frustum: &'a Frustum, up: [f64; 3]) -> Self {
        let slopes = Self::inside(frustum, up, 0.0).map(|slope| {
            let level = slope.abs() < 1e-6;
            (slope, (!level).then(|| 1.0 / slope))
        });
        Self {
            frustum,
            up,
            slopes,
            most: slopes.map(|(slope, _)| (63.0 * slope).max(0.0) + BLUR),
        }
    }

    /// How far inside each border a point is, m times what the border's normal lacks to one.
    #[inline]
    fn inside(frustum: &Frustum, p: [f64; 3], near: f64) -> [f64; 5] {
        let (h, v) = (frustum.tan_half_h * p[2], frustum.tan_half_v * p[2]);
        [p[2] - near, h - p[0], h + p[0], v - p[1], v + p[1]]
    }

    /// Those of the cells `mask` of a column that are covered; `p` is the centre of cell 0 in the camera frame, m.
    #[inline]
    pub(crate) fn covers(&self, p: [f64; 3], mask: u64) -> u64 {
        if mask == 0 {
            return 0;
        }
        let inside = Self::inside(self.frustum, p, self.frustum.near);
        if (0..5).any(|k| inside[k] + self.most[k] < 0.0) {
            return 0;
        }
        let (mut low, mut high) = (0.0_f64, 63.0_f64);
        let mut sure = true;
        for (a, (slope, cells)) in inside.into_iter().zip(self.slopes) {
            match cells {
                Some(cells) if slope > 0.0 => low = low.max(-a * cells),
                Some(cells) => high = high.min(-a * cells),
                None if a < -1e-3 => return 0,
                None => sure &= a > 1e-3,
            }
        }
        // The ball: no nearer than the column is to the eye.
        let (up, far) = (self.up, self.frustum.far);
        let square = up[0] * up[0] + up[1] * up[1] + up[2] * up[2];
        let middle = -(p[0] * up[0] + p[1] * up[1] + p[2] * up[2]) / square;
        let nearest = [0, 1, 2].map(|k| p[k] + middle * up[k]);
        let aside = nearest.iter().map(|v| v * v).sum::<f64>();
        let left = (far * far - aside) / square;
        if left < -BLUR {
            return 0;
        }
        let half = left.max(0.0).sqrt();
        // Near the rim of the ball its border runs along the column.
        sure &= half > 1e-2;
        let rim = if sure { BLUR } else { 1.0 };
        low = low.max(middle - half - rim);
        high = high.min(middle + half + rim);
        let outer = run(low - BLUR, high + BLUR) & mask;
        let inner = if sure {
            run(low + 2.0 * BLUR, high - 2.0 * BLUR)
        } else {
            0
        };
        let mut kept = outer & inner;
        let mut rest = outer & !inner;
        while rest != 0 {
            let bit = rest.trailing_zeros();
            rest &= rest - 1;
            let at = [0, 1, 2].map(|k| p[k] + f64::from(bit) * up[k]);
            kept |= u64::from(self.frustum.covers(at)) << bit;
        }
        kept
    }
}

/// Bits of the whole numbers from `low` to `high`, of those from 0 to 63.
#[inline]
fn run(low: f64, high: f64) -> u64 {
    let (low, high) = (low.clamp(0.0, 64.0), high.clamp(-1.0, 63.0));
    let first = low as u32 + u32::from(f64::from(low as u32) < low);
    if high < 0.0 || first > 63 || first > high as u32 {
        return 0;
    }
    (u64::MAX >> (63 - high as u32)) & (u64::MAX << first)
}

/// Which faces of a voxel an image shows whole, with a square around them.
///
/// For each face and each border of the image, how far inside the border the voxel's centre must be, at its own depth.
#[derive(Clone, Debug)]
pub(crate) struct Held {
    insets: [[f64; 4]; 6],
    tangents: [f64; 2],
}

impl Held {
    /// For a camera at `pose`, voxels of `cell_size` m, and squares of half a side `half` m around the faces' middles.
    pub(crate) fn new(frustum: &Frustum, pose: &Pose, cell_size: f64, half: f64) -> Self {
        let tangents = [frustum.tan_half_h, frustum.tan_half_v];
        // What a metre along a world axis moves a point beyond a border: left and right, up and down.
        let beyond = |axis: usize, border: usize| {
            let sign = if border.is_multiple_of(2) { 1.0 } else { -1.0 };
            let k = border / 2;
            sign * pose.rotation[axis][k] - tangents[k] * pose.rotation[axis][2]
        };
        let insets = std::array::from_fn(|face| {
            let (axis, out) = (face / 2, if face % 2 == 0 { -1.0 } else { 1.0 });
            std::array::from_fn(|border| {
                half * (beyond((axis + 1) % 3, border).abs() + beyond((axis + 2) % 3, border).abs())
                    + 0.5 * cell_size * out * beyond(axis, border)
            })
        });
        Self { insets, tangents }
    }

    /// Those of the faces of a voxel whose centre is at a point of the camera frame, m.
    #[inline]
    pub(crate) fn of(&self, p: [f64; 3], faces: u8) -> u8 {
        let room = [
            self.tangents[0] * p[2] - p[0],
            self.tangents[0] * p[2] + p[0],
            self.tangents[1] * p[2] - p[1],
            self.tangents[1] * p[2] + p[1],
        ];
        let mut held = 0;
        for (face, insets) in self.insets.iter().enumerate() {
            if faces >> face & 1 != 0 && (0..4).all(|b| room[b] >= insets[b]) {
                held |= 1 << face;
            }
        }
        held
    }
}

/// What a spinning LiDAR with a vertical axis covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lidar {
    /// Position in the base frame, m.
    pub offset: [f64; 3],
    /// Lowest elevation, rad (down is negative).
    pub low: f64,
    /// Highest elevation, rad.
    pub high: f64,
    /// Largest distance, m.
    pub range: f64,
}

impl Lidar {
    /// Position in the world when the base stands at `base` = x, y, yaw.
    pub fn eye(&self, base: [f64; 3]) -> [f64; 3] {
        let (s, c) = base[2].sin_cos();
        let o = self.offset;
        [
            base[0] + c * o[0] - s * o[1],
            base[1] + s * o[0] + c * o[1],
            o[2],
        ]
    }

    /// True if a point at `d` from the sensor (m, world axes) is in range and elevation band.
    #[inline]
    pub fn covers(&self, d: [f64; 3]) -> bool {
        self.shape().covers(d)
    }

    pub(crate) fn shape(&self) -> LidarShape {
        LidarShape {
            low: self.low.tan(),
            high: self.high.tan(),
            range2: self.range * self.range,
        }
    }

    pub(crate) fn validate(&self) -> Result<(), Error> {
        if !(self.range > 0.0 && self.range.is_finite()) {
            return Err(Error::Param {
                field: "lidar.range",
                value: self.range,
                range: "positive and finite",
            });
        }
        let right = std::f64::consts::FRAC_PI_2;
        if !(self.low > -right && self.low < self.high) {
            return Err(Error::Param {
                field: "lidar.low",
                value: self.low,
                range: "in (-pi/2, high)",
            });
        }
        if self.high.is_nan() || self.high >= right {
            return Err(Error::Param {
                field: "lidar.high",
                value: self.high,
                range: "below pi/2",
            });
        }
        match self.offset.iter().find(|v| !v.is_finite()) {
            Some(&value) => Err(Error::Param {
                field: "lidar.offset",
                value,
                range: "finite",
            }),
            None => Ok(()),
        }
    }
}

/// [`Lidar`] with its tangents and square worked out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LidarShape {
    low: f64,
    high: f64,
    range2: f64,
}

impl LidarShape {
    #[inline]
    pub(crate) fn covers(&self, d: [f64; 3]) -> bool {
        let r2 = d[0] * d[0] + d[1] * d[1];
        let r = r2.sqrt();
        d[2] >= r * self.low && d[2] <= r * self.high && r2 + d[2] * d[2] <= self.range2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 4000, ..ProptestConfig::default() })]

        /// A run of covered cells is what a look at each cell tells, also for level and upright cameras, whose borders run along
        /// the column, and for columns on a border or at the rim of the range.
        #[test]
        fn a_run_of_cells_is_each_of_them(
            yaw in prop_oneof![Just(0.0), Just(std::f64::consts::FRAC_PI_2), -3.2..3.2_f64],
            pitch in prop_oneof![Just(0.0), Just(std::f64::consts::FRAC_PI_2), -1.6..1.6_f64],
            roll in prop_oneof![Just(0.0), -3.2..3.2_f64],
            column in prop_oneof![
                (-5.0..5.0_f64, -5.0..5.0_f64),
                (-30..30_i32, -30..30_i32).prop_map(|(x, y)| (0.15 * f64::from(x), 0.15 * f64::from(y))),
            ],
            height in prop_oneof![Just(0.075), 0.0..3.0_f64],
            cell in prop_oneof![Just(0.15), 0.02..0.3_f64],
            near in prop_oneof![Just(0.0), 0.0..1.0_f64],
            mask in prop_oneof![Just(u64::MAX), any::<u64>()],
        ) {
            let camera = Pose::looking([0.0, 0.0, height], yaw, pitch).rolled(roll);
            let frustum = Frustum { near, ..Frustum::degrees(69.0, 42.0, 0.0, 4.0) };
            let up = camera.rotation[2].map(|v| v * cell);
            let p = camera.to_camera([column.0, column.1, 0.5 * cell]);
            let each = (0..64).filter(|&n| {
                mask >> n & 1 != 0
                    && frustum.covers([0, 1, 2].map(|a| p[a] + f64::from(n) * up[a]))
            });
            prop_assert_eq!(
                Risers::new(&frustum, up).covers(p, mask),
                each.fold(0, |bits, n: u32| bits | 1 << n)
            );
        }
    }
}
