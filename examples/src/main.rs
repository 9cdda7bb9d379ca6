//! The command line: reads arguments, runs, prints, and turns errors into exit statuses.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use clap::Parser;
use seekplan::baselines::{self, Baseline, BaselineSettings};
use seekplan::bench::{self, Campaign};
use seekplan::cli::{
    BenchArgs, Cli, Command, FlapArgs, GenerateArgs, HeatsArgs, LayoutArg, MapArg, ModeArg,
    ReportArgs, SceneAction, SensorsArg,
};
use seekplan::flap::{self, FlapSettings, MapKind};
use seekplan::generate::{Blueprint, Layout};
use seekplan::heats::{self, Planner, Sensors, Settings};
use seekplan::record::{self, Ended, Ground, JsonLines, Recorder, ReportError, Silent};
use seekplan::report::{ProgressLine, Status};
use seekplan::scene::Scene;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit status for bad input.
const BAD_INPUT: u8 = 2;
/// Exit status after Ctrl-C.
const INTERRUPTED: u8 = 130;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let command = match cli.command {
        Some(command) => command,
        // `cargo run --release` alone runs HEATS with its defaults.
        None => match Cli::parse_from(["seekplan", "heats"]).command {
            Some(command) => command,
            None => return ExitCode::from(BAD_INPUT),
        },
    };
    let outcome = match command {
        Command::Heats(args) => run_heats(&args),
        Command::Flap(args) => run_flap(&args),
        Command::Bench(args) => run_bench(&args),
        Command::Scene(args) => match args.action {
            SceneAction::Check { scene } => check(&scene),
            SceneAction::Generate(args) => generate(&args),
        },
        Command::Report(args) => run_report(&args),
    };
    match outcome {
        Ok(code) => code,
        Err(message) => {
            eprintln!("seekplan: {message}");
            ExitCode::from(BAD_INPUT)
        }
    }
}

fn check(name: &str) -> Result<ExitCode, String> {
    let scene = Scene::open(name).map_err(|e| e.to_string())?;
    println!(
        "{}: {} shapes, {} tags, bounds {:?} to {:?} m: valid",
        scene.name,
        scene.shapes.len(),
        scene.tags.len(),
        scene.bounds.min,
        scene.bounds.max
    );
    Ok(ExitCode::SUCCESS)
}

fn generate(args: &GenerateArgs) -> Result<ExitCode, String> {
    let size: Result<Vec<f64>, _> = args.size.split('x').map(str::parse).collect();
    let Ok([length, width]) = size.as_deref() else {
        return Err(format!(
            "--size {}: write length and width in metres, e.g. 40x30",
            args.size
        ));
    };
    let blueprint = Blueprint {
        layout: match args.layout {
            LayoutArg::Rooms => Layout::Rooms,
            LayoutArg::Maze => Layout::Maze,
            LayoutArg::Aisles => Layout::Aisles,
        },
        size: [*length, *width],
        door: args.door,
        tags: args.tags,
        closed_room: args.closed_room,
        seed: args.seed,
    };
    let scene = blueprint.build().map_err(|e| e.to_string())?;
    let text = serde_json::to_string_pretty(&scene).map_err(|e| e.to_string())?;
    std::fs::write(&args.out, text)
        .map_err(|e| format!("cannot write {}: {e}", args.out.display()))?;
    println!("wrote {}", args.out.display());
    check(&args.out.to_string_lossy())
}

/// A planner of `seekplan heats` by its name.
#[derive(Clone, Copy)]
enum Which {
    Heats(Planner),
    Baseline(Baseline),
}

impl Which {
    fn named(name: &str) -> Result<Self, String> {
        let heats = Planner::ALL.map(|p| (p.name(), Self::Heats(p)));
        let baselines = Baseline::ALL.map(|b| (b.name(), Self::Baseline(b)));
        let all = || heats.iter().chain(&baselines);
        all()
            .find(|(n, _)| *n == name)
            .map(|(_, which)| *which)
            .ok_or_else(|| {
                let names: Vec<&str> = all().map(|(n, _)| *n).collect();
                format!(
                    "no planner is called {name:?}; there are {}",
                    names.join(", ")
                )
            })
    }
}

/// The planner of a config file, if it names one.
fn named_in(text: &str) -> Option<String> {
    let table: toml::Table = toml::from_str(text).ok()?;
    Some(table.get("planner")?.as_str()?.to_owned())
}

/// Settings and planner of `seekplan heats`.
enum Chosen {
    Heats(Box<Settings>),
    Baseline(Box<BaselineSettings>),
}

