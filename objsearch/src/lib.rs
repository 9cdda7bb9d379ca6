//! Object search plans that minimise the expected time to find a target.
//!
//! A robot may look from many views; each shows some cells of the volumes that may hold the target, and going from view
//! to view takes time. A planner orders views so that the expected time until the target is seen is small, after FLAP for
//! CAOS (Gedicke, Günther and Hertzberg, 2016).
//!
//! | planner | what it is |
//! | --- | --- |
//! | [`greedy`] | largest probability of new cells per second, again and again |
//! | [`branch_and_bound`] | FLAP's: depth-first, with depth limit psi, branch limit phi, dominance xi |
//! | [`deepen`], [`widen`] | FLAP's, with psi or phi growing until the budget is used up |
//! | [`local`] | iterated local search, anytime; never worse than greedy or FLAP's; the one to use |
//! | [`optimal`] | the optimum of up to [`EXACT_VIEWS`] views by dynamic programming |
//! | [`prove`] | proves a sequence optimal, or finds a better one, where the budget reaches |
//!
//! [`Belief`] says where the target may be, [`TravelTable`] what travel takes, [`search()`] runs the loop of planning, going
//! and looking.
//!
//! ```
//! use objsearch::{Budget, Goal, LocalParams, Task, Times, View, cell_weight, local};
//!
//! // Two volumes of 100 cells: the target is in the first with 20 %, in the second with 60 %.
//! let weights = [100.0 * cell_weight(0.2, 100)?, 100.0 * cell_weight(0.6, 100)?];
//! let times = Times::new(vec![10.0; 2], vec![10.0; 4])?;
//! let views = [View::new([0]), View::new([1])];
//! let task = Task::new(&weights, &views, &times, &Goal::default())?;
//! let found = local(&task, &LocalParams::default(), &[], &mut Budget::steps(10_000));
//! assert_eq!(found.sequence, [1, 0]); // the likely volume first
//! assert!((found.expected_time - (10.0 + 0.4 * 10.0)).abs() < 1e-9); // FLAP eq. 4
//! # Ok::<(), objsearch::Error>(())
//! ```
//!
//! # Cost
//!
//! [`optimal`] takes v² 2ᵛ steps for v views. The searches take what their [`Budget`] allows, in steps that look at the cells that one view
//! shows; a table of travel is v² numbers.
//!
//! # Limits
//!
//! One target that does not move and is seen for certain, or with a given probability, in views that show its cell. Views and travel times
//! are given; sampling and path planning are other crates' work.
//!
//! # Citation
//!
//! Please cite seekplan (`CITATION.cff` of the repository) and FLAP for CAOS (Gedicke, Günther and Hertzberg, IFAC IAV 2016).

mod belief;
mod bound;
mod branch;
mod budget;
mod cluster;
mod cost;
mod cover;
mod dominance;
mod error;
mod exact;
mod local;
mod memo;
mod moves;
mod order;
mod paths;
mod plan;
mod rng;
mod search;
mod task;
mod travel;

pub use belief::{Belief, Volume, cell_probability, cell_weight, probability_of};
pub use bound::lower_bound;
pub use branch::{BranchParams, branch_and_bound, deepen, greedy, prove, widen};
pub use budget::Budget;
pub use cluster::{Clusters, cluster};
pub use cost::{CostModel, Times};
pub use dominance::Dominance;
pub use error::Error;
pub use exact::{EXACT_VIEWS, optimal};
pub use local::{LocalParams, STEPS_PER_TENTH_SECOND, local};
pub use paths::{GridPaths, Paths};
pub use plan::{Plan, Status};
pub use search::{Ended, Look, Mode, Record, Step, Survey, World, search};
pub use task::{Evaluation, Goal, Task, View};
pub use travel::{FromState, Place, Regression, Speeds, TravelModel, TravelTable};

/// The code of the README is tested.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
