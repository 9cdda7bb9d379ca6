//! How long a whole-body move takes: eq. 2 of HEATS with what it leaves out, the base's turns and accelerations.

use super::body::Joints;
use std::f64::consts::{PI, TAU};

/// Ways shorter than this are turns on the spot, m.
const SPOT: f64 = 0.05;

/// Shares of a turn that base and shoulder pan divide between them.
const SHARES: u32 = 4;

/// Speeds that a move may use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Base, m/s.
    pub v: f64,
    /// Base, rad/s.
    pub w: f64,
    /// Base, m/s2.
    pub a: f64,
    /// Base, rad/s2.
    pub alpha: f64,
    /// Each joint, rad/s.
    pub joint: f64,
}

/// Rest to rest over a distance at a top speed and an acceleration.
pub(crate) fn trapezoid(distance: f64, speed: f64, acceleration: f64) -> f64 {
    if distance * acceleration >= speed * speed {
        distance / speed + speed / acceleration
    } else {
        2.0 * (distance.max(0.0) / acceleration).sqrt()
    }
}

fn turn_between(a: f64, b: f64) -> f64 {
    let d = (a - b).rem_euclid(TAU);
    d.min(TAU - d)
}

impl Pace {
    /// Seconds from one whole-body state to another along a way of `way` m, about: turn towards the goal, drive forwards or in
    /// reverse, then let base or shoulder pan make up for the yaw, whichever is quicker. The arm moves all the while.
    /// Infinite for an infinite way.
    pub fn seconds(&self, way: f64, from: (&[f64; 3], &Joints), to: (&[f64; 3], &Joints)) -> f64 {
        if !way.is_finite() {
            return f64::INFINITY;
        }
        let others = (1..6)
            .map(|j| (from.1[j] - to.1[j]).abs() / self.joint)
            .fold(0.0, f64::max);
        // The camera's bearing is base yaw plus shoulder pan, so a yaw that is off by `yaw` is `yaw` more for the pan.
        let pan = |yaw: f64| turn_between(from.1[0], to.1[0] + yaw) / self.joint;
        let turn = |angle: f64| trapezoid(angle, self.w, self.alpha);
        // Base and pan share the turn at the end.
        let finish = |base: f64, arrival: f64| {
            let off = (to.0[2] - arrival + PI).rem_euclid(TAU) - PI;
            (0..=SHARES)
                .map(|k| {
                    let by_base = off * f64::from(k) / f64::from(SHARES);
                    (base + turn(by_base.abs()))
                        .max(pan(off - by_base))
                        .max(others)
                })
                .fold(f64::INFINITY, f64::min)
        };
        if way < SPOT {
            return finish(0.0, from.0[2]);
        }
        let heading = (to.0[1] - from.0[1]).atan2(to.0[0] - from.0[0]);
        [heading, heading + PI]
            .into_iter()
            .map(|yaw| {
                let base = turn(turn_between(yaw, from.0[2])) + trapezoid(way, self.v, self.a);
                finish(base, yaw)
            })
            .fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PACE: Pace = Pace {
        v: 0.8,
        w: 1.0,
        a: 0.8,
        alpha: 2.0,
        joint: 0.8,
    };

    #[test]
    fn a_straight_drive_is_a_trapezoid() {
        let arm = [0.0; 6];
        let t = PACE.seconds(4.0, (&[0.0; 3], &arm), (&[4.0, 0.0, 0.0], &arm));
        assert!((t - 6.0).abs() < 1e-9, "{t}");
    }

    #[test]
    fn what_is_behind_is_reached_in_reverse() {
        let arm = [0.0; 6];
        let t = PACE.seconds(4.0, (&[0.0; 3], &arm), (&[-4.0, 0.0, 0.0], &arm));
        assert!((t - 6.0).abs() < 1e-9, "{t}");
    }

    #[test]
    fn base_and_pan_share_a_turn() {
        let arm = [0.0; 6];
        let t = PACE.seconds(0.0, (&[0.0; 3], &arm), (&[0.0, 0.0, PI], &arm));
        // Half of it each; either alone would take more than 3.6 s.
        assert!((t - (0.5 * PI + 0.5)).abs() < 1e-9, "{t}");
        let t = PACE.seconds(0.0, (&[0.0; 3], &arm), (&[0.0, 0.0, 0.4], &arm));
        assert!(t < 0.5, "{t}");
    }

    #[test]
    fn no_way_takes_for_ever() {
        let arm = [0.0; 6];
        let t = PACE.seconds(f64::INFINITY, (&[0.0; 3], &arm), (&[1.0, 0.0, 0.0], &arm));
        assert_eq!(t, f64::INFINITY);
    }
}
