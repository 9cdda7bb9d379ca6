//! Files: reference maps and answers, round trips, and every kind of damage.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stderr)]

mod common;

use common::{Numbers, cells, random_map};
use std::path::PathBuf;
use voxmap::io::{
    Cloud, Error, GridInfo, OcTree, Pgm, read_pcd, read_pgm, read_ply, write_pcd, write_pgm,
    write_ply,
};
use voxmap::{CostMap, Ground, SensorModel, State, UnknownPolicy, VoxelMap};

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

/// Every file format at least once: a good file each.
fn good_files() -> Vec<(&'static str, Vec<u8>)> {
    let map = random_map(3, [30.0, 12.0, 6.0], 0.6, 0.2);
    let tree = OcTree::from_map(&map).unwrap();
    let cloud = cloud();
    let ascii_ply = "ply\nformat ascii 1.0\nelement odd 1\nproperty list uchar int v\nelement vertex 2\nproperty double z\n\
                     property float x\nproperty float y\nend_header\n2 7 8\n3 1 2\n6 4 5\n";
    let big_ply = [
        &b"ply\nformat binary_big_endian 1.0\nelement odd 1\nproperty list uchar short v\nelement vertex 1\nproperty uchar a\n\
           property float x\nproperty double y\nproperty short z\nend_header\n"[..],
        &[2, 0, 1, 0, 2, 9],
        &1.5f32.to_be_bytes(),
        &(-2.5f64).to_be_bytes(),
        &(-3i16).to_be_bytes(),
    ]
    .concat();
    let ascii_pcd = "# .PCD v0.7\nVERSION 0.7\nFIELDS a x y z\nSIZE 4 4 4 4\nTYPE U F F F\nCOUNT 2 1 1 1\nWIDTH 2\nHEIGHT 1\n\
                     VIEWPOINT 1 2 3 1 0 0 0\nPOINTS 2\nDATA ascii\n9 9 1 2 3\n9 9 4 5 nan";
    // x, y, z of three equal points: a literal run of 12, then copies.
    let mut packed =
        b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 3\nDATA binary_compressed\n".to_vec();
    let mut lzf = Vec::new();
    for v in [1.0f32, 2.0, 3.0] {
        lzf.push(3);
        lzf.extend(v.to_le_bytes());
        lzf.extend([6 << 5, 3]);
    }
    packed.extend((lzf.len() as u32).to_le_bytes());
    packed.extend(36u32.to_le_bytes());
    packed.extend(lzf);
    let (info, image) = GridInfo::of(&ground(), "map.pgm");
    vec![
        ("bt", tree.write_bt()),
        ("ot", tree.write_ot()),
        ("ply", write_ply(&cloud)),
        ("ply", ascii_ply.into()),
        ("ply", big_ply),
        ("pcd", write_pcd(&cloud)),
        ("pcd", ascii_pcd.into()),
        ("pcd", packed),
        ("pgm", write_pgm(&image)),
        ("pgm", b"P2 # text\n3 2\n15\n0 7 15\n15 7 0".to_vec()),
        ("yaml", info.write().into_bytes()),
        (
            "yaml",
            b"image: a.pgm\nresolution: 0.1\norigin:\n- 1\n- 2\n- 0\nnegate: 1\n".to_vec(),
        ),
        ("voxm", map.save()),
    ]
}

fn cloud() -> Cloud {
    let mut numbers = Numbers(5);
    let points = (0..50)
        .map(|_| [0; 3].map(|_| 9.0 * numbers.next() as f32 - 4.0))
        .collect();
    Cloud {
        position: [1.25, -2.5, 0.5],
        rotation: [0.5, 0.5, -0.5, 0.5],
        ..Cloud::new(points)
    }
}

fn ground() -> CostMap {
    let kinds = [Ground::Free, Ground::Unknown, Ground::Obstacle];
    let mut numbers = Numbers(6);
    let cells = (0..17 * 9).map(|_| kinds[numbers.below(3)]).collect();
    CostMap::from_ground(0.05, [-1.5, 2.0], [17, 9], cells).unwrap()
}

/// Reads bytes as a kind of file; the error's text if they are none.
fn read(kind: &str, bytes: &[u8]) -> Result<(), String> {
    let text = |e: Error| e.to_string();
    match kind {
        "bt" => drop(
            OcTree::read_bt(bytes)
                .and_then(|t| t.to_map(&SensorModel::default(), 1 << 16))
                .map_err(text)?,
        ),
        "ot" => drop(
            OcTree::read_ot(bytes)
                .and_then(|t| t.to_map(&SensorModel::default(), 1 << 16))
                .map_err(text)?,
        ),
        "ply" => drop(read_ply(bytes).map_err(text)?),
        "pcd" => drop(read_pcd(bytes).map_err(text)?),
        "pgm" => drop(read_pgm(bytes).map_err(text)?),
        "yaml" => drop(GridInfo::read(&String::from_utf8_lossy(bytes)).map_err(text)?),
        _ => drop(VoxelMap::load(bytes, 1 << 16).map_err(text)?),
    }
    Ok(())
}

