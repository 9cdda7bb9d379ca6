//! Gauss-Newton DDP with multiple shooting: backward Riccati pass, non-linear roll-out that closes the gaps, line search.

use crate::constraint::Constraint;
use crate::cost::{CostModel, Expansion};
use crate::error::{Error, positive};
use crate::robot::Robot;
use nalgebra::{SMatrix, SVector};

/// Effort and tolerances.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Most iterations.
    pub iterations: usize,
    /// Converged when the expected decrease of the objective falls below this.
    pub tolerance: f64,
    /// Most halvings of a step.
    pub halvings: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            iterations: 50,
            tolerance: 1e-6,
            halvings: 12,
        }
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The expected decrease is below the tolerance and the gaps are closed.
    Converged,
    /// The iterations ran out.
    IterationLimit,
    /// No step along the search direction improved the merit.
    Stalled,
}

/// What a solve did.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// How it ended.
    pub status: Status,
    /// Objective at the end: costs and barriers.
    pub cost: f64,
    /// Sum of absolute defects between knots at the end.
    pub gap: f64,
    /// Iterations done.
    pub iterations: usize,
    /// Length of the last step taken, 1 = full.
    pub step: f64,
    /// Regularisation at the end.
    pub regularization: f64,
    /// Least z of each constraint group along the solution, with its name.
    pub margins: Vec<(&'static str, f64)>,
}

/// One knot's linear-quadratic model and policy.
#[derive(Clone, Debug)]
struct Knot<const NX: usize, const NU: usize> {
    a: SMatrix<f64, NX, NX>,
    b: SMatrix<f64, NX, NU>,
    model: Expansion<NX, NU>,
    /// Defect: f(x_k, u_k) - x_{k+1}.
    gap: SVector<f64, NX>,
    feedforward: SVector<f64, NU>,
    feedback: SMatrix<f64, NU, NX>,
}

/// A horizon of `n` inputs and `n + 1` states; all memory is allocated at construction.
#[derive(Clone, Debug)]
pub struct Solver<const NX: usize, const NU: usize> {
    dt: f64,
    xs: Vec<SVector<f64, NX>>,
    us: Vec<SVector<f64, NU>>,
    trial_xs: Vec<SVector<f64, NX>>,
    trial_us: Vec<SVector<f64, NU>>,
    knots: Vec<Knot<NX, NU>>,
    regularization: f64,
    /// Weight of the gaps in the merit; only ever raised during a solve.
    gap_weight: f64,
}

/// Constraints as the solver takes them.
type Constraints<'a, const NX: usize, const NU: usize> = [&'a dyn Constraint<NX, NU>];

impl<const NX: usize, const NU: usize> Solver<NX, NU> {
    /// A horizon of `knots` steps of `dt` s, all zero.
    ///
    /// # Errors
    /// [`Error::NoKnots`], or [`Error::Param`] for a bad `dt`.
    pub fn new(knots: usize, dt: f64) -> Result<Self, Error> {
        positive("dt", dt)?;
        if knots == 0 {
            return Err(Error::NoKnots);
        }
        let knot = Knot {
            a: SMatrix::zeros(),
            b: SMatrix::zeros(),
            model: Expansion::zeros(),
            gap: SVector::zeros(),
            feedforward: SVector::zeros(),
            feedback: SMatrix::zeros(),
        };
        Ok(Self {
            dt,
            xs: vec![SVector::zeros(); knots + 1],
            us: vec![SVector::zeros(); knots],
            trial_xs: vec![SVector::zeros(); knots + 1],
            trial_us: vec![SVector::zeros(); knots],
            knots: vec![knot; knots + 1],
            regularization: 0.0,
            gap_weight: 0.0,
        })
    }

    /// Time between knots, s.
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// States of the solution, one more than inputs.
    pub fn states(&self) -> &[SVector<f64, NX>] {
        &self.xs
    }

