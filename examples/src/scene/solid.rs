//! A shape as exact geometry: rays, containment, extent, and parry's form of it for distances.

use super::format::Shape;
use parry3d::math::{Pose, Rot3, Vec3};
use parry3d::query::{Ray, RayCast};
use parry3d::shape::{Cuboid, Cylinder, SharedShape, TriMesh};

/// Slope below which a box counts as upright; over 30 m it amounts to 0.03 mm.
const UPRIGHT: f64 = 1e-6;

/// The kind of a solid and its sizes in its own frame.
#[derive(Clone, Debug)]
pub enum Form {
    /// A box of these half extents, m.
    Box([f64; 3]),
    /// A cylinder along local z: radius and half length, m.
    Cylinder(f64, f64),
    /// Triangles in the world frame; the solid's frame is the identity.
    Mesh(Box<Mesh>),
}

/// A triangle mesh in the world frame.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Corners, m.
    pub vertices: Vec<[f64; 3]>,
    /// Indices of corners.
    pub triangles: Vec<[u32; 3]>,
    /// parry's mesh, with its own bounding volume tree.
    tree: TriMesh,
}

/// A solid of the world with its frame.
#[derive(Clone)]
pub struct Solid {
    /// `object.part`.
    pub name: String,
    /// Kind and sizes.
    pub form: Form,
    /// Origin of its frame in the world, m.
    pub center: [f64; 3],
    /// Its three local axes in the world frame, unit.
    pub axes: [[f64; 3]; 3],
    /// Local z is world z: its faces are walls, floors and lids.
    pub upright: bool,
    /// Lower corner of its bounding box in the world, m.
    pub low: [f64; 3],
    /// Upper corner of its bounding box in the world, m.
    pub high: [f64; 3],
    parry: SharedShape,
    pose: Pose,
}

impl std::fmt::Debug for Solid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Solid")
            .field("name", &self.name)
            .field("low", &self.low)
            .finish()
    }
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn vec3(a: [f64; 3]) -> Vec3 {
    Vec3::new(a[0] as f32, a[1] as f32, a[2] as f32)
}

/// parry's pose of a frame given by its axes in the world and its origin.
pub(crate) fn pose(axes: &[[f64; 3]; 3], center: [f64; 3]) -> Pose {
    let columns = parry3d::math::Mat3::from_cols(vec3(axes[0]), vec3(axes[1]), vec3(axes[2]));
    Pose::from_parts(vec3(center), Rot3::from_mat3(&columns).normalize())
}

/// parry's pose of a cylinder whose axis is our local z: parry's runs along y.
pub(crate) fn cylinder_pose(axes: &[[f64; 3]; 3], center: [f64; 3]) -> Pose {
    pose(&[axes[0], axes[2], axes[1].map(|v| -v)], center)
}

fn axes_of_yaw(yaw: f64) -> [[f64; 3]; 3] {
    let (s, c) = yaw.sin_cos();
    [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]
}

fn axes_of_quat(q: [f64; 4]) -> [[f64; 3]; 3] {
    let norm = q.iter().map(|v| v * v).sum::<f64>().sqrt();
    let [w, x, y, z] = q.map(|v| v / norm);
    [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y + w * z),
            2.0 * (x * z - w * y),
        ],
        [
            2.0 * (x * y - w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z + w * x),
        ],
        [
            2.0 * (x * z + w * y),
            2.0 * (y * z - w * x),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ]
}

/// Renames the axes of a box so that local z is world z, if one of them is vertical.
fn stand_up(axes: &mut [[f64; 3]; 3], half: &mut [f64; 3]) -> bool {
    let Some(k) = (0..3).find(|&k| axes[k][0].hypot(axes[k][1]) < UPRIGHT) else {
        return false;
    };
    let x = (k + 1) % 3;
    let yaw = axes[x][1].atan2(axes[x][0]);
    // Cyclic renaming keeps the frame right-handed; an axis that points down flips the other one, and a box is
    // symmetric.
    *half = [half[x], half[(k + 2) % 3], half[k]];
    *axes = axes_of_yaw(yaw);
    true
}

