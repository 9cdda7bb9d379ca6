//! The robot's tables in single precision, and forward kinematics of sixteen states at once.

use super::lanes::{LANES, LaneFrame, Lanes, Lanes3, fused, sin_cos};
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

/// To be filled.
pub(crate) const NO_SPHERES: SphereLanes = [[[0.0; LANES]; 3]; ARM_SPHERES];

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
    pub(crate) fn in_base<const FMA: bool>(&self, joints: &[Lanes; 6], out: &mut SphereLanes) {
        let mut frames = [[[[0.0; LANES]; 3]; 4]; 7];
        self.chain::<FMA>(joints, &mut frames);
        for (to, (center, _, link)) in out.iter_mut().zip(&self.spheres) {
            let [x, y, z, p] = &frames[usize::from((*link).min(6))];
            let [a, b, c] = *center;
            for i in 0..3 {
                for l in 0..LANES {
                    let sum = fused::<FMA>(y[i][l], b, fused::<FMA>(z[i][l], c, p[i][l]));
                    to[i][l] = fused::<FMA>(x[i][l], a, sum);
                }
            }
        }
    }

    /// Frames 0 (mount) to 6 (flange) in the base frame: the DH recursion of [`Ur5e::chain`](crate::Ur5e::chain), one
    /// lane after the other in the source, in vectors in the machine's code.
    #[inline(always)]
    fn chain<const FMA: bool>(&self, joints: &[Lanes; 6], frames: &mut [LaneFrame; 7]) {
        let [d1, a2, a3, d4, d5, d6] = self.lengths;
        let root = Narrow(self.mount);
        for l in 0..LANES {
            let angle = |j: usize| sin_cos::<FMA>(joints[j][l]);
            let f1 = root.turned::<FMA>(angle(0), 0.0, d1).folded();
            let f2 = f1.turned::<FMA>(angle(1), a2, 0.0);
            let f3 = f2.turned::<FMA>(angle(2), a3, 0.0);
            let f4 = f3.turned::<FMA>(angle(3), 0.0, d4).folded();
            let f5 = f4.turned::<FMA>(angle(4), 0.0, d5).folded_back();
            let f6 = f5.turned::<FMA>(angle(5), 0.0, d6);
            root.store(&mut frames[0], l);
            f1.store(&mut frames[1], l);
            f2.store(&mut frames[2], l);
            f3.store(&mut frames[3], l);
            f4.store(&mut frames[4], l);
            f5.store(&mut frames[5], l);
            f6.store(&mut frames[6], l);
        }
    }
}

/// A frame of one lane: columns and origin.
#[derive(Clone, Copy)]
struct Narrow([[f32; 3]; 4]);

impl Narrow {
    /// Turned about z, moved by `d` along it and by `a` along the new x.
    #[inline(always)]
    fn turned<const FMA: bool>(&self, (s, c): (f32, f32), a: f32, d: f32) -> Self {
        let [x, y, z, p] = self.0;
        let mut out = self.0;
        for i in 0..3 {
            out[0][i] = fused::<FMA>(x[i], c, y[i] * s);
            out[1][i] = fused::<FMA>(y[i], c, -(x[i] * s));
            out[3][i] = fused::<FMA>(out[0][i], a, fused::<FMA>(z[i], d, p[i]));
        }
        Self(out)
    }

    /// Turned by pi/2 about x.
    #[inline(always)]
    fn folded(&self) -> Self {
        let [x, y, z, p] = self.0;
        Self([x, z, y.map(|v| -v), p])
    }

    /// Turned by -pi/2 about x.
    #[inline(always)]
    fn folded_back(&self) -> Self {
        let [x, y, z, p] = self.0;
        Self([x, z.map(|v| -v), y, p])
    }

    #[inline(always)]
    fn store(&self, to: &mut LaneFrame, l: usize) {
        for k in 0..4 {
            for i in 0..3 {
                to[k][i][l] = self.0[k][i];
            }
        }
    }
}

/// Points of the base frame in the world.
#[inline(always)]
pub(crate) fn to_world<const FMA: bool>(
    turn: &(Lanes, Lanes),
    base: &[Lanes; 3],
    p: &Lanes3,
) -> Lanes3 {
    let (sin, cos) = turn;
    let mut out = *p;
    for l in 0..LANES {
        let (x, y) = (p[0][l], p[1][l]);
        out[0][l] = fused::<FMA>(cos[l], x, fused::<FMA>(-sin[l], y, base[0][l]));
        out[1][l] = fused::<FMA>(sin[l], x, fused::<FMA>(cos[l], y, base[1][l]));
    }
    out
}

/// Sine and cosine of every lane.
#[inline(always)]
pub(crate) fn turns<const FMA: bool>(angle: &Lanes) -> (Lanes, Lanes) {
    let (mut sin, mut cos) = ([0.0; LANES], [0.0; LANES]);
    for l in 0..LANES {
        (sin[l], cos[l]) = sin_cos::<FMA>(angle[l]);
    }
    (sin, cos)
}