    /// Inputs of the solution.
    pub fn inputs(&self) -> &[SVector<f64, NU>] {
        &self.us
    }

    /// Feedback gain of the first knot: `u = inputs()[0] + gain (x - states()[0])`.
    pub fn gain(&self) -> &SMatrix<f64, NU, NX> {
        &self.knots[0].feedback
    }

    /// Sets the guess the next solve starts from. The states need not fit the inputs.
    ///
    /// # Errors
    /// [`Error::TooShort`] or [`Error::NotFinite`], naming the guess.
    pub fn set_guess(
        &mut self,
        states: &[SVector<f64, NX>],
        inputs: &[SVector<f64, NU>],
    ) -> Result<(), Error> {
        let n = self.us.len();
        if states.len() < n + 1 {
            return Err(Error::TooShort {
                what: "guess of states",
                given: states.len(),
                needed: n + 1,
            });
        }
        if inputs.len() < n {
            return Err(Error::TooShort {
                what: "guess of inputs",
                given: inputs.len(),
                needed: n,
            });
        }
        for (knot, x) in states[..=n].iter().enumerate() {
            finite("guess of states", knot, x.as_slice())?;
        }
        for (knot, u) in inputs[..n].iter().enumerate() {
            finite("guess of inputs", knot, u.as_slice())?;
        }
        self.xs.copy_from_slice(&states[..=n]);
        self.us.copy_from_slice(&inputs[..n]);
        Ok(())
    }

    pub(crate) fn guess_mut(&mut self) -> (&mut Vec<SVector<f64, NX>>, &mut Vec<SVector<f64, NU>>) {
        (&mut self.xs, &mut self.us)
    }

    /// Minimises cost and barriers from `x0`, starting from the present guess. The solution is never worse in merit than the
    /// guess, whenever it ends.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for `x0`, [`Error::TooShort`] for a reference shorter than the horizon, [`Error::Param`] for a bad
    /// barrier.
    pub fn solve(
        &mut self,
        robot: &(impl Robot<NX, NU> + ?Sized),
        cost: &(impl CostModel<NX, NU> + ?Sized),
        constraints: &Constraints<'_, NX, NU>,
        x0: &SVector<f64, NX>,
        options: &Options,
    ) -> Result<Report, Error> {
        finite("x0", 0, x0.as_slice())?;
        let n = self.us.len();
        if cost.knots() < n {
            return Err(Error::TooShort {
                what: "reference",
                given: cost.knots(),
                needed: n,
            });
        }
        for constraint in constraints {
            constraint.barrier().validate()?;
        }
        self.xs[0] = *x0;
        self.gap_weight = 0.0;
        let mut objective = objective(&self.xs, &self.us, self.dt, cost, constraints);
        let mut report = Report {
            status: Status::IterationLimit,
            cost: objective,
            gap: 0.0,
            iterations: 0,
            step: 0.0,
            regularization: self.regularization,
            margins: Vec::new(),
        };
        let mut gap = self.expand(robot, cost, constraints);
        while report.iterations < options.iterations {
            report.iterations += 1;
            let Some((linear, quadratic)) = self.backward() else {
                // Levenberg: an input Hessian that is not positive definite gets more on its diagonal.
                self.regularization = (self.regularization * 10.0).max(1e-9);
                if self.regularization > 1e9 {
                    report.status = Status::Stalled;
                    break;
                }
                continue;
            };
            let expected = linear + 0.5 * quadratic;
            if -expected < options.tolerance && gap < 1e-9 {
                report.status = Status::Converged;
                break;
            }
            // Raised so that the merit falls along the step even where closing a gap costs.
            if gap > 0.0 {
                self.gap_weight = self.gap_weight.max(2.0 * expected.max(0.0) / gap + 1e-3);
            }
            let merit = objective + self.gap_weight * gap;
            let mut alpha = 1.0;
            let mut taken = None;
            for _ in 0..=options.halvings {
                let new = self.roll_out(robot, cost, constraints, x0, alpha);
                let trial = new + self.gap_weight * (1.0 - alpha) * gap;
                let model = alpha * linear + 0.5 * alpha * alpha * quadratic
                    - alpha * self.gap_weight * gap;
                if trial.is_finite() && trial <= merit + 1e-4 * model.min(0.0) {
                    taken = Some(new);
                    break;
                }
                alpha *= 0.5;
            }
            let Some(new) = taken else {
                if self.regularization >= 1e3 {
                    report.status = Status::Stalled;
                    break;
                }
                self.regularization = (self.regularization * 10.0).max(1e-6);
                continue;
            };
            std::mem::swap(&mut self.xs, &mut self.trial_xs);
            std::mem::swap(&mut self.us, &mut self.trial_us);
            objective = new;
            report.step = alpha;
            self.regularization = if self.regularization > 1e-9 {
                0.5 * self.regularization
            } else {
                0.0
            };
            gap = self.expand(robot, cost, constraints);
        }
        report.cost = objective;
        report.gap = gap;
        report.regularization = self.regularization;
        report.margins = constraints
            .iter()
            .map(|constraint| {
                let mut least = f64::INFINITY;
                for k in 0..=n {
                    let mut look = |z: f64| least = least.min(z);
                    if k > 0 {
                        constraint.values(k, &self.xs[k], self.us.get(k), &mut look);
                    } else {
                        values_of_inputs(*constraint, &self.xs[0], &self.us[0], &mut look);
                    }
                }
                (constraint.name(), least)
            })
            .collect();
        Ok(report)
    }

