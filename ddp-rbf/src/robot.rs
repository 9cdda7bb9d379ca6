//! What the solver must know about a robot's motion.

use crate::ode::{rk4, rk4_sensitivity};
use nalgebra::{SMatrix, SVector};

/// A robot with `NX` states and `NU` inputs.
///
/// Laws: [`jacobians`](Self::jacobians) are the derivatives of [`flow`](Self::flow), and
/// [`linearize`](Self::linearize) those of [`step`](Self::step); [`check_jacobians`](crate::check_jacobians) tests the first.
pub trait Robot<const NX: usize, const NU: usize> {
    /// Rate of change of the state, per second.
    fn flow(&self, x: &SVector<f64, NX>, u: &SVector<f64, NU>) -> SVector<f64, NX>;
    /// Derivatives of the flow by state and by input.
    fn jacobians(
        &self,
        x: &SVector<f64, NX>,
        u: &SVector<f64, NU>,
    ) -> (SMatrix<f64, NX, NX>, SMatrix<f64, NX, NU>);
    /// The state after `dt` s with the input held; one Runge-Kutta step by default.
    fn step(&self, x: &SVector<f64, NX>, u: &SVector<f64, NU>, dt: f64) -> SVector<f64, NX> {
        rk4(self, x, u, dt)
    }
    /// Derivatives of [`step`](Self::step) by state and by input.
    fn linearize(
        &self,
        x: &SVector<f64, NX>,
        u: &SVector<f64, NU>,
        dt: f64,
    ) -> (SMatrix<f64, NX, NX>, SMatrix<f64, NX, NU>) {
        rk4_sensitivity(self, x, u, dt)
    }
    /// [`linearize`](Self::linearize) along a whole horizon; a robot that can do many knots at once overrides it. `out` has
    /// one entry per input; what it holds before is arbitrary.
    fn linearize_all(
        &self,
        states: &[SVector<f64, NX>],
        inputs: &[SVector<f64, NU>],
        dt: f64,
        out: &mut [Linear<NX, NU>],
    ) {
        for ((x, u), out) in states.iter().zip(inputs).zip(out) {
            (out.a, out.b) = self.linearize(x, u, dt);
        }
    }
}

/// Derivatives of a step by state and by input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear<const NX: usize, const NU: usize> {
    /// By state.
    pub a: SMatrix<f64, NX, NX>,
    /// By input.
    pub b: SMatrix<f64, NX, NU>,
}

impl<const NX: usize, const NU: usize, R: Robot<NX, NU> + ?Sized> Robot<NX, NU> for &R {
    fn flow(&self, x: &SVector<f64, NX>, u: &SVector<f64, NU>) -> SVector<f64, NX> {
        (**self).flow(x, u)
    }
    fn jacobians(
        &self,
        x: &SVector<f64, NX>,
        u: &SVector<f64, NU>,
    ) -> (SMatrix<f64, NX, NX>, SMatrix<f64, NX, NU>) {
        (**self).jacobians(x, u)
    }
    fn step(&self, x: &SVector<f64, NX>, u: &SVector<f64, NU>, dt: f64) -> SVector<f64, NX> {
        (**self).step(x, u, dt)
    }
    fn linearize(
        &self,
        x: &SVector<f64, NX>,
        u: &SVector<f64, NU>,
        dt: f64,
    ) -> (SMatrix<f64, NX, NX>, SMatrix<f64, NX, NU>) {
        (**self).linearize(x, u, dt)
    }
    fn linearize_all(
        &self,
        states: &[SVector<f64, NX>],
        inputs: &[SVector<f64, NU>],
        dt: f64,
        out: &mut [Linear<NX, NU>],
    ) {
        (**self).linearize_all(states, inputs, dt, out);
    }
}
