//! Linear-quadratic problems of run-time size: the recursion against the whole system of optimality conditions, and the
//! solver against both, in the sizes where it works with zeros and in those where it does not.
#![cfg(feature = "faer")]
#![allow(missing_docs, clippy::unwrap_used)]

use ddp_rbf::nalgebra::{DMatrix, DVector, SMatrix, SVector};
use ddp_rbf::{
    Constraint, CostModel, Error, Expansion, LqProblem, LqSolution, LqStage, Options, Robot,
    Solver, Status,
};
use proptest::prelude::*;

/// Numbers between -1 and 1 that look random, from a seed.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    fn matrix(&mut self, rows: usize, cols: usize) -> DMatrix<f64> {
        DMatrix::from_fn(rows, cols, |_, _| self.next())
    }
    fn vector(&mut self, len: usize) -> DVector<f64> {
        DVector::from_fn(len, |_, _| self.next())
    }
    /// A convex stage from `nx` states to `next`.
    fn stage(&mut self, nx: usize, nu: usize, next: usize) -> LqStage {
        let root = self.matrix(nx + nu, nx + nu);
        let all = root.transpose() * &root + DMatrix::identity(nx + nu, nx + nu) * 0.1;
        LqStage {
            a: self.matrix(next, nx) * 0.6,
            b: self.matrix(next, nu),
            offset: self.vector(next),
            xx: all.view((0, 0), (nx, nx)).into(),
            uu: all.view((nx, nx), (nu, nu)).into(),
            ux: all.view((nx, 0), (nu, nx)).into(),
            qx: self.vector(nx),
            qu: self.vector(nu),
        }
    }
}

fn far(a: &LqSolution, b: &LqSolution) -> f64 {
    let pairs = a
        .states
        .iter()
        .zip(&b.states)
        .chain(a.inputs.iter().zip(&b.inputs));
    pairs
        .map(|(a, b)| (a - b).amax() / (1.0 + b.amax()))
        .fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(32) })]

    /// Also where sizes change along the horizon.
    #[test]
    fn the_recursion_meets_the_optimality_conditions(
        sizes in prop::collection::vec((1..6usize, 1..5usize), 1..8), last in 1..6usize, seed in any::<u64>(),
    ) {
        let mut draw = Draw(seed);
        let next = |k: usize| sizes.get(k + 1).map_or(last, |s| s.0);
        let stages: Vec<_> = sizes.iter().enumerate().map(|(k, &(nx, nu))| draw.stage(nx, nu, next(k))).collect();
        let terminal = (DMatrix::identity(last, last), draw.vector(last));
        let problem = LqProblem::new(stages, terminal, draw.vector(sizes[0].0)).unwrap();
        let (a, b) = (problem.riccati().unwrap(), problem.kkt().unwrap());
        prop_assert!(far(&a, &b) < 1e-9, "{}", far(&a, &b));
        prop_assert_eq!(a.gains.len(), sizes.len());
    }
}

/// A linear robot with a quadratic cost of its own at every knot; steps are exact.
struct Plant<const NX: usize, const NU: usize> {
    stages: Vec<LqStage>,
    terminal: (DMatrix<f64>, DVector<f64>),
}

impl<const NX: usize, const NU: usize> Plant<NX, NU> {
    fn new(knots: usize, seed: u64) -> Self {
        let mut draw = Draw(seed);
        let mut stages: Vec<_> = (0..knots).map(|_| draw.stage(NX, NU, NX)).collect();
        // One dynamics for all, since a robot does not know the knot.
        let (a, b) = (stages[0].a.clone(), stages[0].b.clone());
        for s in &mut stages {
            (s.a, s.b) = (a.clone(), b.clone());
            s.offset.fill(0.0);
        }
        Self {
            stages,
            terminal: (DMatrix::identity(NX, NX), draw.vector(NX)),
        }
    }
    fn problem(&self, start: &SVector<f64, NX>) -> LqProblem {
        let start = DVector::from_column_slice(start.as_slice());
        LqProblem::new(self.stages.clone(), self.terminal.clone(), start).unwrap()
    }
}

impl<const NX: usize, const NU: usize> Robot<NX, NU> for Plant<NX, NU> {
    fn flow(&self, x: &SVector<f64, NX>, u: &SVector<f64, NU>) -> SVector<f64, NX> {
        self.step(x, u, 1.0) - x
    }
    fn jacobians(
        &self,
        x: &SVector<f64, NX>,
        u: &SVector<f64, NU>,
    ) -> (SMatrix<f64, NX, NX>, SMatrix<f64, NX, NU>) {
        let (a, b) = self.linearize(x, u, 1.0);
        (a - SMatrix::identity(), b)
    }
    fn step(&self, x: &SVector<f64, NX>, u: &SVector<f64, NU>, _: f64) -> SVector<f64, NX> {
        let (a, b) = self.linearize(x, u, 1.0);
        a * x + b * u
    }
    fn linearize(
        &self,
        _: &SVector<f64, NX>,
        _: &SVector<f64, NU>,
        _: f64,
    ) -> (SMatrix<f64, NX, NX>, SMatrix<f64, NX, NU>) {
        let s = &self.stages[0];
        (
            SMatrix::from_fn(|i, j| s.a[(i, j)]),
            SMatrix::from_fn(|i, j| s.b[(i, j)]),
        )
    }
}

