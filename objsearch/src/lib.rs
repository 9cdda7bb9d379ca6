//! Object search plans that minimise the expected time to find a target.
//!
//! A robot may look from many views; each shows some cells of the volumes that may hold the target, and going from view
//! to view takes time. [`plan`] orders views so that the expected time until the target is seen is small, after FLAP for
//! CAOS: utility-greedy construction, refined by its depth-first branch and bound; [`optimal`] is exact for small sets.
//!
//! ```
//! use objsearch::{CostModel, Params, Task, View, cell_weight, plan};
//!
//! // Two volumes of 100 cells: the target is in the first with 20 %, in the second with 60 %.
//! let weights = [100.0 * cell_weight(0.2, 100)?, 100.0 * cell_weight(0.6, 100)?];
//! struct Seconds;
//! impl CostModel for Seconds {
//!     fn first(&self, _view: usize) -> f64 { 10.0 }
//!     fn between(&self, _from: usize, _to: usize) -> f64 { 10.0 }
//! }
//! let task = Task::new(&weights, &[View::new([0]), View::new([1])], &Seconds, 0.05)?;
//! let found = plan(&task, &Params::default());
//! assert_eq!(found.sequence, [1, 0]); // the likely volume first
//! assert!((found.expected_time - (10.0 + 0.4 * 10.0)).abs() < 1e-9); // FLAP eq. 4
//! # Ok::<(), objsearch::Error>(())
//! ```

mod belief;
mod exact;
mod search;
mod task;

pub use belief::{cell_probability, cell_weight, probability_of};
pub use exact::{EXACT_VIEWS, optimal};
pub use search::{Params, Plan, Status, greedy, plan};
pub use task::{CostModel, Evaluation, Task, View};

/// The caller's mistakes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A probability outside 0 (included) to 1 (excluded).
    #[error("{what} = {value} must be at least 0 and below 1")]
    Probability {
        /// What the probability is of.
        what: &'static str,
        /// The value given.
        value: f64,
    },
    /// A volume without cells.
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
    /// More views than the exact planner can hold.
    #[error("{views} views are too many for the exact planner, at most {most}")]
    TooManyViews {
        /// Number of views given.
        views: usize,
        /// Largest number.
        most: usize,
    },
}
