//! Arithmetic on fixed-width arrays, in loops that the compiler turns into vector instructions.
#![allow(clippy::excessive_precision)] // the published constants, to the last digit

/// States that are looked at together.
pub const LANES: usize = 16;

/// One number per lane.
pub type Lanes = [f32; LANES];

/// A vector of the world or of a frame, one per lane.
pub(crate) type Lanes3 = [Lanes; 3];

#[inline(always)]
pub(crate) fn splat(v: f32) -> Lanes {
    [v; LANES]
}

#[inline(always)]
pub(crate) fn each(f: impl Fn(usize) -> f32) -> Lanes {
    let mut out = [0.0; LANES];
    for l in 0..LANES {
        out[l] = f(l);
    }
    out
}

/// `a * b + c * d`.
#[inline(always)]
pub(crate) fn sum2(a: &Lanes, b: &Lanes, c: &Lanes, d: &Lanes) -> Lanes {
    each(|l| a[l] * b[l] + c[l] * d[l])
}

/// A frame per lane, stored by columns like [`Frame`](crate::Frame).
#[derive(Clone, Copy)]
pub(crate) struct LaneFrame {
    pub(crate) x: Lanes3,
    pub(crate) y: Lanes3,
    pub(crate) z: Lanes3,
    pub(crate) p: Lanes3,
}

impl LaneFrame {
    #[inline(always)]
    pub(crate) fn apply(&self, c: [f32; 3]) -> Lanes3 {
        let mut out = [[0.0; LANES]; 3];
        for i in 0..3 {
            for l in 0..LANES {
                out[i][l] = self.p[i][l]
                    + (self.x[i][l] * c[0] + self.y[i][l] * c[1] + self.z[i][l] * c[2]);
            }
        }
        out
    }
}

const TWO_OVER_PI: f32 = std::f32::consts::FRAC_2_PI;
// pi/2 in three parts, each short enough that a small integer times it is exact (Cody and Waite).
const PIO2_A: f32 = 1.570_312_5;
const PIO2_B: f32 = 4.837_512_969_970_703e-4;
const PIO2_C: f32 = 7.549_789_948_768_648e-8;
/// Adding and taking away 1.5 * 2^23 rounds to a whole number.
const ROUND: f32 = 12_582_912.0;

/// Sine and cosine of each lane; error below 2e-7 for angles up to a few hundred radians. NaN stays NaN.
///
/// Minimax polynomials on [-pi/4, pi/4] after reduction by multiples of pi/2; no branches.
#[inline(always)]
pub(crate) fn sin_cos(angle: &Lanes) -> (Lanes, Lanes) {
    let (mut sin, mut cos) = ([0.0; LANES], [0.0; LANES]);
    for l in 0..LANES {
        let a = angle[l];
        let shifted = a * TWO_OVER_PI + ROUND;
        let quarter = shifted.to_bits();
        let k = shifted - ROUND;
        let r = ((a - k * PIO2_A) - k * PIO2_B) - k * PIO2_C;
        let s = r * r;
        // Taylor terms fitted to the interval's ends.
        let p = r + r * s * (-1.666_665_46e-1 + s * (8.332_160_87e-3 + s * -1.951_529_59e-4));
        let q = 1.0 - 0.5 * s
            + s * s * (4.166_664_57e-2 + s * (-1.388_731_63e-3 + s * 2.443_315_71e-5));
        let swap = quarter & 1 == 1;
        let (u, v) = if swap { (q, p) } else { (p, q) };
        // Bit 1 of the quarter flips the sine; bit 0 xor bit 1 flips the cosine.
        let flip_sin = (quarter & 2) << 30;
        let flip_cos = (quarter.wrapping_add(1) & 2) << 30;
        sin[l] = f32::from_bits(u.to_bits() ^ flip_sin);
        cos[l] = f32::from_bits(v.to_bits() ^ flip_cos);
    }
    (sin, cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_agree_with_the_library() {
        let mut worst = 0.0f64;
        for i in 0..200_000 {
            let a = (f64::from(i) - 1e5) * 2e-4;
            let (s, c) = sin_cos(&splat(a as f32));
            let a = f64::from(a as f32);
            worst = worst.max((f64::from(s[0]) - a.sin()).abs());
            worst = worst.max((f64::from(c[LANES - 1]) - a.cos()).abs());
        }
        assert!(worst < 2e-7, "{worst}");
        assert!(sin_cos(&splat(f32::NAN)).0[0].is_nan());
    }
}
