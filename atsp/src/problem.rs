//! What is asked and what is answered.

/// What is to be ordered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Problem {
    /// A tour through all nodes that returns to where it began; reported from node 0 on.
    Closed,
    /// A path through all nodes from `start`; the end is free.
    Open {
        /// First node.
        start: usize,
    },
    /// A path through all nodes from `start` to `end`; a closed tour through `start` when both are the same node.
    Path {
        /// First node.
        start: usize,
        /// Last node.
        end: usize,
    },
}

/// How hard to try to prove the order optimal, and so how good [`Solution::lower_bound`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Proof {
    /// The assignment problem's bound only: a few per cent to a third below the optimum where costs are nearly symmetric.
    Assignment,
    /// Up to 128 nodes as `Effort { steps: 100, branches: 200 }`, after `n^2 / 2` kicks or `32 n` if that is fewer; it
    /// takes one to three milliseconds at 50 nodes. Above, and with fewer kicks, as [`Assignment`](Self::Assignment).
    Quick,
    /// At any size: Held and Karp's ascent, then branch and bound.
    Effort {
        /// Steps of the ascent, each O(n^2): 100 come within about one per cent of the optimum, 1000 within a few tenths.
        steps: u32,
        /// Branches of the branch and bound, each O(n^2); zero for the bound alone.
        branches: u64,
    },
}

/// Effort and randomness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Params {
    /// Largest closed problem solved to proved optimality whatever it takes, nodes; from 8 to 20 are taken. A path's
    /// fixed start and end count as one node. Memory for dynamic programming, `8 n 2^(n-1)` bytes, is taken only where
    /// branch and bound fails.
    pub exact_nodes: usize,
    /// Kicks of the iterated local search above that.
    pub kicks: u64,
    /// Seed of the kicks.
    pub seed: u64,
    /// Proof and lower bound above `exact_nodes`.
    pub proof: Proof,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            exact_nodes: 13,
            kicks: 2000,
            seed: 1,
            proof: Proof::Quick,
        }
    }
}

/// An order of all nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Every node once; the first is the start, the last the end where the form fixes it.
    pub order: Vec<usize>,
    /// Sum of the arcs, with the arc back to the start for closed tours; summed from the given costs.
    pub cost: f64,
    /// True only when proved, up to the rounding of sums: no order costs less by more than 1e-10 of the cost.
    pub optimal: bool,
    /// A proved lower bound of every order's cost, where one was computed.
    pub lower_bound: Option<f64>,
    /// Kicks that were tried.
    pub kicks: u64,
}

impl Solution {
    /// How far the cost can be above the optimum, as a share of the cost; `None` without a bound.
    ///
    /// Zero when optimal. The share is taken of the cost's magnitude; costs of zero with a lower bound give infinity.
    pub fn gap(&self) -> Option<f64> {
        if self.optimal {
            return Some(0.0);
        }
        self.lower_bound.map(|bound| {
            let gap = (self.cost - bound).max(0.0);
            if gap > 0.0 {
                gap / self.cost.abs()
            } else {
                0.0
            }
        })
    }
}

/// What the caller does while the solver works: stop it, or note its progress. Any `FnMut() -> bool` is one.
///
/// ```
/// use atsp::Watch;
/// let deadline = std::time::Instant::now() + std::time::Duration::from_millis(5);
/// let mut watch = || std::time::Instant::now() >= deadline;
/// assert!(!watch.stop());
/// ```
pub trait Watch {
    /// True to stop at the best order so far. Asked about every ten to twenty microseconds of work.
    fn stop(&mut self) -> bool;
    /// Told of each better order that can be driven, by its cost.
    fn improved(&mut self, _cost: f64) {}
}

impl<F: FnMut() -> bool> Watch for F {
    fn stop(&mut self) -> bool {
        self()
    }
}
