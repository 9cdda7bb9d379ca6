//! Closed-form inverse kinematics of the UR family: all branches, flags at singular sets, no allocation.

use crate::frame::{Frame, V3, add, cross, dot, norm, scale, sub};
use crate::ur5e::{Ur5e, jacobian_of};
use nalgebra::{Isometry3, Matrix6, Vector6};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Which singular sets a solution lies on or next to (relative distance below 1e-6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Singular {
    /// The wrist centre lies on the cylinder of radius d4 around the pan axis: both shoulder branches meet.
    pub shoulder: bool,
    /// The elbow is straight or folded (sin q3 = 0): both elbow branches meet.
    pub elbow: bool,
    /// Axes 4 and 6 are parallel (sin q5 = 0): only q4 +- q6 is determined, q6 was taken from the caller.
    pub wrist: bool,
}

impl Singular {
    /// True on any of the sets.
    #[must_use]
    pub fn any(self) -> bool {
        self.shoulder || self.elbow || self.wrist
    }
}

/// One joint vector that reaches the wanted flange pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IkSolution {
    /// Joint angles in (-pi, pi], rad. Limits are not applied here.
    pub joints: [f64; 6],
    /// Branch number: bit 2 shoulder, bit 1 wrist, bit 0 elbow. Where branches meet only the lower one is listed.
    pub branch: u8,
    /// Singular sets near this solution.
    pub singular: Singular,
}

/// Up to eight solutions, ordered by branch number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IkSolutions {
    all: [IkSolution; 8],
    len: usize,
}

impl IkSolutions {
    /// The solutions.
    #[must_use]
    pub fn as_slice(&self) -> &[IkSolution] {
        &self.all[..self.len]
    }
    /// Number of solutions, 0 to 8.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }
    /// True if the pose is out of reach.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }
    fn push(&mut self, solution: IkSolution) {
        if self.len < 8 {
            self.all[self.len] = solution;
            self.len += 1;
        }
    }
}

/// A pose may lie this far (m) inside the shoulder cylinder and still be clamped onto it.
const SHOULDER_SLACK: f64 = 1e-9;
/// |sin q3| below which both elbows are the same: merging costs less than 1e-14 m, being of second order.
const MERGE_ELBOW: f64 = 1e-7;
/// Distance (m) from the shoulder cylinder's tangent point below which both shoulders are the same: the size of
/// the rounding error there.
const MERGE_SHOULDER: f64 = 1e-8;
/// |sin q5| below which q6 is the caller's: a wrong q6 then costs less than 2e-10 rad.
const WRIST: f64 = 1e-10;
/// Excess of |cos q3| over 1 that is clamped: at most 2e-10 m of position error.
const ELBOW_SLACK: f64 = 1e-9;
/// The same next to another singular set, where rounding in q1 or q6 moves the elbow's target much farther;
/// what is clamped there is then worked off by damped steps, or the branch is dropped.
const ELBOW_SLACK_SINGULAR: f64 = 1e-4;
/// Closure error (m or rad) up to which a solution clamped next to two singular sets is kept.
const KEEP: f64 = 1e-8;
/// Distance to a singular set that raises its flag.
const FLAG: f64 = 1e-6;
/// Some units in the last place.
const ROUNDING: f64 = 4e-15;
/// Closure error (m or rad) above which a Newton step is tried.
const POLISH: f64 = 1e-13;

impl Ur5e {
    /// All solutions for a flange pose given in the arm's base frame; `out` is overwritten.
    ///
    /// A pose out of reach, or with a number that is not finite, leaves `out` empty. On the wrist's singular
    /// set q6 = 0 is chosen where it can be; see [`ik_near`](Self::ik_near) to choose another.
    pub fn ik(&self, base_from_flange: &Isometry3<f64>, out: &mut IkSolutions) {
        self.ik_near(&Frame::from(base_from_flange), 0.0, out);
    }

