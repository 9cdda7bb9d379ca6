//! Candidate arcs: for each node the few arcs out of it and into it that a good tour may use.

use crate::closed::Closed;
use crate::pace::Pace;

/// Arcs per node and direction.
pub(crate) const WIDTH: usize = 8;

/// The other end of an arc.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    pub(crate) cost: f64,
    pub(crate) node: u32,
}

/// Two tables of [`WIDTH`] arcs a node, fewer in sets of fewer nodes, each node's arcs in order of cost.
#[derive(Debug, Default)]
pub(crate) struct Candidates {
    width: usize,
    out: Vec<Arc>,
    into: Vec<Arc>,
    limit: Vec<f64>,
}

impl Candidates {
    /// Picks by the reduced cost `cost - u[from] - v[to]`; `u` and `v` may be empty for plain costs.
    ///
    /// False, with nothing usable picked, when the caller stopped.
    pub(crate) fn pick(
        &mut self,
        closed: &Closed,
        u: &[f64],
        v: &[f64],
        pace: &mut Pace<'_>,
    ) -> bool {
        let n = closed.n;
        let k = WIDTH.min(n - 1);
        let none = Arc {
            cost: f64::INFINITY,
            node: 0,
        };
        self.width = k;
        for table in [&mut self.out, &mut self.into] {
            table.clear();
            table.resize(n * k, none);
        }
        // First the reduced costs stand where the costs belong; `limit` is the worst kept into each node.
        self.limit.clear();
        self.limit.resize(n, f64::INFINITY);
        for i in 0..n {
            if pace.spend(4 * n) {
                return false;
            }
            let (row, price) = (closed.row(i), u.get(i).copied().unwrap_or(0.0));
            let mine = &mut self.out[i * k..(i + 1) * k];
            let mut worst = f64::INFINITY;
            for j in 0..n {
                let reduced = row[j] - price - v.get(j).copied().unwrap_or(0.0);
                if reduced < worst && i != j {
                    worst = insert(mine, reduced, j as u32);
                }
                if reduced < self.limit[j] && i != j {
                    self.limit[j] = insert(&mut self.into[j * k..(j + 1) * k], reduced, i as u32);
                }
            }
        }
        for node in 0..n {
            if pace.spend(40 * k) {
                return false;
            }
            let out = &mut self.out[node * k..(node + 1) * k];
            for arc in out.iter_mut() {
                arc.cost = closed.cost(node, arc.node as usize);
            }
            sort(out);
            let into = &mut self.into[node * k..(node + 1) * k];
            for arc in into.iter_mut() {
                arc.cost = closed.cost(arc.node as usize, node);
            }
            sort(into);
        }
        true
    }

    /// Arcs out of a node, cheapest first.
    #[inline]
    pub(crate) fn heads(&self, node: u32) -> &[Arc] {
        let i = node as usize * self.width;
        &self.out[i..i + self.width]
    }

    /// Arcs into a node, cheapest first.
    #[inline]
    pub(crate) fn tails(&self, node: u32) -> &[Arc] {
        let i = node as usize * self.width;
        &self.into[i..i + self.width]
    }

    /// Mean difference of the two directions over mean cost, over candidate arcs that are allowed both ways.
    pub(crate) fn asymmetry(&self, closed: &Closed) -> f64 {
        let (mut difference, mut sum) = (0.0, 0.0);
        for node in 0..closed.n {
            for arc in self.heads(node as u32) {
                let back = closed.cost(arc.node as usize, node);
                if arc.cost < closed.forbidden && back < closed.forbidden {
                    difference += (arc.cost - back).abs();
                    sum += arc.cost.max(back);
                }
            }
        }
        if sum > 0.0 { difference / sum } else { 0.0 }
    }
}

/// Puts an arc in its place and drops the last; the new worst.
#[inline]
fn insert(arcs: &mut [Arc], cost: f64, node: u32) -> f64 {
    let mut k = arcs.len() - 1;
    while k > 0 && arcs[k - 1].cost > cost {
        arcs[k] = arcs[k - 1];
        k -= 1;
    }
    arcs[k] = Arc { cost, node };
    arcs[arcs.len() - 1].cost
}

/// Insertion sort by cost, then node.
fn sort(arcs: &mut [Arc]) {
    for i in 1..arcs.len() {
        let arc = arcs[i];
        let mut k = i;
        while k > 0 && (arcs[k - 1].cost, arcs[k - 1].node) > (arc.cost, arc.node) {
            arcs[k] = arcs[k - 1];
            k -= 1;
        }
        arcs[k] = arc;
    }
}
