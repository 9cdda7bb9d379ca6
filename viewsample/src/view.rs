//! What goes into the sampler and what comes out.

use crate::map::Cell;
use crate::{Gain, Pose};

/// Which of the two searches a frontier belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Free voxels next to unknown ones.
    Exploration,
    /// Occupied voxels next to free ones, not yet seen by the colour camera.
    Inspection,
}

/// A frontier cluster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cluster<'a> {
    /// Identity; stays while the cluster is untouched.
    pub id: u64,
    /// Exploration or inspection.
    pub kind: Kind,
    /// The frontier voxels. A voxel belongs to at most one cluster of its kind.
    pub cells: &'a [Cell],
    /// Middle of the voxels in the world, m.
    pub centroid: [f64; 3],
}

/// What happened to the map and the frontiers since the last update.
#[derive(Clone, Copy, Debug, Default)]
pub struct Changes<'a> {
    /// New clusters, and changed ones under the id they had.
    pub added: &'a [Cluster<'a>],
    /// Clusters that are gone. Their voxels stop being frontier unless an added cluster has them.
    pub removed: &'a [u64],
    /// Half-open boxes of cells that hold every voxel whose state changed. The first update names
    /// the whole map.
    pub boxes: &'a [(Cell, Cell)],
}

/// A whole-body state that looks at something, and what it is worth.
#[derive(Clone, Debug, PartialEq)]
pub struct Viewpoint<S> {
    /// The cluster whose library it is from; none for a view of [`Sampler::views_from`](crate::Sampler::views_from).
    pub cluster: Option<u64>,
    /// Base pose x, y, yaw, m and rad.
    pub base: [f64; 3],
    /// Index of the posture.
    pub posture: usize,
    /// Everything but the base.
    pub state: S,
    /// world_from_camera.
    pub camera: Pose,
    /// Information gain, eq. 4.
    pub gain: Gain,
    /// Voxels of the cluster itself that are in sight.
    pub own: u32,
    /// Time to get there, s (eq. 2).
    pub seconds: f64,
    /// Motion gain, eq. 3.
    pub motion: f64,
    /// Motion gain times information gain, eq. 1.
    pub score: f64,
}

/// Why a cluster has no view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum NoView {
    /// No base position of its library is free.
    NoFreeBase,
    /// Some base positions are free, but no posture there is.
    NoFreeBody,
    /// What the free postures see is below the threshold.
    TooLittleSeen,
    /// The cost model says never.
    Unreachable,
}

/// Work done, in counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Calls of [`Robot::base_is_free`](crate::Robot::base_is_free).
    pub base_checks: u64,
    /// Calls of [`Robot::is_free`](crate::Robot::is_free).
    pub body_checks: u64,
    /// Camera poses whose cells inside the frustums were counted.
    pub camera_bounds: u64,
    /// Base positions whose LiDAR view was cast.
    pub lidar_views: u64,
    /// Camera poses whose view was cast.
    pub camera_views: u64,
}

impl std::ops::AddAssign for Effort {
    fn add_assign(&mut self, other: Self) {
        self.base_checks += other.base_checks;
        self.body_checks += other.body_checks;
        self.camera_bounds += other.camera_bounds;
        self.lidar_views += other.lidar_views;
        self.camera_views += other.camera_views;
    }
}

/// The candidate set C of Algorithm 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidates<S> {
    /// The best view of each library, by ascending cluster id.
    pub views: Vec<Viewpoint<S>>,
    /// Clusters without a view, by ascending id: dormant until the map changes near them.
    pub without: Vec<(u64, NoView)>,
    /// Work done.
    pub effort: Effort,
}
