//! The fan of rays that stands for a camera.

use crate::Error;

/// Where a camera without roll is and looks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FanPose {
    /// Position in the world, m.
    pub position: [f64; 3],
    /// Heading of the optical axis, rad.
    pub yaw: f64,
    /// Elevation of the optical axis, up positive, rad.
    pub pitch: f64,
}

/// Rays over a field of view, evenly spaced in azimuth and elevation.
#[derive(Clone, Debug, PartialEq)]
pub struct Fan {
    range: f64,
    /// Half the field of view, rad.
    half: [f64; 2],
    /// Directions in the camera's frame: x ahead, y left, z up.
    directions: Vec<[f64; 3]>,
}

impl Fan {
    /// Rays of length `range` (m) at azimuths from minus half `fov[0]` and elevations from minus half `fov[1]` (rad) on, in
    /// steps of `step` (rad).
    ///
    /// # Errors
    /// [`Error::Param`](crate::Error) for a range or step that is not positive and finite, or a field of view that is
    /// negative or wider than a full turn.
    pub fn new(range: f64, fov: [f64; 2], step: f64) -> Result<Self, Error> {
        super::poses::positive("range", range)?;
        super::poses::positive("step", step)?;
        for (field, value) in [("fov[0]", fov[0]), ("fov[1]", fov[1])] {
            if !(0.0..=std::f64::consts::TAU).contains(&value) {
                return Err(super::poses::bad(field, value));
            }
        }
        // A hundred-millionth of a step forgives fields of view that are whole numbers of steps up to rounding.
        let [columns, rows] = fov.map(|f| (f / step + 1e-8).floor() as usize + 1);
        let mut directions = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            let (up, level) = (row as f64 * step - 0.5 * fov[1]).sin_cos();
            for column in 0..columns {
                let (left, ahead) = (column as f64 * step - 0.5 * fov[0]).sin_cos();
                directions.push([level * ahead, level * left, up]);
            }
        }
        Ok(Self {
            range,
            half: fov.map(|f| 0.5 * f),
            directions,
        })
    }

    /// FLAP's fan for cells of `cell_size` (m): steps of a cell at the end of the range. The camera of its experiments
    /// has a range of 3 m and a field of view of 0.9934 x 0.6855 rad, 2520 rays on 0.05 m cells.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn flap(range: f64, fov: [f64; 2], cell_size: f64) -> Result<Self, Error> {
        Self::new(range, fov, cell_size / range)
    }

    /// Number of rays.
    pub fn rays(&self) -> usize {
        self.directions.len()
    }

    /// Length of the rays, m.
    pub fn range(&self) -> f64 {
        self.range
    }

    /// False if no ray at a pose comes within `radius` (m) of a point: what changes there does not change the view.
    pub fn may_meet(&self, pose: &FanPose, point: [f64; 3], radius: f64) -> bool {
        let d = [0, 1, 2].map(|a| point[a] - pose.position[a]);
        let r = d.iter().map(|v| v * v).sum::<f64>().sqrt();
        if r > self.range + radius {
            return false;
        }
        if r <= radius {
            return true;
        }
        let ((sy, cy), (sp, cp)) = (pose.yaw.sin_cos(), pose.pitch.sin_cos());
        let level = cy * d[0] + sy * d[1];
        let [ahead, left, up] = [
            cp * level + sp * d[2],
            cy * d[1] - sy * d[0],
            cp * d[2] - sp * level,
        ];
        // The ball fills directions of up to this angle from its middle; a millionth forgives rounding.
        let sine = (radius / r).min(1.0);
        let elevation = (up / r).clamp(-1.0, 1.0).asin();
        if elevation.abs() > self.half[1] + sine.asin() + 1e-6 {
            return false;
        }
        let cosine = elevation.cos();
        // Rays tilted beyond the vertical point the other way.
        let all_around = sine >= cosine || self.half[1] > std::f64::consts::FRAC_PI_2;
        all_around || left.atan2(ahead).abs() <= self.half[0] + (sine / cosine).asin() + 1e-6
    }

    /// Unit directions of the rays in the world.
    pub fn directions(&self, pose: &FanPose) -> impl Iterator<Item = [f64; 3]> + '_ {
        let ((sy, cy), (sp, cp)) = (pose.yaw.sin_cos(), pose.pitch.sin_cos());
        self.directions.iter().map(move |&[x, y, z]| {
            let ahead = cp * x - sp * z;
            [cy * ahead - sy * y, sy * ahead + cy * y, sp * x + cp * z]
        })
    }

    /// Ends of the rays in the world, m.
    pub fn ends(&self, pose: &FanPose) -> Vec<[f64; 3]> {
        self.directions(pose)
            .map(|d| [0, 1, 2].map(|a| pose.position[a] + self.range * d[a]))
            .collect()
    }
}
