//! Measures the kinematics: speed, lost branches, singular poses, batched checks, a viewpoint library.
//!
//! ```text
//! cargo run --release -p mobimanip --features diff-ik,urdf --example bench_ik -- [--json] [--samples N] [--python PYTHON]
//! ```
//!
//! Times are CPU time of one thread. With `--python` the closed-form IK of the PyPI package `eaik` is timed in the same
//! run through its Python call, and forward kinematics and Jacobians are compared with those of `pin` (Pinocchio); each
//! is skipped with a message where the package is missing.
#![allow(
    missing_docs,
    clippy::print_stdout,
    clippy::print_stderr,
    clippy::disallowed_methods
)]

mod measure;
mod peer;

use measure::{Random, nanos};
use robots::{
    BatchBody, BodyState, Frame, GridField, IkSolutions, LANES, MobileManipulator, StateBlock,
    Ur5e, looking,
};
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};
use std::hint::black_box;

fn frame(arm: &Ur5e, q: &[f64; 6]) -> Frame {
    arm.chain(&Frame::IDENTITY, q)[6]
}

fn same(a: &[f64; 6], b: &[f64; 6], tolerance: f64) -> bool {
    a.iter().zip(b).all(|(x, y)| {
        let d = (x - y).rem_euclid(TAU);
        d.min(TAU - d) <= tolerance
    })
}

/// Random joint vectors: how often the branch they came from is among the solutions, and how well all close.
fn branches(arm: &Ur5e, samples: usize) -> Value {
    let (mut random, mut out) = (Random(1), IkSolutions::default());
    let (mut asked, mut found, mut solutions, mut worst) = (0u64, 0u64, 0u64, 0.0f64);
    for _ in 0..samples {
        let q = random.joints();
        if q[4].sin().abs() < 1e-4 || q[2].sin().abs() < 1e-4 {
            continue;
        }
        let target = frame(arm, &q);
        arm.ik_near(&target, 0.0, &mut out);
        asked += 1;
        solutions += out.len() as u64;
        found += u64::from(out.as_slice().iter().any(|s| same(&s.joints, &q, 1e-6)));
        for s in out.as_slice() {
            let (p, a) = frame(arm, &s.joints).error_to(&target);
            worst = worst.max(p).max(a);
        }
    }
    json!({ "asked": asked, "original_branch_found": found, "solutions_mean": solutions as f64 / asked.max(1) as f64, "worst_closure": worst })
}

/// Poses on the singular sets: how many keep a solution that closes, and carry the flag.
fn singular(arm: &Ur5e, samples: usize) -> Value {
    let (mut random, mut out) = (Random(2), IkSolutions::default());
    let mut report = json!({});
    for (name, kind) in [("wrist", 0), ("elbow", 1), ("shoulder", 2)] {
        let (mut asked, mut closing, mut flagged) = (0, 0, 0);
        while asked < samples {
            let mut q = random.joints();
            match kind {
                0 => q[4] = if random.unit() < 0.5 { 0.0 } else { PI },
                1 => q[2] = 0.0,
                _ => {
                    // The wrist centre above the pan axis: solve for q4, which moves it along the arm's plane.
                    let reach = |q4: f64| {
                        arm.a2 * q[1].cos()
                            + arm.a3 * (q[1] + q[2]).cos()
                            + arm.d5 * (q[1] + q[2] + q4).sin()
                    };
                    let needed = -(reach(0.0) - arm.d5 * (q[1] + q[2]).sin()) / arm.d5;
                    if needed.abs() > 1.0 {
                        continue;
                    }
                    q[3] = needed.asin() - q[1] - q[2];
                }
            }
            asked += 1;
            let target = frame(arm, &q);
            arm.ik_near(&target, 0.0, &mut out);
            let good = |s: &&robots::IkSolution| {
                let (p, a) = frame(arm, &s.joints).error_to(&target);
                p < 1e-7 && a < 1e-7
            };
            closing += usize::from(out.as_slice().iter().any(|s| good(&s)));
            let flag = |s: &&robots::IkSolution| match kind {
                0 => s.singular.wrist,
                1 => s.singular.elbow,
                _ => s.singular.shoulder,
            };
            flagged += usize::from(out.as_slice().iter().any(|s| good(&s) && flag(&s)));
        }
        report[name] = json!({ "asked": asked, "closing": closing, "flagged": flagged });
    }
    report
}

