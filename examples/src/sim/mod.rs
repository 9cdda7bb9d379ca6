//! The kinematic simulator: exact geometry, sensors, robot motion, and the ground truth that judges a run.
//!
//! Planners never read this module's world; they see scans, images, the robot's own state and nothing else.

mod body;
mod camera;
mod clearance;
mod detector;
mod distance;
mod drift;
mod intruder;
mod lidar;
mod noise;
mod raster;
mod seen;
mod speckle;
mod step;
mod tree;
mod truth;
mod world;

pub use body::{Body, CameraPose, Kinematics, Part, PartShape};
pub use camera::{DepthCamera, DepthModel};
pub use clearance::Clearance;
pub use detector::{Detection, TagCamera, TagDetector};
pub use drift::{Drift, DriftModel};
pub use lidar::{Lidar, LidarModel};
pub use noise::Noise;
pub use raster::Pinhole;
pub use seen::SurfaceSeen;
pub(crate) use step::stoppable;
pub use step::{Command, Due, JOINTS, MotionLimits, Simulator, StartError, State, TICK, Tally};
pub use truth::{GroundTruth, GroundTruthError};
pub use world::World;

/// What a range sensor returned, as world points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointScan {
    /// Where the rays start, m.
    pub origin: [f64; 3],
    /// Points on surfaces, m.
    pub hits: Vec<[f32; 3]>,
    /// End points, at [`max_range`](Self::max_range), of rays that met nothing, m.
    pub misses: Vec<[f32; 3]>,
    /// Longest range of the sensor, m.
    pub max_range: f64,
}
