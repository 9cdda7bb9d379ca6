//! What is measured of a workload.

use crate::clock::{median_ms, repeated_ms, timed};
use crate::office::{Dice, is_solid};
use crate::{Scan, Workload};
use frontier::Map as _;
use serde_json::{Value, json};
use std::path::Path;
use voxmap::io::OcTree;
use voxmap::{
    Config, CostMap, CostMapParams, Esdf, EsdfParams, GrazingGuard, SensorModel, State,
    UnknownPolicy, VoxelMap,
};

type Failure = Box<dyn std::error::Error>;

fn blank(w: &Workload) -> Result<VoxelMap, voxmap::Error> {
    VoxelMap::new(&Config {
        cell_size: w.cell_size,
        low: w.low,
        high: w.high,
        sensor: SensorModel::default(),
    })
}

/// How far hits are moved into the solid, m, and the grazing guard.
type Care = (f64, Option<GrazingGuard>);

/// As OctoMap has it.
const PLAIN: Care = (0.0, None);

/// What a scan has by default, and a guard.
fn careful(guard: Option<GrazingGuard>) -> Care {
    (voxmap::Scan::default().hit_depth, guard)
}

fn insert(
    map: &mut VoxelMap,
    scan: &Scan,
    range: f64,
    dedupe: bool,
    (hit_depth, grazing_guard): Care,
) -> Result<(), voxmap::Error> {
    map.insert(&voxmap::Scan {
        origin: scan.origin,
        hits: &scan.points,
        max_range: range,
        hit_depth,
        one_ray_per_end_voxel: dedupe,
        grazing_guard,
        ..voxmap::Scan::default()
    })
    .map(|_| ())
}

/// Inserts everything into a fresh map: the map, and the median time of a scan, ms. With `each`, calls it after each scan.
fn inserted(
    w: &Workload,
    dedupe: bool,
    care: Care,
    mut each: impl FnMut(&mut VoxelMap),
) -> Result<(VoxelMap, f64), voxmap::Error> {
    let mut map = blank(w)?;
    let mut times = Vec::new();
    for scan in &w.scans {
        let (done, time) = timed(|| insert(&mut map, scan, w.range, dedupe, care));
        done?;
        times.push(time);
        each(&mut map);
    }
    Ok((map, median_ms(&mut times)))
}

/// Shares of known cells with something solid that count as free, and of empty ones that count as occupied.
fn errors(w: &Workload, map: &VoxelMap) -> Value {
    let (mut solid, mut missed, mut empty, mut ghosts) = (0, 0, 0, 0);
    for cell in cells(map) {
        let state = map.state(cell);
        if state == State::Unknown {
            continue;
        }
        let low = map.center(cell).map(|v| v - 0.5 * map.cell_size());
        if is_solid(&w.solids, low, map.cell_size()) {
            solid += 1;
            missed += usize::from(state == State::Free);
        } else {
            empty += 1;
            ghosts += usize::from(state == State::Occupied);
        }
    }
    json!({
        "false_free": missed as f64 / f64::from(solid.max(1)),
        "false_occupied": ghosts as f64 / f64::from(empty.max(1)),
    })
}

fn cells(map: &VoxelMap) -> impl Iterator<Item = [i32; 3]> + use<> {
    let b = map.bounds();
    (b.low[2]..b.high[2]).flat_map(move |z| {
        (b.low[1]..b.high[1]).flat_map(move |y| (b.low[0]..b.high[0]).map(move |x| [x, y, z]))
    })
}

/// The workload's solids, every other cell free.
fn truth(w: &Workload) -> Result<VoxelMap, voxmap::Error> {
    let mut map = blank(w)?;
    map.set_free_box([f64::NEG_INFINITY; 3], [f64::INFINITY; 3]);
    let b = map.bounds();
    for (low, high) in &w.solids {
        // Cells that they reach into by more than a hair.
        let from = map.cell_at(low.map(|v| v + 1e-6));
        let to = map.cell_at(high.map(|v| v - 1e-6));
        let range = |a: usize| from[a].max(b.low[a])..(to[a] + 1).min(b.high[a]);
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    map.set_state([x, y, z], State::Occupied);
                }
            }
        }
    }
    Ok(map)
}

