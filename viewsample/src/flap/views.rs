//! Sampling and evaluating until there are enough views, or no time is left.

use super::fan::{Fan, FanPose};
use super::poses::{Limits, Target, sample_from, sample_poses};
use super::sight::SightGrid;
use crate::Error;
use crate::map::Cell;

/// How many views to make, and which to keep.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewParams {
    /// Poses towards frontier cells to evaluate at most. FLAP: 200.
    pub count: usize,
    /// Poses at the robot's place to evaluate besides. FLAP: 0.
    pub local_count: usize,
    /// Keep views that show nothing.
    pub keep_blind: bool,
    /// Seed of the poses.
    pub seed: u64,
}

impl Default for ViewParams {
    fn default() -> Self {
        Self {
            count: 200,
            local_count: 0,
            keep_blind: false,
            seed: 0,
        }
    }
}

/// A camera pose and what it is expected to show.
#[derive(Clone, Debug, PartialEq)]
pub struct FanView {
    /// The pose.
    pub pose: FanPose,
    /// Indices of the cells shown, ascending, of the [`SightGrid`] used.
    pub cells: Vec<u32>,
}

/// Tries for each view wanted.
const TRIES: usize = 100;

/// Samples poses and evaluates each, an anytime operation: `stop` is asked after each pose and before each evaluation, and what is
/// there by then is returned. `free` says whether a camera may be at a pose. `robot`: where it is now, for local poses.
///
/// # Errors
/// As [`Limits::validate`].
pub fn sample_views(
    sight: &mut SightGrid,
    fan: &Fan,
    targets: &[Target],
    limits: &Limits,
    params: &ViewParams,
    robot: [f64; 2],
    free: &mut dyn FnMut(&FanPose) -> bool,
    stop: &mut dyn FnMut() -> bool,
) -> Result<Vec<FanView>, Error> {
    let mut poses = sample_from(robot, None, limits, params.seed ^ 1, params.local_count)?;
    poses.retain(|pose| free(pose));
    let wanted = params.count + poses.len();
    if params.count > 0 && !stop() {
        let most = params.count.saturating_mul(TRIES);
        sample_poses(targets, limits, params.seed, most, &mut |pose, _| {
            if free(&pose) {
                poses.push(pose);
            }
            poses.len() < wanted && !stop()
        })?;
    }
    let mut views = Vec::with_capacity(poses.len());
    for pose in poses {
        if stop() {
            break;
        }
        let cells = sight.view(fan, &pose).to_vec();
        if params.keep_blind || !cells.is_empty() {
            views.push(FanView { pose, cells });
        }
    }
    Ok(views)
}

impl SightGrid {
    /// The cells of a view, in the map's numbers.
    pub fn cells_of(&self, view: &FanView) -> Vec<Cell> {
        view.cells.iter().map(|&i| self.cell(i)).collect()
    }
}
