//! Cells, boxes of cells, balls and cameras: the plain types of the public interface.

/// Index of a voxel: cell `c` covers `[low + c h, low + (c + 1) h)` on every axis.
pub type Cell = [i32; 3];

/// A half-open box of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct CellBox {
    /// First cell inside.
    pub low: Cell,
    /// First cell beyond, on every axis.
    pub high: Cell,
}

impl CellBox {
    /// True if the box holds the cell.
    pub fn contains(&self, cell: Cell) -> bool {
        (0..3).all(|a| self.low[a] <= cell[a] && cell[a] < self.high[a])
    }

    /// The box grown by `by` cells on every side.
    pub fn grown(&self, by: i32) -> Self {
        Self {
            low: self.low.map(|v| v - by),
            high: self.high.map(|v| v + by),
        }
    }

    /// The cells of both boxes; may be empty.
    pub fn common(&self, other: &Self) -> Self {
        Self {
            low: [0, 1, 2].map(|a| self.low[a].max(other.low[a])),
            high: [0, 1, 2].map(|a| self.high[a].min(other.high[a])),
        }
    }

    /// The smallest box that holds both.
    pub fn joined(&self, other: &Self) -> Self {
        Self {
            low: [0, 1, 2].map(|a| self.low[a].min(other.low[a])),
            high: [0, 1, 2].map(|a| self.high[a].max(other.high[a])),
        }
    }

    /// True if both boxes share a cell.
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|a| self.low[a] < other.high[a] && other.low[a] < self.high[a])
    }

    /// Number of cells.
    pub fn volume(&self) -> usize {
        (0..3)
            .map(|a| (self.high[a] - self.low[a]).max(0) as usize)
            .product()
    }
}

/// What is known of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Never observed.
    Unknown,
    /// Observed, below the occupancy threshold.
    Free,
    /// Observed, at or above the occupancy threshold.
    Occupied,
}

/// A ball in the world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Centre, m.
    pub center: [f64; 3],
    /// Radius, m.
    pub radius: f64,
}

/// A pinhole camera: z forward, x right, y down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Rows of the rotation world-from-camera.
    pub rotation: [[f64; 3]; 3],
    /// Position in the world frame, m.
    pub translation: [f64; 3],
    /// Tangent of half the horizontal field of view.
    pub tan_half_h: f64,
    /// Tangent of half the vertical field of view.
    pub tan_half_v: f64,
}

impl Ball {
    /// True if the point lies inside or on the ball.
    pub fn contains(&self, point: [f64; 3]) -> bool {
        let square: f64 = (0..3).map(|a| (point[a] - self.center[a]).powi(2)).sum();
        square <= self.radius * self.radius
    }
}

impl Camera {
    /// True if the point lies inside the image and in front of the camera.
    pub fn sees(&self, point: [f64; 3]) -> bool {
        let d = [0, 1, 2].map(|a| point[a] - self.translation[a]);
        let along = |axis: usize| {
            (0..3)
                .map(|row| self.rotation[row][axis] * d[row])
                .sum::<f64>()
        };
        let depth = along(2);
        depth > 0.0
            && along(0).abs() <= depth * self.tan_half_h
            && along(1).abs() <= depth * self.tan_half_v
    }

    /// True if a square lies in front of the camera and whole inside the image: its middle, the axis that it is normal to (0 to 2),
    /// and half its side, m; its sides are parallel to the other axes.
    pub fn sees_square(&self, middle: [f64; 3], axis: usize, half: f64) -> bool {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
            .into_iter()
            .all(|(a, b)| {
                let mut corner = middle;
                corner[u] += a * half;
                corner[v] += b * half;
                self.sees(corner)
            })
    }
}
