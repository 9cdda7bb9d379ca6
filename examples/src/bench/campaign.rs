//! Running the trials of a suite.

use crate::record::{WriteError, write_file};
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// What can go wrong.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BenchError {
    /// No suite has this name.
    #[error("no suite is called {0:?}; there is flap-figure6")]
    NoSuite(String),
    /// Not I/N.
    #[error("shard {0:?} is not I/N with 1 <= I <= N")]
    Shard(String),
    /// A trial failed.
    #[error("trial {trial}: {message}")]
    Trial {
        /// Name of the trial.
        trial: String,
        /// What went wrong.
        message: String,
    },
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A result could not be read.
    #[error("cannot read {path}: {message}")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        message: String,
    },
}

/// One run of a suite.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trial {
    /// Its name, unique in the suite, fit for a file name.
    pub name: String,
    /// Trials of one group stand together and run one after another in the same job, so that they can share work.
    pub group: usize,
}

/// A set of trials and what is made of their results.
pub trait Suite: Sync {
    /// All trials, in the order of their groups.
    fn trials(&self) -> Vec<Trial>;
    /// Runs the trials of one group in turn; hands over each result as JSON text with its trial's index. It may leave out the
    /// trials for which `wanted` is false, and ends early when `deliver` says so.
    ///
    /// # Errors
    /// What went wrong, in words.
    fn run_group(
        &self,
        group: usize,
        wanted: &dyn Fn(usize) -> bool,
        deliver: &mut dyn FnMut(usize, String) -> bool,
    ) -> Result<(), String>;
    /// Tables and pictures from all results (in the order of the trials): the text to print, then files as name and content.
    ///
    /// # Errors
    /// What is wrong with the results.
    fn report(&self, results: &[String]) -> Result<(String, Vec<(String, String)>), String>;
}

/// How to run a suite.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Campaign {
    /// Groups of trials at the same time.
    pub jobs: usize,
    /// Part and number of parts, counted from 0.
    pub shard: (usize, usize),
    /// Keep results that are there.
    pub resume: bool,
    /// Folder of the results.
    pub out: PathBuf,
}

/// What a campaign gave.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// Text to print.
    pub table: String,
    /// Files written besides the trials' results.
    pub files: Vec<PathBuf>,
    /// Whether it was stopped.
    pub interrupted: bool,
}

/// Reads `I/N`; absent means all.
///
/// # Errors
/// [`BenchError::Shard`].
pub fn parse_shard(text: Option<&str>) -> Result<(usize, usize), BenchError> {
    let Some(text) = text else {
        return Ok((0, 1));
    };
    let wrong = || BenchError::Shard(text.to_owned());
    let (part, parts) = text.split_once('/').ok_or_else(wrong)?;
    let part: usize = part.trim().parse().map_err(|_| wrong())?;
    let parts: usize = parts.trim().parse().map_err(|_| wrong())?;
    if (1..=parts).contains(&part) {
        Ok((part - 1, parts))
    } else {
        Err(wrong())
    }
}

/// Runs what is missing of a suite's shard and reports once every trial of the suite has a result.
///
/// # Errors
/// [`BenchError`]; results written so far stay.
pub fn run(
    suite: &dyn Suite,
    campaign: &Campaign,
    stop: &AtomicBool,
    say: &(dyn Fn(&str) + Sync),
) -> Result<Report, BenchError> {
    let trials = suite.trials();
    let folder = campaign.out.join("trials");
    let file = |trial: usize| format!("{}.json", trials[trial].name);
    let there = |trial: usize| folder.join(file(trial)).is_file();
    let (part, parts) = campaign.shard;
    // Without --resume what this shard is to run is run anew.
    let missing: Vec<bool> = (0..trials.len())
        .map(|t| trials[t].group % parts == part && !(campaign.resume && there(t)))
        .collect();
    let mut groups: Vec<usize> = (0..trials.len())
        .filter(|&t| missing[t])
        .map(|t| trials[t].group)
        .collect();
    groups.dedup();
    let todo = missing.iter().filter(|m| **m).count();
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let failed: Mutex<Option<BenchError>> = Mutex::new(None);
    let fail = |error: BenchError| {
        if let Ok(mut slot) = failed.lock() {
            slot.get_or_insert(error);
        }
    };
    let over = || stop.load(Ordering::Relaxed) || failed.lock().is_ok_and(|f| f.is_some());
    let work = || {
        while let Some(&group) = groups.get(next.fetch_add(1, Ordering::Relaxed)) {
            if over() {
                return;
            }
            let mut deliver = |trial: usize, json: String| {
                if let Err(error) = write_file(&folder, &file(trial), &json) {
                    fail(error.into());
                    return false;
                }
                let count = done.fetch_add(1, Ordering::Relaxed) + 1;
                say(&format!("[{count}/{todo}] {}", trials[trial].name));
                !over()
            };
            if let Err(message) = suite.run_group(group, &|t| missing[t], &mut deliver) {
                let trial = format!("of group {group}");
                fail(BenchError::Trial { trial, message });
                return;
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..campaign.jobs.clamp(1, 64) {
            scope.spawn(work);
        }
        work();
    });
    if let Some(error) = failed.into_inner().ok().flatten() {
        return Err(error);
    }
    let interrupted = stop.load(Ordering::Relaxed);
    let absent = (0..trials.len()).filter(|&t| !there(t)).count();
    if absent > 0 {
        return Ok(Report {
            table: format!("{absent} of {} trials have no result yet\n", trials.len()),
            files: Vec::new(),
            interrupted,
        });
    }
    let results = (0..trials.len())
        .map(|t| {
            let path = folder.join(file(t));
            std::fs::read_to_string(&path).map_err(|e| BenchError::Read {
                path,
                message: e.to_string(),
            })
        })
        .collect::<Result<Vec<_>, _>>()?;
    let (table, contents) = suite.report(&results).map_err(|message| BenchError::Read {
        path: folder,
        message,
    })?;
    let files = contents
        .into_iter()
        .map(|(name, text)| write_file(&campaign.out, &name, &text))
        .collect::<Result<_, _>>()?;
    Ok(Report {
        table,
        files,
        interrupted,
    })
}
