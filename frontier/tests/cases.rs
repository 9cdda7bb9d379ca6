//! One named case for each thing that goes wrong.
#![allow(missing_docs, clippy::unwrap_used)]

use frontier::grid::{Grid, State};
use frontier::{Error, Frontiers, Kind, Params, Side};

#[test]
fn an_unknown_map_has_no_frontier() {
    let mut frontiers = Frontiers::new(Params::default()).unwrap();
    let update = frontiers.update(&Grid::new([5, 5, 5]), &[]);
    assert!(update.added.is_empty());
    assert_eq!(frontiers.is_frontier([1, 1, 1]), None);
}

#[test]
fn bad_parameters_are_named() {
    let bad = Params {
        exploration_size: 0.0,
        ..Params::default()
    };
    assert_eq!(
        Frontiers::new(bad).err(),
        Some(Error::Param {
            field: "exploration_size",
            value: 0.0
        })
    );
    let bad = Params {
        inspection_band: (4, 4),
        ..Params::default()
    };
    assert_eq!(
        Frontiers::new(bad).err(),
        Some(Error::Band {
            field: "inspection_band",
            low: 4,
            high: 4
        })
    );
    let bad = Params {
        normal_angle: f64::NAN,
        ..Params::default()
    };
    assert!(matches!(
        Frontiers::new(bad).err(),
        Some(Error::Param {
            field: "normal_angle",
            ..
        })
    ));
    let bad = Params {
        shrink_share: 1.5,
        ..Params::default()
    };
    assert!(matches!(
        Frontiers::new(bad).err(),
        Some(Error::Share { .. })
    ));
}

#[test]
fn boxes_outside_the_map_are_harmless() {
    let mut frontiers = Frontiers::new(Params::default()).unwrap();
    let map = Grid::parse("..?\n..?");
    frontiers.update(&map, &[]);
    let update = frontiers.update(
        &map,
        &[
            ([-99, -99, -99], [i32::MAX; 3]),
            ([50, 50, 50], [60, 60, 60]),
        ],
    );
    assert!(update.added.is_empty() && update.removed.is_empty());
}

#[test]
fn the_map_edge_is_no_frontier() {
    assert!(frontier::exploration(&Grid::parse("...\n...")).is_empty());
}

#[test]
fn another_map_size_starts_over() {
    let mut frontiers = Frontiers::new(Params::default()).unwrap();
    let first = frontiers.update(&Grid::parse("..?"), &[]);
    let second = frontiers.update(&Grid::parse("..??"), &[]);
    assert_eq!(second.removed, first.added);
    assert_eq!(frontiers.clusters().count(), 1);
}

#[test]
fn two_walls_of_a_corner_are_two_clusters() {
    // A room's corner: free inside, walls along x and along y.
    let map = Grid::parse("#######\n#......\n#......\n#......\n#......");
    let mut frontiers = Frontiers::new(Params::default()).unwrap();
    frontiers.update(&map, &[]);
    let normals: Vec<[f64; 3]> = frontiers
        .clusters()
        .filter(|c| c.kind == Kind::Inspection)
        .map(|c| c.normal)
        .collect();
    assert_eq!(normals.len(), 2);
    assert!(
        normals.contains(&[0.0, 1.0, 0.0]) && normals.contains(&[1.0, 0.0, 0.0]),
        "{normals:?}"
    );
}

/// The two sides look at each other: both normals point into unknown space.
#[test]
fn both_sides_look_into_the_unknown() {
    let map = Grid::parse("...???\n...???\n...???");
    for (side, x) in [(Side::Free, 2), (Side::Unknown, 3)] {
        let mut frontiers = Frontiers::new(Params {
            exploration_side: side,
            ..Params::default()
        })
        .unwrap();
        frontiers.update(&map, &[]);
        let cluster = frontiers.clusters().next().unwrap();
        assert_eq!(cluster.cells, [[x, 0, 0], [x, 1, 0], [x, 2, 0]]);
        assert_eq!(cluster.normal, [1.0, 0.0, 0.0]);
    }
}

/// FUEL drops what is below its minimum and never looks at it again; here it is kept, and joins when more is found.
#[test]
fn small_leftovers_are_kept_and_grow() {
    let mut map = Grid::parse("..?#########");
    let mut frontiers = Frontiers::new(Params::default()).unwrap();
    let update = frontiers.update(&map, &[]);
    let small = frontiers.get(update.added[0]).unwrap();
    assert!(small.small && small.cells.len() == 1);
    let mut wide = Grid::new([12, 20, 1]);
    for y in 0..20 {
        wide.set([0, y, 0], State::Free);
    }
    map = wide;
    frontiers.update(&map, &[]);
    assert!(
        frontiers
            .clusters()
            .filter(|c| c.kind == Kind::Exploration)
            .any(|c| !c.small)
    );
    assert_eq!(
        frontiers.clusters().map(|c| c.cells.len()).sum::<usize>(),
        20
    );
}

/// A new cell joins the cluster beside it, also across the border of two words and a row apart.
#[test]
fn clusters_join_across_words() {
    for (old, new) in [(63, 64), (64, 63), (62, 63), (64, 65)] {
        for (dy, dz) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dz| (dy, dz))) {
            let mut map = Grid::new([70, 5, 5]);
            map.set([old, 2, 2], State::Free);
            let mut frontiers = Frontiers::new(Params::default()).unwrap();
            let first = frontiers.update(&map, &[]);
            let cell = [new, 2 + dy, 2 + dz];
            map.set(cell, State::Free);
            let update = frontiers.update(&map, &[(cell, cell.map(|v| v + 1))]);
            assert_eq!(update.removed, first.added, "{old} {cell:?}");
            assert_eq!(frontiers.clusters().count(), 1, "{old} {cell:?}");
        }
    }
}
