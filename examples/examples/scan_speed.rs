//! Prints what a LiDAR scan, a depth image and a clearance query cost in the office.
#![allow(
    missing_docs,
    clippy::print_stdout,
    clippy::disallowed_methods,
    clippy::unwrap_used
)]
use seekplan::scene::Scene;
use seekplan::sim::*;
use std::time::Instant;

fn main() {
    for name in ["office", "maze", "lab"] {
        let scene = Scene::builtin(name).unwrap();
        let world = World::new(&scene);
        let mut lidar = Lidar::new(LidarModel::default(), Noise::default());
        let mut depth = DepthCamera::new(DepthModel::default(), Noise::default());
        let (low, high) = (scene.bounds.min, scene.bounds.max);
        let poses: Vec<[f64; 3]> = (0..40)
            .map(|i| {
                let s = (i as f64 + 0.5) / 40.0;
                let y = if name == "office" {
                    10.0
                } else {
                    0.5 * (low[1] + high[1])
                };
                [
                    low[0] + 0.5 + s * (high[0] - low[0] - 1.0),
                    y,
                    0.1 * i as f64,
                ]
            })
            .collect();
        let (columns, rows) = lidar.size();
        let begin = Instant::now();
        let mut points = 0;
        for _ in 0..5 {
            for &p in &poses {
                let scan = lidar.scan(&world, p);
                points += scan.hits.len() + scan.misses.len();
            }
        }
        let t = begin.elapsed().as_secs_f64() / 200.0;
        println!(
            "{name}: lidar {columns} x {rows}: {:.3} ms a scan, {:.1} ns a ray, {} points",
            1e3 * t,
            1e9 * t / (columns * rows) as f64,
            points / 200
        );
        let begin = Instant::now();
        for _ in 0..5 {
            for &[x, y, a] in &poses {
                let (s, c) = a.sin_cos();
                // Looking along the heading, level.
                let rotation = [[s, 0.0, c], [-c, 0.0, s], [0.0, -1.0, 0.0]];
                depth.scan(&world, &(rotation, [x, y, 1.0]));
            }
        }
        let t = begin.elapsed().as_secs_f64() / 200.0;
        println!(
            "{name}: depth {:?}: {:.3} ms an image, {:.1} ns a ray",
            DepthModel::default().size,
            1e3 * t,
            1e9 * t / 4320.0
        );
        let begin = Instant::now();
        let mut sum = 0.0;
        let mut n = 0;
        for &p in &poses {
            for i in 0..200 {
                let a = i as f64 * 0.0314;
                let d = [a.cos(), a.sin(), -0.2];
                sum += world.cast([p[0], p[1], 0.9], d, 10.0).unwrap_or(10.0);
                n += 1;
            }
        }
        println!(
            "{name}: single cast {:.0} ns (mean {:.2} m)",
            1e9 * begin.elapsed().as_secs_f64() / n as f64,
            sum / n as f64
        );
        let begin = Instant::now();
        let truth = GroundTruth::new(&scene, &world, scene.limits.voxel).unwrap();
        println!(
            "{name}: ground truth {:?} in {:.1} ms: {:?} reachable, surface; inspectable {}",
            truth.size(),
            1e3 * begin.elapsed().as_secs_f64(),
            truth.counts(),
            truth.inspectable().count()
        );
        for up_to in [0.05, 0.5] {
            let begin = Instant::now();
            let mut n = 0;
            let mut least = f64::INFINITY;
            for &[x, y, a] in &poses {
                for i in 0..20 {
                    let yaw = a + i as f64 * 0.01;
                    let (s, c) = yaw.sin_cos();
                    let r = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
                    let at = |f: f64, z: f64| [x + c * f, y + s * f, z];
                    let mut body = Body::default();
                    let mut add = |shape, stands| {
                        body.parts.push(Part {
                            shape,
                            stands,
                            name: "",
                        })
                    };
                    add(
                        PartShape::Box {
                            center: at(0.0, 0.2),
                            rotation: r,
                            half: [0.375, 0.275, 0.2],
                        },
                        true,
                    );
                    add(
                        PartShape::Cylinder {
                            center: at(0.1, 0.45),
                            rotation: r,
                            radius: 0.09,
                            half_height: 0.05,
                        },
                        true,
                    );
                    for k in 0..6 {
                        let k = k as f64;
                        add(
                            PartShape::Capsule {
                                a: at(0.1 + 0.08 * k, 0.6 + 0.1 * k),
                                b: at(0.1 + 0.08 * (k + 1.0), 0.7 + 0.1 * k),
                                radius: 0.06,
                            },
                            false,
                        );
                    }
                    add(
                        PartShape::Box {
                            center: at(0.65, 1.2),
                            rotation: r,
                            half: [0.02, 0.06, 0.02],
                        },
                        false,
                    );
                    least = least.min(world.clearance(&body, up_to).distance);
                    n += 1;
                }
            }
            println!(
                "{name}: clearance up to {up_to} m: {:.2} us (least {least:.3})",
                1e6 * begin.elapsed().as_secs_f64() / n as f64
            );
        }
    }
}
