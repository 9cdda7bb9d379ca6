//! Regions: laws on random floor plans, and rooms that a person would name.
#![allow(missing_docs, clippy::unwrap_used)]

use proptest::prelude::*;
use std::collections::BTreeSet;
use voxmap::{
    Config, CostMap, CostMapParams, Error, Ground, RegionParams, Regions, SensorModel, State,
    VoxelMap,
};

const H: f64 = 0.25;

/// A plan of free rectangles (cells) in unknown space.
fn plan(size: [i32; 2], rooms: &[[i32; 4]]) -> CostMap {
    let high = [f64::from(size[0]) * H, f64::from(size[1]) * H, 3.0 * H];
    let mut map = VoxelMap::new(&Config {
        cell_size: H,
        low: [0.0; 3],
        high,
        sensor: SensorModel::default(),
    })
    .unwrap();
    for &[x0, y0, x1, y1] in rooms {
        for z in 0..3 {
            for y in y0..y1 {
                for x in x0..x1 {
                    map.set_state([x, y, z], State::Free);
                }
            }
        }
    }
    CostMap::project(&map, &CostMapParams::default()).unwrap()
}

fn labelled(regions: &Regions, grid: &CostMap) -> Vec<([i32; 2], u32)> {
    let [nx, ny] = grid.size().map(|n| n as i32);
    (0..ny)
        .flat_map(|y| (0..nx).map(move |x| [x, y]))
        .filter_map(|c| regions.label(c).map(|l| (c, l)))
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) })]

    /// Labels stand on free ground (or specks closed over), every region is connected, has its centre inside and its area
    /// right; the same plan gives the same labels.
    #[test]
    fn regions_partition_the_free_ground(
        rooms in prop::collection::vec((0..60i32, 0..40i32, 4..30i32, 4..20i32), 1..6),
    ) {
        let rooms: Vec<[i32; 4]> =
            rooms.iter().map(|&(x, y, w, h)| [x, y, (x + w).min(70), (y + h).min(50)]).collect();
        let grid = plan([70, 50], &rooms);
        let regions = Regions::segment(&grid, &RegionParams::default()).unwrap();
        let cells = labelled(&regions, &grid);
        for &(c, _) in &cells {
            let near_free = (-1..=1).any(|dx| (-1..=1).any(|dy| grid.ground([c[0] + dx, c[1] + dy]) == Ground::Free));
            prop_assert!(near_free);
        }
        for &id in regions.ids() {
            let mine: BTreeSet<[i32; 2]> = cells.iter().filter(|c| c.1 == id).map(|c| c.0).collect();
            let area = regions.area(id).unwrap();
            prop_assert!((area - mine.len() as f64 * H * H).abs() < 1e-9);
            prop_assert_eq!(regions.label(grid.cell_at(regions.center(id).unwrap())), Some(id));
            // Connected over cell sides.
            let mut open = vec![*mine.iter().next().unwrap()];
            let mut seen: BTreeSet<[i32; 2]> = open.iter().copied().collect();
            while let Some([x, y]) = open.pop() {
                for n in [[x - 1, y], [x + 1, y], [x, y - 1], [x, y + 1]] {
                    if mine.contains(&n) && seen.insert(n) {
                        open.push(n);
                    }
                }
            }
            prop_assert_eq!(seen.len(), mine.len());
        }
        prop_assert_eq!(&Regions::segment(&grid, &RegionParams::default()).unwrap(), &regions);
    }
}

#[test]
fn a_convex_room_is_one_region() {
    let grid = plan([60, 40], &[[5, 5, 50, 30]]);
    assert_eq!(
        Regions::segment(&grid, &RegionParams::default())
            .unwrap()
            .count(),
        1
    );
}

#[test]
fn rooms_behind_doors_are_regions_of_their_own() {
    // Two rooms of 10 m x 6 m side by side, a door of 1 m between, a corridor below with doors to both.
    let rooms = [
        [0, 20, 40, 44],
        [42, 20, 82, 44],
        [40, 30, 42, 34],
        [0, 6, 82, 14],
        [16, 14, 20, 20],
        [60, 14, 64, 20],
    ];
    let grid = plan([90, 50], &rooms);
    let regions = Regions::segment(&grid, &RegionParams::default()).unwrap();
    let at = |x: f64, y: f64| regions.nearest_label([x, y]).unwrap();
    let (left, right, corridor) = (at(5.0, 8.0), at(15.5, 8.0), at(10.0, 2.5));
    assert!(left != right && left != corridor && right != corridor);
    assert!(
        regions
            .adjacency()
            .contains(&(left.min(right), left.max(right)))
    );
}

#[test]
fn labels_carry_over_by_overlap() {
    let before = plan([90, 50], &[[42, 20, 82, 44]]);
    let after = plan(
        [90, 50],
        &[[0, 17, 40, 47], [42, 17, 82, 47], [40, 31, 42, 33]],
    );
    let first = Regions::segment(&before, &RegionParams::default()).unwrap();
    let mut second = Regions::segment(&after, &RegionParams::default()).unwrap();
    second.carry_labels(&first);
    let room = [15.5, 8.0];
    assert_eq!(second.nearest_label(room), first.nearest_label(room));
    assert_ne!(second.nearest_label([5.0, 8.0]), first.nearest_label(room));
}

#[test]
fn empty_maps_and_bad_parameters() {
    let grid = plan([10, 10], &[]);
    let regions = Regions::segment(&grid, &RegionParams::default()).unwrap();
    assert_eq!(
        (regions.count(), regions.nearest_label([1.0, 1.0])),
        (0, None)
    );
    let bad = RegionParams {
        tau: f64::NAN,
        ..RegionParams::default()
    };
    assert!(matches!(
        Regions::segment(&grid, &bad),
        Err(Error::Length { field: "tau", .. })
    ));
}

/// Labels survive the growth of the map that lies below, and an update without a change does nothing.
#[test]
fn labels_survive_growth() {
    let mut map = voxmap::VoxelMap::growing(0.1, &voxmap::SensorModel::default(), 1 << 24).unwrap();
    let floor = |map: &mut voxmap::VoxelMap, low: [f64; 2], high: [f64; 2]| {
        let cell = |p: [f64; 2], z: f64| map.cell_at([p[0], p[1], z]);
        let cells = voxmap::CellBox {
            low: cell(low, 0.0),
            high: cell(high, 0.7),
        };
        map.grow(cells).unwrap();
        map.set_free_box([low[0], low[1], 0.0], [high[0], high[1], 0.7]);
    };
    floor(&mut map, [0.0, 0.0], [4.0, 4.0]);
    let mut grid = CostMap::project(&map, &CostMapParams::default()).unwrap();
    let params = RegionParams::default();
    let mut regions = Regions::segment(&grid, &params).unwrap();
    let id = regions.nearest_label([2.0, 2.0]).unwrap();
    assert_eq!(regions.update(&grid, &params), Ok(false));
    // A second room, far enough away for the map to grow on the low side.
    map.take_changes();
    floor(&mut map, [-20.0, 0.0], [-14.0, 5.0]);
    let changes = map.take_changes();
    grid.update(&map, &changes.state_boxes);
    assert_eq!(regions.update(&grid, &params), Ok(true));
    assert_eq!(regions.count(), 2);
    assert_eq!(regions.nearest_label([2.0, 2.0]), Some(id));
    let other = regions.nearest_label([-17.0, 2.0]).unwrap();
    assert_ne!(other, id);
}
