//! The caller's mistakes.

/// What is wrong with an argument.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter that is zero, negative or not finite.
    #[error("{field} = {value} must be positive and finite")]
    Param {
        /// Name of the parameter.
        field: &'static str,
        /// The value given.
        value: f64,
    },
    /// A horizon without knots.
    #[error("a horizon needs at least one knot")]
    NoKnots,
    /// A start, guess or reference that is not finite.
    #[error("{what} is not finite at knot {knot}, entry {entry}")]
    NotFinite {
        /// What it is.
        what: &'static str,
        /// Knot of the horizon.
        knot: usize,
        /// Entry of the vector.
        entry: usize,
    },
    /// A reference or guess shorter than the horizon.
    #[error("{what} has {given} knots, the horizon needs {needed}")]
    TooShort {
        /// What it is.
        what: &'static str,
        /// Knots given.
        given: usize,
        /// Knots needed.
        needed: usize,
    },
    /// A matrix or vector of a size that does not fit the others.
    #[error("{what} of knot {knot} is {given:?}, rows by columns, and must be {needed:?}")]
    Shape {
        /// Which one.
        what: &'static str,
        /// Knot of the horizon.
        knot: usize,
        /// Rows and columns given.
        given: (usize, usize),
        /// Rows and columns needed.
        needed: (usize, usize),
    },
    /// A cost that has no minimum, or none that is unique.
    #[error("the cost has no minimum over the input of knot {knot}")]
    Indefinite {
        /// Knot of the horizon.
        knot: usize,
    },
    /// A robot of spheres that does not fit together.
    #[error("{what} ({index})")]
    Chain {
        /// What is wrong.
        what: &'static str,
        /// Which joint, sphere or size.
        index: usize,
    },
    /// A model whose Jacobian disagrees with finite differences.
    #[error("{what}, row {row}, column {column}: {given}, finite differences say {expected}")]
    Jacobian {
        /// Which derivative.
        what: &'static str,
        /// Row.
        row: usize,
        /// Column; inputs count on from the states.
        column: usize,
        /// The model's entry.
        given: f64,
        /// What central differences say.
        expected: f64,
    },
    /// A constraint group whose rows are not those of its values.
    #[error(
        "{group}: constraint {index} differs between rows and values, or is visited by one only"
    )]
    Visits {
        /// Name of the group.
        group: &'static str,
        /// Number of the constraint.
        index: usize,
    },
}

pub(crate) fn positive(field: &'static str, value: f64) -> Result<(), Error> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(Error::Param { field, value })
    }
}
