//! The benchmark's instances (../shared/data/mpc): the optima that an interior-point solver found, from both guesses.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stderr, dead_code)]

#[path = "../examples/mobile_manipulator/problem.rs"]
mod problem;

use ddp_rbf::{Barrier, BoxField, DriveArm, Options, Solver, Status};
use problem::{Instance, Problem, Terms};
use std::path::PathBuf;

fn data() -> Option<(Problem, Vec<Instance>)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/mpc");
    if !folder.exists() {
        eprintln!("skipped: {} is not there", folder.display());
        return None;
    }
    Some((
        Problem::read(&folder.join("problem.json")).unwrap(),
        Instance::read_all(&folder).unwrap(),
    ))
}

#[test]
fn every_solve_reaches_the_reference_optimum() {
    let Some((problem, instances)) = data() else {
        return;
    };
    for instance in &instances {
        for n in [30, 60] {
            let dt = 3.0 / n as f64;
            let cost = problem.tracking(instance, n, dt, 0);
            let walls = BoxField::new(instance.boxes.clone(), None, problem.beta).unwrap();
            let floor = BoxField::new(instance.boxes.clone(), Some(0.0), problem.beta).unwrap();
            let terms = Terms::new(&problem, problem.barrier, [0.0; 2], 0.0, &walls, &floor);
            let best = instance.best("rbf", n).unwrap();
            for (guess, xs, us) in problem.guesses(instance, &cost) {
                let mut solver = Solver::new(n, dt).unwrap();
                solver.set_guess(&xs, &us).unwrap();
                let options = Options {
                    tolerance: 1e-10,
                    ..Options::default()
                };
                let report = solver
                    .solve(&DriveArm, &cost, &terms.all(), &instance.x0, &options)
                    .unwrap();
                let gap = report.cost - best;
                assert_eq!(
                    report.status,
                    Status::Converged,
                    "{} {guess}",
                    instance.name
                );
                // Two programs that share no code agree to nine digits; below the reference is within its own tolerance.
                assert!(gap.abs() < 1e-8, "{} N={n} {guess}: {gap:e}", instance.name);
                assert!(report.gap < 1e-12);
            }
        }
    }
}

/// The default barrier costs a few per cent of the hard-constrained optimum's tracking, the paper's several times it.
#[test]
fn default_barriers_track_like_hard_constraints() {
    let Some((problem, instances)) = data() else {
        return;
    };
    let n = 60;
    let median = |barrier: Barrier| {
        let mut ratios: Vec<f64> = instances
            .iter()
            .map(|instance| {
                let cost = problem.tracking(instance, n, 0.05, 0);
                let walls = BoxField::new(instance.boxes.clone(), None, problem.beta).unwrap();
                let floor = BoxField::new(instance.boxes.clone(), Some(0.0), problem.beta).unwrap();
                let terms = Terms::new(&problem, barrier, [0.0; 2], 0.0, &walls, &floor);
                let mut solver = Solver::new(n, 0.05).unwrap();
                let [(_, xs, us), _] = problem.guesses(instance, &cost);
                solver.set_guess(&xs, &us).unwrap();
                let report = solver
                    .solve(
                        &DriveArm,
                        &cost,
                        &terms.all(),
                        &instance.x0,
                        &Options::default(),
                    )
                    .unwrap();
                let barriers: f64 = solver.groups().iter().map(|g| g.penalty).sum();
                (report.cost - barriers) / instance.best("hard", n).unwrap()
            })
            .collect();
        ratios.sort_by(f64::total_cmp);
        ratios[ratios.len() / 2]
    };
    let (ours, paper) = (median(Barrier::default()), median(Barrier::paper()));
    assert!(ours < 1.05, "{ours}");
    assert!(paper > 1.5, "{paper}");
}
