#![allow(missing_docs, clippy::unwrap_used)]
mod common;

use common::room;
use hybrid_astar::*;
use parry3d::math::{Pose, Rotation, Vector};
use parry3d::query::PointQuery;
use parry3d::shape::Cuboid;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Clearance against a look at every cell.
    #[test]
    fn clearance_is_the_nearest_centre(map in room(), x in 0.01f64..0.99, y in 0.01f64..0.99) {
        let (low, high) = map.bounds();
        let p = [low[0] + x * (high[0] - low[0]), low[1] + y * (high[1] - low[1])];
        let mut best = f64::INFINITY;
        for cy in -1..=map.size()[1] as i32 {
            for cx in -1..=map.size()[0] as i32 {
                if map.is_blocked([cx, cy]) {
                    let c = [low[0] + (f64::from(cx) + 0.5) * 0.1, low[1] + (f64::from(cy) + 0.5) * 0.1];
                    best = best.min((c[0] - p[0]).hypot(c[1] - p[1]));
                }
            }
        }
        let c = map.clearance(p) + 0.05;
        // Outside, the straight line across the border counts, corners aside.
        prop_assert!(c <= best + 0.005 && c >= best - 0.03, "{c} {best}");
        prop_assert!(conformance::check_map(&map, 0.1, 12).is_ok());
    }

    /// The outline test against a look at every cell centre.
    #[test]
    fn outline_test_is_exact(map in room(), x in 0.0f64..1.0, y in 0.0f64..1.0, yaw in -3.0f64..3.0) {
        let (low, high) = map.bounds();
        let p = [low[0] + x * (high[0] - low[0]), low[1] + y * (high[1] - low[1])];
        let (s, c) = yaw.sin_cos();
        let corners = [[-0.4, -0.25], [0.4, -0.25], [0.4, 0.25], [-0.4, 0.25]].map(|o: [f64; 2]| [p[0] + c * o[0] - s * o[1], p[1] + s * o[0] + c * o[1]]);
        let mut free = true;
        for cy in -10..map.size()[1] as i32 + 10 {
            for cx in -10..map.size()[0] as i32 + 10 {
                let d = [low[0] + (f64::from(cx) + 0.5) * 0.1 - p[0], low[1] + (f64::from(cy) + 0.5) * 0.1 - p[1]];
                let (u, v) = (c * d[0] + s * d[1], c * d[1] - s * d[0]);
                free &= !(map.is_blocked([cx, cy]) && u.abs() <= 0.4 && v.abs() <= 0.25);
            }
        }
        prop_assert_eq!(map.outline_is_free(&corners), Some(free));
    }

    /// The bucket wave against Bellman-Ford sweeps over the same cells.
    #[test]
    fn field_is_the_shortest_path(map in room(), x in 0usize..40, y in 0usize..40, weight in 0.0f64..1.0) {
        let params = GridParams { cell_size: 0.2, admissible: false, clearance_weight: weight, source_reach: 0.0, ..GridParams::default() };
        let (low, high) = map.bounds();
        let size = [0, 1].map(|k| ((high[k] - low[k]) / 0.2 - 1e-6).ceil() as usize);
        let center = |x: usize, y: usize| [low[0] + (x as f64 + 0.5) * 0.2, low[1] + (y as f64 + 0.5) * 0.2];
        let (sx, sy) = (x.min(size[0] - 1), y.min(size[1] - 1));
        let field = Field::from(&map, 0.3137, center(sx, sy), &params).unwrap();
        let factor: Vec<f64> = (0..size[0] * size[1]).map(|i| {
            let c = map.clearance(center(i % size[0], i / size[0]));
            if c < 0.3137 { f64::INFINITY } else { 1.0 + weight * (1.0 - (c - 0.3137) / 0.4).clamp(0.0, 1.0).powi(2) }
        }).collect();
        let mut dist = vec![f64::INFINITY; factor.len()];
        if factor[sy * size[0] + sx].is_finite() {
            dist[sy * size[0] + sx] = 0.0;
        }
        loop {
            let mut changed = false;
            for y in 0..size[1] as i64 {
                for x in 0..size[0] as i64 {
                    for (dx, dy) in [(1i64, 0i64), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)] {
                        let (u, v) = (x + dx, y + dy);
                        if u < 0 || v < 0 || u >= size[0] as i64 || v >= size[1] as i64 { continue; }
                        let (a, b) = (y as usize * size[0] + x as usize, v as usize * size[0] + u as usize);
                        let next = dist[b] + 0.1 * ((dx * dx + dy * dy) as f64).sqrt() * (factor[a] + factor[b]);
                        if next < dist[a] - 1e-9 { dist[a] = next; changed = true; }
                    }
                }
            }
            if !changed { break; }
        }
        for y in 0..size[1] {
            for x in 0..size[0] {
                let (ours, theirs) = (field.distance(center(x, y)), dist[y * size[0] + x]);
                prop_assert!(ours == theirs || (ours - theirs).abs() < 1e-3, "{x} {y}: {ours} {theirs}");
            }
        }
    }
}

