//! Forward kinematics and whole-body collision checks of sixteen states at once, in single precision.
//!
//! Plain arrays of fixed width; the same source is compiled for the baseline and for AVX2, and the machine decides at
//! run time. Results of the two may differ in the last bit.

mod check;
mod dispatch;
mod field;
mod lanes;
mod model;
mod schedule;

pub use field::{BatchField, GridField};
pub use lanes::{LANES, Lanes};
pub use model::{BatchBody, SphereLanes, StateBlock};
pub use schedule::BatchOnSchedule;
