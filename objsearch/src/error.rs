//! What a caller can get wrong.

/// The caller's mistakes. A search that can see nothing is no mistake but a [`Status`](crate::Status).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A probability outside its interval.
    #[error("{what} = {value} must be {wanted}")]
    Probability {
        /// What the probability is of.
        what: &'static str,
        /// The value given.
        value: f64,
        /// The interval.
        wanted: &'static str,
    },
    /// A volume without cells.
    #[error(
        "volume {volume} from {low:?} to {high:?} holds no cell; each upper bound must be above the lower one"
    )]
    EmptyVolume {
        /// Index of the volume.
        volume: usize,
        /// First cell.
        low: [i32; 3],
        /// First cell beyond.
        high: [i32; 3],
    },
    /// A volume that reaches out of the map.
    #[error(
        "volume {volume} from {low:?} to {high:?} is not inside the map from {map_low:?} to {map_high:?}"
    )]
    OutsideMap {
        /// Index of the volume.
        volume: usize,
        /// First cell.
        low: [i32; 3],
        /// First cell beyond.
        high: [i32; 3],
        /// First cell of the map.
        map_low: [i32; 3],
        /// First cell beyond the map.
        map_high: [i32; 3],
    },
    /// No cells to share a probability among.
    #[error("a volume needs at least one cell")]
    NoCells,
    /// A cell weight that is negative or not finite.
    #[error("weight of cell {cell} is {value}, must be zero or more and finite")]
    Weight {
        /// Index of the cell.
        cell: usize,
        /// The value given.
        value: f64,
    },
    /// A view names a cell that does not exist.
    #[error("view {view} shows cell {cell}, but there are only {cells} cells")]
    Cell {
        /// Index of the view.
        view: usize,
        /// Index of the cell.
        cell: usize,
        /// Number of cells.
        cells: usize,
    },
    /// A travel time that is NaN, negative or zero. Infinite means unreachable and is allowed.
    #[error("time to view {to} is {value} s, must be positive (infinite when unreachable)")]
    Time {
        /// Index of the view driven to.
        to: usize,
        /// The value given, s.
        value: f64,
    },
    /// A table of times with the wrong number of entries.
    #[error("{what} holds {found} times, must hold {wanted}")]
    TableSize {
        /// Which table.
        what: &'static str,
        /// Entries given.
        found: usize,
        /// Entries needed.
        wanted: usize,
    },
    /// A table that was promised to be symmetric and is not.
    #[error(
        "time from view {from} to {to} is {there} s but back it is {back} s; the table was promised to be symmetric"
    )]
    Asymmetric {
        /// Index of one view.
        from: usize,
        /// Index of the other view.
        to: usize,
        /// Time one way, s.
        there: f64,
        /// Time the other way, s.
        back: f64,
    },
    /// More views than the exact planner can hold.
    #[error("{views} views are too many for the exact planner, at most {most}")]
    TooManyViews {
        /// Number of views given.
        views: usize,
        /// Largest number.
        most: usize,
    },
    /// A parameter outside its interval.
    #[error("{field} = {value} must be {wanted}")]
    Param {
        /// Name of the field.
        field: &'static str,
        /// The value given.
        value: f64,
        /// The interval.
        wanted: &'static str,
    },
}
