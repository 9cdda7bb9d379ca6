//! Any bytes as a saved map, with a checksum that fits.
#![no_main]

use libfuzzer_sys::fuzz_target;
use voxmap::VoxelMap;

fuzz_target!(|bytes: &[u8]| {
    let mut bytes = bytes.to_vec();
    let hash = bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, &b| {
        (hash ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)
    });
    bytes.extend(hash.to_le_bytes());
    if let Ok(map) = VoxelMap::load(&bytes, 1 << 16) {
        assert!(VoxelMap::load(&map.save(), 1 << 16).is_ok());
    }
});
