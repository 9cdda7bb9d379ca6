//! Times the map on real and synthetic scans, one thread, CPU time:
//!
//! ```text
//! cargo run --release -p voxmap --example bench_scans -- DIR [--json] [--dump OUT] [--scans N] [--only NAMES]
//! ```
//!
//! Workloads are a synthetic office (LiDAR and depth camera at 0.15 m and 0.05 m; not with `--only-files`) and everything
//! below DIR that `files.rs` knows. `--dump OUT` writes each workload's scans and obstacles, so that a peer can
//! work on the very same data: `tools/map_peers.py` does that and prints ratios.
#![allow(
    missing_docs,
    unreachable_pub,
    clippy::print_stdout,
    clippy::print_stderr
)]

mod clock;
mod files;
mod measure;
mod office;

use files::Scan;
use office::Dice;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Scans to insert, and where.
pub struct Workload {
    pub name: String,
    pub cell_size: f64,
    pub range: f64,
    pub low: [f64; 3],
    pub high: [f64; 3],
    pub scans: Vec<Scan>,
    /// What there really is; empty if unknown.
    pub solids: Vec<office::Solid>,
}

/// At most `most` scans of each workload that is wanted.
fn offices(most: usize, wanted: impl Fn(&str) -> bool) -> Vec<Workload> {
    let mut dice = Dice::new(7);
    let solids = office::office(&mut dice);
    let mut out = Vec::new();
    for cell_size in [0.15f64, 0.05] {
        for (letter, range) in [("L", 10.0), ("D", 5.0)] {
            let name = format!("{letter}{:02}", (100.0 * cell_size).round());
            if !wanted(&name) {
                continue;
            }
            let mut dice = Dice::new(11);
            let scans = match letter {
                "L" => office::lidar(&solids, most.min(60), &mut dice),
                _ => office::depth(&solids, most.min(200), &mut dice),
            };
            out.push(Workload {
                name,
                cell_size,
                range,
                low: [0.0, 0.0, -0.15],
                high: [30.0, 20.1, 3.15],
                scans,
                solids: solids.clone(),
            });
        }
    }
    out
}

/// A workload of a file or folder, its bounds those of what is in range.
fn from_file(path: &Path) -> Result<Vec<Workload>, std::io::Error> {
    let name = path
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let (scans, range, cells) = if path.is_dir() {
        (files::read_images(path)?, 5.0, vec![0.05, 0.02])
    } else if path.extension().is_some_and(|e| e == "scn") {
        (files::read_scn(path)?, 50.0, vec![0.2])
    } else {
        (files::read_bin(path)?, 10.0, vec![0.15, 0.05])
    };
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for scan in &scans {
        for point in &scan.points {
            let way = [0, 1, 2].map(|a| f64::from(point[a]) - scan.origin[a]);
            let length = way.iter().map(|v| v * v).sum::<f64>().sqrt();
            let share = (range / length).min(1.0);
            for a in 0..3 {
                let end = scan.origin[a] + share * way[a];
                low[a] = low[a].min(end).min(scan.origin[a]);
                high[a] = high[a].max(end).max(scan.origin[a]);
            }
        }
    }
    Ok(cells
        .into_iter()
        .map(|h| Workload {
            name: format!("{name}-{h}"),
            cell_size: h,
            range,
            // Whole cells, as OctoMap has them.
            low: low.map(|v| ((v / h).floor() - 1.0) * h),
            high: high.map(|v| ((v / h).ceil() + 1.0) * h),
            scans: scans
                .iter()
                .map(|s| Scan {
                    origin: s.origin,
                    points: s.points.clone(),
                })
                .collect(),
            solids: Vec::new(),
        })
        .collect())
}

struct Options {
    folder: Option<PathBuf>,
    json: bool,
    only_files: bool,
    dump: Option<PathBuf>,
    /// Scans of a workload that are used; 0 for all.
    scans: usize,
    /// Names of workloads; empty for all.
    only: Vec<String>,
}

fn options() -> Result<Options, String> {
    let mut out = Options {
        folder: None,
        json: false,
        only_files: false,
        dump: None,
        scans: 0,
        only: Vec::new(),
    };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--json" => out.json = true,
            "--only-files" => out.only_files = true,
            "--scans" => {
                let word = words.next().ok_or("--scans needs a number")?;
                out.scans = word
                    .parse()
                    .map_err(|_| format!("{word}: is no number of scans"))?;
            }
            "--only" => {
                let names = words.next().ok_or("--only needs names")?;
                out.only = names.split(',').map(str::to_owned).collect();
            }
            "--dump" => out.dump = Some(words.next().ok_or("--dump needs a folder")?.into()),
            _ if word.starts_with('-') => {
                return Err(format!(
                    "{word}: unknown; usage: bench_scans [DIR] [--json] [--only-files] [--dump OUT] [--scans N] [--only NAMES]"
                ));
            }
            _ => out.folder = Some(word.into()),
        }
    }
    if let Some(folder) = out.folder.as_ref().filter(|f| !f.is_dir()) {
        return Err(format!("{}: is no folder", folder.display()));
    }
    Ok(out)
}

fn run(options: &Options) -> Result<Value, Box<dyn std::error::Error>> {
    let mut results = Vec::new();
    let mut report = |result: Value| {
        if !options.json {
            println!(
                "{}",
                serde_json::to_string_pretty(&result).unwrap_or_default()
            );
        }
        results.push(result);
    };
    let most = if options.scans > 0 {
        options.scans
    } else {
        usize::MAX
    };
    let wanted =
        |name: &str| options.only.is_empty() || options.only.iter().any(|only| only == name);
    let mut workloads = if options.only_files {
        Vec::new()
    } else {
        offices(most, wanted)
    };
    for path in options.folder.iter().flat_map(|f| files::find(f)) {
        if path.extension().is_some_and(|e| e == "bt") {
            report(measure::octree(&path)?);
        } else {
            workloads.extend(from_file(&path)?);
        }
    }
    workloads.retain(|w| wanted(&w.name));
    for workload in &mut workloads {
        workload.scans.truncate(most);
        if let Some(folder) = &options.dump {
            std::fs::create_dir_all(folder)?;
            files::write_bin(
                &folder.join(format!("{}.bin", workload.name)),
                &workload.scans,
            )?;
        }
        report(measure::scans(workload, options.dump.as_deref())?);
    }
    Ok(json!({ "calibration_ns_per_add": clock::calibration(), "workloads": results }))
}

fn main() -> std::process::ExitCode {
    let result = options()
        .map_err(Into::into)
        .and_then(|options| Ok((run(&options)?, options.json)));
    match result {
        Ok((all, json)) => {
            if json {
                println!("{all:#}");
            }
            std::process::ExitCode::SUCCESS
        }
        Err(e) => {
            let e: Box<dyn std::error::Error> = e;
            eprintln!("{e}");
            std::process::ExitCode::from(2)
        }
    }
}
