//! FLAP end to end on the embedded race scene, and what it refuses.
#![allow(missing_docs, clippy::unwrap_used)]

mod bench_support;

use seekplan::bench::{self, Campaign, Kept, Left, Order, Suite, Trial};
use seekplan::flap::{FlapError, FlapSettings, MapKind, PlannerKind, Site, ViewsKind, run, run_at};
use seekplan::scene::Scene;
use std::sync::atomic::{AtomicBool, Ordering};

fn settings(planner: PlannerKind) -> FlapSettings {
    FlapSettings {
        planner,
        samples: 60,
        budget_ms: 5.0,
        ..FlapSettings::default()
    }
}

fn never() -> AtomicBool {
    AtomicBool::new(false)
}

#[test]
fn the_race_world_is_searched_to_the_end_and_the_same_way_twice() {
    let scene = Scene::builtin("race").unwrap();
    let local = settings(PlannerKind::Local);
    let site = Site::new(&scene, &local).unwrap();
    let mut looks = 0;
    let outcome = run_at(&site, &local, &never(), &mut |_| looks += 1).unwrap();
    let result = &outcome.result;
    assert_eq!(result.ended, "complete", "{}", result.reason);
    assert_eq!(looks, result.sensing_actions);
    assert_eq!(outcome.poses.len(), looks);
    // The expected time is that of the steps (FLAP eq. 4 with what the looks gave).
    let mut before = 0.0;
    let mut expected = 0.0;
    for step in &result.steps {
        expected += (1.0 - step.probability_before) * (step.time_s - before);
        before = step.time_s;
        assert!(step.probability >= step.probability_before);
    }
    assert!((expected - result.expected_time_s).abs() < 1e-9);
    assert!(result.probability > 0.5 && result.expected_time_s < result.execution_time_s);
    // No view is taken twice.
    let mut views: Vec<usize> = result.steps.iter().map(|s| s.view).collect();
    views.sort_unstable();
    views.dedup();
    assert_eq!(views.len(), result.steps.len());
    let again = run(&scene, &local, &never(), &mut |_| ()).unwrap();
    assert_eq!(again.result.reproducible(), result.reproducible());
    // The first plan is no worse than greedy's.
    let greedy = settings(PlannerKind::Greedy);
    assert!(site.serves(&greedy));
    let plain = run_at(&site, &greedy, &never(), &mut |_| ()).unwrap();
    assert!(result.reachable_views < result.views);
    // With groups of views as published, no view is cut off from the others either.
    let grouped = FlapSettings {
        clusters: 20,
        offline: true,
        ..greedy.clone()
    };
    assert!(!site.serves(&grouped));
    let offline = run(&scene, &grouped, &never(), &mut |_| ()).unwrap().result;
    assert_eq!(offline.ended, "complete");
    assert_eq!(offline.sensing_actions, offline.first_plan_views);
    // The first plan shows all but the threshold of what can be seen.
    assert!(1.0 - offline.probability < (1.0 - plain.result.probability) / 0.95 + 1e-9);
    assert!(result.first_plan_time_s <= plain.result.first_plan_time_s + 1e-9);
    assert!(result.first_plan_bound_s <= result.first_plan_time_s);
    let other = FlapSettings {
        map: MapKind::Walls,
        ..greedy
    };
    assert!(!site.serves(&other));
}

#[test]
fn walls_alone_haze_missing_looks_and_fresh_views_end_too() {
    let scene = Scene::builtin("race").unwrap();
    let base = FlapSettings {
        samples: 40,
        map: MapKind::Walls,
        ..settings(PlannerKind::Local)
    };
    for changed in [
        base.clone(),
        FlapSettings {
            haze: 2.0,
            haze_elsewhere: 0.3,
            ..base.clone()
        },
        FlapSettings {
            views: ViewsKind::Fresh,
            look_limit: 4,
            ..base.clone()
        },
        FlapSettings {
            detection: 0.8,
            look_limit: 6,
            ..base.clone()
        },
        FlapSettings {
            offline: true,
            ..base.clone()
        },
    ] {
        let result = run(&scene, &changed, &never(), &mut |_| ()).unwrap().result;
        assert!(result.sensing_actions > 1, "{changed:?}");
        assert!(result.probability > 0.05 && result.probability < 1.0);
        assert!(result.ended == "complete" || result.sensing_actions == changed.look_limit);
    }
}

#[test]
fn stopped_searches_leave_a_result() {
    let scene = Scene::builtin("race").unwrap();
    let stop = never();
    let mut looks = 0;
    let outcome = run(&scene, &settings(PlannerKind::Greedy), &stop, &mut |_| {
        looks += 1;
        stop.store(looks >= 2, Ordering::Relaxed);
    })
    .unwrap();
    assert_eq!(outcome.result.ended, "interrupted");
    assert_eq!(outcome.result.sensing_actions, 2);
}

