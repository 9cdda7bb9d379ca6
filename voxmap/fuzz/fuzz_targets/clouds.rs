//! Any bytes as PLY and PCD.
#![no_main]

use libfuzzer_sys::fuzz_target;
use voxmap::io::{read_pcd, read_ply, write_pcd, write_ply};

fuzz_target!(|bytes: &[u8]| {
    if let Ok(cloud) = read_ply(bytes) {
        assert_eq!(read_ply(&write_ply(&cloud)).map(|c| c.points.len()), Ok(cloud.points.len()));
    }
    if let Ok(cloud) = read_pcd(bytes) {
        assert_eq!(read_pcd(&write_pcd(&cloud)).map(|c| c.points.len()), Ok(cloud.points.len()));
    }
});
