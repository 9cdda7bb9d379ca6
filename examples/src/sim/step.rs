//! The robot in the world: limits, motion, contact, and when sensors are due.

use super::PointScan;
use super::body::{Body, CameraPose, Kinematics};
use super::camera::DepthCamera;
use super::detector::{Detection, TagDetector};
use super::lidar::Lidar;
use super::world::World;

/// Length of a tick, s.
pub const TICK: f64 = 0.02;
/// Joints of the arm.
pub const JOINTS: usize = 6;
/// What a command may exceed a limit by before it counts as a violation.
const SLACK: f64 = 1e-6;
/// A contact episode ends when the robot is this much farther away than when it began, m.
const SEPARATION: f64 = 0.005;

/// Limits of the robot's motion. Default: HEATS sect. VI-B and G item 52.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionLimits {
    /// Speed of the base, m/s.
    pub v: f64,
    /// Turn rate of the base, rad/s.
    pub w: f64,
    /// Acceleration of the base, m/s2.
    pub a: f64,
    /// Turn acceleration of the base, rad/s2.
    pub alpha: f64,
    /// Speed of each joint, rad/s.
    pub joint_v: [f64; JOINTS],
    /// Acceleration of each joint, rad/s2.
    pub joint_a: [f64; JOINTS],
    /// Lowest and highest angle of each joint, rad.
    pub joint_range: [(f64, f64); JOINTS],
}

impl Default for MotionLimits {
    fn default() -> Self {
        let turn = (-std::f64::consts::TAU, std::f64::consts::TAU);
        let mut joint_range = [turn; JOINTS];
        // UR5e: the elbow alone is limited to half a turn each way.
        joint_range[2] = (-std::f64::consts::PI, std::f64::consts::PI);
        Self {
            v: 0.8,
            w: 1.5,
            a: 0.8,
            alpha: 2.0,
            joint_v: [0.8; JOINTS],
            joint_a: [2.0; JOINTS],
            joint_range,
        }
    }
}

impl MotionLimits {
    /// The defaults with a scene's speeds.
    pub fn for_scene(limits: &crate::scene::Limits) -> Self {
        Self {
            v: limits.v_max,
            w: limits.w_max,
            joint_v: [limits.joint_v_max; JOINTS],
            ..Self::default()
        }
    }

    fn check(&self) -> Result<(), StartError> {
        let ends = self
            .joint_range
            .iter()
            .flat_map(|(low, high)| [low.abs(), high.abs(), high - low]);
        let speeds = [self.v, self.w, self.a, self.alpha].into_iter();
        let mut all = speeds.chain(self.joint_v).chain(self.joint_a).chain(ends);
        all.find(|v| !(v.is_finite() && *v >= 0.0))
            .map_or(Ok(()), |v| Err(StartError::Limit(v)))
    }
}

/// Velocities asked for over one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Command {
    /// Forward speed, m/s.
    pub v: f64,
    /// Turn rate, rad/s.
    pub w: f64,
    /// Joint speeds, rad/s.
    pub qd: [f64; JOINTS],
}

/// State of the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Base pose x, y, yaw in the world frame, m and rad; the yaw is not wrapped.
    pub base: [f64; 3],
    /// Joint angles, rad.
    pub joints: [f64; JOINTS],
    /// Forward speed, m/s.
    pub v: f64,
    /// Turn rate, rad/s.
    pub w: f64,
    /// Joint speeds, rad/s.
    pub qd: [f64; JOINTS],
}

/// What a run cost so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tally {
    /// Sum of base translation, m.
    pub base_path: f64,
    /// Sum over joints and ticks of |dq|, rad.
    pub joint_rotation: f64,
    /// Contact episodes.
    pub collisions: usize,
    /// Smallest exact distance between robot and world, m; 0 after a contact.
    pub min_clearance: f64,
    /// Ticks whose command asked for more than the limits allow.
    pub limit_violations: usize,
}

/// Sensors that take a measurement at the present tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Due {
    /// A LiDAR scan.
    pub lidar: bool,
    /// A depth image.
    pub depth: bool,
    /// An RGB image.
    pub rgb: bool,
}

