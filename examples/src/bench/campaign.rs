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
    #[error("no suite is called {0:?}; there are heats-tables, flap-figure6, and any FILE.toml")]
    NoSuite(String),
    /// A suite is wrong.
    #[error(transparent)]
    Suite(#[from] super::suite_file::SuiteError),
    /// Trials have no result.
    #[error("{} of {of} trials have no result: {}", missing.len(), missing.join(", "))]
    Missing {
        /// Their names.
        missing: Vec<String>,
        /// Number of all.
        of: usize,
    },
    /// A result is broken, or of another version or other settings than this suite.
    #[error("{path}: {flaw}")]
    Unfit {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        flaw: Flaw,
    },
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

/// Why a result that is there is none of this suite's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Flaw {
    /// Not whole, or no result at all: the trial is to be repeated.
    #[error("broken result: {0}")]
    Broken(String),
    /// Whole, but of something else: it must not be mixed with this suite's, nor be overwritten unasked.
    #[error(
        "result of another version or other settings ({0}); choose another --out, or run without --resume to replace it"
    )]
    Other(String),
}

/// One run of a suite.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trial {
    /// Its name, unique in the suite, fit for a file name.
    pub name: String,
    /// Trials of one group stand together and run one after another in the same job, so that they can share work.
    pub group: usize,
}

/// How the trials of a group are to be run.
#[derive(Clone, Copy)]
pub struct Order<'a> {
    /// Ends the run when it turns true.
    pub stop: &'a AtomicBool,
    /// Whether a trial, by its index, is to be run.
    pub wanted: &'a dyn Fn(usize) -> bool,
    /// Whether each trial is to leave a report, if the suite can make one.
    pub reports: bool,
}

/// What a trial leaves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Left {
    /// Its result, JSON.
    pub result: String,
    /// A page that shows how it went, HTML.
    pub report: Option<String>,
}

/// The result of a trial as it lies in the campaign's folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Kept {
    /// The result, JSON.
    pub result: String,
    /// Its file, from the campaign's folder.
    pub file: String,
    /// The trial's report, from the campaign's folder, if there is one.
    pub report: Option<String>,
}

/// A set of trials and what is made of their results.
pub trait Suite: Sync {
    /// All trials, in the order of their groups.
    fn trials(&self) -> Vec<Trial>;
    /// Runs the trials of one group in turn; hands over what each leaves with its trial's index. It may leave out the trials
    /// that are not `wanted`, ends early when `deliver` says so, and delivers no trial that `stop` cut short.
    ///
    /// # Errors
    /// What went wrong, in words.
    fn run_group(
        &self,
        group: usize,
        order: Order<'_>,
        deliver: &mut dyn FnMut(usize, Left) -> bool,
    ) -> Result<(), String>;
    /// Whether a file's text is the result of a trial.
    ///
    /// # Errors
    /// What is wrong with it.
    fn check(&self, _trial: usize, json: &str) -> Result<(), Flaw> {
        let value: Result<serde_json::Value, _> = serde_json::from_str(json);
        value.map(|_| ()).map_err(|e| Flaw::Broken(e.to_string()))
    }
    /// Tables and pictures from all results (in the order of the trials): the text to print, then files as name and content.
    ///
    /// # Errors
    /// What is wrong with the results.
    fn report(&self, results: &[Kept]) -> Result<(String, Vec<(String, String)>), String>;
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
    /// Leave a report of each trial beside its result, and run trials anew that have none.
    pub reports: bool,
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

/// Subfolder of the trials' files.
const TRIALS: &str = "trials";

/// The results of a suite in a folder.
struct Results<'a> {
    suite: &'a dyn Suite,
    trials: Vec<Trial>,
    folder: PathBuf,
}

impl<'a> Results<'a> {
    fn new(suite: &'a dyn Suite, out: &std::path::Path) -> Self {
        Self {
            suite,
            trials: suite.trials(),
            folder: out.join(TRIALS),
        }
    }

    fn file(&self, trial: usize) -> String {
        format!("{}.json", self.trials[trial].name)
    }

    fn report(&self, trial: usize) -> String {
        format!("{}.html", self.trials[trial].name)
    }

    fn has_report(&self, trial: usize) -> bool {
        self.folder.join(self.report(trial)).is_file()
    }

