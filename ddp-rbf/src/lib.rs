//! Differential dynamic programming with relaxed barriers for whole-body model predictive control
