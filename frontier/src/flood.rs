//! Connected sets of waiting cells, by runs of a word at a time.

use crate::Cell;
use crate::layer::Layer;

impl Layer {
    /// Takes the 26-connected set of waiting cells around the first one of a word; its cells in no order that matters. Nothing
    /// where none waits.
    pub(crate) fn flood(&mut self, word: usize) -> Vec<Cell> {
        let waiting = self.loose[word];
        // Runs of waiting cells, all taken: what is left to do is to look beside them.
        let mut runs = Vec::new();
        self.take_runs(word, waiting & waiting.wrapping_neg(), &mut runs);
        let mut next = 0;
        while let Some(&(at, bits)) = runs.get(next) {
            next += 1;
            let (first, last) = self.ends(at);
            let wide = bits | bits << 1 | bits >> 1;
            for beside in self.rows_beside(at) {
                self.take_runs(beside, wide, &mut runs);
                if !first && bits & 1 != 0 {
                    self.take_runs(beside - 1, 1 << 63, &mut runs);
                }
                if !last && bits >> 63 != 0 {
                    self.take_runs(beside + 1, 1, &mut runs);
                }
            }
        }
        let many = runs.iter().map(|(_, bits)| bits.count_ones() as usize);
        let mut cells = Vec::with_capacity(many.sum());
        for (word, bits) in runs {
            self.append(word, bits, &mut cells);
        }
        cells
    }

    /// Takes the runs of waiting cells of a word that hold any of some bits.
    fn take_runs(&mut self, word: usize, bits: u64, runs: &mut Vec<(usize, u64)>) {
        let waiting = &mut self.loose[word];
        if bits & *waiting != 0 {
            let taken = spread(bits & *waiting, *waiting);
            *waiting &= !taken;
            runs.push((word, taken));
        }
    }
}

/// The runs of ones in `room` that hold any of the bits of `seeds`, all of them in `room`.
fn spread(seeds: u64, room: u64) -> u64 {
    let (mut up, mut down) = (seeds, seeds);
    let (mut above, mut below) = (room, room);
    // Twice as far in each round; `above` and `below` are the cells from which that many steps are free.
    for step in [1, 2, 4, 8, 16, 32] {
        up |= above & up << step;
        down |= below & down >> step;
        above &= above << step;
        below &= below >> step;
    }
    up | down
}

#[cfg(test)]
mod tests {
    use super::spread;

    #[test]
    fn seeds_fill_their_runs() {
        assert_eq!(spread(0, u64::MAX), 0);
        assert_eq!(spread(1 << 20, u64::MAX), u64::MAX);
        assert_eq!(spread(0b0000_0100_0000, 0b1101_1110_1011), 0b0001_1110_0000);
        let mut random = 1u64;
        for _ in 0..2000 {
            let mut next = || {
                random = random
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                random ^ random >> 29
            };
            let room = next() | next();
            let seeds = room & next() & next() & next();
            let mut slow = seeds;
            for _ in 0..64 {
                slow |= (slow << 1 | slow >> 1) & room;
            }
            assert_eq!(spread(seeds, room), slow);
        }
    }
}
