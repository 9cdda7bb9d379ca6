//! What holds for any command, pose and seed.
#![allow(missing_docs, clippy::unwrap_used)]

mod scene_support;

use proptest::prelude::*;
use scene_support::{block, scene, shape};
use seekplan::scene::Scene;
use seekplan::sim::{
    Body, CameraPose, Command, DepthCamera, DepthModel, JOINTS, Kinematics, Lidar, LidarModel,
    MotionLimits, Noise, Part, PartShape, Simulator, TICK, TagCamera, TagDetector, World,
};

/// A stand-in robot: the base box, and an upright mast with a boom that turns with the first joint.
#[derive(Clone, Copy, Debug)]
struct Crane;

fn along(base: [f64; 3], angle: f64, reach: f64, z: f64) -> [f64; 3] {
    let (s, c) = (base[2] + angle).sin_cos();
    [base[0] + reach * c, base[1] + reach * s, z]
}

impl Kinematics for Crane {
    fn body(&self, base: [f64; 3], joints: &[f64; JOINTS], out: &mut Body) {
        let (s, c) = base[2].sin_cos();
        let rotation = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
        let center = [base[0], base[1], 0.2];
        let boom = |reach, z| along(base, joints[0], reach, z);
        out.parts = vec![
            Part {
                shape: PartShape::Box {
                    center,
                    rotation,
                    half: [0.375, 0.275, 0.2],
                },
                stands: true,
                name: "base",
            },
            Part {
                shape: PartShape::Capsule {
                    a: boom(0.0, 0.5),
                    b: boom(0.0, 1.0),
                    radius: 0.06,
                },
                stands: false,
                name: "mast",
            },
            Part {
                shape: PartShape::Capsule {
                    a: boom(0.0, 1.0),
                    b: boom(0.6, 1.0 + 0.1 * joints[1].sin()),
                    radius: 0.05,
                },
                stands: false,
                name: "boom",
            },
        ];
    }

    fn camera(&self, base: [f64; 3], joints: &[f64; JOINTS]) -> CameraPose {
        let (s, c) = (base[2] + joints[0]).sin_cos();
        (
            [[s, 0.0, c], [-c, 0.0, s], [0.0, -1.0, 0.0]],
            along(base, joints[0], 0.65, 1.0),
        )
    }
}

fn simulator(scene: &Scene, noise: Noise) -> Simulator<Crane> {
    let sensors = (
        Lidar::new(LidarModel::default(), noise),
        DepthCamera::new(DepthModel::default(), noise),
        TagDetector::new(TagCamera::new(scene.limits.d_ins), &scene.tags),
    );
    let start = [scene.start.x, scene.start.y, scene.start.yaw];
    let limits = MotionLimits::for_scene(&scene.limits);
    Simulator::new(
        Crane,
        World::new(scene),
        limits,
        sensors,
        start,
        [0.0; JOINTS],
    )
    .unwrap()
}

/// Anything a broken controller may send.
fn speed(limit: f64) -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -1.5 * limit..1.5 * limit,
        1 => Just(f64::NAN),
        1 => prop_oneof![Just(f64::INFINITY), Just(-1e9)],
    ]
}

