//! Branch and bound on assignments: proves an order optimal, or finds a better one.
//!
//! The ascent's bound and what it leaves of each cost come first: a tour better than the best known has no arc that costs
//! more than the gap in what is left, so most arcs go. Then the assignment problem on what is left; its shortest cycle is
//! broken by forbidding one of its arcs after the other and keeping those before (Carpaneto and Toth 1980). One
//! augmenting path repairs the assignment of each branch.

use crate::ascent::Ascent;
use crate::assignment::{Assignment, FREE};
use crate::closed::Closed;

/// Deepest nesting of branches; deeper ones give the proof up.
const DEEPEST: usize = 32;
/// Bounds and costs that differ by less than this share of a tour are equal: rounding of the sums.
pub(crate) const ROUNDING: f64 = 1e-10;

/// What became of the proof.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Verdict {
    /// Lower bound of every tour.
    pub(crate) bound: f64,
    /// The best tour was proved optimal.
    pub(crate) is_complete: bool,
}

/// Workspace.
#[derive(Debug, Default)]
pub(crate) struct Branch {
    ascent: Ascent,
    assignment: Assignment,
    /// What is left of each cost; arcs that are out hold `out`.
    left: Vec<f64>,
    out: f64,
    /// Overwritten entries of `left`, to be put back.
    log: Vec<(u32, f64)>,
    /// Assignments of the branches above.
    saved: Vec<u32>,
    prices: Vec<f64>,
    kept: Vec<bool>,
    /// Arcs to branch on, of all branches above.
    arcs: Vec<(u32, u32)>,
    seen: Vec<bool>,
    tour: Vec<u32>,
    best: Vec<u32>,
    best_cost: f64,
    base: f64,
    slack: f64,
    budget: u64,
    is_cut_short: bool,
}

impl Branch {
    /// The best tour, as good as the one handed in or better.
    pub(crate) fn best(&self) -> (&[u32], f64) {
        (&self.best, self.best_cost)
    }

    /// Tries to prove a tour of the given cost optimal, in so many steps of ascent and branches. `prices` are the
    /// assignment's.
    pub(crate) fn prove(
        &mut self,
        closed: &Closed,
        prices: &[f64],
        tour: &[u32],
        cost: f64,
        steps: u32,
        branches: u64,
        stop: &mut dyn FnMut() -> bool,
    ) -> Verdict {
        let n = closed.n;
        self.best.clear();
        self.best.extend_from_slice(tour);
        self.best_cost = cost;
        self.slack = ROUNDING * cost;
        let bound = self
            .ascent
            .run(closed, prices, steps, cost, self.slack, stop);
        let mut proof = Verdict {
            bound: bound - self.slack,
            is_complete: bound >= cost - self.slack,
        };
        if proof.is_complete || branches == 0 || stop() {
            return proof;
        }
        self.left.resize(n * n, 0.0);
        self.base = self.ascent.residual(closed, &mut self.left);
        let gap = (cost - self.base).max(self.slack);
        self.out = 4.0 * gap;
        for i in 0..n {
            for (j, left) in self.left[i * n..(i + 1) * n].iter_mut().enumerate() {
                *left = if i == j || *left > gap {
                    self.out
                } else {
                    left.max(0.0)
                };
            }
        }
        self.log.clear();
        self.arcs.clear();
        self.kept.clear();
        self.kept.resize(n, false);
        self.budget = branches;
        self.is_cut_short = false;
        if self
            .assignment
            .solve(n, &self.left, &mut |_| false)
            .is_none()
        {
            return proof;
        }
        let root = self.base + self.sum();
        proof.bound = proof.bound.max(root - self.slack);
        self.visit(closed, 0, stop);
        proof.is_complete = !self.is_cut_short;
        proof
    }

    fn sum(&self) -> f64 {
        let n = self.kept.len();
        (0..n)
            .map(|i| self.left[i * n + self.assignment.next[i] as usize])
            .sum()
    }

