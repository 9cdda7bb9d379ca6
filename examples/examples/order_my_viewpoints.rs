//! In which order do I visit my viewpoints? Asymmetric times, a start, no way back: `cargo run --example order_my_viewpoints`.
#![allow(clippy::print_stdout)]

use atsp::{Error, FromFn, Params, Problem, solve};

fn main() -> Result<(), Error> {
    // Place and heading of the robot and of the views. To turn costs time, so the way back takes another time than the way there.
    let views: [([f64; 2], f64); 6] = [
        ([0.0, 0.0], 0.0),
        ([4.0, 0.5], 1.6),
        ([1.0, 3.0], 3.1),
        ([5.0, 4.0], 0.0),
        ([2.0, 1.0], 0.8),
        ([4.5, 2.5], 1.6),
    ];
    let seconds = |from: usize, to: usize| {
        let ((a, turned), (b, wanted)) = (views[from], views[to]);
        let (x, y) = (b[0] - a[0], b[1] - a[1]);
        let turn = |angle: f64| angle.sin().atan2(angle.cos()).abs();
        let heading = y.atan2(x);
        x.hypot(y) / 0.8 + turn(heading - turned) + turn(wanted - heading)
    };
    let costs = FromFn::new(views.len(), seconds);
    let found = solve(&costs, Problem::Open { start: 0 }, &Params::default())?;
    for pair in found.order.windows(2) {
        println!(
            "{} -> {}: {:.1} s",
            pair[0],
            pair[1],
            seconds(pair[0], pair[1])
        );
    }
    println!("{:.1} s in all, optimal: {}", found.cost, found.optimal);
    Ok(())
}
