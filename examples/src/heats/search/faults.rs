//! What goes wrong in a run on purpose, and how the search bears it: it stands while a sensor it relies on is silent, and a stage
//! that ran out of its budget is asked again without blaming the place.

use super::*;
use crate::heats::fault::{BudgetStage, FaultSettings, SilentSensor};
use crate::record::{FaultNote, Outline};
use crate::scene::BoxShape;
use crate::sim::{CameraPose, Drift, DriftModel, Due, State};

/// A sensor that was not heard of for longer than this is silent, s: two measurements and a half.
const SILENCE: f64 = 0.25;
/// Half the edges of a person, m.
const PERSON: [f64; 3] = [0.25, 0.25, 0.85];
/// Height of a person's feet above the floor, m, so that floor and person do not touch.
const FEET: f64 = 0.005;
/// What is left of a path when the robot counts as standing, m.
const STANDING: f64 = 0.1;

/// Where a box that comes and goes is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Presence {
    Expected,
    There,
    Gone,
}

/// The faults of a run and what was made of them so far.
pub(super) struct Faults {
    settings: FaultSettings,
    door: Presence,
    person: Presence,
    /// When LiDAR, depth and RGB camera last delivered, s.
    heard: [f64; 3],
    /// What the robot was about when it had to stand.
    held: Option<&'static str>,
    /// Calls of the stage with a budget.
    calls: u64,
    /// Whether a stage ran out of its budget since this was last cleared.
    pub(super) spent: bool,
    /// The error of localisation.
    pub(super) drift: Option<Drift>,
    /// What happened, for the result.
    pub(super) notes: Vec<FaultNote>,
}

impl Faults {
    pub(super) fn new(settings: &Settings) -> Self {
        let fault = settings.fault.clone();
        let drift = fault.localisation.as_ref().map(|off| {
            Drift::new(DriftModel {
                position: off.position,
                heading: off.heading.to_radians(),
                correlation: off.correlation,
                seed: settings.seed,
            })
        });
        Self {
            settings: fault,
            door: Presence::Expected,
            person: Presence::Expected,
            heard: [0.0; 3],
            held: None,
            calls: 0,
            spent: false,
            drift,
            notes: Vec::new(),
        }
    }

    fn note(&mut self, now: f64, what: &str) {
        self.notes.push(FaultNote {
            time_s: now,
            what: what.to_owned(),
        });
    }

    /// The measurements that fall due and come.
    pub(super) fn delivered(&mut self, due: Due, now: f64) -> Due {
        let Some(silence) = &self.settings.silence else {
            return due;
        };
        let (which, end) = (silence.sensor, silence.time + silence.seconds);
        let silent = now >= silence.time && now < end;
        let comes = |sensor| !(silent && (which == sensor || which == SilentSensor::All));
        let out = Due {
            lidar: due.lidar && comes(SilentSensor::Lidar),
            depth: due.depth && comes(SilentSensor::Depth),
            rgb: due.rgb && comes(SilentSensor::Rgb),
        };
        for (heard, came) in self.heard.iter_mut().zip([out.lidar, out.depth, out.rgb]) {
            if came {
                *heard = now;
            }
        }
        out
    }

    /// Whether a sensor that the search relies on is silent: a robot that does not see must not move, and images that do not come
    /// inspect nothing.
    fn is_blind(&self, now: f64, sensors: Sensors) -> bool {
        let unused = usize::from(sensors == Sensors::Camera);
        self.settings.silence.is_some() && self.heard[unused..].iter().any(|h| now - h > SILENCE)
    }

    /// Whether this call of a stage runs out of its budget.
    pub(super) fn runs_out(&mut self, stage: BudgetStage, now: f64) -> bool {
        let Some(budget) = &self.settings.budget else {
            return false;
        };
        let active = now >= budget.time && now < budget.time + budget.seconds;
        if stage != budget.stage || !active {
            return false;
        }
        self.calls += 1;
        let out = self.calls.is_multiple_of(budget.every);
        if out && !self.notes.iter().any(|n| n.what.ends_with("of its budget")) {
            self.note(now, &format!("{} ran out of its budget", stage.name()));
        }
        self.spent |= out;
        out
    }
}