#[test]
fn bad_input_is_refused_by_name() {
    let scene = Scene::builtin("race").unwrap();
    let fails = |scene: &Scene, settings: &FlapSettings, word: &str| {
        let error = run(scene, settings, &never(), &mut |_| ()).unwrap_err();
        assert!(error.to_string().contains(word), "{error} lacks {word}");
    };
    let good = settings(PlannerKind::Greedy);
    fails(
        &scene,
        &FlapSettings {
            threshold: 1.0,
            ..good.clone()
        },
        "threshold",
    );
    fails(
        &scene,
        &FlapSettings {
            detection: 0.0,
            ..good.clone()
        },
        "detection",
    );
    fails(
        &scene,
        &FlapSettings {
            branch_limit: f64::NAN,
            ..good.clone()
        },
        "branch_limit",
    );
    fails(
        &scene,
        &FlapSettings {
            budget_ms: f64::INFINITY,
            ..good.clone()
        },
        "budget_ms",
    );
    let mut bare = scene.clone();
    bare.target_volumes.clear();
    fails(&bare, &good, "target_volumes");
    let mut certain = scene.clone();
    certain.target_volumes[0].p = 1.0;
    fails(&certain, &good, "volume probability");
    let mut outside = scene.clone();
    outside.target_volumes[0].max[0] = 99.0;
    let error = run(&outside, &good, &never(), &mut |_| ()).unwrap_err();
    assert!(matches!(
        error,
        FlapError::Search(objsearch::Error::OutsideMap { volume: 0, .. })
    ));
}

#[test]
fn no_samples_or_no_looks_end_at_once() {
    let scene = Scene::builtin("race").unwrap();
    let none = FlapSettings {
        samples: 0,
        ..settings(PlannerKind::Local)
    };
    let result = run(&scene, &none, &never(), &mut |_| ()).unwrap().result;
    assert_eq!(
        (result.ended.as_str(), result.sensing_actions),
        ("complete", 0)
    );
    let still = FlapSettings {
        look_limit: 0,
        ..settings(PlannerKind::Local)
    };
    let result = run(&scene, &still, &never(), &mut |_| ()).unwrap().result;
    assert_eq!(
        (result.ended.as_str(), result.sensing_actions),
        ("time_limit", 0)
    );
}

