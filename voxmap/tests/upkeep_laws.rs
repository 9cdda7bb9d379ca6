//! What follows a map's changes equals what is made anew: over every kind of map, both frontier conventions, one and two threads.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::{Numbers, random_map};
use frontier::{Fringe, Frontiers, Kind, Params, Side, Split, exploration_on, inspection};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::sync::mpsc;
use voxmap::{
    Camera, Cell, CellBox, CostMap, CostMapParams, Esdf, EsdfParams, GrazingGuard, RegionParams,
    Regions, Scan, SensorModel, VoxelMap,
};

const MOST: usize = 1 << 23;

/// A bounded map, a growing one, one loaded from a file, a copy of a snapshot, a cropped one.
fn kinds(seed: u64) -> [VoxelMap; 5] {
    let bounded = random_map(seed, [70.0, 18.0, 9.0], 0.4, 0.2);
    let mut growing = VoxelMap::growing(0.25, &SensorModel::fuel(), MOST).unwrap();
    growing
        .insert(&scan(seed, &[[1.0, 2.0, 0.5], [3.0, -2.0, 1.0]]))
        .unwrap();
    let loaded = VoxelMap::load(&bounded.save(), MOST).unwrap();
    let copied = (*growing.snapshot()).clone();
    let mut cropped = growing.clone();
    let low = cropped.bounds().low;
    let high = [low[0] + 64, low[1] + 8, low[2] + 8];
    cropped.crop(CellBox { low, high }).unwrap();
    [bounded, growing, loaded, copied, cropped]
}

fn scan(seed: u64, hits: &[[f32; 3]]) -> Scan<'_> {
    let mut numbers = Numbers(seed);
    Scan {
        origin: [0; 3].map(|_| numbers.next()),
        hits,
        max_range: 5.0,
        grazing_guard: [
            None,
            Some(GrazingGuard::default()),
            Some(GrazingGuard::thorough()),
        ][numbers.below(3)],
        ..Scan::default()
    }
}

