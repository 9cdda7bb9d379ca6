//! A checker and a yardstick that share no code with the planner.

use crate::load::NavMap;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Poses of the path, no further than 2.5 cm and 1.5 degrees apart, whose filled footprint holds the centre of a
/// blocked cell.
pub fn violations(map: &NavMap, footprint: &[[f64; 2]], poses: &[[f64; 3]]) -> usize {
    let mut bad = 0;
    for w in poses.windows(2) {
        let (a, b) = (w[0], w[1]);
        let n = ((b[0] - a[0]).hypot(b[1] - a[1]) / 0.025)
            .max((b[2] - a[2]).abs() / 0.026)
            .ceil()
            .max(1.0);
        for i in 0..=n as usize {
            let f = i as f64 / n;
            let pose = [0, 1, 2].map(|k| a[k] + f * (b[k] - a[k]));
            bad += usize::from(hits(map, footprint, pose));
        }
    }
    bad
}

fn hits(map: &NavMap, footprint: &[[f64; 2]], pose: [f64; 3]) -> bool {
    let reach = footprint
        .iter()
        .map(|c| c[0].hypot(c[1]))
        .fold(0.0, f64::max);
    let (sin, cos) = pose[2].sin_cos();
    let cell = |v: f64, axis: usize| ((v - map.low[axis]) / map.cell - 0.5).floor() as i64;
    for y in cell(pose[1] - reach, 1)..=cell(pose[1] + reach, 1) + 1 {
        for x in cell(pose[0] - reach, 0)..=cell(pose[0] + reach, 0) + 1 {
            let inside =
                x >= 0 && y >= 0 && (x as usize) < map.size[0] && (y as usize) < map.size[1];
            if inside && !map.blocked[y as usize * map.size[0] + x as usize] {
                continue;
            }
            let dx = map.low[0] + (x as f64 + 0.5) * map.cell - pose[0];
            let dy = map.low[1] + (y as f64 + 0.5) * map.cell - pose[1];
            let (u, v) = (cos * dx + sin * dy, cos * dy - sin * dx);
            let within = (0..footprint.len()).all(|i| {
                let (a, b) = (footprint[i], footprint[(i + 1) % footprint.len()]);
                (b[0] - a[0]) * (v - a[1]) - (b[1] - a[1]) * (u - a[0]) >= 0.0
            });
            if within {
                return true;
            }
        }
    }
    false
}

/// Plain Dijkstra with a binary heap over the whole map at 0.1 m, 8 neighbours, from one cell: the yardstick D.
/// A coarse cell is open if the inscribed disc fits (by a plain count of cells around, made beforehand).
pub struct Yardstick {
    size: [usize; 2],
    open: Vec<bool>,
}

impl Yardstick {
    pub fn new(map: &NavMap, clearance: impl Fn([f64; 2]) -> f64, radius: f64) -> Self {
        let size = [0, 1].map(|k| (map.size[k] as f64 * map.cell / 0.1).ceil() as usize);
        let mut open = Vec::new();
        for y in 0..size[1] {
            for x in 0..size[0] {
                let p = [
                    map.low[0] + (x as f64 + 0.5) * 0.1,
                    map.low[1] + (y as f64 + 0.5) * 0.1,
                ];
                open.push(clearance(p) >= radius);
            }
        }
        Self { size, open }
    }

    /// Returns the number of settled cells.
    pub fn run(&self, from: [usize; 2]) -> usize {
        let [w, h] = self.size;
        let mut dist = vec![u64::MAX; w * h];
        let mut heap = BinaryHeap::new();
        let start = from[1].min(h - 1) * w + from[0].min(w - 1);
        dist[start] = 0;
        heap.push(Reverse((0u64, start)));
        let mut settled = 0;
        while let Some(Reverse((d, at))) = heap.pop() {
            if d > dist[at] {
                continue;
            }
            settled += 1;
            let (x, y) = ((at % w) as i64, (at / w) as i64);
            for (dx, dy) in [
                (1, 0),
                (-1, 0),
                (0, 1),
                (0, -1),
                (1, 1),
                (1, -1),
                (-1, 1),
                (-1, -1),
            ] {
                let (nx, ny) = (x + dx, y + dy);
                if nx < 0 || ny < 0 || nx >= w as i64 || ny >= h as i64 {
                    continue;
                }
                let to = ny as usize * w + nx as usize;
                let next = d + if dx != 0 && dy != 0 { 14142 } else { 10000 };
                if self.open[to] && next < dist[to] {
                    dist[to] = next;
                    heap.push(Reverse((next, to)));
                }
            }
        }
        settled
    }
}
