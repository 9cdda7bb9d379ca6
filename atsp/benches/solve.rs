//! Instances of the sizes a robot meets: the shared exploration and TSPLIB files where they are, else seeded points.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

#[path = "../examples/support/mod.rs"]
#[allow(dead_code)]
mod support;

use std::time::Duration;

use atsp::{CostMatrix, FromFn, Params, Problem, Proof, Solver};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};

/// Seeded points in a 30 m x 20 m office; driving back over one's tracks costs a turn.
fn office(n: usize) -> CostMatrix {
    let at = |i: usize| {
        let h = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (
            (h >> 40) as f64 / f64::from(1 << 24) * 30.0,
            ((h >> 16) & 0xff_ffff) as f64 / f64::from(1 << 24) * 20.0,
        )
    };
    CostMatrix::copy_of(&FromFn::new(n, |a, b| {
        let ((ax, ay), (bx, by)) = (at(a), at(b));
        ((ax - bx).hypot(ay - by)) / 0.8 + if bx < ax { 1.5 } else { 0.0 }
    }))
    .unwrap()
}

/// Reads one of the shared instances, or says that it is not there.
fn shared(file: &str) -> Option<support::Instance> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../shared/data")
        .join(file);
    let read = support::read(&path);
    if let Err(message) = &read {
        println!("skipped: {message}");
    }
    read.ok()
}

/// What a robot asks for: a path through so many nodes, with counted effort and a solver that is kept.
fn open_paths(c: &mut Criterion) {
    let mut group = c.benchmark_group("open path");
    for n in [5, 12, 30, 100] {
        let costs = office(n);
        let params = Params {
            kicks: 500,
            ..Params::default()
        };
        let mut solver = Solver::new();
        group.bench_function(format!("{n} nodes"), |b| {
            b.iter(|| solver.solve(&costs, Problem::Open { start: 0 }, &params));
        });
    }
    group.finish();
}

/// Small sets to proved optimality; assignments that are tours; and everything before the first kick.
fn parts(c: &mut Criterion) {
    let mut group = c.benchmark_group("instance");
    for (file, kicks) in [
        ("atsp-explore/office-n010-s100.json", 2000),
        ("atsp-explore/regions-n012-s100.json", 2000),
        ("tsplib-atsp/rbg403.atsp", 2000),
        ("atsp-explore/free-n200-s100.json", 0),
        ("atsp-explore/free-n200-s100.json", 500),
        ("tsplib-atsp/kro124p.atsp", 500),
    ] {
        let Some(instance) = shared(file) else {
            continue;
        };
        let params = Params {
            kicks,
            ..Params::default()
        };
        let mut solver = Solver::new();
        group.bench_function(BenchmarkId::new(instance.name.clone(), kicks), |b| {
            b.iter(|| solver.solve(&instance.costs, instance.problem, &params));
        });
    }
    group.finish();
}

/// The stronger bound, beside the assignment's.
fn bounds(c: &mut Criterion) {
    let mut group = c.benchmark_group("bound of 100 nodes");
    let costs = office(100);
    for steps in [0, 100] {
        let params = Params {
            kicks: 0,
            proof: Proof::Effort { steps, branches: 0 },
            ..Params::default()
        };
        let mut solver = Solver::new();
        group.bench_function(format!("{steps} steps"), |b| {
            b.iter(|| solver.solve(&costs, Problem::Open { start: 0 }, &params));
        });
    }
    group.finish();
}

/// An order of yesterday of which nothing is left to find.
fn warm(c: &mut Criterion) {
    let costs = office(100);
    let mut solver = Solver::new();
    let problem = Problem::Open { start: 0 };
    let order = solver
        .solve(&costs, problem, &Params::default())
        .unwrap()
        .order;
    let params = Params {
        kicks: 0,
        ..Params::default()
    };
    c.bench_function("warm start of 100 nodes", |b| {
        b.iter(|| solver.solve_from(&costs, problem, &order, &params));
    });
}

criterion_group! {
    name = benches;
    // Half a minute in all.
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1));
    targets = open_paths, parts, bounds, warm
}
criterion_main!(benches);
