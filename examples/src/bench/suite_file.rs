//! Suites as TOML files: which planners, scenes, sensors and seeds.

use crate::baselines::{Baseline, BaselineSettings};
use crate::heats::{Planner, Sensors, Settings};
use crate::scene::{Scene, SceneError};
use serde::Deserialize;
use std::collections::BTreeMap;

/// What is wrong with a suite.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SuiteError {
    /// The file could not be read.
    #[error("cannot read suite {path}: {message}")]
    Read {
        /// The file.
        path: String,
        /// Why.
        message: String,
    },
    /// No TOML, or a field that is unknown, missing or of a wrong type.
    #[error("suite: {0}")]
    Parse(String),
    /// No planner has this name.
    #[error("suite: {field} = {name:?}: no such planner; there are {names}")]
    Planner {
        /// The field.
        field: String,
        /// What it says.
        name: String,
        /// What exists.
        names: String,
    },
    /// A planner that has the camera alone was given more, or the sensors are unknown.
    #[error(
        "suite: {field} = {name:?}: sensors are both or camera, and camera alone for {camera_alone}"
    )]
    Sensors {
        /// The field.
        field: String,
        /// What it says.
        name: String,
        /// The planners that have the camera alone.
        camera_alone: String,
    },
    /// A scene cannot be opened.
    #[error("suite: {field}: {source}")]
    Scene {
        /// The field.
        field: String,
        /// Why.
        source: SceneError,
    },
    /// A list is empty, or seeds are zero in number.
    #[error("suite: {field} must name at least one {what}")]
    Empty {
        /// The field.
        field: &'static str,
        /// What it is a list of.
        what: &'static str,
    },
    /// Something is named twice.
    #[error("suite: {field} names {name:?} twice")]
    Twice {
        /// The field.
        field: &'static str,
        /// What.
        name: String,
    },
    /// A setting of a planner is wrong.
    #[error("suite: {field}: {message}")]
    Settings {
        /// The field.
        field: String,
        /// Why.
        message: String,
    },
}

/// Number of seeds from 1 on, or a list.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged)]
pub enum Seeds {
    /// 1 to this number.
    Count(u64),
    /// These.
    List(Vec<u64>),
}

/// A suite file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SuiteFile {
    /// Planners, each with its sensors behind a slash where not all of `sensors` are wanted: `heats/camera`. A name of one's own
    /// behind a colon, `heats-plus:straight`, is the planner with what [`set`](Self::set) says for that name.
    pub planners: Vec<String>,
    /// Embedded scenes or paths.
    pub scenes: Vec<String>,
    /// Sensors of planners that name none.
    #[serde(default)]
    pub sensors: Vec<String>,
    /// Seeds of each planner in each scene.
    pub seeds: Seeds,
    /// Simulated seconds after which a trial ends; the scene's limit when absent.
    #[serde(default)]
    pub time_limit: Option<f64>,
    /// Assignments for a planner, as for `--set`; those for a variant (`heats-plus:straight`) do not hold for the planner itself,
    /// nor the other way round.
    #[serde(default)]
    pub set: BTreeMap<String, Vec<String>>,
}

/// One planner with its sensors.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    /// Name in tables and file names.
    pub(super) name: String,
    pub(super) what: What,
}

/// Settings of a row, but for the seed.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum What {
    Heats(Box<Settings>),
    Baseline(Box<BaselineSettings>),
}

impl What {
    /// With a seed.
    pub(super) fn seeded(&self, seed: u64) -> Self {
        match self {
            Self::Heats(s) => Self::Heats(Box::new(Settings {
                seed,
                ..(**s).clone()
            })),
            Self::Baseline(s) => Self::Baseline(Box::new(BaselineSettings {
                seed,
                ..(**s).clone()
            })),
        }
    }

    pub(super) fn to_toml(&self) -> String {
        match self {
            Self::Heats(s) => s.to_toml(),
            Self::Baseline(s) => s.to_toml(),
        }
    }
}

/// A suite that is ready to run.
#[derive(Clone, Debug)]
pub(super) struct Resolved {
    pub(super) rows: Vec<Row>,
    pub(super) scenes: Vec<(String, Scene)>,
    pub(super) seeds: Vec<u64>,
}

impl SuiteFile {
    /// Reads a suite's text.
    ///
    /// # Errors
    /// [`SuiteError::Parse`] naming line and field.
    pub fn from_toml(text: &str) -> Result<Self, SuiteError> {
        toml::from_str(text).map_err(|e| SuiteError::Parse(e.to_string()))
    }

