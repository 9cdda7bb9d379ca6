//! The cheapest 1-arborescence: one arc into every node, every node reached from node 0.
//!
//! Every tour is one, so its cost bounds tours from below. Edmonds' contraction on dense costs in O(n^2) (Gabow, Galil,
//! Spencer and Tarjan 1986 grow one path the same way): each set of nodes takes its cheapest arc in; a cycle of such
//! sets becomes one set, whose arcs in are cheaper by what its members have already paid. What the sets pay is an
//! optimal solution of the dual program, and gives the reduced costs that [`residual`](Arborescence::residual) returns.

const NONE: u32 = u32::MAX;

/// Workspace and answer. Sets are numbered: below `n` the single nodes, then contracted cycles in order of making.
#[derive(Debug, Default)]
pub(crate) struct Arborescence {
    n: usize,
    /// `into[slot * n + tail]`: cheapest arc from the tail into the set that uses the slot, less what was paid.
    into: Vec<f64>,
    /// The head of that arc.
    head: Vec<u32>,
    /// What each set pays.
    paid: Vec<f64>,
    /// Arc into each set, as tail and head.
    arc: Vec<(u32, u32)>,
    /// Set each set is a part of.
    parent: Vec<u32>,
    slot: Vec<u32>,
    /// Outermost set of each node.
    outer: Vec<u32>,
    is_done: Vec<bool>,
    path: Vec<u32>,
    entered: Vec<bool>,
    /// Tail of the arc into each node, in the answer.
    pub(crate) tail: Vec<u32>,
    /// Arcs out of each node, in the answer.
    pub(crate) degree: Vec<u32>,
    /// For `residual`: nodes set by set, where each set's begin, and how many it has.
    leaves: Vec<u32>,
    begin: Vec<u32>,
    size: Vec<u32>,
    above: Vec<f64>,
}

impl Arborescence {
    /// Finds the cheapest for the costs `costs[from * n + to] - price[from]`; its cost.
    pub(crate) fn solve(&mut self, n: usize, costs: &[f64], price: &[f64]) -> f64 {
        self.start(n, costs, price);
        for node in 1..n {
            let set = self.outer[node];
            if !self.is_done[set as usize] {
                self.path.clear();
                self.path.push(set);
                self.grow();
            }
        }
        self.expand();
        self.paid.iter().sum()
    }

    fn start(&mut self, n: usize, costs: &[f64], price: &[f64]) {
        self.n = n;
        // Column-major, so that a set's arcs in lie side by side.
        self.into.resize(n * n, 0.0);
        self.head.resize(n * n, 0);
        for to in 0..n {
            let into = &mut self.into[to * n..(to + 1) * n];
            for (from, (cost, price)) in into.iter_mut().zip(price).enumerate() {
                *cost = costs[from * n + to] - price;
            }
            into[to] = f64::INFINITY;
            self.head[to * n..(to + 1) * n].fill(to as u32);
        }
        self.paid.clear();
        self.arc.clear();
        self.parent.clear();
        self.slot.clear();
        self.outer.clear();
        self.is_done.clear();
        for node in 0..n as u32 {
            self.add(node);
            self.outer.push(node);
        }
        // The root: its arc in closes the tour and takes no part in the contraction.
        self.enter(0);
        self.is_done[0] = true;
    }

    fn add(&mut self, slot: u32) {
        self.paid.push(0.0);
        self.arc.push((NONE, NONE));
        self.parent.push(NONE);
        self.slot.push(slot);
        self.is_done.push(false);
    }

    /// Gives the set its cheapest arc in; the arc's tail.
    fn enter(&mut self, set: usize) -> usize {
        let n = self.n;
        let slot = self.slot[set] as usize;
        let row = &self.into[slot * n..(slot + 1) * n];
        let least = row
            .iter()
            .fold(f64::INFINITY, |a, &c| if c < a { c } else { a });
        let tail = row.iter().position(|&c| c == least).unwrap_or(0);
        self.paid[set] = least;
        self.arc[set] = (tail as u32, self.head[slot * n + tail]);
        tail
    }

    /// Follows cheapest arcs backwards from the end of the path until it meets a set that the root reaches.
    fn grow(&mut self) {
        while let Some(&set) = self.path.last() {
            let tail = self.enter(set as usize);
            let from = self.outer[tail];
            if self.is_done[from as usize] {
                for &set in &self.path {
                    self.is_done[set as usize] = true;
                }
                return;
            }
            if let Some(at) = self.path.iter().position(|&s| s == from) {
                self.contract(at);
            } else {
                self.path.push(from);
            }
        }
    }

