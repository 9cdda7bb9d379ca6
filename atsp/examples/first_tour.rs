//! Orders five viewpoints in two rooms and prints which one to visit first.
#![allow(clippy::print_stdout)]

use atsp::{Decision, Params, Place, two_level};

fn main() -> Result<(), atsp::Error> {
    // Robot at the origin of room 0; three views there, two in room 1 behind a door at x = 6 m.
    let views = [
        (2.0, 1.0),
        (4.0, -1.0),
        (1.0, -2.0),
        (8.0, 1.0),
        (9.0, -1.0),
    ];
    let rooms = [0, 0, 0, 1, 1];
    let centres = [(3.0, 0.0), (8.5, 0.0)];
    let at = |place: Place| match place {
        Place::Robot => (0.0, 0.0),
        Place::Candidate(c) => views[c],
        Place::Region(r) => centres[r],
    };
    let seconds = |a: Place, b: Place| {
        let ((ax, ay), (bx, by)) = (at(a), at(b));
        f64::hypot(ax - bx, ay - by) / 0.8
    };
    let decision = Decision {
        current: 0,
        regions: 2,
        region_of: &rooms,
    };
    if let Some(choice) = two_level(&decision, seconds, &Params::default())? {
        println!("rooms in the order {:?}", choice.region_order);
        println!(
            "views of this room in the order {:?}",
            choice.viewpoint_order
        );
        println!(
            "go to view {} at {:?}",
            choice.candidate, views[choice.candidate]
        );
    }
    Ok(())
}
