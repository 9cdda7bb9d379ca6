//! OpEn's PANOC (crate optimization_engine) on the same problem with the same model: single shooting, gradients by the
//! adjoint equations.

use crate::problem::{Instance, Outcome, Problem, Terms, U, X};
use cpu_time::ThreadTime;
use ddp_rbf::nalgebra::{SMatrix, SVector};
use ddp_rbf::{
    BoxField, Constraint, CostModel, DriveArm, Expansion, Horizon, Linear, Robot, Tracking,
};
use optimization_engine::Problem as Program;
use optimization_engine::constraints::Rectangle;
use optimization_engine::panoc::{PANOCCache, PANOCOptimizer};
use serde_json::{Value, json};
use std::cell::RefCell;

/// Most iterations that are tried.
const MOST: usize = 400;
/// Remembered pairs of its quasi-Newton directions.
const MEMORY: usize = 20;

/// The objective as a function of the inputs alone.
struct Shooting<'a> {
    cost: &'a Tracking<9, 8>,
    groups: &'a [&'a dyn Constraint<9, 8>],
    dt: f64,
    xs: Vec<X>,
    us: Vec<U>,
    models: Vec<Expansion<9, 8>>,
    linear: Vec<Linear<9, 8>>,
    gradients: usize,
}

impl Shooting<'_> {
    fn roll_out(&mut self, inputs: &[f64]) {
        for (k, u) in inputs.chunks_exact(8).enumerate() {
            self.us[k] = U::from_column_slice(u);
            self.xs[k + 1] = DriveArm.step(&self.xs[k], &self.us[k], self.dt);
        }
    }

    fn value(&mut self, inputs: &[f64]) -> f64 {
        self.roll_out(inputs);
        let along = Horizon {
            states: &self.xs,
            inputs: &self.us,
            weight: self.dt,
        };
        let n = self.us.len();
        let stages: f64 = (0..n)
            .map(|k| self.cost.stage(k, &self.xs[k], &self.us[k]))
            .sum();
        let barriers: f64 = self
            .groups
            .iter()
            .map(|g| g.penalize(&along, None).sum)
            .sum();
        stages + self.cost.terminal(&self.xs[n]) + barriers
    }

    fn gradient(&mut self, inputs: &[f64], out: &mut [f64]) {
        self.gradients += 1;
        self.roll_out(inputs);
        self.expand();
        let n = self.us.len();
        DriveArm.linearize_all(&self.xs[..n], &self.us, self.dt, &mut self.linear);
        let mut adjoint = self.models[n].x;
        for k in (0..n).rev() {
            let (m, l) = (&self.models[k], &self.linear[k]);
            let by_input = m.u + l.b.tr_mul(&adjoint);
            out[8 * k..8 * k + 8].copy_from_slice(by_input.as_slice());
            adjoint = m.x + l.a.tr_mul(&adjoint);
        }
    }

    /// First derivatives of cost and barriers; second ones come along.
    fn expand(&mut self) {
        let n = self.us.len();
        for (k, model) in self.models.iter_mut().enumerate() {
            *model = Expansion::zeros();
            if k < n {
                self.cost.expand_stage(k, &self.xs[k], &self.us[k], model);
            } else {
                self.cost.expand_terminal(&self.xs[k], model);
            }
        }
        let along = Horizon {
            states: &self.xs,
            inputs: &self.us,
            weight: self.dt,
        };
        for group in self.groups {
            group.penalize(&along, Some(&mut self.models));
        }
    }
}

/// Time until the objective is within 1e-4 of the optimum, from both guesses, in microseconds: as it is, and less what the
/// second derivatives cost, as if a gradient were no dearer than a value.
pub(crate) fn solve(problem: &Problem, instance: &Instance, n: usize, best: f64) -> Outcome<Value> {
    let dt = 3.0 / n as f64;
    let cost = problem.tracking(instance, n, dt, 0);
    let walls = BoxField::new(instance.boxes.clone(), None, problem.beta)?;
    let floor = BoxField::new(instance.boxes.clone(), Some(0.0), problem.beta)?;
    let terms = Terms::new(problem, problem.barrier, [0.0; 2], 0.0, &walls, &floor);
    let groups = terms.all();
    let shooting = RefCell::new(Shooting {
        cost: &cost,
        groups: &groups,
        dt,
        xs: vec![instance.x0; n + 1],
        us: vec![U::zeros(); n],
        models: vec![Expansion::zeros(); n + 1],
        linear: vec![
            Linear {
                a: SMatrix::zeros(),
                b: SMatrix::zeros()
            };
            n
        ],
        gradients: 0,
    });
    let high: Vec<f64> = (0..n)
        .flat_map(|_| problem.input_limit.iter().copied())
        .collect();
    let low: Vec<f64> = high.iter().map(|v| -v).collect();
    let limits = Rectangle::new(Some(&low), Some(&high));
    let mut out = json!({});
    for (guess, _, us) in problem.guesses(instance, &cost) {
        let start: Vec<f64> = us.iter().flat_map(SVector::iter).copied().collect();
        let mut cache = PANOCCache::new(8 * n, 1e-12, MEMORY);
        let mut run = |iterations: usize| -> Outcome<(f64, f64)> {
            cache.reset();
            let mut inputs = start.clone();
            shooting.borrow_mut().gradients = 0;
            let value = |u: &[f64], to: &mut f64| {
                *to = shooting.borrow_mut().value(u);
                Ok(())
            };
            let gradient = |u: &[f64], to: &mut [f64]| {
                shooting.borrow_mut().gradient(u, to);
                Ok(())
            };
            let clock = ThreadTime::now();
            PANOCOptimizer::new(Program::new(&limits, gradient, value), &mut cache)
                .with_max_iter(iterations)
                .solve(&mut inputs)
                .map_err(|e| format!("OpEn: {e:?}"))?;
            let time = clock.elapsed().as_secs_f64() * 1e6;
            Ok((shooting.borrow_mut().value(&inputs) - best, time))
        };
        let mut needed = None;
        for iterations in 1..=MOST {
            if run(iterations)?.0 <= 1e-4 {
                needed = Some(iterations);
                break;
            }
        }
        let Some(needed) = needed else {
            out[guess] = json!({ "iterations_to_1e-4": null });
            continue;
        };
        let mut times: Vec<f64> = (0..11)
            .map(|_| run(needed).map(|r| r.1))
            .collect::<Outcome<_>>()?;
        times.sort_by(f64::total_cmp);
        let (time, gradients) = (times[1], shooting.borrow().gradients);
        // What expanding costs beyond a value.
        let mut shooting = shooting.borrow_mut();
        let mut fastest = [f64::INFINITY; 2];
        for _ in 0..21 {
            let clock = ThreadTime::now();
            shooting.value(&start);
            fastest[0] = fastest[0].min(clock.elapsed().as_secs_f64() * 1e6);
            let clock = ThreadTime::now();
            shooting.roll_out(&start);
            shooting.expand();
            fastest[1] = fastest[1].min(clock.elapsed().as_secs_f64() * 1e6);
        }
        let spared = gradients as f64 * (fastest[1] - fastest[0]).max(0.0);
        out[guess] = json!({
            "iterations_to_1e-4": needed, "gradients": gradients, "us_to_1e-4": time, "us_less_second_derivatives": time - spared,
        });
    }
    Ok(out)
}
