//! Robots that search: HEATS and its competitors, end to end in a built-in simulator

pub mod clock;
pub mod scene;
pub mod sim;
