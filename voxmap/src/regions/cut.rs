//! One cut of a component: the shortest that resolves the most concavity.

use super::contour::{Contour, concavity, distance, foot, simplify, trace};
use super::{RegionParams, components};

/// A vertex or foot that a cut may end at.
#[derive(Clone, Copy)]
struct End {
    contour: usize,
    /// Position along the contour, cells.
    along: f64,
    point: [f64; 2],
    concavity: f64,
}

/// Cuts a component (sorted cell indices) in parts, or `None` when no notch has a legal cut.
pub(crate) fn split(
    part: &[usize],
    size: [usize; 2],
    cell_size: f64,
    params: &RegionParams,
) -> Option<Vec<Vec<usize>>> {
    let tau = params.tau / cell_size;
    // A window of the component's own size keeps the work local.
    let nx = size[0];
    let xs = part.iter().map(|&i| i % nx);
    let (x0, x1) = (xs.clone().min()?, xs.max()?);
    let (y0, y1) = (part[0] / nx, part[part.len() - 1] / nx);
    let window = [x1 - x0 + 1, y1 - y0 + 1];
    let mut image = vec![false; window[0] * window[1]];
    let mut cells = Vec::with_capacity(part.len());
    for &i in part {
        let (x, y) = (i % nx - x0, i / nx - y0);
        image[y * window[0] + x] = true;
        cells.push((x as i32, y as i32));
    }
    let inside = |x: i32, y: i32| {
        x >= 0
            && y >= 0
            && (x as usize) < window[0]
            && (y as usize) < window[1]
            && image[y as usize * window[0] + x as usize]
    };
    let contours: Vec<Contour> = trace(&inside, &cells)
        .into_iter()
        .map(|c| Contour {
            points: simplify(&c.points, params.simplify / cell_size),
            ..c
        })
        .collect();
    let (from, to) = best_cut(&contours, tau, params.skinny * tau, &inside)?;
    burn(&mut image, window, from, to);
    let pieces = components(&image, window);
    if pieces.len() < 2 && !contours.iter().any(|c| c.hole) {
        return None; // burnt, but not through: rounding at a corner
    }
    Some(
        pieces
            .into_iter()
            .map(|piece| {
                piece
                    .into_iter()
                    .map(|i| (i / window[0] + y0) * nx + i % window[0] + x0)
                    .collect()
            })
            .collect(),
    )
}

/// The legal cut of largest weight: resolved concavity over length.
fn best_cut(
    contours: &[Contour],
    tau: f64,
    skinny: f64,
    inside: &impl Fn(i32, i32) -> bool,
) -> Option<([f64; 2], [f64; 2])> {
    let mut vertices: Vec<End> = Vec::new();
    let mut edges: Vec<(usize, f64, [f64; 2], [f64; 2])> = Vec::new();
    let mut lengths = Vec::new();
    for (contour, c) in contours.iter().enumerate() {
        let n = c.points.len();
        let depth = if c.hole {
            hole_concavity(&c.points, tau)
        } else {
            concavity(&c.points)
        };
        let mut along = 0.0;
        for i in 0..n {
            let (p, q) = (c.points[i], c.points[(i + 1) % n]);
            vertices.push(End {
                contour,
                along,
                point: p,
                concavity: depth[i],
            });
            edges.push((contour, along, p, q));
            along += distance(p, q);
        }
        lengths.push(along);
    }
    let mut cuts: Vec<(f64, f64, End, End)> = Vec::new();
    for v in vertices.iter().filter(|v| v.concavity > tau) {
        let mut consider = |o: End| {
            let length = distance(v.point, o.point);
            if length < 1.5 {
                return;
            }
            if o.contour == v.contour {
                let way = (o.along - v.along).abs();
                if way.min(lengths[v.contour] - way) < skinny {
                    return;
                }
            }
            let more = if o.concavity > tau {
                o.concavity
            } else {
                0.5 * o.concavity
            };
            cuts.push(((v.concavity + more) / length, length, *v, o));
        };
        for &o in &vertices {
            consider(o);
        }
        for &(contour, along, p, q) in &edges {
            if contour == v.contour && (p == v.point || q == v.point) {
                continue;
            }
            let point = foot(v.point, p, q);
            if point != p && point != q {
                consider(End {
                    contour,
                    along: along + distance(p, point),
                    point,
                    concavity: 0.0,
                });
            }
        }
    }
    cuts.sort_by(|a, b| {
        b.0.total_cmp(&a.0)
            .then(a.1.total_cmp(&b.1))
            .then(a.2.point[1].total_cmp(&b.2.point[1]))
            .then(a.2.point[0].total_cmp(&b.2.point[0]))
    });
    cuts.iter()
        .find(|(_, _, v, o)| is_inside(v.point, o.point, inside))
        .map(|(_, _, v, o)| (v.point, o.point))
}

/// A hole wider than tau has two notches, its farthest vertices, as deep as it is wide; others are furniture.
fn hole_concavity(points: &[[f64; 2]], tau: f64) -> Vec<f64> {
    let mut depth = vec![0.0; points.len()];
    let (mut far, mut pair) = (0.0, (0, 0));
    for i in 0..points.len() {
        for j in 0..i {
            let d = distance(points[i], points[j]);
            if d > far {
                (far, pair) = (d, (j, i));
            }
        }
    }
    if far >= tau {
        depth[pair.0] = far;
        depth[pair.1] = far;
    }
    depth
}

/// True if the segment between two border points runs through the component, its very ends aside.
fn is_inside(a: [f64; 2], b: [f64; 2], inside: &impl Fn(i32, i32) -> bool) -> bool {
    let length = distance(a, b);
    let steps = (length * 4.0).ceil() as i32;
    (0..=steps).all(|i| {
        let s = f64::from(i) / f64::from(steps) * length;
        // Near its ends the segment may run along a border.
        if s < 0.75 || s > length - 0.75 {
            return true;
        }
        let t = s / length;
        let p = [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
        inside(p[0].floor() as i32, p[1].floor() as i32)
    })
}

/// Clears a one-cell line between two points, 1.5 cells longer at both ends, without diagonal leaks.
fn burn(image: &mut [bool], size: [usize; 2], a: [f64; 2], b: [f64; 2]) {
    let length = distance(a, b);
    let way = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
    let steps = ((length + 3.0) * 8.0).ceil() as i32;
    let mut clear = |x: i32, y: i32| {
        if x >= 0 && y >= 0 && (x as usize) < size[0] && (y as usize) < size[1] {
            image[y as usize * size[0] + x as usize] = false;
        }
    };
    // Off the corner lattice by a hair, always to the same side.
    let offset = 1e-3;
    for i in 0..=steps {
        let s = f64::from(i) / f64::from(steps) * (length + 3.0) - 1.5;
        let x = (a[0] + way[0] * s - way[1] * offset + offset).floor() as i32;
        let y = (a[1] + way[1] * s + way[0] * offset + offset).floor() as i32;
        clear(x, y);
    }
}
