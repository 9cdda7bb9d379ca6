//! Random scenes and a second reading of their geometry through parry alone.
#![allow(dead_code, missing_docs, clippy::unwrap_used)]

use parry3d::math::{Pose, Rot3, Vec3};
use parry3d::query::{self, Ray};
use parry3d::shape::{Cuboid, Cylinder, SharedShape, TriMesh};
use proptest::prelude::*;
use seekplan::scene::{
    Bounds, BoxShape, CylinderShape, Limits, MeshShape, Scene, Shape, Start, Tag, Units,
};

pub(crate) const LOW: [f64; 3] = [-6.0, -6.0, 0.0];
pub(crate) const HIGH: [f64; 3] = [6.0, 6.0, 3.0];

/// A scene of the given shapes, with the start in its middle.
pub(crate) fn scene(shapes: Vec<Shape>, tags: Vec<Tag>) -> Scene {
    Scene {
        schema: "search-scene/1".into(),
        name: "test".into(),
        description: String::new(),
        license: "CC0-1.0".into(),
        origin: serde_json::Value::Null,
        units: Units {
            length: "m".into(),
            angle: "rad".into(),
        },
        frame: String::new(),
        bounds: Bounds {
            min: LOW,
            max: HIGH,
        },
        floor_z: 0.0,
        ceiling_z: None,
        start: Start {
            x: 0.0,
            y: 0.0,
            yaw: 0.0,
        },
        limits: Limits::default(),
        tags,
        rooms: vec![],
        closed_areas: vec![],
        target_volumes: vec![],
        shapes,
    }
}

pub(crate) fn block(name: &str, center: [f64; 3], half_extents: [f64; 3], yaw: f64) -> Shape {
    Shape::Box(BoxShape {
        name: name.into(),
        center,
        half_extents,
        yaw: Some(yaw),
        quat: None,
    })
}

fn center() -> impl Strategy<Value = [f64; 3]> {
    [-6.0..6.0, -6.0..6.0, 0.0..2.5]
}

fn quat() -> impl Strategy<Value = [f64; 4]> {
    [-1.0..1.0, -1.0..1.0, -1.0..1.0, -1.0..1.0].prop_filter_map(
        "zero quaternion",
        |q: [f64; 4]| {
            let norm = q.iter().map(|v| v * v).sum::<f64>().sqrt();
            (norm > 0.1).then(|| q.map(|v| v / norm))
        },
    )
}

/// Turned quaternions, half of them quarter turns, which leave a box upright with renamed axes.
fn turn() -> impl Strategy<Value = [f64; 4]> {
    let quarter = (0..3_usize, 0..4_i32).prop_map(|(axis, n)| {
        let (s, c) = (f64::from(n) * std::f64::consts::FRAC_PI_4).sin_cos();
        let mut q = [c, 0.0, 0.0, 0.0];
        q[axis + 1] = s;
        q
    });
    prop_oneof![quat(), quarter]
}

/// Any shape: upright and tilted boxes and cylinders, tetrahedra.
pub(crate) fn shape() -> impl Strategy<Value = Shape> {
    let half = || [0.02..0.8, 0.02..0.8, 0.02..1.0];
    let upright = (center(), half(), -4.0..4.0).prop_map(|(c, h, yaw)| block("box.u", c, h, yaw));
    let straight = (center(), half()).prop_map(|(c, h)| block("box.s", c, h, 0.0));
    let turned = (center(), half(), turn()).prop_map(|(center, half_extents, q)| {
        Shape::Box(BoxShape {
            name: "box.q".into(),
            center,
            half_extents,
            yaw: None,
            quat: Some(q),
        })
    });
    let cylinder = (center(), 0.02..0.6, 0.02..1.0, proptest::option::of(turn())).prop_map(
        |(center, radius, half_height, quat)| {
            Shape::Cylinder(CylinderShape {
                name: "can.c".into(),
                center,
                radius,
                half_height,
                quat,
            })
        },
    );
    let mesh = (center(), [-0.8..0.8, -0.8..0.8, 0.2..0.8_f64]).prop_map(
        |(c, d): ([f64; 3], [f64; 3])| {
            let at = |x: f64, y: f64, z: f64| [c[0] + x, c[1] + y, c[2] + z];
            Shape::Mesh(MeshShape {
                name: "tent.m".into(),
                vertices: vec![
                    at(0.5, 0.0, 0.0),
                    at(-0.4, 0.5, 0.0),
                    at(-0.4, -0.5, 0.0),
                    at(d[0], d[1], d[2]),
                ],
                triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
            })
        },
    );
    prop_oneof![3 => upright, 2 => straight, 2 => turned, 3 => cylinder, 1 => mesh]
}

