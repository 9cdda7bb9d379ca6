//! Exact distance between robot and world.

use super::body::{Body, Part, PartShape};
use super::tree::{Aabb, gap};
use super::world::World;
use crate::scene::Solid;
use crate::scene::parry_pose as pose;
use crate::scene::{parry_cylinder_pose as cylinder_pose, parry_vector as vec3};
use parry3d::math::Pose;
use parry3d::query;
use parry3d::shape::{Cuboid, Cylinder, Segment, Shape};

/// The nearest pair of robot part and world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Distance, m; 0 or less when they touch; the search bound when nothing is nearer.
    pub distance: f64,
    /// Index of the part; `None` when nothing is nearer than the bound.
    pub part: Option<usize>,
    /// Index of the solid; `None` with a part means floor or ceiling.
    pub solid: Option<usize>,
}

/// A part prepared for queries: its core, the radius around the core, and its bounding box.
enum Core {
    Segment(Segment),
    Box(Cuboid),
    Cylinder(Cylinder),
}

struct Prepared {
    core: Core,
    pose: Pose,
    radius: f64,
    aabb: Aabb,
}

fn columns(rows: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|j| [rows[0][j], rows[1][j], rows[2][j]])
}

fn prepare(shape: &PartShape) -> Prepared {
    match *shape {
        PartShape::Capsule { a, b, radius } => {
            let middle = [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]));
            let half = [0, 1, 2].map(|k| 0.5 * (b[k] - a[k]));
            let core = Segment::new(vec3(half.map(|v| -v)), vec3(half));
            let low = [0, 1, 2].map(|k| a[k].min(b[k]) - radius);
            let high = [0, 1, 2].map(|k| a[k].max(b[k]) + radius);
            let pose = Pose::from_translation(vec3(middle));
            Prepared {
                core: Core::Segment(core),
                pose,
                radius,
                aabb: (low, high),
            }
        }
        PartShape::Box {
            center,
            rotation,
            half,
        } => {
            let reach =
                [0, 1, 2].map(|k| (0..3).map(|j| rotation[k][j].abs() * half[j]).sum::<f64>());
            Prepared {
                core: Core::Box(Cuboid::new(vec3(half))),
                pose: pose(&columns(&rotation), center),
                radius: 0.0,
                aabb: around(center, reach),
            }
        }
        PartShape::Cylinder {
            center,
            rotation,
            radius,
            half_height,
        } => {
            let reach = [0, 1, 2].map(|k| {
                let a = rotation[k][2];
                half_height * a.abs() + radius * (1.0 - a * a).max(0.0).sqrt()
            });
            Prepared {
                core: Core::Cylinder(Cylinder::new(half_height as f32, radius as f32)),
                pose: cylinder_pose(&columns(&rotation), center),
                radius: 0.0,
                aabb: around(center, reach),
            }
        }
    }
}

fn around(center: [f64; 3], reach: [f64; 3]) -> Aabb {
    (
        [0, 1, 2].map(|k| center[k] - reach[k]),
        [0, 1, 2].map(|k| center[k] + reach[k]),
    )
}

impl Prepared {
    fn distance(&self, solid: &Solid) -> f64 {
        let (shape, at) = solid.parry();
        let core: &dyn Shape = match &self.core {
            Core::Segment(s) => s,
            Core::Box(s) => s,
            Core::Cylinder(s) => s,
        };
        // All pairs used here are supported; an unsupported one counts as touching.
        let between = query::distance(&self.pose, core, at, shape.as_ref());
        between.map_or(0.0, |d| f64::from(d.distance)) - self.radius
    }
}

impl World {
    /// Distance from a convex shape to the nearest solid, floor or ceiling, m; `up_to` when nothing is nearer.
    pub fn distance(&self, shape: &PartShape, up_to: f64) -> f64 {
        let part = Part {
            shape: *shape,
            stands: false,
            name: "",
        };
        let mut best = Clearance {
            distance: up_to,
            part: None,
            solid: None,
        };
        self.nearer(0, &part, &mut best);
        best.distance
    }

    /// The nearest pair of a robot's parts and the world, exact below `up_to`.
    pub fn clearance(&self, body: &Body, up_to: f64) -> Clearance {
        let mut best = Clearance {
            distance: up_to,
            part: None,
            solid: None,
        };
        for (i, part) in body.parts.iter().enumerate() {
            self.nearer(i, part, &mut best);
        }
        best
    }

    fn nearer(&self, index: usize, part: &Part, best: &mut Clearance) {
        let prepared = prepare(&part.shape);
        let (low, high) = prepared.aabb;
        let floor = if part.stands {
            f64::INFINITY
        } else {
            low[2] - self.floor
        };
        let plane = floor.min(self.ceiling - high[2]);
        if plane < best.distance {
            *best = Clearance {
                distance: plane,
                part: Some(index),
                solid: None,
            };
        }
        self.tree.descend(
            best.distance.max(0.0),
            |low, high| gap(&prepared.aabb, low, high),
            |i, limit| {
                let solid = &self.solids[i];
                if gap(&prepared.aabb, &solid.low, &solid.high) <= limit {
                    let distance = prepared.distance(solid);
                    if distance < best.distance {
                        *best = Clearance {
                            distance,
                            part: Some(index),
                            solid: Some(i),
                        };
                    }
                }
                best.distance.max(0.0)
            },
        );
    }
}
