//! Integrators: one classical Runge-Kutta step with exact sensitivities, and Dormand-Prince 5(4) with step control.

use crate::robot::{Linear, Robot};
use nalgebra::{SMatrix, SVector};

/// One step of the classical fourth-order Runge-Kutta method with the input held.
pub fn rk4<const NX: usize, const NU: usize>(
    robot: &(impl Robot<NX, NU> + ?Sized),
    x: &SVector<f64, NX>,
    u: &SVector<f64, NU>,
    dt: f64,
) -> SVector<f64, NX> {
    let k1 = robot.flow(x, u);
    let k2 = robot.flow(&(x + k1 * (0.5 * dt)), u);
    let k3 = robot.flow(&(x + k2 * (0.5 * dt)), u);
    let k4 = robot.flow(&(x + k3 * dt), u);
    x + (k1 + (k2 + k3) * 2.0 + k4) * (dt / 6.0)
}

/// The derivative of [`rk4`]'s result by state and input: exact for the discrete step, not an approximation of the flow's.
pub fn rk4_sensitivity<const NX: usize, const NU: usize>(
    robot: &(impl Robot<NX, NU> + ?Sized),
    x: &SVector<f64, NX>,
    u: &SVector<f64, NU>,
    dt: f64,
) -> (SMatrix<f64, NX, NX>, SMatrix<f64, NX, NU>) {
    let one = SMatrix::<f64, NX, NX>::identity();
    let k1 = robot.flow(x, u);
    let x2 = x + k1 * (0.5 * dt);
    let k2 = robot.flow(&x2, u);
    let x3 = x + k2 * (0.5 * dt);
    let k3 = robot.flow(&x3, u);
    let x4 = x + k3 * dt;
    let (a1, b1) = robot.jacobians(x, u);
    let (a2, b2) = robot.jacobians(&x2, u);
    let (a3, b3) = robot.jacobians(&x3, u);
    let (a4, b4) = robot.jacobians(&x4, u);
    // Slopes of the four stages.
    let (s1, t1) = (a1, b1);
    let (s2, t2) = (a2 * (one + s1 * (0.5 * dt)), b2 + a2 * t1 * (0.5 * dt));
    let (s3, t3) = (a3 * (one + s2 * (0.5 * dt)), b3 + a3 * t2 * (0.5 * dt));
    let (s4, t4) = (a4 * (one + s3 * dt), b4 + a4 * t3 * dt);
    (
        one + (s1 + (s2 + s3) * 2.0 + s4) * (dt / 6.0),
        (t1 + (t2 + t3) * 2.0 + t4) * (dt / 6.0),
    )
}

/// Result of an adaptive integration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integrated<const NX: usize> {
    /// State reached.
    pub x: SVector<f64, NX>,
    /// Steps accepted.
    pub steps: usize,
    /// False if the steps ran out or the state stopped being finite; `x` is then where it stopped.
    pub finished: bool,
}

/// Control of the adaptive step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepControl {
    /// Bound of the error estimate of each step, relative to 1 + |x|.
    pub tolerance: f64,
    /// Longest step, s: error control of smooth dynamics must not choose where constraints are looked at.
    pub longest: f64,
    /// Most steps tried.
    pub most_steps: usize,
}

impl Default for StepControl {
    /// The relative tolerance of the paper's ODE45, 1e-3, with steps of at most 0.1 s.
    fn default() -> Self {
        Self {
            tolerance: 1e-3,
            longest: 0.1,
            most_steps: 1000,
        }
    }
}

/// Nodes of Dormand and Prince's pair: the last row is the solution of order 5.
const A: [[f64; 6]; 6] = [
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
        0.0,
    ],
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];
/// Weights of the solution of order 4.
const LOW: [f64; 7] = [
    5179.0 / 57600.0,
    0.0,
    7571.0 / 16695.0,
    393.0 / 640.0,
    -92097.0 / 339200.0,
    187.0 / 2100.0,
    1.0 / 40.0,
];

/// Integrates over `time` s with the input held, by Dormand and Prince's embedded pair of orders 5 and 4 (the paper's ODE45).
/// `tolerance` bounds the error estimate of each step relative to 1 + |x|; no more than `most_steps` are tried.
pub fn dormand_prince<const NX: usize, const NU: usize>(
    robot: &(impl Robot<NX, NU> + ?Sized),
    x0: &SVector<f64, NX>,
    u: &SVector<f64, NU>,
    time: f64,
    tolerance: f64,
    most_steps: usize,
) -> Integrated<NX> {
    let control = StepControl {
        tolerance,
        longest: f64::INFINITY,
        most_steps,
    };
    adaptive(robot, x0, u, time, &control, |_, _| {})
}

