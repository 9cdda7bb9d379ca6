//! An independent check of finished plans: matrices written out, every ball against everything, four times as fine as the
//! problem's rule asks. Shares no code with the planner's own check but the tables.

use crate::problem::Problem;
use crate::robot::{Joints, Model};

/// Finest time and joint step of the problems' own rule, s and rad, and how much finer we look.
const RULE: (f64, f64) = (0.05, 0.05);
const FINER: f64 = 4.0;
/// Rounding of speeds, positions and distances.
const SLACK: f64 = 1e-7;

/// What a path gets wrong: states that touch something, steps that are too fast, ends that are off, lengths that differ.
pub(crate) fn violations(model: &Model, problem: &Problem, path: &[Joints]) -> usize {
    let mut count = 0;
    if path.len() != problem.base.len() {
        return 1;
    }
    count += usize::from(path[0] != problem.start);
    count += usize::from(path[path.len() - 1] != problem.goal);
    for step in 1..path.len() {
        let (a, b) = (path[step - 1], path[step]);
        let mut widest = 0.0f64;
        for j in 0..6 {
            let d = (b[j] - a[j]).abs();
            widest = widest.max(d);
            count += usize::from(d > model.speed[j] * problem.dt + SLACK);
            count += usize::from(b[j] < model.limits[j].0 || b[j] > model.limits[j].1);
        }
        let pieces = (FINER * (problem.dt / RULE.0).max(widest / RULE.1)).ceil() as usize;
        for k in 0..=pieces {
            let t = k as f64 / pieces as f64;
            let q: Joints = std::array::from_fn(|j| a[j] + t * (b[j] - a[j]));
            let (p, n) = (problem.base[step - 1], problem.base[step]);
            let pose: [f64; 3] = std::array::from_fn(|i| p[i] + t * (n[i] - p[i]));
            count += usize::from(touches(model, problem, &q, pose));
        }
    }
    count
}

type Matrix = [[f64; 4]; 4];

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    let mut c = [[0.0; 4]; 4];
    for i in 0..4 {
        for j in 0..4 {
            for k in 0..4 {
                c[i][j] += a[i][k] * b[k][j];
            }
        }
    }
    c
}

fn turn_z(angle: f64) -> Matrix {
    let (s, c) = angle.sin_cos();
    [
        [c, -s, 0.0, 0.0],
        [s, c, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]
}

fn turn_x(angle: f64) -> Matrix {
    let (s, c) = angle.sin_cos();
    [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, c, -s, 0.0],
        [0.0, s, c, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]
}

fn shift(x: f64, y: f64, z: f64) -> Matrix {
    [
        [1.0, 0.0, 0.0, x],
        [0.0, 1.0, 0.0, y],
        [0.0, 0.0, 1.0, z],
        [0.0, 0.0, 0.0, 1.0],
    ]
}

fn apply(m: &Matrix, p: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| m[i][0] * p[0] + m[i][1] * p[1] + m[i][2] * p[2] + m[i][3])
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}

fn touches(model: &Model, problem: &Problem, q: &Joints, pose: [f64; 3]) -> bool {
    let base = times(&shift(pose[0], pose[1], 0.0), &turn_z(pose[2]));
    let mount = shift(model.mount[0], model.mount[1], model.mount[2]);
    let mut frames = vec![mount];
    for j in 0..6 {
        let (d, a, alpha) = model.dh[j];
        let link = times(&times(&turn_z(q[j]), &shift(a, 0.0, d)), &turn_x(alpha));
        frames.push(times(&frames[j], &link));
    }
    let centers: Vec<[f64; 3]> = model
        .balls
        .iter()
        .map(|b| apply(&frames[b.frame], b.center))
        .collect();
    for (i, ball) in model.balls.iter().enumerate() {
        let limit = ball.radius - SLACK;
        let world = apply(&base, centers[i]);
        if world[2] < limit {
            return true;
        }
        for b in &problem.boxes {
            let nearest = std::array::from_fn(|k| world[k].clamp(b[k] - b[k + 3], b[k] + b[k + 3]));
            if apart(world, nearest) < limit {
                return true;
            }
        }
        if i >= model.first_over_base {
            let (low, high) = model.base_box;
            let nearest = std::array::from_fn(|k| centers[i][k].clamp(low[k], high[k]));
            if apart(centers[i], nearest) < limit {
                return true;
            }
        }
    }
    model.pairs.iter().any(|&(i, j)| {
        apart(centers[i], centers[j]) < model.balls[i].radius + model.balls[j].radius - SLACK
    })
}
