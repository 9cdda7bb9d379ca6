//! An arm of balls on a chain of joints, among oriented boxes, capsules and balls; exact distances.

#![allow(unsafe_code)]

use serde_json::Value;
use std::cell::RefCell;
use strrt::{Robot, motion_is_clear};

pub(crate) type Joints = [f64; 6];
/// Columns of the rotation, then the origin.
pub(crate) type Frame = [[f64; 3]; 4];

/// Motions are looked at down to this travel, m.
const RESOLUTION: f64 = 4e-3;
/// Balls at most.
const BALLS: usize = 64;
/// Balls that are looked at together.
const LANES: usize = 8;
/// More than single precision loses within a few metres, m.
const ROUNDING: f32 = 1e-5;

type Lanes = [f32; LANES];
type Row = [f32; BALLS];
/// Coordinate of balls beyond the last, m.
const NOWHERE: f32 = 1e3;
/// Not 0, so that shares exist.
const NO_TRAVEL: Row = [1e-6; BALLS];

/// A link's place on its parent.
pub(crate) struct Link {
    pub(crate) parent: Option<usize>,
    pub(crate) fixed: Frame,
    /// Number of the joint and its axis.
    pub(crate) joint: Option<(usize, [f64; 3])>,
}

pub(crate) struct Ball {
    pub(crate) link: usize,
    pub(crate) center: [f64; 3],
    pub(crate) radius: f64,
}

pub(crate) struct Arm {
    /// Parents before children.
    pub(crate) links: Vec<Link>,
    pub(crate) balls: Vec<Ball>,
    /// Balls of links that are at least two joints apart.
    pub(crate) pairs: Vec<(usize, usize)>,
    /// The same: a ball, and the first of those it must not touch, which run to the last.
    far: Vec<(usize, usize)>,
    /// 0 beyond the last.
    radius: Row,
    pub(crate) limits: [(f64, f64); 6],
    /// For each ball, how far from each joint's axis its centre can be, m; 0 for joints that do not move it.
    levers: Vec<Joints>,
}

pub(crate) enum Solid {
    /// World frame and half sizes.
    Box(Frame, [f64; 3]),
    /// Ends and radius; a ball if the ends are one.
    Capsule([f64; 3], [f64; 3], f64),
}

fn three(v: &Value) -> Option<[f64; 3]> {
    Some([v[0].as_f64()?, v[1].as_f64()?, v[2].as_f64()?])
}

/// `frame * point`.
pub(crate) fn apply(f: &Frame, p: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| f[3][i] + f[0][i] * p[0] + f[1][i] * p[1] + f[2][i] * p[2])
}

fn times(a: &Frame, b: &Frame) -> Frame {
    let turn =
        |v: [f64; 3]| std::array::from_fn(|i| a[0][i] * v[0] + a[1][i] * v[1] + a[2][i] * v[2]);
    [turn(b[0]), turn(b[1]), turn(b[2]), apply(a, b[3])]
}

/// URDF's roll, pitch, yaw about fixed axes.
fn placed(xyz: [f64; 3], [r, p, y]: [f64; 3]) -> Frame {
    let ((sr, cr), (sp, cp), (sy, cy)) = (r.sin_cos(), p.sin_cos(), y.sin_cos());
    [
        [cy * cp, sy * cp, -sp],
        [cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr],
        [cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr],
        xyz,
    ]
}

