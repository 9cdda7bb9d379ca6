//! Whole-body problems of a folder: `whole_body*.json`, with `mm-robot.json` beside them or the one built in.
//!
//! `cargo run --release -p strrt --example whole_body -- DIR [--json] [--seconds 1.0] [--seeds 1]
//! [--variant bidirectional|multi-step|published]`
//!
//! Times are this thread's CPU time. The cost is noted after 0.1 s and at the end; plans are checked again by other code.
#![allow(
    missing_docs,
    clippy::print_stdout,
    clippy::print_stderr,
    clippy::disallowed_methods
)]

mod problem;
mod recheck;
mod robot;

use problem::Problem;
use robot::{Model, Scene};
use serde_json::{Value, json};
use std::error::Error;
use std::path::{Path, PathBuf};
use strrt::{Params, Planner, Status, Variant};

fn main() -> Result<(), Box<dyn Error>> {
    let settings = Settings::from_arguments()?;
    let table = settings.folder.join("mm-robot.json");
    let text = std::fs::read_to_string(&table)
        .unwrap_or_else(|_| include_str!("mm-robot.json").to_string());
    let model = Model::read(&serde_json::from_str(&text)?)
        .ok_or("the robot's file lacks a table or has a wrong one")?;
    let mut queries = Vec::new();
    for file in files(&settings.folder)? {
        let list: Value = serde_json::from_str(&std::fs::read_to_string(&file)?)?;
        for entry in list.as_array().ok_or("a problem file must be a list")? {
            let problem = Problem::read(entry).ok_or("a problem lacks a field")?;
            for seed in 0..settings.seeds {
                let query = run(&model, &problem, seed, &settings);
                if !settings.json {
                    println!("{query}");
                }
                queries.push(query);
            }
        }
    }
    let summary = summary(&queries);
    if settings.json {
        println!("{}", json!({ "queries": queries, "summary": summary }));
    } else {
        println!("{summary:#}");
    }
    Ok(())
}

struct Settings {
    folder: PathBuf,
    json: bool,
    seconds: f64,
    seeds: u64,
    variant: Variant,
}

impl Settings {
    fn from_arguments() -> Result<Self, Box<dyn Error>> {
        let mut settings = Self {
            folder: PathBuf::from("."),
            json: false,
            seconds: 1.0,
            seeds: 1,
            variant: Variant::default(),
        };
        let mut rest = std::env::args().skip(1);
        while let Some(word) = rest.next() {
            let mut value = || rest.next().ok_or(format!("{word} needs a value"));
            match word.as_str() {
                "--json" => settings.json = true,
                "--seconds" => settings.seconds = value()?.parse()?,
                "--seeds" => settings.seeds = value()?.parse()?,
                "--variant" => {
                    settings.variant = match value()?.as_str() {
                        "published" => Variant::Published,
                        "multi-step" => Variant::MultiStep,
                        "bidirectional" => Variant::Bidirectional,
                        other => return Err(format!("no variant is called {other}").into()),
                    }
                }
                other if !other.starts_with('-') => settings.folder = PathBuf::from(other),
                other => return Err(format!("unknown argument {other}").into()),
            }
        }
        Ok(settings)
    }
}

fn files(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut found: Vec<PathBuf> = std::fs::read_dir(folder)?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with("whole_body") && name.ends_with(".json")
        })
        .collect();
    found.sort();
    if found.is_empty() {
        return Err(format!("{} has no whole_body*.json", folder.display()).into());
    }
    Ok(found)
}

/// CPU time of this thread, s. Giving way first makes the kernel bring its account up to date.
fn cpu_seconds() -> f64 {
    std::thread::yield_now();
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanos = text.split(' ').next().and_then(|n| n.parse::<f64>().ok());
    nanos.map_or_else(wall_seconds, |n| n * 1e-9)
}

/// Where there is no such account.
fn wall_seconds() -> f64 {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    now.map_or(0.0, |d| d.as_secs_f64())
}

fn run(model: &Model, problem: &Problem, seed: u64, settings: &Settings) -> Value {
    let begin = cpu_seconds();
    let scene = Scene::new(model, &problem.base, &problem.boxes);
    // The base's path is given to the end: no waiting beyond it.
    let params = Params {
        variant: settings.variant,
        max_wait: 0,
        ..Params::default()
    };
    let (start, goal, steps) = (problem.start, problem.goal, problem.base.len());
    let mut planner = match Planner::new(&scene, start, goal, steps, problem.dt, &params, seed) {
        Ok(planner) => planner,
        Err(error) => {
            return json!({ "id": problem.id, "solved": false, "error": error.to_string() });
        }
    };
    let (mut first, mut first_cost, mut early) = (None, None, None);
    let mut used = cpu_seconds() - begin;
    loop {
        if first.is_none() && planner.cost().is_finite() {
            (first, first_cost) = (Some(used), Some(planner.cost()));
        }
        if used <= 0.1 && planner.cost().is_finite() {
            early = Some(planner.cost());
        }
        if used >= settings.seconds {
            break;
        }
        let wanted = if first.is_none() { 4 } else { 16 };
        let done = planner.step(wanted);
        used = cpu_seconds() - begin;
        if done < wanted {
            if used <= 0.1 && planner.cost().is_finite() {
                early = Some(planner.cost());
            }
            break;
        }
    }
    let plan = planner.plan();
    let solved = plan.status == Status::Solved;
    let violations = solved.then(|| recheck::violations(model, problem, &plan.path));
    let ratio = |cost: Option<f64>| Some(cost? / problem.reference?);
    let cost = solved.then_some(plan.cost);
    let rounded = |value: Option<f64>| value.map(|v| (v * 1e5).round() / 1e5);
    json!({
        "id": problem.id, "class": problem.class, "seed": seed, "solved": solved,
        "reason": plan.reason.map(|r| r.to_string()),
        "first_ms": rounded(first.map(|s| s * 1e3)), "total_ms": rounded(Some(used * 1e3)),
        "seconds": (steps - 1) as f64 * problem.dt,
        "cost": rounded(cost), "first_ratio": rounded(ratio(first_cost)),
        "ratio_at_0.1s": rounded(ratio(early)), "ratio": rounded(ratio(cost)),
        "iterations": plan.iterations, "checks": plan.checks, "violations": violations,
    })
}

/// Medians, 95th percentiles and worst values of what was measured.
fn summary(queries: &[Value]) -> Value {
    let spread = |key: &str| {
        let mut values: Vec<f64> = queries.iter().filter_map(|q| q[key].as_f64()).collect();
        values.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let index = (share * values.len() as f64).ceil() as usize;
            values.get(index.max(1) - 1).copied()
        };
        json!({ "median": at(0.5), "p95": at(0.95), "max": at(1.0), "of": values.len() })
    };
    let count = |test: &dyn Fn(&Value) -> bool| queries.iter().filter(|q| test(q)).count();
    json!({
        "queries": queries.len(),
        "solved": count(&|q| q["solved"] == true),
        "solved_in_0.2s": count(&|q| q["first_ms"].as_f64().is_some_and(|ms| ms <= 200.0)),
        "violations": queries.iter().filter_map(|q| q["violations"].as_u64()).sum::<u64>(),
        "first_ms": spread("first_ms"), "total_ms": spread("total_ms"),
        "first_ratio": spread("first_ratio"), "ratio_at_0.1s": spread("ratio_at_0.1s"),
        "ratio": spread("ratio"),
    })
}
