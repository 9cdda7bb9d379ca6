//! A campaign of the FLAP suite without its hours: one search, and results of all trials made from it.

use seekplan::bench::{self, Campaign, Report};
use seekplan::flap::{FlapSettings, PlannerKind, run};
use seekplan::scene::Scene;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Seeds of each experiment.
pub(crate) const SEEDS: usize = 2;

/// Leaves results of all trials in `out`, the expected time 1 s longer from trial to trial, and has the campaign report them.
pub(crate) fn campaign(out: &Path) -> Report {
    let settings = FlapSettings {
        planner: PlannerKind::Greedy,
        samples: 60,
        ..FlapSettings::default()
    };
    let scene = Scene::builtin("race").unwrap();
    let never = AtomicBool::new(false);
    let mut result = run(&scene, &settings, &never, &mut |_| ()).unwrap().result;
    let suite = bench::suite("flap-figure6", Some(SEEDS)).unwrap();
    std::fs::create_dir_all(out.join("trials")).unwrap();
    for (k, trial) in suite.trials().iter().enumerate() {
        result.expected_time_s = 100.0 + k as f64;
        result.wall.expected_planning_s = 0.0;
        let json = serde_json::to_string_pretty(&result).unwrap();
        std::fs::write(out.join(format!("trials/{}.json", trial.name)), json).unwrap();
    }
    let campaign = Campaign {
        jobs: 1,
        shard: (0, 1),
        resume: true,
        reports: false,
        out: out.to_owned(),
    };
    bench::run(suite.as_ref(), &campaign, &never, &|trial| {
        panic!("{trial} was run though its result is there")
    })
    .unwrap()
}
