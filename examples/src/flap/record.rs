//! `result.json` of a FLAP search, format `seekplan-result/1`, and the closing table.

use super::draw::draw;
use super::search::Outcome;
use super::settings::{FlapSettings, MapKind};
use super::site::Site;
use crate::record::{Ground, SCHEMA, StageMs, WriteError};
use objsearch::{Ended, Record};
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// One look.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepRecord {
    /// Number of the view.
    pub view: usize,
    /// Camera position, m.
    pub camera: [f64; 3],
    /// Heading of the camera, rad.
    pub yaw: f64,
    /// Elevation of the camera, rad.
    pub pitch: f64,
    /// Simulated time after the look, s.
    pub time_s: f64,
    /// Probability to have seen the target before the look.
    pub probability_before: f64,
    /// Probability to have seen the target after it.
    pub probability: f64,
    /// Views of the plan that it began.
    pub planned_views: usize,
    /// Expected time of that plan, s.
    pub planned_time_s: f64,
}

/// Figures that differ between two equal runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FlapWall {
    /// Whole search, s.
    pub total_s: f64,
    /// CPU time of a plan.
    pub plan_ms: StageMs,
    /// CPU time of all plans, each counted with the probability that it is needed, s.
    pub expected_planning_s: f64,
    /// Sampling and evaluating views, CPU time, ms.
    pub views_ms: f64,
    /// Making travel tables, CPU time, ms.
    pub table_ms: f64,
}

/// The record of one search. SI units throughout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlapResult {
    /// Always `seekplan-result/1`.
    pub schema: String,
    /// `flap`.
    pub system: String,
    /// Name of the planner.
    pub planner: String,
    /// Name of the scene.
    pub scene: String,
    /// Seed of everything random.
    pub seed: u64,
    /// `complete`, `time_limit` (limit of looks, or no view left to go to) or `interrupted`.
    pub ended: String,
    /// Why, in words.
    pub reason: String,
    /// `continual` or `offline`.
    pub mode: String,
    /// `known` or `walls`.
    pub map: String,
    /// Expected time until the target is seen or the search ends, s.
    pub expected_time_s: f64,
    /// Simulated time of the whole search, s.
    pub execution_time_s: f64,
    /// Looks.
    pub sensing_actions: usize,
    /// Probability that the target would have been seen.
    pub probability: f64,
    /// Probability that a target is in cells that were not seen.
    pub unseen_probability: f64,
    /// Views sampled at the start.
    pub views: usize,
    /// Those of them that can be reached.
    pub reachable_views: usize,
    /// Expected time of the first plan, s.
    pub first_plan_time_s: f64,
    /// Lower bound of it where the planner knows one, s.
    pub first_plan_bound_s: f64,
    /// Views of the first plan.
    pub first_plan_views: usize,
    /// Plans made.
    pub plans: usize,
    /// The looks in order.
    pub steps: Vec<StepRecord>,
    /// Settings as TOML text.
    pub settings: String,
    /// Times of this machine.
    pub wall: FlapWall,
}

impl FlapResult {
    pub(super) fn new(
        site: &Site,
        settings: &FlapSettings,
        record: &Record,
        steps: Vec<StepRecord>,
    ) -> Self {
        let (ended, reason) = match record.ended {
            Ended::Found => ("complete", "the target was seen"),
            Ended::Exhausted => ("complete", "less than the threshold is left to see"),
            Ended::PlanDone => ("complete", "the offline plan was carried out"),
            Ended::Stuck => ("time_limit", "no view is left that can be reached"),
            Ended::LookLimit => ("time_limit", "the limit of looks was reached"),
        };
        let map = match settings.map {
            MapKind::Known => "known",
            MapKind::Walls => "walls",
        };
        Self {
            schema: SCHEMA.into(),
            system: "flap".into(),
            planner: settings.planner.name().into(),
            scene: site.name.clone(),
            seed: settings.seed,
            ended: ended.into(),
            reason: reason.into(),
            mode: if settings.offline {
                "offline"
            } else {
                "continual"
            }
            .into(),
            map: map.into(),
            expected_time_s: record.expected_time,
            execution_time_s: record.execution_time,
            sensing_actions: record.steps.len(),
            probability: record.probability,
            unseen_probability: 0.0,
            views: site.sampled,
            reachable_views: site.views.len(),
            first_plan_time_s: 0.0,
            first_plan_bound_s: 0.0,
            first_plan_views: 0,
            plans: record.plans,
            steps,
            settings: settings.to_toml(),
            wall: FlapWall::default(),
        }
    }

