//! Ways between two poses that ignore obstacles: rotate-line-rotate, arc-line, and Dubins curves.

use crate::moves::{Motion, Move, wrap};
use std::f64::consts::{PI, TAU};

/// Up to five moves.
pub(crate) type Way = Vec<Move>;

const SMALL: f64 = 1e-9;

fn push_turn(way: &mut Way, angle: f64) {
    if angle.abs() > SMALL {
        way.push(Move::turn(angle));
    }
}

/// Turn to face (or turn the back on) the point, drive straight, turn by what `settle` makes of the arrival heading.
pub(crate) fn rotate_line(
    from: [f64; 3],
    to: [f64; 2],
    motion: Motion,
    settle: impl Fn(f64) -> f64,
) -> Way {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = dx.hypot(dy);
    let mut way = Way::with_capacity(3);
    let mut yaw = from[2];
    if length > SMALL {
        let back = if motion == Motion::Reverse { PI } else { 0.0 };
        let turn = wrap(dy.atan2(dx) + back - yaw);
        push_turn(&mut way, turn);
        yaw += turn;
        way.push(Move::drive(motion, length, 0.0));
    }
    push_turn(&mut way, settle(yaw) - yaw);
    way
}

/// One arc of radius `r` to the side given (+1 left, -1 right), then a straight line to the point.
pub(crate) fn arc_line(
    from: [f64; 3],
    to: [f64; 2],
    r: f64,
    side: f64,
    motion: Motion,
) -> Option<Way> {
    // Driving backwards is driving forwards with the front and back exchanged.
    let yaw = if motion == Motion::Reverse {
        from[2] + PI
    } else {
        from[2]
    };
    let (sin, cos) = yaw.sin_cos();
    let center = [from[0] - side * r * sin, from[1] + side * r * cos];
    let (dx, dy) = (to[0] - center[0], to[1] - center[1]);
    let line = (dx * dx + dy * dy - r * r).max(-1.0);
    if line < 0.0 {
        return None;
    }
    let line = line.sqrt();
    let tangent = dy.atan2(dx) + side * r.atan2(line);
    let mut angle = (side * (tangent - yaw)).rem_euclid(TAU);
    if angle > TAU - 1e-7 {
        angle = 0.0;
    }
    // Going round the long way is never what is wanted.
    if angle > 1.25 * PI {
        return None;
    }
    let mut way = Way::with_capacity(2);
    push_drive(&mut way, motion, angle * r, side / r);
    push_drive(&mut way, motion, line, 0.0);
    Some(way)
}

/// The one arc from the pose to the point; its curvature (left positive) and length. `None` for a point behind.
pub(crate) fn single_arc(from: [f64; 3], to: [f64; 2], motion: Motion) -> Option<Move> {
    let yaw = if motion == Motion::Reverse {
        from[2] + PI
    } else {
        from[2]
    };
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let chord = dx.hypot(dy);
    let bearing = wrap(dy.atan2(dx) - yaw);
    if chord < SMALL || bearing.abs() > 0.5 * PI {
        return None;
    }
    let curvature = 2.0 * bearing.sin() / chord;
    let length = if bearing.abs() < 1e-7 {
        chord
    } else {
        chord * bearing / bearing.sin()
    };
    Some(Move::drive(motion, length, curvature))
}

fn push_drive(way: &mut Way, motion: Motion, length: f64, curvature: f64) {
    if length > SMALL {
        way.push(Move::drive(motion, length, curvature));
    }
}

/// Curves between two poses for the base: Dubins curves of every radius, and for a car that reverses the Reeds-Shepp
/// curves of the smallest.
pub(crate) fn between(
    from: [f64; 3],
    to: [f64; 3],
    radii: &[f64; 3],
    drive: crate::Drive,
    list: &mut Vec<Way>,
) {
    for &r in radii {
        dubins(from, to, r, Motion::Forward, |way| list.push(way));
    }
    if let crate::Drive::ReedsShepp { radius } = drive {
        crate::reeds_shepp::curves(from, to, radius, |way| list.push(way));
    }
}

