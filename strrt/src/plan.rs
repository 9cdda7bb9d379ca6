//! What goes into a plan and what comes out.

use crate::error::Error;
use crate::planner::Planner;
use crate::robot::Robot;
use crate::smooth::smooth;

/// How the search tree grows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Variant {
    /// HEATS as published: samples anywhere, one time step per sample, choice of parent and rewiring over neighbouring
    /// layers, the goal joined from the step before the last. Nothing is improved afterwards.
    Published,
    /// Each sample is followed until it is reached or blocked, new nodes try the timed straight line to the goal, and paths
    /// found are shortened.
    #[default]
    MultiStep,
    /// Two trees, from the start forwards and from the goal backwards in time; paths found are shortened.
    Bidirectional,
}

/// Effort and variant.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// How the tree grows.
    pub variant: Variant,
    /// Samples at most until a first path is found.
    pub iterations: usize,
    /// Samples and shortcuts spent on improving it.
    pub improvements: usize,
    /// Share of samples that are the goal itself (one tree only).
    pub goal_bias: f64,
    /// Time the arm gets at least, as a factor on what its straight motion needs; the base waits for the rest.
    pub slack: f64,
    /// Most steps of waiting before the base leaves and as many after it has arrived. 0: the horizon is fixed.
    pub max_wait: usize,
    /// First steps whose states need not be valid: for a start that the map overran. [`Robot::depth`] must not grow
    /// meanwhile, and who is out stays out.
    pub start_grace: usize,
    /// Joint acceleration that the path should keep, rad/s^2, from rest to rest; `None`: as published, not considered.
    /// [`smooth`] runs on the result, and the arm gets time to speed up and slow down.
    pub acceleration: Option<f64>,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            variant: Variant::MultiStep,
            iterations: 2000,
            improvements: 200,
            goal_bias: 0.1,
            slack: 1.1,
            max_wait: 200,
            start_grace: 0,
            acceleration: None,
        }
    }
}

impl Params {
    /// Checks every field.
    ///
    /// # Errors
    /// [`Error::Param`] with the field's name.
    pub fn validate(&self) -> Result<(), Error> {
        let check = |field, value: f64, good: bool, needed| {
            if good {
                Ok(())
            } else {
                Err(Error::Param {
                    field,
                    value,
                    needed,
                })
            }
        };
        let bias = self.goal_bias;
        check(
            "goal_bias",
            bias,
            (0.0..=1.0).contains(&bias),
            "within 0 to 1",
        )?;
        let slack = self.slack;
        check(
            "slack",
            slack,
            (1.0..=100.0).contains(&slack),
            "within 1 to 100",
        )?;
        let wait = self.max_wait;
        check(
            "max_wait",
            wait as f64,
            wait <= 1_000_000,
            "at most 1000000 steps",
        )?;
        let a = self.acceleration.unwrap_or(1.0);
        check(
            "acceleration",
            a,
            a > 0.0 && a.is_finite(),
            "positive and finite",
        )
    }
}

/// How planning ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// A path was found.
    Solved,
    /// No path exists; [`Plan::reason`] says why.
    Infeasible,
    /// No path within the samples.
    BudgetExhausted,
}

/// Why there is no path.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Reason {
    /// The start state is not valid at the first step.
    StartInvalid,
    /// The goal state is not valid at the last step.
    GoalInvalid,
    /// The base itself is not free at a step, whatever the arm does.
    BaseBlocked {
        /// The first such step.
        step: usize,
    },
    /// The arm would have to wait longer than [`Params::max_wait`] allows.
    TooFar {
        /// Steps the joints need.
        needed: usize,
        /// Steps there are, waits included.
        available: usize,
    },
    /// The samples ran out.
    NotFound {
        /// Latest step of the base that the tree from the start reached.
        reached: usize,
    },
}

impl std::fmt::Display for Reason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::StartInvalid => write!(f, "the start state is not free at the first step"),
            Self::GoalInvalid => write!(f, "the goal state is not free at the last step"),
            Self::BaseBlocked { step } => write!(f, "the base itself is not free at step {step}"),
            Self::TooFar { needed, available } => {
                write!(
                    f,
                    "the joints need {needed} steps, there are {available} with all waits"
                )
            }
            Self::NotFound { reached } => {
                write!(
                    f,
                    "no path within the samples; the tree reached step {reached}"
                )
            }
        }
    }
}

/// A timed path of the arm.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan<const N: usize> {
    /// How planning ended.
    pub status: Status,
    /// Why there is no path.
    pub reason: Option<Reason>,
    /// One state per step: first `waited_before` with the base at its first pose, then one per pose, then `waited_after` with
    /// the base at its last. Empty without a path.
    pub path: Vec<[f64; N]>,
    /// Steps the base has to wait before it leaves.
    pub waited_before: usize,
    /// Steps the base waits at its end.
    pub waited_after: usize,
    /// Sum of Euclidean joint distances, rad; infinite without a path.
    pub cost: f64,
    /// Samples drawn and improvements tried; 0 if a straight motion did.
    pub iterations: usize,
    /// States and motions that the robot was asked about.
    pub checks: u64,
}

/// Plans the arm's motion over `steps` poses of the base, `dt` s apart.
///
/// Straight motions are tried first: even, early, late. If the arm needs longer than the base, the base waits: at its end, and
/// if that fails, at its start. Equal arguments give equal plans, on any machine.
///
/// # Errors
/// [`Error`] for no steps, a bad `dt`, limits, speeds or parameter, or ends outside the joint limits.
pub fn plan<const N: usize>(
    robot: &impl Robot<N>,
    start: [f64; N],
    goal: [f64; N],
    steps: usize,
    dt: f64,
    params: &Params,
    seed: u64,
) -> Result<Plan<N>, Error> {
    let mut planner = Planner::new(robot, start, goal, steps, dt, params, seed)?;
    while planner.cost().is_infinite() && planner.iterations() < params.iterations {
        if planner.step(1) == 0 {
            break;
        }
    }
    if planner.cost().is_finite() {
        planner.step(params.improvements);
    }
    let plan = planner.plan();
    match params.acceleration {
        Some(limit) if plan.status == Status::Solved => smooth(robot, &plan, dt, limit),
        _ => Ok(plan),
    }
}
