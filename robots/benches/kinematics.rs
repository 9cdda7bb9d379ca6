//! Kinematics on fixed random joint vectors: FK, FK with 25 spheres, closed-form IK, self-clearance.
#![allow(missing_docs)]

use criterion::{Criterion, criterion_group, criterion_main};
use robots::{BatchBody, BodyState, Frame, IkSolutions, LANES, MobileManipulator, StateBlock};
use std::f64::consts::{PI, TAU};
use std::hint::black_box;

fn kinematics(c: &mut Criterion) {
    let robot = MobileManipulator::default();
    // 64 joint vectors of a low-discrepancy sequence over (-pi, pi)^6.
    let states: Vec<BodyState> = (1..65)
        .map(|i| {
            let joints = [0.8566, 0.7338, 0.6286, 0.5385, 0.4613, 0.3952]
                .map(|a| (f64::from(i) * a).fract() * TAU - PI);
            BodyState {
                base: [f64::from(i) * 0.1, 1.0, f64::from(i) * 0.05],
                joints,
            }
        })
        .collect();
    let targets: Vec<Frame> = states
        .iter()
        .map(|s| robot.arm.chain(&Frame::IDENTITY, &s.joints)[6])
        .collect();
    let mut i = 0;
    let mut next = move || {
        i = (i + 1) % 64;
        i
    };
    let mut group = c.benchmark_group("ur5e");
    group.bench_function("fk", |b| {
        b.iter(|| robot.arm.fk(black_box(&states[next()].joints)))
    });
    group.bench_function("fk_25_spheres", |b| {
        b.iter(|| robot.arm_spheres(black_box(&states[next()])))
    });
    group.bench_function("sphere_jacobians", |b| {
        b.iter(|| robot.sphere_jacobians(black_box(&states[next()])))
    });
    group.bench_function("self_clearance", |b| {
        b.iter(|| robot.self_clearance(black_box(&states[next()].joints)))
    });
    group.bench_function("self_is_free", |b| {
        b.iter(|| robot.self_is_free(black_box(&states[next()].joints), 0.005))
    });
    let mut out = IkSolutions::default();
    group.bench_function("ik_all_branches", |b| {
        b.iter(|| {
            robot
                .arm
                .ik_near(black_box(&targets[next()]), 0.0, &mut out);
            out.len()
        });
    });
    group.bench_function("compensate_yaw", |b| {
        b.iter(|| {
            let s = &states[next()];
            robot.compensate_yaw(
                black_box(s),
                [s.base[0], s.base[1], s.base[2] + 0.3],
                &s.joints,
            )
        });
    });
    group.finish();

    let body = BatchBody::new(&robot);
    let blocks: Vec<StateBlock> = states.chunks(LANES).map(StateBlock::new).collect();
    let mut group = c.benchmark_group("sixteen states");
    group.throughput(criterion::Throughput::Elements(LANES as u64));
    let mut k = 0;
    let mut block = move || {
        k = (k + 1) % 4;
        k
    };
    group.bench_function("fk_25_spheres", |b| {
        b.iter(|| body.spheres(black_box(&blocks[block()])))
    });
    group.bench_function("whole_check_without_obstacles", |b| {
        b.iter(|| body.free(black_box(&blocks[block()]), &|_: [f32; 3]| 10.0f32, 0.01))
    });
    group.finish();
}

criterion_group!(benches, kinematics);
criterion_main!(benches);
