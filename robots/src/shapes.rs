//! The robot's simple solids, in the frames they are fixed to and in the world.

use crate::frame::{Frame, V3, add, dot, norm, scale, sub};
use crate::ur5e::Ur5e;

/// Index of the camera among the bodies; the arm's links are 1 to 6 and the base is 0.
pub const CAMERA_LINK: u8 = 7;
/// Capsules that make up the arm.
pub const CAPSULES: usize = 8;

/// All points within `radius` of a segment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Capsule {
    /// One end of the segment, m.
    pub a: [f64; 3],
    /// Other end of the segment, m.
    pub b: [f64; 3],
    /// m.
    pub radius: f64,
    /// Link it belongs to, 0 (base) to 6 (flange). As a body-fixed shape it is given in DH frame `link`.
    pub link: u8,
}

/// A box that may be turned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cuboid {
    /// Centre (origin) and axes.
    pub frame: Frame,
    /// Half of the extents along the frame's axes, m.
    pub half: [f64; 3],
}

/// A ball of the collision model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sphere {
    /// Centre, m; in the world, or in the frame of its link where it is a table entry.
    pub center: [f64; 3],
    /// m.
    pub radius: f64,
    /// 0 base, 1 to 6 links of the arm, [`CAMERA_LINK`] camera. The camera is fixed to DH frame 6.
    pub link: u8,
}

impl Capsule {
    pub(crate) fn moved(&self, by: &Frame) -> Self {
        Self {
            a: by.apply(self.a),
            b: by.apply(self.b),
            ..*self
        }
    }

    /// Distance (m) from a point to the surface; negative inside.
    #[must_use]
    pub fn distance(&self, point: [f64; 3]) -> f64 {
        segment_distance(self.a, self.b, point) - self.radius
    }
}

impl Cuboid {
    pub(crate) fn moved(&self, by: &Frame) -> Self {
        Self {
            frame: by.then(&self.frame),
            half: self.half,
        }
    }

    /// Distance (m) from a point to the surface; negative inside.
    #[must_use]
    pub fn distance(&self, point: [f64; 3]) -> f64 {
        let local = self.frame.apply_inverse(point);
        let out = [0, 1, 2].map(|i| local[i].abs() - self.half[i]);
        let outside = norm(out.map(|v| v.max(0.0)));
        if outside > 0.0 {
            outside
        } else {
            out[0].max(out[1]).max(out[2])
        }
    }
}

pub(crate) fn segment_distance(a: V3, b: V3, point: V3) -> f64 {
    let (ab, ap) = (sub(b, a), sub(point, a));
    let square = dot(ab, ab);
    let t = if square > 0.0 {
        (dot(ap, ab) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    norm(sub(ap, scale(ab, t)))
}

/// Radii and offsets of the maker's simplified geometry.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkSizes {
    /// Radius of the shoulder housing, m.
    pub shoulder: f64,
    /// Radius of the upper arm, m.
    pub upper_arm: f64,
    /// Radius of the elbow housing, m.
    pub elbow: f64,
    /// Radius of the forearm, m.
    pub forearm: f64,
    /// Radius of the three wrist housings, m.
    pub wrist: f64,
    /// Distance of the upper arm's axis from the pan axis, m.
    pub upper_arm_offset: f64,
    /// Distance of the forearm's axis from the pan axis, m.
    pub forearm_offset: f64,
}

impl Default for LinkSizes {
    fn default() -> Self {
        Self {
            shoulder: 0.060,
            upper_arm: 0.054,
            elbow: 0.060,
            forearm: 0.040,
            wrist: 0.045,
            upper_arm_offset: 0.138,
            forearm_offset: 0.007,
        }
    }
}

impl LinkSizes {
    /// The arm as capsules, each in the DH frame of its link.
    ///
    /// Housings around a joint's axis are solids of revolution, so each may ride on either side of its joint.
    #[must_use]
    pub fn capsules(&self, arm: &Ur5e) -> [Capsule; CAPSULES] {
        let capsule = |link, a, b, radius| Capsule { a, b, radius, link };
        let (upper, fore) = (self.upper_arm_offset, self.forearm_offset);
        [
            // The column: its rounded end touches the mounting face.
            capsule(
                1,
                [0.0, self.shoulder - arm.d1, 0.0],
                [0.0; 3],
                self.shoulder,
            ),
            capsule(1, [0.0; 3], [0.0, 0.0, upper], self.shoulder),
            capsule(2, [-arm.a2, 0.0, upper], [0.0, 0.0, upper], self.upper_arm),
            capsule(2, [0.0, 0.0, upper], [0.0, 0.0, fore], self.elbow),
            capsule(3, [-arm.a3, 0.0, fore], [0.0, 0.0, fore], self.forearm),
            capsule(4, [0.0, fore - arm.d4, 0.0], [0.0; 3], self.wrist),
            capsule(5, [0.0, arm.d5, 0.0], [0.0; 3], self.wrist),
            // The flange is flat: the rounded end stops at it.
            capsule(6, [0.0, 0.0, -arm.d6], [0.0, 0.0, -self.wrist], self.wrist),
        ]
    }
}

/// Spheres of equal radius that contain a capsule: (radius, distance of the first and last centre from the
/// segment's ends), with `count` centres evenly spread.
///
/// Half-way between two centres the sphere's section must still be `radius` wide, and the cap must lie inside the
/// last sphere: with L the length, `L = 2 (R - r) + 2 (n - 1) sqrt(R^2 - r^2)`.
pub(crate) fn capsule_cover(length: f64, radius: f64, count: usize) -> (f64, f64) {
    let n = count.max(1) as f64;
    if length <= 0.0 {
        return (radius, 0.0);
    }
    let spread = |big: f64| {
        2.0 * (big - radius) + 2.0 * (n - 1.0) * (big * big - radius * radius).max(0.0).sqrt()
    };
    // Monotone in R: bisection, ending on the safe side.
    let (mut low, mut high) = (radius, radius + 0.5 * length);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if spread(middle) >= length {
            high = middle
        } else {
            low = middle
        }
    }
    (high, high - radius)
}

/// `count` spheres in `out` that contain `capsule`.
pub(crate) fn cover_capsule(capsule: &Capsule, count: usize, mut out: impl FnMut(Sphere)) {
    let axis = sub(capsule.b, capsule.a);
    let length = norm(axis);
    let (radius, inset) = capsule_cover(length, capsule.radius, count);
    for i in 0..count.max(1) {
        let part = if count > 1 {
            i as f64 / (count - 1) as f64
        } else {
            0.5
        };
        let along = if count > 1 {
            inset + part * (length - 2.0 * inset)
        } else {
            0.5 * length
        };
        let t = if length > 0.0 { along / length } else { 0.0 };
        out(Sphere {
            center: add(capsule.a, scale(axis, t)),
            radius: radius + 1e-9,
            link: capsule.link,
        });
    }
}