/// The Dubins curves arc-line-arc of radius `r`, driven in the given direction; those with loops are left out.
pub(crate) fn dubins(
    from: [f64; 3],
    to: [f64; 3],
    r: f64,
    motion: Motion,
    mut found: impl FnMut(Way),
) {
    let flip = if motion == Motion::Reverse { PI } else { 0.0 };
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let d = dx.hypot(dy) / r;
    let bearing = dy.atan2(dx);
    let (a, b) = (from[2] + flip - bearing, to[2] + flip - bearing);
    let ((sa, ca), (sb, cb)) = (a.sin_cos(), b.sin_cos());
    let angle = |x: f64| {
        let w = x.rem_euclid(TAU);
        if w > TAU - 1e-7 { 0.0 } else { w }
    };
    let cab = (a - b).cos();
    // (first side, last side, squared line, first angle, last angle)
    let words = [
        {
            let p2 = 2.0 + d * d - 2.0 * cab + 2.0 * d * (sa - sb);
            let t = (cb - ca).atan2(d + sa - sb);
            (1.0, 1.0, p2, t - a, b - t)
        },
        {
            let p2 = 2.0 + d * d - 2.0 * cab + 2.0 * d * (sb - sa);
            let t = (ca - cb).atan2(d - sa + sb);
            (-1.0, -1.0, p2, a - t, t - b)
        },
        {
            let p2 = -2.0 + d * d + 2.0 * cab + 2.0 * d * (sa + sb);
            let t = (-ca - cb).atan2(d + sa + sb) - (-2f64).atan2(p2.max(0.0).sqrt());
            (1.0, -1.0, p2, t - a, t - b)
        },
        {
            let p2 = -2.0 + d * d + 2.0 * cab - 2.0 * d * (sa + sb);
            let t = (ca + cb).atan2(d - sa - sb) - 2f64.atan2(p2.max(0.0).sqrt());
            (-1.0, 1.0, p2, a - t, b - t)
        },
    ];
    for (first, last, p2, t, q) in words {
        if p2 < 0.0 {
            continue;
        }
        let (t, q) = (angle(t), angle(q));
        if t > 1.25 * PI || q > 1.25 * PI {
            continue;
        }
        let mut way = Way::with_capacity(3);
        push_drive(&mut way, motion, t * r, first / r);
        push_drive(&mut way, motion, p2.sqrt() * r, 0.0);
        push_drive(&mut way, motion, q * r, last / r);
        found(way);
    }
}

/// Pose after all moves.
pub(crate) fn end(from: [f64; 3], way: &[Move]) -> [f64; 3] {
    way.iter().fold(from, |p, m| m.end(p))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_way_ends_where_it_should() {
        let poses = [
            [0.0, 0.0, 0.3],
            [2.0, 1.0, -2.0],
            [0.4, -0.3, 3.0],
            [-1.5, 0.2, 1.0],
            [0.5, 0.0, 0.3],
        ];
        for from in poses {
            for to in poses {
                for motion in [Motion::Forward, Motion::Reverse] {
                    dubins(from, to, 0.5, motion, |way| {
                        let e = end(from, &way);
                        assert!(
                            (e[0] - to[0]).hypot(e[1] - to[1]) < 1e-6,
                            "{from:?} {to:?} {way:?}"
                        );
                        assert!(wrap(e[2] - to[2]).abs() < 1e-6);
                    });
                    for side in [-1.0, 1.0] {
                        if let Some(way) = arc_line(from, [to[0], to[1]], 0.5, side, motion) {
                            let e = end(from, &way);
                            assert!((e[0] - to[0]).hypot(e[1] - to[1]) < 1e-6);
                        }
                    }
                    if let Some(arc) = single_arc(from, [to[0], to[1]], motion) {
                        let e = arc.end(from);
                        assert!((e[0] - to[0]).hypot(e[1] - to[1]) < 1e-6);
                    }
                    let e = end(from, &rotate_line(from, [to[0], to[1]], motion, |_| to[2]));
                    assert!(
                        (e[0] - to[0]).hypot(e[1] - to[1]) < 1e-9
                            && wrap(e[2] - to[2]).abs() < 1e-9
                    );
                }
            }
        }
    }
}
