//! Gauss-Newton DDP with multiple shooting: backward Riccati pass, non-linear roll-out that closes the gaps, line search.

use crate::constraint::{Constraint, Horizon};
use crate::cost::{CostModel, Expansion};
#[cfg(feature = "faer")]
use crate::dense::backward as backward_large;
use crate::error::{Error, positive};
#[cfg(not(feature = "faer"))]
use crate::riccati::backward_dense as backward_large;
use crate::riccati::{Backward, Expected, Pattern, Policy, fits};
use crate::robot::{Linear, Robot};
use crate::simd::dispatch_narrow;
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

impl Options {
    /// For control: at most three iterations from a warm start, and few halvings, since the next control step comes soon.
    pub fn real_time() -> Self {
        Self {
            iterations: 3,
            halvings: 2,
            ..Self::default()
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
    /// The caller's clock ran out.
    OutOfTime,
    /// No step along the search direction improved the merit.
    Stalled,
}

/// What a solve did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// How it ended.
    pub status: Status,
    /// Objective at the end: costs and barriers.
    pub cost: f64,
    /// Sum of absolute defects between knots at the end.
    pub gap: f64,
    /// Iterations done.
    pub iterations: usize,
    /// Length of the last step taken, 1 = full; 0 if none was.
    pub step: f64,
    /// Steps that were halved, over all iterations.
    pub halved: usize,
    /// Regularisation at the end.
    pub regularization: f64,
    /// Decrease of the objective that the last backward pass promised for a full step.
    pub expected: f64,
}

/// What one group of constraints comes to along the solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Name of the group.
    pub name: &'static str,
    /// Least z; below zero it is violated. Beyond a cut-off it may be infinite.
    pub least: f64,
    /// Weighted sum of its barriers.
    pub penalty: f64,
}

/// One trajectory with its quadratic models.
#[derive(Clone, Debug)]
struct Trajectory<const NX: usize, const NU: usize> {
    xs: Vec<SVector<f64, NX>>,
    us: Vec<SVector<f64, NU>>,
    models: Vec<Expansion<NX, NU>>,
    groups: Vec<Group>,
    /// Whether the models may have mixed second derivatives that are not zero.
    coupled: bool,
}

/// A horizon of `n` inputs and `n + 1` states; all memory is allocated at construction.
#[derive(Clone, Debug)]
pub struct Solver<const NX: usize, const NU: usize> {
    dt: f64,
    now: Trajectory<NX, NU>,
    trial: Trajectory<NX, NU>,
    linear: Vec<Linear<NX, NU>>,
    /// Defects: f(x_k, u_k) - x_{k+1}.
    gaps: Vec<SVector<f64, NX>>,
    policies: Vec<Policy<NX, NU>>,
    pattern: Pattern,
    regularization: f64,
    /// Whether the full step is likely to be taken, as the last one was: then its models are made at once.
    eager: bool,
    /// Weight of the gaps in the merit; only ever raised during a solve.
    gap_weight: f64,
}

/// Constraints as the solver takes them.
type Constraints<'a, const NX: usize, const NU: usize> = [&'a dyn Constraint<NX, NU>];

/// Steps shorter than this raise the regularisation.
const SHORT: f64 = 0.125;

