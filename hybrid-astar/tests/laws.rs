#![allow(missing_docs, clippy::unwrap_used)]
mod common;

use common::{dense, pose, room, room_at};
use hybrid_astar::*;
use proptest::prelude::*;

fn robot() -> Footprint {
    Footprint::circles(&[
        ([-0.25, 0.0], 0.302),
        ([0.0, 0.0], 0.302),
        ([0.25, 0.0], 0.302),
    ])
}

fn share() -> impl Strategy<Value = (f64, f64, f64)> {
    (0.05f64..0.95, 0.05f64..0.95, 0.0f64..1.0)
}

fn params() -> Params {
    Params {
        max_expansions: 3000,
        ..Params::default()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// A solved plan starts and ends where asked, jumps nowhere, and is free all along.
    #[test]
    fn paths_are_free_and_connected(map in room(), a in share(), b in share(), kind in 0usize..4) {
        let (start, goal) = (pose(&map, a), pose(&map, b));
        let yaw = match kind {
            0 => GoalYaw::Free,
            1 => GoalYaw::Fixed(goal[2]),
            2 => GoalYaw::Any(vec![goal[2], goal[2] + 2.0]),
            _ => GoalYaw::Within { yaw: goal[2], tolerance: 0.5 },
        };
        let params = Params { start_tolerance: 0.0, ..params() };
        let plan = plan(&map, &robot(), start, [goal[0], goal[1]], &yaw, &params).unwrap();
        if plan.is_solved() {
            let poses = plan.poses();
            prop_assert_eq!(poses[0], start);
            let end = poses[poses.len() - 1];
            prop_assert!((end[0] - goal[0]).hypot(end[1] - goal[1]) < 1e-9);
            let turned = |to: f64| { let d = (end[2] - to).rem_euclid(std::f64::consts::TAU); d.min(std::f64::consts::TAU - d) };
            match &yaw {
                GoalYaw::Fixed(y) => prop_assert!(turned(*y) < 1e-6),
                GoalYaw::Any(list) => prop_assert!(list.iter().any(|y| turned(*y) < 1e-6)),
                GoalYaw::Within { yaw, tolerance } => prop_assert!(turned(*yaw) < tolerance + 1e-6),
                _ => {}
            }
            for w in poses.windows(2) {
                prop_assert!((w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]) < 0.06);
                prop_assert!((w[1][2] - w[0][2]).abs() < 0.15);
            }
            for p in dense(&poses) {
                // The clearance of a grid is exact to a few millimetres between its cells.
                prop_assert!(room_at(&map, &robot(), p) > -0.005, "{p:?} {}", room_at(&map, &robot(), p));
            }
            for s in &plan.segments {
                for w in s.poses.windows(2) {
                    let ahead = (w[1][0] - w[0][0]) * w[0][2].cos() + (w[1][1] - w[0][1]) * w[0][2].sin();
                    match s.motion {
                        Motion::Forward => prop_assert!(ahead > -1e-9),
                        Motion::Reverse => prop_assert!(ahead < 1e-9),
                        // The place of a turn is rounded where pieces of a path meet.
                        Motion::Turn => prop_assert!((w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]) < 1e-9),
                    }
                }
            }
        } else {
            prop_assert!(plan.reason.is_some() && plan.segments.is_empty());
        }
    }

    /// The timed path keeps to the limits, lies on the path, and begins and ends at rest.
    #[test]
    fn timing_keeps_the_limits(map in room(), a in share(), b in share(), v in 0.2f64..1.5, w in 0.3f64..2.0, acc in 0.2f64..2.0, dt in 0.02f64..0.2) {
        let (start, goal) = (pose(&map, a), pose(&map, b));
        let limits = Limits { v, w, a: acc, alpha: 2.0 };
        let plan = plan(&map, &robot(), start, [goal[0], goal[1]], &GoalYaw::Fixed(goal[2]), &params()).unwrap();
        let timed = plan.time(&limits, dt).unwrap();
        if plan.is_solved() && !plan.segments.is_empty() {
            let (n, poses) = (timed.motions.len(), plan.poses());
            prop_assert_eq!((timed.poses.len(), timed.v.len(), timed.w.len()), (n + 1, n + 1, n + 1));
            prop_assert_eq!(timed.poses[0], start);
            prop_assert_eq!(timed.poses[n], plan.end);
            prop_assert!(timed.v[0] == 0.0 && timed.v[n] == 0.0 && timed.w[0] == 0.0 && timed.w[n] == 0.0);
            let mut speed = 0.0f64;
            for k in 0..n {
                let (p, q) = (timed.poses[k], timed.poses[k + 1]);
                let moved = (q[0] - p[0]).hypot(q[1] - p[1]) / dt;
                let turned = (q[2] - p[2]).abs() / dt;
                prop_assert!(moved <= v + 1e-6 && turned <= w + 1e-6, "{moved} {turned}");
                prop_assert!(timed.v[k].abs() <= v + 1e-9 && timed.w[k].abs() <= w + 1e-9);
                prop_assert!((timed.v[k + 1] - timed.v[k]).abs() <= acc * dt + 1e-6);
                let signed = if timed.motions[k] == Motion::Reverse { -moved } else { moved };
                if signed * speed >= 0.0 {
                    prop_assert!((signed - speed).abs() <= acc * dt + 1e-3 * v, "{signed} after {speed}");
                }
                speed = signed;
                // On the path: on one of its short chords.
                let off = poses.windows(2).map(|w| {
                    let d = [w[1][0] - w[0][0], w[1][1] - w[0][1]];
                    let l2 = d[0] * d[0] + d[1] * d[1];
                    let f = if l2 > 0.0 { (((q[0] - w[0][0]) * d[0] + (q[1] - w[0][1]) * d[1]) / l2).clamp(0.0, 1.0) } else { 0.0 };
                    (q[0] - w[0][0] - f * d[0]).hypot(q[1] - w[0][1] - f * d[1])
                }).fold(f64::INFINITY, f64::min);
                prop_assert!(off < 1e-9);
            }
            prop_assert_eq!(timed.at(-1.0).unwrap(), start);
            prop_assert_eq!(timed.at(1e9).unwrap(), plan.end);
        }
    }

    /// Faster limits never make a path take longer.
    #[test]
    fn time_falls_with_the_limits(map in room(), a in share(), b in share(), f in 1.0f64..3.0) {
        let (start, goal) = (pose(&map, a), pose(&map, b));
        let plan = plan(&map, &robot(), start, [goal[0], goal[1]], &GoalYaw::Free, &params()).unwrap();
        let slow = Limits::default();
        let at = |l: &Limits| plan.time(l, 0.01).unwrap().seconds();
        let base = at(&slow) + 0.0101;
        let faster = [
            Limits { v: slow.v * f, ..slow },
            Limits { a: slow.a * f, ..slow },
            Limits { w: slow.w * f, alpha: slow.alpha * f, ..slow },
        ];
        for limits in &faster {
            prop_assert!(at(limits) <= base);
        }
        if plan.is_solved() {
            prop_assert!((plan.seconds - at(&slow)).abs() <= 0.0101);
        }
    }

    /// The same question has the same answer, with a fresh planner or a used one.
    #[test]
    fn plans_repeat(map in room(), a in share(), b in share()) {
        let (start, goal) = (pose(&map, a), pose(&map, b));
        let ask = |p: &mut Planner, s| p.plan(&map, &robot(), s, [goal[0], goal[1]], &GoalYaw::Free).unwrap();
        let mut used = Planner::new(params()).unwrap();
        let first = ask(&mut used, start);
        prop_assert_eq!(&ask(&mut used, start), &first);
        prop_assert_eq!(&ask(&mut Planner::new(params()).unwrap(), start), &first);
    }

    /// Distances are the same both ways, no shorter than the straight line, and their paths are as long as they say.
    #[test]
    fn fields_are_symmetric(map in room(), a in share(), b in share(), sixteen: bool) {
        let (p, q) = (pose(&map, a), pose(&map, b));
        let (p, q) = ([p[0], p[1]], [q[0], q[1]]);
        let neighbours = if sixteen { Neighbours::Sixteen } else { Neighbours::Eight };
        let params = GridParams { cell_size: 0.1, neighbours, source_reach: 0.0, ..GridParams::default() };
        let space = Space::new(&map, 0.3, &params).unwrap();
        let field = space.field(p).unwrap();
        let (there, back) = (field.distance(q), space.field(q).unwrap().distance(p));
        prop_assert!(there == back || (there - back).abs() < 1e-3, "{there} {back}");
        prop_assert!(there >= (p[0] - q[0]).hypot(p[1] - q[1]) - 1e-5);
        let path = field.path(q);
        prop_assert_eq!(path.is_empty(), there.is_infinite());
        if !path.is_empty() {
            let length: f64 = path.windows(2).map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1])).sum();
            prop_assert!((length - there).abs() < 0.35, "{length} {there}");
        }
    }

    /// More obstacles never bring a point nearer.
    #[test]
    fn obstacles_only_lengthen(map in room(), extra in (0usize..40, 0usize..40), a in share()) {
        let p = pose(&map, a);
        let size = map.size();
        let blocked: Vec<bool> = (0..size[0] * size[1]).map(|i| map.is_blocked([(i % size[0]) as i32, (i / size[0]) as i32])).collect();
        let mut more = blocked.clone();
        for i in 0..6 {
            more[(extra.1 + i).min(size[1] - 1) * size[0] + extra.0.min(size[0] - 1)] = true;
        }
        let more = grid::Grid::new(size, 0.1, [-1.0, 0.5], &more).unwrap();
        let params = GridParams { cell_size: 0.1, source_reach: 0.0, ..GridParams::default() };
        let before = Field::from(&map, 0.2, [p[0], p[1]], &params).unwrap();
        let after = Field::from(&more, 0.2, [p[0], p[1]], &params).unwrap();
        for i in 0..20 {
            let q = pose(&map, (f64::from(i) / 20.0, (f64::from(i) * 0.37).fract(), 0.0));
            prop_assert!(after.distance([q[0], q[1]]) >= before.distance([q[0], q[1]]) - 1e-4);
        }
    }
}

