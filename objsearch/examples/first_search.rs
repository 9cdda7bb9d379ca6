//! Three volumes, five views: prints the greedy, the branch-and-bound, the local and the optimal order.
#![allow(clippy::print_stdout)]

use objsearch::{
    BranchParams, Budget, Error, Goal, LocalParams, Task, Times, View, branch_and_bound,
    cell_weight, greedy, local, optimal,
};

fn main() -> Result<(), Error> {
    // One cell stands for 50: shelf 20 %, table 50 %, window sill 10 %.
    let weights = [
        50.0 * cell_weight(0.2, 50)?,
        50.0 * cell_weight(0.5, 50)?,
        50.0 * cell_weight(0.1, 50)?,
    ];
    let views = [
        View::new([0]),
        View::new([1]),
        View::new([2]),
        View::new([0, 2]),
        View::new([1, 2]),
    ];
    // Views on a line, 0.5 m/s, 5 s to look.
    let at = [1.0f64, 6.0, -2.0, -4.0, 9.0];
    let first = at.map(|x| x.abs() / 0.5 + 5.0).to_vec();
    let between = at
        .iter()
        .flat_map(|a| at.iter().map(move |b| (a - b).abs() / 0.5 + 5.0))
        .collect();
    let task = Task::new(
        &weights,
        &views,
        &Times::new(first, between)?,
        &Goal::default(),
    )?;
    let budget = || Budget::steps(100_000);
    for (name, found) in [
        ("greedy", greedy(&task)),
        (
            "branch and bound",
            branch_and_bound(&task, &BranchParams::default(), &mut budget()),
        ),
        (
            "local",
            local(&task, &LocalParams::default(), &[], &mut budget()),
        ),
        ("optimal", optimal(&task)?),
    ] {
        println!(
            "{name:>16}: views {:?}, expected {:.1} s",
            found.sequence, found.expected_time
        );
    }
    Ok(())
}