/// One change of some kind.
fn edit(map: &mut VoxelMap, numbers: &mut Numbers) {
    let corner = numbers.point(map);
    let beyond = corner.map(|v| v + 2.0 * numbers.next());
    let middle = map.center(map.cell_at(corner));
    match numbers.below(6) {
        0 => map.reset_box(corner, beyond),
        1 => map.decay_box(corner, beyond, 0.5),
        2 => map.set_free_box(corner, beyond),
        3 => drop(map.mark_inspected(
            &Camera {
                rotation: [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
                translation: middle,
                tan_half_h: 0.8,
                tan_half_v: 0.8,
            },
            5.0,
        )),
        _ => {
            let hits: Vec<[f32; 3]> = (0..60)
                .map(|_| [0, 1, 2].map(|a| (middle[a] + 6.0 * (numbers.next() - 0.5)) as f32))
                .collect();
            map.insert(&Scan {
                origin: middle,
                ..scan(numbers.0, &hits)
            })
            .unwrap();
        }
    }
}

fn members(frontiers: &Frontiers, kind: Kind) -> BTreeSet<Cell> {
    let mut all = BTreeSet::new();
    for cluster in frontiers.clusters().filter(|c| c.kind == kind) {
        assert!(
            cluster.cells.iter().all(|&cell| all.insert(cell)),
            "a cell twice"
        );
    }
    all
}

/// Everything that follows a map.
struct Layers {
    frontiers: Vec<(Side, Frontiers)>,
    field: Esdf,
    ground: CostMap,
    regions: Regions,
}

fn esdf() -> EsdfParams {
    EsdfParams {
        truncation: 1.0,
        unknown_is_occupied: true,
    }
}

impl Layers {
    fn new(map: &VoxelMap) -> Self {
        let frontiers = [
            (Side::Free, Split::KMeans),
            (Side::Free, Split::PrincipalAxis),
            (Side::Unknown, Split::KMeans),
            (Side::Unknown, Split::PrincipalAxis),
        ]
        .map(|(exploration_side, exploration_split)| {
            let params = Params {
                exploration_side,
                exploration_split,
                ..Params::default()
            };
            (exploration_side, Frontiers::new(params).unwrap())
        });
        let ground = CostMap::project(map, &CostMapParams::default()).unwrap();
        let regions = Regions::segment(&ground, &RegionParams::default()).unwrap();
        let field = Esdf::new(map, esdf()).unwrap();
        let mut layers = Self {
            frontiers: frontiers.into(),
            field,
            ground,
            regions,
        };
        for (_, frontiers) in &mut layers.frontiers {
            frontiers.update(map, &[]);
        }
        layers
    }

    fn update(&mut self, map: &mut VoxelMap) {
        let changes = map.take_changes();
        let boxes: Vec<_> = changes.boxes.iter().map(|b| (b.low, b.high)).collect();
        for (_, frontiers) in &mut self.frontiers {
            frontiers.update(&*map, &boxes);
        }
        self.field.update(map, &changes);
        self.ground.update(map, &changes.state_boxes);
        self.regions
            .update(&self.ground, &RegionParams::default())
            .unwrap();
    }

    /// Everything that can be asked of them, to compare.
    fn answers(&self, map: &VoxelMap) -> Vec<u64> {
        let mut out = Vec::new();
        for (_, frontiers) in &self.frontiers {
            for c in frontiers.clusters() {
                out.extend([c.id, c.cells.len() as u64]);
                out.extend(c.centroid.iter().chain(&c.normal).map(|v| v.to_bits()));
            }
        }
        let b = map.bounds();
        for cell in (b.low[0]..b.high[0]).flat_map(|x| (b.low[1]..b.high[1]).map(move |y| [x, y])) {
            let at = map.center([cell[0], cell[1], b.low[2]]);
            let at = [at[0], at[1]];
            out.push(
                self.field
                    .cell_distance([cell[0], cell[1], b.low[2] + 2])
                    .to_bits(),
            );
            out.push(self.ground.clearance(at).to_bits());
            out.push(self.regions.nearest_label(at).map_or(0, u64::from));
        }
        out
    }
}

/// A map after some changes, and its layers, kept up to date all along.
fn lived(mut map: VoxelMap, seed: u64) -> (Vec<u8>, Vec<u64>) {
    let mut layers = Layers::new(&map);
    let mut numbers = Numbers(seed);
    for _ in 0..4 {
        edit(&mut map, &mut numbers);
        layers.update(&mut map);
    }
    (map.save(), layers.answers(&map))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    /// Cells of clusters on both sides, fringe, distances and clearances, after any change of any kind of map.
    #[test]
    fn layers_that_follow_equal_new_ones(seed: u64) {
        for (kind, mut map) in kinds(seed).into_iter().enumerate() {
            map.take_changes();
            let mut layers = Layers::new(&map);
            let mut fringe = Fringe::new(&map);
            let mut numbers = Numbers(seed ^ kind as u64);
            for _ in 0..4 {
                let bounds = map.bounds();
                edit(&mut map, &mut numbers);
                if map.bounds() == bounds {
                    let listed = map.clone().take_changes();
                    fringe.update(&map, listed.cells());
                } else {
                    fringe = Fringe::new(&map);
                }
                layers.update(&mut map);
                prop_assert_eq!(&fringe, &Fringe::new(&map), "kind {}", kind);
                let surface: BTreeSet<Cell> = inspection(&map, (i32::MIN, i32::MAX)).into_iter().collect();
                for (side, frontiers) in &layers.frontiers {
                    let edge: BTreeSet<Cell> = exploration_on(&map, *side).into_iter().collect();
                    prop_assert_eq!(&members(frontiers, Kind::Exploration), &edge, "kind {}", kind);
                    prop_assert_eq!(&members(frontiers, Kind::Inspection), &surface, "kind {}", kind);
                }
                let field = Esdf::new(&map, esdf()).unwrap();
                let ground = CostMap::project(&map, &CostMapParams::default()).unwrap();
                let b = map.bounds();
                for _ in 0..300 {
                    let cell = [0, 1, 2].map(|a| b.low[a] + numbers.below(map.size()[a]) as i32);
                    let at = map.center(cell);
                    prop_assert_eq!(layers.field.cell_distance(cell), field.cell_distance(cell));
                    prop_assert_eq!(layers.ground.clearance([at[0], at[1]]), ground.clearance([at[0], at[1]]));
                }
            }
        }
    }

    /// The word methods agree with the single-cell ones for every kind of map, and for a snapshot.
    #[test]
    fn every_kind_of_map_keeps_the_frontier_laws(seed: u64) {
        for map in kinds(seed) {
            frontier::conformance::check(&map);
            frontier::conformance::check(&*map.snapshot());
        }
    }

    /// Two threads, each with a map and its layers, answer as one after the other.
    #[test]
    fn two_threads_answer_as_one(seed: u64) {
        for map in kinds(seed) {
            let alone = [seed, !seed].map(|s| lived(map.clone(), s));
            let side_by_side = std::thread::scope(|scope| {
                let map = &map;
                [seed, !seed].map(|s| scope.spawn(move || lived(map.clone(), s))).map(|t| t.join().unwrap())
            });
            prop_assert_eq!(alone, side_by_side);
        }
    }

    /// A planner in a thread of its own reads snapshots while the map goes on, and sees each as it was.
    #[test]
    fn planners_read_while_the_map_is_written(seed: u64) {
        for mut map in kinds(seed) {
            let (send, receive) = mpsc::channel();
            let planner = std::thread::spawn(move || {
                receive.into_iter().map(|snapshot: voxmap::Snapshot| snapshot.save()).collect::<Vec<_>>()
            });
            let mut numbers = Numbers(seed);
            let mut then = Vec::new();
            for _ in 0..4 {
                edit(&mut map, &mut numbers);
                send.send(map.snapshot()).unwrap();
                then.push(map.save());
            }
            drop(send);
            prop_assert_eq!(planner.join().unwrap(), then);
        }
    }
}
