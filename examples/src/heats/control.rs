//! Local IPC optimisation: model predictive control along a whole-body path, and the guard before commands leave
//! (HEATS sect. V-B).

use super::body::Whole;
use super::motion::BodyPath;
use super::settings::MotionSettings;
use crate::sim::{Command, MotionLimits, State, TICK, stoppable};
use ddp_rbf::nalgebra::SVector;
use ddp_rbf::{
    Barrier, Constraint, GuardParams, InputBox, Mpc, Options, Robot, StateBox, Tracking, Verdict,
    guard,
};
use robots::{FieldClearance, SelfClearance};

type X = SVector<f64, 9>;
type U = SVector<f64, 8>;

/// Beyond these distances a constraint does not push: inputs, joints (rad), clearance (m), self-clearance (m).
const CUTOFFS: (f64, f64, f64, f64) = (0.05, 0.2, 0.25, 0.08);

/// How much nearer than it is a body may come to a surface that showed up inside the margin, on its way out, m: sliding along the
/// side of a voxel must not be refused for what interpolation and the roundness of the circles over the base add and take.
const SLIDE: f64 = 0.018;

/// Commands braked one after another, 0.4 s of them, after which a body just outside of the margin is held: its controller finds
/// nothing that keeps out of it.
const HELD: usize = 10;

/// The margin that the guard keeps, and how it gives way where a body could not move otherwise.
#[derive(Clone, Copy, Debug, Default)]
struct Slack {
    /// Room that is kept while the margin is not there, m; set once when that begins, so that slack does not add up.
    floor: Option<f64>,
    /// Commands braked one after another.
    held: usize,
}

impl Slack {
    /// Room to keep for a body that has `room` m, where `usual` is the margin.
    fn margin(&mut self, room: f64, usual: f64) -> f64 {
        self.floor = match self.floor {
            _ if room >= usual && self.held < HELD => None,
            Some(floor) if room >= floor => Some(floor),
            // Outside of all that is mapped it stays there.
            _ if room > 0.0 => Some((room - SLIDE).max(0.0)),
            _ => Some(room - SLIDE),
        };
        self.floor.map_or(usual, |floor| floor.min(usual))
    }

    /// Notes what became of a command given with so much room.
    fn note(&mut self, braked: bool, room: f64, usual: f64) {
        self.held = match braked {
            true => self.held + 1,
            // Once it moves, it goes on until the margin is there again with some to spare.
            false if self.held >= HELD && room < usual + SLIDE => self.held,
            false => 0,
        };
    }
}

/// The controller of one run.
pub struct Controller {
    mpc: Mpc<9, 8>,
    settings: MotionSettings,
    limits: MotionLimits,
    guard: GuardParams<8>,
    slack: Slack,
    /// Input asked for at present.
    wanted: U,
    /// Commands replaced by braking.
    pub brakes: usize,
}

fn state_vector(base: [f64; 3], joints: &[f64; 6]) -> X {
    X::from_fn(|i, _| if i < 3 { base[i] } else { joints[i - 3] })
}

fn input_vector(command: &Command) -> U {
    U::from_fn(|i, _| match i {
        0 => command.v,
        1 => command.w,
        j => command.qd[j - 2],
    })
}

fn velocity(state: &State) -> U {
    input_vector(&Command {
        v: state.v,
        w: state.w,
        qd: state.qd,
    })
}

fn command_of(u: &U) -> Command {
    Command {
        v: u[0],
        w: u[1],
        qd: std::array::from_fn(|j| u[2 + j]),
    }
}

impl Controller {
    /// A controller at rest.
    ///
    /// # Errors
    /// The solver's message for a horizon it cannot hold.
    pub fn new(settings: &MotionSettings, limits: &MotionLimits) -> Result<Self, ddp_rbf::Error> {
        let acceleration = U::from_fn(|i, _| match i {
            0 => limits.a,
            1 => limits.alpha,
            j => limits.joint_a[j - 2],
        });
        Ok(Self {
            mpc: Mpc::new(settings.knots, settings.horizon / settings.knots as f64)?,
            settings: settings.clone(),
            limits: *limits,
            guard: GuardParams {
                acceleration,
                period: settings.control_period,
                look: TICK,
                margin: settings.guard_margin,
            },
            slack: Slack::default(),
            wanted: U::zeros(),
            brakes: 0,
        })
    }

