//! Our side of the exchange with OctoMap's own library; `tools/octomap_exchange.py` is the other.
//!
//! ```text
//! cargo run --release -p voxmap --example octree_exchange -- write DIR     # DIR/ours.bt, DIR/ours.ot and DIR/ours.csv
//! cargo run --release -p voxmap --example octree_exchange -- read FILE OUT  # leaves of a .bt or .ot as CSV; the file again as OUT
//! ```
//!
//! The map written is what a depth camera makes of a room, by FLAP's rules: touched cells, then a fan of rays, a box reset
//! but for its occupied cells, and a floor plan raised to walls.
#![allow(clippy::print_stdout)]

use std::fmt::Write;
use std::path::Path;
use voxmap::io::OcTree;
use voxmap::{CellBox, Config, FanImage, SensorModel, State, VoxelMap};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["write", dir] => write(Path::new(dir)),
        ["read", file, out] => read(Path::new(file), Path::new(out)),
        _ => Err("octree_exchange write DIR | read FILE OUT".into()),
    }
}

fn write(dir: &Path) -> Result<(), Failure> {
    let tree = OcTree::from_map(&room()?)?;
    std::fs::write(dir.join("ours.bt"), tree.write_bt())?;
    std::fs::write(dir.join("ours.ot"), tree.write_ot())?;
    std::fs::write(dir.join("ours.csv"), listed(&tree))?;
    println!("{} leaves", tree.leaves().len());
    Ok(())
}

fn read(file: &Path, out: &Path) -> Result<(), Failure> {
    let bytes = std::fs::read(file).map_err(|e| format!("{}: {e}", file.display()))?;
    let binary = bytes.starts_with(b"# Octomap OcTree binary");
    let tree = if binary {
        OcTree::read_bt(&bytes)?
    } else {
        OcTree::read_ot(&bytes)?
    };
    print!("{}", listed(&tree));
    let again = if binary {
        tree.write_bt()
    } else {
        tree.write_ot()
    };
    Ok(std::fs::write(out, again)?)
}

/// Leaves as `x,y,z,level,occupied,log_odds`: lowest cell, log2 of the edge in cells, state, value.
fn listed(tree: &OcTree) -> String {
    let mut text = String::new();
    for leaf in tree.leaves() {
        let [x, y, z] = leaf.cell;
        let occupied = u8::from(leaf.state() == State::Occupied);
        let _ = writeln!(
            text,
            "{x},{y},{z},{},{occupied},{}",
            leaf.level, leaf.log_odds
        );
    }
    text
}

/// 6 m x 5 m x 2 m at 0.05 m, on both sides of the origin.
fn room() -> Result<VoxelMap, Failure> {
    let mut map = VoxelMap::new(&Config {
        cell_size: 0.05,
        low: [-3.0, -2.0, -0.05],
        high: [3.0, 3.0, 2.0],
        sensor: SensorModel::default(),
    })?;
    let mut walls = vec![false; 120 * 100];
    for y in 0..100 {
        for x in 0..120 {
            walls[y * 120 + x] = x == 0 || y == 0 || x == 119 || y == 99;
        }
    }
    map.extrude(&walls, 120, [-3.0, -2.0], 0.05, 1.5);
    let origin = [-1.0, 0.2, 1.3];
    for turn in 0..12 {
        let yaw = f64::from(turn) * std::f64::consts::TAU / 12.0;
        let (mut points, mut ends) = (Vec::new(), Vec::new());
        for row in -20..=20 {
            for column in -30..=30 {
                let (up, level) = (f64::from(row) / 60.0 - 0.2).sin_cos();
                let (left, ahead) = (yaw + f64::from(column) / 60.0).sin_cos();
                let d = [level * ahead, level * left, up];
                ends.push([0, 1, 2].map(|a| origin[a] + 3.0 * d[a]));
                // A ball of 0.4 m about (0.8, 0.6, 0.7).
                let to = [0, 1, 2].map(|a| [0.8, 0.6, 0.7][a] - origin[a]);
                let along: f64 = (0..3).map(|a| to[a] * d[a]).sum();
                let off = to.iter().map(|v| v * v).sum::<f64>() - along * along;
                if along > 0.0 && off < 0.16 {
                    let r = along - (0.16 - off).sqrt();
                    points.push([0, 1, 2].map(|a| origin[a] + r * d[a]));
                }
            }
        }
        map.insert_fan(&FanImage {
            origin,
            points: &points,
            range: (0.4, 3.0),
            ends: &ends,
            stop_at_occupied: true,
        })?;
    }
    let volume = CellBox {
        low: map.cell_at([0.42, 0.22, 0.32]),
        high: map.cell_at([1.02, 0.82, 1.02]),
    };
    map.reset_cells(&volume, true);
    Ok(map)
}
