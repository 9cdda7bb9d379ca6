//! Linear-quadratic problems whose sizes are known at run time: a dense Riccati recursion, and the whole system of optimality
//! conditions at once, which is slow and says whether the recursion is right. Both by faer.
//!
//! The solver's own backward pass takes the recursion of this module where states or inputs are too many for the one that
//! works with the zeros of the dynamics.

use crate::cost::Expansion;
use crate::error::Error;
use crate::riccati::{Expected, Policy};
use crate::robot::Linear;
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::Solve;
use faer::{Accum, Mat, MatRef, Par, Side};
use nalgebra::{DMatrix, DVector, SVector};

/// One step of a linear-quadratic problem: `x' = a x + b u + offset`, at the cost
/// `1/2 x' xx x + 1/2 u' uu u + u' ux x + qx . x + qu . u`.
#[derive(Clone, Debug, PartialEq)]
pub struct LqStage {
    /// Dynamics by state; next states by states.
    pub a: DMatrix<f64>,
    /// Dynamics by input; next states by inputs.
    pub b: DMatrix<f64>,
    /// Constant part of the dynamics.
    pub offset: DVector<f64>,
    /// Cost's Hessian by state, symmetric.
    pub xx: DMatrix<f64>,
    /// Cost's Hessian by input, symmetric.
    pub uu: DMatrix<f64>,
    /// Mixed second derivatives, inputs by states.
    pub ux: DMatrix<f64>,
    /// Cost's gradient by state.
    pub qx: DVector<f64>,
    /// Cost's gradient by input.
    pub qu: DVector<f64>,
}

/// A horizon of [`LqStage`]s. Sizes may differ from stage to stage as long as they fit together.
#[derive(Clone, Debug, PartialEq)]
pub struct LqProblem {
    stages: Vec<LqStage>,
    terminal: (DMatrix<f64>, DVector<f64>),
    start: DVector<f64>,
}

/// The optimum of a linear-quadratic problem.
#[derive(Clone, Debug, PartialEq)]
pub struct LqSolution {
    /// One more than inputs.
    pub states: Vec<DVector<f64>>,
    /// Inputs between the states.
    pub inputs: Vec<DVector<f64>>,
    /// Optimal feedback `u = inputs[k] + gains[k] (x - states[k])`; empty from [`LqProblem::kkt`].
    pub gains: Vec<DMatrix<f64>>,
}

impl LqProblem {
    /// A problem with its terminal Hessian and gradient and its first state.
    ///
    /// # Errors
    /// [`Error::NoKnots`], [`Error::Shape`] for sizes that do not fit together, [`Error::NotFinite`].
    pub fn new(
        stages: Vec<LqStage>,
        terminal: (DMatrix<f64>, DVector<f64>),
        start: DVector<f64>,
    ) -> Result<Self, Error> {
        if stages.is_empty() {
            return Err(Error::NoKnots);
        }
        let mut nx = start.len();
        finite("start", 0, start.as_slice())?;
        for (knot, s) in stages.iter().enumerate() {
            let (nu, next) = (s.b.ncols(), s.a.nrows());
            for (what, given, needed) in [
                ("a", s.a.shape(), (next, nx)),
                ("b", s.b.shape(), (next, nu)),
                ("offset", s.offset.shape(), (next, 1)),
                ("xx", s.xx.shape(), (nx, nx)),
                ("uu", s.uu.shape(), (nu, nu)),
                ("ux", s.ux.shape(), (nu, nx)),
                ("qx", s.qx.shape(), (nx, 1)),
                ("qu", s.qu.shape(), (nu, 1)),
            ] {
                shape(what, knot, given, needed)?;
            }
            let matrices = [&s.a, &s.b, &s.xx, &s.uu, &s.ux];
            for m in matrices {
                finite("a stage's matrix", knot, m.as_slice())?;
            }
            for v in [&s.offset, &s.qx, &s.qu] {
                finite("a stage's vector", knot, v.as_slice())?;
            }
            nx = next;
        }
        let knot = stages.len();
        shape("terminal Hessian", knot, terminal.0.shape(), (nx, nx))?;
        shape("terminal gradient", knot, terminal.1.shape(), (nx, 1))?;
        finite("terminal Hessian", knot, terminal.0.as_slice())?;
        finite("terminal gradient", knot, terminal.1.as_slice())?;
        Ok(Self {
            stages,
            terminal,
            start,
        })
    }

