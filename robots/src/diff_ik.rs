//! Differential inverse kinematics with joint and speed limits as a quadratic program, for arms without a closed form.
//!
//! One step minimises `|J dq - e|^2_W + damping^2 |dq|^2` over a box: how far each joint may move now. Where the
//! minimum without the box lies inside it, that is the answer; otherwise clarabel solves the program.

use crate::chain::{Chain, JointKind};
use crate::error::Error;
use crate::frame::{Frame, add, cross, norm, scale, sub};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus,
    SupportedConeT::NonnegativeConeT,
};
use nalgebra::{DMatrix, DVector};

/// Settings of [`Chain::ik_step`] and [`Chain::ik`].
#[derive(Clone, Debug, PartialEq)]
pub struct DiffIk {
    /// Metres that a radian of wrong attitude is worth.
    pub radian: f64,
    /// Least damping, m per rad of joint motion: what keeps steps finite where the arm is singular.
    pub damping: f64,
    /// Longest motion of a joint in one iteration of [`Chain::ik`], rad or m.
    pub longest: f64,
    /// Position error up to which a pose counts as reached, m.
    pub position: f64,
    /// Attitude error up to which a pose counts as reached, rad.
    pub angle: f64,
    /// Iterations from one seed.
    pub iterations: usize,
    /// Seeds tried: the caller's, then random ones within the limits.
    pub seeds: usize,
}

impl Default for DiffIk {
    fn default() -> Self {
        Self {
            radian: 0.3,
            damping: 1e-4,
            longest: 0.6,
            position: 1e-6,
            angle: 1e-6,
            iterations: 60,
            seeds: 30,
        }
    }
}

impl DiffIk {
    /// Checks every field.
    ///
    /// # Errors
    /// The field that is not positive and finite.
    pub fn validate(&self) -> Result<(), Error> {
        for (field, value) in [
            ("radian", self.radian),
            ("damping", self.damping),
            ("longest", self.longest),
            ("position", self.position),
            ("angle", self.angle),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Error::Param { field, value });
            }
        }
        Ok(())
    }
}

/// One step towards a pose.
#[derive(Clone, Debug, PartialEq)]
pub struct IkStep {
    /// Motion of each joint, rad or m.
    pub motion: Vec<f64>,
    /// True if a limit held a joint back.
    pub limited: bool,
}

/// The outcome of [`Chain::ik`].
#[derive(Clone, Debug, PartialEq)]
pub struct IkFound {
    /// Joint positions within the limits: of the pose if `reached`, else the best that was found.
    pub joints: Vec<f64>,
    /// Whether the pose is reached within the tolerances.
    pub reached: bool,
    /// Position error, m.
    pub position_error: f64,
    /// Attitude error, rad.
    pub angle_error: f64,
    /// Iterations of all seeds.
    pub iterations: usize,
    /// Iterations in which limits held and the program was solved.
    pub programs: usize,
}

impl Chain {
    /// The motion of the joints during `seconds` that brings the tip nearest to `target` (base frame): within the joint
    /// limits and speeds. For servoing: call it again at the next time step.
    ///
    /// # Errors
    /// Joint positions of a wrong number, outside the limits or not finite; a `seconds` that is not positive; a bad
    /// setting.
    pub fn ik_step(
        &self,
        q: &[f64],
        target: &Frame,
        seconds: f64,
        settings: &DiffIk,
    ) -> Result<IkStep, Error> {
        settings.validate()?;
        self.inside(q, target)?;
        if !(seconds > 0.0 && seconds.is_finite()) {
            return Err(Error::Param {
                field: "seconds",
                value: seconds,
            });
        }
        let frames = self.frames(q)?;
        let bounds: Vec<(f64, f64)> = (0..self.len())
            .map(|j| {
                let joint = &self.joints[j];
                let most = joint.speed * seconds;
                (
                    (joint.limits.0 - q[j]).max(-most).min(0.0),
                    (joint.limits.1 - q[j]).min(most).max(0.0),
                )
            })
            .collect();
        let (motion, limited) = self.step(&frames, target, &bounds, settings.damping, settings);
        Ok(IkStep { motion, limited })
    }