    /// Makes one set of the path's sets from position `at` on.
    fn contract(&mut self, at: usize) {
        let n = self.n;
        let new = self.paid.len() as u32;
        let keep = self.slot[self.path[at] as usize] as usize;
        let paid = self.paid[self.path[at] as usize];
        self.into[keep * n..(keep + 1) * n]
            .iter_mut()
            .for_each(|c| *c -= paid);
        for k in at..self.path.len() {
            let member = self.path[k] as usize;
            self.parent[member] = new;
            if k == at {
                continue;
            }
            let slot = self.slot[member] as usize;
            let paid = self.paid[member];
            for tail in 0..n {
                let cost = self.into[slot * n + tail] - paid;
                if cost < self.into[keep * n + tail] {
                    self.into[keep * n + tail] = cost;
                    self.head[keep * n + tail] = self.head[slot * n + tail];
                }
            }
        }
        self.path.truncate(at);
        self.path.push(new);
        self.add(keep as u32);
        for node in 0..n {
            if self.parent[self.outer[node] as usize] == new {
                self.outer[node] = new;
                self.into[keep * n + node] = f64::INFINITY;
            }
        }
    }

    /// From the outermost sets inwards: the arc into a set replaces those of the members it enters.
    fn expand(&mut self) {
        let sets = self.paid.len();
        self.entered.clear();
        self.entered.resize(sets, false);
        self.tail.clear();
        self.tail.resize(self.n, 0);
        self.degree.clear();
        self.degree.resize(self.n, 0);
        for set in (0..sets).rev() {
            if self.entered[set] {
                continue;
            }
            let (tail, head) = self.arc[set];
            self.tail[head as usize] = tail;
            self.degree[tail as usize] += 1;
            let mut inside = head;
            while inside as usize != set {
                self.entered[inside as usize] = true;
                inside = self.parent[inside as usize];
            }
        }
    }

    /// What is left of each cost after all that is paid for it, at least zero: every tour costs the bound plus what is
    /// left of its arcs, or more. The diagonal is not written.
    pub(crate) fn residual(&mut self, costs: &[f64], price: &[f64], left: &mut [f64]) {
        let n = self.n;
        let sets = self.paid.len();
        // `above[set]`: paid by the set and all sets around it.
        self.above.clear();
        self.above.resize(sets, 0.0);
        self.size.clear();
        self.size.resize(sets, 0);
        for set in (0..sets).rev() {
            let parent = self.parent[set];
            let around = if parent == NONE {
                0.0
            } else {
                self.above[parent as usize]
            };
            self.above[set] = self.paid[set] + around;
        }
        for set in 0..sets {
            if set < n {
                self.size[set] = 1;
            }
            let parent = self.parent[set];
            if parent != NONE {
                self.size[parent as usize] += self.size[set];
            }
        }
        // Nodes in an order in which every set is one stretch.
        self.begin.clear();
        self.begin.resize(sets, 0);
        self.leaves.clear();
        self.leaves.resize(n, 0);
        let mut top = 0;
        // `slot` becomes the next free place inside each set.
        for set in (0..sets).rev() {
            let parent = self.parent[set];
            let next = if parent == NONE {
                &mut top
            } else {
                &mut self.slot[parent as usize]
            };
            self.begin[set] = *next;
            *next += self.size[set];
            self.slot[set] = self.begin[set];
            if set < n {
                self.leaves[self.begin[set] as usize] = set as u32;
            }
        }
        for to in 0..n {
            let total = self.above[to];
            for from in 0..n {
                left[from * n + to] = costs[from * n + to] - price[from] - total;
            }
            // Sets that hold both ends were not crossed.
            let mut inner = to as u32;
            while self.parent[inner as usize] != NONE {
                let set = self.parent[inner as usize];
                let (a, b) = self.stretch(set);
                let (c, d) = self.stretch(inner);
                for k in (a..c).chain(d..b) {
                    let from = self.leaves[k] as usize;
                    left[from * n + to] += self.above[set as usize];
                }
                inner = set;
            }
        }
    }

    fn stretch(&self, set: u32) -> (usize, usize) {
        let begin = self.begin[set as usize] as usize;
        (begin, begin + self.size[set as usize] as usize)
    }
}
