//! A differential drive goes around a pillar: prints the way and the smallest distance, and draws it if a file is named.
#![allow(clippy::print_stdout)]

use ddp_rbf::nalgebra::{SMatrix, SVector, vector};
use ddp_rbf::{Barrier, Constraint, Error, InputBox, Options, Robot, Solver, Tracking};

struct Drive;

impl Robot<3, 2> for Drive {
    fn flow(&self, x: &SVector<f64, 3>, u: &SVector<f64, 2>) -> SVector<f64, 3> {
        vector![u[0] * x[2].cos(), u[0] * x[2].sin(), u[1]]
    }
    fn jacobians(
        &self,
        x: &SVector<f64, 3>,
        u: &SVector<f64, 2>,
    ) -> (SMatrix<f64, 3, 3>, SMatrix<f64, 3, 2>) {
        let (s, c) = x[2].sin_cos();
        let mut a = SMatrix::zeros();
        (a[(0, 2)], a[(1, 2)]) = (-u[0] * s, u[0] * c);
        let mut b = SMatrix::zeros();
        (b[(0, 0)], b[(1, 0)], b[(2, 1)]) = (c, s, 1.0);
        (a, b)
    }
}

/// A pillar of 0.3 m radius at (1, 0.05).
struct Pillar;

impl Pillar {
    fn way(x: &SVector<f64, 3>) -> ([f64; 2], f64) {
        let d = [x[0] - 1.0, x[1] - 0.05];
        (d, d[0].hypot(d[1]))
    }
}

impl Constraint<3, 2> for Pillar {
    fn name(&self) -> &'static str {
        "pillar"
    }
    fn barrier(&self) -> Barrier {
        Barrier::default()
    }
    fn values(
        &self,
        _: usize,
        x: &SVector<f64, 3>,
        _: Option<&SVector<f64, 2>>,
        visit: &mut dyn FnMut(f64),
    ) {
        visit(Self::way(x).1 - 0.3);
    }
    fn rows(
        &self,
        _: usize,
        x: &SVector<f64, 3>,
        _: Option<&SVector<f64, 2>>,
        visit: &mut dyn FnMut(f64, &SVector<f64, 3>, &SVector<f64, 2>),
    ) {
        let (d, norm) = Self::way(x);
        visit(
            norm - 0.3,
            &vector![d[0] / norm, d[1] / norm, 0.0],
            &SVector::zeros(),
        );
    }
}

fn main() -> Result<(), Error> {
    let n = 40;
    let goal = vector![2.0, 0.0, 0.0];
    let weights = (
        vector![2.0, 2.0, 0.2],
        vector![0.1, 0.1],
        vector![50.0, 50.0, 5.0],
    );
    let cost = Tracking::new(
        vec![goal; n + 1],
        vec![SVector::zeros(); n],
        0.1,
        weights.0,
        weights.1,
        weights.2,
    );
    let limits = InputBox::new(vector![-0.8, -1.5], vector![0.8, 1.5], Barrier::default());
    let mut solver = Solver::new(n, 0.1)?;
    let report = solver.solve(
        &Drive,
        &cost,
        &[&limits, &Pillar],
        &SVector::zeros(),
        &Options::default(),
    )?;
    println!(
        "{:?} after {} iterations, cost {:.4}",
        report.status, report.iterations, report.cost
    );
    for group in solver.groups() {
        println!("smallest z of {}: {:.3}", group.name, group.least);
    }
    for x in solver.states().iter().step_by(5) {
        println!("({:.2}, {:.2}) heading {:.2}", x[0], x[1], x[2]);
    }
    if let Some(path) = std::env::args().nth(1) {
        match std::fs::write(&path, picture(solver.states())) {
            Ok(()) => println!("drawn in {path}"),
            Err(e) => println!("{path}: {e}"),
        }
    }
    Ok(())
}

/// The pillar, the way, and the heading at every fifth knot, as SVG; 200 pixels are a metre.
fn picture(states: &[SVector<f64, 3>]) -> String {
    let at = |x: f64, y: f64| (200.0 * (x + 0.4), 200.0 * (0.9 - y));
    let way: Vec<String> = states
        .iter()
        .map(|s| {
            let (x, y) = at(s[0], s[1]);
            format!("{x:.1},{y:.1}")
        })
        .collect();
    let mut out = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 560 360\">\n<rect width=\"560\" height=\"360\" fill=\"white\"/>\n",
    );
    let (x, y) = at(1.0, 0.05);
    out += &format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"60\" fill=\"#888\"/>\n");
    out += &format!(
        "<polyline points=\"{}\" fill=\"none\" stroke=\"#06c\" stroke-width=\"3\"/>\n",
        way.join(" ")
    );
    for s in states.iter().step_by(5) {
        let ((x, y), (a, b)) = (
            at(s[0], s[1]),
            at(s[0] + 0.08 * s[2].cos(), s[1] + 0.08 * s[2].sin()),
        );
        out += &format!(
            "<line x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{a:.1}\" y2=\"{b:.1}\" stroke=\"#c30\" stroke-width=\"2\"/>\n"
        );
    }
    out + "</svg>\n"
}
