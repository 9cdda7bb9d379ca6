//! Checkers for models: derivatives against central differences, naming the entry that is wrong.

use crate::constraint::Constraint;
use crate::cost::{CostModel, Expansion};
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
    let mut worst = Worst::new("Jacobian of the flow", tolerance);
    for_each_direction(x, u, |column, [(x1, u1), (x0, u0)], width| {
        let slope = (robot.flow(&x1, &u1) - robot.flow(&x0, &u0)) / width;
        for row in 0..NX {
            let given = if column < NX {
                a[(row, column)]
            } else {
                b[(row, column - NX)]
            };
            worst.compare(row, column, given, slope[row]);
        }
    });
    worst.result()
}

/// Compares the derivatives of a robot's discrete step, single and over a horizon, with central differences.
///
/// # Errors
/// [`Error::Jacobian`] with the entry that disagrees most.
pub fn check_step<const NX: usize, const NU: usize>(
    robot: &(impl Robot<NX, NU> + ?Sized),
    x: &SVector<f64, NX>,
    u: &SVector<f64, NU>,
    dt: f64,
    tolerance: f64,
) -> Result<(), Error> {
    let (a, b) = robot.linearize(x, u, dt);
    let mut all = [crate::robot::Linear {
        a: a * 0.0,
        b: b * 0.0,
    }];
    robot.linearize_all(
        std::slice::from_ref(x),
        std::slice::from_ref(u),
        dt,
        &mut all,
    );
    let mut single = Worst::new("derivative of the step", tolerance);
    let mut batch = Worst::new("derivative of the step over a horizon", tolerance);
    for_each_direction(x, u, |column, [(x1, u1), (x0, u0)], width| {
        let slope = (robot.step(&x1, &u1, dt) - robot.step(&x0, &u0, dt)) / width;
        for row in 0..NX {
            let (one, many) = if column < NX {
                (a[(row, column)], all[0].a[(row, column)])
            } else {
                (b[(row, column - NX)], all[0].b[(row, column - NX)])
            };
            single.compare(row, column, one, slope[row]);
            batch.compare(row, column, many, slope[row]);
        }
    });
    single.result().and(batch.result())
}

/// Compares the gradients of a constraint group at one knot with central differences of its values. The row that is named
/// is the number of the constraint as it is visited. Give a barrier without a cut-off, so that every constraint is visited.
///
/// # Errors
/// [`Error::Jacobian`] with the entry that disagrees most; [`Error::Visits`] if rows and values differ in number or value.
pub fn check_constraint<const NX: usize, const NU: usize>(
    constraint: &(impl Constraint<NX, NU> + ?Sized),
    k: usize,
    x: &SVector<f64, NX>,
    u: Option<&SVector<f64, NU>>,
    tolerance: f64,
) -> Result<(), Error> {
    let values = |x: &SVector<f64, NX>, u: &SVector<f64, NU>, given: bool| {
        let mut out = Vec::new();
        constraint.values(k, x, given.then_some(u), &mut |z| out.push(z));
        out
    };
    let given = u.is_some();
    let u = u.copied().unwrap_or_else(SVector::zeros);
    let here = values(x, &u, given);
    let mut rows = Vec::new();
    constraint.rows(k, x, given.then_some(&u), &mut |z, zx, zu| {
        rows.push((z, *zx, *zu))
    });
    let wrong = (0..rows.len().max(here.len())).find(|&i| match (rows.get(i), here.get(i)) {
        (Some((z, _, _)), Some(v)) => (z - v).abs() > 1e-9 * (1.0 + v.abs()),
        _ => true,
    });
    if let Some(index) = wrong {
        return Err(Error::Visits {
            group: constraint.name(),
            index,
        });
    }
    let mut worst = Worst::new("gradient of a constraint", tolerance);
    for_each_direction(x, &u, |column, [(x1, u1), (x0, u0)], width| {
        let (high, low) = (values(&x1, &u1, given), values(&x0, &u0, given));
        for (row, (_, zx, zu)) in rows.iter().enumerate() {
            let one = if column < NX {
                zx[column]
            } else {
                zu[column - NX]
            };
            let slope = match (high.get(row), low.get(row)) {
                (Some(a), Some(b)) => (a - b) / width,
                _ => f64::NAN,
            };
            worst.compare(row, column, one, slope);
        }
    });
    worst.result()
}

