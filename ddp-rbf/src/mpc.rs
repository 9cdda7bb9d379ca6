//! Receding horizon: the solver kept warm from control step to control step.

use crate::constraint::Constraint;
use crate::cost::{CostModel, Tracking};
use crate::error::Error;
use crate::robot::Robot;
use crate::solver::{Group, Options, Report, Solver, Status};
use nalgebra::{SMatrix, SVector};

/// A model predictive controller over a fixed horizon.
#[derive(Clone, Debug)]
pub struct Mpc<const NX: usize, const NU: usize> {
    solver: Solver<NX, NU>,
    warm: bool,
    /// Knots at the end that the last shift left without a plan.
    unplanned: usize,
    statistics: Statistics,
    /// Solution of the first of two starts.
    spare: (Vec<SVector<f64, NX>>, Vec<SVector<f64, NU>>),
}

/// What the controller did since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Control steps.
    pub steps: usize,
    /// Iterations of all steps.
    pub iterations: usize,
    /// Steps that ended for want of time.
    pub out_of_time: usize,
    /// Steps whose search found nothing better.
    pub stalled: usize,
    /// Steps whose plan violates some constraint.
    pub violated: usize,
    /// Least z of any constraint in any plan; infinite before the first step.
    pub least: f64,
    /// Most regularisation that was left at the end of a step.
    pub regularization: f64,
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
            unplanned: 0,
            statistics: Statistics {
                least: f64::INFINITY,
                ..Statistics::default()
            },
            spare: (
                vec![SVector::zeros(); knots + 1],
                vec![SVector::zeros(); knots],
            ),
        })
    }

    /// Forgets the last solution: the next step starts from its reference.
    pub fn reset(&mut self) {
        self.warm = false;
        self.unplanned = 0;
    }

    /// Moves the last solution on by `seconds`: states and inputs are read between the knots. Past the end states are held and
    /// the next [`step`](Self::step) takes its inputs from the reference.
    pub fn shift(&mut self, seconds: f64) {
        let steps = seconds / self.solver.dt();
        if !(steps > 0.0 && steps.is_finite()) {
            return;
        }
        let (xs, us) = self.solver.guess_mut();
        shift_by(xs, steps);
        shift_by(us, steps);
        let n = us.len();
        // Rounding must not count a knot that is still covered.
        self.unplanned = (self.unplanned + (steps - 1e-6).ceil() as usize).min(n);
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
        self.step_until(robot, cost, constraints, x0, options, &mut || false)
    }

    /// [`step`](Self::step) with a limit of time: `out_of_time` is asked before every iteration after the first.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn step_until(
        &mut self,
        robot: &(impl Robot<NX, NU> + ?Sized),
        cost: &Tracking<NX, NU>,
        constraints: &[&dyn Constraint<NX, NU>],
        x0: &SVector<f64, NX>,
        options: &Options,
        out_of_time: &mut dyn FnMut() -> bool,
    ) -> Result<Report, Error> {
        self.guess(robot, cost)?;
        let report = self
            .solver
            .solve_until(robot, cost, constraints, x0, options, out_of_time)?;
        self.record(&report);
        Ok(report)
    }

    /// [`step`](Self::step) from two starts, for when the map or the reference has jumped: the last solution and the
    /// reference, each with the iterations of `options`; the one of lower cost stays. True if that is the reference's.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn step_from_both(
        &mut self,
        robot: &(impl Robot<NX, NU> + ?Sized),
        cost: &Tracking<NX, NU>,
        constraints: &[&dyn Constraint<NX, NU>],
        x0: &SVector<f64, NX>,
        options: &Options,
    ) -> Result<(Report, bool), Error> {
        self.guess(robot, cost)?;
        let first = self.solver.solve(robot, cost, constraints, x0, options);
        if let Ok(report) = &first {
            self.record(report);
        }
        self.spare.0.copy_from_slice(self.solver.states());
        self.spare.1.copy_from_slice(self.solver.inputs());
        self.solver.set_guess(&cost.states, &cost.inputs)?;
        let second = self.solver.solve(robot, cost, constraints, x0, options);
        if let Ok(report) = &second {
            self.record(report);
        }
        match (first, second) {
            (Ok(a), Ok(b)) if b.cost < a.cost && b.gap <= a.gap.max(1e-9) => Ok((b, true)),
            (Err(_), Ok(b)) => Ok((b, true)),
            (first, _) => {
                self.solver.set_guess(&self.spare.0, &self.spare.1)?;
                first.map(|report| (report, false))
            }
        }
    }

    /// First half of a real-time iteration, before the state is measured: call [`shift`](Self::shift) first. Then
    /// [`react`](Self::react) as soon as the state is there.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn prepare(
        &mut self,
        robot: &(impl Robot<NX, NU> + ?Sized),
        cost: &Tracking<NX, NU>,
        constraints: &[&dyn Constraint<NX, NU>],
    ) -> Result<Report, Error> {
        self.guess(robot, cost)?;
        let report = self.solver.prepare(robot, cost, constraints)?;
        self.record(&report);
        Ok(report)
    }

    /// The input for a measured state by the prepared feedback law, in well under a microsecond. May be asked again and
    /// again between two preparations.
    pub fn react(&self, x0: &SVector<f64, NX>) -> SVector<f64, NU> {
        self.solver.reaction(x0)
    }

    /// Second half of a real-time iteration: takes the full step from the measured state, to be shifted and prepared next.
    ///
    /// # Errors
    /// As [`Solver::commit`].
    pub fn commit(
        &mut self,
        robot: &(impl Robot<NX, NU> + ?Sized),
        x0: &SVector<f64, NX>,
    ) -> Result<(), Error> {
        self.solver.commit(robot, x0)
    }

    /// The last solution carried on, or the reference.
    fn guess(
        &mut self,
        robot: &(impl Robot<NX, NU> + ?Sized),
        cost: &Tracking<NX, NU>,
    ) -> Result<(), Error> {
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
        } else if self.unplanned > 0 {
            let dt = self.solver.dt();
            let (xs, us) = self.solver.guess_mut();
            for k in n - self.unplanned..n {
                us[k] = cost.inputs[k];
                xs[k + 1] = robot.step(&xs[k], &us[k], dt);
            }
        }
        self.unplanned = 0;
        Ok(())
    }

    fn record(&mut self, report: &Report) {
        self.warm = true;
        let least = self
            .solver
            .groups()
            .iter()
            .fold(f64::INFINITY, |least, g| least.min(g.least));
        let s = &mut self.statistics;
        s.steps += 1;
        s.iterations += report.iterations;
        s.out_of_time += usize::from(report.status == Status::OutOfTime);
        s.stalled += usize::from(report.status == Status::Stalled);
        s.violated += usize::from(least < 0.0);
        s.least = s.least.min(least);
        s.regularization = s.regularization.max(report.regularization);
    }

    /// States of the solution.
    pub fn states(&self) -> &[SVector<f64, NX>] {
        self.solver.states()
    }

    /// Inputs of the solution.
    pub fn inputs(&self) -> &[SVector<f64, NU>] {
        self.solver.inputs()
    }

    /// Groups of constraints along the solution.
    pub fn groups(&self) -> &[Group] {
        self.solver.groups()
    }

    /// What was done so far.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// Feedback gain of the first knot.
    pub fn gain(&self) -> &SMatrix<f64, NU, NX> {
        self.solver.gain()
    }

    /// The solver, for gains of later knots.
    pub fn solver(&self) -> &Solver<NX, NU> {
        &self.solver
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
            values[k.saturating_add(whole).min(last)],
            values[k.saturating_add(whole).saturating_add(1).min(last)],
        );
        values[k] = a + (b - a) * part;
    }
}
