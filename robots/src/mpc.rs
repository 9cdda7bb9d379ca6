//! The robot as `ddp_rbf` sees it: motion with exact discrete sensitivities, clearance to a distance field and to itself.
//!
//! State: x, y, yaw of the base, q1..q6; input v, omega, joint speeds. Models and constraints are evaluated for several knots
//! at once by `ddp_rbf`'s kernels for robots made of spheres.

use crate::base::BaseShape;
use crate::manipulator::MobileManipulator;
use ddp_rbf::{
    Barrier, Chain, Constraint, DriveArm, Expansion, Field, Horizon, Joint, Linear, LinkSphere,
    PairClearance, Penalty, PlaneClearance, Robot, SphereClearance,
};
use nalgebra::{SMatrix, SVector};

type State = SVector<f64, 9>;
type Input = SVector<f64, 8>;

/// Height of the base's spheres above the floor, m: the middle of its body.
const BASE_MIDDLE: f64 = 0.2;
/// Spheres along and across the base.
const BASE_GRID: [usize; 2] = [4, 3];
/// The floor, as a plane that spheres stay above.
const FLOOR: [[f64; 4]; 1] = [[0.0, 0.0, 1.0, 0.0]];

impl Robot<9, 8> for MobileManipulator {
    fn flow(&self, x: &State, u: &Input) -> State {
        DriveArm.flow(x, u)
    }
    fn jacobians(&self, x: &State, u: &Input) -> (SMatrix<f64, 9, 9>, SMatrix<f64, 9, 8>) {
        DriveArm.jacobians(x, u)
    }
    /// Runge-Kutta with a held input is Simpson's rule for this system.
    fn step(&self, x: &State, u: &Input, dt: f64) -> State {
        DriveArm.step(x, u, dt)
    }
    fn linearize(&self, x: &State, u: &Input, dt: f64) -> (SMatrix<f64, 9, 9>, SMatrix<f64, 9, 8>) {
        DriveArm.linearize(x, u, dt)
    }
    fn linearize_all(&self, states: &[State], inputs: &[Input], dt: f64, out: &mut [Linear<9, 8>]) {
        DriveArm.linearize_all(states, inputs, dt, out);
    }
}

/// The robot's spheres on their chain: first the arm's and the camera's, then a grid of them over the base, at half height.
#[derive(Clone, Debug)]
struct Spheres {
    chain: Chain,
    /// Indices of the arm's spheres.
    arm: Vec<usize>,
    /// Indices of all spheres.
    all: Vec<usize>,
}

impl Spheres {
    fn new(robot: &MobileManipulator) -> Result<Self, ddp_rbf::Error> {
        let root = robot.mount.rotation.to_rotation_matrix();
        let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| root[(i, j)]));
        let origin = robot.mount.translation.vector;
        let joints = robot
            .arm
            .dh()
            .map(|[d, a, alpha]| Joint { d, a, alpha })
            .to_vec();
        let mut spheres: Vec<LinkSphere> = robot
            .body
            .spheres
            .iter()
            .map(|s| LinkSphere {
                link: usize::from(s.link.min(6)),
                center: s.center,
                radius: s.radius,
            })
            .collect();
        let arm = (0..spheres.len()).collect();
        // Small enough to stay off the floor.
        let cell = [
            robot.base.length / BASE_GRID[0] as f64,
            robot.base.width / BASE_GRID[1] as f64,
        ];
        spheres.extend((0..BASE_GRID[0] * BASE_GRID[1]).map(|i| {
            let at = [i % BASE_GRID[0], i / BASE_GRID[0]];
            let [x, y] = [0, 1].map(|k| (at[k] as f64 + 0.5 - 0.5 * BASE_GRID[k] as f64) * cell[k]);
            LinkSphere {
                link: 0,
                center: [x, y, BASE_MIDDLE],
                radius: 0.5 * cell[0].hypot(cell[1]),
            }
        }));
        let all = (0..spheres.len()).collect();
        let chain = Chain::new(
            true,
            rows,
            [origin[0], origin[1], origin[2]],
            joints,
            spheres,
        )?;
        Ok(Self { chain, arm, all })
    }
}