/// Groups of constraints for which there is room without allocating.
const GROUPS: usize = 16;

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
        let trajectory = || Trajectory {
            xs: vec![SVector::zeros(); knots + 1],
            us: vec![SVector::zeros(); knots],
            models: vec![Expansion::zeros(); knots + 1],
            groups: Vec::with_capacity(GROUPS),
            coupled: false,
        };
        let linear = Linear {
            a: SMatrix::zeros(),
            b: SMatrix::zeros(),
        };
        let policy = Policy {
            feedforward: SVector::zeros(),
            feedback: SMatrix::zeros(),
        };
        Ok(Self {
            dt,
            now: trajectory(),
            trial: trajectory(),
            linear: vec![linear; knots],
            gaps: vec![SVector::zeros(); knots],
            policies: vec![policy; knots],
            pattern: Pattern::with_capacity(NX, NU),
            regularization: 0.0,
            eager: true,
            gap_weight: 0.0,
        })
    }

    /// Time between knots, s.
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// States of the solution, one more than inputs.
    pub fn states(&self) -> &[SVector<f64, NX>] {
        &self.now.xs
    }

    /// Inputs of the solution.
    pub fn inputs(&self) -> &[SVector<f64, NU>] {
        &self.now.us
    }

    /// Groups of constraints along the solution, in the order they were given.
    pub fn groups(&self) -> &[Group] {
        &self.now.groups
    }

    /// Feedback gain of the first knot: `u = inputs()[0] + gain (x - states()[0])`. It is the last backward pass's, taken at
    /// the trajectory before the last step.
    pub fn gain(&self) -> &SMatrix<f64, NU, NX> {
        &self.policies[0].feedback
    }

    /// Feedback gain of knot `k`, if there is one.
    pub fn gain_at(&self, k: usize) -> Option<&SMatrix<f64, NU, NX>> {
        self.policies.get(k).map(|p| &p.feedback)
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
        let n = self.now.us.len();
        long_enough("guess of states", states.len(), n + 1)?;
        long_enough("guess of inputs", inputs.len(), n)?;
        for (knot, x) in states[..=n].iter().enumerate() {
            finite("guess of states", knot, x.as_slice())?;
        }
        for (knot, u) in inputs[..n].iter().enumerate() {
            finite("guess of inputs", knot, u.as_slice())?;
        }
        self.now.xs.copy_from_slice(&states[..=n]);
        self.now.us.copy_from_slice(&inputs[..n]);
        Ok(())
    }

    pub(crate) fn guess_mut(&mut self) -> (&mut Vec<SVector<f64, NX>>, &mut Vec<SVector<f64, NU>>) {
        (&mut self.now.xs, &mut self.now.us)
    }

    /// Minimises cost and barriers from `x0`, starting from the present guess. The solution is never worse in merit than the
    /// guess, whenever it ends.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for `x0` or for an objective that is not finite at the guess, [`Error::TooShort`] for a reference
    /// shorter than the horizon, [`Error::Param`] for a bad barrier.
    pub fn solve(
        &mut self,
        robot: &(impl Robot<NX, NU> + ?Sized),
        cost: &(impl CostModel<NX, NU> + ?Sized),
        constraints: &Constraints<'_, NX, NU>,
        x0: &SVector<f64, NX>,
        options: &Options,
    ) -> Result<Report, Error> {
        self.solve_until(robot, cost, constraints, x0, options, &mut || false)
    }

    /// [`solve`](Self::solve) with a limit of time: `out_of_time` is asked before every iteration after the first.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn solve_until(
        &mut self,
        robot: &(impl Robot<NX, NU> + ?Sized),
        cost: &(impl CostModel<NX, NU> + ?Sized),
        constraints: &Constraints<'_, NX, NU>,
        x0: &SVector<f64, NX>,
        options: &Options,
        out_of_time: &mut dyn FnMut() -> bool,
    ) -> Result<Report, Error> {
        finite("x0", 0, x0.as_slice())?;
        self.check(cost, constraints)?;
        let was = std::mem::replace(&mut self.now.xs[0], *x0);
        self.gap_weight = 0.0;
        let mut objective = self.now.evaluate(self.dt, cost, constraints, true);
        let mut gap = self.open_gaps(robot);
        if !(objective.is_finite() && gap.is_finite()) {
            self.now.xs[0] = was;
            return Err(Error::NotFinite {
                what: "the objective or a step from the guess",
                knot: 0,
                entry: 0,
            });
        }
        self.linearize(robot);
        let mut report = Report {
            status: Status::IterationLimit,
            cost: objective,
            gap: 0.0,
            iterations: 0,
            step: 0.0,
            halved: 0,
            regularization: self.regularization,
            expected: 0.0,
        };
        while report.iterations < options.iterations {
            if report.iterations > 0 && out_of_time() {
                report.status = Status::OutOfTime;
                break;
            }
            report.iterations += 1;
            let last = report.iterations == options.iterations;
            let Some(Expected { linear, quadratic }) = self.backward(gap > 0.0) else {
                // Levenberg: an input Hessian that is not positive definite gets more on its diagonal.
                self.regularization = (self.regularization * 10.0).max(1e-9);
                if self.regularization > 1e9 {
                    self.regularization = 0.0;
                    report.status = Status::Stalled;
                    break;
                }
                continue;
            };
            let expected = linear + 0.5 * quadratic;
            report.expected = -expected;
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
            for halving in 0..=options.halvings {
                self.roll_out(robot, x0, alpha);
                let expand = self.eager && halving == 0 && !last;
                let new = self.trial.evaluate(self.dt, cost, constraints, expand);
                let trial = new + self.gap_weight * (1.0 - alpha) * gap;
                let model = alpha * linear + 0.5 * alpha * alpha * quadratic
                    - alpha * self.gap_weight * gap;
                if trial.is_finite() && trial <= merit + 1e-4 * model.min(0.0) {
                    if !(expand || last) {
                        self.trial.evaluate(self.dt, cost, constraints, true);
                    }
                    taken = Some(new);
                    break;
                }
                report.halved += 1;
                alpha *= 0.5;
            }
            let Some(new) = taken else {
                // Damping that is felt: a share of what the inputs' own costs weigh.
                let least = 0.1 * self.mean_input_weight();
                if self.regularization >= 1e6 * least {
                    report.status = Status::Stalled;
                    break;
                }
                self.regularization = (self.regularization * 10.0).max(least);
                self.eager = false;
                continue;
            };
            self.eager = alpha == 1.0;
            // Short steps say that the model reaches less far than the step wants.
            self.regularization = if alpha < SHORT {
                (self.regularization * 4.0).max(0.1 * self.mean_input_weight())
            } else if self.regularization > 1e-9 {
                0.5 * self.regularization
            } else {
                0.0
            };
            std::mem::swap(&mut self.now, &mut self.trial);
            objective = new;
            report.step = alpha;
            // The roll-out kept exactly this share of each gap.
            for g in &mut self.gaps {
                *g *= 1.0 - alpha;
            }
            gap *= 1.0 - alpha;
            if !last {
                self.linearize(robot);
            }
        }
        report.cost = objective;
        report.gap = gap;
        report.regularization = self.regularization;
        Ok(report)
    }

    /// Mean of the inputs' second derivatives over all knots.
    fn mean_input_weight(&self) -> f64 {
        let n = self.now.us.len();
        let sum: f64 = self.now.models[..n].iter().map(|m| m.uu.trace()).sum();
        (sum / (n * NU) as f64).max(1e-9)
    }

    /// The part of an iteration that can be done before the state is measured: models, sensitivities and the backward pass
    /// at the present guess. Then [`reaction`](Self::reaction) is the input for any measured state near the guess, and
    /// [`commit`](Self::commit) takes the step.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn prepare(
        &mut self,
        robot: &(impl Robot<NX, NU> + ?Sized),
        cost: &(impl CostModel<NX, NU> + ?Sized),
        constraints: &Constraints<'_, NX, NU>,
    ) -> Result<Report, Error> {
        self.check(cost, constraints)?;
        let objective = self.now.evaluate(self.dt, cost, constraints, true);
        let gap = self.open_gaps(robot);
        if !(objective.is_finite() && gap.is_finite()) {
            return Err(Error::NotFinite {
                what: "the objective or a step from the guess",
                knot: 0,
                entry: 0,
            });
        }
        self.linearize(robot);
        self.regularization = 0.0;
        let mut report = Report {
            status: Status::IterationLimit,
            cost: objective,
            gap,
            iterations: 1,
            step: 0.0,
            halved: 0,
            regularization: 0.0,
            expected: 0.0,
        };
        loop {
            if let Some(e) = self.backward(gap > 0.0) {
                report.expected = -(e.linear + 0.5 * e.quadratic);
                report.regularization = self.regularization;
                return Ok(report);
            }
            self.regularization = (self.regularization * 10.0).max(1e-9);
            if self.regularization > 1e9 {
                self.regularization = 0.0;
                report.status = Status::Stalled;
                for policy in &mut self.policies {
                    policy.feedforward = SVector::zeros();
                    policy.feedback = SMatrix::zeros();
                }
                return Ok(report);
            }
        }
    }

    /// The first input for a measured state, by the prepared policy.
    pub fn reaction(&self, x0: &SVector<f64, NX>) -> SVector<f64, NU> {
        let policy = &self.policies[0];
        self.now.us[0] + policy.feedforward + policy.feedback * (x0 - self.now.xs[0])
    }

    /// Takes the full step of the prepared policy from a measured state.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if `x0` or the roll-out is not finite; the guess then stays as it was.
    pub fn commit(
        &mut self,
        robot: &(impl Robot<NX, NU> + ?Sized),
        x0: &SVector<f64, NX>,
    ) -> Result<(), Error> {
        finite("x0", 0, x0.as_slice())?;
        self.roll_out(robot, x0, 1.0);
        for (knot, x) in self.trial.xs.iter().enumerate() {
            finite("the prepared step's roll-out", knot, x.as_slice())?;
        }
        std::mem::swap(&mut self.now, &mut self.trial);
        Ok(())
    }

    fn check(
        &self,
        cost: &(impl CostModel<NX, NU> + ?Sized),
        constraints: &Constraints<'_, NX, NU>,
    ) -> Result<(), Error> {
        long_enough("reference", cost.knots(), self.now.us.len())?;
        constraints.iter().try_for_each(|c| c.validate())
    }

    /// Defects of the guess; returns the sum of their magnitudes.
    fn open_gaps(&mut self, robot: &(impl Robot<NX, NU> + ?Sized)) -> f64 {
        let mut sum = 0.0;
        for (k, gap) in self.gaps.iter_mut().enumerate() {
            let next = robot.step(&self.now.xs[k], &self.now.us[k], self.dt);
            *gap = next - self.now.xs[k + 1];
            sum += gap.iter().map(|v| v.abs()).sum::<f64>();
        }
        sum
    }

    fn linearize(&mut self, robot: &(impl Robot<NX, NU> + ?Sized)) {
        let (xs, us) = (&self.now.xs, &self.now.us);
        robot.linearize_all(&xs[..us.len()], us, self.dt, &mut self.linear);
        self.pattern.find(&self.linear, &self.now.models);
        self.now.coupled = self.pattern.coupled();
    }

    fn backward(&mut self, open: bool) -> Option<Expected> {
        if fits(NX, NU) {
            dispatch_narrow(Backward {
                linear: &self.linear,
                models: &self.now.models,
                gaps: &self.gaps,
                open,
                pattern: &self.pattern,
                regularization: self.regularization,
                policies: &mut self.policies,
            })
        } else {
            backward_large(
                &self.linear,
                &self.now.models,
                &self.gaps,
                self.regularization,
                &mut self.policies,
            )
        }
    }

    /// Rolls the policy out with step length `alpha`; each gap shrinks by the same share.
    fn roll_out(
        &mut self,
        robot: &(impl Robot<NX, NU> + ?Sized),
        x0: &SVector<f64, NX>,
        alpha: f64,
    ) {
        let (xs, us) = (&mut self.trial.xs, &mut self.trial.us);
        xs[0] = *x0;
        for (k, policy) in self.policies.iter().enumerate() {
            let dx = xs[k] - self.now.xs[k];
            let mut u = self.now.us[k] + policy.feedforward * alpha;
            for i in 0..NX {
                for j in 0..NU {
                    u[j] += policy.feedback[(j, i)] * dx[i];
                }
            }
            us[k] = u;
            xs[k + 1] = robot.step(&xs[k], &u, self.dt);
            if alpha < 1.0 {
                xs[k + 1] -= self.gaps[k] * (1.0 - alpha);
            }
        }
    }
}

