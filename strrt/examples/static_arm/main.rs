//! Static problems of a folder, `mbm_ur5_*.json` (MotionBenchMaker as repacked by VAMP), with `ur5-mbm-robot.json` beside
//! them: an arm that stands still has all the time it wants.
//!
//! `cargo run --release -p strrt --example static_arm -- DIR [--json] [--seconds 0.1] [--seeds 1] [--only NAME]`
//!
//! Problems whose ends are not free are skipped and counted. Times are this thread's CPU time; lengths are compared with
//! those of VAMP's RRT-Connect and simplification, `vamp_cost`. Paths are looked at again every 5 mrad.
#![allow(
    missing_docs,
    clippy::print_stdout,
    clippy::print_stderr,
    clippy::disallowed_methods
)]

mod arm;

use arm::{Arm, Scene, Solid};
use serde_json::{Value, json};
use std::error::Error;
use std::path::PathBuf;
use strrt::{Params, Planner, Variant};

/// Time steps, s: at 1 rad/s the joints' largest motion in one, rad.
const STEP: f64 = 0.5;

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

fn joints(v: &Value) -> Option<[f64; 6]> {
    let list: Vec<f64> = v.as_array()?.iter().filter_map(Value::as_f64).collect();
    list.try_into().ok()
}

/// States along the path, 5 mrad apart, that touch something.
fn violations(scene: &Scene<'_>, path: &[[f64; 6]]) -> usize {
    let mut bad = 0;
    for w in path.windows(2) {
        let far = (0..6)
            .map(|j| (w[1][j] - w[0][j]).abs())
            .fold(0.0, f64::max);
        let n = (far / 0.005).ceil().max(1.0);
        for i in 0..=n as usize {
            let f = i as f64 / n;
            let q = std::array::from_fn(|j| w[0][j] + f * (w[1][j] - w[0][j]));
            // What a motion check may leave undetected: half its resolution.
            bad += usize::from(scene.clearance(&q) < -2e-3);
        }
        bad += usize::from(far > STEP + 1e-9);
    }
    bad
}

fn run(
    scene: &Scene<'_>,
    problem: &Value,
    seed: u64,
    seconds: f64,
) -> Result<Value, Box<dyn Error>> {
    // The files' joint values are rounded and may lie a little outside the limits.
    let inside = |q: [f64; 6]| -> [f64; 6] {
        std::array::from_fn(|j| {
            let (low, high) = scene.arm.limits[j];
            if q[j] < low && q[j] > low - 1e-5 {
                low
            } else if q[j] > high && q[j] < high + 1e-5 {
                high
            } else {
                q[j]
            }
        })
    };
    let start = inside(joints(&problem["start"]).ok_or("no start")?);
    let goal = inside(joints(&problem["goal"]).ok_or("no goal")?);
    let begin = cpu_seconds();
    let params = Params {
        variant: Variant::Bidirectional,
        // Time is no matter here: room for long ways round.
        slack: 2.5,
        max_wait: 1000,
        ..Params::default()
    };
    let mut planner = Planner::new(scene, start, goal, 1, STEP, &params, seed)?;
    let (mut first, mut first_cost) = (None, None);
    loop {
        let used = cpu_seconds() - begin;
        if first.is_none() && planner.cost().is_finite() {
            (first, first_cost) = (Some(used), Some(planner.cost()));
        }
        let wanted = if first.is_none() { 4 } else { 16 };
        if used >= seconds || planner.step(wanted) < wanted {
            break;
        }
    }
    let total = cpu_seconds() - begin;
    if first.is_none() && planner.cost().is_finite() && total <= seconds {
        (first, first_cost) = (Some(total), Some(planner.cost()));
    }
    let plan = planner.plan();
    let vamp = problem["vamp_cost"].as_f64();
    let ratio = |c: Option<f64>| Some(c? / vamp?);
    let solved = first.is_some();
    Ok(json!({
        "id": problem["id"], "seed": seed, "solved": solved,
        "reason": plan.reason.map(|r| r.to_string()),
        "first_ms": first.map(|s| s * 1e3), "total_ms": total * 1e3,
        "cost": solved.then_some(plan.cost), "first_ratio": ratio(first_cost),
        "ratio": ratio(solved.then_some(plan.cost)),
        "iterations": plan.iterations, "checks": plan.checks,
        "violations": violations(scene, &plan.path),
    }))
}

fn spread(rows: &[Value], key: &str) -> Value {
    let mut values: Vec<f64> = rows.iter().filter_map(|q| q[key].as_f64()).collect();
    values.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let index = (share * values.len() as f64).ceil() as usize;
        values
            .get(index.max(1) - 1)
            .map(|v| (v * 1e4).round() / 1e4)
    };
    json!({ "median": at(0.5), "p95": at(0.95), "max": at(1.0), "of": values.len() })
}

fn summary(rows: &[Value]) -> Value {
    json!({
        "asked": rows.len(),
        "solved": rows.iter().filter(|q| q["solved"] == true).count(),
        "violations": rows.iter().filter_map(|q| q["violations"].as_u64()).sum::<u64>(),
        "first_ms": spread(rows, "first_ms"), "first_ratio": spread(rows, "first_ratio"),
        "ratio": spread(rows, "ratio"),
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let (mut folder, mut only) = (PathBuf::from("."), String::new());
    let (mut verbose, mut seconds, mut seeds) = (false, 0.1, 1u64);
    let mut rest = std::env::args().skip(1);
    while let Some(word) = rest.next() {
        let mut value = || rest.next().ok_or(format!("{word} needs a value"));
        match word.as_str() {
            "--json" => verbose = true,
            "--seconds" => seconds = value()?.parse()?,
            "--seeds" => seeds = value()?.parse()?,
            "--only" => only = value()?,
            other if !other.starts_with('-') => folder = PathBuf::from(other),
            other => return Err(format!("unknown argument {other}").into()),
        }
    }
    let text = std::fs::read_to_string(folder.join("ur5-mbm-robot.json"))?;
    let arm = Arm::read(&serde_json::from_str(&text)?).ok_or("the robot's file lacks something")?;
    let mut files: Vec<PathBuf> = std::fs::read_dir(&folder)?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with("mbm_ur5_") && name.ends_with(".json") && name.contains(&only)
        })
        .collect();
    files.sort();
    let (mut all, mut skipped, mut report) = (Vec::new(), 0, json!({}));
    for file in &files {
        let data: Value = serde_json::from_str(&std::fs::read_to_string(file)?)?;
        let family = data["family"].as_str().unwrap_or("?").to_owned();
        let mut rows = Vec::new();
        for problem in data["problems"].as_array().ok_or("no problems")? {
            let solids = problem["obstacles"].as_array().ok_or("no obstacles")?;
            let solids: Option<Vec<Solid>> = solids.iter().map(Solid::read).collect();
            let scene = Scene::new(&arm, solids.ok_or("an obstacle of another type")?);
            let ends = [&problem["start"], &problem["goal"]].map(joints);
            let free = ends.iter().flatten().all(|q| scene.clearance(q) > 0.0);
            if problem["endpoints_free"] != true || !free {
                skipped += 1;
                continue;
            }
            for seed in 0..seeds {
                let mut row = run(&scene, problem, seed, seconds)?;
                row["family"] = json!(family);
                rows.push(row);
            }
        }
        report[&family] = summary(&rows);
        all.extend(rows);
    }
    report["all"] = summary(&all);
    report["skipped: an end is not free"] = json!(skipped);
    if verbose {
        report["queries"] = Value::Array(all);
    }
    println!("{report:#}");
    Ok(())
}
