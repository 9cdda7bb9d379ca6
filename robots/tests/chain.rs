//! Chains from data: kinematics against the UR5e's closed form and differences, files, differential inverse kinematics.
#![cfg(all(feature = "urdf", feature = "diff-ik"))]
#![allow(missing_docs, clippy::unwrap_used)]
mod common;

use common::Random;
use robots::{Chain, DiffIk, Error, Frame, Ur5e};

const UR: (&str, &str) = (
    include_str!("data/ur5e.urdf"),
    include_str!("data/ur5e.json"),
);
const SEVEN: (&str, &str) = (
    include_str!("data/lifted_seven.urdf"),
    include_str!("data/lifted_seven.json"),
);

fn read((urdf, side): (&str, &str)) -> Chain {
    Chain::from_urdf(urdf, side).unwrap()
}

fn inside(chain: &Chain, random: &mut Random) -> Vec<f64> {
    let each = chain.joints.iter().map(|j| {
        let (low, high) = (j.limits.0.max(-3.1), j.limits.1.min(3.1));
        random.within(low, high)
    });
    each.collect()
}

#[test]
fn the_file_of_a_ur5e_is_the_ur5e() {
    let (chain, arm, mut random) = (read(UR), Ur5e::default(), Random(4));
    assert_eq!((chain.len(), chain.spheres.len()), (6, 9));
    for _ in 0..200 {
        let q = random.joints();
        let (p, a) = chain
            .tip(&q)
            .unwrap()
            .error_to(&arm.chain(&Frame::IDENTITY, &q)[6]);
        assert!(p < 1e-12 && a < 1e-12, "{p} {a}");
        let ours = chain.jacobian(&q).unwrap();
        let theirs = arm.jacobian(&q);
        for (j, column) in ours.iter().enumerate() {
            for i in 0..6 {
                assert!((column[i] - theirs[(i, j)]).abs() < 1e-12);
            }
        }
        let camera = chain.camera(&q).unwrap();
        let tip = chain.tip(&q).unwrap();
        assert!((camera.p[0] - tip.p[0] - 0.05 * tip.z[0]).abs() < 1e-12);
    }
}

#[test]
fn jacobians_agree_with_central_differences() {
    let (chain, mut random) = (read(SEVEN), Random(5));
    assert_eq!(chain.len(), 8);
    let h = 1e-5;
    for _ in 0..50 {
        let q = inside(&chain, &mut random);
        let columns = chain.jacobian(&q).unwrap();
        for j in 0..q.len() {
            let at = |d: f64| {
                let mut moved = q.clone();
                moved[j] += d;
                chain.tip(&moved).unwrap()
            };
            let (a, b, tip) = (at(-h), at(h), chain.tip(&q).unwrap());
            for i in 0..3 {
                assert!(((b.p[i] - a.p[i]) / (2.0 * h) - columns[j][i]).abs() < 1e-8);
                // d(axis)/dq = w x axis, for each axis of the tip.
            }
            let w = [columns[j][3], columns[j][4], columns[j][5]];
            for (before, after, axis) in [(a.x, b.x, tip.x), (a.y, b.y, tip.y), (a.z, b.z, tip.z)] {
                let cross = [
                    w[1] * axis[2] - w[2] * axis[1],
                    w[2] * axis[0] - w[0] * axis[2],
                    w[0] * axis[1] - w[1] * axis[0],
                ];
                for i in 0..3 {
                    assert!(((after[i] - before[i]) / (2.0 * h) - cross[i]).abs() < 1e-8);
                }
            }
        }
    }
}

#[test]
fn poses_within_reach_are_reached_within_the_limits() {
    for (files, least) in [(UR, 40), (SEVEN, 40)] {
        let (chain, mut random) = (read(files), Random(6));
        let mut reached = 0;
        for k in 0..40 {
            let (from, wanted) = (inside(&chain, &mut random), inside(&chain, &mut random));
            let target = chain.tip(&wanted).unwrap();
            let found = chain.ik(&from, &target, &DiffIk::default(), k).unwrap();
            assert!(chain.limit_violation(&found.joints).unwrap().is_none());
            let (p, a) = chain.tip(&found.joints).unwrap().error_to(&target);
            assert!(
                (p - found.position_error).abs() < 1e-12 && (a - found.angle_error).abs() < 1e-12
            );
            assert_eq!(found.reached, p <= 1e-6 && a <= 1e-6);
            assert_eq!(
                found,
                chain.ik(&from, &target, &DiffIk::default(), k).unwrap()
            );
            reached += usize::from(found.reached);
        }
        assert!(reached >= least, "{reached} of 40");
    }
}

