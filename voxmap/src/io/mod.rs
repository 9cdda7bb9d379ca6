//! Files in and out: bytes to maps and back. Nothing here opens a file; readers take bytes and survive any of them with a
//! typed error and memory in proportion to their number.

//!
//! | format | read | write |
//! | --- | --- | --- |
//! | OctoMap `.bt` and `.ot` | [`OcTree::read_bt`], [`OcTree::read_ot`] | [`OcTree::write_bt`], [`OcTree::write_ot`] |
//! | PLY and PCD clouds | [`read_ply`], [`read_pcd`] | [`write_ply`], [`write_pcd`] |
//! | nav2 PGM and YAML | [`read_pgm`], [`GridInfo::read`], [`GridInfo::cost_map`] | [`GridInfo::of`], [`write_pgm`], [`GridInfo::write`] |
//! | own snapshot | [`VoxelMap::load`](crate::VoxelMap::load) | [`VoxelMap::save`](crate::VoxelMap::save) |

mod bytes;
mod cloud;
mod error;
mod grid;
mod octree;
mod pcd;
mod ply;
mod saved;

pub use cloud::Cloud;
pub use error::Error;
pub use grid::{GridInfo, Pgm, read_pgm, write_pgm};
pub use octree::{OcLeaf, OcTree};
pub use pcd::{read_pcd, write_pcd};
pub use ply::{read_ply, write_ply};
