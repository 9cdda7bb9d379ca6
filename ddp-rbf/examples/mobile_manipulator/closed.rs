//! Closed loop: the plant moves exactly, the controller sees a voxel map.

use crate::esdf;
use crate::problem::{Instance, Outcome, Problem, ROW, Terms, U, X};
use cpu_time::ThreadTime;
use ddp_rbf::{
    Barrier, BoxField, Braking, Constraint, Counts, DriveArm, Field, GridField, GuardParams, LANES,
    Lanes, Mpc, Options, Robot, SafetyLayer, SafetyParams,
};

/// Control period, s.
const PERIOD: f64 = 0.05;
/// A robot whose reference has ended and that has come no nearer to its end for this long gives up and stands, s: the place
/// for a new plan.
const PATIENCE: f64 = 4.0;
/// Time between looks at the exact clearance, s.
const LOOK: f64 = 0.01;
/// Distance from the end of the reference at which a robot has arrived, m.
pub(crate) const ARRIVED: f64 = 0.3;
/// Knots of the horizon of 3 s.
const KNOTS: usize = 60;

/// How a run is controlled.
#[derive(Clone, Copy)]
pub(crate) struct Scheme {
    /// Side of the map's voxels, m.
    pub(crate) cell: f64,
    pub(crate) barrier: Barrier,
    /// Room that the controller keeps from the map beyond what the map may hide, in voxels; `None` keeps none at all.
    pub(crate) margin: Option<f64>,
    /// Whether a guard looks at every command. It keeps what the map may hide.
    pub(crate) guard: bool,
    pub(crate) iterations: usize,
    /// Whether inputs can only change at a limited rate, in the plant too.
    pub(crate) limited: bool,
    /// Length of the run, s.
    pub(crate) duration: f64,
}

impl Scheme {
    /// The defaults: the guard keeps from each sphere what interpolation may hide from it, the controller a third of a voxel
    /// more, so that it steers before the guard stops.
    pub(crate) fn standard(cell: f64) -> Self {
        Self {
            cell,
            barrier: Barrier::default(),
            margin: Some(1.0 / 3.0),
            guard: true,
            iterations: 3,
            limited: false,
            duration: 8.0,
        }
    }

    /// As published: its barrier, no margin, no guard.
    pub(crate) fn paper(cell: f64) -> Self {
        Self {
            barrier: Barrier::paper(),
            margin: None,
            guard: false,
            ..Self::standard(cell)
        }
    }
}

/// A box that appears during a run.
#[derive(Clone, Copy)]
pub(crate) struct Intruder {
    /// When, s.
    pub(crate) time: f64,
    pub(crate) shape: [f64; 6],
}

/// What a run came to.
pub(crate) struct Run {
    /// Least exact clearance, least distance between own spheres, m.
    pub(crate) clearance: f64,
    pub(crate) own: f64,
    /// Least room to the input limits and to the joint limits.
    pub(crate) input_room: f64,
    pub(crate) joint_room: f64,
    /// Distance of the base from the end of its reference at the end, m.
    pub(crate) error: f64,
    /// Sum of the tracking cost of the states.
    pub(crate) tracking: f64,
    pub(crate) counts: Counts,
    /// The last reason for braking.
    pub(crate) braking: Option<Braking>,
    /// Speed of the base and fastest joint at the end.
    pub(crate) speed: f64,
    /// CPU time of each control step after the first, microseconds.
    pub(crate) times: Vec<f64>,
    pub(crate) states: Vec<X>,
    pub(crate) inputs: Vec<U>,
}

impl Run {
    /// No contact, no limit left, and the end reached.
    pub(crate) fn is_good(&self) -> bool {
        self.clearance >= 0.0
            && self.own >= 0.0
            && self.input_room >= -1e-9
            && self.joint_room >= 0.0
            && self.error < ARRIVED
    }
}

