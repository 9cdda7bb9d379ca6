//! FLAP's planner: utility-greedy construction (eq. 6) inside a depth-first branch and bound with a depth limit psi, a
//! branch limit phi and optional pruning of dominated views (eq. 7).

use crate::belief::probability_of;
use crate::task::Task;

/// Limits of the branch and bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// Depth above which every node has one child (psi); 0 is greedy.
    pub depth_limit: usize,
    /// Views whose inverse utility exceeds the best one's by more than this factor are not branched on (phi); 1 is greedy.
    pub branch_limit: f64,
    /// Drop views that an already expanded sibling dominates (xi): larger probability and smaller time.
    pub prune_dominated: bool,
    /// Nodes to expand at most.
    pub expansions: u64,
}

impl Default for Params {
    /// psi = 2, phi = 1.3, xi = 1: the deterministic setting of FLAP's experiments.
    fn default() -> Self {
        Self {
            depth_limit: 2,
            branch_limit: 1.3,
            prune_dominated: true,
            expansions: 1_000_000,
        }
    }
}

/// How a planning call ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The limits' whole tree was searched.
    Finished,
    /// The expansions ran out; the plan is the best so far.
    BudgetExhausted,
}

/// An order of views.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Views in order; empty when no view shows anything.
    pub sequence: Vec<usize>,
    /// Expected time of the sequence, s (FLAP eq. 4).
    pub expected_time: f64,
    /// Probability that the sequence sees the target (FLAP eq. 8).
    pub probability: f64,
    /// How the call ended.
    pub status: Status,
    /// Nodes expanded.
    pub expansions: u64,
}

/// The greedy sequence: always the view with the largest probability of new cells per second (FLAP eq. 6).
pub fn greedy(task: &Task) -> Plan {
    plan(
        task,
        &Params {
            depth_limit: 0,
            branch_limit: 1.0,
            ..Params::default()
        },
    )
}

/// Plans a sequence of views.
pub fn plan(task: &Task, params: &Params) -> Plan {
    let gains = task
        .views
        .iter()
        .map(|v| v.cells.iter().map(|&c| task.weights[c]).sum())
        .collect();
    let left = task.views.iter().map(|v| v.cells.len()).collect();
    let mut search = Search {
        task,
        params,
        covered: vec![false; task.weights.len()],
        sequence: Vec::new(),
        best: None,
        expansions: 0,
        exhausted: false,
    };
    search.expand(&Node {
        gains,
        left,
        expected: 0.0,
        weight: 0.0,
    });
    let sequence = search.best.map_or_else(Vec::new, |b| b.1);
    let value = task.evaluate(&sequence);
    Plan {
        sequence,
        expected_time: value.expected_time,
        probability: value.probability,
        status: if search.exhausted {
            Status::BudgetExhausted
        } else {
            Status::Finished
        },
        expansions: search.expansions,
    }
}

/// What is left at one depth.
struct Node {
    /// Uncovered weight of each view.
    gains: Vec<f64>,
    /// Uncovered cells of each view.
    left: Vec<usize>,
    expected: f64,
    weight: f64,
}

struct Search<'a> {
    task: &'a Task,
    params: &'a Params,
    covered: Vec<bool>,
    sequence: Vec<usize>,
    best: Option<(f64, Vec<usize>)>,
    expansions: u64,
    exhausted: bool,
}

impl Search<'_> {
    fn accept(&mut self, expected: f64) {
        if self.best.as_ref().is_none_or(|(best, _)| expected < *best) {
            self.best = Some((expected, self.sequence.clone()));
        }
    }

    /// Depth is bounded by the number of views, since every step covers a new cell.
    fn expand(&mut self, node: &Node) {
        if self.expansions >= self.params.expansions && self.best.is_some() {
            self.exhausted = true;
            return;
        }
        self.expansions += 1;
        if node.weight > self.task.goal_weight() {
            return self.accept(node.expected);
        }
        let last = self.sequence.last().copied();
        // (inverse utility, probability, seconds, view)
        let mut children: Vec<(f64, f64, f64, usize)> = (0..self.task.len())
            .filter(|&v| node.left[v] > 0 && node.gains[v] > 0.0)
            .map(|v| {
                let (p, t) = (probability_of(node.gains[v]), self.task.seconds(last, v));
                (t / p, p, t, v)
            })
            .filter(|child| child.2.is_finite())
            .collect();
        if children.is_empty() {
            return self.accept(node.expected);
        }
        children.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.3.cmp(&b.3)));
        let cutoff = self.params.branch_limit.max(1.0) * children[0].0;
        let survival = f64::exp(-node.weight);
        let mut expanded: Vec<(f64, f64)> = Vec::new();
        for &(key, p, t, v) in &children {
            if key > cutoff {
                break;
            }
            let expected = node.expected + survival * t;
            if self.best.as_ref().is_some_and(|(best, _)| expected > *best) {
                continue;
            }
            if self.params.prune_dominated && expanded.iter().any(|&(q, s)| q > p && s < t) {
                continue;
            }
            expanded.push((p, t));
            let (child, newly) = self.cover(node, v, expected);
            self.sequence.push(v);
            self.expand(&child);
            self.sequence.pop();
            for cell in newly {
                self.covered[cell] = false;
            }
            if self.sequence.len() >= self.params.depth_limit || self.exhausted {
                break;
            }
        }
    }

    /// The node below `node` through view `v`, and the cells it covers newly.
    fn cover(&mut self, node: &Node, v: usize, expected: f64) -> (Node, Vec<usize>) {
        let task = self.task;
        let (mut gains, mut left) = (node.gains.clone(), node.left.clone());
        let newly: Vec<usize> = task.views[v]
            .cells
            .iter()
            .copied()
            .filter(|&c| !self.covered[c])
            .collect();
        for &cell in &newly {
            self.covered[cell] = true;
            for &other in &task.shown_by[cell] {
                gains[other] -= task.weights[cell];
                left[other] -= 1;
                if left[other] == 0 {
                    gains[other] = 0.0; // no drift from subtraction
                }
            }
        }
        (
            Node {
                gains,
                left,
                expected,
                weight: node.weight + node.gains[v],
            },
            newly,
        )
    }
}