fn command() -> impl Strategy<Value = Command> {
    (speed(0.8), speed(1.5), prop::array::uniform6(speed(0.8))).prop_map(|(v, w, qd)| Command {
        v,
        w,
        qd,
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Speeds and accelerations stay within limits whatever is asked, and the robot never stands inside a shape.
    #[test]
    fn limits_hold_for_any_command(
        commands in prop::collection::vec((command(), 1..40_usize), 1..12),
        shapes in prop::collection::vec(shape(), 0..12),
    ) {
        // Keep the start free.
        let shapes = shapes.into_iter().filter(|s| {
            let s = seekplan::scene::Solid::new(s);
            (0..2).any(|k| s.low[k] > 0.8 || s.high[k] < -0.8)
        });
        let mut sim = simulator(&scene(shapes.collect(), vec![]), Noise::default());
        let limits = *sim.limits();
        for (command, times) in commands {
            for _ in 0..times {
                let before = *sim.state();
                let moved = sim.step(&command);
                let now = *sim.state();
                let pairs = [(before.v, now.v, limits.v, limits.a), (before.w, now.w, limits.w, limits.alpha)];
                let joints = (0..JOINTS).map(|k| (before.qd[k], now.qd[k], limits.joint_v[k], limits.joint_a[k]));
                for (last, speed, top, acceleration) in pairs.into_iter().chain(joints) {
                    prop_assert!(speed.abs() <= top);
                    if moved {
                        prop_assert!((speed - last).abs() <= acceleration * TICK + 1e-12);
                    } else {
                        prop_assert_eq!(speed, 0.0);
                    }
                }
                prop_assert!(now.base.iter().chain(&now.joints).all(|x| x.is_finite()));
                prop_assert!(sim.clearance(1.0) > 0.0);
                let step = (now.base[0] - before.base[0]).hypot(now.base[1] - before.base[1]);
                prop_assert!(step <= limits.v * TICK + 1e-12);
            }
        }
        let tally = sim.tally();
        prop_assert_eq!(tally.collisions > 0, tally.min_clearance == 0.0);
    }

    /// A command within limits is carried out to the letter and counts no violation.
    #[test]
    fn admissible_commands_are_obeyed(steps in prop::collection::vec([-1.0..1.0, -1.0..1.0, -1.0..1.0], 1..60)) {
        let mut sim = simulator(&scene(vec![], vec![]), Noise::default());
        let limits = *sim.limits();
        for change in steps {
            let change: [f64; 3] = change;
            let s = *sim.state();
            let next = |now: f64, change: f64, a: f64, top: f64| (now + change * a * TICK).clamp(-top, top);
            let mut command = Command {
                v: next(s.v, change[0], limits.a, limits.v),
                w: next(s.w, change[1], limits.alpha, limits.w),
                ..Command::default()
            };
            command.qd[0] = next(s.qd[0], change[2], limits.joint_a[0], limits.joint_v[0]);
            prop_assert!(sim.step(&command));
            prop_assert_eq!((sim.state().v, sim.state().w, sim.state().qd), (command.v, command.w, command.qd));
        }
        prop_assert_eq!(sim.tally().limit_violations, 0);
    }

    /// Driving at constant speed and turn rate ends where the circle says, in any number of ticks.
    #[test]
    fn arcs_are_exact(v in 0.1..0.8, w in -1.4..1.4, yaw in -3.0..3.0, ticks in 1..60_u32) {
        let (v, w): (f64, f64) = (v, w);
        let mut world = scene(vec![], vec![]);
        world.start.yaw = yaw;
        let mut sim = simulator(&world, Noise::default());
        let command = Command { v, w, ..Command::default() };
        while sim.state().v != v || sim.state().w != w {
            sim.step(&command);
        }
        let a = *sim.state();
        for _ in 0..ticks {
            sim.step(&command);
        }
        let (b, t) = (*sim.state(), f64::from(ticks) * TICK);
        let chord = if w.abs() < 1e-9 { v * t } else { 2.0 * v / w * (0.5 * w * t).sin() };
        let heading = a.base[2] + 0.5 * w * t;
        prop_assert!((b.base[0] - a.base[0] - chord * heading.cos()).abs() < 1e-9);
        prop_assert!((b.base[1] - a.base[1] - chord * heading.sin()).abs() < 1e-9);
        prop_assert!((b.base[2] - a.base[2] - w * t).abs() < 1e-12);
    }

    /// Every hit lies on a surface, every miss at the end of the range, and no ray is lost without noise.
    #[test]
    fn scans_are_complete(shapes in prop::collection::vec(shape(), 0..30), base in [-4.0..4.0, -4.0..4.0, -3.0..3.0]) {
        let scene = scene(shapes, vec![]);
        let world = World::new(&scene);
        let model = LidarModel { step: 0.05, ..LidarModel::default() };
        let mut lidar = Lidar::new(model, Noise::default());
        let scan = lidar.scan(&world, base).clone();
        let (columns, rows) = lidar.size();
        let range = |p: &[f32; 3]| (0..3).map(|k| (f64::from(p[k]) - scan.origin[k]).powi(2)).sum::<f64>().sqrt();
        let near = (0..columns).flat_map(|c| (0..rows).map(move |r| (c, r)));
        let near = near.filter(|&(c, r)| f64::from(lidar.reach(c, r)) / lidar.elevation(r).cos() < 0.1 + 1e-6);
        prop_assert!(scan.hits.len() + scan.misses.len() + near.count() >= columns * rows);
        prop_assert!(scan.misses.iter().all(|p| (range(p) - 10.0).abs() < 1e-4));
        prop_assert!(scan.hits.iter().all(|p| (0.1 - 1e-4..10.0 + 1e-4).contains(&range(p))));
    }
}

/// A drive with every sensor gives the same bits on one thread and on two, and again.
#[test]
fn runs_do_not_depend_on_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let office = Scene::builtin("office").unwrap();
            let mut sim = simulator(
                &office,
                Noise {
                    sigma: 0.01,
                    dropout: 0.05,
                    seed: 7,
                    ..Noise::default()
                },
            );
            let mut log = Vec::new();
            for tick in 0..100 {
                sim.step(&Command {
                    v: 0.5,
                    w: 0.3 * f64::from(tick).sin(),
                    qd: [0.1; JOINTS],
                });
                if sim.due().lidar {
                    let (scan, image) = sim.scan_and_image();
                    log.push((scan.clone(), image.clone()));
                    sim.detect();
                }
            }
            (log, *sim.state(), *sim.tally(), sim.found().to_vec())
        })
    };
    let first = run(1);
    assert!(first.0.len() == 20);
    assert!(first == run(2));
    assert!(first == run(2));
}

/// Ranges falsified by noise scatter as asked, and drop-outs are as many as asked.
#[test]
fn noise_has_the_asked_figures() {
    let room = scene(
        vec![block("wall.w", [3.0, 0.0, 1.5], [0.1, 6.0, 1.5], 0.0)],
        vec![],
    );
    let world = World::new(&room);
    let mut camera = DepthCamera::new(
        DepthModel::default(),
        Noise {
            sigma: 0.01,
            dropout: 0.1,
            seed: 3,
            ..Noise::default()
        },
    );
    // Looking along +x from 2 m before the wall; level rows see it at depth 1.9.
    let pose = (
        [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
        [1.0, 0.0, 1.5],
    );
    let (mut ratios, mut points) = (Vec::new(), 0);
    for _ in 0..20 {
        let scan = camera.scan(&world, &pose);
        points += scan.hits.len() + scan.misses.len();
        ratios.extend(
            scan.hits
                .iter()
                .filter(|p| p[2] > 0.5)
                .map(|p| (f64::from(p[0]) - 1.0) / 1.9 - 1.0),
        );
    }
    let n = ratios.len() as f64;
    let mean = ratios.iter().sum::<f64>() / n;
    let sigma = (ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / n).sqrt();
    let lost = 1.0 - f64::from(points as u32) / (20.0 * 80.0 * 54.0);
    assert!(
        mean.abs() < 3e-4 && (sigma - 0.01).abs() < 3e-4,
        "mean {mean}, sigma {sigma}"
    );
    assert!((lost - 0.1).abs() < 0.005, "lost {lost}");
}
