//! The solver against a dense solve and against a quadratic program.
#![allow(missing_docs, clippy::unwrap_used)]

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, ZeroConeT};
use ddp_rbf::nalgebra::{DMatrix, DVector, SMatrix, SVector, vector};
use ddp_rbf::{Barrier, Constraint, InputBox, Options, Robot, Solver, Tracking};

struct Cart;

impl Robot<2, 1> for Cart {
    fn flow(&self, x: &SVector<f64, 2>, u: &SVector<f64, 1>) -> SVector<f64, 2> {
        vector![x[1], u[0]]
    }
    fn jacobians(
        &self,
        _: &SVector<f64, 2>,
        _: &SVector<f64, 1>,
    ) -> (SMatrix<f64, 2, 2>, SMatrix<f64, 2, 1>) {
        (
            SMatrix::from_row_slice(&[0.0, 1.0, 0.0, 0.0]),
            SMatrix::from_row_slice(&[0.0, 1.0]),
        )
    }
}

const N: usize = 15;
const DT: f64 = 0.2;

fn cost() -> Tracking<2, 1> {
    Tracking::new(
        vec![vector![1.0, 0.0]; N + 1],
        vec![vector![0.0]; N],
        DT,
        vector![1.0, 0.1],
        vector![0.05],
        vector![10.0, 1.0],
    )
}

/// States as an affine function of the inputs: x = m u + c, from the dynamics by superposition.
fn condensed(x0: SVector<f64, 2>) -> (DMatrix<f64>, DVector<f64>) {
    let roll = |us: &[f64]| {
        let mut x = x0;
        let mut out = Vec::new();
        for &u in us {
            x = Cart.step(&x, &vector![u], DT);
            out.extend_from_slice(x.as_slice());
        }
        DVector::from_vec(out)
    };
    let c = roll(&[0.0; N]);
    let mut m = DMatrix::zeros(2 * N, N);
    for k in 0..N {
        let mut us = [0.0; N];
        us[k] = 1.0;
        m.set_column(k, &(roll(&us) - &c));
    }
    (m, c)
}

/// Hessian and gradient of the tracking cost in the inputs alone.
fn quadratic(x0: SVector<f64, 2>) -> (DMatrix<f64>, DVector<f64>) {
    let (m, c) = condensed(x0);
    let mut weights = DVector::zeros(2 * N);
    let mut offset = c;
    for k in 0..N {
        let last = k + 1 == N;
        weights[2 * k] = if last { 10.0 } else { DT };
        weights[2 * k + 1] = if last { 1.0 } else { 0.1 * DT };
        offset[2 * k] -= 1.0;
    }
    let wm = DMatrix::from_fn(2 * N, N, |i, j| weights[i] * m[(i, j)]);
    let h = m.transpose() * &wm + DMatrix::identity(N, N) * (0.05 * DT);
    let g = wm.transpose() * offset;
    (h, g)
}

#[test]
fn without_constraints_the_dense_solution_is_met() {
    let x0 = vector![-0.5, 0.2];
    let (h, g) = quadratic(x0);
    let exact = h.lu().solve(&(-g)).unwrap();
    let mut solver = Solver::new(N, DT).unwrap();
    let none: [&dyn Constraint<2, 1>; 0] = [];
    solver
        .solve(
            &Cart,
            &cost(),
            &none,
            &x0,
            &Options {
                tolerance: 1e-14,
                ..Options::default()
            },
        )
        .unwrap();
    for (u, e) in solver.inputs().iter().zip(exact.iter()) {
        assert!((u[0] - e).abs() < 1e-8, "{} against {e}", u[0]);
    }
}

#[test]
fn barriers_tend_to_the_quadratic_program() {
    let x0 = vector![-0.5, 0.2];
    let (h, g) = quadratic(x0);
    // min 1/2 u'Hu + g'u subject to |u| <= 0.5, by an interior-point solver.
    let limit = 0.5;
    let rows: Vec<Vec<f64>> = (0..N)
        .map(|i| {
            (0..N)
                .map(|j| if i <= j { h[(i, j)] } else { 0.0 })
                .collect()
        })
        .collect();
    let p = CscMatrix::from(&rows);
    let mut bounds = vec![vec![0.0; N]; 2 * N];
    for k in 0..N {
        bounds[k][k] = 1.0;
        bounds[N + k][k] = -1.0;
    }
    let a = CscMatrix::from(&bounds);
    let settings = DefaultSettings {
        verbose: false,
        ..DefaultSettings::default()
    };
    let cones = [ZeroConeT(0), NonnegativeConeT(2 * N)];
    let mut program =
        DefaultSolver::new(&p, g.as_slice(), &a, &vec![limit; 2 * N], &cones, settings).unwrap();
    program.solve();
    let exact = program.solution.x.clone();
    assert!(
        exact.iter().any(|u| u.abs() > limit - 1e-4),
        "the limit should bind"
    );

    let mut worst = Vec::new();
    for mu in [1e-2, 1e-3, 1e-4, 1e-5] {
        let limits = InputBox::new(
            vector![-limit],
            vector![limit],
            Barrier {
                mu,
                delta: 1e-6,
                cutoff: None,
            },
        );
        let constraints: [&dyn Constraint<2, 1>; 1] = [&limits];
        let mut solver = Solver::new(N, DT).unwrap();
        let options = Options {
            iterations: 200,
            tolerance: 1e-12,
            ..Options::default()
        };
        solver
            .solve(&Cart, &cost(), &constraints, &x0, &options)
            .unwrap();
        worst.push(
            solver
                .inputs()
                .iter()
                .zip(&exact)
                .map(|(u, e)| (u[0] - e).abs())
                .fold(0.0, f64::max),
        );
    }
    assert!(worst.windows(2).all(|w| w[1] < w[0]), "{worst:?}");
    assert!(worst[3] < 2e-3, "{worst:?}");
}
