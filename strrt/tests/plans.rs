//! Plans are timed paths within speed, through free states, from start to goal.
#![allow(missing_docs, clippy::unwrap_used)]

use proptest::prelude::*;
use strrt::{Error, Params, Reason, Robot, Status, Variant, plan, steps_needed, straight};

/// Two joints; discs in joint space are blocked during some steps.
#[derive(Debug)]
struct Discs(Vec<([f64; 2], f64, std::ops::Range<usize>)>);

impl Robot<2> for Discs {
    fn limits(&self) -> [(f64, f64); 2] {
        [(-3.0, 3.0); 2]
    }
    fn max_speed(&self) -> [f64; 2] {
        [0.8; 2]
    }
    fn is_valid(&self, q: &[f64; 2], step: usize) -> bool {
        self.0
            .iter()
            .all(|(c, r, when)| !when.contains(&step) || (q[0] - c[0]).hypot(q[1] - c[1]) > *r)
    }
}

fn discs() -> impl Strategy<Value = Discs> {
    prop::collection::vec(
        (
            prop::array::uniform2(-2.0..2.0f64),
            0.1..0.7f64,
            0..30usize,
            1..60usize,
        ),
        0..5,
    )
    .prop_map(|list| {
        Discs(
            list.into_iter()
                .map(|(c, r, a, n)| (c, r, a..a + n))
                .collect(),
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) })]

    #[test]
    fn solved_plans_keep_every_promise(
        robot in discs(),
        start in prop::array::uniform2(-2.0..2.0f64),
        goal in prop::array::uniform2(-2.0..2.0f64),
        steps in 1..80usize,
        seed in 0..5u64,
    ) {
        let params = Params { iterations: 300, ..Params::default() };
        let found = plan(&robot, start, goal, steps, 0.1, &params, seed).unwrap();
        prop_assert_eq!(&plan(&robot, start, goal, steps, 0.1, &params, seed).unwrap(), &found);
        if found.status == Status::Solved {
            prop_assert_eq!(found.path.len(), found.waited_before + steps + found.waited_after);
            prop_assert_eq!(found.path[0], start);
            prop_assert_eq!(*found.path.last().unwrap(), goal);
            let mut cost = 0.0;
            for (i, q) in found.path.iter().enumerate() {
                let step = i.saturating_sub(found.waited_before).min(steps - 1);
                prop_assert!(robot.is_valid(q, step));
                if i > 0 {
                    let p = found.path[i - 1];
                    for j in 0..2 {
                        prop_assert!((q[j] - p[j]).abs() <= 0.08 + 1e-8);
                    }
                    cost += (q[0] - p[0]).hypot(q[1] - p[1]);
                }
            }
            prop_assert!((cost - found.cost).abs() < 1e-9);
        } else {
            prop_assert!(found.reason.is_some() && found.path.is_empty());
        }
    }

    /// Without obstacles the plan is the straight line, in every variant.
    #[test]
    fn free_space_is_crossed_straight(
        start in prop::array::uniform2(-2.0..2.0f64),
        goal in prop::array::uniform2(-2.0..2.0f64),
    ) {
        let line = (start[0] - goal[0]).hypot(start[1] - goal[1]);
        for variant in [Variant::Published, Variant::MultiStep, Variant::Bidirectional] {
            let found = plan(&Discs(vec![]), start, goal, 20, 0.1, &Params { variant, ..Params::default() }, 1).unwrap();
            prop_assert_eq!(found.status, Status::Solved);
            prop_assert!((found.cost - line).abs() < 1e-9);
        }
    }
}

#[test]
fn short_schedules_wait() {
    let needed = steps_needed(&[0.0, 0.0], &[1.6, 0.0], &[0.8; 2], 0.1);
    assert_eq!(needed, 20);
    let found = plan(
        &Discs(vec![]),
        [0.0; 2],
        [1.6, 0.0],
        5,
        0.1,
        &Params::default(),
        1,
    )
    .unwrap();
    assert_eq!(found.status, Status::Solved);
    assert!(found.path.len() > needed && found.waited_after > 0);
    assert_eq!(
        straight(&Discs(vec![]), [0.0; 2], [1.6, 0.0], 5, 0.1).unwrap(),
        None
    );
}

#[test]
fn blocked_ends_say_which() {
    let blocked = Discs(vec![([1.0, 1.0], 0.2, 0..99)]);
    let at = |start, goal| plan(&blocked, start, goal, 20, 0.1, &Params::default(), 1).unwrap();
    assert_eq!(at([1.0, 1.0], [0.0; 2]).reason, Some(Reason::StartInvalid));
    assert_eq!(at([0.0; 2], [1.0, 1.0]).reason, Some(Reason::GoalInvalid));
}

#[test]
fn bad_input_is_named() {
    let robot = Discs(vec![]);
    let p = Params::default();
    assert_eq!(
        plan(&robot, [0.0; 2], [0.0; 2], 0, 0.1, &p, 1),
        Err(Error::NoSteps)
    );
    assert_eq!(
        plan(&robot, [0.0; 2], [0.0; 2], 9, 0.0, &p, 1),
        Err(Error::TimeStep(0.0))
    );
    assert!(matches!(
        plan(&robot, [0.0; 2], [9.0, 0.0], 9, 0.1, &p, 1),
        Err(Error::OutsideLimits {
            which: "goal",
            joint: 0,
            ..
        })
    ));
    assert!(matches!(
        plan(&robot, [f64::NAN, 0.0], [0.0; 2], 9, 0.1, &p, 1),
        Err(Error::OutsideLimits {
            which: "start",
            joint: 0,
            ..
        })
    ));
}
