//! What is made to go wrong in a run, so that one can see what becomes of it. Nothing, by default.

use super::settings::SettingsError;
use serde::{Deserialize, Serialize};

/// The faults of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FaultSettings {
    /// Share of rays of LiDAR and depth camera whose range is drawn uniformly between the sensor's nearest and farthest.
    pub outliers: f64,
    /// A door that closes.
    pub door: Option<DoorFault>,
    /// A person who steps into the way.
    pub person: Option<PersonFault>,
    /// A sensor that delivers nothing.
    pub silence: Option<SilenceFault>,
    /// An error of localisation.
    pub localisation: Option<LocalisationFault>,
    /// A stage of planning that runs out of its budget.
    pub budget: Option<BudgetFault>,
}

/// A box that is there for a part of the run. If the robot could not stop before it when it is due, it waits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DoorFault {
    /// When it closes, s.
    pub time: f64,
    /// When it opens again, s; never when absent.
    pub until: Option<f64>,
    /// Centre, m.
    pub center: [f64; 3],
    /// Half the edges, m.
    pub half_extents: [f64; 3],
    /// Rotation about z, rad.
    #[serde(default)]
    pub yaw: f64,
}

/// A box of 0.5 x 0.5 x 1.7 m that appears on the way of the base. It waits for a place where it meets no solid and a robot at top
/// speed could still stop before it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PersonFault {
    /// When it appears, s.
    pub time: f64,
    /// When it is gone again, s; never when absent.
    pub until: Option<f64>,
    /// How far along the base path under way its middle is, m; straight on where the path ends before that, and straight ahead of
    /// a robot that stands.
    #[serde(default = "ahead")]
    pub ahead: f64,
}

fn ahead() -> f64 {
    2.0
}

/// A sensor that delivers nothing for a while.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SilenceFault {
    /// Which.
    #[serde(default)]
    pub sensor: SilentSensor,
    /// From when on, s.
    pub time: f64,
    /// For how long, s.
    #[serde(default = "ten")]
    pub seconds: f64,
}

fn ten() -> f64 {
    10.0
}

/// A sensor that can fall silent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SilentSensor {
    /// The LiDAR on the base.
    Lidar,
    /// The depth camera.
    Depth,
    /// The RGB camera.
    Rgb,
    /// All of them.
    #[default]
    All,
}

impl SilentSensor {
    /// Its name in settings.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lidar => "lidar",
            Self::Depth => "depth",
            Self::Rgb => "rgb",
            Self::All => "all",
        }
    }
}

/// The pose that mapping, planning and control believe wanders about the true one: a first-order Gauss-Markov process in x, y and
/// yaw. Collisions, tags and the way are judged with the true one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LocalisationFault {
    /// Standard deviation of x and of y, m.
    pub position: f64,
    /// Standard deviation of the yaw, degrees.
    pub heading: f64,
    /// Time over which an error keeps 1/e of itself, s.
    pub correlation: f64,
}

impl Default for LocalisationFault {
    fn default() -> Self {
        Self {
            position: 0.02,
            heading: 0.5,
            correlation: 10.0,
        }
    }
}

/// A stage that fails as if its budget had run out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BudgetFault {
    /// Which.
    pub stage: BudgetStage,
    /// From when on, s.
    pub time: f64,
    /// For how long, s.
    #[serde(default = "ten")]
    pub seconds: f64,
    /// Every how many-th call of it in that time fails; 1 is each.
    #[serde(default = "one")]
    pub every: u64,
}

fn one() -> u64 {
    1
}

/// A stage that can run out of its budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BudgetStage {
    /// Frontiers and view libraries.
    Frontier,
    /// Choice of the next view.
    Decision,
    /// Base path.
    BasePath,
    /// Arm path.
    ArmPath,
    /// Receding-horizon control.
    Control,
}

impl BudgetStage {
    /// Its name in settings.
    pub fn name(self) -> &'static str {
        match self {
            Self::Frontier => "frontier",
            Self::Decision => "decision",
            Self::BasePath => "base_path",
            Self::ArmPath => "arm_path",
            Self::Control => "control",
        }
    }
}

/// Refuses a value that is not as wanted.
fn check(
    ok: bool,
    field: &'static str,
    value: f64,
    wanted: &'static str,
) -> Result<(), SettingsError> {
    if ok {
        Ok(())
    } else {
        Err(SettingsError::Range {
            field,
            value,
            wanted,
        })
    }
}

fn not_negative(field: &'static str, value: f64) -> Result<(), SettingsError> {
    check(
        value >= 0.0 && value.is_finite(),
        field,
        value,
        "zero or more and finite",
    )
}

fn positive(field: &'static str, value: f64) -> Result<(), SettingsError> {
    check(
        value > 0.0 && value.is_finite(),
        field,
        value,
        "positive and finite",
    )
}

fn later(field: &'static str, until: Option<f64>, time: f64) -> Result<(), SettingsError> {
    match until {
        None => Ok(()),
        Some(until) => check(
            until > time && until.is_finite(),
            field,
            until,
            "finite and later than time",
        ),
    }
}

impl FaultSettings {
    /// True if nothing goes wrong.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Checks every range.
    ///
    /// # Errors
    /// [`SettingsError::Range`] for the first field outside its range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        check(
            (0.0..=1.0).contains(&self.outliers),
            "fault.outliers",
            self.outliers,
            "between 0 and 1",
        )?;
        if let Some(door) = &self.door {
            not_negative("fault.door.time", door.time)?;
            later("fault.door.until", door.until, door.time)?;
            for v in door.center {
                check(v.is_finite(), "fault.door.center", v, "finite")?;
            }
            for v in door.half_extents {
                positive("fault.door.half_extents", v)?;
            }
            check(door.yaw.is_finite(), "fault.door.yaw", door.yaw, "finite")?;
        }
        if let Some(person) = &self.person {
            not_negative("fault.person.time", person.time)?;
            later("fault.person.until", person.until, person.time)?;
            positive("fault.person.ahead", person.ahead)?;
        }
        if let Some(silence) = &self.silence {
            not_negative("fault.silence.time", silence.time)?;
            positive("fault.silence.seconds", silence.seconds)?;
        }
        if let Some(off) = &self.localisation {
            not_negative("fault.localisation.position", off.position)?;
            not_negative("fault.localisation.heading", off.heading)?;
            positive("fault.localisation.correlation", off.correlation)?;
        }
        if let Some(budget) = &self.budget {
            not_negative("fault.budget.time", budget.time)?;
            positive("fault.budget.seconds", budget.seconds)?;
            check(
                budget.every >= 1,
                "fault.budget.every",
                budget.every as f64,
                "1 or more",
            )?;
        }
        Ok(())
    }
}
