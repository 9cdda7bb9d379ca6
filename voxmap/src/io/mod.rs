//! Files in and out: bytes to maps and back. Nothing here opens a file; readers take bytes and survive any of them with a
//! typed error and memory in proportion to their number.

mod bytes;
mod error;
mod octree;

pub use error::Error;
pub use octree::{OcLeaf, OcTree};
