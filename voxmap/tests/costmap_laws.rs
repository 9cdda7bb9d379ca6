//! The cost map against brute force.
#![allow(missing_docs, clippy::unwrap_used)]

use proptest::prelude::*;
use voxmap::{
    CellBox, Config, CostMap, CostMapParams, Error, Ground, SensorModel, State, VoxelMap,
};

const H: f64 = 0.25;
const SIZE: [i32; 3] = [14, 11, 6];

fn map() -> VoxelMap {
    let high = [0, 1, 2].map(|a| f64::from(SIZE[a]) * H);
    VoxelMap::new(&Config {
        cell_size: H,
        low: [0.0; 3],
        high,
        sensor: SensorModel::default(),
    })
    .unwrap()
}

fn filled(states: &[u8]) -> VoxelMap {
    let mut map = map();
    let mut at = states.iter().cycle();
    for z in 0..SIZE[2] {
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                // Mostly free, so that clearances are not all zero.
                let state = match *at.next().unwrap() {
                    0..=1 => State::Unknown,
                    2..=3 => State::Occupied,
                    _ => State::Free,
                };
                map.set_state([x, y, z], state);
            }
        }
    }
    map
}

/// Distance to the nearest square of a kind, over all cells and one ring outside.
fn brute(grid: &CostMap, p: [f64; 2], outside: bool, blocks: impl Fn(Ground) -> bool) -> f64 {
    let mut best = f64::INFINITY;
    for y in -1..=SIZE[1] {
        for x in -1..=SIZE[0] {
            let inside = x >= 0 && y >= 0 && x < SIZE[0] && y < SIZE[1];
            let blocked = if inside {
                blocks(grid.ground([x, y]))
            } else {
                outside
            };
            if blocked {
                let gap = |a: usize, c: i32| {
                    (f64::from(c) * H - p[a])
                        .max(p[a] - f64::from(c + 1) * H)
                        .max(0.0)
                };
                best = best.min(gap(0, x).hypot(gap(1, y)));
            }
        }
    }
    best
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    /// A column is an obstacle, free or unknown exactly as its cells in the bands say.
    #[test]
    fn projection_follows_the_columns(states in prop::collection::vec(0..60u8, 97)) {
        let map = filled(&states);
        let params = CostMapParams { occupied_band: (0.25, 1.25), free_band: (0.0, 0.75) };
        let grid = CostMap::project(&map, &params).unwrap();
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let expected = if (1..5).any(|z| map.is_occupied([x, y, z])) {
                    Ground::Obstacle
                } else if (0..3).all(|z| map.is_free([x, y, z])) {
                    Ground::Free
                } else {
                    Ground::Unknown
                };
                prop_assert_eq!(grid.ground([x, y]), expected);
            }
        }
    }

    /// Clearance is exact below a metre and never too large beyond; updates of changed boxes equal a new projection.
    #[test]
    fn clearance_equals_brute_force(
        states in prop::collection::vec(0..200u8, 83),
        points in prop::collection::vec((0.0..3.5f64, 0.0..2.75f64), 20),
        edit in (0..14i32, 0..11i32, 0..3u8),
    ) {
        let mut map = filled(&states);
        let mut grid = CostMap::project(&map, &CostMapParams::default()).unwrap();
        let (x, y, kind) = edit;
        for z in 0..SIZE[2] {
            map.set_state([x, y, z], [State::Unknown, State::Free, State::Occupied][usize::from(kind)]);
        }
        grid.update(&map, &[CellBox { low: [x, y, 0], high: [x + 1, y + 1, SIZE[2]] }]);
        let fresh = CostMap::project(&map, &CostMapParams::default()).unwrap();
        for (px, py) in points {
            let p = [px, py];
            prop_assert_eq!(grid.clearance(p), fresh.clearance(p));
            for wanted in [-0.1, 0.0, 0.2, 0.36, 0.5, 0.75, 1.0, grid.clearance(p)] {
                prop_assert_eq!(grid.has_clearance(p, wanted), grid.clearance(p) >= wanted, "{}", wanted);
            }
            for (found, expected) in [
                (grid.clearance(p), brute(&grid, p, true, |g| g != Ground::Free)),
                (grid.obstacle_clearance(p), brute(&grid, p, false, |g| g == Ground::Obstacle)),
            ] {
                if expected == 0.0 {
                    prop_assert!(found <= 0.0);
                } else {
                    prop_assert!(found <= expected + 1e-9, "{found} above {expected}");
                    if expected < 0.9 {
                        prop_assert!((found - expected).abs() < 1e-9, "{found} against {expected}");
                    }
                }
            }
        }
    }
}

#[test]
fn bad_points_and_bands_are_harmless() {
    let map = map();
    let grid = CostMap::project(&map, &CostMapParams::default()).unwrap();
    assert!(grid.clearance([f64::NAN, 0.0]) < 0.0);
    assert!(grid.clearance([-5.0, 99.0]) < 0.0);
    let bad = CostMapParams {
        occupied_band: (1.0, 1.0),
        ..CostMapParams::default()
    };
    assert!(matches!(
        CostMap::project(&map, &bad),
        Err(Error::Length {
            field: "occupied_band",
            ..
        })
    ));
}

/// Inflation by a radius turns exactly the cells into obstacles whose centre is nearer than that to one.
#[test]
fn inflation_grows_obstacles() {
    let states: Vec<u8> = (0..97u8).map(|k| k.wrapping_mul(37) % 60).collect();
    let grid = CostMap::project(&filled(&states), &CostMapParams::default()).unwrap();
    for radius in [0.0, 0.2, 0.55, 1.0] {
        let inflated = grid.inflated(radius).unwrap();
        for y in 0..grid.size()[1] as i32 {
            for x in 0..grid.size()[0] as i32 {
                let here = [x, y];
                let gap = brute(&grid, grid.center(here), false, |g| g == Ground::Obstacle);
                let wanted = if gap < radius {
                    Ground::Obstacle
                } else {
                    grid.ground(here)
                };
                assert_eq!(inflated.ground(here), wanted, "{here:?} {radius} {gap}");
            }
        }
    }
    for radius in [-0.1, 1.1, f64::NAN] {
        assert!(matches!(
            grid.inflated(radius),
            Err(voxmap::Error::Length {
                field: "radius",
                ..
            })
        ));
    }
}