    /// As [`ik`](Self::ik), with the q6 (rad) to keep where the wrist is singular.
    ///
    /// If that q6 would put the elbow out of reach, the nearest q6 that does not is taken: a reachable pose
    /// never loses its last solution.
    pub fn ik_near(&self, base_from_flange: &Frame, wrist3: f64, out: &mut IkSolutions) {
        out.len = 0;
        let t = base_from_flange;
        if !t.is_finite() || !wrist3.is_finite() {
            return;
        }
        // Centre of the third wrist joint; its distance from the arm's plane is d4.
        let p5 = sub(t.p, scale(t.z, self.d6));
        let rho = p5[0].hypot(p5[1]);
        if rho < self.d4 - SHOULDER_SLACK {
            return;
        }
        let side = ((rho - self.d4) * (rho + self.d4)).max(0.0).sqrt();
        let middle = p5[1].atan2(p5[0]) + FRAC_PI_2;
        let merged = side < MERGE_SHOULDER;
        let half = if merged { 0.0 } else { side.atan2(self.d4) };
        for (bit, q1) in [(0u8, middle + half), (4, middle - half)] {
            if bit == 4 && merged {
                break;
            }
            self.wrist_branches(t, p5, wrap(q1), wrist3, bit, side < FLAG, out);
        }
    }

    fn wrist_branches(
        &self,
        t: &Frame,
        p5: V3,
        q1: f64,
        wrist3: f64,
        bit: u8,
        shoulder: bool,
        out: &mut IkSolutions,
    ) {
        let (s1, c1) = q1.sin_cos();
        let ahead = [c1, s1, 0.0]; // horizontal axis of the arm's plane
        let normal = [s1, -c1, 0.0]; // z axis of frames 1, 2, 3
        let c5 = dot(t.z, normal);
        let s5_abs = dot(t.z, ahead).hypot(t.z[2]);
        let plane = Plane {
            reach: dot(p5, ahead),
            height: p5[2] - self.d1,
        };
        let (along, across) = (dot(normal, t.x), -dot(normal, t.y));
        let in_flange = along.hypot(across);
        for (wrist_bit, sign) in [(0u8, 1.0), (2, -1.0)] {
            let singular = s5_abs <= WRIST || in_flange <= 0.0;
            let s5 = if singular { 0.0 } else { sign * s5_abs };
            let q5 = s5.atan2(c5);
            let (s6, c6) = if singular {
                wrist3.sin_cos()
            } else {
                (sign * across / in_flange, sign * along / in_flange)
            };
            // x axis of frame 4 has the angle q2 + q3 + q4 in the arm's plane.
            let x4 = sub(
                scale(sub(scale(t.x, c6), scale(t.y, s6)), c5),
                scale(t.z, s5),
            );
            let mut wrist = Wrist {
                q5,
                s6,
                c6,
                sum: (x4[2], dot(x4, ahead)),
            };
            let mut elbow = self.elbow(&plane, wrist.sum, shoulder);
            if elbow.is_none()
                && s5_abs < FLAG
                && let Some(moved) = self.reachable_wrist(&plane, &wrist, t, ahead, c5)
            {
                // Turning q6 off its nominal value costs |sin q5| times the turn.
                let turn = wrap(moved.s6.atan2(moved.c6) - s6.atan2(c6)).abs();
                wrist = moved;
                elbow = self.elbow(&plane, wrist.sum, shoulder);
                if let Some(e) = elbow.as_mut() {
                    e.strained |= turn * s5_abs > 1e-12;
                }
            }
            if let Some(elbow) = elbow {
                // Near the sets of the wrist and the shoulder rounding in q6 and q1 moves the elbow's target by as much
                // more, and so far is the square of sin q3 uncertain.
                let wrist_doubt = if singular { 0.0 } else { ROUNDING / s5_abs };
                let doubt = wrist_doubt + ROUNDING / plane.reach.abs().max(FLAG);
                let flags = Singular {
                    shoulder,
                    elbow: elbow.s3 * elbow.s3 < FLAG * FLAG + doubt,
                    wrist: s5_abs < FLAG,
                };
                self.elbow_branches(t, q1, (s1, c1), &wrist, &elbow, bit | wrist_bit, flags, out);
            }
            if singular {
                break;
            }
        }
    }

