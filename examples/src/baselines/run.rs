//! The run: sense, plan, drive, reach out, look, until the planner has nothing left or the time is over.

use super::aep::Aep;
use super::first_look::first_look;
use super::planner::{Next, Planner, Sight};
use super::rig::Rig;
use super::settings::{Baseline, BaselineSettings};
use super::stand::{Effort, Stand, in_reach, plan_way, stands};
use super::view::View;
use super::wg_nbvp::WgNbvp;
use crate::clock::{Lap, Stage};
use crate::heats::{BodyPath, HeatsError, Joints, Run, STEP, Ways, is_clear};
use crate::record::{Candidate, DecisionEvent, Ended, Event, Recorder, Silent, Stop, round};
use crate::report::Status;
use crate::scene::Scene;
use crate::sim::TICK;
use robots::BodyState;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use viewsample::Pose;

/// Time between samples of the way, s.
const SAMPLE_PERIOD: f64 = 0.2;
/// How long a robot that should move may stand, s.
const PATIENCE: f64 = 3.0;
/// How long a path's end may be approached beyond its time, s.
const LATENESS: f64 = 3.0;
/// How much deeper than the robot is a path out of a violation may go, m.
const SLACK: f64 = 0.01;
/// The reference waits while base (m) or joints (rad) lag further behind.
const LAG: (f64, f64) = (0.25, 0.5);
/// How far camera (m) and its axis (rad) may be from a view that counts as reached.
const REACHED: (f64, f64) = (0.15, 0.09);
/// Time between plans that led nowhere, s.
const PAUSE: f64 = 0.5;
/// Plans in a row that led nowhere before the run ends: the planner offers nothing that can be reached.
const FRUITLESS: usize = 40;

/// A path that is followed or waits for planning to end.
struct Follow {
    path: BodyPath,
    /// Time along it, s.
    time: f64,
    /// What it leads to; none for the first look around.
    view: Option<View>,
    camera: Pose,
    /// Since when the robot has not moved, and where it was.
    still: (f64, [f64; 3], Joints),
}

