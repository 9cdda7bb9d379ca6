//! Trapezoid speed profiles and equal-time poses.

use crate::error::positive;
use crate::moves::Motion;
use crate::trace::Segment;
use crate::{Error, Limits};

/// A path sampled at equal times.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct TimedPath {
    /// Poses [x, y, yaw] at times 0, dt, 2 dt, ...; the last is the end of the path. Yaw runs on without jumps.
    pub poses: Vec<[f64; 3]>,
    /// Time between poses, s.
    pub dt: f64,
    /// What the base does between pose k and k + 1: one fewer than `poses`.
    pub motions: Vec<Motion>,
    /// Signed speed along x at each pose, m/s.
    pub v: Vec<f64>,
    /// Turning rate at each pose, rad/s.
    pub w: Vec<f64>,
}

impl TimedPath {
    /// Duration, s.
    pub fn seconds(&self) -> f64 {
        self.dt * self.motions.len() as f64
    }

    /// Pose at time `t` s: linear between the samples, held before the start and after the end. `None` if the path
    /// is empty or `t` is NaN.
    pub fn at(&self, t: f64) -> Option<[f64; 3]> {
        let last = self.poses.len().checked_sub(1)?;
        if t.is_nan() {
            return None;
        }
        let u = (t / self.dt).clamp(0.0, last as f64);
        let k = (u.floor() as usize).min(last.saturating_sub(1));
        let (a, b) = (self.poses[k], self.poses[(k + 1).min(last)]);
        let f = u - k as f64;
        Some([
            a[0] + f * (b[0] - a[0]),
            a[1] + f * (b[1] - a[1]),
            a[2] + f * (b[2] - a[2]),
        ])
    }
}

/// One interval of the profile: constant acceleration between two poses.
struct Interval {
    from: [f64; 3],
    to: [f64; 3],
    /// Extent (m, or rad in a turn) and speeds at its ends.
    extent: f64,
    v0: f64,
    v1: f64,
    start: f64,
    motion: Motion,
}

impl Interval {
    fn seconds(&self) -> f64 {
        if self.extent <= 0.0 {
            0.0
        } else {
            2.0 * self.extent / (self.v0 + self.v1)
        }
    }
}

/// Times the segments: rest at the end and at every change of motion, `speed` m/s at the start if that is a drive.
pub(crate) fn profile(
    segments: &[Segment],
    limits: &Limits,
    dt: f64,
    speed: f64,
) -> Result<TimedPath, Error> {
    limits.validate()?;
    positive("dt", dt)?;
    if !speed.is_finite() {
        return Err(Error::Param {
            field: "initial speed",
            value: speed,
            must: "finite",
        });
    }
    let mut intervals: Vec<Interval> = Vec::new();
    let mut clock = 0.0;
    for (k, segment) in segments.iter().enumerate() {
        let entry = match segment.motion {
            Motion::Forward if k == 0 => speed.max(0.0),
            Motion::Reverse if k == 0 => (-speed).max(0.0),
            _ => 0.0,
        };
        for mut interval in speeds(segment, limits, entry) {
            interval.start = clock;
            clock += interval.seconds();
            intervals.push(interval);
        }
    }
    let first = segments.iter().find_map(|s| s.poses.first());
    let Some(&first) = first else {
        return Ok(TimedPath {
            dt,
            ..TimedPath::default()
        });
    };
    let steps = (clock / dt - 1e-9).ceil().max(0.0);
    if steps > 1e7 {
        return Err(Error::Param {
            field: "dt",
            value: dt,
            must: "at least a ten-millionth of the path's duration",
        });
    }
    let steps = steps as usize;
    // Slower by less than one dt over the whole path, so that it ends on a sample.
    let pace = if steps > 0 {
        clock / (steps as f64 * dt)
    } else {
        1.0
    };
    let mut out = TimedPath {
        dt,
        poses: vec![first],
        ..TimedPath::default()
    };
    let mut k = 0;
    let rates = |t: f64, k: &mut usize| -> ([f64; 3], f64, f64) {
        while *k + 1 < intervals.len() && intervals[*k + 1].start <= t {
            *k += 1;
        }
        let i = &intervals[*k];
        let (span, s) = (i.seconds(), (t - i.start).max(0.0));
        let rate = if span > 0.0 {
            (i.v1 - i.v0) / span
        } else {
            0.0
        };
        let f = if i.extent > 0.0 {
            ((i.v0 * s + 0.5 * rate * s * s) / i.extent).clamp(0.0, 1.0)
        } else {
            1.0
        };
        let turn = i.to[2] - i.from[2];
        let pose = [
            i.from[0] + f * (i.to[0] - i.from[0]),
            i.from[1] + f * (i.to[1] - i.from[1]),
            i.from[2] + f * turn,
        ];
        let v = (i.v0 + rate * s.min(span)) * pace;
        match i.motion {
            Motion::Turn => (pose, 0.0, v * turn.signum()),
            Motion::Forward => (pose, v, v * turn / i.extent.max(1e-12)),
            Motion::Reverse => (pose, -v, v * turn / i.extent.max(1e-12)),
        }
    };
    if intervals.is_empty() {
        out.v.push(0.0);
        out.w.push(0.0);
        return Ok(out);
    }
    let (_, v, w) = rates(0.0, &mut k);
    out.v.push(v);
    out.w.push(w);
    for step in 1..=steps {
        let mut middle = k;
        let motion = {
            let t = (step as f64 - 0.5) * dt * pace;
            rates(t, &mut middle);
            intervals[middle].motion
        };
        let (pose, v, w) = rates(step as f64 * dt * pace, &mut k);
        out.motions.push(motion);
        out.poses.push(pose);
        out.v.push(v);
        out.w.push(w);
    }
    if let (Some(last), Some(to)) = (out.poses.last_mut(), intervals.last().map(|i| i.to)) {
        *last = to;
        if limits.a.is_finite()
            && let (Some(v), Some(w)) = (out.v.last_mut(), out.w.last_mut())
        {
            (*v, *w) = (0.0, 0.0);
        }
    }
    Ok(out)
}

