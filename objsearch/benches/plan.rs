//! Plans of the instances in `shared/data/flap-instances`, or of the 14-view one alone where that folder is absent.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stderr)]

#[path = "../examples/instances/instance.rs"]
#[allow(dead_code)]
mod instance;

use criterion::{Criterion, criterion_group, criterion_main};
use instance::Instance;
use objsearch::{BranchParams, Budget, LocalParams, branch_and_bound, greedy, local, lower_bound};

fn instances(c: &mut Criterion) {
    let folder = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../shared/data/flap-instances"
    );
    let mut files = vec![concat!(env!("CARGO_MANIFEST_DIR"), "/tests/synth-014.json").to_string()];
    // race-known: 129 views, 4769 classes, known map.
    files.extend(["race-known", "synth-200"].map(|name| format!("{folder}/{name}.json")));
    for file in files {
        let Ok(instance) = Instance::load(file.as_ref()) else {
            eprintln!("skipped: no {file}");
            continue;
        };
        let task = &instance.task;
        let mut group = c.benchmark_group(&instance.name);
        group.sample_size(20);
        group.bench_function("greedy", |b| b.iter(|| greedy(task)));
        group.bench_function("branch and bound", |b| {
            b.iter(|| branch_and_bound(task, &BranchParams::default(), &mut Budget::unlimited()))
        });
        let descent = LocalParams {
            perturbations: 0,
            branch_start: false,
            ..LocalParams::default()
        };
        group.bench_function("local, descent alone", |b| {
            b.iter(|| local(task, &descent, &[], &mut Budget::unlimited()))
        });
        group.bench_function("lower bound", |b| b.iter(|| lower_bound(task)));
        group.finish();
    }
}

criterion_group!(benches, instances);
criterion_main!(benches);