/// Size (3 x i32), then a byte a cell, x fastest: 0 where it is occupied, else 1.
fn obstacles(map: &VoxelMap) -> Vec<u8> {
    let size = map.size().map(|n| (n as i32).to_le_bytes());
    let mut out = size.concat();
    out.extend(cells(map).map(|cell| u8::from(!map.is_occupied(cell))));
    out
}

/// Surface cells that turned from occupied to free, summed over all scans: each loses its inspection.
fn flicker(w: &Workload, care: Care) -> Result<usize, voxmap::Error> {
    let mut lost = 0;
    let mut before = blank(w)?;
    before.take_changes();
    let mut map = before.clone();
    for scan in &w.scans {
        insert(&mut map, scan, w.range, false, care)?;
        for cell in map.take_changes().cells() {
            lost += usize::from(before.is_occupied(cell) && map.is_free(cell));
            before.set_state(cell, map.state(cell));
        }
    }
    Ok(lost)
}

/// Exploration frontier cells of the whole map as words, each layer's handed to `each`.
fn detect(map: &VoxelMap, mut each: impl FnMut(&[u64])) {
    let b = map.bounds();
    let row = map.size()[0].div_ceil(64);
    let mut words = vec![0; row * map.size()[1]];
    for z in b.low[2]..b.high[2] {
        map.exploration_words([b.low[0], b.low[1], z], row, &mut words);
        each(&words);
    }
}

/// Time to find the exploration frontier of the whole map, us.
fn detect_us(map: &VoxelMap) -> f64 {
    1e3 * repeated_ms(15, || {
        detect(map, |words| {
            std::hint::black_box(words);
        });
    })
}

/// Point queries, ns, and casts of up to 10 m from the scans' origins, us.
fn queries(w: &Workload, map: &VoxelMap) -> Value {
    let mut dice = Dice::new(3);
    let points: Vec<[f64; 3]> = (0..100_000)
        .map(|_| [0, 1, 2].map(|a| dice.between(w.low[a], w.high[a])))
        .collect();
    let point_ms = repeated_ms(5, || {
        let occupied = |p: &&[f64; 3]| map.state(map.cell_at(**p)) == State::Occupied;
        points.iter().filter(occupied).count()
    });
    let rays: Vec<([f64; 3], [f64; 3])> = (0..20_000)
        .map(|k| {
            let scan = &w.scans[k % w.scans.len()];
            (scan.origin, [0, 1, 2].map(|_| dice.between(-1.0, 1.0)))
        })
        .collect();
    // As OctoMap's castRay with ignoreUnknownCells, and counting the unknown cells.
    let [cast_ms, counting_ms] = [UnknownPolicy::Ignore, UnknownPolicy::Pass].map(|policy| {
        repeated_ms(5, || {
            let hit = |(o, d): &&([f64; 3], [f64; 3])| map.cast(*o, *d, 10.0, policy).occupied;
            rays.iter().filter(hit).count()
        })
    });
    let hits = rays
        .iter()
        .filter(|(o, d)| map.cast(*o, *d, 10.0, UnknownPolicy::Ignore).occupied)
        .count();
    json!({
        "point_query_ns": point_ms * 1e6 / points.len() as f64,
        "cast_us": cast_ms * 1e3 / rays.len() as f64,
        "cast_counting_us": counting_ms * 1e3 / rays.len() as f64,
        "cast_hit_share": hits as f64 / rays.len() as f64,
    })
}

