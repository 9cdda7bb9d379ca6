//! Turning squares of cells over, so that rows become columns.

use super::column::{Block, LANES};

/// As many blocks as a block has cells.
#[derive(Clone, Debug)]
pub(super) struct Tile(pub Box<[Block; LANES]>);

impl Default for Tile {
    fn default() -> Self {
        Self(Box::new([Block([0; LANES]); LANES]))
    }
}

/// Cell `i` of block `k` becomes cell `k` of block `i`.
#[inline(always)]
pub(super) fn turn(tile: &mut Tile, spare: &mut Tile) {
    // Each round shuffles block k with block k + 32 like halves of a pack of cards: the bits of a cell's number (block, then
    // place in it) move on by one place; after six rounds both halves of the number have changed places.
    let (mut from, mut to) = (&mut tile.0, &mut spare.0);
    for _ in 0..LANES.ilog2() {
        let (first, second) = from.split_at(LANES / 2);
        let (pairs, _) = to.as_chunks_mut::<2>();
        for ((a, b), pair) in first.iter().zip(second).zip(pairs) {
            for i in 0..LANES / 2 {
                pair[0].0[2 * i] = a.0[i];
                pair[0].0[2 * i + 1] = b.0[i];
                pair[1].0[2 * i] = a.0[LANES / 2 + i];
                pair[1].0[2 * i + 1] = b.0[LANES / 2 + i];
            }
        }
        (from, to) = (to, from);
    }
}

/// Bit `i` of word `k` becomes bit `k` of word `i`.
#[inline(always)]
pub(super) fn turn_bits(words: &mut [u64; 64]) {
    // Quarters off the diagonal change places, then the quarters' quarters, and so on.
    let mut mask = u64::MAX >> 32;
    let mut width = 32;
    while width > 0 {
        for pair in words.chunks_exact_mut(2 * width) {
            let (first, second) = pair.split_at_mut(width);
            for (a, b) in first.iter_mut().zip(second) {
                let swap = (*a >> width ^ *b) & mask;
                *b ^= swap;
                *a ^= swap << width;
            }
        }
        width /= 2;
        mask ^= mask << width;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_turned() {
        let mut tile = Tile::default();
        for k in 0..LANES {
            for i in 0..LANES {
                tile.0[k].0[i] = (k * LANES + i) as u16;
            }
        }
        turn(&mut tile, &mut Tile::default());
        for k in 0..LANES {
            for i in 0..LANES {
                assert_eq!(usize::from(tile.0[i].0[k]), k * LANES + i);
            }
        }
    }

    #[test]
    fn bits_are_turned() {
        let of = |k: u64| k.wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(k as u32);
        let mut words = [0; 64];
        for (k, word) in (0..).zip(&mut words) {
            *word = of(k);
        }
        turn_bits(&mut words);
        for k in 0..64 {
            for i in 0..64 {
                assert_eq!(words[i as usize] >> k & 1, of(k) >> i & 1);
            }
        }
    }
}
