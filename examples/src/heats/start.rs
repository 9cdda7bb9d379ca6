//! Where a run begins, if not where the scene says and with the arm drawn in.

use super::body::Joints;
use super::settings::SettingsError;
use crate::scene::{Footprint, Scene, SceneError, Start};
use serde::{Deserialize, Serialize};

/// The robot's first state. Absent parts are as ever: the scene's start, and the first posture of the library.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StartSettings {
    /// Base pose x, y, yaw, m and rad, in place of the scene's.
    pub base: Option<[f64; 3]>,
    /// Joint angles, rad.
    pub joints: Option<Joints>,
}

impl StartSettings {
    /// True if all is as ever.
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }

    /// Checks that all is finite. What is in the way of the robot is told when the run begins.
    ///
    /// # Errors
    /// [`SettingsError::Range`].
    pub fn validate(&self) -> Result<(), SettingsError> {
        let finite = |field, values: &[f64]| match values.iter().find(|v| !v.is_finite()) {
            None => Ok(()),
            Some(&value) => Err(SettingsError::Range {
                field,
                value,
                wanted: "finite",
            }),
        };
        finite("start.base", self.base.as_ref().map_or(&[], |b| &b[..]))?;
        finite("start.joints", self.joints.as_ref().map_or(&[], |j| &j[..]))
    }

    /// The scene with this start in place of its own; none if it keeps its own.
    ///
    /// # Errors
    /// [`SceneError`] if the base cannot stand there.
    pub fn scene(&self, scene: &Scene) -> Result<Option<Scene>, SceneError> {
        let Some([x, y, yaw]) = self.base else {
            return Ok(None);
        };
        let moved = Scene {
            start: Start { x, y, yaw },
            ..scene.clone()
        };
        moved.check(&Footprint::default())?;
        Ok(Some(moved))
    }
}
