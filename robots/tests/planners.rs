//! The robot behind the planners' traits.
#![allow(clippy::unwrap_used)]

use robots::{BodyState, InWorld, MobileManipulator, OnSchedule};

/// A table top at 0.7 m to 0.75 m height, 1 m ahead of the origin and 1 m deep.
fn table(center: [f64; 3], radius: f64) -> bool {
    let (low, high) = ([1.0, -1.0, 0.70], [2.0, 1.0, 0.75]);
    let square: f64 = (0..3)
        .map(|i| (center[i] - center[i].clamp(low[i], high[i])).powi(2))
        .sum();
    square > radius * radius
}

#[test]
fn body_is_tested_against_the_world() {
    let robot = MobileManipulator::default();
    let postures = robot.default_postures().unwrap();
    let world = InWorld::new(&robot, postures[0].joints, 0.02, table, |b| b[0] < 0.6);
    let at = |x: f64, i: usize| BodyState {
        base: [x, 0.0, 0.0],
        joints: postures[i].joints,
    };
    assert!(world.is_free(&at(0.0, 0)));
    // The base's own test.
    assert!(!world.is_free(&at(0.7, 0)) && world.arm_is_free(&at(0.5, 0)));
    // Looking up from under the table is fine where the arm fits, and not where it does not.
    let hits = (0..7).filter(|i| !world.arm_is_free(&at(0.95, *i))).count();
    assert!(hits > 0 && hits < 8);
    assert!(!world.is_free(&BodyState {
        base: [f64::NAN, 0.0, 0.0],
        joints: postures[0].joints
    }));
}

#[test]
fn motions_are_tested_between_their_ends() {
    let robot = MobileManipulator::default();
    let q = robot.default_postures().unwrap()[0].joints;
    // A thin wall between two base poses that are both free of it.
    let wall = |c: [f64; 3], r: f64| (c[0] - 1.0).abs() > r;
    let base = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    let arm = OnSchedule::new(&robot, &base, 0.0, wall);
    assert!(arm.state_is_free(&q, 0) && arm.state_is_free(&q, 1) && arm.state_is_free(&q, 99));
    assert!(!arm.motion_is_free(&q, &q, 0, 1));
    assert!(arm.motion_is_free(&q, &q, 0, 0));
    assert!(!arm.state_is_free(&[7.0, q[1], q[2], q[3], q[4], q[5]], 0));
    assert!(!arm.state_is_free(&[f64::NAN; 6], 0));
    // A step that turns through +-pi takes the short way.
    let base = [[0.0, 0.0, 3.1], [0.0, 0.0, -3.1]];
    let ahead = |c: [f64; 3], _: f64| c[0] < 0.36;
    assert!(OnSchedule::new(&robot, &base, 0.0, ahead).motion_is_free(&q, &q, 0, 1));
}

#[cfg(feature = "viewsample")]
#[test]
fn view_planner_finds_its_postures() {
    use viewsample::{Params, Pose, Robot};
    let robot = MobileManipulator::default();
    let ours = robot.default_postures().unwrap();
    let world = InWorld::new(&robot, ours[0].joints, 0.02, table, |b: [f64; 3]| {
        b[0] < 0.5
    });
    let theirs = viewsample::postures(&world, &Params::default()).unwrap();
    assert_eq!(theirs.len(), 7);
    let library = robots::library(&ours);
    for p in theirs.iter().chain(&library) {
        let camera = robot.camera_frame(&BodyState {
            base: [0.0; 3],
            joints: p.state,
        });
        let (position, angle) = camera.error_to(&(&p.camera).into());
        assert!(position < 1e-9 && angle < 1e-9);
        assert!(robot.self_is_free(&p.state, 0.0));
        let same = Pose::looking(
            p.camera.translation,
            0.0,
            robots::default_views()[p.view].pitch,
        );
        assert!(
            (0..3)
                .all(|i| (0..3)
                    .all(|j| (same.rotation[i][j] - p.camera.rotation[i][j]).abs() < 1e-9))
        );
    }
    let bases: Vec<[f64; 3]> = (0..60)
        .map(|i| [f64::from(i) * 0.03 - 0.5, 0.1, f64::from(i) * 0.2])
        .collect();
    viewsample::conformance::check_robot(&world, &theirs, &bases).unwrap();
    let places: Vec<([f64; 3], [f64; 6])> = bases
        .iter()
        .zip(library.iter().cycle())
        .map(|(b, p)| (*b, p.state))
        .collect();
    viewsample::conformance::check_costs(&robot, &places).unwrap();
    assert!(
        world
            .reach(&Pose::looking([0.4, 0.0, 2.5], 0.0, 0.0))
            .is_none()
    );
}

