//! One search: looks at the world, plans, goes and looks again.

use super::plans::PlanError;
use super::record::{FlapResult, StepRecord};
use super::settings::{FlapSettings, PlannerKind, SettingsError, ViewsKind};
use super::site::{self, Site, Travel};
use super::space::{self, CELL, Seen, Space};
use super::tap::Tap;
use crate::clock::Lap;
use crate::record::{Recorder, Silent};
use crate::scene::Scene;
use crate::sim::DepthCamera;
use cpu_time::ThreadTime;
use objsearch::{
    Budget, CostModel, Goal, GridPaths, LocalParams, Look, Place, Plan, Record, Survey, Task,
    TravelTable, View, branch_and_bound, deepen, greedy, local, probability_of, widen,
};
use std::sync::atomic::{AtomicBool, Ordering};
use viewsample::flap::{FanPose, Haze};

/// What can go wrong.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FlapError {
    /// Settings out of range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// A floor plan without a free place.
    #[error(transparent)]
    Plans(#[from] PlanError),
    /// A scene without anything to search.
    #[error("scene {0} has no target_volumes; FLAP needs at least one with 0 < p < 1")]
    NoVolumes(String),
    /// Volumes or planning input refused.
    #[error(transparent)]
    Search(#[from] objsearch::Error),
    /// The map was refused.
    #[error(transparent)]
    Map(#[from] voxmap::Error),
    /// Views could not be sampled.
    #[error(transparent)]
    Views(#[from] viewsample::Error),
    /// A camera pose was refused.
    #[error(transparent)]
    Robot(#[from] robots::Error),
    /// A sampled view is out of the robot's reach.
    #[error("the robot cannot bring its camera to {0:?}")]
    Unreachable([f64; 3]),
}

/// A search and what is needed to draw it.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// What goes into `result.json`.
    pub result: FlapResult,
    /// Base positions of the looks, the start first, m.
    pub way: Vec<[f64; 2]>,
    /// Camera poses of the looks.
    pub poses: Vec<FanPose>,
    /// Camera poses of all views sampled at first.
    pub sampled: Vec<FanPose>,
}

/// What a running search tells after each look.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// Looks so far.
    pub looks: usize,
    /// Simulated time, s.
    pub time: f64,
    /// Probability that the target would have been seen.
    pub probability: f64,
    /// Expected time so far, s.
    pub expected_time: f64,
    /// Views of the plan that the look began.
    pub planned: usize,
}

/// A view of the search.
#[derive(Clone, Debug)]
struct SearchView {
    pose: FanPose,
    place: Place,
    /// Unknown cells of the volumes that it shows, as indices of the sight grid, and the chance of each to be shown.
    cells: Vec<(u32, f64)>,
    taken: bool,
    /// Row in the travel table; none if the view was dropped.
    row: Option<usize>,
}

/// The world as the planner's loop sees it.
struct FlapWorld<'a, 'r> {
    site: &'a Site,
    settings: &'a FlapSettings,
    travel: Travel,
    paths: GridPaths,
    space: Space,
    camera: DepthCamera,
    views: Vec<SearchView>,
    table: TravelTable,
    here: Place,
    /// Times of the last survey, by view.
    seconds: Vec<(usize, f64)>,
    surveys: u64,
    resample_ms: f64,
    retable_ms: f64,
    /// Where all that happens is told.
    tap: &'a Tap<'r>,
}

impl<'a, 'r> FlapWorld<'a, 'r> {
    fn new(
        site: &'a Site,
        settings: &'a FlapSettings,
        tap: &'a Tap<'r>,
    ) -> Result<Self, FlapError> {
        let views = site
            .views
            .iter()
            .enumerate()
            .map(|(row, view)| {
                Ok(SearchView {
                    pose: view.pose,
                    place: site::place(&site.robot, &view.pose)?,
                    cells: view.cells.iter().map(|&c| (c, 1.0)).collect(),
                    taken: false,
                    row: Some(row),
                })
            })
            .collect::<Result<_, FlapError>>()?;
        let mut world = Self {
            site,
            settings,
            travel: Travel::of(settings),
            paths: site.paths.clone(),
            space: site.space.clone(),
            camera: space::camera(),
            views,
            table: site.table.clone(),
            here: site.start,
            seconds: Vec::new(),
            surveys: 0,
            resample_ms: 0.0,
            retable_ms: 0.0,
            tap,
        };
        if world.is_hazy() {
            for view in 0..world.views.len() {
                world.evaluate(view);
            }
        }
        Ok(world)
    }

    fn is_hazy(&self) -> bool {
        self.settings.haze > 0.0 || self.settings.haze_elsewhere > 0.0
    }

    fn evaluate(&mut self, view: usize) {
        let pose = self.views[view].pose;
        self.views[view].cells = if self.is_hazy() {
            let haze = Haze {
                of_interest: self.settings.haze,
                elsewhere: self.settings.haze_elsewhere,
            };
            self.space.sight.view_through(&self.site.fan, &pose, haze)
        } else {
            let shown = self.space.sight.view(&self.site.fan, &pose);
            shown.iter().map(|&c| (c, 1.0)).collect()
        };
    }

    /// Brings what the views show up to date after a look.
    fn refresh(&mut self, seen: &Seen) {
        let changed = if self.is_hazy() {
            &seen.changed
        } else {
            &seen.blocked
        };
        // Half the diagonal of a cell.
        let radius = 0.87 * CELL;
        for view in 0..self.views.len() {
            if self.views[view].taken {
                continue;
            }
            let pose = self.views[view].pose;
            let fan = &self.site.fan;
            if changed.iter().any(|c| fan.may_meet(&pose, *c, radius)) {
                self.evaluate(view);
            } else {
                let sight = &self.space.sight;
                self.views[view].cells.retain(|&(c, _)| sight.is_open(c));
            }
        }
    }

    /// Keeps the planned views, drops the others and samples new ones.
    fn resample(&mut self, planned: &[usize]) -> Result<(), FlapError> {
        for (view, state) in self.views.iter_mut().enumerate() {
            state.taken |= !planned.contains(&view);
        }
        let lap = ThreadTime::now();
        let targets = site::targets(&self.space);
        let settings = FlapSettings {
            samples: self.settings.samples.saturating_sub(planned.len()),
            ..self.settings.clone()
        };
        // Another stream of poses in each cycle.
        let seed = self.settings.seed.wrapping_add(self.surveys << 32);
        let (fan, limits) = (&self.site.fan, &self.site.limits);
        let space = &mut self.space;
        let fresh = site::sample(
            space,
            fan,
            &targets,
            limits,
            &settings,
            seed,
            self.here.base,
        )?;
        let places = fresh
            .iter()
            .map(|v| site::place(&self.site.robot, &v.pose))
            .collect::<Result<Vec<_>, _>>()?;
        let reached = site::reachable(&self.here, &places, &mut self.paths);
        for ((view, place), _) in fresh.into_iter().zip(places).zip(reached).filter(|v| v.1) {
            self.views.push(SearchView {
                pose: view.pose,
                place,
                cells: view.cells.iter().map(|&c| (c, 1.0)).collect(),
                taken: false,
                row: None,
            });
            if self.is_hazy() {
                self.evaluate(self.views.len() - 1);
            }
        }
        self.resample_ms += 1e3 * lap.elapsed().as_secs_f64();
        let lap = ThreadTime::now();
        let mut places = Vec::new();
        for view in self.views.iter_mut() {
            view.row = (!view.taken).then_some(places.len());
            if !view.taken {
                places.push(view.place);
            }
        }
        self.table = site::travel_table(&places, self.settings.clusters, &mut self.paths);
        self.retable_ms += 1e3 * lap.elapsed().as_secs_f64();
        Ok(())
    }

    /// The planning problem over these views, with their cells thinned by the chance to be shown, or not.
    fn task(&self, views: &[usize], costs: &impl CostModel, thin: bool) -> Result<Task, FlapError> {
        let shown: Vec<View> = views
            .iter()
            .map(|&v| {
                let cells = self.views[v].cells.iter();
                let kept = cells.filter(|&&(c, chance)| !thin || coin(c) < chance);
                View::new(kept.filter_map(|(c, _)| self.space.number.get(c).copied()))
            })
            .collect();
        let goal = Goal {
            threshold: self.settings.threshold,
            detection: self.settings.detection,
        };
        Ok(Task::new(&self.space.weights, &shown, costs, &goal)?)
    }
}

/// A number in [0, 1) that belongs to a cell: a view shows the cell if its chance to do so is above that.
///
/// What hides a cell hides it from most sides, so all views share the number: a cell that is hard to see counts only for the
/// views with the best chance, if for any. With a number for each view and cell, every view would miss most cells, some other
/// one would show them, and plans would be many times too long.
fn coin(cell: u32) -> f64 {
    let mut z = u64::from(cell).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

impl objsearch::World for FlapWorld<'_, '_> {
    type Error = FlapError;

    fn survey(&mut self, planned: &[usize]) -> Result<Survey, FlapError> {
        if self.settings.views == ViewsKind::Fresh && self.surveys > 0 {
            self.resample(planned)?;
        }
        self.surveys += 1;
        let views: Vec<usize> = (0..self.views.len())
            .filter(|&v| !self.views[v].taken && !self.views[v].cells.is_empty())
            .collect();
        let rows: Vec<usize> = views.iter().filter_map(|&v| self.views[v].row).collect();
        let costs = self
            .table
            .from_state(&self.travel, &self.here, &rows, &mut self.paths)?;
        self.seconds = views
            .iter()
            .enumerate()
            .map(|(i, &v)| (v, costs.first(i)))
            .collect();
        let whole = self.task(&views, &costs, false)?;
        // Whether to go on is a matter of what can be shown at all.
        if self.is_hazy() && whole.goal_weight() >= 0.0 {
            let thinned = self.task(&views, &costs, true)?;
            if thinned.goal_weight() >= 0.0 {
                return Ok(Survey {
                    task: thinned,
                    views,
                });
            }
        }
        Ok(Survey { task: whole, views })
    }

    fn look(&mut self, view: usize) -> Result<Look, FlapError> {
        let pose = self.views[view].pose;
        self.views[view].taken = true;
        let place = self.views[view].place;
        let seconds = match self.seconds.iter().find(|(v, _)| *v == view) {
            Some(&(_, seconds)) if self.settings.mode() == objsearch::Mode::Continual => seconds,
            // Offline, from where the robot is by now.
            _ => {
                let mut costs = Vec::new();
                objsearch::Paths::from(&mut self.paths, self.here.base, &[place.base], &mut costs);
                objsearch::TravelModel::seconds(&self.travel, costs[0], &self.here, &place)
            }
        };
        let seen = self
            .space
            .look(&self.site.world, &mut self.camera, &self.site.fan, &pose)?;
        self.tap.look(&self.space.map, &seen, &pose, place.base);
        self.refresh(&seen);
        self.here = place;
        Ok(Look {
            seconds,
            weight: seen.weight,
            found: false,
        })
    }
}

/// Makes a scene ready and searches it.
///
/// # Errors
/// [`FlapError`].
pub fn run(
    scene: &Scene,
    settings: &FlapSettings,
    stop: &AtomicBool,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Outcome, FlapError> {
    run_recorded(scene, settings, stop, progress, &mut Silent)
}

/// As [`run`], and tells `recorder` all that happens. The search is the same whoever records it.
///
/// # Errors
/// [`FlapError`].
pub fn run_recorded(
    scene: &Scene,
    settings: &FlapSettings,
    stop: &AtomicBool,
    progress: &mut dyn FnMut(&Progress),
    recorder: &mut dyn Recorder,
) -> Result<Outcome, FlapError> {
    let site = Site::new(scene, settings)?;
    run_at_recorded(&site, scene, settings, stop, progress, recorder)
}

/// Searches a site that serves the settings.
///
/// # Errors
/// [`FlapError`].
pub fn run_at(
    site: &Site,
    settings: &FlapSettings,
    stop: &AtomicBool,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Outcome, FlapError> {
    search(site, settings, stop, progress, &Tap::new(&mut Silent))
}

/// As [`run_at`], and tells `recorder` all that happens. `scene`: that of the site.
///
/// # Errors
/// [`FlapError`].
pub fn run_at_recorded(
    site: &Site,
    scene: &Scene,
    settings: &FlapSettings,
    stop: &AtomicBool,
    progress: &mut dyn FnMut(&Progress),
    recorder: &mut dyn Recorder,
) -> Result<Outcome, FlapError> {
    let tap = Tap::new(recorder);
    tap.begin(scene, settings, site);
    search(site, settings, stop, progress, &tap)
}

fn search(
    site: &Site,
    settings: &FlapSettings,
    stop: &AtomicBool,
    progress: &mut dyn FnMut(&Progress),
    tap: &Tap<'_>,
) -> Result<Outcome, FlapError> {
    let total = Lap::start();
    let mut world = FlapWorld::new(site, settings, tap)?;
    let mut plan_ms: Vec<f64> = Vec::new();
    let mut first: Option<Plan> = None;
    let mut planner = |task: &Task, rest: &[usize]| {
        let started = ThreadTime::now();
        let plan = plan(task, rest, settings);
        plan_ms.push(1e3 * started.elapsed().as_secs_f64());
        first.get_or_insert_with(|| plan.clone());
        plan
    };
    let (mut looks, mut expected_time, mut before) = (0, 0.0, 0.0);
    let mut observe = |step: &objsearch::Step| {
        looks += 1;
        expected_time += (1.0 - step.probability_before) * (step.time - before);
        before = step.time;
        let now = Progress {
            looks,
            time: step.time,
            probability: step.probability,
            expected_time,
            planned: step.planned,
        };
        tap.looked(step, &now);
        progress(&now);
        !stop.load(Ordering::Relaxed)
    };
    let record: Record = objsearch::search(
        &mut world,
        settings.mode(),
        settings.look_limit,
        &mut planner,
        &mut observe,
    )?;
    let mut expected_planning = 0.0;
    let mut survival = 1.0;
    for (i, ms) in plan_ms.iter().enumerate() {
        expected_planning += survival * 1e-3 * ms;
        if let Some(step) = record.steps.get(i) {
            survival = 1.0 - step.probability;
        }
    }
    let poses: Vec<FanPose> = record
        .steps
        .iter()
        .map(|s| world.views[s.view].pose)
        .collect();
    let mut way = vec![site.start.base];
    way.extend(record.steps.iter().map(|s| world.views[s.view].place.base));
    let steps = record
        .steps
        .iter()
        .zip(&poses)
        .map(|(step, pose)| StepRecord {
            view: step.view,
            camera: pose.position,
            yaw: pose.yaw,
            pitch: pose.pitch,
            time_s: step.time,
            probability_before: step.probability_before,
            probability: step.probability,
            planned_views: step.planned,
            planned_time_s: step.planned_time,
        })
        .collect();
    let left: f64 = world.space.weights.iter().sum();
    let mut result = FlapResult::new(site, settings, &record, steps);
    result.interrupted(stop.load(Ordering::Relaxed));
    result.unseen_probability = probability_of(left);
    tap.end(result.execution_time_s, &result);
    if let Some(first) = first {
        result.first_plan_time_s = first.expected_time;
        result.first_plan_bound_s = first.lower_bound;
        result.first_plan_views = first.sequence.len();
    }
    result.wall.total_s = total.seconds();
    result.wall.plan_ms = super::record::spread(&mut plan_ms);
    result.wall.expected_planning_s = expected_planning;
    result.wall.views_ms = site.views_ms + world.resample_ms;
    result.wall.table_ms = site.table_ms + world.retable_ms;
    Ok(Outcome {
        result,
        way,
        poses,
        sampled: site.views.iter().map(|v| v.pose).collect(),
    })
}

/// Plans as the settings say.
fn plan(task: &Task, rest: &[usize], settings: &FlapSettings) -> Plan {
    let branch = settings.branch();
    let mut budget = Budget::steps(settings.steps());
    match settings.planner {
        PlannerKind::Greedy => greedy(task),
        // The paper lets it finish (60 s); so does this, within a hundred times the budget.
        PlannerKind::Flap => {
            let steps = settings.steps().saturating_mul(100);
            branch_and_bound(task, &branch, &mut Budget::steps(steps))
        }
        PlannerKind::IterPsi => deepen(task, &branch, &mut budget),
        PlannerKind::IterPhi => widen(task, &branch, &mut budget),
        PlannerKind::Local => {
            let params = LocalParams {
                seed: settings.seed,
                ..LocalParams::default()
            };
            local(task, &params, rest, &mut budget)
        }
    }
}
