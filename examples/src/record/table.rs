//! The closing table of a run.

use super::result::RunResult;
use std::fmt::Write;

/// Most given-up places listed.
const GIVEN_UP_ROWS: usize = 6;

/// Formats the result as the aligned table a person reads at the end of a run.
pub fn closing_table(result: &RunResult) -> String {
    let mut out = String::new();
    let mut row = |name: &str, value: String| {
        let _ = writeln!(out, "  {name:<22} {value}");
    };
    row(
        "scene",
        format!(
            "{} (seed {}, sensors {})",
            result.scene, result.seed, result.sensors
        ),
    );
    row("planner", result.planner.clone());
    row("ended", result.ended.to_string());
    row("search time", format!("{:.1} s", result.search_time_s));
    row("last tag", format!("{:.1} s", result.last_target_time_s));
    row(
        "completeness",
        format!(
            "{:.1} % ({} of {} tags)",
            100.0 * result.completeness,
            result.found,
            result.targets
        ),
    );
    row(
        "explored, inspected",
        format!(
            "{:.1} % of free space, {:.1} % of surface ({:.1} % seen once)",
            100.0 * result.explored_fraction,
            100.0 * result.inspected_fraction,
            100.0 * result.seen_fraction
        ),
    );
    row("base path", format!("{:.1} m", result.base_path_m));
    row(
        "joint rotation",
        format!("{:.1} rad", result.joint_rotation_rad),
    );
    row("collisions", result.collisions.to_string());
    row(
        "minimum clearance",
        format!("{:.3} m", result.min_clearance_m),
    );
    row("limit violations", result.limit_violations.to_string());
    row(
        "decisions, views",
        format!("{}, {}", result.decisions, result.views_reached),
    );
    row("braking commands", result.brakes.to_string());
    row("given-up places", result.given_up.len().to_string());
    for place in result.given_up.iter().take(GIVEN_UP_ROWS) {
        let [x, y, z] = place.place;
        row(
            "",
            format!(
                "({x:.2}, {y:.2}, {z:.2}) m, {} voxels: {}",
                place.voxels, place.reason
            ),
        );
    }
    if result.given_up.len() > GIVEN_UP_ROWS {
        row(
            "",
            format!(
                "and {} more, in result.json",
                result.given_up.len() - GIVEN_UP_ROWS
            ),
        );
    }
    row(
        "wall time",
        format!(
            "{:.1} s, {:.1} times real time",
            result.wall.total_s, result.wall.real_time_factor
        ),
    );
    let _ = writeln!(
        out,
        "  {:<22} {:>9} {:>9} {:>9} {:>9}",
        "stage, ms", "median", "p95", "max", "calls"
    );
    for (name, stage) in &result.wall.stages {
        let name = name.strip_suffix("_ms").unwrap_or(name).replace('_', " ");
        let _ = writeln!(
            out,
            "  {name:<22} {:>9.2} {:>9.2} {:>9.2} {:>9}",
            stage.median, stage.p95, stage.max, stage.count
        );
    }
    out
}