/// Compares the gradient of a stage cost with central differences, and the products of its Hessian with the unit vectors
/// with differences of the gradient. Row 0 is the gradient; row 1 + i the Hessian's row i.
///
/// # Errors
/// [`Error::Jacobian`] with the entry that disagrees most.
pub fn check_cost<const NX: usize, const NU: usize>(
    cost: &(impl CostModel<NX, NU> + ?Sized),
    k: usize,
    x: &SVector<f64, NX>,
    u: &SVector<f64, NU>,
    tolerance: f64,
) -> Result<(), Error> {
    let expand = |x: &SVector<f64, NX>, u: &SVector<f64, NU>| {
        let mut out = Expansion::zeros();
        cost.expand_stage(k, x, u, &mut out);
        out
    };
    let here = expand(x, u);
    let mut worst = Worst::new(
        "derivative of the cost (row 0 gradient, then Hessian)",
        tolerance,
    );
    for_each_direction(x, u, |column, [(x1, u1), (x0, u0)], width| {
        let slope = (cost.stage(k, &x1, &u1) - cost.stage(k, &x0, &u0)) / width;
        let (high, low) = (expand(&x1, &u1), expand(&x0, &u0));
        let gradient = if column < NX {
            here.x[column]
        } else {
            here.u[column - NX]
        };
        worst.compare(0, column, gradient, slope);
        for i in 0..NX {
            let given = if column < NX {
                here.xx[(i, column)]
            } else {
                here.ux[(column - NX, i)]
            };
            worst.compare(1 + i, column, given, (high.x[i] - low.x[i]) / width);
        }
        for i in 0..NU {
            let given = if column < NX {
                here.ux[(i, column)]
            } else {
                here.uu[(i, column - NX)]
            };
            worst.compare(1 + NX + i, column, given, (high.u[i] - low.u[i]) / width);
        }
    });
    worst.result()
}

/// Points on both sides along each state and input, and the distance between them.
fn for_each_direction<const NX: usize, const NU: usize>(
    x: &SVector<f64, NX>,
    u: &SVector<f64, NU>,
    mut look: impl FnMut(usize, [(SVector<f64, NX>, SVector<f64, NU>); 2], f64),
) {
    for column in 0..NX + NU {
        let (mut x1, mut x0, mut u1, mut u0) = (*x, *x, *u, *u);
        let (high, low) = if column < NX {
            (&mut x1[column], &mut x0[column])
        } else {
            (&mut u1[column - NX], &mut u0[column - NX])
        };
        let h = 1e-6 * (1.0 + high.abs());
        *high += h;
        *low -= h;
        look(column, [(x1, u1), (x0, u0)], 2.0 * h);
    }
}

/// The entry that disagrees most.
struct Worst {
    what: &'static str,
    error: f64,
    found: Result<(), Error>,
}

impl Worst {
    fn new(what: &'static str, tolerance: f64) -> Self {
        Self {
            what,
            error: tolerance,
            found: Ok(()),
        }
    }

    fn compare(&mut self, row: usize, column: usize, given: f64, expected: f64) {
        let error = (given - expected).abs() / (1.0 + expected.abs());
        if error > self.error || error.is_nan() {
            self.error = if error.is_nan() { f64::INFINITY } else { error };
            self.found = Err(Error::Jacobian {
                what: self.what,
                row,
                column,
                given,
                expected,
            });
        }
    }

    fn result(self) -> Result<(), Error> {
        self.found
    }
}
