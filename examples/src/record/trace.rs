//! What a run leaves behind for pictures: the way of the robot and its last map.

use super::topdown::Outline;

/// One sample of the robot's way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Simulated time, s.
    pub time: f64,
    /// Base pose x, y, yaw in the world frame, m and rad.
    pub base: [f64; 3],
    /// Camera position in the world frame, m.
    pub camera: [f64; 3],
}

/// A viewpoint that was reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Simulated time, s.
    pub time: f64,
    /// Camera position in the world frame, m.
    pub camera: [f64; 3],
    /// Optical axis in the world frame, unit.
    pub axis: [f64; 3],
}

/// What the robot knows of one ground cell, for the coverage layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coverage {
    /// Nothing.
    Unknown,
    /// Known free at driving height.
    Free,
    /// Holds an occupied voxel, none of them inspected.
    Occupied,
    /// Holds occupied voxels, some or all inspected.
    Inspected,
}

/// The last state of the map seen from above.
#[derive(Clone, Debug, PartialEq)]
pub struct MapLayer {
    /// Edge of a cell, m.
    pub cell_size: f64,
    /// World position of the lower corner, m.
    pub low: [f64; 2],
    /// Cells along x and y.
    pub size: [usize; 2],
    /// Row-major, x fastest.
    pub coverage: Vec<Coverage>,
    /// Region label of each cell, `None` outside regions; same order.
    pub regions: Vec<Option<u32>>,
}

/// Everything a picture of a run needs besides the scene and the result.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// The way, sampled at a fixed period.
    pub samples: Vec<Sample>,
    /// Reached viewpoints.
    pub stops: Vec<Stop>,
    /// Solids that came while the run was under way.
    pub intruders: Vec<Outline>,
    /// The last map, if the run got that far.
    pub map: Option<MapLayer>,
}
