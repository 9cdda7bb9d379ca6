//! One case for each thing that goes wrong, and the robot's default figures.

use robots::*;

#[test]
fn numbers_that_are_not_finite_are_refused() {
    let robot = MobileManipulator::default();
    let bad = [f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0];
    assert_eq!(robot.self_clearance(&bad), f64::NEG_INFINITY);
    assert!(!robot.self_is_free(&bad, 0.0));
    assert!(!robot.line_is_free(&bad, &[0.0; 6]));
    assert_eq!(robot.arm.limit_violation(&bad), Some((0, f64::INFINITY)));
    let goal = BodyState {
        joints: bad,
        ..BodyState::default()
    };
    assert_eq!(
        robot.compensate_yaw(&goal, [0.0; 3], &[0.0; 6]),
        Err(Error::NotFinite {
            field: "goal.joints"
        })
    );
    let goal = BodyState::default();
    assert_eq!(
        robot.compensate_yaw(&goal, [0.0, f64::INFINITY, 0.0], &[0.0; 6]),
        Err(Error::NotFinite { field: "base" })
    );
    let pose = robot.camera_pose(&goal);
    assert!(robot.ik_camera([0.0; 3], &pose, &bad).as_slice().is_empty());
    assert!(
        robot
            .ik_camera([f64::NAN; 3], &pose, &[0.0; 6])
            .as_slice()
            .is_empty()
    );
}

#[test]
fn views_out_of_reach_are_named() {
    let robot = MobileManipulator::default();
    let high = View {
        height: 2.5,
        pitch: 0.0,
    };
    let weights = PostureWeights::default();
    let error = robot.posture(&high, &[0.0; 6], &weights).unwrap_err();
    assert_eq!(
        error.to_string(),
        "no posture without self-collision looks 0.0 deg up from a height of 2.50 m"
    );
    let bad = View {
        height: f64::NAN,
        pitch: 0.0,
    };
    assert_eq!(
        robot.posture(&bad, &[0.0; 6], &weights),
        Err(Error::NotFinite { field: "view" })
    );
    assert_eq!(robot.postures(&[], &weights), Err(Error::NoViews));
}

#[test]
fn limits_are_checked_by_joint() {
    let arm = Ur5e::default();
    assert_eq!(arm.limit_violation(&[6.0, -6.0, 3.0, 0.0, 0.0, 0.0]), None);
    let (joint, out) = arm
        .limit_violation(&[0.0, 0.0, 3.2, 0.0, 0.0, 0.0])
        .unwrap();
    assert!(joint == 2 && (out - 0.0584).abs() < 1e-3);
}

#[test]
fn arm_points_forward_at_zero() {
    // The maker's arm extends along -x at zero; the mount turns it forward.
    let robot = MobileManipulator::default();
    let frames = robot.arm_frames(&BodyState::default());
    let elbow = frames[2].p;
    assert!(
        (elbow[0] - 0.525).abs() < 1e-12
            && elbow[1].abs() < 1e-12
            && (elbow[2] - 0.6625).abs() < 1e-12
    );
    assert_eq!(robot.lidar_position([1.0, 2.0, 0.0]), [1.25, 2.0, 0.45]);
}

#[test]
fn arm_through_the_base_is_seen() {
    let robot = MobileManipulator::default();
    // Straight down through the box.
    assert!(robot.self_clearance(&[0.0, std::f64::consts::FRAC_PI_2, 0.0, 0.0, 0.0, 0.0]) < -0.1);
    // Straight up.
    assert!(robot.self_clearance(&[0.0, -std::f64::consts::FRAC_PI_2, 0.0, 0.0, 0.0, 0.0]) > 0.03);
    // Folded onto itself.
    assert!(robot.self_clearance(&[0.0, -std::f64::consts::FRAC_PI_2, 3.1, 0.0, 0.0, 0.0]) < 0.0);
}

#[test]
fn default_postures_are_good() {
    let robot = MobileManipulator::default();
    let postures = robot.default_postures().unwrap();
    assert_eq!(postures.len(), 7);
    let level = postures[0];
    // Fits a doorway with the base: nothing stands out much farther than the base's corner (0.465 m).
    assert!(level.reach < 0.46, "{}", level.reach);
    for (p, view) in postures.iter().zip(default_views()) {
        assert_eq!(p.view, view);
        let camera = robot.camera_frame(&BodyState {
            base: [0.0; 3],
            joints: p.joints,
        });
        let (e, a) = camera.error_to(&p.camera);
        assert!(e < 1e-9 && a < 1e-9);
        assert!(
            (camera.z[2] - view.pitch.sin()).abs() < 1e-9
                && camera.z[1].abs() < 1e-9
                && camera.y[2] < 0.0
        );
        assert!((camera.p[2] - view.height).abs() <= 0.2 + 1e-9);
        assert!(p.clearance > 0.02 && p.hidden < 0.15, "{p:?}");
        assert!(robot.line_is_free(&level.joints, &p.joints));
        assert!(robot.arm.limit_violation(&p.joints).is_none());
        assert!(robot.arm_seconds(&level.joints, &p.joints) < 4.0);
    }
    // The same twice.
    assert_eq!(postures, robot.default_postures().unwrap());
}
