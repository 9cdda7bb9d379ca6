//! Object search plans that minimise the expected time to find a target
