//! Asymmetric travelling-salesman tours and paths in milliseconds, and the two-level decision of HEATS
