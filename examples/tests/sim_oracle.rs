//! Fast sensors and distances against parry's own answers over every shape, one by one.
#![allow(missing_docs, clippy::unwrap_used)]

mod scene_support;

use parry3d::math::{Mat3, Pose, Rot3};
use parry3d::shape::{Capsule, Cuboid, Cylinder};
use proptest::prelude::*;
use scene_support::{
    cast_by_parry, distance_by_parry, meets_by_parry, near_edge, parry, scene, shape, v,
};
use seekplan::scene::{Scene, Shape};
use seekplan::sim::{
    DepthCamera, DepthModel, GroundTruth, Lidar, LidarModel, Noise, PartShape, World,
};

/// parry works in f32: at 12 m a coordinate has steps of 1e-6 m, a grazing angle magnifies them.
const TOLERANCE: f64 = 2e-3;
/// parry casts rays on cylinders by GJK, which stops some millimetres early.
const ROUND: f64 = 5e-3;
/// Neighbouring rays tried for rays that graze an edge, rad; parry finds round shapes by GJK, up to a millimetre off.
const SPREAD: f64 = 1e-3;

fn direction(azimuth: f64, elevation: f64) -> [f64; 3] {
    let ((sa, ca), (se, ce)) = (azimuth.sin_cos(), elevation.sin_cos());
    [ce * ca, ce * sa, se]
}

/// Rotation rows of a camera looking along `yaw`, `pitch` up, rolled.
fn look(yaw: f64, pitch: f64, roll: f64) -> [[f64; 3]; 3] {
    let (ahead, right) = (direction(yaw, pitch), [yaw.sin(), -yaw.cos(), 0.0]);
    let down = [
        ahead[1] * right[2] - ahead[2] * right[1],
        ahead[2] * right[0] - ahead[0] * right[2],
        ahead[0] * right[1] - ahead[1] * right[0],
    ];
    let (s, c) = roll.sin_cos();
    [0, 1, 2].map(|k| {
        [
            c * right[k] + s * down[k],
            c * down[k] - s * right[k],
            ahead[k],
        ]
    })
}

