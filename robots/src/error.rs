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
}
