//! The run: sense, decide, move, until nothing is left to see.

use super::body::{Exact, Joints, Whole};
use super::control::Controller;
use super::failures::Failures;
use super::mapping::Mapper;
use super::motion::{
    BodyPath, Failure, MotionParams, STEP, compensate, is_clear, plan_arm, plan_base,
};
use super::settings::{PlanningTime, Sensors, Settings};
use super::targets::{Choice, Outcome, Targets};
use crate::clock::{Account, Lap, Planning, Stage, Stopwatch};
use crate::record::{
    Coverage, Ended, MapLayer, Progress, RunResult, SCHEMA, Sample, StageMs, Stop, TargetFound,
    Trace, Wall,
};
use crate::report::Status;
use crate::scene::Scene;
use crate::sim::{
    DepthCamera, DepthModel, GroundTruth, Lidar, LidarModel, MotionLimits, Noise, Simulator, TICK,
    TagCamera, TagDetector, World,
};
use hybrid_astar::{GoalYaw, Limits, Planner};
use robots::{BodyState, MobileManipulator};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use viewsample::Pose;
use voxmap::{Ball, Camera, Ground};

/// Room that a view's base pose has beyond what paths need, so that a path can end there with any yaw near it, m.
const VIEW_ROOM: f64 = 0.04;
/// Turning rate of the camera below which images are sharp enough to read a tag (G item 45), rad/s.
const STEADY: f64 = 1.0;
/// Time between samples of the way, s.
const SAMPLE_PERIOD: f64 = 0.2;
/// How long a robot that should move may stand, s.
const PATIENCE: f64 = 3.0;
/// How long a path's end may be approached beyond its time, s.
const LATENESS: f64 = 3.0;
/// The reference waits while base (m) or joints (rad) lag further behind.
const LAG: (f64, f64) = (0.25, 0.5);

/// A finished run.
#[derive(Clone, Debug)]
pub struct Run {
    /// What was found and what it cost.
    pub result: RunResult,
    /// What pictures need.
    pub trace: Trace,
}

