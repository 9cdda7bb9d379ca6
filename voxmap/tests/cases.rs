//! One case for each thing that goes wrong.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::{cells, map};
use std::ops::ControlFlow;
use voxmap::{
    Ball, Camera, Config, Error, Esdf, EsdfParams, Scan, SensorModel, State, UnknownPolicy,
    VoxelMap,
};

fn config() -> Config {
    Config {
        cell_size: 0.5,
        low: [0.0; 3],
        high: [10.0, 5.0, 3.0],
        sensor: SensorModel::default(),
    }
}

#[test]
fn cell_size_must_be_positive() {
    for h in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let result = VoxelMap::new(&Config {
            cell_size: h,
            ..config()
        });
        assert!(
            matches!(
                result,
                Err(Error::Length {
                    field: "cell_size",
                    ..
                })
            ),
            "{h}"
        );
    }
}

#[test]
fn bounds_must_hold_something() {
    for high in [
        [0.0; 3],
        [-1.0, 5.0, 3.0],
        [f64::NAN, 5.0, 3.0],
        [f64::INFINITY, 5.0, 3.0],
    ] {
        let result = VoxelMap::new(&Config { high, ..config() });
        assert!(matches!(result, Err(Error::Bounds { .. })), "{high:?}");
    }
}

#[test]
fn maps_of_2_to_the_32_cells_are_refused() {
    let result = VoxelMap::new(&Config {
        cell_size: 0.001,
        high: [4096.0, 1.024, 1.024],
        ..config()
    });
    assert!(matches!(result, Err(Error::TooLarge { .. })));
    let result = VoxelMap::new(&Config {
        cell_size: 1e-300,
        ..config()
    });
    assert!(matches!(result, Err(Error::TooLarge { .. })));
}

#[test]
fn probabilities_must_make_sense() {
    let ok = SensorModel::default();
    for sensor in [
        SensorModel {
            hit: 0.4,
            ..ok.clone()
        },
        SensorModel {
            miss: 0.6,
            ..ok.clone()
        },
        SensorModel {
            hit: 1.0,
            ..ok.clone()
        },
        SensorModel {
            miss: f64::NAN,
            ..ok.clone()
        },
        SensorModel {
            min: 0.9,
            ..ok.clone()
        },
        SensorModel {
            max: 0.4,
            ..ok.clone()
        },
    ] {
        let result = VoxelMap::new(&Config {
            sensor: sensor.clone(),
            ..config()
        });
        assert!(
            matches!(result, Err(Error::Probability { .. })),
            "{sensor:?}"
        );
    }
    VoxelMap::new(&Config {
        sensor: SensorModel::fuel(),
        ..config()
    })
    .unwrap();
}

#[test]
fn bounds_round_up_to_whole_cells() {
    let map = VoxelMap::new(&Config {
        cell_size: 0.15,
        high: [30.0, 20.0, 3.0],
        ..config()
    });
    assert_eq!(map.unwrap().size(), [200, 134, 20]);
}

#[test]
fn scans_name_their_bad_numbers() {
    let mut map = map(0.25, [8.0; 3]);
    let bad = Scan {
        origin: [0.0, f64::NAN, 0.0],
        ..Scan::default()
    };
    assert!(matches!(
        map.insert(&bad),
        Err(Error::Position {
            field: "origin",
            ..
        })
    ));
    for max_range in [0.0, -1.0, f64::NAN] {
        let bad = Scan {
            max_range,
            ..Scan::default()
        };
        assert!(matches!(
            map.insert(&bad),
            Err(Error::Length {
                field: "max_range",
                ..
            })
        ));
    }
    let bad = Scan {
        hit_depth: -0.1,
        ..Scan::default()
    };
    assert!(matches!(
        map.insert(&bad),
        Err(Error::Length {
            field: "hit_depth",
            ..
        })
    ));
    assert_eq!(map.insert(&Scan::default()).unwrap().rays, 0);
}

