//! Depth images by FLAP's rules, resets and raised floor plans.
#![allow(missing_docs, clippy::unwrap_used)]

use proptest::prelude::*;
use voxmap::{CellBox, Config, Error, FanImage, SensorModel, State, VoxelMap};

fn map() -> VoxelMap {
    VoxelMap::new(&Config {
        cell_size: 0.1,
        low: [0.0; 3],
        high: [3.0, 2.0, 1.0],
        sensor: SensorModel::default(),
    })
    .unwrap()
}

fn all(map: &VoxelMap) -> Vec<State> {
    let [nx, ny, nz] = map.size().map(|n| n as i32);
    (0..nz)
        .flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
        .map(|c| map.state(c))
        .collect()
}

const ORIGIN: [f64; 3] = [0.15, 0.95, 0.45];

/// A fan of rays along x that spreads in y.
fn ends() -> Vec<[f64; 3]> {
    (-40..=40)
        .map(|k| [2.15, 0.95 + 0.02 * f64::from(k), 0.45])
        .collect()
}

#[test]
fn touched_cells_stop_the_fan_and_space_without_return_is_free() {
    let mut map = map();
    // One point ahead at 1 m; one beyond the range; one too near; one that is not a number.
    let points = [
        [1.15, 0.95, 0.45],
        [2.55, 0.95, 0.45],
        [0.35, 0.95, 0.45],
        [f64::NAN; 3],
    ];
    let image = FanImage {
        origin: ORIGIN,
        points: &points,
        range: (0.4, 2.0),
        ends: &ends(),
        stop_at_occupied: false,
    };
    assert!(map.insert_fan(&image).unwrap() > 0);
    assert_eq!(map.state([11, 9, 4]), State::Occupied);
    // Before the point free, behind it unknown, beside it free up to the end of the range.
    assert_eq!(map.state([10, 9, 4]), State::Free);
    assert_eq!(map.state([15, 9, 4]), State::Unknown);
    assert_eq!(map.state([20, 13, 4]), State::Free);
    assert_eq!(map.state([25, 9, 4]), State::Unknown);
    // The near point was left out: its cell was passed.
    assert_eq!(map.state([3, 9, 4]), State::Free);
    // Each cell changed once: one hit outweighs the rays that would have freed it.
    assert_eq!(map.state([11, 9, 4]), State::Occupied);
}

#[test]
fn occupied_cells_may_stop_the_fan_too() {
    let ends = ends();
    for stop_at_occupied in [false, true] {
        let mut map = map();
        map.set_state([8, 9, 4], State::Occupied);
        let image = FanImage {
            origin: ORIGIN,
            points: &[],
            range: (0.4, 2.0),
            ends: &ends,
            stop_at_occupied,
        };
        map.insert_fan(&image).unwrap();
        let behind = if stop_at_occupied {
            State::Unknown
        } else {
            State::Free
        };
        assert_eq!(map.state([15, 9, 4]), behind);
        assert_eq!(map.state([8, 9, 4]), State::Occupied);
    }
}

#[test]
fn resets_forget_free_cells_and_may_keep_occupied_ones() {
    let mut kept = map();
    kept.set_state([5, 5, 5], State::Occupied);
    kept.set_state([6, 5, 5], State::Free);
    kept.set_state([9, 5, 5], State::Free);
    let mut gone = kept.clone();
    let cells = CellBox {
        low: [-5, 4, 4],
        high: [8, 7, 99],
    };
    kept.reset_cells(&cells, true);
    gone.reset_cells(&cells, false);
    assert_eq!(kept.state([5, 5, 5]), State::Occupied);
    assert_eq!(gone.state([5, 5, 5]), State::Unknown);
    for map in [&kept, &gone] {
        assert_eq!(map.state([6, 5, 5]), State::Unknown);
        assert_eq!(map.state([9, 5, 5]), State::Free);
    }
}

#[test]
fn floor_plans_become_walls_and_a_floor() {
    let mut map = map();
    // Pixels of 0.5 m: a wall in the third column.
    let plan: Vec<bool> = (0..6 * 4).map(|i| i % 6 == 2).collect();
    map.extrude(&plan, 6, [0.0; 2], 0.5, 0.6);
    assert_eq!(map.state([12, 3, 0]), State::Occupied);
    assert_eq!(map.state([12, 3, 5]), State::Occupied);
    assert_eq!(map.state([12, 3, 6]), State::Unknown);
    assert_eq!(map.state([3, 3, 0]), State::Occupied);
    assert_eq!(map.state([3, 3, 1]), State::Unknown);
    // A plan of no width is no plan, but there is a floor.
    let mut bare = self::map();
    bare.extrude(&[], 0, [0.0; 2], 0.5, 2.0);
    assert_eq!(bare.state([12, 3, 0]), State::Occupied);
    assert_eq!(bare.state([12, 3, 1]), State::Unknown);
}

#[test]
fn bad_images_are_refused() {
    let mut map = map();
    let good = FanImage {
        origin: ORIGIN,
        points: &[],
        range: (0.4, 2.0),
        ends: &[],
        stop_at_occupied: false,
    };
    let bad = map.insert_fan(&FanImage {
        origin: [f64::NAN; 3],
        ..good.clone()
    });
    assert!(matches!(
        bad,
        Err(Error::Position {
            field: "origin",
            ..
        })
    ));
    for range in [
        (0.4, f64::INFINITY),
        (0.4, -1.0),
        (3.0, 2.0),
        (f64::NAN, 2.0),
    ] {
        let bad = map.insert_fan(&FanImage {
            range,
            ..good.clone()
        });
        assert!(
            matches!(bad, Err(Error::Length { field: "range", .. })),
            "{range:?}"
        );
    }
    assert_eq!(map.insert_fan(&good), Ok(0));
}

proptest! {
    /// What was reset and is observed again is as it was, wherever the image decides.
    #[test]
    fn reset_and_observe_again_restores_the_map(
        points in prop::collection::vec((0.6..2.0f64, 0.2..1.7f64), 0..30),
        low in (0..20i32, 0..12i32, 0..6i32),
    ) {
        let points: Vec<[f64; 3]> = points.iter().map(|&(x, y)| [x, y, 0.45]).collect();
        let ends = ends();
        let image = FanImage { origin: ORIGIN, points: &points, range: (0.4, 2.0), ends: &ends, stop_at_occupied: false };
        let mut map = map();
        map.insert_fan(&image).unwrap();
        let before = all(&map);
        let cells = CellBox { low: [low.0, low.1, low.2], high: [low.0 + 9, low.1 + 7, low.2 + 4] };
        map.reset_cells(&cells, false);
        map.insert_fan(&image).unwrap();
        prop_assert_eq!(all(&map), before);
    }
}
