//! Distances to obstacles for many points at once.

use super::lanes::{LANES, Lanes};

/// Knows the distance from points of the world to the nearest obstacle.
pub trait BatchField {
    /// Distance, m, at each of the points (x, y, z; m, world); what is too small costs solutions, what is too large
    /// costs safety. Must be pure; NaN counts as occupied.
    fn distances(&self, x: &Lanes, y: &Lanes, z: &Lanes) -> Lanes;
}

/// A field from a function of one point.
impl<F: Fn([f32; 3]) -> f32> BatchField for F {
    #[inline(always)]
    fn distances(&self, x: &Lanes, y: &Lanes, z: &Lanes) -> Lanes {
        super::lanes::each(|l| self([x[l], y[l], z[l]]))
    }
}

/// Distances sampled on a regular grid, read at the nearest sample.
#[derive(Clone, Copy, Debug)]
pub struct GridField<'a> {
    /// Position of sample (0, 0, 0), m, world.
    pub origin: [f64; 3],
    /// Distance between samples, m.
    pub cell: f64,
    /// Samples along x, y and z.
    pub size: [usize; 3],
    /// Distances, m; x runs fastest, then y, then z. Missing ones count as `outside`.
    pub values: &'a [f32],
    /// Distance assumed outside the grid, m.
    pub outside: f32,
    /// Taken off every distance, m. `cell * 0.87` (half a diagonal) makes a nearest sample of an exact field a lower
    /// bound everywhere.
    pub slack: f32,
}

impl BatchField for GridField<'_> {
    #[inline(always)]
    fn distances(&self, x: &Lanes, y: &Lanes, z: &Lanes) -> Lanes {
        let scale = (1.0 / self.cell) as f32;
        let low = self.origin.map(|v| v as f32);
        let size = self.size.map(|n| n as f32);
        let (row, layer) = (self.size[0] as i32, (self.size[0] * self.size[1]) as i32);
        let mut index = [0i32; LANES];
        for l in 0..LANES {
            let (u, v, w) = (
                (x[l] - low[0]) * scale + 0.5,
                (y[l] - low[1]) * scale + 0.5,
                (z[l] - low[2]) * scale + 0.5,
            );
            // NaN fails every comparison.
            let inside = (u >= 0.0)
                & (v >= 0.0)
                & (w >= 0.0)
                & (u < size[0])
                & (v < size[1])
                & (w < size[2]);
            let at = (u as i32) + (v as i32) * row + (w as i32) * layer;
            index[l] = if inside { at } else { -1 };
        }
        let mut out = [0.0; LANES];
        for l in 0..LANES {
            let value = self.values.get(index[l] as u32 as usize);
            out[l] = value.copied().unwrap_or(self.outside) - self.slack;
        }
        out
    }
}
