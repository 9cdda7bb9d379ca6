//! Reeds-Shepp curves: the shortest ways of a car that can reverse (Reeds and Shepp 1990).
//!
//! Their table has 48 words; mirrored in the start's axis, in time, and read backwards they come from eight formulas.
//! Lengths are in units of the radius, angles in (-pi, pi]; a negative length is driven backwards.

use crate::moves::{Motion, Move, wrap};
use crate::steer::{Way, end};
use std::f64::consts::{FRAC_PI_2, PI};

/// Side of a curve: left, straight, right.
type Side = f64;
const L: Side = 1.0;
const S: Side = 0.0;
const R: Side = -1.0;

/// Up to five pieces: side and signed length.
#[derive(Clone, Copy)]
struct Word {
    pieces: [(Side, f64); 5],
    count: usize,
}

fn word(pieces: &[(Side, f64)]) -> Word {
    let mut out = Word {
        pieces: [(S, 0.0); 5],
        count: pieces.len(),
    };
    out.pieces[..pieces.len()].copy_from_slice(pieces);
    out
}

const SLACK: f64 = -1e-10;

fn polar(x: f64, y: f64) -> (f64, f64) {
    (x.hypot(y), y.atan2(x))
}

/// The pair of angles that the four-arc formulas share.
fn tau_omega(u: f64, v: f64, xi: f64, eta: f64, phi: f64) -> (f64, f64) {
    let delta = wrap(u - v);
    let (a, b) = (u.sin() - delta.sin(), u.cos() - delta.cos() - 1.0);
    let t1 = (eta * a - xi * b).atan2(xi * a + eta * b);
    let t2 = 2.0 * (delta.cos() - v.cos() - u.cos()) + 3.0;
    let tau = wrap(if t2 < 0.0 { t1 + PI } else { t1 });
    (tau, wrap(tau - u + v - phi))
}

/// The eight formulas for a goal at (x, y, phi) seen from the start; `backwards` only those worth reading backwards.
fn formulas(x: f64, y: f64, phi: f64, backwards: bool, mut found: impl FnMut(Word)) {
    let (sin, cos) = phi.sin_cos();
    let (xi, eta) = (x - sin, y - 1.0 + cos);
    let (rho, theta) = polar(xi, eta);
    let (xr, er) = (x + sin, y - 1.0 - cos);
    let (rr, tr) = polar(xr, er);
    if !backwards {
        // L+ S+ L+
        let v = wrap(phi - theta);
        if theta >= SLACK && v >= SLACK {
            found(word(&[(L, theta), (S, rho), (L, v)]));
        }
        // L+ S+ R+
        if rr >= 2.0 {
            let u = (rr * rr - 4.0).max(0.0).sqrt();
            let t = wrap(tr + 2f64.atan2(u));
            let v = wrap(t - phi);
            if t >= SLACK && v >= SLACK {
                found(word(&[(L, t), (S, u), (R, v)]));
            }
        }
        // L+ R+ L- R-
        let c = 0.25 * (2.0 + rr);
        if c <= 1.0 {
            let u = c.acos();
            let (t, v) = tau_omega(u, -u, xr, er, phi);
            if t >= SLACK && v <= -SLACK {
                found(word(&[(L, t), (R, u), (L, -u), (R, v)]));
            }
        }
        // L+ R- L- R+
        let c = (20.0 - rr * rr) / 16.0;
        if (0.0..=1.0).contains(&c) {
            let u = -c.acos();
            if u >= -FRAC_PI_2 {
                let (t, v) = tau_omega(u, u, xr, er, phi);
                if t >= SLACK && v >= SLACK {
                    found(word(&[(L, t), (R, u), (L, u), (R, v)]));
                }
            }
        }
        // L+ R- S- L- R+
        if rr >= 2.0 {
            let u = 4.0 - (rr * rr - 4.0).max(0.0).sqrt();
            if u <= -SLACK {
                let t = wrap(((4.0 - u) * xr - 2.0 * er).atan2(-2.0 * xr + (u - 4.0) * er));
                let v = wrap(t - phi);
                if t >= SLACK && v >= SLACK {
                    let q = -FRAC_PI_2;
                    found(word(&[(L, t), (R, q), (S, u), (L, q), (R, v)]));
                }
            }
        }
    }
    // L+ R- L+-
    if rho <= 4.0 {
        let u = -2.0 * (0.25 * rho).asin();
        let t = wrap(theta + 0.5 * u + PI);
        let v = wrap(phi - t + u);
        if t >= SLACK && u <= -SLACK {
            found(word(&[(L, t), (R, u), (L, v)]));
        }
    }
    // L+ R- S- L-
    if rho >= 2.0 {
        let r = (rho * rho - 4.0).max(0.0).sqrt();
        let u = 2.0 - r;
        let t = wrap(theta + r.atan2(-2.0));
        let v = wrap(phi - FRAC_PI_2 - t);
        if t >= SLACK && u <= -SLACK && v <= -SLACK {
            found(word(&[(L, t), (R, -FRAC_PI_2), (S, u), (L, v)]));
        }
    }
    // L+ R- S- R-
    let (rho, theta) = polar(-er, xr);
    if rho >= 2.0 {
        let u = 2.0 - rho;
        let v = wrap(theta + FRAC_PI_2 - phi);
        if theta >= SLACK && u <= -SLACK && v <= -SLACK {
            found(word(&[(L, theta), (R, -FRAC_PI_2), (S, u), (R, v)]));
        }
    }
}

