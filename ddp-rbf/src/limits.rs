//! Boxes on inputs and states, and half-spaces.

use crate::barrier::{Barrier, Sum};
use crate::constraint::{Constraint, Horizon, Penalty};
use crate::cost::Expansion;
use crate::error::Error;
use crate::simd::{Kernel, LANES, Lanes, Vector, dispatch};
use nalgebra::SVector;

/// Lower and upper limits of the inputs, optionally narrowed to what is reachable from the present input at a limited
/// acceleration.
#[derive(Clone, Debug, PartialEq)]
pub struct InputBox<const NU: usize> {
    low: SVector<f64, NU>,
    high: SVector<f64, NU>,
    barrier: Barrier,
    /// Present input and largest change per knot.
    cone: Option<(SVector<f64, NU>, SVector<f64, NU>)>,
}

impl<const NU: usize> InputBox<NU> {
    /// `low < u < high` at every knot.
    pub fn new(low: SVector<f64, NU>, high: SVector<f64, NU>, barrier: Barrier) -> Self {
        Self {
            low,
            high,
            barrier,
            cone: None,
        }
    }

    /// Also `|u_k - now| < change (k + 1)`: with `change` = acceleration times dt, what limited acceleration can reach.
    #[must_use]
    pub fn reachable_from(mut self, now: SVector<f64, NU>, change: SVector<f64, NU>) -> Self {
        self.cone = Some((now, change));
        self
    }

    /// Limits of input `i` at knot `k`.
    #[inline]
    pub fn limits(&self, k: usize, i: usize) -> (f64, f64) {
        let (mut low, mut high) = (self.low[i], self.high[i]);
        if let Some((now, change)) = &self.cone {
            let room = change[i] * (k + 1) as f64;
            low = low.max(now[i] - room);
            high = high.min(now[i] + room);
        }
        (low, high)
    }
}

impl<const NX: usize, const NU: usize> Constraint<NX, NU> for InputBox<NU> {
    fn name(&self) -> &'static str {
        "input limits"
    }
    fn barrier(&self) -> Barrier {
        self.barrier
    }
    fn values(
        &self,
        k: usize,
        _: &SVector<f64, NX>,
        u: Option<&SVector<f64, NU>>,
        visit: &mut dyn FnMut(f64),
    ) {
        let Some(u) = u else { return };
        for i in 0..NU {
            let (low, high) = self.limits(k, i);
            visit(u[i] - low);
            visit(high - u[i]);
        }
    }
    fn rows(
        &self,
        k: usize,
        _: &SVector<f64, NX>,
        u: Option<&SVector<f64, NU>>,
        visit: &mut dyn FnMut(f64, &SVector<f64, NX>, &SVector<f64, NU>),
    ) {
        let Some(u) = u else { return };
        let none = SVector::zeros();
        let mut row = SVector::zeros();
        for i in 0..NU {
            let (low, high) = self.limits(k, i);
            row[i] = 1.0;
            visit(u[i] - low, &none, &row);
            row[i] = -1.0;
            visit(high - u[i], &none, &row);
            row[i] = 0.0;
        }
    }
    fn penalize(
        &self,
        along: &Horizon<'_, NX, NU>,
        mut models: Option<&mut [Expansion<NX, NU>]>,
    ) -> Penalty {
        dispatch(Sides {
            barrier: &self.barrier,
            weight: along.weight,
            count: NU,
            knots: along.inputs.len(),
            at: |k: usize, i: usize| {
                let (low, high) = self.limits(k, i);
                (along.inputs[k][i], low, high)
            },
            add: |k: usize, i: usize, slope: f64, curvature: f64| {
                if let Some(models) = &mut models {
                    models[k].u[i] += slope;
                    models[k].uu[(i, i)] += curvature;
                }
            },
        })
    }
}

/// Two-sided limits on single variables, many at a time.
struct Sides<'a, A, B> {
    barrier: &'a Barrier,
    weight: f64,
    /// Variables per knot.
    count: usize,
    knots: usize,
    /// Value, low and high of a variable at a knot.
    at: A,
    /// Takes slope and curvature of a variable at a knot.
    add: B,
}

impl<A, B> Kernel for Sides<'_, A, B>
where
    A: Fn(usize, usize) -> (f64, f64, f64),
    B: FnMut(usize, usize, f64, f64),
{
    type Output = Penalty;
    #[inline(always)]
    fn run<V: Vector>(self) -> Penalty {
        let Self {
            barrier,
            weight,
            count,
            knots,
            at,
            mut add,
        } = self;
        let mut sum: Sum<V> = Sum::new(barrier, weight);
        let (mut extra, mut least) = (0.0, f64::INFINITY);
        // Through all knots without a break, so that few variables fill vectors too.
        let whole = knots * count / LANES * LANES;
        let (mut k, mut i) = (0, 0);
        for _ in 0..whole / LANES {
            let (mut value, mut low, mut high) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            let (from_k, from_i) = (k, i);
            for lane in 0..LANES {
                (value[lane], low[lane], high[lane]) = at(k, i);
                next(&mut k, &mut i, count);
            }
            let value = V::load(&value);
            let (below, bend) = sum.add(value - V::load(&low));
            let (above, bow) = sum.add(V::load(&high) - value);
            let (slope, curvature) = ((below - above).array(), (bend + bow).array());
            (k, i) = (from_k, from_i);
            for lane in 0..LANES {
                add(k, i, slope[lane], curvature[lane]);
                next(&mut k, &mut i, count);
            }
        }
        // What does not fill a vector.
        for _ in whole..knots * count {
            let (value, low, high) = at(k, i);
            let (a, below, bend) = barrier.eval(value - low);
            let (b, above, bow) = barrier.eval(high - value);
            extra += a + b;
            least = least.min(value - low).min(high - value);
            add(k, i, weight * (below - above), weight * (bend + bow));
            next(&mut k, &mut i, count);
        }
        let (value, lowest) = sum.finish();
        let lanes: Lanes = value.array();
        Penalty {
            sum: lanes.iter().sum::<f64>() + weight * extra,
            least: lowest.array().into_iter().fold(least, f64::min),
        }
    }
}

