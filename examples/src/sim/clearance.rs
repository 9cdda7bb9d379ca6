//! Exact distance between robot and world.

use super::body::{Body, Part, PartShape};
use super::distance::{Placed, Plan, Prism, to_segment};
use super::tree::{Aabb, gap};
use super::world::World;
use crate::scene::parry_pose as pose;
use crate::scene::{Form, Solid};
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

/// The core of a part.
enum Core {
    Segment([f64; 3], [f64; 3]),
    Box(Cuboid),
    Cylinder(Cylinder),
}

/// A part prepared for queries.
struct Prepared {
    core: Core,
    /// Pose of the core in the world; that of a segment is only a translation.
    pose: Pose,
    /// Radius around the core, m.
    radius: f64,
    aabb: Aabb,
    /// The part as an upright prism, if it is one.
    prism: Option<Prism>,
    /// Kind, centre and axes of a box or cylinder.
    frame: Option<(Form, [f64; 3], [[f64; 3]; 3])>,
}

fn columns(rows: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|j| [rows[0][j], rows[1][j], rows[2][j]])
}

/// Whether a rotation leaves z upright, either way round.
fn is_upright(rotation: &[[f64; 3]; 3]) -> bool {
    rotation[0][2].hypot(rotation[1][2]) < 1e-9
}

fn prepare(shape: &PartShape) -> Prepared {
    match *shape {
        PartShape::Capsule { a, b, radius } => {
            let low = [0, 1, 2].map(|k| a[k].min(b[k]) - radius);
            let high = [0, 1, 2].map(|k| a[k].max(b[k]) + radius);
            let pose = Pose::from_translation(vec3([0, 1, 2].map(|k| 0.5 * (a[k] + b[k]))));
            Prepared {
                core: Core::Segment(a, b),
                pose,
                radius,
                aabb: (low, high),
                prism: None,
                frame: None,
            }
        }
        PartShape::Box {
            center,
            rotation,
            half,
        } => {
            let reach =
                [0, 1, 2].map(|k| (0..3).map(|j| rotation[k][j].abs() * half[j]).sum::<f64>());
            let aabb = around(center, reach);
            let axis = [rotation[0][0], rotation[1][0]];
            let axes = columns(&rotation);
            let plan = Plan::Rectangle([center[0], center[1]], axis, [half[0], half[1]]);
            Prepared {
                core: Core::Box(Cuboid::new(vec3(half))),
                pose: pose(&axes, center),
                radius: 0.0,
                prism: upright(&rotation, plan, &aabb),
                frame: Some((Form::Box(half), center, axes)),
                aabb,
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
            let aabb = around(center, reach);
            let axes = columns(&rotation);
            let plan = Plan::Disc([center[0], center[1]], radius);
            Prepared {
                core: Core::Cylinder(Cylinder::new(half_height as f32, radius as f32)),
                pose: cylinder_pose(&axes, center),
                radius: 0.0,
                prism: upright(&rotation, plan, &aabb),
                frame: Some((Form::Cylinder(radius, half_height), center, axes)),
                aabb,
            }
        }
    }
}

fn upright(rotation: &[[f64; 3]; 3], plan: Plan, aabb: &Aabb) -> Option<Prism> {
    is_upright(rotation).then(|| Prism {
        plan,
        low: aabb.0[2],
        high: aabb.1[2],
    })
}

fn around(center: [f64; 3], reach: [f64; 3]) -> Aabb {
    (
        [0, 1, 2].map(|k| center[k] - reach[k]),
        [0, 1, 2].map(|k| center[k] + reach[k]),
    )
}

impl Prepared {
    fn body(&self) -> Option<Placed<'_>> {
        self.frame.as_ref().map(|(form, center, axes)| Placed {
            form,
            center: *center,
            axes: *axes,
        })
    }

    fn distance(&self, solid: &Solid) -> f64 {
        if let (Some(part), Some(other)) = (&self.prism, Prism::of(solid)) {
            return part.distance(&other);
        }
        if let Core::Segment(a, b) = self.core
            && let Some(distance) = to_segment(solid, a, b)
        {
            return distance - self.radius;
        }
        let (shape, at) = solid.parry();
        let segment;
        let core: &dyn Shape = match &self.core {
            Core::Segment(a, b) => {
                let half = [0, 1, 2].map(|k| 0.5 * (b[k] - a[k]));
                segment = Segment::new(vec3(half.map(|v| -v)), vec3(half));
                &segment
            }
            Core::Box(s) => s,
            Core::Cylinder(s) => s,
        };
        // All pairs used here are supported; an unsupported one counts as touching.
        let between = query::distance(&self.pose, core, at, shape.as_ref());
        let between = between.map_or(0.0, |d| f64::from(d.distance));
        let tighter = self
            .body()
            .and_then(|body| body.approach(&Placed::of(solid)));
        between.min(tighter.unwrap_or(between)) - self.radius
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