fn jacobian_error(arm: &Ur5e) -> f64 {
    let (mut random, mut worst, h) = (Random(3), 0.0f64, 1e-5);
    for _ in 0..200 {
        let q = random.joints();
        let j = arm.jacobian(&q);
        for k in 0..6 {
            let at = |d: f64| {
                let mut moved = q;
                moved[k] += d;
                frame(arm, &moved).p
            };
            let (a, b) = (at(-h), at(h));
            for i in 0..3 {
                worst = worst.max(((b[i] - a[i]) / (2.0 * h) - j[(i, k)]).abs());
            }
        }
    }
    worst
}

/// An empty room 8 x 8 x 2 m with boxes, distances sampled every 5 cm: 4.1 million samples.
struct Room {
    values: Vec<f32>,
}

const CELL: f64 = 0.05;
const SIZE: [usize; 3] = [320, 320, 40];
const LOW: [f64; 3] = [-8.0, -8.0, 0.0];

impl Room {
    fn new() -> Self {
        let mut random = Random(4);
        let boxes: Vec<([f64; 3], [f64; 3])> = (0..12)
            .map(|_| {
                let c = [
                    random.within(-6.0, 6.0),
                    random.within(-6.0, 6.0),
                    random.within(0.1, 1.6),
                ];
                let h = [
                    random.within(0.1, 0.6),
                    random.within(0.1, 0.6),
                    random.within(0.05, 0.4),
                ];
                (c, h)
            })
            .collect();
        let mut values = Vec::with_capacity(SIZE.iter().product());
        for z in 0..SIZE[2] {
            for y in 0..SIZE[1] {
                for x in 0..SIZE[0] {
                    let p = [x, y, z];
                    let p: [f64; 3] = std::array::from_fn(|i| LOW[i] + p[i] as f64 * CELL);
                    let gap = |(c, h): &([f64; 3], [f64; 3])| {
                        (0..3)
                            .map(|i| ((p[i] - c[i]).abs() - h[i]).max(0.0).powi(2))
                            .sum::<f64>()
                            .sqrt()
                    };
                    values.push(boxes.iter().map(gap).fold(3.0, f64::min) as f32);
                }
            }
        }
        Self { values }
    }

    fn field(&self) -> GridField<'_> {
        GridField {
            origin: LOW,
            cell: CELL,
            size: SIZE,
            values: &self.values,
            outside: 0.0,
            slack: 0.0,
        }
    }
}

fn speeds(robot: &MobileManipulator, room: &Room) -> Value {
    let (arm, body) = (&robot.arm, BatchBody::new(robot));
    let mut random = Random(5);
    let states: Vec<BodyState> = (0..1024)
        .map(|_| BodyState {
            base: [
                random.within(-6.0, 6.0),
                random.within(-6.0, 6.0),
                random.within(-PI, PI),
            ],
            joints: random.joints(),
        })
        .collect();
    let targets: Vec<Frame> = states.iter().map(|s| frame(arm, &s.joints)).collect();
    let blocks: Vec<StateBlock> = states.chunks(LANES).map(StateBlock::new).collect();
    let n = states.len() as f64;
    let mut out = IkSolutions::default();
    let ik = nanos(|| {
        for t in &targets {
            arm.ik_near(black_box(t), 0.0, &mut out);
            black_box(&out);
        }
    }) / n;
    let fk = nanos(|| {
        for s in &states {
            black_box(arm.chain(&Frame::IDENTITY, black_box(&s.joints)));
        }
    }) / n;
    let spheres = nanos(|| {
        for s in &states {
            black_box(robot.arm_spheres(black_box(s)));
        }
    }) / n;
    let batched = nanos(|| {
        for b in &blocks {
            black_box(body.spheres(black_box(b)));
        }
    }) / n;
    let field = room.field();
    let check = nanos(|| {
        for b in &blocks {
            black_box(body.free(black_box(b), &field, 0.01));
        }
    }) / n;
    // Every lane free of the world: no early exit, all spheres and pairs are looked at.
    let open = |_: [f32; 3]| 10.0f32;
    let whole = nanos(|| {
        for b in &blocks {
            black_box(body.free(black_box(b), &open, 0.01));
        }
    }) / n;
    let free: usize = blocks
        .iter()
        .map(|b| body.free(b, &field, 0.01).iter().filter(|f| **f).count())
        .sum();
    json!({
        "ik_all_branches_ns": ik, "fk_ns": fk, "fk_25_spheres_ns": spheres, "fk_25_spheres_batched_ns": batched,
        "check_batched_ns": check, "checks_per_second": 1e9 / check, "states_free": free, "states": states.len(),
        "check_without_obstacles_ns": whole,
    })
}

