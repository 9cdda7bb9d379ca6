//! Viewpoint generation and scoring for robots that carry a camera through unknown rooms.
//!
//! A frontier cluster wants to be looked at: from where, with which posture, and is it worth the
//! way? This crate answers as HEATS does (section IV-B):
//!
//! - [`postures`]: the camera attitudes a robot can hold, solved once by inverse kinematics;
//! - [`Sampler`]: for each cluster a library of base poses on rings around its centroid times the
//!   postures, and from each library the view that maximises `G = exp(-lambda t) G_info` (eq. 1-4);
//! - [`Sampler::gain_at`]: what any view would see now.
//!
//! The map, the robot and the cost of motion are yours: the traits [`Map`], [`Robot`] and
//! [`CostModel`] over plain arrays. [`conformance`] tests their laws. Units are m, s and rad.
//!
//! ```
//! use viewsample::grid::{Grid, Mast};
//! use viewsample::{Changes, Cluster, Frustum, Kind, Params, Sampler, Straight, postures};
//!
//! // A room of 6 m x 3 m; what is behind the opening in the east was never seen.
//! let map = Grid::parse(&format!("{0}\n{1}{0}", "#".repeat(22),
//!     format!("#{}??\n", ".".repeat(19)).repeat(8)), 8, 0.3);
//! let robot = Mast { map: &map, radius: 0.3, height: 0.4, lift: (0.4, 1.5) };
//! // A short-sighted robot: no LiDAR, a depth camera of 3 m.
//! let params = Params { lidar: None, depth: Frustum::degrees(87.0, 58.0, 0.3, 3.0), ahead: vec![0.1],
//!     ..Params::default() };
//! let mut sampler = Sampler::new(&params, postures(&robot, &params)?)?;
//!
//! // One cluster: the free cells next to the unknown.
//! let cells = map.exploration();
//! assert_eq!(cells.len(), 8 * 8);
//! let opening = Cluster { id: 7, kind: Kind::Exploration, cells: &cells, centroid: [5.85, 1.5, 1.2] };
//! sampler.update(&map, &Changes { added: &[opening], boxes: &[map.bounds()], ..Changes::default() })?;
//!
//! // The robot stands in the west and drives 0.8 m/s; its mast moves at 0.5 m/s and 0.8 rad/s.
//! let costs = Straight { base_speed: 0.8, joint_speed: [0.5, 0.8] };
//! let found = sampler.candidates(&robot, &costs, [1.0, 1.5, 0.0], &[1.0, 0.0])?;
//! let view = &found.views[0];
//! assert_eq!(view.cluster, Some(7));
//! assert!(view.base[0] < 5.0 && view.base[2].abs() < 1.6, "it stands west of the opening and looks east");
//! assert!(view.gain.exploration > 20 && view.own == view.gain.exploration);
//! assert_eq!(view.gain, sampler.gain_at(view.base, &view.camera)?);
//! # Ok::<(), viewsample::Error>(())
//! ```
//!
//! FLAP's views, sampled around frontier cells and evaluated by a fan of rays through unknown space, are in [`flap`].
//!
//! # How it is fast
//!
//! The sampler keeps the map as one bit a cell in words along z. One walk through the plane serves all
//! frontier cells of a column, and a run of cells in z is tested with one mask. Candidates wait in a queue
//! under an upper bound of their score, and only those are cast that could be best. What was cast is
//! kept until the map or a frontier changes inside the box around the view. LiDAR counts may lag a few updates behind
//! ([`Params::lidar_patience`]) and are shared by neighbouring positions ([`Params::lidar_grid`]); with 0 for both,
//! everything equals the definition, which the tests check.
//!
//! # Cost
//!
//! An update costs what lies near the change: what was cast is kept until something changes in the box around the view. A decision casts
//! only candidates that could be best, with rays to the frontier cells in reach.
//!
//! # Limits
//!
//! Views lie on rings of fixed radii with a fixed set of postures, and aimed ones where a face asks for it: where neither fits,
//! [`Sampler::candidates`] says why and [`Sampler::retry`] tries wider ones.
//!
//! # Citation
//!
//! Please cite seekplan (`CITATION.cff` of the repository) and HEATS (Zhang et al.), or FLAP for CAOS (Gedicke, Günther and Hertzberg,
//! IFAC IAV 2016) for [`flap`].

mod aim;
pub mod conformance;
mod cover;
mod dirty;
mod error;
pub mod flap;
mod gain;
mod geometry;
pub mod grid;
mod library;
mod map;
mod params;
mod posture;
mod reach;
mod rng;
mod robot;
mod sampler;
mod sight;
mod tiles;
mod totals;
mod tour;
mod view;
mod world;

pub use aim::Aim;
pub use error::Error;
pub use gain::{Gain, Seen};
pub use geometry::{Frustum, Lidar, Pose};
pub use map::{Cell, Map};
pub use params::{Params, Relaxed, View};
pub use posture::{Posture, postures};
pub use reach::InverseReach;
pub use robot::{CostModel, Robot, Straight};
pub use sampler::Sampler;
pub use view::{Candidates, Changes, Cluster, Effort, Kind, NoView, Viewpoint};

/// The README's example is tested too.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
