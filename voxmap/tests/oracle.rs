//! The fast code against brute force on small maps.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::{Numbers, cells, map, overlap, random_map};
use std::collections::{BTreeSet, HashSet};
use std::ops::ControlFlow;
use voxmap::{Ball, Camera, Cell, Esdf, EsdfParams, Scan, State, UnknownPolicy, VoxelMap};

/// Every cell the ray surely crosses is marked, none that it surely misses.
fn check_ray(map: &VoxelMap, marked: &BTreeSet<Cell>, from: [f64; 3], to: [f64; 3]) {
    // Ends may move by 1/1024 cell.
    let hair = 0.003 * map.cell_size();
    for cell in cells(map) {
        let (enter, leave) = overlap(map, cell, from, to, hair);
        if marked.contains(&cell) {
            assert!(enter <= leave, "{cell:?} is not on the ray {from:?} {to:?}");
        }
        let (enter, leave) = overlap(map, cell, from, to, -hair);
        if enter < leave {
            assert!(
                marked.contains(&cell),
                "{cell:?} is on the ray {from:?} {to:?}"
            );
        }
    }
}

#[test]
fn inserted_rays_mark_exactly_the_cells_they_cross() {
    let mut numbers = Numbers(1);
    for _ in 0..150 {
        let mut map = map(0.25, [13.0, 9.0, 7.0]);
        let from = numbers.point(&map);
        let to = numbers.point(&map).map(|v| f64::from(v as f32));
        let misses = [to.map(|v| v as f32)];
        let scan = Scan {
            origin: from,
            misses: &misses,
            ..Scan::default()
        };
        map.insert(&scan).unwrap();
        let marked: BTreeSet<Cell> = cells(&map).filter(|&c| map.is_known(c)).collect();
        assert_eq!(map.counts().free, marked.len());
        check_ray(&map, &marked, from, to);
    }
}

#[test]
fn walks_visit_exactly_the_cells_they_cross() {
    let mut numbers = Numbers(2);
    for _ in 0..150 {
        let map = map(0.25, [13.0, 9.0, 7.0]);
        let (from, to) = (numbers.point(&map), numbers.point(&map));
        let mut path = vec![];
        map.walk(from, to, |c| {
            path.push(c);
            ControlFlow::Continue(())
        });
        let marked: BTreeSet<Cell> = path.iter().copied().filter(|&c| map.contains(c)).collect();
        check_ray(&map, &marked, from, to);
        for pair in path.windows(2) {
            assert_eq!(
                (0..3).map(|a| (pair[0][a] - pair[1][a]).abs()).sum::<i32>(),
                1
            );
        }
    }
}

/// A ray and its reverse cross the same cells, unless they touch a border between cells: there each may take either side.
#[test]
fn reversed_walks_visit_the_same_cells() {
    let mut numbers = Numbers(27);
    let mut same = 0;
    for _ in 0..400 {
        let map = map(0.25, [13.0, 9.0, 7.0]);
        let (from, to) = (numbers.point(&map), numbers.point(&map));
        let walked = |from, to| {
            let mut path = BTreeSet::new();
            map.walk(from, to, |c| {
                path.insert(c);
                ControlFlow::Continue(())
            });
            path
        };
        let (there, back) = (walked(from, to), walked(to, from));
        assert_eq!(there.len(), back.len());
        for &cell in there.symmetric_difference(&back) {
            let (enter, leave) = overlap(&map, cell, from, to, 0.0);
            let metres = (leave - enter).max(0.0)
                * (0..3)
                    .map(|a| (to[a] - from[a]).powi(2))
                    .sum::<f64>()
                    .sqrt();
            assert!(
                metres < 1e-6,
                "{cell:?} is crossed for {metres} m one way only"
            );
        }
        same += usize::from(there == back);
    }
    assert!(same > 390, "{same}");
}

