//! Where nothing moves: the search without time keeps the same promises.
#![allow(missing_docs, clippy::unwrap_used)]

use proptest::prelude::*;
use strrt::{
    Params, Planner, Reason, Robot, Status, Variant, peak_acceleration, plan, steps_needed,
};

/// Two joints among discs that stay.
#[derive(Clone, Debug)]
struct Discs {
    discs: Vec<([f64; 2], f64)>,
    batch: usize,
}

impl Robot<2> for Discs {
    fn limits(&self) -> [(f64, f64); 2] {
        [(-2.0, 2.0); 2]
    }
    fn max_speed(&self) -> [f64; 2] {
        [1.0, 0.7]
    }
    fn is_valid(&self, q: &[f64; 2], _: usize) -> bool {
        let clear = |(c, r): &([f64; 2], f64)| (q[0] - c[0]).hypot(q[1] - c[1]) > *r;
        self.discs.iter().all(clear)
    }
    fn is_static(&self) -> bool {
        true
    }
    fn batch(&self) -> usize {
        self.batch
    }
}

/// The same, but the planner does not know that nothing moves.
struct Unknown<'a>(&'a Discs);

impl Robot<2> for Unknown<'_> {
    fn limits(&self) -> [(f64, f64); 2] {
        self.0.limits()
    }
    fn max_speed(&self) -> [f64; 2] {
        self.0.max_speed()
    }
    fn is_valid(&self, q: &[f64; 2], step: usize) -> bool {
        self.0.is_valid(q, step)
    }
}

fn two() -> impl Strategy<Value = [f64; 2]> {
    prop::array::uniform2(-1.9..1.9f64)
}

fn discs() -> impl Strategy<Value = Discs> {
    let list = prop::collection::vec((two(), 0.1..0.7f64), 0..7);
    (list, prop::sample::select(vec![1, 8])).prop_map(|(discs, batch)| Discs { discs, batch })
}

fn variants() -> impl Strategy<Value = Variant> {
    prop::sample::select(vec![
        Variant::Published,
        Variant::MultiStep,
        Variant::Bidirectional,
    ])
}

/// A disc between start and goal.
fn one_disc() -> Discs {
    Discs {
        discs: vec![([0.0, 0.0], 0.8)],
        batch: 1,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(96) })]

    #[test]
    fn plans_are_free_in_time_and_exact(
        arm in discs(), start in two(), goal in two(), steps in 1..60usize, max_wait in 0..80usize,
        variant in variants(), seed in any::<u64>(),
    ) {
        let params = Params { variant, max_wait, iterations: 300, improvements: 100, ..Params::default() };
        let found = plan(&arm, start, goal, steps, 0.1, &params, seed).unwrap();
        prop_assert_eq!(&plan(&arm, start, goal, steps, 0.1, &params, seed).unwrap(), &found);
        if found.status == Status::Solved {
            let path = &found.path;
            prop_assert_eq!(path.len(), found.waited_before + steps + found.waited_after);
            prop_assert!(found.waited_before <= max_wait && found.waited_after <= max_wait);
            prop_assert_eq!((path[0], path[path.len() - 1]), (start, goal));
            let sum: f64 = path.windows(2).map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1])).sum();
            prop_assert!((sum - found.cost).abs() < 1e-9);
            for pair in path.windows(2) {
                prop_assert!(arm.is_valid(&pair[1], 0) && arm.is_motion_valid(&pair[0], &pair[1], 0, 0));
                for j in 0..2 {
                    prop_assert!((pair[1][j] - pair[0][j]).abs() <= 0.1 * arm.max_speed()[j] + 1e-9);
                }
            }
        }
    }

    /// What the search in space-time solves, the one without time solves too.
    #[test]
    fn nothing_is_lost(arm in discs(), start in two(), goal in two(), steps in 1..40usize, seed in any::<u64>()) {
        let params = Params { variant: Variant::Bidirectional, iterations: 300, improvements: 0, ..Params::default() };
        let in_time = plan(&Unknown(&arm), start, goal, steps, 0.1, &params, seed).unwrap();
        let more = Params { iterations: 3000, ..params };
        let without = plan(&arm, start, goal, steps, 0.1, &more, seed).unwrap();
        prop_assert!(in_time.status != Status::Solved || without.status == Status::Solved);
        prop_assert_eq!(in_time.status == Status::Infeasible, without.status == Status::Infeasible);
    }

    /// Whoever checks many states at once gets the same path.
    #[test]
    fn batches_change_nothing(arm in discs(), start in two(), goal in two(), seed in any::<u64>()) {
        let go = |batch| {
            let arm = Discs { batch, ..arm.clone() };
            let found = plan(&arm, start, goal, 5, 0.1, &Params::default(), seed).unwrap();
            (found.path, found.iterations)
        };
        prop_assert_eq!(go(1), go(8));
    }

    /// The cost never rises, and many small steps are one large one.
    #[test]
    fn small_steps_are_one_large(arm in discs(), start in two(), goal in two(), seed in any::<u64>()) {
        let params = Params::default();
        let mut one = Planner::new(&arm, start, goal, 1, 0.1, &params, seed).unwrap();
        let mut many = Planner::new(&arm, start, goal, 1, 0.1, &params, seed).unwrap();
        one.step(200);
        let mut before = f64::INFINITY;
        for _ in 0..40 {
            many.step(5);
            prop_assert!(many.cost() <= before);
            before = many.cost();
        }
        prop_assert_eq!(one.plan(), many.plan());
    }
}

