//! Files: reference maps and answers, round trips, and every kind of damage.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stderr)]

mod common;

use common::{Numbers, cells, random_map};
use std::path::PathBuf;
use voxmap::io::{Error, OcTree};
use voxmap::{SensorModel, State, UnknownPolicy};

/// A file of the shared data, or `None` with a note when it is not there.
fn shared(name: &str) -> Option<Vec<u8>> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../shared/data")
        .join(name);
    let found = std::fs::read(&path).ok();
    if found.is_none() {
        eprintln!("SKIPPED: {} is not there", path.display());
    }
    found
}

fn numbers(line: &str) -> Vec<f64> {
    line.split(',')
        .map(|v| v.parse().unwrap_or(f64::NAN))
        .collect()
}

#[test]
fn building_079_gives_octomaps_own_answers() {
    let Some(bytes) = shared("scans/octomap/geb079.bt") else {
        return;
    };
    let tree = OcTree::read_bt(&bytes).unwrap();
    assert_eq!(tree.bounds(), ([-100, -94, -4], [387, 93, 35]));
    let map = tree.to_map(&SensorModel::default(), 1 << 24).unwrap();
    assert_eq!(
        (map.counts().occupied, map.counts().free),
        (185_673, 950_759)
    );
    let text = String::from_utf8(shared("scans/octomap/geb079_queries.csv").unwrap()).unwrap();
    for line in text.lines().skip(1) {
        let p = numbers(line);
        let wanted = match line.rsplit(',').next().unwrap() {
            "free" => State::Free,
            "occupied" => State::Occupied,
            _ => State::Unknown,
        };
        let point = [p[0], p[1], p[2]];
        assert_eq!(tree.state_at(point), wanted, "{line}");
        assert_eq!(map.state(map.cell_at(point)), wanted, "{line}");
    }
    let text = String::from_utf8(shared("scans/octomap/geb079_rays.csv").unwrap()).unwrap();
    for line in text.lines().skip(1) {
        let r = numbers(line);
        let hit = map.cast(
            [r[0], r[1], r[2]],
            [r[3], r[4], r[5]],
            r[6],
            UnknownPolicy::Pass,
        );
        assert_eq!(hit.occupied, r[7] == 1.0, "{line}");
        if hit.occupied {
            assert_eq!(hit.cell, map.cell_at([r[8], r[9], r[10]]), "{line}");
        }
    }
    // Written again it is the same file but for comments: same header numbers, same nodes.
    let again = tree.write_bt();
    let data = |bytes: &[u8]| {
        let at = bytes.windows(5).position(|w| w == b"data\n").unwrap();
        bytes[at..].to_vec()
    };
    assert_eq!(data(&again), data(&bytes));
    assert_eq!(OcTree::read_bt(&again).unwrap(), tree);
}

#[test]
fn trees_and_maps_round_trip() {
    for seed in 0..12 {
        let (free, occupied) = [(0.6, 0.2), (1.0, 0.0), (0.0, 0.02)][seed as usize % 3];
        let mut map = random_map(seed, [70.0, 20.0, 9.0], free, occupied);
        map.set_free_box([1.0, 1.5, 0.0], [6.0, 4.5, 2.0]);
        let tree = OcTree::from_map(&map).unwrap();
        assert_eq!(OcTree::read_ot(&tree.write_ot()).unwrap(), tree);
        for tree in [tree.clone(), OcTree::read_bt(&tree.write_bt()).unwrap()] {
            let back = tree.to_map(&SensorModel::default(), 1 << 24).unwrap();
            for cell in cells(&map) {
                let at = map.center(cell);
                assert_eq!(map.state(cell), tree.state_at(at));
                assert_eq!(map.state(cell), back.state(back.cell_at(at)));
            }
        }
    }
}

/// Few damaged bytes, or many: a typed error or a tree, never a panic.
fn mutate(bytes: &[u8], numbers: &mut Numbers) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for _ in 0..=numbers.below(8) {
        if out.is_empty() {
            break;
        }
        let at = numbers.below(out.len());
        match numbers.below(6) {
            0 => out.truncate(at),
            1 => out[at] ^= 1 << numbers.below(8),
            2 => out[at] = 0xff,
            3 => out.insert(at, numbers.below(256) as u8),
            4 => drop(out.remove(at)),
            // A piece again: counts and contents no longer agree.
            _ => {
                let piece = out[at..(at + 40).min(out.len())].to_vec();
                out.splice(at..at, piece);
            }
        }
    }
    out
}

