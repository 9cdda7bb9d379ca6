//! A rigid transform stored by columns: the form the DH recursion and the sphere transform want.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// Three reals: a point in metres or a direction.
pub(crate) type V3 = [f64; 3];

#[inline]
pub(crate) fn add(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
#[inline]
pub(crate) fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
#[inline]
pub(crate) fn scale(a: V3, s: f64) -> V3 {
    [a[0] * s, a[1] * s, a[2] * s]
}
#[inline]
pub(crate) fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
#[inline]
pub(crate) fn cross(a: V3, b: V3) -> V3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
#[inline]
pub(crate) fn norm(a: V3) -> f64 {
    dot(a, a).sqrt()
}

/// A right-handed orthonormal frame: the columns of its rotation and its origin (m), all in the parent frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// x axis in the parent frame.
    pub x: [f64; 3],
    /// y axis in the parent frame.
    pub y: [f64; 3],
    /// z axis in the parent frame.
    pub z: [f64; 3],
    /// Origin in the parent frame, m.
    pub p: [f64; 3],
}

impl Default for Frame {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Frame {
    /// The parent frame itself.
    pub const IDENTITY: Self = Self {
        x: [1.0, 0.0, 0.0],
        y: [0.0, 1.0, 0.0],
        z: [0.0, 0.0, 1.0],
        p: [0.0; 3],
    };

    /// Frame of a base standing at `pose` = (x m, y m, yaw rad), z = 0.
    #[must_use]
    pub fn planar(pose: [f64; 3]) -> Self {
        let (s, c) = pose[2].sin_cos();
        Self {
            x: [c, s, 0.0],
            y: [-s, c, 0.0],
            z: [0.0, 0.0, 1.0],
            p: [pose[0], pose[1], 0.0],
        }
    }

    /// From rows of a rotation matrix and a translation (m), as camera poses are exchanged between crates.
    #[must_use]
    pub fn from_rows(rotation: &[[f64; 3]; 3], translation: [f64; 3]) -> Self {
        let column = |j: usize| [rotation[0][j], rotation[1][j], rotation[2][j]];
        Self {
            x: column(0),
            y: column(1),
            z: column(2),
            p: translation,
        }
    }

    /// Rows of the rotation matrix: `rows()[i][j]` is row i, column j.
    #[must_use]
    pub fn rows(&self) -> [[f64; 3]; 3] {
        [0, 1, 2].map(|i| [self.x[i], self.y[i], self.z[i]])
    }

    /// A direction of this frame, in the parent frame.
    #[inline]
    #[must_use]
    pub fn rotate(&self, v: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| self.x[i] * v[0] + self.y[i] * v[1] + self.z[i] * v[2])
    }

    /// A point of this frame (m), in the parent frame.
    #[inline]
    #[must_use]
    pub fn apply(&self, point: [f64; 3]) -> [f64; 3] {
        add(self.rotate(point), self.p)
    }

    /// A point of the parent frame (m), in this frame.
    #[inline]
    #[must_use]
    pub fn apply_inverse(&self, point: [f64; 3]) -> [f64; 3] {
        let d = sub(point, self.p);
        [dot(self.x, d), dot(self.y, d), dot(self.z, d)]
    }

    /// `parent_from_self * self_from_other`.
    #[inline]
    #[must_use]
    pub fn then(&self, other: &Self) -> Self {
        Self {
            x: self.rotate(other.x),
            y: self.rotate(other.y),
            z: self.rotate(other.z),
            p: self.apply(other.p),
        }
    }

    /// `self_from_parent`.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rows = self.rows();
        let p = [
            -dot(self.x, self.p),
            -dot(self.y, self.p),
            -dot(self.z, self.p),
        ];
        Self {
            x: rows[0],
            y: rows[1],
            z: rows[2],
            p,
        }
    }

    /// True if every number is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        [self.x, self.y, self.z, self.p]
            .iter()
            .flatten()
            .all(|v| v.is_finite())
    }

    /// Distance (m) between the origins, and angle (rad, 0 to pi) between the rotations, of two frames.
    #[must_use]
    pub fn error_to(&self, other: &Self) -> (f64, f64) {
        let position = norm(sub(self.p, other.p));
        // |R1 - R2|_F = 2 sqrt(2) sin(angle / 2): exact for small angles, where acos of the trace is not.
        let square: f64 = [
            sub(self.x, other.x),
            sub(self.y, other.y),
            sub(self.z, other.z),
        ]
        .iter()
        .map(|d| dot(*d, *d))
        .sum();
        (position, 2.0 * (square / 8.0).sqrt().min(1.0).asin())
    }
}

impl From<&Isometry3<f64>> for Frame {
    fn from(t: &Isometry3<f64>) -> Self {
        let r = t.rotation.to_rotation_matrix();
        let column = |j: usize| [r[(0, j)], r[(1, j)], r[(2, j)]];
        Self {
            x: column(0),
            y: column(1),
            z: column(2),
            p: [t.translation.x, t.translation.y, t.translation.z],
        }
    }
}

impl From<&Frame> for Isometry3<f64> {
    fn from(f: &Frame) -> Self {
        let r = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[
            Vector3::from(f.x),
            Vector3::from(f.y),
            Vector3::from(f.z),
        ]));
        Isometry3::from_parts(
            Translation3::from(Vector3::from(f.p)),
            UnitQuaternion::from_rotation_matrix(&r),
        )
    }
}
