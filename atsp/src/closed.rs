//! Every problem form as a closed tour with finite, non-negative costs, without arbitrary big numbers.
//!
//! - fixed start and end: both become one node, with the costs out of the start and into the end;
//! - fixed start, free end: going back to the start costs nothing;
//! - forbidden arcs: more than any tour without them, so that the search may pass through them but never ends on one;
//! - negative costs: every arc out of a node is raised by the same amount, which moves every tour alike.

use crate::cost::CostModel;
use crate::error::Error;
use crate::problem::Problem;

/// A closed tour over the nodes `0..n` that starts at node 0, and how to read it back.
#[derive(Debug, Default)]
pub(crate) struct Closed {
    /// Number of nodes.
    pub(crate) n: usize,
    /// Row-major costs, at least zero. The diagonal and forbidden arcs hold [`forbidden`](Self::forbidden).
    pub(crate) costs: Vec<f64>,
    /// Cost of a forbidden arc: above any tour without one.
    pub(crate) forbidden: f64,
    /// What was added to every tour to make the costs non-negative.
    pub(crate) raised: f64,
    /// True where the order has ends: node 0 of the closed tour then stands for them.
    pub(crate) is_path: bool,
    /// Original node of each closed node; closed node 0 is the start.
    nodes: Vec<usize>,
    /// Closed node of each original node; the fixed end has none.
    closed_of: Vec<u32>,
    /// Appended when the order is read back.
    end: Option<usize>,
}

const NONE: u32 = u32::MAX;

impl Closed {
    /// Maps the nodes of a problem over `len` nodes; the problem's are in range.
    pub(crate) fn map(&mut self, problem: Problem, len: usize) {
        let (start, end) = match problem {
            Problem::Closed => (0, None),
            Problem::Open { start } => (start, None),
            Problem::Path { start, end } => (start, (end != start).then_some(end)),
        };
        self.end = end;
        self.is_path = match problem {
            Problem::Closed => false,
            Problem::Open { .. } => true,
            Problem::Path { start, end } => start != end,
        };
        self.nodes.clear();
        self.nodes.push(start);
        self.nodes
            .extend((0..len).filter(|&n| n != start && Some(n) != end));
        self.closed_of.clear();
        self.closed_of.resize(len, NONE);
        for (i, &node) in self.nodes.iter().enumerate() {
            self.closed_of[node] = i as u32;
        }
        self.n = self.nodes.len();
    }

    /// Whether allowed arcs lead from node 0 to every node and back: without that there is no tour.
    pub(crate) fn is_connected(&self) -> bool {
        let n = self.n;
        let reaches_all = |arc: &dyn Fn(usize, usize) -> f64| {
            let mut reached = vec![false; n];
            let mut open = vec![0];
            reached[0] = true;
            while let Some(from) = open.pop() {
                for to in 0..n {
                    if !reached[to] && arc(from, to) < self.forbidden {
                        reached[to] = true;
                        open.push(to);
                    }
                }
            }
            reached.into_iter().all(|r| r)
        };
        reaches_all(&|a, b| self.costs[a * n + b]) && reaches_all(&|a, b| self.costs[b * n + a])
    }

    /// The cost of an arc between two different closed nodes, asked of the caller.
    #[inline]
    pub(crate) fn ask(&self, model: &impl CostModel, from: usize, to: usize) -> f64 {
        if to > 0 {
            model.cost(self.nodes[from], self.nodes[to])
        } else if let Some(end) = self.end {
            model.cost(self.nodes[from], end)
        } else if self.is_path {
            0.0
        } else {
            model.cost(self.nodes[from], self.nodes[0])
        }
    }

