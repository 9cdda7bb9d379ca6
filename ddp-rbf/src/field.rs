//! Distance fields: the trait, and two ready-made ones: boxes and a voxel grid.

use crate::elementary::{exp, floor, ln};
use crate::error::{Error, positive};
use crate::simd::{Kernel, LANES, Lanes, Portable, Vector, dispatch};

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

/// A box this much (times 1 / beta) farther than the nearest has no part in the soft minimum: exp(-32) / beta is below the
/// rounding of a distance of a metre.
const SOFT_REACH: f64 = 32.0;
/// Boxes whose distance is remembered from the first look; those after them are measured again.
const REMEMBERED: usize = 32;

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

    /// Distance and gradient at many points; `squares` is room for the first boxes.
    #[inline(always)]
    fn group<V: Vector>(&self, point: [V; 3], squares: &mut [V; REMEMBERED]) -> [V; 4] {
        let (zero, one) = (V::zero(), V::splat(1.0));
        // First the least, squared, so that only boxes near it cost a root, an exponential and a gradient.
        let mut least = V::splat(f64::MAX);
        for (i, b) in self.boxes.iter().enumerate() {
            let square = ToBox::new(b, &point).square;
            if i < squares.len() {
                squares[i] = square;
            }
            least = square.min(least);
        }
        let floor = self.floor.map(|h| point[2] - V::splat(h));
        let inside = !V::splat(SMOOTH).all_less(least);
        least = least.sqrt();
        if inside {
            // Some point may lie within boxes, where the depth counts.
            for b in &self.boxes {
                let ToBox { q, square, .. } = ToBox::new(b, &point);
                least = (square.sqrt() + depth(&q)).min(least);
            }
        }
        if let Some(height) = floor {
            least = height.min(least);
        }
        let beta = V::splat(self.beta);
        let reach = least + V::splat(SOFT_REACH / self.beta);
        // A box that holds the point is never far.
        let far = reach.max(zero);
        let far = far.mul_add(far, V::splat(2.0 * SMOOTH));
        // Listed first: a jump per box would often be foretold wrong.
        let mut near = [0; REMEMBERED];
        let mut count = 0;
        let first = self.boxes.len().min(REMEMBERED);
        for i in 0..first {
            near[count] = i;
            count += usize::from(!far.all_less(squares[i]));
        }
        let low = floor.filter(|height| !reach.all_less(*height));
        let others = self.boxes.len() - first;
        if (count, others, low.is_none()) == (1, 0, true) {
            // Nothing but one box: the soft minimum is its distance.
            let (distance, slopes) = ToBox::new(&self.boxes[near[0]], &point).slopes(inside);
            return [distance, slopes[0], slopes[1], slopes[2]];
        }
        let mut sum = zero;
        let mut gradient = [zero; 3];
        for k in 0..count + others {
            let b = &self.boxes[if k < count {
                near[k]
            } else {
                first + k - count
            }];
            let (distance, slopes) = ToBox::new(b, &point).slopes(inside);
            let weight = reach.if_less(distance, zero, exp((least - distance) * beta));
            sum = sum + weight;
            for a in 0..3 {
                gradient[a] = weight.mul_add(slopes[a], gradient[a]);
            }
        }
        if let Some(height) = low {
            let weight = exp((least - height) * beta);
            sum = sum + weight;
            gradient[2] = gradient[2] + weight;
        }
        let inverse = one / sum;
        [
            ln(sum).neg_mul_add(V::splat(1.0 / self.beta), least),
            gradient[0] * inverse,
            gradient[1] * inverse,
            gradient[2] * inverse,
        ]
    }
}

/// Added under the root of a distance, m^2, so that it has a slope everywhere.
const SMOOTH: f64 = 1e-12;

/// Where a point lies to a box.
struct ToBox<V> {
    /// From the box's centre.
    from: [V; 3],
    /// Distance beyond the faces along each axis, negative within.
    q: [V; 3],
    /// The same, zero within.
    out: [V; 3],
    /// Square of the smoothed length of `out`.
    square: V,
}

impl<V: Vector> ToBox<V> {
    #[inline(always)]
    fn new(b: &[f64; 6], point: &[V; 3]) -> Self {
        let zero = V::zero();
        let mut from = [zero; 3];
        let mut q = [zero; 3];
        let mut out = [zero; 3];
        let mut square = V::splat(SMOOTH);
        for a in 0..3 {
            from[a] = point[a] - V::splat(b[a]);
            q[a] = from[a].abs() - V::splat(b[3 + a]);
            out[a] = q[a].max(zero);
            square = out[a].mul_add(out[a], square);
        }
        Self {
            from,
            q,
            out,
            square,
        }
    }

    /// Distance and its gradient; `inside` if some point may lie within the box.
    #[inline(always)]
    fn slopes(&self, inside: bool) -> (V, [V; 3]) {
        let (zero, one) = (V::zero(), V::splat(1.0));
        let Self {
            from,
            q,
            out,
            square,
        } = self;
        let inverse = square.inverse_sqrt();
        let mut distance = *square * inverse;
        let mut slopes = [out[0] * inverse, out[1] * inverse, out[2] * inverse];
        if inside {
            // Within the slope is along the nearest face.
            distance = distance + depth(q);
            let top = q[0].max(q[1]).max(q[2]);
            let mut open = top.if_less(zero, one, zero);
            for a in 0..3 {
                let nearest = q[a].if_less(top, zero, open);
                open = open - nearest;
                slopes[a] = slopes[a] + nearest;
            }
        }
        for a in 0..3 {
            slopes[a] = slopes[a].with_sign_of(from[a]);
        }
        (distance, slopes)
    }
}

