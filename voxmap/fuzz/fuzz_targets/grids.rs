//! Any bytes as a map's YAML, a zero byte, and its PGM.
#![no_main]

use libfuzzer_sys::fuzz_target;
use voxmap::io::{GridInfo, read_pgm};

fuzz_target!(|bytes: &[u8]| {
    let cut = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    let info = GridInfo::read(&String::from_utf8_lossy(&bytes[..cut]));
    let image = read_pgm(bytes.get(cut + 1..).unwrap_or(&[]));
    if let (Ok(info), Ok(image)) = (info, image) {
        let _ = info.cost_map(&image);
    }
});
