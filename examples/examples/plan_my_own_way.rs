//! Is my own planner any good? One rule of thumb beside the planners here: `cargo run --example plan_my_own_way`.
#![allow(clippy::print_stdout)]

use objsearch::{Budget, Error, Goal, LocalParams, Plan, Status, Task, Times, View};
use objsearch::{cell_weight, greedy, local};

/// Always to the nearest view: what a robot does that does not plan.
fn nearest_first(task: &Task) -> Plan {
    let mut order: Vec<usize> = Vec::new();
    while let Some(next) = (0..task.len())
        .filter(|view| task.is_reachable(*view) && !order.contains(view))
        .min_by(|&a, &b| {
            let seconds = |view| task.seconds(order.last().copied(), view);
            seconds(a).total_cmp(&seconds(b))
        })
    {
        order.push(next);
    }
    // Passes over views that show nothing new, and stops when enough is seen.
    let worth = task.evaluate(&order);
    Plan {
        sequence: worth.used,
        expected_time: worth.expected_time,
        probability: worth.probability,
        complete: worth.complete,
        lower_bound: 0.0,
        status: Status::Finished,
        expansions: order.len() as u64,
    }
}

fn main() -> Result<(), Error> {
    // Nine shelves along a corridor, the object most likely at its far end; from view 9 the last three are in sight at once.
    let shelves = 9_usize;
    let weights = (0..shelves)
        .map(|k| cell_weight(if k < 6 { 0.05 } else { 0.22 }, 1))
        .collect::<Result<Vec<f64>, Error>>()?;
    let mut views: Vec<View> = (0..shelves).map(|k| View::new([k])).collect();
    views.push(View::new([6, 7, 8]));
    let place = |view: usize| if view == shelves { 7.0 } else { view as f64 };
    let seconds = |from: f64, to: usize| 4.0 + 3.0 * (from - place(to)).abs();
    let all = 0..views.len();
    let first = all.clone().map(|to| seconds(-1.0, to)).collect();
    let between = all
        .clone()
        .flat_map(|from| all.clone().map(move |to| (from, to)))
        .map(|(from, to)| seconds(place(from), to))
        .collect();
    let times = Times::new(first, between)?;
    let task = Task::new(&weights, &views, &times, &Goal::default())?;

    let budget = &mut Budget::steps(10_000);
    for (planner, plan) in [
        ("nearest first", nearest_first(&task)),
        ("greedy", greedy(&task)),
        ("local", local(&task, &LocalParams::default(), &[], budget)),
    ] {
        let (order, time) = (&plan.sequence, plan.expected_time);
        println!("{planner}: {order:?}, {time:.1} s expected");
    }
    Ok(())
}