#[test]
fn bad_points_are_counted_and_left_out() {
    let mut map = map(0.25, [8.0; 3]);
    let origin = map.center([2, 2, 2]).map(|v| f64::from(v as f32));
    let hits = [
        [f32::NAN, 0.0, 0.0],
        [0.0, f32::INFINITY, 0.0],
        [f32::MAX, -f32::MAX, f32::MAX],
        origin.map(|v| v as f32),
        map.center([6, 2, 2]).map(|v| v as f32),
    ];
    let stats = map
        .insert(&Scan {
            origin,
            hits: &hits,
            max_range: 5.0,
            ..Scan::default()
        })
        .unwrap();
    assert_eq!(stats.rejected, 3);
    assert_eq!(stats.rays, 2, "a ray to 1e38 m is a ray, cut at the range");
    assert!(map.is_occupied([6, 2, 2]));
    assert_eq!(map.counts().occupied, 1);
}

#[test]
fn a_million_equal_points_are_one_hit() {
    let mut map = map(0.25, [8.0; 3]);
    let origin = map.center([1, 1, 1]);
    let hits = vec![map.center([6, 1, 1]).map(|v| v as f32); 1_000_000];
    let scan = Scan {
        origin,
        hits: &hits,
        one_ray_per_end_voxel: true,
        ..Scan::default()
    };
    let stats = map.insert(&scan).unwrap();
    assert_eq!((stats.rays, stats.updated), (1, 6));
    let mut once = common::map(0.25, [8.0; 3]);
    once.insert(&Scan {
        hits: &hits[..1],
        ..scan
    })
    .unwrap();
    for c in cells(&map) {
        assert_eq!(map.state(c), once.state(c));
    }
}

/// A wall whose face lies exactly on a border between cells falls into the cell behind, seen from either side.
#[test]
fn faces_on_borders_fall_into_the_solid() {
    for (from, wall, cell) in [(1, 4.0, 4), (7, 4.0, 3)] {
        let mut map = VoxelMap::new(&Config {
            cell_size: 1.0,
            high: [8.0, 3.0, 3.0],
            ..config()
        })
        .unwrap();
        let hits = [[wall, 1.5, 1.5]];
        map.insert(&Scan {
            origin: map.center([from, 1, 1]),
            hits: &hits,
            ..Scan::default()
        })
        .unwrap();
        assert!(map.is_occupied([cell, 1, 1]));
        assert_eq!(map.counts().occupied, 1);
    }
}

#[test]
fn rays_beyond_the_range_or_the_map_only_free() {
    let mut map = VoxelMap::new(&config()).unwrap();
    let origin = [1.25, 1.25, 1.25];
    // Behind the range, on the floor, and beyond the far wall.
    let hits = [[9.25, 1.25, 1.25], [2.25, 1.25, 0.0], [1.25, 7.0, 1.25]];
    map.insert(&Scan {
        origin,
        hits: &hits,
        max_range: 4.0,
        ..Scan::default()
    })
    .unwrap();
    let counts = map.counts();
    assert_eq!(counts.occupied, 0);
    assert!(map.is_free([10, 2, 2]) && !map.is_known([11, 2, 2]));
    assert!(map.is_free([4, 2, 0]) && map.is_free([2, 9, 2]));
}

#[test]
fn sensors_outside_the_map_see_into_it() {
    let mut map = VoxelMap::new(&config()).unwrap();
    let hits = [[6.25, 1.25, 1.25]];
    map.insert(&Scan {
        origin: [-3.0, 1.25, 1.25],
        hits: &hits,
        ..Scan::default()
    })
    .unwrap();
    assert!(map.is_free([0, 2, 2]) && map.is_occupied([12, 2, 2]));
    assert_eq!(map.counts().known, 13);
    let past = [[-1.0, 9.0, 1.0]];
    let stats = map.insert(&Scan {
        origin: [-3.0, 1.0, 1.0],
        hits: &past,
        ..Scan::default()
    });
    assert_eq!(stats.unwrap().rays, 0);
}

