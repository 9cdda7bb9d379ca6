//! Where do I look first for my keys? Views in the order of least expected time: `cargo run --example search_with_my_belief`.
#![allow(clippy::print_stdout)]

use objsearch::{Budget, Error, Goal, LocalParams, Task, Times, View, cell_weight, greedy, local};

fn main() -> Result<(), Error> {
    // What I believe: 50 % in the hall, 25 % on the desk, 15 % in the kitchen; each place is a cell.
    let weights = [
        cell_weight(0.5, 1)?,
        cell_weight(0.25, 1)?,
        cell_weight(0.15, 1)?,
    ];
    // From where I see what: the door shows hall and desk, but it is farther than the desk.
    let views = [
        View::new([0]),
        View::new([1]),
        View::new([2]),
        View::new([0, 1]),
    ];
    let names = ["hall", "desk", "kitchen", "door"];
    let first = vec![20.0, 8.0, 12.0, 18.0];
    let between = vec![
        5.0, 15.0, 25.0, 9.0, //
        15.0, 5.0, 10.0, 18.0, //
        25.0, 10.0, 5.0, 30.0, //
        9.0, 18.0, 30.0, 5.0,
    ];
    let times = Times::new(first, between)?;
    let task = Task::new(&weights, &views, &times, &Goal::default())?;
    let budget = &mut Budget::steps(10_000);
    for (planner, plan) in [
        ("greedy", greedy(&task)),
        ("local", local(&task, &LocalParams::default(), &[], budget)),
    ] {
        let order: Vec<&str> = plan.sequence.iter().map(|&v| names[v]).collect();
        println!("{planner}: {order:?}, {:.1} s expected", plan.expected_time);
    }
    Ok(())
}
