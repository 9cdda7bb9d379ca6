//! Ready-made robots: integrators on a differential drive, and any robot with limited acceleration.

use crate::elementary::sin_cos;
use crate::robot::{Linear, Robot};
use crate::simd::{Kernel, LANES, NARROW, Vector, dispatch, dispatch_narrow};
use nalgebra::{SMatrix, SVector};

/// A differential drive that carries integrators: state `[x, y, yaw, q...]`, input `[v, omega, q rates...]`, so that
/// `NX = NU + 1`. The step is the Runge-Kutta one, which is Simpson's rule for this system: exact to the fifth power of the
/// angle turned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriveArm;

impl DriveArm {
    /// Fails to compile for sizes that do not belong together.
    const fn check<const NX: usize, const NU: usize>() {
        assert!(
            NU >= 2 && NX == NU + 1,
            "a drive with an arm has one more state than inputs"
        );
    }
}

impl<const NX: usize, const NU: usize> Robot<NX, NU> for DriveArm {
    fn flow(&self, x: &SVector<f64, NX>, u: &SVector<f64, NU>) -> SVector<f64, NX> {
        const { Self::check::<NX, NU>() };
        let (s, c) = x[2].sin_cos();
        SVector::from_fn(|i, _| match i {
            0 => u[0] * c,
            1 => u[0] * s,
            i => u[i - 1],
        })
    }

    fn jacobians(
        &self,
        x: &SVector<f64, NX>,
        u: &SVector<f64, NU>,
    ) -> (SMatrix<f64, NX, NX>, SMatrix<f64, NX, NU>) {
        const { Self::check::<NX, NU>() };
        let (s, c) = x[2].sin_cos();
        let (mut a, mut b) = (SMatrix::zeros(), SMatrix::zeros());
        a[(0, 2)] = -u[0] * s;
        a[(1, 2)] = u[0] * c;
        b[(0, 0)] = c;
        b[(1, 0)] = s;
        for i in 2..NX {
            b[(i, i - 1)] = 1.0;
        }
        (a, b)
    }

    #[inline]
    fn step(&self, x: &SVector<f64, NX>, u: &SVector<f64, NU>, dt: f64) -> SVector<f64, NX> {
        const { Self::check::<NX, NU>() };
        // Start, middle and end of the turn in three of the four lanes.
        let turn = u[1] * dt;
        let [cos, sin] = dispatch_narrow(Simpson([x[2], x[2] + 0.5 * turn, x[2] + turn, x[2]]));
        let mut next = *x;
        next[0] += dt * u[0] * cos;
        next[1] += dt * u[0] * sin;
        for i in 2..NX {
            next[i] += dt * u[i - 1];
        }
        next
    }

    fn linearize(
        &self,
        x: &SVector<f64, NX>,
        u: &SVector<f64, NU>,
        dt: f64,
    ) -> (SMatrix<f64, NX, NX>, SMatrix<f64, NX, NU>) {
        let mut out = [Linear {
            a: SMatrix::zeros(),
            b: SMatrix::zeros(),
        }];
        self.linearize_all(
            std::slice::from_ref(x),
            std::slice::from_ref(u),
            dt,
            &mut out,
        );
        (out[0].a, out[0].b)
    }

    fn linearize_all(
        &self,
        states: &[SVector<f64, NX>],
        inputs: &[SVector<f64, NU>],
        dt: f64,
        out: &mut [Linear<NX, NU>],
    ) {
        const { Self::check::<NX, NU>() };
        dispatch(Linearize {
            states,
            inputs,
            dt,
            out,
        });
    }
}

/// Means of cosine and sine by Simpson's rule from their values at start, middle and end.
struct Simpson([f64; NARROW]);

impl Kernel<NARROW> for Simpson {
    type Output = [f64; 2];
    #[inline(always)]
    fn run<V: Vector<NARROW>>(self) -> [f64; 2] {
        let (s, c) = sin_cos(V::load(&self.0));
        [c.array(), s.array()].map(|v| (v[0] + 4.0 * v[1] + v[2]) / 6.0)
    }
}

struct Linearize<'a, const NX: usize, const NU: usize> {
    states: &'a [SVector<f64, NX>],
    inputs: &'a [SVector<f64, NU>],
    dt: f64,
    out: &'a mut [Linear<NX, NU>],
}