/// Why a run could not begin or go on. What was recorded until then is lost only if it could not begin.
#[derive(Debug, thiserror::Error)]
pub enum HeatsError {
    /// A setting is out of range.
    #[error(transparent)]
    Settings(#[from] super::settings::SettingsError),
    /// The map cannot be made.
    #[error("map: {0}")]
    Map(#[from] voxmap::Error),
    /// The ground truth cannot be made.
    #[error("ground truth: {0}")]
    Truth(#[from] crate::sim::GroundTruthError),
    /// The robot cannot stand at its start.
    #[error("start: {0}")]
    Start(#[from] crate::sim::StartError),
    /// A planner refused its input.
    #[error("{0}")]
    Planner(String),
}

/// What the robot is about.
enum Motion {
    /// Nothing planned: stand.
    Rest,
    /// Following a path.
    Follow(Box<Follow>),
}

struct Follow {
    path: BodyPath,
    /// Time along the path, s.
    time: f64,
    /// What it is for; none for the first look around.
    target: Option<Target>,
    /// Camera pose at its end.
    camera: Pose,
    /// Since when the robot has not moved, and where it was.
    still: (f64, [f64; 3], Joints),
}

struct Target {
    choice: Choice,
    /// Frontier information expected when it was chosen.
    expected: f64,
}

/// Runs HEATS on a scene until the search is complete, the time limit, or `stop`. `progress` is told once a simulated second.
///
/// # Errors
/// [`HeatsError`] if the run cannot begin: settings out of range, a map too large, a start in contact.
pub fn run(
    scene: &Scene,
    settings: &Settings,
    stop: &AtomicBool,
    progress: &mut dyn FnMut(&Status<'_>),
) -> Result<Run, HeatsError> {
    settings.validate()?;
    let lap = Lap::start();
    let mut search = Search::new(scene, settings)?;
    let ended = search.go(stop, progress)?;
    Ok(search.finish(ended, lap))
}

struct Search<'a> {
    scene: &'a Scene,
    settings: &'a Settings,
    robot: MobileManipulator,
    sim: Simulator<Exact>,
    truth: GroundTruth,
    mapper: Mapper,
    targets: Targets,
    failures: Failures,
    base_planner: Planner,
    motion_params: MotionParams,
    controller: Controller,
    account: Account,
    watch: Stopwatch,
    motion: Motion,
    /// A path that is still being computed, and when it is there.
    pending: Option<(f64, Box<Follow>)>,
    /// Earliest time of the next decision.
    next_decision: f64,
    /// The reached view that the next image still has to show.
    arrived: Option<Target>,
    rgb: (f64, f64),
    looked_around: bool,
    /// Whether the last image was sharp; a tag must be read in two in a row.
    was_steady: bool,
    activity: &'static str,
    trace: Trace,
    progress: Vec<Progress>,
    decisions: usize,
    views_reached: usize,
    camera_down: Joints,
    time_limit: f64,
}

fn whole<'a>(robot: &'a MobileManipulator, mapper: &'a Mapper, settings: &Settings) -> Whole<'a> {
    Whole {
        robot,
        mapper,
        base_clearance: settings.motion.base_clearance,
        arm_clearance: settings.views.clearance,
    }
}

fn camera_at(robot: &MobileManipulator, base: [f64; 3], joints: &Joints) -> Pose {
    let frame = robot.camera_frame(&BodyState {
        base,
        joints: *joints,
    });
    Pose {
        rotation: frame.rows(),
        translation: frame.p,
    }
}

impl<'a> Search<'a> {
    fn new(scene: &'a Scene, settings: &'a Settings) -> Result<Self, HeatsError> {
        let planner = |e: &dyn std::fmt::Display| HeatsError::Planner(e.to_string());
        let mut robot = MobileManipulator::default();
        let l = &scene.limits;
        let (linear, angular, joint) = settings.motion.acceleration;
        robot.limits.speed = l.v_max;
        robot.limits.turn_speed = l.w_max;
        robot.limits.joint_speed = [l.joint_v_max; 6];
        robot.limits.acceleration = linear;
        robot.limits.turn_acceleration = angular;
        robot.limits.joint_acceleration = [joint; 6];
        let limits = MotionLimits {
            a: linear,
            alpha: angular,
            joint_a: [joint; 6],
            ..MotionLimits::for_scene(l)
        };
        let mapper = Mapper::new(scene, settings)?;
        let world = World::new(scene);
        let truth = GroundTruth::new(scene, &world, mapper.map.cell_size())?;
        let postures = robot.default_postures().map_err(|e| planner(&e))?;
        let height = scene.bounds.max[2] - scene.bounds.min[2];
        let targets = Targets::new(
            settings,
            &robot,
            &postures,
            mapper.map.cell_size(),
            mapper.inspect_range,
            height,
        )
        .map_err(|e| planner(&e))?;
        let share = settings.motion.reference_speed;
        let base = Limits {
            v: share * limits.v,
            w: share * limits.w,
            a: 0.8 * limits.a,
            alpha: 0.8 * limits.alpha,
        };
        let base_planner = Planner::new(hybrid_astar::Params {
            limits: base,
            margin: settings.motion.base_clearance,
            start_tolerance: 0.15,
            goal_tolerance: 0.0,
            max_expansions: 20_000,
            ..hybrid_astar::Params::default()
        })
        .map_err(|e| planner(&e))?;
        let motion_params = MotionParams {
            base,
            joint_speed: share * l.joint_v_max,
            joint_range: limits.joint_range,
            arm_iterations: settings.motion.arm_iterations,
        };
        let controller = Controller::new(&settings.motion, &limits).map_err(|e| planner(&e))?;
        let noise = |stream: u64| Noise {
            sigma: settings.map.range_noise,
            dropout: settings.map.dropout,
            seed: settings.seed.wrapping_mul(2).wrapping_add(stream),
        };
        let lidar = Lidar::new(
            LidarModel {
                offset: robot.base.lidar,
                ..LidarModel::default()
            },
            noise(0),
        );
        let depth = DepthCamera::new(DepthModel::default(), noise(1));
        let tag_camera = TagCamera::new(mapper.inspect_range);
        let rgb = (
            (0.5 * tag_camera.field[0]).tan(),
            (0.5 * tag_camera.field[1]).tan(),
        );
        let detector = TagDetector::new(tag_camera, &scene.tags);
        let start = [scene.start.x, scene.start.y, scene.start.yaw];
        let sim = Simulator::new(
            Exact(robot.clone()),
            world,
            limits,
            (lidar, depth, detector),
            start,
            postures[0].joints,
        )?;
        let planning = match settings.planning_time {
            PlanningTime::Counted => Planning::Counted,
            PlanningTime::Measured => Planning::Measured,
        };
        Ok(Self {
            scene,
            settings,
            sim,
            truth,
            mapper,
            targets,
            failures: Failures::default(),
            base_planner,
            motion_params,
            controller,
            account: Account::new(planning),
            watch: Stopwatch::default(),
            motion: Motion::Rest,
            pending: None,
            next_decision: 0.0,
            arrived: None,
            rgb,
            looked_around: false,
            was_steady: false,
            activity: "looking around",
            trace: Trace::default(),
            progress: Vec::new(),
            decisions: 0,
            views_reached: 0,
            // 50 degrees down: the image reaches from the robot's feet to beyond where the LiDAR first meets the floor.
            camera_down: postures.get(3).map_or(postures[0].joints, |p| p.joints),
            time_limit: settings.time_limit.unwrap_or(l.time_limit),
            robot,
        })
    }

    fn whole(&self) -> Whole<'_> {
        whole(&self.robot, &self.mapper, self.settings)
    }

    fn go(
        &mut self,
        stop: &AtomicBool,
        progress: &mut dyn FnMut(&Status<'_>),
    ) -> Result<Ended, HeatsError> {
        let state = *self.sim.state();
        let body: Vec<Ball> = self
            .robot
            .spheres(&BodyState {
                base: state.base,
                joints: state.joints,
            })
            .all
            .iter()
            .map(|s| Ball {
                center: s.center,
                radius: s.radius,
            })
            .collect();
        self.mapper.clear_start(&body, 0.3);
        let every = |seconds: f64| (seconds / TICK).round() as u64;
        let control = every(self.settings.motion.control_period).max(1);
        loop {
            let now = self.sim.time();
            let ticks = self.sim.ticks();
            if stop.load(Ordering::Relaxed) {
                return Ok(Ended::Interrupted);
            }
            if now >= self.time_limit - 1e-9 {
                return Ok(Ended::TimeLimit);
            }
            let imaged = self.sense()?;
            if ticks.is_multiple_of(every(SAMPLE_PERIOD)) {
                self.sample(now);
            }
            if ticks.is_multiple_of(every(1.0)) {
                self.tell(now, progress);
            }
            if imaged && self.think(now)? {
                return Ok(Ended::Complete);
            }
            if ticks.is_multiple_of(control) {
                self.control(now)?;
            }
            let command = self.controller.tick(self.sim.state());
            let lap = Lap::start();
            self.sim.step(&command);
            self.watch.stop(Stage::Simulator, lap);
        }
    }

    /// Takes in the measurements that fall due. True if an image came.
    fn sense(&mut self) -> Result<bool, HeatsError> {
        let due = self.sim.due();
        if !(due.lidar || due.depth || due.rgb) {
            return Ok(false);
        }
        let state = *self.sim.state();
        let body: Vec<Ball> = self
            .robot
            .spheres(&BodyState {
                base: state.base,
                joints: state.joints,
            })
            .all
            .iter()
            .map(|s| Ball {
                center: s.center,
                radius: s.radius,
            })
            .collect();
        let both = self.settings.sensors == Sensors::Both;
        let lap = Lap::start();
        if due.lidar && due.depth && both {
            self.sim.scan_and_image();
        }
        self.watch.stop(Stage::Simulator, lap);
        let lap = Lap::start();
        if due.lidar && both {
            let scan = self.sim.scan();
            self.mapper
                .integrate(scan.origin, &scan.hits, &scan.misses, scan.max_range, &body)?;
        }
        if due.depth {
            let image = self.sim.image();
            self.mapper.integrate(
                image.origin,
                &image.hits,
                &image.misses,
                image.max_range,
                &body,
            )?;
        }
        // Images of a camera that turns fast are blurred: no tag is read in them, so nothing counts as inspected.
        let steady = self.sim.camera_turn() < STEADY;
        if due.rgb && steady && std::mem::replace(&mut self.was_steady, steady) {
            let (rotation, translation) = *self.sim.camera();
            let camera = Camera {
                rotation,
                translation,
                tan_half_h: self.rgb.0,
                tan_half_v: self.rgb.1,
            };
            self.mapper.inspect(&camera);
        } else if due.rgb {
            self.was_steady = steady;
        }
        let boxes = self.mapper.refresh();
        self.targets.note(boxes);
        self.watch.stop(Stage::MapUpdate, lap);
        if due.rgb {
            self.sim.detect();
        }
        Ok(due.depth)
    }

    /// Decides what to do next where that is due. True when the search is complete.
    fn think(&mut self, now: f64) -> Result<bool, HeatsError> {
        if let Some((at, _)) = &self.pending {
            if now + 1e-9 < *at {
                return Ok(false);
            }
            if let Some((at, mut follow)) = self.pending.take() {
                follow.time = now - at;
                follow.still.0 = now;
                self.controller.reset();
                self.motion = Motion::Follow(follow);
            }
        }
        if !self.looked_around {
            self.looked_around = true;
            self.look_around(now);
            return Ok(false);
        }
        let mut current = None;
        match &self.motion {
            Motion::Follow(follow) if follow.target.is_none() => {
                if follow.time < follow.path.seconds() + 0.2 {
                    return Ok(false);
                }
                self.rest();
            }
            Motion::Follow(follow) => {
                if self.has_arrived(follow) {
                    self.arrive(now);
                } else if self.is_stuck(follow, now) {
                    self.strike(now, "the robot did not get there");
                } else if !is_clear(&self.whole(), &follow.path, follow.time, 0.0) {
                    self.activity = "replanning: path blocked";
                    self.rest();
                } else if now < self.next_decision {
                    return Ok(false);
                } else {
                    self.refresh()?;
                    current = self.worth_going();
                    if current.is_some() {
                        self.next_decision = now + self.settings.decision.period;
                        return Ok(false);
                    }
                }
            }
            Motion::Rest => {
                if now < self.next_decision {
                    return Ok(false);
                }
            }
        }
        self.decide(now, current)
    }

    /// Turns once on the spot with the camera down, so that the floor around the start is known (G item 9); where the base cannot
    /// turn, the shoulder does.
    fn look_around(&mut self, now: f64) {
        let state = *self.sim.state();
        let whole = self.whole();
        let turns = (0..36).all(|i| {
            let yaw = state.base[2] + f64::from(i) * std::f64::consts::TAU / 36.0;
            whole.base_room([state.base[0], state.base[1], yaw]) >= -0.5
        }) && (0..36).all(|i| {
            let yaw = state.base[2] + f64::from(i) * std::f64::consts::TAU / 36.0;
            whole.robot.base_circles().iter().all(|&([x, y], r)| {
                let (s, c) = yaw.sin_cos();
                let p = [state.base[0] + c * x - s * y, state.base[1] + s * x + c * y];
                self.mapper.ground.obstacle_clearance(p) >= r + 0.1
            })
        });
        let steps = 70;
        let ease = |i: usize| {
            let t = i as f64 / steps as f64;
            // Smoothstep: rest to rest, within the acceleration limits.
            t * t * (3.0 - 2.0 * t)
        };
        let mut path = BodyPath {
            base: Vec::new(),
            joints: Vec::new(),
        };
        let reach = if turns { steps } else { 3 * steps };
        for i in 0..=reach {
            let lower = (i as f64 * STEP / 2.5).min(1.0);
            let lower = lower * lower * (3.0 - 2.0 * lower);
            let mut joints: Joints = std::array::from_fn(|j| {
                state.joints[j] + lower * (self.camera_down[j] - state.joints[j])
            });
            let mut base = state.base;
            if turns {
                base[2] += std::f64::consts::TAU * ease(i);
            } else {
                // Shoulder: a third of the time each to one side, to the other, and back.
                let third = i / steps;
                let part = ease(i - third * steps);
                let side = std::f64::consts::PI * 0.8;
                joints[0] += match third {
                    0 => side * part,
                    1 => side * (1.0 - 2.0 * part),
                    2 => -side * (1.0 - part),
                    _ => 0.0,
                };
            }
            path.base.push(base);
            path.joints.push(joints);
        }
        let (base, joints) = path.end();
        let camera = camera_at(&self.robot, base, &joints);
        self.motion = Motion::Follow(Box::new(Follow {
            path,
            time: 0.0,
            target: None,
            camera,
            still: (now, state.base, state.joints),
        }));
        self.controller.reset();
    }

    fn rest(&mut self) {
        self.motion = Motion::Rest;
        self.controller.halt();
        self.next_decision = 0.0;
    }

    /// Whether the camera is where the path ends (G item 44).
    fn has_arrived(&self, follow: &Follow) -> bool {
        let (rotation, translation) = self.sim.camera();
        let wanted = &follow.camera;
        let off: f64 = (0..3)
            .map(|a| (translation[a] - wanted.translation[a]).powi(2))
            .sum::<f64>()
            .sqrt();
        let cosine: f64 = (0..3).map(|a| rotation[a][2] * wanted.rotation[a][2]).sum();
        let d = &self.settings.decision;
        follow.time + 0.5 >= follow.path.seconds()
            && off <= d.reached_position
            && cosine.clamp(-1.0, 1.0).acos() <= d.reached_angle.to_radians()
    }

    fn is_stuck(&self, follow: &Follow, now: f64) -> bool {
        now - follow.still.0 > PATIENCE || follow.time > follow.path.seconds() + LATENESS
    }

    /// The view is reached: if what it promised did not come, it never will.
    fn arrive(&mut self, now: f64) {
        let Motion::Follow(follow) = std::mem::replace(&mut self.motion, Motion::Rest) else {
            return;
        };
        self.next_decision = 0.0;
        let (rotation, translation) = *self.sim.camera();
        self.views_reached += 1;
        self.trace.stops.push(Stop {
            time: now,
            camera: translation,
            axis: [0, 1, 2].map(|a| rotation[a][2]),
        });
        let mut follow = follow;
        if let Some(target) = follow.target.take() {
            self.arrived = Some(target);
        }
        // The path's last stretch goes on being tracked until the next one is there.
        self.motion = Motion::Follow(follow);
    }

    /// The target under way, if enough of what it promised is still there.
    fn worth_going(&self) -> Option<Choice> {
        let Motion::Follow(follow) = &self.motion else {
            return None;
        };
        let (target, path) = (follow.target.as_ref()?, &follow.path);
        let left = self.targets.gain_at(path.end().0, &target.choice.camera);
        let enough = left >= self.settings.decision.keep_share * target.expected
            && left >= self.settings.views.threshold.min(target.expected);
        enough.then(|| target.choice.clone())
    }

    /// Notes a failure of the target under way, and stops.
    fn strike(&mut self, now: f64, reason: &str) {
        if let Motion::Follow(follow) = std::mem::replace(&mut self.motion, Motion::Rest)
            && let Some(target) = follow.target
        {
            self.fail(&target.choice, now, reason);
        }
        self.rest();
    }

    fn fail(&mut self, choice: &Choice, now: f64, reason: &str) {
        let d = &self.settings.decision;
        let base = [choice.base[0], choice.base[1]];
        if self.failures.strike(base, now, d.exclusion) >= d.strikes {
            self.failures
                .give_up(&choice.cells, choice.camera.translation, reason, now);
        }
    }

    /// One decision and the motion that follows from it. True when nothing is left.
    fn decide(&mut self, now: f64, current: Option<Choice>) -> Result<bool, HeatsError> {
        let lap = Lap::start();
        self.next_decision = now + self.settings.decision.period;
        self.mapper.segment(now)?;
        let outcome = self.choose(now, current.as_ref());
        let outcome = outcome?;
        self.decisions += 1;
        match outcome {
            Outcome::Done => Ok(true),
            Outcome::Wait => Ok(false),
            Outcome::Go(choice) => {
                if self.is_better(current.as_ref(), &choice) {
                    self.set_out(now, *choice, lap);
                }
                Ok(false)
            }
        }
    }

    /// Whether to leave the target under way for another: only for one that is much nearer, or the robot wavers between
    /// targets of about equal worth.
    fn is_better(&self, current: Option<&Choice>, choice: &Choice) -> bool {
        let Some(current) = current else { return true };
        let Motion::Follow(follow) = &self.motion else {
            return true;
        };
        if current == choice {
            return false;
        }
        let left = follow.path.seconds() - follow.time;
        let state = self.sim.state();
        let way = (choice.base[0] - state.base[0]).hypot(choice.base[1] - state.base[1]);
        let arm = self.robot.arm_seconds(&state.joints, &choice.joints);
        let needs = (way / self.motion_params.base.v).max(arm);
        left > 3.0 && needs < 0.4 * left
    }

    /// Brings frontiers and libraries up to date.
    fn refresh(&mut self) -> Result<(), HeatsError> {
        let whole = whole(&self.robot, &self.mapper, self.settings);
        self.targets
            .update(&whole, &self.failures, &mut self.watch)
            .map_err(HeatsError::Planner)
    }

    fn choose(&mut self, now: f64, current: Option<&Choice>) -> Result<Outcome, HeatsError> {
        let state = *self.sim.state();
        let whole = Whole {
            base_clearance: self.settings.motion.base_clearance + VIEW_ROOM,
            ..whole(&self.robot, &self.mapper, self.settings)
        };
        let (targets, failures, watch) = (&mut self.targets, &mut self.failures, &mut self.watch);
        targets
            .update(&whole, failures, watch)
            .map_err(HeatsError::Planner)?;
        if let Some(reached) = self.arrived.take() {
            // What a reached view still promises does not come from there.
            let (rotation, translation) = *self.sim.camera();
            let camera = Pose {
                rotation,
                translation,
            };
            if targets.gain_at(state.base, &camera) >= 0.5 * reached.expected {
                let cells = targets.seen_from(state.base, &camera);
                failures.give_up(
                    &cells,
                    translation,
                    "in sight of a reached view, but never inspected",
                    now,
                );
                targets
                    .drop_given_up(&whole, failures)
                    .map_err(HeatsError::Planner)?;
            }
        }
        targets
            .choose(
                &whole,
                failures,
                (state.base, state.joints),
                current,
                now,
                watch,
            )
            .map_err(HeatsError::Planner)
    }

    /// Plans the way to a chosen view and follows it once planning is done.
    fn set_out(&mut self, now: f64, choice: Choice, lap: Lap) {
        self.activity = if choice.relaxed {
            "last tries"
        } else {
            "driving to a view"
        };
        match self.plan_motion(now, &choice) {
            Ok((path, camera, operations)) => {
                let counted = self.targets.counted
                    + 3e-6 * operations.0 as f64
                    + 30e-6 * operations.1 as f64
                    + 0.01;
                let ready = self.account.charge(now, counted, lap.seconds());
                let expected = self.targets.gain_at(path.end().0, &camera).max(1e-9);
                let state = self.sim.state();
                self.pending = Some((
                    ready,
                    Box::new(Follow {
                        path,
                        time: 0.0,
                        target: Some(Target { choice, expected }),
                        camera,
                        still: (now, state.base, state.joints),
                    }),
                ));
            }
            Err(Failure(reason)) => {
                self.account
                    .charge(now, self.targets.counted, lap.seconds());
                self.fail(&choice, now, &reason);
                self.next_decision = now + 0.1;
                if matches!(&self.motion, Motion::Follow(follow) if follow.target.is_some()) {
                    self.rest();
                }
            }
        }
    }

    /// Base with free yaw first; where the arm cannot make up for it, the yaw of the library (sect. V-A).
    fn plan_motion(
        &mut self,
        now: f64,
        choice: &Choice,
    ) -> Result<(BodyPath, Pose, (usize, usize)), Failure> {
        let state = *self.sim.state();
        let speed = if state.v.abs() < 0.02 { 0.0 } else { state.v };
        let goal = BodyState {
            base: choice.base,
            joints: choice.joints,
        };
        let place = [choice.base[0], choice.base[1]];
        let seed = self.settings.seed ^ (now / TICK) as u64;
        let whole = whole(&self.robot, &self.mapper, self.settings);
        let (planner, watch) = (&mut self.base_planner, &mut self.watch);
        let mut tried = Err(Failure("no way was tried".into()));
        for yaw in [GoalYaw::Free, GoalYaw::Fixed(choice.base[2])] {
            let (base, _) = watch.time(Stage::BasePath, || {
                plan_base(
                    planner,
                    &whole,
                    &self.motion_params,
                    state.base,
                    speed,
                    place,
                    &yaw,
                )
            });
            let base = match base {
                Ok(base) => base,
                Err(failure) => {
                    tried = Err(failure);
                    break;
                }
            };
            let end = base.poses[base.poses.len() - 1];
            let lap = Lap::start();
            let arm = compensate(&whole, &goal, end, &state.joints)
                .ok_or_else(|| {
                    Failure("no free arm posture shows the view from where the base stops".into())
                })
                .and_then(|joints| {
                    plan_arm(
                        &whole,
                        &self.motion_params,
                        &base.poses,
                        state.joints,
                        joints,
                        seed,
                    )
                });
            watch.stop(Stage::ArmPath, lap);
            match arm {
                Ok((path, samples)) => {
                    let (base_end, joints_end) = path.end();
                    let camera = camera_at(&self.robot, base_end, &joints_end);
                    tried = Ok((path, camera, (base.expansions, samples)));
                    break;
                }
                Err(failure) => tried = Err(failure),
            }
        }
        tried
    }

    /// One control step along the path, if there is one.
    fn control(&mut self, now: f64) -> Result<(), HeatsError> {
        let mut motion = std::mem::replace(&mut self.motion, Motion::Rest);
        if let Motion::Follow(follow) = &mut motion {
            let state = *self.sim.state();
            let (base, joints) = follow.path.at(follow.time);
            let lag = (base[0] - state.base[0]).hypot(base[1] - state.base[1]);
            let turn = (0..6)
                .map(|j| (joints[j] - state.joints[j]).abs())
                .fold(0.0, f64::max);
            if lag <= LAG.0 && turn <= LAG.1 && (base[2] - state.base[2]).abs() <= LAG.1 {
                follow.time += self.settings.motion.control_period;
            }
            let (_, was, were) = &follow.still;
            let moved = (was[0] - state.base[0]).hypot(was[1] - state.base[1]) > 0.02
                || (was[2] - state.base[2]).abs() > 0.05
                || (0..6).any(|j| (were[j] - state.joints[j]).abs() > 0.05);
            if moved {
                follow.still = (now, state.base, state.joints);
            }
            let lap = Lap::start();
            let whole = whole(&self.robot, &self.mapper, self.settings);
            self.controller
                .step(&whole, &state, &follow.path, follow.time)
                .map_err(|e| HeatsError::Planner(e.to_string()))?;
            self.watch.stop(Stage::Mpc, lap);
        }
        self.motion = motion;
        Ok(())
    }

    fn sample(&mut self, now: f64) {
        let state = self.sim.state();
        self.trace.samples.push(Sample {
            time: now,
            base: state.base,
            camera: self.sim.camera().1,
        });
    }

    fn shares(&self) -> (f64, f64) {
        let map = &self.mapper.map;
        (
            self.truth.explored_fraction(|c| map.is_known(c)),
            self.truth.inspected_fraction(|c| map.is_inspected(c)),
        )
    }

    fn tell(&mut self, now: f64, progress: &mut dyn FnMut(&Status<'_>)) {
        let (explored, inspected) = self.shares();
        let found = self.sim.found().len();
        self.progress.push(Progress {
            time_s: now,
            explored,
            inspected,
            found,
        });
        progress(&Status {
            time: now,
            found,
            targets: self.scene.tags.len(),
            explored,
            inspected,
            activity: self.activity,
        });
    }

    fn map_layer(&self) -> MapLayer {
        let ground = &self.mapper.ground;
        let map = &self.mapper.map;
        let [nx, ny] = ground.size();
        let mut coverage = Vec::with_capacity(nx * ny);
        let mut regions = Vec::with_capacity(nx * ny);
        for y in 0..ny as i32 {
            for x in 0..nx as i32 {
                let column = |test: &dyn Fn([i32; 3]) -> bool| {
                    (0..map.size()[2] as i32).any(|z| test([x, y, z]))
                };
                coverage.push(if column(&|c| map.is_inspected(c)) {
                    Coverage::Inspected
                } else if column(&|c| map.is_occupied(c)) {
                    Coverage::Occupied
                } else if ground.ground([x, y]) == Ground::Free {
                    Coverage::Free
                } else {
                    Coverage::Unknown
                });
                regions.push(self.mapper.regions.as_ref().and_then(|r| r.label([x, y])));
            }
        }
        MapLayer {
            cell_size: ground.cell_size(),
            low: ground.low(),
            size: [nx, ny],
            coverage,
            regions,
        }
    }

    fn finish(mut self, ended: Ended, lap: Lap) -> Run {
        let now = self.sim.time();
        self.sample(now);
        if ended == Ended::Complete {
            for (place, cells) in self.targets.leftovers(&self.whole()) {
                self.failures
                    .give_up(&cells, place, "no free view sees enough of it", now);
            }
        }
        let (explored_fraction, inspected_fraction) = self.shares();
        let tally = *self.sim.tally();
        let found: Vec<TargetFound> = self
            .sim
            .found()
            .iter()
            .map(|d| TargetFound {
                id: d.id,
                time_s: d.time,
            })
            .collect();
        let targets = self.scene.tags.len();
        let total_s = lap.seconds();
        let stages: BTreeMap<String, StageMs> = Stage::ALL
            .iter()
            .map(|&stage| {
                let s = self.watch.summary(stage);
                (
                    stage.name().to_owned(),
                    StageMs {
                        count: s.count,
                        median: s.median,
                        p95: s.p95,
                        max: s.max,
                    },
                )
            })
            .collect();
        let result = RunResult {
            schema: SCHEMA.to_owned(),
            system: "heats".to_owned(),
            planner: "heats".to_owned(),
            sensors: match self.settings.sensors {
                Sensors::Both => "both".to_owned(),
                Sensors::Camera => "camera".to_owned(),
            },
            scene: self.scene.name.clone(),
            seed: self.settings.seed,
            ended,
            targets,
            found: found.len(),
            completeness: if targets == 0 {
                1.0
            } else {
                found.len() as f64 / targets as f64
            },
            last_target_time_s: found.iter().map(|t| t.time_s).fold(0.0, f64::max),
            targets_found: found,
            search_time_s: now,
            base_path_m: tally.base_path,
            joint_rotation_rad: tally.joint_rotation,
            explored_fraction,
            inspected_fraction,
            given_up: std::mem::take(&mut self.failures.given_up),
            collisions: tally.collisions,
            min_clearance_m: tally.min_clearance,
            limit_violations: tally.limit_violations,
            decisions: self.decisions,
            views_reached: self.views_reached,
            brakes: self.controller.brakes,
            planning_time_s: self.account.charged(),
            progress: std::mem::take(&mut self.progress),
            settings: self.settings.to_toml(),
            wall: Wall {
                total_s,
                real_time_factor: now / total_s.max(1e-9),
                stages,
            },
        };
        self.trace.map = Some(self.map_layer());
        Run {
            result,
            trace: std::mem::take(&mut self.trace),
        }
    }
}
