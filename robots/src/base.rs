//! The driving base: its box, what stands on it, and the circles and spheres that cover it.

use crate::cover::circles;
use crate::frame::Frame;
use crate::shapes::{Capsule, Cuboid, Sphere};

/// How far the circles that cover the base's rectangle stick out, m: little, so that the base gets through a 0.9 m door of which a map
/// of 0.15 m voxels leaves 0.75 m.
const OVER: f64 = 0.015;
/// Spheres in each layer of the box: three in a row.
const BASE_COLUMNS: usize = 3;
/// Layers of spheres over the height of the base's box.
pub const BASE_LAYERS: usize = 3;
/// Spheres on the base: the box in layers, the pedestal, the LiDAR.
pub const BASE_SPHERES: usize = BASE_COLUMNS * BASE_LAYERS + 2;

/// A box-shaped base that turns about the middle of its rectangle; x is forward.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseShape {
    /// Extent along x, m.
    pub length: f64,
    /// Extent along y, m.
    pub width: f64,
    /// The box spans z = 0 to this height, m.
    pub height: f64,
    /// Upright cylinder under the arm: centre (x, y) in the base frame, m.
    pub pedestal: [f64; 2],
    /// Radius of the pedestal, m.
    pub pedestal_radius: f64,
    /// The pedestal spans the box's top to this height, m: the arm's mounting face.
    pub pedestal_top: f64,
    /// Centre of the LiDAR's head in the base frame, m.
    pub lidar: [f64; 3],
    /// Radius of a ball around the LiDAR's head that the arm keeps out of, m.
    pub lidar_radius: f64,
    /// Circles (centre in the base frame, radius; m) that together contain the rectangle
    /// and stick out by no more than 15 mm; at the default size one lies around the turning centre.
    pub circles: Vec<([f64; 2], f64)>,
    /// The rectangle's corners in the base frame, counter-clockwise, m.
    pub outline: [[f64; 2]; 4],
}

impl Default for BaseShape {
    fn default() -> Self {
        Self::new(
            [0.75, 0.55, 0.40],
            [0.10, 0.0, 0.50],
            0.09,
            [0.25, 0.0, 0.45],
        )
    }
}

impl BaseShape {
    /// A base of the given length, width and height (m), with a pedestal of `pedestal_radius` up to the arm's
    /// mounting point `mount` and a LiDAR at `lidar`, both in the base frame.
    #[must_use]
    pub fn new(size: [f64; 3], mount: [f64; 3], pedestal_radius: f64, lidar: [f64; 3]) -> Self {
        let [length, width, height] = size;
        let (l, w) = (0.5 * length, 0.5 * width);
        Self {
            length,
            width,
            height,
            pedestal: [mount[0], mount[1]],
            pedestal_radius,
            pedestal_top: mount[2],
            lidar,
            lidar_radius: 0.05,
            circles: circles([l, w], OVER),
            outline: [[-l, -w], [l, -w], [l, w], [-l, w]],
        }
    }

    /// Spheres in the base frame that contain the box, the pedestal and the LiDAR.
    ///
    /// Below the floor they stick out too, and 0.24 m above the box with the default sizes: for low obstacles use
    /// the circles against a planar map where one is at hand.
    #[must_use]
    pub fn spheres(&self) -> [Sphere; BASE_SPHERES] {
        let mut out = [Sphere::default(); BASE_SPHERES];
        let half = 0.5 * self.height / BASE_LAYERS as f64;
        let part = self.length / BASE_COLUMNS as f64;
        let radius = (0.5 * part).hypot(0.5 * self.width).hypot(half) + 1e-9;
        for layer in 0..BASE_LAYERS {
            for i in 0..BASE_COLUMNS {
                let x = (i as f64 + 0.5) * part - 0.5 * self.length;
                let z = (2 * layer + 1) as f64 * half;
                out[layer * BASE_COLUMNS + i] = Sphere {
                    center: [x, 0.0, z],
                    radius,
                    link: 0,
                };
            }
        }
        let post = 0.5 * (self.pedestal_top - self.height);
        let center = [self.pedestal[0], self.pedestal[1], self.height + post];
        out[BASE_SPHERES - 2] = Sphere {
            center,
            radius: self.pedestal_radius.hypot(post) + 1e-9,
            link: 0,
        };
        out[BASE_SPHERES - 1] = Sphere {
            center: self.lidar,
            radius: self.lidar_radius,
            link: 0,
        };
        out
    }

    /// The box with the base at `base_frame`.
    #[must_use]
    pub fn cuboid(&self, base_frame: &Frame) -> Cuboid {
        let middle = Frame {
            p: [0.0, 0.0, 0.5 * self.height],
            ..Frame::IDENTITY
        };
        let half = [0.5 * self.length, 0.5 * self.width, 0.5 * self.height];
        Cuboid {
            frame: middle,
            half,
        }
        .moved(base_frame)
    }

    /// The pedestal as a capsule whose rounded upper end stays below the mounting face; its lower end is inside
    /// the box.
    #[must_use]
    pub fn pedestal_capsule(&self, base_frame: &Frame) -> Capsule {
        let at = |z: f64| base_frame.apply([self.pedestal[0], self.pedestal[1], z]);
        let top = self.pedestal_top - self.pedestal_radius;
        Capsule {
            a: at(top.min(self.height)),
            b: at(top),
            radius: self.pedestal_radius,
            link: 0,
        }
    }

    /// Distance (m) from a point of the base frame to the box, the flat-topped pedestal and the LiDAR's ball;
    /// negative inside one of them.
    #[must_use]
    pub fn distance(&self, point: [f64; 3]) -> f64 {
        let [x, y, z] = point;
        let out = [
            x.abs() - 0.5 * self.length,
            y.abs() - 0.5 * self.width,
            (z - 0.5 * self.height).abs() - 0.5 * self.height,
        ];
        let cuboid = rounded(
            length2(out[0].max(0.0), out[1].max(0.0)),
            out[2].max(0.0),
            out[0].max(out[1]).max(out[2]),
        );
        let around = length2(x - self.pedestal[0], y - self.pedestal[1]) - self.pedestal_radius;
        let above = z - self.pedestal_top;
        // The cylinder is taken down to the floor: below the box's top it is inside the box.
        let pedestal = rounded(around.max(0.0), above.max(0.0), around.max(above));
        let [dx, dy, dz] = [0, 1, 2].map(|i| point[i] - self.lidar[i]);
        let lidar = (dx * dx + dy * dy + dz * dz).sqrt() - self.lidar_radius;
        cuboid.min(pedestal).min(lidar)
    }
}

/// Distance outside from its two parts, or the depth inside.
#[inline]
fn rounded(a: f64, b: f64, inside: f64) -> f64 {
    if inside > 0.0 { length2(a, b) } else { inside }
}

/// Plain root of squares: lengths of metres neither overflow nor vanish, and `hypot` is several times slower.
#[inline]
fn length2(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}
