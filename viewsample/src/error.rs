//! The caller's mistakes.

/// The caller's mistakes. "No view" is a result, not an error.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter is outside its range.
    #[error("{field} = {value} must be {range}")]
    Param {
        /// Name of the field of [`Params`](crate::Params).
        field: &'static str,
        /// The value given.
        value: f64,
        /// What it has to be.
        range: &'static str,
    },
    /// The robot reaches none of the views of [`Params::views`](crate::Params::views).
    #[error("the robot reaches none of the {0} views")]
    NoPosture(usize),
    /// The map's cell size is zero, negative or not finite.
    #[error("cell size {0} m must be positive and finite")]
    CellSize(f64),
    /// The centroid of a cluster is not finite.
    #[error("the centroid of cluster {id} is not finite: {centroid:?}")]
    Centroid {
        /// Identity of the cluster.
        id: u64,
        /// The value given, m.
        centroid: [f64; 3],
    },
    /// The current pose of the robot is not finite.
    #[error("the base pose is not finite: {0:?}")]
    Pose([f64; 3]),
    /// The boxes and frontier cells span more cells than the sampler stores.
    #[error("the map spans {0} cells, more than 2^31")]
    TooLarge(u64),
}
