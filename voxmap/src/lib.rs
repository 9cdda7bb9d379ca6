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

mod ball;
mod cast;
mod changes;
mod costmap;
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
