//! Inequality constraints `z(x, u) > 0` and what their barriers add to a horizon's objective.

use crate::barrier::Barrier;
use crate::cost::Expansion;
use crate::error::Error;
use nalgebra::SVector;

/// A group of inequality constraints.
///
/// Laws: [`rows`](Self::rows) visits the values of [`values`](Self::values) with their gradients, except that those beyond the
/// barrier's cut-off may be left out by either. At the last knot, and wherever only states are asked for, `u` is `None` and
/// input constraints are silent. [`penalize`](Self::penalize) agrees with the sum over the rows.
/// [`check_constraint`](crate::check_constraint) tests the gradients.
pub trait Constraint<const NX: usize, const NU: usize> {
    /// Name in reports.
    fn name(&self) -> &'static str;
    /// Barrier of every constraint of the group.
    fn barrier(&self) -> Barrier;
    /// Checks the group before a solve; by default its barrier.
    ///
    /// # Errors
    /// What is wrong with it.
    fn validate(&self) -> Result<(), Error> {
        self.barrier().validate()
    }
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
    /// The barriers along a whole horizon: their sum, and their Gauss-Newton models added to `models` (one per state) if
    /// given. The default goes through [`rows`](Self::rows) knot by knot; groups that can do many knots at once override it.
    ///
    /// The first state is given, so there only constraints that depend on the input count.
    fn penalize(
        &self,
        along: &Horizon<'_, NX, NU>,
        models: Option<&mut [Expansion<NX, NU>]>,
    ) -> Penalty {
        knot_by_knot(self, along, models)
    }
}

/// States, inputs and the weight of their barriers.
#[derive(Clone, Copy, Debug)]
pub struct Horizon<'a, const NX: usize, const NU: usize> {
    /// One more than inputs.
    pub states: &'a [SVector<f64, NX>],
    /// Inputs between the states.
    pub inputs: &'a [SVector<f64, NU>],
    /// Weight of every barrier: the time between knots, since barriers are integrals, s.
    pub weight: f64,
}

/// What the barriers of a group come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penalty {
    /// Weighted sum of the barriers.
    pub sum: f64,
    /// Least z; where all lie beyond a cut-off it may be infinite.
    pub least: f64,
}

fn knot_by_knot<const NX: usize, const NU: usize>(
    constraint: &(impl Constraint<NX, NU> + ?Sized),
    along: &Horizon<'_, NX, NU>,
    mut models: Option<&mut [Expansion<NX, NU>]>,
) -> Penalty {
    let barrier = constraint.barrier();
    let mut sum = 0.0;
    let mut least = f64::INFINITY;
    for (k, x) in along.states.iter().enumerate() {
        let u = along.inputs.get(k);
        if k > 0 && models.is_none() {
            constraint.values(k, x, u, &mut |z| {
                sum += barrier.value(z);
                least = least.min(z);
            });
            continue;
        }
        constraint.rows(k, x, u, &mut |z, zx, zu| {
            if k == 0 && zu.iter().all(|&v| v == 0.0) {
                return;
            }
            let (value, slope, curvature) = barrier.eval(z);
            sum += value;
            least = least.min(z);
            if let Some(models) = &mut models {
                let (slope, curvature) = (along.weight * slope, along.weight * curvature);
                add_row(&mut models[k], k, slope, curvature, zx, zu);
            }
        });
    }
    Penalty {
        sum: along.weight * sum,
        least,
    }
}

/// Adds the Gauss-Newton model of one barrier term: `slope` and `curvature` times the constraint's gradient.
fn add_row<const NX: usize, const NU: usize>(
    model: &mut Expansion<NX, NU>,
    k: usize,
    slope: f64,
    curvature: f64,
    zx: &SVector<f64, NX>,
    zu: &SVector<f64, NU>,
) {
    if slope == 0.0 && curvature == 0.0 {
        return;
    }
    // The first state is given, so state rows there say nothing.
    if k > 0 {
        for j in 0..NX {
            if zx[j] != 0.0 {
                model.x[j] += slope * zx[j];
                let c = curvature * zx[j];
                for i in 0..NX {
                    model.xx[(i, j)] += c * zx[i];
                }
            }
        }
    }
    for j in 0..NU {
        if zu[j] != 0.0 {
            model.u[j] += slope * zu[j];
            for i in 0..NU {
                model.uu[(i, j)] += curvature * zu[i] * zu[j];
            }
            if k > 0 {
                for i in 0..NX {
                    model.ux[(j, i)] += curvature * zu[j] * zx[i];
                }
            }
        }
    }
}
