//! `ddp_rbf::Field` for [`Esdf`]: the trilinear value and the gradient of the same interpolant.

use crate::Esdf;
use ddp_rbf::Field;

impl Field for Esdf {
    fn distance_gradient(&self, point: [f64; 3]) -> (f64, [f64; 3]) {
        Self::distance_gradient(self, point)
    }
}
