//! The run: sense, decide, move, until nothing is left to see.

mod faults;
mod moves;
mod outcome;
mod setup;
mod tap;

use crate::clock::{Account, Lap, Planning, Stage, Stopwatch};
use crate::heats::body::{Exact, Joints, Whole};
use crate::heats::control::Controller;
use crate::heats::failures::Failures;
use crate::heats::fault::BudgetStage;
use crate::heats::glance;
use crate::heats::mapping::Mapper;
use crate::heats::motion::{
    BodyPath, Failure, MotionParams, STEP, is_clear, plan_arm, plan_base, stances, turn_on,
};
use crate::heats::pace::Pace;
use crate::heats::settings::{PlanningTime, Sensors, Settings};
use crate::heats::targets::{Choice, Outcome, Targets};
use crate::record::{
    Coverage, Ended, MapLayer, Progress, Recorder, RunResult, SCHEMA, Sample, Silent, StageMs,
    Stop, TargetFound, Trace, Wall,
};
use crate::report::Status;
use crate::scene::{Scene, SceneError};
use crate::sim::{
    DepthCamera, DepthModel, GroundTruth, Lidar, LidarModel, MotionLimits, Noise, Simulator,
    SurfaceSeen, TICK, TagDetector, World,
};
use faults::Faults;
use hybrid_astar::{GoalYaw, Limits, Planner};
pub(crate) use outcome::map_layer;
use robots::{BodyState, MobileManipulator};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
pub(crate) use tap::Tap;
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
/// A path that is blocked before it was followed for so long counts as a failure of its target, s.
const FRESH: f64 = 0.5;
/// A path that is blocked no farther than this from where the last one was is no way out either, m.
const STANDS: f64 = 0.1;
/// How much deeper than the robot is a path out of a violation may go, m.
const SLACK: f64 = 0.01;
/// How long a path's end may be approached beyond its time, s.
const LATENESS: f64 = 3.0;
/// How long before the end of a path the next one is asked for, s: about as long as planning takes.
const AHEAD: f64 = 0.7;
/// Time between the looks that the rest of a path is taken to bring, s.
const AHEAD_LOOKS: f64 = 0.3;
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
    Settings(#[from] crate::heats::SettingsError),
    /// The map cannot be made.
    #[error("map: {0}")]
    Map(#[from] voxmap::Error),
    /// The ground truth cannot be made.
    #[error("ground truth: {0}")]
    Truth(#[from] crate::sim::GroundTruthError),
    /// The start set in place of the scene's is none.
    #[error("start.base: {0}")]
    Scene(#[from] SceneError),
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
    /// Whether the next path was asked for before the end of this one.
    ahead: bool,
}

/// A path that is still being computed, or planned from the end of the one that is followed.
struct Pending {
    /// When it is there.
    at: f64,
    /// Whether it begins where the path that is followed ends.
    ahead: bool,
    follow: Box<Follow>,
}

/// What a decision and its path start from.
#[derive(Clone, Copy)]
struct Departure {
    base: [f64; 3],
    joints: Joints,
    /// Speed along x, m/s.
    speed: f64,
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
    run_recorded(scene, settings, stop, progress, &mut Silent)
}

/// As [`run`], and tells `recorder` all that happens. The run is the same whoever records it.
///
/// # Errors
/// As [`run`]. What the recorder could not keep is told by its own [`finish`](Recorder::finish).
pub fn run_recorded(
    scene: &Scene,
    settings: &Settings,
    stop: &AtomicBool,
    progress: &mut dyn FnMut(&Status<'_>),
    recorder: &mut dyn Recorder,
) -> Result<Run, HeatsError> {
    settings.validate()?;
    let lap = Lap::start();
    let moved = settings.start.scene(scene)?;
    let scene = moved.as_ref().unwrap_or(scene);
    let mut search = Search::new(scene, settings, recorder)?;
    let ended = search.go(stop, progress)?;
    Ok(search.finish(ended, lap))
}

struct Search<'a> {
    scene: &'a Scene,
    settings: &'a Settings,
    robot: MobileManipulator,
    sim: Simulator<Exact>,
    truth: GroundTruth,
    /// What the RGB camera has shown, whatever the map says.
    seen: SurfaceSeen,
    mapper: Mapper,
    targets: Targets,
    failures: Failures,
    base_planner: Planner,
    motion_params: MotionParams,
    controller: Controller,
    account: Account,
    watch: Stopwatch,
    motion: Motion,
    pending: Option<Pending>,
    /// Earliest time of the next decision.
    next_decision: f64,
    /// Where the robot was when a path was last found blocked.
    blocked_at: Option<[f64; 3]>,
    /// The reached view that the next image still has to show.
    arrived: Option<Target>,
    rgb: (f64, f64),
    looked_around: bool,
    /// Whether the last image was sharp; a tag must be read in two in a row.
    was_steady: bool,
    /// Whether the last image was inspected: it and the one before were sharp.
    sharp: bool,
    /// Camera of the last image.
    last_image: Camera,
    activity: &'static str,
    trace: Trace,
    progress: Vec<Progress>,
    decisions: usize,
    views_reached: usize,
    camera_down: Joints,
    /// Camera postures of the library.
    postures: Vec<Joints>,
    time_limit: f64,
    /// Where all that happens is told.
    tap: Tap<'a>,
    /// What goes wrong on purpose.
    faults: Faults,
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
    fn whole(&self) -> Whole<'_> {
        whole(&self.robot, &self.mapper, self.settings)
    }

    fn go(
        &mut self,
        stop: &AtomicBool,
        progress: &mut dyn FnMut(&Status<'_>),
    ) -> Result<Ended, HeatsError> {
        let state = self.state();
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
            self.disturb(now);
            let imaged = self.sense()?;
            if ticks.is_multiple_of(every(SAMPLE_PERIOD)) {
                self.sample(now);
            }
            if ticks.is_multiple_of(every(1.0)) {
                self.tell(now, progress);
            }
            let blind = self.stands_blind(now);
            if imaged && !blind && self.think(now)? {
                return Ok(Ended::Complete);
            }
            if ticks.is_multiple_of(control) && !blind {
                self.control(now)?;
            }
            let command = self.controller.tick(self.sim.state());
            let lap = Lap::start();
            self.sim.step(&command);
            self.watch.stop(Stage::Simulator, lap);
            if let Some(drift) = &mut self.faults.drift {
                drift.advance();
            }
        }
    }

    /// Takes in the measurements that fall due. True if an image came.
    fn sense(&mut self) -> Result<bool, HeatsError> {
        let (asked, now) = (self.sim.due(), self.sim.time());
        let due = self.faults.delivered(asked, now);
        if asked.rgb && !due.rgb {
            // The next image is not one of two in a row.
            self.sharp = false;
            self.was_steady = false;
            self.sim.miss_image();
        }
        if !(due.lidar || due.depth || due.rgb) {
            return Ok(false);
        }
        let state = self.state();
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
        let base = self.sim.state().base;
        let both = self.settings.sensors == Sensors::Both;
        let lap = Lap::start();
        if due.lidar && due.depth && both {
            self.sim.scan_and_image();
        }
        self.watch.stop(Stage::Simulator, lap);
        let lap = Lap::start();
        if due.lidar && both {
            let scan = self.sim.scan();
            let scan = match &mut self.faults.drift {
                None => scan,
                Some(drift) => drift.scan(&base, scan),
            };
            self.tap.scan(now, "lidar", scan);
            self.mapper
                .integrate(scan.origin, &scan.hits, &scan.misses, scan.max_range, &body)?;
        }
        if due.depth {
            let image = self.sim.image();
            let image = match &mut self.faults.drift {
                None => image,
                Some(drift) => drift.scan(&base, image),
            };
            if !both {
                self.tap.scan(now, "depth", image);
            }
            self.mapper.integrate(
                image.origin,
                &image.hits,
                &image.misses,
                image.max_range,
                &body,
            )?;
        }
        // Images of a camera that turns fast are blurred: no tag is read in them, so nothing counts as inspected.
        if due.rgb {
            let steady = self.sim.camera_turn() < STEADY;
            self.sharp = std::mem::replace(&mut self.was_steady, steady) && steady;
        }
        if due.rgb {
            let (rotation, translation) = self.camera();
            let camera = Camera {
                rotation,
                translation,
                tan_half_h: self.rgb.0,
                tan_half_v: self.rgb.1,
            };
            if self.sharp || !self.settings.map.sharp_only {
                self.mapper.inspect(&self.last_image, &camera);
            }
            self.last_image = camera;
        }
        let boxes = self.mapper.refresh();
        self.tap.note(&boxes);
        self.targets.note(boxes);
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

    /// Decides what to do next where that is due. True when the search is complete.
    fn think(&mut self, now: f64) -> Result<bool, HeatsError> {
        if self.pending.as_ref().is_some_and(|p| !p.ahead) && !self.start_pending(now) {
            return Ok(false);
        }
        if !self.looked_around {
            self.looked_around = true;
            self.look_around(now);
            return Ok(false);
        }
        match &self.motion {
            Motion::Follow(follow) if follow.target.is_none() => {
                // What could not be looked at from here will be from elsewhere.
                if follow.time < follow.path.seconds() + 0.2 && !self.is_stuck(follow, now) {
                    return Ok(false);
                }
                self.rest();
            }
            Motion::Follow(follow) => {
                if self.has_arrived(follow) {
                    self.arrive(now);
                    if let Some(pending) = &mut self.pending {
                        pending.ahead = false;
                        if self.refresh(now)? {
                            self.settle(now)?;
                        } else {
                            self.arrived = None;
                        }
                        self.start_pending(now);
                        return Ok(false);
                    }
                } else if self.is_stuck(follow, now) {
                    self.strike(now, "the robot did not get there");
                } else if !self.is_still_clear(follow) {
                    self.activity = "replanning: path blocked";
                    let here = self.state().base;
                    let stands = self
                        .blocked_at
                        .replace(here)
                        .is_some_and(|p| (p[0] - here[0]).hypot(p[1] - here[1]) < STANDS);
                    if follow.time < FRESH || stands {
                        self.strike(now, "the way is blocked where it begins");
                    } else {
                        self.rest();
                    }
                } else if self.pending.is_some() {
                    return Ok(false);
                } else if follow.time + AHEAD >= follow.path.seconds() && !follow.ahead {
                    self.decide_ahead(now)?;
                    return Ok(false);
                } else if now < self.next_decision {
                    return Ok(false);
                } else {
                    self.refresh(now)?;
                    if self.is_worth_going() {
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
        self.decide(now)
    }

    /// Follows the pending path if it is there by now.
    fn start_pending(&mut self, now: f64) -> bool {
        if self.pending.as_ref().is_some_and(|p| now + 1e-9 < p.at) {
            return false;
        }
        if let Some(Pending { at, mut follow, .. }) = self.pending.take() {
            // One that had to wait for the robot begins at its beginning.
            follow.time = if now - at > 0.2 { 0.0 } else { now - at };
            follow.still.0 = now;
            self.controller.reset();
            self.motion = Motion::Follow(follow);
        }
        true
    }

    fn rest(&mut self) {
        self.pending = None;
        self.motion = Motion::Rest;
        self.controller.halt();
        self.next_decision = 0.0;
    }

    /// Whether the camera is where the path ends and has taken a sharp image there (G item 44).
    fn has_arrived(&self, follow: &Follow) -> bool {
        let (rotation, translation) = self.camera();
        let wanted = &follow.camera;
        let off: f64 = (0..3)
            .map(|a| (translation[a] - wanted.translation[a]).powi(2))
            .sum::<f64>()
            .sqrt();
        let cosine: f64 = (0..3).map(|a| rotation[a][2] * wanted.rotation[a][2]).sum();
        let d = &self.settings.decision;
        self.sharp
            && follow.time + 0.5 >= follow.path.seconds()
            && off <= d.reached_position
            && cosine.clamp(-1.0, 1.0).acos() <= d.reached_angle.to_radians()
    }

    /// Whether the rest of the path keeps out of what the map shows now, or at least goes no deeper into it than the robot is.
    fn is_still_clear(&self, follow: &Follow) -> bool {
        let state = self.state();
        let whole = self.whole();
        let now = whole.room(state.base, &state.joints);
        is_clear(&whole, &follow.path, follow.time, now.min(0.0) - SLACK)
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
        self.tap.reached(now, self.sim.camera());
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

    /// Whether enough of what the target under way promised is still there.
    fn is_worth_going(&self) -> bool {
        let Motion::Follow(follow) = &self.motion else {
            return false;
        };
        let Some(target) = &follow.target else {
            return false;
        };
        let left = self.targets.gain_at(follow.path.end().0, &follow.camera);
        left >= self.settings.decision.keep_share * target.expected
            && left >= self.targets.threshold().min(target.expected)
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
    fn decide(&mut self, now: f64) -> Result<bool, HeatsError> {
        let lap = Lap::start();
        self.next_decision = now + self.settings.decision.period;
        self.mapper.segment(now)?;
        let state = self.state();
        let from = Departure {
            base: state.base,
            joints: state.joints,
            speed: if state.v.abs() < 0.02 { 0.0 } else { state.v },
        };
        if self.refresh(now)? {
            self.settle(now)?;
        } else {
            self.arrived = None;
            return Ok(false);
        }
        let outcome = self.choose(now, &from, &[])?;
        self.decisions += 1;
        self.record_decision(now, &outcome, false);
        match outcome {
            Outcome::Done => Ok(true),
            Outcome::Wait => Ok(false),
            Outcome::Go(choice) => {
                self.set_out(now, *choice, lap, (from, false));
                Ok(false)
            }
        }
    }

    /// Decides what follows the path under way, shortly before its end: planning then costs no standing.
    fn decide_ahead(&mut self, now: f64) -> Result<(), HeatsError> {
        let Motion::Follow(follow) = &mut self.motion else {
            return Ok(());
        };
        follow.ahead = true;
        let lap = Lap::start();
        let (base, joints) = follow.path.end();
        let (first, last) = (follow.time, follow.path.seconds());
        let steps = ((last - first) / AHEAD_LOOKS).ceil().max(1.0);
        let before: Vec<glance::Look> = (1..=steps as usize)
            .map(|k| {
                let (base, joints) = follow.path.at(first + (last - first) * k as f64 / steps);
                (base, camera_at(&self.robot, base, &joints))
            })
            .collect();
        let from = Departure {
            base,
            joints,
            speed: 0.0,
        };
        self.mapper.segment(now)?;
        if !self.refresh(now)? {
            return Ok(());
        }
        let outcome = self.choose(now, &from, &before)?;
        self.decisions += 1;
        self.record_decision(now, &outcome, true);
        if let Outcome::Go(choice) = outcome {
            self.set_out(now, *choice, lap, (from, true));
        }
        Ok(())
    }

    /// Brings frontiers and libraries up to date with the map. False if that ran out of its budget.
    fn refresh(&mut self, now: f64) -> Result<bool, HeatsError> {
        if self.faults.runs_out(BudgetStage::Frontier, now) {
            return Ok(false);
        }
        let whole = whole(&self.robot, &self.mapper, self.settings);
        self.targets
            .update(&whole, &self.failures, &mut self.watch)
            .map_err(HeatsError::Planner)?;
        Ok(true)
    }

    /// Gives up what a view that was reached still promises: it does not come from there.
    fn settle(&mut self, now: f64) -> Result<(), HeatsError> {
        let Some(reached) = self.arrived.take() else {
            return Ok(());
        };
        let base = self.state().base;
        let (rotation, translation) = self.camera();
        let camera = Pose {
            rotation,
            translation,
        };
        let least = 0.5 * reached.expected;
        let (wanted_base, wanted) = (reached.choice.base, &reached.choice.camera);
        let (cells, reason) = if self.targets.gain_at(base, &camera) >= least {
            (
                self.targets.seen_from(base, &camera),
                "in sight of a reached view, but never inspected",
            )
        } else if self.targets.gain_at(wanted_base, wanted) >= least
            && self.failures.reach_in_vain(wanted.translation) >= self.settings.decision.strikes
        {
            // From where the robot came to stand, as near as it goes, it is out of sight.
            (
                self.targets.seen_from(wanted_base, wanted),
                "promised by a view that never showed it when it was reached",
            )
        } else {
            return Ok(());
        };
        self.failures
            .give_up(&cells, wanted.translation, reason, now);
        let whole = whole(&self.robot, &self.mapper, self.settings);
        self.targets
            .drop_given_up(&whole, &self.failures)
            .map_err(HeatsError::Planner)
    }

    /// The next view, chosen from where the robot will be after the looks `before`.
    fn choose(
        &mut self,
        now: f64,
        from: &Departure,
        before: &[glance::Look],
    ) -> Result<Outcome, HeatsError> {
        if self.faults.runs_out(BudgetStage::Decision, now) {
            return Ok(Outcome::Wait);
        }
        // Where the robot comes to rest when it brakes now.
        let stop = from.speed * from.speed.abs() / (2.0 * self.motion_params.base.a);
        let rest = [
            from.base[0] + stop * from.base[2].cos(),
            from.base[1] + stop * from.base[2].sin(),
        ];
        let whole = Whole {
            base_clearance: self.settings.motion.base_clearance + VIEW_ROOM,
            ..whole(&self.robot, &self.mapper, self.settings)
        };
        self.targets
            .choose(
                &whole,
                &mut self.failures,
                (from.base, from.joints),
                (rest, before),
                now,
                &mut self.watch,
            )
            .map_err(HeatsError::Planner)
    }

    /// One control step along the path, if there is one.
    fn control(&mut self, now: f64) -> Result<(), HeatsError> {
        if self.faults.runs_out(BudgetStage::Control, now) {
            self.hold(now);
            return Ok(());
        }
        let mut motion = std::mem::replace(&mut self.motion, Motion::Rest);
        if let Motion::Follow(follow) = &mut motion {
            let state = self
                .faults
                .drift
                .as_ref()
                .map_or(*self.sim.state(), |drift| drift.state(self.sim.state()));
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
            self.tap.horizon(now, &self.controller);
        }
        self.motion = motion;
        Ok(())
    }
}
