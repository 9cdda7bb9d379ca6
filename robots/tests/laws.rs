//! Properties of the whole robot that hold for any input.
#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use robots::{BodyState, Frame, MobileManipulator, SELF_MARGIN, looking};
use std::f64::consts::PI;

fn states() -> impl Strategy<Value = BodyState> {
    let base = (-10.0..10.0f64, -10.0..10.0f64, -PI..PI).prop_map(|(x, y, yaw)| [x, y, yaw]);
    (base, prop::array::uniform6(-PI..PI)).prop_map(|(base, joints)| BodyState { base, joints })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    /// Camera inverse kinematics reaches the pose, respects limits and self-collision, and lists the quickest first.
    #[test]
    fn camera_solutions_hold(state in states(), seed in prop::array::uniform6(-4.0..4.0f64)) {
        let robot = MobileManipulator::default();
        let wanted = robot.camera_frame(&state);
        let found = robot.ik_camera(state.base, &robot.camera_pose(&state), &seed);
        for s in found.as_slice() {
            let (p, r) = robot.camera_frame(&BodyState { base: state.base, joints: s.joints }).error_to(&wanted);
            prop_assert!(p < 1e-8 && r < 1e-8);
            prop_assert!(robot.arm.limit_violation(&s.joints).is_none());
            prop_assert!(s.clearance >= SELF_MARGIN);
            prop_assert_eq!(s.seconds, robot.arm_seconds(&seed, &s.joints));
        }
        prop_assert!(found.as_slice().windows(2).all(|w| w[0].seconds <= w[1].seconds));
        if robot.self_is_free(&state.joints, SELF_MARGIN + 1e-6) {
            prop_assert!(!found.as_slice().is_empty());
        }
    }

    /// The self-clearance does not depend on where the base is, and changes no faster than the joints can move it.
    #[test]
    fn self_clearance_is_continuous(q in prop::array::uniform6(-PI..PI), d in prop::array::uniform6(-1e-3..1e-3f64)) {
        let robot = MobileManipulator::default();
        let mut p = q;
        for j in 0..6 { p[j] += d[j]; }
        let turn: f64 = d.iter().map(|v| v.abs()).sum();
        // No point of the arm is farther than 1.3 m from a joint's axis; both ends of a pair may move.
        prop_assert!((robot.self_clearance(&p) - robot.self_clearance(&q)).abs() <= 2.0 * 1.3 * turn + 1e-12);
        prop_assert!(robot.self_is_free(&q, -1.0));
    }

    /// Growing a link can only take self-clearance away.
    #[test]
    fn thicker_links_clear_less(q in prop::array::uniform6(-PI..PI), grow in 0.001..0.02f64) {
        let robot = MobileManipulator::default();
        let mut thick = robot.clone();
        for s in &mut thick.body.spheres { s.radius += grow; }
        prop_assert!(thick.self_clearance(&q) <= robot.self_clearance(&q) - grow + 1e-12);
    }

    /// A base that stands where it should needs no compensation; one that stands elsewhere keeps the camera's pose
    /// where that can be reached, and otherwise its attitude. The residual reported is the true one.
    #[test]
    fn compensation_keeps_the_camera(state in states(), dx in -0.2..0.2f64, dy in -0.2..0.2f64, dyaw in -PI..PI) {
        let robot = MobileManipulator::default();
        let base = [state.base[0] + dx, state.base[1] + dy, state.base[2] + dyaw];
        let wanted = robot.camera_frame(&state);
        let c = robot.compensate_yaw(&state, base, &state.joints).unwrap();
        let (p, r) = robot.camera_frame(&BodyState { base, joints: c.joints }).error_to(&wanted);
        prop_assert!((p - c.position_error).abs() < 1e-12 && (r - c.angle_error).abs() < 1e-12);
        if c.exact {
            prop_assert!(p < 1e-8 && r < 1e-8 && c.clearance >= SELF_MARGIN);
        } else {
            prop_assert!(r < 1e-7, "the pan keeps the attitude: {r}");
        }
        prop_assert!(robot.arm.limit_violation(&c.joints).is_none());
        // The pan alone keeps the attitude, and shifts the camera by no more than the arm's mount and the drive do.
        let pan = robot.compensate_pan(&state, base, &state.joints).unwrap();
        let bound = 2.0 * 0.10 * (0.5 * dyaw).sin().abs() + dx.hypot(dy);
        prop_assert!(!pan.exact && pan.angle_error < 1e-7 && pan.position_error <= bound + 1e-9);
        let same = robot.compensate_yaw(&state, state.base, &state.joints).unwrap();
        prop_assert!(same.position_error < 1e-8 && same.angle_error < 1e-7);
        if same.exact && robot.self_is_free(&state.joints, SELF_MARGIN + 1e-6) {
            prop_assert!(robot.arm_seconds(&state.joints, &same.joints) < 1e-3);
        }
    }

    /// With the arm on the turning axis the pan alone keeps the camera's pose.
    #[test]
    fn pan_is_exact_on_the_turning_axis(state in states(), dyaw in -PI..PI) {
        let mut robot = MobileManipulator::default();
        robot.mount.translation.x = 0.0;
        let goal = robot.camera_frame(&state);
        let mut joints = state.joints;
        joints[0] -= dyaw;
        let turned = BodyState { base: [state.base[0], state.base[1], state.base[2] + dyaw], joints };
        let (p, r) = robot.camera_frame(&turned).error_to(&goal);
        prop_assert!(p < 1e-9 && r < 1e-9);
    }

    /// Frames: inverse, product and rows agree.
    #[test]
    fn frames_form_a_group(state in states(), p in prop::array::uniform3(-3.0..3.0f64)) {
        let f = MobileManipulator::default().camera_frame(&state);
        let (a, b) = f.then(&f.inverse()).error_to(&Frame::IDENTITY);
        prop_assert!(a < 1e-12 && b < 1e-12);
        prop_assert_eq!(Frame::from_rows(&f.rows(), f.p), f);
        let back = f.apply_inverse(f.apply(p));
        prop_assert!((0..3).all(|i| (back[i] - p[i]).abs() < 1e-12));
        let g = looking(p, state.base[2], 0.3);
        prop_assert!((g.z[2] - 0.3f64.sin()).abs() < 1e-12 && g.x[2].abs() < 1e-12 && g.y[2] < 0.0);
    }
}
