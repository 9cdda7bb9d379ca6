//! Properties that hold for any map.
#![allow(missing_docs, clippy::unwrap_used)]

use frontier::grid::{Grid, State};
use frontier::{
    Cell, Frontiers, Kind, Map, Params, Side, Split, conformance, exploration, exploration_on,
    inspection,
};
use proptest::prelude::*;
use std::collections::BTreeSet;

const SIZE: [i32; 3] = [70, 6, 5];

fn state() -> impl Strategy<Value = State> {
    prop_oneof![
        Just(State::Unknown),
        Just(State::Free),
        Just(State::Occupied),
        Just(State::Inspected)
    ]
}

/// Maps made of a few boxes of one state each.
fn maps() -> impl Strategy<Value = Grid> {
    prop::collection::vec(
        (
            0..70i32,
            0..6i32,
            0..5i32,
            1..30i32,
            1..6i32,
            1..5i32,
            state(),
        ),
        1..12,
    )
    .prop_map(|boxes| {
        let mut grid = Grid::new(SIZE);
        for (x, y, z, dx, dy, dz, state) in boxes {
            fill(&mut grid, [x, y, z], [x + dx, y + dy, z + dz], state);
        }
        grid
    })
}

/// Cubes of one state each, many beside the border of the first two words.
fn edits(many: std::ops::Range<usize>) -> impl Strategy<Value = Vec<(i32, i32, i32, i32, State)>> {
    let x = prop_oneof![0..70i32, 59..66i32];
    prop::collection::vec((x, 0..6i32, 0..5i32, 1..6i32, state()), many)
}

fn fill(grid: &mut Grid, low: Cell, high: Cell, state: State) {
    for z in low[2]..high[2] {
        for y in low[1]..high[1] {
            for x in low[0]..high[0] {
                grid.set([x, y, z], state);
            }
        }
    }
}

