//! Robots that search: HEATS and its competitors, end to end in a built-in simulator.
//!
//! [`scene`] and [`sim`] make the world, [`heats`] searches it, [`record`] keeps what happened, [`cli`] is the command line.

pub mod cli;
pub mod clock;
pub mod heats;
pub mod record;
pub mod report;
pub mod scene;
pub mod sim;
