//! A tree in joint space and time, growing forwards from the start or backwards from the goal.

use crate::rng::Rng;
use crate::robot::Robot;
use crate::task::{Timed, distance};

/// A tree; nodes are indices, in order of birth.
#[derive(Clone, Debug)]
pub(crate) struct Tree<const N: usize> {
    /// Grows forwards in time.
    forward: bool,
    q: Vec<[f64; N]>,
    step: Vec<usize>,
    parent: Vec<usize>,
    /// Joint distance from the root.
    cost: Vec<f64>,
    children: Vec<Vec<usize>>,
    /// Nodes of each step.
    layers: Vec<Vec<usize>>,
    /// Nodes that may be grown from: all of a sparse tree's tips and every few on the way, all of a dense one.
    landmarks: Vec<usize>,
    /// Steps and states of the landmarks, side by side for the scan.
    marked: Vec<(usize, [f64; N])>,
    /// Farthest step in the tree's direction of time.
    frontier: usize,
    /// Steps at which growth was blocked, once for each time.
    blocked: Vec<usize>,
}

/// Every how manieth node of a long extension may be grown from.
const SPACING: usize = 4;

impl<const N: usize> Tree<N> {
    pub(crate) fn new(forward: bool, root: [f64; N], last: usize) -> Self {
        let mut tree = Self {
            forward,
            q: Vec::new(),
            step: Vec::new(),
            parent: Vec::new(),
            cost: Vec::new(),
            children: Vec::new(),
            layers: vec![Vec::new(); last + 1],
            landmarks: Vec::new(),
            marked: Vec::new(),
            blocked: Vec::new(),
            frontier: if forward { 0 } else { last },
        };
        let root = tree.add(root, tree.frontier, 0, 0.0);
        tree.mark(root);
        tree
    }

    /// Number of nodes; also the next node's index.
    pub(crate) fn len(&self) -> usize {
        self.q.len()
    }

    /// State and step of a node.
    pub(crate) fn at(&self, node: usize) -> (&[f64; N], usize) {
        (&self.q[node], self.step[node])
    }

    /// Joint distance from the root to a node.
    pub(crate) fn cost(&self, node: usize) -> f64 {
        self.cost[node]
    }

    fn add(&mut self, q: [f64; N], step: usize, parent: usize, cost: f64) -> usize {
        let id = self.q.len();
        self.q.push(q);
        self.step.push(step);
        self.parent.push(parent);
        self.cost.push(cost);
        self.children.push(Vec::new());
        if id != parent {
            self.children[parent].push(id);
        }
        self.layers[step].push(id);
        id
    }

    fn mark(&mut self, id: usize) {
        self.landmarks.push(id);
        self.marked.push((self.step[id], self.q[id]));
        self.frontier = if self.forward {
            self.frontier.max(self.step[id])
        } else {
            self.frontier.min(self.step[id])
        };
    }

    /// A step at which growth was blocked, drawn by how often it was; `None` if it never was.
    pub(crate) fn some_blocked(&self, rng: &mut Rng) -> Option<usize> {
        let n = self.blocked.len();
        (n > 0).then(|| self.blocked[rng.below(n)])
    }

    /// A node that may be grown from, the farthest in time of three drawn.
    pub(crate) fn some_far(&self, rng: &mut Rng) -> usize {
        let n = self.landmarks.len();
        let draws = [rng.below(n), rng.below(n), rng.below(n)].map(|i| self.landmarks[i]);
        let far = |id: &usize| (self.ahead(*id, self.frontier).unwrap_or(0), *id);
        draws.into_iter().min_by_key(far).unwrap_or(0)
    }

    /// Steps from a node to `step` in the tree's direction of time, if there are any.
    fn ahead(&self, node: usize, step: usize) -> Option<usize> {
        let from = self.step[node];
        let n = if self.forward {
            step.checked_sub(from)
        } else {
            from.checked_sub(step)
        };
        n.filter(|&n| n > 0)
    }

    /// The node before `step` (in the tree's time) nearest to `q`: joint distance, plus `weight.0` times what lies beyond the
    /// joints' speeds, plus `weight.1` for each step between. An infinite `weight.0` admits only nodes that can be there in
    /// time.
    pub(crate) fn nearest<R: Robot<N>>(
        &self,
        timed: &Timed<'_, '_, N, R>,
        q: &[f64; N],
        step: usize,
        weight: (f64, f64),
    ) -> Option<usize> {
        let reach = &timed.task.reach;
        let (mut best, mut found) = (f64::INFINITY, None);
        for (index, (at, from)) in self.marked.iter().enumerate() {
            let ahead = if self.forward {
                step as isize - *at as isize
            } else {
                *at as isize - step as isize
            };
            if ahead <= 0 {
                continue;
            }
            let time = ahead as f64;
            let (mut square, mut excess) = (0.0, 0.0f64);
            for j in 0..N {
                let d = (q[j] - from[j]).abs();
                square += d * d;
                excess = excess.max(d - reach[j] * time);
            }
            if square >= best * best {
                continue;
            }
            let mut metric = f64::sqrt(square) + weight.1 * time;
            if excess > 1e-9 && weight.0 > 0.0 {
                metric += weight.0 * excess;
            }
            if metric < best {
                (best, found) = (metric, Some(index));
            }
        }
        found.map(|index| self.landmarks[index])
    }

