//! The anytime planner: horizons, searches, improvement, and the best path so far.

use crate::error::Error;
use crate::line::{steps_needed, steps_needed_from_rest, straight_somehow};
use crate::plan::{Params, Plan, Reason, Status, Variant};
use crate::polish::{Polish, is_straight};
use crate::rng::Rng;
use crate::robot::Robot;
use crate::search::Search;
use crate::task::{Task, Timed, Waits, cost};

/// Samples after which one more horizon is searched too.
const OPENING: usize = 256;

/// Samples after which two trees that have not met start anew, with time and without; half as many more every time. Small
/// trees are quick, and whether they meet soon is a matter of luck.
const PATIENCE: [usize; 2] = [1000, 2000];

/// Planning in small steps, for callers with a clock.
///
/// The cost never rises from one step to the next, and `n` steps of one are one step of `n`.
///
/// ```
/// use strrt::{Params, Planner, Status};
///
/// // Two joints; from step 10 to 20 both must not be near zero at once.
/// let arm = strrt::from_fn([(-3.0, 3.0); 2], [1.0; 2], |q: &[f64; 2], step| {
///     !(10..20).contains(&step) || q[0].hypot(q[1]) > 1.0
/// });
/// let mut planner = Planner::new(&arm, [-1.5, 0.0], [1.5, 0.0], 31, 0.1, &Params::default(), 3)?;
/// let mut before = f64::INFINITY;
/// for _ in 0..50 { // or until the deadline
///     planner.step(10);
///     assert!(planner.cost() <= before);
///     before = planner.cost();
/// }
/// assert_eq!(planner.plan().status, Status::Solved);
/// # Ok::<(), strrt::Error>(())
/// ```
pub struct Planner<'a, const N: usize, R> {
    task: Task<'a, N, R>,
    params: Params,
    rng: Rng,
    /// Waits that may be tried, the quickest first.
    horizons: Vec<Waits>,
    /// One search for each horizon that is open; `None` before its first sample.
    searches: Vec<Option<Search<N>>>,
    /// The horizon of the best path, or the one whose turn it is.
    current: usize,
    polish: Option<Polish<N>>,
    best: Option<(f64, Vec<[f64; N]>)>,
    /// Set when there is nothing to search.
    failure: Option<Reason>,
    iterations: usize,
    /// Latest step of the base reached from the start.
    reached: usize,
    /// Samples that two trees get to meet.
    patience: usize,
    /// Nothing moves, and time is left out of the search.
    still: bool,
}

impl<'a, const N: usize, R: Robot<N>> Planner<'a, N, R> {
    /// Checks the task and tries the straight motions. Arguments as for [`plan`](crate::plan).
    ///
    /// # Errors
    /// As [`plan`](crate::plan).
    pub fn new(
        robot: &'a R,
        start: [f64; N],
        goal: [f64; N],
        steps: usize,
        dt: f64,
        params: &Params,
        seed: u64,
    ) -> Result<Self, Error> {
        params.validate()?;
        let mut task = Task::new(robot, start, goal, steps, dt)?;
        task.grace = params.start_grace;
        let still = robot.is_static()
            && params.start_grace == 0
            && params.acceleration.is_none()
            && params.variant != Variant::Published;
        let mut planner = Self {
            horizons: Vec::new(),
            searches: Vec::new(),
            task,
            params: params.clone(),
            rng: Rng::new(seed),
            current: 0,
            polish: None,
            best: None,
            failure: None,
            iterations: 0,
            reached: 0,
            patience: PATIENCE[usize::from(still)],
            still,
        };
        planner.failure = planner.look_for_reasons();
        if planner.failure.is_none() {
            planner.lay_horizons();
            planner.try_straight();
        }
        Ok(planner)
    }

    fn look_for_reasons(&self) -> Option<Reason> {
        let task = &self.task;
        if let Some(step) = (0..task.steps).find(|&step| !task.robot.base_is_valid(step)) {
            return Some(Reason::BaseBlocked { step });
        }
        if task.grace == 0 && !task.robot.is_valid(&task.start, 0) {
            return Some(Reason::StartInvalid);
        }
        if !task.robot.is_valid(&task.goal, task.steps - 1) {
            return Some(Reason::GoalInvalid);
        }
        let speed = task.robot.max_speed();
        let needed = steps_needed(&task.start, &task.goal, &speed, task.dt);
        let available = task.steps - 1 + self.params.max_wait;
        (needed > available).then_some(Reason::TooFar { needed, available })
    }

    /// Waits in the order in which they are tried: none or as few as the arm needs, then more.
    fn lay_horizons(&mut self) {
        let (task, params) = (&self.task, &self.params);
        if self.still {
            // A path brings its own.
            self.horizons.push(Waits::default());
            self.searches.push(None);
            return;
        }
        let speed = task.robot.max_speed();
        let least = steps_needed(&task.start, &task.goal, &speed, task.dt);
        let calm = params.acceleration.map_or(least, |a| {
            steps_needed_from_rest(&task.start, &task.goal, &speed, a, task.dt)
        });
        let wanted = ((least as f64 * params.slack).ceil() as usize).max(calm);
        let room = wanted.saturating_sub(task.steps - 1).min(params.max_wait);
        // With this much more, the arm can fold where the base stands, before it leaves.
        let extra = (room + least + 5).min(params.max_wait);
        for (before, after) in [(0, room), (room, 0), (0, extra), (extra, 0), (extra, extra)] {
            let waits = Waits { before, after };
            if !self.horizons.contains(&waits) {
                self.horizons.push(waits);
            }
        }
        self.searches = self.horizons.iter().map(|_| None).collect();
    }