/// The robot cannot stand at its start.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StartError {
    /// A coordinate of the base is NaN or infinite.
    #[error("base pose {0:?} is not finite")]
    Base([f64; 3]),
    /// A joint is NaN or outside its range.
    #[error("joint {joint} at {angle} rad is outside its range")]
    Joint {
        /// Its index.
        joint: usize,
        /// Its angle, rad.
        angle: f64,
    },
    /// A limit is NaN, infinite or negative.
    #[error("motion limit {0} must be finite and not negative")]
    Limit(f64),
    /// A part touches the world.
    #[error("at the start the robot's {part} touches {obstacle} (distance {distance:.4} m)")]
    Contact {
        /// Name of the part.
        part: &'static str,
        /// Name of the shape, `floor` or `ceiling`.
        obstacle: String,
        /// Distance, m, zero or negative.
        distance: f64,
    },
}

/// The simulated robot and its sensors in a world.
///
/// One call of [`step`](Self::step) is one tick of [`TICK`] seconds. Sensors cost no simulated time; they fall due at
/// their rates, the first time at tick 0.
#[derive(Clone, Debug)]
pub struct Simulator<K> {
    /// The kinematics.
    pub kinematics: K,
    world: World,
    limits: MotionLimits,
    lidar: Lidar,
    depth: DepthCamera,
    detector: TagDetector,
    state: State,
    ticks: u64,
    tally: Tally,
    body: Body,
    camera: CameraPose,
    turn: f64,
    /// Distance at which the present contact episode ends, m.
    contact_until: Option<f64>,
}

/// Ticks between two measurements.
fn period(rate: f64) -> u64 {
    ((1.0 / (rate * TICK)).round() as u64).max(1)
}

/// Largest speed from which a joint that moves on for one tick can then stop within `room`:
/// v^2 / 2a + v TICK = room. Braking at `a` from such a speed keeps to it at every later tick.
pub(crate) fn stoppable(room: f64, a: f64) -> f64 {
    let room = room.max(0.0);
    if a > 0.0 {
        a * ((TICK * TICK + 2.0 * room / a).sqrt() - TICK)
    } else {
        room / TICK
    }
}

