//! Instances from files: TSPLIB matrices and the JSON files of exploration instances.

use std::path::Path;

use atsp::{CostMatrix, Problem};
use serde_json::Value;

/// A problem with what is known of its optimum.
pub(crate) struct Instance {
    pub(crate) name: String,
    pub(crate) family: String,
    pub(crate) costs: CostMatrix,
    pub(crate) problem: Problem,
    /// Cost of the best order known.
    pub(crate) best: Option<f64>,
}

/// Reads a `.atsp` or `.json` file, and the best known cost from `optima.json` or `best.json` beside it.
pub(crate) fn read(path: &Path) -> Result<Instance, String> {
    let at = |e: String| format!("{}: {e}", path.display());
    let text = std::fs::read_to_string(path).map_err(|e| at(e.to_string()))?;
    let name = path
        .file_stem()
        .map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let is_json = path.extension().is_some_and(|e| e == "json");
    let (family, costs, problem, list) = if is_json {
        let (family, costs, problem) = exploration(&text).map_err(at)?;
        (family, costs, problem, "best.json")
    } else {
        let costs = atsp::tsplib::parse(&text)
            .map_err(|e| at(e.to_string()))?
            .costs;
        ("tsplib".to_owned(), costs, Problem::Closed, "optima.json")
    };
    let best = std::fs::read_to_string(path.with_file_name(list))
        .ok()
        .and_then(|text| serde_json::from_str::<Value>(&text).ok())
        .and_then(|known| {
            let entry = &known[&name];
            entry.as_f64().or_else(|| entry["cost"].as_f64())
        });
    Ok(Instance {
        name,
        family,
        costs,
        problem,
        best,
    })
}

/// Fields `family`, `kind` (path, open, closed), `start`, `end`, `cost` (rows; null forbids the arc).
fn exploration(text: &str) -> Result<(String, CostMatrix, Problem), String> {
    let value: Value = serde_json::from_str(text).map_err(|e| e.to_string())?;
    let rows = value["cost"].as_array().ok_or("no array \"cost\"")?;
    let rows = rows
        .iter()
        .map(|row| {
            let row = row.as_array().ok_or("a row of \"cost\" is no array")?;
            row.iter()
                .map(|c| match c {
                    Value::Null => Ok(f64::INFINITY),
                    c => c.as_f64().ok_or("a cost is neither number nor null"),
                })
                .collect::<Result<Vec<f64>, &str>>()
        })
        .collect::<Result<Vec<_>, _>>()?;
    let costs = CostMatrix::from_rows(&rows).map_err(|e| e.to_string())?;
    let index = |key: &str| {
        value[key]
            .as_u64()
            .map(|i| i as usize)
            .ok_or(format!("no index {key:?}"))
    };
    let problem = match value["kind"].as_str() {
        Some("path") => Problem::Path {
            start: index("start")?,
            end: index("end")?,
        },
        Some("open") => Problem::Open {
            start: index("start")?,
        },
        Some("closed") => Problem::Closed,
        other => {
            return Err(format!(
                "kind is {other:?}; can be read: path, open, closed"
            ));
        }
    };
    let family = value["family"].as_str().unwrap_or("").to_owned();
    Ok((family, costs, problem))
}