    /// Looks below the current assignment.
    fn visit(&mut self, closed: &Closed, depth: usize, stop: &mut dyn FnMut() -> bool) {
        let n = closed.n;
        let bound = self.base + self.sum();
        if bound >= self.best_cost - self.slack {
            return;
        }
        let first = self.arcs.len();
        if !self.pick_cycle(closed, bound) {
            return;
        }
        if depth == DEEPEST {
            self.is_cut_short = true;
        }
        self.save(depth);
        let logged = self.log.len();
        let last = self.arcs.len();
        for k in first..last {
            if self.budget == 0 || stop() {
                self.is_cut_short = true;
            }
            if self.is_cut_short {
                break;
            }
            self.budget -= 1;
            let (i, j) = self.arcs[k];
            // Without this arc...
            let at = i as usize * n + j as usize;
            let was = std::mem::replace(&mut self.left[at], self.out);
            self.assignment.next[i as usize] = FREE;
            self.assignment.previous[j as usize] = FREE;
            self.assignment.augment(&self.left, i as usize);
            self.visit(closed, depth + 1, stop);
            self.left[at] = was;
            self.restore(depth);
            // ... and with it, in all that follow: the other arcs out of its tail go.
            self.kept[i as usize] = true;
            for head in 0..n {
                let at = i as usize * n + head;
                if head != j as usize && self.left[at] < self.out {
                    self.log.push((at as u32, self.left[at]));
                    self.left[at] = self.out;
                }
            }
        }
        for k in first..last {
            self.kept[self.arcs[k].0 as usize] = false;
        }
        while self.log.len() > logged {
            if let Some((at, was)) = self.log.pop() {
                self.left[at as usize] = was;
            }
        }
        self.arcs.truncate(first);
    }

    /// Puts the free arcs of the cycle with fewest of them on `arcs`; false if nothing is left to branch on. A single
    /// cycle is a tour: it is noted if it is better.
    fn pick_cycle(&mut self, closed: &Closed, bound: f64) -> bool {
        let n = closed.n;
        let next = &self.assignment.next;
        self.seen.clear();
        self.seen.resize(n, false);
        let (mut fewest, mut start) = (usize::MAX, 0);
        for node in 0..n {
            if self.seen[node] {
                continue;
            }
            let (mut free, mut len, mut at) = (0, 0, node);
            while !self.seen[at] {
                self.seen[at] = true;
                free += usize::from(!self.kept[at]);
                len += 1;
                at = next[at] as usize;
            }
            if free < fewest {
                (fewest, start) = (free, node);
            }
            if len == n {
                self.tour.clear();
                let mut at = 0;
                for _ in 0..n {
                    self.tour.push(at);
                    at = next[at as usize];
                }
                let cost = closed.along(&self.tour);
                if cost < self.best_cost {
                    self.best_cost = cost;
                    self.best.copy_from_slice(&self.tour);
                }
                if bound >= cost - self.slack {
                    return false;
                }
            }
        }
        let mut at = start;
        loop {
            let head = next[at];
            if !self.kept[at] {
                self.arcs.push((at as u32, head));
            }
            at = head as usize;
            if at == start {
                return fewest > 0;
            }
        }
    }

    fn save(&mut self, depth: usize) {
        let n = self.kept.len();
        let a = &self.assignment;
        self.saved.truncate(2 * n * depth);
        self.saved.extend_from_slice(&a.next);
        self.saved.extend_from_slice(&a.previous);
        self.prices.truncate(n * depth);
        self.prices.extend_from_slice(&a.v);
    }

    fn restore(&mut self, depth: usize) {
        let n = self.kept.len();
        let saved = &self.saved[2 * n * depth..];
        self.assignment.next.copy_from_slice(&saved[..n]);
        self.assignment.previous.copy_from_slice(&saved[n..2 * n]);
        self.assignment
            .v
            .copy_from_slice(&self.prices[n * depth..n * (depth + 1)]);
    }
}