/// Distance field of the known obstacles: whole, and after k cells toggled in a box of 40 x 40 x 18.
fn distances(map: &VoxelMap, truncation: f64) -> Result<Value, Failure> {
    let params = EsdfParams {
        truncation,
        unknown_is_occupied: false,
    };
    let whole = repeated_ms(5, || Esdf::new(map, params.clone()));
    let mut updates = serde_json::Map::new();
    let mut map = map.clone();
    let mut field = Esdf::new(&map, params.clone())?;
    map.take_changes();
    let mut dice = Dice::new(5);
    let b = map.bounds();
    for k in [10, 100, 1000, 5000] {
        let mut times = Vec::new();
        for _ in 0..7 {
            let corner = [0, 1, 2].map(|a| b.low[a] + (b.high[a] - b.low[a]) / 3);
            for _ in 0..k {
                let cell = [
                    corner[0] + dice.below(40) as i32,
                    corner[1] + dice.below(40) as i32,
                    (b.low[2] + dice.below(18) as i32).min(b.high[2] - 1),
                ];
                let free = map.is_occupied(cell);
                map.set_state(cell, if free { State::Free } else { State::Occupied });
            }
            let changes = map.take_changes();
            times.push(timed(|| field.update(&map, &changes)).1);
        }
        updates.insert(k.to_string(), json!(median_ms(&mut times) * 1e3));
    }
    let fresh = Esdf::new(&map, params)?;
    let equal = cells(&map).all(|c| fresh.cell_distance(c) == field.cell_distance(c));
    Ok(json!({ "whole_ms": whole, "update_us": updates, "update_equals_rebuild": equal }))
}

/// Frontiers of the finished map, and their upkeep over the scans.
fn frontiers(w: &Workload) -> Result<Value, Failure> {
    let mut clusters = frontier::Frontiers::new(frontier::Params::default())?;
    // FUEL's search: exploration alone, cut along the principal axis until at most 2 m from end to end.
    let mut fuel = frontier::Frontiers::new(frontier::Params {
        exploration_split: frontier::Split::PrincipalAxis,
        exploration_extent: 2.0 / w.cell_size,
        inspection_band: (i32::MIN, i32::MIN + 1),
        ..frontier::Params::default()
    })?;
    let (mut detection, mut upkeep, mut like_fuel) = (Vec::new(), Vec::new(), Vec::new());
    let mut words = 0;
    let (map, _) = inserted(w, false, PLAIN, |map| {
        let changes = map.take_changes();
        words += changes.words.len();
        // Only the words of changed boxes and of the cells beside them.
        let near = || {
            let low = map.bounds().low;
            let mut bits = Vec::new();
            for b in &changes.state_boxes {
                let first = (b.low[0] - 1 - low[0]).div_euclid(64);
                let row = ((b.high[0] - low[0]).div_euclid(64) - first + 1) as usize;
                let rows = (b.high[1] - b.low[1] + 2) as usize;
                bits.resize(row * rows, 0);
                for z in b.low[2] - 1..=b.high[2] {
                    let at = [low[0] + 64 * first, b.low[1] - 1, z];
                    map.exploration_words(at, row, &mut bits);
                    std::hint::black_box(&bits);
                }
            }
        };
        detection.push(timed(near).1);
        let boxes: Vec<_> = changes.boxes.iter().map(|b| (b.low, b.high)).collect();
        upkeep.push(timed(|| clusters.update(&*map, &boxes)).1);
        like_fuel.push(timed(|| fuel.update(&*map, &boxes)).1);
    })?;
    let mut found = 0;
    detect(&map, |words| {
        found += words.iter().map(|w| w.count_ones()).sum::<u32>()
    });
    Ok(json!({
        "cells": found,
        "whole_us": detect_us(&map),
        "changed_words_per_scan": words as f64 / w.scans.len() as f64,
        "changed_boxes_us": median_ms(&mut detection) * 1e3,
        "clusters_update_ms": median_ms(&mut upkeep),
        "clusters": clusters.clusters().count(),
        "clusters_like_fuel_update_ms": median_ms(&mut like_fuel),
        "clusters_like_fuel": fuel.clusters().count(),
    }))
}

