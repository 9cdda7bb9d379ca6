//! Space-time RRT* for arms whose base moves on a known schedule (HEATS sect. V-A).
//!
//! The base's poses are given at equal times; the arm has to go from one joint state at the first time to another at the last,
//! each joint within its speed, every whole-body state free, with the least sum of joint distances. [`plan`] searches the
//! product of joint space and time; where the arm needs longer than the base, it waits with the base standing. Where nothing
//! but the arm moves, time is left out of the search ([`Robot::is_static`]).
//!
//! ```
//! use strrt::{Params, Robot, Status, plan};
//!
//! // One joint that must stay below a bar: at steps 4 to 6 nothing above 0.2 rad is free.
//! struct UnderTheBar;
//! impl Robot<1> for UnderTheBar {
//!     fn limits(&self) -> [(f64, f64); 1] { [(-1.0, 1.0)] }
//!     fn max_speed(&self) -> [f64; 1] { [1.0] }
//!     fn is_valid(&self, q: &[f64; 1], step: usize) -> bool {
//!         !(4..=6).contains(&step) || q[0] < 0.2
//!     }
//! }
//! let found = plan(&UnderTheBar, [0.5], [0.5], 12, 0.1, &Params::default(), 1)?;
//! assert_eq!(found.status, Status::Solved);
//! assert!(found.path[5][0] < 0.2);
//! assert_eq!(found.path[11], [0.5]);
//! # Ok::<(), strrt::Error>(())
//! ```
//!
//! # Cost
//!
//! [`Robot::is_valid`] is most of the time; beside it a sample costs a look through the tree's nodes. Memory is one state for each node.
//!
//! # Limits
//!
//! The number of joints is fixed at compile time, and all joints are intervals (one that turns for ever has wide limits). `Infeasible` is
//! said only where start, goal, base or the wait that is needed rule a path out; elsewhere a search that finds none ends with its samples.
//!
//! # Citation
//!
//! Please cite seekplan (`CITATION.cff` of the repository) and HEATS (Zhang et al.), sect. V-A.

mod adapters;
mod error;
mod line;
mod plan;
mod planner;
mod polish;
mod rng;
mod robot;
mod search;
mod smooth;
mod still;
mod task;
mod tree;

pub use adapters::{FromBatchFn, FromFn, from_batch_fn, from_fn, motion_is_clear};
pub use error::Error;
pub use line::{steps_needed, steps_needed_from_rest, straight};
pub use plan::{Params, Plan, Reason, Status, Variant, plan};
pub use planner::Planner;
pub use robot::Robot;
pub use smooth::{peak_acceleration, smooth};

/// The code of the README is tested.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
