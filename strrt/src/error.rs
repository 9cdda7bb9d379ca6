//! The caller's mistakes.

/// What is wrong with an argument. "No path" is a result, not an error.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No step to plan over.
    #[error("steps = 0, at least one pose of the base is needed")]
    NoSteps,
    /// A time step that is zero, negative or not finite.
    #[error("dt = {0} s must be positive and finite")]
    TimeStep(f64),
    /// A joint limit with low above high, or not finite.
    #[error(
        "joint {joint} has limits {low} to {high} rad, low must be at most high and both finite"
    )]
    Limits {
        /// Index of the joint.
        joint: usize,
        /// Lower limit, rad.
        low: f64,
        /// Upper limit, rad.
        high: f64,
    },
    /// A joint speed that is zero, negative or not finite.
    #[error("joint {joint} has a top speed of {speed} rad/s, must be positive and finite")]
    Speed {
        /// Index of the joint.
        joint: usize,
        /// The speed given, rad/s.
        speed: f64,
    },
    /// A start or goal outside the joint limits, or not finite.
    #[error("{which} has joint {joint} at {angle} rad, must lie within {low} to {high} rad")]
    OutsideLimits {
        /// `start` or `goal`.
        which: &'static str,
        /// Index of the joint.
        joint: usize,
        /// The angle given, rad.
        angle: f64,
        /// Lower limit, rad.
        low: f64,
        /// Upper limit, rad.
        high: f64,
    },
    /// A parameter out of its range.
    #[error("{field} = {value} must be {needed}")]
    Param {
        /// Name of the field.
        field: &'static str,
        /// The value given.
        value: f64,
        /// What would be right.
        needed: &'static str,
    },
    /// A path given to [`smooth`](crate::smooth) that has no state, or one that is not finite.
    #[error("the path needs at least one state, all finite")]
    Path,
}