/// Two tangents and an arc: the shortest way around a disc is known.
#[test]
fn the_way_around_a_disc_is_nearly_the_shortest() {
    let (radius, far) = (0.8f64, 1.6f64);
    let turn = std::f64::consts::PI - 2.0 * (radius / far).acos();
    let best = 2.0 * (far * far - radius * radius).sqrt() + radius * turn;
    for seed in 0..5 {
        let params = Params {
            improvements: 3000,
            ..Params::default()
        };
        let arm = one_disc();
        let found = plan(&arm, [-far, 0.0], [far, 0.0], 1, 0.1, &params, seed).unwrap();
        assert!(found.cost < 1.02 * best, "{} of {best}", found.cost);
    }
}

/// No step is spent in the goal when the base has long arrived, and the arm is about as quick as it can be.
#[test]
fn the_arm_arrives_as_soon_as_it_can() {
    let params = Params {
        improvements: 1000,
        ..Params::default()
    };
    let found = plan(&one_disc(), [-1.6, 0.0], [1.6, 0.0], 1, 0.1, &params, 4).unwrap();
    let n = found.path.len();
    assert_ne!(found.path[n - 2], found.path[n - 1]);
    // 32 steps are the least in a straight line.
    assert!((32..=45).contains(&(n - 1)), "{n}");
    // Straight ahead it takes the least there is, whatever the slack; the rest of a long schedule is spent at the goal.
    let open = Discs {
        discs: vec![],
        batch: 1,
    };
    let go = |goal, steps| plan(&open, [0.0; 2], goal, steps, 0.1, &Params::default(), 1).unwrap();
    let speed = open.max_speed();
    let least = steps_needed(&[0.0; 2], &[1.0, 1.3], &speed, 0.1);
    assert_eq!(go([1.0, 1.3], 1).path.len(), least + 1);
    let long = go([1.0, 1.3], 60);
    assert_eq!((long.path.len(), long.waited_after), (60, 0));
    assert_eq!(long.path[least..], vec![[1.0, 1.3]; 60 - least]);
    assert_eq!(go([0.0; 2], 1).path, [[0.0; 2]]);
}

