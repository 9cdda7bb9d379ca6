//! 71 real depth images against the map that OctoMap 1.10 makes of them.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stderr)]

#[allow(dead_code, unreachable_pub)]
#[path = "../examples/bench_scans/files.rs"]
mod files;

use std::collections::HashMap;
use std::io::Read;
use std::path::PathBuf;
use voxmap::{Cell, Scan, SensorModel, State, VoxelMap};

/// OctoMap's cells: index and log-odds.
fn golden(path: &std::path::Path) -> HashMap<Cell, f32> {
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(std::fs::File::open(path).unwrap())
        .read_to_end(&mut bytes)
        .unwrap();
    let (records, _) = bytes[4..].as_chunks::<10>();
    records
        .iter()
        .map(|r| {
            let index = [0, 2, 4].map(|at| i32::from(i16::from_le_bytes([r[at], r[at + 1]])));
            (index, f32::from_le_bytes([r[6], r[7], r[8], r[9]]))
        })
        .collect()
}

/// At least 99.9 % of all cells known to either are in the same state. The others are explained: OctoMap traces in doubles
/// from rounded `float` directions and we in whole numbers, so that a ray may cross a corner on the other side. Then the two
/// cells beside the corner differ by one miss, which shows only where that miss decides.
#[test]
fn real_images_give_octomaps_map() {
    let folder =
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/scans/icl_livingroom1");
    if !folder.is_dir() {
        eprintln!("SKIPPED: {} is not there", folder.display());
        return;
    }
    let golden = golden(&folder.join("octomap_r005.bin.gz"));
    let mut map = VoxelMap::growing(0.05, &SensorModel::octomap(), 1 << 26).unwrap();
    for scan in files::read_images(&folder).unwrap() {
        map.insert(&Scan {
            origin: scan.origin,
            hits: &scan.points,
            max_range: 5.0,
            hit_depth: 0.0,
            ..Scan::default()
        })
        .unwrap();
    }
    let state = |log: &f32| {
        if *log >= 0.0 {
            State::Occupied
        } else {
            State::Free
        }
    };
    let b = map.bounds();
    let (mut known, mut differ, mut swapped, mut far) = (golden.len(), 0, 0, 0);
    for z in b.low[2]..b.high[2] {
        for y in b.low[1]..b.high[1] {
            for x in b.low[0]..b.high[0] {
                let cell = [x, y, z];
                let ours = map.state(cell);
                let theirs = golden.get(&cell).map_or(State::Unknown, state);
                known += usize::from(theirs == State::Unknown && ours != State::Unknown);
                if ours == theirs {
                    continue;
                }
                differ += 1;
                swapped += usize::from(ours != State::Unknown && theirs != State::Unknown);
                // One miss more or less on either side, or a cell that only one of them touched, once or twice.
                let odds = golden.get(&cell).map_or(0.0, |v| f64::from(*v));
                far += usize::from((map.log_odds(cell) - odds).abs() > 1.3);
            }
        }
    }
    assert!(golden.keys().all(|c| b.contains(*c)));
    eprintln!(
        "{known} cells known, {differ} differ, {swapped} of them free against occupied, {far} by more than three misses"
    );
    assert!(differ * 1000 <= known, "{differ} of {known} differ");
    assert!(
        far * 10_000 <= known,
        "{far} of {known} differ by more than ties explain"
    );
}
