//! From moves to sampled segments, with curvature ramped where there is room.

use crate::body::Body;
use crate::moves::{Motion, Move};
use crate::{Limits, Map};

/// One stretch of a plan between two stops.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// What the base does in it.
    pub motion: Motion,
    /// Poses [x, y, yaw] along it, world frame, m and rad; the first is the last of the segment before. Yaw runs on
    /// without jumps of a full turn. No two are further apart than a few centimetres or degrees.
    pub poses: Vec<[f64; 3]>,
}

impl Segment {
    /// Metres driven.
    pub fn length(&self) -> f64 {
        self.poses
            .windows(2)
            .map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]))
            .sum()
    }

    /// Radians turned, both ways added.
    pub fn turned(&self) -> f64 {
        self.poses
            .windows(2)
            .map(|w| (w[1][2] - w[0][2]).abs())
            .sum()
    }
}

/// Spacing of samples along a drive, m, and in a turn, rad.
const SPACING: f64 = 0.04;
const TURN_SPACING: f64 = 0.05;

/// Samples the moves, one segment for each run of one motion.
pub(crate) fn segments<M: Map>(
    map: &M,
    body: &Body,
    limits: &Limits,
    start: [f64; 3],
    moves: &[Move],
    soften: bool,
) -> Vec<Segment> {
    let mut out = Vec::new();
    let mut from = start;
    let mut i = 0;
    while i < moves.len() {
        let motion = moves[i].motion;
        let mut j = i;
        while j < moves.len() && moves[j].motion == motion {
            j += 1;
        }
        let run = &moves[i..j];
        let mut poses = sample(from, run);
        if motion != Motion::Turn && soften && limits.alpha.is_finite() && run.len() > 1 {
            // At full speed the turning rate of the tightest curve needs this far to build up.
            let ramp = limits.w * limits.v / limits.alpha;
            let spacing =
                run.iter().map(Move::extent).sum::<f64>() / (poses.len() - 1).max(1) as f64;
            for share in [1.0, 0.5, 0.25] {
                let half = (0.5 * share * ramp / spacing).round() as usize;
                let soft = ramped(&poses, half);
                if half > 0 && body.all_free(map, &soft) {
                    poses = soft;
                    break;
                }
            }
        }
        from = *poses.last().unwrap_or(&from);
        out.push(Segment { motion, poses });
        i = j;
    }
    out
}

/// Poses at equal distances along a run of one motion.
fn sample(start: [f64; 3], run: &[Move]) -> Vec<[f64; 3]> {
    let total: f64 = run.iter().map(Move::extent).sum();
    let spacing = if run[0].motion == Motion::Turn {
        TURN_SPACING
    } else {
        SPACING
    };
    let n = (total / spacing).ceil().max(1.0) as usize;
    let mut poses = vec![start];
    let (mut from, mut k, mut before) = (start, 0, 0.0);
    for i in 1..=n {
        let s = total * i as f64 / n as f64;
        while k + 1 < run.len() && s > before + run[k].extent() {
            before += run[k].extent();
            from = run[k].end(from);
            k += 1;
        }
        poses.push(run[k].pose_at(from, (s - before).min(run[k].extent())));
    }
    poses
}

/// Averages positions over a sliding window of `2 half + 1` samples that narrows to nothing at the ends: a jump in
/// curvature becomes a ramp as long as the window. End poses stay.
fn ramped(poses: &[[f64; 3]], half: usize) -> Vec<[f64; 3]> {
    let n = poses.len();
    let mut sums = vec![[0.0; 2]; n + 1];
    for (i, p) in poses.iter().enumerate() {
        sums[i + 1] = [sums[i][0] + p[0], sums[i][1] + p[1]];
    }
    let mut out = poses.to_vec();
    for i in 1..n.saturating_sub(1) {
        let k = half.min(i).min(n - 1 - i);
        for axis in 0..2 {
            out[i][axis] = (sums[i + k + 1][axis] - sums[i - k][axis]) / (2 * k + 1) as f64;
        }
    }
    for i in 1..n.saturating_sub(1) {
        // The heading follows the new tangent; its offset from the old tangent tells the direction of travel.
        let tangent = |p: &[[f64; 3]]| (p[i + 1][1] - p[i - 1][1]).atan2(p[i + 1][0] - p[i - 1][0]);
        out[i][2] = poses[i][2] + crate::moves::wrap(tangent(&out) - tangent(poses));
    }
    out
}