impl Search<'_> {
    /// State of the robot as it believes to be.
    pub(super) fn state(&self) -> State {
        let state = self.sim.state();
        let drift = self.faults.drift.as_ref();
        drift.map_or(*state, |drift| drift.state(state))
    }

    /// Pose of the camera as it believes to be.
    pub(super) fn camera(&self) -> CameraPose {
        let camera = self.sim.camera();
        let drift = self.faults.drift.as_ref();
        drift.map_or(*camera, |d| d.camera(&self.sim.state().base, camera))
    }

    /// Lets boxes come and go.
    pub(super) fn disturb(&mut self, now: f64) {
        if let Some(door) = self.faults.settings.door.clone() {
            let shape = BoxShape {
                name: "fault.door".into(),
                center: door.center,
                half_extents: door.half_extents,
                yaw: Some(door.yaw),
                quat: None,
            };
            if self.faults.door == Presence::Expected
                && now >= door.time
                && door.until.is_none_or(|until| now < until)
                && self.sim.place(&shape, false)
            {
                self.faults.door = Presence::There;
                self.appeared(now, &shape, "the door closed");
            }
            if self.faults.door == Presence::There && door.until.is_some_and(|until| now >= until) {
                self.faults.door = Presence::Gone;
                self.sim.take_away(&shape.name);
                self.faults.note(now, "the door opened");
            }
        }
        if let Some(person) = self.faults.settings.person.clone() {
            if self.faults.person == Presence::Expected
                && now >= person.time
                && person.until.is_none_or(|until| now < until)
            {
                let shape = self.person(person.ahead);
                if self.is_inside(&shape)
                    && self.sim.world().is_vacant(&shape)
                    && self.sim.place(&shape, true)
                {
                    self.faults.person = Presence::There;
                    self.appeared(now, &shape, "a person stepped into the way");
                }
            }
            if self.faults.person == Presence::There
                && person.until.is_some_and(|until| now >= until)
            {
                self.faults.person = Presence::Gone;
                self.sim.take_away("fault.person");
                self.faults.note(now, "the person went away");
            }
        }
    }

    fn appeared(&mut self, now: f64, shape: &BoxShape, what: &str) {
        let (sin, cos) = shape.yaw.unwrap_or(0.0).sin_cos();
        let [hx, hy, hz] = shape.half_extents;
        let corner = |(u, v): (f64, f64)| {
            [
                shape.center[0] + cos * u * hx - sin * v * hy,
                shape.center[1] + sin * u * hx + cos * v * hy,
            ]
        };
        let floor = self.scene.floor_z;
        self.trace.intruders.push(Outline {
            corners: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(corner)
                .to_vec(),
            band: (shape.center[2] - hz - floor, shape.center[2] + hz - floor),
        });
        let [x, y, _] = shape.center;
        self.faults
            .note(now, &format!("{what} at ({x:.2}, {y:.2}) m"));
    }

    /// A person so far along the base path under way.
    fn person(&self, ahead: f64) -> BoxShape {
        let base = self.sim.state().base;
        let mut at = [base[0], base[1]];
        let (sin, cos) = base[2].sin_cos();
        let mut direction = [cos, sin];
        let mut left = ahead;
        if let Motion::Follow(follow) = &self.motion {
            let first = (follow.time / STEP).ceil() as usize;
            let rest = &follow.path.base[first.min(follow.path.base.len() - 1)..];
            let length: f64 = rest
                .windows(2)
                .map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1]))
                .sum();
            if length > STANDING {
                for pose in rest {
                    let step = [pose[0] - at[0], pose[1] - at[1]];
                    let long = step[0].hypot(step[1]);
                    if long < 1e-6 {
                        continue;
                    }
                    direction = step.map(|v| v / long);
                    let part = long.min(left);
                    at = [0, 1].map(|k| at[k] + part * direction[k]);
                    left -= part;
                    if left <= 0.0 {
                        break;
                    }
                }
            }
        }
        let at = [0, 1].map(|k| at[k] + left.max(0.0) * direction[k]);
        BoxShape {
            name: "fault.person".into(),
            center: [at[0], at[1], self.scene.floor_z + FEET + PERSON[2]],
            half_extents: PERSON,
            yaw: Some(direction[1].atan2(direction[0])),
            quat: None,
        }
    }

    fn is_inside(&self, shape: &BoxShape) -> bool {
        let bounds = &self.scene.bounds;
        (0..2).all(|k| (bounds.min[k]..=bounds.max[k]).contains(&shape.center[k]))
    }

    /// Whether the robot must stand now because it does not see. It then brakes and keeps what it was about for later.
    pub(super) fn stands_blind(&mut self, now: f64) -> bool {
        if self.faults.is_blind(now, self.settings.sensors) {
            if self.faults.held.is_none() {
                self.faults.held = Some(self.activity);
                self.activity = "standing: a sensor is silent";
                self.faults
                    .note(now, "a sensor fell silent: the robot stands");
            }
            self.hold(now);
            return true;
        }
        if let Some(activity) = self.faults.held.take() {
            self.activity = activity;
            self.faults.note(now, "the sensor is back");
        }
        false
    }

    /// Brakes; a path under way waits, and does not count as one on which the robot is stuck.
    pub(super) fn hold(&mut self, now: f64) {
        self.controller.halt();
        if let Motion::Follow(follow) = &mut self.motion {
            follow.still.0 = now;
        }
    }
}
