//! map_server YAML + PGM, and the query files.

use hybrid_astar::grid::Grid;
use serde_json::Value;
use std::error::Error;
use std::fs;
use std::path::Path;

/// A map: blocked cells row by row from the lowest y, and the same as a [`Grid`] of points.
pub struct NavMap {
    pub name: String,
    pub size: [usize; 2],
    pub cell: f64,
    pub low: [f64; 2],
    pub blocked: Vec<bool>,
    pub grid: Grid,
}

fn field<'a>(yaml: &'a str, name: &str) -> Result<&'a str, String> {
    let line = yaml
        .lines()
        .find_map(|l| l.strip_prefix(name).and_then(|r| r.strip_prefix(':')));
    line.map(str::trim)
        .ok_or(format!("no `{name}` in the map's YAML"))
}

/// Reads a map_server YAML and the PGM it names. Cells darker than the free threshold (unknown ones, too) are blocked.
pub fn map(path: &Path) -> Result<NavMap, Box<dyn Error>> {
    let yaml = fs::read_to_string(path)?;
    let cell: f64 = field(&yaml, "resolution")?.parse()?;
    let origin: Vec<f64> = field(&yaml, "origin")?
        .trim_matches(['[', ']'])
        .split(',')
        .map(|v| v.trim().parse())
        .collect::<Result<_, _>>()?;
    let negate = field(&yaml, "negate").is_ok_and(|v| v == "1");
    let free_below: f64 = field(&yaml, "free_thresh")?.parse()?;
    let bytes = fs::read(path.with_file_name(field(&yaml, "image")?.trim_matches('"')))?;
    let (mut words, mut at) = (Vec::new(), 0);
    while words.len() < 4 {
        while bytes.get(at).is_some_and(u8::is_ascii_whitespace) {
            at += 1;
        }
        if bytes.get(at) == Some(&b'#') {
            while bytes.get(at).is_some_and(|&b| b != b'\n') {
                at += 1;
            }
            continue;
        }
        let from = at;
        while bytes.get(at).is_some_and(|b| !b.is_ascii_whitespace()) {
            at += 1;
        }
        if from == at {
            return Err("PGM header ends early".into());
        }
        words.push(std::str::from_utf8(&bytes[from..at])?.to_owned());
    }
    if words[0] != "P5" {
        return Err(format!("{}: only binary PGM (P5) is read", words[0]).into());
    }
    let (w, h, top): (usize, usize, f64) =
        (words[1].parse()?, words[2].parse()?, words[3].parse()?);
    let pixels = bytes
        .get(at + 1..at + 1 + w * h)
        .ok_or("PGM data ends early")?;
    let mut blocked = vec![false; w * h];
    for y in 0..h {
        for x in 0..w {
            let value = f64::from(pixels[(h - 1 - y) * w + x]) / top;
            let occupancy = if negate { value } else { 1.0 - value };
            // 205 of 255 means unknown.
            blocked[y * w + x] = occupancy >= free_below;
        }
    }
    let low = [
        *origin.first().ok_or("origin")?,
        *origin.get(1).ok_or("origin")?,
    ];
    let grid = Grid::new([w, h], cell, low, &blocked)?.with_inset(0.0);
    let name = path
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    Ok(NavMap {
        name,
        size: [w, h],
        cell,
        low,
        blocked,
        grid,
    })
}

/// One query of a map's JSON file.
pub struct Query {
    pub id: u64,
    pub class: String,
    pub start: [f64; 3],
    pub goal: [f64; 3],
    pub ref_time: [Option<f64>; 2],
    pub ref_length: [Option<f64>; 2],
}

/// Footprint, speed limits and queries.
pub struct Queries {
    pub footprint: Vec<[f64; 2]>,
    pub v: f64,
    pub w: f64,
    pub list: Vec<Query>,
}

fn numbers<const N: usize>(v: &Value) -> Result<[f64; N], String> {
    let list: Vec<f64> = v
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(Value::as_f64)
        .collect();
    list.try_into()
        .map_err(|_| format!("expected {N} numbers, got {v}"))
}

pub fn queries(path: &Path) -> Result<Queries, Box<dyn Error>> {
    let json: Value = serde_json::from_str(&fs::read_to_string(path)?)?;
    let footprint = json["footprint"]
        .as_array()
        .ok_or("no footprint")?
        .iter()
        .map(numbers::<2>)
        .collect::<Result<_, _>>()?;
    let mut list = Vec::new();
    for q in json["queries"].as_array().ok_or("no queries")? {
        list.push(Query {
            id: q["id"].as_u64().unwrap_or(0),
            class: q["class"].as_str().unwrap_or("?").to_owned(),
            start: numbers(&q["start"])?,
            goal: numbers(&q["goal"])?,
            ref_time: [q["ref_time"].as_f64(), q["ref_time_yaw_free"].as_f64()],
            ref_length: [q["ref_length"].as_f64(), q["ref_length_yaw_free"].as_f64()],
        });
    }
    Ok(Queries {
        footprint,
        v: json["v_max"].as_f64().ok_or("no v_max")?,
        w: json["w_max"].as_f64().ok_or("no w_max")?,
        list,
    })
}
