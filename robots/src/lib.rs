//! Kinematics of mobile manipulators: a UR5e on a differential-drive base, with a camera on the flange.
//!
//! - [`Ur5e`]: forward kinematics, Jacobian, and closed-form inverse kinematics that lists every branch, flags
//!   singular sets and never loses the last solution there.
//! - [`MobileManipulator`]: base, arm, camera and LiDAR together; collision spheres that contain the solids
//!   ([`spheres`](MobileManipulator::spheres)), the solids themselves
//!   ([`link_capsules`](MobileManipulator::link_capsules)), self-clearance, camera inverse kinematics, and
//!   [`compensate_yaw`](MobileManipulator::compensate_yaw) for a base that came to stand differently than planned.
//! - [`BatchBody`]: the whole-body check of sixteen states at once against a distance field, vectorised.
//! - [`Chain`]: any serial arm from data; from a URDF with a small file beside it (feature `urdf`), with differential
//!   inverse kinematics under joint and speed limits (feature `diff-ik`).
//! - [`LiftHead`]: a PR2-like robot whose camera sits on a pan-tilt head over a lifting torso.
//! - [`PanCamera`]: FLAP's simpler model of the same robot, whose camera turns with the base and stays in place.
//! - [`Posture`]: arm states that look ahead from a wanted height at a wanted elevation.
//!
//! Metres, radians, seconds. The base frame has x forward, z up and its origin on the floor at the turning centre;
//! the camera's optical frame has z forward, x right, y down. Nothing on the planning path allocates.
//!
//! ```
//! use robots::{BodyState, IkSolutions, MobileManipulator};
//!
//! let robot = MobileManipulator::default();
//! let joints = [0.3, -1.2, 1.5, -0.4, 1.3, 0.2];
//!
//! // Closed-form inverse kinematics gives the joints back, among the other branches.
//! let mut found = IkSolutions::default();
//! robot.arm.ik(&robot.arm.fk(&joints), &mut found);
//! assert_eq!(found.len(), 8);
//! let close = |q: &[f64; 6]| q.iter().zip(&joints).all(|(a, b)| (a - b).abs() < 1e-9);
//! assert!(found.as_slice().iter().any(|s| close(&s.joints)));
//!
//! // The base was to stop at yaw 0.5 but stopped at 0.9 and 5 cm short: the camera still gets to its pose.
//! let goal = BodyState { base: [1.0, 2.0, 0.5], joints };
//! let fixed = robot.compensate_yaw(&goal, [0.95, 2.0, 0.9], &joints)?;
//! assert!(fixed.exact && fixed.position_error < 1e-9);
//!
//! // Spheres that contain the robot there, for a distance field.
//! let body = robot.spheres(&BodyState { base: [0.95, 2.0, 0.9], joints: fixed.joints });
//! assert_eq!(body.arm().len(), 25);
//! # Ok::<(), robots::Error>(())
//! ```
//!
//! # Cost
//!
//! Closed-form kinematics take constant time and never allocate; [`Chain`]'s inverse kinematics iterate, each time in proportion to the
//! joints. A whole-body check looks up every sphere once.
//!
//! # Limits
//!
//! Closed forms are for the UR5e's geometry. [`Chain`] finds a solution near its start or says that it found none, which is no proof.
//! Collision spheres contain the solids: self-clearance is never too large and somewhat too small.
//!
//! # Citation
//!
//! Please cite seekplan (`CITATION.cff` of the repository).

mod base;
mod batch;
mod body;
mod camera;
mod chain;
mod collision;
mod cover;
#[cfg(feature = "diff-ik")]
mod diff_ik;
mod error;
mod frame;
mod head;
mod ik;
mod jacobians;
mod manipulator;
#[cfg(feature = "ddp-rbf")]
mod mpc;
mod pan_camera;
mod posture;
mod shapes;
mod traits;
mod ur5e;
#[cfg(feature = "urdf")]
mod urdf;
mod view;
mod world;

pub use base::*;
pub use batch::{
    BatchBody, BatchField, BatchOnSchedule, GridField, LANES, Lanes, SphereLanes, StateBlock,
};
pub use body::*;
pub use camera::*;
pub use chain::{Chain, ChainJoint, ChainSphere, JointKind};
#[cfg(feature = "diff-ik")]
pub use diff_ik::{DiffIk, IkFound, IkStep};
pub use error::Error;
pub use frame::Frame;
pub use head::{HeadState, LiftHead};
pub use ik::{IkSolution, IkSolutions, Singular};
pub use jacobians::*;
pub use manipulator::*;
#[cfg(feature = "ddp-rbf")]
pub use mpc::{FieldClearance, SelfClearance};
pub use pan_camera::{LevelCamera, PanCamera, PanState};
pub use posture::*;
pub use shapes::{CAMERA_LINK, CAPSULES, Capsule, Cuboid, LinkSizes, Sphere};
#[cfg(feature = "viewsample")]
pub use traits::library;
pub use ur5e::Ur5e;
#[cfg(feature = "urdf")]
pub use urdf::{UrdfCamera, UrdfSide, UrdfSphere};
pub use view::*;
pub use world::{InWorld, OnSchedule};

/// The code of the README is tested.
#[doc = include_str!("../README.md")]
#[cfg(doctest)]
pub struct ReadmeDoctests;
