//! Open loop: one horizon solved to the reference optimum, and how long that takes.

use crate::problem::{Instance, Outcome, Problem, Terms, U, X};
use cpu_time::ThreadTime;
use ddp_rbf::{Barrier, BoxField, DriveArm, Options, Report, Solver};

/// A horizon of one instance, solved from one guess.
pub(crate) struct Solved {
    pub(crate) guess: &'static str,
    pub(crate) report: Report,
    /// Iterations until the objective is within 1e-4 of the optimum; 0 if that was not reached.
    pub(crate) needed: usize,
    /// CPU time of those iterations, of one iteration from the guess, and of each further one; microseconds.
    pub(crate) time_needed: f64,
    pub(crate) first: f64,
    pub(crate) per_iteration: f64,
    pub(crate) states: Vec<X>,
    pub(crate) inputs: Vec<U>,
}

/// Solves an instance with the problem's own barrier from both guesses. `repeats` solves are timed, and the tenth percentile
/// counts.
pub(crate) fn solve(
    problem: &Problem,
    instance: &Instance,
    n: usize,
    best: f64,
    repeats: usize,
) -> Outcome<Vec<Solved>> {
    let dt = 3.0 / n as f64;
    let cost = problem.tracking(instance, n, dt, 0);
    let walls = BoxField::new(instance.boxes.clone(), None, problem.beta)?;
    let floor = BoxField::new(instance.boxes.clone(), Some(0.0), problem.beta)?;
    let terms = Terms::new(problem, problem.barrier, [0.0; 2], 0.0, &walls, &floor);
    let groups = terms.all();
    let mut solver = Solver::new(n, dt)?;
    let mut out = Vec::new();
    for (guess, xs, us) in problem.guesses(instance, &cost) {
        let run = |solver: &mut Solver<9, 8>, iterations, tolerance| -> Outcome<(Report, f64)> {
            solver.set_guess(&xs, &us)?;
            let options = Options {
                iterations,
                tolerance,
                ..Options::default()
            };
            let start = ThreadTime::now();
            let report = solver.solve(&DriveArm, &cost, &groups, &instance.x0, &options)?;
            Ok((report, start.elapsed().as_secs_f64() * 1e6))
        };
        let mut needed = 0;
        for m in 1..=60 {
            if run(&mut solver, m, 1e-14)?.0.cost - best <= 1e-4 {
                needed = m;
                break;
            }
        }
        let time = |solver: &mut Solver<9, 8>, m: usize| -> Outcome<f64> {
            let mut all = Vec::with_capacity(repeats);
            for _ in 0..repeats.max(1) {
                all.push(run(solver, m, 1e-14)?.1);
            }
            all.sort_by(f64::total_cmp);
            Ok(all[all.len() / 10])
        };
        let first = time(&mut solver, 1)?;
        let four = time(&mut solver, 4)?;
        let time_needed = time(&mut solver, needed.max(1))?;
        let (report, _) = run(&mut solver, 100, 1e-10)?;
        out.push(Solved {
            guess,
            report,
            needed,
            time_needed,
            first,
            per_iteration: (four - first) / 3.0,
            states: solver.states().to_vec(),
            inputs: solver.inputs().to_vec(),
        });
    }
    Ok(out)
}

/// Tracking part of the optimum with another barrier, from the guess that ends lower: what the barrier costs.
pub(crate) fn tracking_of(
    problem: &Problem,
    instance: &Instance,
    n: usize,
    barrier: Barrier,
) -> Outcome<f64> {
    let dt = 3.0 / n as f64;
    let cost = problem.tracking(instance, n, dt, 0);
    let walls = BoxField::new(instance.boxes.clone(), None, problem.beta)?;
    let floor = BoxField::new(instance.boxes.clone(), Some(0.0), problem.beta)?;
    let terms = Terms::new(problem, barrier, [0.0; 2], 0.0, &walls, &floor);
    let mut solver = Solver::new(n, dt)?;
    let mut lowest = (f64::INFINITY, 0.0);
    for (_, xs, us) in problem.guesses(instance, &cost) {
        solver.set_guess(&xs, &us)?;
        let options = Options {
            iterations: 100,
            tolerance: 1e-10,
            ..Options::default()
        };
        let report = solver.solve(&DriveArm, &cost, &terms.all(), &instance.x0, &options)?;
        let barriers: f64 = solver.groups().iter().map(|g| g.penalty).sum();
        if report.cost < lowest.0 {
            lowest = (report.cost, report.cost - barriers);
        }
    }
    Ok(lowest.1)
}