#[cfg(feature = "hybrid-astar")]
#[test]
fn base_planner_gets_the_footprint() {
    use hybrid_astar::Robot;
    let robot = MobileManipulator::default();
    assert_eq!(robot.circles(), robot.base_circles());
    assert_eq!(robot.outline(), robot.base.outline);
    let limits = hybrid_astar::Limits::from(&robot.limits);
    assert_eq!(limits, hybrid_astar::Limits::default());
}

#[cfg(feature = "strrt")]
#[test]
fn arm_planner_ducks_under_a_lintel() {
    // The base drives forward through a gate whose lintel is too low for the level posture.
    let robot = MobileManipulator::default();
    let postures = robot.default_postures().unwrap();
    let (start, goal) = (postures[0].joints, postures[1].joints);
    let base: Vec<[f64; 3]> = (0..100).map(|i| [f64::from(i) * 0.04, 0.0, 0.0]).collect();
    let lintel = |c: [f64; 3], r: f64| {
        let square: f64 = [(c[0] - 2.0).abs() - 0.1, 1.0 - c[2]]
            .iter()
            .map(|d| d.max(0.0).powi(2))
            .sum();
        square > r * r
    };
    let arm = OnSchedule::new(&robot, &base, 0.01, lintel);
    assert!(!arm.state_is_free(&start, 50));
    let plan = strrt::plan(
        &arm,
        start,
        goal,
        base.len(),
        0.1,
        &strrt::Params::default(),
        1,
    )
    .unwrap();
    assert_eq!(plan.status, strrt::Status::Solved, "{plan:?}");
    for (step, pair) in plan.path.windows(2).enumerate() {
        assert!((0..6).all(|j| (pair[1][j] - pair[0][j]).abs() <= 0.08 + 1e-9));
        if plan.waited_before == 0 && plan.waited_after == 0 {
            assert!(
                arm.state_is_free(&pair[0], step)
                    && arm.motion_is_free(&pair[0], &pair[1], step, step + 1)
            );
        }
    }
}

/// The same with sixteen states at a time: what it finds, the check in double precision accepts.
#[cfg(feature = "strrt")]
#[test]
fn batched_checks_duck_under_a_lintel_too() {
    let robot = MobileManipulator::default();
    let postures = robot.default_postures().unwrap();
    let (start, goal) = (postures[0].joints, postures[1].joints);
    let base: Vec<[f64; 3]> = (0..100).map(|i| [f64::from(i) * 0.04, 0.0, 0.0]).collect();
    let distance = |c: [f64; 3]| {
        let d = [(c[0] - 2.0).abs() - 0.1, 1.0 - c[2]];
        d.iter().map(|d| d.max(0.0).powi(2)).sum::<f64>().sqrt()
    };
    let field = |c: [f32; 3]| distance(c.map(f64::from)) as f32;
    let arm = robots::BatchOnSchedule::new(&robot, &base, 0.01, field);
    assert!(!arm.states_are_free(&[start], &[50]) && arm.states_are_free(&[start], &[0]));
    assert!(!arm.states_are_free(&[[7.0, 0.0, 0.0, 0.0, 0.0, 0.0]], &[0]));
    assert!(!arm.motions_are_free(&[start, start], &[0, 99]));
    let params = strrt::Params::default();
    let plan = strrt::plan(&arm, start, goal, base.len(), 0.1, &params, 1).unwrap();
    assert_eq!(plan.status, strrt::Status::Solved);
    let exact = OnSchedule::new(&robot, &base, 0.01, |c, r| distance(c) >= r);
    if plan.waited_before == 0 && plan.waited_after == 0 {
        for (step, pair) in plan.path.windows(2).enumerate() {
            assert!(exact.state_is_free(&pair[0], step));
            assert!(exact.motion_is_free(&pair[0], &pair[1], step, step + 1));
        }
    }
}
