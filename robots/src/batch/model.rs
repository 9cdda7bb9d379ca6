//! The robot's tables in single precision, and forward kinematics of sixteen states at once.

use super::lanes::{LANES, LaneFrame, Lanes, Lanes3, each, sin_cos, splat, sum2};
use crate::body::ARM_SPHERES;
use crate::frame::Frame;
use crate::manipulator::{BodyState, MobileManipulator};

/// A [`MobileManipulator`] prepared for batched checks: its tables in single precision.
///
/// Made once and used for many states; it does not follow later changes of the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct BatchBody {
    mount: [[f32; 3]; 4],
    /// d1, a2, a3, d4, d5, d6.
    lengths: [f32; 6],
    pub(crate) spheres: [([f32; 3], f32, u8); ARM_SPHERES],
    pub(crate) pairs: Vec<(u8, u8, f32)>,
    pub(crate) base: BaseTable,
}

/// What stands on the base, in the base frame, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BaseTable {
    pub(crate) half: [f32; 3],
    pub(crate) pedestal: [f32; 4],
    pub(crate) lidar: [f32; 4],
}

/// Sixteen states side by side.
#[derive(Clone, Copy, Debug)]
pub struct StateBlock {
    /// x (m), y (m), yaw (rad) of the base in the world.
    pub base: [Lanes; 3],
    /// Joint angles, rad.
    pub joints: [Lanes; 6],
}

impl StateBlock {
    /// From at most [`LANES`] states; the last one fills the lanes that are left. All zero for none.
    #[must_use]
    pub fn new(states: &[BodyState]) -> Self {
        let mut out = Self {
            base: [[0.0; LANES]; 3],
            joints: [[0.0; LANES]; 6],
        };
        let Some(last) = states.len().checked_sub(1) else {
            return out;
        };
        for l in 0..LANES {
            let s = &states[l.min(last)];
            for i in 0..3 {
                out.base[i][l] = s.base[i] as f32;
            }
            for j in 0..6 {
                out.joints[j][l] = s.joints[j] as f32;
            }
        }
        out
    }
}

/// Sphere centres of sixteen states: `[sphere][axis][lane]`, m.
pub type SphereLanes = [[Lanes; 3]; ARM_SPHERES];

impl BatchBody {
    /// Copies the robot's tables.
    #[must_use]
    pub fn new(robot: &MobileManipulator) -> Self {
        let narrow = |v: [f64; 3]| v.map(|x| x as f32);
        let mount = Frame::from(&robot.mount);
        let (arm, base) = (&robot.arm, &robot.base);
        Self {
            mount: [mount.x, mount.y, mount.z, mount.p].map(narrow),
            lengths: [arm.d1, arm.a2, arm.a3, arm.d4, arm.d5, arm.d6].map(|v| v as f32),
            spheres: robot
                .body
                .spheres
                .map(|s| (narrow(s.center), s.radius as f32, s.link)),
            pairs: robot
                .body
                .pairs
                .iter()
                .map(|&(i, j)| {
                    let of = |k: u8| robot.body.spheres[usize::from(k)].radius;
                    (i, j, (of(i) + of(j)) as f32)
                })
                .collect(),
            base: BaseTable {
                half: narrow([0.5 * base.length, 0.5 * base.width, 0.5 * base.height]),
                pedestal: [
                    base.pedestal[0] as f32,
                    base.pedestal[1] as f32,
                    base.pedestal_radius as f32,
                    base.pedestal_top as f32,
                ],
                lidar: [
                    base.lidar[0] as f32,
                    base.lidar[1] as f32,
                    base.lidar[2] as f32,
                    base.lidar_radius as f32,
                ],
            },
        }
    }

    /// Sphere centres in the base frame, in the order of [`ArmBody::spheres`](crate::ArmBody::spheres).
    #[inline(always)]
    pub(crate) fn in_base(&self, joints: &[Lanes; 6]) -> SphereLanes {
        let frames = self.chain(joints);
        let mut out = [[[0.0; LANES]; 3]; ARM_SPHERES];
        for (to, (center, _, link)) in out.iter_mut().zip(&self.spheres) {
            *to = frames[usize::from((*link).min(6))].apply(*center);
        }
        out
    }

    /// Frames 0 (mount) to 6 (flange) in the base frame: the DH recursion of [`Ur5e::chain`](crate::Ur5e::chain).
    #[inline(always)]
    fn chain(&self, joints: &[Lanes; 6]) -> [LaneFrame; 7] {
        let wide = |v: [f32; 3]| v.map(splat);
        let root = LaneFrame {
            x: wide(self.mount[0]),
            y: wide(self.mount[1]),
            z: wide(self.mount[2]),
            p: wide(self.mount[3]),
        };
        let [d1, a2, a3, d4, d5, d6] = self.lengths;
        let f1 = up(&root, &joints[0], d1);
        let f2 = flat(&f1, &joints[1], a2, 0.0);
        let f3 = flat(&f2, &joints[2], a3, 0.0);
        let f4 = up(&f3, &joints[3], d4);
        let f5 = down(&f4, &joints[4], d5);
        let f6 = flat(&f5, &joints[5], 0.0, d6);
        [root, f1, f2, f3, f4, f5, f6]
    }
}

/// Points of the base frame in the world.
#[inline(always)]
pub(crate) fn to_world(turn: &(Lanes, Lanes), base: &[Lanes; 3], p: &Lanes3) -> Lanes3 {
    let (sin, cos) = turn;
    [
        each(|l| base[0][l] + (cos[l] * p[0][l] - sin[l] * p[1][l])),
        each(|l| base[1][l] + (sin[l] * p[0][l] + cos[l] * p[1][l])),
        p[2],
    ]
}

#[inline(always)]
fn turned(f: &LaneFrame, angle: &Lanes) -> (Lanes3, Lanes3) {
    let (s, c) = sin_cos(angle);
    let minus = each(|l| -s[l]);
    let (mut x, mut y) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    for i in 0..3 {
        x[i] = sum2(&f.x[i], &c, &f.y[i], &s);
        y[i] = sum2(&f.y[i], &c, &f.x[i], &minus);
    }
    (x, y)
}

#[inline(always)]
fn moved(p: &Lanes3, along: &Lanes3, by: f32) -> Lanes3 {
    let mut out = *p;
    for i in 0..3 {
        for l in 0..LANES {
            out[i][l] += along[i][l] * by;
        }
    }
    out
}

#[inline(always)]
fn negated(v: &Lanes3) -> Lanes3 {
    let mut out = *v;
    for row in &mut out {
        for value in row {
            *value = -*value;
        }
    }
    out
}

/// Joint with a = 0, alpha = pi/2.
#[inline(always)]
fn up(f: &LaneFrame, angle: &Lanes, d: f32) -> LaneFrame {
    let (x, y) = turned(f, angle);
    LaneFrame {
        x,
        y: f.z,
        z: negated(&y),
        p: moved(&f.p, &f.z, d),
    }
}

/// Joint with a = 0, alpha = -pi/2.
#[inline(always)]
fn down(f: &LaneFrame, angle: &Lanes, d: f32) -> LaneFrame {
    let (x, y) = turned(f, angle);
    LaneFrame {
        x,
        y: negated(&f.z),
        z: y,
        p: moved(&f.p, &f.z, d),
    }
}

/// Joint with alpha = 0.
#[inline(always)]
fn flat(f: &LaneFrame, angle: &Lanes, a: f32, d: f32) -> LaneFrame {
    let (x, y) = turned(f, angle);
    LaneFrame {
        x,
        y,
        z: f.z,
        p: moved(&moved(&f.p, &x, a), &f.z, d),
    }
}
