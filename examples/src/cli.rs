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
    /// Check a scene file.
    Scene(SceneArgs),
}

/// Options of `seekplan heats`.
#[derive(Clone, Debug, Args)]
pub struct HeatsArgs {
    /// Embedded scene (office, maze, lab, closet) or path of a search-scene/1 file.
    #[arg(long, default_value = "office")]
    pub scene: String,
    /// Planner. Built so far: heats.
    #[arg(long, default_value = "heats")]
    pub planner: String,
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
    /// Folder for result.json and topdown.svg.
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
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
}
