//! A tree in joint space and time, growing forwards from the start or backwards from the goal.

use crate::line::{Task, distance};
use crate::robot::Robot;

/// A state at a step.
#[derive(Clone, Debug)]
pub(crate) struct Node<const N: usize> {
    pub q: [f64; N],
    pub step: usize,
    pub parent: usize,
    /// Joint distance from the root.
    pub cost: f64,
    children: Vec<usize>,
}

/// Grows forwards (`true`) or backwards in time.
#[derive(Clone, Debug)]
pub(crate) struct Tree<const N: usize> {
    pub forward: bool,
    pub nodes: Vec<Node<N>>,
    /// Nodes of each step.
    layers: Vec<Vec<usize>>,
}

impl<const N: usize> Tree<N> {
    pub(crate) fn new(forward: bool, root: [f64; N], last: usize) -> Self {
        let step = if forward { 0 } else { last };
        let mut tree = Self {
            forward,
            nodes: Vec::new(),
            layers: vec![Vec::new(); last + 1],
        };
        tree.add(root, step, 0, 0.0);
        tree
    }

    fn add(&mut self, q: [f64; N], step: usize, parent: usize, cost: f64) -> usize {
        let id = self.nodes.len();
        self.nodes.push(Node {
            q,
            step,
            parent,
            cost,
            children: Vec::new(),
        });
        if id != parent {
            self.nodes[parent].children.push(id);
        }
        self.layers[step].push(id);
        id
    }

    /// Steps from a node to `step` in the tree's direction of time, if there are any.
    fn ahead(&self, node: usize, step: usize) -> Option<usize> {
        let from = self.nodes[node].step;
        let n = if self.forward {
            step.checked_sub(from)
        } else {
            from.checked_sub(step)
        };
        n.filter(|&n| n > 0)
    }

    /// The node before `step` (in the tree's time) nearest to `q`: joint distance, plus what lies beyond the joints' speeds,
    /// weighted.
    pub(crate) fn nearest<R: Robot<N>>(
        &self,
        task: &Task<'_, N, R>,
        q: &[f64; N],
        step: usize,
    ) -> Option<usize> {
        let mut best: Option<(f64, usize)> = None;
        for id in 0..self.nodes.len() {
            let Some(n) = self.ahead(id, step) else {
                continue;
            };
            let node = &self.nodes[id];
            let mut excess = 0.0f64;
            for j in 0..N {
                excess = excess.max((q[j] - node.q[j]).abs() - task.reach[j] * n as f64);
            }
            let metric = distance(&node.q, q) + 10.0 * excess.max(0.0);
            if best.is_none_or(|b| metric < b.0) {
                best = Some((metric, id));
            }
        }
        best.map(|b| b.1)
    }

    /// One step from a node towards `(q, step)`: eq. 5, the speed that would arrive in time, clamped per joint.
    fn towards<R: Robot<N>>(
        &self,
        task: &Task<'_, N, R>,
        node: usize,
        q: &[f64; N],
        steps: usize,
    ) -> [f64; N] {
        let from = &self.nodes[node].q;
        std::array::from_fn(|j| {
            let even = (q[j] - from[j]) / steps as f64;
            let (low, high) = task.limits[j];
            (from[j] + even.clamp(-task.reach[j], task.reach[j])).clamp(low, high)
        })
    }

    /// Grows from `node` towards `(q, step)`, at most `most` steps, until blocked or there. Returns the new nodes in order.
    pub(crate) fn extend<R: Robot<N>>(
        &mut self,
        task: &Task<'_, N, R>,
        mut node: usize,
        q: &[f64; N],
        step: usize,
        most: usize,
        rewire: bool,
    ) -> Vec<usize> {
        let mut grown = Vec::new();
        while grown.len() < most {
            let Some(steps) = self.ahead(node, step) else {
                break;
            };
            let new = self.towards(task, node, q, steps);
            let here = self.nodes[node].step;
            let next = if self.forward { here + 1 } else { here - 1 };
            if !self.can_step(task, node, &new, next) {
                break;
            }
            let parent = if rewire {
                self.best_parent(task, node, &new, next)
            } else {
                node
            };
            let cost = self.nodes[parent].cost + distance(&self.nodes[parent].q, &new);
            let id = self.add(new, next, parent, cost);
            if rewire {
                self.rewire(task, id);
            }
            grown.push(id);
            node = id;
        }
        grown
    }

    fn can_step<R: Robot<N>>(
        &self,
        task: &Task<'_, N, R>,
        node: usize,
        q: &[f64; N],
        step: usize,
    ) -> bool {
        let from = &self.nodes[node];
        if self.forward {
            task.can_step(&from.q, q, from.step)
        } else {
            // Backwards: `q` comes first in time, and it is `q` that must be shown free.
            task.within_reach(q, &from.q, 1)
                && task.is_valid(q, step)
                && (step < task.grace
                    || task.robot.is_motion_valid(
                        q,
                        &from.q,
                        task.base_step(step),
                        task.base_step(from.step),
                    ))
        }
    }

    /// The cheapest node of the layer before that can step to `q`; `node` can.
    fn best_parent<R: Robot<N>>(
        &self,
        task: &Task<'_, N, R>,
        node: usize,
        q: &[f64; N],
        step: usize,
    ) -> usize {
        let through = |id: usize| self.nodes[id].cost + distance(&self.nodes[id].q, q);
        let mut best = (through(node), node);
        for &id in &self.layers[self.nodes[node].step] {
            let cost = through(id);
            if cost < best.0
                && task.within_reach(&self.nodes[id].q, q, 1)
                && self.can_step(task, id, q, step)
            {
                best = (cost, id);
            }
        }
        best.1
    }

    /// Nodes of the next layer that are cheaper through `id` get it as parent.
    fn rewire<R: Robot<N>>(&mut self, task: &Task<'_, N, R>, id: usize) {
        let step = self.nodes[id].step;
        let next = if self.forward {
            step + 1
        } else {
            step.wrapping_sub(1)
        };
        let Some(layer) = self.layers.get(next) else {
            return;
        };
        for other in layer.clone() {
            let q = self.nodes[other].q;
            let cost = self.nodes[id].cost + distance(&self.nodes[id].q, &q);
            if cost + 1e-12 < self.nodes[other].cost && self.can_step(task, id, &q, next) {
                let parent = self.nodes[other].parent;
                self.nodes[parent].children.retain(|&c| c != other);
                self.nodes[other].parent = id;
                self.nodes[id].children.push(other);
                self.lower(other, self.nodes[other].cost - cost);
            }
        }
    }

    /// Takes `by` off the cost of a node and all below it.
    fn lower(&mut self, root: usize, by: f64) {
        let mut open = vec![root];
        while let Some(id) = open.pop() {
            self.nodes[id].cost -= by;
            open.extend_from_slice(&self.nodes[id].children);
        }
    }

    /// The states from the root to a node, in the tree's own order.
    pub(crate) fn path_to(&self, mut id: usize) -> Vec<[f64; N]> {
        let mut path = vec![self.nodes[id].q];
        while self.nodes[id].parent != id {
            id = self.nodes[id].parent;
            path.push(self.nodes[id].q);
        }
        path.reverse();
        path
    }
}
