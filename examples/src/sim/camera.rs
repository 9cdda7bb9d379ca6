//! The depth camera.

use super::PointScan;
use super::body::CameraPose;
use super::noise::{Disturbance, Noise};
use super::raster::{Pinhole, draw};
use super::world::World;

/// Geometry of the depth camera. Default: G item 1 of the HEATS defaults (RealSense D435i), one ray for about
/// 1.1 degrees, two for a voxel of 0.15 m at the longest range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthModel {
    /// Rays across and down.
    pub size: [usize; 2],
    /// Horizontal and vertical field of view, rad.
    pub field: [f64; 2],
    /// Returns nearer than this are dropped, m along the ray.
    pub min_range: f64,
    /// Longest range, m along the ray.
    pub max_range: f64,
    /// Images a second.
    pub rate: f64,
}

impl Default for DepthModel {
    fn default() -> Self {
        Self {
            size: [80, 54],
            field: [87.0_f64.to_radians(), 58.0_f64.to_radians()],
            min_range: 0.3,
            max_range: 4.0,
            rate: 10.0,
        }
    }
}

/// The sensor with its buffers.
#[derive(Clone, Debug)]
pub struct DepthCamera {
    model: DepthModel,
    pinhole: Pinhole,
    /// Length of the ray through each pixel for depth 1.
    length: Vec<f32>,
    depth: Vec<f32>,
    disturbance: Disturbance,
    /// Measured ranges, where there are outliers.
    measured: Vec<f32>,
    scan: PointScan,
}

impl DepthCamera {
    /// A camera of the given geometry.
    pub fn new(model: DepthModel, noise: Noise) -> Self {
        let pinhole = Pinhole::new(model.size, model.field[0], model.field[1]);
        let [width, height] = model.size;
        let length = (0..width * height)
            .map(|i| {
                let (x, y) = (
                    pinhole.coordinate(0, i % width),
                    pinhole.coordinate(1, i / width),
                );
                (1.0 + x * x + y * y).sqrt() as f32
            })
            .collect();
        Self {
            pinhole,
            length,
            depth: vec![0.0; width * height],
            disturbance: Disturbance::new(noise, 2),
            measured: Vec::new(),
            scan: PointScan {
                max_range: model.max_range,
                ..PointScan::default()
            },
            model,
        }
    }

    /// The geometry it was made with.
    pub fn model(&self) -> &DepthModel {
        &self.model
    }

    /// Its rays.
    pub fn pinhole(&self) -> &Pinhole {
        &self.pinhole
    }

    /// Depth along the optical axis of the last image, m, rows of `size[0]`; a miss has the depth of the longest
    /// range.
    pub fn depth(&self) -> &[f32] {
        &self.depth
    }

    /// Takes an image from a camera pose.
    pub fn scan(&mut self, world: &World, pose: &CameraPose) -> &PointScan {
        let max = self.model.max_range as f32;
        for (depth, length) in self.depth.iter_mut().zip(&self.length) {
            *depth = max / length;
        }
        draw(
            &self.pinhole,
            world,
            pose,
            self.model.max_range,
            &mut self.depth,
        );
        self.collect(pose);
        &self.scan
    }

    fn collect(&mut self, (rotation, origin): &CameraPose) {
        let (min, max) = (self.model.min_range as f32, self.model.max_range as f32);
        let width = self.model.size[0];
        self.scan.origin = *origin;
        self.scan.hits.clear();
        self.scan.misses.clear();
        let perfect = self.disturbance.is_off();
        let wild = self.disturbance.has_outliers();
        if wild {
            self.measured.clear();
            self.measured
                .extend(self.depth.iter().zip(&self.length).map(|(d, l)| d * l));
            self.disturbance
                .falsify(&mut self.measured, (min, max), width, false);
        }
        for (i, (&depth, &length)) in self.depth.iter().zip(&self.length).enumerate() {
            let mut range = depth * length;
            let mut depth = f64::from(depth);
            if wild {
                range = self.measured[i];
                if range.is_nan() {
                    continue;
                }
                depth = f64::from(range / length);
            } else if !perfect {
                let Some(factor) = self.disturbance.factor() else {
                    continue;
                };
                if range < max * (1.0 - 1e-6) {
                    range *= factor as f32;
                    depth *= factor;
                }
            }
            if range < min {
                continue;
            }
            let missed = range >= max * (1.0 - 1e-6);
            if missed {
                depth = f64::from(max / length);
            }
            let (x, y) = (
                self.pinhole.coordinate(0, i % width),
                self.pinhole.coordinate(1, i / width),
            );
            let point = [0, 1, 2].map(|k| {
                let d = rotation[k][0] * x + rotation[k][1] * y + rotation[k][2];
                (origin[k] + depth * d) as f32
            });
            if missed {
                self.scan.misses.push(point)
            } else {
                self.scan.hits.push(point)
            }
        }
    }
}