/// All figures of a workload.
pub fn scans(w: &Workload, dump: Option<&Path>) -> Result<Value, Failure> {
    if w.scans.iter().all(|scan| scan.points.is_empty()) {
        return Ok(json!({ "name": w.name, "scans": w.scans.len(), "points_per_scan": 0.0 }));
    }
    let (map, all) = inserted(w, false, PLAIN, |map| drop(map.take_changes()))?;
    let (_, dedupe) = inserted(w, true, PLAIN, |map| drop(map.take_changes()))?;
    // With the depth of hits that is the default, without a guard and with each.
    let cares = [
        None,
        Some(GrazingGuard::default()),
        Some(GrazingGuard::thorough()),
    ]
    .map(careful);
    let (deep, _) = inserted(w, false, cares[0], |map| drop(map.take_changes()))?;
    let (guarded, guard) = inserted(w, false, cares[1], |map| drop(map.take_changes()))?;
    let (thorough, thoroughly) = inserted(w, false, cares[2], |map| drop(map.take_changes()))?;
    // Distances are those of the true walls where they are known: what a finished exploration works with.
    let walls = if w.solids.is_empty() {
        map.clone()
    } else {
        truth(w)?
    };
    if let Some(folder) = dump {
        std::fs::write(folder.join(format!("{}.occ", w.name)), obstacles(&walls))?;
    }
    let counts = map.counts();
    let points: usize = w.scans.iter().map(|s| s.points.len()).sum();
    let cells = map.size().iter().product::<usize>();
    let mut out = json!({
        "name": w.name,
        "cell_size": w.cell_size,
        "max_range": w.range,
        "scans": w.scans.len(),
        "points_per_scan": points as f64 / w.scans.len() as f64,
        "cells": cells,
        "known": counts.known,
        "occupied": counts.occupied,
        "insert_all_ms": all,
        "insert_dedupe_ms": dedupe,
        "insert_guarded_ms": guard,
        "insert_thorough_ms": thoroughly,
        "memory_mib": map.memory() as f64 / f64::from(1 << 20),
        "queries": queries(w, &map),
        "esdf": distances(&walls, (2.0f64).min(200.0 * w.cell_size))?,
        "frontiers": frontiers(w)?,
        "cost_map_ms": repeated_ms(5, || CostMap::project(&map, &CostMapParams::default())),
    });
    if !w.solids.is_empty() {
        out["errors_as_octomap"] = errors(w, &map);
        out["errors"] = errors(w, &deep);
        out["errors_guarded"] = errors(w, &guarded);
        out["errors_thorough"] = errors(w, &thorough);
        out["flicker_as_octomap"] = json!(flicker(w, PLAIN)?);
        out["flicker"] = json!(flicker(w, cares[0])?);
        out["flicker_guarded"] = json!(flicker(w, cares[1])?);
        out["flicker_thorough"] = json!(flicker(w, cares[2])?);
    }
    Ok(out)
}

/// Figures of an OctoMap file.
pub fn octree(path: &Path) -> Result<Value, Failure> {
    let bytes = std::fs::read(path)?;
    let tree = OcTree::read_bt(&bytes)?;
    let model = SensorModel::default();
    let map = tree.to_map(&model, 1 << 28)?;
    let counts = map.counts();
    let mut dice = Dice::new(9);
    let rays: Vec<([f64; 3], [f64; 3])> = (0..20_000)
        .map(|_| {
            let origin = [0, 1, 2].map(|a| {
                let low = map.low()[a];
                dice.between(low, low + map.size()[a] as f64 * map.cell_size())
            });
            (origin, [0, 1, 2].map(|_| dice.between(-1.0, 1.0)))
        })
        .collect();
    let casts = repeated_ms(3, || {
        let hit =
            |(o, d): &&([f64; 3], [f64; 3])| map.cast(*o, *d, 10.0, UnknownPolicy::Ignore).occupied;
        rays.iter().filter(hit).count()
    });
    Ok(json!({
        "name": path.file_stem().unwrap_or_default().to_string_lossy(),
        "cell_size": map.cell_size(),
        "cells": map.size().iter().product::<usize>(),
        "occupied": counts.occupied,
        "free": counts.free,
        "read_ms": repeated_ms(3, || OcTree::read_bt(&bytes)),
        "to_map_ms": repeated_ms(3, || tree.to_map(&model, 1 << 28)),
        "write_ms": repeated_ms(3, || tree.write_bt()),
        "memory_mib": map.memory() as f64 / f64::from(1 << 20),
        "cast_us": casts * 1e3 / rays.len() as f64,
        "esdf": distances(&map, 2.0)?,
        "frontier_whole_us": detect_us(&map),
    }))
}
