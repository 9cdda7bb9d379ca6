//! Log-odds voxel maps for robots: sensor integration, ray casts, distance fields, cost maps and regions.
//!
//! ```
//! use voxmap::{Config, Scan, SensorModel, State, VoxelMap};
//!
//! let mut map = VoxelMap::new(&Config {
//!     cell_size: 0.5,
//!     low: [0.0; 3],
//!     high: [4.0, 1.0, 1.0],
//!     sensor: SensorModel::default(),
//! })?;
//! // One ray along x that hits a wall at x = 2.6 m.
//! map.insert(&Scan { origin: [0.25, 0.25, 0.25], hits: &[[2.6, 0.25, 0.25]], ..Scan::default() })?;
//! assert_eq!(map.state([0, 0, 0]), State::Free);
//! assert_eq!(map.state([5, 0, 0]), State::Occupied);
//! assert_eq!(map.state([6, 0, 0]), State::Unknown);
//! # Ok::<(), voxmap::Error>(())
//! ```
//!
//! # Cost
//!
//! A scan takes one step for each cell on each of its rays, 16 rays at a time, and one update for each cell it touches. Casts, updates of the
//! distance field, the cost map and the lists of changes cost what they look at, not the map. Memory is a quarter of a byte for each cell of
//! the bounds, and in pages of 64 x 8 x 8 cells a byte more for each where something was observed, three quarters where a face was
//! inspected.
//!
//! # Limits
//!
//! Bit planes are dense over the bounds: at most 2^30 cells, so that a kilometre at 5 cm is out of reach. Log-odds have steps of 0.05.
//! Insertion uses one thread; planners read a [`Snapshot`] meanwhile.
//!
//! # Citation
//!
//! Please cite seekplan (`CITATION.cff` of the repository); the model is OctoMap's (Hornung, Wurm, Bennewitz, Stachniss and Burgard,
//! Autonomous Robots 34, 2013).

mod ball;
mod cast;
mod changes;
mod costmap;
mod depth;
mod edit;
mod error;
mod esdf;
mod geometry;
mod grow;
mod insert;
mod inspect;
pub mod io;
mod map;
mod regions;
mod rings;
mod sensor;
mod simd;
mod snapshot;
mod steps;
mod store;
mod traits;
mod walk;
mod wide;

pub use cast::Ray;
pub use changes::{ChangedWord, Changes};
pub use costmap::{CostMap, CostMapParams, Ground};
pub use depth::{DepthImage, DepthPoints};
pub use error::Error;
pub use esdf::{Esdf, EsdfParams};
pub use geometry::{Ball, Camera, Cell, CellBox, State};
pub use insert::{FanImage, GrazingGuard, Scan, ScanStats};
pub use map::{Config, Counts, VoxelMap};
pub use regions::{RegionParams, Regions};
pub use sensor::SensorModel;
pub use snapshot::Snapshot;
pub use walk::{Hit, UnknownPolicy};

/// The README's code, tested.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