#[test]
fn rays_along_borders_and_corners_stay_6_connected() {
    let mut map = VoxelMap::new(&config()).unwrap();
    // Exactly along a border, and exactly through corners.
    for (origin, end) in [
        ([0.0, 1.0, 1.0], [9.0, 1.0, 1.0]),
        ([0.0, 0.0, 0.0], [2.5, 2.5, 2.5]),
        ([4.0, 4.0, 2.0], [2.0, 2.0, 0.0]),
    ] {
        map.reset_box([-1.0; 3], [11.0; 3]);
        map.insert(&Scan {
            origin,
            misses: &[end],
            ..Scan::default()
        })
        .unwrap();
        let (first, last) = (map.cell_at(origin), map.cell_at(end.map(f64::from)));
        let steps: i32 = (0..3).map(|a| (first[a] - last[a]).abs()).sum();
        assert_eq!(map.counts().free as i32, steps + 1);
        assert!(map.is_free(first) && map.is_free(last));
    }
}

/// Longer than the integer lanes can count: 3000 cells.
#[test]
fn very_long_rays_are_exact_too() {
    let mut map = VoxelMap::new(&Config {
        cell_size: 0.01,
        high: [30.0, 0.05, 0.05],
        ..config()
    })
    .unwrap();
    let misses = [[29.995, 0.045, 0.025]];
    map.insert(&Scan {
        origin: [0.005, 0.005, 0.025],
        misses: &misses,
        ..Scan::default()
    })
    .unwrap();
    assert_eq!(map.counts().free, 3000 + 4);
}

#[test]
fn the_self_filter_keeps_the_robot_out() {
    let mut map = VoxelMap::new(&config()).unwrap();
    let skip = [Ball {
        center: [3.0, 1.25, 1.25],
        radius: 0.6,
    }];
    // On the robot itself, and beyond it.
    let hits = [[2.6, 1.25, 1.25], [6.25, 1.25, 1.25]];
    let scan = Scan {
        origin: [0.25, 1.25, 1.25],
        hits: &hits,
        skip: &skip,
        ..Scan::default()
    };
    let stats = map.insert(&scan).unwrap();
    assert_eq!((stats.filtered, stats.rays), (1, 1));
    assert!(!map.is_known([5, 2, 2]) && !map.is_known([6, 2, 2]));
    assert!(map.is_free([4, 2, 2]) && map.is_free([7, 2, 2]) && map.is_occupied([12, 2, 2]));
    // The filter is gone with its scan.
    map.insert(&Scan { skip: &[], ..scan }).unwrap();
    assert!(map.is_known([5, 2, 2]));
}

