//! A PR2-like robot: a base that turns on the spot, a torso that lifts, a head that pans and tilts a camera.

use crate::error::Error;
use crate::frame::Frame;
use crate::ik::wrap;
use std::f64::consts::PI;

/// State of a [`LiftHead`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeadState {
    /// x (m), y (m), yaw (rad) of the base in the world.
    pub base: [f64; 3],
    /// Lift of the torso, m.
    pub torso: f64,
    /// Pan of the head to the left, rad.
    pub pan: f64,
    /// Tilt of the head, rad; down is positive, as in the maker's description.
    pub tilt: f64,
}

/// Base, torso lift, head pan and tilt; `Default` is the PR2 by its robot description.
///
/// Lengths in m, along the base's x (forward) and z.
#[derive(Clone, Debug, PartialEq)]
pub struct LiftHead {
    /// Half of the square footprint's side.
    pub half_width: f64,
    /// (x, z) of the torso at zero lift, over the floor.
    pub torso: [f64; 2],
    /// (x, z) of the pan axis's origin on the torso.
    pub pan: [f64; 2],
    /// (x, z) of the tilt axis on the panned head.
    pub tilt: [f64; 2],
    /// (x, z) of the camera on the tilted head; it looks along x.
    pub camera: [f64; 2],
    /// Least and greatest lift.
    pub torso_limits: (f64, f64),
    /// Least and greatest pan, rad.
    pub pan_limits: (f64, f64),
    /// Least (up) and greatest (down) tilt, rad.
    pub tilt_limits: (f64, f64),
    /// Greatest speeds of torso (m/s), pan and tilt (rad/s).
    pub speeds: [f64; 3],
}

impl Default for LiftHead {
    /// Hard limits and speeds of the PR2's robot description; the camera 0.292 m above the pan axis's origin, which
    /// gives heights of 1.464 m and more at level tilt.
    fn default() -> Self {
        Self {
            half_width: 0.334,
            torso: [-0.05, 0.051 + 0.739_675],
            pan: [-0.01707, 0.38145],
            tilt: [0.068, 0.0],
            camera: [0.0232, 0.292],
            torso_limits: (0.0115, 0.305),
            pan_limits: (-3.007, 3.007),
            tilt_limits: (-0.471, 1.396),
            speeds: [0.013, 6.0, 5.0],
        }
    }
}

impl LiftHead {
    /// The figures printed in the FLAP paper and used by its program: pan over 350 and tilt over 115 degrees, camera
    /// heights of 1.484 to 1.784 m, lift 0.01 m/s, head half a turn a second.
    #[must_use]
    pub fn flap() -> Self {
        let half = 175.0f64.to_radians();
        Self {
            torso_limits: (0.020, 0.320),
            pan_limits: (-half, half),
            tilt_limits: (-0.471, 115.0f64.to_radians() - 0.471),
            speeds: [0.01, PI, PI],
            ..Self::default()
        }
    }

    /// (x, z) of the tilt axis relative to the pan axis's foot on the floor, at a lift.
    fn tilt_axis(&self, torso: f64) -> [f64; 2] {
        [
            self.tilt[0],
            self.torso[1] + torso + self.pan[1] + self.tilt[1],
        ]
    }

    /// (x, z) of the camera relative to the tilt axis.
    fn camera_offset(&self, tilt: f64) -> [f64; 2] {
        let (s, c) = tilt.sin_cos();
        [
            self.camera[0] * c + self.camera[1] * s,
            self.camera[1] * c - self.camera[0] * s,
        ]
    }

    /// Distance of the pan axis ahead of the base's turning centre.
    fn axis_ahead(&self) -> f64 {
        self.torso[0] + self.pan[0]
    }

    /// world_from_camera; optical frame (z forward, x right, y down).
    #[must_use]
    pub fn camera_frame(&self, state: &HeadState) -> Frame {
        let [x, y, yaw] = state.base;
        let (axis, offset) = (self.tilt_axis(state.torso), self.camera_offset(state.tilt));
        let ahead = axis[0] + offset[0];
        let heading = yaw + state.pan;
        let ((sy, cy), (sh, ch)) = (yaw.sin_cos(), heading.sin_cos());
        let a = self.axis_ahead();
        let p = [
            x + a * cy + ahead * ch,
            y + a * sy + ahead * sh,
            axis[1] + offset[1],
        ];
        crate::posture::looking(p, heading, -state.tilt)
    }

