//! Iterated local search on closed tours: segment insertion, segment exchange and reversal with candidate lists,
//! local double-bridge kicks, undo by copy.

use crate::cost::{CostMatrix, CostModel};
use crate::rng::Rng;

/// Best outgoing arcs looked at per node.
const CANDIDATES: usize = 8;
/// Longest stretch of the tour that one kick rearranges.
const KICK_STRETCH: usize = 50;
/// Gains below this share of the tour are rounding.
const EPSILON: f64 = 1e-12;

pub(crate) struct Search<'a> {
    costs: &'a CostMatrix,
    candidates: Vec<Vec<usize>>,
    tour: Vec<usize>,
    place: Vec<usize>,
    /// Nodes whose surroundings changed since they were last looked at.
    queue: Vec<usize>,
    queued: Vec<bool>,
    spare: Vec<usize>,
}

impl<'a> Search<'a> {
    /// `tour` is a permutation of the nodes; all costs are finite.
    pub(crate) fn new(costs: &'a CostMatrix, tour: Vec<usize>) -> Self {
        let n = tour.len();
        let candidates = (0..n)
            .map(|from| {
                let mut heads: Vec<usize> = (0..n).filter(|&to| to != from).collect();
                heads.sort_by(|&a, &b| {
                    costs
                        .cost(from, a)
                        .total_cmp(&costs.cost(from, b))
                        .then(a.cmp(&b))
                });
                heads.truncate(CANDIDATES);
                heads
            })
            .collect();
        let mut search = Self {
            costs,
            candidates,
            tour: Vec::new(),
            place: vec![0; n],
            queue: Vec::with_capacity(n),
            queued: vec![false; n],
            spare: Vec::with_capacity(n),
        };
        search.restore(&tour);
        search
    }

    fn restore(&mut self, tour: &[usize]) {
        self.tour.clear();
        self.tour.extend_from_slice(tour);
        for (i, &node) in tour.iter().enumerate() {
            self.place[node] = i;
        }
    }

    fn wake(&mut self, node: usize) {
        if !self.queued[node] {
            self.queued[node] = true;
            self.queue.push(node);
        }
    }

    fn at(&self, i: usize) -> usize {
        let n = self.tour.len();
        self.tour[if i >= n { i - n } else { i }]
    }

    /// Cost of the closed tour, summed anew.
    pub(crate) fn cost(&self) -> f64 {
        let n = self.tour.len();
        (0..n)
            .map(|i| self.costs.cost(self.tour[i], self.at(i + 1)))
            .sum()
    }

    /// Descends until no move of the neighbourhood gains.
    pub(crate) fn descend(&mut self, tolerance: f64) {
        while let Some(node) = self.queue.pop() {
            self.queued[node] = false;
            while self.improve(node, tolerance) {}
        }
    }

    /// Tries moves that give `tail` a better successor; applies the first that gains.
    ///
    /// With the tour cut after `tail`, positions are counted from its old successor: `tail` stands at the end. Moving
    /// the segment `[1..=j]`... is one pure exchange of two neighbouring segments: a -> b', c -> a', b -> c'.
    fn improve(&mut self, tail: usize, tolerance: f64) -> bool {
        let n = self.tour.len();
        if n < 4 {
            return false;
        }
        let start = self.place[tail] + 1; // position of the old successor, may equal n
        let old_head = self.at(start % n);
        let removed_first = self.costs.cost(tail, old_head);
        for c in 0..self.candidates[tail].len() {
            let head = self.candidates[tail][c];
            let first_gain = removed_first - self.costs.cost(tail, head);
            if first_gain <= tolerance {
                break;
            }
            // Offset of the new successor from the old one; the arc before it goes.
            let offset = (self.place[head] + n - start % n) % n;
            if offset == 0 {
                continue;
            }
            let before = self.at((start + offset - 1) % n);
            let gain = first_gain + self.costs.cost(before, head);
            // Third cut after position k >= offset: tail -> head..at(k) -> old_head..before -> at(k+1).
            let (mut best, mut cut) = (tolerance, usize::MAX);
            for k in offset..n - 1 {
                let end = self.at((start + k) % n);
                let after = self.at((start + k + 1) % n);
                let total = gain + self.costs.cost(end, after)
                    - self.costs.cost(end, old_head)
                    - self.costs.cost(before, after);
                if total > best {
                    (best, cut) = (total, k);
                }
            }
            if cut != usize::MAX {
                self.exchange(start % n, offset, cut);
                return true;
            }
            if self.reverse_if_better(start % n, offset, tail, head, tolerance) {
                return true;
            }
        }
        false
    }

