//! The assignment problem by shortest augmenting paths: a lower bound of every closed tour.

use crate::cost::{CostMatrix, CostModel};

/// Cheapest set of cycles that covers every node once, as successor of each node, and its cost.
///
/// `None` if every such set uses a forbidden arc, which proves that no tour exists. O(n^3).
pub(crate) fn assignment(costs: &CostMatrix) -> Option<(Vec<usize>, f64)> {
    let n = costs.len();
    const NONE: usize = usize::MAX;
    let mut row_of = vec![NONE; n + 1]; // row assigned to each column; column n is the virtual root
    let mut u = vec![0.0; n];
    let mut v = vec![0.0; n + 1];
    for row in 0..n {
        row_of[n] = row;
        let mut column = n;
        let mut reach = vec![f64::INFINITY; n];
        let mut from = vec![n; n];
        let mut done = vec![false; n + 1];
        while row_of[column] != NONE {
            done[column] = true;
            let tail = row_of[column];
            let (mut delta, mut next) = (f64::INFINITY, NONE);
            for head in 0..n {
                if done[head] {
                    continue;
                }
                if head != tail {
                    let reduced = costs.cost(tail, head) - u[tail] - v[head];
                    if reduced < reach[head] {
                        reach[head] = reduced;
                        from[head] = column;
                    }
                }
                if reach[head] < delta {
                    (delta, next) = (reach[head], head);
                }
            }
            if next == NONE {
                return None;
            }
            for head in 0..=n {
                if done[head] {
                    u[row_of[head]] += delta;
                    v[head] -= delta;
                } else if head < n {
                    reach[head] -= delta;
                }
            }
            column = next;
        }
        while column != n {
            let previous = from[column];
            row_of[column] = row_of[previous];
            column = previous;
        }
    }
    let mut successor = vec![NONE; n];
    for (column, &row) in row_of[..n].iter().enumerate() {
        successor[row] = column;
    }
    let cost = (0..n).map(|i| costs.cost(i, successor[i])).sum();
    Some((successor, cost))
}
