//! The UR5e arm: DH parameters, joint limits, forward kinematics and the geometric Jacobian.

use crate::frame::{Frame, V3, add, cross, scale, sub};
use nalgebra::{Isometry3, Matrix6};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A six-joint arm of the UR family (two parallel links, three offset wrist axes); `Default` is the UR5e.
///
/// Standard DH: `T_i = RotZ(q_i) TransZ(d_i) TransX(a_i) RotX(alpha_i)` with
/// alpha = (pi/2, 0, 0, pi/2, -pi/2, 0). Arms of other sizes differ only in the six lengths.
#[derive(Clone, Debug, PartialEq)]
pub struct Ur5e {
    /// Height of the shoulder axis over the mounting face, m.
    pub d1: f64,
    /// Length of the upper arm along x of frame 2, m; negative in the maker's convention.
    pub a2: f64,
    /// Length of the forearm along x of frame 3, m; negative in the maker's convention.
    pub a3: f64,
    /// Offset of the second wrist joint from the plane of the arm, m.
    pub d4: f64,
    /// Distance between the first and the third wrist joint, m.
    pub d5: f64,
    /// Distance from the third wrist joint's centre to the flange, m.
    pub d6: f64,
    /// Lower and upper limit of each joint, rad.
    pub limits: [(f64, f64); 6],
}

impl Default for Ur5e {
    fn default() -> Self {
        let turn = (-TAU, TAU);
        Self {
            d1: 0.1625,
            a2: -0.425,
            a3: -0.3922,
            d4: 0.1333,
            d5: 0.0997,
            d6: 0.0996,
            // The elbow passes +-pi only through the upper arm.
            limits: [turn, turn, (-PI, PI), turn, turn, turn],
        }
    }
}

impl Ur5e {
    /// DH rows (d m, a m, alpha rad) of the six joints.
    #[must_use]
    pub fn dh(&self) -> [[f64; 3]; 6] {
        [
            [self.d1, 0.0, FRAC_PI_2],
            [0.0, self.a2, 0.0],
            [0.0, self.a3, 0.0],
            [self.d4, 0.0, FRAC_PI_2],
            [self.d5, 0.0, -FRAC_PI_2],
            [self.d6, 0.0, 0.0],
        ]
    }

    /// Pose of the flange (frame 6) in the arm's base frame.
    #[must_use]
    pub fn fk(&self, q: &[f64; 6]) -> Isometry3<f64> {
        (&self.chain(&Frame::IDENTITY, q)[6]).into()
    }

    /// Poses of the arm's base (index 0) and of the six DH frames in the arm's base frame.
    #[must_use]
    pub fn frames(&self, q: &[f64; 6]) -> [Isometry3<f64>; 7] {
        self.chain(&Frame::IDENTITY, q).map(|f| (&f).into())
    }

    /// The arm's base frame `root` and the six DH frames, all in the frame that `root` is given in.
    ///
    /// The plain-array twin of [`frames`](Self::frames), without the conversion to quaternions.
    #[inline]
    #[must_use]
    pub fn chain(&self, root: &Frame, q: &[f64; 6]) -> [Frame; 7] {
        let turn = q.map(f64::sin_cos);
        self.chain_sin_cos(root, &turn)
    }

    #[inline]
    pub(crate) fn chain_sin_cos(&self, root: &Frame, turn: &[(f64, f64); 6]) -> [Frame; 7] {
        let f1 = step_up(root, turn[0], self.d1);
        let f2 = step_flat(&f1, turn[1], self.a2, 0.0);
        let f3 = step_flat(&f2, turn[2], self.a3, 0.0);
        let f4 = step_up(&f3, turn[3], self.d4);
        let f5 = step_down(&f4, turn[4], self.d5);
        let f6 = step_flat(&f5, turn[5], 0.0, self.d6);
        [*root, f1, f2, f3, f4, f5, f6]
    }

    /// Geometric Jacobian of the flange in the arm's base frame: rows 0..3 velocity of the flange's origin
    /// (m/s per rad/s), rows 3..6 angular velocity; column j belongs to joint j.
    #[must_use]
    pub fn jacobian(&self, q: &[f64; 6]) -> Matrix6<f64> {
        jacobian_of(&self.chain(&Frame::IDENTITY, q))
    }

