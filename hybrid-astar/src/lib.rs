//! Base paths for robots that drive, reverse and turn in place.
//!
//! [`plan`] searches a lattice of positions and headings (hybrid A*: every node keeps its exact pose), guided by a
//! grid wave from the goal, tries direct curves to the goal on the way, and shortens the result on its *timed* price:
//! seconds, stops and closeness to obstacles. The goal heading may be fixed, free, one of several or a range
//! ([`GoalYaw`]). [`Plan::time`] makes equal-time poses with a trapezoid profile. [`Field`] answers one-to-all
//! distances for tours. All you need is a map that knows clearances ([`Map`]) and a footprint ([`Robot`]).
//!
//! ```
//! use hybrid_astar::{Footprint, GoalYaw, Limits, Motion, Params, grid::Grid, plan};
//! // A room 6 m by 4 m with a wall that leaves a gap of 1.5 m on the right; one character is 0.5 m.
//! let map = Grid::parse(
//!     "............\n............\n............\n............\n#########...\n............\n............\n............",
//!     0.5,
//! );
//! let robot = Footprint::rectangle(0.75, 0.55, 3);
//! let path = plan(&map, &robot, [1.0, 0.8, 0.0], [1.0, 3.0], &GoalYaw::Free, &Params::default())?;
//! // Through the gap and back: further than the 2.2 m as the crow flies.
//! assert!(path.is_solved() && path.length > 7.0 && path.length < 11.0);
//! let timed = path.time(&Limits::default(), 0.1)?;
//! assert_eq!(timed.poses[0], [1.0, 0.8, 0.0]);
//! assert!(timed.v.iter().all(|v| v.abs() <= 0.8));
//! assert_eq!(timed.motions[0], Motion::Forward);
//! # Ok::<(), hybrid_astar::Error>(())
//! ```
//!
//! # Cost
//!
//! A query makes one wave over the grid's cells and expands at most [`Params::max_expansions`] nodes, each with some dozen clearance
//! queries; memory is a few numbers for each cell and each node.
//!
//! # Limits
//!
//! Flat ground and a footprint of circles. A passage that is a centimetre or two too narrow may be neither refused by proof nor found: then
//! the search ends with its budget and names the place.
//!
//! # Citation
//!
//! Please cite seekplan (`CITATION.cff` of the repository) and Dolgov, Thrun, Montemerlo and Diebel, Path Planning for Autonomous Vehicles
//! in Unknown Semi-structured Environments (IJRR 29, 2010), whose search this is.

mod body;
pub mod conformance;
mod error;
mod field;
pub mod grid;
mod headings;
mod moves;
mod outline;
mod outlook;
mod params;
mod plan;
mod planner;
mod price;
mod raster;
mod reeds_shepp;
mod search;
mod shot;
mod smooth;
mod stamps;
mod steer;
mod table;
mod time;
mod trace;
mod traits;
mod wave;

pub use error::Error;
pub use field::{Field, GridParams, Neighbours, Space};
pub use moves::Motion;
pub use params::{Drive, GoalYaw, Limits, Params};
pub use plan::{Plan, Reason, Status};
pub use planner::{Planner, plan};
pub use time::TimedPath;
pub use trace::Segment;
pub use traits::{Footprint, Map, Robot};

/// The code of the README is tested.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