/// Runs a baseline on a scene until the search is complete, the time limit, or `stop`. `progress` is told once a simulated second.
///
/// # Errors
/// [`HeatsError`] if the run cannot begin: settings out of range, a map too large, a start in contact.
pub fn run(
    scene: &Scene,
    settings: &BaselineSettings,
    stop: &AtomicBool,
    progress: &mut dyn FnMut(&Status<'_>),
) -> Result<Run, HeatsError> {
    run_recorded(scene, settings, stop, progress, &mut Silent)
}

/// As [`run`], and tells `recorder` all that happens. The run is the same whoever records it.
///
/// # Errors
/// As [`run`].
pub fn run_recorded(
    scene: &Scene,
    settings: &BaselineSettings,
    stop: &AtomicBool,
    progress: &mut dyn FnMut(&Status<'_>),
    recorder: &mut dyn Recorder,
) -> Result<Run, HeatsError> {
    settings.validate()?;
    let lap = Lap::start();
    let rig = Rig::new(scene, settings, recorder)?;
    let planner: Box<dyn Planner> = match settings.planner {
        Baseline::Aep => Box::new(Aep::new(
            &settings.aep,
            rig.field,
            settings.stand.exclusion,
            settings.seed,
        )),
        Baseline::WgNbvp => Box::new(WgNbvp::new(
            &settings.wg_nbvp,
            rig.field,
            settings.stand.exclusion,
            settings.seed,
        )),
    };
    let mut search = Search {
        rig,
        planner,
        follow: None,
        pending: None,
        queue: VecDeque::new(),
        looked_around: false,
        turned_back: false,
        next_plan: 0.0,
        fruitless: 0,
    };
    let ended = search.go(stop, progress)?;
    Ok(search.rig.finish(ended, lap))
}

struct Search<'a> {
    rig: Rig<'a>,
    planner: Box<dyn Planner>,
    follow: Option<Follow>,
    /// The next path, and when planning it is done.
    pending: Option<(f64, Follow)>,
    /// Views that the arm takes up from where the base stands.
    queue: VecDeque<View>,
    looked_around: bool,
    turned_back: bool,
    next_plan: f64,
    fruitless: usize,
}

impl Search<'_> {
    fn go(
        &mut self,
        stop: &AtomicBool,
        progress: &mut dyn FnMut(&Status<'_>),
    ) -> Result<Ended, HeatsError> {
        let every = |seconds: f64| (seconds / TICK).round() as u64;
        let control = every(self.rig.settings.motion.control_period).max(1);
        loop {
            let (now, ticks) = (self.rig.sim.time(), self.rig.sim.ticks());
            if stop.load(Ordering::Relaxed) {
                return Ok(Ended::Interrupted);
            }
            if now >= self.rig.time_limit - 1e-9 {
                return Ok(Ended::TimeLimit);
            }
            let imaged = self.rig.sense()?;
            if ticks.is_multiple_of(every(SAMPLE_PERIOD)) {
                self.rig.sample();
            }
            if ticks.is_multiple_of(every(1.0)) {
                self.rig.tell(progress);
            }
            if imaged && self.think(now)? {
                return Ok(Ended::Complete);
            }
            if ticks.is_multiple_of(control) {
                self.control(now)?;
            }
            let command = self.rig.controller.tick(self.rig.sim.state());
            let lap = Lap::start();
            self.rig.sim.step(&command);
            self.rig.watch.stop(Stage::Simulator, lap);
        }
    }

    /// Plans where that is due. True when the planner has nothing left.
    fn think(&mut self, now: f64) -> Result<bool, HeatsError> {
        if !self.looked_around {
            self.looked_around = true;
            self.look_around(now);
            return Ok(false);
        }
        if let Some((ready, _)) = &self.pending {
            if now + 1e-9 < *ready {
                return Ok(false);
            }
            if let Some((_, mut follow)) = self.pending.take() {
                follow.still.0 = now;
                self.rig.controller.reset();
                self.follow = Some(follow);
            }
        }
        if let Some(follow) = &self.follow {
            let (arrived, stuck) = (self.has_arrived(follow), self.is_stuck(follow, now));
            let view = follow.view;
            if arrived {
                self.arrive(now, view);
            } else if stuck && view.is_none() && !self.turned_back {
                self.turn_back(now);
                return Ok(false);
            } else if stuck || !self.is_still_clear(follow) {
                self.rest();
                if let Some(view) = view {
                    self.planner.failed(&view, now);
                    self.queue.clear();
                    self.rig.activity = "replanning: path blocked";
                }
            } else {
                return Ok(false);
            }
        }
        if now < self.next_plan {
            return Ok(false);
        }
        self.plan(now)
    }

    fn rest(&mut self) {
        self.follow = None;
        self.pending = None;
        self.rig.controller.halt();
    }

    fn arrive(&mut self, now: f64, view: Option<View>) {
        self.rest();
        let Some(view) = view else {
            return;
        };
        self.planner.reached(&view);
        self.rig.views_reached += 1;
        let camera = *self.rig.sim.camera();
        self.rig.tap.reached(now, &camera);
        self.rig.trace.stops.push(Stop {
            time: now,
            camera: camera.1,
            axis: [0, 1, 2].map(|a| camera.0[a][2]),
        });
    }

    /// Whether the camera is where the path ends and has taken a sharp image there (G item 44).
    fn has_arrived(&self, follow: &Follow) -> bool {
        if follow.time + 0.3 < follow.path.seconds() {
            return false;
        }
        if follow.view.is_none() {
            // What could not be looked at from here will be from elsewhere.
            return follow.time + 1e-9 >= follow.path.seconds();
        }
        let (rotation, translation) = self.rig.sim.camera();
        let wanted = &follow.camera;
        let off: f64 = (0..3)
            .map(|a| (translation[a] - wanted.translation[a]).powi(2))
            .sum::<f64>()
            .sqrt();
        let cosine: f64 = (0..3).map(|a| rotation[a][2] * wanted.rotation[a][2]).sum();
        self.rig.sharp && off <= REACHED.0 && cosine.clamp(-1.0, 1.0).acos() <= REACHED.1
    }

    fn is_stuck(&self, follow: &Follow, now: f64) -> bool {
        now - follow.still.0 > PATIENCE || follow.time > follow.path.seconds() + LATENESS
    }

    /// Whether the rest of the path keeps out of what the map shows now, or at least goes no deeper into it than the robot is.
    fn is_still_clear(&self, follow: &Follow) -> bool {
        if follow.view.is_none() {
            return true;
        }
        let state = self.rig.sim.state();
        let whole = self.rig.whole();
        let now = whole.room(state.base, &state.joints);
        is_clear(&whole, &follow.path, follow.time, now.min(0.0) - SLACK)
    }

    fn here(&self) -> ([f64; 3], Joints) {
        let state = self.rig.sim.state();
        (state.base, state.joints)
    }

    /// Asks the planner, and plans the way to the first of its views that can be reached. True when it has nothing left.
    fn plan(&mut self, now: f64) -> Result<bool, HeatsError> {
        let lap = Lap::start();
        // What the arm still has to take up from here.
        while let Some(view) = self.queue.pop_front() {
            if self.set_out(now, &view, None, lap) {
                return Ok(false);
            }
            self.planner.failed(&view, now);
        }
        let from = self.here();
        let disc = 0.5 * self.rig.robot.base.width + self.rig.settings.motion.base_clearance;
        let ways =
            Ways::new(&self.rig.mapper, disc).map_err(|e| HeatsError::Planner(e.to_string()))?;
        let (rotation, translation) = *self.rig.sim.camera();
        let axis = [0, 1, 2].map(|a| rotation[a][2]);
        let mount = self.rig.robot.base.pedestal;
        let (s, c) = from.0[2].sin_cos();
        let sight = Sight {
            whole: self.rig.whole(),
            ways: &ways,
            params: &self.rig.params,
            base: from.0,
            joints: from.1,
            camera: View {
                place: translation,
                yaw: axis[1].atan2(axis[0]),
                pitch: axis[2].clamp(-1.0, 1.0).asin(),
            },
            turret: [
                from.0[0] + c * mount[0] - s * mount[1],
                from.0[1] + s * mount[0] + c * mount[1],
                self.rig.robot.base.pedestal_top,
            ],
            band: self.rig.settings.map.inspect_band,
            disc,
            now,
        };
        let next = self.planner.next(&sight);
        self.rig.watch.stop(Stage::Decision, lap);
        self.rig.decisions += 1;
        let views = match &next {
            Next::Done => Vec::new(),
            Next::First(views) | Next::Sweep(views) => views.clone(),
        };
        let mut chosen = None;
        if let Next::Sweep(_) = next {
            self.rig.activity = "looking from here";
            self.queue.extend(views.iter().copied());
            while let Some(view) = self.queue.pop_front() {
                if self.set_out(now, &view, None, lap) {
                    chosen = views.iter().position(|v| *v == view);
                    break;
                }
                self.planner.failed(&view, now);
            }
        } else {
            self.rig.activity = "driving to a view";
            for (i, view) in views.iter().enumerate().take(self.rig.settings.stand.ways) {
                if self.set_out(now, view, Some(&ways), lap) {
                    chosen = Some(i);
                    break;
                }
                self.planner.failed(view, now);
            }
        }
        self.record(now, &next, &views, chosen);
        if chosen.is_some() {
            self.fruitless = 0;
            return Ok(false);
        }
        let counted = self.planner.counted();
        self.rig.account.charge(now, counted, lap.seconds());
        self.fruitless += 1;
        self.next_plan = now + PAUSE;
        Ok(next == Next::Done || self.fruitless >= FRUITLESS)
    }

    /// Plans the way to a view, by the arm alone where no ways are told, and follows it once planning is done.
    fn set_out(&mut self, now: f64, view: &View, ways: Option<&Ways>, lap: Lap) -> bool {
        let from = self.here();
        let rig = &mut self.rig;
        let whole = crate::heats::Whole {
            robot: &rig.robot,
            mapper: &rig.mapper,
            base_clearance: rig.settings.motion.base_clearance,
            arm_clearance: rig.settings.stand.clearance,
        };
        let mut looked = 0;
        let found: Vec<Stand> = match ways {
            None => in_reach(&whole, &rig.params, from, view)
                .into_iter()
                .collect(),
            Some(ways) => {
                let settings = &rig.settings.stand;
                stands(&whole, ways, &rig.params, settings, from, view, &mut looked)
            }
        };
        let seed = rig.settings.seed ^ (now / TICK) as u64;
        let mut effort = Effort::default();
        let mut planned = None;
        for stand in &found {
            let lap = Lap::start();
            let way = plan_way(
                &mut rig.base_planner,
                &whole,
                &rig.params,
                from,
                stand,
                &rig.home,
                seed,
                &mut effort,
            );
            rig.watch.stop(Stage::BasePath, lap);
            if let Ok(path) = way {
                planned = Some(path);
                break;
            }
        }
        let Some(path) = planned else {
            return false;
        };
        let (base, joints) = path.end();
        let frame = rig.robot.camera_frame(&BodyState { base, joints });
        let camera = Pose {
            rotation: frame.rows(),
            translation: frame.p,
        };
        self.planner.set_out(view);
        let counted = self.planner.counted()
            + 3e-6 * effort.nodes as f64
            + 30e-6 * effort.samples as f64
            + 8e-6 * looked as f64
            + 0.01;
        let ready = rig.account.charge(now, counted, lap.seconds());
        rig.tap.plan((now, ready), &rig.robot, &path, &camera);
        let follow = Follow {
            path,
            time: 0.0,
            view: Some(*view),
            camera,
            still: (now, from.0, from.1),
        };
        self.pending = Some((ready, follow));
        true
    }

    fn record(&mut self, now: f64, next: &Next, views: &[View], chosen: Option<usize>) {
        let candidate = |view: &View| {
            let frame = view.frame();
            Candidate {
                base: [view.place[0], view.place[1], view.yaw].map(round),
                view: crate::record::View::new(&frame.rows(), frame.p),
                gain: 0.0,
                seconds: 0.0,
            }
        };
        let outcome = match (next, chosen) {
            (Next::Done, _) => "done",
            (_, Some(_)) => "go",
            (_, None) => "wait",
        };
        self.rig.tap.tell(now, || {
            Event::Decision(DecisionEvent {
                outcome: outcome.to_owned(),
                ahead: false,
                candidates: views.iter().map(candidate).collect(),
                chosen,
                regions: Vec::new(),
            })
        });
    }

    /// Begins the first look around.
    fn look_around(&mut self, now: f64) {
        let (base, joints) = self.here();
        let path = first_look(&self.rig.whole(), (base, joints), &self.rig.down);
        let (end, held) = path.end();
        let frame = self.rig.robot.camera_frame(&BodyState {
            base: end,
            joints: held,
        });
        let camera = Pose {
            rotation: frame.rows(),
            translation: frame.p,
        };
        self.rig
            .tap
            .plan((now, now), &self.rig.robot, &path, &camera);
        self.rig.controller.reset();
        self.follow = Some(Follow {
            path,
            time: 0.0,
            view: None,
            camera,
            still: (now, base, joints),
        });
    }

    /// Leads the first look around back to its start, where there is room.
    fn turn_back(&mut self, now: f64) {
        self.turned_back = true;
        let (base, joints) = self.here();
        if let Some(follow) = &mut self.follow {
            let last = ((follow.time / STEP) as usize).min(follow.path.base.len() - 1);
            follow.path.base.truncate(last + 1);
            follow.path.joints.truncate(last + 1);
            follow.path.base.reverse();
            follow.path.joints.reverse();
            follow.time = 0.0;
            follow.still = (now, base, joints);
        }
        self.rig.controller.reset();
    }

    /// One control step along the path, if there is one.
    fn control(&mut self, now: f64) -> Result<(), HeatsError> {
        let Some(mut follow) = self.follow.take() else {
            return Ok(());
        };
        let state = *self.rig.sim.state();
        let (base, joints) = follow.path.at(follow.time);
        let lag = (base[0] - state.base[0]).hypot(base[1] - state.base[1]);
        let turn = (0..6)
            .map(|j| (joints[j] - state.joints[j]).abs())
            .fold((base[2] - state.base[2]).abs(), f64::max);
        if lag <= LAG.0 && turn <= LAG.1 {
            follow.time += self.rig.settings.motion.control_period;
        }
        let (_, was, were) = &follow.still;
        let moved = (was[0] - state.base[0]).hypot(was[1] - state.base[1]) > 0.02
            || (was[2] - state.base[2]).abs() > 0.05
            || (0..6).any(|j| (were[j] - state.joints[j]).abs() > 0.05);
        if moved {
            follow.still = (now, state.base, state.joints);
        }
        let lap = Lap::start();
        let rig = &mut self.rig;
        let whole = crate::heats::Whole {
            robot: &rig.robot,
            mapper: &rig.mapper,
            base_clearance: rig.settings.motion.base_clearance,
            arm_clearance: rig.settings.stand.clearance,
        };
        rig.controller
            .step(&whole, &state, &follow.path, follow.time)
            .map_err(|e| HeatsError::Planner(e.to_string()))?;
        rig.watch.stop(Stage::Mpc, lap);
        rig.tap.horizon(now, &rig.controller);
        self.follow = Some(follow);
        Ok(())
    }
}
