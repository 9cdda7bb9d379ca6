//! Arithmetic on fixed-width arrays, in loops that the compiler turns into vector instructions.
#![allow(clippy::excessive_precision)] // the published constants, to the last digit

/// States that are looked at together.
pub const LANES: usize = 16;

/// One number per lane.
pub type Lanes = [f32; LANES];

/// A vector of the world or of a frame, one per lane.
pub(crate) type Lanes3 = [Lanes; 3];

#[inline(always)]
pub(crate) fn each(f: impl Fn(usize) -> f32) -> Lanes {
    let mut out = [0.0; LANES];
    for l in 0..LANES {
        out[l] = f(l);
    }
    out
}

/// `a * b + c`, in one rounding where the machine does that in one instruction (`FMA`).
#[inline(always)]
pub(crate) fn fused<const FMA: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FMA { a.mul_add(b, c) } else { a * b + c }
}

/// A frame per lane: columns x, y, z and origin, each with its three axes.
pub(crate) type LaneFrame = [[Lanes; 3]; 4];

const TWO_OVER_PI: f32 = std::f32::consts::FRAC_2_PI;
// pi/2 in three parts, each short enough that a small integer times it is exact (Cody and Waite).
const PIO2_A: f32 = 1.570_312_5;
const PIO2_B: f32 = 4.837_512_969_970_703e-4;
const PIO2_C: f32 = 7.549_789_948_768_648e-8;
/// Adding and taking away 1.5 * 2^23 rounds to a whole number.
const ROUND: f32 = 12_582_912.0;

/// Sine and cosine; error below 2e-7 for angles up to a few hundred radians. NaN stays NaN.
///
/// Minimax polynomials on [-pi/4, pi/4] after reduction by multiples of pi/2; no branches, so that a loop over lanes
/// becomes vector instructions.
#[inline(always)]
pub(crate) fn sin_cos<const FMA: bool>(angle: f32) -> (f32, f32) {
    let shifted = fused::<FMA>(angle, TWO_OVER_PI, ROUND);
    let quarter = shifted.to_bits();
    let k = shifted - ROUND;
    let r = fused::<FMA>(-k, PIO2_A, angle);
    let r = fused::<FMA>(-k, PIO2_C, fused::<FMA>(-k, PIO2_B, r));
    let s = r * r;
    // Taylor terms fitted to the interval's ends.
    let p = fused::<FMA>(s, -1.951_529_59e-4, 8.332_160_87e-3);
    let p = fused::<FMA>(r * s, fused::<FMA>(s, p, -1.666_665_46e-1), r);
    let q = fused::<FMA>(s, 2.443_315_71e-5, -1.388_731_63e-3);
    let q = fused::<FMA>(s, q, 4.166_664_57e-2);
    let q = fused::<FMA>(s * s, q, fused::<FMA>(s, -0.5, 1.0));
    let swap = quarter & 1 == 1;
    let (u, v) = if swap { (q, p) } else { (p, q) };
    // Bit 1 of the quarter flips the sine; bit 0 xor bit 1 flips the cosine.
    let flip_sin = (quarter & 2) << 30;
    let flip_cos = (quarter.wrapping_add(1) & 2) << 30;
    (
        f32::from_bits(u.to_bits() ^ flip_sin),
        f32::from_bits(v.to_bits() ^ flip_cos),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_agree_with_the_library() {
        let mut worst = 0.0f64;
        for i in 0..200_000 {
            let a = (f64::from(i) - 1e5) * 2e-4;
            for (s, c) in [sin_cos::<false>(a as f32), sin_cos::<true>(a as f32)] {
                let a = f64::from(a as f32);
                worst = worst.max((f64::from(s) - a.sin()).abs());
                worst = worst.max((f64::from(c) - a.cos()).abs());
            }
        }
        assert!(worst < 2e-7, "{worst}");
        assert!(sin_cos::<false>(f32::NAN).0.is_nan());
    }
}
