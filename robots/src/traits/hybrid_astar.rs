//! Base paths: the footprint.

use crate::base::BaseShape;
use crate::manipulator::{Limits, MobileManipulator};

impl hybrid_astar::Robot for BaseShape {
    fn circles(&self) -> &[([f64; 2], f64)] {
        &self.circles
    }
    fn outline(&self) -> &[[f64; 2]] {
        &self.outline
    }
}

impl hybrid_astar::Robot for MobileManipulator {
    fn circles(&self) -> &[([f64; 2], f64)] {
        &self.base.circles
    }
    fn outline(&self) -> &[[f64; 2]] {
        &self.base.outline
    }
}

impl From<&Limits> for hybrid_astar::Limits {
    fn from(limits: &Limits) -> Self {
        Self {
            v: limits.speed,
            w: limits.turn_speed,
            a: limits.acceleration,
            alpha: limits.turn_acceleration,
        }
    }
}