    /// The state that puts the camera at `position` (m), looking towards `heading` and `pitch` (rad, up is
    /// positive), with the base at yaw `yaw`; the camera has no roll. `None` if a joint would leave its limits.
    ///
    /// The three joints and the base's place are fixed by these: tilt by the pitch, lift by the height, pan by the
    /// yaw that is left.
    #[must_use]
    pub fn reach(
        &self,
        position: [f64; 3],
        heading: f64,
        pitch: f64,
        yaw: f64,
    ) -> Option<HeadState> {
        let tilt = -pitch;
        let (axis, offset) = (self.tilt_axis(0.0), self.camera_offset(tilt));
        let torso = position[2] - axis[1] - offset[1];
        let ahead = axis[0] + offset[0];
        let ((sy, cy), (sh, ch)) = (yaw.sin_cos(), heading.sin_cos());
        let a = self.axis_ahead();
        let base = [
            position[0] - ahead * ch - a * cy,
            position[1] - ahead * sh - a * sy,
            yaw,
        ];
        let state = HeadState {
            base,
            torso,
            pan: wrap(heading - yaw),
            tilt,
        };
        self.limit_violation(&state).is_none().then_some(state)
    }

    /// Pan and tilt that bring `point` (m, world) to the middle of the image, with the base and lift of `state`;
    /// `None` if a joint would leave its limits or the point is too near to the tilt axis.
    #[must_use]
    pub fn look_at(&self, state: &HeadState, point: [f64; 3]) -> Option<HeadState> {
        let [x, y, yaw] = state.base;
        let (sy, cy) = yaw.sin_cos();
        let a = self.axis_ahead();
        let (dx, dy) = (point[0] - x - a * cy, point[1] - y - a * sy);
        let axis = self.tilt_axis(state.torso);
        let (ahead, up) = (dx.hypot(dy) - axis[0], point[2] - axis[1]);
        // In the tilted frame the point must lie at the camera's height: R sin(tilt + elevation) = camera z.
        let sine = self.camera[1] / ahead.hypot(up);
        if sine.is_nan() || sine.abs() > 1.0 {
            return None;
        }
        let tilt = wrap(sine.asin() - up.atan2(ahead));
        let found = HeadState {
            pan: wrap(dy.atan2(dx) - yaw),
            tilt,
            ..*state
        };
        // The other root looks backwards.
        let (s, c) = tilt.sin_cos();
        let forward = ahead * c - up * s > self.camera[0];
        (forward && self.limit_violation(&found).is_none()).then_some(found)
    }

    /// The first joint (0 torso, 1 pan, 2 tilt) outside its limits, with the amount (m or rad); NaN is infinitely
    /// far outside.
    #[must_use]
    pub fn limit_violation(&self, state: &HeadState) -> Option<(usize, f64)> {
        let joints = [
            (state.torso, self.torso_limits),
            (state.pan, self.pan_limits),
            (state.tilt, self.tilt_limits),
        ];
        joints
            .iter()
            .enumerate()
            .find_map(|(j, &(q, (low, high)))| {
                let out = (low - q).max(q - high);
                if q.is_nan() {
                    Some((j, f64::INFINITY))
                } else {
                    (out > 1e-12).then_some((j, out))
                }
            })
    }

    /// Seconds that torso and head need between two states, all joints moving at once at full speed.
    ///
    /// # Errors
    /// If a number is not finite.
    pub fn seconds(&self, from: &HeadState, to: &HeadState) -> Result<f64, Error> {
        let moves = [
            to.torso - from.torso,
            to.pan - from.pan,
            to.tilt - from.tilt,
        ];
        if moves.iter().any(|d| !d.is_finite()) {
            return Err(Error::NotFinite {
                field: "head state",
            });
        }
        Ok((0..3)
            .map(|j| moves[j].abs() / self.speeds[j])
            .fold(0.0, f64::max))
    }
}
