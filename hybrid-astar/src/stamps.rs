//! The footprint at every heading of a circle of bins, ready to be placed: exactly, or shrunk to what a whole box of
//! poses has in common.

use crate::Map;
use crate::body::Body;
use std::f64::consts::{SQRT_2, TAU};

/// Footprints of one size of box, one for each bin.
pub(crate) struct Stamps {
    list: Vec<Stamp>,
    /// Half a turn changes nothing.
    symmetric: bool,
}

/// What a box's poses have in common, about the middle of the box in the axes of the world.
enum Stamp {
    /// A convex polygon.
    Outline(Vec<[f64; 2]>),
    /// Circle centres and the clearance each needs, m.
    Circles(Vec<([f64; 2], f64)>),
    /// Nothing: some pose of the box may always be free.
    Nothing,
}

impl Stamps {
    /// For `bins` headings, the first of them `first` rad, and boxes that reach `half` m from their middle along x and
    /// y and `turn` rad to both sides.
    ///
    /// With `half = turn = 0` these are the footprints themselves.
    pub(crate) fn new(body: &Body, bins: usize, first: f64, half: f64, turn: f64) -> Self {
        let unit = TAU / bins as f64;
        let list = (0..bins).map(|k| {
            let (sin, cos) = (first + k as f64 * unit).sin_cos();
            let place = |o: [f64; 2]| [cos * o[0] - sin * o[1], sin * o[0] + cos * o[1]];
            if body.outline().is_empty() {
                let shrunk = body.circles().iter().map(|&(o, need)| {
                    // Distance to an obstacle changes no faster than the centre moves.
                    let moved = half * SQRT_2 + o[0].hypot(o[1]) * turn;
                    (place(o), need - moved)
                });
                return Stamp::Circles(shrunk.collect());
            }
            let corners: Vec<[f64; 2]> = body.outline().iter().map(|&o| place(o)).collect();
            match common_part(&corners, half, turn) {
                Some(part) => Stamp::Outline(part),
                None => Stamp::Nothing,
            }
        });
        Self {
            list: list.collect(),
            symmetric: bins.is_multiple_of(2) && symmetric(body),
        }
    }

    /// Whether the footprint is the same after half a turn, so that half the bins tell all.
    pub(crate) fn symmetric(&self) -> bool {
        self.symmetric
    }

    /// Whether nothing is hit at bin `k` of the box around `middle`: for shrunk stamps false proves that no pose of
    /// the box is free.
    pub(crate) fn free<M: Map>(&self, map: &M, middle: [f64; 2], k: usize) -> bool {
        match &self.list[k] {
            Stamp::Nothing => true,
            Stamp::Outline(part) => {
                let mut placed = [[0.0; 2]; 16];
                for (to, from) in placed.iter_mut().zip(part) {
                    *to = [middle[0] + from[0], middle[1] + from[1]];
                }
                map.outline_is_free(&placed[..part.len()]) == Some(true)
            }
            Stamp::Circles(list) => list
                .iter()
                .all(|(o, need)| map.clearance([middle[0] + o[0], middle[1] + o[1]]) >= *need),
        }
    }
}

fn symmetric(body: &Body) -> bool {
    let mirrored = |a: &[f64; 2], b: &[f64; 2]| (a[0] + b[0]).hypot(a[1] + b[1]) < 1e-9;
    let (outline, circles) = (body.outline(), body.circles());
    if outline.is_empty() {
        let pair = |a: &([f64; 2], f64), b: &([f64; 2], f64)| mirrored(&a.0, &b.0) && a.1 == b.1;
        circles.iter().all(|a| circles.iter().any(|b| pair(a, b)))
    } else {
        outline
            .iter()
            .all(|a| outline.iter().any(|b| mirrored(a, b)))
    }
}

/// A polygon that every pose of a box covers: each edge of the one in the middle moved inwards by as much as the box
/// moves it. `None` if nothing is left, or an edge is lost on the way.
///
/// A point `u` lies behind the edge with normal `n` and offset `c` at every pose if
/// `n.u + t sin(turn) + half (|n_x| + |n_y|) <= c`, with `t` the most any point of the polygon lies along the edge from the
/// foot of the origin: turning by `d` turns `n`, and `n` turned is `n cos d + n' sin d`.
fn common_part(corners: &[[f64; 2]], half: f64, turn: f64) -> Option<Vec<[f64; 2]>> {
    let n = corners.len();
    let lines: Vec<([f64; 2], f64)> = (0..n)
        .map(|i| {
            let (a, b) = (corners[i], corners[(i + 1) % n]);
            let d = [b[0] - a[0], b[1] - a[1]];
            let l = d[0].hypot(d[1]);
            let normal = [d[1] / l, -d[0] / l];
            let along = |p: &[f64; 2]| (normal[0] * p[1] - normal[1] * p[0]).abs();
            let far = corners.iter().map(along).fold(0.0, f64::max);
            // The normal turns, too, by up to `turn`.
            let spread = (normal[0].abs() + normal[1].abs() + SQRT_2 * turn).min(SQRT_2);
            let by = half * spread + far * turn.sin();
            (normal, normal[0] * a[0] + normal[1] * a[1] - by)
        })
        .collect();
    if lines.iter().any(|l| l.1 <= 0.0) {
        return None;
    }
    let mut part = Vec::with_capacity(n);
    for i in 0..n {
        let ((p, c), (q, d)) = (lines[(i + n - 1) % n], lines[i]);
        let det = p[0] * q[1] - p[1] * q[0];
        let corner = [(c * q[1] - d * p[1]) / det, (p[0] * d - q[0] * c) / det];
        // A corner beyond another edge: that one, or this, has no length left.
        if !lines
            .iter()
            .all(|(n, c)| n[0] * corner[0] + n[1] * corner[1] <= c + 1e-9)
        {
            return None;
        }
        part.push(corner);
    }
    Some(part)
}
