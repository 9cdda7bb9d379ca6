//! The three motions of the base, as exact arcs.

/// What the base is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Motion {
    /// Driving along its x axis.
    Forward,
    /// Driving against its x axis.
    Reverse,
    /// Turning in place.
    Turn,
}

/// One constant-curvature motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Move {
    pub(crate) motion: Motion,
    /// Metres travelled (not negative), or radians turned (signed).
    pub(crate) amount: f64,
    /// Heading change per metre travelled, rad/m; left is positive. Zero for a turn.
    pub(crate) curvature: f64,
}

impl Move {
    pub(crate) fn drive(motion: Motion, amount: f64, curvature: f64) -> Self {
        Self {
            motion,
            amount,
            curvature,
        }
    }

    pub(crate) fn turn(angle: f64) -> Self {
        Self {
            motion: Motion::Turn,
            amount: angle,
            curvature: 0.0,
        }
    }

    /// Length of the parameter range of [`pose_at`](Self::pose_at): m, or rad for a turn.
    pub(crate) fn extent(&self) -> f64 {
        self.amount.abs()
    }

    /// Heading change over the whole move, rad.
    pub(crate) fn heading_change(&self) -> f64 {
        if self.motion == Motion::Turn {
            self.amount
        } else {
            self.amount * self.curvature
        }
    }

    /// Pose after `s` of the move's extent from `p`. Yaw is not wrapped.
    pub(crate) fn pose_at(&self, p: [f64; 3], s: f64) -> [f64; 3] {
        let sign = match self.motion {
            Motion::Turn => return [p[0], p[1], p[2] + s * self.amount.signum()],
            Motion::Forward => 1.0,
            Motion::Reverse => -1.0,
        };
        let (sin, cos) = p[2].sin_cos();
        if self.curvature.abs() * s < 1e-7 {
            return [
                p[0] + sign * s * cos,
                p[1] + sign * s * sin,
                p[2] + self.curvature * s,
            ];
        }
        let yaw = p[2] + self.curvature * s;
        let (sin1, cos1) = yaw.sin_cos();
        let r = sign / self.curvature;
        [p[0] + r * (sin1 - sin), p[1] + r * (cos - cos1), yaw]
    }

    pub(crate) fn end(&self, p: [f64; 3]) -> [f64; 3] {
        self.pose_at(p, self.extent())
    }
}

/// Angle in (-pi, pi].
pub(crate) fn wrap(a: f64) -> f64 {
    let t = std::f64::consts::TAU;
    let w = a - t * (a / t).round();
    if w <= -std::f64::consts::PI { w + t } else { w }
}
