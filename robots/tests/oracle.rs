//! The fast code against independent solvers: nalgebra products, parry3d shapes, central differences.
#![allow(clippy::unwrap_used)]

mod common;

use common::Random;
use nalgebra::{Isometry3, Matrix4, Vector3};
use parry3d::math::{Pose, Rotation, Vector};
use parry3d::query::PointQuery;
use parry3d::shape;
use robots::{
    BodyState, Capsule, Cuboid, Frame, LINK_PAIRS, MobileManipulator, Sphere, Ur5e, by_inputs,
};
use std::f64::consts::PI;

fn dh(d: f64, a: f64, alpha: f64, q: f64) -> Matrix4<f64> {
    let rot_z = Matrix4::from_axis_angle(&Vector3::z_axis(), q);
    let rot_x = Matrix4::from_axis_angle(&Vector3::x_axis(), alpha);
    rot_z * Matrix4::new_translation(&Vector3::new(a, 0.0, d)) * rot_x
}

#[test]
fn fk_is_the_product_of_dh_matrices() {
    let (arm, mut random) = (Ur5e::default(), Random(3));
    for _ in 0..2000 {
        let q = [0; 6].map(|_| random.within(-7.0, 7.0));
        let frames = arm.frames(&q);
        let mut t = Matrix4::identity();
        for (i, [d, a, alpha]) in arm.dh().iter().enumerate() {
            t *= dh(*d, *a, *alpha, q[i]);
            assert!((frames[i + 1].to_homogeneous() - t).amax() < 2e-15 * 10.0);
        }
        assert!((arm.fk(&q).to_homogeneous() - t).amax() < 2e-14);
    }
}

#[test]
fn camera_pose_is_the_product_of_isometries() {
    let (robot, mut random) = (MobileManipulator::default(), Random(4));
    for _ in 0..500 {
        let state = random_state(&mut random);
        let [x, y, yaw] = state.base;
        let base = Isometry3::new(Vector3::new(x, y, 0.0), Vector3::z() * yaw);
        let expected =
            base * robot.mount * robot.arm.fk(&state.joints) * robot.camera.flange_from_camera;
        let got = robot.camera_pose(&state);
        assert!((got.to_homogeneous() - expected.to_homogeneous()).amax() < 1e-13);
        // Lens 0.05 m ahead of the flange, looking along its z axis.
        let flange = robot.arm_frames(&state)[6];
        let lens = flange.apply([0.0, 0.0, 0.05]);
        assert!((Vector3::from(lens) - got.translation.vector).norm() < 1e-14);
    }
}

fn random_state(random: &mut Random) -> BodyState {
    let base = [
        random.within(-10.0, 10.0),
        random.within(-10.0, 10.0),
        random.within(-PI, PI),
    ];
    BodyState {
        base,
        joints: random.joints(),
    }
}

#[test]
fn manipulability_is_the_determinant() {
    let (arm, mut random) = (Ur5e::default(), Random(5));
    for _ in 0..2000 {
        let q = random.joints();
        assert!((arm.manipulability(&q) - arm.jacobian(&q).determinant().abs()).abs() < 1e-12);
    }
}

#[test]
fn arm_jacobian_agrees_with_central_differences() {
    let (arm, mut random) = (Ur5e::default(), Random(6));
    let h = 1e-5;
    for _ in 0..500 {
        let q = random.joints();
        let j = arm.jacobian(&q);
        for k in 0..6 {
            let (mut up, mut down) = (q, q);
            up[k] += h;
            down[k] -= h;
            let (a, b) = (arm.fk(&up), arm.fk(&down));
            let v = (a.translation.vector - b.translation.vector) / (2.0 * h);
            let w = (a.rotation * b.rotation.inverse()).scaled_axis() / (2.0 * h);
            for i in 0..3 {
                assert!((j[(i, k)] - v[i]).abs() < 1e-7);
                assert!((j[(3 + i, k)] - w[i]).abs() < 1e-7);
            }
        }
    }
}

fn moved(state: &BodyState, k: usize, h: f64) -> BodyState {
    let mut s = *state;
    if k < 3 {
        s.base[k] += h
    } else {
        s.joints[k - 3] += h
    }
    s
}

