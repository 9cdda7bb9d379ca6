//! The footprint against the map: single poses and whole motions.

use crate::moves::{Motion, Move};
use crate::outline::{cover, edges, inflate, placed, shrinkable, shrunk};
use crate::{Error, Map, Robot};

/// The footprint with its margin, ready for checks.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    /// Circle centres in the base frame and the clearance each needs, m.
    circles: Vec<([f64; 2], f64)>,
    outline: Vec<[f64; 2]>,
    /// Circles that cover the outline: much cheaper to test, and often enough.
    cover: Vec<([f64; 2], f64)>,
    /// Radius of the largest disc about the origin inside the footprint, margin included, m.
    pub(crate) inscribed: f64,
    /// Radius of the smallest disc about the origin that holds the footprint, margin included, m.
    pub(crate) circumscribed: f64,
    /// Distance of the checked point that turning moves most, m.
    lever: f64,
    check_step: f64,
    margin: f64,
    /// Deepest violation allowed on the way out of a start in violation, m; see [`Body::begin`].
    leave: f64,
    /// How far the outline can shrink before it loses an edge, m.
    shrink: f64,
}

/// A motion that was driven without collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Swept {
    /// How much room is missing at its end, m; 0 if none.
    pub(crate) missing: f64,
    /// Share of the motion spent with room missing.
    pub(crate) share: f64,
    /// Room at its end, m.
    pub(crate) room: f64,
}