    /// Copies the costs, once.
    ///
    /// Asks `stop` now and then; answers `Ok(false)`, with nothing usable copied, when it said so.
    ///
    /// # Errors
    /// [`Error::BadCost`], [`Error::Overflow`].
    pub(crate) fn load(
        &mut self,
        model: &impl CostModel,
        stop: &mut dyn FnMut() -> bool,
    ) -> Result<bool, Error> {
        let n = self.n;
        self.costs.clear();
        self.costs.reserve(n * n);
        let (mut span, mut lowest, mut has_forbidden) = (0.0, 0.0f64, false);
        // A few thousand costs between two questions.
        let rows = 4096_usize.div_ceil(n);
        for i in 0..n {
            if i % rows == rows - 1 && stop() {
                return Ok(false);
            }
            let row = self.costs.len();
            let from = self.nodes[i];
            let home = if i == 0 {
                f64::INFINITY
            } else {
                self.ask(model, i, 0)
            };
            self.costs.push(home);
            self.costs
                .extend(self.nodes[1..].iter().map(|&to| model.cost(from, to)));
            self.costs[row + i] = f64::INFINITY;
            let mut largest = 0.0f64;
            let (mut sound, mut infinite) = (true, 0);
            for &cost in &self.costs[row..] {
                let size = if cost == f64::INFINITY {
                    infinite += 1;
                    0.0
                } else {
                    cost.abs()
                };
                sound &= size < f64::INFINITY;
                lowest = if cost < lowest { cost } else { lowest };
                largest = if size > largest { size } else { largest };
            }
            // The diagonal is one of them.
            has_forbidden |= infinite > 1;
            if !sound {
                return Err(self.bad_cost(i));
            }
            span += largest;
        }
        if lowest < 0.0 {
            span += self.raise();
        } else {
            self.raised = 0.0;
        }
        // Above any sum of finite arcs, on the scale of the costs themselves: doubling them doubles it.
        self.forbidden = if span > 0.0 { 3.0 * span } else { 1.0 };
        if !(self.forbidden * 4.0 * n as f64).is_finite() {
            return Err(Error::Overflow);
        }
        for i in 0..n {
            self.costs[i * n + i] = self.forbidden;
        }
        if has_forbidden {
            for cost in &mut self.costs {
                if *cost == f64::INFINITY {
                    *cost = self.forbidden;
                }
            }
        }
        Ok(true)
    }

    /// Adds to each row what makes its lowest cost zero, if that is negative; the sum of the additions.
    fn raise(&mut self) -> f64 {
        self.raised = 0.0;
        for row in self.costs.chunks_exact_mut(self.n) {
            let lowest = row.iter().fold(0.0, |a: f64, &c| a.min(c));
            if lowest < 0.0 {
                self.raised -= lowest;
                row.iter_mut().for_each(|c| *c -= lowest);
            }
        }
        self.raised
    }

    /// Names the first NaN or negative infinity of the row copied last.
    fn bad_cost(&self, row: usize) -> Error {
        let costs = &self.costs[row * self.n..];
        let column = costs
            .iter()
            .position(|c| c.is_nan() || *c == f64::NEG_INFINITY)
            .unwrap_or(0);
        Error::BadCost {
            from: self.nodes[row],
            to: if column == 0 {
                self.end.unwrap_or(self.nodes[0])
            } else {
                self.nodes[column]
            },
            cost: costs[column],
        }
    }

    /// The costs out of a node.
    #[inline]
    pub(crate) fn row(&self, from: usize) -> &[f64] {
        &self.costs[from * self.n..(from + 1) * self.n]
    }

    /// The cost of one arc.
    #[inline]
    pub(crate) fn cost(&self, from: usize, to: usize) -> f64 {
        self.costs[from * self.n + to]
    }

    /// The cost of a closed tour.
    pub(crate) fn along(&self, tour: &[u32]) -> f64 {
        let Some(&last) = tour.last() else { return 0.0 };
        let mut from = last as usize;
        let mut sum = 0.0;
        if self.n > 1 {
            for &node in tour {
                sum += self.cost(from, node as usize);
                from = node as usize;
            }
        }
        sum
    }

    /// True for the cost of a tour that uses no forbidden arc.
    #[inline]
    pub(crate) fn is_allowed(&self, cost: f64) -> bool {
        cost < self.forbidden
    }

    /// The order over original nodes of a closed tour, from the start on.
    pub(crate) fn read_back(&self, tour: &[u32]) -> Vec<usize> {
        let zero = tour.iter().position(|&node| node == 0).unwrap_or(0);
        let mut order = Vec::with_capacity(tour.len() + 1);
        order.extend(
            tour[zero..]
                .iter()
                .chain(&tour[..zero])
                .map(|&i| self.nodes[i as usize]),
        );
        order.extend(self.end);
        order
    }

    /// Closed node of an original node, if there is one.
    pub(crate) fn closed_of(&self, node: usize) -> Option<u32> {
        self.closed_of.get(node).copied().filter(|&c| c != NONE)
    }
}
