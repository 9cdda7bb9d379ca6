//! Convex polygons: covers, margins, edges.

use crate::Error;

/// Circles that together cover a convex polygon: it is cut into slabs across its longer side, one circle for each.
pub(crate) fn cover(corners: &[[f64; 2]]) -> Vec<([f64; 2], f64)> {
    const SLABS: usize = 6;
    if corners.is_empty() {
        return Vec::new();
    }
    let span = |axis: usize| {
        let values = corners.iter().map(|c| c[axis]);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        (low, values.fold(f64::NEG_INFINITY, f64::max))
    };
    let spans = [span(0), span(1)];
    let long = usize::from(spans[1].1 - spans[1].0 > spans[0].1 - spans[0].0);
    let (low, high) = spans[long];
    let slabs = (0..SLABS).filter_map(|k| {
        let at = |k: usize| low + (high - low) * k as f64 / SLABS as f64;
        let part = clipped(&clipped(corners, long, at(k), 1.0), long, at(k + 1), -1.0);
        let mut middle = [0.0; 2];
        for axis in 0..2 {
            let values = part.iter().map(|c| c[axis]);
            let low = values.clone().fold(f64::INFINITY, f64::min);
            middle[axis] = 0.5 * (low + values.fold(f64::NEG_INFINITY, f64::max));
        }
        let far = |c: &[f64; 2]| (c[0] - middle[0]).hypot(c[1] - middle[1]);
        let radius = part.iter().map(far).fold(0.0, f64::max);
        (!part.is_empty()).then_some((middle, radius))
    });
    slabs.collect()
}

/// The part of a convex polygon on one side of a line across an axis.
fn clipped(corners: &[[f64; 2]], axis: usize, at: f64, side: f64) -> Vec<[f64; 2]> {
    let mut out = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let (da, db) = (side * (a[axis] - at), side * (b[axis] - at));
        if da >= 0.0 {
            out.push(a);
        }
        if da * db < 0.0 {
            let f = da / (da - db);
            out.push([a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1])]);
        }
    }
    out
}

/// A point of the base frame in the world.
pub(crate) fn placed(pose: [f64; 3], o: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = pose[2].sin_cos();
    [
        pose[0] + cos * o[0] - sin * o[1],
        pose[1] + sin * o[0] + cos * o[1],
    ]
}

/// The polygon with every edge moved inwards by `by`; the rest of the array is unused.
pub(crate) fn shrunk(corners: &[[f64; 2]], by: f64) -> [[f64; 2]; 16] {
    let n = corners.len();
    let mut list = [([0.0; 2], [0.0; 2]); 16];
    for (to, edge) in list.iter_mut().zip(edges(corners)) {
        *to = edge;
    }
    let mut out = [[0.0; 2]; 16];
    for i in 0..n {
        let ((a, p), (b, q)) = (list[(i + n - 1) % n], list[i]);
        let det = p[0] * q[1] - p[1] * q[0];
        let (c, d) = (
            p[0] * a[0] + p[1] * a[1] - by,
            q[0] * b[0] + q[1] * b[1] - by,
        );
        out[i] = [(c * q[1] - d * p[1]) / det, (p[0] * d - q[0] * c) / det];
    }
    out
}

/// How far the edges can move inwards until one has no length left, m.
pub(crate) fn shrinkable(corners: &[[f64; 2]]) -> f64 {
    let n = corners.len();
    if n == 0 {
        return 0.0;
    }
    // Corners move linearly, so each edge's length does, too.
    let unit = shrunk(corners, 1.0);
    let mut least = f64::INFINITY;
    for (i, (a, normal)) in edges(corners).enumerate() {
        let along = [-normal[1], normal[0]];
        let length = |p: [f64; 2], q: [f64; 2]| (q[0] - p[0]) * along[0] + (q[1] - p[1]) * along[1];
        let before = length(a, corners[(i + 1) % n]);
        let after = length(unit[i], unit[(i + 1) % n]);
        if before > after {
            least = least.min(before / (before - after));
        }
    }
    0.999 * least
}

/// Corner and outward normal of each edge of a counter-clockwise polygon.
pub(crate) fn edges(corners: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    (0..corners.len()).map(|i| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        let d = [b[0] - a[0], b[1] - a[1]];
        let l = d[0].hypot(d[1]);
        (a, [d[1] / l, -d[0] / l])
    })
}

/// Moves every edge outwards by `margin`.
pub(crate) fn inflate(corners: &[[f64; 2]], margin: f64) -> Result<Vec<[f64; 2]>, Error> {
    let bad = Error::Footprint(
        "the outline must be convex, counter-clockwise, around the origin, of 3 to 16 finite corners",
    );
    if !(3..=16).contains(&corners.len()) || corners.iter().flatten().any(|v| !v.is_finite()) {
        return Err(bad);
    }
    let list: Vec<_> = edges(corners).collect();
    let n = list.len();
    let mut out = Vec::with_capacity(n);
    for i in 0..n {
        let ((a, p), (b, q)) = (list[(i + n - 1) % n], list[i]);
        // Corner i lies on edge i-1 and edge i.
        let det = p[0] * q[1] - p[1] * q[0];
        let (c, d) = (
            p[0] * a[0] + p[1] * a[1] + margin,
            q[0] * b[0] + q[1] * b[1] + margin,
        );
        if det.is_nan() || det < 1e-9 || d <= 0.0 {
            return Err(bad);
        }
        out.push([(c * q[1] - d * p[1]) / det, (p[0] * d - q[0] * c) / det]);
    }
    Ok(out)
}