#[test]
fn body_jacobians_agree_with_central_differences() {
    let (robot, mut random) = (MobileManipulator::default(), Random(7));
    let h = 1e-5;
    for _ in 0..200 {
        let state = random_state(&mut random);
        let (spheres, jacobians) = robot.sphere_jacobians(&state);
        assert_eq!(spheres, robot.arm_spheres(&state));
        let (camera, linear, angular) = robot.camera_jacobian(&state);
        assert!(camera.error_to(&robot.camera_frame(&state)).0 < 1e-12);
        for k in 0..9 {
            let (up, down) = (moved(&state, k, h), moved(&state, k, -h));
            let (a, b) = (robot.arm_spheres(&up), robot.arm_spheres(&down));
            for (s, j) in jacobians.iter().enumerate() {
                for i in 0..3 {
                    let slope = (a[s].center[i] - b[s].center[i]) / (2.0 * h);
                    assert!(
                        (j[i][k] - slope).abs() < 1e-7,
                        "sphere {s} axis {i} state {k}"
                    );
                }
            }
            let (a, b) = (robot.camera_pose(&up), robot.camera_pose(&down));
            let w = (a.rotation * b.rotation.inverse()).scaled_axis() / (2.0 * h);
            for i in 0..3 {
                let slope = (a.translation.vector[i] - b.translation.vector[i]) / (2.0 * h);
                assert!((linear[i][k] - slope).abs() < 1e-7);
                assert!((angular[i][k] - w[i]).abs() < 1e-7);
            }
        }
        // By inputs: driving forward for a moment moves every sphere along the heading.
        let inputs = by_inputs(&jacobians[10], state.base[2]);
        assert!(
            (inputs[0][0] - state.base[2].cos()).abs() < 1e-12
                && (inputs[1][0] - state.base[2].sin()).abs() < 1e-12
        );
        assert_eq!(inputs[2][1], 0.0);
    }
}

// parry works in single precision; this is its distance error at the robot's size.
const SINGLE: f64 = 2e-6;

fn vector(p: [f64; 3]) -> Vector {
    Vector::new(p[0] as f32, p[1] as f32, p[2] as f32)
}

fn inside_cover(point: [f64; 3], spheres: &[Sphere]) -> bool {
    spheres.iter().any(|s| {
        let square: f64 = (0..3).map(|i| (point[i] - s.center[i]).powi(2)).sum();
        square.sqrt() <= s.radius + SINGLE
    })
}

/// The point of a parry shape's surface nearest to a random point around it.
fn surface_point(
    shape: &dyn PointQuery,
    pose: &Pose,
    around: [f64; 3],
    spread: f64,
    random: &mut Random,
) -> [f64; 3] {
    let p = around.map(|v| v + random.within(-spread, spread));
    let hit = shape.project_point(pose, vector(p), false);
    [
        f64::from(hit.point.x),
        f64::from(hit.point.y),
        f64::from(hit.point.z),
    ]
}

fn parry_box(b: &Cuboid) -> (shape::Cuboid, Pose) {
    let f = Isometry3::from(&b.frame);
    let q = f.rotation.quaternion().coords;
    let rotation = Rotation::from_xyzw(q[0] as f32, q[1] as f32, q[2] as f32, q[3] as f32);
    (
        shape::Cuboid::new(vector(b.half)),
        Pose::from_parts(vector(b.frame.p), rotation),
    )
}

#[test]
fn spheres_contain_the_solids() {
    let (robot, mut random) = (MobileManipulator::default(), Random(8));
    let mut checked = 0;
    for _ in 0..40 {
        let mut state = random_state(&mut random);
        state.base[0] *= 0.05;
        state.base[1] *= 0.05;
        let set = robot.spheres(&state);
        for c in robot.link_capsules(&state) {
            let solid = shape::Capsule::new(vector(c.a), vector(c.b), c.radius as f32);
            let own: Vec<Sphere> = set
                .arm()
                .iter()
                .filter(|s| s.link == c.link)
                .copied()
                .collect();
            for _ in 0..150 {
                let t = random.unit();
                let middle = [0, 1, 2].map(|i| c.a[i] + t * (c.b[i] - c.a[i]));
                let p = surface_point(&solid, &Pose::IDENTITY, middle, 0.2, &mut random);
                assert!(inside_cover(p, &own), "link {}: {p:?}", c.link);
                assert!(c.distance(p).abs() < SINGLE);
                checked += 1;
            }
        }
        let boxes = [
            (robot.camera_box(&state), 0.1, set.arm()),
            (robot.base_box(state.base), 0.8, set.base()),
        ];
        for (b, spread, spheres) in boxes {
            let (solid, pose) = parry_box(&b);
            for _ in 0..300 {
                let p = surface_point(&solid, &pose, b.frame.p, spread, &mut random);
                assert!(inside_cover(p, spheres), "box: {p:?}");
                assert!(b.distance(p).abs() < SINGLE);
                checked += 1;
            }
        }
        let post = robot.base.pedestal_capsule(&Frame::planar(state.base));
        let solid = shape::Capsule::new(vector(post.a), vector(post.b), post.radius as f32);
        for _ in 0..100 {
            let p = surface_point(&solid, &Pose::IDENTITY, post.b, 0.2, &mut random);
            assert!(inside_cover(p, set.base()) || robot.base_box(state.base).distance(p) < SINGLE);
        }
    }
    assert!(checked > 60_000);
}