/// Runs an instance in closed loop.
pub(crate) fn run(
    problem: &Problem,
    instance: &Instance,
    scheme: &Scheme,
    intruder: Option<Intruder>,
) -> Outcome<Run> {
    let mut boxes = instance.boxes.clone();
    let mut exact = BoxField::new(boxes.clone(), None, problem.beta)?;
    let mut map = Map::new(&boxes, scheme.cell)?;
    let mut pending = intruder;
    let acceleration = if scheme.limited {
        U::from_fn(|i, _| if i == 0 { 0.8 } else { 2.0 })
    } else {
        U::from_element(f64::INFINITY)
    };
    let mut layer = SafetyLayer::new(SafetyParams {
        guard: GuardParams {
            acceleration,
            period: PERIOD,
            look: LOOK,
            margin: 0.0,
        },
        low: -problem.input_limit,
        high: problem.input_limit,
        decrease: 4.0,
    })?;
    let mut mpc = Mpc::new(KNOTS, 3.0 / KNOTS as f64)?;
    let options = Options {
        iterations: scheme.iterations,
        ..Options::real_time()
    };
    let mut x = instance.x0;
    let mut now = U::zeros();
    let mut out = Run {
        clearance: f64::INFINITY,
        own: f64::INFINITY,
        input_room: f64::INFINITY,
        joint_room: f64::INFINITY,
        error: 0.0,
        tracking: 0.0,
        counts: Counts::default(),
        braking: None,
        speed: 0.0,
        times: Vec::new(),
        states: vec![x],
        inputs: Vec::new(),
    };
    let end = instance.states[instance.states.len() - 1];
    let (mut nearest, mut nearest_at) = (f64::INFINITY, 0.0);
    let steps = (scheme.duration / PERIOD).round() as usize;
    for step in 0..steps {
        let t = step as f64 * PERIOD;
        let mut jumped = false;
        if let Some(i) = pending.take_if(|i| t >= i.time) {
            boxes.push(i.shape);
            exact = BoxField::new(boxes.clone(), None, problem.beta)?;
            map = Map::new(&boxes, scheme.cell)?;
            jumped = true;
        }
        let row = (t / ROW).round() as usize;
        let cost = problem.tracking(instance, KNOTS, mpc.dt(), row);
        let start = ThreadTime::now();
        let mut terms = map.terms(problem, scheme.barrier, scheme.margin, 0.01);
        if scheme.limited {
            terms.inputs = terms.inputs.reachable_from(now, acceleration * mpc.dt());
        }
        mpc.shift(PERIOD);
        if jumped {
            mpc.step_from_both(&DriveArm, &cost, &terms.all(), &x, &options)?;
        } else {
            mpc.step(&DriveArm, &cost, &terms.all(), &x, &options)?;
        }
        let away = (x[0] - end[0]).hypot(x[1] - end[1]);
        if away < nearest - 0.01 || t < ROW * instance.states.len() as f64 {
            (nearest, nearest_at) = (away, t);
        }
        let given_up = away > ARRIVED && t - nearest_at > PATIENCE;
        let command = if given_up {
            U::zeros()
        } else {
            mpc.inputs()[0]
        };
        let target = if scheme.guard {
            let hard = map.terms(problem, scheme.barrier, Some(0.0), 0.0);
            let hard: [&dyn Constraint<9, 8>; 4] = [&hard.joints, &hard.base, &hard.arm, &hard.own];
            let room = |x: &X| map.room(problem, x);
            let (u, _) = layer.check(&DriveArm, &x, &now, &command, &hard, room);
            out.braking = layer.braking().or(out.braking);
            u
        } else {
            command
        };
        if step > 0 {
            out.times.push(start.elapsed().as_secs_f64() * 1e6);
        }
        for _ in 0..(PERIOD / LOOK).round() as usize {
            now = U::from_fn(|i, _| {
                let change = acceleration[i] * LOOK;
                now[i] + (target[i] - now[i]).clamp(-change, change)
            });
            x = DriveArm.step(&x, &now, LOOK);
            let (room, own) = problem.clearance(&exact, &x);
            out.clearance = out.clearance.min(room);
            out.own = out.own.min(own);
            for i in 0..8 {
                out.input_room = out.input_room.min(problem.input_limit[i] - now[i].abs());
            }
            for &(i, low, high) in &problem.joint_limits {
                out.joint_room = out.joint_room.min(x[i] - low).min(high - x[i]);
            }
            let at = out.inputs.len() + 1;
            let r = ((at as f64 * LOOK / ROW).round() as usize).min(instance.states.len() - 1);
            let d = x - instance.states[r];
            out.tracking += 0.5 * LOOK * d.component_mul(&d).dot(&problem.state_weight);
            out.states.push(x);
            out.inputs.push(now);
        }
    }
    out.error = (x[0] - end[0]).hypot(x[1] - end[1]);
    out.speed = now.amax();
    out.counts = layer.counts();
    Ok(out)
}