    /// Linear-quadratic models at all knots; returns the sum of absolute gaps.
    fn expand(
        &mut self,
        robot: &(impl Robot<NX, NU> + ?Sized),
        cost: &(impl CostModel<NX, NU> + ?Sized),
        constraints: &Constraints<'_, NX, NU>,
    ) -> f64 {
        let n = self.us.len();
        let mut gap = 0.0;
        for k in 0..=n {
            let knot = &mut self.knots[k];
            let (x, u) = (&self.xs[k], self.us.get(k));
            knot.model = Expansion::zeros();
            match u {
                Some(u) => {
                    cost.expand_stage(k, x, u, &mut knot.model);
                    (knot.a, knot.b) = robot.linearize(x, u, self.dt);
                    knot.gap = robot.step(x, u, self.dt) - self.xs[k + 1];
                    gap += knot.gap.abs().sum();
                }
                None => cost.expand_terminal(x, &mut knot.model),
            }
            for constraint in constraints {
                let barrier = constraint.barrier();
                let model = &mut knot.model;
                constraint.rows(k, x, u, &mut |z, zx, zu| {
                    let (_, slope, curvature) = barrier.eval(z);
                    add_row(model, k, self.dt * slope, self.dt * curvature, zx, zu);
                });
            }
        }
        gap
    }