    /// Swaps the neighbouring segments `[0, offset)` and `[offset, cut]`, counted from position `start`.
    fn exchange(&mut self, start: usize, offset: usize, cut: usize) {
        let n = self.tour.len();
        self.spare.clear();
        for k in (offset..=cut).chain(0..offset) {
            self.spare.push(self.tour[(start + k) % n]);
        }
        self.write_back(start);
        for k in [n - 1, 0, cut - offset, cut - offset + 1, cut, (cut + 1) % n] {
            let node = self.at((start + k) % n);
            self.wake(node);
        }
    }

    /// 2-opt: tail -> head reversed back to old_head -> after head.
    fn reverse_if_better(
        &mut self,
        start: usize,
        offset: usize,
        tail: usize,
        head: usize,
        tolerance: f64,
    ) -> bool {
        let n = self.tour.len();
        if offset + 1 >= n {
            return false;
        }
        let old_head = self.at(start);
        let after = self.at((start + offset + 1) % n);
        let mut gain = self.costs.cost(tail, old_head) + self.costs.cost(head, after)
            - self.costs.cost(tail, head)
            - self.costs.cost(old_head, after);
        for k in 0..offset {
            let (a, b) = (self.at((start + k) % n), self.at((start + k + 1) % n));
            gain += self.costs.cost(a, b) - self.costs.cost(b, a);
        }
        if gain <= tolerance {
            return false;
        }
        self.spare.clear();
        for k in (0..=offset).rev() {
            self.spare.push(self.tour[(start + k) % n]);
        }
        self.write_back(start);
        for k in 0..=offset {
            let node = self.at((start + k) % n);
            self.wake(node);
        }
        self.wake(tail);
        self.wake(after);
        true
    }

    fn write_back(&mut self, start: usize) {
        let n = self.tour.len();
        for k in 0..self.spare.len() {
            let position = (start + k) % n;
            let node = self.spare[k];
            self.tour[position] = node;
            self.place[node] = position;
        }
    }

    /// Wakes every node, last first, so that node 0 is looked at first.
    fn wake_all(&mut self) {
        for node in (0..self.tour.len()).rev() {
            self.wake(node);
        }
    }

    /// Descends, then kicks `kicks` times, keeping the best. Returns the tour from node 0 on, its cost and the kicks done.
    pub(crate) fn run(mut self, kicks: u64, bound: f64, rng: &mut Rng) -> (Vec<usize>, f64, u64) {
        let n = self.tour.len();
        self.wake_all();
        let scale = self.cost().abs().max(f64::MIN_POSITIVE);
        let tolerance = EPSILON * scale;
        self.descend(tolerance);
        let mut cost = self.cost();
        let mut kept = self.tour.clone();
        let mut best = (kept.clone(), cost);
        let mut done = 0;
        let mut idle = 0u64;
        let mut blind = 0u32;
        while done < kicks && best.1 > bound + tolerance && n >= 8 {
            done += 1;
            self.kick(rng);
            self.descend(tolerance);
            let new_cost = self.cost();
            idle += 1;
            if new_cost <= cost || blind > 0 {
                if new_cost < best.1 - tolerance {
                    best = (self.tour.clone(), new_cost);
                    idle = 0;
                }
                cost = new_cost;
                kept.clone_from(&self.tour);
                blind = blind.saturating_sub(1);
            } else {
                let tour = std::mem::take(&mut kept);
                self.restore(&tour);
                kept = tour;
            }
            if idle > 5 * n as u64 {
                // Stagnation: from the best, accept a number of kicks whatever they cost.
                kept.clone_from(&best.0);
                let tour = best.0.clone();
                self.restore(&tour);
                cost = best.1;
                blind = 50;
                idle = 0;
            }
        }
        let zero = best.0.iter().position(|&node| node == 0).unwrap_or(0);
        best.0.rotate_left(zero);
        (best.0, best.1, done)
    }

    /// Double bridge on three short neighbouring segments.
    fn kick(&mut self, rng: &mut Rng) {
        let n = self.tour.len();
        let stretch = KICK_STRETCH.min(n - 2);
        let start = rng.below(n);
        let mut cuts = [0; 3];
        loop {
            for cut in &mut cuts {
                *cut = 1 + rng.below(stretch);
            }
            cuts.sort_unstable();
            if cuts[0] != cuts[1] && cuts[1] != cuts[2] {
                break;
            }
        }
        let [a, b, c] = cuts;
        self.spare.clear();
        for k in (b..c).chain(a..b).chain(0..a) {
            self.spare.push(self.tour[(start + k) % n]);
        }
        self.write_back(start);
        for k in [n - 1, 0, c - b - 1, c - b, c - a - 1, c - a, c - 1, c % n] {
            let node = self.at((start + k) % n);
            self.wake(node);
        }
    }
}
