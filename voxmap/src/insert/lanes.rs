//! Exact 6-connected traversal of many rays in lock step.

use super::rays::Batch;
use crate::simd::Kernel;

/// Rays in lock step.
const LANES: usize = 16;

/// Sets the bit of every cell on the rays `order` of a batch, ends included.
pub(super) struct Trace<'a> {
    pub batch: &'a Batch,
    pub order: &'a [u16],
    pub marks: &'a mut [u64],
}

impl Kernel for Trace<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            batch,
            order,
            marks,
        } = self;
        for group in order.chunks(LANES) {
            let mut next = [[i32::MAX; LANES]; 3];
            let mut delta = [[0; LANES]; 3];
            let mut step = [[0; LANES]; 3];
            let mut end = [0; LANES];
            let mut address = [batch.first[usize::from(group[0])]; LANES];
            let mut count = 0;
            for (lane, &ray) in group.iter().enumerate() {
                let ray = usize::from(ray);
                for a in 0..3 {
                    next[a][lane] = batch.next[a][ray];
                    delta[a][lane] = batch.delta[a][ray];
                    step[a][lane] = batch.step[a][ray];
                }
                end[lane] = batch.end[ray];
                address[lane] = batch.first[ray];
                count = count.max(batch.count[ray]);
            }
            for _ in 0..count {
                mark(marks, &address);
                advance(&mut next, &delta, &step, &end, &mut address);
            }
            mark(marks, &address);
        }
    }
}

#[inline(always)]
fn mark(marks: &mut [u64], address: &[i32; LANES]) {
    for &a in address {
        marks[(a as u32 >> 6) as usize] |= 1u64 << (a & 63);
    }
}

/// One step of every lane whose end is not reached: along the axis with the earliest crossing, ties to the lower axis.
#[inline(always)]
fn advance(
    next: &mut [[i32; LANES]; 3],
    delta: &[[i32; LANES]; 3],
    step: &[[i32; LANES]; 3],
    end: &[i32; LANES],
    address: &mut [i32; LANES],
) {
    for l in 0..LANES {
        let (x, y, z) = (next[0][l], next[1][l], next[2][l]);
        let first = x.min(y).min(z);
        let go = -i32::from(first <= end[l]);
        let along_x = -i32::from(x == first) & go;
        let along_y = -i32::from(y == first) & !along_x & go;
        let along_z = !(along_x | along_y) & go;
        next[0][l] = x + (delta[0][l] & along_x);
        next[1][l] = y + (delta[1][l] & along_y);
        next[2][l] = z + (delta[2][l] & along_z);
        address[l] += (step[0][l] & along_x) | (step[1][l] & along_y) | (step[2][l] & along_z);
    }
}
