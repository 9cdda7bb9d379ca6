//! A UR5e on a mobile base: its own kinematics and exact ball-against-box checks.

use serde_json::Value;
use strrt::{Robot, motion_is_clear};

/// Joints.
pub(crate) type Joints = [f64; 6];

/// Bounds on the distance between a joint's axis and the centre of any ball beyond it, m, from the link lengths of the UR5e.
const LEVER: Joints = [1.07, 1.03, 0.61, 0.21, 0.14, 0.05];
/// The same for the base's turning axis.
const BASE_LEVER: f64 = 1.22;
/// How far from the mount a ball can reach, m, with its radius.
const REACH: f64 = 1.45;
/// Motions are looked at down to this travel, m.
const RESOLUTION: f64 = 1e-3;
/// Upper bound where nothing is near, m.
const FAR: f64 = 10.0;

/// One ball of the cover.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    pub(crate) frame: usize,
    pub(crate) center: [f64; 3],
    pub(crate) radius: f64,
}

/// What `mm-robot.json` says.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub(crate) dh: [(f64, f64, f64); 6],
    pub(crate) limits: [(f64, f64); 6],
    pub(crate) speed: Joints,
    pub(crate) mount: [f64; 3],
    pub(crate) base_box: ([f64; 3], [f64; 3]),
    pub(crate) balls: Vec<Ball>,
    /// Balls that must not touch.
    pub(crate) pairs: Vec<(usize, usize)>,
    /// First ball that is tested against the base box.
    pub(crate) first_over_base: usize,
}

impl Model {
    /// From the file's content; `None` if something is missing.
    pub(crate) fn read(file: &Value) -> Option<Self> {
        let three = |v: &Value| Some([v[0].as_f64()?, v[1].as_f64()?, v[2].as_f64()?]);
        let mut dh = [(0.0, 0.0, 0.0); 6];
        let (mut limits, mut speed) = ([(0.0, 0.0); 6], [0.0; 6]);
        for j in 0..6 {
            let row = &file["dh"][j];
            let turn = row["alpha_over_pi"].as_f64()? * std::f64::consts::PI;
            dh[j] = (row["d"].as_f64()?, row["a"].as_f64()?, turn);
            limits[j] = (file["q_min"][j].as_f64()?, file["q_max"][j].as_f64()?);
            speed[j] = file["qd_max"][j].as_f64()?;
        }
        let rows = file["spheres"].as_array()?;
        let (mut balls, mut links) = (Vec::new(), Vec::new());
        for row in rows {
            balls.push(Ball {
                frame: row[0].as_u64()? as usize,
                center: [row[1].as_f64()?, row[2].as_f64()?, row[3].as_f64()?],
                radius: row[4].as_f64()?,
            });
            links.push(row[5].as_u64()?);
        }
        let mut pairs = Vec::new();
        for i in 0..links.len() {
            for j in 0..links.len() {
                let (a, b) = (links[i], links[j]);
                if a < 4 && b >= a + 2 && (a, b) != (3, 5) {
                    pairs.push((i, j));
                }
            }
        }
        Some(Self {
            dh,
            limits,
            speed,
            mount: three(&file["arm_mount_xyz"])?,
            base_box: (three(&file["base_box_min"])?, three(&file["base_box_max"])?),
            balls,
            pairs,
            first_over_base: 3,
        })
    }
}

/// Frame: columns of the rotation, and the origin.
type Frame = [[f64; 3]; 4];

/// The arm over its base's path among boxes.
pub(crate) struct Scene<'a> {
    pub(crate) model: &'a Model,
    /// x, y, yaw at each step.
    pub(crate) base: &'a [[f64; 3]],
    /// Low and high corners of the boxes that are near at each step.
    near: Vec<Vec<([f64; 3], [f64; 3])>>,
    folded: [(f64, f64); 6],
}

impl<'a> Scene<'a> {
    /// Boxes are centre and half size.
    pub(crate) fn new(model: &'a Model, base: &'a [[f64; 3]], boxes: &[[f64; 6]]) -> Self {
        let near = base
            .iter()
            .map(|pose| {
                let (s, c) = pose[2].sin_cos();
                let shoulder = [
                    pose[0] + c * model.mount[0] - s * model.mount[1],
                    pose[1] + s * model.mount[0] + c * model.mount[1],
                    model.mount[2] + model.dh[0].0,
                ];
                boxes
                    .iter()
                    .map(|b| {
                        (
                            [b[0] - b[3], b[1] - b[4], b[2] - b[5]],
                            [b[0] + b[3], b[1] + b[4], b[2] + b[5]],
                        )
                    })
                    .filter(|b| to_box(&shoulder, b) < REACH)
                    .collect()
            })
            .collect();
        Self {
            model,
            base,
            near,
            folded: model.dh.map(|row| row.2.sin_cos()),
        }
    }

