//! Maps that grow and are cropped, snapshots, decay, the grazing guard, moving things: what holds for any scan.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::{Numbers, cells, map, random_map};
use proptest::prelude::*;
use voxmap::{
    CellBox, CostMap, CostMapParams, Error, Esdf, EsdfParams, GrazingGuard, Scan, SensorModel,
    State, UnknownPolicy, VoxelMap,
};

const MOST: usize = 1 << 24;

fn points(numbers: &mut Numbers, n: usize, reach: f64) -> Vec<[f32; 3]> {
    (0..n)
        .map(|_| [0; 3].map(|_| (reach * (2.0 * numbers.next() - 1.0)) as f32))
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// A growing map and a bounded one that is large enough hold the same, cell for cell, and so do their layers.
    #[test]
    fn growing_maps_equal_bounded_ones(seed: u64) {
        let mut numbers = Numbers(seed);
        let mut growing = VoxelMap::growing(0.25, &SensorModel::default(), MOST).unwrap();
        let mut bounded = VoxelMap::new(&voxmap::Config {
            cell_size: 0.25,
            low: [-16.0, -8.0, -8.0],
            high: [16.0, 8.0, 8.0],
            sensor: SensorModel::default(),
        })
        .unwrap();
        let params = EsdfParams { truncation: 1.0, unknown_is_occupied: true };
        let mut field = Esdf::new(&growing, params.clone()).unwrap();
        let mut ground = CostMap::project(&growing, &CostMapParams::default()).unwrap();
        for k in 0..4 {
            let origin = [0; 3].map(|_| 2.0 * numbers.next() - 1.0);
            let hits = points(&mut numbers, 30, 2.0 + 1.5 * f64::from(k));
            let scan = Scan { origin, hits: &hits, max_range: 6.0, ..Scan::default() };
            growing.insert(&scan).unwrap();
            bounded.insert(&scan).unwrap();
            let changes = growing.take_changes();
            field.update(&growing, &changes);
            ground.update(&growing, &changes.state_boxes);
        }
        prop_assert_eq!(growing.counts(), bounded.counts());
        for cell in cells(&bounded) {
            let at = bounded.center(cell);
            prop_assert_eq!(bounded.state(cell), growing.state(growing.cell_at(at)));
        }
        let fresh = Esdf::new(&growing, params).unwrap();
        let flat = CostMap::project(&growing, &CostMapParams::default()).unwrap();
        let b = growing.bounds();
        for _ in 0..500 {
            let cell = [0, 1, 2].map(|a| b.low[a] + numbers.below(growing.size()[a]) as i32);
            prop_assert_eq!(field.cell_distance(cell), fresh.cell_distance(cell));
            let at = growing.center(cell);
            prop_assert_eq!(ground.clearance([at[0], at[1]]), flat.clearance([at[0], at[1]]));
        }
        prop_assert_eq!(growing.cell_at([0.1, 0.1, 0.1]), [0; 3], "cells keep their indices");
    }

    /// A cropped map keeps what lies in the window and forgets the rest; changes not yet taken are kept inside it.
    #[test]
    fn cropping_keeps_the_window(seed: u64) {
        let mut numbers = Numbers(seed);
        let mut map = VoxelMap::growing(0.25, &SensorModel::default(), MOST).unwrap();
        let hits = points(&mut numbers, 200, 12.0);
        map.insert(&Scan { hits: &hits, origin: [0.1; 3], ..Scan::default() }).unwrap();
        let before = map.clone();
        let window = CellBox { low: [-64, -16, -8], high: [64, 8, 16] };
        map.crop(window).unwrap();
        prop_assert_eq!(map.bounds(), window);
        for cell in cells(&before) {
            let cell = [0, 1, 2].map(|a| cell[a] + before.bounds().low[a]);
            let wanted = if window.contains(cell) { before.state(cell) } else { State::Unknown };
            prop_assert_eq!(map.state(cell), wanted);
        }
        prop_assert!(map.memory() < before.memory());
        let known = map.counts().known;
        prop_assert_eq!(map.take_changes().cells().count(), known);
    }

    /// A snapshot stays what it was, and saved and loaded maps are equal in every answer.
    #[test]
    fn snapshots_and_files_keep_everything(seed: u64) {
        let mut numbers = Numbers(seed);
        let mut map = random_map(seed, [70.0, 20.0, 9.0], 0.5, 0.2);
        let hits = points(&mut numbers, 200, 4.0);
        let scan = Scan { hits: &hits, origin: [0.2, 1.2, 0.6], ..Scan::default() };
        map.insert(&scan).unwrap();
        let camera = voxmap::Camera {
            rotation: [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
            translation: map.center([2, 10, 4]),
            tan_half_h: 0.8,
            tan_half_v: 0.8,
        };
        map.mark_inspected(&camera, 5.0);
        let then = map.clone();
        let snapshot = map.snapshot();
        let loaded = VoxelMap::load(&map.save(), MOST).unwrap();
        map.insert(&scan).unwrap();
        map.reset_box([0.0; 3], [3.0; 3]);
        for cell in cells(&then) {
            for copy in [&*snapshot, &loaded] {
                prop_assert_eq!(copy.state(cell), then.state(cell));
                prop_assert_eq!(copy.log_odds(cell), then.log_odds(cell));
                prop_assert_eq!(copy.open_faces(cell), then.open_faces(cell));
            }
        }
        prop_assert_eq!(loaded.save(), then.save());
        // A copy of a snapshot is a map like any other.
        let mut copy = (*snapshot).clone();
        copy.insert(&scan).unwrap();
        let mut again = then.clone();
        again.insert(&scan).unwrap();
        prop_assert_eq!(copy.save(), again.save());
    }

    /// Skipping empty blocks changes no answer, also for rays along axes, diagonals and borders.
    #[test]
    fn skipping_casts_equal_cell_by_cell_ones(seed: u64) {
        let mut numbers = Numbers(seed);
        let share = [0.0, 0.0005, 0.005, 0.1][numbers.below(4)];
        let map = random_map(seed, [70.0, 40.0, 19.0], 0.7, share);
        for k in 0..400 {
            let origin = if k % 2 == 0 { map.center(numbers.cell(&map)) } else { numbers.point(&map) };
            let direction = match k % 3 {
                0 => [0; 3].map(|_| numbers.below(3) as f64 - 1.0),
                _ => [0; 3].map(|_| 2.0 * numbers.next() - 1.0),
            };
            let length = 12.0 * numbers.next();
            let slow = map.cast(origin, direction, length, UnknownPolicy::Pass);
            let fast = map.cast(origin, direction, length, UnknownPolicy::Ignore);
            prop_assert_eq!((fast.cell, fast.occupied, fast.distance), (slow.cell, slow.occupied, slow.distance));
        }
    }

    /// Decay moves every known cell of the box towards 0 and nothing else; enough of it forgets the box.
    #[test]
    fn decay_forgets_slowly(seed: u64, by in 0.01f64..1.0) {
        let mut map = random_map(seed, [70.0, 9.0, 5.0], 0.5, 0.3);
        let before = map.clone();
        let (low, high) = ([0.0, 1.0, 0.0], [9.0, 2.0, 9.0]);
        map.decay_box(low, high, by);
        for cell in cells(&map) {
            let c = map.center(cell);
            let inside = (0..3).all(|a| low[a] <= c[a] && c[a] <= high[a]);
            let (old, new) = (before.log_odds(cell), map.log_odds(cell));
            if inside {
                let step = (by / 0.05).round().max(1.0) * 0.05;
                prop_assert!((new.abs() - (old.abs() - step).max(0.0)).abs() < 1e-9);
            } else {
                prop_assert_eq!(old, new);
            }
            prop_assert!(new != 0.0 || map.state(cell) == State::Unknown);
        }
        for _ in 0..80 {
            map.decay_box([-99.0; 3], [99.0; 3], 0.05);
        }
        prop_assert_eq!(map.counts().known, 0);
    }

    /// The guard only withholds passes: hits are the same, and what is freed is a part of what is freed without it.
    #[test]
    fn the_guard_only_withholds(seed: u64) {
        let mut numbers = Numbers(seed);
        let mut plain = map(0.25, [60.0, 30.0, 9.0]);
        let hits: Vec<[f32; 3]> = (0..400)
            .map(|_| [0.2 + 12.0 * numbers.next() as f32, 7.0 * numbers.next() as f32, 0.1])
            .collect();
        let scan = Scan { origin: [0.0, 4.0, 1.0], hits: &hits, ..Scan::default() };
        let blank = plain.clone();
        plain.insert(&scan).unwrap();
        for guard in [GrazingGuard::default(), GrazingGuard::thorough()] {
            let mut guarded = blank.clone();
            guarded.insert(&Scan { grazing_guard: Some(guard), ..scan.clone() }).unwrap();
            for cell in cells(&plain) {
                prop_assert_eq!(plain.is_occupied(cell), guarded.is_occupied(cell));
                prop_assert!(!guarded.is_free(cell) || plain.is_free(cell));
            }
            prop_assert!(guarded.counts().free < plain.counts().free);
        }
    }
}

/// A floor scanned at a flat angle in sparse rings: without the guard the cells between the rings are freed, with it none.
#[test]
fn flat_rays_leave_the_floor_alone() {
    let mut plain = map(0.25, [60.0, 60.0, 12.0]);
    let origin = [6.0, 7.0, 0.8];
    // The floor's surface lies in the middle of the lowest cells.
    let hits: Vec<[f32; 3]> = [3.0f32, 4.0, 5.5]
        .iter()
        .flat_map(|r| (0..720).map(move |k| (r, (k as f32).to_radians() / 2.0)))
        .map(|(r, yaw)| [6.0 + r * yaw.cos(), 7.0 + r * yaw.sin(), 0.125])
        .collect();
    let mut guarded = plain.clone();
    let scan = Scan {
        origin,
        hits: &hits,
        ..Scan::default()
    };
    plain.insert(&scan).unwrap();
    guarded
        .insert(&Scan {
            grazing_guard: Some(GrazingGuard::default()),
            ..scan
        })
        .unwrap();
    let freed = |map: &VoxelMap| cells(map).filter(|c| c[2] == 0 && map.is_free(*c)).count();
    assert!(freed(&plain) > 100, "{}", freed(&plain));
    assert_eq!(freed(&guarded), 0);
    // The space above is freed all the same.
    let above = |map: &VoxelMap| cells(map).filter(|c| c[2] > 0 && map.is_free(*c)).count();
    assert_eq!(above(&plain), above(&guarded));
}

/// Rays a good way apart, and a wall that stands on the floor: only the thorough guard leaves the floor before it alone, up to
/// rays that touch the foot of the wall. Across a border of the map's words of 64 cells as elsewhere.
#[test]
fn a_thorough_guard_sees_coarse_floors_and_the_feet_of_walls() {
    for case in 0..8 {
        let at = [20.0, 62.0][case & 1];
        let (turn, coarse) = (case & 2 != 0, case & 4 != 0);
        let mut plain = map(0.25, [80.0, 80.0, 12.0]);
        let place = |along: f64, side: f64, z: f64| {
            let [x, y] = if turn { [side, along] } else { [along, side] };
            let low = plain.low();
            [low[0] + 0.25 * x, low[1] + 0.25 * y, low[2] + 0.25 * z].map(|v| v as f32)
        };
        // Every third cell of a row of the floor; or every one, and a wall behind it.
        let row = |x: f64, z: f64, step: f64| {
            (0..4).map(move |k| (x + 0.5, 40.5 + step * f64::from(k), z))
        };
        let ends: Vec<_> = if coarse {
            row(at, 0.5, 3.0).collect()
        } else {
            row(at, 0.5, 1.0).chain(row(at + 1.0, 1.5, 1.0)).collect()
        };
        let hits: Vec<[f32; 3]> = ends.iter().map(|&(x, y, z)| place(x, y, z)).collect();
        let scan = Scan {
            origin: place(at - 15.0, 36.5, 3.0).map(f64::from),
            hits: &hits,
            ..Scan::default()
        };
        let [mut guarded, mut thorough] = [plain.clone(), plain.clone()];
        plain.insert(&scan).unwrap();
        for (map, guard) in [
            (&mut guarded, GrazingGuard::default()),
            (&mut thorough, GrazingGuard::thorough()),
        ] {
            let grazing_guard = Some(guard);
            map.insert(&Scan {
                grazing_guard,
                ..scan.clone()
            })
            .unwrap();
        }
        let freed = |map: &VoxelMap| cells(map).filter(|c| c[2] == 0 && map.is_free(*c)).count();
        assert_eq!(freed(&plain), freed(&guarded));
        assert!(freed(&plain) >= 12);
        // Of the row's last ray before a wall it cannot tell: nothing is ahead of it on two sides.
        let last = if coarse { 0 } else { 4 };
        assert!(freed(&thorough) <= last, "case {case}");
        assert!(thorough.counts().free > 30);
    }
}

/// A wall that is hit sparsely and passed closely again and again stays; with patience it goes at last once it is not there.
#[test]
fn protected_cells_lose_only_now_and_then() {
    let guard = |patience| {
        Some(GrazingGuard {
            tail: 0.0,
            patience,
            thorough: false,
        })
    };
    let mut map = map(0.25, [40.0, 20.0, 6.0]);
    for x in 0..40 {
        map.set_state([x, 10, 3], State::Occupied);
    }
    let wall = map.clone();
    // Rays along the wall's own cells; every third of them is hit.
    let hits: Vec<[f32; 3]> = (0..13)
        .map(|k| map.center([3 * k, 10, 3]).map(|v| v as f32))
        .collect();
    let scan = Scan {
        origin: map.center([0, 10, 3]),
        hits: &hits,
        grazing_guard: guard(1_000_000),
        ..Scan::default()
    };
    for _ in 0..100 {
        map.insert(&scan).unwrap();
    }
    // The very first scan of all counts for every patience.
    assert!((2..37).all(|x| map.is_occupied([x, 10, 3])));
    let scans_until_free = |patience| {
        let mut map = wall.clone();
        (1..1000).find(|_| {
            map.insert(&Scan {
                grazing_guard: guard(patience),
                ..scan.clone()
            })
            .unwrap();
            map.is_free([4, 10, 3])
        })
    };
    let (off, on) = (scans_until_free(1).unwrap(), scans_until_free(4).unwrap());
    assert_eq!(off, 9);
    assert!((4 * off - 3..=4 * off).contains(&on), "{off} {on}");
}

/// What has gone is free again after three scans that look through it, what has come is seen after two.
#[test]
fn moving_things_come_and_go() {
    let mut map = VoxelMap::new(&voxmap::Config {
        cell_size: 0.25,
        low: [0.0; 3],
        high: [8.0, 2.0, 2.0],
        sensor: SensorModel::dynamic(),
    })
    .unwrap();
    let origin = map.center([1, 4, 4]);
    let see = |map: &mut VoxelMap, x: i32| {
        let hits = [map.center([x, 4, 4]).map(|v| v as f32)];
        map.insert(&Scan {
            origin,
            hits: &hits,
            ..Scan::default()
        })
        .unwrap();
    };
    let mut until = |from: i32, to: i32, cell: [i32; 3], wanted: State| {
        for _ in 0..50 {
            see(&mut map, from);
        }
        (1..50).find(|_| {
            see(&mut map, to);
            map.state(cell) == wanted
        })
    };
    assert_eq!(until(15, 30, [15, 4, 4], State::Free), Some(3));
    assert_eq!(until(30, 15, [15, 4, 4], State::Occupied), Some(2));
}

#[test]
fn growth_has_limits() {
    let model = SensorModel::default();
    let bad = VoxelMap::growing(0.25, &model, 100);
    assert!(matches!(bad, Err(Error::TooLarge { most: 100, .. })));
    assert!(matches!(
        VoxelMap::growing(0.0, &model, MOST),
        Err(Error::Length { .. })
    ));
    let mut map = VoxelMap::growing(0.25, &model, 1 << 18).unwrap();
    fn scan(hits: &[[f32; 3]]) -> Scan<'_> {
        Scan {
            hits,
            origin: [0.5; 3],
            ..Scan::default()
        }
    }
    map.insert(&scan(&[[3.0, 0.5, 0.5]])).unwrap();
    let counts = map.counts();
    for far in [1e4f32, 1e9, f32::MAX] {
        let hits = [[2.0, 0.5, 0.5], [far, far, far]];
        let error = map.insert(&scan(&hits)).unwrap_err();
        assert!(matches!(error, Error::TooLarge { .. }), "{error}");
        assert!(error.to_string().contains("smaller bounds"));
    }
    assert_eq!(
        map.counts(),
        counts,
        "a scan that does not fit leaves no trace"
    );
    // With a range it fits; points that are no numbers do not matter.
    let hits = [
        [1e9, 0.5, 0.5],
        [f32::NAN, 0.5, 0.5],
        [f32::INFINITY, 0.0, 0.0],
    ];
    map.insert(&Scan {
        max_range: 4.0,
        ..scan(&hits)
    })
    .unwrap();
    assert!(map.is_free(map.cell_at([4.0, 0.5, 0.5])));
    let none = CellBox {
        low: [0; 3],
        high: [0; 3],
    };
    assert!(matches!(map.crop(none), Err(Error::TooLarge { .. })));
    let mut bounded = random_map(1, [9.0, 9.0, 9.0], 0.5, 0.1);
    assert!(matches!(
        bounded.crop(bounded.bounds()),
        Err(Error::Fixed { .. })
    ));
    assert!(matches!(
        bounded.grow(bounded.bounds().grown(1)),
        Err(Error::Fixed { .. })
    ));
    assert_eq!(bounded.grow(bounded.bounds()), Ok(false));
}

