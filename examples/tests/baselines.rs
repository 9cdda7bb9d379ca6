//! AEP and WG-NBVP on the small embedded scene: they search, never collide, end as they should, and do so the same way twice.
#![allow(missing_docs, clippy::unwrap_used)]

use seekplan::baselines::{Baseline, BaselineSettings, run, run_recorded};
use seekplan::record::{Ended, Event, Memory, RunResult};
use seekplan::scene::Scene;
use std::sync::atomic::{AtomicBool, Ordering};

fn settings(planner: Baseline, time_limit: f64) -> BaselineSettings {
    BaselineSettings {
        time_limit: Some(time_limit),
        ..BaselineSettings::of(planner)
    }
}

fn text(result: &RunResult) -> String {
    serde_json::to_string(&result.reproducible()).unwrap()
}

#[test]
fn the_closet_is_explored_without_a_touch() {
    let scene = Scene::builtin("closet").unwrap();
    for planner in Baseline::ALL {
        let never = AtomicBool::new(false);
        let run = run(&scene, &settings(planner, 60.0), &never, &mut |_| {}).unwrap();
        let result = run.result;
        assert_eq!(
            (result.planner.as_str(), result.sensors.as_str()),
            (planner.name(), "camera")
        );
        assert_eq!((result.collisions, result.limit_violations), (0, 0));
        assert!(result.min_clearance_m > 0.0);
        assert!(
            result.explored_fraction > 0.9,
            "{planner:?} {}",
            result.explored_fraction
        );
        assert!(result.found >= 1 && result.views_reached > 3, "{planner:?}");
        // The settings in a result repeat it.
        let again = BaselineSettings::from_toml(&result.settings).unwrap();
        assert_eq!(again, settings(planner, 60.0));
    }
}

#[test]
fn one_thread_or_two_and_a_recorder_change_nothing() {
    let scene = Scene::builtin("closet").unwrap();
    for planner in Baseline::ALL {
        let settings = settings(planner, 25.0);
        let never = AtomicBool::new(false);
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| text(&run(&scene, &settings, &never, &mut |_| {}).unwrap().result))
        };
        let one = with(1);
        assert_eq!(one, with(2));
        let mut memory = Memory::default();
        let recorded = run_recorded(&scene, &settings, &never, &mut |_| {}, &mut memory).unwrap();
        assert_eq!(one, text(&recorded.result));
        let begin = match &memory.entries[0].1 {
            Event::Begin(begin) => begin.planner.clone(),
            other => panic!("{other:?}"),
        };
        assert_eq!(begin, planner.name());
        let decided = |e: &Event| matches!(e, Event::Decision(d) if d.outcome == "go");
        assert!(memory.entries.iter().any(|e| decided(&e.1)));
    }
}

#[test]
fn an_interrupted_run_keeps_its_result() {
    let scene = Scene::builtin("closet").unwrap();
    for planner in Baseline::ALL {
        let stop = AtomicBool::new(false);
        let mut progress = |status: &seekplan::report::Status<'_>| {
            stop.store(status.time >= 3.0, Ordering::Relaxed);
        };
        let run = run(&scene, &settings(planner, 60.0), &stop, &mut progress).unwrap();
        assert_eq!(run.result.ended, Ended::Interrupted);
        assert!(run.result.search_time_s < 3.5 && !run.result.progress.is_empty());
    }
}
