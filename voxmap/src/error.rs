//! The caller's mistakes.

/// What is wrong with an argument.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A length that is zero, negative or not finite.
    #[error("{field} = {value} must be positive and finite")]
    Length {
        /// Name of the parameter.
        field: &'static str,
        /// The value given.
        value: f64,
    },
    /// A probability outside its range.
    #[error("{field} = {value} must be {wanted}")]
    Probability {
        /// Name of the parameter.
        field: &'static str,
        /// The value given.
        value: f64,
        /// What would be right.
        wanted: &'static str,
    },
    /// Bounds that are not finite or hold no cell.
    #[error("bounds {low:?} to {high:?} m must be finite, with low below high on every axis")]
    Bounds {
        /// Lower corner, m.
        low: [f64; 3],
        /// Upper corner, m.
        high: [f64; 3],
    },
    /// More cells than the map can address.
    #[error("{cells} cells are too many, at most {most}; use larger cells or smaller bounds")]
    TooLarge {
        /// Cells asked for.
        cells: f64,
        /// Largest number.
        most: usize,
    },
    /// A bounded map was asked to grow or to be cropped.
    #[error("the bounds {bounds:?} of this map are fixed; VoxelMap::growing makes one that grows")]
    Fixed {
        /// The map's bounds.
        bounds: crate::CellBox,
    },
    /// Another number of ground cells than the size says.
    #[error(
        "{given} cells given for a map of {size:?}, must be as many as the product, and at least one"
    )]
    Cells {
        /// Number of cells given.
        given: usize,
        /// Cells along x and y.
        size: [usize; 2],
    },
    /// An image whose pixels do not fill its rows.
    #[error("{pixels} pixels are no whole rows of width = {width}")]
    Image {
        /// Pixels given.
        pixels: usize,
        /// Pixels of a row.
        width: usize,
    },
    /// A position that is not finite.
    #[error("{field} = {value:?} must be finite")]
    Position {
        /// Name of the argument.
        field: &'static str,
        /// The value given, m.
        value: [f64; 3],
    },
}
