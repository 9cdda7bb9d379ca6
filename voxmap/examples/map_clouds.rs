//! Builds a map from a folder of posed clouds and draws it from above, coloured by the height of the highest thing in each
//! column:
//!
//! ```text
//! cargo run --release -p voxmap --example map_clouds -- FOLDER OUT.svg [CELL_SIZE]
//! ```
//!
//! Reads `*.pcd` (with the sensor's position in VIEWPOINT) and `*.ply` (sensor at the origin), points in the world frame.
//! Without arguments it writes clouds of a small room to `target/map_clouds` first and maps those.
#![allow(clippy::print_stdout, clippy::print_stderr)]

#[path = "draw/mod.rs"]
mod draw;

use std::path::{Path, PathBuf};
use voxmap::io::{Cloud, read_pcd, read_ply, write_pcd};
use voxmap::{Error, GrazingGuard, Scan, SensorModel, VoxelMap};

/// What a sensor sees in a room of 6 m x 4 m with a cabinet in it.
fn room(at: [f64; 3]) -> Cloud {
    let solids = [
        ([-0.2, -0.2, 0.0], [0.0, 4.2, 2.5]),
        ([6.0, -0.2, 0.0], [6.2, 4.2, 2.5]),
        ([-0.2, -0.2, 0.0], [6.2, 0.0, 2.5]),
        ([-0.2, 4.0, 0.0], [6.2, 4.2, 2.5]),
        ([-0.2, -0.2, -0.2], [6.2, 4.2, 0.0]),
        ([2.5, 1.5, 0.0], [3.3, 2.4, 1.2]),
    ];
    let mut points = Vec::new();
    for i in 0..60 {
        let (se, ce) = (f64::from(i) - 40.0).to_radians().sin_cos();
        for j in 0..360 {
            let (s, c) = f64::from(j).to_radians().sin_cos();
            let d = [ce * c, ce * s, se];
            let mut best = f64::INFINITY;
            for (low, high) in solids {
                let (mut enter, mut leave) = (0.0f64, best);
                for a in 0..3 {
                    let (t0, t1): (f64, f64) = ((low[a] - at[a]) / d[a], (high[a] - at[a]) / d[a]);
                    enter = enter.max(t0.min(t1));
                    leave = leave.min(t0.max(t1));
                }
                if enter < leave {
                    best = enter;
                }
            }
            if best.is_finite() {
                points.push([0, 1, 2].map(|a| (at[a] + best * d[a]) as f32));
            }
        }
    }
    Cloud {
        position: at,
        ..Cloud::new(points)
    }
}

fn demo() -> std::io::Result<PathBuf> {
    let folder = PathBuf::from("target/map_clouds");
    std::fs::create_dir_all(&folder)?;
    for (k, at) in [
        [1.0, 1.0, 0.8],
        [5.0, 1.2, 0.8],
        [4.8, 3.2, 0.8],
        [1.2, 3.1, 0.8],
    ]
    .iter()
    .enumerate()
    {
        std::fs::write(folder.join(format!("{k}.pcd")), write_pcd(&room(*at)))?;
    }
    Ok(folder)
}

fn build(folder: &Path, cell_size: f64) -> Result<VoxelMap, Box<dyn std::error::Error>> {
    let mut map = VoxelMap::growing(cell_size, &SensorModel::default(), 1 << 27)?;
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .map_err(|e| format!("{}: {e}", folder.display()))?
        .filter_map(|e| Some(e.ok()?.path()))
        .collect();
    files.sort();
    for path in files {
        let read = match path.extension().and_then(|e| e.to_str()) {
            Some("pcd") => read_pcd,
            Some("ply") => read_ply,
            _ => continue,
        };
        let cloud = read(&std::fs::read(&path)?).map_err(|e| format!("{}: {e}", path.display()))?;
        let stats = map
            .insert(&Scan {
                origin: cloud.position,
                hits: &cloud.points,
                max_range: 30.0,
                grazing_guard: Some(GrazingGuard::default()),
                ..Scan::default()
            })
            .map_err(|e: Error| format!("{}: {e}", path.display()))?;
        println!(
            "{}: {} rays, {} points left out",
            path.display(),
            stats.rays,
            stats.rejected
        );
    }
    Ok(map)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let folder = match words.first() {
        Some(folder) => PathBuf::from(folder),
        None => demo()?,
    };
    let out = words
        .get(1)
        .map_or("target/map_clouds/map.svg", String::as_str);
    let cell_size = words.get(2).map_or(Ok(0.1), |w| w.parse())?;
    let map = build(&folder, cell_size)?;
    let counts = map.counts();
    println!(
        "{} free and {} occupied cells, {} KiB",
        counts.free,
        counts.occupied,
        map.memory() / 1024
    );
    let b = map.bounds();
    let top = |x: usize, y: usize| {
        let cell = |z: i32| [b.low[0] + x as i32, b.low[1] + y as i32, z];
        let highest = (b.low[2]..b.high[2])
            .rev()
            .find(|&z| map.is_occupied(cell(z)));
        match highest {
            Some(z) => draw::shade(f64::from(z) * cell_size / 2.5),
            None if (b.low[2]..b.high[2]).any(|z| map.is_free(cell(z))) => "#ffffff".into(),
            None => String::new(),
        }
    };
    std::fs::write(out, draw::svg([map.size()[0], map.size()[1]], 4.0, top))?;
    println!("{out}");
    Ok(())
}
