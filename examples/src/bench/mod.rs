//! Campaigns: a suite is expanded to trials, each trial leaves its own result file, and the files make the tables.
//!
//! A trial's file is written under a temporary name and renamed, so that a campaign can be stopped at any time and taken up
//! again with `--resume`, run by several jobs, and split among machines with `--shard`. A new suite implements [`Suite`].

mod campaign;
mod chart;
mod flap;
mod page;

pub use campaign::{BenchError, Campaign, Report, Suite, Trial, parse_shard, run};
pub use flap::Figure6;

/// The suite of a name; `trials`: seeds of each experiment if not the suite's own number.
///
/// # Errors
/// [`BenchError::NoSuite`] for an unknown name.
pub fn suite(name: &str, trials: Option<usize>) -> Result<Box<dyn Suite>, BenchError> {
    match name {
        "flap-figure6" => Ok(Box::new(Figure6::new(trials.unwrap_or(20)))),
        _ => Err(BenchError::NoSuite(name.to_owned())),
    }
}