/// Least time from a pose to the goal's cell and heading over a coarse lattice, by plain Dijkstra: 0.1 m, 16 headings,
/// steps to the neighbouring cell that lies in the heading's direction (or behind), and turns by one heading.
fn lattice_seconds(map: &grid::Grid, half: [f64; 2], start: [usize; 3], goal: [usize; 3]) -> f64 {
    let [w, h] = map.size();
    let (low, _) = map.bounds();
    let unit = std::f64::consts::TAU / 16.0;
    let free = |x: usize, y: usize, k: usize| {
        let p = [
            low[0] + (x as f64 + 0.5) * 0.1,
            low[1] + (y as f64 + 0.5) * 0.1,
        ];
        let (s, c) = (k as f64 * unit).sin_cos();
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|q: [f64; 2]| {
            let o = [q[0] * half[0], q[1] * half[1]];
            [p[0] + c * o[0] - s * o[1], p[1] + s * o[0] + c * o[1]]
        });
        map.outline_is_free(&corners) == Some(true)
    };
    let index = |x: usize, y: usize, k: usize| (y * w + x) * 16 + k;
    if !free(start[0], start[1], start[2]) {
        return f64::INFINITY;
    }
    let mut dist = vec![f64::INFINITY; w * h * 16];
    let mut open = std::collections::BinaryHeap::new();
    let key = |d: f64| std::cmp::Reverse((d * 1e6) as u64);
    dist[index(start[0], start[1], start[2])] = 0.0;
    open.push((key(0.0), start));
    while let Some((_, [x, y, k])) = open.pop() {
        let d = dist[index(x, y, k)];
        if [x, y, k] == goal {
            return d;
        }
        let (s, c) = (k as f64 * unit).sin_cos();
        // Two or so cells ahead in the heading's direction, near enough to stay on the line.
        let ahead = [(2.3 * c).round() as i64, (2.3 * s).round() as i64];
        let length = 0.1 * ((ahead[0] * ahead[0] + ahead[1] * ahead[1]) as f64).sqrt();
        let mut next = vec![
            (x as i64, y as i64, (k + 1) % 16, unit / 1.5),
            (x as i64, y as i64, (k + 15) % 16, unit / 1.5),
        ];
        for sign in [1, -1] {
            let factor = if sign > 0 { 1.0 } else { 1.5 };
            next.push((
                x as i64 + sign * ahead[0],
                y as i64 + sign * ahead[1],
                k,
                factor * length / 0.8,
            ));
        }
        for (u, v, m, cost) in next {
            if u < 0 || v < 0 || u >= w as i64 || v >= h as i64 {
                continue;
            }
            let (u, v) = (u as usize, v as usize);
            // Both ends free with a margin that covers what lies between.
            if d + cost < dist[index(u, v, m)] - 1e-9 && free(u, v, m) {
                dist[index(u, v, m)] = d + cost;
                open.push((key(d + cost), [u, v, m]));
            }
        }
    }
    f64::INFINITY
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// What a plain search over a coarse lattice finds with room to spare, the planner finds, too, in not much more time.
    #[test]
    fn no_way_of_the_lattice_is_missed(map in room(), a in (4usize..36, 4usize..36, 0usize..16), b in (4usize..36, 4usize..36, 0usize..16)) {
        let best = lattice_seconds(&map, [0.46, 0.36], [a.0, a.1, a.2], [b.0, b.1, b.2]);
        let (low, _) = map.bounds();
        let unit = std::f64::consts::TAU / 16.0;
        let pose = |c: (usize, usize, usize)| [low[0] + (c.0 as f64 + 0.5) * 0.1, low[1] + (c.1 as f64 + 0.5) * 0.1, c.2 as f64 * unit];
        let (start, goal) = (pose(a), pose(b));
        let robot = Footprint::polygon(&[[-0.35, -0.25], [0.35, -0.25], [0.35, 0.25], [-0.35, 0.25]]);
        let map = map.with_inset(0.0);
        let limits = Limits { a: f64::INFINITY, alpha: f64::INFINITY, ..Limits::default() };
        let params = Params { limits, start_tolerance: 0.0, clearance_weight: 0.0, ..Params::default() };
        if best.is_finite() {
            let plan = plan(&map, &robot, start, [goal[0], goal[1]], &GoalYaw::Fixed(goal[2]), &params).unwrap();
            prop_assert!(plan.is_solved(), "{start:?} {goal:?} {:?}", plan.reason);
            prop_assert!(plan.seconds <= 1.15 * best + 0.5, "{} against {best}", plan.seconds);
        }
    }

    /// A quarter turn of the map turns the distances with it.
    #[test]
    fn fields_turn_with_the_map(map in room(), x in 2usize..30, y in 2usize..30) {
        let [w, h] = map.size();
        let blocked: Vec<bool> = (0..w * h).map(|i| {
            // Cell (u, v) of the turned map, h wide, is cell (v, h - 1 - u) of the map.
            let (u, v) = (i % h, i / h);
            map.is_blocked([v as i32, (h - 1 - u) as i32])
        }).collect();
        let turned = grid::Grid::new([h, w], 0.1, [0.0; 2], &blocked).unwrap();
        let (low, _) = map.bounds();
        let params = GridParams { cell_size: 0.1, admissible: false, source_reach: 0.0, ..GridParams::default() };
        let at = |x: usize, y: usize| [low[0] + (x as f64 + 0.5) * 0.1, low[1] + (y as f64 + 0.5) * 0.1];
        let there = |x: usize, y: usize| [((h - 1 - y) as f64 + 0.5) * 0.1, (x as f64 + 0.5) * 0.1];
        let a = Field::from(&map, 0.2501, at(x, y), &params).unwrap();
        let b = Field::from(&turned, 0.2501, there(x, y), &params).unwrap();
        for k in 0..40 {
            let (u, v) = ((k * 7) % w, (k * 11) % h);
            let (p, q) = (a.distance(at(u, v)), b.distance(there(u, v)));
            prop_assert!(p == q || (p - q).abs() < 1e-3, "{p} {q}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// The filled footprint as a box of parry3d along the whole path: no centre of a blocked cell in it, nor any in
    /// the margin but for what lies between two checks.
    #[test]
    fn footprints_stay_clear_by_parry(map in room(), a in (0.05f64..0.95, 0.05f64..0.95, 0.0f64..1.0), b in (0.05f64..0.95, 0.05f64..0.95, 0.0f64..1.0)) {
        let map = map.with_inset(0.0);
        let robot = Footprint::rectangle(0.7, 0.5, 3);
        let (start, goal) = (common::pose(&map, a), common::pose(&map, b));
        let params = Params { start_tolerance: 0.0, margin: 0.03, check_step: 0.04, ..Params::default() };
        let plan = plan(&map, &robot, start, [goal[0], goal[1]], &GoalYaw::Free, &params).unwrap();
        let shape = Cuboid::new(Vector::new(0.35, 0.25, 0.5));
        let (low, _) = map.bounds();
        let [w, h] = map.size();
        for p in common::dense(&plan.poses()).into_iter().step_by(2) {
            let pose = Pose::from_parts(Vector::new(p[0] as f32, p[1] as f32, 0.0), Rotation::from_rotation_z(p[2] as f32));
            let cell = |v: f64, axis: usize| ((v - low[axis]) / 0.1) as i32;
            let (cx, cy) = (cell(p[0], 0), cell(p[1], 1));
            for y in (cy - 6).max(-1)..=(cy + 6).min(h as i32) {
                for x in (cx - 6).max(-1)..=(cx + 6).min(w as i32) {
                    if map.is_blocked([x, y]) {
                        let at = [0, 1].map(|k| (low[k] + (f64::from([x, y][k]) + 0.5) * 0.1) as f32);
                        let d = shape.distance_to_point(&pose, Vector::new(at[0], at[1], 0.0), true);
                        // Half a check step less than the margin; poses between samples of the path lie a millimetre off.
                        prop_assert!(d > 0.03 - 0.02 - 0.002, "{d} at {p:?}");
                    }
                }
            }
        }
    }
}
