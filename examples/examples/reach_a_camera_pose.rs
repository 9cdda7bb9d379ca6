//! Which joints put the camera there? All closed-form solutions, and the best: `cargo run --example reach_a_camera_pose`.
#![allow(clippy::print_stdout)]

use robots::{MobileManipulator, looking};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = MobileManipulator::default();
    let now = robot.default_postures()?[0].joints;
    // From where the base stands: look down a little to the left, from 0.6 m ahead and 1.1 m up.
    let base = [2.0, 1.0, 0.0];
    let wanted = looking([2.6, 1.1, 1.1], 0.5, -0.4);
    let found = robot.ik_camera_frame(base, &wanted, &now);
    for s in found.as_slice() {
        println!(
            "{:6.2?} rad  {:.2} s away, {:.3} m from itself",
            s.joints, s.seconds, s.clearance
        );
    }
    let best = found.best().ok_or("no posture reaches that pose")?;
    println!("best: {:.3?}", best.joints);
    Ok(())
}