impl Solid {
    /// The exact geometry of a shape that passed the scene's check.
    pub fn new(shape: &Shape) -> Self {
        let (form, center, axes, upright) = match shape {
            Shape::Box(s) => {
                let mut half = s.half_extents;
                let mut axes = s
                    .quat
                    .map_or_else(|| axes_of_yaw(s.yaw.unwrap_or(0.0)), axes_of_quat);
                let upright = s.quat.is_none() || stand_up(&mut axes, &mut half);
                (Form::Box(half), s.center, axes, upright)
            }
            Shape::Cylinder(s) => {
                let mut axes = s.quat.map_or_else(|| axes_of_yaw(0.0), axes_of_quat);
                let upright = axes[2][0].hypot(axes[2][1]) < UPRIGHT;
                if upright {
                    axes = axes_of_yaw(0.0);
                }
                (
                    Form::Cylinder(s.radius, s.half_height),
                    s.center,
                    axes,
                    upright,
                )
            }
            Shape::Mesh(s) => {
                let vertices = s.vertices.iter().map(|&v| vec3(v)).collect();
                // Only an empty mesh is refused, and the scene's check has refused it before.
                let tree = TriMesh::new(vertices, s.triangles.clone()).unwrap_or_else(|_| {
                    #[allow(clippy::unwrap_used)] // one triangle is never empty
                    TriMesh::new(vec![Vec3::ZERO; 3], vec![[0, 1, 2]]).unwrap()
                });
                let (vertices, triangles) = (s.vertices.clone(), s.triangles.clone());
                let form = Form::Mesh(Box::new(Mesh {
                    vertices,
                    triangles,
                    tree,
                }));
                (form, [0.0; 3], axes_of_yaw(0.0), false)
            }
        };
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for k in 0..3 {
            match &form {
                Form::Box(half) => {
                    let reach: f64 = (0..3).map(|j| half[j] * axes[j][k].abs()).sum();
                    (low[k], high[k]) = (center[k] - reach, center[k] + reach);
                }
                Form::Cylinder(radius, half_height) => {
                    let a = axes[2][k];
                    let reach = half_height * a.abs() + radius * (1.0 - a * a).max(0.0).sqrt();
                    (low[k], high[k]) = (center[k] - reach, center[k] + reach);
                }
                Form::Mesh(mesh) => {
                    for &i in mesh.triangles.iter().flatten() {
                        low[k] = low[k].min(mesh.vertices[i as usize][k]);
                        high[k] = high[k].max(mesh.vertices[i as usize][k]);
                    }
                }
            }
        }
        let (parry, at) = match &form {
            Form::Box(half) => (
                SharedShape::new(Cuboid::new(vec3(*half))),
                pose(&axes, center),
            ),
            Form::Cylinder(radius, half_height) => {
                let shape = Cylinder::new(*half_height as f32, *radius as f32);
                (SharedShape::new(shape), cylinder_pose(&axes, center))
            }
            Form::Mesh(mesh) => (SharedShape::new(mesh.tree.clone()), Pose::identity()),
        };
        Self {
            name: shape.name().to_owned(),
            form,
            center,
            axes,
            upright,
            low,
            high,
            parry,
            pose: at,
        }
    }

    /// parry's shape and its pose in the world.
    pub(crate) fn parry(&self) -> (&SharedShape, &Pose) {
        (&self.parry, &self.pose)
    }

    /// Whether an upright cube of the world meets the solid.
    pub fn meets_cube(&self, center: [f64; 3], half: f64) -> bool {
        let cube = parry3d::shape::Cuboid::new(vec3([half; 3]));
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let (shape, at) = self.parry();
        parry3d::query::intersection_test(&pose(&axes, center), &cube, at, shape.as_ref())
            .is_ok_and(|found| found.intersecting)
            || self.contains(center)
    }

    /// A world point in the solid's frame.
    pub fn to_local(&self, p: [f64; 3]) -> [f64; 3] {
        self.turn_to_local(sub(p, self.center))
    }

    /// A world direction in the solid's frame.
    pub fn turn_to_local(&self, d: [f64; 3]) -> [f64; 3] {
        [
            dot(self.axes[0], d),
            dot(self.axes[1], d),
            dot(self.axes[2], d),
        ]
    }

