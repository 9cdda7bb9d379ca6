//! Whole-body problems from their file.

use crate::robot::Joints;
use serde_json::Value;

/// One problem: the arm goes from `start` to `goal` while the base follows its path.
#[derive(Clone, Debug)]
pub(crate) struct Problem {
    pub(crate) id: u64,
    pub(crate) class: String,
    pub(crate) dt: f64,
    /// x, y, yaw.
    pub(crate) base: Vec<[f64; 3]>,
    /// Centre and half size.
    pub(crate) boxes: Vec<[f64; 6]>,
    pub(crate) start: Joints,
    pub(crate) goal: Joints,
    /// Best known cost, rad.
    pub(crate) reference: Option<f64>,
}

impl Problem {
    /// From an entry of the file; `None` if something is missing.
    pub(crate) fn read(entry: &Value) -> Option<Self> {
        Some(Self {
            id: entry["id"].as_u64()?,
            class: entry["class"].as_str().unwrap_or("").to_string(),
            dt: entry["dt"].as_f64()?,
            base: rows(&entry["base_path"])?,
            boxes: rows(&entry["boxes"])?,
            start: row(&entry["q_start"])?,
            goal: row(&entry["q_goal"])?,
            reference: entry["ref_cost"].as_f64(),
        })
    }
}

fn row<const K: usize>(value: &Value) -> Option<[f64; K]> {
    let values: Vec<f64> = value
        .as_array()?
        .iter()
        .map(Value::as_f64)
        .collect::<Option<_>>()?;
    values.try_into().ok()
}

fn rows<const K: usize>(value: &Value) -> Option<Vec<[f64; K]>> {
    value.as_array()?.iter().map(row).collect()
}
