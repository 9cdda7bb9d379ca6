//! Runs instance files and folders and prints the figures of the crate's README, in CPU time of this thread.
//!
//! `cargo run --release -p atsp --example figures -- [--seeds 11] [--limit MS] [--json] FILE_OR_FOLDER...`
//!
//! Three tables: the way to the best known cost; deadlines; an earlier order of which a tenth of the nodes changed.
//! `--json` prints the first as one line per instance instead, for `tools/atsp_peers.py`.
#![allow(clippy::print_stdout, clippy::print_stderr, missing_docs)]

mod support;

use std::time::Duration;

use atsp::{CostModel, FromFn, Params, Problem, Solution, Solver, Watch};
use cpu_time::ThreadTime;
use serde_json::json;
use support::Instance;

/// Equal costs, up to the rounding of sums.
const SAME: f64 = 1e-9;
/// At most twelve nodes between two ends: solved and proved.
const SMALL: usize = 14;

/// Stops at a time or a cost and notes when each better order came.
struct Trace {
    begin: ThreadTime,
    limit: Duration,
    goal: f64,
    /// Milliseconds and cost.
    steps: Vec<(f64, f64)>,
}

impl Trace {
    fn new(limit_ms: f64, goal: f64) -> Self {
        Self {
            // Room first: the clock starts after the allocation.
            steps: Vec::with_capacity(4096),
            limit: Duration::from_secs_f64(limit_ms / 1e3),
            goal,
            begin: ThreadTime::now(),
        }
    }
    fn ms(&self) -> f64 {
        self.begin.elapsed().as_secs_f64() * 1e3
    }
    /// Cost known after so many milliseconds.
    fn cost_at(&self, ms: f64) -> Option<f64> {
        self.steps
            .iter()
            .take_while(|s| s.0 <= ms)
            .last()
            .map(|s| s.1)
    }
    /// When the goal was reached.
    fn reached(&self) -> Option<f64> {
        self.steps.iter().find(|s| s.1 <= self.goal).map(|s| s.0)
    }
}

