//! Runs every query of a folder of maps and reports time, length and effort against the references.
//!
//! ```text
//! cargo run --release -p hybrid-astar --example nav_maps -- DIR [--json] [--only NAME] [--set key=value] [--trace]
//! ```
//!
//! `D` is the time of one plain Dijkstra over the same map at 0.1 m, measured in the same run. All times are CPU time
//! of this thread, the least of up to three runs. Path times use the reference's model: speed limits, no
//! acceleration limit.
#![allow(
    missing_docs,
    unreachable_pub,
    clippy::print_stdout,
    clippy::print_stderr,
    clippy::disallowed_methods
)]

mod judge;
mod load;

use hybrid_astar::{Footprint, GoalYaw, Limits, Motion, Params, Plan, Planner, Status};
use serde_json::json;
use std::path::{Path, PathBuf};

struct Row {
    map: String,
    id: u64,
    class: String,
    free: bool,
    plan: Plan,
    /// Without smoothing.
    first_ms: f64,
    ms: f64,
    /// With the goal's wave at hand.
    again_ms: f64,
    d_ms: f64,
    violations: usize,
    ref_time: Option<f64>,
    ref_length: Option<f64>,
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

/// Least CPU time of three runs (fewer if they are long), ms, and the last result.
fn clock<T>(mut f: impl FnMut() -> T) -> (f64, T) {
    let mut run = || {
        let begin = cpu_seconds();
        let value = f();
        ((cpu_seconds() - begin) * 1e3, value)
    };
    let (mut best, mut last) = run();
    for _ in 0..2 {
        if best > 100.0 {
            break;
        }
        let (ms, value) = run();
        (best, last) = (best.min(ms), value);
    }
    (best, last)
}

fn run(
    path: &Path,
    set: &[(String, f64)],
    trace: bool,
    rows: &mut Vec<Row>,
) -> Result<(), Box<dyn std::error::Error>> {
    let map = load::map(&path.with_extension("yaml"))?;
    let queries = load::queries(path)?;
    let limits = Limits {
        v: queries.v,
        w: queries.w,
        a: f64::INFINITY,
        alpha: f64::INFINITY,
    };
    let mut params = Params {
        limits,
        cell_size: map.cell.max(0.1),
        // The queries' passages are as narrow as the footprint and a few centimetres.
        margin: 0.01,
        check_step: 0.02,
        // The references drive backwards at no extra price.
        reverse_factor: 1.05,
        reverse_reach: 3.0,
        ..Params::default()
    };
    for (key, value) in set {
        match key.as_str() {
            "cell_size" => params.cell_size = *value,
            "headings" => params.headings = *value as usize,
            "greed" => params.greed = *value,
            "clearance_weight" => params.clearance_weight = *value,
            "comfort" => params.comfort = *value,
            "margin" => params.margin = *value,
            "start_tolerance" => params.start_tolerance = *value,
            "reverse_factor" => params.reverse_factor = *value,
            "reverse_reach" => params.reverse_reach = *value,
            "turn_weight" => params.turn_weight = *value,
            "a" => params.limits.a = *value,
            "alpha" => params.limits.alpha = *value,
            "smooth" => params.smooth = *value != 0.0,
            "max_expansions" => params.max_expansions = *value as usize,
            _ => return Err(format!("unknown setting `{key}`").into()),
        }
    }
    let robot = Footprint::polygon(&queries.footprint);
    let inscribed = queries
        .footprint
        .iter()
        .map(|c| c[0].abs().min(c[1].abs()))
        .fold(f64::INFINITY, f64::min);
    let yardstick = judge::Yardstick::new(
        &map,
        |p| hybrid_astar::Map::clearance(&map.grid, p),
        inscribed,
    );
    for q in &queries.list {
        let cell = [0, 1].map(|k| ((q.goal[k] - map.low[k]) / 0.1) as usize);
        let (d_ms, _) = clock(|| yardstick.run(cell));
        for free in [false, true] {
            let yaw = if free {
                GoalYaw::Free
            } else {
                GoalYaw::Fixed(q.goal[2])
            };
            let goal = [q.goal[0], q.goal[1]];
            let mut planner = Planner::new(params.clone())?;
            let rough = Params {
                smooth: false,
                ..params.clone()
            };
            let mut first = Planner::new(rough)?;
            let (first_ms, _) = clock(|| {
                first.clear();
                first.plan(&map.grid, &robot, q.start, goal, &yaw)
            });
            let (ms, plan) = clock(|| {
                planner.clear();
                planner.plan(&map.grid, &robot, q.start, goal, &yaw)
            });
            let (again_ms, _) = clock(|| planner.plan(&map.grid, &robot, q.start, goal, &yaw));
            let plan = plan?;
            if trace {
                eprintln!(
                    "{} {} {} {} {:?} ms {ms:.2} D {d_ms:.2} again {again_ms:.2} exp {} t/ref {:.3} len {:.2} segs {}",
                    map.name,
                    q.id,
                    q.class,
                    free,
                    plan.status,
                    plan.expansions,
                    plan.seconds / q.ref_time[usize::from(free)].unwrap_or(f64::NAN),
                    plan.length,
                    plan.segments.len()
                );
            }
            rows.push(Row {
                map: map.name.clone(),
                id: q.id,
                class: q.class.clone(),
                free,
                first_ms,
                ms,
                again_ms,
                d_ms,
                violations: judge::violations(&map, &queries.footprint, &plan.poses()),
                ref_time: q.ref_time[usize::from(free)],
                ref_length: q.ref_length[usize::from(free)],
                plan,
            });
        }
    }
    Ok(())
}

/// Changes between forward and reverse, with or without a turn between.
fn cusps(plan: &Plan) -> usize {
    let drives: Vec<Motion> = plan
        .segments
        .iter()
        .map(|s| s.motion)
        .filter(|m| *m != Motion::Turn)
        .collect();
    drives.windows(2).filter(|w| w[0] != w[1]).count()
}

fn quantiles(mut list: Vec<f64>) -> serde_json::Value {
    list.sort_by(f64::total_cmp);
    let at = |q: f64| {
        list.get(((list.len() as f64 - 1.0) * q).round() as usize)
            .map(|v| (v * 1e4).round() / 1e4)
    };
    json!({ "count": list.len(), "median": at(0.5), "p95": at(0.95), "p99": at(0.99), "max": at(1.0) })
}

fn summary(rows: &[&Row]) -> serde_json::Value {
    let feasible: Vec<&&Row> = rows.iter().filter(|r| r.class != "infeasible").collect();
    let solved: Vec<&&Row> = feasible
        .iter()
        .filter(|r| r.plan.status == Status::Solved)
        .copied()
        .collect();
    let all = |f: &dyn Fn(&Row) -> Option<f64>, list: &[&&Row]| {
        quantiles(list.iter().filter_map(|r| f(r)).collect())
    };
    let infeasible: Vec<&&Row> = rows.iter().filter(|r| r.class == "infeasible").collect();
    json!({
        "feasible": feasible.len(),
        "solved": solved.len(),
        "violations": rows.iter().map(|r| r.violations).sum::<usize>(),
        "first_ms": all(&|r| Some(r.first_ms), &feasible),
        "total_ms": all(&|r| Some(r.ms), &feasible),
        "ms_per_D": all(&|r| Some(r.ms / r.d_ms), &feasible),
        "cached_per_D": all(&|r| Some(r.again_ms / r.d_ms), &feasible),
        "time_per_ref": all(&|r| r.ref_time.map(|t| r.plan.seconds / t), &solved),
        "length_per_ref": all(&|r| r.ref_length.map(|t| r.plan.length / t), &solved),
        "stops": all(&|r| Some(r.plan.segments.len().saturating_sub(1) as f64), &solved),
        "expansions": all(&|r| Some(r.plan.expansions as f64), &feasible),
        "infeasible": infeasible.len(),
        "refused": infeasible.iter().filter(|r| r.plan.status != Status::Solved).count(),
        "refused_per_D": all(&|r| Some(r.ms / r.d_ms), &infeasible),
        "cusps": all(&|r| Some(cusps(&r.plan) as f64), &solved),
    })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let mut folder = None;
    let (mut only, mut set) = (String::new(), Vec::new());
    let (mut verbose, mut trace) = (false, false);
    let mut i = 0;
    while i < args.len() {
        match args[i].as_str() {
            "--json" => verbose = true,
            "--trace" => trace = true,
            "--only" | "--set" => {
                let value = args
                    .get(i + 1)
                    .ok_or("a value is missing after the last option")?;
                if args[i] == "--only" {
                    only = value.clone();
                } else {
                    let (key, number) = value.split_once('=').ok_or("--set wants key=value")?;
                    set.push((key.to_owned(), number.parse::<f64>()?));
                }
                i += 1;
            }
            other => folder = Some(PathBuf::from(other)),
        }
        i += 1;
    }
    let folder =
        folder.ok_or("usage: nav_maps DIR [--json] [--only NAME] [--set key=value] [--trace]")?;
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)?
        .filter_map(|e| e.ok().map(|e| e.path()))
        .collect();
    files.retain(|p| {
        p.extension().is_some_and(|e| e == "json") && p.with_extension("yaml").exists()
    });
    files.retain(|p| p.to_string_lossy().contains(&only));
    files.sort();
    let mut rows = Vec::new();
    for path in &files {
        run(path, &set, trace, &mut rows)?;
    }
    let round = |v: f64| (v * 1e4).round() / 1e4;
    let part = |free: bool| summary(&rows.iter().filter(|r| r.free == free).collect::<Vec<_>>());
    let mut report = json!({ "fixed_yaw": part(false), "free_yaw": part(true) });
    if verbose {
        report["queries"] = rows
            .iter()
            .map(|r| {
                json!({
                    "map": r.map, "id": r.id, "class": r.class, "yaw": if r.free { "free" } else { "fixed" },
                    "status": format!("{:?}", r.plan.status), "reason": r.plan.reason.as_ref().map(ToString::to_string),
                    "solved": r.plan.is_solved(), "first_ms": round(r.first_ms), "total_ms": round(r.ms), "again_ms": round(r.again_ms), "D_ms": round(r.d_ms), "ms_per_D": round(r.ms / r.d_ms),
                    "expansions": r.plan.expansions, "length": round(r.plan.length), "seconds": round(r.plan.seconds), "cost": round(r.plan.cost),
                    "time_per_ref": r.ref_time.map(|t| round(r.plan.seconds / t)),
                    "length_per_ref": r.ref_length.map(|t| round(r.plan.length / t)), "violations": r.violations,
                })
            })
            .collect();
    }
    println!("{}", serde_json::to_string_pretty(&report)?);
    Ok(())
}
