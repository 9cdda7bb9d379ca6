//! Exact distances of simple shapes, in f64.
//!
//! General convex pairs go to parry's GJK, which works in f32 and stops a millimetre or two early on round shapes.
//! The pairs that matter most have closed or convex one-dimensional forms; the rest are tightened by projections.

use crate::scene::{Form, Solid};

/// Steps of the golden section search: 0.618^44 of a metre is below a nanometre.
const STEPS: usize = 44;

/// Most projections back and forth.
const PROJECTIONS: usize = 300;

/// Distance from a world point to a box or cylinder, 0 inside; `None` for a mesh.
pub(crate) fn to_point(solid: &Solid, p: [f64; 3]) -> Option<f64> {
    let l = solid.to_local(p);
    match &solid.form {
        Form::Box(half) => Some(length([0, 1, 2].map(|k| (l[k].abs() - half[k]).max(0.0)))),
        Form::Cylinder(radius, half) => {
            let aside = (l[0].hypot(l[1]) - radius).max(0.0);
            Some(aside.hypot((l[2].abs() - half).max(0.0)))
        }
        Form::Mesh(_) => None,
    }
}

/// Distance from a segment to a box or cylinder; `None` for a mesh.
///
/// The distance to a convex set is convex along a line, so a golden section search finds its minimum.
pub(crate) fn to_segment(solid: &Solid, a: [f64; 3], b: [f64; 3]) -> Option<f64> {
    let at = |s: f64| to_point(solid, [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k])));
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (0.0, 1.0);
    let (mut s, mut t) = (1.0 - golden, golden);
    let (mut fs, mut ft) = (at(s)?, at(t)?);
    for _ in 0..STEPS {
        if fs <= ft {
            (high, t, ft) = (t, s, fs);
            s = high - golden * (high - low);
            fs = at(s)?;
        } else {
            (low, s, fs) = (s, t, ft);
            t = low + golden * (high - low);
            ft = at(t)?;
        }
        if fs == 0.0 || ft == 0.0 {
            return Some(0.0);
        }
    }
    Some(fs.min(ft).min(at(0.0)?).min(at(1.0)?))
}

/// A box or cylinder in a frame: its kind, centre and axes in the world.
#[derive(Clone, Debug)]
pub(crate) struct Placed<'a> {
    pub(crate) form: &'a Form,
    pub(crate) center: [f64; 3],
    pub(crate) axes: [[f64; 3]; 3],
}

impl<'a> Placed<'a> {
    pub(crate) fn of(solid: &'a Solid) -> Self {
        Self {
            form: &solid.form,
            center: solid.center,
            axes: solid.axes,
        }
    }

    /// The point of the body nearest to `p`; `None` for a mesh.
    fn nearest(&self, p: [f64; 3]) -> Option<[f64; 3]> {
        let d = [0, 1, 2].map(|k| p[k] - self.center[k]);
        let mut l = self.axes.map(|a| a[0] * d[0] + a[1] * d[1] + a[2] * d[2]);
        match *self.form {
            Form::Box(half) => l = [0, 1, 2].map(|k| l[k].clamp(-half[k], half[k])),
            Form::Cylinder(radius, half) => {
                let shrink = (radius / l[0].hypot(l[1])).min(1.0);
                l = [l[0] * shrink, l[1] * shrink, l[2].clamp(-half, half)];
            }
            Form::Mesh(_) => return None,
        }
        Some(
            [0, 1, 2].map(|k| self.center[k] + (0..3).map(|j| self.axes[j][k] * l[j]).sum::<f64>()),
        )
    }

    /// An upper bound of the distance to another body, from projections back and forth, which converge to the
    /// nearest points of two convex sets; `None` for a mesh.
    pub(crate) fn approach(&self, other: &Self) -> Option<f64> {
        let mut b = self.center;
        let mut last = f64::INFINITY;
        for _ in 0..PROJECTIONS {
            let a = other.nearest(b)?;
            b = self.nearest(a)?;
            let distance = length([0, 1, 2].map(|k| a[k] - b[k]));
            if last - distance < 1e-9 {
                return Some(distance);
            }
            last = distance;
        }
        Some(last)
    }
}