fn check_rays(scene: &Scene, origin: [f64; 3], angles: &[(f64, f64)], max: f64) {
    let world = World::new(scene);
    let all: Vec<_> = scene.shapes.iter().map(parry).collect();
    for &(a, e) in angles {
        let t = world
            .cast(origin, direction(a, e), max)
            .unwrap_or(f64::INFINITY);
        let exact = |da, de| cast_by_parry(&all, 0.0, origin, direction(a + da, e + de), max);
        assert!(
            near_edge(t, ROUND, exact, SPREAD),
            "from {origin:?} along ({a}, {e}): {t}, parry {}",
            exact(0.0, 0.0)
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// One ray through the tree meets what parry meets over all shapes. Cylinders are left out: parry's GJK now and
    /// then finds one that a ray passes by a millimetre; the next law holds for them.
    #[test]
    fn casts_agree_with_parry(
        shapes in prop::collection::vec(shape(), 1..40),
        origin in [-6.0..6.0, -6.0..6.0, 0.1..2.5],
        angles in prop::collection::vec((-3.2..3.2, -1.5..1.5), 50),
    ) {
        let shapes = shapes.into_iter().filter(|s| !matches!(s, Shape::Cylinder(_)));
        check_rays(&scene(shapes.collect(), vec![]), origin, &angles, 10.0);
    }

    /// A ray ends on a surface, to a micrometre, and nowhere before does it pass through a solid.
    #[test]
    fn casts_end_at_the_first_surface(
        shapes in prop::collection::vec(shape(), 1..40),
        origin in [-6.0..6.0, -6.0..6.0, 0.1..2.5],
        angles in prop::collection::vec((-3.2..3.2, -1.5..1.5), 20),
    ) {
        let scene = scene(shapes, vec![]);
        let world = World::new(&scene);
        let (origin, max): ([f64; 3], f64) = (origin, 8.0);
        let inside = |p: [f64; 3]| p[2] < 0.0 || world.solids().iter().any(|s| s.contains(p));
        for (a, e) in angles {
            let d = direction(a, e);
            let at = |t: f64| [0, 1, 2].map(|k| origin[k] + t * d[k]);
            let hit = world.cast(origin, d, max);
            if inside(origin) {
                // A ray from within a mesh ends at its skin.
                continue;
            }
            let end = hit.unwrap_or(max);
            for i in 1..400 {
                let t = end * f64::from(i) / 400.0;
                prop_assert!(t > end - 1e-4 || !inside(at(t)), "inside at {t} before {end}");
            }
            if hit.is_some() {
                // Grazing hits may leave at once; a sphere of a micrometre around the hit must touch.
                let ball = PartShape::Capsule { a: at(end), b: at(end), radius: 0.0 };
                prop_assert!(world.distance(&ball, 1.0) < 2e-5, "{} off", world.distance(&ball, 1.0));
            }
        }
    }

    /// Every ray of a LiDAR scan is the ray cast alone.
    #[test]
    fn lidar_agrees_with_single_rays(
        shapes in prop::collection::vec(shape(), 1..40),
        base in [-4.0..4.0, -4.0..4.0, -4.0..4.0],
    ) {
        let scene = scene(shapes, vec![]);
        let world = World::new(&scene);
        let model = LidarModel { step: 0.06, ..LidarModel::default() };
        let mut lidar = Lidar::new(model, Noise::default());
        lidar.scan(&world, base);
        let origin = lidar.origin(base, 0.0);
        let (columns, rows) = lidar.size();
        for column in 0..columns {
            for row in 0..rows {
                let (a, e) = (lidar.azimuth(column, base[2]), lidar.elevation(row));
                let t = f64::from(lidar.reach(column, row)) / e.cos();
                let exact = |da, de| world.cast(origin, direction(a + da, e + de), 10.0).unwrap_or(10.0);
                prop_assert!(near_edge(t, 1e-4, exact, 1e-5), "column {column} row {row}: {t}, alone {}", exact(0.0, 0.0));
            }
        }
    }

    /// Every pixel of a depth image is the ray cast alone.
    #[test]
    fn depth_agrees_with_single_rays(
        shapes in prop::collection::vec(shape(), 1..40),
        origin in [-4.0..4.0, -4.0..4.0, 0.1..2.5],
        (yaw, pitch, roll) in (-3.2..3.2, -1.5..1.5, -3.2..3.2),
    ) {
        let scene = scene(shapes, vec![]);
        let world = World::new(&scene);
        // A camera within rounding of a face sees it or not.
        prop_assume!(world.distance(&PartShape::Capsule { a: origin, b: origin, radius: 0.0 }, 1.0) > 1e-4);
        let mut camera = DepthCamera::new(DepthModel { size: [31, 22], ..DepthModel::default() }, Noise::default());
        let rotation = look(yaw, pitch, roll);
        camera.scan(&world, &(rotation, origin));
        for row in 0..22 {
            for column in 0..31 {
                let (x, y) = (camera.pinhole().coordinate(0, column), camera.pinhole().coordinate(1, row));
                let length = (1.0 + x * x + y * y).sqrt();
                let exact = |dx: f64, dy: f64| {
                    let d = [0, 1, 2].map(|k| rotation[k][0] * (x + dx) + rotation[k][1] * (y + dy) + rotation[k][2]);
                    length * world.cast(origin, d, 4.0 / length).unwrap_or(4.0 / length)
                };
                let t = length * f64::from(camera.depth()[row * 31 + column]);
                prop_assert!(near_edge(t, 1e-4, exact, 1e-5), "pixel {column} {row}: {t}, alone {}", exact(0.0, 0.0));
            }
        }
    }

    /// The distance of a robot part to the world is the smallest over all shapes, floor included.
    #[test]
    fn distances_agree_with_parry(
        shapes in prop::collection::vec(shape(), 1..30),
        center in [-5.0..5.0, -5.0..5.0, 0.3..2.0],
        (yaw, pitch, roll) in (-3.2..3.2, -1.5..1.5, -3.2..3.2),
        size in [0.02..0.4, 0.02..0.4, 0.02..0.4],
        kind in 0..3,
        up_to in prop_oneof![Just(0.05), Just(0.5), Just(f64::INFINITY)],
    ) {
        let scene = scene(shapes, vec![]);
        let world = World::new(&scene);
        let all: Vec<_> = scene.shapes.iter().map(parry).collect();
        let (center, size): ([f64; 3], [f64; 3]) = (center, size);
        let r = look(yaw, pitch, roll);
        let turned = Rot3::from_mat3(&Mat3::from_cols(
            v([r[0][0], r[1][0], r[2][0]]), v([r[0][1], r[1][1], r[2][1]]), v([r[0][2], r[1][2], r[2][2]])));
        let at = Pose::from_parts(v(center), turned);
        let axis = |k: usize, s: f64| [0, 1, 2].map(|i| center[i] + s * r[i][k]);
        let (part, expected, lowest) = match kind {
            0 => {
                let (a, b) = (axis(2, -size[2]), axis(2, size[2]));
                let capsule = Capsule::new(v(a), v(b), size[0] as f32);
                (PartShape::Capsule { a, b, radius: size[0] },
                 distance_by_parry(&all, &capsule, &Pose::identity()), a[2].min(b[2]) - size[0])
            }
            1 => {
                let reach: f64 = (0..3).map(|j| r[2][j].abs() * size[j]).sum();
                (PartShape::Box { center, rotation: r, half: size },
                 distance_by_parry(&all, &Cuboid::new(v(size)), &at), center[2] - reach)
            }
            _ => {
                let up = Rot3::from_rotation_x(std::f32::consts::FRAC_PI_2);
                let at = Pose::from_parts(v(center), turned * up);
                let side = (1.0 - r[2][2] * r[2][2]).max(0.0).sqrt();
                (PartShape::Cylinder { center, rotation: r, radius: size[0], half_height: size[2] },
                 distance_by_parry(&all, &Cylinder::new(size[2] as f32, size[0] as f32), &at),
                 center[2] - r[2][2].abs() * size[2] - side * size[0])
            }
        };
        let expected = expected.min(lowest).min(up_to).max(0.0);
        let distance = world.distance(&part, up_to).max(0.0);
        prop_assert!((distance - expected).abs() < TOLERANCE, "{distance}, parry {expected}");
    }

    /// A voxel is solid exactly when parry finds a shape in its core, and reachable by the definition.
    #[test]
    fn ground_truth_follows_its_definition(shapes in prop::collection::vec(shape(), 0..25)) {
        let mut scene = scene(shapes, vec![]);
        (scene.bounds.min, scene.bounds.max) = ([-3.0, -3.0, 0.0], [3.0, 3.0, 2.1]);
        let world = World::new(&scene);
        let truth = GroundTruth::new(&scene, &world, 0.3).unwrap();
        prop_assert_eq!(truth.size(), [20, 20, 7]);
        let all: Vec<_> = scene.shapes.iter().map(parry).collect();
        let cells = |f: &mut dyn FnMut([i32; 3])| {
            for x in 0..20 { for y in 0..20 { for z in 0..7 { f([x, y, z]); } } }
        };
        let mut count = 0;
        cells(&mut |c| {
            let low = [-3.0, -3.0, 0.0];
            let center = [0, 1, 2].map(|k| low[k] + 0.3 * (f64::from(c[k]) + 0.5));
            let meets = |half: f64| meets_by_parry(&all, center, half);
            // Surely filled if even a smaller core is met, surely not if a larger one is free.
            let core = 0.15 - GroundTruth::DEPTH;
            if meets(core - TOLERANCE) { assert!(truth.is_solid(c), "{c:?}"); }
            if !meets(core + TOLERANCE) { assert!(!truth.is_solid(c), "{c:?}"); }
            let beside = |test: &dyn Fn([i32; 3]) -> bool| {
                (0..3).any(|k| [-1, 1].iter().any(|d| { let mut n = c; n[k] += d; test(n) }))
            };
            assert!(!(truth.is_solid(c) && truth.is_reachable(c)));
            if !truth.is_solid(c) && beside(&|n| truth.is_reachable(n)) { assert!(truth.is_reachable(c)); }
            assert_eq!(truth.is_surface(c), truth.is_solid(c) && beside(&|n| truth.is_reachable(n)));
            count += usize::from(truth.is_surface(c));
        });
        prop_assert_eq!(count, truth.surface().count());
    }
}

#[test]
fn embedded_scenes_agree_with_parry() {
    for name in seekplan::scene::BUILTIN {
        let scene = Scene::builtin(name).unwrap();
        let origin = [scene.start.x, scene.start.y, 0.9];
        let angles: Vec<_> = (0..1000)
            .map(|i| (0.006_283 * f64::from(i), -0.5 + 0.001 * f64::from(i)))
            .collect();
        check_rays(&scene, origin, &angles, 40.0);
    }
}

#[test]
fn many_casts_equal_single_casts() {
    let scene = Scene::builtin("office").unwrap();
    let world = World::new(&scene);
    let directions: Vec<_> = (0..3000)
        .map(|i| direction(0.01 * f64::from(i), -0.3 + 0.0003 * f64::from(i)))
        .collect();
    let origin = [3.0, 10.0, 0.8];
    let mut out = Vec::new();
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| world.cast_many(origin, &directions, 10.0, &mut out));
        for (d, &t) in directions.iter().zip(&out) {
            assert_eq!(t, world.cast(origin, *d, 10.0).unwrap_or(f64::INFINITY));
        }
    }
}