#[test]
fn an_empty_scan_changes_nothing() {
    for mut map in [
        map(0.25, [9.0; 3]),
        VoxelMap::growing(0.25, &SensorModel::default(), MOST).unwrap(),
    ] {
        map.insert(&Scan {
            grazing_guard: Some(GrazingGuard::default()),
            ..Scan::default()
        })
        .unwrap();
        assert_eq!(map.counts().known, 0);
        assert!(map.take_changes().is_empty());
    }
}

/// Found by the fuzz target `scans`: an end beside the first cell of a row, far from all others.
#[test]
fn a_thorough_guard_looks_beyond_the_rows_first_cell() {
    let scan = Scan {
        origin: [0.110_840_127, 0.110_841_297, 2.7e-43],
        hits: &[[0.110_855_1, 5.2e-44, 0.110_855_1]],
        grazing_guard: Some(GrazingGuard::thorough()),
        ..Scan::default()
    };
    let mut map = VoxelMap::growing(0.1, &SensorModel::default(), 1 << 20).unwrap();
    assert_eq!(map.insert(&scan).unwrap().rays, 1);
    assert!(map.is_occupied([1, -1, 1]));
}

/// A floor seen from above the map is kept like a ceiling seen from below it.
#[test]
fn the_guard_works_for_sensors_beyond_either_face() {
    let [kept, mirrored] = [false, true].map(|mirrored| {
        let mut map = map(0.25, [64.0, 16.0, 8.0]);
        let low = map.low();
        let place = |x: f64, y: f64, z: f64| {
            let z = if mirrored { 8.0 - z } else { z };
            [low[0] + 0.25 * x, low[1] + 0.25 * y, low[2] + 0.25 * z]
        };
        let hits: Vec<[f32; 3]> = (20..50)
            .flat_map(|x| (2..14).map(move |y| place(f64::from(x) + 0.4, f64::from(y) + 0.6, 0.45)))
            .map(|p| p.map(|v| v as f32))
            .collect();
        map.insert(&Scan {
            origin: place(-3.0, 8.3, 9.5),
            hits: &hits,
            grazing_guard: Some(GrazingGuard::default()),
            ..Scan::default()
        })
        .unwrap();
        let floor = if mirrored { 7 } else { 0 };
        let on_floor = |c: &[i32; 3]| c[2] == floor;
        let freed = cells(&map).filter(on_floor).filter(|c| map.is_free(*c));
        (freed.count(), map.counts().occupied)
    });
    assert_eq!(kept, mirrored);
    assert!(kept.0 < 10, "{kept:?}");
    assert_eq!(kept.1, 30 * 12);
}
