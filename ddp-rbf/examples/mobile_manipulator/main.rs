//! The mobile manipulator of the benchmark (format heats-ipc-bench/1), solved, controlled and timed.
//!
//! ```text
//! cargo run --release -p ddp-rbf --example mobile_manipulator -- DIR [--json] [--knots 60] [--cells 0.05,0.1,0.15]
//!     [--sudden CASES] [--robot mm-robot.json] [--peer] [--candidates FILE] [--log FILE]
//! ```
//!
//! DIR holds `problem.json` and the instances. For each instance: the cost of the horizon and its gap to the reference
//! optimum from both guesses, iterations, CPU time of an iteration (with `--peer` beside OpEn's PANOC on the same model); then closed loop on a voxel map with the defaults and
//! with the paper's scheme. `--candidates` and `--log` write trajectories for an independent judge. Times are CPU times of
//! this thread in microseconds. With `--features clarabel` the safety layer projects unsafe commands, otherwise it makes them
//! smaller or brakes.
#![allow(clippy::print_stdout)]

mod closed;
mod esdf;
mod open;
mod peer;
mod problem;
mod sudden;

use closed::Scheme;
use ddp_rbf::Barrier;
use problem::{Instance, Outcome, Problem};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// What the command line asks for.
struct Asked {
    folder: PathBuf,
    json: bool,
    knots: Vec<usize>,
    cells: Vec<f64>,
    sudden: usize,
    robot: Option<PathBuf>,
    peer: bool,
    candidates: Option<PathBuf>,
    log: Option<PathBuf>,
}

fn asked() -> Outcome<Asked> {
    let mut out = Asked {
        folder: PathBuf::new(),
        json: false,
        knots: vec![60],
        cells: vec![0.15],
        sudden: 0,
        robot: None,
        peer: false,
        candidates: None,
        log: None,
    };
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--json" => out.json = true,
            "--peer" => out.peer = true,
            "--knots" => out.knots = list(&value()?)?,
            "--cells" => out.cells = list(&value()?)?,
            "--sudden" => out.sudden = value()?.parse()?,
            "--robot" => out.robot = Some(value()?.into()),
            "--candidates" => out.candidates = Some(value()?.into()),
            "--log" => out.log = Some(value()?.into()),
            other if other.starts_with('-') => return Err(format!("unknown option {other}").into()),
            folder => out.folder = folder.into(),
        }
    }
    if out.folder.as_os_str().is_empty() {
        return Err(
            "usage: mobile_manipulator DIR [--json] [--knots N,N] [--cells H,H] ...".into(),
        );
    }
    if out.knots.iter().any(|n| ![30, 60, 120].contains(n)) {
        return Err("--knots takes 30, 60 and 120, to which the reference has rows".into());
    }
    Ok(out)
}

fn list<T: std::str::FromStr>(text: &str) -> Outcome<Vec<T>> {
    text.split(',')
        .map(|v| {
            v.trim()
                .parse()
                .map_err(|_| format!("{v} is not a number").into())
        })
        .collect()
}

fn main() -> Outcome<()> {
    let asked = asked()?;
    let problem = Problem::read(&asked.folder.join("problem.json"))?;
    let instances = Instance::read_all(&asked.folder)?;
    let say = |line: String| {
        if !asked.json {
            println!("{line}");
        }
    };
    let mut rows = Vec::new();
    let (mut candidates, mut log) = (Vec::new(), Vec::new());
    let mut summary = Summary::default();
    for instance in &instances {
        let mut row = json!({ "name": instance.name });
        for &n in &asked.knots {
            row[format!("N{n}")] =
                open_loop(&problem, instance, n, &mut summary, &mut candidates, &say)?;
            if let (true, Some(best)) = (asked.peer, instance.best("rbf", n)) {
                let found = peer::solve(&problem, instance, n, best)?;
                say(format!("{:18} N={n:<3} OpEn {found}", instance.name));
                summary.compare(&row[format!("N{n}")], &found);
                row[format!("N{n}")]["open_engine"] = found;
            }
        }
        for &cell in &asked.cells {
            row[format!("closed_{}cm", (cell * 100.0).round())] =
                closed_loop(&problem, instance, cell, &mut summary, &mut log, &say)?;
        }
        rows.push(row);
    }
    let mut all = json!({ "instances": rows, "summary": summary.value() });
    if asked.sudden > 0 {
        all["sudden"] = sudden::cases(&problem, &instances, asked.sudden)?;
        say(format!("sudden obstacles: {}", all["sudden"]));
    }
    if let Some(path) = &asked.robot {
        all["large_robot"] = sudden::large_robot(&problem, &instances, path)?;
        say(format!("large robot: {}", all["large_robot"]));
    }
    say(format!("summary: {}", all["summary"]));
    if asked.json {
        println!("{}", serde_json::to_string_pretty(&all)?);
    }
    write(asked.candidates.as_deref(), &candidates)?;
    write(asked.log.as_deref(), &log)
}

