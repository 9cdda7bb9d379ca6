//! What the planner must know about a map and a robot.

/// A planar map that knows how far the nearest obstacle is.
///
/// Laws, tested by [`conformance::check_map`](crate::conformance::check_map): bounds are finite and not empty;
/// clearance is never NaN inside the bounds and changes by no more than the distance moved (plus one cell of the
/// map's own resolution).
pub trait Map {
    /// Distance from `p` (world frame, m) to the nearest obstacle, m; zero or negative inside one.
    ///
    /// What counts as an obstacle (unknown cells, the outside) is the map's choice. A value that is too small costs
    /// paths, one that is too large costs safety.
    fn clearance(&self, p: [f64; 2]) -> f64;
    /// Lower and upper corner of the mapped rectangle, m. No path leaves it.
    fn bounds(&self) -> ([f64; 2], [f64; 2]);
    /// A number that changes whenever the map does; a [`Planner`](crate::Planner) keeps its fields while it stays.
    fn revision(&self) -> u64 {
        0
    }
    /// Whether the filled convex polygon (corners in the world frame, counter-clockwise) touches no obstacle;
    /// `None` if the map cannot tell, and then the robot's circles decide.
    fn outline_is_free(&self, _corners: &[[f64; 2]]) -> Option<bool> {
        None
    }
}

impl<M: Map + ?Sized> Map for &M {
    fn clearance(&self, p: [f64; 2]) -> f64 {
        (**self).clearance(p)
    }
    fn bounds(&self) -> ([f64; 2], [f64; 2]) {
        (**self).bounds()
    }
    fn revision(&self) -> u64 {
        (**self).revision()
    }
    fn outline_is_free(&self, corners: &[[f64; 2]]) -> Option<bool> {
        (**self).outline_is_free(corners)
    }
}

/// The footprint of a base that turns about its frame's origin.
pub trait Robot {
    /// Circles that together cover the footprint: (centre in the base frame, radius), m.
    fn circles(&self) -> &[([f64; 2], f64)];
    /// The footprint as a convex polygon in the base frame, counter-clockwise, m; empty if only circles are known.
    /// Used in place of the circles where the map can test polygons.
    fn outline(&self) -> &[[f64; 2]] {
        &[]
    }
}

impl<R: Robot + ?Sized> Robot for &R {
    fn circles(&self) -> &[([f64; 2], f64)] {
        (**self).circles()
    }
    fn outline(&self) -> &[[f64; 2]] {
        (**self).outline()
    }
}

/// A footprint given by its numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Footprint {
    circles: Vec<([f64; 2], f64)>,
    outline: Vec<[f64; 2]>,
}

impl Footprint {
    /// A disc about the turning centre, radius in m.
    pub fn disc(radius: f64) -> Self {
        Self {
            circles: vec![([0.0; 2], radius)],
            outline: Vec::new(),
        }
    }

    /// Circles in the base frame, (centre, radius), m.
    pub fn circles(circles: &[([f64; 2], f64)]) -> Self {
        Self {
            circles: circles.to_vec(),
            outline: Vec::new(),
        }
    }

    /// A rectangle about the turning centre, `length` along x, `width` along y, m: covered by `count` equal circles
    /// along its axis, and kept as an outline.
    pub fn rectangle(length: f64, width: f64, count: usize) -> Self {
        let n = count.max(1);
        let part = length / n as f64;
        let radius = 0.5 * part.hypot(width);
        let circles = (0..n)
            .map(|i| ([(i as f64 + 0.5) * part - 0.5 * length, 0.0], radius))
            .collect();
        let (l, w) = (0.5 * length, 0.5 * width);
        Self {
            circles,
            outline: vec![[-l, -w], [l, -w], [l, w], [-l, w]],
        }
    }

    /// A convex polygon, counter-clockwise in the base frame, m, with the one circle that covers it.
    pub fn polygon(corners: &[[f64; 2]]) -> Self {
        let radius = corners.iter().map(|c| c[0].hypot(c[1])).fold(0.0, f64::max);
        Self {
            circles: vec![([0.0; 2], radius)],
            outline: corners.to_vec(),
        }
    }
}

impl Robot for Footprint {
    fn circles(&self) -> &[([f64; 2], f64)] {
        &self.circles
    }
    fn outline(&self) -> &[[f64; 2]] {
        &self.outline
    }
}
