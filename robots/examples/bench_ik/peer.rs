//! The same question asked of the PyPI package `eaik`, through its Python call.

use robots::Ur5e;
use serde_json::{Value, json};
use std::process::Command;

const SCRIPT: &str = r#"
import sys, json, time
try:
    import numpy as np
    from eaik.IK_DH import DhRobot
except Exception as e:
    print(json.dumps({"skipped": "python package `eaik` is missing: %s" % e})); sys.exit()
dh = json.loads(sys.argv[1])
bot = DhRobot(np.array([r[2] for r in dh]), np.array([r[1] for r in dh]), np.array([r[0] for r in dh]))
rng = np.random.default_rng(1)
poses = [bot.fwdKin(rng.uniform(-np.pi, np.pi, 6)) for _ in range(500)]
times = []
for _ in range(9):
    t = time.process_time_ns()
    n = sum(len(bot.IK(p).Q) for p in poses)
    times.append((time.process_time_ns() - t) / len(poses))
print(json.dumps({"eaik_ns": sorted(times)[4], "solutions_mean": n / len(poses)}))
"#;

/// What the peer needs and the ratio of our time to it.
pub(crate) fn eaik(python: Option<&str>, arm: &Ur5e, own: f64) -> Value {
    let Some(python) = python else {
        return json!("skipped: give --python PYTHON, with the package `eaik`");
    };
    let dh = json!(arm.dh()).to_string();
    let run = Command::new(python).args(["-c", SCRIPT, &dh]).output();
    let output = match run {
        Ok(output) => output,
        Err(error) => return json!(format!("skipped: {python}: {error}")),
    };
    let text = String::from_utf8_lossy(&output.stdout);
    match serde_json::from_str::<Value>(text.trim()) {
        Ok(mut report) => {
            if let Some(theirs) = report["eaik_ns"].as_f64() {
                report["ours_over_eaik"] = json!(own / theirs);
            }
            report
        }
        Err(_) => json!(format!(
            "skipped: {}",
            String::from_utf8_lossy(&output.stderr).trim()
        )),
    }
}
