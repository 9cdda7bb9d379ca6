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
//!
//! # Cost
//!
//! An update looks at the cells of the changed boxes, 64 at a time where the map can, and at the clusters they touch; a first one looks at
//! the whole of [`Map::bounds`]. Memory is a few bits for each cell of the bounds and an owner for each frontier cell and its neighbours in
//! a word. K-means takes time in proportion to the cells.
//!
//! # Limits
//!
//! Cells are `i32` indices and bounds are finite: a map without bounds gives those of what it has seen. One thread.
//!
//! # Citation
//!
//! Please cite seekplan (`CITATION.cff` of the repository) and the paper whose frontiers you use: HEATS (Zhang et al.) or FLAP for CAOS
//! (Gedicke, Günther and Hertzberg, IFAC IAV 2016).

mod cluster;
pub mod conformance;
mod detect;
mod flood;
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