impl<const NX: usize, const NU: usize> Trajectory<NX, NU> {
    /// Costs and barriers along the trajectory, and with `expand` their quadratic models. Barriers are integrals, so each
    /// is weighted by `dt`.
    fn evaluate(
        &mut self,
        dt: f64,
        cost: &(impl CostModel<NX, NU> + ?Sized),
        constraints: &Constraints<'_, NX, NU>,
        expand: bool,
    ) -> f64 {
        let n = self.us.len();
        let mut total = cost.terminal(&self.xs[n]);
        // Until it is looked at again.
        let coupled = self.coupled;
        if expand {
            self.coupled = true;
            self.models[n].clear(coupled);
            cost.expand_terminal(&self.xs[n], &mut self.models[n]);
        }
        for k in 0..n {
            let (x, u) = (&self.xs[k], &self.us[k]);
            total += cost.stage(k, x, u);
            if expand {
                let model = &mut self.models[k];
                model.clear(coupled);
                cost.expand_stage(k, x, u, model);
            }
        }
        self.groups.clear();
        let along = Horizon {
            states: &self.xs,
            inputs: &self.us,
            weight: dt,
        };
        for constraint in constraints {
            let models = expand.then_some(&mut self.models[..]);
            let penalty = constraint.penalize(&along, models);
            total += penalty.sum;
            self.groups.push(Group {
                name: constraint.name(),
                least: penalty.least,
                penalty: penalty.sum,
            });
        }
        total
    }
}

fn long_enough(what: &'static str, given: usize, needed: usize) -> Result<(), Error> {
    if given < needed {
        return Err(Error::TooShort {
            what,
            given,
            needed,
        });
    }
    Ok(())
}

pub(crate) fn finite(what: &'static str, knot: usize, values: &[f64]) -> Result<(), Error> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(entry) => Err(Error::NotFinite { what, knot, entry }),
        None => Ok(()),
    }
}
