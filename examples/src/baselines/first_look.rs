//! The first look around, as HEATS begins with the camera alone.

use crate::heats::{BodyPath, Joints, STEP, Whole};
use std::f64::consts::{PI, TAU};

/// Steps of a turn.
const STEPS: usize = 70;
/// Time in which the camera is lowered, s.
const LOWERING: f64 = 2.5;

/// Rest to rest, within the limits of acceleration.
fn ease(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

/// Turns on the spot with the camera level, and back with it lowered to `down`, so that the floor around the start is known; where
/// the base cannot turn, the shoulder does.
pub(super) fn first_look(whole: &Whole<'_>, from: ([f64; 3], Joints), down: &Joints) -> BodyPath {
    let (base, joints) = from;
    let turns = whole.turns_clear(base, 0.1);
    let mut path = BodyPath {
        base: Vec::new(),
        joints: Vec::new(),
    };
    for back in [false, true] {
        for i in 0..=if turns { STEPS } else { 3 * STEPS } {
            let lower = if back {
                ease((i as f64 * STEP / LOWERING).min(1.0))
            } else {
                0.0
            };
            let mut at: Joints = std::array::from_fn(|j| joints[j] + lower * (down[j] - joints[j]));
            let mut pose = base;
            if turns {
                let part = ease(i as f64 / STEPS as f64);
                pose[2] += TAU * if back { 1.0 - part } else { part };
            } else {
                // To one side, to the other, and back.
                let third = i / STEPS;
                let part = ease((i - third * STEPS) as f64 / STEPS as f64);
                at[0] += 0.8
                    * PI
                    * match third {
                        0 => part,
                        1 => 1.0 - 2.0 * part,
                        2 => part - 1.0,
                        _ => 0.0,
                    };
            }
            path.base.push(pose);
            path.joints.push(at);
        }
    }
    path
}
