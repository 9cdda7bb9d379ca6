//! What tests of the pipeline begin with.

use super::body::Joints;
use super::mapping::Mapper;
use super::settings::Settings;
use crate::scene::Scene;
use robots::{MobileManipulator, PostureWeights, View};

/// The map of the embedded closet in which all is known to be free.
pub(super) fn free_closet() -> Mapper {
    let scene = Scene::builtin("closet").expect("embedded");
    let mut mapper = Mapper::new(&scene, &Settings::default()).expect("a small map");
    mapper.map.set_free_sphere([2.0, 2.0, 1.0], 20.0);
    let _ = mapper.refresh();
    mapper
}

/// Joints that hold the camera 1.1 m high at an elevation, rad.
pub(super) fn looking(robot: &MobileManipulator, pitch: f64) -> Joints {
    let view = View { height: 1.1, pitch };
    let postures = robot.postures(&[view], &PostureWeights::default());
    postures.expect("in reach")[0].joints
}