impl Watch for Trace {
    fn stop(&mut self) -> bool {
        self.steps.last().is_some_and(|s| s.1 <= self.goal) || self.begin.elapsed() >= self.limit
    }
    fn improved(&mut self, cost: f64) {
        let ms = self.ms();
        self.steps.push((ms, cost));
    }
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn without_limit(seed: u64) -> Params {
    Params {
        kicks: u64::MAX,
        seed,
        ..Params::default()
    }
}

fn run(
    solver: &mut Solver,
    instance: &Instance,
    seed: u64,
    trace: &mut Trace,
) -> Result<Solution, String> {
    solver
        .solve_watched(
            &instance.costs,
            instance.problem,
            &[],
            &without_limit(seed),
            trace,
        )
        .map_err(|e| format!("{}: {e}", instance.name))
}

/// Per cent above the best known; infinite without an order.
fn gap(cost: Option<f64>, best: f64) -> f64 {
    cost.map_or(f64::INFINITY, |c| {
        100.0 * (c - best) / best.abs().max(f64::MIN_POSITIVE)
    })
}

struct Row {
    hits: u64,
    ms: Vec<f64>,
    proved: u64,
    gaps: [f64; 3],
}

/// The way to the best known cost.
fn row(instance: &Instance, seeds: u64, limit: f64) -> Result<Row, String> {
    let best = instance
        .best
        .ok_or(format!("{}: no best known cost beside it", instance.name))?;
    let mut solver = Solver::new();
    let (mut ms, mut hits, mut proved) = (Vec::new(), 0, 0);
    let mut gaps: [Vec<f64>; 3] = Default::default();
    // The first run allocates and is not counted.
    for seed in 0..=seeds {
        // Small sets run to the end, so that their time is that of the proof.
        let goal = best + SAME * best.abs();
        let is_small = instance.costs.len() <= SMALL;
        let mut trace = Trace::new(limit, if is_small { f64::NEG_INFINITY } else { goal });
        let found = run(&mut solver, instance, seed, &mut trace)?;
        let took = trace.ms();
        if seed == 0 {
            continue;
        }
        hits += u64::from(found.cost <= goal);
        proved += u64::from(found.optimal);
        ms.push(match is_small {
            true => took,
            false => trace.reached().unwrap_or(f64::INFINITY),
        });
        for (k, at) in [1.0, 10.0, 100.0].into_iter().enumerate() {
            let cost = if took <= at {
                Some(found.cost)
            } else {
                trace.cost_at(at)
            };
            gaps[k].push(gap(cost, best));
        }
    }
    median(&mut ms);
    Ok(Row {
        hits,
        ms,
        proved,
        gaps: gaps.map(|mut g| median(&mut g)),
    })
}

/// Overshoot of each seed at a budget, ms.
fn overshoot(
    solver: &mut Solver,
    instance: &Instance,
    seeds: u64,
    budget: f64,
) -> Result<Vec<f64>, String> {
    let mut over = Vec::new();
    for seed in 1..=seeds {
        let mut trace = Trace::new(budget, f64::NEG_INFINITY);
        let found = run(solver, instance, seed, &mut trace)?;
        over.push((trace.ms() - budget).max(0.0));
        if found.order.len() != instance.costs.len() || !found.cost.is_finite() {
            return Err(format!("{}: no order after {budget} ms", instance.name));
        }
    }
    Ok(over)
}

/// Warm against cold when a tenth of the nodes went and as many came: gaps at 0.5 ms, and times to the best, ms.
fn churn(solver: &mut Solver, instance: &Instance, seed: u64) -> Result<[f64; 4], String> {
    let n = instance.costs.len();
    let tenth = n / 11;
    // The nodes in a random order, ends apart.
    let mut nodes: Vec<usize> = (1..n - 1).collect();
    let mut state = seed;
    for i in (1..nodes.len()).rev() {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        nodes.swap(i, (state >> 33) as usize % (i + 1));
    }
    let (both, changing) = nodes.split_at(nodes.len() - 2 * tenth);
    let set = |extra: &[usize]| -> Vec<usize> {
        let inside = both.iter().chain(extra).copied();
        std::iter::once(0).chain(inside).chain([n - 1]).collect()
    };
    let (before, after) = (set(&changing[..tenth]), set(&changing[tenth..]));
    let mut solve = |set: &[usize], hint: &[usize], limit: f64, goal: f64| {
        let costs = FromFn::new(set.len(), |a, b| instance.costs.cost(set[a], set[b]));
        let problem = Problem::Path {
            start: 0,
            end: set.len() - 1,
        };
        let mut trace = Trace::new(limit, goal);
        solver
            .solve_watched(&costs, problem, hint, &without_limit(seed), &mut trace)
            .map(|found| (found, trace))
            .map_err(|e| format!("{}: {e}", instance.name))
    };
    let (old, _) = solve(&before, &[], 100.0, f64::NEG_INFINITY)?;
    // The old order in the new numbers: nodes that went are strangers.
    let hint: Vec<usize> = old
        .order
        .iter()
        .filter_map(|&i| after.iter().position(|&node| node == before[i]))
        .collect();
    let (found, _) = solve(&after, &[], 300.0, f64::NEG_INFINITY)?;
    let goal = found.cost + SAME * found.cost;
    let (_, warm) = solve(&after, &hint, 300.0, goal)?;
    let (_, cold) = solve(&after, &[], 300.0, goal)?;
    Ok([
        gap(warm.cost_at(0.5), found.cost),
        gap(cold.cost_at(0.5), found.cost),
        warm.reached().unwrap_or(300.0),
        cold.reached().unwrap_or(300.0),
    ])
}

/// The instance files of folders and files, in order of name.
fn files(paths: &[String]) -> Result<Vec<std::path::PathBuf>, String> {
    let mut found = Vec::new();
    for path in paths {
        let path = std::path::Path::new(path);
        if path.is_dir() {
            let mut inside: Vec<_> = std::fs::read_dir(path)
                .map_err(|e| format!("{}: {e}", path.display()))?
                .filter_map(|entry| entry.ok().map(|e| e.path()))
                .filter(|p| p.extension().is_some_and(|e| e == "json" || e == "atsp"))
                .filter(|p| !p.ends_with("best.json") && !p.ends_with("optima.json"))
                .collect();
            inside.sort();
            found.extend(inside);
        } else {
            found.push(path.to_owned());
        }
    }
    if found.is_empty() {
        return Err("no .atsp or .json instance found".to_owned());
    }
    Ok(found)
}

fn main() -> std::process::ExitCode {
    match print() {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            std::process::ExitCode::from(2)
        }
    }
}

