//! The arm over a moving base: a gate that the arm must duck under, and the same without it.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use strrt::{Params, Variant, from_fn, plan, steps_needed};

/// Six joints; a stand-in for a body: the farthest point's height and reach of a planar chain of the three main joints.
fn height(q: &[f64; 6]) -> f64 {
    let (a, b) = (q[1], q[1] + q[2]);
    0.6 - 0.425 * a.sin() - 0.392 * b.sin() - 0.1 * (b + q[3]).sin()
}

fn gate(c: &mut Criterion) {
    let (start, goal) = (
        [0.3, -1.5, 0.4, 0.2, 1.0, 0.0],
        [-0.8, -1.2, 0.3, -0.5, 1.2, 1.0],
    );
    let steps = 80;
    assert!(steps_needed(&start, &goal, &[0.8; 6], 0.1) < steps);
    let gated = from_fn([(-3.1, 3.1); 6], [0.8; 6], |q: &[f64; 6], step| {
        !(30..45).contains(&step) || height(q) < 0.9
    });
    let open = from_fn([(-3.1, 3.1); 6], [0.8; 6], |q: &[f64; 6], _| {
        height(q) < 3.0
    });
    let mut group = c.benchmark_group("80 steps");
    group.bench_function("straight", |b| {
        b.iter(|| {
            plan(
                &open,
                black_box(start),
                goal,
                steps,
                0.1,
                &Params::default(),
                1,
            )
            .unwrap()
        });
    });
    for variant in [Variant::MultiStep, Variant::Bidirectional] {
        let params = Params {
            variant,
            ..Params::default()
        };
        group.bench_function(format!("gate, {variant:?}, 200 improvements"), |b| {
            b.iter(|| plan(&gated, black_box(start), goal, steps, 0.1, &params, 1).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, gate);
criterion_main!(benches);
