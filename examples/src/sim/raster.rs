//! A pinhole image of exact depths: every solid is drawn over the pixels its outline may cover.

use super::body::CameraPose;
use super::world::World;
use crate::scene::{Form, Solid};

/// Parts of a solid nearer to the image plane than this are cut off before projection, m.
const NEAR: f64 = 1e-3;
/// In place of a zero direction component, whose reciprocal would be infinite.
const TINY: f32 = 1e-20;

/// Rays of an image: pixel centres of a symmetric pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pinhole {
    /// Pixels across and down.
    pub size: [usize; 2],
    /// Tangents of half the horizontal and vertical field of view.
    pub tan_half: [f64; 2],
}

impl Pinhole {
    /// A camera of the given fields of view, rad.
    pub fn new(size: [usize; 2], horizontal: f64, vertical: f64) -> Self {
        Self {
            size,
            tan_half: [horizontal, vertical].map(|a| (0.5 * a).tan()),
        }
    }

    /// Image coordinate x/z or y/z of a pixel centre along one axis.
    pub fn coordinate(&self, axis: usize, pixel: usize) -> f64 {
        ((2 * pixel + 1) as f64 / self.size[axis] as f64 - 1.0) * self.tan_half[axis]
    }

    /// First pixel and one past the last along one axis whose centres lie in `low..=high`.
    fn pixels(&self, axis: usize, low: f64, high: f64) -> (usize, usize) {
        let n = self.size[axis] as f64;
        let pixel = |x: f64| 0.5 * ((x / self.tan_half[axis] + 1.0) * n - 1.0);
        // Half a thousandth of a pixel of slack for rounding; a spare pixel costs only time.
        let first = (pixel(low) - 5e-4).ceil().clamp(0.0, n);
        let last = (pixel(high) + 5e-4).floor().clamp(-1.0, n - 1.0);
        (first as usize, (last + 1.0) as usize)
    }
}

/// Draws exact depths (distance along the optical axis, m) into `depth`, rows of `size[0]`, shortening what stands
/// there. Fill `depth` with the farthest depth of interest first.
pub(crate) fn draw(
    pinhole: &Pinhole,
    world: &World,
    pose: &CameraPose,
    range: f64,
    depth: &mut [f32],
) {
    let (rotation, origin) = pose;
    let xs: Vec<f32> = (0..pinhole.size[0])
        .map(|i| pinhole.coordinate(0, i) as f32)
        .collect();
    for (row, depth) in depth.chunks_mut(pinhole.size[0]).enumerate() {
        let y = pinhole.coordinate(1, row);
        for (i, depth) in depth.iter_mut().enumerate() {
            let dz = rotation[2][0] * f64::from(xs[i]) + rotation[2][1] * y + rotation[2][2];
            *depth = depth.min(world.cast_planes(origin[2], dz) as f32);
        }
    }
    let column = |j: usize| [rotation[0][j], rotation[1][j], rotation[2][j]];
    let (right, down, ahead) = (column(0), column(1), column(2));
    for solid in &world.solids {
        let Some(window) = window(pinhole, solid, pose, range) else {
            continue;
        };
        let local = solid.to_local(*origin);
        // Local direction of pixel (x, y) is right*x + down*y + ahead.
        let turned = [right, down, ahead].map(|v| solid.turn_to_local(v));
        for row in window[1].0..window[1].1 {
            let y = pinhole.coordinate(1, row);
            let span = window[0].0..window[0].1;
            let depth = &mut depth[row * pinhole.size[0]..][span.clone()];
            let xs = &xs[span];
            let base = [0, 1, 2].map(|k| (turned[1][k] * y + turned[2][k]) as f32);
            let slope = turned[0].map(|v| v as f32);
            let o = local.map(|v| v as f32);
            match solid.form {
                Form::Box(half) => draw_box(half.map(|v| v as f32), o, slope, base, xs, depth),
                Form::Cylinder(radius, half) => {
                    draw_cylinder(radius as f32, half as f32, o, slope, base, xs, depth);
                }
                Form::Mesh(_) => {
                    for (depth, &x) in depth.iter_mut().zip(xs) {
                        let d = [0, 1, 2].map(|k| right[k] * f64::from(x) + down[k] * y + ahead[k]);
                        if let Some(t) = solid.cast(*origin, d, f64::from(*depth)) {
                            *depth = t as f32;
                        }
                    }
                }
            }
        }
    }
}

#[inline]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline]
fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