fn write(path: Option<&Path>, values: &[Value]) -> Outcome<()> {
    match path {
        Some(path) => Ok(std::fs::write(path, serde_json::to_string(values)?)?),
        None => Ok(()),
    }
}

/// Figures over all instances.
#[derive(Default)]
struct Summary {
    reached: usize,
    solves: usize,
    per_iteration: Vec<f64>,
    to_optimum: [Vec<f64>; 2],
    tracking: [Vec<f64>; 2],
    /// Times of OpEn over ours to 1e-4, as they are and less what second derivatives cost.
    peer: [Vec<f64>; 2],
    steps: Vec<f64>,
    good: [usize; 2],
    runs: usize,
}

impl Summary {
    fn compare(&mut self, ours: &Value, theirs: &Value) {
        for guess in ["reference", "hold"] {
            for (i, what) in ["us_to_1e-4", "us_less_second_derivatives"]
                .iter()
                .enumerate()
            {
                let (a, b) = (
                    ours[guess]["us_to_1e-4"].as_f64(),
                    theirs[guess][what].as_f64(),
                );
                self.peer[i].extend(b.zip(a).map(|(b, a)| b / a));
            }
        }
    }

    fn value(&self) -> Value {
        json!({
            "solves_that_reach_the_optimum": format!("{} of {}", self.reached, self.solves),
            "us_per_iteration_median": percentile(&self.per_iteration, 0.5),
            "us_to_1e-4_from_reference_median": percentile(&self.to_optimum[0], 0.5),
            "us_to_1e-4_from_hold_median": percentile(&self.to_optimum[1], 0.5),
            "tracking_over_hard_optimum_default": {
                "median": percentile(&self.tracking[0], 0.5), "worst": percentile(&self.tracking[0], 1.0) },
            "tracking_over_hard_optimum_paper": {
                "median": percentile(&self.tracking[1], 0.5), "worst": percentile(&self.tracking[1], 1.0) },
            "open_engine_time_over_ours_to_1e-4": {
                "solved": self.peer[0].len(), "median": percentile(&self.peer[0], 0.5),
                "median_less_second_derivatives": percentile(&self.peer[1], 0.5) },
            "us_per_control_step": {
                "median": percentile(&self.steps, 0.5), "p99": percentile(&self.steps, 0.99),
                "worst": percentile(&self.steps, 1.0) },
            "closed_loop_good_default": format!("{} of {}", self.good[0], self.runs),
            "closed_loop_good_paper": format!("{} of {}", self.good[1], self.runs),
        })
    }
}

/// The value below which a share of all lie; null for none.
pub(crate) fn percentile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    Some(sorted[(share * last as f64).round() as usize])
}

