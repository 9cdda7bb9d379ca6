//! Exploration and inspection frontiers of voxel maps, clustered and kept up to date incrementally.
//!
//! Exploration frontiers are free cells next to unknown ones (or unknown next to free: [`Side`]), inspection frontiers are occupied cells next to free ones that
//! were not inspected (HEATS sect. IV-A, 6-neighbourhood). [`Frontiers`] keeps clusters of both as a map changes: only what a
//! changed box touches is looked at again, untouched clusters keep their ids, and the set of cells always equals that of a
//! search from scratch. Clusters below the minimum size are kept and marked [`small`](Cluster::small), never lost.
//!
//! [`Fringe`] keeps FLAP's frontiers, unknown cells next to free ones, with the cells on the faces of search volumes and the
//! normals that say from which side to look.
//!
//! ```
//! use frontier::{exploration, grid::Grid};
//!
//! // One row: free, free, never seen, wall.
//! let map = Grid::parse("..?#");
//! assert_eq!(exploration(&map), [[1, 0, 0]]);
//! ```

mod cluster;
pub mod conformance;
mod detect;
mod fringe;
pub mod grid;
mod kmeans;
mod layer;
mod map;
mod params;
mod split;
mod update;

pub use cluster::{Cluster, Kind};
pub use detect::{exploration, exploration_on, inspection};
pub use fringe::Fringe;
pub use map::Map;
pub use params::{Error, Params, Side, Split};
pub use update::{Frontiers, Update};

/// Index of a voxel.
pub type Cell = [i32; 3];

/// A half-open box of cells: first cell inside, first cell beyond on every axis.
pub type CellBox = (Cell, Cell);

/// The code of the README is tested.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
