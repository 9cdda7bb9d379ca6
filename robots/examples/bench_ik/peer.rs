//! The same questions asked of PyPI packages, through their Python calls: inverse kinematics of `eaik`, forward
//! kinematics and Jacobians of `pin` (Pinocchio).

use crate::measure::Random;
use robots::{Frame, HeadState, LiftHead, Ur5e};
use serde_json::{Value, json};
use std::process::{Command, Stdio};

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

const PINOCCHIO: &str = r#"
import sys, json
try:
    import numpy as np
    import pinocchio as pin
except Exception as e:
    print(json.dumps({"skipped": "python package `pin` is missing: %s" % e})); sys.exit()
ask = json.load(sys.stdin)
turn = lambda axis, a: pin.AngleAxis(a, np.array(axis)).toRotationMatrix()
model, parent, place = pin.Model(), 0, pin.SE3.Identity()
for d, a, alpha in ask["dh"]:
    parent = model.addJoint(parent, pin.JointModelRZ(), place, "j%d" % (model.njoints))
    place = pin.SE3(turn([1.0, 0, 0], alpha), np.array([a, 0, d]))
tip = model.addFrame(pin.Frame("tip", parent, place, pin.FrameType.OP_FRAME))
data = model.createData()
fk = jac = 0.0
for row in ask["arm"]:
    q = np.array(row["q"])
    pin.forwardKinematics(model, data, q); pin.updateFramePlacements(model, data)
    fk = max(fk, np.abs(data.oMf[tip].homogeneous[:3, :].T.ravel() - np.array(row["frame"])).max())
    j = pin.computeFrameJacobian(model, data, q, tip, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
    jac = max(jac, np.abs(j.ravel() - np.array(row["jacobian"])).max())
# Base x, y, yaw, torso lift, head pan, head tilt; then the camera, and its optical axes.
h, at = ask["head"], lambda v: pin.SE3(np.eye(3), np.array([v[0], 0.0, v[1]]))
model, joint, one = pin.Model(), 0, pin.SE3.Identity()
for k, (kind, place) in enumerate([(pin.JointModelPX(), one), (pin.JointModelPY(), one), (pin.JointModelRZ(), one),
        (pin.JointModelPZ(), at(h["torso"])), (pin.JointModelRZ(), at(h["pan"])), (pin.JointModelRY(), at(h["tilt"]))]):
    joint = model.addJoint(joint, kind, place, "h%d" % k)
optical = pin.SE3(np.array([[0.0, 0, 1], [-1, 0, 0], [0, -1, 0]]), np.array([h["camera"][0], 0, h["camera"][1]]))
tip = model.addFrame(pin.Frame("camera", joint, optical, pin.FrameType.OP_FRAME))
data = model.createData()
head = 0.0
for row in ask["states"]:
    pin.forwardKinematics(model, data, np.array(row["q"])); pin.updateFramePlacements(model, data)
    head = max(head, np.abs(data.oMf[tip].homogeneous[:3, :].T.ravel() - np.array(row["frame"])).max())
print(json.dumps({"fk_worst": fk, "jacobian_worst": jac, "pr2_head_worst": head, "states": len(ask["arm"])}))
"#;

/// Largest difference of our forward kinematics (arm and PR2 head) and Jacobian to Pinocchio's, m and 1.
pub(crate) fn pinocchio(python: Option<&str>, arm: &Ur5e) -> Value {
    let Some(python) = python else {
        return json!("skipped: give --python PYTHON, with the package `pin`");
    };
    let mut random = Random(7);
    let flat = |f: &Frame| [f.x, f.y, f.z, f.p].concat();
    let arm_rows: Vec<Value> = (0..500)
        .map(|_| {
            let q = random.joints();
            let frame = arm.chain(&Frame::IDENTITY, &q)[6];
            let jacobian = arm.jacobian(&q).transpose();
            json!({ "q": q, "frame": flat(&frame), "jacobian": jacobian.as_slice() })
        })
        .collect();
    let head = LiftHead::default();
    let states: Vec<Value> = (0..500)
        .map(|_| {
            let state = HeadState {
                base: [
                    random.within(-9.0, 9.0),
                    random.within(-9.0, 9.0),
                    random.within(-3.0, 3.0),
                ],
                torso: random.within(0.02, 0.3),
                pan: random.within(-3.0, 3.0),
                tilt: random.within(-0.4, 1.3),
            };
            let q = [state.base.as_slice(), &[state.torso, state.pan, state.tilt]].concat();
            json!({ "q": q, "frame": flat(&head.camera_frame(&state)) })
        })
        .collect();
    let ask = json!({
        "dh": arm.dh(), "arm": arm_rows, "states": states,
        "head": { "torso": head.torso, "pan": head.pan, "tilt": head.tilt, "camera": head.camera },
    });
    let run = Command::new(python)
        .args(["-c", PINOCCHIO])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let output = run.and_then(|mut child| {
        if let Some(mut to) = child.stdin.take() {
            std::io::Write::write_all(&mut to, ask.to_string().as_bytes())?;
        }
        child.wait_with_output()
    });
    match output {
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stdout);
            serde_json::from_str(text.trim()).unwrap_or_else(|_| {
                json!(format!(
                    "skipped: {}",
                    String::from_utf8_lossy(&output.stderr).trim()
                ))
            })
        }
        Err(error) => json!(format!("skipped: {python}: {error}")),
    }
}