/// The voxel map, with the floor for the arm.
struct Map {
    cell: f64,
    walls: GridField,
    floored: Floored,
}

/// A voxel field over a floor at height 0.
struct Floored(GridField);

impl Field for Floored {
    fn distance_gradient(&self, p: [f64; 3]) -> (f64, [f64; 3]) {
        let (d, g) = self.0.distance_gradient(p);
        if p[2] < d {
            (p[2], [0.0, 0.0, 1.0])
        } else {
            (d, g)
        }
    }

    fn batch(&self, points: &[[Lanes; 3]], out: &mut [[Lanes; 4]]) {
        self.0.batch(points, out);
        for ([_, _, heights], [d, x, y, z]) in points.iter().zip(out) {
            for lane in 0..LANES {
                if heights[lane] < d[lane] {
                    d[lane] = heights[lane];
                    (x[lane], y[lane], z[lane]) = (0.0, 0.0, 1.0);
                }
            }
        }
    }
}

impl Map {
    fn new(boxes: &[[f64; 6]], cell: f64) -> Outcome<Self> {
        let walls = esdf::of_boxes(boxes, cell)?;
        Ok(Self {
            cell,
            floored: Floored(walls.clone()),
            walls,
        })
    }

    /// Room for what interpolation may hide from the smallest sphere of each group, base and arm, and `extra` voxels.
    fn margins(&self, problem: &Problem, extra: Option<f64>) -> [f64; 2] {
        let Some(extra) = extra else { return [0.0; 2] };
        [&problem.base, &problem.arm].map(|group| {
            let radii = group.iter().map(|&i| problem.chain.spheres()[i].radius);
            let least = radii.fold(f64::INFINITY, f64::min);
            self.walls.excess(least) + extra * self.cell
        })
    }

    fn terms<'a>(
        &'a self,
        problem: &'a Problem,
        barrier: Barrier,
        extra: Option<f64>,
        own: f64,
    ) -> Terms<'a, GridField, Floored> {
        let margins = self.margins(problem, extra);
        Terms::new(problem, barrier, margins, own, &self.walls, &self.floored)
    }

    /// Room of a state as the guard counts it: to the map less what it may hide; the robot's own spheres, the floor and the
    /// limits are exact.
    fn room(&self, problem: &Problem, x: &X) -> f64 {
        let centers = problem.chain.centers(x.as_slice()).unwrap_or_default();
        let spheres = problem.chain.spheres();
        let [base, arm] = self.margins(problem, Some(0.0));
        let mut room = f64::INFINITY;
        for &i in &problem.base {
            room = room.min(self.walls.distance(centers[i]) - spheres[i].radius - base);
        }
        for &i in &problem.arm {
            let floor = centers[i][2] - spheres[i].radius;
            let wall = self.walls.distance(centers[i]) - spheres[i].radius - arm;
            room = room.min(floor).min(wall);
        }
        for &(i, j) in &problem.pairs {
            let d = [0, 1, 2].map(|a| centers[i][a] - centers[j][a]);
            let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            room = room.min(length - spheres[i].radius - spheres[j].radius);
        }
        for &(i, low, high) in &problem.joint_limits {
            room = room.min(x[i] - low).min(high - x[i]);
        }
        room
    }
}