#[test]
fn steps_keep_limits_and_speeds_and_come_nearer() {
    let (chain, mut random) = (read(SEVEN), Random(7));
    let settings = DiffIk::default();
    let mut limited = 0;
    for _ in 0..40 {
        let mut q = inside(&chain, &mut random);
        let target = chain.tip(&inside(&chain, &mut random)).unwrap();
        for _ in 0..60 {
            let error = |q: &[f64]| {
                let (p, a) = chain.tip(q).unwrap().error_to(&target);
                p * p + (0.3 * a) * (0.3 * a)
            };
            let step = chain.ik_step(&q, &target, 0.02, &settings).unwrap();
            limited += usize::from(step.limited);
            let before = error(&q);
            for (j, m) in step.motion.iter().enumerate() {
                assert!(m.abs() <= chain.joints[j].speed * 0.02 + 1e-12);
                q[j] += m;
            }
            assert!(
                chain
                    .limit_violation(&q)
                    .unwrap()
                    .is_none_or(|v| v.1 < 1e-12)
            );
            for (value, joint) in q.iter_mut().zip(&chain.joints) {
                *value = value.clamp(joint.limits.0, joint.limits.1);
            }
            // First order: small motions may lose a little where the tip turns by half a turn.
            assert!(error(&q) <= before * 1.02 + 1e-9, "{before} {}", error(&q));
        }
    }
    assert!(limited > 100);
}

/// The program's minimum against a projected-gradient descent over the same box.
#[test]
fn a_limited_step_is_the_minimum_over_the_box() {
    let (chain, mut random) = (read(UR), Random(8));
    let settings = DiffIk {
        damping: 0.05,
        ..DiffIk::default()
    };
    let mut seen = 0;
    while seen < 20 {
        let q = inside(&chain, &mut random);
        let target = chain.tip(&inside(&chain, &mut random)).unwrap();
        let step = chain.ik_step(&q, &target, 0.05, &settings).unwrap();
        if !step.limited {
            continue;
        }
        seen += 1;
        let columns = chain.jacobian(&q).unwrap();
        let tip = chain.tip(&q).unwrap();
        // The rotation vector, from the skew part of target * tip^T.
        let (rt, rs) = (target.rows(), tip.rows());
        let m = |i: usize, j: usize| (0..3).map(|k| rt[i][k] * rs[j][k]).sum::<f64>();
        let half = [m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1)].map(|v| 0.5 * v);
        let sin = half.iter().map(|v| v * v).sum::<f64>().sqrt();
        let angle = sin.atan2(0.5 * (m(0, 0) + m(1, 1) + m(2, 2) - 1.0));
        let mut e = [0.0; 6];
        for i in 0..3 {
            e[i] = target.p[i] - tip.p[i];
            e[3 + i] = half[i] / sin * angle;
        }
        let value = |x: &[f64]| {
            let mut sum = 0.05 * 0.05 * x.iter().map(|v| v * v).sum::<f64>();
            for i in 0..6 {
                let w = if i < 3 { 1.0 } else { 0.09 };
                let r: f64 = (0..6).map(|j| columns[j][i] * x[j]).sum::<f64>() - e[i];
                sum += w * r * r;
            }
            sum
        };
        let bound = |j: usize| {
            let (joint, most) = (&chain.joints[j], chain.joints[j].speed * 0.05);
            (
                (joint.limits.0 - q[j]).max(-most),
                (joint.limits.1 - q[j]).min(most),
            )
        };
        let mut x = vec![0.0; 6];
        for _ in 0..20_000 {
            for j in 0..6 {
                let h = 1e-6;
                let (mut up, mut down) = (x.clone(), x.clone());
                up[j] += h;
                down[j] -= h;
                // Coordinate descent: the second derivative along one joint is constant.
                let (f0, fu, fd) = (value(&x), value(&up), value(&down));
                let slope = (fu - fd) / (2.0 * h);
                let curve = (columns[j].iter().enumerate())
                    .map(|(i, v)| 2.0 * if i < 3 { 1.0 } else { 0.09 } * v * v)
                    .sum::<f64>()
                    + 2.0 * 0.05 * 0.05;
                let (low, high) = bound(j);
                x[j] = (x[j] - slope / curve).clamp(low, high);
                debug_assert!(value(&x) <= f0 + 1e-9);
            }
        }
        assert!(
            value(&step.motion) <= value(&x) + 1e-6,
            "{} {}",
            value(&step.motion),
            value(&x)
        );
    }
}