/// Duration of the profile from rest to rest, s.
pub(crate) fn seconds(segments: &[Segment], limits: &Limits) -> f64 {
    segments
        .iter()
        .flat_map(|s| speeds(s, limits, 0.0))
        .map(|i| i.seconds())
        .sum()
}

/// Forward and backward pass over one segment.
fn speeds(segment: &Segment, limits: &Limits, entry: f64) -> Vec<Interval> {
    let turn = segment.motion == Motion::Turn;
    let (top, accel) = if turn {
        (limits.w, limits.alpha)
    } else {
        (limits.v, limits.a)
    };
    let mut list: Vec<Interval> = Vec::with_capacity(segment.poses.len());
    let mut bend: Vec<f64> = Vec::with_capacity(segment.poses.len());
    for w in segment.poses.windows(2) {
        let (from, to) = (w[0], w[1]);
        let extent = if turn {
            (to[2] - from[2]).abs()
        } else {
            (to[0] - from[0]).hypot(to[1] - from[1])
        };
        if extent > 1e-12 {
            // From rest to rest within one interval there is no speed between: at least two are needed.
            let pieces = if segment.poses.len() == 2 {
                (extent / 0.05).ceil().max(2.0)
            } else {
                1.0
            };
            // The end is `to` itself, not what adding the difference makes of it.
            let at = |i: f64| {
                if i < pieces {
                    [0, 1, 2].map(|a| from[a] + (to[a] - from[a]) * (i / pieces))
                } else {
                    to
                }
            };
            for i in 0..pieces as usize {
                list.push(Interval {
                    from: at(i as f64),
                    to: at(i as f64 + 1.0),
                    extent: extent / pieces,
                    v0: 0.0,
                    v1: 0.0,
                    start: 0.0,
                    motion: segment.motion,
                });
                bend.push(if turn {
                    0.0
                } else {
                    (to[2] - from[2]) / extent
                });
            }
        }
    }
    let n = list.len();
    if n == 0 {
        return list;
    }
    // Change of curvature at each node, per metre; known to no better than a tenth of a metre.
    let sharp: Vec<f64> = (0..=n)
        .map(|i| {
            if i == 0 || i == n {
                return 0.0;
            }
            (bend[i] - bend[i - 1]).abs() / (0.5 * (list[i].extent + list[i - 1].extent))
        })
        .collect();
    let cap: Vec<f64> = (0..=n)
        .map(|i| {
            let k = bend[i.saturating_sub(1)]
                .abs()
                .max(bend[i.min(n - 1)].abs());
            let mut v = top;
            if k * top > limits.w {
                v = limits.w / k;
            }
            if limits.alpha.is_finite() && sharp[i] * v * v > limits.alpha {
                v = (limits.alpha / sharp[i]).sqrt();
            }
            v
        })
        .collect();
    if accel.is_infinite() {
        for (i, interval) in list.iter_mut().enumerate() {
            (interval.v0, interval.v1) = (cap[i], cap[i + 1]);
        }
        return list;
    }
    // Speeding up on a curve turns faster, too.
    let gain = |i: usize| {
        if limits.alpha.is_finite() && bend[i].abs() * accel > limits.alpha {
            limits.alpha / bend[i].abs()
        } else {
            accel
        }
    };
    let mut v = cap;
    v[0] = entry.min(v[0]);
    v[n] = 0.0;
    for i in 0..n {
        v[i + 1] = v[i + 1].min((v[i] * v[i] + 2.0 * gain(i) * list[i].extent).sqrt());
    }
    for i in (0..n).rev() {
        v[i] = v[i].min((v[i + 1] * v[i + 1] + 2.0 * gain(i) * list[i].extent).sqrt());
    }
    for (i, interval) in list.iter_mut().enumerate() {
        (interval.v0, interval.v1) = (v[i], v[i + 1]);
    }
    list
}