    /// Opens what the suite names and checks every field. `trials` stands in place of its number of seeds.
    pub(super) fn resolve(&self, trials: Option<usize>) -> Result<Resolved, SuiteError> {
        let empty = |field, what| Err(SuiteError::Empty { field, what });
        if self.planners.is_empty() {
            return empty("planners", "planner");
        }
        if self.scenes.is_empty() {
            return empty("scenes", "scene");
        }
        let seeds: Vec<u64> = match (trials, &self.seeds) {
            (Some(0), _) => return empty("--trials", "seed"),
            (Some(n), _) => (1..=n as u64).collect(),
            (None, Seeds::Count(n)) => (1..=*n).collect(),
            (None, Seeds::List(list)) => list.clone(),
        };
        if seeds.is_empty() {
            return empty("seeds", "seed");
        }
        if let Some(seed) = repeated(&seeds) {
            let name = seed.to_string();
            return Err(SuiteError::Twice {
                field: "seeds",
                name,
            });
        }
        let mut rows: Vec<Row> = Vec::new();
        for (k, planner) in self.planners.iter().enumerate() {
            rows.extend(self.rows(&format!("planners[{k}]"), planner)?);
        }
        for name in self.set.keys() {
            if !self.planners.iter().any(|p| bare(p) == name) {
                return Err(SuiteError::Settings {
                    field: format!("set.{name}"),
                    message: "no such planner in planners".into(),
                });
            }
        }
        let names: Vec<&str> = rows.iter().map(|r| r.name.as_str()).collect();
        if let Some(name) = repeated(&names) {
            let name = (*name).to_owned();
            return Err(SuiteError::Twice {
                field: "planners",
                name,
            });
        }
        let mut scenes = Vec::new();
        for (k, name) in self.scenes.iter().enumerate() {
            let scene = Scene::open(name).map_err(|source| SuiteError::Scene {
                field: format!("scenes[{k}] = {name:?}"),
                source,
            })?;
            let stem = std::path::Path::new(name).file_stem().unwrap_or_default();
            let plain = |c: char| {
                if c.is_ascii_alphanumeric() || c == '-' {
                    c
                } else {
                    '_'
                }
            };
            let short: String = stem.to_string_lossy().chars().map(plain).collect();
            scenes.push((short, scene));
        }
        let names: Vec<&String> = scenes.iter().map(|(n, _)| n).collect();
        if let Some(name) = repeated(&names) {
            let name = (*name).clone();
            return Err(SuiteError::Twice {
                field: "scenes",
                name,
            });
        }
        Ok(Resolved {
            rows,
            scenes,
            seeds,
        })
    }

    /// A planner with each of its sensors.
    fn rows(&self, field: &str, text: &str) -> Result<Vec<Row>, SuiteError> {
        let full = bare(text);
        let (name, variant) = full.split_once(':').map_or((full, ""), |(n, v)| (n, v));
        let sets = || {
            let own = self.set.get(full).into_iter().flatten();
            own.map(String::as_str)
        };
        let wrong = |message: String| SuiteError::Settings {
            field: format!("{field} = {full:?}"),
            message,
        };
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        if full.contains(':') && (variant.is_empty() || !variant.chars().all(plain)) {
            return Err(wrong(
                "what follows the colon must be of small letters, digits and hyphens".into(),
            ));
        }
        let row = full.replace(':', "-");
        let sensors_wrong = || SuiteError::Sensors {
            field: field.to_owned(),
            name: text.to_owned(),
            camera_alone: Baseline::ALL.map(Baseline::name).join(" and "),
        };
        let one = text.split_once('/').map(|(_, sensors)| sensors.to_owned());
        if let Some(planner) = Baseline::ALL.into_iter().find(|b| b.name() == name) {
            if one.is_some_and(|s| s != "camera") {
                return Err(sensors_wrong());
            }
            let mut settings = BaselineSettings::of(planner)
                .with(sets())
                .map_err(|e| wrong(e.to_string()))?;
            settings.planner = planner;
            settings.time_limit = self.time_limit.or(settings.time_limit);
            settings.validate().map_err(|e| wrong(e.to_string()))?;
            return Ok(vec![Row {
                name: row,
                what: What::Baseline(Box::new(settings)),
            }]);
        }
        let Some(planner) = Planner::ALL.into_iter().find(|p| p.name() == name) else {
            let heats = Planner::ALL.iter().map(|p| p.name());
            let names: Vec<&str> = heats
                .chain(Baseline::ALL.iter().map(|b| b.name()))
                .collect();
            return Err(SuiteError::Planner {
                field: field.to_owned(),
                name: name.to_owned(),
                names: names.join(", "),
            });
        };
        let all = match one {
            Some(one) => vec![one],
            None if self.sensors.is_empty() => vec!["both".to_owned()],
            None => self.sensors.clone(),
        };
        let mut rows = Vec::new();
        for sensors in all {
            let (kind, suffix) = match sensors.as_str() {
                "both" => (Sensors::Both, ""),
                "camera" => (Sensors::Camera, "-camera"),
                _ => return Err(sensors_wrong()),
            };
            let mut settings = Settings::of(planner)
                .and_then(|s| s.with(sets()))
                .map_err(|e| wrong(e.to_string()))?;
            settings.planner = planner;
            settings.sensors = kind;
            settings.time_limit = self.time_limit.or(settings.time_limit);
            settings.validate().map_err(|e| wrong(e.to_string()))?;
            rows.push(Row {
                name: format!("{row}{suffix}"),
                what: What::Heats(Box::new(settings)),
            });
        }
        Ok(rows)
    }
}

fn bare(planner: &str) -> &str {
    planner.split_once('/').map_or(planner, |(name, _)| name)
}

/// The first that comes twice.
fn repeated<T: Ord>(all: &[T]) -> Option<&T> {
    let mut seen = std::collections::BTreeSet::new();
    all.iter().find(|x| !seen.insert(*x))
}