    /// Solves by a backward recursion and a roll-out; time grows with the number of knots.
    ///
    /// # Errors
    /// [`Error::Indefinite`] where the cost has no minimum over a knot's input.
    pub fn riccati(&self) -> Result<LqSolution, Error> {
        let mut value = Value {
            hessian: dynamic(&self.terminal.0).to_owned(),
            gradient: column(&self.terminal.1).to_owned(),
        };
        let mut policies = Vec::with_capacity(self.stages.len());
        for (knot, s) in self.stages.iter().enumerate().rev() {
            value.shift(column(&s.offset));
            let policy = value.step_back(&Knot::of(s), 0.0);
            policies.push(policy.ok_or(Error::Indefinite { knot })?);
        }
        policies.reverse();
        let mut out = LqSolution {
            states: vec![self.start.clone()],
            inputs: Vec::new(),
            gains: Vec::new(),
        };
        let mut x = self.start.clone();
        for (s, p) in self.stages.iter().zip(&policies) {
            let (nu, nx) = (p.feedback.nrows(), p.feedback.ncols());
            let gain = DMatrix::from_fn(nu, nx, |i, j| p.feedback[(i, j)]);
            let u = &gain * &x + DVector::from_fn(nu, |i, _| p.feedforward[(i, 0)]);
            x = &s.a * &x + &s.b * &u + &s.offset;
            out.states.push(x.clone());
            out.inputs.push(u);
            out.gains.push(gain);
        }
        Ok(out)
    }

    /// Solves the optimality conditions of all states, inputs and multipliers at once by LU; time grows with the cube of
    /// their number. A second opinion.
    ///
    /// # Errors
    /// [`Error::Indefinite`] (knot 0) if the conditions have no unique solution. Whether it is a minimum is not looked at.
    pub fn kkt(&self) -> Result<LqSolution, Error> {
        // Columns: states, inputs, multipliers of the first state and of each step.
        let sizes = |s: &LqStage| (s.a.ncols(), s.b.ncols());
        let last = self.terminal.1.len();
        let mut x_at = vec![0];
        for s in &self.stages {
            x_at.push(x_at[x_at.len() - 1] + sizes(s).0);
        }
        let n = self.stages.len();
        let mut u_at = vec![x_at[n] + last];
        for s in &self.stages {
            u_at.push(u_at[u_at.len() - 1] + sizes(s).1);
        }
        let y_at: Vec<usize> = x_at.iter().map(|x| x + u_at[n]).collect();
        let total = y_at[n] + last;
        let mut m = Mat::<f64>::zeros(total, total);
        let mut right = Mat::<f64>::zeros(total, 1);
        let mut put = |row: usize, col: usize, block: &DMatrix<f64>, sign: f64| {
            for j in 0..block.ncols() {
                for i in 0..block.nrows() {
                    m[(row + i, col + j)] += sign * block[(i, j)];
                }
            }
        };
        for (k, s) in self.stages.iter().enumerate() {
            let nx = sizes(s).0;
            put(x_at[k], x_at[k], &s.xx, 1.0);
            put(u_at[k], u_at[k], &s.uu, 1.0);
            put(u_at[k], x_at[k], &s.ux, 1.0);
            put(x_at[k], u_at[k], &s.ux.transpose(), 1.0);
            // -x_0 = -start, and a x + b u - x' = -offset, and their transposes.
            put(y_at[k], x_at[k], &DMatrix::identity(nx, nx), -1.0);
            put(x_at[k], y_at[k], &DMatrix::identity(nx, nx), -1.0);
            put(y_at[k + 1], x_at[k], &s.a, 1.0);
            put(x_at[k], y_at[k + 1], &s.a.transpose(), 1.0);
            put(y_at[k + 1], u_at[k], &s.b, 1.0);
            put(u_at[k], y_at[k + 1], &s.b.transpose(), 1.0);
        }
        put(x_at[n], x_at[n], &self.terminal.0, 1.0);
        put(y_at[n], x_at[n], &DMatrix::identity(last, last), -1.0);
        put(x_at[n], y_at[n], &DMatrix::identity(last, last), -1.0);
        let mut put = |row: usize, block: &DVector<f64>| {
            for i in 0..block.len() {
                right[(row + i, 0)] -= block[i];
            }
        };
        for (k, s) in self.stages.iter().enumerate() {
            put(x_at[k], &s.qx);
            put(u_at[k], &s.qu);
            put(y_at[k + 1], &s.offset);
        }
        put(x_at[n], &self.terminal.1);
        put(y_at[0], &self.start);
        let solution = m.partial_piv_lu().solve(&right);
        if !(0..total).all(|i| solution[(i, 0)].is_finite()) {
            return Err(Error::Indefinite { knot: 0 });
        }
        let part = |from: usize, len: usize| DVector::from_fn(len, |i, _| solution[(from + i, 0)]);
        let mut states: Vec<_> = self
            .stages
            .iter()
            .zip(&x_at)
            .map(|(s, &at)| part(at, sizes(s).0))
            .collect();
        states.push(part(x_at[n], last));
        Ok(LqSolution {
            states,
            inputs: self
                .stages
                .iter()
                .zip(&u_at)
                .map(|(s, &at)| part(at, sizes(s).1))
                .collect(),
            gains: Vec::new(),
        })
    }
}

