//! Search where nothing moves: two trees in joint space alone, that grow towards each other (RRT-Connect, Kuffner and LaValle,
//! ICRA 2000), the smaller one first, with nodes that stop answering to far samples once they were blocked (dynamic domain,
//! Yershova et al., ICRA 2005).

use crate::rng::Rng;
use crate::robot::Robot;
use crate::task::{Task, Timed, between, distance, even};

/// Longest edge, as a share of the diagonal of the box that samples come from.
const RANGE: f64 = 0.05;
/// How far from a blocked node samples still count, in longest edges; and the least after many failures.
const DOMAIN: (f64, f64) = (6.0, 2.0);
/// How much a failure or success changes that, as a share.
const ADAPT: f64 = 0.05;
/// Draws for one sample.
const TRIES: usize = 32;
/// Nodes whose distances are computed together.
const LANES: usize = 8;

/// A tree; nodes are indices, in order of birth.
struct Tree<const N: usize> {
    forward: bool,
    q: Vec<[f64; N]>,
    parent: Vec<usize>,
    /// Square of the distance up to which samples count.
    domain: Vec<f64>,
    /// The states again, eight nodes side by side.
    blocks: Vec<[[f64; LANES]; N]>,
}

impl<const N: usize> Tree<N> {
    fn new(forward: bool, root: [f64; N]) -> Self {
        let mut tree = Self {
            forward,
            q: Vec::new(),
            parent: Vec::new(),
            domain: Vec::new(),
            blocks: Vec::new(),
        };
        tree.add(root, 0);
        tree
    }

    fn add(&mut self, q: [f64; N], parent: usize) -> usize {
        let (id, lane) = (self.q.len(), self.q.len() % LANES);
        if lane == 0 {
            self.blocks.push([[f64::INFINITY; LANES]; N]);
        }
        if let Some(block) = self.blocks.last_mut() {
            for j in 0..N {
                block[j][lane] = q[j];
            }
        }
        self.q.push(q);
        self.parent.push(parent);
        self.domain.push(f64::INFINITY);
        id
    }

    /// The node nearest to `q` and the square of its distance; ties go to the lowest of a lane.
    fn nearest(&self, q: &[f64; N]) -> (usize, f64) {
        let (mut least, mut found) = ([f64::INFINITY; LANES], [0usize; LANES]);
        for (index, block) in self.blocks.iter().enumerate() {
            let mut squares = [0.0; LANES];
            for j in 0..N {
                for l in 0..LANES {
                    let d = block[j][l] - q[j];
                    squares[l] += d * d;
                }
            }
            for l in 0..LANES {
                if squares[l] < least[l] {
                    (least[l], found[l]) = (squares[l], index);
                }
            }
        }
        let mut best = (found[0] * LANES, least[0]);
        for l in 1..LANES {
            if least[l] < best.1 {
                best = (found[l] * LANES + l, least[l]);
            }
        }
        best
    }

    /// Adds `q` below `node` if the way between them is free.
    fn join<R: Robot<N>>(
        &mut self,
        timed: &Timed<'_, '_, N, R>,
        node: usize,
        q: &[f64; N],
    ) -> Option<usize> {
        let from = &self.q[node];
        let free = if self.forward {
            timed.edge_is_free(&timed.swift(from, q), true)
        } else {
            timed.edge_is_free(&timed.swift(q, from), false)
        };
        free.then(|| self.add(*q, node))
    }

    fn blocked(&mut self, node: usize, range: f64) {
        let (most, least) = (DOMAIN.0 * range, DOMAIN.1 * range);
        let domain = &mut self.domain[node];
        *domain = if domain.is_finite() {
            (*domain * (1.0 - ADAPT)).max(least * least)
        } else {
            most * most
        };
    }

    /// Waypoints from the root to a node.
    fn path_to(&self, mut id: usize) -> Vec<[f64; N]> {
        let mut path = vec![self.q[id]];
        while id != 0 {
            id = self.parent[id];
            path.push(self.q[id]);
        }
        path.reverse();
        path
    }
}

/// Two trees under way.
pub(crate) struct Still<const N: usize> {
    trees: [Tree<N>; 2],
    /// Joint angles that samples come from, rad.
    span: [(f64, f64); N],
    /// Longest edge, rad.
    range: f64,
    pub(crate) samples: usize,
}

impl<const N: usize> Still<N> {
    /// Paths may take up to `most` steps.
    pub(crate) fn new<R: Robot<N>>(task: &Task<'_, N, R>, most: usize) -> Self {
        let span: [(f64, f64); N] = std::array::from_fn(|j| {
            let ((low, high), far) = (task.limits[j], task.reach[j] * most as f64);
            let (least, greatest) = (
                task.start[j].min(task.goal[j]),
                task.start[j].max(task.goal[j]),
            );
            // What lies farther from an end is out of reach.
            (low.max(greatest - far), high.min(least + far))
        });
        let diagonal = span.iter().map(|s| (s.1 - s.0) * (s.1 - s.0)).sum::<f64>();
        Self {
            trees: [Tree::new(true, task.start), Tree::new(false, task.goal)],
            span,
            range: RANGE * diagonal.sqrt(),
            samples: 0,
        }
    }

    /// Draws one sample; returns a path if the trees meet: one state per step, as quick as the joints are.
    pub(crate) fn iterate<R: Robot<N>>(
        &mut self,
        timed: &Timed<'_, '_, N, R>,
        bound: f64,
        rng: &mut Rng,
    ) -> Option<Vec<[f64; N]>> {
        self.samples += 1;
        let range = self.range;
        let (here, there) = if self.trees[0].q.len() <= self.trees[1].q.len() {
            (0, 1)
        } else {
            (1, 0)
        };
        let tree = &mut self.trees[here];
        let (mut q, mut near, mut far) = (timed.task.start, 0, 0.0);
        for _ in 0..TRIES {
            q = self
                .span
                .map(|(low, high)| low + rng.unit() * (high - low).max(0.0));
            if distance(&q, &timed.task.start) + distance(&q, &timed.task.goal) >= bound {
                continue; // no shorter path leads through here
            }
            let (node, square) = tree.nearest(&q);
            (near, far) = (node, square.sqrt());
            if square <= tree.domain[node] {
                break;
            }
        }
        if far > range {
            q = between(&tree.q[near], &q, range / far);
        }
        let Some(tip) = tree.join(timed, near, &q) else {
            tree.blocked(near, range);
            return None;
        };
        tree.domain[near] *= 1.0 + ADAPT;
        let other = &mut self.trees[there];
        let (mut met, square) = other.nearest(&q);
        let (from, pieces) = (
            other.q[met],
            (square.sqrt() / range).ceil().max(1.0) as usize,
        );
        for piece in &even(&from, &q, pieces)[1..] {
            met = other.join(timed, met, piece)?;
        }
        let (forward, backward) = if here == 0 { (tip, met) } else { (met, tip) };
        let mut corners = self.trees[0].path_to(forward);
        corners.extend(self.trees[1].path_to(backward).iter().rev().skip(1));
        let mut path = vec![timed.task.start];
        for pair in corners.windows(2) {
            path.extend_from_slice(&timed.swift(&pair[0], &pair[1])[1..]);
        }
        Some(path)
    }
}