    /// Riccati recursion from the last knot; `None` if an input Hessian is not positive definite. Returns the linear and the
    /// quadratic part of the expected change of the objective for a full step.
    fn backward(&mut self) -> Option<(f64, f64)> {
        let n = self.us.len();
        let last = &self.knots[n].model;
        let (mut vx, mut vxx) = (last.x, last.xx);
        let (mut linear, mut quadratic) = (0.0, 0.0);
        for k in (0..n).rev() {
            let knot = &mut self.knots[k];
            // The gap shifts where the next knot's model is looked at.
            let shifted = vx + vxx * knot.gap;
            linear += vx.dot(&knot.gap);
            quadratic += knot.gap.dot(&(vxx * knot.gap));
            let pa = vxx * knot.a;
            let pb = vxx * knot.b;
            let qx = knot.model.x + knot.a.tr_mul(&shifted);
            let qu = knot.model.u + knot.b.tr_mul(&shifted);
            let qxx = knot.model.xx + knot.a.tr_mul(&pa);
            let qux = knot.model.ux + knot.b.tr_mul(&pa);
            let mut quu = knot.model.uu + knot.b.tr_mul(&pb);
            for i in 0..NU {
                quu[(i, i)] += self.regularization;
            }
            let factor = quu.cholesky()?;
            knot.feedforward = -factor.solve(&qu);
            knot.feedback = -factor.solve(&qux);
            if !knot.feedforward.iter().all(|v| v.is_finite()) {
                return None;
            }
            linear += qu.dot(&knot.feedforward);
            quadratic += knot.feedforward.dot(&(quu * knot.feedforward));
            vx = qx
                + knot.feedback.tr_mul(&(quu * knot.feedforward + qu))
                + qux.tr_mul(&knot.feedforward);
            vxx = qxx
                + knot.feedback.tr_mul(&(quu * knot.feedback + qux))
                + qux.tr_mul(&knot.feedback);
            vxx = (vxx + vxx.transpose()) * 0.5;
        }
        Some((linear, quadratic))
    }

    /// Rolls the policy out with step length `alpha`; each gap shrinks by the same share. Returns the objective.
    fn roll_out(
        &mut self,
        robot: &(impl Robot<NX, NU> + ?Sized),
        cost: &(impl CostModel<NX, NU> + ?Sized),
        constraints: &Constraints<'_, NX, NU>,
        x0: &SVector<f64, NX>,
        alpha: f64,
    ) -> f64 {
        self.trial_xs[0] = *x0;
        for k in 0..self.us.len() {
            let knot = &self.knots[k];
            let dx = self.trial_xs[k] - self.xs[k];
            self.trial_us[k] = self.us[k] + knot.feedforward * alpha + knot.feedback * dx;
            self.trial_xs[k + 1] = robot.step(&self.trial_xs[k], &self.trial_us[k], self.dt)
                - knot.gap * (1.0 - alpha);
        }
        objective(&self.trial_xs, &self.trial_us, self.dt, cost, constraints)
    }
}

/// Constraints at the first knot: its state is given, so only those that depend on the input count.
fn values_of_inputs<const NX: usize, const NU: usize>(
    constraint: &dyn Constraint<NX, NU>,
    x: &SVector<f64, NX>,
    u: &SVector<f64, NU>,
    visit: &mut dyn FnMut(f64),
) {
    constraint.rows(0, x, Some(u), &mut |z, _, zu| {
        if zu.iter().any(|&v| v != 0.0) {
            visit(z);
        }
    });
}

/// Costs and barriers along a trajectory. Barriers are integrals, so each is weighted by `dt`.
fn objective<const NX: usize, const NU: usize>(
    xs: &[SVector<f64, NX>],
    us: &[SVector<f64, NU>],
    dt: f64,
    cost: &(impl CostModel<NX, NU> + ?Sized),
    constraints: &Constraints<'_, NX, NU>,
) -> f64 {
    let n = us.len();
    let mut total = cost.terminal(&xs[n]);
    for k in 0..n {
        total += cost.stage(k, &xs[k], &us[k]);
    }
    for constraint in constraints {
        let barrier = constraint.barrier();
        let mut penalty = 0.0;
        let mut add = |z: f64| penalty += barrier.value(z);
        values_of_inputs(*constraint, &xs[0], &us[0], &mut add);
        for k in 1..=n {
            constraint.values(k, &xs[k], us.get(k), &mut add);
        }
        total += dt * penalty;
    }
    total
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
            for i in 0..NX {
                model.ux[(j, i)] += curvature * zu[j] * zx[i];
            }
        }
    }
}

pub(crate) fn finite(what: &'static str, knot: usize, values: &[f64]) -> Result<(), Error> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(entry) => Err(Error::NotFinite { what, knot, entry }),
        None => Ok(()),
    }
}
