//! The planners' traits, each behind the feature named after its crate.

#[cfg(feature = "hybrid-astar")]
mod hybrid_astar;
#[cfg(feature = "strrt")]
mod strrt;
#[cfg(feature = "viewsample")]
mod viewsample;

#[cfg(feature = "viewsample")]
pub use viewsample::library;