/// For one target: 120 base poses on rings around it, 7 camera pitches, closed-form IK and a whole-body check of all
/// branches.
fn library(robot: &MobileManipulator, room: &Room) -> Value {
    let body = BatchBody::new(robot);
    let field = room.field();
    let (target, pitches) = (
        [1.5, 0.5, 1.0],
        [-45.0f64, -30.0, -15.0, 0.0, 15.0, 30.0, 45.0],
    );
    let home = [0.0, -1.2, 1.5, -0.4, 1.3, 0.2];
    let mut counts = (0, 0, 0);
    let time = nanos(|| {
        counts = (0, 0, 0);
        let mut states: Vec<BodyState> = Vec::new();
        for ring in 0..10 {
            for k in 0..12 {
                let (r, a) = (0.9 + 0.15 * f64::from(ring), f64::from(k) * TAU / 12.0);
                let base = [target[0] - r * a.cos(), target[1] - r * a.sin(), a];
                for pitch in pitches {
                    // The lens 0.8 m from the target, on the side of the base.
                    let p = pitch.to_radians();
                    let lens = [
                        target[0] - 0.8 * p.cos() * a.cos(),
                        target[1] - 0.8 * p.cos() * a.sin(),
                        target[2] - 0.8 * p.sin(),
                    ];
                    counts.0 += 1;
                    let found = robot.ik_camera_frame(base, &looking(lens, a, p), &home);
                    states.extend(found.as_slice().iter().map(|s| BodyState {
                        base,
                        joints: s.joints,
                    }));
                }
            }
        }
        counts.1 = states.len();
        for part in states.chunks(LANES) {
            let free = body.free(&StateBlock::new(part), &field, 0.01);
            counts.2 += free[..part.len()].iter().filter(|f| **f).count();
        }
    });
    json!({ "ms": time * 1e-6, "camera_poses": counts.0, "arm_states": counts.1, "free": counts.2 })
}

#[cfg(all(feature = "diff-ik", feature = "urdf"))]
fn numeric() -> Result<Value, robots::Error> {
    use robots::{Chain, DiffIk};
    let chain = Chain::from_urdf(
        include_str!("../../tests/data/ur5e.urdf"),
        include_str!("../../tests/data/ur5e.json"),
    )?;
    let mut random = Random(6);
    let (mut times, mut reached, mut iterations, mut programs) = (Vec::new(), 0, 0, 0);
    let asked = 1000;
    for k in 0..asked {
        let (from, q) = (random.joints(), random.joints());
        let target = chain.tip(&q)?;
        let begin = measure::cpu_seconds();
        let found = chain.ik(&from, &target, &DiffIk::default(), k)?;
        times.push((measure::cpu_seconds() - begin) * 1e6);
        reached += usize::from(found.reached);
        iterations += found.iterations;
        programs += found.programs;
    }
    times.sort_by(f64::total_cmp);
    let at = |q: f64| times[((times.len() - 1) as f64 * q) as usize];
    Ok(json!({
        "asked": asked, "reached": reached, "us_median": at(0.5), "us_p95": at(0.95),
        "iterations_mean": iterations as f64 / asked as f64, "programs_mean": programs as f64 / asked as f64,
    }))
}

#[cfg(not(all(feature = "diff-ik", feature = "urdf")))]
fn numeric() -> Result<Value, robots::Error> {
    Ok(json!("built without the features diff-ik and urdf"))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let value = |name: &str| {
        let at = args.iter().position(|a| a == name)?;
        args.get(at + 1).cloned()
    };
    let samples: usize = value("--samples").map_or(Ok(1_000_000), |v| v.parse())?;
    let robot = MobileManipulator::default();
    let room = Room::new();
    let speeds = speeds(&robot, &room);
    let own = speeds["ik_all_branches_ns"].as_f64().unwrap_or(f64::NAN);
    let report = json!({
        "branches": branches(&robot.arm, samples),
        "singular": singular(&robot.arm, samples / 100),
        "jacobian_vs_differences": jacobian_error(&robot.arm),
        "speeds": speeds,
        "library_of_one_cluster": library(&robot, &room),
        "differential_ik": numeric()?,
        "peer": peer::eaik(value("--python").as_deref(), &robot.arm, own),
        "pinocchio": peer::pinocchio(value("--python").as_deref(), &robot.arm),
    });
    if args.iter().any(|a| a == "--json") {
        println!("{}", serde_json::to_string_pretty(&report)?);
        return Ok(());
    }
    for (name, part) in report.as_object().into_iter().flatten() {
        println!("{name}: {part}");
    }
    Ok(())
}
