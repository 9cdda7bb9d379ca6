//! The nearest command that keeps the hard constraints' decrease in bounds: a quadratic program in the inputs.

use crate::constraint::Constraint;
use crate::robot::Robot;
use crate::safety::SafetyParams;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};
use nalgebra::SVector;

/// `gradient . u >= bound`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row<const NU: usize> {
    gradient: SVector<f64, NU>,
    bound: f64,
}

/// Linearises every hard constraint after one period: `h + h_x (x' - x) >= (1 - decrease period) h`, where x' moves with
/// the input as the step's derivative says. Constraints that no input can bring near zero within a period are left out.
pub(crate) fn rows<const NX: usize, const NU: usize>(
    robot: &impl Robot<NX, NU>,
    x: &SVector<f64, NX>,
    command: &SVector<f64, NU>,
    params: &SafetyParams<NU>,
    hard: &[&dyn Constraint<NX, NU>],
    out: &mut Vec<Row<NU>>,
) {
    out.clear();
    let period = params.guard.period;
    let moved = robot.step(x, command, period) - x;
    let (_, b) = robot.linearize(x, command, period);
    let keep = (params.decrease * period).min(1.0);
    for group in hard {
        group.rows(1, x, None, &mut |z, zx, _| {
            let gradient = b.tr_mul(zx);
            let still = zx.dot(&moved) - gradient.dot(command);
            // A violated constraint must not get worse; the look lets it recover.
            let bound = -keep * z.max(0.0) - still;
            let lowest: f64 = (0..NU)
                .map(|i| (gradient[i] * params.low[i]).min(gradient[i] * params.high[i]))
                .sum();
            if lowest < bound {
                out.push(Row { gradient, bound });
            }
        });
    }
}

/// `min |u - command|^2` subject to the rows and the limits; `None` if there is no such command.
pub(crate) fn project<const NU: usize>(
    command: &SVector<f64, NU>,
    rows: &[Row<NU>],
    low: &SVector<f64, NU>,
    high: &SVector<f64, NU>,
) -> Option<SVector<f64, NU>> {
    if !(command.iter().all(|v| v.is_finite())
        && rows
            .iter()
            .all(|r| r.bound.is_finite() && r.gradient.iter().all(|v| v.is_finite())))
    {
        return None;
    }
    let m = rows.len() + 2 * NU;
    // Columns of [-rows; I; -I], dense on top.
    let mut starts = vec![0];
    let (mut indices, mut values) = (Vec::new(), Vec::new());
    for i in 0..NU {
        for (r, row) in rows.iter().enumerate() {
            indices.push(r);
            values.push(-row.gradient[i]);
        }
        indices.extend([rows.len() + i, rows.len() + NU + i]);
        values.extend([1.0, -1.0]);
        starts.push(indices.len());
    }
    let a = CscMatrix::new(m, NU, starts, indices, values);
    let mut b: Vec<f64> = rows.iter().map(|r| -r.bound).collect();
    b.extend(high.iter());
    b.extend(low.iter().map(|v| -v));
    let identity = CscMatrix::new(NU, NU, (0..=NU).collect(), (0..NU).collect(), vec![1.0; NU]);
    let q: Vec<f64> = command.iter().map(|v| -v).collect();
    let settings = DefaultSettings {
        verbose: false,
        max_iter: 50,
        ..DefaultSettings::default()
    };
    let mut solver =
        DefaultSolver::new(&identity, &q, &a, &b, &[NonnegativeConeT(m)], settings).ok()?;
    solver.solve();
    if solver.solution.status != SolverStatus::Solved {
        return None;
    }
    let u = SVector::<f64, NU>::from_fn(|i, _| {
        solver.solution.x[i].clamp(low[i].min(high[i]), high[i])
    });
    u.iter().all(|v| v.is_finite()).then_some(u)
}
