//! Settings of a FLAP search.

use objsearch::{BranchParams, Dominance, Mode, STEPS_PER_TENTH_SECOND};
use serde::{Deserialize, Serialize};

/// Which planner orders the views.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PlannerKind {
    /// Utility greedy.
    Greedy,
    /// FLAP's branch and bound.
    Flap,
    /// FLAP's with growing depth limit.
    IterPsi,
    /// FLAP's with growing branch limit.
    IterPhi,
    /// Iterated local search.
    #[default]
    Local,
}

impl PlannerKind {
    /// Its name on the command line and in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Greedy => "greedy",
            Self::Flap => "flap",
            Self::IterPsi => "iter_psi",
            Self::IterPhi => "iter_phi",
            Self::Local => "local",
        }
    }
}

/// What is known at the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MapKind {
    /// Everything but what lies in the volumes, and their occupied cells.
    #[default]
    Known,
    /// Walls and floor.
    Walls,
}

/// Where views come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ViewsKind {
    /// Sampled once at the start and evaluated anew in every cycle: the paper's experiments.
    #[default]
    Fixed,
    /// The views of the last plan are kept, the others sampled anew in every cycle: the paper's system.
    Fresh,
}

/// How travel times are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TravelKind {
    /// FLAP's regression over path costs.
    #[default]
    Flap,
    /// Speeds of base, torso and head.
    Speeds,
}

/// Settings of a search; defaults are the paper's, with our planner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FlapSettings {
    /// Seed of start and views.
    pub seed: u64,
    /// The planner.
    pub planner: PlannerKind,
    /// Plan once, not after every look.
    pub offline: bool,
    /// What is known at the start.
    pub map: MapKind,
    /// Where views come from.
    pub views: ViewsKind,
    /// Views sampled.
    pub samples: usize,
    /// Views sampled at the robot's place besides.
    pub local_samples: usize,
    /// Groups of close-by views for path searches (published: 50); 0 for one path search a view.
    pub clusters: usize,
    /// How travel times are computed.
    pub travel: TravelKind,
    /// Probability that may remain to be found at the end (omega).
    pub threshold: f64,
    /// Probability to notice a target in view.
    pub detection: f64,
    /// Depth limit (psi) of FLAP's planner.
    pub depth_limit: usize,
    /// Branch limit (phi) of FLAP's planner.
    pub branch_limit: f64,
    /// Pruning of dominated views (xi) in FLAP's planner.
    pub prune_dominated: bool,
    /// Budget of a plan, ms of one core of 2020's: it is counted in steps, so that runs can be repeated.
    pub budget_ms: f64,
    /// How unknown space in the volumes hides what lies behind it, 1/m: predictions are discounted by `exp(-haze l)` for l
    /// metres of it. 0 is the published prediction.
    pub haze: f64,
    /// The same for unknown space outside the volumes, 1/m.
    pub haze_elsewhere: f64,
    /// Most looks.
    pub look_limit: usize,
}

impl Default for FlapSettings {
    fn default() -> Self {
        Self {
            seed: 1,
            planner: PlannerKind::Local,
            offline: false,
            map: MapKind::Known,
            views: ViewsKind::Fixed,
            samples: 200,
            local_samples: 0,
            clusters: 0,
            travel: TravelKind::Flap,
            threshold: 0.05,
            detection: 1.0,
            depth_limit: 2,
            branch_limit: 1.3,
            prune_dominated: false,
            budget_ms: 100.0,
            haze: 0.0,
            haze_elsewhere: 0.0,
            look_limit: 200,
        }
    }
}

/// What is wrong with settings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// Not `key=value`.
    #[error("{0:?} is not of the form key=value")]
    Assignment(String),
    /// Not TOML, an unknown field, or a value of the wrong type.
    #[error("settings: {0}")]
    Parse(String),
    /// A number outside its range.
    #[error("{field} = {value} must be {wanted}")]
    Range {
        /// Name of the field.
        field: &'static str,
        /// The value given.
        value: f64,
        /// The range.
        wanted: &'static str,
    },
}