#[test]
fn readers_survive_damage() {
    let mut numbers = Numbers(77);
    for (kind, bytes) in good_files() {
        read(kind, &bytes).unwrap();
        let (mut refused, mut read_all) = (0, 0);
        for _ in 0..600 {
            let mut damaged = mutate(&bytes, &mut numbers);
            if kind == "voxm" && numbers.below(2) == 0 && damaged.len() > 8 {
                // With a checksum that fits, so that what lies behind it is tested as well.
                damaged.truncate(damaged.len() - 8);
                let hash = damaged.iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, &b| {
                    (hash ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)
                });
                damaged.extend(hash.to_le_bytes());
            }
            match read(kind, &damaged) {
                Ok(()) => read_all += 1,
                Err(text) => {
                    assert!(!text.is_empty() && text.len() < 400, "{text}");
                    refused += 1;
                }
            }
        }
        assert!(
            refused > 50,
            "{kind}: {refused} of 600 refused, {read_all} read"
        );
        // Bytes of every other kind of file are refused, and so are none.
        for (other, foreign) in good_files() {
            if other != kind {
                assert!(read(kind, &foreign).is_err(), "{other} read as {kind}");
            }
        }
        assert!(read(kind, b"").is_err());
    }
}

#[test]
fn clouds_round_trip_in_every_encoding() {
    let cloud = cloud();
    assert_eq!(read_pcd(&write_pcd(&cloud)).unwrap(), cloud);
    assert_eq!(read_ply(&write_ply(&cloud)).unwrap().points, cloud.points);
    let files = good_files();
    let plys: Vec<Cloud> = files
        .iter()
        .filter(|f| f.0 == "ply")
        .map(|f| read_ply(&f.1).unwrap())
        .collect();
    assert_eq!(plys[1].points, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert_eq!(plys[2].points, [[1.5, -2.5, -3.0]]);
    let pcds: Vec<Cloud> = files
        .iter()
        .filter(|f| f.0 == "pcd")
        .map(|f| read_pcd(&f.1).unwrap())
        .collect();
    assert_eq!(pcds[1].points[0], [1.0, 2.0, 3.0]);
    assert!(pcds[1].points[1][2].is_nan());
    assert_eq!(pcds[1].position, [1.0, 2.0, 3.0]);
    assert_eq!(pcds[2].points, [[1.0, 2.0, 3.0]; 3]);
    for write in [write_pcd, write_ply] {
        let read = |bytes: Vec<u8>| read_pcd(&bytes).or_else(|_| read_ply(&bytes));
        assert_eq!(
            read(write(&Cloud::new(vec![]))).unwrap().points,
            [[0.0f32; 3]; 0]
        );
    }
}

#[test]
fn grids_round_trip() {
    let map = ground();
    let (info, image) = GridInfo::of(&map, "map.pgm");
    let info = GridInfo::read(&info.write()).unwrap();
    let back = info
        .cost_map(&read_pgm(&write_pgm(&image)).unwrap())
        .unwrap();
    assert_eq!(
        (back.size(), back.low(), back.cell_size()),
        (map.size(), map.low(), map.cell_size())
    );
    for y in 0..9 {
        for x in 0..17 {
            assert_eq!(back.ground([x, y]), map.ground([x, y]));
            let p = map.center([x, y]);
            assert_eq!(back.clearance(p), map.clearance(p));
        }
    }
    // Sixteen bits, and dark ground free.
    let wide = Pgm {
        width: 2,
        height: 1,
        white: 1000,
        pixels: vec![1000, 0],
    };
    assert_eq!(read_pgm(&write_pgm(&wide)).unwrap(), wide);
    let negated = GridInfo {
        negate: true,
        ..info.clone()
    }
    .cost_map(&wide)
    .unwrap();
    assert_eq!(
        (negated.ground([0, 0]), negated.ground([1, 0])),
        (Ground::Obstacle, Ground::Free)
    );
    let turned = GridInfo {
        origin: [0.0, 0.0, 0.1],
        ..info.clone()
    };
    assert!(matches!(
        turned.cost_map(&wide),
        Err(Error::Malformed {
            part: "yaw of the origin",
            ..
        })
    ));
    let short = Pgm {
        pixels: vec![0],
        ..wide.clone()
    };
    assert!(matches!(
        info.cost_map(&short),
        Err(Error::Malformed { part: "size", .. })
    ));
}

#[test]
fn nav2_maps_are_read() {
    for name in ["nav2_depot", "gen_office_1", "intel_lab", "race_extended"] {
        let Some(yaml) = shared(&format!("nav-maps/{name}.yaml")) else {
            return;
        };
        let info = GridInfo::read(&String::from_utf8(yaml).unwrap()).unwrap();
        let image = read_pgm(&shared(&format!("nav-maps/{}", info.image)).unwrap()).unwrap();
        let map = info.cost_map(&image).unwrap();
        assert_eq!(map.size(), [image.width, image.height]);
        // The shared maps hold 0, 205 and 254 only.
        let count = |v: u16| image.pixels.iter().filter(|&&p| p == v).count();
        assert_eq!(map.free_count(), count(254), "{name}");
        let [nx, ny] = map.size().map(|n| n as i32);
        let unknown = (0..ny).flat_map(|y| (0..nx).map(move |x| [x, y]));
        assert_eq!(
            unknown
                .filter(|&c| map.ground(c) == Ground::Unknown)
                .count(),
            count(205),
            "{name}"
        );
    }
}

#[test]
fn other_files_name_their_faults() {
    let fault = |kind: &str, bytes: &[u8]| read(kind, bytes).unwrap_err();
    for (kind, bytes, words) in [
        ("ply", &b"ply\nformat ascii 2.0\n"[..], "header line"),
        ("ply", b"ply\nformat binary_little_endian 1.0\nelement vertex 999999999999\nproperty float x\nproperty float y\n\
                  property float z\nend_header\n", "announces 999999999999 points, holds 0"),
        ("ply", b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n1 2\n", "must be z"),
        ("ply", b"ply\nformat ascii 1.0\nend_header\n", "element vertex"),
        ("ply", b"ply\nformat ascii 1.0\nproperty float x\n", "below an element"),
        ("pcd", b"FIELDS x y\nSIZE 4 4\nTYPE F F\nPOINTS 0\nDATA ascii\n", "field x, y or z"),
        ("pcd", b"FIELDS x y z\nSIZE 4 4\nTYPE F F F\nPOINTS 0\nDATA ascii\n", "as long as FIELDS"),
        ("pcd", b"FIELDS x y z\nSIZE 4 4 3\nTYPE F F F\nPOINTS 0\nDATA ascii\n", "TYPE and SIZE"),
        ("pcd", b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 2\nPOINTS 3\nDATA ascii\n", "announces 4"),
        ("pcd", b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 3000000000\nDATA binary_compressed\n\0\0\0\0\xff\xff\xff\xff", "unpacked"),
        ("pcd", b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA ascii\n1 2 three\n", "a coordinate"),
        ("pgm", b"P6 1 1 255\n\0\0\0", "magic number"),
        ("pgm", b"P5 65536 65536 255\n", "pixels: 4294967296 asked for"),
        ("pgm", b"P5 9999999999 1 255\n", "below 2^32"),
        ("pgm", b"P5 2 2 255\n\0\0", "announces 4 pixels, holds 2"),
        ("pgm", b"P5 1 1 70000\n\0\0", "white value"),
        ("pgm", b"P2 1 1 9\n10\n", "at most the white value"),
        ("yaml", b"image: a.pgm\norigin: [0, 0, 0]\n", "resolution"),
        ("yaml", b"resolution: 0.1\norigin: [0, 0]\n", "[x, y, yaw]"),
        ("yaml", b"resolution: 0.1\norigin: [0, 0, 0]\nmode: raw\n", "trinary or scale"),
        ("yaml", b"resolution: 0.1\norigin: [0, 0, 0]\noccupied_thresh: 0.1\n", "0 <= free <= occupied <= 1"),
        ("yaml", b"what", "key: value"),
        ("voxm", b"VOXM\x02\0\0\0", "version"),
        ("voxm", b"VOXM\x01\0\0\0", "the checksum"),
        ("voxm", b"VOXM\x01\0\0\0........", "the file is damaged"),
    ] {
        let text = fault(kind, bytes);
        assert!(text.contains(words), "{kind}: {text:?} lacks {words:?}");
    }
    // A saved map larger than the caller allows.
    let map = random_map(3, [64.0, 12.0, 6.0], 0.6, 0.2);
    assert!(matches!(
        VoxelMap::load(&map.save(), 1000),
        Err(Error::TooLarge { most: 1000.0, .. })
    ));
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
