//! The planners that HEATS compares itself with, in the same simulator: AEP and WG-NBVP.
//!
//! - **AEP**: Selin, Tiger, Duberg, Heintz and Jensfelt, "Efficient Autonomous Exploration Planning of Large-Scale 3-D Environments",
//!   RA-L 2019. A tree near the robot, each node with the unknown volume that its best yaw shows (sparse rays, or a Gaussian process
//!   over cached gains); where the best branch scores too little, the cheapest cached place that still promises much.
//! - **WG-NBVP**: Naazare, Garcia Rosas and Schulz, "Online Next-Best-View Planner for 3D-Exploration and Inspection With a Mobile
//!   Manipulator Robot", RA-L 2022. A tree of camera poses around the arm, each with a weighted sum of unknown volume, measurement and
//!   a penalty for visited places; the arm takes up what it reaches of the best branch, else the base moves to the nearest of the
//!   best cached views.
//!
//! Both see with the depth camera alone, as in the HEATS paper (sect. VI-B), and have map, limits, start pose, time limit, collision
//! rules, controller and clock of HEATS. Their planning time is counted likewise: voxels looked up, samples, regressions.
//!
//! # Where they depart from what was published, and why
//!
//! Both:
//! - The camera is carried by an arm on a base that drives on the floor. A view is taken up by the base pose (on rings around the camera)
//!   and arm posture that are quickest, base first and arm after it (decoupled, as the HEATS paper has it). An arm that would touch
//!   something on the way is drawn in before the base drives.
//! - The range of gains is that of our depth camera, 4 m; volumes that are thresholds or normalisers are scaled with the full view.
//! - Volume is integrated with the exact cell, and yaws are compared with parts of columns; the published code rounds both.
//! - A view that cannot be reached is excluded for a time that doubles, so that the planner cannot ask for it for ever.
//! - Distances to cached goals are ways over the ground, from one search that finds them all, in place of straight lines (WG-NBVP) or of
//!   a second tree of 100 nodes (AEP) that in a large building often finds none.
//!
//! AEP:
//! - Heights are those the arm reaches; a disc of the base's width must stand on free ground below each node.
//! - The tree is rewired rightly (the published code passes the wrong node).
//! - Where the published planner declares the exploration complete its thresholds are halved, down to
//!   [`AepSettings::least_share`]: rooms have pockets smaller than the 16 m3 of a multicopter's halls.
//! - Four moves in a row that uncover next to nothing end the local search for this time, and a goal visited twice is no goal any
//!   more: rays through gaps promise volume that images do not show.
//!
//! WG-NBVP:
//! - The task has no radiation or gas to measure, so the published weights for exploring free space apply. With
//!   [`Measure::Inspection`] the measurement of a pose is the surface still to be inspected within 1.5 m, and the yaw turns to it: it
//!   then stays long where it is and sees less of the building.
//! - What the arm reaches is told by inverse kinematics with collision checks rather than by a distance of 1.3 m.
//! - Rays end at the scene's border, not at the camera's height band, and at the robot's own base.

mod aep;
mod first_look;
mod gain;
mod gp;
mod planner;
mod rig;
mod run;
mod settings;
mod stand;
#[cfg(test)]
mod tests;
mod view;
mod wg_nbvp;

pub use gain::{BestView, RayParams, Rays};
pub use gp::{Kernel, Posterior, predict};
pub use run::{run, run_recorded};
pub use settings::{
    AepSettings, Baseline, BaselineSettings, Measure, RaySettings, StandSettings, WgNbvpSettings,
};