/// [`dormand_prince`] with its exact discrete sensitivities: the derivatives of the result by state and by input, the
/// lengths of the steps held.
pub fn dormand_prince_sensitivity<const NX: usize, const NU: usize>(
    robot: &(impl Robot<NX, NU> + ?Sized),
    x0: &SVector<f64, NX>,
    u: &SVector<f64, NU>,
    time: f64,
    control: &StepControl,
) -> (Integrated<NX>, Linear<NX, NU>) {
    let mut total = Linear {
        a: SMatrix::identity(),
        b: SMatrix::zeros(),
    };
    let end = adaptive(robot, x0, u, time, control, |x, h| {
        // The same stages, differentiated.
        let mut k = [SVector::<f64, NX>::zeros(); 6];
        let mut s = [total; 6];
        let (mut at, mut by) = (*x, total);
        for stage in 0..6 {
            k[stage] = robot.flow(&at, u);
            let (fx, fu) = robot.jacobians(&at, u);
            s[stage] = Linear {
                a: fx * by.a,
                b: fx * by.b + fu,
            };
            (at, by) = (*x, total);
            for j in 0..=stage {
                let weight = h * A[stage][j];
                at += k[j] * weight;
                by.a += s[j].a * weight;
                by.b += s[j].b * weight;
            }
        }
        total = by;
    });
    (end, total)
}

/// Steps with error control; tells where each accepted step began and how long it was.
fn adaptive<const NX: usize, const NU: usize>(
    robot: &(impl Robot<NX, NU> + ?Sized),
    x0: &SVector<f64, NX>,
    u: &SVector<f64, NU>,
    time: f64,
    control: &StepControl,
    mut accepted: impl FnMut(&SVector<f64, NX>, f64),
) -> Integrated<NX> {
    let mut out = Integrated {
        x: *x0,
        steps: 0,
        finished: time <= 0.0,
    };
    let (mut t, mut h) = (0.0, time.min(control.longest));
    let mut tries = 0;
    while !out.finished && tries < control.most_steps {
        tries += 1;
        let last = t + h >= time;
        if last {
            h = time - t;
        }
        let mut k = [SVector::<f64, NX>::zeros(); 7];
        k[0] = robot.flow(&out.x, u);
        let mut next = out.x;
        for stage in 0..6 {
            next = out.x;
            for (j, slope) in k.iter().enumerate().take(stage + 1) {
                next += slope * (h * A[stage][j]);
            }
            k[stage + 1] = robot.flow(&next, u);
        }
        let mut low = out.x;
        for (slope, weight) in k.iter().zip(LOW) {
            low += slope * (h * weight);
        }
        let error = (next - low).amax() / (1.0 + out.x.amax()) / control.tolerance;
        if !error.is_finite() {
            return out;
        }
        if error <= 1.0 {
            accepted(&out.x, h);
            t += h;
            out.x = next;
            out.steps += 1;
            out.finished = last;
        }
        h *= (0.9 * error.max(1e-10).powf(-0.2)).clamp(0.2, 5.0);
        h = h.min(control.longest);
    }
    out
}

/// A robot whose steps are integrated by [`dormand_prince`]: the paper's roll-out. Where the steps run out or the state
/// stops being finite the step is not finite, which the solver refuses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive<R> {
    /// The robot.
    pub robot: R,
    /// Control of the step.
    pub control: StepControl,
}

impl<R: Robot<NX, NU>, const NX: usize, const NU: usize> Robot<NX, NU> for Adaptive<R> {
    fn flow(&self, x: &SVector<f64, NX>, u: &SVector<f64, NU>) -> SVector<f64, NX> {
        self.robot.flow(x, u)
    }
    fn jacobians(
        &self,
        x: &SVector<f64, NX>,
        u: &SVector<f64, NU>,
    ) -> (SMatrix<f64, NX, NX>, SMatrix<f64, NX, NU>) {
        self.robot.jacobians(x, u)
    }
    fn step(&self, x: &SVector<f64, NX>, u: &SVector<f64, NU>, dt: f64) -> SVector<f64, NX> {
        let end = adaptive(&self.robot, x, u, dt, &self.control, |_, _| {});
        if end.finished {
            end.x
        } else {
            SVector::from_element(f64::NAN)
        }
    }
    fn linearize(
        &self,
        x: &SVector<f64, NX>,
        u: &SVector<f64, NU>,
        dt: f64,
    ) -> (SMatrix<f64, NX, NX>, SMatrix<f64, NX, NU>) {
        let (_, total) = dormand_prince_sensitivity(&self.robot, x, u, dt, &self.control);
        (total.a, total.b)
    }
}
