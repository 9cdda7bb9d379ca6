//! A mobile manipulator of 12 spheres and 24 pairs in a room, 60 knots: the parts of an iteration, and control steps. Also one
//! backward pass of 36 states, which the feature `faer` makes faster.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use ddp_rbf::nalgebra::{SMatrix, SVector};
use ddp_rbf::{
    Barrier, BoxField, Chain, Constraint, DriveArm, Expansion, Field, GridField, Horizon, InputBox,
    Joint, Linear, LinkSphere, Mpc, Options, PairClearance, Robot, Solver, SphereClearance,
    StateBox, Tracking,
};
use std::f64::consts::{FRAC_PI_2, PI};
use std::hint::black_box;

type X = SVector<f64, 9>;
type U = SVector<f64, 8>;

const KNOTS: usize = 60;
const DT: f64 = 0.05;

/// A UR5e on a drive (figures of its data sheet), base first.
fn chain() -> Chain {
    let joint = |d, a, alpha| Joint { d, a, alpha };
    let sphere = |link, center, radius| LinkSphere {
        link,
        center,
        radius,
    };
    Chain::new(
        true,
        [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]],
        [0.1, 0.0, 0.55],
        vec![
            joint(0.1625, 0.0, FRAC_PI_2),
            joint(0.0, -0.425, 0.0),
            joint(0.0, -0.3922, 0.0),
            joint(0.1333, 0.0, FRAC_PI_2),
            joint(0.0997, 0.0, -FRAC_PI_2),
            joint(0.0996, 0.0, 0.0),
        ],
        vec![
            sphere(0, [0.16, 0.0, 0.28], 0.32),
            sphere(0, [-0.16, 0.0, 0.28], 0.32),
            sphere(0, [0.1, 0.0, 0.65], 0.1),
            sphere(2, [0.29, 0.0, 0.13], 0.09),
            sphere(2, [0.145, 0.0, 0.13], 0.09),
            sphere(2, [0.0, 0.0, 0.09], 0.09),
            sphere(3, [0.26, 0.0, 0.01], 0.08),
            sphere(3, [0.13, 0.0, 0.01], 0.08),
            sphere(3, [0.0, 0.0, 0.06], 0.075),
            sphere(4, [0.0, 0.0, 0.0], 0.07),
            sphere(5, [0.0, 0.0, 0.0], 0.07),
            sphere(6, [0.0, 0.0, 0.05], 0.07),
        ],
    )
    .unwrap()
}

/// Four walls, two tables, a cupboard and a lamp.
fn room() -> Vec<[f64; 6]> {
    vec![
        [3.0, 0.0, 1.25, 0.1, 3.0, 1.25],
        [-3.0, 0.0, 1.25, 0.1, 3.0, 1.25],
        [0.0, 3.0, 1.25, 3.0, 0.1, 1.25],
        [0.0, -3.0, 1.25, 3.0, 0.1, 1.25],
        [0.6, 1.2, 0.72, 0.6, 0.4, 0.03],
        [-1.2, -1.3, 0.72, 0.5, 0.4, 0.03],
        [2.5, -1.0, 0.9, 0.3, 0.5, 0.9],
        [0.9, -0.9, 0.8, 0.1, 0.1, 0.8],
    ]
}

/// The room in voxels of 5 cm.
fn voxels(boxes: &BoxField) -> GridField {
    let (low, cell, size) = ([-3.2, -3.2, -0.2], 0.05, [129, 129, 60]);
    let mut distances = Vec::with_capacity(size.iter().product());
    for z in 0..size[2] {
        for y in 0..size[1] {
            for x in 0..size[0] {
                let at = [x, y, z];
                let point = [0, 1, 2].map(|a| low[a] + at[a] as f64 * cell);
                distances.push(boxes.exact(point) as f32);
            }
        }
    }
    GridField::new(low, cell, size, distances).unwrap()
}

