//! The footprint against the map: single poses and whole motions.

use crate::moves::{Motion, Move};
use crate::{Error, Map, Robot};

/// The footprint with its margin, ready for checks.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    /// Circle centres in the base frame and the clearance each needs, m.
    circles: Vec<([f64; 2], f64)>,
    outline: Vec<[f64; 2]>,
    /// Radius of the largest disc about the origin inside the footprint, margin included, m.
    pub(crate) inscribed: f64,
    /// Radius of the smallest disc about the origin that holds the footprint, margin included, m.
    pub(crate) circumscribed: f64,
    /// Distance of the checked point that turning moves most, m.
    lever: f64,
    check_step: f64,
}

impl Body {
    /// `use_outline`: whether the map can test polygons.
    pub(crate) fn new<M: Map, R: Robot>(
        map: &M,
        robot: &R,
        margin: f64,
        check_step: f64,
    ) -> Result<Self, Error> {
        let raw = robot.outline();
        let (low, high) = map.bounds();
        let middle = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])];
        let probe: Vec<[f64; 2]> = raw
            .iter()
            .map(|c| [middle[0] + c[0], middle[1] + c[1]])
            .collect();
        let exact = raw.len() >= 3 && map.outline_is_free(&probe).is_some();
        let mut circles = Vec::new();
        for &(o, r) in robot.circles() {
            if !(o[0].is_finite() && o[1].is_finite() && r > 0.0 && r.is_finite()) {
                return Err(Error::Footprint(
                    "every circle needs a finite centre and a positive, finite radius",
                ));
            }
            circles.push((o, r + margin));
        }
        let outline = if exact {
            inflate(raw, margin)?
        } else {
            Vec::new()
        };
        if circles.is_empty() && outline.is_empty() {
            return Err(Error::Footprint(
                "at least one circle is needed (or an outline, on a map that tests outlines)",
            ));
        }
        let (inscribed, circumscribed);
        if exact {
            circumscribed = outline.iter().map(|c| c[0].hypot(c[1])).fold(0.0, f64::max);
            inscribed = edges(&outline)
                .map(|(a, n)| n[0] * a[0] + n[1] * a[1])
                .fold(f64::INFINITY, f64::min)
                .max(0.0);
        } else {
            circumscribed = circles
                .iter()
                .map(|(o, r)| o[0].hypot(o[1]) + r)
                .fold(0.0, f64::max);
            inscribed = circles
                .iter()
                .map(|(o, r)| r - o[0].hypot(o[1]))
                .fold(0.0, f64::max);
        }
        let lever = if exact {
            circumscribed
        } else {
            circles
                .iter()
                .map(|(o, _)| o[0].hypot(o[1]))
                .fold(0.0, f64::max)
        };
        Ok(Self {
            circles,
            outline,
            inscribed,
            circumscribed,
            lever,
            check_step,
        })
    }

    /// Room around the footprint at the pose, m: not negative if it is free. A positive value holds for every pose
    /// whose checked points are no further away than the value.
    pub(crate) fn room<M: Map>(&self, map: &M, pose: [f64; 3]) -> f64 {
        let center = map.clearance([pose[0], pose[1]]);
        if center >= self.circumscribed {
            return center - self.circumscribed;
        }
        if center.is_nan() {
            return f64::NEG_INFINITY;
        }
        let (sin, cos) = pose[2].sin_cos();
        let place = |o: [f64; 2]| {
            [
                pose[0] + cos * o[0] - sin * o[1],
                pose[1] + sin * o[0] + cos * o[1],
            ]
        };
        if !self.outline.is_empty() {
            let mut corners = [[0.0; 2]; 16];
            for (to, from) in corners.iter_mut().zip(&self.outline) {
                *to = place(*from);
            }
            if center > 0.0 && map.outline_is_free(&corners[..self.outline.len()]) == Some(true) {
                return 0.0;
            }
            // How much is missing until the turning circle is free: enough to order violated poses.
            return (center - self.circumscribed).min(-1e-6);
        }
        let mut least = f64::INFINITY;
        for &(o, need) in &self.circles {
            least = least.min(map.clearance(place(o)) - need);
        }
        if least.is_nan() {
            f64::NEG_INFINITY
        } else {
            least
        }
    }

    /// Drives `step` from `from` and says how much room is missing at its end (0 if none), or `None` if it collides.
    ///
    /// `missing` is how much is missing at `from`: the violation may only shrink on the way.
    pub(crate) fn sweep<M: Map>(
        &self,
        map: &M,
        from: [f64; 3],
        step: &Move,
        missing: f64,
    ) -> Option<f64> {
        let extent = step.extent();
        let rate = match step.motion {
            Motion::Turn => self.lever,
            _ => 1.0 + step.curvature.abs() * self.lever,
        };
        let mut missing = missing;
        let mut s = 0.0;
        let least = if rate > 0.0 {
            self.check_step / rate
        } else {
            f64::INFINITY
        };
        let mut room = if missing > 0.0 {
            0.0
        } else {
            self.room(map, from).max(0.0)
        };
        loop {
            // Even spacing over what is left, so that the last step is not a sliver.
            let left = extent - s;
            if left <= 0.0 {
                return Some(missing);
            }
            let jump = if rate > 0.0 {
                (room / rate).max(least)
            } else {
                f64::INFINITY
            };
            s = if left <= jump {
                extent
            } else {
                s + jump.max(left / (left / jump).ceil() * 0.999)
            };
            room = self.room(map, step.pose_at(from, s));
            if room >= 0.0 {
                missing = 0.0;
            } else if -room <= missing + 1e-8 {
                missing = -room;
                room = 0.0;
            } else {
                return None;
            }
        }
    }

    /// Whether every pose of the list is free and the gaps between are no wider than the list makes them.
    pub(crate) fn all_free<M: Map>(&self, map: &M, poses: &[[f64; 3]]) -> bool {
        let mut i = 0;
        while i < poses.len() {
            let room = self.room(map, poses[i]);
            if room < 0.0 {
                return false;
            }
            // Skip what the room covers.
            let here = poses[i];
            i += 1;
            while i < poses.len() {
                let p = poses[i];
                let moved = (p[0] - here[0]).hypot(p[1] - here[1])
                    + self.lever * crate::moves::wrap(p[2] - here[2]).abs();
                if moved > room {
                    break;
                }
                i += 1;
            }
        }
        true
    }
}

