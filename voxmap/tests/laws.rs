//! What holds for any scan and any map.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::{Numbers, cells, map, random_map};
use proptest::prelude::*;
use voxmap::{Camera, Cell, Esdf, EsdfParams, Scan, SensorModel, State, VoxelMap};

fn points(seed: u64, map: &VoxelMap, n: usize) -> Vec<[f32; 3]> {
    let mut numbers = Numbers(seed);
    (0..n)
        .map(|_| numbers.point(map).map(|v| v as f32))
        .collect()
}

fn states(map: &VoxelMap) -> Vec<State> {
    cells(map).map(|c| map.state(c)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// The order of the points in a scan does not matter.
    #[test]
    fn order_does_not_matter(seed: u64, n in 1usize..700) {
        let mut forward = map(0.25, [40.0, 20.0, 8.0]);
        let origin = Numbers(seed).point(&forward);
        let mut hits = points(seed ^ 1, &forward, n);
        let mut backward = forward.clone();
        forward.insert(&Scan { origin, hits: &hits, ..Scan::default() }).unwrap();
        hits.reverse();
        backward.insert(&Scan { origin, hits: &hits, ..Scan::default() }).unwrap();
        prop_assert_eq!(states(&forward), states(&backward));
    }

    /// One ray per end frees no cell that all rays would not, and agrees on every hit.
    #[test]
    fn one_ray_per_end_is_a_part_of_all(seed: u64, n in 1usize..700) {
        let mut all = map(0.25, [40.0, 20.0, 8.0]);
        let origin = Numbers(seed).point(&all);
        let hits = points(seed ^ 1, &all, n);
        let mut some = all.clone();
        let scan = Scan { origin, hits: &hits, ..Scan::default() };
        all.insert(&scan).unwrap();
        some.insert(&Scan { one_ray_per_end_voxel: true, ..scan }).unwrap();
        for cell in cells(&all) {
            prop_assert_eq!(all.is_occupied(cell), some.is_occupied(cell));
            prop_assert!(!some.is_free(cell) || all.is_free(cell));
        }
    }

    /// Rows of words agree with cells, also where rows fill their words, and in maps that have grown below cell 0.
    #[test]
    fn frontier_words_keep_the_laws(seed: u64, skip: bool) {
        let mut numbers = Numbers(seed);
        let length = [1.0, 63.0, 64.0, 65.0, 128.0, 131.0][numbers.below(6)];
        let mut map = random_map(seed, [length, 4.0, 3.0], 0.4, 0.3);
        map.skip_narrow_faces(skip);
        frontier::conformance::check(&map);
        let mut map = VoxelMap::growing(0.25, &SensorModel::default(), 1 << 20).unwrap();
        let hits: Vec<[f32; 3]> = (0..20)
            .map(|_| [40.0, 2.0, 1.0].map(|side| (side * (numbers.next() - 0.5)) as f32))
            .collect();
        map.insert(&Scan { origin: [0.0; 3], hits: &hits, max_range: 30.0, ..Scan::default() }).unwrap();
        frontier::conformance::check(&map);
    }

    /// A face is to be inspected if it is open, the cell is thick enough, and the surface goes on around it; words of cells agree
    /// with cells.
    #[test]
    fn only_wide_faces_are_to_be_inspected(seed: u64, strips: bool) {
        let mut map = random_map(seed, [131.0, 7.0, 6.0], 0.4, 0.55);
        if strips {
            // Something to be beside of.
            for k in 0..6 {
                let eye = Numbers(seed ^ k).point(&map);
                // Looks along +y, or up.
                let rotation = match k % 2 {
                    0 => [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
                    _ => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                };
                let camera = Camera { rotation, translation: eye, tan_half_h: 1.5, tan_half_v: 1.5 };
                map.mark_inspected_within(&camera, 4.0, 1.2);
            }
        }
        let unseen: std::collections::BTreeMap<Cell, u8> = cells(&map).map(|c| (c, map.open_faces(c))).collect();
        map.skip_narrow_faces(true);
        map.skip_inspected_strips(strips);
        let steps = [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]];
        let plus = |c: Cell, d: Cell| [0, 1, 2].map(|a| c[a] + d[a]);
        for cell in cells(&map) {
            let open = |c: Cell, f: usize| map.is_occupied(c) && map.is_free(plus(c, steps[f]));
            let mut expected = 0u8;
            for f in 0..6 {
                let axis = f / 2;
                let thin = (0..3).any(|a| a != axis && open(cell, 2 * a) && open(cell, 2 * a + 1));
                let around = |d: Cell| {
                    // Upright surfaces may step by one cell along their normal.
                    let shifts = if axis == 2 { 0..=0 } else { -1..=1 };
                    shifts.into_iter().any(|s| {
                        let mut d = d;
                        d[axis] += s;
                        let c = plus(cell, d);
                        open(c, f) && (!strips || unseen.get(&c).is_some_and(|faces| faces >> f & 1 != 0))
                    })
                };
                let wide = if axis == 2 {
                    [-1, 1].into_iter().any(|x| [-1, 1].into_iter().any(|y| {
                        around([x, 0, 0]) && around([0, y, 0]) && around([x, y, 0])
                    }))
                } else {
                    let mut side = [0; 3];
                    side[1 - axis] = 1;
                    let other = side.map(|v: i32| -v);
                    (around(side) || around(other)) && (around([0, 0, 1]) || around([0, 0, -1]))
                };
                if unseen[&cell] >> f & 1 != 0 && !thin && wide {
                    expected |= 1 << f;
                }
            }
            prop_assert_eq!(map.open_faces(cell), expected, "{:?}", cell);
            #[cfg(feature = "frontier")]
            {
                let mut word = [0];
                frontier::Map::inspection_words(&map, cell, 1, &mut word);
                let word = word[0];
                prop_assert_eq!(word & 1 != 0, expected != 0, "word at {:?}", cell);
            }
        }
    }

    /// What a scan does to a cell does not depend on how many scans elsewhere lie in between: 1, 255, 256 or 300.
    #[test]
    fn scans_elsewhere_do_not_matter(seed: u64) {
        let blank = map(0.25, [40.0, 20.0, 8.0]);
        let (near, far) = (blank.center([3, 3, 3]), blank.center([35, 15, 6]));
        let mut numbers = Numbers(seed);
        let mut ends = |low: i32| -> Vec<[f32; 3]> {
            (0..9)
                .map(|_| {
                    let cell = [0, 1, 2].map(|a| low.min(31 / (a + 1)) + numbers.below(4) as i32);
                    blank.center(cell).map(|v| v as f32)
                })
                .collect()
        };
        let (here, there) = (ends(0), ends(31));
        let own = |between: usize| -> Vec<State> {
            let mut map = blank.clone();
            for _ in 0..2 {
                map.insert(&Scan { origin: near, hits: &here, ..Scan::default() }).unwrap();
                for _ in 0..between {
                    map.insert(&Scan { origin: far, hits: &there, ..Scan::default() }).unwrap();
                }
            }
            cells(&map).filter(|c| c[0] < 8).map(|c| map.state(c)).collect()
        };
        let once = own(1);
        for between in [255, 256, 300] {
            prop_assert_eq!(&own(between), &once);
        }
    }

    /// Maps that are filled side by side in two threads hold the same, byte for byte, as those filled one after the other.
    #[test]
    fn threads_do_not_matter(seed: u64) {
        let fill = move |seed: u64| {
            let mut map = map(0.25, [40.0, 20.0, 8.0]);
            for k in 0..4 {
                let origin = Numbers(seed ^ k).point(&map);
                let hits = points(seed ^ (k + 9), &map, 300);
                map.insert(&Scan { origin, hits: &hits, ..Scan::default() }).unwrap();
            }
            let field = Esdf::new(&map, EsdfParams::default()).unwrap();
            let distances: Vec<u64> = cells(&map).map(|c| field.cell_distance(c).to_bits()).collect();
            (map.save(), distances)
        };
        let alone = [fill(seed), fill(!seed)];
        let side_by_side = std::thread::scope(|scope| {
            [seed, !seed].map(|s| scope.spawn(move || fill(s))).map(|t| t.join().unwrap())
        });
        prop_assert_eq!(alone, side_by_side);
    }

    /// The same scan again and again saturates: nothing changes from some point on, and 300 scans are as good as 30.
    #[test]
    fn repeated_scans_saturate(seed: u64) {
        let mut map = map(0.25, [20.0, 10.0, 5.0]);
        let origin = map.center([3, 4, 2]);
        let hits = points(seed, &map, 50);
        let scan = Scan { origin, hits: &hits, ..Scan::default() };
        for _ in 0..30 {
            map.insert(&scan).unwrap();
        }
        let before = states(&map);
        map.take_changes();
        for _ in 0..270 {
            map.insert(&scan).unwrap();
        }
        prop_assert!(map.take_changes().is_empty());
        prop_assert_eq!(before, states(&map));
    }

    /// Changes are exactly the cells that differ, each once, and the boxes hold them and are disjoint.
    #[test]
    fn changes_are_what_changed(seed: u64, n in 0usize..60) {
        let mut map = random_map(seed, [75.0, 20.0, 9.0], 0.6, 0.1);
        map.take_changes();
        let before = map.clone();
        let mut numbers = Numbers(seed ^ 7);
        for _ in 0..n {
            let cell = numbers.cell(&map);
            let state = [State::Free, State::Occupied][numbers.below(2)];
            map.set_state(cell, state);
        }
        let camera = Camera {
            rotation: [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
            translation: map.center([2, 10, 4]),
            tan_half_h: 0.8,
            tan_half_v: 0.8,
        };
        map.mark_inspected(&camera, 5.0);
        let changes = map.take_changes();
        let listed: Vec<Cell> = changes.cells().collect();
        let mut sorted = listed.clone();
        sorted.sort_by_key(|c| [c[2], c[1], c[0]]);
        sorted.dedup();
        prop_assert_eq!(&sorted, &listed);
        for cell in cells(&map) {
            let differs = before.state(cell) != map.state(cell);
            let holds = |boxes: &[voxmap::CellBox]| boxes.iter().filter(|b| b.contains(cell)).count();
            if differs {
                prop_assert_eq!(holds(&changes.state_boxes), 1);
            }
            prop_assert!(holds(&changes.boxes) <= 1);
            prop_assert!(holds(&changes.state_boxes) <= 1);
        }
        for cell in &listed {
            prop_assert!(changes.boxes.iter().any(|b| b.contains(*cell)));
        }
        prop_assert!(map.take_changes().is_empty());
    }

    /// Distances change no faster than the way; with trilinear values, by at most sqrt(3) times it.
    #[test]
    fn distances_are_lipschitz(seed: u64) {
        let map = random_map(seed, [25.0, 15.0, 8.0], 0.98, 0.02);
        let field = Esdf::new(&map, EsdfParams::default()).unwrap();
        let h = map.cell_size();
        for cell in cells(&map) {
            for a in 0..3 {
                let mut beside = cell;
                beside[a] += 1;
                let step = field.cell_distance(cell) - field.cell_distance(beside);
                prop_assert!(step.abs() <= h * 1.000_01);
            }
        }
        let mut numbers = Numbers(seed);
        let (p, q) = (numbers.point(&map), numbers.point(&map));
        let way = (0..3).map(|a| (p[a] - q[a]).powi(2)).sum::<f64>().sqrt();
        prop_assert!((field.distance(p) - field.distance(q)).abs() <= way * 3f64.sqrt() + 1e-5);
    }

    /// A cell is free, occupied or unknown, and only occupied cells are inspected; the counts agree.
    #[test]
    fn states_exclude_each_other(seed: u64, n in 1usize..200) {
        let mut map = map(0.25, [70.0, 10.0, 5.0]);
        let camera = Camera {
            rotation: [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
            translation: map.center([2, 5, 2]),
            tan_half_h: 0.8,
            tan_half_v: 0.8,
        };
        for k in 0..4 {
            let hits = points(seed ^ k, &map, n);
            let origin = map.center([3, 4, 2]);
            map.insert(&Scan { origin, hits: &hits, ..Scan::default() }).unwrap();
            map.mark_inspected(&camera, 9.0);
        }
        let counts = map.counts();
        let count = |f: &dyn Fn(Cell) -> bool| cells(&map).filter(|&c| f(c)).count();
        prop_assert_eq!(counts.free, count(&|c| map.is_free(c)));
        prop_assert_eq!(counts.occupied, count(&|c| map.is_occupied(c)));
        prop_assert_eq!(counts.known, count(&|c| map.is_known(c)));
        prop_assert_eq!(counts.inspected, count(&|c| map.is_inspected(c)));
        prop_assert_eq!(counts.known, counts.free + counts.occupied);
        prop_assert_eq!(count(&|c| map.is_inspected(c) && !map.is_occupied(c)), 0);
    }
}
