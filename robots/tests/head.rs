//! The PR2-like head.

use nalgebra::{Isometry3, Translation3, Vector3};
use proptest::prelude::*;
use robots::{HeadState, LiftHead, looking};

fn states() -> impl Strategy<Value = HeadState> {
    let base = (-5.0..5.0f64, -5.0..5.0f64, -3.1..3.1f64).prop_map(|(x, y, yaw)| [x, y, yaw]);
    (base, 0.012..0.305f64, -3.0..3.0f64, -0.47..1.39f64).prop_map(|(base, torso, pan, tilt)| {
        HeadState {
            base,
            torso,
            pan,
            tilt,
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    /// Forward kinematics is the product of the robot description's transforms.
    #[test]
    fn camera_is_the_product_of_transforms(s in states()) {
        let head = LiftHead::default();
        let t = |x: f64, z: f64| Isometry3::from_parts(Translation3::new(x, 0.0, z), Default::default());
        let turn = |axis: Vector3<f64>, a: f64| Isometry3::new(Vector3::zeros(), axis * a);
        let pose = Isometry3::new(Vector3::new(s.base[0], s.base[1], 0.0), Vector3::z() * s.base[2])
            * t(-0.05, 0.790675 + s.torso) * t(-0.01707, 0.38145) * turn(Vector3::z(), s.pan)
            * t(0.068, 0.0) * turn(Vector3::y(), s.tilt) * t(0.0232, 0.292);
        let camera = head.camera_frame(&s);
        let p = pose.translation.vector;
        prop_assert!((0..3).all(|i| (p[i] - camera.p[i]).abs() < 1e-12));
        let forward = pose.rotation * Vector3::x();
        let right = pose.rotation * -Vector3::y();
        prop_assert!((0..3).all(|i| (forward[i] - camera.z[i]).abs() < 1e-12 && (right[i] - camera.x[i]).abs() < 1e-12));
    }

    /// Inverse kinematics gives the state back.
    #[test]
    fn reach_closes(s in states()) {
        let head = LiftHead::default();
        let camera = head.camera_frame(&s);
        let back = head.reach(camera.p, s.base[2] + s.pan, -s.tilt, s.base[2]);
        prop_assert!(back.is_some());
        if let Some(b) = back {
            let (p, a) = head.camera_frame(&b).error_to(&camera);
            prop_assert!(p < 1e-12 && a < 1e-12);
            prop_assert!((b.torso - s.torso).abs() < 1e-12 && (b.pan - s.pan).abs() < 1e-12);
        }
    }

    /// Looking at a point on the optical axis changes nothing; any point looked at is on the axis, in front.
    #[test]
    fn look_at_aims(s in states(), far in 0.3..6.0f64, other in prop::array::uniform3(-4.0..4.0f64)) {
        let head = LiftHead::default();
        let point = head.camera_frame(&s).apply([0.0, 0.0, far]);
        if let Some(same) = head.look_at(&s, point) {
            let seen = head.camera_frame(&same).apply_inverse(point);
            prop_assert!(seen[0].abs() < 1e-9 && seen[1].abs() < 1e-9 && seen[2] > 0.0);
        }
        let ahead = head.camera_frame(&s).apply([0.0, 0.0, 1.0 + far]);
        // Points that the head sees over its own axis (steep views turn the far side to the front) have two states.
        if s.tilt < 0.9 {
            prop_assert!(head.look_at(&s, ahead).is_some_and(|b| (b.tilt - s.tilt).abs() < 1e-9 && (b.pan - s.pan).abs() < 1e-9));
        }
        if let Some(b) = head.look_at(&s, other) {
            let seen = head.camera_frame(&b).apply_inverse(other);
            prop_assert!(seen[0].abs() < 1e-9 && seen[1].abs() < 1e-9 && seen[2] > 0.0);
            prop_assert!(head.limit_violation(&b).is_none());
        }
    }
}

#[test]
fn heights_and_refusals() {
    let head = LiftHead::default();
    let level = HeadState {
        torso: 0.1,
        ..HeadState::default()
    };
    assert!((head.camera_frame(&level).p[2] - 1.564_125).abs() < 1e-9);
    // Too high, too low, behind the pan limit, not a number.
    assert!(head.reach([0.0, 0.0, 2.0], 0.0, 0.0, 0.0).is_none());
    assert!(head.reach([0.0, 0.0, 1.2], 0.0, 0.0, 0.0).is_none());
    assert!(head.reach([0.0, 0.0, 1.6], 3.1, 0.0, 0.0).is_none());
    assert!(
        head.reach([f64::NAN, 0.0, f64::NAN], 0.0, 0.0, 0.0)
            .is_none()
    );
    assert!(head.look_at(&level, [f64::NAN; 3]).is_none());
    assert!(head.look_at(&level, [0.0, 0.0, 1.3]).is_none());
    assert_eq!(
        head.limit_violation(&HeadState { pan: 3.5, ..level })
            .map(|v| v.0),
        Some(1)
    );
    let flap = LiftHead::flap();
    assert!(
        (flap
            .camera_frame(&HeadState {
                torso: 0.02,
                ..level
            })
            .p[2]
            - 1.484)
            .abs()
            < 1e-3
    );
    assert!(
        (flap
            .seconds(
                &level,
                &HeadState {
                    torso: 0.2,
                    pan: 1.0,
                    ..level
                }
            )
            .unwrap()
            - 10.0)
            .abs()
            < 1e-9
    );
    assert!(
        flap.seconds(
            &level,
            &HeadState {
                tilt: f64::NAN,
                ..level
            }
        )
        .is_err()
    );
    let looked = looking([1.0, 2.0, 1.6], 0.4, -0.2);
    let state = head.reach(looked.p, 0.4, -0.2, 0.1).unwrap();
    assert!(head.camera_frame(&state).error_to(&looked).0 < 1e-12);
}
