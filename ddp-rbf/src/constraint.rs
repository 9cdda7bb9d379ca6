//! Inequality constraints `z(x, u) > 0`, each with its barrier.

use crate::barrier::Barrier;
use nalgebra::SVector;

/// A group of inequality constraints.
///
/// Laws: [`rows`](Self::rows) visits the same values in the same order as [`values`](Self::values), with their gradients.
/// At the last knot, and wherever only states are asked for, `u` is `None` and input constraints are silent.
pub trait Constraint<const NX: usize, const NU: usize> {
    /// Name in reports.
    fn name(&self) -> &'static str;
    /// Barrier of every constraint of the group.
    fn barrier(&self) -> Barrier;
    /// Visits each z at knot `k`.
    fn values(
        &self,
        k: usize,
        x: &SVector<f64, NX>,
        u: Option<&SVector<f64, NU>>,
        visit: &mut dyn FnMut(f64),
    );
    /// Visits each z at knot `k` with its gradients by state and by input. Constraints beyond the barrier's cut-off may be left
    /// out.
    fn rows(
        &self,
        k: usize,
        x: &SVector<f64, NX>,
        u: Option<&SVector<f64, NU>>,
        visit: &mut dyn FnMut(f64, &SVector<f64, NX>, &SVector<f64, NU>),
    );
}

/// A field of distances to obstacles.
///
/// Laws: the gradient is that of the same interpolant as the value, so that a line search is never lied to.
pub trait Field {
    /// Distance at a point (world frame, m), and its gradient.
    fn distance_gradient(&self, point: [f64; 3]) -> (f64, [f64; 3]);
    /// Distance alone.
    fn distance(&self, point: [f64; 3]) -> f64 {
        self.distance_gradient(point).0
    }
    /// Distances and gradients of many points; a field that can do better overrides it.
    fn batch(&self, points: &[[f64; 3]], out: &mut Vec<(f64, [f64; 3])>) {
        out.clear();
        out.extend(points.iter().map(|&p| self.distance_gradient(p)));
    }
}

impl<F: Field + ?Sized> Field for &F {
    fn distance_gradient(&self, point: [f64; 3]) -> (f64, [f64; 3]) {
        (**self).distance_gradient(point)
    }
    fn distance(&self, point: [f64; 3]) -> f64 {
        (**self).distance(point)
    }
    fn batch(&self, points: &[[f64; 3]], out: &mut Vec<(f64, [f64; 3])>) {
        (**self).batch(points, out);
    }
}

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
}

/// Lower and upper limits of some states.
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
}