impl<const NX: usize, const NU: usize> Kernel for Linearize<'_, NX, NU> {
    type Output = ();
    #[inline(always)]
    fn run<V: Vector>(self) {
        let n = self.inputs.len().min(self.states.len()).min(self.out.len());
        let dt = V::splat(self.dt);
        let sixth = V::splat(1.0 / 6.0);
        let two = V::splat(2.0);
        let mut k = 0;
        while k < n {
            let lanes = LANES.min(n - k);
            let mut rows = [[0.0; LANES]; 3];
            for lane in 0..LANES {
                // A group that is not full repeats its last knot.
                let knot = k + lane.min(lanes - 1);
                rows[0][lane] = self.states[knot][2];
                rows[1][lane] = self.inputs[knot][0];
                rows[2][lane] = self.inputs[knot][1];
            }
            let (yaw, v, w) = (V::load(&rows[0]), V::load(&rows[1]), V::load(&rows[2]));
            let turn = w * dt;
            let (s0, c0) = sin_cos(yaw);
            let (s1, c1) = sin_cos(turn.mul_add(V::splat(0.5), yaw));
            let (s2, c2) = sin_cos(yaw + turn);
            let four = V::splat(4.0);
            let cos = (c1.mul_add(four, c0) + c2) * sixth * dt;
            let sin = (s1.mul_add(four, s0) + s2) * sixth * dt;
            // By the turning rate: the middle counts half of the turn, the end all of it.
            let dcos = -(s1.mul_add(two, s2) * sixth * v * dt * dt);
            let dsin = c1.mul_add(two, c2) * sixth * v * dt * dt;
            let (ax, ay) = ((-(sin * v)).array(), (cos * v).array());
            let (cos, sin, dcos, dsin) = (cos.array(), sin.array(), dcos.array(), dsin.array());
            for lane in 0..lanes {
                let out = &mut self.out[k + lane];
                out.a = SMatrix::identity();
                out.b = SMatrix::zeros();
                out.a[(0, 2)] = ax[lane];
                out.a[(1, 2)] = ay[lane];
                out.b[(0, 0)] = cos[lane];
                out.b[(1, 0)] = sin[lane];
                out.b[(0, 1)] = dcos[lane];
                out.b[(1, 1)] = dsin[lane];
                for i in 2..NX {
                    out.b[(i, i - 1)] = self.dt;
                }
            }
            k += LANES;
        }
    }
}

/// A robot whose inputs are states and are driven by their rates: state `[x, u]`, input `du/dt`, so that `NZ = NX + NU`.
/// Limits on velocities become a [`StateBox`](crate::StateBox), limits on accelerations an
/// [`InputBox`](crate::InputBox).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Accelerated<R, const NX: usize>(pub R);

impl<R, const NX: usize, const NU: usize, const NZ: usize> Robot<NZ, NU> for Accelerated<R, NX>
where
    R: Robot<NX, NU>,
{
    fn flow(&self, z: &SVector<f64, NZ>, rate: &SVector<f64, NU>) -> SVector<f64, NZ> {
        const {
            assert!(
                NZ == NX + NU,
                "an accelerated robot's state holds the robot's state and input"
            )
        };
        let (x, u) = parts::<NX, NU, NZ>(z);
        let flow = self.0.flow(&x, &u);
        SVector::from_fn(|i, _| if i < NX { flow[i] } else { rate[i - NX] })
    }

    fn jacobians(
        &self,
        z: &SVector<f64, NZ>,
        _: &SVector<f64, NU>,
    ) -> (SMatrix<f64, NZ, NZ>, SMatrix<f64, NZ, NU>) {
        let (x, u) = parts::<NX, NU, NZ>(z);
        let (fx, fu) = self.0.jacobians(&x, &u);
        let a = SMatrix::from_fn(|i, j| match (i < NX, j < NX) {
            (true, true) => fx[(i, j)],
            (true, false) => fu[(i, j - NX)],
            _ => 0.0,
        });
        let b = SMatrix::from_fn(|i, j| f64::from(u8::from(i == NX + j)));
        (a, b)
    }
}

fn parts<const NX: usize, const NU: usize, const NZ: usize>(
    z: &SVector<f64, NZ>,
) -> (SVector<f64, NX>, SVector<f64, NU>) {
    (
        SVector::from_fn(|i, _| z[i]),
        SVector::from_fn(|i, _| z[NX + i]),
    )
}
