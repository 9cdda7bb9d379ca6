//! What becomes of a search when something goes wrong: it hits nothing it could see, keeps what it found, and goes on.
#![allow(missing_docs, clippy::unwrap_used)]

use seekplan::heats::{self, HeatsError, Settings, SettingsError};
use seekplan::record::{Ended, RunResult};
use seekplan::scene::{BoxShape, Scene};
use seekplan::sim::{
    DepthCamera, DepthModel, Lidar, LidarModel, Noise, PointScan, TagCamera, World,
};
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

fn settings(seconds: f64, sets: &[&str]) -> Settings {
    let settings = Settings {
        seed: 1,
        time_limit: Some(seconds),
        ..Settings::default()
    };
    settings.with(sets.iter().copied()).unwrap()
}

fn run(seconds: f64, sets: &[&str]) -> RunResult {
    let scene = Scene::builtin("closet").unwrap();
    let settings = settings(seconds, sets);
    let stop = AtomicBool::new(false);
    let result = heats::run(&scene, &settings, &stop, &mut |_| {})
        .unwrap()
        .result;
    // What a reader of the result sees is what was asked for.
    let kept = Settings::from_toml(&result.settings).unwrap();
    assert_eq!(kept.fault, settings.fault);
    assert_eq!(kept.start, settings.start);
    assert_eq!((result.collisions, result.limit_violations), (0, 0));
    assert!(result.min_clearance_m > 0.0);
    for pair in result.progress.windows(2) {
        assert!(pair[1].found >= pair[0].found);
    }
    result
}

/// The same run with nothing wrong.
fn usual() -> &'static RunResult {
    static USUAL: OnceLock<RunResult> = OnceLock::new();
    USUAL.get_or_init(|| run(13.0, &[]))
}

/// What was found before a fault is what would have been found without it, and it is still there at the end.
fn keeps_what_was_found(result: &RunResult, before: f64) {
    let early = |r: &RunResult| {
        let found = r.targets_found.iter().filter(|t| t.time_s < before);
        found.cloned().collect::<Vec<_>>()
    };
    let wanted = early(usual());
    assert!(!wanted.is_empty(), "the first tag is in sight of the start");
    assert_eq!(early(result), wanted);
}

/// When something of that kind happened, s.
fn when(result: &RunResult, what: &str) -> f64 {
    let note = result.faults.iter().find(|n| n.what.contains(what));
    note.unwrap_or_else(|| panic!("{what:?} is not in {:?}", result.faults))
        .time_s
}

const DOOR: [&str; 4] = [
    "fault.door.time=5",
    "fault.door.center=[2.6, 2.1, 1.0]",
    "fault.door.half_extents=[0.05, 0.6, 1.0]",
    "fault.door.yaw=0.3",
];

#[test]
fn nothing_of_this_shows_where_nothing_goes_wrong() {
    let text = serde_json::to_string(usual()).unwrap();
    assert!(!text.contains("fault") && !text.contains("[start]"));
    assert_eq!(Settings::default().with([]), Ok(Settings::default()));
}

#[test]
fn a_door_that_closes_is_seen_and_not_hit() {
    let result = run(14.0, &DOOR);
    let closed = when(&result, "door closed");
    assert!((5.0..10.0).contains(&closed), "{closed}");
    keeps_what_was_found(&result, 5.0);
    assert!(result.base_path_m > 0.3, "{}", result.base_path_m);
}

#[test]
fn a_door_that_opens_again_is_gone() {
    let mut sets = DOOR.to_vec();
    sets.push("fault.door.until=6.5");
    let result = run(7.0, &sets);
    assert!(when(&result, "door opened") >= 6.5);
}

#[test]
fn a_person_in_the_way_is_not_hit() {
    let result = run(14.0, &["fault.person.time=4"]);
    let came = when(&result, "person stepped");
    assert!((4.0..12.0).contains(&came), "{came}");
    keeps_what_was_found(&result, 4.0);
}