fn shape(
    what: &'static str,
    knot: usize,
    given: (usize, usize),
    needed: (usize, usize),
) -> Result<(), Error> {
    if given == needed {
        Ok(())
    } else {
        Err(Error::Shape {
            what,
            knot,
            given,
            needed,
        })
    }
}

fn finite(what: &'static str, knot: usize, values: &[f64]) -> Result<(), Error> {
    crate::solver::finite(what, knot, values)
}

fn dynamic(m: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(m.as_slice(), m.nrows(), m.ncols())
}

fn column(v: &DVector<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(v.as_slice(), v.len(), 1)
}

/// What one step of the recursion reads.
struct Knot<'a> {
    a: MatRef<'a, f64>,
    b: MatRef<'a, f64>,
    xx: MatRef<'a, f64>,
    uu: MatRef<'a, f64>,
    ux: MatRef<'a, f64>,
    x: MatRef<'a, f64>,
    u: MatRef<'a, f64>,
}

impl<'a> Knot<'a> {
    fn of(s: &'a LqStage) -> Self {
        Self {
            a: dynamic(&s.a),
            b: dynamic(&s.b),
            xx: dynamic(&s.xx),
            uu: dynamic(&s.uu),
            ux: dynamic(&s.ux),
            x: column(&s.qx),
            u: column(&s.qu),
        }
    }
}

/// `u = feedforward + feedback x`, and the decrease that the feedforward brings.
struct Law {
    feedforward: Mat<f64>,
    feedback: Mat<f64>,
    gained: f64,
}

/// Quadratic value function of a knot.
struct Value {
    hessian: Mat<f64>,
    gradient: Mat<f64>,
}

/// `left' right`, added to what is there.
fn add_product(to: &mut Mat<f64>, left: MatRef<'_, f64>, right: MatRef<'_, f64>, factor: f64) {
    matmul(
        to.as_mut(),
        Accum::Add,
        left.transpose(),
        right,
        factor,
        Par::Seq,
    );
}

impl Value {
    /// The dynamics arrive `offset` further on.
    fn shift(&mut self, offset: MatRef<'_, f64>) {
        matmul(
            self.gradient.as_mut(),
            Accum::Add,
            self.hessian.as_ref(),
            offset,
            1.0,
            Par::Seq,
        );
    }

