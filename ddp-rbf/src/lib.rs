//! Differential dynamic programming with relaxed barriers for whole-body model predictive control.
//!
//! [`Solver`] minimises a cost over a horizon of inputs by Gauss-Newton DDP (iLQR) with multiple shooting; inequality
//! constraints enter as [`Barrier`]s (HEATS eq. 9), so that a solve never fails for infeasibility. [`Mpc`] keeps it warm from
//! control step to control step, and [`guard`](guard()) checks a command against braking before it leaves.
//!
//! ```
//! use ddp_rbf::{Barrier, InputBox, Options, Robot, Solver, Status, Tracking};
//! use nalgebra::{SMatrix, SVector, matrix, vector};
//!
//! // A cart: position and speed, pushed by a force of at most 1.
//! struct Cart;
//! impl Robot<2, 1> for Cart {
//!     fn flow(&self, x: &SVector<f64, 2>, u: &SVector<f64, 1>) -> SVector<f64, 2> { vector![x[1], u[0]] }
//!     fn jacobians(&self, _: &SVector<f64, 2>, _: &SVector<f64, 1>) -> (SMatrix<f64, 2, 2>, SMatrix<f64, 2, 1>) {
//!         (matrix![0.0, 1.0; 0.0, 0.0], matrix![0.0; 1.0])
//!     }
//! }
//! // Go to 1 and stand there.
//! let cost = Tracking::new(vec![vector![1.0, 0.0]; 41], vec![vector![0.0]; 40], 0.1,
//!     vector![1.0, 0.1], vector![0.01], vector![100.0, 10.0]);
//! let push = InputBox::new(vector![-1.0], vector![1.0], Barrier::default());
//! let mut solver = Solver::new(40, 0.1)?;
//! let report = solver.solve(&Cart, &cost, &[&push], &vector![0.0, 0.0], &Options::default())?;
//! assert_eq!(report.status, Status::Converged);
//! assert!((solver.states()[40] - vector![1.0, 0.0]).norm() < 0.05);
//! assert!(solver.inputs().iter().all(|u| u[0].abs() < 1.0));
//! # Ok::<(), ddp_rbf::Error>(())
//! ```
//!
//! # Cost
//!
//! An iteration is linear in the knots and cubic in states and inputs of one knot, whose numbers are fixed at compile time. Memory is a few
//! matrices for each knot; nothing is allocated after construction.
//!
//! # Limits
//!
//! A solve finds a local optimum near its guess, from which a wall between two ways is not crossed. Barriers are relaxed: a constraint may be
//! cut by some millimetres, and only the guard promises clearance.
//!
//! # Citation
//!
//! Please cite seekplan (`CITATION.cff` of the repository) and HEATS (Zhang et al.), sect. V-B, eq. 6-9.

mod barrier;
mod chain;
mod check;
mod clearance;
mod constraint;
mod cost;
#[cfg(feature = "faer")]
mod dense;
mod elementary;
mod error;
mod field;
mod guard;
mod kinematic;
mod limits;
mod mpc;
pub mod ode;
#[cfg(feature = "clarabel")]
mod projection;
mod riccati;
mod robot;
mod safety;
mod simd;
mod solver;

pub use barrier::Barrier;
pub use chain::{Chain, Joint, LinkSphere, MAX_JOINTS, MAX_SPHERES};
pub use check::{check_constraint, check_cost, check_jacobians, check_step};
pub use clearance::{PairClearance, PlaneClearance, SphereClearance};
pub use constraint::{Constraint, Horizon, Penalty};
pub use cost::{CostModel, Expansion, Tracking};
#[cfg(feature = "faer")]
pub use dense::{LqProblem, LqSolution, LqStage};
pub use error::Error;
pub use field::{BoxField, Field, GridField};
pub use guard::{GuardParams, Verdict, guard};
pub use kinematic::{Accelerated, DriveArm};
pub use limits::{HalfSpaces, InputBox, StateBox};
pub use mpc::{Mpc, Statistics};
pub use nalgebra;
pub use robot::{Linear, Robot};
pub use safety::{Braking, Counts, SafetyLayer, SafetyParams};
pub use simd::{LANES, Lanes};
pub use solver::{Group, Options, Report, Solver, Status};

/// The code of the README is tested.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