/// Across the room between the tables, the arm turning.
fn reference(n: usize) -> Tracking<9, 8> {
    let states: Vec<X> = (0..=n)
        .map(|k| {
            let t = k as f64 * DT;
            X::from_column_slice(&[
                -1.5 + 0.6 * t,
                0.1,
                0.0,
                0.3 * t,
                -1.2 - 0.1 * t,
                1.4,
                -1.6 + 0.1 * t,
                -1.5,
                0.2 * t,
            ])
        })
        .collect();
    let input = U::from_column_slice(&[0.6, 0.0, 0.3, -0.1, 0.0, 0.1, 0.0, 0.2]);
    Tracking::new(
        states,
        vec![input; n],
        DT,
        X::from_column_slice(&[20.0, 20.0, 10.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0]),
        U::from_column_slice(&[0.5, 0.3, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1]),
        X::from_column_slice(&[20.0, 20.0, 10.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0]),
    )
}

fn bench(c: &mut Criterion) {
    let chain = chain();
    let boxes = BoxField::new(room(), None, 50.0).unwrap();
    let grid = voxels(&boxes);
    let mut pairs: Vec<(usize, usize)> = [0, 1]
        .iter()
        .flat_map(|&b| (5..12).map(move |i| (b, i)))
        .collect();
    pairs.extend((7..12).map(|i| (2, i)));
    pairs.extend([(3, 9), (3, 10), (3, 11), (4, 10), (4, 11)]);
    let barrier = Barrier::default();
    let top = U::from_column_slice(&[0.8, 1.5, 0.8, 0.8, 0.8, 0.8, 0.8, 0.8]);
    let inputs = InputBox::new(-top, top, barrier);
    let joints = StateBox {
        limits: (3..9).map(|i| (i, -2.0 * PI, 2.0 * PI)).collect(),
        barrier,
    };
    let spheres = [0, 1, 3, 4, 5, 6, 7, 8, 9, 10, 11];
    let own = PairClearance {
        chain: &chain,
        pairs: &pairs,
        margin: 0.01,
        barrier,
        name: "own",
    };
    fn clearance<'a, F: Field>(
        chain: &'a Chain,
        field: &'a F,
        spheres: &'a [usize],
    ) -> SphereClearance<'a, F> {
        SphereClearance {
            chain,
            field,
            spheres,
            margin: 0.02,
            on_base: false,
            barrier: Barrier::default(),
            name: "room",
        }
    }
    let (by_boxes, by_grid) = (
        clearance(&chain, &boxes, &spheres),
        clearance(&chain, &grid, &spheres),
    );
    let cost = reference(KNOTS);
    let x0 = cost.states[0];

    let mut group = c.benchmark_group("models of 60 knots");
    let along = Horizon {
        states: &cost.states,
        inputs: &cost.inputs,
        weight: DT,
    };
    let mut models = vec![Expansion::<9, 8>::zeros(); KNOTS + 1];
    let parts: [(&str, &dyn Constraint<9, 8>); 5] = [
        ("16 input limits", &inputs),
        ("12 joint limits", &joints),
        ("11 spheres to 8 boxes", &by_boxes),
        ("11 spheres to voxels", &by_grid),
        ("24 pairs", &own),
    ];
    for (name, part) in parts {
        group.bench_function(name, |b| {
            b.iter(|| part.penalize(&along, Some(&mut models)))
        });
        group.bench_function(format!("{name}, values only"), |b| {
            b.iter(|| part.penalize(black_box(&along), None))
        });
    }
    let mut linear = vec![
        Linear {
            a: SMatrix::zeros(),
            b: SMatrix::zeros()
        };
        KNOTS
    ];
    group.bench_function("dynamics", |b| {
        b.iter(|| DriveArm.linearize_all(&cost.states[..KNOTS], &cost.inputs, DT, &mut linear));
    });
    group.finish();

    let with_grid: [&dyn Constraint<9, 8>; 4] = [&inputs, &joints, &by_grid, &own];
    let with_boxes: [&dyn Constraint<9, 8>; 4] = [&inputs, &joints, &by_boxes, &own];
    let mut group = c.benchmark_group("whole body");
    for (name, all) in [("boxes", with_boxes), ("voxels", with_grid)] {
        let mut solver = Solver::new(KNOTS, DT).unwrap();
        let options = Options {
            iterations: 1,
            tolerance: 1e-14,
            ..Options::default()
        };
        group.bench_function(format!("first iteration, {name}"), |b| {
            b.iter(|| {
                solver.set_guess(&cost.states, &cost.inputs).unwrap();
                solver.solve(&DriveArm, &cost, &all, &x0, &options).unwrap()
            });
        });
    }
    let mut mpc = Mpc::new(KNOTS, DT).unwrap();
    group.bench_function("warm control step, voxels", |b| {
        mpc.reset();
        mpc.step(&DriveArm, &cost, &with_grid, &x0, &Options::default())
            .unwrap();
        b.iter(|| {
            mpc.shift(DT);
            mpc.step(&DriveArm, &cost, &with_grid, &x0, &Options::real_time())
                .unwrap()
        });
    });
    group.bench_function("preparation, voxels", |b| {
        b.iter(|| mpc.prepare(&DriveArm, &cost, &with_grid).unwrap())
    });
    group.bench_function("reaction", |b| b.iter(|| mpc.react(black_box(&x0))));
    group.finish();
}