/// Every Reeds-Shepp curve of `radius` m from one pose to another; none is left out that could be the shortest.
pub(crate) fn curves(from: [f64; 3], to: [f64; 3], radius: f64, mut found: impl FnMut(Way)) {
    let (sin, cos) = from[2].sin_cos();
    let (dx, dy) = ((to[0] - from[0]) / radius, (to[1] - from[1]) / radius);
    let (x, y, phi) = (
        cos * dx + sin * dy,
        cos * dy - sin * dx,
        wrap(to[2] - from[2]),
    );
    // The same question asked from the goal back.
    let (xb, yb) = (x * phi.cos() + y * phi.sin(), x * phi.sin() - y * phi.cos());
    for (x, y, backwards) in [(x, y, false), (xb, yb, true)] {
        for time in [1.0, -1.0] {
            for side in [1.0, -1.0] {
                formulas(time * x, side * y, time * side * phi, backwards, |w| {
                    let mut way = Way::with_capacity(w.count);
                    let pieces = &w.pieces[..w.count];
                    let mut add = |&(s, length): &(Side, f64)| {
                        let length = time * length;
                        if length.abs() > 1e-9 {
                            let (motion, sign) = if length > 0.0 {
                                (Motion::Forward, 1.0)
                            } else {
                                (Motion::Reverse, -1.0)
                            };
                            // Steered left, a car that backs turns to the right.
                            let curvature = sign * side * s / radius;
                            way.push(Move::drive(motion, length.abs() * radius, curvature));
                        }
                    };
                    if backwards {
                        pieces.iter().rev().for_each(&mut add);
                    } else {
                        pieces.iter().for_each(&mut add);
                    }
                    // Rounding next to the limits of a formula.
                    let reached = end(from, &way);
                    let off = (reached[0] - to[0]).hypot(reached[1] - to[1]);
                    if off < 1e-6 * radius.max(1.0) && wrap(reached[2] - to[2]).abs() < 1e-6 {
                        found(way);
                    }
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shortest(from: [f64; 3], to: [f64; 3], radius: f64) -> f64 {
        let mut best = f64::INFINITY;
        curves(from, to, radius, |way| {
            best = best.min(way.iter().map(Move::extent).sum());
        });
        best
    }

    #[test]
    fn known_lengths() {
        let zero = [0.0; 3];
        // Straight ahead and back; a half turn on the spot takes three quarter... of the classic three-point turn: pi.
        assert!((shortest(zero, [3.0, 0.0, 0.0], 1.0) - 3.0).abs() < 1e-9);
        assert!((shortest(zero, [-3.0, 0.0, 0.0], 1.0) - 3.0).abs() < 1e-9);
        assert!((shortest(zero, [0.0, 0.0, PI], 1.0) - PI).abs() < 1e-9);
        assert!((shortest(zero, [0.0, 4.0, PI], 2.0) - 2.0 * PI).abs() < 1e-9);
    }

    #[test]
    fn lengths_are_symmetric_and_scale_and_never_missing() {
        let mut seed = 1u64;
        let mut unit = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        for _ in 0..3000 {
            let mut pose = || {
                [
                    8.0 * unit() - 4.0,
                    8.0 * unit() - 4.0,
                    2.0 * PI * unit() - PI,
                ]
            };
            let (a, b) = (pose(), pose());
            let d = shortest(a, b, 1.0);
            assert!(d.is_finite() && d >= (a[0] - b[0]).hypot(a[1] - b[1]) - 1e-9);
            assert!((d - shortest(b, a, 1.0)).abs() < 1e-6, "{a:?} {b:?}");
            let double = |p: [f64; 3]| [2.0 * p[0], 2.0 * p[1], p[2]];
            assert!((2.0 * d - shortest(double(a), double(b), 2.0)).abs() < 1e-6);
            // No Dubins curve is shorter.
            crate::steer::dubins(a, b, 1.0, Motion::Forward, |way| {
                assert!(way.iter().map(Move::extent).sum::<f64>() >= d - 1e-9);
            });
        }
    }
}