    /// Joint positions within the limits that bring the tip to `target` (base frame), from `q` and, if that ends in a
    /// local minimum, from random seeds of the stream `seed`. "Out of reach" is a result, not an error.
    ///
    /// # Errors
    /// Joint positions of a wrong number, outside the limits or not finite; a bad setting.
    pub fn ik(
        &self,
        q: &[f64],
        target: &Frame,
        settings: &DiffIk,
        seed: u64,
    ) -> Result<IkFound, Error> {
        settings.validate()?;
        self.inside(q, target)?;
        let mut random = Random(seed);
        let mut best = IkFound {
            joints: q.to_vec(),
            reached: false,
            position_error: f64::INFINITY,
            angle_error: f64::INFINITY,
            iterations: 0,
            programs: 0,
        };
        let mut from = q.to_vec();
        for _ in 0..settings.seeds.max(1) {
            self.descend(&mut from, target, settings, &mut best)?;
            if best.reached {
                break;
            }
            for (value, joint) in from.iter_mut().zip(&self.joints) {
                // Endless joints start within a turn.
                let widest = if joint.kind == JointKind::Revolute {
                    std::f64::consts::PI
                } else {
                    10.0
                };
                let (low, high) = (joint.limits.0.max(-widest), joint.limits.1.min(widest));
                *value = if low < high {
                    low + random.unit() * (high - low)
                } else {
                    joint.limits.0.max(joint.limits.1.min(0.0))
                };
            }
        }
        Ok(best)
    }

    /// Steps from one seed, which is overwritten; keeps the best state of all.
    fn descend(
        &self,
        q: &mut [f64],
        target: &Frame,
        settings: &DiffIk,
        best: &mut IkFound,
    ) -> Result<(), Error> {
        let mut frames = Vec::with_capacity(self.len() + 2);
        let mut before = f64::INFINITY;
        let mut stalled = 0;
        for _ in 0..=settings.iterations {
            self.frames_into(q, &mut frames)?;
            let (position, angle) = frames[frames.len() - 1].error_to(target);
            let size = position + settings.radian * angle;
            if size < best.position_error + settings.radian * best.angle_error {
                best.joints.copy_from_slice(q);
                (best.position_error, best.angle_error) = (position, angle);
            }
            if position <= settings.position && angle <= settings.angle {
                best.reached = true;
                return Ok(());
            }
            // A local minimum: eight iterations without a tenth of progress.
            stalled = if size < 0.9 * before { 0 } else { stalled + 1 };
            before = before.min(size);
            if stalled >= 8 {
                return Ok(());
            }
            best.iterations += 1;
            let bounds: Vec<(f64, f64)> = (0..self.len())
                .map(|j| {
                    let (low, high) = self.joints[j].limits;
                    (
                        (low - q[j]).max(-settings.longest).min(0.0),
                        (high - q[j]).min(settings.longest).max(0.0),
                    )
                })
                .collect();
            // Far away the model is only roughly right, and near the goal damping would slow convergence.
            let damping = settings.damping + 0.1 * size.min(1.0);
            let (motion, limited) = self.step(&frames, target, &bounds, damping, settings);
            best.programs += usize::from(limited);
            for j in 0..q.len() {
                let (low, high) = self.joints[j].limits;
                q[j] = (q[j] + motion[j]).clamp(low, high);
            }
        }
        Ok(())
    }