/// A turn about one of the coordinate axes.
fn turned(f: &Frame, axis: [f64; 3], angle: f64) -> Frame {
    let (s, c) = angle.sin_cos();
    let k = axis.iter().position(|v| *v != 0.0).unwrap_or(2);
    let s = s * axis[k];
    let (u, v) = ((k + 1) % 3, (k + 2) % 3);
    let mut out = *f;
    for i in 0..3 {
        out[u][i] = c * f[u][i] + s * f[v][i];
        out[v][i] = c * f[v][i] - s * f[u][i];
    }
    out
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

impl Arm {
    /// From `ur5-mbm-robot.json`; `None` if something is missing.
    pub(crate) fn read(file: &Value) -> Option<Self> {
        let mut names = vec![file["joints"][0]["parent"].as_str()?.to_owned()];
        let mut links = vec![Link {
            parent: None,
            fixed: placed([0.0; 3], [0.0; 3]),
            joint: None,
        }];
        let (mut limits, mut moving) = ([(0.0, 0.0); 6], 0);
        for row in file["joints"].as_array()? {
            let parent = names
                .iter()
                .position(|n| Some(n.as_str()) == row["parent"].as_str())?;
            let joint = if row["type"] == "revolute" {
                limits[moving] = (row["lower"].as_f64()?, row["upper"].as_f64()?);
                moving += 1;
                Some((moving - 1, three(&row["axis"])?))
            } else {
                None
            };
            links.push(Link {
                parent: Some(parent),
                fixed: placed(three(&row["xyz"])?, three(&row["rpy"])?),
                joint,
            });
            names.push(row["child"].as_str()?.to_owned());
        }
        let mut balls = Vec::new();
        for row in file["link_spheres"].as_array()? {
            let link = names
                .iter()
                .position(|n| Some(n.as_str()) == row["link"].as_str())?;
            for s in row["spheres"].as_array()? {
                balls.push(Ball {
                    link,
                    center: three(s)?,
                    radius: s[3].as_f64()?,
                });
            }
        }
        // Joints before a ball, and the length of the chain from each of them to it.
        let mut levers = vec![[0.0f64; 6]; balls.len()];
        let mut depth = vec![0; balls.len()];
        for (k, ball) in balls.iter().enumerate() {
            let (mut at, mut reach) = (Some(ball.link), norm(ball.center));
            while let Some(link) = at.map(|i| &links[i]) {
                if let Some((j, _)) = link.joint {
                    levers[k][j] = reach;
                    depth[k] += 1;
                }
                reach += norm(link.fixed[3]);
                at = link.parent;
            }
        }
        let mut pairs = Vec::new();
        for i in 0..balls.len() {
            for j in i + 1..balls.len() {
                // The three wrist links touch one another at rest.
                if depth[j] >= depth[i] + 2 && depth[i] < 4 {
                    pairs.push((i, j));
                }
            }
        }
        if balls.len() > BALLS || moving != 6 {
            return None;
        }
        let far = (0..balls.len()).filter_map(|i| {
            let first = pairs.iter().find(|p| p.0 == i)?.1;
            Some((i, first))
        });
        let far: Vec<(usize, usize)> = far.collect();
        // Balls are listed from the base to the tip, so that the ones to stay clear of come last.
        if far.iter().map(|f| balls.len() - f.1).sum::<usize>() != pairs.len() {
            return None;
        }
        let mut radius = [0.0; BALLS];
        for (to, ball) in radius.iter_mut().zip(&balls) {
            *to = ball.radius as f32;
        }
        Some(Self {
            links,
            balls,
            pairs,
            far,
            radius,
            limits,
            levers,
        })
    }

    fn centers(&self, q: &Joints, frames: &mut Vec<Frame>, centers: &mut Vec<[f64; 3]>) {
        frames.clear();
        for link in &self.links {
            let f = link
                .parent
                .map_or(link.fixed, |p| times(&frames[p], &link.fixed));
            frames.push(link.joint.map_or(f, |(j, axis)| turned(&f, axis, q[j])));
        }
        centers.clear();
        centers.extend(self.balls.iter().map(|b| apply(&frames[b.link], b.center)));
    }
}

impl Solid {
    /// From one entry of `obstacles`; cylinders are taken as capsules.
    pub(crate) fn read(v: &Value) -> Option<Self> {
        let m = &v["pose"];
        let mut frame: Frame = [[0.0; 3]; 4];
        for i in 0..3 {
            for (k, column) in frame.iter_mut().enumerate() {
                column[i] = m[i][k].as_f64()?;
            }
        }
        let d = &v["dims"];
        match v["type"].as_str()? {
            "box" => Some(Self::Box(frame, three(d)?.map(|x| 0.5 * x))),
            "cylinder" => {
                let (half, radius) = (0.5 * d[0].as_f64()?, d[1].as_f64()?);
                let end = |z: f64| apply(&frame, [0.0, 0.0, z]);
                Some(Self::Capsule(end(-half), end(half), radius))
            }
            "sphere" => Some(Self::Capsule(frame[3], frame[3], d[0].as_f64()?)),
            _ => None,
        }
    }

    /// Distance of a point from the solid, m; negative inside a capsule, 0 inside a box.
    fn distance(&self, p: &[f64; 3]) -> f64 {
        match self {
            Self::Box(f, half) => {
                let d: [f64; 3] = std::array::from_fn(|i| p[i] - f[3][i]);
                let mut square = 0.0;
                for k in 0..3 {
                    let along = d[0] * f[k][0] + d[1] * f[k][1] + d[2] * f[k][2];
                    let out = (along.abs() - half[k]).max(0.0);
                    square += out * out;
                }
                square.sqrt()
            }
            Self::Capsule(a, b, r) => {
                let ab: [f64; 3] = std::array::from_fn(|i| b[i] - a[i]);
                let ap: [f64; 3] = std::array::from_fn(|i| p[i] - a[i]);
                let (l, along): (f64, f64) = (0..3)
                    .map(|i| (ab[i] * ab[i], ab[i] * ap[i]))
                    .fold((0.0, 0.0), |s, v| (s.0 + v.0, s.1 + v.1));
                let t = if l > 0.0 {
                    (along / l).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                norm(std::array::from_fn(|i| ap[i] - t * ab[i])) - r
            }
        }
    }
}

/// A box, or all points no further than `radius` from one, in single precision.
struct Flat {
    axes: [[f32; 3]; 3],
    middle: [f32; 3],
    half: [f32; 3],
    radius: f32,
}

/// The arm at its place; the base does not move.
pub(crate) struct Scene<'a> {
    pub(crate) arm: &'a Arm,
    pub(crate) solids: Vec<Solid>,
    flat: Vec<Flat>,
    work: RefCell<(Vec<Frame>, Vec<[f64; 3]>)>,
}

impl<'a> Scene<'a> {
    pub(crate) fn new(arm: &'a Arm, solids: Vec<Solid>) -> Self {
        Self {
            arm,
            flat: solids.iter().map(Flat::new).collect(),
            solids,
            work: RefCell::default(),
        }
    }

    /// Least distance between a ball and a solid or another ball, m, up to 1; negative or 0 if some touch. In double
    /// precision and without the tables of [`share`](Self::share), to check what that let pass.
    pub(crate) fn clearance(&self, q: &Joints) -> f64 {
        let mut work = self.work.borrow_mut();
        let (frames, centers) = &mut *work;
        self.arm.centers(q, frames, centers);
        let balls = &self.arm.balls;
        let mut least = 1.0f64;
        for (c, ball) in centers.iter().zip(balls) {
            for solid in &self.solids {
                least = least.min(solid.distance(c) - ball.radius);
            }
        }
        for &(i, j) in &self.arm.pairs {
            let gap = norm(std::array::from_fn(|k| centers[i][k] - centers[j][k]));
            least = least.min(gap - balls[i].radius - balls[j].radius);
        }
        least
    }

    /// Least distance as a share of what the ball (or two together) may travel, up to 1; not positive if some touch.
    /// Eight balls at a time, in single precision and with a margin for its rounding.
    fn share(&self, q: &Joints, travel: &Row) -> f64 {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the only requirement of a function with target features is that the machine has them.
            return unsafe { self.share_avx2(q, travel) };
        }
        self.share_inline(q, travel)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn share_avx2(&self, q: &Joints, travel: &Row) -> f64 {
        self.share_inline(q, travel)
    }

    #[inline(always)]
    fn share_inline(&self, q: &Joints, travel: &Row) -> f64 {
        let mut work = self.work.borrow_mut();
        let (frames, centers) = &mut *work;
        self.arm.centers(q, frames, centers);
        let mut place = [[NOWHERE; BALLS]; 3];
        for (k, c) in centers.iter().enumerate() {
            for i in 0..3 {
                place[i][k] = c[i] as f32;
            }
        }
        let radius = &self.arm.radius;
        let chunks = centers.len().div_ceil(LANES);
        let row = |axis: usize, k: usize| lanes(&place[axis][k * LANES..(k + 1) * LANES]);
        let mut least = 1.0f32;
        for solid in &self.flat {
            for k in 0..chunks {
                let at = k * LANES..(k + 1) * LANES;
                let (r, t) = (lanes(&radius[at.clone()]), lanes(&travel[at]));
                let squares = solid.squares([row(0, k), row(1, k), row(2, k)]);
                if !within(&squares, r, t, solid.radius, 0.0, least) {
                    continue;
                }
                for l in 0..LANES {
                    let gap = squares[l].sqrt() - ROUNDING - solid.radius - r[l];
                    least = least.min(gap / t[l]);
                }
                if least <= 0.0 {
                    return 0.0;
                }
            }
        }
        for &(i, first) in &self.arm.far {
            let c = [0, 1, 2].map(|axis| place[axis][i]);
            for k in first / LANES..chunks {
                let at = k * LANES..(k + 1) * LANES;
                let (r, t) = (lanes(&radius[at.clone()]), lanes(&travel[at]));
                let p = [row(0, k), row(1, k), row(2, k)];
                let mut squares = [0.0; LANES];
                for l in 0..LANES {
                    let d = [p[0][l] - c[0], p[1][l] - c[1], p[2][l] - c[2]];
                    squares[l] = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                }
                if !within(&squares, r, t, radius[i], travel[i], least) {
                    continue;
                }
                // Balls before the first one are neighbours.
                for l in first.saturating_sub(k * LANES)..LANES {
                    let gap = squares[l].sqrt() - ROUNDING - r[l] - radius[i];
                    least = least.min(gap / (t[l] + travel[i]));
                }
                if least <= 0.0 {
                    return 0.0;
                }
            }
        }
        f64::from(least)
    }
}

/// Whether one of eight gaps is less than the share of its travel.
#[inline(always)]
fn within(squares: &Lanes, r: &Lanes, t: &Lanes, radius: f32, travel: f32, least: f32) -> bool {
    let mut worst = [0.0f32; LANES];
    for l in 0..LANES {
        let need = r[l] + (radius + ROUNDING) + least * (t[l] + travel);
        worst[l] = squares[l] - need * need;
    }
    worst.iter().any(|w| *w < 0.0)
}

#[inline(always)]
fn lanes(part: &[f32]) -> &Lanes {
    part.try_into().unwrap_or(&[0.0; LANES])
}

impl Flat {
    fn new(solid: &Solid) -> Self {
        let narrow = |v: [f64; 3]| v.map(|x| x as f32);
        match solid {
            Solid::Box(f, half) => Self {
                axes: [f[0], f[1], f[2]].map(narrow),
                middle: narrow(f[3]),
                half: narrow(*half),
                radius: 0.0,
            },
            Solid::Capsule(a, b, r) => {
                // A box without width around the capsule's line.
                let ab: [f64; 3] = std::array::from_fn(|i| b[i] - a[i]);
                let l = norm(ab);
                let z = if l > 0.0 {
                    ab.map(|v| v / l)
                } else {
                    [0.0, 0.0, 1.0]
                };
                let k = (0..3).fold(0, |k, i| if z[i].abs() < z[k].abs() { i } else { k });
                let cross = |u: [f64; 3], v: [f64; 3]| {
                    [0, 1, 2]
                        .map(|i| u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3])
                };
                let mut other = [0.0; 3];
                other[k] = 1.0;
                let x = cross(other, z);
                let x = x.map(|v| v / norm(x));
                Self {
                    axes: [x, cross(z, x), z].map(narrow),
                    middle: narrow(std::array::from_fn(|i| 0.5 * (a[i] + b[i]))),
                    half: [0.0, 0.0, 0.5 * l as f32],
                    radius: *r as f32,
                }
            }
        }
    }

    /// Squared distances of eight points from the box, m^2.
    #[inline(always)]
    fn squares(&self, p: [&Lanes; 3]) -> Lanes {
        let mut out = [0.0; LANES];
        for l in 0..LANES {
            let d = [0, 1, 2].map(|i| p[i][l] - self.middle[i]);
            let mut square = 0.0;
            for k in 0..3 {
                let a = &self.axes[k];
                let along = d[0] * a[0] + d[1] * a[1] + d[2] * a[2];
                let over = (along.abs() - self.half[k]).max(0.0);
                square += over * over;
            }
            out[l] = square;
        }
        out
    }
}

impl Robot<6> for Scene<'_> {
    fn limits(&self) -> [(f64, f64); 6] {
        self.arm.limits
    }
    fn max_speed(&self) -> Joints {
        [1.0; 6]
    }
    fn is_static(&self) -> bool {
        true
    }
    fn is_valid(&self, q: &Joints, _: usize) -> bool {
        self.share(q, &NO_TRAVEL) > 0.0
    }
    fn is_motion_valid(&self, a: &Joints, b: &Joints, _: usize, _: usize) -> bool {
        let mut travel = NO_TRAVEL;
        for (to, lever) in travel.iter_mut().zip(&self.arm.levers) {
            let sum: f64 = (0..6).map(|j| lever[j] * (b[j] - a[j]).abs()).sum();
            *to = (sum as f32).max(1e-6);
        }
        let used = &travel[..self.arm.balls.len()];
        let most = f64::from(used.iter().copied().fold(0.0, f32::max));
        let at = |t: f64| std::array::from_fn(|j| a[j] + t * (b[j] - a[j]));
        // In shares of the motion, so that each ball counts with its own travel.
        motion_is_clear(|t| self.share(&at(t), &travel), 1.0, RESOLUTION / most)
    }
}
