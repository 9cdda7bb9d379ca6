//! The robot in the simulator with its map: what is sensed, what is recorded, what is left at the end. As HEATS does it, with the
//! camera alone.

use super::settings::BaselineSettings;
use crate::clock::{Account, Lap, Planning, Stage, Stopwatch};
use crate::heats::{
    Controller, Exact, HeatsError, Joints, Mapper, MotionParams, PlanningTime, Run, Tap, Whole,
    map_layer,
};
use crate::record::{
    Ended, GivenUp, Progress, Recorder, RunResult, SCHEMA, Sample, StageMs, TargetFound, Trace,
    Wall,
};
use crate::report::Status;
use crate::scene::Scene;
use crate::sim::{
    DepthCamera, DepthModel, GroundTruth, Lidar, LidarModel, MotionLimits, Noise, Simulator,
    SurfaceSeen, TagDetector, World,
};
use hybrid_astar::{Limits, Planner};
use robots::{BodyState, MobileManipulator, View as Attitude};
use voxmap::{Ball, Camera};

/// Turning rate of the camera below which images are sharp enough to read a tag (G item 45), rad/s.
const STEADY: f64 = 1.0;
/// Height (m) and elevation (degrees) of the camera when the run begins and while the arm is drawn in, and of the look at the floor
/// around the start: as HEATS begins.
const ATTITUDES: [(f64, f64); 2] = [(1.2, 0.0), (1.38, -50.0)];

/// Space around the robot that is taken for free when it begins, m: 0.3 (G item 9), and what voxels that are partly within it lack of
/// letting the base turn.
const START_ROOM: f64 = 0.4;

/// Robot, simulator, map and records of a run.
pub(super) struct Rig<'a> {
    pub(super) scene: &'a Scene,
    pub(super) settings: &'a BaselineSettings,
    pub(super) robot: MobileManipulator,
    pub(super) sim: Simulator<Exact>,
    pub(super) mapper: Mapper,
    pub(super) base_planner: Planner,
    pub(super) params: MotionParams,
    pub(super) controller: Controller,
    pub(super) account: Account,
    pub(super) watch: Stopwatch,
    pub(super) tap: Tap<'a>,
    pub(super) trace: Trace,
    /// Field of view of the depth camera, rad.
    pub(super) field: [f64; 2],
    /// Arm postures: drawn in and level, and looking at the floor.
    pub(super) home: Joints,
    pub(super) down: Joints,
    pub(super) time_limit: f64,
    pub(super) activity: &'static str,
    pub(super) decisions: usize,
    pub(super) views_reached: usize,
    pub(super) given_up: Vec<GivenUp>,
    /// Whether the last image was inspected: it and the one before were sharp.
    pub(super) sharp: bool,
    truth: GroundTruth,
    seen: SurfaceSeen,
    progress: Vec<Progress>,
    rgb: (f64, f64),
    was_steady: bool,
    last_image: Camera,
}