fn print() -> Result<(), String> {
    let mut paths = Vec::new();
    let (mut seeds, mut limit, mut as_json) = (11u64, 1000.0f64, false);
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut value = || args.next().unwrap_or_default();
        match arg.as_str() {
            "--seeds" => seeds = value().parse().map_err(|e| format!("--seeds: {e}"))?,
            "--limit" => limit = value().parse().map_err(|e| format!("--limit: {e}"))?,
            "--json" => as_json = true,
            _ => paths.push(arg),
        }
    }
    let mut instances = Vec::new();
    for path in files(&paths)? {
        instances.push(support::read(&path)?);
    }
    if !as_json {
        println!(
            "| instance | n | best in | proved | ms to best, median | most | gap at 1 ms, % | 10 ms | 100 ms |"
        );
        println!("|---|---|---|---|---|---|---|---|---|");
    }
    for instance in &instances {
        let row = row(instance, seeds, limit)?;
        let n = instance.costs.len();
        let (middle, most) = (row.ms[row.ms.len() / 2], row.ms[row.ms.len() - 1]);
        if as_json {
            let line = json!({
                "name": instance.name, "family": instance.family, "n": n, "best": instance.best, "seeds": seeds,
                "hits": row.hits, "proved": row.proved, "ms_median": middle, "ms_most": most,
                "gap_1ms": row.gaps[0], "gap_10ms": row.gaps[1], "gap_100ms": row.gaps[2],
            });
            println!("{line}");
        } else {
            println!(
                "| {} | {n} | {}/{seeds} | {} | {middle:.3} | {most:.3} | {:.3} | {:.3} | {:.3} |",
                instance.name, row.hits, row.proved, row.gaps[0], row.gaps[1], row.gaps[2],
            );
        }
    }
    if as_json {
        return Ok(());
    }
    println!("\n| budget, ms | runs | overshoot, ms: 99th percentile | most |\n|---|---|---|---|");
    let mut solver = Solver::new();
    for budget in [0.0, 1.0, 10.0, 100.0] {
        let mut over = Vec::new();
        for instance in &instances {
            // Runs long enough to be worth stopping: short ones end by themselves.
            let runs = if budget > 50.0 { 1 } else { seeds };
            over.extend(overshoot(&mut solver, instance, runs, budget)?);
        }
        median(&mut over);
        let p99 = over[(over.len() * 99).div_ceil(100) - 1];
        println!(
            "| {budget} | {} | {p99:.3} | {:.3} |",
            over.len(),
            over[over.len() - 1]
        );
    }
    println!(
        "\n| a tenth changed | n | gap at 0.5 ms, %: warm | cold | ms to best: warm | cold |\n|---|---|---|---|---|---|"
    );
    let paths = |i: &&Instance| {
        i.costs.len() >= 50 && matches!(i.problem, Problem::Path { .. }) && i.family != "oneway"
    };
    for instance in instances.iter().filter(paths) {
        let mut columns: [Vec<f64>; 4] = Default::default();
        for seed in 1..=seeds.min(5) {
            let figures = churn(&mut solver, instance, seed)?;
            for (column, figure) in columns.iter_mut().zip(figures) {
                column.push(figure);
            }
        }
        let [warm, cold, warm_ms, cold_ms] = columns.map(|mut c| median(&mut c));
        println!(
            "| {} | {} | {warm:.3} | {cold:.3} | {warm_ms:.3} | {cold_ms:.3} |",
            instance.name,
            instance.costs.len() - instance.costs.len() / 11,
        );
    }
    Ok(())
}
