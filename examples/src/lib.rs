//! Robots that search: HEATS and its competitors, end to end in a built-in simulator.
//!
//! [`scene`] and [`sim`] make the world (or [`generate`] does, at any size), [`heats`], [`flap`] and [`baselines`] search it, [`record`] keeps what happened, [`cli`] is the command line.

pub mod baselines;
pub mod bench;
pub mod cli;
pub mod clock;
pub mod flap;
pub mod generate;
pub mod heats;
pub mod record;
pub mod report;
pub mod scene;
pub mod sim;
mod tree;

/// The code of the README is tested.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