/// Coupled masses: 18 positions and speeds, pushed at 18 places.
struct Masses;

impl Robot<36, 18> for Masses {
    fn flow(&self, x: &SVector<f64, 36>, u: &SVector<f64, 18>) -> SVector<f64, 36> {
        SVector::from_fn(|i, _| {
            let left = |k: usize| if k > 0 { x[k - 1] } else { 0.0 };
            let right = |k: usize| if k < 17 { x[k + 1] } else { 0.0 };
            match i.checked_sub(18) {
                None => x[i + 18],
                Some(k) => left(k) - 2.0 * x[k] + right(k) + u[k],
            }
        })
    }
    fn jacobians(
        &self,
        _: &SVector<f64, 36>,
        _: &SVector<f64, 18>,
    ) -> (SMatrix<f64, 36, 36>, SMatrix<f64, 36, 18>) {
        let a = SMatrix::from_fn(|i, j| match i.checked_sub(18) {
            None => f64::from(u8::from(j == i + 18)),
            Some(k) if j == k => -2.0,
            Some(k) => f64::from(u8::from(j < 18 && j.abs_diff(k) == 1)),
        });
        (a, SMatrix::from_fn(|i, j| f64::from(u8::from(i == j + 18))))
    }
    // Euler's rule, so that the backward pass is most of the time.
    fn step(&self, x: &SVector<f64, 36>, u: &SVector<f64, 18>, dt: f64) -> SVector<f64, 36> {
        x + self.flow(x, u) * dt
    }
    fn linearize(
        &self,
        x: &SVector<f64, 36>,
        u: &SVector<f64, 18>,
        dt: f64,
    ) -> (SMatrix<f64, 36, 36>, SMatrix<f64, 36, 18>) {
        let (a, b) = self.jacobians(x, u);
        (SMatrix::identity() + a * dt, b * dt)
    }
}

fn large(c: &mut Criterion) {
    let n = 20;
    let cost = Tracking::new(
        vec![SVector::<f64, 36>::from_element(0.1); n + 1],
        vec![SVector::<f64, 18>::zeros(); n],
        0.1,
        SVector::from_element(1.0),
        SVector::from_element(0.1),
        SVector::from_element(1.0),
    );
    let none: [&dyn Constraint<36, 18>; 0] = [];
    let mut solver = Solver::new(n, 0.1).unwrap();
    let name = if cfg!(feature = "faer") {
        "preparation, 36 states, faer"
    } else {
        "preparation, 36 states"
    };
    c.bench_function(name, |b| {
        b.iter(|| solver.prepare(&Masses, &cost, &none).unwrap())
    });
}

criterion_group!(benches, bench, large);
criterion_main!(benches);