#[test]
fn a_robot_whose_sensor_is_silent_stands_and_goes_on() {
    for sensor in ["lidar", "depth", "rgb", "all"] {
        let choice = format!("fault.silence.sensor={sensor}");
        // Set out in the middle of the first turn, which moves base and arm.
        let sets = [&choice, "fault.silence.time=2", "fault.silence.seconds=4"];
        let scene = Scene::builtin("closet").unwrap();
        let mut moved = Vec::new();
        let result = heats::run(
            &scene,
            &settings(9.0, &sets),
            &AtomicBool::new(false),
            &mut |status| {
                moved.push((
                    status.time,
                    status.activity == "standing: a sensor is silent",
                ))
            },
        )
        .unwrap();
        let (trace, result) = (result.trace, result.result);
        assert_eq!(result.collisions, 0);
        let stood = when(&result, "fell silent");
        assert!((2.0..2.5).contains(&stood), "{sensor}: {stood}");
        assert!((6.0..6.2).contains(&when(&result, "is back")), "{sensor}");
        // From the top turning speed of 0.9 rad/s at 2 rad/s2 it stands within half a second, and moves again later.
        let at = |t: f64| trace.samples.iter().find(|s| s.time >= t - 1e-9).unwrap();
        assert_eq!(at(3.0).base, at(6.0).base, "{sensor}");
        assert_eq!(at(3.0).camera, at(6.0).camera, "{sensor}");
        assert!(at(2.0).base != at(3.0).base && at(6.0).base != at(8.0).base);
        assert!(moved.contains(&(4.0, true)) && moved.contains(&(8.0, false)));
    }
    keeps_what_was_found(&run(4.0, &["fault.silence.time=2"]), 2.0);
}

#[test]
fn a_search_survives_a_wrong_pose() {
    let sets = ["fault.localisation.position=0.02"];
    let result = run(13.0, &sets);
    assert!(result.targets_found.iter().any(|t| t.id == 1));
    assert!(result.base_path_m > 0.3 && result.explored_fraction > 0.5);
    // The error changes the run: it is not the usual one.
    assert!(result.base_path_m != usual().base_path_m);
}

/// Taken for what they seem, noisy returns fill the space around the robot, which then stands and believes all seen after 9 s.
#[test]
fn noise_and_outliers_do_not_fill_the_room() {
    let result = run(12.0, &["map.range_noise=0.01", "fault.outliers=0.01"]);
    assert_eq!(result.ended, Ended::TimeLimit);
    assert!(result.given_up.is_empty(), "{:?}", result.given_up);
    assert!(result.base_path_m > 0.3, "{}", result.base_path_m);
    assert!(result.explored_fraction > 0.95);
    assert!(result.brakes <= 5, "{}", result.brakes);
}

#[test]
fn planning_that_runs_out_of_its_budget_is_tried_again() {
    for (stage, every) in [
        ("frontier", 1),
        ("decision", 1),
        ("base_path", 1),
        ("arm_path", 1),
        ("control", 1),
        ("base_path", 2),
    ] {
        let sets = [
            format!("fault.budget.stage={stage}"),
            format!("fault.budget.every={every}"),
            // Set in before the first decision, which follows the turn at the start after 8 s.
            "fault.budget.time=6".into(),
            "fault.budget.seconds=5".into(),
        ];
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        let result = run(14.0, &sets);
        let out = when(&result, "of its budget");
        assert!((6.0..11.0).contains(&out), "{stage}: {out}");
        keeps_what_was_found(&result, 6.0);
        // No place is blamed, and the robot drives once it is over.
        assert!(result.given_up.is_empty(), "{stage}: {:?}", result.given_up);
        assert!(result.base_path_m > 0.1, "{stage}: {}", result.base_path_m);
    }
}

#[test]
fn a_folded_arm_in_a_corner_unfolds() {
    let sets = [
        "start.base=[0.72, 0.72, 0.8]",
        "start.joints=[0.0, -2.6, 2.4, -1.4, -1.57, 0.0]",
    ];
    let result = run(20.0, &sets);
    assert!(result.base_path_m > 0.3 && result.joint_rotation_rad > 3.0);
    assert!(!result.targets_found.is_empty());
}

#[test]
fn all_faults_at_once_give_the_same_result_twice() {
    let mut sets = DOOR.to_vec();
    sets.extend([
        "fault.outliers=0.01",
        "map.range_noise=0.01",
        "fault.localisation.position=0.02",
        "fault.person.time=3",
        "fault.silence.time=7",
        "fault.silence.seconds=1",
        "fault.budget.stage=decision",
        "fault.budget.time=8",
        "fault.budget.every=2",
        "start.base=[1.4, 1.8, 0.3]",
    ]);
    let text = |r: &RunResult| serde_json::to_string(&r.reproducible()).unwrap();
    assert_eq!(text(&run(10.0, &sets)), text(&run(10.0, &sets)));
}

