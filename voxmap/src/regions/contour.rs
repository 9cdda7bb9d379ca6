//! Contours of a set of cells: border tracing, simplification, hull bridges.

/// A closed contour in corner coordinates (the cell x, y has corners x..x+1, y..y+1), inside on the left.
#[derive(Clone, Debug)]
pub(crate) struct Contour {
    pub points: Vec<[f64; 2]>,
    /// True for the border of a hole.
    pub hole: bool,
}

/// Traces all contours of the cells for which `inside` holds within `size`.
pub(crate) fn trace(inside: &impl Fn(i32, i32) -> bool, cells: &[(i32, i32)]) -> Vec<Contour> {
    use std::collections::BTreeMap;
    // Border edges from corner to corner with the inside on the left; a corner has at most two leaving edges.
    let mut edges: BTreeMap<(i32, i32), Vec<(i32, i32)>> = BTreeMap::new();
    for &(x, y) in cells {
        for (outside, from, to) in [
            ((x, y - 1), (x, y), (x + 1, y)),
            ((x + 1, y), (x + 1, y), (x + 1, y + 1)),
            ((x, y + 1), (x + 1, y + 1), (x, y + 1)),
            ((x - 1, y), (x, y + 1), (x, y)),
        ] {
            if !inside(outside.0, outside.1) {
                edges.entry(from).or_default().push(to);
            }
        }
    }
    let mut contours = Vec::new();
    while let Some((&start, _)) = edges.first_key_value() {
        let mut points = vec![start];
        let mut at = start;
        let mut heading = (0, 0);
        while let Some(next) = take(&mut edges, at, heading) {
            let step = (next.0 - at.0, next.1 - at.1);
            if step == heading {
                points.pop();
            }
            points.push(next);
            heading = step;
            at = next;
            if at == start {
                break;
            }
        }
        points.pop();
        let area: i64 = (0..points.len())
            .map(|i| {
                let (a, b) = (points[i], points[(i + 1) % points.len()]);
                i64::from(a.0) * i64::from(b.1) - i64::from(b.0) * i64::from(a.1)
            })
            .sum();
        let points = points
            .iter()
            .map(|p| [f64::from(p.0), f64::from(p.1)])
            .collect();
        contours.push(Contour {
            points,
            hole: area < 0,
        });
    }
    contours
}

/// Removes and returns the edge out of a corner; where two leave, the sharpest left turn, so that cells that touch only at
/// a corner get contours of their own.
fn take(
    edges: &mut std::collections::BTreeMap<(i32, i32), Vec<(i32, i32)>>,
    at: (i32, i32),
    heading: (i32, i32),
) -> Option<(i32, i32)> {
    let out = edges.get_mut(&at)?;
    let mut best = 0;
    for i in 1..out.len() {
        let left = |to: (i32, i32)| heading.0 * (to.1 - at.1) - heading.1 * (to.0 - at.0);
        if left(out[i]) > left(out[best]) {
            best = i;
        }
    }
    let next = out.swap_remove(best);
    if out.is_empty() {
        edges.remove(&at);
    }
    Some(next)
}

pub(crate) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Nearest point of a segment.
pub(crate) fn foot(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let way = [b[0] - a[0], b[1] - a[1]];
    let square = way[0] * way[0] + way[1] * way[1];
    if square == 0.0 {
        return a;
    }
    let t = ((p[0] - a[0]) * way[0] + (p[1] - a[1]) * way[1]) / square;
    let t = t.clamp(0.0, 1.0);
    [a[0] + t * way[0], a[1] + t * way[1]]
}

/// Douglas-Peucker on a closed contour, cut open at its two mutually far vertices.
pub(crate) fn simplify(points: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    let n = points.len();
    if n <= 4 {
        return points.to_vec();
    }
    let far = |from: usize| {
        let mut best = 0;
        for i in 1..n {
            if distance(points[from], points[i]) > distance(points[from], points[best]) {
                best = i;
            }
        }
        best
    };
    let a = far(0);
    let b = far(a);
    let (a, b) = (a.min(b), a.max(b));
    let mut keep = vec![false; n];
    keep[a] = true;
    keep[b] = true;
    let mut open = vec![(a, b), (b, a + n)];
    while let Some((from, to)) = open.pop() {
        let (p, q) = (points[from % n], points[to % n]);
        let (mut worst, mut at) = (tolerance, None);
        for i in from + 1..to {
            let r = points[i % n];
            let d = distance(r, foot(r, p, q));
            if d > worst {
                (worst, at) = (d, Some(i));
            }
        }
        if let Some(i) = at {
            keep[i % n] = true;
            open.push((from, i));
            open.push((i, to));
        }
    }
    (0..n).filter(|&i| keep[i]).map(|i| points[i]).collect()
}

/// Distance of each vertex of an outer contour to the hull edge that bridges its pocket; 0 on the hull.
pub(crate) fn concavity(points: &[[f64; 2]]) -> Vec<f64> {
    let n = points.len();
    let on_hull = hull(points);
    let mut depth = vec![0.0; n];
    let corners: Vec<usize> = (0..n).filter(|&i| on_hull[i]).collect();
    for (k, &from) in corners.iter().enumerate() {
        let to = corners[(k + 1) % corners.len()];
        let to = if to <= from { to + n } else { to };
        for i in from + 1..to {
            let p = points[i % n];
            depth[i % n] = distance(p, foot(p, points[from], points[to % n]));
        }
    }
    depth
}

/// Which vertices are corners of the convex hull (monotone chain).
fn hull(points: &[[f64; 2]]) -> Vec<bool> {
    let n = points.len();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| {
        points[i][0]
            .total_cmp(&points[j][0])
            .then(points[i][1].total_cmp(&points[j][1]))
            .then(i.cmp(&j))
    });
    let turn = |a: usize, b: usize, c: usize| {
        let (p, q, r) = (points[a], points[b], points[c]);
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    let mut on = vec![false; n];
    for reverse in [false, true] {
        let mut chain: Vec<usize> = Vec::new();
        for k in 0..n {
            let i = if reverse { order[n - 1 - k] } else { order[k] };
            while chain.len() >= 2 && turn(chain[chain.len() - 2], chain[chain.len() - 1], i) <= 0.0
            {
                chain.pop();
            }
            chain.push(i);
        }
        for i in chain {
            on[i] = true;
        }
    }
    on
}
