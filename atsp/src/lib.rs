//! Asymmetric travelling-salesman tours and paths in milliseconds, and the two-level decision of HEATS.
//!
//! A robot re-orders its viewpoints several times a second: a few to a few hundred nodes, asymmetric costs in seconds,
//! the start fixed (the robot), the end fixed (the door to the next region) or free. [`solve`] orders them: optimal and
//! proved for small sets, a seeded iterated local search above. Costs are `f64` and used as they are, never rounded;
//! an infinite cost is a forbidden arc and is never part of a returned order.
//!
//! ```
//! use atsp::{CostMatrix, Params, Problem, solve};
//!
//! // Three views beside a corridor; node 0 is the robot. Driving back costs more than driving on.
//! let costs = CostMatrix::from_rows(&[
//!     [0.0, 1.0, 2.0, 3.0],
//!     [9.0, 0.0, 1.0, 2.0],
//!     [9.0, 4.0, 0.0, 1.0],
//!     [9.0, 5.0, 4.0, 0.0],
//! ])?;
//! let tour = solve(&costs, Problem::Open { start: 0 }, &Params::default())?;
//! assert_eq!(tour.order, [0, 1, 2, 3]);
//! assert_eq!(tour.cost, 3.0);
//! assert!(tour.optimal);
//! # Ok::<(), atsp::Error>(())
//! ```

mod arborescence;
mod ascent;
mod assignment;
mod branch;
mod candidates;
mod closed;
mod cost;
mod error;
mod exact;
mod pace;
mod problem;
mod rng;
mod search;
mod solver;
mod start;
mod tour;
#[cfg(feature = "tsplib")]
pub mod tsplib;
mod two_level;

pub use cost::{CostMatrix, CostModel, FromFn};
pub use error::Error;
pub use problem::{Params, Problem, Proof, Solution, Watch};
pub use solver::{Solver, solve, solve_from};
pub use two_level::{Choice, Decision, Place, two_level, two_level_from};

/// The code of the README is tested.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
