#![allow(missing_docs, clippy::unwrap_used)]
mod common;

use common::room;
use hybrid_astar::*;
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