/// Depth of a point within a box, negative; zero outside.
#[inline(always)]
fn depth<V: Vector>(q: &[V; 3]) -> V {
    q[0].max(q[1]).max(q[2]).min(V::zero())
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
                let mut squares = [V::zero(); REMEMBERED];
                for (p, out) in points.iter().zip(out) {
                    let at = [V::load(&p[0]), V::load(&p[1]), V::load(&p[2])];
                    let found = field.group(at, &mut squares);
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
    fn distance_gradient(&self, point: [f64; 3]) -> (f64, [f64; 3]) {
        let [d, x, y, z] = self.group(point.map(Portable::<1>::splat));
        let [d, x, y, z] = [d, x, y, z].map(|v| v.array()[0]);
        (d, [x, y, z])
    }
    fn batch(&self, points: &[[Lanes; 3]], out: &mut [[Lanes; 4]]) {
        struct Run<'a>(&'a GridField, &'a [[Lanes; 3]], &'a mut [[Lanes; 4]]);
        impl Kernel for Run<'_> {
            type Output = ();
            #[inline(always)]
            fn run<V: Vector>(self) {
                let Self(field, points, out) = self;
                for (p, out) in points.iter().zip(out) {
                    let found = field.group([V::load(&p[0]), V::load(&p[1]), V::load(&p[2])]);
                    for i in 0..4 {
                        found[i].store(&mut out[i]);
                    }
                }
            }
        }
        dispatch(Run(self, points, out));
    }
}

impl GridField {
    /// Distance and gradient at as many points as there are lanes.
    #[inline(always)]
    fn group<const L: usize, V: Vector<L>>(&self, point: [V; 3]) -> [V; 4] {
        let (zero, one) = (V::zero(), V::splat(1.0));
        let (cell, per_cell) = (V::splat(self.cell), V::splat(1.0 / self.cell));
        let mut first = zero;
        let mut part = [zero; 3];
        let mut beyond = [zero; 3];
        let mut away = zero;
        // Addresses are whole numbers below 2^53, exact.
        let mut stride = 1.0;
        for a in 0..3 {
            let t = (point[a] - V::splat(self.low[a])) * per_cell;
            // What is not a number stays so in the part, not in the index.
            let inside = t.max(zero).min(V::splat((self.size[a] - 1) as f64));
            beyond[a] = (t - inside) * cell;
            away = beyond[a].mul_add(beyond[a], away);
            let whole = V::splat((self.size[a] - 2) as f64).min(floor(inside));
            part[a] = inside - whole;
            first = whole.mul_add(V::splat(stride), first);
            stride *= self.size[a] as f64;
        }
        let corners = self.corners(first);
        // Along x, then y, then z; differences are the slopes.
        let [x, y, z] = part;
        let mut values = [zero; 4];
        let mut slopes = [zero; 4];
        for k in 0..4 {
            let a = corners[2 * k];
            slopes[k] = corners[2 * k + 1] - a;
            values[k] = slopes[k].mul_add(x, a);
        }
        let (y0, y1) = (values[1] - values[0], values[3] - values[2]);
        let (v0, v1) = (y0.mul_add(y, values[0]), y1.mul_add(y, values[2]));
        let x0 = (slopes[1] - slopes[0]).mul_add(y, slopes[0]);
        let x1 = (slopes[3] - slopes[2]).mul_add(y, slopes[2]);
        let mut value = (v1 - v0).mul_add(z, v0);
        let mut gradient = [
            (x1 - x0).mul_add(z, x0) * per_cell,
            (y1 - y0).mul_add(z, y0) * per_cell,
            (v1 - v0) * per_cell,
        ];
        if !away.all_less(V::splat(f64::MIN_POSITIVE)) {
            let way = away.sqrt();
            let inverse = one / way.max(V::splat(f64::MIN_POSITIVE));
            value = value - way;
            for a in 0..3 {
                let out = V::zero().if_less(beyond[a].abs(), zero, gradient[a]);
                gradient[a] = (beyond[a] * inverse).neg_mul_add(one, out);
            }
        }
        [value, gradient[0], gradient[1], gradient[2]]
    }

    /// Distances at the corners of cells, x fastest; `first` is the address of each cell's first corner.
    #[inline(always)]
    fn corners<const L: usize, V: Vector<L>>(&self, first: V) -> [V; CORNERS] {
        let first = first.array();
        let (sy, sz) = (self.size[0], self.size[0] * self.size[1]);
        let mut columns = [V::zero(); CORNERS];
        if L == CORNERS {
            // A row per cell, turned in registers: gathered through memory, loads would wait for eight narrow stores.
            let mut rows = [V::zero(); L];
            for lane in 0..L {
                let cell = self.cell(first[lane] as usize, sy, sz);
                let mut row = [0.0; L];
                for k in 0..L {
                    row[k] = f64::from(cell[k]);
                }
                rows[lane] = V::load(&row);
            }
            columns[..L].copy_from_slice(&V::transpose(rows));
            return columns;
        }
        for k in 0..CORNERS {
            let mut column = [0.0; L];
            for lane in 0..L {
                column[lane] = f64::from(self.cell(first[lane] as usize, sy, sz)[k]);
            }
            columns[k] = V::load(&column);
        }
        columns
    }

    /// Distances at the corners of one cell.
    #[inline(always)]
    fn cell(&self, first: usize, sy: usize, sz: usize) -> [f32; CORNERS] {
        let mut out = [0.0; CORNERS];
        for (out, offset) in out.chunks_exact_mut(2).zip([0, sy, sz, sz + sy]) {
            if let Some(pair) = self.distances[first + offset..].first_chunk::<2>() {
                out.copy_from_slice(pair);
            }
        }
        out
    }
}

/// Corners of a cell.
const CORNERS: usize = 8;
