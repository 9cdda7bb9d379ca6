//! Reading of instance files.

use objsearch::{Goal, Task, Times, View};
use std::error::Error;
use std::path::Path;

/// A planning problem with what is known about it.
pub(crate) struct Instance {
    /// File name without its ending.
    pub(crate) name: String,
    /// The problem.
    pub(crate) task: Task,
    /// Expected time of the best sequence known, s.
    pub(crate) best: Option<f64>,
    json: serde_json::Value,
}

impl Instance {
    /// Reads a file.
    pub(crate) fn load(path: &Path) -> Result<Self, Box<dyn Error>> {
        let json: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path)?)?;
        let numbers = |key: &str| -> Result<Vec<f64>, Box<dyn Error>> {
            let list = json[key].as_array().ok_or(format!("no list {key}"))?;
            list.iter()
                .map(|x| x.as_f64().ok_or_else(|| format!("{key}: {x}").into()))
                .collect()
        };
        let views = json["views"]
            .as_array()
            .ok_or("no views")?
            .iter()
            .map(|view| {
                let cells = view.as_array().into_iter().flatten();
                View::new(cells.filter_map(|c| c.as_u64()).map(|c| c as usize))
            })
            .collect::<Vec<_>>();
        let times = Times::from_lower(numbers("t0")?, &numbers("t_lower")?)?;
        let goal = Goal {
            threshold: json["omega"].as_f64().ok_or("no omega")?,
            ..Goal::default()
        };
        let task = Task::new(&numbers("cell_weight")?, &views, &times, &goal)?;
        let name = path.file_stem().map(|s| s.to_string_lossy().into_owned());
        Ok(Self {
            name: name.unwrap_or_default(),
            best: json["best"]["expected_time"].as_f64(),
            task,
            json,
        })
    }

    /// A stored reference value, s.
    pub(crate) fn reference(&self, key: &str) -> Option<f64> {
        self.json["reference"][key].as_f64()
    }
}
