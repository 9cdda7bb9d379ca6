//! The consumers' traits, each behind the feature of its crate's name.

#[cfg(feature = "frontier")]
mod frontier;
