//! The distance field of a nav2 map as a picture:
//!
//! ```text
//! cargo run --release -p voxmap --example nav_distance -- MAP.yaml OUT.svg
//! ```
//!
//! Red is near an obstacle or unknown ground, blue is 2 m away or more. Without arguments it draws a map made here, and
//! writes that as PGM and YAML beside the picture.
#![allow(clippy::print_stdout)]

#[path = "draw/mod.rs"]
mod draw;

use std::path::{Path, PathBuf};
use voxmap::io::{GridInfo, read_pgm, write_pgm};
use voxmap::{CostMap, Ground};

/// Distance at which the picture is blue, m.
const FAR: f64 = 2.0;

/// Two rooms with a door.
fn demo(folder: &Path) -> Result<PathBuf, Box<dyn std::error::Error>> {
    let size = [160usize, 100];
    let ground = (0..size[0] * size[1])
        .map(|i| {
            let (x, y) = (i % size[0], i / size[0]);
            let border = x.min(size[0] - 1 - x).min(y).min(size[1] - 1 - y) < 2;
            let wall = (78..82).contains(&x) && !(40..60).contains(&y);
            if border || wall {
                Ground::Obstacle
            } else {
                Ground::Free
            }
        })
        .collect();
    let map = CostMap::from_ground(0.05, [-4.0, -2.5], size, ground)?;
    let (info, image) = GridInfo::of(&map, "rooms.pgm");
    std::fs::create_dir_all(folder)?;
    std::fs::write(folder.join("rooms.pgm"), write_pgm(&image))?;
    let path = folder.join("rooms.yaml");
    std::fs::write(&path, info.write())?;
    Ok(path)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let folder = Path::new("target/nav_distance");
    let yaml = match words.first() {
        Some(path) => PathBuf::from(path),
        None => demo(folder)?,
    };
    let named = |path: &Path, e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
    let text = std::fs::read_to_string(&yaml).map_err(|e| named(&yaml, &e))?;
    let info = GridInfo::read(&text).map_err(|e| named(&yaml, &e))?;
    let image = yaml.parent().unwrap_or(Path::new(".")).join(&info.image);
    let bytes = std::fs::read(&image).map_err(|e| named(&image, &e))?;
    let pixels = read_pgm(&bytes).map_err(|e| named(&image, &e))?;
    let map = info.cost_map(&pixels)?;
    let free = map.free_count() as f64 * map.cell_size().powi(2);
    println!(
        "{:?} cells of {} m, {free:.1} m2 free",
        map.size(),
        map.cell_size()
    );
    let color = |x: usize, y: usize| {
        let cell = [x as i32, y as i32];
        match map.ground(cell) {
            Ground::Obstacle => "#000000".into(),
            Ground::Unknown => String::new(),
            Ground::Free => draw::shade(1.0 - map.clearance(map.center(cell)) / FAR),
        }
    };
    let out = words
        .get(1)
        .map_or_else(|| folder.join("rooms.svg"), PathBuf::from);
    std::fs::write(&out, draw::svg(map.size(), 4.0, color))?;
    println!("{}", out.display());
    Ok(())
}
