//! Does a ball touch the map? Exact for cubes, one row of cells at a time.

use crate::map::VoxelMap;

impl VoxelMap {
    /// True if the ball touches no occupied cell's cube, nor an unknown one if `unknown_blocks`. Exact for cubes; touching
    /// from outside at a point is no touch. Space outside the map counts as unknown, except below and above it, where it
    /// counts as free: floor and ceiling are the caller's. Never free for numbers that are not finite.
    pub fn ball_is_free(&self, center: [f64; 3], radius: f64, unknown_blocks: bool) -> bool {
        let c = self.scaled(center);
        let r = radius / self.cell_size;
        if !(r >= 0.0 && r.is_finite() && c.iter().all(|v| v.is_finite())) {
            return false;
        }
        let size = self.size.map(|n| n as f64);
        let beyond = |a: usize| c[a] - r < 0.0 || c[a] + r > size[a];
        // A ball over the side of the map touches unknown space beside some layer, unless it is all below or above.
        if unknown_blocks && (beyond(0) || beyond(1)) && c[2] + r > 0.0 && c[2] - r < size[2] {
            return self.outside_is_clear(c, r) && self.rows_are_free(c, r, true);
        }
        self.rows_are_free(c, r, unknown_blocks)
    }

    /// True if the ball does not touch the space beside the map, between its lowest and highest layer.
    fn outside_is_clear(&self, c: [f64; 3], r: f64) -> bool {
        let size = self.size.map(|n| n as f64);
        let above = (-c[2]).max(c[2] - size[2]).max(0.0);
        // Half-width of the ball where it is widest within those layers.
        let width = (r * r - above * above).max(0.0).sqrt();
        (0..2).all(|a| c[a] - width >= 0.0 && c[a] + width <= size[a])
    }

    /// The cells inside the map; cell units.
    fn rows_are_free(&self, c: [f64; 3], r: f64, unknown_blocks: bool) -> bool {
        let rows = |a: usize| {
            let first = (c[a] - r).floor().max(0.0) as usize;
            let end = (c[a] + r).floor() + 1.0;
            first..(end.max(0.0) as usize).min(self.size[a])
        };
        let gap = |a: usize, row: usize| (row as f64 - c[a]).max(c[a] - row as f64 - 1.0).max(0.0);
        for z in rows(2) {
            let left = r * r - gap(2, z).powi(2);
            for y in rows(1) {
                let left = left - gap(1, y).powi(2);
                if left <= 0.0 {
                    continue;
                }
                // Cells with near side before c + width and far side behind c - width.
                let width = left.sqrt();
                let first = (c[0] - width).floor().max(0.0) as usize;
                let end = ((c[0] + width).ceil().max(0.0) as usize).min(self.size[0]);
                if first < end && self.row_blocks(y, z, first, end, unknown_blocks) {
                    return false;
                }
            }
        }
        true
    }

    /// True if a cell `first..end` of a row is occupied, or unknown if that blocks.
    #[inline]
    fn row_blocks(&self, y: usize, z: usize, first: usize, end: usize, unknown: bool) -> bool {
        let plane = if unknown { &self.free } else { &self.occupied };
        let flip = if unknown { u64::MAX } else { 0 };
        let row = self.word(0, y, z);
        (first / 64..=(end - 1) / 64).any(|w| {
            let mut bits = plane[row + w] ^ flip;
            if w == first / 64 {
                bits &= u64::MAX << (first % 64);
            }
            if w == (end - 1) / 64 {
                bits &= u64::MAX >> (63 - (end - 1) % 64);
            }
            bits != 0
        })
    }
}