    /// Whether a world point lies in the solid; a mesh counts as solid inside its surface (by parity).
    pub fn contains(&self, p: [f64; 3]) -> bool {
        let l = self.to_local(p);
        match &self.form {
            Form::Box(half) => (0..3).all(|k| l[k].abs() <= half[k]),
            Form::Cylinder(radius, half_height) => {
                l[0].hypot(l[1]) <= *radius && l[2].abs() <= *half_height
            }
            Form::Mesh(mesh) => {
                // An odd direction, so that the ray meets no edge of a hand-made mesh.
                let d = [0.5377, 0.4421, 0.7180];
                let corners = |t: &[u32; 3]| t.map(|i| mesh.vertices[i as usize]);
                let met = mesh
                    .triangles
                    .iter()
                    .filter(|t| cast_triangle(p, d, corners(t)).is_some());
                let crossings = met.count();
                crossings % 2 == 1
            }
        }
    }

    /// Where a ray first meets the solid, in units of `direction`'s length; 0 when it starts inside a box or
    /// cylinder. `None` beyond `max`.
    pub fn cast(&self, origin: [f64; 3], direction: [f64; 3], max: f64) -> Option<f64> {
        let t = match &self.form {
            Form::Box(half) => {
                let (o, d) = (self.to_local(origin), self.turn_to_local(direction));
                let (near, far) = slabs(o, d, half);
                (near <= far).then_some(near)?
            }
            Form::Cylinder(radius, half_height) => {
                let (o, d) = (self.to_local(origin), self.turn_to_local(direction));
                let (mut near, mut far) = slab(o[2], d[2], *half_height);
                let a = d[0] * d[0] + d[1] * d[1];
                let c = o[0] * o[0] + o[1] * o[1] - radius * radius;
                if a > 0.0 {
                    let b = o[0] * d[0] + o[1] * d[1];
                    let disc = b * b - a * c;
                    if disc < 0.0 {
                        return None;
                    }
                    near = near.max((-b - disc.sqrt()) / a);
                    far = far.min((-b + disc.sqrt()) / a);
                } else if c > 0.0 {
                    return None;
                }
                near = near.max(0.0);
                (near <= far).then_some(near)?
            }
            Form::Mesh(mesh) => {
                let ray = Ray::new(vec3(origin), vec3(direction));
                f64::from(mesh.tree.cast_local_ray(&ray, max as f32, false)?)
            }
        };
        (t <= max).then_some(t)
    }
}

/// Interval of the ray parameter inside `|x| <= half` along one axis.
fn slab(o: f64, d: f64, half: f64) -> (f64, f64) {
    if d == 0.0 {
        return if o.abs() <= half {
            (f64::NEG_INFINITY, f64::INFINITY)
        } else {
            (f64::INFINITY, f64::NEG_INFINITY)
        };
    }
    let (a, b) = ((-half - o) / d, (half - o) / d);
    (a.min(b), a.max(b))
}

fn slabs(o: [f64; 3], d: [f64; 3], half: &[f64; 3]) -> (f64, f64) {
    let (mut near, mut far) = (0.0_f64, f64::INFINITY);
    for k in 0..3 {
        let (a, b) = slab(o[k], d[k], half[k]);
        near = near.max(a);
        far = far.min(b);
    }
    (near, far)
}

/// Moeller-Trumbore: where a ray meets a triangle, either side.
fn cast_triangle(o: [f64; 3], d: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> Option<f64> {
    let cross = |u: [f64; 3], v: [f64; 3]| {
        [
            u[1] * v[2] - u[2] * v[1],
            u[2] * v[0] - u[0] * v[2],
            u[0] * v[1] - u[1] * v[0],
        ]
    };
    let (e1, e2, s) = (sub(b, a), sub(c, a), sub(o, a));
    let p = cross(d, e2);
    let det = dot(e1, p);
    if det == 0.0 {
        return None;
    }
    let u = dot(s, p) / det;
    let q = cross(s, e1);
    let v = dot(d, q) / det;
    let t = dot(e2, q) / det;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0).then_some(t)
}
