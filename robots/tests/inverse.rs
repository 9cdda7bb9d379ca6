//! Closed-form inverse kinematics: nothing lost, everything closes.

mod common;

use common::Random;
use proptest::prelude::*;
use robots::{Frame, IkSolutions, Ur5e};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn turn(a: f64, b: f64) -> f64 {
    let d = (a - b).rem_euclid(TAU);
    d.min(TAU - d)
}

fn same(a: &[f64; 6], b: &[f64; 6], tolerance: f64) -> bool {
    (0..6).all(|j| turn(a[j], b[j]) <= tolerance)
}

fn frame(arm: &Ur5e, q: &[f64; 6]) -> Frame {
    arm.chain(&Frame::IDENTITY, q)[6]
}

/// Every solution reaches the pose.
fn worst_closure(arm: &Ur5e, target: &Frame, found: &IkSolutions) -> f64 {
    let errors = found.as_slice().iter().map(|s| {
        assert!(
            s.joints.iter().all(|v| v.is_finite() && v.abs() <= PI),
            "{s:?}"
        );
        let (p, r) = frame(arm, &s.joints).error_to(target);
        p.max(r)
    });
    errors.fold(0.0, f64::max)
}

#[test]
fn random_branches_come_back() {
    let arm = Ur5e::default();
    let (mut random, mut out) = (Random(1), IkSolutions::default());
    let (mut count, mut worst) = (0usize, 0.0f64);
    let n = 40_000;
    for _ in 0..n {
        let q = random.joints();
        // Distance from the shoulder's singular set: of the wrist centre from the pan axis in the arm's plane.
        let frames = arm.chain(&Frame::IDENTITY, &q);
        let ahead = frames[5].p[0].hypot(frames[5].p[1]) - arm.d4;
        if q[4].sin().abs() < 1e-4 || q[2].sin().abs() < 1e-4 || ahead < 1e-7 {
            continue;
        }
        arm.ik(&arm.fk(&q), &mut out);
        assert!(
            out.as_slice().iter().any(|s| same(&s.joints, &q, 1e-6)),
            "{q:?} lost: {out:?}"
        );
        assert!(out.as_slice().windows(2).all(|w| w[0].branch < w[1].branch));
        count += out.len();
        worst = worst.max(worst_closure(&arm, &frames[6], &out));
    }
    println!(
        "{:.2} solutions each, closure {worst:.1e}",
        count as f64 / f64::from(n)
    );
    assert!(worst < 1e-9, "{worst:e}");
    assert!(count > 6 * n as usize);
}

/// Joint vectors on each singular set and on their intersections, and close to them.
fn singular_joints(arm: &Ur5e, random: &mut Random, kind: usize, near: f64) -> [f64; 6] {
    let mut q = random.joints();
    let mut jitter = || near * (2.0 * random.unit() - 1.0);
    if kind & 1 != 0 {
        q[4] = [0.0, PI, -PI][kind % 3] + jitter();
    }
    if kind & 2 != 0 {
        q[2] = [0.0, PI][(kind / 8) % 2] + jitter();
    }
    if kind & 4 != 0 {
        // Put the wrist centre over the pan axis: solve a2 c2 + a3 c23 + d5 s234 = 0 for q2 by turning the rest.
        let x = arm.a2 + arm.a3 * q[2].cos() + arm.d5 * (q[2] + q[3]).sin();
        let y = arm.a3 * q[2].sin() - arm.d5 * (q[2] + q[3]).cos();
        q[1] = FRAC_PI_2 - y.atan2(x) + jitter();
    }
    q
}

#[test]
fn singular_sets_keep_a_solution() {
    let arm = Ur5e::default();
    let (mut random, mut out) = (Random(2), IkSolutions::default());
    for near in [0.0, 1e-15, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5] {
        let mut worst = 0.0f64;
        for i in 0..6000 {
            let kind = 1 + i % 15;
            let kind = if kind & 7 == 0 { 7 } else { kind };
            let q = singular_joints(&arm, &mut random, kind, near);
            let target = frame(&arm, &q);
            for wrist3 in [0.0, q[5], -2.5] {
                arm.ik_near(&target, wrist3, &mut out);
                assert!(
                    !out.is_empty(),
                    "near {near:e} kind {kind}: {q:?} has no solution with q6 = {wrist3}"
                );
                worst = worst.max(worst_closure(&arm, &target, &out));
                if near < 1e-8 {
                    let flags = out.as_slice().iter().map(|s| s.singular);
                    assert!(
                        flags.clone().any(|f| f.any()),
                        "near {near:e} kind {kind}: {q:?} not flagged: {out:?}"
                    );
                    if kind & 7 == 1 {
                        assert!(flags.clone().any(|f| f.wrist));
                    }
                    if kind & 7 == 2 {
                        assert!(flags.clone().any(|f| f.elbow));
                    }
                    if kind & 7 == 4 {
                        assert!(flags.clone().any(|f| f.shoulder));
                    }
                }
            }
            if near == 0.0 && kind & 7 == 1 {
                arm.ik_near(&target, q[5], &mut out);
                assert!(
                    out.as_slice().iter().any(|s| same(&s.joints, &q, 1e-6)),
                    "{q:?} lost: {out:?}"
                );
            }
        }
        println!("near {near:e}: closure {worst:.1e}");
        assert!(worst < 3e-7, "{worst:e}");
    }
}