/// A whole scan against sets of cells: once per cell, hits win, the self filter holds.
#[test]
fn scans_equal_a_model_of_single_rays() {
    let mut numbers = Numbers(3);
    for round in 0..30 {
        let mut map = map(0.25, [70.0, 11.0, 6.0]);
        let origin = if round % 3 == 0 {
            numbers.point(&map)
        } else {
            map.center(numbers.cell(&map))
        };
        let points: Vec<[f32; 3]> = (0..300)
            .map(|_| numbers.point(&map).map(|v| v as f32))
            .collect();
        let (hits, misses) = points.split_at(200);
        let skip = [Ball {
            center: numbers.point(&map),
            radius: 0.6,
        }];
        let scan = Scan {
            origin,
            hits,
            misses,
            max_range: 6.0,
            skip: &skip,
            ..Scan::default()
        };
        // Each ray alone, in a map of its own.
        let (mut hit, mut passed) = (HashSet::new(), HashSet::new());
        for (i, point) in points.iter().enumerate() {
            let mut alone = VoxelMap::clone(&map);
            let one = std::slice::from_ref(point);
            let (hits, misses) = if i < 200 {
                (one, &one[..0])
            } else {
                (&one[..0], one)
            };
            alone
                .insert(&Scan {
                    hits,
                    misses,
                    ..scan.clone()
                })
                .unwrap();
            for cell in cells(&alone) {
                if alone.is_occupied(cell) {
                    hit.insert(cell);
                } else if alone.is_free(cell) {
                    passed.insert(cell);
                }
            }
        }
        let stats = map.insert(&scan).unwrap();
        for cell in cells(&map) {
            let wanted = if hit.contains(&cell) {
                State::Occupied
            } else if passed.contains(&cell) {
                State::Free
            } else {
                State::Unknown
            };
            assert_eq!(map.state(cell), wanted, "{cell:?}");
            if skip[0].contains(map.center(cell)) {
                assert_eq!(wanted, State::Unknown);
            }
        }
        assert_eq!(stats.updated, hit.union(&passed).count());
        assert_eq!(stats.rejected, 0);
    }
}