fn message(result: Result<Chain, Error>) -> String {
    result.unwrap_err().to_string()
}

#[test]
fn files_that_make_no_sense_say_why() {
    let side = |text: &str| message(Chain::from_urdf(UR.0, text));
    assert!(side("{").contains("side file"));
    assert!(side(r#"{ "base": "base_link", "tip": "hand" }"#).contains("no link `hand`"));
    assert!(side(r#"{ "base": "tool0", "tip": "base_link" }"#).contains("does not hang below"));
    assert!(side(r#"{ "base": "base_link", "tip": "tool0", "colour": 1 }"#).contains("colour"));
    let sphere = |link: &str, radius: f64| {
        side(&format!(
            r#"{{ "base": "base_link", "tip": "wrist_1_link", "spheres": [{{ "link": "{link}", "center": [0,0,0], "radius": {radius} }}] }}"#
        ))
    };
    assert!(sphere("tool0", 0.1).contains("not on the way to the tip"));
    assert!(sphere("elbow_link", 0.0).contains("positive radius"));
    let camera = r#"{ "base": "base_link", "tip": "tool0", "camera": { "link": "elbow_link" } }"#;
    assert!(side(camera).contains("not behind the last joint"));
    assert!(message(Chain::from_urdf("<robot", UR.1)).contains("URDF"));
    let floating = UR.0.replace("type=\"fixed\"", "type=\"floating\"");
    assert!(message(Chain::from_urdf(&floating, UR.1)).contains("joint `tool`"));
    let missing = Chain::from_urdf_files("no/such.urdf".as_ref(), "no/such.json".as_ref());
    assert!(message(missing).contains("no/such.urdf"));
    let no_axis =
        UR.0.replacen("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 0\"/>", 1);
    assert!(message(Chain::from_urdf(&no_axis, UR.1)).contains("no length"));
    let crossed =
        UR.0.replacen("lower=\"-6.283185307179586\"", "lower=\"7\"", 1);
    assert!(message(Chain::from_urdf(&crossed, UR.1)).contains("lower first"));
}

#[test]
fn bad_joints_and_settings_are_named() {
    let chain = read(UR);
    let target = chain.tip(&[0.1; 6]).unwrap();
    let defaults = DiffIk::default();
    assert_eq!(
        chain.tip(&[0.0; 5]).unwrap_err().to_string(),
        "5 joint positions given, the arm has 6"
    );
    assert!(chain.tip(&[f64::NAN; 6]).is_err());
    let outside = chain.ik(&[0.0, 0.0, 3.5, 0.0, 0.0, 0.0], &target, &defaults, 0);
    assert!(outside.unwrap_err().to_string().contains("joint 2"));
    for seconds in [0.0, -1.0, f64::NAN] {
        let step = chain.ik_step(&[0.0; 6], &target, seconds, &defaults);
        assert!(step.unwrap_err().to_string().contains("seconds"));
    }
    let still = DiffIk {
        longest: 0.0,
        ..defaults.clone()
    };
    let refused = chain.ik(&[0.0; 6], &target, &still, 0).unwrap_err();
    assert!(refused.to_string().contains("longest = 0"));
    let nowhere = Frame {
        p: [f64::NAN; 3],
        ..target
    };
    assert!(chain.ik(&[0.0; 6], &nowhere, &defaults, 0).is_err());
    // Out of reach is a result.
    let far = Frame {
        p: [5.0, 0.0, 0.0],
        ..target
    };
    let found = chain
        .ik(
            &[0.0; 6],
            &far,
            &DiffIk {
                seeds: 2,
                ..defaults
            },
            0,
        )
        .unwrap();
    assert!(!found.reached && found.position_error > 3.0);
}
