//! One named case for each thing that goes wrong.
#![allow(missing_docs, clippy::unwrap_used)]

use objsearch::{
    Belief, BranchParams, Budget, Ended, Error, Goal, GridPaths, LocalParams, Look, Mode, Paths,
    Place, Regression, Speeds, Status, Survey, Task, Times, TravelModel, TravelTable, View, Volume,
    World, branch_and_bound, cell_weight, cluster, deepen, greedy, local, optimal, prove, search,
    widen,
};

fn every(n: usize, seconds: f64) -> Times {
    Times::new(vec![seconds; n], vec![seconds; n * n]).unwrap()
}

fn singles(n: usize, times: &Times) -> Result<Task, Error> {
    let views: Vec<View> = (0..n).map(|v| View::new([v])).collect();
    Task::new(&vec![0.5; n], &views, times, &Goal::default())
}

#[test]
fn certain_and_impossible_probabilities_are_refused() {
    for p in [0.0, 1.0, -0.1, 1.5, f64::NAN, f64::INFINITY] {
        assert!(
            matches!(cell_weight(p, 3), Err(Error::Probability { .. })),
            "{p}"
        );
        let volume = Volume {
            low: [0; 3],
            high: [1; 3],
            probability: p,
        };
        assert!(matches!(
            Belief::new(&[volume], ([0; 3], [4; 3])),
            Err(Error::Probability { .. })
        ));
    }
    assert_eq!(cell_weight(0.5, 0), Err(Error::NoCells));
}

#[test]
fn thresholds_and_detection_outside_their_intervals_are_refused() {
    for threshold in [0.0, 1.0, 1.5, f64::NAN] {
        let goal = Goal {
            threshold,
            ..Goal::default()
        };
        let found = Task::new(&[0.1], &[View::new([0])], &every(1, 1.0), &goal);
        assert!(
            matches!(
                found,
                Err(Error::Probability {
                    what: "threshold",
                    ..
                })
            ),
            "{threshold}"
        );
    }
    for detection in [0.0, -1.0, 1.1, f64::NAN] {
        let goal = Goal {
            detection,
            ..Goal::default()
        };
        let found = Task::new(&[0.1], &[View::new([0])], &every(1, 1.0), &goal);
        assert!(
            matches!(
                found,
                Err(Error::Probability {
                    what: "detection",
                    ..
                })
            ),
            "{detection}"
        );
    }
}

#[test]
fn empty_and_outside_volumes_are_named() {
    let volume = |low, high| Volume {
        low,
        high,
        probability: 0.2,
    };
    let bounds = ([0; 3], [10; 3]);
    let good = volume([0; 3], [2; 3]);
    let empty = Belief::new(&[good.clone(), volume([5; 3], [5, 6, 6])], bounds);
    assert!(matches!(empty, Err(Error::EmptyVolume { volume: 1, .. })));
    let outside = Belief::new(&[volume([8; 3], [11, 9, 9])], bounds);
    assert!(matches!(outside, Err(Error::OutsideMap { volume: 0, .. })));
    assert_eq!(volume([5; 3], [3; 3]).cells(), 0);
    let nan = Volume::touching([f64::NAN; 3], [0.1; 3], [0.0; 3], 0.05, 0.2);
    assert!(Belief::new(&[nan], ([-5; 3], [-1; 3])).is_err());
}

#[test]
fn touching_counts_both_end_cells() {
    // A side of 0.8 m on 0.05 m cells, not aligned with them.
    let volume = Volume::touching(
        [7.31, 11.11, 0.76],
        [8.11, 11.91, 0.96],
        [0.0; 3],
        0.05,
        0.2,
    );
    assert_eq!(volume.high[0] - volume.low[0], 17);
    assert_eq!(volume.high[1] - volume.low[1], 17);
}

#[test]
fn wrong_cells_and_weights_are_named() {
    let found = Task::new(&[0.1], &[View::new([7])], &every(1, 1.0), &Goal::default());
    assert_eq!(
        found,
        Err(Error::Cell {
            view: 0,
            cell: 7,
            cells: 1
        })
    );
    for weight in [-1.0, f64::NAN, f64::INFINITY] {
        let found = Task::new(
            &[weight],
            &[View::new([0])],
            &every(1, 1.0),
            &Goal::default(),
        );
        assert!(
            matches!(found, Err(Error::Weight { cell: 0, .. })),
            "{weight}"
        );
    }
}

#[test]
fn nan_negative_and_zero_times_are_named() {
    for time in [f64::NAN, -1.0, 0.0, f64::NEG_INFINITY] {
        assert!(
            matches!(singles(2, &every(2, time)), Err(Error::Time { to: 0, .. })),
            "{time}"
        );
        let mut between = vec![1.0; 4];
        between[1] = time;
        let times = Times::new(vec![1.0; 2], between).unwrap();
        assert!(matches!(singles(2, &times), Err(Error::Time { to: 1, .. })));
    }
}

