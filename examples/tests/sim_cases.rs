//! Named cases of sensors, detection, contact and time.
#![allow(missing_docs, clippy::unwrap_used)]

mod scene_support;

use scene_support::{block, scene};
use seekplan::clock::{Account, Cost, Planning, Stage, Stopwatch};
use seekplan::scene::{Scene, Tag};
use seekplan::sim::{
    Body, CameraPose, Command, DepthCamera, DepthModel, GroundTruth, GroundTruthError, JOINTS,
    Kinematics, Lidar, LidarModel, MotionLimits, Noise, Part, PartShape, Simulator, StartError,
    TICK, TagCamera, TagDetector, World,
};

/// The base box alone, with a camera 1 m above its centre.
struct Cart;

impl Kinematics for Cart {
    fn body(&self, base: [f64; 3], _: &[f64; JOINTS], out: &mut Body) {
        let (s, c) = base[2].sin_cos();
        let rotation = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
        let center = [base[0], base[1], 0.2];
        let shape = PartShape::Box {
            center,
            rotation,
            half: [0.375, 0.275, 0.2],
        };
        out.parts = vec![Part {
            shape,
            stands: true,
            name: "base",
        }];
    }
    fn camera(&self, base: [f64; 3], _: &[f64; JOINTS]) -> CameraPose {
        let (s, c) = base[2].sin_cos();
        (
            [[s, 0.0, c], [-c, 0.0, s], [0.0, -1.0, 0.0]],
            [base[0], base[1], 1.0],
        )
    }
}

fn start(scene: &Scene, joints: [f64; JOINTS]) -> Result<Simulator<Cart>, StartError> {
    let sensors = (
        Lidar::new(LidarModel::default(), Noise::default()),
        DepthCamera::new(DepthModel::default(), Noise::default()),
        TagDetector::new(TagCamera::new(4.0), &scene.tags),
    );
    let base = [scene.start.x, scene.start.y, scene.start.yaw];
    Simulator::new(
        Cart,
        World::new(scene),
        MotionLimits::default(),
        sensors,
        base,
        joints,
    )
}

fn tag(center: [f64; 3], normal: [f64; 3], size: f64) -> Tag {
    let (up, attached_to, category) = ([0.0, 0.0, 1.0], String::new(), String::new());
    Tag {
        id: 4,
        center,
        normal,
        up,
        size,
        attached_to,
        category,
    }
}