/// What an upright prism covers of the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Plan {
    /// A rectangle: centre, unit direction of its first axis, half extents.
    Rectangle([f64; 2], [f64; 2], [f64; 2]),
    /// A disc: centre and radius.
    Disc([f64; 2], f64),
}

/// An upright prism: what it covers of the ground, and its height band.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prism {
    pub(crate) plan: Plan,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Prism {
    /// The solid as a prism, if it is an upright box or cylinder.
    pub(crate) fn of(solid: &Solid) -> Option<Self> {
        let center = [solid.center[0], solid.center[1]];
        let plan = match solid.form {
            Form::Box(half) if solid.upright => Plan::Rectangle(
                center,
                [solid.axes[0][0], solid.axes[0][1]],
                [half[0], half[1]],
            ),
            Form::Cylinder(radius, _) if solid.upright => Plan::Disc(center, radius),
            _ => return None,
        };
        Some(Self {
            plan,
            low: solid.low[2],
            high: solid.high[2],
        })
    }

    /// Distance between two prisms, 0 when they overlap: both are products of a plan and a height band.
    pub(crate) fn distance(&self, other: &Self) -> f64 {
        let rise = (other.low - self.high).max(self.low - other.high).max(0.0);
        rise.hypot(plan_distance(&self.plan, &other.plan))
    }
}

fn length(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

/// A point seen from a rectangle's centre, along its axes.
fn into((center, axis): ([f64; 2], [f64; 2]), p: [f64; 2]) -> [f64; 2] {
    let d = [p[0] - center[0], p[1] - center[1]];
    [
        axis[0] * d[0] + axis[1] * d[1],
        axis[0] * d[1] - axis[1] * d[0],
    ]
}

fn plan_distance(a: &Plan, b: &Plan) -> f64 {
    match (*a, *b) {
        (Plan::Disc(c, r), Plan::Disc(d, s)) => ((c[0] - d[0]).hypot(c[1] - d[1]) - r - s).max(0.0),
        (Plan::Disc(c, r), Plan::Rectangle(center, axis, half))
        | (Plan::Rectangle(center, axis, half), Plan::Disc(c, r)) => {
            let l = into((center, axis), c);
            let d = [0, 1].map(|k| (l[k].abs() - half[k]).max(0.0));
            (d[0].hypot(d[1]) - r).max(0.0)
        }
        (Plan::Rectangle(ca, xa, ha), Plan::Rectangle(cb, xb, hb)) => {
            rectangles((ca, xa, ha), (cb, xb, hb))
        }
    }
}

type Rectangle = ([f64; 2], [f64; 2], [f64; 2]);

/// Distance between two turned rectangles: apart, the nearest pair holds a corner of one of them.
fn rectangles(a: Rectangle, b: Rectangle) -> f64 {
    // Overlap: no separating axis among the four face normals.
    let mut apart = false;
    let mut nearest = f64::INFINITY;
    for (one, other) in [(a, b), (b, a)] {
        let frame = (one.0, one.1);
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(u, v)| {
            let (c, x, h) = other;
            let (du, dv) = (u * h[0], v * h[1]);
            into(
                frame,
                [c[0] + du * x[0] - dv * x[1], c[1] + du * x[1] + dv * x[0]],
            )
        });
        for k in 0..2 {
            let low = corners.iter().fold(f64::INFINITY, |m, c| m.min(c[k]));
            let high = corners.iter().fold(f64::NEG_INFINITY, |m, c| m.max(c[k]));
            apart |= low > one.2[k] || high < -one.2[k];
        }
        for c in corners {
            let d = [0, 1].map(|k| (c[k].abs() - one.2[k]).max(0.0));
            nearest = nearest.min(d[0].hypot(d[1]));
        }
    }
    if apart { nearest } else { 0.0 }
}
