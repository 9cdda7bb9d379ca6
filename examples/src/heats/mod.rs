//! HEATS: explore an unknown building and inspect every occupied surface to find tags, with a mobile manipulator.
//!
//! Zhang, Wang, Zhang, Wang and Chen, "HEATS: A Hierarchical Framework for Efficient Autonomous Target Search with Mobile
//! Manipulators". The pipeline composes the workspace's crates: [`mapping`](Mapper) → frontiers → viewpoints →
//! [`decide`] → whole-body path → control, closed over the simulator.

mod body;
mod control;
mod decision;
mod failures;
mod fault;
#[cfg(test)]
mod fixture;
mod glance;
mod mapping;
mod motion;
mod pace;
mod returns;
mod search;
mod settings;
mod start;
mod targets;

pub use body::{Exact, Joints, Whole};
pub use control::Controller;
pub use decision::{Considered, Stand, Ways, decide};
pub use failures::Failures;
pub use fault::{
    BudgetFault, BudgetStage, DoorFault, FaultSettings, LocalisationFault, PersonFault,
    SilenceFault, SilentSensor,
};
pub use mapping::Mapper;
pub use motion::{BodyPath, Failure, MotionParams};
pub(crate) use motion::{STEP, is_clear, plan_arm, plan_base};
pub use pace::Pace;
pub(crate) use pace::trapezoid;
pub use search::{HeatsError, Run, run, run_recorded};
pub(crate) use search::{Tap, map_layer};
pub use settings::{
    DecisionSettings, FrontierSettings, MapSettings, MotionSettings, Planner, PlanningTime,
    Sensors, Settings, SettingsError, ViewSettings,
};
pub use start::StartSettings;
pub use targets::{Choice, Targets};
