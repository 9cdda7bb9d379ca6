//! The end of a scan: marks become log-odds, once per cell, 64 cells at a time.

use super::Window;
use crate::map::VoxelMap;

impl VoxelMap {
    /// Adds up the marks of a scan and clears them. Returns the number of cells updated.
    pub(super) fn apply(&mut self, window: &mut Window) -> usize {
        let mut updated = 0;
        let [(y0, y1), (z0, z1)] = std::mem::replace(&mut window.rows, [(usize::MAX, 0); 2]);
        for z in z0..z1 {
            for word in self.word(0, y0, z)..self.word(0, y1, z) {
                if window.passed[word] | window.hit[word] != 0 {
                    let skip = window.skip.get(word).map_or(0, |s| *s);
                    let hit = std::mem::take(&mut window.hit[word]) & !skip;
                    let passed = std::mem::take(&mut window.passed[word]) & !skip;
                    updated += self.apply_word(word, hit, passed & !hit);
                    if let Some(end) = window.end.get_mut(word) {
                        *end = 0;
                    }
                }
            }
        }
        updated
    }

    fn apply_word(&mut self, word: usize, hit: u64, miss: u64) -> usize {
        let odds = self.odds;
        let touched = hit | miss;
        let mut above = 0u64;
        for (mut bits, delta) in [(hit, odds.hit), (miss, odds.miss)] {
            while bits != 0 {
                let x = bits.trailing_zeros();
                bits &= bits - 1;
                let log = &mut self.log[word * 64 + x as usize];
                *log = log.saturating_add(delta).clamp(odds.min, odds.max);
                above |= u64::from(*log >= odds.occupied) << x;
            }
        }
        let free = self.free[word] & !touched | touched & !above;
        let occupied = self.occupied[word] & !touched | above;
        let changed = (free ^ self.free[word]) | (occupied ^ self.occupied[word]);
        if changed != 0 {
            self.free[word] = free;
            self.occupied[word] = occupied;
            for plane in &mut self.seen {
                plane[word] &= occupied;
            }
            self.dirty.state(word, changed);
        }
        touched.count_ones() as usize
    }
}