/// With less time than any way around takes, there is no plan; with a little more, there is.
#[test]
fn no_plan_takes_more_time_than_there_is() {
    let go = |max_wait| {
        let params = Params {
            max_wait,
            ..Params::default()
        };
        plan(&one_disc(), [0.0, -1.6], [0.0, 1.6], 1, 0.1, &params, 2).unwrap()
    };
    // Straight ahead, the second joint needs 46 steps; there is no need for more, the first being quicker.
    assert!(matches!(
        go(45).reason,
        Some(Reason::TooFar { needed: 46, .. })
    ));
    assert_eq!(go(60).status, Status::Solved);
    assert!(go(60).waited_after <= 60);
    // A start walled in: the samples run out, with a reason.
    let ring = Discs {
        discs: (0..24)
            .map(|k| {
                let (s, c) = (f64::from(k) * std::f64::consts::TAU / 24.0).sin_cos();
                ([0.9 * c, 0.9 * s], 0.2)
            })
            .collect(),
        batch: 1,
    };
    let none = plan(&ring, [0.0; 2], [1.5; 2], 1, 0.1, &Params::default(), 1).unwrap();
    assert_eq!(none.status, Status::BudgetExhausted);
    assert_eq!(none.reason, Some(Reason::NotFound { reached: 0 }));
}

/// Joints that turn without end: only what can be reached in time is searched.
#[test]
fn endless_joints_are_searched_within_reach() {
    struct Endless;
    impl Robot<2> for Endless {
        fn limits(&self) -> [(f64, f64); 2] {
            [(-1e300, 1e300); 2]
        }
        fn max_speed(&self) -> [f64; 2] {
            [1.0; 2]
        }
        fn is_valid(&self, q: &[f64; 2], _: usize) -> bool {
            q[0].hypot(q[1]) > 0.8
        }
        fn is_static(&self) -> bool {
            true
        }
    }
    let go = |max_wait| {
        let params = Params {
            max_wait,
            ..Params::default()
        };
        plan(&Endless, [-1.6, 0.0], [1.6, 0.0], 1, 0.1, &params, 6).unwrap()
    };
    for max_wait in [40, 100_000] {
        let found = go(max_wait);
        assert_eq!(found.status, Status::Solved);
        assert!(found.path.len() <= max_wait + 1);
    }
}

/// Limited acceleration needs time, and so does a start in violation: these are searched in space-time.
#[test]
fn acceleration_and_grace_still_hold() {
    let params = Params {
        acceleration: Some(2.0),
        slack: 2.0,
        ..Params::default()
    };
    let found = plan(&one_disc(), [-1.6, 0.0], [1.6, 0.0], 1, 0.1, &params, 3).unwrap();
    assert_eq!(found.status, Status::Solved);
    assert!(peak_acceleration(&found.path, 0.1) <= 2.0 * (1.0 + 1e-6));
    let params = Params {
        start_grace: 4,
        ..Params::default()
    };
    let found = plan(&one_disc(), [-0.75, 0.0], [-1.6, 0.0], 1, 0.1, &params, 3).unwrap();
    assert_eq!(found.status, Status::Solved);
}

/// Six joints, a wall with a window: the same on every machine, at every level of optimisation.
#[test]
fn debug_and_release_plan_the_same() {
    struct Window;
    impl Robot<6> for Window {
        fn limits(&self) -> [(f64, f64); 6] {
            [(-3.0, 3.0); 6]
        }
        fn max_speed(&self) -> [f64; 6] {
            [1.0; 6]
        }
        fn is_valid(&self, q: &[f64; 6], _: usize) -> bool {
            q[0].abs() > 0.3 || q[1..].iter().all(|v| (v - 0.8).abs() < 0.6)
        }
        fn is_static(&self) -> bool {
            true
        }
    }
    let params = Params {
        iterations: 20_000,
        ..Params::default()
    };
    let (start, goal) = (
        [-1.5, 0.0, 1.0, -1.0, 0.5, 0.0],
        [1.5, -0.5, 0.0, 0.3, -1.0, 2.0],
    );
    let found = plan(&Window, start, goal, 1, 0.1, &params, 5).unwrap();
    let seen = (found.iterations, found.checks, found.path.len());
    assert_eq!(
        (seen, (found.cost * 1e9).round() / 1e9),
        ((4019, 30683, 34), 5.0965962)
    );
}
