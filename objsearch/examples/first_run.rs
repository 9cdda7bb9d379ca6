//! Three volumes, five views: prints the greedy, the branch-and-bound and the optimal order.
#![allow(clippy::print_stdout)]

use objsearch::{CostModel, Error, Params, Task, View, cell_weight, greedy, optimal, plan};

/// Views on a line, 0.5 m/s, 5 s to look.
struct Line([f64; 5]);

impl CostModel for Line {
    fn first(&self, view: usize) -> f64 {
        self.0[view].abs() / 0.5 + 5.0
    }
    fn between(&self, from: usize, to: usize) -> f64 {
        (self.0[from] - self.0[to]).abs() / 0.5 + 5.0
    }
}

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
    let task = Task::new(&weights, &views, &Line([1.0, 6.0, -2.0, -4.0, 9.0]), 0.05)?;
    for (name, found) in [
        ("greedy", greedy(&task)),
        ("branch and bound", plan(&task, &Params::default())),
        ("optimal", optimal(&task)?),
    ] {
        println!(
            "{name:>16}: views {:?}, expected {:.1} s",
            found.sequence, found.expected_time
        );
    }
    Ok(())
}
