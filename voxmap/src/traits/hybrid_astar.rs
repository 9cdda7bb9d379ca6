//! `hybrid_astar::Map` for [`CostMap`]: ground that is not known free is an obstacle.

use crate::CostMap;
use hybrid_astar::Map;

impl Map for CostMap {
    fn clearance(&self, p: [f64; 2]) -> f64 {
        Self::clearance(self, p)
    }
    fn bounds(&self) -> ([f64; 2], [f64; 2]) {
        let (low, size) = (self.low(), self.size());
        (
            low,
            [0, 1].map(|a| low[a] + size[a] as f64 * self.cell_size()),
        )
    }
    fn revision(&self) -> u64 {
        Self::revision(self)
    }
}