#[test]
fn readers_survive_damage() {
    let map = random_map(3, [30.0, 12.0, 6.0], 0.6, 0.2);
    let tree = OcTree::from_map(&map).unwrap();
    let mut numbers = Numbers(77);
    for _ in 0..3000 {
        if let Ok(tree) = OcTree::read_bt(&mutate(&tree.write_bt(), &mut numbers)) {
            let _ = tree.to_map(&SensorModel::default(), 1 << 16);
        }
        if let Ok(tree) = OcTree::read_ot(&mutate(&tree.write_ot(), &mut numbers)) {
            let _ = tree.to_map(&SensorModel::default(), 1 << 16);
        }
    }
}

#[test]
fn octree_files_name_their_faults() {
    let whole = OcTree::from_map(&random_map(3, [9.0, 9.0, 6.0], 0.6, 0.2)).unwrap();
    let bytes = whole.write_bt();
    assert!(matches!(
        OcTree::read_bt(&bytes[..bytes.len() - 1]),
        Err(Error::Truncated { part: "a node", .. })
    ));
    let mut longer = bytes.clone();
    longer.push(0);
    assert!(matches!(
        OcTree::read_bt(&longer),
        Err(Error::Count { found: 1, .. })
    ));
    assert!(matches!(
        OcTree::read_ot(&bytes),
        Err(Error::Malformed {
            part: "first line",
            ..
        })
    ));
    assert!(matches!(
        OcTree::read_bt(b""),
        Err(Error::Truncated { offset: 0, .. })
    ));
    let text = |rest: &str| format!("# Octomap OcTree binary file\n{rest}").into_bytes();
    for (part, header) in [
        ("id", "size 1\nres 1\ndata\n"),
        ("id", "id Other\nsize 1\nres 1\ndata\n"),
        ("size", "id OcTree\nsize -1\nres 1\ndata\n"),
        ("res", "id OcTree\nsize 1\nres 0\ndata\n"),
        ("res", "id OcTree\nsize 1\nres nan\ndata\n"),
        ("header line", "id OcTree\nlength 1\nres 1\ndata\n"),
    ] {
        match OcTree::read_bt(&text(header)) {
            Err(Error::Malformed { part: found, .. }) => assert_eq!(found, part),
            other => panic!("{header}: {other:?}"),
        }
    }
    // Inner nodes without end are cut at the format's depth.
    let mut deep = text("id OcTree\nsize 99\nres 1\ndata\n");
    deep.extend([0xff; 64]);
    assert!(matches!(
        OcTree::read_bt(&deep),
        Err(Error::Malformed { part: "depth", .. })
    ));
}

#[test]
fn a_few_bytes_cannot_ask_for_a_map_of_2_to_the_48_cells() {
    let mut bytes = b"# Octomap OcTree file\nid OcTree\nsize 1\nres 0.1\ndata\n".to_vec();
    bytes.extend([0, 0, 128, 63, 0]);
    let tree = OcTree::read_ot(&bytes).unwrap();
    assert_eq!(tree.state_at([1.0, 2.0, 3.0]), State::Occupied);
    assert!(matches!(
        tree.to_map(&SensorModel::default(), 1 << 20),
        Err(Error::TooLarge { .. })
    ));
    // Neither can the writer lose it.
    assert_eq!(OcTree::read_ot(&tree.write_ot()).unwrap(), tree);
    let split = OcTree::read_bt(&tree.write_bt()).unwrap();
    assert_eq!(split.leaves().len(), 8);
    assert_eq!(split.state_at([-1.0, 2.0, -3.0]), State::Occupied);
    assert_eq!(split.state_at([1.0, 4000.0, 3.0]), State::Unknown);
}

#[test]
fn maps_off_the_grid_are_refused() {
    let map = voxmap::VoxelMap::new(&voxmap::Config {
        cell_size: 0.3,
        low: [0.1, 0.0, 0.0],
        high: [1.0; 3],
        sensor: SensorModel::default(),
    })
    .unwrap();
    assert!(matches!(
        OcTree::from_map(&map),
        Err(Error::Unaligned { .. })
    ));
}