fn chosen(args: &HeatsArgs) -> Result<Chosen, String> {
    let text = match &args.config {
        None => String::new(),
        Some(path) => std::fs::read_to_string(path)
            .map_err(|e| format!("cannot read {}: {e}", path.display()))?,
    };
    let name = args.planner.clone().or_else(|| named_in(&text));
    let sets = || args.set.iter().map(String::as_str);
    match Which::named(name.as_deref().unwrap_or(Planner::default().name()))? {
        Which::Heats(planner) => {
            let first = Settings {
                seed: 1,
                ..Settings::of(planner).map_err(|e| e.to_string())?
            };
            let mut settings = Settings {
                planner,
                ..first.overlaid(&text).map_err(|e| e.to_string())?
            }
            .with(sets())
            .map_err(|e| e.to_string())?;
            if let Some(sensors) = args.sensors {
                settings.sensors = match sensors {
                    SensorsArg::Both => Sensors::Both,
                    SensorsArg::Camera => Sensors::Camera,
                };
            }
            settings.seed = args.seed.unwrap_or(settings.seed);
            settings.time_limit = args.time_limit.or(settings.time_limit);
            settings.validate().map_err(|e| e.to_string())?;
            Ok(Chosen::Heats(Box::new(settings)))
        }
        Which::Baseline(planner) => {
            if args.sensors == Some(SensorsArg::Both) {
                return Err(format!(
                    "planner {} sees with the camera alone; leave out --sensors both",
                    planner.name()
                ));
            }
            let mut settings = BaselineSettings {
                planner,
                ..BaselineSettings::from_toml(&text).map_err(|e| e.to_string())?
            }
            .with(sets())
            .map_err(|e| e.to_string())?;
            settings.seed = args.seed.unwrap_or(settings.seed);
            settings.time_limit = args.time_limit.or(settings.time_limit);
            settings.validate().map_err(|e| e.to_string())?;
            Ok(Chosen::Baseline(Box::new(settings)))
        }
    }
}

fn run_heats(args: &HeatsArgs) -> Result<ExitCode, String> {
    let chosen = chosen(args)?;
    let scene = Scene::open(&args.scene).map_err(|e| e.to_string())?;

    let stop = stop_on_interrupt()?;
    let mut line = ProgressLine::new(args.quiet);
    let mut recorder = recorder(args.no_record, &args.out);
    let mut show = |status: &Status<'_>| line.show(status);
    let run = match &chosen {
        Chosen::Heats(settings) => {
            heats::run_recorded(&scene, settings, &stop, &mut show, recorder.as_mut())
        }
        Chosen::Baseline(settings) => {
            baselines::run_recorded(&scene, settings, &stop, &mut show, recorder.as_mut())
        }
    }
    .map_err(|e| e.to_string())?;
    line.finish();
    let mut files = record::write(&args.out, &run.result, &Ground::of(&scene), &run.trace)
        .map_err(|e| e.to_string())?;
    files.extend(keep(recorder.as_mut(), &args.out));
    if !args.quiet {
        print!("{}", record::closing_table(&run.result));
        for file in files {
            println!("  wrote {}", file.display());
        }
    }
    Ok(match run.result.ended {
        Ended::Interrupted => ExitCode::from(INTERRUPTED),
        Ended::Complete | Ended::TimeLimit => ExitCode::SUCCESS,
    })
}

/// Where a run's events go.
fn recorder(none: bool, out: &Path) -> Box<dyn Recorder> {
    if none {
        Box::new(Silent)
    } else {
        Box::new(JsonLines::new(out))
    }
}

/// Ends a recording and makes the report of it. A run is worth its result even if its recording could not be written.
fn keep(recorder: &mut dyn Recorder, folder: &Path) -> Vec<PathBuf> {
    if !recorder.is_on() {
        return Vec::new();
    }
    let made = recorder.finish().map_err(ReportError::from);
    match made.and_then(|()| record::rebuild(folder)) {
        Ok(files) => files,
        Err(error) => {
            eprintln!("seekplan: no report: {error}");
            Vec::new()
        }
    }
}