pub(crate) fn v(p: [f64; 3]) -> Vec3 {
    Vec3::new(p[0] as f32, p[1] as f32, p[2] as f32)
}

fn rotation(q: [f64; 4]) -> Rot3 {
    Rot3::from_xyzw(q[1] as f32, q[2] as f32, q[3] as f32, q[0] as f32).normalize()
}

/// A shape as parry sees it, read straight from the file's fields.
pub(crate) fn parry(shape: &Shape) -> (SharedShape, Pose) {
    match shape {
        Shape::Box(s) => {
            let turned = match (s.quat, s.yaw) {
                (Some(q), _) => rotation(q),
                (None, yaw) => Rot3::from_rotation_z(yaw.unwrap_or(0.0) as f32),
            };
            (
                SharedShape::new(Cuboid::new(v(s.half_extents))),
                Pose::from_parts(v(s.center), turned),
            )
        }
        Shape::Cylinder(s) => {
            // parry's cylinders run along y.
            let up = Rot3::from_rotation_x(std::f32::consts::FRAC_PI_2);
            let turned = s.quat.map_or(Rot3::IDENTITY, rotation) * up;
            let shape = Cylinder::new(s.half_height as f32, s.radius as f32);
            (
                SharedShape::new(shape),
                Pose::from_parts(v(s.center), turned),
            )
        }
        Shape::Mesh(s) => {
            let vertices = s.vertices.iter().map(|&p| v(p)).collect();
            (
                SharedShape::new(TriMesh::new(vertices, s.triangles.clone()).unwrap()),
                Pose::identity(),
            )
        }
    }
}

/// parry's own answer for one ray against every shape and the floor, without any tree.
pub(crate) fn cast_by_parry(
    all: &[(SharedShape, Pose)],
    floor: f64,
    origin: [f64; 3],
    direction: [f64; 3],
    max: f64,
) -> f64 {
    let ray = Ray::new(v(origin), v(direction));
    let mut best = f64::INFINITY;
    if direction[2] < 0.0 {
        best = (floor - origin[2]) / direction[2];
    }
    for (shape, pose) in all {
        if let Some(t) = shape.cast_ray(pose, &ray, max as f32, true) {
            best = best.min(f64::from(t));
        }
    }
    if best <= max { best } else { f64::INFINITY }
}

/// Smallest distance between a convex parry shape and every shape, without any tree. Alternating projections between
/// two convex sets converge to their nearest points; GJK in f32 would stop millimetres early on round shapes.
pub(crate) fn distance_by_parry(
    all: &[(SharedShape, Pose)],
    shape: &dyn parry3d::shape::Shape,
    pose: &Pose,
) -> f64 {
    let project = |other: &dyn parry3d::shape::Shape, at: &Pose| {
        let mut p = at.translation;
        let mut last = f32::INFINITY;
        for _ in 0..3000 {
            let a = shape.project_point(pose, p, true).point;
            p = other.project_point(at, a, true).point;
            last = (p - a).length();
            if last == 0.0 {
                break;
            }
        }
        f64::from(last)
    };
    let each = all.iter().map(|(other, at)| match other.as_trimesh() {
        Some(mesh) => mesh
            .triangles()
            .map(|t| project(&t, at))
            .fold(f64::INFINITY, f64::min),
        None => project(other.as_ref(), at),
    });
    each.fold(f64::INFINITY, f64::min)
}

/// Whether a cube meets any shape.
pub(crate) fn meets_by_parry(all: &[(SharedShape, Pose)], center: [f64; 3], half: f64) -> bool {
    let (cube, pose) = (Cuboid::new(v([half; 3])), Pose::from_translation(v(center)));
    let meets = |(s, p): &(SharedShape, Pose)| {
        query::intersection_test(&pose, &cube, p, s.as_ref())
            .unwrap()
            .intersecting
    };
    all.iter().any(meets)
}

/// Whether `value` is explained by `exact` at this ray or at one of its neighbours: a ray that grazes an edge may
/// go either way.
pub(crate) fn near_edge(
    value: f64,
    tolerance: f64,
    exact: impl Fn(f64, f64) -> f64,
    spread: f64,
) -> bool {
    let mut least = f64::INFINITY;
    let mut most = f64::NEG_INFINITY;
    for (a, b) in [(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
        let t = exact(a * spread, b * spread);
        if t == value || (t - value).abs() <= tolerance {
            return true;
        }
        least = least.min(t);
        most = most.max(t);
    }
    // Across an edge what lies behind it may slope away by a little more.
    let slack = if most - least > 10.0 * tolerance {
        0.02 * value
    } else {
        0.0
    };
    value >= least - slack && value <= most + slack
}
