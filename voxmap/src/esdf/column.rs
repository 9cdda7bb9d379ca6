//! Minima over shifts along a column of blocks.

/// Cells beside each other that share their shifts.
pub(super) const LANES: usize = 64;
/// Squared distances of as many cells. Aligned to lines of the cache, which halves the price of a load.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Block(pub [u16; LANES]);

/// Lists are filled up to a multiple of this, so that vector code has no rest to do one by one.
const GROUP: usize = 32;
/// Shifts between two looks at whether any can still improve a block.
const SOME: usize = 4;

/// Blocks in a row, with blocks at the cap on both sides. Most have nothing to gain from most shifts (the floor is as far below
/// their neighbours), which the least value of each block tells: no shift beyond the last useful one is tried.
#[derive(Clone, Debug, Default)]
pub(super) struct Column {
    /// Longest shift.
    reach: usize,
    /// Entries before that of place 0: at least the reach.
    pad: usize,
    blocks: Vec<Block>,
    /// Least and largest value of each block.
    least: Vec<u16>,
    most: Vec<u16>,
    /// The last shift that can improve each block.
    last: Vec<u16>,
}

impl Column {
    /// Room for `len` places, and the reach on both sides of them.
    #[inline(always)]
    pub(super) fn reset(&mut self, reach: usize, len: usize) {
        let cap = ((reach + 1) * (reach + 1)) as u16;
        let pad = reach.next_multiple_of(GROUP);
        let many = len.next_multiple_of(GROUP);
        (self.reach, self.pad) = (reach, pad);
        refill(&mut self.blocks, pad + len + pad, Block([cap; LANES]));
        refill(&mut self.least, pad + many + pad, cap);
        refill(&mut self.most, pad + many + pad, 0);
        refill(&mut self.last, many, 0);
    }

    /// Puts a block at a place, which may lie as far outside as the reach; `counts` are its cells that
    /// count.
    #[inline(always)]
    pub(super) fn set(&mut self, place: isize, block: Block, counts: &Block) {
        let at = self.pad.wrapping_add_signed(place);
        self.blocks[at] = block;
        let (mut least, mut most) = (u16::MAX, 0);
        for i in 0..LANES {
            least = least.min(block.0[i] | !counts.0[i]);
            most = most.max(block.0[i] & counts.0[i]);
        }
        (self.least[at], self.most[at]) = (least, most);
    }

    /// Finds the last shift of each block by which something lies that is below the block's largest value even with the
    /// shift's square.
    #[inline(always)]
    pub(super) fn plan(&mut self) {
        let n = self.last.len();
        let most = &self.most[self.pad..][..n];
        let top = most.iter().fold(0, |a, &b| a.max(b));
        self.last.fill(0);
        for shift in 1..=self.reach {
            let add = (shift * shift) as u16;
            if add >= top {
                return;
            }
            let below = &self.least[self.pad - shift..][..n];
            let above = &self.least[self.pad + shift..][..n];
            for (((last, &most), &a), &b) in self.last.iter_mut().zip(most).zip(below).zip(above) {
                let useful = a.min(b).saturating_add(add) < most;
                *last = if useful { shift as u16 } else { *last };
            }
        }
    }

    /// `min over j of blocks[place + j] + j^2`, as planned.
    #[inline(always)]
    pub(super) fn least(&self, place: usize, counts: &Block) -> Block {
        let at = self.pad + place;
        let mut best = self.blocks[at];
        // A few more do no harm.
        let last = usize::from(self.last[place]).next_multiple_of(SOME);
        let (_, below) = self.blocks[at - last..at].as_rchunks::<SOME>();
        let (above, _) = self.blocks[at + 1..][..last].as_chunks::<SOME>();
        for ((below, above), first) in below.iter().rev().zip(above).zip((1..).step_by(SOME)) {
            // Nearer places first, until no shift can bring any cell less than it has.
            if first > SOME && !exceeds(&best, (first * first) as u16, counts) {
                break;
            }
            for k in 0..SOME {
                let (a, b) = (&below[SOME - 1 - k], &above[k]);
                let add = ((first + k) * (first + k)) as u16;
                for i in 0..LANES {
                    best.0[i] = best.0[i].min(a.0[i].min(b.0[i]).saturating_add(add));
                }
            }
        }
        best
    }
}

/// Whether a cell that counts is above a limit.
#[inline(always)]
fn exceeds(block: &Block, limit: u16, counts: &Block) -> bool {
    let mut excess = 0;
    for i in 0..LANES {
        excess |= block.0[i].saturating_sub(limit) & counts.0[i];
    }
    excess != 0
}

/// So many equal values.
#[inline(always)]
fn refill<T: Copy>(buffer: &mut Vec<T>, len: usize, value: T) {
    buffer.clear();
    buffer.resize(len, value);
}

/// What tells that the first `lanes` cells of a block count: all bits of each.
#[inline(always)]
pub(super) fn counting(lanes: usize) -> Block {
    Block(std::array::from_fn(
        |i| if i < lanes { u16::MAX } else { 0 },
    ))
}