/// A footprint that is not the same backwards, on a map whose blocked cells are points.
fn wedge() -> Footprint {
    Footprint::polygon(&[[-0.3, -0.25], [0.4, -0.2], [0.4, 0.2], [-0.3, 0.25]])
}

/// For both directions alike: no price on driving backwards, and no limit.
fn either_way() -> Params {
    Params {
        limits: Limits {
            a: f64::INFINITY,
            alpha: f64::INFINITY,
            ..Limits::default()
        },
        reverse_factor: 1.0,
        reverse_reach: 1e3,
        start_tolerance: 0.0,
        ..Params::default()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Driven backwards a path leads from its end to its start: what can be planned one way can be planned the other
    /// way, and takes about as long.
    #[test]
    fn paths_lead_both_ways(map in room(), a in share(), b in share()) {
        let map = map.with_inset(0.0);
        let (start, goal) = (pose(&map, a), pose(&map, b));
        let ask = |from: [f64; 3], to: [f64; 3]| {
            plan(&map, &wedge(), from, [to[0], to[1]], &GoalYaw::Fixed(to[2]), &either_way()).unwrap()
        };
        let (there, back) = (ask(start, goal), ask(goal, start));
        prop_assert_eq!(there.is_solved(), back.is_solved(), "{:?} {:?}", there.reason, back.reason);
        if there.is_solved() {
            let (t, u) = (there.seconds, back.seconds);
            prop_assert!(t <= 1.3 * u + 1.5 && u <= 1.3 * t + 1.5, "{t} {u}");
        }
    }

    /// A quarter turn of everything turns the answer with it: solved or not, and about as quick.
    #[test]
    fn plans_turn_with_the_map(map in room(), a in share(), b in share()) {
        let [w, h] = map.size();
        let blocked: Vec<bool> = (0..w * h).map(|i| {
            let (u, v) = (i % h, i / h);
            map.is_blocked([v as i32, (h - 1 - u) as i32])
        }).collect();
        let turned = grid::Grid::new([h, w], 0.1, [0.0; 2], &blocked).unwrap().with_inset(0.0);
        let map = map.with_inset(0.0);
        let (low, high) = map.bounds();
        let there = |p: [f64; 3]| [high[1] - p[1], p[0] - low[0], p[2] + std::f64::consts::FRAC_PI_2];
        let (start, goal) = (pose(&map, a), pose(&map, b));
        let ask = |map: &grid::Grid, from: [f64; 3], to: [f64; 3]| {
            plan(map, &wedge(), from, [to[0], to[1]], &GoalYaw::Fixed(to[2]), &either_way()).unwrap()
        };
        let (one, two) = (ask(&map, start, goal), ask(&turned, there(start), there(goal)));
        prop_assert_eq!(one.is_solved(), two.is_solved(), "{:?} {:?}", one.reason, two.reason);
        if one.is_solved() {
            let (t, u) = (one.seconds, two.seconds);
            prop_assert!(t <= 1.1 * u + 0.5 && u <= 1.1 * t + 0.5, "{t} {u}");
        }
    }
}
