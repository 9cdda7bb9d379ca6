//! Read-only copies for a planner's thread.

use crate::map::VoxelMap;
use std::ops::Deref;
use std::sync::Arc;

/// A map as it was at one moment. Reads like the map it was taken from, in any number of threads; clones are free.
#[derive(Clone, Debug)]
pub struct Snapshot(Arc<VoxelMap>);

impl Deref for Snapshot {
    type Target = VoxelMap;
    fn deref(&self) -> &VoxelMap {
        &self.0
    }
}

impl VoxelMap {
    /// A read-only copy: copies the bit planes (a quarter of a byte a cell) and shares the pages of log-odds and inspected
    /// faces until the map writes to them. Changes not yet taken stay with the map.
    pub fn snapshot(&self) -> Snapshot {
        let copy = Self {
            free: self.free.clone(),
            occupied: self.occupied.clone(),
            log: self.log.clone(),
            seen: self.seen.clone(),
            blocks: self.blocks.clone(),
            dirty: crate::changes::Dirty::new(self.free.len()),
            scan: crate::insert::Window::default(),
            ..*self
        };
        Snapshot(Arc::new(copy))
    }
}