/// The next of `count` variables, then the next knot.
#[inline(always)]
fn next(k: &mut usize, i: &mut usize, count: usize) {
    *i += 1;
    if *i == count {
        (*k, *i) = (*k + 1, 0);
    }
}

/// Lower and upper limits of some states: joints, or velocities where they are states.
#[derive(Clone, Debug, PartialEq)]
pub struct StateBox {
    /// (index of the state, low, high).
    pub limits: Vec<(usize, f64, f64)>,
    /// Barrier of each side.
    pub barrier: Barrier,
}

impl<const NX: usize, const NU: usize> Constraint<NX, NU> for StateBox {
    fn name(&self) -> &'static str {
        "state limits"
    }
    fn barrier(&self) -> Barrier {
        self.barrier
    }
    fn values(
        &self,
        _: usize,
        x: &SVector<f64, NX>,
        _: Option<&SVector<f64, NU>>,
        visit: &mut dyn FnMut(f64),
    ) {
        for &(i, low, high) in &self.limits {
            visit(x[i] - low);
            visit(high - x[i]);
        }
    }
    fn rows(
        &self,
        _: usize,
        x: &SVector<f64, NX>,
        _: Option<&SVector<f64, NU>>,
        visit: &mut dyn FnMut(f64, &SVector<f64, NX>, &SVector<f64, NU>),
    ) {
        let none = SVector::zeros();
        let mut row = SVector::zeros();
        for &(i, low, high) in &self.limits {
            row[i] = 1.0;
            visit(x[i] - low, &row, &none);
            row[i] = -1.0;
            visit(high - x[i], &row, &none);
            row[i] = 0.0;
        }
    }
    fn penalize(
        &self,
        along: &Horizon<'_, NX, NU>,
        mut models: Option<&mut [Expansion<NX, NU>]>,
    ) -> Penalty {
        let limits = &self.limits;
        dispatch(Sides {
            barrier: &self.barrier,
            weight: along.weight,
            count: limits.len(),
            knots: along.inputs.len(),
            // The first state is given.
            at: |k: usize, i: usize| {
                let (state, low, high) = limits[i];
                (along.states[k + 1][state], low, high)
            },
            add: |k: usize, i: usize, slope: f64, curvature: f64| {
                if let Some(models) = &mut models {
                    let state = limits[i].0;
                    models[k + 1].x[state] += slope;
                    models[k + 1].xx[(state, state)] += curvature;
                }
            },
        })
    }
}

/// Half-spaces of states and inputs: `state . x + input . u + offset > 0`.
#[derive(Clone, Debug, PartialEq)]
pub struct HalfSpaces<const NX: usize, const NU: usize> {
    planes: Vec<(SVector<f64, NX>, SVector<f64, NU>, f64)>,
    barrier: Barrier,
}

impl<const NX: usize, const NU: usize> HalfSpaces<NX, NU> {
    /// Each as its normals by state and by input, and its offset. A half-space whose input normal is zero binds the states
    /// after the first; one that names an input binds the knots that have one.
    ///
    /// # Errors
    /// [`Error::NotFinite`] with the number of the half-space.
    pub fn new(
        planes: Vec<(SVector<f64, NX>, SVector<f64, NU>, f64)>,
        barrier: Barrier,
    ) -> Result<Self, Error> {
        for (knot, (x, u, offset)) in planes.iter().enumerate() {
            let mut all = x.iter().chain(u.iter()).chain([offset]);
            if let Some(entry) = all.position(|v| !v.is_finite()) {
                return Err(Error::NotFinite {
                    what: "half-space",
                    knot,
                    entry,
                });
            }
        }
        Ok(Self { planes, barrier })
    }
}

impl<const NX: usize, const NU: usize> Constraint<NX, NU> for HalfSpaces<NX, NU> {
    fn name(&self) -> &'static str {
        "half-spaces"
    }
    fn barrier(&self) -> Barrier {
        self.barrier
    }
    fn values(
        &self,
        k: usize,
        x: &SVector<f64, NX>,
        u: Option<&SVector<f64, NU>>,
        visit: &mut dyn FnMut(f64),
    ) {
        self.rows(k, x, u, &mut |z, _, _| visit(z));
    }
    fn rows(
        &self,
        _: usize,
        x: &SVector<f64, NX>,
        u: Option<&SVector<f64, NU>>,
        visit: &mut dyn FnMut(f64, &SVector<f64, NX>, &SVector<f64, NU>),
    ) {
        for (zx, zu, offset) in &self.planes {
            let by_input = match u {
                Some(u) => zu.dot(u),
                None if zu.iter().all(|&v| v == 0.0) => 0.0,
                None => continue,
            };
            visit(zx.dot(x) + by_input + offset, zx, zu);
        }
    }
}