    /// Marks a search that was stopped from outside.
    pub(super) fn interrupted(&mut self, stopped: bool) {
        if stopped && self.ended == "time_limit" {
            self.ended = "interrupted".into();
            self.reason = "stopped".into();
        }
    }

    /// The result without the machine's times, for byte comparisons.
    pub fn reproducible(&self) -> Self {
        Self {
            wall: FlapWall::default(),
            ..self.clone()
        }
    }
}

/// Median, 95th percentile and maximum.
pub(super) fn spread(ms: &mut [f64]) -> StageMs {
    ms.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let last = ms.len().saturating_sub(1) as f64;
        ms.get((share * last).round() as usize)
            .copied()
            .unwrap_or(0.0)
    };
    StageMs {
        count: ms.len(),
        median: at(0.5),
        p95: at(0.95),
        max: at(1.0),
    }
}

/// Writes `result.json` and `topdown.svg` into `folder`, each under a temporary name first. Returns the paths written.
///
/// # Errors
/// [`WriteError`] naming the file that could not be written.
pub fn write(
    folder: &Path,
    outcome: &Outcome,
    ground: &Ground,
    volumes: &[crate::scene::TargetVolume],
) -> Result<Vec<PathBuf>, WriteError> {
    let json = serde_json::to_string_pretty(&outcome.result).map_err(|e| WriteError {
        path: folder.join("result.json"),
        source: std::io::Error::other(e),
    })?;
    [
        ("result.json", json + "\n"),
        ("topdown.svg", draw(ground, volumes, outcome)),
    ]
    .into_iter()
    .map(|(name, text)| crate::record::write_file(folder, name, &text))
    .collect()
}

/// The table a person reads at the end of a search.
pub fn closing_table(result: &FlapResult) -> String {
    let mut out = String::new();
    let mut row = |name: &str, value: String| {
        let _ = writeln!(out, "  {name:<22} {value}");
    };
    let (mode, map) = (&result.mode, &result.map);
    row(
        "scene",
        format!("{} (seed {}, map {map})", result.scene, result.seed),
    );
    row("planner", format!("{}, {mode}", result.planner));
    row("ended", format!("{}: {}", result.ended, result.reason));
    row("expected time", format!("{:.1} s", result.expected_time_s));
    row(
        "execution time",
        format!("{:.1} s", result.execution_time_s),
    );
    row("sensing actions", result.sensing_actions.to_string());
    let share = 100.0 * result.probability;
    row("probability of success", format!("{share:.1} %"));
    let (views, first) = (result.first_plan_views, result.first_plan_time_s);
    row(
        "first plan",
        format!("{views} views, expected {first:.1} s"),
    );
    if result.first_plan_bound_s > 0.0 {
        row(
            "lower bound of it",
            format!("{:.1} s", result.first_plan_bound_s),
        );
    }
    let plan = &result.wall.plan_ms;
    row(
        "planning",
        format!(
            "median {:.2} ms, p95 {:.2} ms, {} plans",
            plan.median, plan.p95, plan.count
        ),
    );
    row(
        "views",
        format!(
            "{}, {} reachable, in {:.0} ms",
            result.views, result.reachable_views, result.wall.views_ms
        ),
    );
    row("travel table", format!("{:.0} ms", result.wall.table_ms));
    row("wall time", format!("{:.1} s", result.wall.total_s));
    out
}