    /// The planar two-link problem: from the shoulder axis to the origin of frame 3.
    fn elbow(&self, plane: &Plane, (s_sum, c_sum): (f64, f64), singular: bool) -> Option<Elbow> {
        let u = plane.reach - self.d5 * s_sum;
        let w = plane.height + self.d5 * c_sum;
        let c3 =
            (u * u + w * w - self.a2 * self.a2 - self.a3 * self.a3) / (2.0 * self.a2 * self.a3);
        let slack = if singular {
            ELBOW_SLACK_SINGULAR
        } else {
            ELBOW_SLACK
        };
        if c3.is_nan() || c3.abs() > 1.0 + slack {
            return None;
        }
        let strained = c3.abs() > 1.0 + ELBOW_SLACK;
        let c3 = c3.clamp(-1.0, 1.0);
        let mut s3 = ((1.0 - c3) * (1.0 + c3)).sqrt();
        if s3 < MERGE_ELBOW {
            s3 = 0.0;
        }
        Some(Elbow {
            u,
            w,
            c3,
            s3,
            strained,
        })
    }

    fn elbow_branches(
        &self,
        t: &Frame,
        q1: f64,
        turn1: (f64, f64),
        wrist: &Wrist,
        elbow: &Elbow,
        bits: u8,
        singular: Singular,
        out: &mut IkSolutions,
    ) {
        let q6 = wrist.s6.atan2(wrist.c6);
        let sum = wrist.sum.0.atan2(wrist.sum.1);
        let direction = elbow.w.atan2(elbow.u);
        // Angle of the elbow triangle; mirrored by the sign of q3.
        let inner = (self.a3 * elbow.s3).atan2(self.a2 + self.a3 * elbow.c3);
        let q3 = elbow.s3.atan2(elbow.c3);
        for (elbow_bit, sign) in [(0u8, 1.0), (1, -1.0)] {
            let q2 = wrap(direction - sign * inner);
            let joints = [q1, q2, sign * q3, wrap(sum - q2 - sign * q3), wrist.q5, q6];
            if elbow.strained {
                if let Some(joints) = self.relaxed(joints, t) {
                    out.push(IkSolution {
                        joints,
                        branch: bits | elbow_bit,
                        singular,
                    });
                }
            } else {
                let joints = self.polished(joints, turn1, t, singular);
                out.push(IkSolution {
                    joints,
                    branch: bits | elbow_bit,
                    singular,
                });
            }
            if elbow.s3 == 0.0 {
                break;
            }
        }
    }

    /// On the wrist's singular set frame 3 may lie anywhere on a circle of radius d5: the point of that circle
    /// within the arm's reach that is nearest to the wanted one.
    fn reachable_wrist(
        &self,
        plane: &Plane,
        wanted: &Wrist,
        t: &Frame,
        ahead: V3,
        c5: f64,
    ) -> Option<Wrist> {
        let centre = plane.reach.hypot(plane.height);
        let product = 2.0 * self.d5 * centre;
        if product < 1e-12 {
            return None;
        }
        let (l2, l3) = (self.a2.abs(), self.a3.abs());
        let cosine = |r: f64| (r * r - centre * centre - self.d5 * self.d5) / product;
        let (low, high) = (cosine((l2 - l3).abs()).max(-1.0), cosine(l2 + l3).min(1.0));
        if low > high + 1e-9 {
            return None;
        }
        let inset = (0.01 * (high - low)).max(0.0);
        // (u, w) = centre + d5 (cos theta, sin theta) with theta = sum + pi/2.
        let toward = plane.height.atan2(plane.reach);
        let theta = wrap(wanted.sum.0.atan2(wanted.sum.1) + FRAC_PI_2 - toward);
        let cos_new = theta.cos().clamp(
            (low + inset).min(1.0),
            (high - inset).max(-1.0).max((low + inset).min(1.0)),
        );
        let theta_new = cos_new.clamp(-1.0, 1.0).acos().copysign(theta);
        let sum = theta_new + toward - FRAC_PI_2;
        let (s, c) = sum.sin_cos();
        let x4: V3 = add(scale(ahead, c), [0.0, 0.0, s]);
        let sign = if c5 < 0.0 { -1.0 } else { 1.0 };
        let (s6, c6) = (-sign * dot(x4, t.y), sign * dot(x4, t.x));
        let length = s6.hypot(c6);
        (length > 0.5).then(|| Wrist {
            q5: wanted.q5,
            s6: s6 / length,
            c6: c6 / length,
            sum: (s, c),
        })
    }

