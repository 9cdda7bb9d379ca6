//! Properties that hold for any task.
#![allow(missing_docs, clippy::unwrap_used)]

use proptest::prelude::*;
use strrt::{
    Params, Plan, Planner, Robot, Status, Variant, motion_is_clear, peak_acceleration, plan,
    smooth, steps_needed, steps_needed_from_rest, straight,
};

/// Two joints among discs that come and go.
#[derive(Clone, Debug)]
struct Discs {
    /// Centre, radius, first and last step.
    discs: Vec<([f64; 2], f64, usize, usize)>,
    speed: f64,
}

impl Robot<2> for Discs {
    fn limits(&self) -> [(f64, f64); 2] {
        [(-2.0, 2.0); 2]
    }
    fn max_speed(&self) -> [f64; 2] {
        [self.speed, 0.8 * self.speed]
    }
    fn is_valid(&self, q: &[f64; 2], step: usize) -> bool {
        self.discs.iter().all(|(c, r, from, to)| {
            !(*from..=*to).contains(&step) || (q[0] - c[0]).hypot(q[1] - c[1]) > *r
        })
    }
}

#[derive(Clone, Debug)]
struct Task {
    arm: Discs,
    start: [f64; 2],
    goal: [f64; 2],
    steps: usize,
    seed: u64,
}

fn tasks() -> impl Strategy<Value = Task> {
    let disc = (
        [-1.5..1.5f64, -1.5..1.5f64],
        0.1..0.6f64,
        0..30usize,
        0..40usize,
    );
    (
        prop::collection::vec(disc, 0..6),
        0.4..2.0f64,
        [-2.0..2.0f64, -2.0..2.0],
        [-2.0..2.0f64, -2.0..2.0],
        1..50usize,
        any::<u64>(),
    )
        .prop_map(|(discs, speed, start, goal, steps, seed)| Task {
            arm: Discs { discs, speed },
            start,
            goal,
            steps,
            seed,
        })
}

fn variants() -> impl Strategy<Value = Variant> {
    prop::sample::select(vec![
        Variant::Published,
        Variant::MultiStep,
        Variant::Bidirectional,
    ])
}

fn quick(variant: Variant) -> Params {
    Params {
        variant,
        iterations: 300,
        improvements: 60,
        ..Params::default()
    }
}

/// The base's step of each state.
fn base_steps<const N: usize>(plan: &Plan<N>, steps: usize) -> Vec<usize> {
    (0..plan.path.len())
        .map(|i| i.saturating_sub(plan.waited_before).min(steps - 1))
        .collect()
}

