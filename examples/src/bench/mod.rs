//! Campaigns: a suite is expanded to trials, each trial leaves its own result file, and the files make the tables.
//!
//! A trial's file is written under a temporary name and renamed, so that a campaign can be stopped at any time and taken up
//! again with `--resume`, run by several jobs, and split among machines with `--shard`. With `--reports` it leaves a page beside its
//! result in which the run can be watched. A new suite implements [`Suite`].

mod campaign;
mod chart;
mod curves;
mod flap;
mod heats;
mod page;
mod suite_file;
mod trial_file;

pub use campaign::{
    BenchError, Campaign, Flaw, Kept, Left, Order, Report, Suite, Trial, collect, parse_shard, run,
};
pub use flap::Figure6;
pub use heats::HeatsTables;
pub use suite_file::{Seeds, SuiteError, SuiteFile};
pub use trial_file::{Machine, TRIAL_SCHEMA, TrialFile, scene_hash};

use crate::record::Html;

/// The suite of a name, or of a TOML file; `trials`: seeds of each experiment if not the suite's own number.
///
/// # Errors
/// [`BenchError::NoSuite`] for an unknown name, [`BenchError::Suite`] naming the field that is wrong.
pub fn suite(name: &str, trials: Option<usize>) -> Result<Box<dyn Suite>, BenchError> {
    match name {
        "flap-figure6" if trials == Some(0) => Err(SuiteError::Empty {
            field: "--trials",
            what: "seed",
        }
        .into()),
        "flap-figure6" => Ok(Box::new(Figure6::new(trials.unwrap_or(20)))),
        "heats-tables" => Ok(Box::new(HeatsTables::embedded(trials)?)),
        file if file.ends_with(".toml") => {
            let text = std::fs::read_to_string(file).map_err(|e| SuiteError::Read {
                path: file.to_owned(),
                message: e.to_string(),
            })?;
            Ok(Box::new(HeatsTables::new(
                &SuiteFile::from_toml(&text)?,
                trials,
            )?))
        }
        _ => Err(BenchError::NoSuite(name.to_owned())),
    }
}

/// What a trial leaves: its result (`file`), and the page of what was recorded with the figures of the run's `result`.
fn left(
    file: &impl serde::Serialize,
    result: &impl serde::Serialize,
    recorded: Option<Html>,
) -> Result<Left, serde_json::Error> {
    let report = match recorded {
        None => None,
        Some(mut html) => {
            html.set_result(serde_json::to_value(result)?);
            html.page()
        }
    };
    Ok(Left {
        result: serde_json::to_string_pretty(file)? + "\n",
        report,
    })
}

/// Mean and sample standard deviation.
fn spread(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let values: Vec<f64> = values.collect();
    let n = values.len() as f64;
    if values.is_empty() {
        return (0.0, 0.0);
    }
    let mean = values.iter().sum::<f64>() / n;
    let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (mean, (square / (n - 1.0).max(1.0)).sqrt())
}
