//! Settings of the planner and of the timing.

use crate::Error;
use crate::error::{at_least, positive};

/// Speed and acceleration limits of the base.
///
/// `f64::INFINITY` for an acceleration means that speed may change at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest speed along x, m/s. HEATS table I: 0.8.
    pub v: f64,
    /// Largest turning rate, rad/s. HEATS table I: 1.5.
    pub w: f64,
    /// Largest acceleration, m/s^2.
    pub a: f64,
    /// Largest angular acceleration, rad/s^2.
    pub alpha: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            v: 0.8,
            w: 1.5,
            a: 0.8,
            alpha: 2.0,
        }
    }
}

impl Limits {
    /// Checks every field: speeds positive and finite, accelerations positive (infinity allowed).
    pub fn validate(&self) -> Result<(), Error> {
        positive("v", self.v)?;
        positive("w", self.w)?;
        for (field, value) in [("a", self.a), ("alpha", self.alpha)] {
            if value.is_nan() || value <= 0.0 {
                return Err(Error::Param {
                    field,
                    value,
                    must: "positive (infinity for no limit)",
                });
            }
        }
        Ok(())
    }

    /// Seconds lost by stopping once while driving and starting again.
    pub(crate) fn drive_stop(&self) -> f64 {
        self.v / self.a
    }

    /// Seconds lost by starting and ending one turn, for a turn that reaches full rate.
    pub(crate) fn turn_stop(&self) -> f64 {
        self.w / self.alpha
    }
}

/// Seconds of a rest-to-rest motion over `extent` at speed `v` and acceleration `a`: trapezoid or triangle.
pub(crate) fn rest_to_rest(extent: f64, v: f64, a: f64) -> f64 {
    if a.is_infinite() {
        extent / v
    } else if extent * a < v * v {
        2.0 * (extent / a).sqrt()
    } else {
        extent / v + v / a
    }
}

/// How the base moves.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Drive {
    /// Drives, reverses and turns in place.
    #[default]
    Differential,
    /// A car that can reverse: curves no tighter than `radius` m, no turns in place.
    ReedsShepp {
        /// Smallest radius of a curve, m.
        radius: f64,
    },
    /// A car that only drives forwards.
    Dubins {
        /// Smallest radius of a curve, m.
        radius: f64,
    },
}

impl Drive {
    /// Smallest radius of a curve, m; `None` if the base turns in place.
    pub fn radius(&self) -> Option<f64> {
        match self {
            Self::Differential => None,
            Self::ReedsShepp { radius } | Self::Dubins { radius } => Some(*radius),
        }
    }

    pub(crate) fn allows(&self, m: &crate::moves::Move) -> bool {
        use crate::Motion;
        let Some(radius) = self.radius() else {
            return true;
        };
        let backwards = m.motion == Motion::Reverse && matches!(self, Self::Dubins { .. });
        m.motion != Motion::Turn && !backwards && m.curvature.abs() * radius <= 1.0 + 1e-9
    }
}

/// Which headings will do at the goal.
#[derive(Clone, Debug, PartialEq, Default)]
pub enum GoalYaw {
    /// Any heading: HEATS ignores the goal yaw and lets the shoulder make up for it.
    #[default]
    Free,
    /// This heading, rad.
    Fixed(f64),
    /// The best of these headings, rad.
    Any(Vec<f64>),
    /// Headings no further than `tolerance` from `yaw`, rad.
    Within {
        /// Middle of the range, rad.
        yaw: f64,
        /// Half width of the range, rad.
        tolerance: f64,
    },
}

impl GoalYaw {
    pub(crate) fn validate(&self) -> Result<(), Error> {
        let check = |field, value: f64| at_least(field, value, f64::MIN, "finite");
        match self {
            Self::Free => Ok(()),
            Self::Fixed(yaw) => check("goal yaw", *yaw),
            Self::Any(list) if list.is_empty() => Err(Error::Param {
                field: "goal yaws",
                value: 0.0,
                must: "at least one heading",
            }),
            Self::Any(list) => list.iter().try_for_each(|&y| check("goal yaw", y)),
            Self::Within { yaw, tolerance } => {
                check("goal yaw", *yaw)?;
                at_least(
                    "goal yaw tolerance",
                    *tolerance,
                    0.0,
                    "finite and not negative",
                )
            }
        }
    }