fn check(task: &Task, found: &Plan<2>) -> Result<(), TestCaseError> {
    let speed = task.arm.max_speed();
    prop_assert_eq!(
        found.path.len(),
        task.steps + found.waited_before + found.waited_after
    );
    prop_assert_eq!(found.path[0], task.start);
    prop_assert_eq!(*found.path.last().unwrap(), task.goal);
    let at = base_steps(found, task.steps);
    for (q, &step) in found.path.iter().zip(&at) {
        prop_assert!(task.arm.is_valid(q, step));
        prop_assert!(q.iter().all(|a| a.abs() <= 2.0));
    }
    let mut cost = 0.0;
    for (i, w) in found.path.windows(2).enumerate() {
        for j in 0..2 {
            prop_assert!((w[1][j] - w[0][j]).abs() <= speed[j] * 0.1 + 2e-9);
        }
        prop_assert!(task.arm.is_motion_valid(&w[0], &w[1], at[i], at[i + 1]));
        cost += (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]);
    }
    prop_assert!((cost - found.cost).abs() < 1e-9);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// Plans start and end where they should, keep speeds and limits, and are free; the same call gives the same plan.
    #[test]
    fn plans_keep_the_rules(task in tasks(), variant in variants()) {
        let params = quick(variant);
        let run = || plan(&task.arm, task.start, task.goal, task.steps, 0.1, &params, task.seed).unwrap();
        let found = run();
        if found.status == Status::Solved {
            check(&task, &found)?;
        } else {
            prop_assert!(found.reason.is_some() && found.path.is_empty() && found.cost.is_infinite());
        }
        prop_assert_eq!(&found, &run());
    }

    /// The cost never rises, and many small steps are one large one.
    #[test]
    fn more_never_costs(task in tasks(), variant in variants(), parts in prop::collection::vec(1..60usize, 1..6)) {
        let params = quick(variant);
        let new = || Planner::new(&task.arm, task.start, task.goal, task.steps, 0.1, &params, task.seed).unwrap();
        let (mut small, mut large) = (new(), new());
        let mut before = small.cost();
        for &part in &parts {
            small.step(part);
            prop_assert!(small.cost() <= before);
            before = small.cost();
        }
        large.step(parts.iter().sum());
        prop_assert_eq!(small.plan(), large.plan());
    }

    /// Smoothing keeps the rules and the waits; neither cost nor peak acceleration rises.
    #[test]
    fn smoothing_keeps_the_rules(task in tasks()) {
        let params = quick(Variant::Bidirectional);
        let found = plan(&task.arm, task.start, task.goal, task.steps, 0.1, &params, task.seed).unwrap();
        if found.status == Status::Solved {
            let calm = smooth(&task.arm, &found, 0.1, 2.0).unwrap();
            check(&task, &calm)?;
            prop_assert!(calm.cost <= found.cost + 1e-9);
            prop_assert!(peak_acceleration(&calm.path, 0.1) <= peak_acceleration(&found.path, 0.1) + 1e-9);
        }
    }

    /// In free space the arm keeps its acceleration, given the time that `acceleration` asks for.
    #[test]
    fn free_motions_keep_the_acceleration(mut task in tasks(), limit in 0.5..4.0f64) {
        task.arm.discs.clear();
        let params = Params { acceleration: Some(limit), ..Params::default() };
        let found = plan(&task.arm, task.start, task.goal, task.steps, 0.1, &params, 0).unwrap();
        check(&task, &found)?;
        // A window of 16 steps is the widest; what it cannot reach is a matter of speed against acceleration.
        if task.arm.speed <= 0.7 * limit {
            prop_assert!(peak_acceleration(&found.path, 0.1) <= limit * 1.001, "{} of {limit}", peak_acceleration(&found.path, 0.1));
        }
    }

    /// What is solved can be solved backwards in time.
    #[test]
    fn the_mirror_image_is_solved(task in tasks()) {
        struct Mirror<'a>(&'a Discs, usize);
        impl Robot<2> for Mirror<'_> {
            fn limits(&self) -> [(f64, f64); 2] { self.0.limits() }
            fn max_speed(&self) -> [f64; 2] { self.0.max_speed() }
            fn is_valid(&self, q: &[f64; 2], step: usize) -> bool { self.0.is_valid(q, self.1 - 1 - step) }
        }
        let params = Params { variant: Variant::Bidirectional, iterations: 300, improvements: 0, max_wait: 0, ..Params::default() };
        let found = plan(&task.arm, task.start, task.goal, task.steps, 0.1, &params, task.seed).unwrap();
        if found.status == Status::Solved {
            let mirror = Mirror(&task.arm, task.steps);
            // Other samples, so with room for bad luck.
            let params = Params { iterations: 50_000, ..params };
            let back = plan(&mirror, task.goal, task.start, task.steps, 0.1, &params, task.seed).unwrap();
            prop_assert_eq!(back.status, Status::Solved);
        }
    }

    /// More time never makes a task infeasible, if the arm may hold the goal meanwhile.
    #[test]
    fn more_time_never_hurts(task in tasks(), more in 1..25usize, variant in prop::sample::select(vec![Variant::MultiStep, Variant::Bidirectional])) {
        let params = Params { variant, iterations: 300, improvements: 0, max_wait: 0, ..Params::default() };
        let found = plan(&task.arm, task.start, task.goal, task.steps, 0.1, &params, task.seed).unwrap();
        let holds = (task.steps..task.steps + more).all(|step| task.arm.is_valid(&task.goal, step));
        if found.status == Status::Solved && holds {
            // Other samples, so with room for bad luck.
            let params = Params { iterations: 50_000, ..params };
            let longer = plan(&task.arm, task.start, task.goal, task.steps + more, 0.1, &params, task.seed).unwrap();
            prop_assert_eq!(longer.status, Status::Solved);
        }
    }

    /// A straight motion that is free is the plan, at the least cost there is.
    #[test]
    fn straight_motions_are_plans(task in tasks()) {
        if let Some(line) = straight(&task.arm, task.start, task.goal, task.steps, 0.1).unwrap() {
            let params = Params { slack: 1.0, ..Params::default() };
            let found = plan(&task.arm, task.start, task.goal, task.steps, 0.1, &params, 1).unwrap();
            prop_assert_eq!(found.path, line);
            prop_assert_eq!(found.iterations, 0);
        }
    }

    /// The straight motion takes the steps it is said to need, no fewer; from rest it takes no fewer either.
    #[test]
    fn steps_needed_are_needed(from in [-2.0..2.0f64, -2.0..2.0], to in [-2.0..2.0f64, -2.0..2.0], speed in 0.2..2.0f64) {
        let arm = Discs { discs: Vec::new(), speed };
        let needed = steps_needed(&from, &to, &arm.max_speed(), 0.1);
        prop_assert!(straight(&arm, from, to, needed + 1, 0.1).unwrap().is_some());
        if needed > 0 {
            prop_assert!(straight(&arm, from, to, needed, 0.1).unwrap().is_none());
        }
        prop_assert!(steps_needed_from_rest(&from, &to, &arm.max_speed(), 2.0, 0.1) >= needed);
    }

    /// The bisection test of motions agrees with dense sampling, up to its resolution.
    #[test]
    fn motions_are_clear_where_they_are(a in -2.0..2.0f64, b in -2.0..2.0f64, block in -2.0..2.0f64, half in 0.05..0.5f64) {
        let clearance = |t: f64| (a + t * (b - a) - block).abs() - half;
        let clear = motion_is_clear(clearance, (b - a).abs(), 1e-3);
        let least = (0..=4000).map(|i| clearance(f64::from(i) / 4000.0)).fold(f64::INFINITY, f64::min);
        if clear {
            prop_assert!(least > -1e-3);
        } else {
            prop_assert!(least < 2e-3);
        }
    }
}
