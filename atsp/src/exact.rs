//! Held and Karp's dynamic program over subsets: optimal closed tours of small sets.
//!
//! Time 2^(n-1) (n-1)^2, memory 8 bytes times 2^(n-1) (n-1) rounded up to a multiple of four.

use crate::closed::Closed;
use crate::pace::Pace;

/// The table of partial tours, and the best tour.
#[derive(Debug, Default)]
pub(crate) struct Table {
    /// `best[set * stride + last]`: cheapest way from node 0 over the set to its member `last`; infinite for others.
    best: Vec<f64>,
    /// `into[last * stride + from]`: costs between the nodes other than 0, by head.
    into: Vec<f64>,
    tour: Vec<u32>,
}

/// Lanes of the minimum.
const LANES: usize = 4;

impl Table {
    pub(crate) fn tour(&self) -> &[u32] {
        &self.tour
    }

    /// Finds the cheapest closed tour; its cost. `None` when the caller stopped.
    pub(crate) fn solve(&mut self, closed: &Closed, pace: &mut Pace<'_>) -> Option<f64> {
        let n = closed.n;
        self.tour.clear();
        self.tour.push(0);
        if n == 1 {
            return Some(0.0);
        }
        let others = n - 1;
        let stride = others.next_multiple_of(LANES);
        let full = 1usize << others;
        self.into.clear();
        self.into.resize(others * stride, f64::INFINITY);
        for from in 0..others {
            for last in 0..others {
                self.into[last * stride + from] = closed.cost(from + 1, last + 1);
            }
        }
        self.best.clear();
        self.best.resize(full * stride, f64::INFINITY);
        for last in 0..others {
            self.best[(1 << last) * stride + last] = closed.cost(0, last + 1);
        }
        for set in 1..full {
            if set & (set - 1) == 0 {
                continue;
            }
            if pace.spend(stride * others / 4) {
                return None;
            }
            let (done, rest) = self.best.split_at_mut(set * stride);
            let mut left = set;
            while left != 0 {
                let last = left.trailing_zeros() as usize;
                left &= left - 1;
                let before = (set & !(1 << last)) * stride;
                rest[last] = least(
                    &done[before..before + stride],
                    &self.into[last * stride..(last + 1) * stride],
                );
            }
        }
        let close = |last: usize| self.best[(full - 1) * stride + last] + closed.cost(last + 1, 0);
        let (mut last, mut cost) = (0, close(0));
        for other in 1..others {
            if close(other) < cost {
                (last, cost) = (other, close(other));
            }
        }
        // Backwards: a predecessor whose sum is bit for bit the one the forward pass took.
        let mut set = full - 1;
        loop {
            self.tour.push(last as u32 + 1);
            let here = self.best[set * stride + last];
            set &= !(1 << last);
            let (way, into) = (&self.best[set * stride..], &self.into[last * stride..]);
            let Some(previous) =
                (0..others).find(|&p| set & (1 << p) != 0 && way[p] + into[p] == here)
            else {
                break;
            };
            last = previous;
        }
        self.tour[1..].reverse();
        Some(cost)
    }
}

/// Least sum of two rows, in lanes that the compiler can hold in registers.
#[inline]
fn least(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [f64::INFINITY; LANES];
    for (a, b) in a.chunks_exact(LANES).zip(b.chunks_exact(LANES)) {
        for k in 0..LANES {
            let sum = a[k] + b[k];
            lanes[k] = if sum < lanes[k] { sum } else { lanes[k] };
        }
    }
    lanes.iter().fold(f64::INFINITY, |a, &b| a.min(b))
}
