//! A serial arm of any number of joints, from data: for arms that are no UR.

use crate::error::Error;
use crate::frame::{Frame, add, cross, dot, norm, scale, sub};

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about its axis; positions in rad.
    Revolute,
    /// Slides along its axis; positions in m.
    Prismatic,
}

/// A moving joint of a [`Chain`].
#[derive(Clone, Debug, PartialEq)]
pub struct ChainJoint {
    /// Its name, for messages.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Pose of the joint's frame at position zero in the frame of the joint before it.
    pub before: Frame,
    /// Axis in the joint's frame, of length one.
    pub axis: [f64; 3],
    /// Least and greatest position, rad or m.
    pub limits: (f64, f64),
    /// Greatest speed, rad/s or m/s.
    pub speed: f64,
}

/// A ball of a [`Chain`]'s cover.
#[derive(Clone, Debug, PartialEq)]
pub struct ChainSphere {
    /// Number of moving joints before it: 0 is fixed to the base, n to the last link.
    pub joint: usize,
    /// Centre in the frame after that joint, m.
    pub center: [f64; 3],
    /// m.
    pub radius: f64,
}

/// A serial arm: joints, the tip behind the last one, a camera on the tip, and balls that cover the links.
///
/// ```
/// use robots::{Chain, ChainJoint, Frame, JointKind};
/// // Two links of one metre that turn about z.
/// let joint = |x| ChainJoint {
///     name: "turn".into(), kind: JointKind::Revolute, before: Frame { p: [x, 0.0, 0.0], ..Frame::IDENTITY },
///     axis: [0.0, 0.0, 1.0], limits: (-3.0, 3.0), speed: 1.0,
/// };
/// let arm = Chain::new(vec![joint(0.0), joint(1.0)], Frame { p: [1.0, 0.0, 0.0], ..Frame::IDENTITY })?;
/// let tip = arm.tip(&[0.0, std::f64::consts::FRAC_PI_2])?;
/// assert!((tip.p[0] - 1.0).abs() < 1e-12 && (tip.p[1] - 1.0).abs() < 1e-12);
/// # Ok::<(), robots::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// The moving joints, from the base on.
    pub joints: Vec<ChainJoint>,
    /// Pose of the tip (flange, tool) in the frame after the last joint.
    pub tip: Frame,
    /// Pose of the camera's optical frame (z forward, x right, y down) in the tip's frame.
    pub camera: Frame,
    /// Balls that cover the links.
    pub spheres: Vec<ChainSphere>,
    /// Pairs of balls (lower index first) that must not touch.
    pub pairs: Vec<(usize, usize)>,
}

impl Chain {
    /// A chain without balls, the camera on the tip.
    ///
    /// # Errors
    /// No joint, an axis that is not of length one, limits the wrong way round, or a speed that is not positive.
    pub fn new(joints: Vec<ChainJoint>, tip: Frame) -> Result<Self, Error> {
        let chain = Self {
            joints,
            tip,
            camera: Frame::IDENTITY,
            spheres: Vec::new(),
            pairs: Vec::new(),
        };
        chain.validate()?;
        Ok(chain)
    }

    /// Checks every number; call it after changes by hand.
    ///
    /// # Errors
    /// As [`new`](Self::new), and for balls and pairs that do not exist or have no size.
    pub fn validate(&self) -> Result<(), Error> {
        let bad = |what: String| Err(Error::Chain { what });
        if self.joints.is_empty() {
            return bad("a chain needs at least one moving joint".into());
        }
        for j in &self.joints {
            let name = &j.name;
            if !j.before.is_finite() || (norm(j.axis) - 1.0).abs().is_nan() {
                return bad(format!("joint `{name}`: a number is not finite"));
            }
            if (norm(j.axis) - 1.0).abs() > 1e-6 {
                let length = norm(j.axis);
                return bad(format!(
                    "joint `{name}`: the axis has length {length}, must be 1"
                ));
            }
            let (low, high) = j.limits;
            if low.is_nan() || high.is_nan() || low > high {
                return bad(format!(
                    "joint `{name}`: limits {low} to {high}, must be lower first"
                ));
            }
            if j.speed.is_nan() || j.speed <= 0.0 {
                let speed = j.speed;
                return bad(format!("joint `{name}`: speed {speed}, must be positive"));
            }
        }
        if !self.tip.is_finite() || !self.camera.is_finite() {
            return bad("tip or camera: a number is not finite".into());
        }
        for (i, s) in self.spheres.iter().enumerate() {
            let finite = s.center.iter().all(|v| v.is_finite()) && s.radius.is_finite();
            if !finite || s.radius <= 0.0 || s.joint > self.joints.len() {
                return bad(format!(
                    "sphere {i}: needs a finite centre, a positive radius, and a link 0 to {}",
                    self.joints.len()
                ));
            }
        }
        let n = self.spheres.len();
        match self.pairs.iter().find(|&&(i, j)| i >= j || j >= n) {
            Some((i, j)) => bad(format!("pair ({i}, {j}): needs i < j < {n}")),
            None => Ok(()),
        }
    }

    /// Number of moving joints.
    #[must_use]
    pub fn len(&self) -> usize {
        self.joints.len()
    }

