//! Circles that cover a rectangle and stick out by little.

/// How much of what would just do is used, so that circles overlap.
const SHARE: f64 = 0.97;

/// Circles that together contain the rectangle of half length and half width `half` about the origin, and stick out by no more than
/// `over` (all m): a row along the middle, and towards each corner ever smaller ones, each as large as reaches the edges' parts that
/// the one before it left. One circle around all where a length is not finite or nothing may stick out.
pub(crate) fn circles([l, w]: [f64; 2], over: f64) -> Vec<([f64; 2], f64)> {
    // Half the part of an edge that a circle covers whose middle is `d` inside of it.
    let covered = |d: f64| (over * (2.0 * d + over)).sqrt();
    let (long, short) = (l.max(w), l.min(w));
    if !(long.is_finite() && over > 0.0) {
        return vec![([0.0; 2], long.hypot(short) + over)];
    }
    let mut out = Vec::new();
    let mut put = |x: f64, y: f64, r: f64| {
        let middle = if l >= w { [x, y] } else { [y, x] };
        out.push((middle, r));
    };
    // The row: its ends touch the short edges, neighbours overlap at the long ones.
    let reach = long - short;
    let gaps = (reach / (SHARE * covered(short))).ceil();
    for k in 0..=gaps as usize {
        let x = if gaps > 0.0 {
            reach * (2.0 * k as f64 / gaps - 1.0)
        } else {
            0.0
        };
        put(x, 0.0, short + over);
    }
    // The corner is just inside the first circle.
    let mut d = over / (std::f64::consts::SQRT_2 - 1.0) * SHARE;
    while d < short {
        for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            put(x * (long - d), y * (short - d), d + over);
        }
        // The next one covers the edges from where this one ends on: d' - covered(d') <= d + covered(d).
        let end = SHARE * (d + covered(d));
        if short - covered(short) <= end {
            break;
        }
        d = end + over + (over * (2.0 * over + 2.0 * end)).sqrt();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn lengths_without_end_take_one_circle() {
        for half in [[f64::INFINITY, 1.0], [f64::NAN, f64::NAN]] {
            assert_eq!(circles(half, 0.01).len(), 1);
        }
        assert_eq!(circles([0.4, 0.3], 0.0).len(), 1);
    }

    proptest! {
        #[test]
        fn every_point_of_the_rectangle_is_covered_and_nothing_sticks_out_far(
            half in [0.1_f64..1.0, 0.1_f64..1.0], share in 0.02_f64..0.3,
        ) {
            let over = share * half[0].min(half[1]);
            let circles = circles(half, over);
            for i in 0..=60 {
                for j in 0..=60 {
                    let p = [
                        half[0] * (f64::from(i) / 30.0 - 1.0),
                        half[1] * (f64::from(j) / 30.0 - 1.0),
                    ];
                    let inside = circles.iter().any(|(c, r)| (p[0] - c[0]).hypot(p[1] - c[1]) <= *r);
                    prop_assert!(inside, "{p:?} of {half:?} with {over}: {circles:?}");
                }
            }
            for (c, r) in &circles {
                for k in 0..2 {
                    prop_assert!(c[k].abs() + r <= half[k] + over + 1e-9);
                }
            }
        }
    }
}