#[test]
fn lines_of_sight_and_casts_equal_a_slow_walk() {
    let map = random_map(4, [30.0, 20.0, 8.0], 0.8, 0.08);
    let mut numbers = Numbers(5);
    for _ in 0..2000 {
        let (from, to) = (numbers.point(&map), numbers.cell(&map));
        let allowance = numbers.below(4) as u32;
        let (mut clear, mut unknown) = (true, 0);
        map.walk(from, map.center(to), |c| {
            if c == to {
                return ControlFlow::Break(());
            }
            clear &= !map.is_occupied(c);
            unknown += u32::from(!map.is_known(c));
            ControlFlow::Continue(())
        });
        let seen = clear && unknown <= allowance;
        assert_eq!(
            map.line_of_sight(from, to, allowance),
            seen,
            "{from:?} {to:?}"
        );

        let end = map.center(to);
        let way = [0, 1, 2].map(|a| end[a] - from[a]);
        let length = way.iter().map(|v| v * v).sum::<f64>().sqrt();
        let mut first = None;
        map.walk(from, end, |c| {
            if map.is_occupied(c) {
                first = Some(c);
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        });
        let cast = map.cast(from, way, length, UnknownPolicy::Pass);
        assert_eq!(
            cast.occupied.then_some(cast.cell),
            first,
            "{from:?} {end:?}"
        );
        if cast.occupied {
            let (enter, _) = overlap(&map, cast.cell, from, end, 0.0);
            assert!((cast.distance - enter.max(0.0) * length).abs() < 1e-6);
        }
    }
}

fn brute_distance(map: &VoxelMap, cell: Cell, unknown: bool) -> f64 {
    let blocked = |c: &Cell| map.is_occupied(*c) || (unknown && !map.is_known(*c));
    let square = cells(map)
        .filter(blocked)
        .map(|c| {
            (0..3)
                .map(|a| f64::from(c[a] - cell[a]).powi(2))
                .sum::<f64>()
        })
        .fold(f64::INFINITY, f64::min);
    (square.sqrt() - 0.5) * map.cell_size()
}

#[test]
fn distances_equal_brute_force_up_to_the_truncation() {
    for (seed, occupied) in [(6, 0.004), (7, 0.03), (8, 0.0)] {
        let map = random_map(seed, [29.0, 14.0, 9.0], 1.0 - occupied, occupied);
        for (truncation, unknown_is_occupied) in [(0.7, true), (2.0, false), (20.0, true)] {
            let params = EsdfParams {
                truncation,
                unknown_is_occupied,
            };
            let field = Esdf::new(&map, params).unwrap();
            for cell in cells(&map).step_by(3) {
                let (fast, slow) = (
                    field.cell_distance(cell),
                    brute_distance(&map, cell, unknown_is_occupied),
                );
                if slow <= truncation {
                    assert!((fast - slow).abs() < 1e-5, "{cell:?}: {fast} {slow}");
                } else {
                    assert!(fast >= truncation - 1e-5 && fast <= slow + 1e-5);
                }
            }
        }
    }
}

/// Cells go together in blocks of 64: sizes around them, and obstacles so few that ways between blocks are long.
#[test]
fn distances_in_wide_maps_equal_brute_force() {
    for (seed, size) in [
        (20, [64.0, 65.0, 3.0]),
        (21, [129.0, 63.0, 4.0]),
        (22, [190.0, 130.0, 2.0]),
        (23, [5.0, 200.0, 66.0]),
        (24, [200.0, 1.0, 1.0]),
    ] {
        let map = random_map(seed, size, 0.9995, 0.0005);
        let obstacles: Vec<Cell> = cells(&map).filter(|c| map.is_occupied(*c)).collect();
        for reach in [3, 40, 249] {
            let params = EsdfParams {
                truncation: f64::from(reach) * map.cell_size(),
                unknown_is_occupied: false,
            };
            let field = Esdf::new(&map, params.clone()).unwrap();
            for cell in cells(&map).step_by(17) {
                let square = obstacles
                    .iter()
                    .map(|c| (0..3).map(|a| (c[a] - cell[a]).pow(2)).sum::<i32>())
                    .min()
                    .unwrap_or(i32::MAX);
                let slow = (f64::from(square).sqrt() - 0.5) * map.cell_size();
                let fast = field.cell_distance(cell);
                if slow <= params.truncation {
                    assert!(
                        (fast - slow).abs() < 1e-5,
                        "{size:?} {reach} {cell:?}: {fast} {slow}"
                    );
                } else {
                    assert!(fast >= params.truncation - 1e-5 && fast <= slow + 1e-5);
                }
            }
        }
    }
}

#[test]
fn updated_distances_equal_a_rebuild_bit_for_bit() {
    updates_equal_rebuilds([90.0, 40.0, 12.0], 1.5, 40);
    updates_equal_rebuilds([170.0, 140.0, 5.0], 5.0, 12);
}

fn updates_equal_rebuilds(size: [f64; 3], truncation: f64, rounds: usize) {
    let mut map = random_map(9, size, 0.98, 0.01);
    let params = EsdfParams {
        truncation,
        unknown_is_occupied: true,
    };
    let mut field = Esdf::new(&map, params.clone()).unwrap();
    map.take_changes();
    let mut numbers = Numbers(10);
    for round in 0..rounds {
        for _ in 0..[1, 3, 40][round % 3] {
            let state = [State::Free, State::Occupied, State::Unknown][numbers.below(3)];
            map.set_state(numbers.cell(&map), state);
        }
        if round % 10 == 5 {
            let low = numbers.point(&map);
            map.set_free_box(low, low.map(|v| v + 2.0));
        }
        field.update(&map, &map.clone().take_changes());
        map.take_changes();
        let whole = Esdf::new(&map, params.clone()).unwrap();
        for cell in cells(&map) {
            let (a, b) = (field.cell_distance(cell), whole.cell_distance(cell));
            assert_eq!(a.to_bits(), b.to_bits(), "round {round}, {cell:?}");
        }
    }
}

#[test]
fn gradients_are_those_of_the_interpolated_value() {
    let map = random_map(11, [24.0, 17.0, 9.0], 0.97, 0.03);
    let field = Esdf::new(&map, EsdfParams::default()).unwrap();
    let mut numbers = Numbers(12);
    let step = 1e-6;
    for _ in 0..3000 {
        let p = numbers.point(&map);
        let (value, gradient) = field.distance_gradient(p);
        assert_eq!(value, field.distance(p));
        for a in 0..3 {
            let u = (p[a] - map.low()[a]) / map.cell_size() - 0.5;
            if (u - u.round()).abs() < 1e-4 {
                continue;
            }
            let at = |d: f64| {
                let mut q = p;
                q[a] += d;
                field.distance(q)
            };
            let slope = (at(step) - at(-step)) / (2.0 * step);
            assert!(
                (slope - gradient[a]).abs() < 1e-6,
                "{p:?} {a}: {slope} {}",
                gradient[a]
            );
        }
    }
}

#[test]
fn balls_equal_brute_force() {
    let map = random_map(13, [70.0, 20.0, 9.0], 0.9, 0.03);
    let mut numbers = Numbers(14);
    let h = map.cell_size();
    for _ in 0..4000 {
        let (center, radius) = (numbers.point(&map), numbers.next() * 0.8);
        for unknown_blocks in [false, true] {
            // Cells around the ball, also outside the map.
            let low = map.cell_at(center.map(|v| v - 1.0));
            let mut free = true;
            for z in 0..10 {
                for y in 0..10 {
                    for x in 0..10 {
                        let cell = [low[0] + x, low[1] + y, low[2] + z];
                        let above = cell[2] < 0 || cell[2] >= map.size()[2] as i32;
                        let blocked = map.is_occupied(cell)
                            || (unknown_blocks && !above && !map.is_known(cell));
                        let gap: f64 = (0..3)
                            .map(|a| {
                                let near = map.low()[a] + f64::from(cell[a]) * h;
                                (near - center[a])
                                    .max(center[a] - near - h)
                                    .max(0.0)
                                    .powi(2)
                            })
                            .sum();
                        free &= !(blocked && gap < radius * radius);
                    }
                }
            }
            let fast = map.ball_is_free(center, radius, unknown_blocks);
            assert_eq!(fast, free, "{center:?} {radius} {unknown_blocks}");
        }
    }
}

#[test]
fn inspection_equals_its_definition() {
    let mut numbers = Numbers(15);
    for _ in 0..20 {
        let mut map = random_map(numbers.below(1000) as u64, [40.0, 30.0, 8.0], 0.7, 0.05);
        let (s, c) = (6.3 * numbers.next()).sin_cos();
        let camera = Camera {
            rotation: [[s, 0.0, c], [-c, 0.0, s], [0.0, -1.0, 0.0]],
            translation: map.center(numbers.cell(&map)),
            tan_half_h: 0.7,
            tan_half_v: 0.4,
        };
        let eye = camera.translation;
        let before = map.clone();
        let new = map.mark_inspected(&camera, 3.0);
        let mut expected = 0;
        for cell in cells(&map) {
            let p = before.center(cell);
            let distance = (0..3).map(|a| (p[a] - eye[a]).powi(2)).sum::<f64>().sqrt();
            let seen = before.exposed_faces(cell) != 0
                && distance < 3.0
                && camera.sees(p)
                && before.line_of_sight(eye, cell, u32::MAX);
            assert_eq!(map.is_inspected(cell), seen, "{cell:?}");
            expected += usize::from(seen);
        }
        assert_eq!(new, expected);
        assert_eq!(map.counts().inspected, expected);
    }
}

/// Casts and balls against parry3d's cuboids, one for each occupied cell.
#[test]
fn casts_and_balls_equal_parry() {
    use parry3d::math::{Pose, Vec3};
    use parry3d::query::{Ray, RayCast, intersection_test};
    use parry3d::shape::{Ball, Cuboid};
    let vec = |p: [f64; 3]| Vec3::new(p[0] as f32, p[1] as f32, p[2] as f32);
    let mut numbers = Numbers(21);
    for _ in 0..6 {
        let map = random_map(numbers.below(1000) as u64, [20.0, 14.0, 9.0], 0.97, 0.02);
        let h = map.cell_size();
        let cube = Cuboid::new(Vec3::splat(0.5 * h as f32));
        let occupied: Vec<Cell> = cells(&map).filter(|&c| map.is_occupied(c)).collect();
        for _ in 0..200 {
            let origin = numbers.point(&map);
            let direction = [0; 3].map(|_| 2.0 * numbers.next() - 1.0);
            let norm = direction.iter().map(|v| v * v).sum::<f64>().sqrt();
            let ray = Ray::new(vec(origin), vec(direction.map(|v| v / norm)));
            let first = occupied
                .iter()
                .filter_map(|&c| {
                    cube.cast_ray(&Pose::from_translation(vec(map.center(c))), &ray, 5.0, true)
                })
                .fold(f32::INFINITY, f32::min);
            for policy in [UnknownPolicy::Pass, UnknownPolicy::Ignore] {
                let hit = map.cast(origin, direction, 5.0, policy);
                let ours = if hit.occupied {
                    hit.distance as f32
                } else {
                    f32::INFINITY
                };
                // Parry computes in f32, so that a ray that scrapes a cube may miss it there; the oracle above is exact.
                let near = ours == first || (ours - first).abs() < 1e-4;
                let scrapes = || {
                    let hair = 1e-5;
                    let touched = |grow: f64| {
                        occupied.iter().any(|&c| {
                            let end = [0, 1, 2].map(|a| origin[a] + 5.0 * direction[a] / norm);
                            let (enter, leave) = overlap(&map, c, origin, end, grow);
                            enter <= leave
                                && ((enter.max(0.0) * 5.0) as f32 - ours.min(first)).abs() < 1e-3
                        })
                    };
                    touched(hair) != touched(-hair)
                };
                assert!(
                    near || scrapes(),
                    "{origin:?} {direction:?}: {ours} {first}"
                );
            }
            let radius = 0.05 + 0.5 * numbers.next();
            let ball = Ball::new(radius as f32);
            let at = Pose::from_translation(vec(origin));
            let touches = occupied.iter().any(|&c| {
                let cube_at = Pose::from_translation(vec(map.center(c)));
                intersection_test(&at, &ball, &cube_at, &cube)
                    .unwrap()
                    .intersecting
            });
            assert_eq!(
                map.ball_is_free(origin, radius, false),
                !touches,
                "{origin:?} {radius}"
            );
        }
    }
}
