//! A checker for models: Jacobians against central differences.

use crate::error::Error;
use crate::robot::Robot;
use nalgebra::SVector;

/// Compares the Jacobians of a robot's flow at one point with central differences, to a relative tolerance.
///
/// # Errors
/// [`Error::Jacobian`] with the entry that disagrees most.
pub fn check_jacobians<const NX: usize, const NU: usize>(
    robot: &(impl Robot<NX, NU> + ?Sized),
    x: &SVector<f64, NX>,
    u: &SVector<f64, NU>,
    tolerance: f64,
) -> Result<(), Error> {
    let (a, b) = robot.jacobians(x, u);
    let mut worst = tolerance;
    let mut found = Ok(());
    for column in 0..NX + NU {
        let (mut x1, mut x0, mut u1, mut u0) = (*x, *x, *u, *u);
        let size = if column < NX {
            x[column]
        } else {
            u[column - NX]
        };
        let h = 1e-6 * (1.0 + size.abs());
        if column < NX {
            x1[column] += h;
            x0[column] -= h;
        } else {
            u1[column - NX] += h;
            u0[column - NX] -= h;
        }
        let slope = (robot.flow(&x1, &u1) - robot.flow(&x0, &u0)) / (2.0 * h);
        for row in 0..NX {
            let given = if column < NX {
                a[(row, column)]
            } else {
                b[(row, column - NX)]
            };
            let expected = slope[row];
            let error = (given - expected).abs() / (1.0 + expected.abs());
            if error > worst || error.is_nan() {
                worst = error;
                found = Err(Error::Jacobian {
                    row,
                    column,
                    given,
                    expected,
                });
            }
        }
    }
    found
}
