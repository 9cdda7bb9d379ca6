//! The consumers' traits, each behind the feature of its crate's name.

#[cfg(feature = "ddp-rbf")]
mod ddp_rbf;
#[cfg(feature = "frontier")]
mod frontier;
#[cfg(feature = "hybrid-astar")]
mod hybrid_astar;
#[cfg(feature = "viewsample")]
mod viewsample;
