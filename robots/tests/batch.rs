//! The batched check against the scalar one in double precision.
#![allow(missing_docs, clippy::unwrap_used)]
mod common;

use common::Random;
use robots::{BatchBody, BodyState, GridField, InWorld, LANES, MobileManipulator, StateBlock};
use std::f64::consts::PI;

fn states(random: &mut Random, n: usize) -> Vec<BodyState> {
    (0..n)
        .map(|_| BodyState {
            base: [
                random.within(-30.0, 30.0),
                random.within(-20.0, 20.0),
                random.within(-7.0, 7.0),
            ],
            joints: random.joints(),
        })
        .collect()
}

#[test]
fn centres_agree_with_double_precision() {
    let (robot, mut random) = (MobileManipulator::default(), Random(1));
    let body = BatchBody::new(&robot);
    let mut worst = 0.0f64;
    for _ in 0..60 {
        let states = states(&mut random, LANES);
        let centers = body.spheres(&StateBlock::new(&states));
        for (l, state) in states.iter().enumerate() {
            for (c, s) in centers.iter().zip(robot.arm_spheres(state)) {
                for i in 0..3 {
                    worst = worst.max((f64::from(c[i][l]) - s.center[i]).abs());
                }
            }
        }
    }
    // Rounding of a position 30 m away takes up to 2e-6 of it.
    assert!(worst < 5e-6, "{worst}");
}

/// A table, a shelf and the floor as an exact distance.
fn distance(p: [f64; 3]) -> f64 {
    let boxes = [
        ([1.0, 0.5, 0.7], [0.6, 0.4, 0.03]),
        ([-0.9, 0.8, 1.0], [0.2, 0.7, 0.5]),
        ([0.3, -1.0, 1.3], [0.5, 0.2, 0.1]),
    ];
    let outside = |(c, h): &([f64; 3], [f64; 3])| {
        let o = [0, 1, 2].map(|i| ((p[i] - c[i]).abs() - h[i]).max(0.0));
        (o[0] * o[0] + o[1] * o[1] + o[2] * o[2]).sqrt()
    };
    boxes.iter().map(outside).fold(p[2], f64::min)
}

#[test]
fn answers_agree_with_the_scalar_check() {
    let (robot, mut random) = (MobileManipulator::default(), Random(2));
    let body = BatchBody::new(&robot);
    let field = |p: [f32; 3]| distance(p.map(f64::from)) as f32;
    let (mut free, mut blocked, mut near) = (0, 0, 0);
    for _ in 0..400 {
        let states: Vec<BodyState> = (0..LANES)
            .map(|_| BodyState {
                base: [
                    random.within(-0.5, 0.5),
                    random.within(-0.5, 0.5),
                    random.within(-PI, PI),
                ],
                joints: random.joints(),
            })
            .collect();
        let found = body.free(&StateBlock::new(&states), &field, 0.01);
        for (l, state) in states.iter().enumerate() {
            let scalar = |extra: f64| {
                let world = InWorld::new(
                    &robot,
                    [0.0; 6],
                    0.01 + extra,
                    |c, r| distance(c) >= r,
                    |_| true,
                );
                world.is_free(state)
            };
            // Never free where the scalar check is not.
            assert!(!found[l] || scalar(0.0), "{state:?}");
            if found[l] != scalar(0.0) {
                near += 1;
            }
            if found[l] { free += 1 } else { blocked += 1 }
        }
    }
    assert!(
        free > 300 && blocked > 300,
        "{free} free, {blocked} blocked"
    );
    assert!(near <= 2, "{near} of 6400 states refused for rounding");
}

#[test]
fn a_grid_with_slack_is_a_lower_bound() {
    let mut random = Random(3);
    let (cell, size, origin) = (0.1, [50, 40, 25], [-2.5, -2.0, -0.2]);
    let mut values = Vec::new();
    for z in 0..size[2] {
        for y in 0..size[1] {
            for x in 0..size[0] {
                let p = [x, y, z].map(|v| v as f64 * cell);
                values.push(distance([0, 1, 2].map(|i| origin[i] + p[i])) as f32);
            }
        }
    }
    let grid = GridField {
        origin,
        cell,
        size,
        values: &values,
        outside: 0.0,
        slack: 0.0871,
    };
    let (robot, body) = (
        MobileManipulator::default(),
        BatchBody::new(&MobileManipulator::default()),
    );
    let mut free = 0;
    for _ in 0..200 {
        let states: Vec<BodyState> = (0..LANES)
            .map(|_| BodyState {
                base: [
                    random.within(-0.3, 0.3),
                    random.within(-0.3, 0.3),
                    random.within(-PI, PI),
                ],
                joints: random.joints(),
            })
            .collect();
        let found = body.free(&StateBlock::new(&states), &grid, 0.0);
        for (l, state) in states.iter().enumerate() {
            let spheres = robot.arm_spheres(state);
            let clear = spheres.iter().all(|s| distance(s.center) >= s.radius);
            assert!(!found[l] || clear);
            free += usize::from(found[l]);
        }
    }
    assert!(free > 50, "{free}");
}

#[test]
fn states_that_are_not_finite_are_not_free() {
    let body = BatchBody::new(&MobileManipulator::default());
    let good = BodyState {
        base: [0.0; 3],
        joints: [0.0, -1.2, 1.0, -0.4, 1.3, 0.2],
    };
    let open = |_: [f32; 3]| 10.0f32;
    assert!(body.all_free(&[good; 20], &open, 0.0));
    for k in 0..9 {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut bad = good;
            if k < 3 {
                bad.base[k] = value
            } else {
                bad.joints[k - 3] = value
            }
            let found = body.free(&StateBlock::new(&[good, bad, good]), &open, 0.0);
            assert!(found[0] && !found[1] && found[2] && found[LANES - 1]);
        }
    }
    // Nothing asked, nothing wrong; a field that knows nothing is occupied.
    assert!(body.all_free(&[], &open, 0.0));
    assert!(!body.all_free(&[good], &|_: [f32; 3]| f32::NAN, 0.0));
}