    /// Forgets the last solution, for a new path.
    pub fn reset(&mut self) {
        self.mpc.reset();
    }

    /// Asks for rest.
    pub fn halt(&mut self) {
        self.wanted = U::zeros();
        self.mpc.reset();
    }

    /// One control step: solves from the robot's state along `path` from time `t` on, and checks the command.
    ///
    /// # Errors
    /// The solver's message for a state that is not finite.
    pub fn step(
        &mut self,
        whole: &Whole<'_>,
        state: &State,
        path: &BodyPath,
        t: f64,
    ) -> Result<Verdict, ddp_rbf::Error> {
        let n = self.settings.knots;
        let dt = self.settings.horizon / n as f64;
        let now = velocity(state);
        let states: Vec<X> = (0..=n)
            .map(|k| {
                let (base, joints) = path.at(t + k as f64 * dt);
                state_vector(base, &joints)
            })
            .collect();
        let inputs: Vec<U> = states
            .windows(2)
            .map(|pair| {
                let d = pair[1] - pair[0];
                let yaw = 0.5 * (pair[0][2] + pair[1][2]);
                U::from_fn(|i, _| match i {
                    0 => (d[0] * yaw.cos() + d[1] * yaw.sin()) / dt,
                    1 => d[2] / dt,
                    j => d[j + 1] / dt,
                })
            })
            .collect();
        let cost = Tracking::new(
            states,
            inputs,
            dt,
            X::from_column_slice(&[20.0, 20.0, 10.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0]),
            U::from_column_slice(&[0.5, 0.3, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1]),
            X::from_column_slice(&[20.0, 20.0, 10.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0]),
        );
        let (mu, delta) = self.settings.barrier;
        let barrier = Barrier {
            mu,
            delta,
            cutoff: None,
        };
        let top = U::from_fn(|i, _| match i {
            0 => self.limits.v,
            1 => self.limits.w,
            j => self.limits.joint_v[j - 2],
        });
        let input_box = InputBox::new(-top, top, barrier.until(CUTOFFS.0))
            .reachable_from(now, self.guard.acceleration * dt);
        let joint_box = StateBox {
            limits: (0..6)
                .map(|j| {
                    (
                        3 + j,
                        self.limits.joint_range[j].0,
                        self.limits.joint_range[j].1,
                    )
                })
                .collect(),
            barrier: barrier.until(CUTOFFS.1),
        };
        let field = FieldClearance::new(
            whole.robot,
            &whole.mapper.distance,
            self.settings.margin,
            barrier.until(CUTOFFS.2),
        )?;
        let own = SelfClearance::new(whole.robot, 0.01, barrier.until(CUTOFFS.3))?;
        let constraints: [&dyn Constraint<9, 8>; 4] = [&input_box, &joint_box, &field, &own];
        let x0 = state_vector(state.base, &state.joints);
        self.mpc.shift(self.settings.control_period);
        let options = Options {
            iterations: self.settings.iterations,
            ..Options::real_time()
        };
        self.mpc
            .step(whole.robot, &cost, &constraints, &x0, &options)?;
        let command = self.mpc.inputs()[0].zip_map(&top, |u, limit| u.clamp(-limit, limit));
        let clearance = |x: &X| {
            let joints = std::array::from_fn(|j| x[3 + j]);
            // The robot's own parts are exact, so they need less room than the map's.
            let own = whole.robot.self_clearance(&joints) + self.settings.guard_margin;
            whole.room([x[0], x[1], x[2]], &joints).min(own)
        };
        let room = clearance(&x0);
        let margin = self.slack.margin(room, self.guard.margin);
        let (u, verdict) = guard(
            &x0,
            &now,
            &command,
            &GuardParams {
                margin,
                ..self.guard.clone()
            },
            |x, u, dt| whole.robot.step(x, u, dt),
            clearance,
        );
        let braked = verdict == Verdict::Braked;
        self.slack.note(braked, room, self.guard.margin);
        self.brakes += usize::from(braked);
        self.wanted = u;
        Ok(verdict)
    }

    /// Base poses along the last solution, m and rad.
    pub fn horizon(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.mpc.states().iter().map(|x| [x[0], x[1], x[2]])
    }

