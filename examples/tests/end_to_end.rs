//! HEATS on the small embedded scene, whole, twice.
#![allow(missing_docs, clippy::unwrap_used)]

use seekplan::generate::Blueprint;
use seekplan::heats::{self, Planner, Sensors, Settings};
use seekplan::record::{Ended, RunResult};
use seekplan::scene::Scene;
use std::sync::atomic::{AtomicBool, Ordering};

fn run(settings: &Settings) -> RunResult {
    let scene = Scene::builtin("closet").unwrap();
    heats::run(&scene, settings, &AtomicBool::new(false), &mut |_| {})
        .unwrap()
        .result
}

#[test]
fn the_closet_is_searched_whole_and_the_same_way_twice() {
    let settings = Settings {
        seed: 1,
        ..Settings::default()
    };
    let result = run(&settings);
    assert_eq!(result.ended, Ended::Complete);
    assert_eq!(result.found, result.targets);
    assert_eq!(result.collisions, 0);
    assert_eq!(result.limit_violations, 0);
    assert!(result.min_clearance_m > 0.0);
    assert!(
        result.explored_fraction > 0.9,
        "{}",
        result.explored_fraction
    );

    let again = run(&settings);
    let text = |r: &RunResult| serde_json::to_string(&r.reproducible()).unwrap();
    assert_eq!(text(&result), text(&again));

    // Coverage never falls, and tags only add up.
    for pair in result.progress.windows(2) {
        assert!(pair[1].found >= pair[0].found);
        assert!(pair[1].time_s > pair[0].time_s);
    }
}

#[test]
fn the_closet_is_searched_with_the_camera_alone() {
    let settings = Settings {
        seed: 1,
        sensors: Sensors::Camera,
        ..Settings::default()
    };
    let result = run(&settings);
    assert_eq!(result.ended, Ended::Complete);
    assert_eq!(result.found, result.targets);
    assert_eq!((result.collisions, result.limit_violations), (0, 0));
}

/// Doors of 0.9 m are passed, and a room that nobody can enter keeps no search from its end. One of the targets lies on the bottom of
/// a bin that is one voxel wide inside, with one voxel unknown there: too small a frontier not to be looked at.
#[test]
fn a_building_with_narrow_doors_and_a_closed_room_is_searched_to_the_end() {
    let scene = Blueprint {
        size: [9.0, 7.0],
        tags: 4,
        closed_room: true,
        seed: 1,
        ..Blueprint::default()
    }
    .build()
    .unwrap();
    assert_eq!(scene.closed_areas.len(), 1);
    let settings = Settings {
        seed: 1,
        ..Settings::default()
    };
    let result = heats::run(&scene, &settings, &AtomicBool::new(false), &mut |_| {})
        .unwrap()
        .result;
    assert_eq!(result.ended, Ended::Complete);
    assert_eq!(result.found, 4, "given up: {:?}", result.given_up);
    assert!(result.explored_fraction > 0.99);
    assert_eq!((result.collisions, result.limit_violations), (0, 0));
    // What is inside the closed room is neither searched nor given up.
    let room = scene
        .rooms
        .iter()
        .find(|r| scene.closed_areas.contains(&r.name))
        .unwrap();
    for g in &result.given_up {
        let inside =
            (0..2).all(|k| room.min[k] + 0.1 < g.place[k] && g.place[k] < room.max[k] - 0.1);
        assert!(!inside, "{g:?}");
    }
}

/// A view that never shows what it promises is not gone to for ever.
#[test]
fn the_published_rules_come_to_an_end() {
    let settings = Settings {
        seed: 1,
        sensors: Sensors::Camera,
        ..Settings::of(Planner::Heats).unwrap()
    };
    let result = run(&settings);
    assert_eq!(result.ended, Ended::Complete);
    assert_eq!(result.found, result.targets);
    assert_eq!((result.collisions, result.limit_violations), (0, 0));
}

/// Without a LiDAR nothing is known of the ground beside the base, and in the open no wall is near that an image shows.
#[test]
fn the_camera_alone_sets_out_in_the_open() {
    for (scene, planner) in [
        ("office", Planner::Heats),
        ("maze", Planner::Heats),
        ("maze", Planner::HeatsPlus),
    ] {
        let settings = Settings {
            seed: 1,
            sensors: Sensors::Camera,
            time_limit: Some(45.0),
            ..Settings::of(planner).unwrap()
        };
        let name = format!("{scene} {}", planner.name());
        let scene = Scene::builtin(scene).unwrap();
        let result = heats::run(&scene, &settings, &AtomicBool::new(false), &mut |_| {})
            .unwrap()
            .result;
        assert_eq!(result.ended, Ended::TimeLimit, "{name}");
        assert_eq!(result.brakes, 0, "{name}");
        assert!(result.views_reached > 0, "{name}");
        assert_eq!((result.collisions, result.limit_violations), (0, 0));
    }
}

#[test]
fn one_thread_gives_the_same_result_as_two() {
    let settings = Settings {
        seed: 2,
        time_limit: Some(10.0),
        ..Settings::default()
    };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let result = pool.install(|| run(&settings));
        serde_json::to_string(&result.reproducible()).unwrap()
    };
    assert_eq!(with(1), with(2));
}

#[test]
fn an_interrupted_run_keeps_its_result() {
    let scene = Scene::builtin("closet").unwrap();
    let stop = AtomicBool::new(false);
    let settings = Settings {
        seed: 1,
        ..Settings::default()
    };
    let run = heats::run(&scene, &settings, &stop, &mut |status| {
        if status.time > 5.0 {
            stop.store(true, Ordering::Relaxed);
        }
    })
    .unwrap();
    assert_eq!(run.result.ended, Ended::Interrupted);
    assert!(run.result.search_time_s > 5.0);
    assert!(!run.trace.samples.is_empty());
}