#[test]
fn tables_of_the_wrong_size_are_refused() {
    let wrong = |found: &Result<Times, Error>| matches!(found, Err(Error::TableSize { .. }));
    assert!(wrong(&Times::new(vec![1.0; 3], vec![1.0; 8])));
    assert!(wrong(&Times::from_lower(vec![1.0; 3], &[1.0; 4])));
    assert!(wrong(&every(3, 1.0).from_state(vec![1.0; 2])));
}

#[test]
fn broken_promises_of_symmetry_are_named() {
    let found = Times::symmetric(vec![1.0; 2], vec![0.0, 2.0, 3.0, 0.0]);
    assert_eq!(
        found,
        Err(Error::Asymmetric {
            from: 1,
            to: 0,
            there: 3.0,
            back: 2.0
        })
    );
    assert!(Times::symmetric(vec![1.0; 2], vec![0.0, 2.0, 2.0, 9.0]).is_ok());
}

#[test]
fn no_views_is_nothing_to_see() {
    let task = Task::new(&[0.1], &[], &every(0, 1.0), &Goal::default()).unwrap();
    let steps = || Budget::steps(1000);
    for plan in [
        greedy(&task),
        optimal(&task).unwrap(),
        local(&task, &LocalParams::default(), &[3, 1], &mut steps()),
        prove(&task, &[], &mut steps()),
        deepen(&task, &BranchParams::default(), &mut steps()),
        widen(&task, &BranchParams::default(), &mut steps()),
    ] {
        assert!(plan.sequence.is_empty());
        assert_eq!(plan.status, Status::NothingToSee);
        assert_eq!(plan.expected_time, 0.0);
    }
}

#[test]
fn less_than_the_threshold_is_nothing_to_see() {
    let task = Task::new(&[0.04], &[View::new([0])], &every(1, 1.0), &Goal::default()).unwrap();
    assert_eq!(greedy(&task).status, Status::NothingToSee);
    assert!(greedy(&task).complete);
}

#[test]
fn unreachable_views_are_left_out() {
    let task = singles(2, &every(2, f64::INFINITY)).unwrap();
    assert_eq!(greedy(&task).status, Status::NothingToSee);
    assert_eq!(task.total_weight(), 0.0);
    let first = vec![2.0, f64::INFINITY, 4.0];
    let task = singles(3, &Times::new(first, vec![1.0; 9]).unwrap()).unwrap();
    let plan = local(
        &task,
        &LocalParams::default(),
        &[1, 2],
        &mut Budget::steps(10_000),
    );
    assert!(plan.complete && !plan.sequence.contains(&1) && plan.sequence.len() == 2);
    assert!(!task.is_reachable(1) && !task.is_reachable(99));
}

#[test]
fn views_that_cannot_follow_each_other_are_a_dead_end() {
    // Either view can be gone to, but not the other after it.
    let times = Times::new(vec![1.0; 2], vec![f64::INFINITY; 4]).unwrap();
    let task = singles(2, &times).unwrap();
    for plan in [
        greedy(&task),
        optimal(&task).unwrap(),
        prove(&task, &[], &mut Budget::unlimited()),
        local(
            &task,
            &LocalParams::default(),
            &[],
            &mut Budget::steps(10_000),
        ),
    ] {
        assert_eq!(plan.status, Status::DeadEnd, "{plan:?}");
        assert!(!plan.complete);
    }
    assert_eq!(greedy(&task).sequence.len(), 1);
}

#[test]
fn ways_into_dead_ends_are_avoided_where_there_is_another() {
    // From view 0, the best first one, nothing can be reached.
    let inf = f64::INFINITY;
    let times = Times::new(vec![1.0, 5.0], vec![inf, inf, 5.0, inf]).unwrap();
    let task = singles(2, &times).unwrap();
    let plan = branch_and_bound(
        &task,
        &BranchParams {
            branch_limit: inf,
            ..BranchParams::default()
        },
        &mut Budget::unlimited(),
    );
    assert_eq!(
        (plan.sequence.as_slice(), plan.complete),
        (&[1, 0][..], true)
    );
}

#[test]
fn a_zero_budget_still_answers() {
    let task = singles(5, &every(5, 2.0)).unwrap();
    let params = BranchParams::default();
    for plan in [
        branch_and_bound(&task, &params, &mut Budget::steps(0)),
        deepen(&task, &params, &mut Budget::steps(0)),
        widen(&task, &params, &mut Budget::steps(0)),
        local(&task, &LocalParams::default(), &[], &mut Budget::steps(0)),
        prove(&task, &[], &mut Budget::steps(0)),
        prove(&task, &[], &mut Budget::unlimited().until(|| true)),
    ] {
        assert_eq!(plan.sequence.len(), 5);
        assert!(plan.complete);
        assert_eq!(plan.status, Status::BudgetExhausted);
    }
}