/// Two groups of terms under one name.
fn both(a: Penalty, b: Penalty) -> Penalty {
    Penalty {
        sum: a.sum + b.sum,
        least: a.least.min(b.least),
    }
}

/// Every sphere of the robot keeps a margin from the field's surface, and the arm from the floor (HEATS eq. 7).
#[derive(Clone, Debug)]
pub struct FieldClearance<'a, F> {
    spheres: Spheres,
    field: &'a F,
    margin: f64,
    barrier: Barrier,
}

impl<'a, F: Field> FieldClearance<'a, F> {
    /// With `margin` m of room beyond the spheres. A cut-off of the barrier saves most of the work, since most spheres are far
    /// from everything.
    ///
    /// # Errors
    /// [`ddp_rbf::Error::Chain`] for a robot whose figures are not finite.
    pub fn new(
        robot: &MobileManipulator,
        field: &'a F,
        margin: f64,
        barrier: Barrier,
    ) -> Result<Self, ddp_rbf::Error> {
        Ok(Self {
            spheres: Spheres::new(robot)?,
            field,
            margin,
            barrier,
        })
    }

    fn parts(&self) -> (SphereClearance<'_, F>, PlaneClearance<'_>) {
        let (chain, margin, barrier) = (&self.spheres.chain, self.margin, self.barrier);
        (
            SphereClearance {
                chain,
                field: self.field,
                spheres: &self.spheres.all,
                margin,
                on_base: false,
                barrier,
                name: "clearance",
            },
            PlaneClearance {
                chain,
                planes: &FLOOR,
                spheres: &self.spheres.arm,
                margin,
                barrier,
                name: "clearance",
            },
        )
    }
}

impl<F: Field> Constraint<9, 8> for FieldClearance<'_, F> {
    fn name(&self) -> &'static str {
        "clearance"
    }
    fn barrier(&self) -> Barrier {
        self.barrier
    }
    fn values(&self, k: usize, x: &State, u: Option<&Input>, visit: &mut dyn FnMut(f64)) {
        let (field, floor) = self.parts();
        field.values(k, x, u, visit);
        floor.values(k, x, u, visit);
    }
    fn rows(
        &self,
        k: usize,
        x: &State,
        u: Option<&Input>,
        visit: &mut dyn FnMut(f64, &State, &Input),
    ) {
        let (field, floor) = self.parts();
        field.rows(k, x, u, visit);
        floor.rows(k, x, u, visit);
    }
    fn penalize(
        &self,
        along: &Horizon<'_, 9, 8>,
        mut models: Option<&mut [Expansion<9, 8>]>,
    ) -> Penalty {
        let (field, floor) = self.parts();
        let first = field.penalize(along, models.as_deref_mut());
        both(first, floor.penalize(along, models))
    }
}

/// The arm keeps a margin from itself and from the base (HEATS eq. 8).
#[derive(Clone, Debug)]
pub struct SelfClearance<'a> {
    spheres: Spheres,
    base: &'a BaseShape,
    pairs: Vec<(usize, usize)>,
    /// Spheres that can reach the base.
    movable: Vec<usize>,
    margin: f64,
    barrier: Barrier,
}

impl<'a> SelfClearance<'a> {
    /// With `margin` m of room between spheres, and between spheres and the base's box, pedestal and LiDAR.
    ///
    /// # Errors
    /// [`ddp_rbf::Error::Chain`] for a robot whose figures are not finite.
    pub fn new(
        robot: &'a MobileManipulator,
        margin: f64,
        barrier: Barrier,
    ) -> Result<Self, ddp_rbf::Error> {
        let pairs = &robot.body.pairs;
        let body = robot.body.spheres.iter().enumerate();
        Ok(Self {
            spheres: Spheres::new(robot)?,
            base: &robot.base,
            pairs: pairs
                .iter()
                .map(|&(i, j)| (usize::from(i), usize::from(j)))
                .collect(),
            // The column stands on the pedestal by design.
            movable: body.filter(|(_, s)| s.link > 1).map(|(i, _)| i).collect(),
            margin,
            barrier,
        })
    }

