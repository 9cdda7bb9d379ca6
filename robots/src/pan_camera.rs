//! FLAP's simplified PR2: a camera over the base that turns with it, lifts and tilts, and does not move in doing so.

use crate::error::Error;
use crate::frame::Frame;

/// A camera without roll in the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelCamera {
    /// Position, m.
    pub position: [f64; 3],
    /// Heading of the optical axis, rad.
    pub yaw: f64,
    /// Elevation of the optical axis, up positive, rad.
    pub pitch: f64,
}

/// State of a [`PanCamera`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PanState {
    /// x (m), y (m), yaw (rad) of the base in the world.
    pub base: [f64; 3],
    /// Lift of the torso, m.
    pub torso: f64,
    /// Tilt of the head, up positive, rad.
    pub tilt: f64,
}

/// The robot model of FLAP's planner: the base turns the camera, so that the heading is free; the torso sets its height;
/// the head tilts it about its own centre.
#[derive(Clone, Debug, PartialEq)]
pub struct PanCamera {
    /// How far the base's centre is ahead of the camera, m.
    pub base_ahead: f64,
    /// Height of the camera over the floor at zero lift, m.
    pub height: f64,
    /// Least and greatest lift of the torso, m.
    pub torso_limits: (f64, f64),
    /// Least (down) and greatest (up) tilt, rad.
    pub tilt_limits: (f64, f64),
}

impl Default for PanCamera {
    /// FLAP's PR2: camera heights of 1.484 to 1.784 m, pitch -50 to 20 degrees, base 7 cm ahead.
    fn default() -> Self {
        Self {
            base_ahead: 0.07,
            height: 1.464,
            torso_limits: (0.02, 0.32),
            tilt_limits: (-50f64.to_radians(), 20f64.to_radians()),
        }
    }
}

impl PanCamera {
    /// Least and greatest camera height, m.
    #[must_use]
    pub fn heights(&self) -> (f64, f64) {
        (
            self.height + self.torso_limits.0,
            self.height + self.torso_limits.1,
        )
    }

    /// The state that puts the camera there: there is no choice.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for a pose with NaN or infinite numbers. `Ok(None)` if torso or tilt would leave its limits.
    pub fn reach(&self, camera: &LevelCamera) -> Result<Option<PanState>, Error> {
        let finite = camera.position.iter().all(|v| v.is_finite());
        if !(finite && camera.yaw.is_finite() && camera.pitch.is_finite()) {
            return Err(Error::NotFinite {
                field: "camera pose",
            });
        }
        let within = |value: f64, (low, high): (f64, f64)| {
            // A billionth forgives heights that were computed from the limits.
            value >= low - 1e-9 && value <= high + 1e-9
        };
        let torso = camera.position[2] - self.height;
        if !(within(torso, self.torso_limits) && within(camera.pitch, self.tilt_limits)) {
            return Ok(None);
        }
        let (s, c) = camera.yaw.sin_cos();
        Ok(Some(PanState {
            base: [
                camera.position[0] + self.base_ahead * c,
                camera.position[1] + self.base_ahead * s,
                camera.yaw,
            ],
            torso,
            tilt: camera.pitch,
        }))
    }

    /// Where the camera is in a state.
    #[must_use]
    pub fn camera(&self, state: &PanState) -> LevelCamera {
        let [x, y, yaw] = state.base;
        let (s, c) = yaw.sin_cos();
        LevelCamera {
            position: [
                x - self.base_ahead * c,
                y - self.base_ahead * s,
                self.height + state.torso,
            ],
            yaw,
            pitch: state.tilt,
        }
    }

    /// world_from_camera in a state; optical frame (z forward, x right, y down).
    #[must_use]
    pub fn camera_frame(&self, state: &PanState) -> Frame {
        let camera = self.camera(state);
        crate::posture::looking(camera.position, camera.yaw, camera.pitch)
    }
}