/// Points of a scan farther than `off` from all surfaces of the world.
fn strays(world: &World, scan: &PointScan, off: f64) -> usize {
    let far = |p: &&[f32; 3]| {
        let at = p.map(f64::from);
        let d = [0, 1, 2].map(|k| at[k] - scan.origin[k]);
        let range = d.iter().map(|v| v * v).sum::<f64>().sqrt();
        let unit = d.map(|v| v / range);
        let surface = world.cast(scan.origin, unit, 20.0).unwrap_or(20.0);
        (surface - range).abs() > off
    };
    scan.hits.iter().filter(far).count()
}

#[test]
fn outliers_are_drawn_and_all_but_a_few_are_dropped() {
    let scene = Scene::builtin("closet").unwrap();
    let world = World::new(&scene);
    let noise = |outliers| Noise {
        outliers,
        seed: 3,
        ..Noise::default()
    };
    let base = [1.5, 1.8, 0.0];
    let pose = (
        [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
        [1.5, 1.8, 1.2],
    );
    let scans = |outliers: f64| {
        let lidar = Lidar::new(LidarModel::default(), noise(outliers))
            .scan(&world, base)
            .clone();
        let depth = DepthCamera::new(DepthModel::default(), noise(outliers))
            .scan(&world, &pose)
            .clone();
        [lidar, depth]
    };
    for ((clean, wild), span) in scans(0.0).iter().zip(&scans(0.01)).zip([10.0, 4.0]) {
        let count = |s: &PointScan| (s.hits.len() + s.misses.len()) as f64;
        let lost = 1.0 - count(wild) / count(clean);
        // One in a hundred is an outlier; some rays beside one or at a corner go with it.
        assert!((0.008..0.05).contains(&lost), "{span}: {lost}");
        // At 10 m an outlier that lies 7 cm off its surface looks like it.
        let share = strays(&world, wild, 0.15) as f64 / count(clean);
        assert!(share < 0.0003, "{span}: {share}");
        assert_eq!(strays(&world, clean, 0.15), 0);
    }
}

#[test]
fn what_appears_is_seen_by_every_sensor() {
    let scene = Scene::builtin("closet").unwrap();
    let mut blocked = scene.clone();
    let person = BoxShape {
        name: "fault.person".into(),
        center: [3.0, 1.2, 0.855],
        half_extents: [0.25, 0.25, 0.85],
        yaw: Some(0.0),
        quat: None,
    };
    blocked
        .shapes
        .push(seekplan::scene::Shape::Box(person.clone()));
    let (open, shut) = (World::new(&scene), World::new(&blocked));
    assert!(open.is_vacant(&person) && !shut.is_vacant(&person));
    let at = |center| BoxShape {
        center,
        ..person.clone()
    };
    for inside in [[4.65, 1.2, 0.855], [3.0, 0.3, 0.855], [3.0, 1.2, 0.8]] {
        assert!(!open.is_vacant(&at(inside)), "{inside:?}");
    }
    // Tag 1 is on the side of the cabinet behind it.
    let tag = scene.tags.iter().find(|t| t.id == 1).unwrap();
    let eye = (
        [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
        [1.5, 1.2, 0.8],
    );
    let camera = TagCamera::new(4.0);
    assert!(camera.sees(&open, &eye, tag) && !camera.sees(&shut, &eye, tag));
}

#[test]
fn settings_that_make_no_sense_are_named() {
    let refused = |set: &[&str]| match Settings::default().with(set.iter().copied()) {
        Ok(settings) => settings.validate().unwrap_err(),
        Err(error) => error,
    };
    let ranges: [(&str, &[&str], &str); 19] = [
        ("fault.outliers", &["fault.outliers=nan"], "between 0 and 1"),
        (
            "fault.outliers",
            &["fault.outliers=-0.1"],
            "between 0 and 1",
        ),
        ("fault.outliers", &["fault.outliers=1.5"], "between 0 and 1"),
        (
            "fault.door.time",
            &[DOOR[1], DOOR[2], "fault.door.time=-1"],
            "zero or more",
        ),
        (
            "fault.door.until",
            &[DOOR[0], DOOR[1], DOOR[2], "fault.door.until=5"],
            "later",
        ),
        (
            "fault.door.center",
            &[DOOR[0], DOOR[2], "fault.door.center=[nan, 1, 1]"],
            "finite",
        ),
        (
            "fault.door.half_extents",
            &[DOOR[0], DOOR[1], "fault.door.half_extents=[0.1, 0, 1]"],
            "positive",
        ),
        (
            "fault.door.yaw",
            &[DOOR[0], DOOR[1], DOOR[2], "fault.door.yaw=inf"],
            "finite",
        ),
        (
            "fault.person.time",
            &["fault.person.time=nan"],
            "zero or more",
        ),
        (
            "fault.person.ahead",
            &["fault.person.time=1", "fault.person.ahead=-2"],
            "positive",
        ),
        (
            "fault.person.until",
            &["fault.person.time=1", "fault.person.until=nan"],
            "later",
        ),
        (
            "fault.silence.time",
            &["fault.silence.time=-3"],
            "zero or more",
        ),
        (
            "fault.silence.seconds",
            &["fault.silence.time=1", "fault.silence.seconds=0"],
            "positive",
        ),
        (
            "fault.localisation.position",
            &["fault.localisation.position=-0.02"],
            "zero or more",
        ),
        (
            "fault.localisation.heading",
            &["fault.localisation.heading=nan"],
            "zero or more",
        ),
        (
            "fault.localisation.correlation",
            &["fault.localisation.correlation=0"],
            "positive",
        ),
        (
            "fault.budget.time",
            &["fault.budget.stage=decision", "fault.budget.time=nan"],
            "zero or more",
        ),
        (
            "fault.budget.every",
            &[
                "fault.budget.stage=decision",
                "fault.budget.time=1",
                "fault.budget.every=0",
            ],
            "1 or more",
        ),
        (
            "start.joints",
            &["start.joints=[0, 0, nan, 0, 0, 0]"],
            "finite",
        ),
    ];
    for (name, sets, right) in ranges {
        match refused(sets) {
            SettingsError::Range { field, wanted, .. } => {
                assert_eq!(field, name);
                assert!(wanted.contains(right), "{name}: {wanted}");
            }
            other => panic!("{name}: {other}"),
        }
    }
    // Names that do not exist, and what is missing: the text names the field and what there is.
    let words: [(&[&str], [&str; 3]); 5] = [
        (
            &["fault.silence.time=1", "fault.silence.sensor=sonar"],
            ["sensor", "sonar", "`lidar`"],
        ),
        (
            &["fault.budget.time=1", "fault.budget.stage=coffee"],
            ["stage", "coffee", "`base_path`"],
        ),
        (
            &["fault.budget.time=1"],
            ["fault.budget", "missing field", "`stage`"],
        ),
        (&["fault.dor.time=1"], ["dor", "unknown field", "`door`"]),
        (
            &["fault.door.time=1"],
            ["fault.door", "missing field", "`center`"],
        ),
    ];
    for (sets, wanted) in words {
        match refused(sets) {
            SettingsError::Parse(text) => {
                for word in wanted {
                    assert!(text.contains(word), "{sets:?}: {word:?} is not in {text}");
                }
            }
            other => panic!("{sets:?}: {other}"),
        }
    }
    // A file says the same as assignments.
    let file = "[fault.silence]\ntime = 3.0\nsensor = \"depth\"";
    assert_eq!(
        Settings::from_toml(file),
        Settings::default().with(["fault.silence.time=3", "fault.silence.sensor=depth"])
    );
}

#[test]
fn a_start_that_is_none_is_refused() {
    let scene = Scene::builtin("closet").unwrap();
    let refused = |set| {
        heats::run(
            &scene,
            &settings(1.0, &[set]),
            &AtomicBool::new(false),
            &mut |_| {},
        )
        .unwrap_err()
    };
    assert!(matches!(
        refused("start.base=[0.3, 0.3, 0]"),
        HeatsError::Scene(_)
    ));
    assert!(matches!(
        refused("start.base=[9, 9, 0]"),
        HeatsError::Scene(_)
    ));
    assert!(matches!(
        refused("start.joints=[0, 0, 4, 0, 0, 0]"),
        HeatsError::Start(seekplan::sim::StartError::Joint { joint: 2, .. })
    ));
}
