//! The end of a scan: marks become log-odds, once per cell, 64 cells at a time.

use super::Window;
use crate::map::VoxelMap;
use crate::sensor::Odds;
use crate::store::LogRow;

/// Words with at least this many cells to update are updated whole, in vector code; the others bit by bit.
const MANY: u32 = 8;

impl VoxelMap {
    /// Adds up the marks of a scan and clears them. Returns the number of cells updated.
    pub(super) fn apply(&mut self, window: &mut Window) -> usize {
        let mut updated = 0;
        let [(y0, y1), (z0, z1)] = std::mem::replace(&mut window.rows, [(usize::MAX, 0); 2]);
        for z in z0..z1 {
            for y in y0..y1 {
                for w in 0..self.words {
                    let word = self.word(w, y, z);
                    if window.passed[word] | window.hit[word] == 0 {
                        continue;
                    }
                    let skip = window.skip.get(word).map_or(0, |s| *s);
                    let hit = std::mem::take(&mut window.hit[word]) & !skip;
                    let miss = std::mem::take(&mut window.passed[word]) & !skip & !hit;
                    if let Some(end) = window.end.get_mut(word) {
                        *end = 0;
                    }
                    let touched = hit | miss;
                    if touched == 0 {
                        continue;
                    }
                    let odds = self.odds;
                    let row = self.log.make(w, y, z);
                    let above = if touched.count_ones() >= MANY {
                        add_row(row, hit, miss, odds)
                    } else {
                        add_bits(row, hit, odds.hit, odds) | add_bits(row, miss, odds.miss, odds)
                    };
                    self.write(w, y, z, touched, !above, above);
                    updated += touched.count_ones() as usize;
                }
            }
        }
        updated
    }
}

/// Adds `delta` to some cells; returns those that are occupied now.
#[inline]
fn add_bits(row: &mut LogRow, mut bits: u64, delta: i8, odds: Odds) -> u64 {
    let mut above = 0;
    while bits != 0 {
        let x = bits.trailing_zeros();
        bits &= bits - 1;
        let log = &mut row[x as usize];
        *log = log.saturating_add(delta).clamp(odds.min, odds.max);
        above |= u64::from(*log >= odds.occupied) << x;
    }
    above
}

/// Adds to all cells of a row at once; returns those among them that are occupied now.
#[inline]
fn add_row(row: &mut LogRow, hit: u64, miss: u64, odds: Odds) -> u64 {
    let mut above = [0u8; 64];
    let (hits, misses) = (hit.to_le_bytes(), miss.to_le_bytes());
    for byte in 0..8 {
        for bit in 0..8 {
            let x = byte * 8 + bit;
            let mask = 1u8 << bit;
            let is_hit = -i8::from(hits[byte] & mask != 0);
            let is_miss = -i8::from(misses[byte] & mask != 0);
            let delta = (odds.hit & is_hit) | (odds.miss & is_miss);
            let touched = is_hit | is_miss;
            let sum = row[x].saturating_add(delta).clamp(odds.min, odds.max);
            row[x] = (sum & touched) | (row[x] & !touched);
            above[x] = u8::from(row[x] >= odds.occupied);
        }
    }
    let mut bits = 0;
    let (groups, _) = above.as_chunks::<8>();
    for (i, group) in groups.iter().enumerate() {
        // Eight bytes of 0 or 1 become eight bits: the product brings byte k's bit to bit 56 + k, and no sum carries.
        let packed = u64::from_le_bytes(*group).wrapping_mul(0x0102_0408_1020_4080) >> 56;
        bits |= packed << (8 * i);
    }
    bits & (hit | miss)
}
