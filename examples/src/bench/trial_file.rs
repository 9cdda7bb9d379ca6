//! The result file of a trial: the run's result with all that says what was run, and on which machine.

use super::campaign::Flaw;
use crate::record::RunResult;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// Value of [`TrialFile::schema`].
pub const TRIAL_SCHEMA: &str = "seekplan-trial/2";

/// A trial's result file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialFile {
    /// Always [`TRIAL_SCHEMA`].
    pub schema: String,
    /// Name of the trial.
    pub trial: String,
    /// Hash of the scene ([`scene_hash`]).
    pub scene_hash: String,
    /// Version of this program.
    pub version: String,
    /// Hash of the sources it was built of.
    pub sources: String,
    /// Compiler that built it.
    pub rustc: String,
    /// What came of it, with seed, all settings, counters; its `wall` is not reproducible.
    pub result: RunResult,
    /// The machine it ran on: not reproducible.
    pub machine: Machine,
}

/// A machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// Model of its processor.
    pub cpu: String,
    /// Most memory that the process had taken by the trial's end, MiB; absent where the system does not tell.
    pub peak_memory_mib: Option<f64>,
}

impl Machine {
    /// This one.
    pub fn here() -> Self {
        let field = |file: &str, key: &str| {
            let text = std::fs::read_to_string(file).ok()?;
            let line = text.lines().find(|l| l.starts_with(key))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        };
        let peak = field("/proc/self/status", "VmHWM");
        Self {
            cpu: field("/proc/cpuinfo", "model name")
                .unwrap_or_else(|| std::env::consts::ARCH.into()),
            peak_memory_mib: peak
                .and_then(|p| p.split(' ').next()?.parse::<f64>().ok())
                .map(|kib| (kib / 102.4).round() / 10.0),
        }
    }
}

/// Version of this program, hash of the sources it was built of, and the compiler that built it.
pub(super) const BUILD: [&str; 3] = [
    env!("CARGO_PKG_VERSION"),
    env!("SEEKPLAN_SOURCES"),
    env!("SEEKPLAN_RUSTC"),
];

/// FNV-1a (64 bits) of a scene as JSON: the same for every file that says the same.
pub fn scene_hash(scene: &Scene) -> String {
    let text = serde_json::to_string(scene).unwrap_or_default();
    let hash = text.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |h, byte| {
        (h ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
    });
    format!("fnv1a64-{hash:016x}")
}

impl TrialFile {
    /// Reads a file's text.
    ///
    /// # Errors
    /// [`Flaw::Broken`] for a file that is not whole, or of another kind.
    pub fn from_json(text: &str) -> Result<Self, Flaw> {
        let file: Self = serde_json::from_str(text).map_err(|e| Flaw::Broken(e.to_string()))?;
        if file.schema == TRIAL_SCHEMA {
            Ok(file)
        } else {
            Err(Flaw::Broken(format!("schema {:?}", file.schema)))
        }
    }

    /// Whether it is the result of this trial as it would be run now.
    ///
    /// # Errors
    /// [`Flaw::Other`] naming what differs.
    pub fn check(&self, trial: &str, scene_hash: &str, settings: &str) -> Result<(), Flaw> {
        let [version, sources, rustc] = BUILD;
        for (what, is, wanted) in [
            ("trial", self.trial.as_str(), trial),
            ("scene_hash", &self.scene_hash, scene_hash),
            ("version", &self.version, version),
            ("sources", &self.sources, sources),
            ("rustc", &self.rustc, rustc),
            ("settings", &self.result.settings, settings),
        ] {
            if is != wanted {
                let difference = if what == "settings" {
                    let line = is.lines().zip(wanted.lines()).find(|(a, b)| a != b);
                    line.map_or(String::new(), |(a, b)| format!(": {a} instead of {b}"))
                } else {
                    format!(": {is} instead of {wanted}")
                };
                return Err(Flaw::Other(format!("{what}{difference}")));
            }
        }
        Ok(())
    }

    /// The file without what differs between two equal trials.
    pub fn reproducible(&self) -> Self {
        Self {
            result: self.result.reproducible(),
            machine: Machine::default(),
            ..self.clone()
        }
    }
}