    /// Damped steps that close the pose where the Jacobian has lost rank; `None` if it stays open.
    fn relaxed(&self, joints: [f64; 6], target: &Frame) -> Option<[f64; 6]> {
        let mut q = joints;
        for _ in 0..8 {
            let frames = self.chain(&Frame::IDENTITY, &q);
            let error = twist(&frames[6], target);
            if error.amax() <= 1e-12 {
                return Some(q);
            }
            let j = jacobian_of(&frames);
            let damped = j * j.transpose() + Matrix6::from_diagonal_element(1e-12);
            let step = j.transpose() * damped.cholesky()?.solve(&error);
            for k in 0..6 {
                q[k] = wrap(q[k] + step[k]);
            }
        }
        (twist(&self.chain(&Frame::IDENTITY, &q)[6], target).amax() <= KEEP).then_some(q)
    }

    /// One Newton step on SE(3) where the closure is worse than rounding and the Jacobian is sound.
    fn polished(
        &self,
        joints: [f64; 6],
        turn1: (f64, f64),
        target: &Frame,
        singular: Singular,
    ) -> [f64; 6] {
        let mut turns = joints.map(|_| turn1);
        for j in 1..6 {
            turns[j] = joints[j].sin_cos();
        }
        let frames = self.chain_sin_cos(&Frame::IDENTITY, &turns);
        let error = twist(&frames[6], target);
        let size = error.amax();
        if size <= POLISH || singular.any() {
            return joints;
        }
        let Some(step) = jacobian_of(&frames).lu().solve(&error) else {
            return joints;
        };
        let mut better = joints;
        for j in 0..6 {
            better[j] = wrap(joints[j] + step[j]);
        }
        let after = twist(&self.chain(&Frame::IDENTITY, &better)[6], target).amax();
        if after < size { better } else { joints }
    }
}

struct Plane {
    reach: f64,
    height: f64,
}

struct Wrist {
    q5: f64,
    s6: f64,
    c6: f64,
    /// Sine and cosine of q2 + q3 + q4.
    sum: (f64, f64),
}

struct Elbow {
    u: f64,
    w: f64,
    c3: f64,
    s3: f64,
    /// Clamped by more than rounding explains.
    strained: bool,
}

/// Small motion (m, rad) that brings `from` onto `to`, first order.
fn twist(from: &Frame, to: &Frame) -> Vector6<f64> {
    let v = sub(to.p, from.p);
    let w = scale(
        add(
            add(cross(from.x, to.x), cross(from.y, to.y)),
            cross(from.z, to.z),
        ),
        0.5,
    );
    debug_assert!(norm(w).is_finite());
    Vector6::new(v[0], v[1], v[2], w[0], w[1], w[2])
}

/// The angle's copy in (-pi, pi].
#[inline]
pub(crate) fn wrap(angle: f64) -> f64 {
    if angle > -PI && angle <= PI {
        return angle;
    }
    let turned = angle - TAU * (angle / TAU).round();
    if turned <= -PI { turned + TAU } else { turned }
}
