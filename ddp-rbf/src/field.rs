//! Distance fields: the trait, and two ready-made ones: boxes and a voxel grid.

use crate::elementary::{exp, ln};
use crate::error::{Error, positive};
use crate::simd::{Kernel, LANES, Lanes, Vector, dispatch};

/// A field of distances to obstacles.
///
/// Laws: the gradient is that of the same interpolant as the value, so that a line search is never lied to; a batch gives
/// what single queries give, up to rounding.
pub trait Field {
    /// Distance at a point (world frame, m), and its gradient.
    fn distance_gradient(&self, point: [f64; 3]) -> (f64, [f64; 3]);
    /// Distance alone.
    fn distance(&self, point: [f64; 3]) -> f64 {
        self.distance_gradient(point).0
    }
    /// Groups of [`LANES`] points, each group as its x, y and z: distance and gradient (x, y, z) of each. A field that can do
    /// better than one by one overrides it. The slices have the same length.
    fn batch(&self, points: &[[Lanes; 3]], out: &mut [[Lanes; 4]]) {
        for (p, out) in points.iter().zip(out) {
            for lane in 0..LANES {
                let (distance, gradient) =
                    self.distance_gradient([p[0][lane], p[1][lane], p[2][lane]]);
                out[0][lane] = distance;
                for a in 0..3 {
                    out[1 + a][lane] = gradient[a];
                }
            }
        }
    }
}

impl<F: Field + ?Sized> Field for &F {
    fn distance_gradient(&self, point: [f64; 3]) -> (f64, [f64; 3]) {
        (**self).distance_gradient(point)
    }
    fn distance(&self, point: [f64; 3]) -> f64 {
        (**self).distance(point)
    }
    fn batch(&self, points: &[[Lanes; 3]], out: &mut [[Lanes; 4]]) {
        (**self).batch(points, out);
    }
}

/// Axis-aligned boxes, and a floor if wanted, joined by a soft minimum: `-ln(sum exp(-beta d)) / beta`, which lies below
/// the exact minimum by at most `ln(n) / beta`. Smooth except on the boxes' medial surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxField {
    boxes: Vec<[f64; 6]>,
    floor: Option<f64>,
    beta: f64,
}

/// Beyond this many metres above the least distance a box has no part in the soft minimum (exp(-37) at beta = 50).
const SOFT_REACH: f64 = 37.5;
/// Boxes whose distance is remembered from the first look; those after them are measured again.
const REMEMBERED: usize = 24;

impl BoxField {
    /// Boxes as `[cx, cy, cz, hx, hy, hz]` (centre and half extents, m), the height of the floor, and beta (1/m).
    ///
    /// # Errors
    /// [`Error::Param`] for a beta that is not positive, a box that is not finite or has a negative extent, or no box and no
    /// floor.
    pub fn new(boxes: Vec<[f64; 6]>, floor: Option<f64>, beta: f64) -> Result<Self, Error> {
        positive("beta", beta)?;
        for b in &boxes {
            let bad = b.iter().find(|v| !v.is_finite());
            if let Some(&value) = bad.or_else(|| b[3..].iter().find(|v| **v < 0.0)) {
                return Err(Error::Param {
                    field: "box",
                    value,
                });
            }
        }
        if boxes.is_empty() && floor.is_none() {
            return Err(Error::Param {
                field: "boxes and floors",
                value: 0.0,
            });
        }
        Ok(Self { boxes, floor, beta })
    }

    /// The exact minimum of the distances: what a soft field is judged by.
    pub fn exact(&self, point: [f64; 3]) -> f64 {
        let boxes = self.boxes.iter().map(|b| {
            let q = [0, 1, 2].map(|a| (point[a] - b[a]).abs() - b[3 + a]);
            let outside = q.iter().map(|v| v.max(0.0).powi(2)).sum::<f64>().sqrt();
            outside + q[0].max(q[1]).max(q[2]).min(0.0)
        });
        let floor = self.floor.map_or(f64::INFINITY, |h| point[2] - h);
        boxes.fold(floor, f64::min)
    }