fn open_loop(
    problem: &Problem,
    instance: &Instance,
    n: usize,
    summary: &mut Summary,
    candidates: &mut Vec<Value>,
    say: &impl Fn(String),
) -> Outcome<Value> {
    let Some(best) = instance.best("rbf", n) else {
        say(format!(
            "{:18} N={n:<3} holds no reference optimum",
            instance.name
        ));
        return Ok(Value::Null);
    };
    let scale = instance.rolled_out(n).map_or(1.0, |r| (r - best).max(1e-2));
    let mut out = json!({});
    for (i, s) in open::solve(problem, instance, n, best, 21)?
        .iter()
        .enumerate()
    {
        let gap = s.report.cost - best;
        summary.solves += 1;
        summary.reached += usize::from(gap <= 1e-3 * scale && s.report.gap < 1e-6);
        if n == 60 {
            summary.per_iteration.push(s.per_iteration);
            if s.needed > 0 {
                summary.to_optimum[i].push(s.time_needed);
            }
        }
        say(format!(
            "{:18} N={n:<3} {:9} {:?} cost {:.6} gap to reference {gap:9.2e}, {} iterations; to 1e-4: {} in {:.0} us; {:.1} us the first, {:.1} us each further",
            instance.name,
            s.guess,
            s.report.status,
            s.report.cost,
            s.report.iterations,
            s.needed,
            s.time_needed,
            s.first,
            s.per_iteration,
        ));
        out[s.guess] = json!({
            "cost": s.report.cost, "gap_to_reference": gap, "iterations": s.report.iterations,
            "iterations_to_1e-4": s.needed, "us_to_1e-4": s.time_needed,
            "us_first_iteration": s.first, "us_per_iteration": s.per_iteration,
        });
        candidates.push(json!({
            "name": instance.name, "N": n, "time_us": s.time_needed,
            "x": s.states.iter().map(|x| x.as_slice().to_vec()).collect::<Vec<_>>(),
            "u": s.inputs.iter().map(|u| u.as_slice().to_vec()).collect::<Vec<_>>(),
        }));
    }
    if let (60, Some(hard)) = (n, instance.best("hard", n)) {
        for (i, barrier) in [Barrier::default(), Barrier::paper()]
            .into_iter()
            .enumerate()
        {
            let ratio = open::tracking_of(problem, instance, n, barrier)? / hard;
            summary.tracking[i].push(ratio);
            out[["tracking_ratio_default", "tracking_ratio_paper"][i]] = json!(ratio);
        }
    }
    Ok(out)
}

fn closed_loop(
    problem: &Problem,
    instance: &Instance,
    cell: f64,
    summary: &mut Summary,
    log: &mut Vec<Value>,
    say: &impl Fn(String),
) -> Outcome<Value> {
    let mut out = json!({});
    summary.runs += 1;
    let schemes = [
        ("default", Scheme::standard(cell)),
        ("paper", Scheme::paper(cell)),
    ];
    for (i, (name, scheme)) in schemes.into_iter().enumerate() {
        let run = closed::run(problem, instance, &scheme, None)?;
        summary.good[i] += usize::from(run.is_good());
        let c = run.counts;
        let fallbacks = c.projected + c.scaled + c.braked;
        say(format!(
            "{:18} {:3.0} cm {name:8} clearance {:.3} own {:.3} inputs {:.3} end error {:.3} tracking {:.4} projected {} scaled {} braked {} step {:.0} us median {:.0} p99 {}",
            instance.name,
            cell * 100.0,
            run.clearance,
            run.own,
            run.input_room,
            run.error,
            run.tracking,
            c.projected,
            c.scaled,
            c.braked,
            percentile(&run.times, 0.5).unwrap_or(0.0),
            percentile(&run.times, 0.99).unwrap_or(0.0),
            if run.is_good() { "good" } else { "FAILED" },
        ));
        out[name] = json!({
            "good": run.is_good(),
            "min_clearance": run.clearance, "min_self_clearance": run.own,
            "min_constraint_margin": run.clearance.min(run.own).min(run.input_room).min(run.joint_room),
            "min_input_room": run.input_room, "final_error": run.error, "tracking": run.tracking,
            "fallbacks": fallbacks, "projected": c.projected, "scaled": c.scaled, "braked": c.braked,
            "us_per_step": percentile(&run.times, 0.5), "us_per_step_p99": percentile(&run.times, 0.99),
        });
        if i == 0 {
            summary.steps.extend(&run.times);
            log.push(json!({
                "name": instance.name, "dt": 0.01,
                "x": run.states.iter().map(|x| x.as_slice().to_vec()).collect::<Vec<_>>(),
                "u": run.inputs.iter().map(|u| u.as_slice().to_vec()).collect::<Vec<_>>(),
            }));
        }
    }
    Ok(out)
}