    fn parts(&self) -> (PairClearance<'_>, SphereClearance<'_, BaseShape>) {
        let (chain, margin, barrier) = (&self.spheres.chain, self.margin, self.barrier);
        (
            PairClearance {
                chain,
                pairs: &self.pairs,
                margin,
                barrier,
                name: "self-clearance",
            },
            SphereClearance {
                chain,
                field: self.base,
                spheres: &self.movable,
                margin,
                on_base: true,
                barrier,
                name: "self-clearance",
            },
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
    fn values(&self, k: usize, x: &State, u: Option<&Input>, visit: &mut dyn FnMut(f64)) {
        let (pairs, base) = self.parts();
        pairs.values(k, x, u, visit);
        base.values(k, x, u, visit);
    }
    fn rows(
        &self,
        k: usize,
        x: &State,
        u: Option<&Input>,
        visit: &mut dyn FnMut(f64, &State, &Input),
    ) {
        let (pairs, base) = self.parts();
        pairs.rows(k, x, u, visit);
        base.rows(k, x, u, visit);
    }
    fn penalize(
        &self,
        along: &Horizon<'_, 9, 8>,
        mut models: Option<&mut [Expansion<9, 8>]>,
    ) -> Penalty {
        let (pairs, base) = self.parts();
        let first = pairs.penalize(along, models.as_deref_mut());
        both(first, base.penalize(along, models))
    }
}

/// Distance to the base's box, pedestal and LiDAR in the base frame. The gradient is that of the nearest of the three; on
/// edges between two of them it is one of both.
impl Field for BaseShape {
    fn distance_gradient(&self, p: [f64; 3]) -> (f64, [f64; 3]) {
        let half = [0.5 * self.length, 0.5 * self.width, 0.5 * self.height];
        let from = [p[0], p[1], p[2] - half[2]];
        let out = [0, 1, 2].map(|a| from[a].abs() - half[a]);
        let side = [0, 1, 2].map(|a| if from[a] < 0.0 { -1.0 } else { 1.0 });
        let cuboid = {
            let above = out.map(|v| v.max(0.0));
            let length = norm(above);
            if length > 0.0 {
                (length, [0, 1, 2].map(|a| side[a] * above[a] / length))
            } else {
                let deepest = out[0].max(out[1]).max(out[2]);
                let mut way = [0.0; 3];
                let a = (0..3).find(|&a| out[a] == deepest).unwrap_or(2);
                way[a] = side[a];
                (deepest, way)
            }
        };
        let pedestal = {
            let d = [p[0] - self.pedestal[0], p[1] - self.pedestal[1], 0.0];
            let radial = norm(d);
            let outward = d.map(|v| v / radial.max(1e-12));
            let (around, above) = (radial - self.pedestal_radius, p[2] - self.pedestal_top);
            if around.max(above) > 0.0 {
                let (a, b) = (around.max(0.0), above.max(0.0));
                let length = (a * a + b * b).sqrt();
                (
                    length,
                    [outward[0] * a / length, outward[1] * a / length, b / length],
                )
            } else if around > above {
                (around, outward)
            } else {
                (above, [0.0, 0.0, 1.0])
            }
        };
        let lidar = {
            let d = [0, 1, 2].map(|a| p[a] - self.lidar[a]);
            let length = norm(d);
            (length - self.lidar_radius, d.map(|v| v / length.max(1e-12)))
        };
        let nearer = |a: (f64, [f64; 3]), b: (f64, [f64; 3])| if b.0 < a.0 { b } else { a };
        nearer(nearer(cuboid, pedestal), lidar)
    }
    fn distance(&self, point: [f64; 3]) -> f64 {
        Self::distance(self, point)
    }
}

fn norm(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}
