//! Camera poses around frontier cells, drawn within the sensor's and the robot's limits.

use super::fan::FanPose;
use super::interval::{Constraints, Interval};
use crate::Error;
use crate::rng::Rng;

/// What limits camera poses.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// Least and greatest distance between camera and target, m.
    pub range: (f64, f64),
    /// Taken off the greatest distance, m.
    pub range_tolerance: f64,
    /// Least and greatest height of the camera, m.
    pub height: (f64, f64),
    /// Least and greatest elevation of the optical axis, up positive, rad.
    pub pitch: (f64, f64),
    /// Vertical field of view, rad: where the pitch is at its limit the target may be at the image's border.
    pub vertical_fov: f64,
}

impl Default for Limits {
    /// The PR2 of FLAP's experiments.
    fn default() -> Self {
        Self {
            range: (0.4, 3.0),
            range_tolerance: 0.01,
            height: (1.484, 1.784),
            pitch: (-50f64.to_radians(), 20f64.to_radians()),
            vertical_fov: 0.6855,
        }
    }
}

pub(super) fn bad(field: &'static str, value: f64) -> Error {
    Error::Param {
        field,
        value,
        range: "within its limits and finite",
    }
}

pub(super) fn positive(field: &'static str, value: f64) -> Result<(), Error> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(Error::Param {
            field,
            value,
            range: "positive and finite",
        })
    }
}

impl Limits {
    /// Checks every field.
    ///
    /// # Errors
    /// [`Error::Param`] for an interval that is empty or not finite, a negative tolerance or field of view.
    pub fn validate(&self) -> Result<(), Error> {
        positive("range.1", self.range.1 - self.range_tolerance)?;
        let ordered = |field, (low, high): (f64, f64)| {
            if low <= high && low.is_finite() && high.is_finite() {
                Ok(())
            } else {
                Err(Error::Param {
                    field,
                    value: low,
                    range: "finite and not above its upper limit",
                })
            }
        };
        ordered("range", (self.range.0, self.range.1 - self.range_tolerance))?;
        ordered("height", self.height)?;
        ordered("pitch", self.pitch)?;
        let right = std::f64::consts::FRAC_PI_2;
        for (field, value) in [("pitch", self.pitch.0), ("pitch", self.pitch.1)] {
            if value.abs() > right {
                return Err(bad(field, value));
            }
        }
        for (field, value, most) in [
            ("range.0", self.range.0, f64::MAX),
            ("range_tolerance", self.range_tolerance, f64::MAX),
            ("vertical_fov", self.vertical_fov, std::f64::consts::PI),
        ] {
            if !(0.0..=most).contains(&value) {
                return Err(bad(field, value));
            }
        }
        Ok(())
    }

    fn distances(&self) -> Interval {
        Interval::new(self.range.0, self.range.1 - self.range_tolerance)
    }

    /// Sines of the angle of depression at which a target may be seen.
    fn depressions(&self) -> Interval {
        let right = std::f64::consts::FRAC_PI_2;
        let sine = |angle: f64| angle.clamp(-right, right).sin();
        Interval::new(
            -sine(self.pitch.1 + 0.5 * self.vertical_fov),
            -sine(self.pitch.0 - 0.5 * self.vertical_fov),
        )
    }

    /// Whether a pose satisfies every constraint towards a target: distance, height, pitch, side of the frontier, and
    /// the target straight ahead, or above or below the axis by no more than half the field of view where the pitch is at
    /// its limit.
    pub fn allow(&self, pose: &FanPose, target: &Target) -> bool {
        const SLACK: f64 = 1e-9;
        let d = [0, 1, 2].map(|a| pose.position[a] - target.center[a]);
        let r = d.iter().map(|v| v * v).sum::<f64>().sqrt();
        let (distances, sines) = (self.distances(), self.depressions());
        let within =
            |value: f64, low: f64, high: f64| value >= low - SLACK && value <= high + SLACK;
        let side = target
            .normal
            .is_none_or(|n| (0..3).map(|a| n[a] * d[a]).sum::<f64>() >= -SLACK);
        let elevation = -(d[2] / r).asin();
        let wanted = elevation.clamp(self.pitch.0, self.pitch.1);
        let heading = d[0] == 0.0 && d[1] == 0.0 || {
            let off = pose.yaw - (-d[1]).atan2(-d[0]);
            off.sin().abs() < 1e-6 && off.cos() > 0.0
        };
        side && heading
            && within(r, distances.low, distances.high)
            && within(pose.position[2], self.height.0, self.height.1)
            && within(d[2] / r, sines.low, sines.high)
            && within(pose.pitch, wanted, wanted)
    }
}

/// A cell to look at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Its centre, m.
    pub center: [f64; 3],
    /// Direction to the side from which to look, of any length but 0; any side if absent.
    pub normal: Option<[f64; 3]>,
}

