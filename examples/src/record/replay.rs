//! Files that are made from a recording.

use super::html::Html;
use super::json_lines::{RECORD_FILE, ReadError, read};
use super::recorder::{Both, Recorder};
use super::ros::{TRACE_FILE, Trace as RosTrace};
use super::{REPORT_FILE, WriteError};
use std::path::{Path, PathBuf};

/// A recording that could not be turned into something else.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Pictures are drawn of HEATS runs and FLAP searches.
    #[error("no still picture of a {system:?} run: only of heats and flap")]
    NoStill {
        /// What was recorded.
        system: String,
    },
}

/// Plays `record.jsonl` of `folder` to a recorder, and ends it.
///
/// # Errors
/// [`ReportError`]; nothing is written if the recording cannot be read.
pub fn replay(folder: &Path, recorder: &mut dyn Recorder) -> Result<(), ReportError> {
    read(&folder.join(RECORD_FILE), &mut |entry| {
        recorder.record(entry.0, &entry.1);
    })?;
    Ok(recorder.finish()?)
}

/// Makes `report.html` and `trace.mcap` of the recording in `folder`, the report with the figures of `result.json` if it is there.
/// Returns the files written.
///
/// # Errors
/// [`ReportError`].
pub fn rebuild(folder: &Path) -> Result<Vec<PathBuf>, ReportError> {
    let result = std::fs::read(folder.join("result.json"));
    let result = result.ok().and_then(|t| serde_json::from_slice(&t).ok());
    let mut made = Both(Html::new(folder, result), RosTrace::new(folder));
    replay(folder, &mut made)?;
    Ok([REPORT_FILE, TRACE_FILE]
        .map(|name| folder.join(name))
        .to_vec())
}
