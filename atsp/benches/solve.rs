//! Tours of the sizes a robot meets.
#![allow(missing_docs, clippy::unwrap_used)]

use atsp::{CostMatrix, FromFn, Params, Problem, solve};
use criterion::{Criterion, criterion_group, criterion_main};

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

fn open_paths(c: &mut Criterion) {
    let mut group = c.benchmark_group("open path");
    for n in [5, 12, 30, 100] {
        let costs = office(n);
        let params = Params {
            kicks: 500,
            ..Params::default()
        };
        group.bench_function(format!("{n} nodes"), |b| {
            b.iter(|| solve(&costs, Problem::Open { start: 0 }, &params));
        });
    }
    group.finish();
}

criterion_group!(benches, open_paths);
criterion_main!(benches);
