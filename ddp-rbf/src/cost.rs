//! Stage and terminal costs and their quadratic models.

use nalgebra::{SMatrix, SVector};

/// A quadratic model around a point, added to by costs and barriers.
#[derive(Clone, Debug, PartialEq)]
pub struct Expansion<const NX: usize, const NU: usize> {
    /// Gradient by state.
    pub x: SVector<f64, NX>,
    /// Gradient by input.
    pub u: SVector<f64, NU>,
    /// Hessian by state; positive semidefinite.
    pub xx: SMatrix<f64, NX, NX>,
    /// Hessian by input; positive definite after all costs are added.
    pub uu: SMatrix<f64, NU, NU>,
    /// Mixed second derivatives, input by state.
    pub ux: SMatrix<f64, NU, NX>,
}

impl<const NX: usize, const NU: usize> Expansion<NX, NU> {
    /// All zero.
    pub fn zeros() -> Self {
        Self {
            x: SVector::zeros(),
            u: SVector::zeros(),
            xx: SMatrix::zeros(),
            uu: SMatrix::zeros(),
            ux: SMatrix::zeros(),
        }
    }

    /// Makes everything zero in place; mixed derivatives only if `coupled`, otherwise they must be zero already.
    #[inline]
    pub(crate) fn clear(&mut self, coupled: bool) {
        self.x.as_mut_slice().fill(0.0);
        self.u.as_mut_slice().fill(0.0);
        self.xx.as_mut_slice().fill(0.0);
        self.uu.as_mut_slice().fill(0.0);
        if coupled {
            self.ux.as_mut_slice().fill(0.0);
        }
    }
}

/// A cost over a horizon of knots `0..=n`; inputs act on `0..n`.
pub trait CostModel<const NX: usize, const NU: usize> {
    /// Cost of knot `k` with its input.
    fn stage(&self, k: usize, x: &SVector<f64, NX>, u: &SVector<f64, NU>) -> f64;
    /// Cost of the last knot.
    fn terminal(&self, x: &SVector<f64, NX>) -> f64;
    /// Adds the quadratic model of [`stage`](Self::stage).
    fn expand_stage(
        &self,
        k: usize,
        x: &SVector<f64, NX>,
        u: &SVector<f64, NU>,
        into: &mut Expansion<NX, NU>,
    );
    /// Adds the quadratic model of [`terminal`](Self::terminal).
    fn expand_terminal(&self, x: &SVector<f64, NX>, into: &mut Expansion<NX, NU>);
    /// Knots for which there is a reference; the solver refuses horizons beyond it.
    fn knots(&self) -> usize {
        usize::MAX
    }
}

/// Weighted squares of the distance to a reference: the tracking cost L and phi of HEATS eq. 6.
#[derive(Clone, Debug, PartialEq)]
pub struct Tracking<const NX: usize, const NU: usize> {
    /// Reference states, one per knot, the last included.
    pub states: Vec<SVector<f64, NX>>,
    /// Reference inputs, one per knot but the last.
    pub inputs: Vec<SVector<f64, NU>>,
    /// Time between knots, s; stage costs are integrals.
    pub dt: f64,
    /// Weights of the state.
    pub state_weight: SVector<f64, NX>,
    /// Weights of the input.
    pub input_weight: SVector<f64, NU>,
    /// Weights of the last state.
    pub terminal_weight: SVector<f64, NX>,
}

impl<const NX: usize, const NU: usize> Tracking<NX, NU> {
    /// All fields in order.
    pub fn new(
        states: Vec<SVector<f64, NX>>,
        inputs: Vec<SVector<f64, NU>>,
        dt: f64,
        state_weight: SVector<f64, NX>,
        input_weight: SVector<f64, NU>,
        terminal_weight: SVector<f64, NX>,
    ) -> Self {
        Self {
            states,
            inputs,
            dt,
            state_weight,
            input_weight,
            terminal_weight,
        }
    }

    /// Makes the reference of an angle continuous and brings it to within half a turn of `near` (rad), the present angle:
    /// whole turns are added, so that a heading that wraps from pi to -pi is not tracked the long way round. For angles
    /// without end stops only; a joint with limits is where it is.
    #[must_use]
    pub fn unwrapped(mut self, index: usize, near: f64) -> Self {
        let turn = std::f64::consts::TAU;
        let mut last = near;
        for x in &mut self.states {
            if let Some(angle) = x.as_mut_slice().get_mut(index) {
                let moved = *angle + turn * ((last - *angle) / turn).round();
                if moved.is_finite() {
                    *angle = moved;
                    last = moved;
                }
            }
        }
        self
    }
}

impl<const NX: usize, const NU: usize> CostModel<NX, NU> for Tracking<NX, NU> {
    fn stage(&self, k: usize, x: &SVector<f64, NX>, u: &SVector<f64, NU>) -> f64 {
        let (dx, du) = (x - self.states[k], u - self.inputs[k]);
        0.5 * self.dt
            * (dx.component_mul(&dx).dot(&self.state_weight)
                + du.component_mul(&du).dot(&self.input_weight))
    }
    fn terminal(&self, x: &SVector<f64, NX>) -> f64 {
        let dx = self.states.last().map_or_else(SVector::zeros, |r| x - r);
        0.5 * dx.component_mul(&dx).dot(&self.terminal_weight)
    }
    fn expand_stage(
        &self,
        k: usize,
        x: &SVector<f64, NX>,
        u: &SVector<f64, NU>,
        into: &mut Expansion<NX, NU>,
    ) {
        for i in 0..NX {
            into.x[i] += self.dt * self.state_weight[i] * (x[i] - self.states[k][i]);
            into.xx[(i, i)] += self.dt * self.state_weight[i];
        }
        for i in 0..NU {
            into.u[i] += self.dt * self.input_weight[i] * (u[i] - self.inputs[k][i]);
            into.uu[(i, i)] += self.dt * self.input_weight[i];
        }
    }
    fn expand_terminal(&self, x: &SVector<f64, NX>, into: &mut Expansion<NX, NU>) {
        let Some(reference) = self.states.last() else {
            return;
        };
        for i in 0..NX {
            into.x[i] += self.terminal_weight[i] * (x[i] - reference[i]);
            into.xx[(i, i)] += self.terminal_weight[i];
        }
    }
    fn knots(&self) -> usize {
        self.states.len().saturating_sub(1).min(self.inputs.len())
    }
}
