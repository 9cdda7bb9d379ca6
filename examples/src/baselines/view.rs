//! Camera poses as the planners choose them, and where a camera may be.

use crate::heats::Whole;
use robots::Frame;

/// A camera pose without roll.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct View {
    /// Position of the lens, m.
    pub place: [f64; 3],
    /// Yaw, rad.
    pub yaw: f64,
    /// Elevation, rad; up is positive.
    pub pitch: f64,
}

impl View {
    /// World from camera, optical frame.
    pub(super) fn frame(&self) -> Frame {
        robots::looking(self.place, self.yaw, self.pitch)
    }
}

/// Metres between two places.
pub(super) fn apart(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Where a camera may be.
#[derive(Clone, Copy)]
pub(super) struct Room<'a> {
    /// Robot and map.
    pub whole: &'a Whole<'a>,
    /// Known free space kept around the camera, m.
    pub radius: f64,
    /// Heights of the camera, m.
    pub heights: (f64, f64),
    /// Radius of a disc that must stand on free ground below the camera, m; none where the arm alone goes.
    pub ground: Option<f64>,
}

/// Distance between the places of an edge that are looked at, m.
const STRIDE: f64 = 0.1;

impl Room<'_> {
    /// How far a place is from what the camera must keep off, m; zero is just allowed.
    fn slack(&self, place: [f64; 3]) -> f64 {
        let mapper = self.whole.mapper;
        let around = mapper.distance.distance(place) - self.radius;
        let below = self.ground.map_or(f64::INFINITY, |radius| {
            mapper.ground.clearance([place[0], place[1]]) - radius
        });
        around.min(below)
    }

    /// Whether the camera may be at a place.
    pub(super) fn holds(&self, place: [f64; 3]) -> bool {
        let map = &self.whole.mapper.map;
        (self.heights.0..=self.heights.1).contains(&place[2])
            && map.is_free(map.cell_at(place))
            && self.slack(place) >= 0.0
    }

    /// Whether the camera may go straight from one place to another that it may be at. A camera that is in tighter space than it should
    /// be may leave it.
    pub(super) fn connects(&self, from: [f64; 3], to: [f64; 3]) -> bool {
        let length = apart(&from, &to);
        let n = (length / STRIDE).ceil().max(1.0) as usize;
        let mut least = self.slack(from).min(0.0) - 1e-9;
        (0..=n).all(|k| {
            let t = k as f64 / n as f64;
            let slack = self.slack([0, 1, 2].map(|a| from[a] + t * (to[a] - from[a])));
            let fine = slack >= least;
            least = least.max(slack.min(0.0) - 0.02);
            fine
        })
    }
}