    /// Distance and gradient at four points; `all` is room for the distances of the first boxes.
    #[inline(always)]
    fn group<V: Vector>(&self, point: [V; 3], all: &mut [V; REMEMBERED]) -> [V; 4] {
        let zero = V::zero();
        // First the least, so that only boxes near it cost an exponential and a gradient.
        let mut least = match self.floor {
            Some(h) => point[2] - V::splat(h),
            None => V::splat(f64::MAX),
        };
        for (i, b) in self.boxes.iter().enumerate() {
            let d = ToBox::new(b, &point).distance;
            if i < all.len() {
                all[i] = d;
            }
            least = d.min(least);
        }
        let beta = V::splat(self.beta);
        let reach = least + V::splat(SOFT_REACH / self.beta);
        let mut sum = zero;
        let mut gradient = [zero; 3];
        for (i, b) in self.boxes.iter().enumerate() {
            if i < all.len() && reach.all_less(all[i]) {
                continue;
            }
            let ToBox {
                q,
                out,
                root,
                distance,
            } = ToBox::new(b, &point);
            let weight = reach.if_less(distance, zero, exp((least - distance) * beta));
            sum = sum + weight;
            // Outside the slope of the root, inside one along the nearest face.
            let inverse = V::splat(1.0) / root;
            let top = q[0].max(q[1]).max(q[2]);
            let mut open = top.if_less(zero, V::splat(1.0), zero);
            for a in 0..3 {
                let nearest = q[a].if_less(top, zero, open);
                open = open - nearest;
                let slope = out[a].mul_add(inverse, nearest);
                let side = (point[a] - V::splat(b[a])).if_less(zero, -slope, slope);
                gradient[a] = weight.mul_add(side, gradient[a]);
            }
        }
        if let Some(h) = self.floor {
            let weight = exp((least - (point[2] - V::splat(h))) * beta);
            sum = sum + weight;
            gradient[2] = gradient[2] + weight;
        }
        let inverse = V::splat(1.0) / sum;
        [
            least - ln(sum) / beta,
            gradient[0] * inverse,
            gradient[1] * inverse,
            gradient[2] * inverse,
        ]
    }
}

/// Where a point lies to a box.
struct ToBox<V> {
    /// Distance beyond the faces along each axis, negative within.
    q: [V; 3],
    /// The same, zero within.
    out: [V; 3],
    /// Smoothed length of `out`.
    root: V,
    distance: V,
}

impl<V: Vector> ToBox<V> {
    #[inline(always)]
    fn new(b: &[f64; 6], point: &[V; 3]) -> Self {
        let zero = V::zero();
        let mut q = [zero; 3];
        let mut out = [zero; 3];
        let mut square = V::splat(1e-12);
        for a in 0..3 {
            q[a] = (point[a] - V::splat(b[a])).abs() - V::splat(b[3 + a]);
            out[a] = q[a].max(zero);
            square = out[a].mul_add(out[a], square);
        }
        let root = square.sqrt();
        let distance = root + q[0].max(q[1]).max(q[2]).min(zero);
        Self {
            q,
            out,
            root,
            distance,
        }
    }
}

impl Field for BoxField {
    fn distance_gradient(&self, point: [f64; 3]) -> (f64, [f64; 3]) {
        let mut out = [[[0.0; LANES]; 4]];
        self.batch(&[point.map(|v| [v; LANES])], &mut out);
        let [d, x, y, z] = out[0];
        (d[0], [x[0], y[0], z[0]])
    }
    fn batch(&self, points: &[[Lanes; 3]], out: &mut [[Lanes; 4]]) {
        struct Run<'a>(&'a BoxField, &'a [[Lanes; 3]], &'a mut [[Lanes; 4]]);
        impl Kernel for Run<'_> {
            type Output = ();
            #[inline(always)]
            fn run<V: Vector>(self) {
                let Self(field, points, out) = self;
                let mut all = [V::zero(); REMEMBERED];
                for (p, out) in points.iter().zip(out) {
                    let at = [V::load(&p[0]), V::load(&p[1]), V::load(&p[2])];
                    let found = field.group(at, &mut all);
                    for i in 0..4 {
                        found[i].store(&mut out[i]);
                    }
                }
            }
        }
        dispatch(Run(self, points, out));
    }
}

/// Distances at the centres of voxels, trilinear in between. Outside the grid the distance is that of the nearest point of
/// the grid less the way to it: a lower bound for any distance field, whose gradient leads back inside.
#[derive(Clone, Debug, PartialEq)]
pub struct GridField {
    /// Centre of the first voxel, m.
    low: [f64; 3],
    cell: f64,
    size: [usize; 3],
    /// x fastest.
    distances: Vec<f32>,
}