    fn try_straight(&mut self) {
        if self.still {
            let timed = Timed {
                task: &self.task,
                waits: Waits::default(),
            };
            let mut path = timed.swift(&self.task.start, &self.task.goal);
            if timed.path_is_free(&path, 0) {
                path.dedup(); // an arm that stays needs no step
                self.keep(cost(&path), path);
            }
            return;
        }
        for (index, &waits) in self.horizons.iter().enumerate() {
            let timed = Timed {
                task: &self.task,
                waits,
            };
            if let Some(path) = straight_somehow(&timed) {
                self.best = Some((cost(&path), path));
                self.current = index;
                return;
            }
        }
    }

    /// Runs `iterations` more samples or improvements; returns how many were of use: fewer if no path exists or the best
    /// possible one is known.
    pub fn step(&mut self, iterations: usize) -> usize {
        for done in 0..iterations {
            if self.is_finished() {
                return done;
            }
            self.iterations += 1;
            self.iterate();
        }
        iterations
    }

    fn is_finished(&self) -> bool {
        let straight = |cost: f64| is_straight(cost, &self.task.start, &self.task.goal);
        self.failure.is_some() || straight(self.cost())
    }

    fn iterate(&mut self) {
        let solved = self.best.is_some();
        if !solved {
            // Horizons open one after the other and take turns.
            let open = (1 + self.iterations / OPENING).min(self.horizons.len());
            self.current = self.iterations % open;
        }
        let waits = self.horizons[self.current];
        let timed = Timed {
            task: &self.task,
            waits,
        };
        let improves = self.params.variant != Variant::Published;
        if let Some(polish) = &mut self.polish {
            polish.attempt(&timed, self.still, &mut self.rng);
            let (cost, done) = (polish.cost, polish.is_done());
            if self.best.as_ref().is_none_or(|b| cost < b.0) {
                let path = polish.path.clone();
                self.keep(cost, path);
            }
            if done {
                self.polish = None;
                // Other trees may find another way round.
                if self.still
                    || self.params.variant == Variant::Bidirectional
                    || self.rng.unit() < 0.5
                {
                    self.searches[self.current] = None;
                }
            }
            return;
        }
        if improves && let Some((_, path)) = &self.best {
            let kind = self.rng.unit();
            if kind < 0.5 {
                self.polish = if kind < 0.1 {
                    Some(Polish::new(path.clone()))
                } else {
                    Polish::detour(path, &timed, &mut self.rng)
                };
                return;
            }
        }
        if (self.still || self.params.variant == Variant::Bidirectional)
            && let Some(search) = &self.searches[self.current]
            && search.samples() >= self.patience
        {
            self.patience += PATIENCE[usize::from(self.still)] / 2;
            self.searches[self.current] = None;
        }
        let bound = self.cost();
        let most = self.task.steps - 1 + self.params.max_wait;
        let search = self.searches[self.current].get_or_insert_with(|| {
            Search::new(&timed, self.params.variant, self.still.then_some(most))
        });
        let (path, reached) = search.iterate(&timed, &self.params, bound, &mut self.rng);
        if !solved {
            self.reached = self.reached.max(timed.base_step(reached));
        }
        if let Some(path) = path {
            let cost = cost(&path);
            if cost < bound {
                self.keep(cost, path.clone());
            }
            if improves {
                self.polish = Some(Polish::new(path));
            }
        }
    }

    /// Makes a path the best one; where nothing moves, it takes the time it needs, if there is as much.
    fn keep(&mut self, cost: f64, mut path: Vec<[f64; N]>) {
        if self.still {
            let after = path.len().saturating_sub(self.task.steps);
            if after > self.params.max_wait {
                return;
            }
            path.resize(self.task.steps + after, self.task.goal);
            self.horizons[self.current] = Waits { before: 0, after };
        }
        self.best = Some((cost, path));
    }

    /// Cost of the best path so far, rad; infinite before the first.
    pub fn cost(&self) -> f64 {
        self.best.as_ref().map_or(f64::INFINITY, |b| b.0)
    }

    /// Samples and improvements so far.
    pub fn iterations(&self) -> usize {
        self.iterations
    }

    /// The best path so far, or why there is none.
    pub fn plan(&self) -> Plan<N> {
        let status = match (&self.best, self.failure) {
            (Some(_), _) => Status::Solved,
            (None, Some(_)) => Status::Infeasible,
            (None, None) => Status::BudgetExhausted,
        };
        let reason =
            self.failure.or(
                (status == Status::BudgetExhausted).then_some(Reason::NotFound {
                    reached: self.reached,
                }),
            );
        let waits = if self.best.is_some() {
            self.horizons[self.current]
        } else {
            Waits {
                before: 0,
                after: 0,
            }
        };
        Plan {
            status,
            reason,
            path: self.best.as_ref().map_or_else(Vec::new, |b| b.1.clone()),
            waited_before: waits.before,
            waited_after: waits.after,
            cost: self.cost(),
            iterations: self.iterations,
            checks: self.task.checks.get(),
        }
    }
}