    fn pose(&self, a: usize, b: usize, t: f64) -> [f64; 3] {
        let (a, b) = (self.base[a], self.base[b]);
        std::array::from_fn(|i| a[i] + t * (b[i] - a[i]))
    }

    /// Ball centres in the base frame.
    fn balls(&self, q: &Joints, centers: &mut [[f64; 3]]) {
        let m = self.model;
        let mut frame: Frame = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], m.mount];
        let mut ball = 0;
        for j in 0..6 {
            let (sin, cos) = q[j].sin_cos();
            let ((d, a, _), (sa, ca)) = (m.dh[j], self.folded[j]);
            let [x, y, z, o] = frame;
            let mut new = frame;
            for i in 0..3 {
                // RotZ(q) TransZ(d) TransX(a) RotX(alpha)
                let (u, v) = (cos * x[i] + sin * y[i], cos * y[i] - sin * x[i]);
                new[0][i] = u;
                new[1][i] = ca * v + sa * z[i];
                new[2][i] = ca * z[i] - sa * v;
                new[3][i] = o[i] + d * z[i] + a * u;
            }
            frame = new;
            while ball < m.balls.len() && m.balls[ball].frame == j + 1 {
                let c = m.balls[ball].center;
                for i in 0..3 {
                    centers[ball][i] =
                        frame[3][i] + c[0] * frame[0][i] + c[1] * frame[1][i] + c[2] * frame[2][i];
                }
                ball += 1;
            }
        }
    }

    /// Least distance to anything that must not be touched, m; not below `enough`, if that helps. Negative: touching.
    pub(crate) fn clearance(&self, q: &Joints, pose: [f64; 3], step: usize, stop: f64) -> f64 {
        let m = self.model;
        let mut centers = [[0.0; 3]; 32];
        let centers = &mut centers[..m.balls.len()];
        self.balls(q, centers);
        let mut least = FAR;
        for (i, c) in centers.iter().enumerate() {
            least = least.min(c[2] - m.balls[i].radius);
            if i >= m.first_over_base {
                least = least.min(to_box(c, &m.base_box) - m.balls[i].radius);
            }
        }
        if least < stop {
            return least;
        }
        for &(i, j) in &m.pairs {
            let (a, b) = (&centers[i], &centers[j]);
            let square: f64 = (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum();
            let wide = m.balls[i].radius + m.balls[j].radius;
            let bound = least + wide;
            if square < bound * bound || bound < 0.0 {
                least = least.min(square.sqrt() - wide);
            }
        }
        if least < stop {
            return least;
        }
        let (s, c) = pose[2].sin_cos();
        for (i, p) in centers.iter().enumerate().rev() {
            let world = [
                pose[0] + c * p[0] - s * p[1],
                pose[1] + s * p[0] + c * p[1],
                p[2],
            ];
            let r = m.balls[i].radius;
            for b in &self.near[step] {
                let square = to_box_squared(&world, b);
                let bound = least + r;
                if square < bound * bound {
                    least = square.sqrt() - r;
                    if least < stop {
                        return least;
                    }
                }
            }
        }
        least
    }
}

/// Distance of a point from a box, m.
pub(crate) fn to_box(p: &[f64; 3], b: &([f64; 3], [f64; 3])) -> f64 {
    to_box_squared(p, b).sqrt()
}

fn to_box_squared(p: &[f64; 3], (low, high): &([f64; 3], [f64; 3])) -> f64 {
    (0..3)
        .map(|i| {
            let d = (low[i] - p[i]).max(p[i] - high[i]).max(0.0);
            d * d
        })
        .sum()
}

impl Robot<6> for Scene<'_> {
    fn limits(&self) -> [(f64, f64); 6] {
        self.model.limits
    }
    fn max_speed(&self) -> Joints {
        self.model.speed
    }
    fn is_valid(&self, q: &Joints, step: usize) -> bool {
        self.clearance(q, self.base[step], step, 0.0) >= 0.0
    }
    fn is_motion_valid(&self, a: &Joints, b: &Joints, from: usize, to: usize) -> bool {
        let (start, end) = (self.base[from], self.base[to]);
        let arm: f64 = (0..6).map(|j| LEVER[j] * (b[j] - a[j]).abs()).sum();
        let travel = (end[0] - start[0]).hypot(end[1] - start[1])
            + BASE_LEVER * (end[2] - start[2]).abs()
            + arm;
        motion_is_clear(
            |t| {
                let q = std::array::from_fn(|j| a[j] + t * (b[j] - a[j]));
                self.clearance(&q, self.pose(from, to, t), from, 0.0)
            },
            travel,
            RESOLUTION,
        )
    }
}
