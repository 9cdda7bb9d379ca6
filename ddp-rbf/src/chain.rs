//! A robot made of spheres on a serial arm, fixed or on a planar base: where the spheres are and how they move, for many
//! knots at once.

use crate::elementary::sin_cos;
use crate::error::Error;
use crate::simd::{Portable, Vector};

/// Most joints of a [`Chain`].
pub const MAX_JOINTS: usize = 12;
/// Most spheres of a [`Chain`].
pub const MAX_SPHERES: usize = 64;
/// States that move spheres: x, y, yaw and the joints.
pub(crate) const MAX_STATES: usize = 3 + MAX_JOINTS;

/// One revolute joint in standard Denavit-Hartenberg form: `RotZ(q) TransZ(d) TransX(a) RotX(alpha)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Offset along the joint's axis, m.
    pub d: f64,
    /// Length along x after the turn, m.
    pub a: f64,
    /// Twist about x after the turn, rad.
    pub alpha: f64,
}

/// A sphere fixed to a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkSphere {
    /// 0 for what does not move with any joint (its centre is then in the base frame), i for what moves with joint i (its
    /// centre is then in the frame after joint i).
    pub link: usize,
    /// Centre, m.
    pub center: [f64; 3],
    /// m.
    pub radius: f64,
}

/// A serial arm of revolute joints covered by spheres. Its state is `[x, y, yaw, q1, q2, ...]` on a planar base and
/// `[q1, q2, ...]` on a fixed one; a longer state is allowed, what follows does not move spheres.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    planar: bool,
    /// Columns of the rotation from the arm's root to the base frame, and the root's origin.
    root: [[f64; 3]; 4],
    joints: Vec<Joint>,
    /// Cosine and sine of the twists, exact for right angles.
    twists: Vec<(f64, f64)>,
    spheres: Vec<LinkSphere>,
    /// Indices of the spheres in the order of their links.
    order: Vec<usize>,
}

impl Chain {
    /// An arm whose root stands in the base frame with the given rotation (rows) and origin (m). With `planar` the base
    /// frame moves with x, y and yaw; otherwise it is the world.
    ///
    /// # Errors
    /// [`Error::Chain`] for too many joints or spheres, a sphere on a link that is not there, and figures that are not finite
    /// or negative radii.
    pub fn new(
        planar: bool,
        root_rotation: [[f64; 3]; 3],
        root_origin: [f64; 3],
        joints: Vec<Joint>,
        spheres: Vec<LinkSphere>,
    ) -> Result<Self, Error> {
        let bad = |what, index| Err(Error::Chain { what, index });
        if joints.len() > MAX_JOINTS {
            return bad("there are more joints than 12", joints.len());
        }
        if spheres.len() > MAX_SPHERES {
            return bad("there are more spheres than 64", spheres.len());
        }
        if let Some(i) = joints
            .iter()
            .position(|j| !(j.d.is_finite() && j.a.is_finite() && j.alpha.is_finite()))
        {
            return bad("a joint is not finite", i);
        }
        for (i, s) in spheres.iter().enumerate() {
            if s.link > joints.len() {
                return bad("a sphere stands on a link that is not there", i);
            }
            if !(s.radius >= 0.0 && s.radius.is_finite() && s.center.iter().all(|v| v.is_finite()))
            {
                return bad("a sphere is not finite or has a negative radius", i);
            }
        }
        let r = root_rotation;
        if !r
            .iter()
            .flatten()
            .chain(&root_origin)
            .all(|v| v.is_finite())
        {
            return bad("the root is not finite", 0);
        }
        let column = |j: usize| [r[0][j], r[1][j], r[2][j]];
        let twists = joints
            .iter()
            .map(|j| {
                let (s, c) = j.alpha.sin_cos();
                // Right angles are meant exactly.
                let snap = |v: f64| {
                    if (v - v.round()).abs() < 1e-14 {
                        v.round()
                    } else {
                        v
                    }
                };
                (snap(c), snap(s))
            })
            .collect();
        let mut order: Vec<usize> = (0..spheres.len()).collect();
        order.sort_by_key(|&i| spheres[i].link);
        Ok(Self {
            planar,
            root: [column(0), column(1), column(2), root_origin],
            joints,
            twists,
            spheres,
            order,
        })
    }

    /// The spheres.
    pub fn spheres(&self) -> &[LinkSphere] {
        &self.spheres
    }

    /// Number of joints.
    pub fn joints(&self) -> usize {
        self.joints.len()
    }

    /// True if it stands on a planar base.
    pub fn is_planar(&self) -> bool {
        self.planar
    }

    /// States that move spheres: joints, and three for a planar base.
    pub fn states(&self) -> usize {
        self.joints.len() + self.base_states()
    }

    pub(crate) fn base_states(&self) -> usize {
        if self.planar { 3 } else { 0 }
    }

    /// Centres of all spheres at a state, world frame, m.
    ///
    /// # Errors
    /// [`Error::Chain`] if the state is shorter than [`states`](Self::states).
    pub fn centers(&self, state: &[f64]) -> Result<Vec<[f64; 3]>, Error> {
        if state.len() < self.states() {
            return Err(Error::Chain {
                what: "the state is shorter than the base and the joints",
                index: state.len(),
            });
        }
        let mut placed: Placed<Portable<1>, MAX_SPHERES> = Placed::new();
        let mut at = [Portable::zero(); MAX_STATES];
        for (to, from) in at.iter_mut().zip(state) {
            *to = Portable::splat(*from);
        }
        self.place(&at, self.joints.len(), true, &mut placed);
        Ok(placed.centers[..self.spheres.len()]
            .iter()
            .map(|c| c.map(|v| v.array()[0]))
            .collect())
    }

