//! One control step of a nine-state integrator chain with input limits, 30 knots.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use ddp_rbf::nalgebra::{SMatrix, SVector};
use ddp_rbf::{Barrier, Constraint, InputBox, Mpc, Options, Robot, Tracking};

struct Joints;

impl Robot<9, 8> for Joints {
    fn flow(&self, x: &SVector<f64, 9>, u: &SVector<f64, 8>) -> SVector<f64, 9> {
        SVector::from_fn(|i, _| match i {
            0 => u[0] * x[2].cos(),
            1 => u[0] * x[2].sin(),
            i => u[i - 1],
        })
    }
    fn jacobians(
        &self,
        x: &SVector<f64, 9>,
        u: &SVector<f64, 8>,
    ) -> (SMatrix<f64, 9, 9>, SMatrix<f64, 9, 8>) {
        let (s, c) = x[2].sin_cos();
        let (mut a, mut b) = (SMatrix::zeros(), SMatrix::zeros());
        (a[(0, 2)], a[(1, 2)]) = (-u[0] * s, u[0] * c);
        (b[(0, 0)], b[(1, 0)]) = (c, s);
        for i in 2..9 {
            b[(i, i - 1)] = 1.0;
        }
        (a, b)
    }
}

fn bench(c: &mut Criterion) {
    let n = 30;
    let cost = Tracking::new(
        vec![SVector::from_element(0.5); n + 1],
        vec![SVector::zeros(); n],
        0.1,
        SVector::from_element(5.0),
        SVector::from_element(0.1),
        SVector::from_element(5.0),
    );
    let limits = InputBox::new(
        SVector::from_element(-0.8),
        SVector::from_element(0.8),
        Barrier::default(),
    );
    let constraints: [&dyn Constraint<9, 8>; 1] = [&limits];
    let options = Options {
        iterations: 3,
        ..Options::default()
    };
    let mut mpc = Mpc::new(n, 0.1).unwrap();
    c.bench_function("mpc step/9 states, 8 inputs, 30 knots, 3 iterations", |b| {
        b.iter(|| {
            mpc.reset();
            mpc.step(&Joints, &cost, &constraints, &SVector::zeros(), &options)
                .unwrap()
        });
    });
}

criterion_group!(benches, bench);
criterion_main!(benches);
