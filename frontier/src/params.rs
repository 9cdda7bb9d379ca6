//! Limits of clusters, in cells.

/// Which cells between free and unknown space are the exploration frontier.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// Free cells with an unknown neighbour (HEATS, FUEL): places where the robot could stand.
    #[default]
    Free,
    /// Unknown cells with a free neighbour (FLAP, ROG-Map): what remains to be seen.
    Unknown,
}

/// How a connected set of exploration frontier cells is cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Split {
    /// K-means (HEATS), seeded by farthest points.
    #[default]
    KMeans,
    /// Halving along the principal axis until no cell is farther than half the wanted extent from its part's mean (FUEL).
    PrincipalAxis,
}

/// Parameters of clustering. Lengths are in cells, so that this crate needs no cell size.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// Side of the exploration frontier.
    pub exploration_side: Side,
    /// How exploration clusters are cut.
    pub exploration_split: Split,
    /// Wanted cells of an exploration cluster: K of k-means is at least n over this.
    pub exploration_size: f64,
    /// Wanted extent of an exploration cluster: K is at least the longest side over this. HEATS: 2 m of 0.15 m cells.
    pub exploration_extent: f64,
    /// Exploration clusters with fewer cells are marked small.
    pub min_exploration: usize,
    /// Inspection clusters with fewer cells are marked small.
    pub min_inspection: usize,
    /// Cell range `[low, high)` along z of exploration frontiers.
    pub exploration_band: (i32, i32),
    /// Cell range `[low, high)` along z of inspection frontiers.
    pub inspection_band: (i32, i32),
    /// Largest deviation of a cell's normal from its cluster's mean normal in region growing, rad.
    pub normal_angle: f64,
    /// Inspection clusters with cells farther from their centroid are split along their principal axis.
    pub inspection_radius: f64,
    /// Rounds of k-means.
    pub kmeans_iterations: usize,
    /// A touched cluster that lost no more than this share of its cells since it was made, and gained no neighbour, shrinks in
    /// place and keeps its id; otherwise it is made anew.
    pub shrink_share: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            exploration_side: Side::Free,
            exploration_split: Split::KMeans,
            exploration_size: 60.0,
            exploration_extent: 2.0 / 0.15,
            min_exploration: 10,
            min_inspection: 3,
            exploration_band: (i32::MIN, i32::MAX),
            inspection_band: (i32::MIN, i32::MAX),
            normal_angle: 30f64.to_radians(),
            inspection_radius: 1.2 / 0.15,
            kmeans_iterations: 10,
            shrink_share: 0.5,
        }
    }
}

/// The caller's mistakes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter that is zero, negative or not finite.
    #[error("{field} = {value} must be positive and finite")]
    Param {
        /// Name of the field.
        field: &'static str,
        /// The value given.
        value: f64,
    },
    /// A share outside 0..1.
    #[error("{field} = {value} must be between 0 and 1")]
    Share {
        /// Name of the field.
        field: &'static str,
        /// The value given.
        value: f64,
    },
    /// A band without cells.
    #[error("{field} = {low}..{high} must not be empty")]
    Band {
        /// Name of the field.
        field: &'static str,
        /// First cell.
        low: i32,
        /// First cell beyond.
        high: i32,
    },
}

impl Params {
    /// Checks every field.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn validate(&self) -> Result<(), Error> {
        let positive = |field, value: f64| {
            if value > 0.0 && value.is_finite() {
                Ok(())
            } else {
                Err(Error::Param { field, value })
            }
        };
        positive("exploration_size", self.exploration_size)?;
        positive("exploration_extent", self.exploration_extent)?;
        positive("normal_angle", self.normal_angle)?;
        positive("inspection_radius", self.inspection_radius)?;
        if !(0.0..=1.0).contains(&self.shrink_share) {
            return Err(Error::Share {
                field: "shrink_share",
                value: self.shrink_share,
            });
        }
        for (field, (low, high)) in [
            ("exploration_band", self.exploration_band),
            ("inspection_band", self.inspection_band),
        ] {
            if low >= high {
                return Err(Error::Band { field, low, high });
            }
        }
        Ok(())
    }
}
