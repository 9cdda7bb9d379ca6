//! `record.jsonl`: one event a line, append-only, from which every other recording is made.

use super::WriteError;
use super::event::{Entry, Event};
use super::recorder::Recorder;
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Name of the file in a run's folder.
pub const RECORD_FILE: &str = "record.jsonl";

/// Simulated time after which lines are handed to the system, s: what a killed run may lose.
const FLUSH: f64 = 1.0;

/// Writes events as lines of JSON. Holds a buffer and nothing else.
#[derive(Debug)]
pub struct JsonLines {
    path: PathBuf,
    /// Made for the first event, so that a run that cannot begin leaves an older recording alone.
    file: Option<BufWriter<File>>,
    flushed: f64,
    /// The first failure; nothing is written after it.
    failure: Option<std::io::Error>,
}

impl JsonLines {
    /// A recording in `record.jsonl` of `folder`. The first event makes the folder if need be, and replaces an older recording
    /// and what was made of it.
    pub fn new(folder: &Path) -> Self {
        Self {
            path: folder.join(RECORD_FILE),
            file: None,
            flushed: 0.0,
            failure: None,
        }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn open(path: &Path) -> std::io::Result<BufWriter<File>> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
            for made in [super::REPORT_FILE, super::TRACE_FILE] {
                match std::fs::remove_file(folder.join(made)) {
                    Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(e),
                    _ => {}
                }
            }
        }
        Ok(BufWriter::with_capacity(1 << 16, File::create(path)?))
    }

    fn write(&mut self, time: f64, event: &Event) -> std::io::Result<()> {
        let file = match &mut self.file {
            Some(file) => file,
            None => self.file.insert(Self::open(&self.path)?),
        };
        serde_json::to_writer(&mut *file, &(time, event))?;
        file.write_all(b"\n")?;
        if time - self.flushed >= FLUSH || matches!(event, Event::Begin(_) | Event::End(_)) {
            self.flushed = time;
            file.flush()?;
        }
        Ok(())
    }
}

impl Recorder for JsonLines {
    fn record(&mut self, time: f64, event: &Event) {
        if self.failure.is_none() {
            self.failure = self.write(time, event).err();
        }
    }

    fn finish(&mut self) -> Result<(), WriteError> {
        let outcome = match self.failure.take() {
            Some(failure) => Err(failure),
            None => self.file.as_mut().map_or(Ok(()), Write::flush),
        };
        outcome.map_err(|source| WriteError {
            path: self.path.clone(),
            source,
        })
    }
}

/// A recording that cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("cannot read {path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A line is no event of this version.
    #[error("{path}, line {line}: {source}")]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        source: serde_json::Error,
    },
    /// The recording does not begin with what is run.
    #[error("{path} does not begin with a {expected} line", expected = super::event::RECORD_SCHEMA)]
    Begin {
        /// The file.
        path: PathBuf,
    },
}

/// Reads a recording and hands every event to `take`. The last line of a killed run may be cut off; it is left out.
///
/// # Errors
/// [`ReadError`]; a line that is wrong anywhere but at the end of the file is one.
pub fn read(path: &Path, take: &mut dyn FnMut(Entry)) -> Result<(), ReadError> {
    let failed = |source| ReadError::File {
        path: path.to_owned(),
        source,
    };
    let mut file = BufReader::new(File::open(path).map_err(failed)?);
    let mut text = Vec::new();
    let (mut line, mut begun) = (0, false);
    loop {
        text.clear();
        if file.read_until(b'\n', &mut text).map_err(failed)? == 0 {
            break;
        }
        line += 1;
        let entry: Entry = match serde_json::from_slice(&text) {
            Ok(entry) => entry,
            Err(_) if text.last() != Some(&b'\n') => break,
            Err(source) => {
                return Err(ReadError::Line {
                    path: path.to_owned(),
                    line,
                    source,
                });
            }
        };
        let begins = matches!(&entry.1, Event::Begin(b) if b.schema == super::event::RECORD_SCHEMA);
        if (line == 1) != begins {
            return Err(ReadError::Begin {
                path: path.to_owned(),
            });
        }
        begun = true;
        take(entry);
    }
    if !begun {
        return Err(ReadError::Begin {
            path: path.to_owned(),
        });
    }
    Ok(())
}
