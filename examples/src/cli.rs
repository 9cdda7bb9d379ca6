//! The command line of `seekplan`.

use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Robots that search: run a published system in the built-in simulator.
#[derive(Debug, Parser)]
#[command(name = "seekplan", version, about)]
pub struct Cli {
    /// What to run; `heats` when absent.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Explore an unknown building and inspect every surface for tags (HEATS).
    Heats(HeatsArgs),
    /// Search volumes for an object by planning views ahead (FLAP).
    Flap(FlapArgs),
    /// Run a suite of trials and tabulate it.
    Bench(BenchArgs),
    /// Check a scene file, or make one.
    Scene(SceneArgs),
    /// Make report.html anew from a run's recording.
    Report(ReportArgs),
}

/// Options of `seekplan heats`.
#[derive(Clone, Debug, Args)]
pub struct HeatsArgs {
    /// Embedded scene (office, maze, lab, closet) or path of a search-scene/1 file.
    #[arg(long, default_value = "office")]
    pub scene: String,
    /// Planner: heats-plus (ours), heats (as published), aep or wg-nbvp (camera alone) [default: heats-plus].
    #[arg(long)]
    pub planner: Option<String>,
    /// Sensors that may be used [default: both].
    #[arg(long)]
    pub sensors: Option<SensorsArg>,
    /// Seed of everything random [default: 1].
    #[arg(long)]
    pub seed: Option<u64>,
    /// Simulated seconds after which the run ends; the scene's limit when absent.
    #[arg(long, value_name = "S")]
    pub time_limit: Option<f64>,
    /// Sets one field, e.g. --set views.motion_decay=0.4; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// TOML file with settings.
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Folder for result.json, topdown.svg and the recording.
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Do not record what happens.
    #[arg(long)]
    pub no_record: bool,
    /// No progress lines and no table.
    #[arg(long)]
    pub quiet: bool,
}

/// Values of `--sensors`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SensorsArg {
    /// LiDAR and camera.
    Both,
    /// Camera alone.
    Camera,
}

/// Options of `seekplan flap`.
#[derive(Clone, Debug, Args)]
pub struct FlapArgs {
    /// Embedded scene or path of a search-scene/1 file; it needs target_volumes.
    #[arg(long, default_value = "race")]
    pub scene: String,
    /// Planner: flap (as published), greedy, local (ours), iter_psi or iter_phi [default: local].
    #[arg(long)]
    pub planner: Option<String>,
    /// When plans are made [default: continual].
    #[arg(long)]
    pub mode: Option<ModeArg>,
    /// What is known at the start [default: known].
    #[arg(long)]
    pub map: Option<MapArg>,
    /// Seed of start and views [default: 1].
    #[arg(long)]
    pub seed: Option<u64>,
    /// Sets one field, e.g. --set samples=300; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// TOML file with settings.
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Folder for result.json, topdown.svg and the recording.
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Do not record what happens.
    #[arg(long)]
    pub no_record: bool,
    /// No progress lines and no table.
    #[arg(long)]
    pub quiet: bool,
}

/// Values of `--mode`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ModeArg {
    /// Plan anew after every look.
    Continual,
    /// Plan once.
    Offline,
}

/// Values of `--map`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MapArg {
    /// All but what lies in the volumes.
    Known,
    /// Walls and floor.
    Walls,
}

/// Options of `seekplan bench`.
#[derive(Clone, Debug, Args)]
pub struct BenchArgs {
    /// Suite to run: heats-tables (Tables II and III of the HEATS paper), flap-figure6 (the three experiments of the FLAP paper),
    /// or a TOML file.
    #[arg(long, default_value = "flap-figure6")]
    pub suite: String,
    /// Trials at the same time.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub jobs: usize,
    /// Run only part I of N, counted from 1; the table is made when all parts are there.
    #[arg(long, value_name = "I/N")]
    pub shard: Option<String>,
    /// Keep the results that are there and run what is missing.
    #[arg(long)]
    pub resume: bool,
    /// Leave a report.html of each trial beside its result, to watch it in; the page of the campaign leads there. With --resume,
    /// trials without one are run again.
    #[arg(long, conflicts_with = "collect")]
    pub reports: bool,
    /// Print the names of the trials, one a line, and run nothing; trial I is that of `--shard I/N`.
    #[arg(long, conflicts_with = "collect")]
    pub list: bool,
    /// Make the tables of the results that are there, and run nothing.
    #[arg(long)]
    pub collect: bool,
    /// Seeds of each experiment [default: the suite's].
    #[arg(long, value_name = "N")]
    pub trials: Option<usize>,
    /// Folder of the trials' results and the tables.
    #[arg(long, value_name = "DIR", default_value = "bench")]
    pub out: PathBuf,
    /// No progress lines.
    #[arg(long)]
    pub quiet: bool,
}

/// Options of `seekplan scene`.
#[derive(Clone, Debug, Args)]
pub struct SceneArgs {
    /// What to do with the scene.
    #[command(subcommand)]
    pub action: SceneAction,
}

/// The actions of `seekplan scene`.
#[derive(Clone, Debug, Subcommand)]
pub enum SceneAction {
    /// Read and validate a scene file.
    Check {
        /// Embedded scene or path.
        scene: String,
    },
    /// Make a building of any size, furnished, with targets the robot can see.
    Generate(GenerateArgs),
}

/// Options of `seekplan scene generate`.
#[derive(Clone, Debug, Args)]
pub struct GenerateArgs {
    /// Kind of building.
    #[arg(long, default_value = "rooms")]
    pub layout: LayoutArg,
    /// Length and width, m, e.g. 40x30.
    #[arg(long, value_name = "LxW", default_value = "24x16")]
    pub size: String,
    /// Width of doors, m.
    #[arg(long, value_name = "M", default_value_t = 0.9)]
    pub door: f64,
    /// Number of targets.
    #[arg(long, value_name = "N", default_value_t = 8)]
    pub tags: usize,
    /// Wall one room up.
    #[arg(long)]
    pub closed_room: bool,
    /// Seed of everything drawn.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// File to write.
    #[arg(long, value_name = "FILE.json")]
    pub out: PathBuf,
}

/// Values of `--layout`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LayoutArg {
    /// Rooms with one door in each wall between them.
    Rooms,
    /// A grid maze.
    Maze,
    /// A hall with rows of shelves.
    Aisles,
}

/// Options of `seekplan report`.
#[derive(Clone, Debug, Args)]
pub struct ReportArgs {
    /// Folder of a run, with its record.jsonl.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Write a picture of the map at a moment instead.
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Write a picture of the report at a moment instead, taken by an installed Chromium.
    #[arg(long, value_name = "FILE")]
    pub png: Option<PathBuf>,
    /// Simulated time of the pictures, s; the end when absent.
    #[arg(long, value_name = "T")]
    pub at: Option<f64>,
}