/// How much deeper into a violation the way out may go where the margin leaves no room for it, m. A body that
/// stands along a wall must swing its tail towards it to get away.
pub(crate) const SWING: f64 = 0.01;
/// Checks on the way out are this many times denser, because nothing is left of the margin to cover the gaps.
const DENSER: f64 = 4.0;

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
            inscribed,
            circumscribed,
            lever,
            check_step,
            margin,
            leave: 0.0,
            shrink: shrinkable(&outline),
            cover: cover(&outline),
            outline,
        })
    }

    /// Corners with the margin, counter-clockwise in the base frame, m; empty if circles decide.
    pub(crate) fn outline(&self) -> &[[f64; 2]] {
        &self.outline
    }

    /// Circle centres in the base frame and the clearance each needs, m.
    pub(crate) fn circles(&self) -> &[([f64; 2], f64)] {
        &self.circles
    }

    /// Says how much room is missing at the start, m. On the way out the violation may go deeper by a centimetre, or
    /// up to where the footprint itself (without the margin) touches, if that is more.
    pub(crate) fn begin(&mut self, missing: f64) {
        let bare = self.margin - 0.5 * self.check_step / DENSER;
        self.leave = if missing > 0.0 {
            (missing + SWING).max(bare)
        } else {
            0.0
        };
    }

    /// How much room is missing at the pose, m; 0 if it is free. For an outline the depth to which it must shrink.
    pub(crate) fn depth<M: Map>(&self, map: &M, pose: [f64; 3]) -> f64 {
        let room = self.room(map, pose);
        if room >= 0.0 {
            return 0.0;
        }
        if self.outline.is_empty() || room == f64::NEG_INFINITY {
            return -room;
        }
        let free = |by: f64| {
            let corners = shrunk(&self.outline, by).map(|o| placed(pose, o));
            map.outline_is_free(&corners[..self.outline.len()]) == Some(true)
        };
        let (mut low, mut high) = (0.0, self.shrink);
        if map.clearance([pose[0], pose[1]]) <= 0.0 || !free(high) {
            return f64::INFINITY;
        }
        // To a tenth of a millimetre, ending on the safe side.
        for _ in 0..13 {
            let middle = 0.5 * (low + high);
            if free(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    }

    /// Where the footprint at the pose overlaps an obstacle most, world frame, m: the place nearest to it by the map.
    pub(crate) fn worst_place<M: Map>(&self, map: &M, pose: [f64; 3]) -> [f64; 2] {
        let mut best = (f64::INFINITY, [pose[0], pose[1]]);
        let mut look = |o: [f64; 2]| {
            let p = placed(pose, o);
            let c = map.clearance(p);
            let c = if c.is_nan() { f64::NEG_INFINITY } else { c };
            if c < best.0 {
                best = (c, p);
            }
        };
        if self.outline.is_empty() {
            for &(o, r) in &self.circles {
                look(o);
                for k in 0..12 {
                    let (s, c) = (f64::from(k) * std::f64::consts::TAU / 12.0).sin_cos();
                    look([o[0] + r * c, o[1] + r * s]);
                }
            }
        } else {
            let n = self.outline.len();
            for i in 0..n {
                let (a, b) = (self.outline[i], self.outline[(i + 1) % n]);
                // Rings from the outline inwards, so that an obstacle inside is found, too.
                for ring in 0..4 {
                    let f = 1.0 - 0.25 * f64::from(ring);
                    for k in 0..8 {
                        let t = f64::from(k) / 8.0;
                        look([
                            f * (a[0] + t * (b[0] - a[0])),
                            f * (a[1] + t * (b[1] - a[1])),
                        ]);
                    }
                }
            }
            look([0.0; 2]);
        }
        best.1
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
            let mut least = f64::INFINITY;
            for &(o, need) in &self.cover {
                least = least.min(map.clearance(place(o)) - need);
                // NaN is not free, either.
                if least.is_nan() || least < 0.0 {
                    break;
                }
            }
            if least >= 0.0 && least.is_finite() {
                return least;
            }
            let mut corners = [[0.0; 2]; 16];
            for (to, from) in corners.iter_mut().zip(&self.outline) {
                *to = place(*from);
            }
            if center > 0.0 && map.outline_is_free(&corners[..self.outline.len()]) == Some(true) {
                return 0.0;
            }
            // How deep it is takes [`depth`](Self::depth) longer to say.
            return -1e-6;
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

    /// Drives `step` from `from`, or says `None` if it collides.
    ///
    /// `missing` is how much room is missing at `from`. Until a pose is free the violation may be as deep as
    /// [`begin`](Self::begin) allowed; from then on none is. `room` is the room at `from` if it is known.
    pub(crate) fn sweep<M: Map>(
        &self,
        map: &M,
        from: [f64; 3],
        step: &Move,
        missing: f64,
        room: Option<f64>,
    ) -> Option<Swept> {
        let extent = step.extent();
        let rate = match step.motion {
            Motion::Turn => self.lever,
            _ => 1.0 + step.curvature.abs() * self.lever,
        };
        if missing > 0.0 {
            return self.leave_by(map, from, step, missing, rate);
        }
        // Most motions that collide do so at their end.
        let end = self.room(map, step.pose_at(from, extent));
        if end < 0.0 {
            return None;
        }
        let begin = match room {
            Some(room) => room,
            None => self.room(map, from),
        };
        let free = self.between(map, from, step, rate, [0.0, extent], [begin.max(0.0), end]);
        free.then_some(Swept {
            missing: 0.0,
            share: 0.0,
            room: end,
        })
    }

    /// Whether the part of a motion between two free poses is free: either their room covers it but for less than
    /// one check step, or the pose in its middle is free and both halves are.
    fn between<M: Map>(
        &self,
        map: &M,
        from: [f64; 3],
        step: &Move,
        rate: f64,
        [a, b]: [f64; 2],
        [room_a, room_b]: [f64; 2],
    ) -> bool {
        if (b - a) * rate <= room_a + room_b + self.check_step {
            return true;
        }
        // The middle of what is not covered.
        let middle = 0.5 * (a + b) + 0.5 * (room_a - room_b) / rate;
        let room = self.room(map, step.pose_at(from, middle));
        room >= 0.0
            && self.between(map, from, step, rate, [a, middle], [room_a, room])
            && self.between(map, from, step, rate, [middle, b], [room, room_b])
    }

    /// [`sweep`](Self::sweep) from a pose in violation, in steps from its beginning to its end.
    fn leave_by<M: Map>(
        &self,
        map: &M,
        from: [f64; 3],
        step: &Move,
        missing: f64,
        rate: f64,
    ) -> Option<Swept> {
        let extent = step.extent();
        let mut missing = missing;
        let (mut s, mut troubled) = (0.0, 0.0);
        let least = if rate > 0.0 {
            self.check_step / rate
        } else {
            f64::INFINITY
        };
        let mut room = 0.0f64;
        loop {
            // Even spacing over what is left, so that the last step is not a sliver.
            let left = extent - s;
            if left <= 0.0 {
                let share = if extent > 0.0 { troubled / extent } else { 0.0 };
                return Some(Swept {
                    missing,
                    share,
                    room,
                });
            }
            let jump = if rate <= 0.0 {
                f64::INFINITY
            } else if missing > 0.0 {
                least / DENSER
            } else {
                (room / rate).max(least)
            };
            let before = s;
            s = if left <= jump {
                extent
            } else {
                s + jump.max(left / (left / jump).ceil() * 0.999)
            };
            let pose = step.pose_at(from, s);
            room = self.room(map, pose);
            if room >= 0.0 {
                missing = 0.0;
            } else if missing > 0.0 {
                missing = self.depth(map, pose);
                if missing > self.leave {
                    return None;
                }
                troubled += s - before;
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
