//! Robots that search: HEATS and its competitors, end to end in a built-in simulator