    /// One knot back; `None` if the Hessian by the input is not positive definite.
    fn step_back(&mut self, knot: &Knot<'_>, regularization: f64) -> Option<Law> {
        let (nx, nu) = (knot.xx.nrows(), knot.uu.nrows());
        let next = self.hessian.nrows();
        let mut va = Mat::zeros(next, nx);
        let mut vb = Mat::zeros(next, nu);
        let v = self.hessian.as_ref();
        matmul(va.as_mut(), Accum::Replace, v, knot.a, 1.0, Par::Seq);
        matmul(vb.as_mut(), Accum::Replace, v, knot.b, 1.0, Par::Seq);
        let (mut qx, mut qu) = (knot.x.to_owned(), knot.u.to_owned());
        add_product(&mut qx, knot.a, self.gradient.as_ref(), 1.0);
        add_product(&mut qu, knot.b, self.gradient.as_ref(), 1.0);
        let (mut qxx, mut quu, mut qux) =
            (knot.xx.to_owned(), knot.uu.to_owned(), knot.ux.to_owned());
        add_product(&mut qxx, knot.a, va.as_ref(), 1.0);
        add_product(&mut quu, knot.b, vb.as_ref(), 1.0);
        add_product(&mut qux, knot.b, va.as_ref(), 1.0);
        for i in 0..nu {
            quu[(i, i)] += regularization;
        }
        let factor = quu.llt(Side::Lower).ok()?;
        let mut feedforward = factor.solve(&qu);
        let mut feedback = factor.solve(&qux);
        let mut gained = 0.0;
        for i in 0..nu {
            gained += qu[(i, 0)] * feedforward[(i, 0)];
            feedforward[(i, 0)] = -feedforward[(i, 0)];
        }
        for j in 0..nx {
            for i in 0..nu {
                feedback[(i, j)] = -feedback[(i, j)];
            }
        }
        if !gained.is_finite() {
            return None;
        }
        add_product(&mut qx, qux.as_ref(), feedforward.as_ref(), 1.0);
        add_product(&mut qxx, qux.as_ref(), feedback.as_ref(), 1.0);
        // Rounding must not add up to an asymmetry.
        self.hessian = Mat::from_fn(nx, nx, |i, j| 0.5 * (qxx[(i, j)] + qxx[(j, i)]));
        self.gradient = qx;
        Some(Law {
            feedforward,
            feedback,
            gained,
        })
    }
}

/// The solver's backward pass.
pub(crate) fn backward<const NX: usize, const NU: usize>(
    linear: &[Linear<NX, NU>],
    models: &[Expansion<NX, NU>],
    gaps: &[SVector<f64, NX>],
    regularization: f64,
    policies: &mut [Policy<NX, NU>],
) -> Option<Expected> {
    let n = linear.len();
    let fixed = |m: &'_ [f64], rows, cols| Mat::from_fn(rows, cols, |i, j| m[i + j * rows]);
    let mut value = Value {
        hessian: fixed(models[n].xx.as_slice(), NX, NX),
        gradient: fixed(models[n].x.as_slice(), NX, 1),
    };
    let mut expected = Expected {
        linear: 0.0,
        quadratic: 0.0,
    };
    for k in (0..n).rev() {
        let (l, model) = (&linear[k], &models[k]);
        let before: Vec<f64> = (0..NX).map(|i| value.gradient[(i, 0)]).collect();
        value.shift(MatRef::from_column_major_slice(gaps[k].as_slice(), NX, 1));
        for i in 0..NX {
            expected.linear += before[i] * gaps[k][i];
            expected.quadratic += (value.gradient[(i, 0)] - before[i]) * gaps[k][i];
        }
        let knot = Knot {
            a: MatRef::from_column_major_slice(l.a.as_slice(), NX, NX),
            b: MatRef::from_column_major_slice(l.b.as_slice(), NX, NU),
            xx: MatRef::from_column_major_slice(model.xx.as_slice(), NX, NX),
            uu: MatRef::from_column_major_slice(model.uu.as_slice(), NU, NU),
            ux: MatRef::from_column_major_slice(model.ux.as_slice(), NU, NX),
            x: MatRef::from_column_major_slice(model.x.as_slice(), NX, 1),
            u: MatRef::from_column_major_slice(model.u.as_slice(), NU, 1),
        };
        let law = value.step_back(&knot, regularization)?;
        let policy = &mut policies[k];
        for i in 0..NU {
            policy.feedforward[i] = law.feedforward[(i, 0)];
            for j in 0..NX {
                policy.feedback[(i, j)] = law.feedback[(i, j)];
            }
        }
        expected.linear -= law.gained;
        expected.quadratic += law.gained;
    }
    Some(expected)
}