fn run_report(args: &ReportArgs) -> Result<ExitCode, String> {
    if args.at.is_some_and(|t| !t.is_finite() || t < 0.0) {
        return Err("--at must be a time in seconds, zero or more".into());
    }
    if let Some(file) = &args.svg {
        let picture = record::still(&args.folder, args.at).map_err(|e| e.to_string())?;
        std::fs::write(file, picture)
            .map_err(|e| format!("cannot write {}: {e}", file.display()))?;
        println!("wrote {}", file.display());
    }
    if let Some(file) = &args.png {
        record::rebuild(&args.folder).map_err(|e| e.to_string())?;
        photograph(&args.folder, args.at, file)?;
        println!("wrote {}", file.display());
    }
    if args.svg.is_none() && args.png.is_none() {
        for file in record::rebuild(&args.folder).map_err(|e| e.to_string())? {
            println!("wrote {}", file.display());
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Has a Chromium, under whichever name it is installed, draw the report at a moment.
fn photograph(folder: &Path, at: Option<f64>, file: &Path) -> Result<(), String> {
    let page = std::path::absolute(folder.join(record::REPORT_FILE)).map_err(|e| e.to_string())?;
    let file = std::path::absolute(file).map_err(|e| e.to_string())?;
    let moment = at.map_or(String::new(), |t| format!("#t={t}"));
    let url = format!("file://{}{moment}", page.display());
    // Beside the file, so that one from before is there until there is another.
    let taken = file.with_extension("taken.png");
    let _ = std::fs::remove_file(&taken);
    for name in ["chromium", "chromium-browser", "google-chrome"] {
        let run = std::process::Command::new(name)
            .args([
                "--headless=new",
                "--no-sandbox",
                "--disable-gpu",
                "--hide-scrollbars",
                "--virtual-time-budget=4000",
                "--window-size=1280,800",
            ])
            .arg(format!("--screenshot={}", taken.display()))
            .arg(&url)
            .output();
        if run.is_ok() && taken.exists() {
            return std::fs::rename(&taken, &file).map_err(|e| e.to_string());
        }
    }
    Err("--png needs an installed Chromium that can write the file; --svg needs nothing".into())
}

/// A flag that Ctrl-C sets; a second Ctrl-C ends the program at once.
fn stop_on_interrupt() -> Result<Arc<AtomicBool>, String> {
    let stop = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&stop);
    ctrlc::set_handler(move || {
        if seen.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    })
    .map_err(|e| format!("cannot listen for Ctrl-C: {e}"))?;
    Ok(stop)
}

fn flap_settings(args: &FlapArgs) -> Result<FlapSettings, String> {
    let mut settings = match &args.config {
        None => FlapSettings::default(),
        Some(path) => {
            let text = std::fs::read_to_string(path)
                .map_err(|e| format!("cannot read {}: {e}", path.display()))?;
            FlapSettings::from_toml(&text).map_err(|e| e.to_string())?
        }
    };
    let planner = args.planner.iter().map(|name| format!("planner={name}"));
    let assignments: Vec<String> = planner.chain(args.set.iter().cloned()).collect();
    settings = settings
        .with(assignments.iter().map(String::as_str))
        .map_err(|e| e.to_string())?;
    if let Some(mode) = args.mode {
        settings.offline = mode == ModeArg::Offline;
    }
    if let Some(map) = args.map {
        settings.map = match map {
            MapArg::Known => MapKind::Known,
            MapArg::Walls => MapKind::Walls,
        };
    }
    if let Some(seed) = args.seed {
        settings.seed = seed;
    }
    settings.validate().map_err(|e| e.to_string())?;
    Ok(settings)
}

fn run_flap(args: &FlapArgs) -> Result<ExitCode, String> {
    let settings = flap_settings(args)?;
    let scene = Scene::open(&args.scene).map_err(|e| e.to_string())?;
    let stop = stop_on_interrupt()?;
    let quiet = args.quiet;
    let mut recorder = recorder(args.no_record, &args.out);
    let mut show = |p: &flap::Progress| {
        if !quiet {
            eprintln!(
                "look {:2}  {:6.1} s  success {:5.1} %  expected time so far {:6.1} s  plan of {} views",
                p.looks,
                p.time,
                100.0 * p.probability,
                p.expected_time,
                p.planned
            );
        }
    };
    let outcome = flap::run_recorded(&scene, &settings, &stop, &mut show, recorder.as_mut())
        .map_err(|e| e.to_string())?;
    let ground = Ground::of(&scene);
    let mut files = flap::write(&args.out, &outcome, &ground, &scene.target_volumes)
        .map_err(|e| e.to_string())?;
    files.extend(keep(recorder.as_mut(), &args.out));
    if !quiet {
        print!("{}", flap::closing_table(&outcome.result));
        for file in files {
            println!("  wrote {}", file.display());
        }
    }
    Ok(if outcome.result.ended == "interrupted" {
        ExitCode::from(INTERRUPTED)
    } else {
        ExitCode::SUCCESS
    })
}

fn run_bench(args: &BenchArgs) -> Result<ExitCode, String> {
    let suite = bench::suite(&args.suite, args.trials).map_err(|e| e.to_string())?;
    if args.list {
        let mut out = std::io::stdout().lock();
        for trial in suite.trials() {
            // Who reads on, e.g. `head`, may have enough.
            if writeln!(out, "{}", trial.name).is_err() {
                break;
            }
        }
        return Ok(ExitCode::SUCCESS);
    }
    let campaign = Campaign {
        jobs: args.jobs,
        shard: bench::parse_shard(args.shard.as_deref()).map_err(|e| e.to_string())?,
        resume: args.resume,
        reports: args.reports,
        out: args.out.clone(),
    };
    let stop = stop_on_interrupt()?;
    let quiet = args.quiet;
    let report = if args.collect {
        bench::collect(suite.as_ref(), &args.out)
    } else {
        bench::run(suite.as_ref(), &campaign, &stop, &|line: &str| {
            if !quiet {
                eprintln!("{line}");
            }
        })
    }
    .map_err(|e| e.to_string())?;
    print!("{}", report.table);
    for file in &report.files {
        println!("wrote {}", file.display());
    }
    Ok(if report.interrupted {
        ExitCode::from(INTERRUPTED)
    } else {
        ExitCode::SUCCESS
    })
}