/// A camera at the origin's x, y, 1 m high, looking along +x.
fn ahead() -> CameraPose {
    (
        [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
        [0.0, 0.0, 1.0],
    )
}

fn sees(tag: &Tag, shapes: Vec<seekplan::scene::Shape>) -> bool {
    TagCamera::new(4.0).sees(&World::new(&scene(shapes, vec![])), &ahead(), tag)
}

#[test]
fn a_scan_has_the_rays_of_its_data_sheet() {
    let lidar = Lidar::new(LidarModel::default(), Noise::default());
    assert_eq!(lidar.size(), (450, 74));
    assert!((lidar.elevation(0).to_degrees() + 7.0).abs() < 1e-4);
    assert!((lidar.elevation(73).to_degrees() - 51.4).abs() < 1e-4);
    assert_eq!(
        lidar
            .origin([1.0, 2.0, std::f64::consts::PI], 0.0)
            .map(|v| (v * 1e9).round() / 1e9),
        [0.75, 2.0, 0.45]
    );
}

#[test]
fn an_empty_plain_returns_only_floor() {
    let world = World::new(&scene(vec![], vec![]));
    let mut lidar = Lidar::new(LidarModel::default(), Noise::default());
    let scan = lidar.scan(&world, [0.0; 3]);
    // Falling rays reach the floor within 10 m if they fall by more than asin(0.045) = 2.58 degrees: 6 rows.
    assert_eq!(scan.hits.len(), 450 * 6);
    assert_eq!(scan.misses.len(), 450 * 68);
    assert!(scan.hits.iter().all(|p| p[2].abs() < 1e-5));
}

#[test]
fn a_ceiling_stops_rising_rays() {
    let mut room = scene(vec![], vec![]);
    room.ceiling_z = Some(2.5);
    let world = World::new(&room);
    let mut lidar = Lidar::new(LidarModel::default(), Noise::default());
    let scan = lidar.scan(&world, [0.0; 3]);
    assert!(scan.hits.iter().any(|p| (p[2] - 2.5).abs() < 1e-5));
    assert_eq!(world.cast([0.0, 0.0, 1.0], [0.0, 0.0, 1.0], 5.0), Some(1.5));
    assert_eq!(world.cast([0.0, 0.0, 1.0], [0.0, 0.0, 1.0], 1.0), None);
}

#[test]
fn returns_nearer_than_the_minimum_are_dropped() {
    // A slab 5 cm in front of the LiDAR hides the front.
    let world = World::new(&scene(
        vec![block("slab.a", [0.35, 0.0, 0.5], [0.05, 1.0, 0.5], 0.0)],
        vec![],
    ));
    let mut lidar = Lidar::new(LidarModel::default(), Noise::default());
    let scan = lidar.scan(&world, [0.0; 3]);
    assert!(scan.hits.len() + scan.misses.len() < 450 * 74);
    let range = |p: &[f32; 3]| {
        (0..3)
            .map(|k| (f64::from(p[k]) - scan.origin[k]).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    assert!(scan.hits.iter().all(|p| range(p) >= 0.1 - 1e-6));
}

#[test]
fn casts_refuse_nonsense() {
    let world = World::new(&scene(vec![], vec![]));
    assert_eq!(
        world.cast([f64::NAN, 0.0, 1.0], [0.0, 0.0, -1.0], 5.0),
        None
    );
    assert_eq!(
        world.cast([0.0, 0.0, 1.0], [0.0, 0.0, f64::INFINITY], 5.0),
        None
    );
    assert_eq!(world.cast([0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 5.0), None);
}

#[test]
fn a_tag_is_seen_up_to_the_inspection_distance() {
    let at = |x: f64| tag([x, 0.0, 1.0], [-1.0, 0.0, 0.0], 0.16);
    assert!(sees(&at(2.0), vec![]));
    assert!(sees(&at(3.99), vec![]));
    assert!(!sees(&at(4.01), vec![]));
    assert!(!sees(&at(-2.0), vec![]), "behind the camera");
}

#[test]
fn a_tag_must_face_the_camera() {
    let turned = |degrees: f64| {
        let (s, c) = degrees.to_radians().sin_cos();
        tag([2.0, 0.0, 1.0], [-c, s, 0.0], 0.2)
    };
    assert!(sees(&turned(64.0), vec![]));
    assert!(!sees(&turned(66.0), vec![]));
    assert!(!sees(&turned(180.0), vec![]));
}

#[test]
fn all_corners_must_be_in_the_image() {
    // Half the width at 2 m is 2 tan 34.5 = 1.3746 m.
    let beside = |y: f64| tag([2.0, y, 1.0], [-1.0, 0.0, 0.0], 0.2);
    assert!(sees(&beside(1.27), vec![]));
    assert!(!sees(&beside(1.28), vec![]));
}

#[test]
fn a_tag_must_be_large_enough() {
    // Focal lengths 640 / tan 34.5 = 931 px and 360 / tan 21 = 938 px: 24 px at 3.5 m are 0.0899 m.
    assert!(sees(
        &tag([3.5, 0.0, 1.0], [-1.0, 0.0, 0.0], 0.0901),
        vec![]
    ));
    assert!(!sees(
        &tag([3.5, 0.0, 1.0], [-1.0, 0.0, 0.0], 0.0897),
        vec![]
    ));
}

#[test]
fn one_hidden_corner_hides_a_tag() {
    let target = tag([3.0, 0.0, 1.0], [-1.0, 0.0, 0.0], 0.2);
    let wall = block("wall.w", [3.055, 0.0, 1.0], [0.05, 2.0, 1.0], 0.0);
    assert!(
        sees(&target, vec![wall.clone()]),
        "the wall behind does not hide it"
    );
    let post = |y: f64| block("post.p", [2.0, y, 1.0], [0.01, 0.01, 1.0], 0.0);
    assert!(!sees(&target, vec![wall.clone(), post(0.0)]));
    // The corner's sight line passes x = 2 at y = 0.0667.
    assert!(!sees(&target, vec![wall.clone(), post(0.0667)]));
    assert!(sees(&target, vec![wall, post(0.09)]));
}

#[test]
fn a_detection_takes_two_sharp_images_in_a_row() {
    let tags = [tag([2.0, 0.0, 1.0], [-1.0, 0.0, 0.0], 0.2)];
    let world = World::new(&scene(vec![], vec![]));
    let mut detector = TagDetector::new(TagCamera::new(4.0), &tags);
    assert!(detector.frame(&world, &ahead(), 0.0, 0.0).is_empty());
    assert!(
        detector.frame(&world, &ahead(), 1.5, 0.1).is_empty(),
        "blurred"
    );
    assert!(
        detector.frame(&world, &ahead(), 0.9, 0.2).is_empty(),
        "the streak was broken"
    );
    let found = detector.frame(&world, &ahead(), 0.9, 0.3).to_vec();
    assert_eq!((found[0].id, found[0].time, found.len()), (4, 0.3, 1));
    assert!(
        detector.frame(&world, &ahead(), 0.0, 0.4).is_empty(),
        "only once"
    );
    assert_eq!(detector.found().len(), 1);
}

#[test]
fn sensors_fall_due_at_ten_hertz() {
    let mut sim = start(&scene(vec![], vec![]), [0.0; JOINTS]).unwrap();
    let mut due = Vec::new();
    for _ in 0..50 {
        if sim.due().lidar {
            assert!(sim.due().depth && sim.due().rgb);
            due.push(sim.time());
        }
        sim.step(&Command::default());
    }
    assert_eq!(due.len(), 10);
    assert!((due[3] - 0.3).abs() < 1e-12);
}

#[test]
fn a_wall_stops_the_robot_and_counts_once() {
    let wall = block("wall.w", [1.5, 0.0, 1.0], [0.1, 3.0, 1.0], 0.0);
    let mut sim = start(&scene(vec![wall], vec![]), [0.0; JOINTS]).unwrap();
    assert!((sim.tally().min_clearance - (1.4 - 0.375)).abs() < 1e-4);
    let forward = Command {
        v: 0.8,
        ..Command::default()
    };
    for _ in 0..200 {
        sim.step(&forward);
    }
    assert_eq!(
        (sim.tally().collisions, sim.tally().min_clearance),
        (1, 0.0)
    );
    let nose = sim.state().base[0] + 0.375;
    assert!(nose < 1.4 && nose > 1.4 - 0.8 * TICK, "{nose}");
    assert_eq!(sim.state().base[0], sim.tally().base_path);
    // Back off, come again: a second episode.
    for (v, ticks) in [(-0.3, 100), (0.3, 150)] {
        for _ in 0..ticks {
            sim.step(&Command {
                v,
                ..Command::default()
            });
        }
    }
    assert_eq!(sim.tally().collisions, 2);
}

#[test]
fn standing_against_a_wall_without_touching_is_no_collision() {
    let wall = block("wall.w", [1.5, 0.0, 1.0], [0.1, 3.0, 1.0], 0.0);
    let mut world = scene(vec![wall], vec![]);
    world.start.x = 1.02;
    let mut sim = start(&world, [0.0; JOINTS]).unwrap();
    for _ in 0..50 {
        sim.step(&Command::default());
    }
    assert_eq!(sim.tally().collisions, 0);
    assert!((sim.tally().min_clearance - 0.005).abs() < 1e-5);
}

#[test]
fn the_robot_must_fit_at_its_start() {
    let wall = block("wall.w", [0.4, 0.0, 1.0], [0.1, 3.0, 1.0], 0.0);
    let error = start(&scene(vec![wall], vec![]), [0.0; JOINTS])
        .err()
        .unwrap();
    assert!(
        matches!(&error, StartError::Contact { part: "base", obstacle, .. } if obstacle == "wall.w"),
        "{error}"
    );
    let free = scene(vec![], vec![]);
    for angle in [f64::NAN, 7.0] {
        assert!(matches!(
            start(&free, [angle; JOINTS]),
            Err(StartError::Joint { joint: 0, .. })
        ));
    }
    let mut nowhere = free;
    nowhere.start.x = f64::INFINITY;
    assert!(matches!(
        start(&nowhere, [0.0; JOINTS]),
        Err(StartError::Base(_))
    ));
}

#[test]
fn asking_for_too_much_is_counted_by_tick() {
    let mut sim = start(&scene(vec![], vec![]), [0.0; JOINTS]).unwrap();
    let step = MotionLimits::default().a * TICK;
    sim.step(&Command {
        v: step,
        ..Command::default()
    });
    assert_eq!(sim.tally().limit_violations, 0);
    sim.step(&Command {
        v: 2.5 * step,
        w: 9.0,
        qd: [f64::NAN; JOINTS],
    });
    assert_eq!(
        sim.tally().limit_violations,
        1,
        "one a tick, however many limits"
    );
    assert!((sim.state().v - 2.0 * step).abs() < 1e-15);
    assert_eq!(sim.state().qd, [0.0; JOINTS]);
}

#[test]
fn a_joint_brakes_before_the_end_of_its_range() {
    let mut joints = [0.0; JOINTS];
    joints[2] = std::f64::consts::PI - 0.5;
    let mut sim = start(&scene(vec![], vec![]), joints).unwrap();
    let mut qd = [0.0; JOINTS];
    qd[2] = 0.8;
    let mut fastest: f64 = 0.0;
    for _ in 0..150 {
        sim.step(&Command {
            qd,
            ..Command::default()
        });
        fastest = fastest.max(sim.state().qd[2]);
    }
    let left = std::f64::consts::PI - sim.state().joints[2];
    assert!((0.0..1e-3).contains(&left), "{left}");
    assert_eq!(fastest, 0.8);
    assert!(sim.tally().limit_violations > 0);
}

#[test]
fn ground_truth_of_the_closet() {
    let closet = Scene::builtin("closet").unwrap();
    let world = World::new(&closet);
    let truth = GroundTruth::new(&closet, &world, 0.15).unwrap();
    assert_eq!(truth.size(), [34, 28, 16]);
    // Walls are one voxel thick, and lie on voxel borders: no voxel beside them is filled.
    assert!(truth.is_solid([0, 14, 5]) && truth.is_reachable([1, 14, 5]));
    assert!(
        !truth.is_surface([0, 0, 5]),
        "a corner of two walls has no free neighbour"
    );
    assert!(truth.is_solid([31, 8, 3]), "inside the cabinet");
    assert!(!truth.is_surface([31, 8, 3]));
    assert!(truth.inspectable().all(|c| (1..16).contains(&c[2])));
    assert_eq!(
        (
            truth.explored_fraction(|_| true),
            truth.inspected_fraction(|_| false)
        ),
        (1.0, 0.0)
    );
    let half = truth.explored_fraction(|c| c[0] < 17);
    assert!((half - 0.5).abs() < 0.05, "{half}");
}

#[test]
fn ground_truth_refuses_bad_cells() {
    let closet = Scene::builtin("closet").unwrap();
    let world = World::new(&closet);
    assert_eq!(
        GroundTruth::new(&closet, &world, 0.0).unwrap_err(),
        GroundTruthError::CellSize(0.0)
    );
    assert!(matches!(
        GroundTruth::new(&closet, &world, 1e-4),
        Err(GroundTruthError::TooLarge(_))
    ));
}

#[test]
fn planning_time_is_charged_as_the_mode_says() {
    let cost = Cost {
        call: 0.01,
        operation: 1e-3,
    };
    assert!((cost.seconds(20) - 0.03).abs() < 1e-12);
    let mut counted = Account::new(Planning::Counted);
    assert_eq!(counted.charge(1.0, 0.5, 9.0), 1.5);
    assert_eq!(
        counted.charge(1.2, 0.5, 9.0),
        2.0,
        "after the work still under way"
    );
    assert!(counted.is_busy(1.9) && !counted.is_busy(2.0));
    assert_eq!(counted.charged(), 1.0);
    assert_eq!(
        Account::new(Planning::Measured).charge(1.0, 0.5, 0.25),
        1.25
    );
}

#[test]
fn stage_statistics_are_nearest_ranks() {
    let mut watch = Stopwatch::default();
    for i in (1..=100).rev() {
        watch.record(Stage::Mpc, 1e-3 * f64::from(i));
    }
    let s = watch.summary(Stage::Mpc);
    assert_eq!((s.count, s.median, s.p95, s.max), (100, 50.0, 95.0, 100.0));
    assert_eq!(watch.summary(Stage::Decision).count, 0);
    let (value, seconds) = watch.time(Stage::Decision, || 42);
    assert!(value == 42 && seconds >= 0.0 && watch.summary(Stage::Decision).count == 1);
}
