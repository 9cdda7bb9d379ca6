//! Random rooms and brute-force checks.
#![allow(dead_code, unreachable_pub)]

use hybrid_astar::{Map, Robot, grid::Grid};
use proptest::prelude::*;

/// A room of 4 to 7 m with boxes, 0.1 m cells.
pub fn room() -> impl Strategy<Value = Grid> {
    (
        40usize..70,
        40usize..70,
        prop::collection::vec((0usize..70, 0usize..70, 1usize..14, 1usize..14), 0..7),
    )
        .prop_map(|(w, h, boxes)| {
            let mut blocked = vec![false; w * h];
            for (x, y, bw, bh) in boxes {
                for v in y..(y + bh).min(h) {
                    for u in x..(x + bw).min(w) {
                        blocked[v * w + u] = true;
                    }
                }
            }
            Grid::new([w, h], 0.1, [-1.0, 0.5], &blocked).unwrap()
        })
}

/// A pose inside a room, from three shares.
pub fn pose(map: &Grid, share: (f64, f64, f64)) -> [f64; 3] {
    let (low, high) = map.bounds();
    [
        low[0] + share.0 * (high[0] - low[0]),
        low[1] + share.1 * (high[1] - low[1]),
        share.2 * 6.0 - 3.0,
    ]
}

/// Least room of any circle at the pose, m.
pub fn room_at(map: &Grid, robot: &impl Robot, p: [f64; 3]) -> f64 {
    let (s, c) = p[2].sin_cos();
    let at = |o: [f64; 2]| [p[0] + c * o[0] - s * o[1], p[1] + s * o[0] + c * o[1]];
    robot
        .circles()
        .iter()
        .map(|&(o, r)| map.clearance(at(o)) - r)
        .fold(f64::INFINITY, f64::min)
}

/// Poses between the given ones, a centimetre or half a degree apart.
pub fn dense(poses: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut out = Vec::new();
    for w in poses.windows(2) {
        let n = ((w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]) / 0.01)
            .max((w[1][2] - w[0][2]).abs() / 0.01)
            .ceil()
            .max(1.0);
        for i in 0..=n as usize {
            let f = i as f64 / n;
            out.push([0, 1, 2].map(|k| w[0][k] + f * (w[1][k] - w[0][k])));
        }
    }
    out
}
