//! The progress line of a running search.
#![allow(clippy::print_stderr)]

use std::io::{IsTerminal, Write};

/// What a running search tells.
#[derive(Clone, Debug, PartialEq)]
pub struct Status<'a> {
    /// Simulated time, s.
    pub time: f64,
    /// Tags found.
    pub found: usize,
    /// Tags in the scene.
    pub targets: usize,
    /// Share of the reachable free space that is known, 0..1.
    pub explored: f64,
    /// Share of the observable surface that was inspected, 0..1.
    pub inspected: f64,
    /// What the robot is doing.
    pub activity: &'a str,
}

/// One line that is rewritten on a terminal; plain lines every ten simulated seconds elsewhere.
#[derive(Debug)]
pub struct ProgressLine {
    quiet: bool,
    terminal: bool,
    next_plain: f64,
}

impl ProgressLine {
    /// A line on standard error; silent if `quiet`.
    pub fn new(quiet: bool) -> Self {
        Self {
            quiet,
            terminal: std::io::stderr().is_terminal(),
            next_plain: 0.0,
        }
    }

    /// Shows the status.
    pub fn show(&mut self, status: &Status<'_>) {
        if self.quiet || (!self.terminal && status.time + 1e-9 < self.next_plain) {
            return;
        }
        let text = format!(
            "{:6.1} s  tags {}/{}  explored {:5.1} %  inspected {:5.1} %  {}",
            status.time,
            status.found,
            status.targets,
            100.0 * status.explored,
            100.0 * status.inspected,
            status.activity
        );
        if self.terminal {
            eprint!("\r\x1b[2K{text}");
            // A progress line that cannot be shown is no reason to stop the run.
            let _ = std::io::stderr().flush();
        } else {
            self.next_plain = status.time + 10.0;
            eprintln!("{text}");
        }
    }

    /// Ends the line.
    pub fn finish(&mut self) {
        if !self.quiet && self.terminal {
            eprintln!();
        }
    }
}