    /// Minimiser of the damped, weighted error over the box, and whether the box mattered.
    fn step(
        &self,
        frames: &[Frame],
        target: &Frame,
        bounds: &[(f64, f64)],
        damping: f64,
        settings: &DiffIk,
    ) -> (Vec<f64>, bool) {
        let n = self.len();
        let columns = self.columns(frames);
        let error = error_between(&frames[frames.len() - 1], target);
        let weight = |row: usize| {
            if row < 3 {
                1.0
            } else {
                settings.radian * settings.radian
            }
        };
        let product =
            |a: &[f64; 6], b: &[f64; 6]| -> f64 { (0..6).map(|i| weight(i) * a[i] * b[i]).sum() };
        let hessian = DMatrix::from_fn(n, n, |i, j| {
            product(&columns[i], &columns[j]) + if i == j { damping * damping } else { 0.0 }
        });
        let slope = DVector::from_fn(n, |i, _| -product(&columns[i], &error));
        // The damping makes it positive definite.
        let free = hessian
            .clone()
            .cholesky()
            .map(|c| -c.solve(&slope))
            .unwrap_or_else(|| DVector::zeros(n));
        let inside = (0..n).all(|j| bounds[j].0 <= free[j] && free[j] <= bounds[j].1);
        if inside {
            return (free.as_slice().to_vec(), false);
        }
        (program(&hessian, &slope, bounds, &free), true)
    }

    fn inside(&self, q: &[f64], target: &Frame) -> Result<(), Error> {
        if let Some((joint, amount)) = self.limit_violation(q)? {
            return Err(Error::OutsideLimits { joint, amount });
        }
        match target.is_finite() {
            true => Ok(()),
            false => Err(Error::NotFinite { field: "target" }),
        }
    }
}

/// Minimum of `x^T H x / 2 + g^T x` over the box, by clarabel; the clamped free minimum if it fails.
fn program(
    hessian: &DMatrix<f64>,
    slope: &DVector<f64>,
    bounds: &[(f64, f64)],
    free: &DVector<f64>,
) -> Vec<f64> {
    let n = bounds.len();
    let clamped = || -> Vec<f64> {
        (0..n)
            .map(|j| free[j].clamp(bounds[j].0, bounds[j].1))
            .collect()
    };
    // Upper triangle, column by column.
    let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for j in 0..n {
        for i in 0..=j {
            rows.push(i);
            values.push(hessian[(i, j)]);
        }
        starts.push(rows.len());
    }
    let p = CscMatrix::new(n, n, starts, rows, values);
    // x <= high and -x <= -low.
    let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for j in 0..n {
        rows.extend([j, n + j]);
        values.extend([1.0, -1.0]);
        starts.push(rows.len());
    }
    let a = CscMatrix::new(2 * n, n, starts, rows, values);
    let b: Vec<f64> = bounds
        .iter()
        .map(|b| b.1)
        .chain(bounds.iter().map(|b| -b.0))
        .collect();
    let settings: Result<DefaultSettings<f64>, _> =
        DefaultSettingsBuilder::default().verbose(false).build();
    let Ok(settings) = settings else {
        return clamped();
    };
    let cones = [NonnegativeConeT(2 * n)];
    let Ok(mut solver) = DefaultSolver::new(&p, slope.as_slice(), &a, &b, &cones, settings) else {
        return clamped();
    };
    solver.solve();
    match solver.solution.status {
        SolverStatus::Solved | SolverStatus::AlmostSolved => (0..n)
            .map(|j| solver.solution.x[j].clamp(bounds[j].0, bounds[j].1))
            .collect(),
        _ => clamped(),
    }
}

/// Motion [v; w] (m, rad) that turns and shifts `from` onto `to`: the whole rotation vector, not its first order.
fn error_between(from: &Frame, to: &Frame) -> [f64; 6] {
    let v = sub(to.p, from.p);
    let half = scale(
        add(
            add(cross(from.x, to.x), cross(from.y, to.y)),
            cross(from.z, to.z),
        ),
        0.5,
    );
    let (sin, (_, angle)) = (norm(half), from.error_to(to));
    let w = if sin > 1e-9 {
        scale(half, angle / sin)
    } else if angle > 1.0 {
        // Half a turn about an axis that the products do not show: any of the three that differ most will do.
        let axis = [add(from.x, to.x), add(from.y, to.y), add(from.z, to.z)]
            .into_iter()
            .max_by(|a, b| norm(*a).total_cmp(&norm(*b)))
            .unwrap_or([0.0, 0.0, 1.0]);
        scale(axis, angle / norm(axis).max(1e-12))
    } else {
        half
    };
    [v[0], v[1], v[2], w[0], w[1], w[2]]
}

/// SplitMix64: seeds need no more.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}