impl FlapSettings {
    /// Reads TOML; absent fields keep their defaults.
    ///
    /// # Errors
    /// [`SettingsError::Parse`] naming what is unknown or of the wrong type.
    pub fn from_toml(text: &str) -> Result<Self, SettingsError> {
        toml::from_str(text).map_err(|e| SettingsError::Parse(e.to_string()))
    }

    /// Writes TOML.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// Applies `field=value` assignments in order.
    ///
    /// # Errors
    /// [`SettingsError`] naming the assignment that is wrong.
    pub fn with<'a>(
        self,
        assignments: impl IntoIterator<Item = &'a str>,
    ) -> Result<Self, SettingsError> {
        let mut tree: toml::Table =
            toml::from_str(&self.to_toml()).map_err(|e| SettingsError::Parse(e.to_string()))?;
        for assignment in assignments {
            let (key, value) = assignment
                .split_once('=')
                .map(|(key, value)| (key.trim(), value.trim()))
                .ok_or_else(|| SettingsError::Assignment(assignment.to_owned()))?;
            // A bare word is a string, anything else is TOML; whole numbers stand for floats where the field is one.
            let value = toml::from_str::<toml::Table>(&format!("v = {value}"))
                .ok()
                .and_then(|mut table| table.remove("v"))
                .unwrap_or_else(|| toml::Value::String(value.to_owned()));
            let value = match (tree.get(key), value) {
                (Some(toml::Value::Float(_)), toml::Value::Integer(i)) => {
                    toml::Value::Float(i as f64)
                }
                (_, value) => value,
            };
            tree.insert(key.to_owned(), value);
        }
        let text = toml::to_string(&tree).map_err(|e| SettingsError::Parse(e.to_string()))?;
        Self::from_toml(&text)
    }

    /// Checks every range.
    ///
    /// # Errors
    /// [`SettingsError::Range`] of the first field that is wrong.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let check = |field, value: f64, good: bool, wanted| {
            if good {
                Ok(())
            } else {
                Err(SettingsError::Range {
                    field,
                    value,
                    wanted,
                })
            }
        };
        let t = self.threshold;
        check("threshold", t, t > 0.0 && t < 1.0, "above 0 and below 1")?;
        let q = self.detection;
        check("detection", q, q > 0.0 && q <= 1.0, "above 0 and at most 1")?;
        let phi = self.branch_limit;
        check("branch_limit", phi, phi >= 1.0, "1 or more")?;
        for (field, value) in [
            ("budget_ms", self.budget_ms),
            ("haze", self.haze),
            ("haze_elsewhere", self.haze_elsewhere),
        ] {
            let good = value >= 0.0 && value.is_finite();
            check(field, value, good, "zero or more and finite")?;
        }
        for (field, value, most) in [
            ("samples", self.samples, 5000),
            ("local_samples", self.local_samples, 5000),
            ("look_limit", self.look_limit, 100_000),
        ] {
            check(field, value as f64, value <= most, "a number within reason")?;
        }
        Ok(())
    }

    /// Limits of FLAP's planner.
    pub fn branch(&self) -> BranchParams {
        BranchParams {
            depth_limit: self.depth_limit,
            branch_limit: self.branch_limit,
            dominance: if self.prune_dominated {
                Dominance::Siblings
            } else {
                Dominance::Off
            },
            bound: false,
        }
    }

    /// Steps of a plan's budget.
    pub fn steps(&self) -> u64 {
        (self.budget_ms / 100.0 * STEPS_PER_TENTH_SECOND as f64) as u64
    }

    /// When plans are made.
    pub fn mode(&self) -> Mode {
        if self.offline {
            Mode::Offline
        } else {
            Mode::Continual
        }
    }
}
