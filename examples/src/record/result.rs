//! `result.json`: what a run found and what it cost, format `seekplan-result/1`.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Value of [`RunResult::schema`].
pub const SCHEMA: &str = "seekplan-result/1";

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Ended {
    /// The planner declared the search complete.
    Complete,
    /// The time limit of the run was reached.
    TimeLimit,
    /// The person (Ctrl-C) or the calling program stopped the run.
    Interrupted,
}

impl std::fmt::Display for Ended {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Complete => "complete",
            Self::TimeLimit => "time limit",
            Self::Interrupted => "interrupted",
        })
    }
}

/// One detected tag.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TargetFound {
    /// The tag's number in the scene file.
    pub id: u32,
    /// Simulated time of detection, s.
    pub time_s: f64,
}

/// A place the planner stopped trying to see.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GivenUp {
    /// Centre of the place in the world frame, m.
    pub place: [f64; 3],
    /// How many frontier voxels it held.
    pub voxels: usize,
    /// Why, in words.
    pub reason: String,
    /// Simulated time, s.
    pub time_s: f64,
}

/// Something that was made to go wrong.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaultNote {
    /// Simulated time, s.
    pub time_s: f64,
    /// What, in words.
    pub what: String,
}

/// One sample of the coverage-over-time curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Simulated time, s.
    pub time_s: f64,
    /// Share of the reachable free space that is known, 0..1.
    pub explored: f64,
    /// Share of the observable surface that was inspected, 0..1.
    pub inspected: f64,
    /// Tags found so far.
    pub found: usize,
}

/// Median, 95th percentile and maximum of a stage's wall time, ms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageMs {
    /// Number of calls.
    pub count: usize,
    /// Median, ms.
    pub median: f64,
    /// 95th percentile, ms.
    pub p95: f64,
    /// Maximum, ms.
    pub max: f64,
}

/// Wall-clock figures: the only part of a result that differs between two equal runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wall {
    /// Whole run, s.
    pub total_s: f64,
    /// Simulated seconds per wall second.
    pub real_time_factor: f64,
    /// Per stage, under the names `map_update_ms`, `frontier_ms`, ...
    #[serde(flatten)]
    pub stages: BTreeMap<String, StageMs>,
}

/// The record of one run. SI units throughout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunResult {
    /// Always [`SCHEMA`].
    pub schema: String,
    /// `heats`.
    pub system: String,
    /// Name of the planner that ran.
    pub planner: String,
    /// `both` or `camera`.
    pub sensors: String,
    /// Name of the scene.
    pub scene: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Why the run ended.
    pub ended: Ended,
    /// Tags in the scene.
    pub targets: usize,
    /// Tags found.
    pub found: usize,
    /// `found / targets`, 1 when the scene has no tags.
    pub completeness: f64,
    /// The found tags in order of detection.
    pub targets_found: Vec<TargetFound>,
    /// Simulated time at which the run ended (T_done), s.
    pub search_time_s: f64,
    /// Simulated time of the last detection (T_tags), s; 0 when nothing was found.
    pub last_target_time_s: f64,
    /// Sum of base translation, m.
    pub base_path_m: f64,
    /// Sum over joints and ticks of |dq|, rad.
    pub joint_rotation_rad: f64,
    /// Share of the reachable free space that is known at the end, 0..1.
    pub explored_fraction: f64,
    /// Share of the observable surface that was inspected at the end, 0..1.
    pub inspected_fraction: f64,
    /// Share of the observable surface that the RGB camera had in sight in sharp images, judged by exact geometry and by the same rule for
    /// all planners: a voxel's middle in the image, within the range of detection, 0..1.
    pub seen_fraction: f64,
    /// Places the planner stopped trying to see.
    pub given_up: Vec<GivenUp>,
    /// Contact episodes between the exact shapes of robot and world.
    pub collisions: usize,
    /// Smallest exact distance between robot and world over the run, m.
    pub min_clearance_m: f64,
    /// Ticks in which a command asked for more than the limits allow.
    pub limit_violations: usize,
    /// Decisions taken (target viewpoints chosen or confirmed).
    pub decisions: usize,
    /// Viewpoints reached.
    pub views_reached: usize,
    /// Commands replaced by braking because they would have left the safe set.
    pub brakes: usize,
    /// Planner time charged to the simulated clock, s.
    pub planning_time_s: f64,
    /// What was made to go wrong and did, in order; absent from the file where nothing was.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<FaultNote>,
    /// Coverage over time, one sample a simulated second.
    pub progress: Vec<Progress>,
    /// Settings of the run as TOML text.
    pub settings: String,
    /// Wall-clock figures, apart from everything reproducible.
    pub wall: Wall,
}

impl RunResult {
    /// The result without its wall-clock object, for byte comparisons.
    pub fn reproducible(&self) -> Self {
        Self {
            wall: Wall::default(),
            ..self.clone()
        }
    }
}