impl GridField {
    /// A grid whose first voxel is centred at `low` (m), with voxels of `cell` m, `size` of them along x, y and z, and their
    /// distances (m) with x fastest.
    ///
    /// # Errors
    /// [`Error::Param`] for a cell that is not positive, [`Error::TooShort`] for fewer distances than voxels or fewer than two
    /// voxels along an axis, [`Error::NotFinite`] for a distance that is not finite.
    pub fn new(
        low: [f64; 3],
        cell: f64,
        size: [usize; 3],
        distances: Vec<f32>,
    ) -> Result<Self, Error> {
        positive("cell", cell)?;
        if let Some(&given) = size.iter().find(|&&n| n < 2) {
            return Err(Error::TooShort {
                what: "side of the distance grid",
                given,
                needed: 2,
            });
        }
        let needed = size.iter().product();
        if distances.len() != needed {
            return Err(Error::TooShort {
                what: "distance grid",
                given: distances.len(),
                needed,
            });
        }
        if let Some(entry) = distances.iter().position(|d| !d.is_finite()) {
            return Err(Error::NotFinite {
                what: "distance grid",
                knot: 0,
                entry,
            });
        }
        Ok(Self {
            low,
            cell,
            size,
            distances,
        })
    }
}

impl GridField {
    /// How much the interpolated distance may exceed the true one, m, at points at least `radius` from the surface, if the
    /// voxels' own distances are exact: the second derivatives of a distance add up to at most two over the distance, and
    /// linear interpolation over a cell exceeds a convex function by at most an eighth of the cell's square times them. Half a
    /// cell at most. The margin that a guard needs for a sphere of this radius.
    pub fn excess(&self, radius: f64) -> f64 {
        // The nearest corner of a cell may be this much nearer.
        let nearest = radius - 0.5 * 3f64.sqrt() * self.cell;
        if nearest > 0.0 {
            (0.25 * self.cell * self.cell / nearest).min(0.5 * self.cell)
        } else {
            0.5 * self.cell
        }
    }
}

impl Field for GridField {
    #[inline]
    fn distance_gradient(&self, point: [f64; 3]) -> (f64, [f64; 3]) {
        let mut index = [0usize; 3];
        let mut part = [0.0; 3];
        let mut beyond = [0.0; 3];
        for a in 0..3 {
            let t = (point[a] - self.low[a]) / self.cell;
            let top = (self.size[a] - 1) as f64;
            let inside = t.clamp(0.0, top);
            beyond[a] = (t - inside) * self.cell;
            // NaN becomes cell 0 and stays in the part.
            index[a] = (inside as usize).min(self.size[a] - 2);
            part[a] = inside - index[a] as f64;
        }
        let (sy, sz) = (self.size[0], self.size[0] * self.size[1]);
        let first = index[0] + index[1] * sy + index[2] * sz;
        let at = |offset: usize| f64::from(self.distances[first + offset]);
        let [x, y, z] = part;
        let row = |offset: usize| {
            let (a, b) = (at(offset), at(offset + 1));
            (a + (b - a) * x, b - a)
        };
        let ((v00, d00), (v10, d10)) = (row(0), row(sy));
        let ((v01, d01), (v11, d11)) = (row(sz), row(sz + sy));
        let (v0, v1) = (v00 + (v10 - v00) * y, v01 + (v11 - v01) * y);
        let (x0, x1) = (d00 + (d10 - d00) * y, d01 + (d11 - d01) * y);
        let (y0, y1) = (v10 - v00, v11 - v01);
        let mut value = v0 + (v1 - v0) * z;
        let mut gradient = [x0 + (x1 - x0) * z, y0 + (y1 - y0) * z, v1 - v0];
        for (a, slope) in gradient.iter_mut().enumerate() {
            *slope = if beyond[a] == 0.0 {
                *slope / self.cell
            } else {
                0.0
            };
        }
        if beyond.iter().any(|&v| v != 0.0) {
            let way = beyond.iter().map(|v| v * v).sum::<f64>().sqrt();
            value -= way;
            for a in 0..3 {
                gradient[a] -= beyond[a] / way;
            }
        }
        (value, gradient)
    }
}