    /// The allowed heading nearest to `yaw`.
    pub(crate) fn nearest(&self, yaw: f64) -> f64 {
        let toward = |to: f64| yaw + crate::moves::wrap(to - yaw);
        match self {
            Self::Free => yaw,
            Self::Fixed(to) => toward(*to),
            Self::Any(list) => {
                let mut best = f64::INFINITY;
                for &to in list {
                    let d = crate::moves::wrap(to - yaw);
                    if d.abs() < f64::abs(best) {
                        best = d;
                    }
                }
                yaw + best
            }
            Self::Within {
                yaw: middle,
                tolerance,
            } => {
                let d = crate::moves::wrap(yaw - middle);
                yaw + d.clamp(-tolerance, *tolerance) - d
            }
        }
    }

    /// The headings a curve that ends at the goal should try.
    pub(crate) fn targets(&self) -> Vec<f64> {
        match self {
            Self::Free => Vec::new(),
            Self::Fixed(yaw) => vec![*yaw],
            Self::Any(list) => list.clone(),
            Self::Within { yaw, tolerance } if *tolerance > 0.0 => {
                vec![*yaw, yaw - tolerance, yaw + tolerance]
            }
            Self::Within { yaw, .. } => vec![*yaw],
        }
    }
}

/// Settings of [`plan`](crate::plan).
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// Limits that give every motion its price in seconds.
    pub limits: Limits,
    /// What the base can do.
    pub drive: Drive,
    /// Side of a lattice cell, m.
    pub cell_size: f64,
    /// Number of headings of the lattice, 8 to 120.
    pub headings: usize,
    /// Room kept beside the footprint, m. At least half of `check_step`, so that nothing slips through between checks.
    pub margin: f64,
    /// Largest motion of any point of the footprint between two collision checks, m.
    pub check_step: f64,
    /// Price of driving backwards, as a factor on time.
    pub reverse_factor: f64,
    /// Longest stretch driven backwards in one go when a straight line to the goal is tried, m.
    pub reverse_reach: f64,
    /// Price of curves, as a factor on the heading change in seconds; keeps paths from weaving.
    pub turn_weight: f64,
    /// Price of passing close to an obstacle, as a share of time at the narrowest fit. 0 ignores clearance.
    pub clearance_weight: f64,
    /// Distance beyond the inscribed radius at which clearance stops to matter, m.
    pub comfort: f64,
    /// Factor on the distance to go; 1 searches widest, more finds a path sooner. It grows as a search goes on.
    pub greed: f64,
    /// How far the start may be in violation of radius + margin, m; leaving it must not make it worse.
    pub start_tolerance: f64,
    /// How far from the goal asked for the path may end if that is blocked, m.
    pub goal_tolerance: f64,
    /// Largest number of expanded nodes.
    pub max_expansions: usize,
    /// Whether the lattice path is shortened and rounded.
    pub smooth: bool,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            limits: Limits::default(),
            drive: Drive::Differential,
            cell_size: 0.1,
            headings: 36,
            margin: 0.02,
            check_step: 0.04,
            reverse_factor: 1.5,
            reverse_reach: 1.0,
            turn_weight: 0.03,
            clearance_weight: 0.3,
            comfort: 0.4,
            greed: 1.2,
            start_tolerance: 0.1,
            goal_tolerance: 0.0,
            max_expansions: 400_000,
            smooth: true,
        }
    }
}

impl Params {
    /// Checks every field once, so that the planner itself can assume good values.
    pub fn validate(&self) -> Result<(), Error> {
        self.limits.validate()?;
        if let Some(radius) = self.drive.radius() {
            positive("drive.radius", radius)?;
        }
        positive("cell_size", self.cell_size)?;
        positive("check_step", self.check_step)?;
        if !(8..=120).contains(&self.headings) {
            return Err(Error::Param {
                field: "headings",
                value: self.headings as f64,
                must: "from 8 to 120",
            });
        }
        let not_negative = "finite and not negative";
        at_least("margin", self.margin, 0.0, not_negative)?;
        at_least("reverse_reach", self.reverse_reach, 0.0, not_negative)?;
        at_least("turn_weight", self.turn_weight, 0.0, not_negative)?;
        at_least("clearance_weight", self.clearance_weight, 0.0, not_negative)?;
        at_least("start_tolerance", self.start_tolerance, 0.0, not_negative)?;
        at_least("goal_tolerance", self.goal_tolerance, 0.0, not_negative)?;
        at_least(
            "reverse_factor",
            self.reverse_factor,
            1.0,
            "finite and at least 1",
        )?;
        at_least("greed", self.greed, 1.0, "finite and at least 1")?;
        positive("comfort", self.comfort)
    }
}
