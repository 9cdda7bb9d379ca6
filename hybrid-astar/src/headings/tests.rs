//! The search over boxes against a lattice of poses, and boxes against poses in them.

use super::*;
use crate::body::Body;
use crate::grid::Grid;
use crate::planner::raster_pricing;
use crate::price::Price;
use crate::{Footprint, GoalYaw, Params};
use proptest::prelude::*;

const CELL: f64 = 0.05;

/// 2.4 m by 2 m with a wall across and a gap in it, and some single obstacles.
fn tight() -> impl Strategy<Value = Grid> {
    let obstacles = prop::collection::vec((0usize..48, 0usize..40), 0..5);
    (20usize..28, 6usize..30, 8usize..18, 1usize..6, obstacles).prop_map(
        |(wall, gap, wide, thick, obstacles)| {
            let mut blocked = vec![false; 48 * 40];
            for y in (0..40).filter(|y| !(gap..gap + wide).contains(y)) {
                for x in wall..wall + thick {
                    blocked[y * 48 + x] = true;
                }
            }
            for (x, y) in obstacles {
                blocked[y * 48 + x] = true;
            }
            Grid::new([48, 40], CELL, [0.3, -0.7], &blocked)
                .unwrap_or_else(|_| Grid::parse("", 1.0))
                .with_inset(0.0)
        },
    )
}

fn robots() -> [Footprint; 2] {
    let circles = [([-0.12, 0.0], 0.2), ([0.12, 0.0], 0.2)];
    [
        Footprint::rectangle(0.6, 0.4, 3),
        Footprint::circles(&circles),
    ]
}

/// Free poses connected over a lattice of 2.5 cm and 128 headings whose poses are the middles of the finest boxes,
/// moving in any direction: at least all that the base can do there.
fn lattice_connects(map: &Grid, body: &Body, start: [f64; 3], goal: [f64; 2]) -> bool {
    let side = 0.025;
    let (low, high) = crate::Map::bounds(map);
    let size = [0, 1].map(|a| ((high[a] - low[a]) / side).round() as i64);
    let unit = TAU / BINS as f64;
    let middle = |c: [i64; 3]| {
        [
            low[0] + (c[0] as f64 + 0.5) * side,
            low[1] + (c[1] as f64 + 0.5) * side,
            c[2] as f64 * unit,
        ]
    };
    let cell = |p: [f64; 2]| [0, 1].map(|a| ((p[a] - low[a]) / side) as i64);
    let index = |c: [i64; 3]| ((c[1] * size[0] + c[0]) as usize) * BINS + c[2] as usize;
    let mut seen = vec![false; (size[0] * size[1]) as usize * BINS];
    let [x, y] = cell([start[0], start[1]]);
    let mut open = vec![[x, y, (start[2] / unit).round().rem_euclid(128.0) as i64]];
    while let Some(c) = open.pop() {
        if [c[0], c[1]] == cell(goal) {
            return true;
        }
        for (a, d) in [(0, 1), (0, -1), (1, 1), (1, -1), (2, 1), (2, -1)] {
            let mut to = c;
            to[a] += d;
            to[2] = to[2].rem_euclid(BINS as i64);
            if to[0] < 0 || to[1] < 0 || to[0] >= size[0] || to[1] >= size[1] {
                continue;
            }
            if !seen[index(to)] && body.room(map, middle(to)) >= 0.0 {
                seen[index(to)] = true;
                open.push(to);
            }
        }
    }
    false
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// No passage is refused that a fine lattice finds.
    #[test]
    fn refused_passages_are_closed(map in tight(), robot in 0usize..2, y in (0.1f64..0.9, 0.1f64..0.9), yaw in -3.0f64..3.0, free: bool) {
        let params = Params { margin: 0.01, ..Params::default() };
        let robot = &robots()[robot];
        let mut body = Body::new(&map, robot, params.margin, params.check_step).unwrap();
        body.begin(0.0);
        let (low, high) = crate::Map::bounds(&map);
        let at = |share: f64| low[1] + share * (high[1] - low[1]);
        let (start, goal) = ([low[0] + 0.42, at(y.0), yaw], [high[0] - 0.42, at(y.1)]);
        let fits = |h: f64| body.room(&map, [goal[0], goal[1], h]) >= 0.0;
        prop_assume!(body.room(&map, start) >= 0.0);
        // The lattice asks for no heading at the goal: only that one is free.
        prop_assume!((0..128).any(|k| fits(f64::from(k) * TAU / 128.0)));
        let pricing = raster_pricing(&body, &params);
        let price = Price::new(&params, pricing);
        let goal_yaw = if free { GoalYaw::Free } else { GoalYaw::Within { yaw: 0.0, tolerance: 3.2 } };
        let task = Task { map: &map, body: &body, price: &price, params: &params, start, missing: 0.0, goal, yaw: &goal_yaw };
        let mut raster = Raster::new(&map, params.cell_size, pricing).unwrap();
        let mut wave = Wave::new(&mut Lazy { raster: &mut raster, map: &map }, goal, 0.2, false);
        let verdict = look(&task, &mut raster, &mut wave, &mut || false);
        if matches!(verdict, Verdict::NoPassage(_)) {
            prop_assert!(!lattice_connects(&map, &body, start, goal));
        }
    }

    /// A box whose common part is hit holds no free pose.
    #[test]
    fn closed_boxes_hold_no_free_pose(map in tight(), robot in 0usize..2, x in 0.05f64..0.95, y in 0.05f64..0.95, half in 0.0f64..0.06, turn in 0.0f64..0.12, inside in prop::collection::vec((-1.0f64..1.0, -1.0f64..1.0, -1.0f64..1.0), 24)) {
        let body = Body::new(&map, &robots()[robot], 0.01, 0.02).unwrap();
        let (low, high) = crate::Map::bounds(&map);
        let middle = [low[0] + x * (high[0] - low[0]), low[1] + y * (high[1] - low[1])];
        let stamps = Stamps::new(&body, 24, 0.1, half, turn);
        for k in (0..24).filter(|&k| !stamps.free(&map, middle, k)) {
            for (dx, dy, da) in &inside {
                let yaw = 0.1 + k as f64 * TAU / 24.0 + da * turn;
                let pose = [middle[0] + dx * half, middle[1] + dy * half, yaw];
                prop_assert!(body.room(&map, pose) < 0.0, "{pose:?}");
            }
        }
    }
}

#[test]
fn turning_in_place_goes_around_the_circle() {
    assert_eq!(spread(1, ALL), ALL);
    assert_eq!(
        spread(1 << 127, 0b111 | 1 << 127 | 1 << 60),
        0b111 | 1 << 127
    );
    assert_eq!(spread(1, 0b110), 0);
}