#[test]
fn freed_cells_are_no_longer_inspected() {
    let mut map = VoxelMap::new(&config()).unwrap();
    map.set_free_box([0.0; 3], [10.0, 5.0, 3.0]);
    map.set_state([8, 4, 2], State::Occupied);
    let camera = Camera {
        rotation: [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
        translation: [0.25, 2.25, 1.25],
        tan_half_h: 0.5,
        tan_half_v: 0.5,
    };
    assert_eq!(map.mark_inspected(&camera, 2.0), 0, "too far");
    assert_eq!(map.mark_inspected(&camera, 8.0), 1);
    assert_eq!(map.mark_inspected(&camera, 8.0), 0, "once is enough");
    assert!(map.is_inspected([8, 4, 2]));
    map.set_state([8, 4, 2], State::Free);
    map.set_state([8, 4, 2], State::Occupied);
    assert!(!map.is_inspected([8, 4, 2]));
    let blind = Camera {
        translation: [f64::NAN; 3],
        ..camera
    };
    assert_eq!(map.mark_inspected(&blind, 8.0), 0);
}

#[test]
fn far_and_broken_queries_are_answered() {
    let mut map = VoxelMap::new(&config()).unwrap();
    map.set_free_box([0.0; 3], [10.0, 5.0, 3.0]);
    assert!(!map.line_of_sight([f64::NAN; 3], [1, 1, 1], 0));
    assert!(!map.line_of_sight([1e12, 2.0, 1.0], [1, 1, 1], u32::MAX));
    assert!(
        !map.line_of_sight([11.4, 0.75, 0.75], [1, 1, 1], 2),
        "three unknown cells outside"
    );
    assert!(map.line_of_sight([11.4, 0.75, 0.75], [1, 1, 1], 3));
    assert!(map.line_of_sight([2.0, 2.0, 1.0], [1, 1, 1], 0));
    let mut visits = 0;
    map.walk([-1e12, 1.1, 1.1], [1e12, 1.1, 1.1], |_| {
        visits += 1;
        ControlFlow::Continue(())
    });
    assert_eq!(visits, 0, "too far to walk");
    let hit = map.cast([1.0; 3], [1.0, 0.0, 0.0], 1e12, UnknownPolicy::Stop);
    assert!(!hit.occupied);
    assert!((hit.distance - 9.0).abs() < 1e-3);
    for direction in [[0.0; 3], [f64::NAN; 3]] {
        assert!(
            !map.cast([1.0; 3], direction, 5.0, UnknownPolicy::Pass)
                .occupied
        );
    }
    assert!(map.ball_is_free([2.0; 3], 0.4, true));
    assert!(
        !map.ball_is_free([-1.0, 2.0, 1.0], 0.4, true)
            && map.ball_is_free([-1.0, 2.0, 1.0], 0.4, false)
    );
    assert!(
        !map.ball_is_free([f64::NAN; 3], 0.4, false)
            && !map.ball_is_free([2.0; 3], f64::NAN, false)
    );
    assert!(!map.ball_is_free([2.0; 3], 1e9, true));
    map.set_free_sphere([f64::NAN; 3], 1.0);
    map.reset_box([f64::NAN; 3], [f64::NAN; 3]);
    assert_eq!(map.counts().free, 20 * 10 * 6);
}

#[test]
fn distance_fields_of_odd_maps() {
    let map = VoxelMap::new(&Config {
        cell_size: 1.0,
        high: [1.0; 3],
        ..config()
    })
    .unwrap();
    for truncation in [0.0, -1.0, f64::NAN, 1e9] {
        let params = EsdfParams {
            truncation,
            unknown_is_occupied: true,
        };
        assert!(matches!(
            Esdf::new(&map, params),
            Err(Error::Length {
                field: "truncation",
                ..
            })
        ));
    }
    let field = Esdf::new(&map, EsdfParams::default()).unwrap();
    assert_eq!(field.distance_gradient([0.5; 3]), (-0.5, [0.0; 3]));
    assert_eq!(field.distance([f64::INFINITY; 3]), -0.5);
    assert!(field.distance([f64::NAN; 3]) < 0.0);
    // Nothing occupied anywhere: everything is far.
    let params = EsdfParams {
        truncation: 2.0,
        unknown_is_occupied: false,
    };
    let field = Esdf::new(&map, params).unwrap();
    assert!(field.distance([0.5; 3]) >= 2.0);
}

/// A map of free cells with a wall of occupied ones at x = 8, y from 0 to 9, z from 0 to 5, cells of 0.5 m.
fn wall() -> VoxelMap {
    let mut map = VoxelMap::new(&config()).unwrap();
    map.set_free_box([0.0; 3], [10.0, 5.0, 3.0]);
    for y in 0..10 {
        for z in 0..6 {
            map.set_state([8, y, z], State::Occupied);
            // Nothing is known behind it.
            map.set_state([9, y, z], State::Unknown);
        }
    }
    map
}

fn looking_along_x(at: [f64; 3]) -> Camera {
    Camera {
        rotation: [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
        translation: at,
        tan_half_h: 3.0,
        tan_half_v: 3.0,
    }
}

#[test]
fn a_wall_seen_flatter_than_45_degrees_is_inspected_up_to_the_limit() {
    // From 1.25 m before the face, at y = 0.25: the face of cell y is 0.5 y aside.
    let camera = looking_along_x([2.75, 0.25, 1.25]);
    let mut steep = wall();
    steep.mark_inspected_within(&camera, 8.0, 64_f64.to_radians());
    // tan 64 degrees = 2.05; the cells' middles are 1.5 m away.
    assert!(steep.is_inspected([8, 6, 2]), "3.0 m aside is 63.4 degrees");
    assert!(
        !steep.is_inspected([8, 7, 2]),
        "3.5 m aside is 66.8 degrees"
    );
    // The published rule looks for the middle of the cell, behind its neighbours in the wall.
    let mut published = wall();
    published.mark_inspected(&camera, 8.0);
    assert!(published.is_inspected([8, 2, 2]) && !published.is_inspected([8, 6, 2]));
}

#[test]
fn two_images_in_a_row_inspect_what_both_show() {
    let narrow = |y| Camera {
        tan_half_h: 0.62,
        ..looking_along_x([2.75, y, 1.25])
    };
    let mut map = wall();
    map.mark_inspected_twice(&narrow(1.25), &narrow(2.25), 8.0, 1.1, 0.0);
    // The faces are 1.25 m away, so that each shows 0.775 m to either side: 0.475..2.025 and 1.475..3.025.
    let seen: Vec<i32> = (0..10).filter(|&y| map.is_inspected([8, y, 2])).collect();
    assert_eq!(seen, [3]);
    let mut whole = wall();
    assert_eq!(
        whole.mark_inspected_twice(&narrow(1.25), &narrow(2.25), 8.0, 1.1, 0.3),
        0,
        "no target of 0.6 m is whole in both images"
    );
}

#[test]
fn faces_are_wide_where_the_surface_goes_on() {
    let mut map = VoxelMap::new(&config()).unwrap();
    map.set_free_box([0.0; 3], [10.0, 5.0, 3.0]);
    map.skip_narrow_faces(true);
    let mut put = |cells: &mut dyn Iterator<Item = [i32; 3]>| {
        for c in cells {
            map.set_state(c, State::Occupied);
        }
    };
    // A wall at 45 degrees, two cells thick in x and three high; a beam of 2 x 2 cells along x; a block of one cell on it.
    put(&mut (0..6)
        .flat_map(|i| (1..4).flat_map(move |z| (0..2).map(move |dx| [2 + i + dx, 1 + i, z]))));
    put(&mut (10..18).flat_map(|x| (2..4).flat_map(move |y| (1..3).map(move |z| [x, y, z]))));
    put(&mut [[14, 2, 3]].into_iter());
    // The wall's steps go on beside, and above or below.
    assert_eq!(map.open_faces([4, 3, 2]), 0b00_1001);
    assert_eq!(map.open_faces([5, 3, 2]), 0b00_0110);
    // The beam's sides and top are wide, also next to the block, but the block's own faces are not.
    assert_eq!(map.open_faces([12, 2, 2]), 0b10_0100);
    assert_eq!(map.open_faces([15, 2, 2]), 0b10_0100);
    assert_eq!(map.open_faces([14, 2, 3]), 0);
    // The beam's end is two by two cells.
    assert_eq!(map.open_faces([10, 2, 2]), 0b10_0101);
}

#[test]
fn narrow_faces_need_no_inspection_but_may_have_it() {
    // A board one cell thick: its edge is narrow, its two sides are not. A post is narrow all around.
    let mut map = VoxelMap::new(&config()).unwrap();
    map.set_free_box([0.0; 3], [10.0, 5.0, 3.0]);
    for x in 4..8 {
        for y in 4..8 {
            map.set_state([x, y, 2], State::Occupied);
        }
    }
    map.set_state([15, 5, 2], State::Occupied);
    let (inner, edge, post) = ([5, 5, 2], [4, 5, 2], [15, 5, 2]);
    let up_and_down = 0b11_0000;
    assert_eq!(map.open_faces(edge), up_and_down | 1);
    assert_ne!(map.open_faces(post), 0);
    map.skip_narrow_faces(true);
    assert_eq!(map.open_faces(inner), up_and_down);
    assert_eq!(map.open_faces(edge), up_and_down);
    assert_eq!(map.open_faces(post), 0);
    assert!(!map.is_inspected(post), "not seen yet");
    let camera = looking_along_x([6.25, 2.75, 1.25]);
    map.mark_inspected_within(&camera, 8.0, 1.1);
    assert!(map.is_inspected(post), "seen on the way");
    assert!(!map.is_inspected(edge));
}
