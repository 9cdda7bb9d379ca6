//! Reads an OctoMap file and answers queries:
//!
//! ```text
//! cargo run --release -p voxmap --example query_octree -- FILE.bt [X Y Z ...]
//! ```
//!
//! For each point: its state, the distance to the nearest obstacle, and what rays along the axes meet. Without a file it
//! writes a small tree first.
#![allow(clippy::print_stdout)]

use voxmap::io::OcTree;
use voxmap::{Config, Esdf, EsdfParams, SensorModel, State, UnknownPolicy, VoxelMap};

/// A room of 4 m x 3 m x 2 m with a pillar, as a `.bt` file.
fn demo() -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let mut map = VoxelMap::new(&Config {
        cell_size: 0.1,
        low: [0.0; 3],
        high: [4.0, 3.0, 2.0],
        sensor: SensorModel::default(),
    })?;
    map.set_free_box([0.0; 3], [4.0, 3.0, 2.0]);
    for z in 0..20 {
        for x in 18..22 {
            for y in 13..17 {
                map.set_state([x, y, z], State::Occupied);
            }
        }
    }
    Ok(OcTree::from_map(&map)?.write_bt())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let bytes = match words.first() {
        Some(file) => std::fs::read(file).map_err(|e| format!("{file}: {e}"))?,
        None => demo()?,
    };
    let tree = if bytes.starts_with(b"# Octomap OcTree binary") {
        OcTree::read_bt(&bytes)?
    } else {
        OcTree::read_ot(&bytes)?
    };
    let map = tree.to_map(&SensorModel::default(), 1 << 28)?;
    let counts = map.counts();
    let (low, high) = tree.bounds();
    println!(
        "{} leaves of {} m, cells {low:?} to {high:?}",
        tree.leaves().len(),
        tree.resolution()
    );
    println!(
        "{} free and {} occupied cells, {} KiB",
        counts.free,
        counts.occupied,
        map.memory() / 1024
    );
    let field = Esdf::new(
        &map,
        EsdfParams {
            unknown_is_occupied: false,
            ..EsdfParams::default()
        },
    )?;
    let numbers = words
        .iter()
        .skip(1)
        .map(|w| w.parse())
        .collect::<Result<Vec<f64>, _>>()?;
    let (mut points, rest) = numbers.as_chunks::<3>();
    if !rest.is_empty() {
        return Err("points need three numbers each".into());
    }
    if points.is_empty() {
        points = &[[1.0, 1.5, 1.0], [2.0, 1.5, 1.0], [9.0, 1.5, 1.0]];
    }
    for &p in points {
        println!(
            "{p:?}: {:?}, {:.2} m to the nearest obstacle",
            map.state(map.cell_at(p)),
            field.distance(p)
        );
        for way in [
            [1.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, -1.0, 0.0],
        ] {
            let hit = map.cast(p, way, 20.0, UnknownPolicy::Pass);
            let what = if hit.occupied {
                "an obstacle"
            } else {
                "nothing"
            };
            println!(
                "  along {way:?}: {what} in {:.2} m, {} unknown cells",
                hit.distance, hit.unknown
            );
        }
    }
    Ok(())
}
