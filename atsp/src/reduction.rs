//! Every problem form as a closed tour, without big numbers.
//!
//! - fixed start and end: both become one node, with the costs out of the start and into the end;
//! - fixed start, free end: going back to the start costs nothing.

use crate::cost::{CostMatrix, CostModel};
use crate::solve::Problem;

/// A closed tour that starts at node 0, and how to read it back.
pub(crate) struct Reduced {
    /// Costs of the closed tour.
    pub costs: CostMatrix,
    /// Original node of each closed node; closed node 0 is the start.
    nodes: Vec<usize>,
    /// Appended when the order is read back.
    end: Option<usize>,
}

impl Reduced {
    pub(crate) fn new(costs: &CostMatrix, problem: Problem) -> Self {
        let (start, end) = match problem {
            Problem::Closed => (0, None),
            Problem::Open { start } => (start, None),
            Problem::Path { start, end } => (start, (end != start).then_some(end)),
        };
        let mut nodes = vec![start];
        nodes.extend((0..costs.len()).filter(|&n| n != start && Some(n) != end));
        let mut closed = CostMatrix::zeros(nodes.len());
        for (i, &from) in nodes.iter().enumerate() {
            for (j, &to) in nodes.iter().enumerate() {
                if i == j {
                    continue;
                }
                let cost = match problem {
                    Problem::Open { .. } if j == 0 => 0.0,
                    Problem::Path { .. } if j == 0 => costs.cost(from, end.unwrap_or(start)),
                    _ => costs.cost(from, to),
                };
                closed.set(i, j, cost);
            }
        }
        Self {
            costs: closed,
            nodes,
            end,
        }
    }

    /// The order over original nodes of a closed tour that starts at closed node 0.
    pub(crate) fn read_back(&self, tour: &[usize]) -> Vec<usize> {
        tour.iter()
            .map(|&i| self.nodes[i])
            .chain(self.end)
            .collect()
    }

    /// The closed tour of an order over original nodes; unknown and repeated nodes are dropped, missing ones reported.
    pub(crate) fn repair(&self, hint: &[usize]) -> (Vec<usize>, Vec<usize>) {
        let mut seen = vec![false; self.nodes.len()];
        let mut tour = vec![0];
        seen[0] = true;
        for node in hint {
            if let Some(i) = self.nodes.iter().position(|n| n == node)
                && !seen[i]
            {
                seen[i] = true;
                tour.push(i);
            }
        }
        let missing = (0..seen.len()).filter(|&i| !seen[i]).collect();
        (tour, missing)
    }
}
