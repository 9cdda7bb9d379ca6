//! King's steps on a grid of ground cells, row by row in vector code.

use crate::simd::{self, Kernel};

/// Steps are counted up to here.
const FAR: u8 = 250;

/// King's steps from every cell of rows of `width` to the nearest one that is blocked, at most 250. `outside`: what lies beyond
/// the grid is blocked too.
pub(crate) fn rings(blocked: impl Iterator<Item = bool>, width: usize, outside: bool) -> Vec<u8> {
    let mut steps: Vec<u8> = blocked.map(|b| if b { 0 } else { FAR }).collect();
    if width > 0 {
        simd::run(Rings {
            steps: &mut steps,
            width,
            outside,
        });
    }
    steps
}

struct Rings<'a> {
    steps: &'a mut [u8],
    width: usize,
    outside: bool,
}

impl Kernel for Rings<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            steps,
            width,
            outside,
        } = self;
        // The shortest way goes along the row of the blocked cell first, then a row a step.
        let mut other = vec![0; width];
        for row in steps.chunks_exact_mut(width) {
            if outside {
                row[0] = row[0].min(1);
                row[width - 1] = row[width - 1].min(1);
            }
            along(row, &mut other);
        }
        let edge = if outside { 0 } else { FAR };
        let mut before = vec![edge; width + 2];
        for row in steps.chunks_exact_mut(width) {
            on(row, &mut before);
        }
        before.fill(edge);
        for row in steps.chunks_exact_mut(width).rev() {
            on(row, &mut before);
        }
    }
}

/// Steps within a row: by one cell, then by two more, four more, and so on.
#[inline(always)]
fn along(row: &mut [u8], other: &mut [u8]) {
    let mut shift = 1;
    while shift < row.len().min(usize::from(FAR)) {
        let add = shift as u8;
        // Longer shifts cost more than any cell has.
        if row.iter().fold(0, |a, &b| a.max(b)) <= add {
            return;
        }
        other.copy_from_slice(row);
        for (cell, &after) in row.iter_mut().zip(&other[shift..]) {
            *cell = (*cell).min(after.saturating_add(add));
        }
        for (cell, &before) in row[shift..].iter_mut().zip(&*other) {
            *cell = (*cell).min(before.saturating_add(add));
        }
        shift *= 2;
    }
}

/// A step on from the row before, which has a cell more on either side.
#[inline(always)]
fn on(row: &mut [u8], before: &mut [u8]) {
    let n = row.len();
    let (left, middle, right) = (&before[..n], &before[1..=n], &before[2..]);
    for (((cell, &a), &b), &c) in row.iter_mut().zip(left).zip(middle).zip(right) {
        *cell = (*cell).min(a.min(b).min(c).saturating_add(1));
    }
    before[1..=n].copy_from_slice(row);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_equal_their_definition() {
        let mut random = 5u64;
        for (width, height, few) in [
            (1, 1, 2),
            (1, 9, 3),
            (300, 3, 1000),
            (70, 40, 90),
            (33, 65, 5),
            (20, 270, 1 << 30),
        ] {
            let blocked: Vec<bool> = (0..width * height)
                .map(|_| {
                    random = random
                        .wrapping_mul(6_364_136_223_846_793_005)
                        .wrapping_add(1);
                    (random >> 33).is_multiple_of(few)
                })
                .collect();
            for outside in [false, true] {
                let found = rings(blocked.iter().copied(), width, outside);
                for (i, &steps) in found.iter().enumerate() {
                    let (x, y) = (i % width, i / width);
                    let edge = (x + 1).min(width - x).min(y + 1).min(height - y);
                    let nearest = (0..blocked.len())
                        .filter(|&j| blocked[j])
                        .map(|j| (j % width).abs_diff(x).max((j / width).abs_diff(y)))
                        .chain(outside.then_some(edge))
                        .min();
                    assert_eq!(usize::from(steps), nearest.unwrap_or(250).min(250));
                }
            }
        }
    }
}
