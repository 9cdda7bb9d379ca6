//! What a run leaves behind: `result.json`, `topdown.svg`, the closing table, and the recording of all that happened.
//!
//! A run tells a [`Recorder`] its [`Event`]s. [`JsonLines`] writes them to `record.jsonl` as they come; [`Html`] makes `report.html` of them.

mod columns;
mod document;
mod event;
mod html;
mod json_lines;
mod pack;
mod recorder;
mod replay;
mod result;
mod ros;
mod still;
mod table;
mod topdown;
mod trace;

pub(crate) use document::document;

pub use columns::{ColumnClass, Columns, FrontierColumns};
pub use event::{
    Begin, Candidate, CellRuns, CellState, CycleEvent, DecisionEvent, Entry, Event, FoundEvent,
    FrontierShape, FrontiersEvent, GRAIN, GivenUpEvent, GridShape, HorizonEvent, LookEvent,
    PlanEvent, PoseEvent, ProgressEvent, RECORD_SCHEMA, RegionsEvent, RobotShape, ScanEvent,
    StageCycle, View, VolumeShape, round,
};
pub use html::{Html, REPORT_FILE};
pub use json_lines::{JsonLines, RECORD_FILE, ReadError, read};
pub use recorder::{Both, Memory, Recorder, Silent};
pub use replay::{ReportError, rebuild, replay};
pub use result::{
    Ended, FaultNote, GivenUp, Progress, RunResult, SCHEMA, StageMs, TargetFound, Wall,
};
pub use ros::{TRACE_FILE, Trace as RosTrace};
pub use still::still;
pub use table::closing_table;
pub use topdown::{Ground, Mark, Outline, draw};
pub use trace::{Coverage, MapLayer, Sample, Stop, Trace};

use std::path::{Path, PathBuf};

/// A file that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {path}: {source}")]
pub struct WriteError {
    /// The file.
    pub path: PathBuf,
    /// Why.
    pub source: std::io::Error,
}

/// Writes `result.json` and `topdown.svg` into `folder`, each under a temporary name first, so that a killed run
/// leaves no half file. Returns the paths written.
///
/// # Errors
/// [`WriteError`] naming the file that could not be written.
pub fn write(
    folder: &Path,
    result: &RunResult,
    ground: &Ground,
    trace: &Trace,
) -> Result<Vec<PathBuf>, WriteError> {
    let json = serde_json::to_string_pretty(result).map_err(|e| WriteError {
        path: folder.join("result.json"),
        source: std::io::Error::other(e),
    })?;
    [
        ("result.json", json + "\n"),
        ("topdown.svg", draw(ground, trace, result)),
    ]
    .into_iter()
    .map(|(name, text)| write_file(folder, name, &text))
    .collect()
}

/// Writes one file into `folder`, made if need be, under a temporary name first. Returns its path.
///
/// # Errors
/// [`WriteError`] naming the file that could not be written.
pub fn write_file(folder: &Path, name: &str, text: &str) -> Result<PathBuf, WriteError> {
    let fail = |path: &Path| {
        let path = path.to_owned();
        move |source| WriteError { path, source }
    };
    std::fs::create_dir_all(folder).map_err(fail(folder))?;
    let path = folder.join(name);
    // A name of this process's own, so that two that write the same file do not mix.
    let partial = path.with_file_name(format!(".{name}.{}.partial", std::process::id()));
    let written = std::fs::write(&partial, text).map_err(fail(&partial));
    let kept = written.and_then(|()| std::fs::rename(&partial, &path).map_err(fail(&path)));
    if kept.is_err() {
        // Room for others, where the disk is full.
        let _ = std::fs::remove_file(&partial);
    }
    kept.map(|()| path)
}

/// Name that a file has until it is whole.
fn partial_name(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.partial"))
}

/// Text as it may stand in HTML and SVG, also within the quotes of an attribute.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
