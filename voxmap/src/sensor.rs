//! The sensor model: probabilities as the literature gives them, log-odds as the map stores them.

use crate::error::Error;

/// Log-odds of one unit of the stored byte.
pub(crate) const UNIT: f64 = 0.05;

/// Probabilities of the sensor model.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorModel {
    /// Occupancy of a cell that a ray ended in.
    pub hit: f64,
    /// Occupancy of a cell that rays only passed.
    pub miss: f64,
    /// Lower clamp.
    pub min: f64,
    /// Upper clamp.
    pub max: f64,
    /// A cell at or above it is occupied.
    pub occupied: f64,
}

impl Default for SensorModel {
    /// [`octomap`](Self::octomap).
    fn default() -> Self {
        Self::octomap()
    }
}

impl SensorModel {
    /// OctoMap's model: 0.7, 0.4, clamped to 0.1192..0.971, occupied from 0.5 on. UFOMap has the same.
    pub fn octomap() -> Self {
        Self {
            hit: 0.7,
            miss: 0.4,
            min: 0.1192,
            max: 0.971,
            occupied: 0.5,
        }
    }

    /// FUEL's launch files: 0.65, 0.35, clamped to 0.12..0.90, occupied from 0.80 on.
    pub fn fuel() -> Self {
        Self {
            hit: 0.65,
            miss: 0.35,
            min: 0.12,
            max: 0.90,
            occupied: 0.80,
        }
    }

    /// For scenes with moving things: OctoMap's gain, but an upper clamp of 0.8, so that what has gone is free again after
    /// three scans that look through it, and a lower one of 0.2, so that what has come is occupied after two.
    pub fn dynamic() -> Self {
        Self {
            hit: 0.7,
            miss: 0.35,
            min: 0.2,
            max: 0.80,
            occupied: 0.5,
        }
    }
}

/// The model in stored units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Odds {
    pub hit: i8,
    pub miss: i8,
    pub min: i8,
    pub max: i8,
    pub occupied: i8,
}

impl Odds {
    pub(crate) fn new(model: &SensorModel) -> Result<Self, Error> {
        let unit = |field, p: f64| {
            if p > 0.0 && p < 1.0 {
                Ok(((p / (1.0 - p)).ln() / UNIT).round().clamp(-127.0, 127.0) as i8)
            } else {
                Err(Error::Probability {
                    field,
                    value: p,
                    wanted: "above 0 and below 1",
                })
            }
        };
        let odds = Self {
            hit: unit("hit", model.hit)?,
            miss: unit("miss", model.miss)?,
            min: unit("min", model.min)?,
            max: unit("max", model.max)?,
            occupied: unit("occupied", model.occupied)?,
        };
        let check = |ok, field, value, wanted| {
            if ok {
                Ok(())
            } else {
                Err(Error::Probability {
                    field,
                    value,
                    wanted,
                })
            }
        };
        check(odds.hit > 0, "hit", model.hit, "clearly above 0.5")?;
        check(odds.miss < 0, "miss", model.miss, "clearly below 0.5")?;
        check(
            odds.min < odds.occupied,
            "min",
            model.min,
            "below `occupied`",
        )?;
        check(
            odds.max >= odds.occupied,
            "max",
            model.max,
            "at or above `occupied`",
        )?;
        Ok(odds)
    }
}