/// Draws poses, each towards a random one of `targets`: the range, height, pitch and normal intervals are narrowed by
/// constraint propagation, height is drawn first, then the other two coordinates in random order, narrowing again after
/// each (FLAP sect. 3.1).
///
/// Calls `take` with each pose and the index of its target until it says stop, or no target can be seen from anywhere.
/// Returns how many tries failed. `most` limits the tries.
///
/// # Errors
/// As [`Limits::validate`].
pub fn sample_poses(
    targets: &[Target],
    limits: &Limits,
    seed: u64,
    most: usize,
    take: &mut dyn FnMut(FanPose, usize) -> bool,
) -> Result<usize, Error> {
    limits.validate()?;
    let mut rng = Rng::new(seed);
    // Targets not known to be unobservable, and what is left of their intervals once that was looked at.
    let mut open: Vec<usize> = (0..targets.len()).collect();
    let mut start: Vec<Option<Constraints>> = vec![None; targets.len()];
    let mut failed = 0;
    for _ in 0..most {
        if open.is_empty() {
            break;
        }
        let slot = rng.below(open.len());
        let index = open[slot];
        let target = &targets[index];
        let constraints = match start[index] {
            Some(known) => known,
            None => {
                let fresh =
                    initial(target, limits).filter(|_| target.center.iter().all(|v| v.is_finite()));
                let Some(fresh) = fresh else {
                    open.swap_remove(slot);
                    continue;
                };
                start[index] = Some(fresh);
                fresh
            }
        };
        match draw(constraints, target, limits, &mut rng) {
            Some(pose) => {
                if !take(pose, index) {
                    break;
                }
            }
            None => failed += 1,
        }
    }
    Ok(failed)
}

/// Draws `count` poses at a fixed place (m): any heading, any pitch within the limits, and any height unless one is
/// given. FLAP's local mode.
///
/// # Errors
/// As [`Limits::validate`].
pub fn sample_from(
    place: [f64; 2],
    height: Option<f64>,
    limits: &Limits,
    seed: u64,
    count: usize,
) -> Result<Vec<FanPose>, Error> {
    limits.validate()?;
    let mut rng = Rng::new(seed);
    let draw = |_| {
        let z = height.unwrap_or_else(|| rng.between(limits.height.0, limits.height.1));
        FanPose {
            position: [place[0], place[1], z],
            pitch: rng.between(limits.pitch.0, limits.pitch.1),
            yaw: rng.between(0.0, std::f64::consts::TAU),
        }
    };
    Ok((0..count).map(draw).collect())
}

/// The intervals of a target, narrowed; `None` if it can be seen from nowhere.
fn initial(target: &Target, limits: &Limits) -> Option<Constraints> {
    let r = limits.distances();
    let cube = Interval::new(-r.high, r.high);
    let h = target.center[2];
    let lift = Interval::new(limits.height.0 - h, limits.height.1 - h);
    let length = |n: [f64; 3]| n.iter().map(|v| v * v).sum::<f64>().sqrt();
    let normal = target
        .normal
        .filter(|&n| length(n) > 0.0 && length(n).is_finite());
    let (n, b) = match normal {
        Some(n) => (n.map(|v| v / length(n)), Interval::new(0.0, 1.0)),
        None => ([0.0, 0.0, 1.0], Interval::new(-1.0, 1.0)),
    };
    let mut found = Constraints {
        d: [cube, cube, cube.common(lift)],
        r,
        b,
        a: limits.depressions(),
        n,
    };
    found.propagate().then_some(found)
}

/// One try.
fn draw(
    mut constraints: Constraints,
    target: &Target,
    limits: &Limits,
    rng: &mut Rng,
) -> Option<FanPose> {
    // Height first: fewer tries fail.
    let order = if rng.below(2) == 0 {
        [2, 0, 1]
    } else {
        [2, 1, 0]
    };
    for axis in order {
        let least = constraints.least(axis);
        let Interval { low, high } = constraints.d[axis];
        let parts = [
            Interval::new(low, high.min(-least)),
            Interval::new(low.max(least), high),
        ];
        let [below, above] = parts.map(|p| p.width().max(0.0));
        let choice = rng.between(0.0, below + above);
        let part = if parts[0].is_empty() || (choice >= below && !parts[1].is_empty()) {
            parts[1]
        } else {
            parts[0]
        };
        if part.is_empty() {
            return None;
        }
        constraints.d[axis] = Interval::point(rng.between(part.low, part.high.max(part.low)));
        if !constraints.propagate() {
            return None;
        }
    }
    let d = constraints.d.map(|i| i.low);
    let r = d.iter().map(|v| v * v).sum::<f64>().sqrt();
    let pose = FanPose {
        position: [0, 1, 2].map(|a| target.center[a] + d[a]),
        yaw: (-d[1]).atan2(-d[0]),
        pitch: (-(d[2] / r).asin()).clamp(limits.pitch.0, limits.pitch.1),
    };
    // Propagation stops short of the last thousandth.
    limits.allow(&pose, target).then_some(pose)
}