    /// True for a chain without joints, which [`validate`](Self::validate) refuses.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.joints.is_empty()
    }

    pub(crate) fn check(&self, q: &[f64]) -> Result<(), Error> {
        if q.len() != self.len() {
            return Err(Error::Joints {
                given: q.len(),
                needed: self.len(),
            });
        }
        match q.iter().all(|v| v.is_finite()) {
            true => Ok(()),
            false => Err(Error::NotFinite { field: "joints" }),
        }
    }

    /// The base frame (index 0), the frame after each joint, and last the tip; all in the base frame.
    ///
    /// # Errors
    /// A wrong number of joint positions, or one that is not finite.
    pub fn frames(&self, q: &[f64]) -> Result<Vec<Frame>, Error> {
        let mut out = Vec::with_capacity(self.len() + 2);
        self.frames_into(q, &mut out)?;
        Ok(out)
    }

    /// [`frames`](Self::frames) into a buffer that is overwritten.
    ///
    /// # Errors
    /// As [`frames`](Self::frames).
    pub fn frames_into(&self, q: &[f64], out: &mut Vec<Frame>) -> Result<(), Error> {
        self.check(q)?;
        out.clear();
        let mut frame = Frame::IDENTITY;
        out.push(frame);
        for (joint, &value) in self.joints.iter().zip(q) {
            let moved = match joint.kind {
                JointKind::Revolute => turned(joint.axis, value),
                JointKind::Prismatic => Frame {
                    p: scale(joint.axis, value),
                    ..Frame::IDENTITY
                },
            };
            frame = frame.then(&joint.before).then(&moved);
            out.push(frame);
        }
        out.push(frame.then(&self.tip));
        Ok(())
    }

    /// Pose of the tip in the base frame.
    ///
    /// # Errors
    /// As [`frames`](Self::frames).
    pub fn tip(&self, q: &[f64]) -> Result<Frame, Error> {
        let frames = self.frames(q)?;
        Ok(frames[frames.len() - 1])
    }

    /// Pose of the camera in the base frame.
    ///
    /// # Errors
    /// As [`frames`](Self::frames).
    pub fn camera(&self, q: &[f64]) -> Result<Frame, Error> {
        Ok(self.tip(q)?.then(&self.camera))
    }

    /// Geometric Jacobian of the tip in the base frame, one column [v; w] (m, rad per unit of the joint) a joint.
    ///
    /// # Errors
    /// As [`frames`](Self::frames).
    pub fn jacobian(&self, q: &[f64]) -> Result<Vec<[f64; 6]>, Error> {
        let frames = self.frames(q)?;
        Ok(self.columns(&frames))
    }

    pub(crate) fn columns(&self, frames: &[Frame]) -> Vec<[f64; 6]> {
        let tip = frames[frames.len() - 1].p;
        let mut out = Vec::with_capacity(self.len());
        for (joint, frame) in self.joints.iter().zip(&frames[1..]) {
            // Turning about the axis does not move the axis, so the frame after the joint will do.
            let axis = frame.rotate(joint.axis);
            out.push(match joint.kind {
                JointKind::Revolute => {
                    let v = cross(axis, sub(tip, frame.p));
                    [v[0], v[1], v[2], axis[0], axis[1], axis[2]]
                }
                JointKind::Prismatic => [axis[0], axis[1], axis[2], 0.0, 0.0, 0.0],
            });
        }
        out
    }

    /// Centres (m, base frame) and radii of the balls.
    ///
    /// # Errors
    /// As [`frames`](Self::frames).
    pub fn sphere_centers(&self, q: &[f64]) -> Result<Vec<([f64; 3], f64)>, Error> {
        let frames = self.frames(q)?;
        let place = |s: &ChainSphere| (frames[s.joint].apply(s.center), s.radius);
        Ok(self.spheres.iter().map(place).collect())
    }

    /// Least distance (m) between balls of [`pairs`](Self::pairs); infinite without pairs.
    ///
    /// # Errors
    /// As [`frames`](Self::frames).
    pub fn self_clearance(&self, q: &[f64]) -> Result<f64, Error> {
        let balls = self.sphere_centers(q)?;
        let gap =
            |&(i, j): &(usize, usize)| norm(sub(balls[i].0, balls[j].0)) - balls[i].1 - balls[j].1;
        Ok(self.pairs.iter().map(gap).fold(f64::INFINITY, f64::min))
    }

    /// First joint outside its limits with the amount (rad or m) it is outside.
    ///
    /// # Errors
    /// As [`frames`](Self::frames).
    pub fn limit_violation(&self, q: &[f64]) -> Result<Option<(usize, f64)>, Error> {
        self.check(q)?;
        Ok((0..self.len()).find_map(|j| {
            let (low, high) = self.joints[j].limits;
            let out = (low - q[j]).max(q[j] - high);
            (out > 0.0).then_some((j, out))
        }))
    }
}

/// Rotation about a unit axis (Rodrigues).
fn turned(axis: [f64; 3], angle: f64) -> Frame {
    let (s, c) = angle.sin_cos();
    let column = |e: [f64; 3]| {
        add(
            add(scale(e, c), scale(cross(axis, e), s)),
            scale(axis, dot(axis, e) * (1.0 - c)),
        )
    };
    Frame {
        x: column([1.0, 0.0, 0.0]),
        y: column([0.0, 1.0, 0.0]),
        z: column([0.0, 0.0, 1.0]),
        p: [0.0; 3],
    }
}
