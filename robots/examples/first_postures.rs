//! Prints the DH table, the spheres, the camera's mount and the camera postures of the default robot.
#![allow(clippy::print_stdout)]

use robots::{Frame, MobileManipulator};

fn main() -> Result<(), robots::Error> {
    let robot = MobileManipulator::default();
    println!("UR5e, standard DH\n  joint   d m      a m      alpha rad   limits rad");
    for (i, ([d, a, alpha], (low, high))) in robot.arm.dh().iter().zip(robot.arm.limits).enumerate()
    {
        println!(
            "  q{}    {d:7.4}  {a:7.4}  {alpha:7.4}   {low:.4} .. {high:.4}",
            i + 1
        );
    }
    let mount = Frame::from(&robot.mount);
    println!(
        "arm mount in the base frame: {:?} m, x axis towards {:.0?}",
        mount.p, mount.x
    );
    println!(
        "base circles (x, y; radius; m): {:.3?}",
        robot.base_circles()
    );
    println!(
        "{} spheres, {} pairs\n  link  x        y        z        radius m",
        robot.body.spheres.len(),
        robot.body.pairs.len()
    );
    for s in &robot.body.spheres {
        println!(
            "  {}   {:8.4} {:8.4} {:8.4}  {:.4}",
            s.link, s.center[0], s.center[1], s.center[2], s.radius
        );
    }
    let camera = Frame::from(&robot.camera.flange_from_camera);
    println!(
        "camera on the flange: lens {:.3?} m, image right {:.3?}, down {:.3?}, forward {:.3?}",
        camera.p, camera.x, camera.y, camera.z
    );
    println!(
        "postures\n  pitch height ahead  side    q1..q6 rad                                   wait s reach overhang clear  hidden manip price"
    );
    let postures = robot.default_postures()?;
    for p in &postures {
        let wait = robot.arm_seconds(&postures[0].joints, &p.joints);
        println!(
            "  {:4.0}  {:.2}   {:.2}   {:5.2}  [{}]  {wait:.2}  {:.3}  {:6.3}  {:.3}  {:.2}  {:.4} {:.2}",
            p.view.pitch.to_degrees(),
            p.camera.p[2],
            p.camera.p[0],
            p.camera.p[1],
            p.joints.map(|q| format!("{q:6.3}")).join(", "),
            p.reach,
            p.overhang,
            p.clearance,
            p.hidden,
            p.manipulability,
            p.price,
        );
    }
    Ok(())
}