#[test]
fn circles_contain_the_rectangle() {
    let robot = MobileManipulator::default();
    let mut random = Random(9);
    for _ in 0..5000 {
        let p = [random.within(-0.375, 0.375), random.within(-0.275, 0.275)];
        assert!(
            robot
                .base_circles()
                .iter()
                .any(|(c, r)| (p[0] - c[0]).hypot(p[1] - c[1]) <= r + 1e-12)
        );
    }
    for c in robot.base.outline {
        assert!(
            robot
                .base_circles()
                .iter()
                .any(|(m, r)| (c[0] - m[0]).hypot(c[1] - m[1]) <= r + 1e-12)
        );
    }
}

#[test]
fn base_distance_agrees_with_parry() {
    let (robot, mut random) = (MobileManipulator::default(), Random(10));
    let (solid, pose) = parry_box(&robot.base_box([0.0; 3]));
    let post = shape::Cylinder::new(0.25, 0.09);
    // parry's cylinder stands along y; ours along z from the floor to the mounting face.
    let upright = Rotation::from_xyzw((PI as f32 / 4.0).sin(), 0.0, 0.0, (PI as f32 / 4.0).cos());
    let post_pose = Pose::from_parts(Vector::new(0.10, 0.0, 0.25), upright);
    for _ in 0..5000 {
        let p = [
            random.within(-1.0, 1.0),
            random.within(-1.0, 1.0),
            random.within(0.01, 1.2),
        ];
        let ball = ((p[0] - 0.25).powi(2) + p[1].powi(2) + (p[2] - 0.45).powi(2)).sqrt() - 0.05;
        let a = f64::from(solid.distance_to_point(&pose, vector(p), false));
        let b = f64::from(post.distance_to_point(&post_pose, vector(p), false));
        let expected = a.min(b).min(ball);
        let got = robot.base.distance(p);
        if expected > 0.0 {
            assert!((got - expected).abs() < 1e-5, "{p:?}: {got} {expected}");
        } else {
            assert!(got <= 1e-5);
        }
    }
}

/// Exact least distance of the robot's solids by parry: over all pairs of links that are not neighbours, or only
/// over those that the sphere model tests.
fn exact_self_distance(robot: &MobileManipulator, joints: &[f64; 6], all: bool) -> f64 {
    let tested = |a: u8, b: u8| all || LINK_PAIRS.contains(&(a, b));
    let state = BodyState {
        base: [0.0; 3],
        joints: *joints,
    };
    let capsules = robot.link_capsules(&state);
    let (camera, camera_pose) = parry_box(&robot.camera_box(&state));
    let (base, base_pose) = parry_box(&robot.base_box([0.0; 3]));
    let solid = |c: &Capsule| shape::Capsule::new(vector(c.a), vector(c.b), c.radius as f32);
    let gap = |p: &Pose, a: &dyn shape::Shape, q: &Pose, b: &dyn shape::Shape| {
        f64::from(parry3d::query::distance(p, a, q, b).unwrap().distance)
    };
    let mut least = gap(&base_pose, &base, &camera_pose, &camera);
    for a in &capsules {
        for b in &capsules {
            if b.link > a.link + 1 && tested(a.link, b.link) {
                least = least.min(gap(&Pose::IDENTITY, &solid(a), &Pose::IDENTITY, &solid(b)));
            }
        }
        if a.link < 6 && tested(a.link, 7) {
            least = least.min(gap(&Pose::IDENTITY, &solid(a), &camera_pose, &camera));
        }
        if a.link > 1 {
            least = least.min(gap(&Pose::IDENTITY, &solid(a), &base_pose, &base));
        }
    }
    least
}

/// The sphere model with its pruned pairs never overlooks a touch of the solids, over all pairs of links.
#[test]
fn self_clearance_is_conservative() {
    let (robot, mut random) = (MobileManipulator::default(), Random(11));
    let (mut touching, mut free, mut refused) = (0, 0, 0);
    for _ in 0..3000 {
        let q = random.joints();
        let clearance = robot.self_clearance(&q);
        let exact = exact_self_distance(&robot, &q, false);
        // Pairs left out never touch.
        assert_eq!(
            exact > 0.0,
            exact_self_distance(&robot, &q, true) > 0.0,
            "{q:?}"
        );
        assert!(clearance <= exact + 1e-5, "{q:?}: {clearance} > {exact}");
        assert_eq!(clearance >= 0.01, robot.self_is_free(&q, 0.01));
        if exact <= 0.0 {
            touching += 1;
        } else if clearance > 0.0 {
            free += 1;
        } else {
            refused += 1;
        }
    }
    println!("{touching} touching, {free} free, {refused} refused though free");
    assert!(touching > 100 && free > 500 && refused < 300);
}