impl<'a> Rig<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        settings: &'a BaselineSettings,
        recorder: &'a mut dyn Recorder,
    ) -> Result<Self, HeatsError> {
        let refused = |e: &dyn std::fmt::Display| HeatsError::Planner(e.to_string());
        let common = settings.common();
        let motion = &settings.motion;
        let l = &scene.limits;
        let (linear, angular, joint) = motion.acceleration;
        let mut robot = MobileManipulator::default();
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
        let mapper = Mapper::new(scene, &common)?;
        let world = World::new(scene);
        let truth = GroundTruth::new(scene, &world, mapper.map.cell_size())?;
        let attitudes = ATTITUDES.map(|(height, degrees)| Attitude {
            height,
            pitch: degrees.to_radians(),
        });
        let postures = robot
            .postures(&attitudes, &robots::PostureWeights::default())
            .map_err(|e| refused(&e))?;
        let (home, down) = (postures[0].joints, postures[1].joints);
        let share = motion.reference_speed;
        let base = Limits {
            v: share * limits.v,
            w: (share * limits.w).min(motion.turn_speed),
            a: motion.reference_acceleration * limits.a,
            alpha: motion.reference_acceleration * limits.alpha,
        };
        let base_planner = Planner::new(hybrid_astar::Params {
            limits: base,
            margin: motion.base_clearance,
            start_tolerance: 0.15,
            goal_tolerance: 0.0,
            max_expansions: 20_000,
            reverse_factor: motion.reverse.0,
            reverse_reach: motion.reverse.1,
            ..hybrid_astar::Params::default()
        })
        .map_err(|e| refused(&e))?;
        let params = MotionParams {
            base,
            joint_speed: share * l.joint_v_max,
            joint_range: limits.joint_range,
            arm_iterations: motion.arm_iterations,
        };
        let controller = Controller::new(motion, &limits).map_err(|e| refused(&e))?;
        let noise = |stream: u64| Noise {
            sigma: settings.map.range_noise,
            dropout: settings.map.dropout,
            seed: settings.seed.wrapping_mul(2).wrapping_add(stream),
            ..Noise::default()
        };
        // The simulator wants a LiDAR; nobody asks it for a scan.
        let lidar = Lidar::new(
            LidarModel {
                offset: robot.base.lidar,
                ..LidarModel::default()
            },
            noise(0),
        );
        let depth = DepthCamera::new(DepthModel::default(), noise(1));
        let field = depth.model().field;
        let tag_camera = settings.map.tag_camera(mapper.inspect_range);
        let rgb = tag_camera.tangents();
        let seen = SurfaceSeen::new(&truth, &tag_camera);
        let detector = TagDetector::new(tag_camera, &scene.tags);
        let start = [scene.start.x, scene.start.y, scene.start.yaw];
        let sim = Simulator::new(
            Exact(robot.clone()),
            world,
            limits,
            (lidar, depth, detector),
            start,
            home,
        )?;
        let planning = match settings.planning_time {
            PlanningTime::Counted => Planning::Counted,
            PlanningTime::Measured => Planning::Measured,
        };
        let title = (settings.planner.name(), settings.to_toml());
        let tap = Tap::titled(recorder, scene, &common, title, &robot, (&mapper, rgb));
        let mut rig = Self {
            scene,
            settings,
            sim,
            mapper,
            base_planner,
            params,
            controller,
            account: Account::new(planning),
            watch: Stopwatch::default(),
            tap,
            trace: Trace::default(),
            field,
            home,
            down,
            time_limit: settings.time_limit.unwrap_or(l.time_limit),
            activity: "looking around",
            decisions: 0,
            views_reached: 0,
            given_up: Vec::new(),
            sharp: false,
            truth,
            seen,
            progress: Vec::new(),
            rgb,
            was_steady: false,
            last_image: Camera {
                rotation: [[0.0; 3]; 3],
                translation: [0.0; 3],
                tan_half_h: rgb.0,
                tan_half_v: rgb.1,
            },
            robot,
        };
        let body = rig.body();
        rig.mapper.clear_start(&body, START_ROOM);
        Ok(rig)
    }

    pub(super) fn whole(&self) -> Whole<'_> {
        Whole {
            robot: &self.robot,
            mapper: &self.mapper,
            base_clearance: self.settings.motion.base_clearance,
            arm_clearance: self.settings.stand.clearance,
        }
    }

    fn body(&self) -> Vec<Ball> {
        let state = self.sim.state();
        let spheres = self.robot.spheres(&BodyState {
            base: state.base,
            joints: state.joints,
        });
        let ball = |s: &robots::Sphere| Ball {
            center: s.center,
            radius: s.radius,
        };
        spheres.all.iter().map(ball).collect()
    }

    /// Takes in the measurements that fall due. True if an image came.
    pub(super) fn sense(&mut self) -> Result<bool, HeatsError> {
        let due = self.sim.due();
        if !(due.depth || due.rgb) {
            return Ok(false);
        }
        let body = self.body();
        if due.depth {
            let now = self.sim.time();
            let lap = Lap::start();
            let image = self.sim.image();
            self.watch.stop(Stage::Simulator, lap);
            self.tap.scan(now, "depth", image);
            let range = image.max_range;
            self.mapper
                .integrate(image.origin, &image.hits, &image.misses, range, &body)?;
        }
        let lap = Lap::start();
        if due.rgb {
            // Images of a camera that turns fast are blurred.
            let steady = self.sim.camera_turn() < STEADY;
            self.sharp = std::mem::replace(&mut self.was_steady, steady) && steady;
            let (rotation, translation) = *self.sim.camera();
            let camera = Camera {
                rotation,
                translation,
                tan_half_h: self.rgb.0,
                tan_half_v: self.rgb.1,
            };
            if self.sharp {
                self.mapper.inspect(&self.last_image, &camera);
            }
            self.last_image = camera;
        }
        let boxes = self.mapper.refresh();
        self.tap.note(&boxes);
        self.watch.stop(Stage::MapUpdate, lap);
        if due.rgb {
            let lap = Lap::start();
            let turn = self.sim.camera_turn();
            self.seen.look(self.sim.world(), self.sim.camera(), turn);
            self.sim.detect();
            self.watch.stop(Stage::Simulator, lap);
        }
        Ok(due.depth)
    }

    pub(super) fn sample(&mut self) {
        let (now, state) = (self.sim.time(), self.sim.state());
        self.tap.pose(now, &self.robot, state, self.sim.camera());
        self.tap.found(now, self.sim.found(), &self.scene.tags);
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

    pub(super) fn tell(&mut self, progress: &mut dyn FnMut(&Status<'_>)) {
        let now = self.sim.time();
        let (explored, inspected) = self.shares();
        let found = self.sim.found().len();
        self.progress.push(Progress {
            time_s: now,
            explored,
            inspected,
            found,
        });
        self.tap
            .progress(now, (explored, inspected, found), self.activity);
        self.tap
            .state(now, &self.mapper, &self.given_up, &self.watch);
        progress(&Status {
            time: now,
            found,
            targets: self.scene.tags.len(),
            explored,
            inspected,
            activity: self.activity,
        });
    }

    pub(super) fn finish(mut self, ended: Ended, lap: Lap) -> Run {
        self.sample();
        let now = self.sim.time();
        let (explored_fraction, inspected_fraction) = self.shares();
        let tally = *self.sim.tally();
        let found = self.sim.found().iter().map(|d| TargetFound {
            id: d.id,
            time_s: d.time,
        });
        let found: Vec<TargetFound> = found.collect();
        let targets = self.scene.tags.len();
        self.tap
            .state(now, &self.mapper, &self.given_up, &self.watch);
        self.tap.end(now, ended);
        let total_s = lap.seconds();
        let stage = |stage: Stage| {
            let s = self.watch.summary(stage);
            let figures = StageMs {
                count: s.count,
                median: s.median,
                p95: s.p95,
                max: s.max,
            };
            (stage.name().to_owned(), figures)
        };
        let stages = Stage::ALL.into_iter().map(stage).collect();
        let result = RunResult {
            schema: SCHEMA.to_owned(),
            system: "heats".to_owned(),
            planner: self.settings.planner.name().to_owned(),
            sensors: "camera".to_owned(),
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
            seen_fraction: self.seen.fraction(),
            given_up: self.given_up,
            collisions: tally.collisions,
            min_clearance_m: tally.min_clearance,
            limit_violations: tally.limit_violations,
            decisions: self.decisions,
            views_reached: self.views_reached,
            brakes: self.controller.brakes,
            planning_time_s: self.account.charged(),
            faults: Vec::new(),
            progress: self.progress,
            settings: self.settings.to_toml(),
            wall: Wall {
                total_s,
                real_time_factor: now / total_s.max(1e-9),
                stages,
            },
        };
        self.trace.map = Some(map_layer(&self.mapper));
        Run {
            result,
            trace: self.trace,
        }
    }
}