fn draw_box(
    half: [f32; 3],
    o: [f32; 3],
    slope: [f32; 3],
    base: [f32; 3],
    xs: &[f32],
    depth: &mut [f32],
) {
    let low = [0, 1, 2].map(|k| -half[k] - o[k]);
    let high = [0, 1, 2].map(|k| half[k] - o[k]);
    for (depth, &x) in depth.iter_mut().zip(xs) {
        let (mut near, mut far) = (0.0_f32, *depth);
        for k in 0..3 {
            let d = slope[k] * x + base[k];
            let inverse = 1.0 / if d == 0.0 { TINY } else { d };
            let (a, b) = (low[k] * inverse, high[k] * inverse);
            near = greater(lesser(a, b), near);
            far = lesser(greater(a, b), far);
        }
        *depth = if near <= far { near } else { *depth };
    }
}

fn draw_cylinder(
    radius: f32,
    half: f32,
    o: [f32; 3],
    slope: [f32; 3],
    base: [f32; 3],
    xs: &[f32],
    depth: &mut [f32],
) {
    let c = o[0] * o[0] + o[1] * o[1] - radius * radius;
    for (depth, &x) in depth.iter_mut().zip(xs) {
        let d = [0, 1, 2].map(|k| slope[k] * x + base[k]);
        let inverse = 1.0 / if d[2] == 0.0 { TINY } else { d[2] };
        let (a, b) = ((-half - o[2]) * inverse, (half - o[2]) * inverse);
        let near = greater(lesser(a, b), 0.0);
        let far = lesser(greater(a, b), *depth);
        let a = greater(d[0] * d[0] + d[1] * d[1], TINY);
        let b = o[0] * d[0] + o[1] * d[1];
        let disc = b * b - a * c;
        let root = greater(disc, 0.0).sqrt();
        let near = greater((-b - root) / a, near);
        let far = lesser((-b + root) / a, far);
        *depth = if disc >= 0.0 && near <= far {
            near
        } else {
            *depth
        };
    }
}

/// Pixels along x and y that a solid may cover; `None` when it is out of sight or range.
fn window(
    pinhole: &Pinhole,
    solid: &Solid,
    pose: &CameraPose,
    range: f64,
) -> Option<[(usize, usize); 2]> {
    let (rotation, origin) = pose;
    let away = [0, 1, 2].map(|k| {
        (solid.low[k] - origin[k])
            .max(origin[k] - solid.high[k])
            .max(0.0)
    });
    if away.iter().map(|d| d * d).sum::<f64>() > range * range {
        return None;
    }
    let to_camera = |p: [f64; 3]| {
        let d = [0, 1, 2].map(|k| p[k] - origin[k]);
        [0, 1, 2].map(|j| (0..3).map(|k| rotation[k][j] * d[k]).sum::<f64>())
    };
    let half = match solid.form {
        Form::Box(half) => Some(half),
        Form::Cylinder(radius, half) => Some([radius, radius, half]),
        Form::Mesh(_) => None,
    };
    let corners: [[f64; 3]; 8] = std::array::from_fn(|i| {
        let bits = [i & 1, i >> 1 & 1, i >> 2];
        to_camera(match half {
            Some(half) => {
                let s = [0, 1, 2].map(|j| half[j] * (2.0 * bits[j] as f64 - 1.0));
                [0, 1, 2]
                    .map(|k| solid.center[k] + (0..3).map(|j| solid.axes[j][k] * s[j]).sum::<f64>())
            }
            None => [0, 1, 2].map(|k| {
                if bits[k] == 1 {
                    solid.high[k]
                } else {
                    solid.low[k]
                }
            }),
        })
    });
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut take = |p: [f64; 3]| {
        for k in 0..2 {
            low[k] = low[k].min(p[k] / p[2]);
            high[k] = high[k].max(p[k] / p[2]);
        }
    };
    for i in 0..8 {
        if corners[i][2] >= NEAR {
            take(corners[i]);
        }
        // The three edges from this corner, where they pass the near plane.
        for j in [i ^ 1, i ^ 2, i ^ 4] {
            let (a, b) = (corners[i], corners[j]);
            if a[2] >= NEAR && b[2] < NEAR {
                let s = (a[2] - NEAR) / (a[2] - b[2]);
                take([a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), NEAR]);
            }
        }
    }
    // Nothing ahead of the near plane, or a point of the near plane only.
    if low[0] > high[0] {
        return None;
    }
    let window = [0, 1].map(|k| pinhole.pixels(k, low[k], high[k]));
    (window[0].0 < window[0].1 && window[1].0 < window[1].1).then_some(window)
}
