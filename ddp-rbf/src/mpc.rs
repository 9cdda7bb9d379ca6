//! Receding horizon: the solver kept warm from control step to control step.

use crate::constraint::Constraint;
use crate::cost::{CostModel, Tracking};
use crate::error::Error;
use crate::robot::Robot;
use crate::solver::{Options, Report, Solver};
use nalgebra::{SMatrix, SVector};

/// A model predictive controller over a fixed horizon.
#[derive(Clone, Debug)]
pub struct Mpc<const NX: usize, const NU: usize> {
    solver: Solver<NX, NU>,
    warm: bool,
}

impl<const NX: usize, const NU: usize> Mpc<NX, NU> {
    /// A horizon of `knots` steps of `dt` s.
    ///
    /// # Errors
    /// As [`Solver::new`].
    pub fn new(knots: usize, dt: f64) -> Result<Self, Error> {
        Ok(Self {
            solver: Solver::new(knots, dt)?,
            warm: false,
        })
    }

    /// Forgets the last solution: the next step starts from its reference.
    pub fn reset(&mut self) {
        self.warm = false;
    }

    /// Moves the last solution on by `seconds`: states and inputs are read between the knots, and held at the end.
    pub fn shift(&mut self, seconds: f64) {
        let steps = seconds / self.solver.dt();
        if !(steps > 0.0 && steps.is_finite()) {
            return;
        }
        let (xs, us) = self.solver.guess_mut();
        shift_by(xs, steps);
        shift_by(us, steps);
    }

    /// One control step: solves from `x0`, from the last solution, or from the reference after a [`reset`](Self::reset).
    ///
    /// # Errors
    /// As [`Solver::solve`]; the last solution then stays as it was.
    pub fn step(
        &mut self,
        robot: &(impl Robot<NX, NU> + ?Sized),
        cost: &Tracking<NX, NU>,
        constraints: &[&dyn Constraint<NX, NU>],
        x0: &SVector<f64, NX>,
        options: &Options,
    ) -> Result<Report, Error> {
        let n = self.solver.inputs().len();
        if cost.knots() < n {
            return Err(Error::TooShort {
                what: "reference",
                given: cost.knots(),
                needed: n,
            });
        }
        if !self.warm {
            self.solver.set_guess(&cost.states, &cost.inputs)?;
        }
        let report = self.solver.solve(robot, cost, constraints, x0, options)?;
        self.warm = true;
        Ok(report)
    }

    /// States of the solution.
    pub fn states(&self) -> &[SVector<f64, NX>] {
        self.solver.states()
    }

    /// Inputs of the solution.
    pub fn inputs(&self) -> &[SVector<f64, NU>] {
        self.solver.inputs()
    }

    /// Feedback gain of the first knot.
    pub fn gain(&self) -> &SMatrix<f64, NU, NX> {
        self.solver.gain()
    }

    /// Time between knots, s.
    pub fn dt(&self) -> f64 {
        self.solver.dt()
    }
}

/// Reads a sequence `steps` further on, linear between entries, held at the end.
fn shift_by<const N: usize>(values: &mut [SVector<f64, N>], steps: f64) {
    let last = values.len() - 1;
    let (whole, part) = (steps.floor() as usize, steps - steps.floor());
    for k in 0..values.len() {
        let (a, b) = (
            values[(k + whole).min(last)],
            values[(k + whole + 1).min(last)],
        );
        values[k] = a + (b - a) * part;
    }
}
