//! Depth images of a pinhole camera as the points of a scan.

use crate::error::Error;

/// A depth image, and the camera that took it: x to the right, y down, z forwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthImage<'a> {
    /// Distance along the camera's z axis, m, row by row from the upper left pixel on. What is not positive and finite had no
    /// return.
    pub depth: &'a [f32],
    /// Pixels of a row.
    pub width: usize,
    /// Focal lengths along x and y, pixels.
    pub focal: [f64; 2],
    /// Where the optical axis meets the image, pixels; the middle of the upper left pixel is (0, 0).
    pub center: [f64; 2],
    /// Rows of the rotation world-from-camera.
    pub rotation: [[f64; 3]; 3],
    /// Position of the camera in the world frame, m: the scan's origin.
    pub translation: [f64; 3],
    /// Every so many pixels along both axes give a ray, the first from half as many on.
    pub stride: usize,
    /// Returns nearer than this are left out, m: the robot itself, or noise. Zero or more.
    pub nearest: f64,
    /// Depth up to which the rays of pixels without a return are free, m. `None`: they tell nothing, as where glass or black
    /// surfaces swallow the light.
    pub free_without_return: Option<f64>,
}

/// The rays of a depth image, for [`Scan`](crate::Scan).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DepthPoints {
    /// Points that returned, m, world frame: [`Scan::hits`](crate::Scan::hits).
    pub hits: Vec<[f32; 3]>,
    /// Ends of rays without a return: [`Scan::misses`](crate::Scan::misses).
    pub misses: Vec<[f32; 3]>,
}

impl DepthImage<'_> {
    /// The points that the pixels saw, in the order of the pixels.
    ///
    /// ```
    /// use voxmap::{DepthImage, Scan, SensorModel, VoxelMap};
    ///
    /// // Two pixels that look along the world's x axis: one sees a wall 2 m ahead, one sees nothing.
    /// let image = DepthImage {
    ///     depth: &[2.0, 0.0],
    ///     width: 2,
    ///     focal: [100.0; 2],
    ///     center: [0.0; 2],
    ///     rotation: [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
    ///     translation: [0.0, 0.0, 1.0],
    ///     stride: 1,
    ///     nearest: 0.2,
    ///     free_without_return: Some(4.0),
    /// };
    /// let points = image.points()?;
    /// assert_eq!(points.hits, [[2.0, 0.0, 1.0]]);
    /// assert_eq!(points.misses, [[4.0, -0.04, 1.0]]);
    /// let mut map = VoxelMap::growing(0.1, &SensorModel::default(), 1 << 20)?;
    /// let (hits, misses) = (&points.hits[..], &points.misses[..]);
    /// map.insert(&Scan { origin: image.translation, hits, misses, ..Scan::default() })?;
    /// # Ok::<(), voxmap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Image`] for a number of pixels that is no multiple of the width, [`Error::Length`] for focal lengths, a stride
    /// or a free depth that are not positive and finite and a nearest return that is negative or not finite, [`Error::Position`] for a camera that is nowhere.
    pub fn points(&self) -> Result<DepthPoints, Error> {
        let (pixels, width) = (self.depth.len(), self.width);
        if width == 0 || !pixels.is_multiple_of(width) {
            return Err(Error::Image { pixels, width });
        }
        let positive = |field, value: f64| {
            if value > 0.0 && value.is_finite() {
                Ok(())
            } else {
                Err(Error::Length { field, value })
            }
        };
        positive("focal[0]", self.focal[0])?;
        positive("focal[1]", self.focal[1])?;
        positive("stride", self.stride as f64)?;
        // Zero leaves nothing out.
        positive(
            "nearest",
            if self.nearest == 0.0 {
                1.0
            } else {
                self.nearest
            },
        )?;
        positive(
            "free_without_return",
            self.free_without_return.unwrap_or(1.0),
        )?;
        let [cx, cy] = self.center;
        for (field, value) in [
            ("translation", self.translation),
            ("center", [cx, cy, 0.0]),
            ("rotation[0]", self.rotation[0]),
            ("rotation[1]", self.rotation[1]),
            ("rotation[2]", self.rotation[2]),
        ] {
            if !value.iter().all(|v| v.is_finite()) {
                return Err(Error::Position { field, value });
            }
        }
        let mut out = DepthPoints::default();
        for v in (self.stride / 2..pixels / width).step_by(self.stride) {
            for u in (self.stride / 2..width).step_by(self.stride) {
                let depth = f64::from(self.depth[v * width + u]);
                if !(depth > 0.0 && depth.is_finite()) {
                    if let Some(free) = self.free_without_return {
                        out.misses.push(self.place(u, v, free));
                    }
                } else if depth >= self.nearest {
                    out.hits.push(self.place(u, v, depth));
                }
            }
        }
        Ok(out)
    }

    /// Where a pixel's ray is at a depth, in the world frame.
    fn place(&self, u: usize, v: usize, depth: f64) -> [f32; 3] {
        let x = (u as f64 - self.center[0]) * depth / self.focal[0];
        let y = (v as f64 - self.center[1]) * depth / self.focal[1];
        [0, 1, 2].map(|a| {
            let [rx, ry, rz] = self.rotation[a];
            (rx * x + ry * y + rz * depth + self.translation[a]) as f32
        })
    }
}
