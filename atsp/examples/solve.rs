//! Solves one instance file and prints the answer as JSON: `cargo run --release -p atsp --example solve -- FILE`.
//!
//! `FILE` is a TSPLIB full matrix (`.atsp`) or an exploration instance (`.json`). Options: `--ms N` stops after N
//! milliseconds of CPU time, `--kicks N`, `--seed N`, `--prove STEPS,BRANCHES`.
#![allow(clippy::print_stdout, clippy::print_stderr, missing_docs)]

mod support;

use std::path::PathBuf;
use std::time::Duration;

use atsp::{Params, Proof, Solver};
use cpu_time::ThreadTime;
use serde_json::json;

const USAGE: &str = "usage: solve FILE [--ms N] [--kicks N] [--seed N] [--prove STEPS,BRANCHES]";

fn main() -> std::process::ExitCode {
    match run() {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            std::process::ExitCode::from(2)
        }
    }
}

fn run() -> Result<(), String> {
    let mut file: Option<PathBuf> = None;
    let mut limit = None;
    let mut params = Params::default();
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut number = || {
            let text = args.next().unwrap_or_default();
            text.parse::<u64>()
                .map_err(|_| format!("{arg} needs a whole number, not {text:?}\n{USAGE}"))
        };
        match arg.as_str() {
            "--ms" => limit = Some(Duration::from_millis(number()?)),
            "--kicks" => params.kicks = number()?,
            "--seed" => params.seed = number()?,
            "--prove" => {
                let text = args.next().unwrap_or_default();
                let parsed = text
                    .split_once(',')
                    .and_then(|(s, b)| Some((s.parse().ok()?, b.parse().ok()?)));
                let (steps, branches) = parsed.ok_or(format!(
                    "--prove needs STEPS,BRANCHES, not {text:?}\n{USAGE}"
                ))?;
                params.proof = Proof::Effort { steps, branches };
            }
            _ if arg.starts_with('-') => return Err(format!("unknown option {arg}\n{USAGE}")),
            _ => file = Some(PathBuf::from(arg)),
        }
    }
    let instance = support::read(&file.ok_or(USAGE)?)?;
    if limit.is_some() {
        params.kicks = u64::MAX;
    }
    let begin = ThreadTime::now();
    let mut watch = || limit.is_some_and(|limit| begin.elapsed() >= limit);
    let found = Solver::new()
        .solve_watched(&instance.costs, instance.problem, &[], &params, &mut watch)
        .map_err(|e| format!("{}: {e}", instance.name))?;
    let cpu_ms = begin.elapsed().as_secs_f64() * 1e3;
    let above_best = instance
        .best
        .map(|best| (found.cost - best) / best.abs().max(f64::MIN_POSITIVE));
    println!(
        "{}",
        json!({
            "name": instance.name, "family": instance.family, "nodes": found.order.len(), "length": found.cost,
            "lower_bound": found.lower_bound, "gap": found.gap(), "optimal": found.optimal,
            "best_known": instance.best, "above_best_known": above_best,
            "kicks": found.kicks, "cpu_ms": cpu_ms, "order": found.order,
        })
    );
    Ok(())
}
