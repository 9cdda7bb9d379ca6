//! The caller's mistakes.

/// A bad argument. "No path" is not here: it is a [`Status`](crate::Status) of the plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter is out of its range or not finite.
    #[error("{field} = {value} must be {must}")]
    Param {
        /// Name of the field.
        field: &'static str,
        /// The value given.
        value: f64,
        /// What would be right.
        must: &'static str,
    },
    /// A pose or point has a coordinate that is not finite.
    #[error("{what} ({x}, {y}) is not finite")]
    NotFinite {
        /// Which argument.
        what: &'static str,
        /// Its x, m.
        x: f64,
        /// Its y, m.
        y: f64,
    },
    /// The map is empty, not finite, or too large for the cell size.
    #[error("map bounds ({:.3}, {:.3}) to ({:.3}, {:.3}) at {cell_size} m per cell: {must}", low[0], low[1], high[0], high[1])]
    Bounds {
        /// Lower corner, m.
        low: [f64; 2],
        /// Upper corner, m.
        high: [f64; 2],
        /// Side of a grid cell, m.
        cell_size: f64,
        /// What would be right.
        must: &'static str,
    },
    /// The robot has neither a circle nor an outline, or one of no size.
    #[error("footprint: {0}")]
    Footprint(&'static str),
}

pub(crate) fn positive(field: &'static str, value: f64) -> Result<(), Error> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(Error::Param {
            field,
            value,
            must: "positive and finite",
        })
    }
}

pub(crate) fn at_least(
    field: &'static str,
    value: f64,
    low: f64,
    must: &'static str,
) -> Result<(), Error> {
    if value >= low && value.is_finite() {
        Ok(())
    } else {
        Err(Error::Param { field, value, must })
    }
}

pub(crate) fn finite(what: &'static str, p: &[f64]) -> Result<(), Error> {
    if p.iter().all(|v| v.is_finite()) {
        Ok(())
    } else {
        Err(Error::NotFinite {
            what,
            x: p[0],
            y: p[1],
        })
    }
}