#[test]
fn searches_without_a_limit_end() {
    let task = singles(6, &every(6, 2.0)).unwrap();
    let plan = local(
        &task,
        &LocalParams::default(),
        &[],
        &mut Budget::unlimited(),
    );
    assert_eq!(plan.status, Status::Finished);
    let one = singles(1, &every(1, 2.0)).unwrap();
    let plan = local(&one, &LocalParams::default(), &[], &mut Budget::unlimited());
    assert_eq!(plan.sequence, [0]);
}

#[test]
fn a_start_with_wrong_views_is_mended() {
    let task = singles(3, &every(3, 2.0)).unwrap();
    let plan = local(
        &task,
        &LocalParams::default(),
        &[7, 1, 1, 99],
        &mut Budget::steps(0),
    );
    assert!(plan.complete);
    assert_eq!(plan.sequence.len(), 3);
}

#[test]
fn too_many_views_for_the_exact_planner() {
    let task = singles(19, &every(19, 2.0)).unwrap();
    assert_eq!(
        optimal(&task),
        Err(Error::TooManyViews {
            views: 19,
            most: 18
        })
    );
}

#[test]
fn bad_parameters_are_refused() {
    for branch_limit in [0.5, f64::NAN, -1.0] {
        let params = BranchParams {
            branch_limit,
            ..BranchParams::default()
        };
        assert!(matches!(
            params.validate(),
            Err(Error::Param {
                field: "branch_limit",
                ..
            })
        ));
        // Unchecked, it counts as 1.
        let task = singles(3, &every(3, 2.0)).unwrap();
        assert!(branch_and_bound(&task, &params, &mut Budget::unlimited()).complete);
    }
    let params = LocalParams {
        temperature: -1.0,
        ..LocalParams::default()
    };
    assert!(matches!(
        params.validate(),
        Err(Error::Param {
            field: "temperature",
            ..
        })
    ));
    let params = LocalParams {
        drift: f64::NAN,
        ..LocalParams::default()
    };
    assert!(params.validate().is_err());
}

#[test]
fn cost_maps_of_the_wrong_size_are_refused() {
    assert!(matches!(
        GridPaths::new(&[0; 5], (2, 3), [0.0; 2], 0.05),
        Err(Error::TableSize { .. })
    ));
    assert!(matches!(
        GridPaths::new(&[0; 6], (2, 3), [0.0; 2], 0.0),
        Err(Error::Param { .. })
    ));
    assert!(GridPaths::inflated(&[false; 6], (2, 3), [0.0; 2], f64::NAN, 0.5, 10.0).is_err());
    assert!(GridPaths::inflated(&[true; 5], (2, 3), [0.0; 2], 0.05, 0.5, 10.0).is_err());
    assert!(GridPaths::new(&[0; 6], (usize::MAX, 3), [0.0; 2], 0.05).is_err());
    let mut empty = GridPaths::new(&[], (usize::MAX, 0), [0.0; 2], 0.05).unwrap();
    let mut costs = Vec::new();
    empty.from([0.0; 2], &[[0.0; 2]], &mut costs);
    assert_eq!(costs, [f64::INFINITY]);
}

#[test]
fn places_without_a_path_cut_no_group_off() {
    // A corridor of seven cells beside a wall; the view that would stand for all has its base in the wall.
    let blocked: Vec<bool> = (0..14).map(|i| i >= 7).collect();
    let mut paths = GridPaths::inflated(&blocked, (7, 2), [0.0; 2], 1.0, 0.0, 10.0).unwrap();
    let places = [[0.5, 0.5], [3.5, 1.5], [6.5, 0.5], [5.5, 0.5]].map(|base| Place {
        base,
        ..Place::default()
    });
    for clusters in 1..5 {
        let table = TravelTable::clustered(&places, clusters, &mut paths);
        for (a, b) in [(0, 2), (2, 3), (3, 0), (2, 2)] {
            assert!(table.path_cost(a, b).is_finite(), "{clusters}: {a} {b}");
        }
        for v in 0..4 {
            assert_eq!(table.path_cost(1, v), f64::INFINITY);
            assert_eq!(table.path_cost(v, 1), f64::INFINITY);
        }
    }
}

