//! Self-collision of the arm with itself, the base's box, the pedestal and the LiDAR.

use crate::body::ARM_SPHERES;
use crate::frame::{Frame, dot, sub};
use crate::manipulator::MobileManipulator;
use crate::shapes::Sphere;

/// Links up to this one cannot reach the base: the column stands on the pedestal by design.
const FIXED_LINK: u8 = 1;

impl MobileManipulator {
    /// Least distance (m) between spheres of the arm that can touch each other, and between the arm and the base's
    /// box, pedestal and LiDAR; negative in collision, -infinity if a joint angle is not finite.
    #[must_use]
    pub fn self_clearance(&self, joints: &[f64; 6]) -> f64 {
        if joints.iter().any(|q| !q.is_finite()) {
            return f64::NEG_INFINITY;
        }
        let spheres = self.spheres_in_base(joints);
        let mut least = f64::INFINITY;
        let top = self.base_top();
        for s in spheres.iter().filter(|s| s.link > FIXED_LINK) {
            // Cheap lower bound: height over everything on the base.
            if s.center[2] - top - s.radius < least {
                least = least.min(self.base.distance(s.center) - s.radius);
            }
        }
        for &(i, j) in &self.body.pairs {
            let (a, b) = (&spheres[usize::from(i)], &spheres[usize::from(j)]);
            let (d, reach) = (sub(a.center, b.center), a.radius + b.radius);
            // The root is only taken where it lowers the minimum.
            let (square, bound) = (dot(d, d), least + reach);
            if bound > 0.0 && square < bound * bound {
                least = square.sqrt() - reach;
            }
        }
        least
    }

    /// True if [`self_clearance`](Self::self_clearance) is at least `margin` (m); stops at the first sphere or pair
    /// that is not. False for joint angles that are not finite.
    #[must_use]
    pub fn self_is_free(&self, joints: &[f64; 6], margin: f64) -> bool {
        joints.iter().all(|q| q.is_finite())
            && self.spheres_are_free(&self.spheres_in_base(joints), margin)
    }

    /// [`self_is_free`](Self::self_is_free) for spheres of the arm that are already placed in the base frame.
    #[must_use]
    pub fn spheres_are_free(&self, in_base: &[Sphere; ARM_SPHERES], margin: f64) -> bool {
        let top = self
            .base
            .pedestal_top
            .max(self.base.lidar[2] + self.base.lidar_radius)
            + margin;
        let base_free = in_base.iter().filter(|s| s.link > FIXED_LINK).all(|s| {
            s.center[2] - s.radius > top || self.base.distance(s.center) - s.radius >= margin
        });
        base_free
            && self.body.pairs.iter().all(|&(i, j)| {
                let (a, b) = (&in_base[usize::from(i)], &in_base[usize::from(j)]);
                let (d, reach) = (sub(a.center, b.center), a.radius + b.radius + margin);
                dot(d, d) >= reach * reach.max(0.0)
            })
    }

    /// Height of the highest thing on the base, m.
    fn base_top(&self) -> f64 {
        self.base
            .height
            .max(self.base.pedestal_top)
            .max(self.base.lidar[2] + self.base.lidar_radius)
    }

    /// Spheres of the arm in the base frame.
    #[inline]
    #[must_use]
    pub fn spheres_in_base(&self, joints: &[f64; 6]) -> [Sphere; ARM_SPHERES] {
        let frames = self.arm.chain(&Frame::from(&self.mount), joints);
        self.body.spheres.map(|s| Sphere {
            center: frames[usize::from(s.link.min(6))].apply(s.center),
            ..s
        })
    }
}
