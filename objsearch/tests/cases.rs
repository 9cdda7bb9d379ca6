//! One named case for each thing that goes wrong.
#![allow(missing_docs, clippy::unwrap_used)]

use objsearch::{CostModel, Error, Params, Status, Task, View, cell_weight, greedy, optimal, plan};

struct Every(f64);

impl CostModel for Every {
    fn first(&self, _: usize) -> f64 {
        self.0
    }
    fn between(&self, _: usize, _: usize) -> f64 {
        self.0
    }
}

#[test]
fn certain_and_impossible_probabilities_are_refused() {
    assert!(matches!(
        cell_weight(1.0, 3),
        Err(Error::Probability { .. })
    ));
    assert!(matches!(
        cell_weight(f64::NAN, 3),
        Err(Error::Probability { .. })
    ));
    assert_eq!(cell_weight(0.5, 0), Err(Error::NoCells));
    assert!(matches!(
        Task::new(&[0.1], &[], &Every(1.0), 1.5),
        Err(Error::Probability {
            what: "threshold",
            ..
        })
    ));
}

#[test]
fn wrong_tables_are_named() {
    let view = [View::new([0])];
    assert_eq!(
        Task::new(&[0.1], &[View::new([7])], &Every(1.0), 0.05),
        Err(Error::Cell {
            view: 0,
            cell: 7,
            cells: 1
        })
    );
    assert!(matches!(
        Task::new(&[-1.0], &view, &Every(1.0), 0.05),
        Err(Error::Weight { cell: 0, .. })
    ));
    assert!(matches!(
        Task::new(&[0.1], &view, &Every(f64::NAN), 0.05),
        Err(Error::Time { to: 0, .. })
    ));
    assert!(matches!(
        Task::new(&[0.1], &view, &Every(0.0), 0.05),
        Err(Error::Time { to: 0, .. })
    ));
}

#[test]
fn no_views_is_an_empty_plan() {
    let task = Task::new(&[0.1], &[], &Every(1.0), 0.05).unwrap();
    assert!(greedy(&task).sequence.is_empty());
    assert!(optimal(&task).unwrap().sequence.is_empty());
}

#[test]
fn unreachable_views_are_left_out() {
    let task = Task::new(&[0.5], &[View::new([0])], &Every(f64::INFINITY), 0.05).unwrap();
    assert!(greedy(&task).sequence.is_empty());
    assert_eq!(task.total_weight(), 0.0);
}

#[test]
fn a_zero_budget_still_answers() {
    let views: Vec<View> = (0..5).map(|v| View::new([v])).collect();
    let task = Task::new(&[0.5; 5], &views, &Every(2.0), 0.05).unwrap();
    let found = plan(
        &task,
        &Params {
            expansions: 0,
            ..Params::default()
        },
    );
    assert_eq!(found.sequence.len(), 5);
    assert_eq!(found.status, Status::BudgetExhausted);
}

#[test]
fn too_many_views_for_the_exact_planner() {
    let views: Vec<View> = (0..17).map(|v| View::new([v])).collect();
    let task = Task::new(&[0.5; 17], &views, &Every(2.0), 0.05).unwrap();
    assert_eq!(
        optimal(&task),
        Err(Error::TooManyViews {
            views: 17,
            most: 16
        })
    );
}
