//! Moves: the first look around, and the way to a chosen view.

use super::*;

/// A whole-body path, the camera's pose at its end, and what planning it took: nodes expanded, looks and samples.
type Planned = (BodyPath, Pose, (usize, usize));

/// Time for a turn of the base on the first look around, s.
const LOOK_ROUND: f64 = 7.0;
/// How far the base may come off its place on it, m.
const OFF: f64 = 0.06;
/// Time in which the arm is lowered on it, s.
const LOWERING: f64 = 2.5;
/// Time after which planning that ran out of its budget is tried again, s.
const AGAIN: f64 = 0.5;
/// Postures through which the arm is led on a long way at most.
const MOST_POSTURES: usize = 4;
/// Time that any way takes beyond its own, s.
const SETTING_OUT: f64 = 0.3;

impl Search<'_> {
    /// Turns once on the spot with the camera down, so that the floor around the start is known (G item 9); where the base cannot
    /// turn, the shoulder does. Without a LiDAR the arm knows nothing beside it, so the camera first turns level, where it is,
    /// and is lowered for the way back; and the base turns only where the ground is known to be free for it.
    pub(super) fn look_around(&mut self, now: f64) {
        let state = self.state();
        let whole = self.whole();
        // A LiDAR shows the ground beside the base while it turns; without one it must be known before.
        let least = match self.settings.sensors {
            Sensors::Both => -0.5,
            Sensors::Camera => whole.base_clearance + OFF,
        };
        let turns = (0..36).all(|i| {
            let yaw = state.base[2] + f64::from(i) * std::f64::consts::TAU / 36.0;
            whole.base_room([state.base[0], state.base[1], yaw]) >= least
        }) && whole.turns_clear(state.base, 0.1);
        // Turns in order, each from where the last one ended, with the arm as it is or lowered.
        let (side, round) = (0.8 * std::f64::consts::PI, std::f64::consts::TAU);
        let both = self.settings.sensors == Sensors::Both;
        let legs: &[(f64, bool)] = match (turns, both) {
            (true, true) => &[(round, true)],
            (true, false) => &[(round, false), (0.0, true)],
            (false, true) => &[(side, true), (-side, true), (0.0, true)],
            (false, false) => &[(side, false), (-side, false), (side, true)],
        };
        let mut path = BodyPath {
            base: Vec::new(),
            joints: Vec::new(),
        };
        let (mut at, mut lowered) = (0.0, false);
        for &(to, lowers) in legs {
            let seconds = if turns {
                LOOK_ROUND
            } else {
                1.5 * (to - at).abs() / self.motion_params.joint_speed
            };
            let steps = (seconds / STEP).ceil() as usize;
            for i in 0..=steps {
                // Smoothstep: rest to rest, within the acceleration limits.
                let ease = |t: f64| t * t * (3.0 - 2.0 * t);
                let turn = at + (to - at) * ease(i as f64 / steps as f64);
                let lower = if lowered {
                    1.0
                } else if lowers {
                    ease((i as f64 * STEP / LOWERING).min(1.0))
                } else {
                    0.0
                };
                let mut joints: Joints = std::array::from_fn(|j| {
                    state.joints[j] + lower * (self.camera_down[j] - state.joints[j])
                });
                let mut base = state.base;
                if turns {
                    base[2] += turn;
                } else {
                    joints[0] += turn;
                }
                path.base.push(base);
                path.joints.push(joints);
            }
            (at, lowered) = (to, lowers);
        }
        let (base, joints) = path.end();
        let camera = camera_at(&self.robot, base, &joints);
        self.tap.plan((now, now), &self.robot, &path, &camera);
        self.motion = Motion::Follow(Box::new(Follow {
            path,
            time: 0.0,
            target: None,
            camera,
            still: (now, state.base, state.joints),
            ahead: true,
        }));
        self.controller.reset();
    }

    /// Plans the way to a chosen view, and follows it once planning is done and the path before it is at its end.
    pub(super) fn set_out(
        &mut self,
        now: f64,
        choice: Choice,
        lap: Lap,
        (from, ahead): (Departure, bool),
    ) {
        self.activity = if choice.relaxed {
            "last tries"
        } else {
            "driving to a view"
        };
        self.faults.spent = false;
        match self.plan_best(now, &choice, &from) {
            Ok((choice, (path, camera, operations))) => {
                self.targets.set_out(&choice);
                let counted = self.targets.counted
                    + 3e-6 * operations.0 as f64
                    + 30e-6 * operations.1 as f64
                    + 0.01;
                let ready = self.account.charge(now, counted, lap.seconds());
                self.tap.plan((now, ready), &self.robot, &path, &camera);
                // A last try is worth its way whatever is inspected meanwhile: nothing else is left.
                let expected = if choice.relaxed {
                    0.0
                } else {
                    self.targets.gain_at(path.end().0, &camera).max(1e-9)
                };
                self.pending = Some(Pending {
                    at: ready,
                    ahead,
                    follow: Box::new(Follow {
                        path,
                        time: 0.0,
                        target: Some(Target { choice, expected }),
                        camera,
                        still: (now, from.base, from.joints),
                        ahead: false,
                    }),
                });
            }
            // The robot may still see more, and will be asked again at the end of its path.
            Err(_) if ahead => {
                self.account
                    .charge(now, self.targets.counted, lap.seconds());
            }
            // No fault of the place: it is asked for again.
            Err(_) if self.faults.spent => {
                self.account
                    .charge(now, self.targets.counted, lap.seconds());
                self.activity = "planning ran out of its budget";
                self.rest();
                self.next_decision = now + AGAIN;
            }
            Err(Failure(reason)) => {
                self.targets.set_out(&choice);
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

    /// Of the ways to the next view of the tour and to other views of the cover, the one that shows most for its time.
    fn plan_best(
        &mut self,
        now: f64,
        next: &Choice,
        from: &Departure,
    ) -> Result<(Choice, Planned), Failure> {
        let others = std::mem::take(&mut self.targets.alternatives);
        let several = !others.is_empty();
        let mut effort = (0, 0);
        let mut best: Result<(f64, Choice, Planned), Failure> =
            Err(Failure("no view to plan for".into()));
        for (k, choice) in std::iter::once(next.clone()).chain(others).enumerate() {
            match self.plan_motion(now, &choice, from) {
                Ok(straight) => {
                    let (rate, looks) = if several {
                        self.rate(&choice, &straight.0)
                    } else {
                        (0.0, 0)
                    };
                    effort.0 += straight.2.0;
                    effort.1 += straight.2.1 + looks;
                    if best.as_ref().map_or(true, |(least, ..)| rate > *least) {
                        best = Ok((rate, choice, straight));
                    }
                }
                // It is the next view of the tour that is blamed.
                Err(failure) if k == 0 => best = Err(failure),
                Err(_) => {}
            }
        }
        let (_, choice, (path, camera, _)) = best?;
        let (path, looks) = self.lead(path, MOST_POSTURES);
        Ok((choice, (path, camera, (effort.0, effort.1 + looks))))
    }

    /// Information a second of a way when its arm is led through one posture, and how many looks were asked for.
    fn rate(&mut self, choice: &Choice, path: &BodyPath) -> (f64, usize) {
        let (path, asked) = self.lead(path.clone(), 1);
        let looks = glance::looks(&self.whole(), &path);
        // What a last try may show does not count as inspected, and little else is left on its way.
        let own = if choice.relaxed { choice.info } else { 0.0 };
        let seen = self.targets.gain_along(&looks).max(own);
        (seen / (path.seconds() + SETTING_OUT), asked + looks.len())
    }

    /// A path with its arm led through at most so many postures that see what is left, and how many looks were asked for.
    fn lead(&mut self, path: BodyPath, most: usize) -> (BodyPath, usize) {
        if !self.settings.views.on_the_way {
            return (path, 0);
        }
        let lap = Lap::start();
        let whole = whole(&self.robot, &self.mapper, self.settings);
        let targets = &self.targets;
        let led = glance::improve(
            &whole,
            &self.motion_params,
            &self.postures,
            path,
            (self.settings.views.delay_price, most),
            |looks| targets.gain_along(looks),
        );
        self.watch.stop(Stage::ArmPath, lap);
        led
    }

    /// Base with free yaw first; where the arm cannot make up for it, the yaw of the library (sect. V-A).
    fn plan_motion(
        &mut self,
        now: f64,
        choice: &Choice,
        from: &Departure,
    ) -> Result<Planned, Failure> {
        let goal = BodyState {
            base: choice.base,
            joints: choice.joints,
        };
        let place = [choice.base[0], choice.base[1]];
        let seed = self.settings.seed ^ (now / TICK) as u64;
        let whole = whole(&self.robot, &self.mapper, self.settings);
        let (planner, watch) = (&mut self.base_planner, &mut self.watch);
        let mut tried: Result<(BodyPath, Pose), Failure> = Err(Failure("no way was tried".into()));
        let mut effort = (0, 0);
        for yaw in [GoalYaw::Free, GoalYaw::Fixed(choice.base[2])] {
            if self.faults.runs_out(BudgetStage::BasePath, now) {
                tried = Err(Failure("base path: out of budget".into()));
                continue;
            }
            let (base, _) = watch.time(Stage::BasePath, || {
                plan_base(
                    planner,
                    &whole,
                    &self.motion_params,
                    from.base,
                    from.speed,
                    place,
                    &yaw,
                )
            });
            let mut base = match base {
                Ok(base) => base,
                Err(failure) => {
                    tried = Err(failure);
                    continue;
                }
            };
            effort.0 += base.expansions;
            if self.faults.runs_out(BudgetStage::ArmPath, now) {
                tried = Err(Failure("arm path: out of budget".into()));
                continue;
            }
            let lap = Lap::start();
            let stance = stances(
                &whole,
                &self.motion_params,
                &goal,
                &base.poses,
                &from.joints,
            )
            .into_iter()
            .find(|s| {
                let end = base.poses[base.poses.len() - 1];
                whole.arm_is_free([end[0], end[1], end[2] + s.turn], &s.joints)
            });
            let arm = stance
                .ok_or_else(|| {
                    Failure("no free arm posture shows the view from where the base stops".into())
                })
                .and_then(|stance| {
                    turn_on(&mut base.poses, stance.turn, &self.motion_params.base);
                    plan_arm(
                        &whole,
                        &self.motion_params,
                        &base.poses,
                        from.joints,
                        stance.joints,
                        seed,
                    )
                });
            watch.stop(Stage::ArmPath, lap);
            match arm {
                Ok((path, samples)) => {
                    let (base_end, joints_end) = path.end();
                    let camera = camera_at(&self.robot, base_end, &joints_end);
                    effort.1 += samples;
                    tried = Ok((path, camera));
                    break;
                }
                Err(failure) => tried = Err(failure),
            }
        }
        tried.map(|(path, camera)| (path, camera, effort))
    }
}