#[test]
fn settings_are_read_by_name() {
    let changed = FlapSettings::default()
        .with(["planner=iter_psi", "haze=2", "samples = 300", "map=walls"])
        .unwrap();
    assert_eq!(changed.planner, PlannerKind::IterPsi);
    assert_eq!(
        (changed.haze, changed.samples, changed.map),
        (2.0, 300, MapKind::Walls)
    );
    assert_eq!(
        FlapSettings::from_toml(&changed.to_toml()).unwrap(),
        changed
    );
    for (bad, word) in [
        ("planner=magic", "magic"),
        ("sample=3", "sample"),
        ("seed", "key=value"),
    ] {
        let error = FlapSettings::default().with([bad]).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

/// A suite of four trials in two groups, which counts what it runs.
struct Counting(std::sync::atomic::AtomicUsize);

impl Suite for Counting {
    fn trials(&self) -> Vec<Trial> {
        (0..4)
            .map(|t| Trial {
                name: format!("t{t}"),
                group: t / 2,
            })
            .collect()
    }
    fn run_group(
        &self,
        group: usize,
        order: Order<'_>,
        deliver: &mut dyn FnMut(usize, Left) -> bool,
    ) -> Result<(), String> {
        for trial in (2 * group..2 * group + 2).filter(|&t| (order.wanted)(t)) {
            self.0.fetch_add(1, Ordering::Relaxed);
            let left = Left {
                result: format!("{trial}"),
                report: order.reports.then(|| format!("<p>{trial}</p>")),
            };
            if !deliver(trial, left) {
                return Ok(());
            }
        }
        Ok(())
    }
    fn report(&self, kept: &[Kept]) -> Result<(String, Vec<(String, String)>), String> {
        let results: Vec<&str> = kept.iter().map(|k| k.result.as_str()).collect();
        Ok((
            results.join(","),
            vec![("sum.txt".into(), results.concat())],
        ))
    }
}

#[test]
fn campaigns_are_split_resumed_and_reported() {
    let out = std::env::temp_dir().join(format!("seekplan-campaign-{}", std::process::id()));
    let campaign = |shard, resume| Campaign {
        jobs: 2,
        shard,
        resume,
        reports: false,
        out: out.clone(),
    };
    let suite = Counting(std::sync::atomic::AtomicUsize::new(0));
    let ran = || suite.0.swap(0, Ordering::Relaxed);
    let first = bench::run(&suite, &campaign((0, 2), false), &never(), &|_| ()).unwrap();
    assert_eq!(ran(), 2);
    assert!(first.table.contains("2 of 4") && first.files.is_empty());
    let second = bench::run(&suite, &campaign((1, 2), true), &never(), &|_| ()).unwrap();
    assert_eq!((ran(), second.table.as_str()), (2, "0,1,2,3"));
    assert_eq!(std::fs::read_to_string(&second.files[0]).unwrap(), "0123");
    // A lost result is made again, alone; no half file is left behind.
    std::fs::remove_file(out.join("trials/t2.json")).unwrap();
    bench::run(&suite, &campaign((0, 1), true), &never(), &|_| ()).unwrap();
    assert_eq!(ran(), 1);
    bench::run(&suite, &campaign((0, 1), false), &never(), &|_| ()).unwrap();
    assert_eq!(ran(), 4);
    let names = std::fs::read_dir(out.join("trials")).unwrap();
    assert!(
        names
            .into_iter()
            .all(|n| n.unwrap().file_name().to_string_lossy().ends_with(".json"))
    );
    let stopped = bench::run(
        &suite,
        &campaign((0, 1), false),
        &AtomicBool::new(true),
        &|_| (),
    )
    .unwrap();
    assert!(stopped.interrupted && ran() == 0);
    std::fs::remove_dir_all(out).unwrap();
}

/// A trial that is to be watched leaves the page of its own search; one that is not leaves its result alone.
#[test]
fn a_trial_leaves_a_report_when_asked() {
    let suite = bench::suite("flap-figure6", Some(1)).unwrap();
    let leave = |reports| {
        let stop = never();
        let order = Order {
            stop: &stop,
            wanted: &|t| t == 0,
            reports,
        };
        let mut all = Vec::new();
        let mut deliver = |t, left: Left| {
            all.push((t, left));
            true
        };
        suite.run_group(0, order, &mut deliver).unwrap();
        assert_eq!((all.len(), all[0].0), (1, 0));
        all.remove(0).1
    };
    assert_eq!(leave(false).report, None);
    let left = leave(true);
    let page = left.report.unwrap();
    let (_, data) = page
        .split_once(r#"<script type="application/json" id="data">"#)
        .unwrap();
    let (data, _) = data.split_once("</script>").unwrap();
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    let result: serde_json::Value = serde_json::from_str(&left.result).unwrap();
    assert_eq!(data["result"], result);
    assert_eq!(data["begin"]["planner"], result["planner"]);
    let looks = data["looks"].as_array().unwrap().len();
    assert_eq!(looks as u64, result["sensing_actions"].as_u64().unwrap());
}

/// The page of a campaign: the table's figures, and each trial twice or more as a link to a file that is there.
#[test]
fn a_campaign_leaves_a_page_that_leads_to_every_trial() {
    let out = std::env::temp_dir().join(format!("seekplan-page-{}", std::process::id()));
    let report = bench_support::campaign(&out);
    let suite = bench::suite("flap-figure6", Some(bench_support::SEEDS)).unwrap();
    let names: Vec<_> = report
        .files
        .iter()
        .map(|f| f.file_name().unwrap())
        .collect();
    assert_eq!(
        names,
        ["table.md", "trials.csv", "figure6.svg", "report.html"]
    );
    let page = std::fs::read_to_string(&report.files[3]).unwrap();
    for trial in suite.trials() {
        // A mark and a cell for its time; one more mark for its ratio, which greedy has not.
        let file = format!("trials/{}.json", trial.name);
        let links = page.matches(&format!(r#"<a href="{file}""#)).count();
        let greedy = trial.name.contains(".greedy.");
        assert_eq!(links, if greedy { 2 } else { 3 }, "{file}");
        assert!(out.join(&file).is_file());
    }
    let written = std::fs::read_to_string(&report.files[0]).unwrap();
    let rows = written.lines().filter(|l| l.starts_with("| "));
    let cells = rows.filter(|l| !l.contains("---")).map(|line| {
        let cells = line.trim_matches(['|', ' ']).split(" | ");
        cells.map(str::to_owned).collect::<Vec<_>>()
    });
    for cells in cells {
        let tag = if cells[0] == "planner" { "th" } else { "td" };
        let row: String = cells
            .iter()
            .map(|c| format!("<{tag}>{c}</{tag}>"))
            .collect();
        assert!(page.contains(&row), "{row}");
    }
    // Greedy's trials of the first experiment take 100 s and 126 s (and what planning adds): the median lies between.
    assert!(page.contains(">median 113.0<"), "{page}");
    std::fs::remove_dir_all(out).unwrap();
}

#[test]
fn wrong_shards_and_suites_are_refused() {
    for bad in ["", "1", "0/2", "3/2", "a/2", "1/0", "-1/2"] {
        assert!(bench::parse_shard(Some(bad)).is_err(), "{bad}");
    }
    assert_eq!(bench::parse_shard(Some("2/3")).unwrap(), (1, 3));
    assert!(bench::suite("figure7", None).is_err());
    let suite = bench::suite("flap-figure6", Some(2)).unwrap();
    let trials = suite.trials();
    let mut names: Vec<&str> = trials.iter().map(|t| t.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), trials.len());
    // Groups stand together.
    assert!(trials.windows(2).all(|t| t[0].group <= t[1].group));
}
