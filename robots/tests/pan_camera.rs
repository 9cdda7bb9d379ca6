//! FLAP's camera over a base: poses and states go both ways.
#![allow(missing_docs, clippy::unwrap_used)]

use proptest::prelude::*;
use robots::{Error, LevelCamera, PanCamera, PanState};

proptest! {
    /// Camera pose and robot state determine each other.
    #[test]
    fn poses_and_states_go_both_ways(
        position in (-5.0..5.0f64, -5.0..5.0f64, 1.484..1.784f64),
        yaw in -7.0..7.0f64,
        pitch in -0.87..0.34f64,
    ) {
        let robot = PanCamera::default();
        let camera = LevelCamera { position: [position.0, position.1, position.2], yaw, pitch };
        let state = robot.reach(&camera).unwrap().unwrap();
        let back = robot.camera(&state);
        for a in 0..3 {
            prop_assert!((back.position[a] - camera.position[a]).abs() < 1e-12);
        }
        prop_assert_eq!((back.yaw, back.pitch), (yaw, pitch));
        // The base stands 7 cm ahead of the camera.
        let ahead = (state.base[0] - position.0) * yaw.cos() + (state.base[1] - position.1) * yaw.sin();
        prop_assert!((ahead - 0.07).abs() < 1e-12);
        // The optical frame's third axis looks along yaw and pitch.
        let axis = robot.camera_frame(&state).rotate([0.0, 0.0, 1.0]);
        let wanted = [pitch.cos() * yaw.cos(), pitch.cos() * yaw.sin(), pitch.sin()];
        for a in 0..3 {
            prop_assert!((axis[a] - wanted[a]).abs() < 1e-9);
        }
    }
}

#[test]
fn poses_beyond_the_limits_are_not_reached() {
    let robot = PanCamera::default();
    let good = LevelCamera {
        position: [0.0, 0.0, 1.6],
        yaw: 0.0,
        pitch: 0.0,
    };
    assert!(robot.reach(&good).unwrap().is_some());
    assert_eq!(robot.heights(), (1.484, 1.784));
    for camera in [
        LevelCamera {
            position: [0.0, 0.0, 1.48],
            ..good
        },
        LevelCamera {
            position: [0.0, 0.0, 1.79],
            ..good
        },
        LevelCamera {
            pitch: -0.88,
            ..good
        },
        LevelCamera {
            pitch: 0.36,
            ..good
        },
    ] {
        assert_eq!(robot.reach(&camera), Ok(None), "{camera:?}");
    }
    let nan = LevelCamera {
        yaw: f64::NAN,
        ..good
    };
    assert!(matches!(robot.reach(&nan), Err(Error::NotFinite { .. })));
    assert_eq!(robot.camera(&PanState::default()).position[2], 1.464);
}