    /// The command of this tick: towards what is wanted, as fast as acceleration allows.
    pub fn tick(&self, state: &State) -> Command {
        let now = velocity(state);
        let change = self.guard.acceleration * TICK;
        let mut command = command_of(&U::from_fn(|i, _| {
            now[i] + (self.wanted[i] - now[i]).clamp(-change[i], change[i])
        }));
        // No faster than what still stops before the end of a joint's range.
        for (j, qd) in command.qd.iter_mut().enumerate() {
            let (low, high) = self.limits.joint_range[j];
            let a = self.limits.joint_a[j];
            *qd = qd.clamp(
                -stoppable(state.joints[j] - low, a),
                stoppable(high - state.joints[j], a),
            );
        }
        command
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heats::fixture::{free_closet, looking};
    use crate::heats::settings::Settings;
    use crate::scene::Scene;
    use robots::MobileManipulator;

    #[test]
    fn the_margin_gives_way_to_a_held_body_alone_and_once() {
        let usual = 0.02;
        let mut slack = Slack::default();
        // Held just outside of the margin, it keeps it for a while; then it may come nearer, by so much and no more.
        for _ in 0..HELD {
            assert_eq!(slack.margin(0.0203, usual), usual);
            slack.note(true, 0.0203, usual);
        }
        let kept = slack.margin(0.0203, usual);
        assert!((0.0203 - SLIDE - kept).abs() < 1e-12);
        for room in [0.019, 0.012, 0.005, 0.0203, 0.03] {
            slack.note(false, room, usual);
            assert_eq!(slack.margin(room, usual), kept);
        }
        // Away from it all is as it was.
        slack.note(false, 0.05, usual);
        assert_eq!(slack.margin(0.05, usual), usual);
        // One command that is braked changes nothing.
        slack.note(true, 0.05, usual);
        slack.note(false, 0.0203, usual);
        assert_eq!(slack.margin(0.0203, usual), usual);
    }

    /// A body beside which a surface shows up, so near that the margin is gone, drives on along it and gets away.
    #[test]
    fn a_surface_that_shows_up_beside_the_base_does_not_hold_it() {
        let scene = Scene::builtin("closet").expect("embedded");
        let settings = Settings::default();
        let robot = MobileManipulator::default();
        for depth in [-0.01, 0.0, 0.01, 0.03] {
            let mut mapper = free_closet();
            let h = mapper.map.cell_size();
            // One voxel in the side of the base, `depth` m deep.
            let edge = ((2.0 / h).floor() + 2.0) * h;
            let hit = [1.0, edge as f32 + 0.5 * h as f32, 0.3];
            for _ in 0..4 {
                let origin = [1.0, 3.2, 0.3];
                mapper
                    .integrate(origin, &[hit], &[], 10.0, &[])
                    .expect("finite");
            }
            let _ = mapper.refresh();
            let whole = Whole {
                robot: &robot,
                mapper: &mapper,
                base_clearance: 0.0,
                arm_clearance: 0.0,
            };
            let y = edge + depth - 0.275;
            let joints = looking(&robot, -0.3);
            // Along the voxel and past it, in 4 s.
            let path = BodyPath {
                base: (0..=40)
                    .map(|k| [1.0 + 0.03 * f64::from(k), y, 0.0])
                    .collect(),
                joints: vec![joints; 41],
            };
            let limits = MotionLimits::for_scene(&scene.limits);
            let mut controller = Controller::new(&settings.motion, &limits).expect("good settings");
            let mut x = state_vector(path.base[0], &joints);
            let mut u = U::zeros();
            let deepest = whole.room(path.base[0], &joints);
            let mut least = deepest;
            let mut t = 0.0;
            let state = |x: &X, u: &U| State {
                base: [x[0], x[1], x[2]],
                joints: std::array::from_fn(|j| x[3 + j]),
                v: u[0],
                w: u[1],
                qd: std::array::from_fn(|j| u[2 + j]),
            };
            for _ in 0..250 {
                controller
                    .step(&whole, &state(&x, &u), &path, t)
                    .expect("finite");
                for _ in 0..2 {
                    u = input_vector(&controller.tick(&state(&x, &u)));
                    x = whole.robot.step(&x, &u, TICK);
                }
                t += settings.motion.control_period;
                let now = state(&x, &u);
                least = least.min(whole.room(now.base, &now.joints));
            }
            assert!(
                x[0] > 1.9,
                "{depth}: got to {:.3} of 2.2, {} brakes",
                x[0],
                controller.brakes
            );
            assert!(least >= deepest.min(settings.motion.guard_margin) - SLIDE - 1e-3);
        }
    }
}