    /// |det J|, from the product form of the UR family: |a2 a3 s3 s5 r|, r the distance of the wrist centre
    /// from the shoulder pan axis along the arm's plane. Zero exactly on the three singular sets. Unit m^3.
    #[must_use]
    pub fn manipulability(&self, q: &[f64; 6]) -> f64 {
        let (s234, c2, c23) = ((q[1] + q[2] + q[3]).sin(), q[1].cos(), (q[1] + q[2]).cos());
        let radial = self.a2 * c2 + self.a3 * c23 + self.d5 * s234;
        (self.a2 * self.a3 * q[2].sin() * q[4].sin() * radial).abs()
    }

    /// First joint outside its limits, with the amount (rad) it is outside; NaN counts as infinitely far out.
    #[must_use]
    pub fn limit_violation(&self, q: &[f64; 6]) -> Option<(usize, f64)> {
        (0..6).find_map(|j| {
            let (low, high) = self.limits[j];
            let out = (low - q[j]).max(q[j] - high);
            if q[j].is_nan() {
                Some((j, f64::INFINITY))
            } else if out > 0.0 {
                Some((j, out))
            } else {
                None
            }
        })
    }

    /// The copy of `q` (whole turns added per joint) inside the limits that lies nearest to `seed`.
    ///
    /// `None` if some joint has no copy inside its limits. Ties go to the copy towards zero turns.
    #[must_use]
    pub fn nearest_copy(&self, q: &[f64; 6], seed: &[f64; 6]) -> Option<[f64; 6]> {
        let mut out = *q;
        for j in 0..6 {
            let (low, high) = self.limits[j];
            let mut best: Option<f64> = None;
            // Limits never span more than a few turns; count outward from the copy nearest to the seed.
            let nearest = q[j] + TAU * ((seed[j] - q[j]) / TAU).round();
            for k in [0.0, -1.0, 1.0, -2.0, 2.0] {
                let v = nearest + TAU * k;
                if v >= low
                    && v <= high
                    && best.is_none_or(|b| (v - seed[j]).abs() < (b - seed[j]).abs() - 1e-12)
                {
                    best = Some(v);
                }
            }
            out[j] = best?;
        }
        Some(out)
    }
}

/// Geometric Jacobian from the seven frames of a chain, in the frame the chain is given in.
pub(crate) fn jacobian_of(frames: &[Frame; 7]) -> Matrix6<f64> {
    let tip = frames[6].p;
    let mut j = Matrix6::zeros();
    for k in 0..6 {
        let axis = frames[k].z;
        let v = cross(axis, sub(tip, frames[k].p));
        for i in 0..3 {
            j[(i, k)] = v[i];
            j[(3 + i, k)] = axis[i];
        }
    }
    j
}

#[inline]
fn turned(f: &Frame, (s, c): (f64, f64)) -> (V3, V3) {
    let x = add(scale(f.x, c), scale(f.y, s));
    let y = sub(scale(f.y, c), scale(f.x, s));
    (x, y)
}

/// Joint with a = 0, alpha = pi/2.
#[inline]
fn step_up(f: &Frame, turn: (f64, f64), d: f64) -> Frame {
    let (x, y) = turned(f, turn);
    Frame {
        x,
        y: f.z,
        z: scale(y, -1.0),
        p: add(f.p, scale(f.z, d)),
    }
}

/// Joint with a = 0, alpha = -pi/2.
#[inline]
fn step_down(f: &Frame, turn: (f64, f64), d: f64) -> Frame {
    let (x, y) = turned(f, turn);
    Frame {
        x,
        y: scale(f.z, -1.0),
        z: y,
        p: add(f.p, scale(f.z, d)),
    }
}

/// Joint with alpha = 0.
#[inline]
fn step_flat(f: &Frame, turn: (f64, f64), a: f64, d: f64) -> Frame {
    let (x, y) = turned(f, turn);
    Frame {
        x,
        y,
        z: f.z,
        p: add(f.p, add(scale(x, a), scale(f.z, d))),
    }
}