    /// Writes what a trial left. The result comes last: a trial that has one is finished. A report of an older result goes.
    fn keep(&self, trial: usize, left: &Left) -> Result<(), WriteError> {
        let name = self.report(trial);
        if let Some(report) = &left.report {
            write_file(&self.folder, &name, report)?;
        } else {
            let path = self.folder.join(&name);
            match std::fs::remove_file(&path) {
                Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
                    return Err(WriteError { path, source });
                }
                _ => {}
            }
        }
        write_file(&self.folder, &self.file(trial), &left.result).map(|_| ())
    }

    /// Text of a trial's result, or what is wrong with it; none if there is none.
    fn read(&self, trial: usize) -> Option<Result<String, Flaw>> {
        let bytes = match std::fs::read(self.folder.join(self.file(trial))) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return None,
            Err(e) => return Some(Err(Flaw::Broken(e.to_string()))),
        };
        let text = String::from_utf8(bytes).map_err(|e| Flaw::Broken(e.to_string()));
        Some(text.and_then(|text| self.suite.check(trial, &text).map(|()| text)))
    }

    fn unfit(&self, trial: usize, flaw: Flaw) -> BenchError {
        BenchError::Unfit {
            path: self.folder.join(self.file(trial)),
            flaw,
        }
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
    let results = Results::new(suite, &campaign.out);
    let trials = &results.trials;
    let (part, parts) = campaign.shard;
    // Without --resume what this shard is to run is run anew.
    let mut missing = vec![false; trials.len()];
    for t in (0..trials.len()).filter(|&t| trials[t].group % parts == part) {
        missing[t] = match campaign.resume.then(|| results.read(t)).flatten() {
            None => true,
            Some(Ok(_)) => campaign.reports && !results.has_report(t),
            Some(Err(flaw @ Flaw::Broken(_))) => {
                say(&format!(
                    "{}: {flaw}; the trial is repeated",
                    trials[t].name
                ));
                true
            }
            Some(Err(flaw)) => return Err(results.unfit(t, flaw)),
        };
    }
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
            let mut deliver = |trial: usize, left: Left| {
                if let Err(error) = results.keep(trial, &left) {
                    fail(error.into());
                    return false;
                }
                let count = done.fetch_add(1, Ordering::Relaxed) + 1;
                say(&format!("[{count}/{todo}] {}", trials[trial].name));
                !over()
            };
            let order = Order {
                stop,
                wanted: &|t| missing[t],
                reports: campaign.reports,
            };
            let ran = suite.run_group(group, order, &mut deliver);
            if let Err(message) = ran {
                let own = trials.iter().zip(&missing);
                let names: Vec<&str> = own
                    .filter(|(t, missing)| t.group == group && **missing)
                    .map(|(t, _)| t.name.as_str())
                    .collect();
                let trial = names.join(", ");
                fail(BenchError::Trial { trial, message });
                return;
            }
        }
    };
    let jobs = campaign.jobs.clamp(1, 64);
    // Jobs share the cores instead of each taking all of them.
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let alone = || match rayon::ThreadPoolBuilder::new()
        .num_threads((cores / jobs).max(1))
        .build()
    {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    };
    std::thread::scope(|scope| {
        for _ in 1..jobs {
            scope.spawn(alone);
        }
        if jobs > 1 { alone() } else { work() }
    });
    if let Some(error) = failed.into_inner().ok().flatten() {
        return Err(error);
    }
    let interrupted = stop.load(Ordering::Relaxed);
    match collect(suite, &campaign.out) {
        Ok(report) => Ok(Report {
            interrupted,
            ..report
        }),
        Err(BenchError::Missing { missing, of }) => Ok(Report {
            table: format!("{} of {of} trials have no result yet\n", missing.len()),
            files: Vec::new(),
            interrupted,
        }),
        Err(error) => Err(error),
    }
}

/// Makes the tables of the results that are there.
///
/// # Errors
/// [`BenchError::Missing`] names the trials without a result, [`BenchError::Unfit`] a result that is broken or of another version or
/// other settings.
pub fn collect(suite: &dyn Suite, out: &std::path::Path) -> Result<Report, BenchError> {
    let results = Results::new(suite, out);
    let (mut kept, mut missing) = (Vec::new(), Vec::new());
    for (t, trial) in results.trials.iter().enumerate() {
        match results.read(t) {
            None => missing.push(trial.name.clone()),
            Some(Ok(result)) => kept.push(Kept {
                result,
                file: format!("{TRIALS}/{}", results.file(t)),
                report: results
                    .has_report(t)
                    .then(|| format!("{TRIALS}/{}", results.report(t))),
            }),
            Some(Err(flaw)) => return Err(results.unfit(t, flaw)),
        }
    }
    if !missing.is_empty() {
        let of = results.trials.len();
        return Err(BenchError::Missing { missing, of });
    }
    let (table, contents) = suite.report(&kept).map_err(|message| BenchError::Read {
        path: results.folder.clone(),
        message,
    })?;
    let files = contents
        .into_iter()
        .map(|(name, text)| write_file(out, &name, &text))
        .collect::<Result<_, _>>()?;
    Ok(Report {
        table,
        files,
        interrupted: false,
    })
}
