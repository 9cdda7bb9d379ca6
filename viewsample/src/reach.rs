//! Where the base must stand for a camera pose: an inverse reachability map (Vahrenkamp, Asfour, Dillmann 2013).

use crate::rng::Rng;
use crate::{Pose, Robot};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Heights of one bin, m.
const HEIGHT: f64 = 0.08;
/// Pitches and rolls of one bin, rad.
const ANGLE: f64 = TAU / 24.0;
/// Base poses tried for each bin.
const DRAWS: usize = 240;

/// Base poses from which a camera pose can be taken up, by what of it does not depend on the place: height, pitch and roll. Each bin
/// is filled when it is first asked for, by inverse kinematics, and the same whatever was asked before. It holds for one robot:
/// the first that asked.
///
/// A camera that looks down on a high cabinet is in reach of few bases, and one drawn blindly is hardly ever among them.
#[derive(Clone, Debug)]
pub struct InverseReach {
    radius: f64,
    bins: BTreeMap<[i32; 3], Vec<[f64; 3]>>,
}

/// What a camera pose is without its place: heading, and the bin of the rest.
fn bin_of(camera: &Pose) -> (f64, [i32; 3]) {
    let r = &camera.rotation;
    let yaw = r[1][2].atan2(r[0][2]);
    let pitch = r[2][2].clamp(-1.0, 1.0).asin();
    // Without roll the right of the image is level, and its down as steep as the pitch says.
    let roll = (-r[2][0]).atan2(-r[2][1]);
    let bin = [camera.translation[2] / HEIGHT, pitch / ANGLE, roll / ANGLE];
    (yaw, bin.map(|v| v.floor() as i32))
}

impl InverseReach {
    /// For a robot whose camera is never farther than `radius` m from the base's axis.
    pub fn new(radius: f64) -> Self {
        Self {
            radius,
            bins: BTreeMap::new(),
        }
    }

    /// One of the base poses (x, y, yaw) that may take up the camera pose; none if it is out of reach. `pick` in 0..1 chooses.
    pub(crate) fn base<R>(&mut self, robot: &R, camera: &Pose, pick: f64) -> Option<[f64; 3]>
    where
        R: Robot + ?Sized,
    {
        let (yaw, key) = bin_of(camera);
        let radius = self.radius;
        let bin = self
            .bins
            .entry(key)
            .or_insert_with(|| fill(robot, key, radius));
        let at = (pick.clamp(0.0, 1.0) * bin.len() as f64) as usize;
        let [x, y, turn] = *bin.get(at.min(bin.len().saturating_sub(1)))?;
        let (s, c) = yaw.sin_cos();
        let eye = camera.translation;
        Some([eye[0] + c * x - s * y, eye[1] + s * x + c * y, yaw + turn])
    }
}

/// Base poses, seen from the camera's place and heading, that reach a camera somewhere in the bin.
fn fill<R: Robot + ?Sized>(robot: &R, key: [i32; 3], radius: f64) -> Vec<[f64; 3]> {
    let seed = key.iter().fold(0x5bd1_e995_u64, |h, &k| {
        (h ^ u64::from(k as u32)).wrapping_mul(0x2545_f491_4f6c_dd1d)
    });
    let mut rng = Rng::new(seed);
    let mut out = Vec::new();
    for _ in 0..DRAWS {
        let mut inside = |k: usize| f64::from(key[k]) + rng.between(0.0, 1.0);
        let (height, pitch, roll) = (inside(0) * HEIGHT, inside(1) * ANGLE, inside(2) * ANGLE);
        let distance = radius * rng.between(0.0, 1.0).sqrt();
        let (s, c) = rng.between(0.0, TAU).sin_cos();
        let base = [distance * c, distance * s, rng.between(0.0, TAU)];
        let camera = Pose::looking([0.0, 0.0, height], 0.0, pitch).rolled(roll);
        if robot.reach(&camera.seen_from(base)).is_some() {
            out.push(base);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reaches what is near its axis, not too high, and ahead of it.
    struct Boom;

    impl Robot for Boom {
        type State = Pose;
        fn reach(&self, camera: &Pose) -> Option<Pose> {
            let [x, y, z] = camera.translation;
            (x > 0.0 && x.hypot(y) < 0.5 && z < 1.2).then_some(*camera)
        }
        fn is_free(&self, _: [f64; 3], _: &Pose) -> bool {
            true
        }
        fn base_is_free(&self, _: [f64; 3]) -> bool {
            true
        }
    }

    #[test]
    fn bases_reach_the_camera() {
        let mut reach = InverseReach::new(1.0);
        let mut rng = Rng::new(11);
        let mut named = 0;
        for _ in 0..500 {
            let eye = [
                rng.between(-4.0, 4.0),
                rng.between(-4.0, 4.0),
                rng.between(0.2, 2.0),
            ];
            let camera = Pose::looking(eye, rng.between(-3.0, 3.0), rng.between(-1.4, 1.4))
                .rolled(rng.between(-3.0, 3.0));
            let pick = rng.between(0.0, 1.0);
            let base = reach.base(&Boom, &camera, pick);
            assert_eq!(base, reach.base(&Boom, &camera, pick));
            assert_eq!(base, InverseReach::new(1.0).base(&Boom, &camera, pick));
            if let Some(base) = base {
                named += 1;
                assert!(eye[2] < 1.2 + HEIGHT);
                let level = Pose {
                    translation: [eye[0], eye[1], 1.0],
                    ..camera
                };
                assert!(Boom.reach(&level.seen_from(base)).is_some());
            } else {
                assert!(eye[2] > 1.2 - HEIGHT);
            }
        }
        assert!((100..400).contains(&named));
    }

    #[test]
    fn bins_hold_what_they_are_named_for() {
        let mut rng = Rng::new(3);
        for _ in 0..2000 {
            let (yaw, pitch, roll) = (
                rng.between(-3.0, 3.0),
                rng.between(-1.5, 1.5),
                rng.between(-3.1, 3.1),
            );
            let height = rng.between(0.1, 1.6);
            let camera = Pose::looking([1.0, 2.0, height], yaw, pitch).rolled(roll);
            let (heading, bin) = bin_of(&camera);
            assert!((heading - yaw).abs() < 1e-9);
            let expected = [height / HEIGHT, pitch / ANGLE, roll / ANGLE];
            for k in 0..3 {
                let off = expected[k] - f64::from(bin[k]);
                assert!(
                    (-1e-6..1.0 + 1e-6).contains(&off),
                    "{k}: {off} {roll} {bin:?}"
                );
            }
        }
    }
}
