//! FLAP's views: camera poses sampled around frontier cells, and the unknown cells that each would show.
//!
//! [`sample_poses`] draws poses that satisfy range, height, pitch and the frontier's normal by constraint propagation
//! over intervals; [`SightGrid::view`] casts a fan of rays through unknown space and lists the cells of interest it
//! meets; [`sample_views`] does both until a number of views is reached or its caller says stop.
//!
//! ```
//! use viewsample::flap::{Fan, FanPose, SightGrid};
//! use viewsample::grid::Grid;
//!
//! // A row of cells of 0.1 m seen from its end: five free, two unknown, a wall, one unknown behind it.
//! let map = Grid::parse(".....??#?", 1, 0.1);
//! let mut sight = SightGrid::new(&map, map.bounds(), |_| true);
//! let ahead = Fan::new(3.0, [0.0, 0.0], 0.02)?; // one ray
//! let pose = FanPose { position: [0.05, 0.05, 0.05], yaw: 0.0, pitch: 0.0 };
//! let shown: Vec<_> = sight.view(&ahead, &pose).to_vec().iter().map(|&i| sight.cell(i)).collect();
//! assert_eq!(shown, [[5, 0, 0], [6, 0, 0]]);
//! # Ok::<(), viewsample::Error>(())
//! ```

mod fan;
mod interval;
mod poses;
mod sight;
mod views;

pub use fan::{Fan, FanPose};
pub use poses::{Limits, Target, sample_from, sample_poses};
pub use sight::{CellState, Haze, SightGrid};
pub use views::{FanView, ViewParams, sample_views};
