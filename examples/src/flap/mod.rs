//! FLAP for CAOS (Gedicke, Günther and Hertzberg, 2016): search of volumes for an object by planning views ahead.
//!
//! As in the paper's evaluation the robot is placed from view to view, and the time that this would take is charged by
//! the model that the planner uses. [`run`] is one search; [`Site`] what of it several searches may share.

mod draw;
mod plans;
mod record;
mod search;
mod settings;
mod site;
mod space;
mod tap;

pub use draw::draw;
pub(crate) use draw::{Picture, draw_picture};
pub use plans::{FloorPlans, PlanError};
pub use record::{FlapResult, StepRecord, closing_table, write};
pub use search::{FlapError, Outcome, Progress, run, run_at, run_at_recorded, run_recorded};
pub use settings::{FlapSettings, MapKind, PlannerKind, SettingsError, TravelKind, ViewsKind};
pub use site::Site;
