//! Plans of the 14-view instance and of a seeded 100-view task.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use objsearch::{CostModel, Params, Task, View, greedy, plan};

struct Plane;

fn at(view: usize) -> (f64, f64) {
    let h = (view as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (
        (h >> 40) as f64 / f64::from(1 << 24) * 20.0,
        ((h >> 16) & 0xff_ffff) as f64 / f64::from(1 << 24) * 15.0,
    )
}

impl CostModel for Plane {
    fn first(&self, view: usize) -> f64 {
        5.0 + at(view).0.hypot(at(view).1) / 0.3
    }
    fn between(&self, a: usize, b: usize) -> f64 {
        5.0 + (at(a).0 - at(b).0).hypot(at(a).1 - at(b).1) / 0.3
    }
}

fn hundred_views(c: &mut Criterion) {
    let views: Vec<View> = (0..100)
        .map(|v| View::new((0..30).map(|k| (v * 17 + k * k) % 1000)))
        .collect();
    let task = Task::new(&[0.002; 1000], &views, &Plane, 0.05).unwrap();
    c.bench_function("greedy/100 views", |b| b.iter(|| greedy(&task)));
    let params = Params {
        expansions: 2000,
        ..Params::default()
    };
    c.bench_function("branch and bound/100 views, 2000 nodes", |b| {
        b.iter(|| plan(&task, &params))
    });
}

criterion_group!(benches, hundred_views);
criterion_main!(benches);