#[test]
fn axis_aligned_poses_are_solved() {
    // The attitudes at which generated solvers are known to fail.
    let arm = Ur5e::default();
    let mut out = IkSolutions::default();
    let axes = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [-1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, -1.0],
    ];
    let mut solved = 0;
    for x in axes {
        for y in axes {
            let z = [
                x[1] * y[2] - x[2] * y[1],
                x[2] * y[0] - x[0] * y[2],
                x[0] * y[1] - x[1] * y[0],
            ];
            if z == [0.0; 3] {
                continue;
            }
            for p in [
                [0.4, 0.2, 0.3],
                [0.0, 0.4, 0.4],
                [0.3, 0.0, 0.5],
                [-0.3, -0.3, 0.2],
            ] {
                let target = Frame { x, y, z, p };
                arm.ik_near(&target, 0.0, &mut out);
                assert!(!out.is_empty(), "{target:?}");
                assert!(worst_closure(&arm, &target, &out) < 1e-9);
                solved += 1;
            }
        }
    }
    assert_eq!(solved, 96);
}

#[test]
fn bad_targets_have_no_solution() {
    let arm = Ur5e::default();
    let mut out = IkSolutions::default();
    for bad in [f64::NAN, f64::INFINITY, 1e300, 5.0] {
        arm.ik_near(
            &Frame {
                p: [bad, 0.1, 0.2],
                ..Frame::IDENTITY
            },
            0.0,
            &mut out,
        );
        assert!(out.is_empty());
    }
    arm.ik_near(
        &Frame {
            p: [0.3, 0.1, 0.2],
            ..Frame::IDENTITY
        },
        f64::NAN,
        &mut out,
    );
    assert!(out.is_empty());
    // Inside the shoulder's cylinder.
    arm.ik_near(
        &Frame {
            p: [0.05, 0.0, 0.6],
            ..Frame::IDENTITY
        },
        0.0,
        &mut out,
    );
    assert!(out.is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    /// Each solution of a reachable pose reaches it, and branch numbers do not repeat.
    #[test]
    fn solutions_close(q in prop::array::uniform6(-PI..PI)) {
        let (arm, mut out) = (Ur5e::default(), IkSolutions::default());
        let target = frame(&arm, &q);
        arm.ik_near(&target, q[5], &mut out);
        prop_assert!(!out.is_empty());
        prop_assert!(worst_closure(&arm, &target, &out) < 1e-9);
    }

    /// Arms of other lengths keep the same closed form.
    #[test]
    fn other_sizes_close(q in prop::array::uniform6(-PI..PI), scale in 0.3..3.0f64) {
        let d = Ur5e::default();
        let arm = Ur5e { d1: d.d1 * scale, a2: d.a2 * 1.3, a3: d.a3 * scale, d4: d.d4 * 0.8, d5: d.d5, d6: d.d6 * scale, ..d };
        let mut out = IkSolutions::default();
        let target = frame(&arm, &q);
        arm.ik_near(&target, q[5], &mut out);
        prop_assert!(!out.is_empty());
        prop_assert!(worst_closure(&arm, &target, &out) < 1e-9);
    }

    /// The copy nearest to the seed is inside the limits and a whole number of turns away.
    #[test]
    fn copies_are_nearest(q in prop::array::uniform6(-9.0..9.0f64), seed in prop::array::uniform6(-7.0..7.0f64)) {
        let arm = Ur5e::default();
        if let Some(copy) = arm.nearest_copy(&q, &seed) {
            prop_assert!(arm.limit_violation(&copy).is_none());
            for j in 0..6 {
                prop_assert!(turn(copy[j], q[j]) < 1e-9);
                for k in -3..=3 {
                    let other = copy[j] + TAU * f64::from(k);
                    if other >= arm.limits[j].0 && other <= arm.limits[j].1 {
                        prop_assert!((copy[j] - seed[j]).abs() <= (other - seed[j]).abs() + 1e-9);
                    }
                }
            }
        } else {
            prop_assert!(false, "a full turn always has a copy");
        }
    }
}

#[test]
fn a_straight_elbow_near_the_shoulder_cylinder_is_flagged() {
    // Rounding in q1 makes q3 come out as 1.7e-6 here, beyond the flag's usual width.
    let (arm, mut out) = (Ur5e::default(), IkSolutions::default());
    let q = [
        -2.7803392223299146,
        -1.4694354649218415,
        0.0,
        -2.651540809594321,
        0.0562746855010392,
        2.786915170166438,
    ];
    arm.ik_near(&frame(&arm, &q), 0.0, &mut out);
    assert!(out.as_slice().iter().any(|s| s.singular.elbow));
    // A bent elbow near the same place is not.
    let bent = [q[0], q[1], 0.01, q[3], q[4], q[5]];
    arm.ik_near(&frame(&arm, &bent), 0.0, &mut out);
    assert!(!out.is_empty() && out.as_slice().iter().all(|s| !s.singular.elbow));
}
