//! The caller's mistakes.

/// The caller's mistakes. "Out of reach" is a result, not an error.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A number of the input is NaN or infinite.
    #[error("{field} holds a number that is not finite")]
    NotFinite {
        /// Name of the argument.
        field: &'static str,
    },
    /// The list of views is empty.
    #[error("the list of views is empty; give at least one")]
    NoViews,
    /// No posture shows the wanted view.
    #[error(
        "no posture without self-collision looks {pitch_degrees:.1} deg up from a height of {height:.2} m"
    )]
    NoPosture {
        /// Height of the camera asked for, m.
        height: f64,
        /// Elevation asked for, degrees.
        pitch_degrees: f64,
    },
    /// A joint vector of the wrong length.
    #[error("{given} joint positions given, the arm has {needed}")]
    Joints {
        /// Length given.
        given: usize,
        /// Joints of the arm.
        needed: usize,
    },
    /// A joint position to start from is outside the joint's limits.
    #[error(
        "joint {joint} (counted from 0) is {amount} rad or m outside its limits; start inside them"
    )]
    OutsideLimits {
        /// Which joint, from 0.
        joint: usize,
        /// How far outside, rad or m.
        amount: f64,
    },
    /// A setting is zero, negative or not finite.
    #[error("{field} = {value} must be positive and finite")]
    Param {
        /// Name of the field.
        field: &'static str,
        /// The value given.
        value: f64,
    },
    /// A chain, or the files that describe it, make no sense.
    #[error("{what}")]
    Chain {
        /// What is wrong and what would be right.
        what: String,
    },
}
