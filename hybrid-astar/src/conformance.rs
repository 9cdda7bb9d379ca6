//! The laws of [`Map`] as a check for your own implementation's tests.

use crate::Map;

/// Samples `n` by `n` points and says which law is broken, if one is: bounds finite and not empty, clearance not NaN,
/// and no change of clearance beyond the distance moved plus `cell`, the side of the map's own cells in m.
pub fn check_map<M: Map>(map: &M, cell: f64, n: usize) -> Result<(), String> {
    let (low, high) = map.bounds();
    if !low.iter().chain(&high).all(|v| v.is_finite()) || low[0] >= high[0] || low[1] >= high[1] {
        return Err(format!(
            "bounds {low:?} to {high:?} are empty or not finite"
        ));
    }
    let at = |i: usize, k: usize| low[k] + (i as f64 + 0.5) / n as f64 * (high[k] - low[k]);
    for i in 0..n {
        for j in 0..n {
            let p = [at(i, 0), at(j, 1)];
            let c = map.clearance(p);
            if c.is_nan() {
                return Err(format!("clearance at {p:?} is NaN"));
            }
            for q in [
                [at((i + 1).min(n - 1), 0), p[1]],
                [p[0], at((j + 1).min(n - 1), 1)],
            ] {
                let (d, moved) = (map.clearance(q), (q[0] - p[0]).hypot(q[1] - p[1]));
                if c.is_finite() && d.is_finite() && (c - d).abs() > moved + cell {
                    return Err(format!(
                        "clearance changes from {c} at {p:?} to {d} at {q:?}, {moved} m away"
                    ));
                }
            }
        }
    }
    Ok(())
}