#[test]
fn plans_of_many_views_keep_to_the_budget() {
    let n = 90;
    let at = |v: usize| (v * 37 % n) as f64;
    let first = (0..n).map(|v| 5.0 + at(v)).collect();
    let between = (0..n * n)
        .map(|i| 5.0 + (at(i / n) - at(i % n)).abs())
        .collect();
    let task = singles(n, &Times::new(first, between).unwrap()).unwrap();
    let plain = greedy(&task);
    assert!(plain.sequence.len() > 64);
    for steps in [0, 50_000, 1_000_000] {
        let mut budget = Budget::steps(steps);
        let found = local(&task, &LocalParams::default(), &[], &mut budget);
        assert!(found.complete && found.expected_time <= plain.expected_time + 1e-9);
        // One more window or neighbourhood at most, beyond the greedy start.
        assert!(
            budget.spent() < steps + 50_000,
            "{steps}: {}",
            budget.spent()
        );
    }
}

#[test]
fn paths_from_outside_or_into_walls_are_infinite() {
    let mut blocked = [false; 9];
    blocked[4] = true;
    let mut paths = GridPaths::inflated(&blocked, (3, 3), [0.0; 2], 1.0, 0.0, 10.0).unwrap();
    let mut costs = Vec::new();
    paths.from(
        [0.5, 0.5],
        &[
            [1.5, 1.5],
            [9.0, 0.5],
            [f64::NAN, 0.0],
            [2.5, 0.5],
            [0.5, 0.5],
        ],
        &mut costs,
    );
    assert_eq!(
        costs,
        [f64::INFINITY, f64::INFINITY, f64::INFINITY, 150.0, 50.0]
    );
    paths.from([-1.0, 0.5], &[[0.5, 0.5]], &mut costs);
    assert_eq!(costs, [f64::INFINITY]);
    assert!(paths.is_passable([2.5, 2.5]) && !paths.is_passable([1.5, 1.5]));
}

#[test]
fn tables_of_chosen_views_know_their_size() {
    let mut paths = GridPaths::new(&[0; 4], (2, 2), [0.0; 2], 1.0).unwrap();
    let places = [Place {
        base: [0.5, 0.5],
        ..Place::default()
    }];
    let table = TravelTable::clustered(&places, 0, &mut paths);
    assert_eq!(table.len(), 1);
    let model = Regression::default();
    let state = Place {
        base: [1.5, 0.5],
        height: 0.1,
        ..Place::default()
    };
    assert!(table.from_state(&model, &state, &[1], &mut paths).is_err());
    let costs = table.from_state(&model, &state, &[0], &mut paths).unwrap();
    use objsearch::CostModel;
    // 100 units of path, 10 cm of lift, a drive and a look.
    assert!((costs.first(0) - (0.154_359_040_949 + 5.940_009_212_33 + 10.0 + 5.0)).abs() < 1e-9);
    assert!(cluster(&[], 5).medoids.is_empty());
    assert_eq!(cluster(&[[1.0, 1.0], [f64::NAN, 0.0]], 5).of.len(), 2);
}

#[test]
fn standing_still_moves_the_head_alone() {
    let model = Speeds::default();
    let here = Place {
        base: [1.0, 2.0],
        yaw: 3.0,
        height: 1.5,
        pitch: 0.0,
    };
    // From 3 rad to -3 rad is a short turn across pi.
    let turned = Place { yaw: -3.0, ..here };
    let short = 2.0 * (std::f64::consts::PI - 3.0);
    assert!((model.seconds(50.0, &here, &turned) - (5.0 + short / model.head)).abs() < 1e-12);
    let away = Place {
        base: [2.0, 2.0],
        ..here
    };
    assert!((model.seconds(1000.0, &here, &away) - (5.0 + 1.0 / model.drive)).abs() < 1e-12);
}

/// A world whose one view promises but never gives.
struct Mirage;

impl World for Mirage {
    type Error = Error;
    fn survey(&mut self, _: &[usize]) -> Result<Survey, Error> {
        Ok(Survey {
            task: singles(1, &every(1, 2.0))?,
            views: vec![4],
        })
    }
    fn look(&mut self, view: usize) -> Result<Look, Error> {
        assert_eq!(view, 4);
        Ok(Look {
            seconds: 2.0,
            weight: 0.0,
            found: false,
        })
    }
}

#[test]
fn promises_never_kept_end_at_the_limit_of_looks() {
    let mut plan = |task: &Task, _: &[usize]| greedy(task);
    let record = search(&mut Mirage, Mode::Continual, 7, &mut plan, &mut |_| true).unwrap();
    assert_eq!(
        (record.ended, record.steps.len(), record.plans),
        (Ended::LookLimit, 7, 7)
    );
    assert_eq!(record.expected_time, 14.0);
    let record = search(&mut Mirage, Mode::Offline, 7, &mut plan, &mut |_| true).unwrap();
    assert_eq!(
        (record.ended, record.steps.len(), record.plans),
        (Ended::PlanDone, 1, 1)
    );
    let record = search(&mut Mirage, Mode::Continual, 0, &mut plan, &mut |_| true).unwrap();
    assert!(record.steps.is_empty());
}
