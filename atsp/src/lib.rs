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
//!
//! # Cost
//!
//! Up to [`Params::exact_nodes`] nodes by dynamic programming: n² 2ⁿ steps, at most 0.4 MB. Above, each kick of the local search looks at a
//! few segments; the assignment problem that starts it takes n³ steps at most. Memory is at most 64 n² bytes + 1 KiB n, and nothing is
//! allocated per kick.
//!
//! # Limits
//!
//! A matrix of costs has to fit: some thousand nodes. Above `exact_nodes` an order is the best found, with a proved lower bound beside it.
//! Closed tours over independent random costs of 100 nodes and more stand 2 to 4 % above the optimum for 100 ms.
//!
//! # Citation
//!
//! Please cite seekplan (`CITATION.cff` of the repository), and HEATS (Zhang et al., Algorithm 1) for [`two_level`].

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