    /// Places the spheres up to link `last` and the joints' axes. Without `world` the base stands at the origin: enough
    /// for distances between parts of the robot.
    ///
    /// No closures here and in other kernels: they would be compiled without the wide vectors' instructions.
    #[inline(always)]
    pub(crate) fn place<const L: usize, const S: usize, V: Vector<L>>(
        &self,
        state: &[V; MAX_STATES],
        last: usize,
        world: bool,
        out: &mut Placed<V, S>,
    ) {
        let zero = V::zero();
        let base_states = self.base_states();
        let mut turn = [zero, V::splat(1.0)];
        out.base = [zero, zero];
        if world && self.planar {
            out.base = [state[0], state[1]];
            let (s, c) = sin_cos(state[2]);
            turn = [s, c];
        }
        let mut next = 0;
        while next < self.order.len() && self.spheres[self.order[next]].link == 0 {
            let i = self.order[next];
            out.centers[i] = point_of(&turn, &out.base, &self.spheres[i].center);
            next += 1;
        }
        if last == 0 {
            return;
        }
        let mut x = turned(&turn, &self.root[0]);
        let mut y = turned(&turn, &self.root[1]);
        let mut z = turned(&turn, &self.root[2]);
        let mut p = point_of(&turn, &out.base, &self.root[3]);
        for j in 0..last {
            out.axes[j] = z;
            out.moments[j] = cross(p, z);
            let (s, c) = sin_cos(state[base_states + j]);
            let (ca, sa) = self.twists[j];
            let Joint { a, d, .. } = self.joints[j];
            for i in 0..3 {
                let along = s.mul_add(y[i], c * x[i]);
                let side = s.neg_mul_add(x[i], c * y[i]);
                if d != 0.0 {
                    p[i] = z[i].mul_add(V::splat(d), p[i]);
                }
                if a != 0.0 {
                    p[i] = along.mul_add(V::splat(a), p[i]);
                }
                x[i] = along;
                if sa == 0.0 {
                    (y[i], z[i]) = if ca > 0.0 {
                        (side, z[i])
                    } else {
                        (-side, -z[i])
                    };
                } else if ca == 0.0 {
                    (y[i], z[i]) = if sa > 0.0 {
                        (z[i], -side)
                    } else {
                        (-z[i], side)
                    };
                } else {
                    let (ca, sa) = (V::splat(ca), V::splat(sa));
                    (y[i], z[i]) = (ca.mul_add(side, sa * z[i]), sa.neg_mul_add(side, ca * z[i]));
                }
            }
            while next < self.order.len() && self.spheres[self.order[next]].link == j + 1 {
                let i = self.order[next];
                let o = self.spheres[i].center;
                for k in 0..3 {
                    let at = x[k].mul_add(V::splat(o[0]), p[k]);
                    let at = y[k].mul_add(V::splat(o[1]), at);
                    out.centers[i][k] = z[k].mul_add(V::splat(o[2]), at);
                }
                next += 1;
            }
        }
    }
}

/// A vector of the base frame in the world; `turn` is sine and cosine of the yaw.
#[inline(always)]
fn turned<const L: usize, V: Vector<L>>(turn: &[V; 2], v: &[f64; 3]) -> [V; 3] {
    let ([s, c], x, y) = (*turn, V::splat(v[0]), V::splat(v[1]));
    [s.neg_mul_add(y, c * x), s.mul_add(x, c * y), V::splat(v[2])]
}

/// A point of the base frame in the world.
#[inline(always)]
fn point_of<const L: usize, V: Vector<L>>(turn: &[V; 2], base: &[V; 2], v: &[f64; 3]) -> [V; 3] {
    let p = turned(turn, v);
    [base[0] + p[0], base[1] + p[1], p[2]]
}

/// A chain of at most `S` spheres at as many states as a vector has lanes.
pub(crate) struct Placed<V, const S: usize> {
    /// Centres of the spheres.
    pub(crate) centers: [[V; 3]; S],
    /// Axes of the joints.
    pub(crate) axes: [[V; 3]; MAX_JOINTS],
    /// Origin of each joint cross its axis: with the axis, the joint's screw.
    pub(crate) moments: [[V; 3]; MAX_JOINTS],
    /// Where the base stands.
    pub(crate) base: [V; 2],
}

impl<V: Copy, const S: usize> Placed<V, S> {
    /// All zero.
    #[inline(always)]
    pub(crate) fn new<const L: usize>() -> Self
    where
        V: Vector<L>,
    {
        let zero = V::zero();
        Self {
            centers: [[zero; 3]; S],
            axes: [[zero; 3]; MAX_JOINTS],
            moments: [[zero; 3]; MAX_JOINTS],
            base: [zero; 2],
        }
    }

    /// How fast a force `n` at a point (with `torque` = point cross n) is lifted by joint `j`: n . (axis x (point - origin)).
    #[inline(always)]
    pub(crate) fn lift<const L: usize>(&self, j: usize, n: &[V; 3], torque: &[V; 3]) -> V
    where
        V: Vector<L>,
    {
        let (a, m) = (&self.axes[j], &self.moments[j]);
        let near = a[0].mul_add(torque[0], a[1].mul_add(torque[1], a[2] * torque[2]));
        m[0].mul_add(n[0], m[1].mul_add(n[1], m[2].mul_add(n[2], near)))
    }
}

#[inline(always)]
pub(crate) fn cross<const L: usize, V: Vector<L>>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [
        a[2].neg_mul_add(b[1], a[1] * b[2]),
        a[0].neg_mul_add(b[2], a[2] * b[0]),
        a[1].neg_mul_add(b[0], a[0] * b[1]),
    ]
}