/// Angle between two rotations, rad.
fn angle(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> f64 {
    // Half the Frobenius distance is sqrt(2) sin(angle / 2); accurate near zero, unlike the trace.
    let d2: f64 = (0..3)
        .flat_map(|i| (0..3).map(move |j| (a[i][j] - b[i][j]).powi(2)))
        .sum();
    2.0 * (d2.sqrt() / 8.0_f64.sqrt()).clamp(0.0, 1.0).asin()
}

impl<K: Kinematics> Simulator<K> {
    /// Puts the robot at rest at a base pose and joint angles.
    ///
    /// # Errors
    /// [`StartError`] when the state is not finite or touches something.
    pub fn new(
        kinematics: K,
        world: World,
        limits: MotionLimits,
        sensors: (Lidar, DepthCamera, TagDetector),
        base: [f64; 3],
        joints: [f64; JOINTS],
    ) -> Result<Self, StartError> {
        limits.check()?;
        if !base.iter().all(|v| v.is_finite()) {
            return Err(StartError::Base(base));
        }
        let inside = |(angle, (low, high)): (&f64, &(f64, f64))| angle >= low && angle <= high;
        let pairs = || joints.iter().zip(&limits.joint_range);
        if let Some(joint) = pairs().position(|pair| !inside(pair)) {
            return Err(StartError::Joint {
                joint,
                angle: joints[joint],
            });
        }
        let state = State {
            base,
            joints,
            v: 0.0,
            w: 0.0,
            qd: [0.0; JOINTS],
        };
        let mut body = Body::default();
        kinematics.body(base, &joints, &mut body);
        let clearance = world.clearance(&body, f64::INFINITY);
        if clearance.distance <= 0.0 {
            return Err(StartError::Contact {
                part: clearance.part.map_or("body", |i| body.parts[i].name),
                obstacle: clearance.solid.map_or_else(
                    || "floor or ceiling".to_owned(),
                    |i| world.solids()[i].name.clone(),
                ),
                distance: clearance.distance,
            });
        }
        let camera = kinematics.camera(base, &joints);
        let (lidar, depth, detector) = sensors;
        Ok(Self {
            kinematics,
            world,
            limits,
            lidar,
            depth,
            detector,
            state,
            ticks: 0,
            tally: Tally {
                base_path: 0.0,
                joint_rotation: 0.0,
                collisions: 0,
                min_clearance: clearance.distance,
                limit_violations: 0,
            },
            body,
            camera,
            turn: 0.0,
            contact_until: None,
        })
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.ticks as f64 * TICK
    }

    /// Ticks so far.
    pub fn ticks(&self) -> u64 {
        self.ticks
    }

    /// State of the robot.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// What the run cost so far.
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// The limits it enforces.
    pub fn limits(&self) -> &MotionLimits {
        &self.limits
    }

    /// Ground truth; not for planners.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Distance from the robot to another world, m; `up_to` when nothing is nearer.
    pub(crate) fn room_in(&self, world: &World, up_to: f64) -> f64 {
        world.clearance(&self.body, up_to).distance
    }

    /// Changes the world around the robot, and counts how near it then is.
    pub(crate) fn change<T>(&mut self, change: impl FnOnce(&mut World) -> T) -> T {
        let changed = change(&mut self.world);
        let distance = self.room_in(&self.world, self.tally.min_clearance);
        self.tally.min_clearance = self.tally.min_clearance.min(distance);
        changed
    }

    /// Notes that RGB images that were due did not come.
    pub fn miss_image(&mut self) {
        self.detector.interrupt();
    }

    /// Pose of the camera.
    pub fn camera(&self) -> &CameraPose {
        &self.camera
    }

    /// How fast the camera turned over the last tick, rad/s.
    pub fn camera_turn(&self) -> f64 {
        self.turn
    }

    /// Tags found so far.
    pub fn found(&self) -> &[Detection] {
        self.detector.found()
    }

    /// Exact distance between robot and world now, m; `up_to` when nothing is nearer.
    pub fn clearance(&self, up_to: f64) -> f64 {
        self.world.clearance(&self.body, up_to).distance
    }

    /// The velocities that a command leads to: within speed and acceleration limits, and whether it asked for
    /// more. A component that is not finite asks for rest.
    pub fn admit(&self, command: &Command) -> (Command, bool) {
        let mut violated = false;
        let mut clip = |asked: f64, now: f64, speed: f64, acceleration: f64| {
            let step = acceleration * TICK;
            let wanted = if asked.is_finite() { asked } else { 0.0 };
            violated |= !asked.is_finite()
                || asked.abs() > speed + SLACK
                || (asked - now).abs() > step + SLACK;
            // A robot never faster than its limit can always reach the clipped speed's side of it.
            wanted
                .clamp(-speed, speed)
                .clamp(now - step, now + step)
                .clamp(-speed, speed)
        };
        let (s, l) = (&self.state, &self.limits);
        let v = clip(command.v, s.v, l.v, l.a);
        let w = clip(command.w, s.w, l.w, l.alpha);
        let mut qd = [0.0; JOINTS];
        for k in 0..JOINTS {
            qd[k] = clip(command.qd[k], s.qd[k], l.joint_v[k], l.joint_a[k]);
        }
        for k in 0..JOINTS {
            // Fast enough to stop before the end of the joint's range, and no faster.
            let (low, high) = l.joint_range[k];
            let down = stoppable(s.joints[k] - low, l.joint_a[k]);
            let up = stoppable(high - s.joints[k], l.joint_a[k]);
            violated |= qd[k] < -down - SLACK || qd[k] > up + SLACK;
            qd[k] = qd[k].clamp(-down, up);
        }
        (Command { v, w, qd }, violated)
    }

    /// Advances one tick. A move that would touch something is refused: the robot stays where it is, at rest.
    /// Returns whether it moved freely.
    pub fn step(&mut self, command: &Command) -> bool {
        self.ticks += 1;
        let (admitted, violated) = self.admit(command);
        self.tally.limit_violations += usize::from(violated);
        let Command { v, w, qd } = admitted;
        let base = drive(self.state.base, v, w, TICK);
        let mut joints = self.state.joints;
        for k in 0..JOINTS {
            let (low, high) = self.limits.joint_range[k];
            joints[k] = (joints[k] + qd[k] * TICK).clamp(low, high);
        }
        let still = v == 0.0 && w == 0.0 && qd.iter().all(|&q| q == 0.0);
        if !still {
            self.kinematics.body(base, &joints, &mut self.body);
            // Exact below the smallest distance so far, and below what would end the present contact.
            let bound = self
                .tally
                .min_clearance
                .max(self.contact_until.unwrap_or(SEPARATION));
            let distance = self.world.clearance(&self.body, bound).distance;
            if distance <= 0.0 {
                self.refuse();
                return false;
            }
            self.tally.min_clearance = self.tally.min_clearance.min(distance);
            if self.contact_until.is_some_and(|end| distance >= end) {
                self.contact_until = None;
            }
        }
        self.tally.base_path += v.abs() * TICK;
        self.tally.joint_rotation += (0..JOINTS)
            .map(|k| (joints[k] - self.state.joints[k]).abs())
            .sum::<f64>();
        self.state = State {
            base,
            joints,
            v,
            w,
            qd,
        };
        let camera = self.kinematics.camera(base, &joints);
        self.turn = angle(&camera.0, &self.camera.0) / TICK;
        self.camera = camera;
        true
    }

    fn refuse(&mut self) {
        let State { base, joints, .. } = self.state;
        self.state = State {
            base,
            joints,
            v: 0.0,
            w: 0.0,
            qd: [0.0; JOINTS],
        };
        self.turn = 0.0;
        self.kinematics.body(base, &joints, &mut self.body);
        if self.contact_until.is_none() {
            self.tally.collisions += 1;
            let here = self.world.clearance(&self.body, 1.0).distance;
            self.contact_until = Some(here.max(0.0) + SEPARATION);
        }
        self.tally.min_clearance = 0.0;
    }

    /// Sensors that take a measurement at the present tick.
    pub fn due(&self) -> Due {
        let at = |rate| self.ticks.is_multiple_of(period(rate));
        Due {
            lidar: at(self.lidar.model().rate),
            depth: at(self.depth.model().rate),
            rgb: at(self.detector.camera().rate),
        }
    }

    /// Takes a LiDAR scan from where the robot is.
    pub fn scan(&mut self) -> &PointScan {
        self.lidar.scan(&self.world, self.state.base)
    }

    /// Takes a depth image from where the camera is.
    pub fn image(&mut self) -> &PointScan {
        self.depth.scan(&self.world, &self.camera)
    }

    /// Takes a LiDAR scan and a depth image at once, on two threads.
    pub fn scan_and_image(&mut self) -> (&PointScan, &PointScan) {
        let Self {
            lidar,
            depth,
            world,
            state,
            camera,
            ..
        } = self;
        rayon::join(
            || lidar.scan(world, state.base),
            || depth.scan(world, camera),
        )
    }

    /// Looks for tags in the RGB image; returns those found by it. Call it whenever [`Due::rgb`] is set: a tag must
    /// be seen in consecutive images.
    pub fn detect(&mut self) -> &[Detection] {
        let time = self.time();
        self.detector
            .frame(&self.world, &self.camera, self.turn, time)
    }
}

/// A base pose after driving at constant speed and turn rate: an exact arc.
pub(crate) fn drive(base: [f64; 3], v: f64, w: f64, dt: f64) -> [f64; 3] {
    let turn = w * dt;
    // sin(x)/x of half the turn: chord over arc.
    let half = 0.5 * turn;
    let chord = if half.abs() < 1e-6 {
        1.0 - half * half / 6.0
    } else {
        half.sin() / half
    };
    let (sin, cos) = (base[2] + half).sin_cos();
    [
        base[0] + v * dt * chord * cos,
        base[1] + v * dt * chord * sin,
        base[2] + turn,
    ]
}
