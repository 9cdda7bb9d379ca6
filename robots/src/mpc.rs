//! The mobile manipulator for `ddp-rbf`: planar base and arm as one kinematic model, and its collision constraints
//! (HEATS eq. 7, 8).
//!
//! State x, y, yaw, q1..q6; input v, omega, joint speeds.

use crate::body::ARM_SPHERES;
use crate::frame::Frame;
use crate::jacobians::point_jacobian;
use crate::manipulator::{BodyState, MobileManipulator};
use ddp_rbf::{Barrier, Constraint, Field, Robot};
use nalgebra::{SMatrix, SVector};

type State = SVector<f64, 9>;
type Input = SVector<f64, 8>;

/// Height of the base's spheres above the floor, m: the middle of its body.
const BASE_MIDDLE: f64 = 0.2;

impl Robot<9, 8> for MobileManipulator {
    fn flow(&self, x: &State, u: &Input) -> State {
        let (s, c) = x[2].sin_cos();
        let mut rate = State::zeros();
        rate[0] = u[0] * c;
        rate[1] = u[0] * s;
        rate[2] = u[1];
        for j in 0..6 {
            rate[3 + j] = u[2 + j];
        }
        rate
    }

    fn jacobians(&self, x: &State, u: &Input) -> (SMatrix<f64, 9, 9>, SMatrix<f64, 9, 8>) {
        let (s, c) = x[2].sin_cos();
        let (mut a, mut b) = (SMatrix::zeros(), SMatrix::zeros());
        a[(0, 2)] = -u[0] * s;
        a[(1, 2)] = u[0] * c;
        b[(0, 0)] = c;
        b[(1, 0)] = s;
        b[(2, 1)] = 1.0;
        for j in 0..6 {
            b[(3 + j, 2 + j)] = 1.0;
        }
        (a, b)
    }

    /// Runge-Kutta with a held input is Simpson's rule for this system.
    fn step(&self, x: &State, u: &Input, dt: f64) -> State {
        let (cos, sin) = simpson(x[2], u[1] * dt);
        let mut next = *x;
        next[0] += dt * u[0] * cos;
        next[1] += dt * u[0] * sin;
        next[2] += dt * u[1];
        for j in 0..6 {
            next[3 + j] += dt * u[2 + j];
        }
        next
    }

    fn linearize(&self, x: &State, u: &Input, dt: f64) -> (SMatrix<f64, 9, 9>, SMatrix<f64, 9, 8>) {
        let turn = u[1] * dt;
        let (cos, sin) = simpson(x[2], turn);
        // Derivatives of the means by the turn: the middle counts half of it, the end all.
        let ((sm, cm), (se, ce)) = ((x[2] + 0.5 * turn).sin_cos(), (x[2] + turn).sin_cos());
        let (dcos, dsin) = (-(2.0 * sm + se) / 6.0, (2.0 * cm + ce) / 6.0);
        let (mut a, mut b) = (SMatrix::identity(), SMatrix::zeros());
        a[(0, 2)] = -dt * u[0] * sin;
        a[(1, 2)] = dt * u[0] * cos;
        b[(0, 0)] = dt * cos;
        b[(1, 0)] = dt * sin;
        b[(0, 1)] = dt * u[0] * dcos * dt;
        b[(1, 1)] = dt * u[0] * dsin * dt;
        b[(2, 1)] = dt;
        for j in 0..6 {
            b[(3 + j, 2 + j)] = dt;
        }
        (a, b)
    }
}

/// Means of cosine and sine from `yaw` to `yaw + turn` by Simpson's rule.
fn simpson(yaw: f64, turn: f64) -> (f64, f64) {
    let ((s0, c0), (s1, c1), (s2, c2)) = (
        yaw.sin_cos(),
        (yaw + 0.5 * turn).sin_cos(),
        (yaw + turn).sin_cos(),
    );
    ((c0 + 4.0 * c1 + c2) / 6.0, (s0 + 4.0 * s1 + s2) / 6.0)
}

fn state_of(x: &State) -> BodyState {
    BodyState {
        base: [x[0], x[1], x[2]],
        joints: std::array::from_fn(|j| x[3 + j]),
    }
}

/// Every sphere of the robot keeps `margin` from the field's surface, and the arm from the floor (HEATS eq. 7).
pub struct FieldClearance<'a, F> {
    /// The robot.
    pub robot: &'a MobileManipulator,
    /// Distance to obstacles.
    pub field: &'a F,
    /// Room beyond the spheres, m.
    pub margin: f64,
    /// Penalty; a cut-off saves most of the work, since most spheres are far from everything.
    pub barrier: Barrier,
}

impl<F: Field> FieldClearance<'_, F> {
    /// Visits every sphere: centre, radius and margin, and its link (`None` for the base).
    fn spheres(&self, x: &State, mut visit: impl FnMut([f64; 3], f64, Option<usize>, &[Frame; 7])) {
        let state = state_of(x);
        let frames = self.robot.arm_frames(&state);
        for s in &self.robot.body.spheres {
            let link = usize::from(s.link.min(6));
            visit(
                frames[link].apply(s.center),
                s.radius + self.margin,
                Some(link),
                &frames,
            );
        }
        let (sin, cos) = x[2].sin_cos();
        for &([ox, oy], radius) in self.robot.base_circles() {
            let p = [
                x[0] + cos * ox - sin * oy,
                x[1] + sin * ox + cos * oy,
                BASE_MIDDLE,
            ];
            visit(p, radius + self.margin, None, &frames);
        }
    }
}