    /// One step from a node towards `(q, step)`: eq. 5, the speed that would arrive in time, clamped per joint.
    fn towards<R: Robot<N>>(
        &self,
        timed: &Timed<'_, '_, N, R>,
        node: usize,
        q: &[f64; N],
        steps: usize,
    ) -> [f64; N] {
        let (from, task) = (&self.q[node], timed.task);
        std::array::from_fn(|j| {
            if steps == 1 && (q[j] - from[j]).abs() <= task.reach[j] {
                return q[j];
            }
            let even = (q[j] - from[j]) / steps as f64;
            let (low, high) = task.limits[j];
            (from[j] + even.clamp(-task.reach[j], task.reach[j])).clamp(low, high)
        })
    }

    /// Grows from `node` towards `(q, step)`, at most `most` steps, until blocked or there. Returns the last new node.
    pub(crate) fn extend<R: Robot<N>>(
        &mut self,
        timed: &Timed<'_, '_, N, R>,
        mut node: usize,
        q: &[f64; N],
        step: usize,
        most: usize,
        rewire: bool,
    ) -> Option<usize> {
        let mut grown = None;
        for count in 1..=most {
            let Some(steps) = self.ahead(node, step) else {
                break;
            };
            let new = self.towards(timed, node, q, steps);
            let here = self.step[node];
            let next = if self.forward { here + 1 } else { here - 1 };
            if !timed.is_valid(&new, next) || !self.joins(timed, node, &new) {
                self.blocked.push(next);
                break;
            }
            let parent = if rewire {
                self.best_parent(timed, node, &new)
            } else {
                node
            };
            let cost = self.cost[parent] + distance(&self.q[parent], &new);
            let id = self.add(new, next, parent, cost);
            if rewire {
                self.rewire(timed, id);
            }
            if count % SPACING == 0 || most == 1 {
                self.mark(id);
            }
            grown = Some(id);
            node = id;
        }
        if let Some(tip) = grown
            && self.landmarks.last() != Some(&tip)
        {
            self.mark(tip);
        }
        grown
    }

    /// Grows from `node` until `(q, step)` or blocked: at even speed, or as quickly as the joints can and then waiting there.
    /// Returns the last new node.
    pub(crate) fn reach<R: Robot<N>>(
        &mut self,
        timed: &Timed<'_, '_, N, R>,
        node: usize,
        q: &[f64; N],
        step: usize,
        quick: bool,
        rewire: bool,
    ) -> Option<usize> {
        if !quick {
            return self.extend(timed, node, q, step, usize::MAX, rewire);
        }
        let from = &self.q[node];
        let needed = (0..N)
            .map(|j| ((q[j] - from[j]).abs() / timed.task.reach[j] - 1e-9).ceil() as usize)
            .max()
            .unwrap_or(0)
            .clamp(1, self.ahead(node, step)?);
        let early = if self.forward {
            self.step[node] + needed
        } else {
            self.step[node] - needed
        };
        let there = self.extend(timed, node, q, early, usize::MAX, rewire)?;
        if self.step[there] != early || early == step {
            return Some(there);
        }
        self.extend(timed, there, q, step, usize::MAX, rewire)
            .or(Some(there))
    }

    /// True if a free state `q` one step on can be joined to `node`.
    fn joins<R: Robot<N>>(&self, timed: &Timed<'_, '_, N, R>, node: usize, q: &[f64; N]) -> bool {
        let (from, step) = (&self.q[node], self.step[node]);
        if self.forward {
            timed.can_step(from, q, step)
        } else {
            timed.can_step(q, from, step - 1)
        }
    }

    /// The cheapest node of the layer of `node` that can step to `q`; `node` can.
    fn best_parent<R: Robot<N>>(
        &self,
        timed: &Timed<'_, '_, N, R>,
        node: usize,
        q: &[f64; N],
    ) -> usize {
        let through = |id: usize| self.cost[id] + distance(&self.q[id], q);
        let mut best = (through(node), node);
        for &id in &self.layers[self.step[node]] {
            if self.cost[id] < best.0
                && timed.within_reach(&self.q[id], q, 1)
                && through(id) < best.0
                && self.joins(timed, id, q)
            {
                best = (through(id), id);
            }
        }
        best.1
    }

    /// Nodes of the next layer that are cheaper through `id` get it as parent.
    fn rewire<R: Robot<N>>(&mut self, timed: &Timed<'_, '_, N, R>, id: usize) {
        let step = self.step[id];
        let next = if self.forward {
            step + 1
        } else {
            step.wrapping_sub(1)
        };
        let others = self.layers.get(next).map_or(0, Vec::len);
        for k in 0..others {
            let other = self.layers[next][k];
            let q = self.q[other];
            if self.cost[id] >= self.cost[other] || !timed.within_reach(&self.q[id], &q, 1) {
                continue;
            }
            let cost = self.cost[id] + distance(&self.q[id], &q);
            if cost + 1e-12 < self.cost[other] && self.joins(timed, id, &q) {
                let parent = self.parent[other];
                self.children[parent].retain(|&c| c != other);
                self.parent[other] = id;
                self.children[id].push(other);
                self.lower(other, self.cost[other] - cost);
            }
        }
    }

    /// Takes `by` off the cost of a node and all below it.
    fn lower(&mut self, root: usize, by: f64) {
        let mut open = vec![root];
        while let Some(id) = open.pop() {
            self.cost[id] -= by;
            open.extend_from_slice(&self.children[id]);
        }
    }

    /// The states from the root to a node, in the tree's own order.
    pub(crate) fn path_to(&self, mut id: usize) -> Vec<[f64; N]> {
        let mut path = vec![self.q[id]];
        while self.parent[id] != id {
            id = self.parent[id];
            path.push(self.q[id]);
        }
        path.reverse();
        path
    }
}