fn cells(frontiers: &Frontiers, kind: Kind) -> BTreeSet<Cell> {
    let mut all = BTreeSet::new();
    for cluster in frontiers.clusters().filter(|c| c.kind == kind) {
        for &cell in &cluster.cells {
            assert!(all.insert(cell), "{cell:?} is in two clusters");
        }
    }
    all
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn the_built_in_map_keeps_the_laws(map in maps()) {
        conformance::check(&map);
    }

    /// A fully known map has nothing left to explore, a fully inspected one nothing left to inspect.
    #[test]
    fn known_maps_have_no_frontier(rows in prop::collection::vec("[.+]{6}", 1..6)) {
        let map = Grid::parse(&rows.join("\n"));
        prop_assert!(exploration(&map).is_empty());
        prop_assert!(inspection(&map, (i32::MIN, i32::MAX)).is_empty());
    }

    /// After any edits the clusters hold exactly the cells of a search from scratch, each once, and clusters that no edit
    /// touched keep their ids and cells.
    #[test]
    fn updates_equal_a_search_from_scratch(
        start in maps(),
        edits in edits(1..8),
        unknown: bool,
        halves: bool,
    ) {
        let mut map = start;
        let exploration_side = if unknown { Side::Unknown } else { Side::Free };
        let exploration_split = if halves { Split::PrincipalAxis } else { Split::KMeans };
        let params = Params { min_exploration: 3, exploration_side, exploration_split, ..Params::default() };
        let mut frontiers = Frontiers::new(params).unwrap();
        frontiers.update(&map, &[]);
        for (x, y, z, d, state) in edits {
            let before: Vec<_> = frontiers.clusters().cloned().collect();
            let (low, high) = ([x, y, z], [x + d, y + d, z + d]);
            fill(&mut map, low, high, state);
            let update = frontiers.update(&map, &[(low, high)]);
            let explore: BTreeSet<Cell> = exploration_on(&map, exploration_side).into_iter().collect();
            let inspect: BTreeSet<Cell> = inspection(&map, (i32::MIN, i32::MAX)).into_iter().collect();
            prop_assert_eq!(&cells(&frontiers, Kind::Exploration), &explore);
            prop_assert_eq!(&cells(&frontiers, Kind::Inspection), &inspect);
            for cell in &explore {
                prop_assert_eq!(frontiers.is_frontier(*cell), Some(Kind::Exploration));
            }
            for old in before {
                let untouched = !update.removed.contains(&old.id) && !update.changed.contains(&old.id);
                if untouched {
                    prop_assert_eq!(&frontiers.get(old.id).unwrap().cells, &old.cells);
                }
            }
            for id in update.added.iter().chain(&update.changed) {
                prop_assert!(frontiers.get(*id).is_some());
            }
        }
    }

    /// Without limits, and nothing allowed to shrink in place, exploration clusters are the 26-connected sets, after any edits.
    #[test]
    fn unlimited_clusters_are_the_connected_sets(
        start in maps(),
        edits in edits(0..6),
        unknown: bool,
        halves: bool,
    ) {
        let exploration_side = if unknown { Side::Unknown } else { Side::Free };
        let exploration_split = if halves { Split::PrincipalAxis } else { Split::KMeans };
        let params = Params {
            exploration_side,
            exploration_split,
            exploration_size: 1e9,
            exploration_extent: 1e9,
            shrink_share: 0.0,
            ..Params::default()
        };
        let mut map = start;
        let mut frontiers = Frontiers::new(params).unwrap();
        frontiers.update(&map, &[]);
        for (x, y, z, d, state) in edits {
            let (low, high) = ([x, y, z], [x + d, y + d, z + d]);
            fill(&mut map, low, high, state);
            frontiers.update(&map, &[(low, high)]);
        }
        let mut left: BTreeSet<Cell> = exploration_on(&map, exploration_side).into_iter().collect();
        let mut sets = BTreeSet::new();
        while let Some(first) = left.pop_first() {
            let mut set = vec![first];
            let mut next = 0;
            while next < set.len() {
                let [x, y, z] = set[next];
                next += 1;
                for i in 0..27 {
                    let beside = [x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1];
                    if left.remove(&beside) {
                        set.push(beside);
                    }
                }
            }
            set.sort_unstable();
            sets.insert(set);
        }
        let found = frontiers.clusters().filter(|c| c.kind == Kind::Exploration);
        prop_assert_eq!(found.map(|c| c.cells.clone()).collect::<BTreeSet<_>>(), sets);
    }

    /// Small clusters are marked, not lost; inspection clusters stay within their radius; the centroid is their mean.
    #[test]
    fn clusters_keep_their_limits(map in maps()) {
        let params = Params { inspection_radius: 4.0, ..Params::default() };
        let mut frontiers = Frontiers::new(params.clone()).unwrap();
        frontiers.update(&map, &[]);
        for c in frontiers.clusters() {
            let least = if c.kind == Kind::Exploration { params.min_exploration } else { params.min_inspection };
            prop_assert_eq!(c.small, c.cells.len() < least);
            let n = c.cells.len() as f64;
            for a in 0..3 {
                let mean = c.cells.iter().map(|p| f64::from(p[a]) + 0.5).sum::<f64>() / n;
                prop_assert!((mean - c.centroid[a]).abs() < 1e-9);
            }
            if c.kind == Kind::Inspection && c.cells.len() > 1 {
                for p in &c.cells {
                    let far: f64 = (0..3).map(|a| (f64::from(p[a]) + 0.5 - c.centroid[a]).powi(2)).sum();
                    prop_assert!(far.sqrt() <= 4.0 + 1e-9);
                }
            }
        }
    }

    /// Normals and boxes are those of the cells, by definition, on both sides.
    #[test]
    fn clusters_know_their_normal_and_box(map in maps(), unknown: bool) {
        let exploration_side = if unknown { Side::Unknown } else { Side::Free };
        let mut frontiers = Frontiers::new(Params { exploration_side, ..Params::default() }).unwrap();
        frontiers.update(&map, &[]);
        for c in frontiers.clusters() {
            let mut sum = [0.0; 3];
            for &cell in &c.cells {
                let mut towards = [0.0f64; 3];
                for (axis, step) in [(0, -1), (0, 1), (1, -1), (1, 1), (2, -1), (2, 1)] {
                    let mut n = cell;
                    n[axis] += step;
                    let (free, known) = (map.is_free(n), map.is_free(n) || map.is_occupied(n));
                    towards[axis] += f64::from(step) * match (c.kind, exploration_side) {
                        (Kind::Inspection, _) => f64::from(u8::from(free)),
                        (Kind::Exploration, Side::Free) => f64::from(u8::from(!known)),
                        (Kind::Exploration, Side::Unknown) => -f64::from(u8::from(free)),
                    };
                }
                let norm = towards.iter().map(|v| v * v).sum::<f64>().sqrt().max(1.0);
                for a in 0..3 {
                    sum[a] += towards[a] / norm;
                }
            }
            let norm = sum.iter().map(|v| v * v).sum::<f64>().sqrt();
            for a in 0..3 {
                let is = if norm > 1e-9 { sum[a] / norm } else { 0.0 };
                // Sums that nearly cancel have no direction to speak of.
                prop_assert!((is - c.normal[a]).abs() < 1e-9 || norm < 1e-6, "{:?}", c);
                prop_assert_eq!(c.low[a], c.cells.iter().map(|p| p[a]).min().unwrap());
                prop_assert_eq!(c.high[a], c.cells.iter().map(|p| p[a]).max().unwrap());
            }
            prop_assert!(c.cells.is_sorted());
        }
    }

    /// Halved exploration clusters stay within half the wanted extent of their centroid, on either side.
    #[test]
    fn halved_clusters_are_short(map in maps(), unknown: bool) {
        let params = Params {
            exploration_side: if unknown { Side::Unknown } else { Side::Free },
            exploration_split: Split::PrincipalAxis,
            exploration_extent: 8.0,
            ..Params::default()
        };
        let mut frontiers = Frontiers::new(params).unwrap();
        frontiers.update(&map, &[]);
        for c in frontiers.clusters().filter(|c| c.kind == Kind::Exploration && c.cells.len() > 1) {
            for p in &c.cells {
                let far: f64 = (0..3).map(|a| (f64::from(p[a]) + 0.5 - c.centroid[a]).powi(2)).sum();
                prop_assert!(far.sqrt() <= 4.0 + 1e-9);
            }
        }
    }

    /// The same map gives the same clusters.
    #[test]
    fn clustering_is_deterministic(map in maps()) {
        let run = || {
            let mut frontiers = Frontiers::new(Params::default()).unwrap();
            frontiers.update(&map, &[]);
            frontiers.clusters().cloned().collect::<Vec<_>>()
        };
        prop_assert_eq!(run(), run());
    }
}