impl<F: Field> Constraint<9, 8> for FieldClearance<'_, F> {
    fn name(&self) -> &'static str {
        "clearance"
    }
    fn barrier(&self) -> Barrier {
        self.barrier
    }
    fn values(&self, _: usize, x: &State, _: Option<&Input>, visit: &mut dyn FnMut(f64)) {
        self.spheres(x, |p, needs, link, _| {
            visit(self.field.distance(p) - needs);
            if link.is_some() {
                visit(p[2] - needs);
            }
        });
    }
    fn rows(
        &self,
        _: usize,
        x: &State,
        _: Option<&Input>,
        visit: &mut dyn FnMut(f64, &State, &Input),
    ) {
        let end = self.barrier.cutoff.unwrap_or(f64::INFINITY);
        let none = Input::zeros();
        self.spheres(x, |p, needs, link, frames| {
            let (distance, gradient) = self.field.distance_gradient(p);
            let (z, floor) = (distance - needs, p[2] - needs);
            if z >= end && (link.is_none() || floor >= end) {
                return;
            }
            let jacobian = match link {
                Some(link) => point_jacobian(frames, [x[0], x[1], x[2]], p, link),
                None => base_jacobian(x, p),
            };
            if z < end {
                let row = State::from_fn(|i, _| (0..3).map(|a| gradient[a] * jacobian[a][i]).sum());
                visit(z, &row, &none);
            }
            if link.is_some() && floor < end {
                visit(floor, &State::from_fn(|i, _| jacobian[2][i]), &none);
            }
        });
    }
}

/// d(point of the base)/d(state).
fn base_jacobian(x: &State, p: [f64; 3]) -> [[f64; 9]; 3] {
    let mut jacobian = [[0.0; 9]; 3];
    jacobian[0][0] = 1.0;
    jacobian[1][1] = 1.0;
    jacobian[0][2] = x[1] - p[1];
    jacobian[1][2] = p[0] - x[0];
    jacobian
}

/// The arm keeps `margin` from itself and from the base (HEATS eq. 8).
pub struct SelfClearance<'a> {
    /// The robot.
    pub robot: &'a MobileManipulator,
    /// Room between spheres, m.
    pub margin: f64,
    /// Penalty.
    pub barrier: Barrier,
}

impl SelfClearance<'_> {
    /// Visits every distance in the base frame: z, the gradient's direction, and the sphere or spheres it moves.
    fn terms(
        &self,
        centers: &[[f64; 3]; ARM_SPHERES],
        end: f64,
        mut visit: impl FnMut(f64, [f64; 3], usize, Option<usize>),
    ) {
        let spheres = &self.robot.body.spheres;
        for &(i, j) in &self.robot.body.pairs {
            let (i, j) = (usize::from(i), usize::from(j));
            let way = [0, 1, 2].map(|a| centers[i][a] - centers[j][a]);
            let norm = way.iter().map(|v| v * v).sum::<f64>().sqrt();
            let z = norm - spheres[i].radius - spheres[j].radius - self.margin;
            if z < end {
                visit(z, way.map(|v| v / norm.max(1e-9)), i, Some(j));
            }
        }
        for (i, s) in spheres.iter().enumerate().filter(|(_, s)| s.link > 1) {
            let z = self.robot.base.distance(centers[i]) - s.radius - self.margin;
            if z < end {
                // The distance to box, pedestal and LiDAR has corners; central differences serve on both sides of them.
                let h = 1e-5;
                let gradient = [0, 1, 2].map(|a| {
                    let (mut high, mut low) = (centers[i], centers[i]);
                    high[a] += h;
                    low[a] -= h;
                    (self.robot.base.distance(high) - self.robot.base.distance(low)) / (2.0 * h)
                });
                visit(z, gradient, i, None);
            }
        }
    }

    fn centers(&self, x: &State) -> ([Frame; 7], [[f64; 3]; ARM_SPHERES]) {
        let state = BodyState {
            base: [0.0; 3],
            ..state_of(x)
        };
        let frames = self.robot.arm_frames(&state);
        let spheres = &self.robot.body.spheres;
        (
            frames,
            std::array::from_fn(|i| {
                frames[usize::from(spheres[i].link.min(6))].apply(spheres[i].center)
            }),
        )
    }
}

impl Constraint<9, 8> for SelfClearance<'_> {
    fn name(&self) -> &'static str {
        "self-clearance"
    }
    fn barrier(&self) -> Barrier {
        self.barrier
    }
    fn values(&self, _: usize, x: &State, _: Option<&Input>, visit: &mut dyn FnMut(f64)) {
        let end = self.barrier.cutoff.unwrap_or(f64::INFINITY);
        let (_, centers) = self.centers(x);
        self.terms(&centers, end, |z, _, _, _| visit(z));
    }
    fn rows(
        &self,
        _: usize,
        x: &State,
        _: Option<&Input>,
        visit: &mut dyn FnMut(f64, &State, &Input),
    ) {
        let end = self.barrier.cutoff.unwrap_or(f64::INFINITY);
        let none = Input::zeros();
        let (frames, centers) = self.centers(x);
        let spheres = &self.robot.body.spheres;
        let jacobian = |i: usize| {
            point_jacobian(
                &frames,
                [0.0; 3],
                centers[i],
                usize::from(spheres[i].link.min(6)),
            )
        };
        self.terms(&centers, end, |z, direction, i, j| {
            let (here, there) = (jacobian(i), j.map(jacobian));
            let mut row = State::zeros();
            for k in 3..9 {
                row[k] = (0..3)
                    .map(|a| direction[a] * (here[a][k] - there.map_or(0.0, |t| t[a][k])))
                    .sum();
            }
            visit(z, &row, &none);
        });
    }
}
