//! A flat bounding volume tree over axis-aligned boxes, in f64.

/// Boxes a leaf may hold.
const LEAF: usize = 2;

#[derive(Clone, Debug)]
struct Node {
    low: [f64; 3],
    high: [f64; 3],
    /// Leaf: first entry of `order`; else the left child, the right one follows it... at `right`.
    first: u32,
    /// Entries of a leaf; 0 for inner nodes.
    count: u32,
    right: u32,
}

/// The tree.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

/// An axis-aligned box: low and high corner.
pub(crate) type Aabb = ([f64; 3], [f64; 3]);

impl Tree {
    pub(crate) fn new(boxes: &[Aabb]) -> Self {
        let mut tree = Self {
            nodes: Vec::new(),
            order: (0..boxes.len() as u32).collect(),
        };
        if !boxes.is_empty() {
            tree.build(boxes, 0, boxes.len());
        }
        tree
    }

    fn build(&mut self, boxes: &[Aabb], begin: usize, end: usize) -> u32 {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &i in &self.order[begin..end] {
            let (l, h) = boxes[i as usize];
            for k in 0..3 {
                low[k] = low[k].min(l[k]);
                high[k] = high[k].max(h[k]);
            }
        }
        let id = self.nodes.len();
        self.nodes.push(Node {
            low,
            high,
            first: begin as u32,
            count: 0,
            right: 0,
        });
        if end - begin <= LEAF {
            self.nodes[id].count = (end - begin) as u32;
            return id as u32;
        }
        let size = [0, 1, 2].map(|k| high[k] - low[k]);
        let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
        let key = |&i: &u32| boxes[i as usize].0[axis] + boxes[i as usize].1[axis];
        self.order[begin..end].sort_by(|a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
        let middle = (begin + end) / 2;
        self.build(boxes, begin, middle);
        let right = self.build(boxes, middle, end);
        self.nodes[id].right = right;
        id as u32
    }

    /// Best-first-ish descent: `bound` gives a lower bound of a node's cost, `visit` handles an entry and returns
    /// the cost to beat from then on. Nodes whose bound is not below `best` are skipped.
    pub(crate) fn descend(
        &self,
        mut best: f64,
        bound: impl Fn(&[f64; 3], &[f64; 3]) -> f64,
        mut visit: impl FnMut(usize, f64) -> f64,
    ) {
        let Some(root) = self.nodes.first() else {
            return;
        };
        let mut stack: Vec<(u32, f64)> = Vec::with_capacity(32);
        stack.push((0, bound(&root.low, &root.high)));
        while let Some((id, cost)) = stack.pop() {
            if cost > best {
                continue;
            }
            let node = &self.nodes[id as usize];
            if node.count > 0 {
                let first = node.first as usize;
                for &entry in &self.order[first..first + node.count as usize] {
                    best = visit(entry as usize, best);
                }
                continue;
            }
            let (a, b) = (id + 1, node.right);
            let cost_of = |i: u32| {
                let n = &self.nodes[i as usize];
                bound(&n.low, &n.high)
            };
            let (ca, cb) = (cost_of(a), cost_of(b));
            // The nearer child is pushed last and so comes first.
            let pair = if ca <= cb {
                [(b, cb), (a, ca)]
            } else {
                [(a, ca), (b, cb)]
            };
            stack.extend(pair.into_iter().filter(|&(_, c)| c <= best));
        }
    }
}

/// Where a ray with the given reciprocal direction enters a box, 0 when it starts inside; infinite on a miss.
pub(crate) fn entry(low: &[f64; 3], high: &[f64; 3], origin: &[f64; 3], inverse: &[f64; 3]) -> f64 {
    let (mut near, mut far) = (0.0_f64, f64::INFINITY);
    for k in 0..3 {
        let (a, b) = (
            (low[k] - origin[k]) * inverse[k],
            (high[k] - origin[k]) * inverse[k],
        );
        // A ray along a face gives 0 * inf = NaN, which min and max ignore: the box stays a candidate.
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    if near <= far { near } else { f64::INFINITY }
}

/// Distance between two boxes.
pub(crate) fn gap(a: &Aabb, low: &[f64; 3], high: &[f64; 3]) -> f64 {
    let d = [0, 1, 2].map(|k| (low[k] - a.1[k]).max(a.0[k] - high[k]).max(0.0));
    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
}
