//! Any floats as scans of a bounded and of a growing map.
#![no_main]

use libfuzzer_sys::fuzz_target;
use voxmap::{Config, GrazingGuard, Scan, SensorModel, VoxelMap};

fuzz_target!(|bytes: &[u8]| {
    let (words, _) = bytes.as_chunks::<4>();
    let numbers: Vec<f32> = words.iter().map(|w| f32::from_le_bytes(*w)).collect();
    let (points, _) = numbers.as_chunks::<3>();
    let [origin, hits @ ..] = points else { return };
    let scan = Scan {
        origin: origin.map(f64::from),
        hits,
        grazing_guard: Some(if hits.len() % 2 == 0 {
            GrazingGuard::default()
        } else {
            GrazingGuard::thorough()
        }),
        ..Scan::default()
    };
    let sensor = SensorModel::default();
    if let Ok(mut map) = VoxelMap::growing(0.1, &sensor, 1 << 20) {
        let _ = map.insert(&scan);
    }
    let config = Config {
        cell_size: 0.1,
        low: [-3.0; 3],
        high: [3.0; 3],
        sensor,
    };
    if let Ok(mut map) = VoxelMap::new(&config) {
        let _ = map.insert(&scan);
    }
});