/// Corner and outward normal of each edge of a counter-clockwise polygon.
fn edges(corners: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    (0..corners.len()).map(|i| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        let d = [b[0] - a[0], b[1] - a[1]];
        let l = d[0].hypot(d[1]);
        (a, [d[1] / l, -d[0] / l])
    })
}

/// Moves every edge outwards by `margin`.
fn inflate(corners: &[[f64; 2]], margin: f64) -> Result<Vec<[f64; 2]>, Error> {
    let bad = Error::Footprint(
        "the outline must be convex, counter-clockwise, around the origin, of 3 to 16 finite corners",
    );
    if !(3..=16).contains(&corners.len()) || corners.iter().flatten().any(|v| !v.is_finite()) {
        return Err(bad);
    }
    let list: Vec<_> = edges(corners).collect();
    let n = list.len();
    let mut out = Vec::with_capacity(n);
    for i in 0..n {
        let ((a, p), (b, q)) = (list[(i + n - 1) % n], list[i]);
        // Corner i lies on edge i-1 and edge i.
        let det = p[0] * q[1] - p[1] * q[0];
        let (c, d) = (
            p[0] * a[0] + p[1] * a[1] + margin,
            q[0] * b[0] + q[1] * b[1] + margin,
        );
        if det.is_nan() || det < 1e-9 || d <= 0.0 {
            return Err(bad);
        }
        out.push([(c * q[1] - d * p[1]) / det, (p[0] * d - q[0] * c) / det]);
    }
    Ok(out)
}
