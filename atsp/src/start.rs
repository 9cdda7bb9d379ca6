//! First tours: cycles of the assignment joined, the nearest node next, an earlier order repaired.

use crate::closed::Closed;
use crate::pace::Pace;

/// Most nodes looked at for the nearest one.
const WINDOW: usize = 4;
/// Costs looked at in all: few, because with large sets each look is a miss of the cache.
const LOOKS: usize = 800;

/// Workspace of the constructions.
#[derive(Debug, Default)]
pub(crate) struct Starts {
    tour: Vec<u32>,
    /// The order repaired last.
    repaired: Vec<u32>,
    cycles: Vec<u32>,
    /// Begin and length of each cycle in `cycles`.
    spans: Vec<(u32, u32)>,
    seen: Vec<bool>,
    spare: Vec<u32>,
}

impl Starts {
    fn unseen(&mut self, n: usize) {
        self.seen.clear();
        self.seen.resize(n, false);
        self.tour.clear();
        self.tour.reserve(n);
    }

    /// From node 0 always on to the nearest of the next few nodes not yet visited.
    pub(crate) fn nearest(&mut self, n: usize, cost: impl Fn(usize, usize) -> f64) -> &[u32] {
        self.unseen(n);
        self.spare.clear();
        // Backwards, so that the last few are the lowest.
        self.spare.extend((1..n as u32).rev());
        let window = (LOOKS / n).clamp(1, WINDOW);
        let mut here = 0;
        self.tour.push(0);
        while !self.spare.is_empty() {
            let few = self.spare.len().saturating_sub(window);
            let (mut best, mut at) = (f64::INFINITY, few);
            for (k, &node) in self.spare.iter().enumerate().skip(few) {
                let step = cost(here, node as usize);
                if step < best {
                    (best, at) = (step, k);
                }
            }
            here = self.spare.swap_remove(at) as usize;
            self.tour.push(here as u32);
        }
        &self.tour
    }

    /// Karp's patching: joins each smaller cycle to the largest where it costs least. `None` when the caller stopped.
    pub(crate) fn patched(
        &mut self,
        closed: &Closed,
        next: &[u32],
        pace: &mut Pace<'_>,
    ) -> Option<&[u32]> {
        let n = closed.n;
        self.unseen(n);
        self.cycles.clear();
        self.spans.clear();
        for first in 0..n {
            let begin = self.cycles.len();
            let mut node = first;
            while !self.seen[node] {
                self.seen[node] = true;
                self.cycles.push(node as u32);
                node = next[node] as usize;
            }
            if self.cycles.len() > begin {
                self.spans
                    .push((begin as u32, (self.cycles.len() - begin) as u32));
            }
        }
        // Largest first; equally long ones in order of their lowest node.
        self.spans
            .sort_unstable_by_key(|&(begin, len)| (u32::MAX - len, begin));
        for (k, &(begin, len)) in self.spans.iter().enumerate() {
            let cycle = &self.cycles[begin as usize..(begin + len) as usize];
            if k == 0 {
                self.tour.extend_from_slice(cycle);
                continue;
            }
            let (mut best, mut at) = (f64::INFINITY, (0, 0));
            for i in 0..self.tour.len() {
                if pace.spend(2 * cycle.len()) {
                    return None;
                }
                let a = self.tour[i] as usize;
                let b = self.tour[if i + 1 == self.tour.len() { 0 } else { i + 1 }] as usize;
                let (from_a, saved) = (closed.row(a), closed.cost(a, b));
                for (j, &c) in cycle.iter().enumerate() {
                    let d = next[c as usize] as usize;
                    let extra =
                        from_a[d] + closed.cost(c as usize, b) - saved - closed.cost(c as usize, d);
                    if extra < best {
                        (best, at) = (extra, (i, j));
                    }
                }
            }
            let (i, j) = at;
            // Behind tour[i] come the cycle's nodes from the one after cycle[j] round to it.
            self.spare.clear();
            self.spare.extend_from_slice(&self.tour[i + 1..]);
            self.tour.truncate(i + 1);
            self.tour.extend_from_slice(&cycle[j + 1..]);
            self.tour.extend_from_slice(&cycle[..=j]);
            self.tour.extend_from_slice(&self.spare);
        }
        Some(&self.tour)
    }

    /// The hint's order without strangers and repetitions, its missing nodes put where they cost least, lowest first.
    pub(crate) fn repaired(
        &mut self,
        closed: &Closed,
        hint: &[usize],
        cost: impl Fn(usize, usize) -> f64,
    ) -> &[u32] {
        let n = closed.n;
        self.unseen(n);
        if closed.is_path {
            self.tour.push(0);
            self.seen[0] = true;
        }
        for &node in hint {
            if let Some(i) = closed.closed_of(node)
                && !self.seen[i as usize]
            {
                self.seen[i as usize] = true;
                self.tour.push(i);
            }
        }
        for node in 0..n {
            if self.seen[node] {
                continue;
            }
            if self.tour.is_empty() {
                self.tour.push(node as u32);
                continue;
            }
            let (mut best, mut at) = (f64::INFINITY, 0);
            for i in 0..self.tour.len() {
                let a = self.tour[i] as usize;
                let b = self.tour[if i + 1 == self.tour.len() { 0 } else { i + 1 }] as usize;
                let saved = if a == b { 0.0 } else { cost(a, b) };
                let extra = cost(a, node) + cost(node, b) - saved;
                if extra < best {
                    (best, at) = (extra, i);
                }
            }
            self.tour.insert(at + 1, node as u32);
        }
        self.repaired.clear();
        self.repaired.extend_from_slice(&self.tour);
        &self.repaired
    }

    /// What [`repaired`](Self::repaired) made last.
    pub(crate) fn last_repaired(&self) -> &[u32] {
        &self.repaired
    }
}
