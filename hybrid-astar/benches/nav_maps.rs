//! Plans on a real map against the yardstick D, a plain Dijkstra over the same map: first plan, replan, both goal yaws.
//!
//! Uses `../shared/data/nav-maps/nav2_depot`; where it is missing the bench says so and does nothing.
#![allow(
    missing_docs,
    dead_code,
    unreachable_pub,
    clippy::print_stderr,
    clippy::disallowed_methods,
    clippy::unwrap_used
)]

#[path = "../examples/nav_maps/judge.rs"]
mod judge;
#[path = "../examples/nav_maps/load.rs"]
mod load;

use criterion::{Criterion, criterion_group, criterion_main};
use hybrid_astar::{Field, Footprint, GoalYaw, GridParams, Limits, Map, Params, Planner};
use std::hint::black_box;
use std::path::Path;

fn depot(c: &mut Criterion) {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/nav-maps/nav2_depot.json");
    if !path.exists() {
        eprintln!("skipped: {} is missing", path.display());
        return;
    }
    let map = load::map(&path.with_extension("yaml")).unwrap();
    let queries = load::queries(&path).unwrap();
    // The first long query.
    let q = queries.list.iter().find(|q| q.class == "long").unwrap();
    let robot = Footprint::polygon(&queries.footprint);
    let params = Params {
        limits: Limits {
            v: queries.v,
            w: queries.w,
            a: f64::INFINITY,
            alpha: f64::INFINITY,
        },
        ..Params::default()
    };
    let goal = [q.goal[0], q.goal[1]];
    let mut group = c.benchmark_group("nav2_depot");
    let yardstick = judge::Yardstick::new(&map, |p| map.grid.clearance(p), 0.3);
    let cell = [0, 1].map(|k| ((q.goal[k] - map.low[k]) / 0.1) as usize);
    group.bench_function("D", |b| b.iter(|| yardstick.run(black_box(cell))));
    for (name, yaw) in [
        ("fixed", GoalYaw::Fixed(q.goal[2])),
        ("free", GoalYaw::Free),
    ] {
        let mut planner = Planner::new(params.clone()).unwrap();
        group.bench_function(format!("plan, {name} yaw"), |b| {
            b.iter(|| {
                planner.clear();
                planner.plan(&map.grid, &robot, q.start, goal, &yaw)
            });
        });
        group.bench_function(format!("replan, {name} yaw"), |b| {
            b.iter(|| planner.plan(&map.grid, &robot, q.start, goal, &yaw));
        });
    }
    group.bench_function("field of all distances at 0.1 m", |b| {
        let params = GridParams {
            cell_size: 0.1,
            ..GridParams::default()
        };
        b.iter(|| Field::from(&map.grid, 0.3, goal, &params));
    });
    group.finish();
}

criterion_group!(benches, depot);
criterion_main!(benches);