impl<const NX: usize, const NU: usize> CostModel<NX, NU> for Plant<NX, NU> {
    fn stage(&self, k: usize, x: &SVector<f64, NX>, u: &SVector<f64, NU>) -> f64 {
        let s = &self.stages[k];
        let (x, u) = (
            DVector::from_column_slice(x.as_slice()),
            DVector::from_column_slice(u.as_slice()),
        );
        0.5 * x.dot(&(&s.xx * &x))
            + 0.5 * u.dot(&(&s.uu * &u))
            + u.dot(&(&s.ux * &x))
            + s.qx.dot(&x)
            + s.qu.dot(&u)
    }
    fn terminal(&self, x: &SVector<f64, NX>) -> f64 {
        let x = DVector::from_column_slice(x.as_slice());
        0.5 * x.dot(&(&self.terminal.0 * &x)) + self.terminal.1.dot(&x)
    }
    fn expand_stage(
        &self,
        k: usize,
        x: &SVector<f64, NX>,
        u: &SVector<f64, NU>,
        into: &mut Expansion<NX, NU>,
    ) {
        let s = &self.stages[k];
        let (xx, uu) = (
            SMatrix::<f64, NX, NX>::from_fn(|i, j| s.xx[(i, j)]),
            SMatrix::<f64, NU, NU>::from_fn(|i, j| s.uu[(i, j)]),
        );
        let ux = SMatrix::<f64, NU, NX>::from_fn(|i, j| s.ux[(i, j)]);
        into.x += xx * x + ux.tr_mul(u) + SVector::<f64, NX>::from_fn(|i, _| s.qx[i]);
        into.u += uu * u + ux * x + SVector::<f64, NU>::from_fn(|i, _| s.qu[i]);
        into.xx += xx;
        into.uu += uu;
        into.ux += ux;
    }
    fn expand_terminal(&self, x: &SVector<f64, NX>, into: &mut Expansion<NX, NU>) {
        into.x +=
            SVector::<f64, NX>::from_fn(|i, _| x[i] * self.terminal.0[(i, i)] + self.terminal.1[i]);
        into.xx += SMatrix::<f64, NX, NX>::identity();
    }
}

/// The solver's first full step from a guess with gaps is the optimum of the whole system; so are its gains.
fn solver_agrees<const NX: usize, const NU: usize>(knots: usize, seed: u64) {
    let plant = Plant::<NX, NU>::new(knots, seed);
    let mut draw = Draw(seed ^ 1);
    let start = SVector::<f64, NX>::from_fn(|_, _| draw.next());
    let problem = plant.problem(&start);
    let exact = problem.kkt().unwrap();
    let gains = problem.riccati().unwrap().gains;
    let mut solver = Solver::new(knots, 1.0).unwrap();
    let xs: Vec<_> = (0..=knots)
        .map(|_| SVector::<f64, NX>::from_fn(|_, _| draw.next()))
        .collect();
    let us: Vec<_> = (0..knots)
        .map(|_| SVector::<f64, NU>::from_fn(|_, _| draw.next()))
        .collect();
    solver.set_guess(&xs, &us).unwrap();
    let none: [&dyn Constraint<NX, NU>; 0] = [];
    let options = Options {
        tolerance: 1e-9,
        ..Options::default()
    };
    let report = solver
        .solve(&plant, &plant, &none, &start, &options)
        .unwrap();
    assert_eq!(report.status, Status::Converged);
    assert_eq!(report.iterations, 2, "one to reach it, one to see it");
    for (x, e) in solver.states().iter().zip(&exact.states) {
        assert!((0..NX).all(|i| (x[i] - e[i]).abs() < 1e-9 * (1.0 + e.amax())));
    }
    for (u, e) in solver.inputs().iter().zip(&exact.inputs) {
        assert!((0..NU).all(|i| (u[i] - e[i]).abs() < 1e-9 * (1.0 + e.amax())));
    }
    for (k, e) in gains.iter().enumerate() {
        let found = solver.gain_at(k).unwrap();
        let worst = (0..NU)
            .flat_map(|i| (0..NX).map(move |j| (i, j)))
            .map(|at| (found[at] - e[at]).abs());
        assert!(worst.fold(0.0, f64::max) < 1e-9 * (1.0 + e.amax()));
    }
}

#[test]
fn the_solver_meets_the_optimality_conditions() {
    solver_agrees::<9, 8>(20, 3);
    solver_agrees::<4, 2>(30, 4);
    // Too large for the recursion that works with zeros.
    solver_agrees::<36, 30>(6, 5);
}

#[test]
fn bad_problems_are_told_by_name() {
    let mut draw = Draw(7);
    let stage = draw.stage(3, 2, 3);
    let terminal = (DMatrix::identity(3, 3), DVector::zeros(3));
    let start = DVector::zeros(3);
    let make = |stage: LqStage| LqProblem::new(vec![stage], terminal.clone(), start.clone());
    assert!(make(stage.clone()).is_ok());
    assert_eq!(
        LqProblem::new(Vec::new(), terminal.clone(), start.clone()),
        Err(Error::NoKnots)
    );
    let wrong = LqStage {
        qu: DVector::zeros(3),
        ..stage.clone()
    };
    let shape = Error::Shape {
        what: "qu",
        knot: 0,
        given: (3, 1),
        needed: (2, 1),
    };
    assert_eq!(make(wrong), Err(shape));
    let mut wrong = stage.clone();
    wrong.b[(1, 1)] = f64::NAN;
    assert!(matches!(
        make(wrong),
        Err(Error::NotFinite {
            knot: 0,
            entry: 4,
            ..
        })
    ));
    let short = LqProblem::new(
        vec![stage.clone()],
        (DMatrix::identity(2, 2), DVector::zeros(3)),
        start.clone(),
    );
    assert!(matches!(
        short,
        Err(Error::Shape {
            what: "terminal Hessian",
            knot: 1,
            ..
        })
    ));
    // A cost that falls without end along an input.
    let mut wrong = stage;
    wrong.uu = DMatrix::identity(2, 2) * -100.0;
    assert_eq!(
        make(wrong).unwrap().riccati(),
        Err(Error::Indefinite { knot: 0 })
    );
}
