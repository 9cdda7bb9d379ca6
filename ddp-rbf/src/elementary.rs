//! Sine, cosine, exponential and logarithm of many numbers at once, to about one unit in the last place.
//!
//! Reduction to a small interval, then the Taylor series to where its next term is below 1e-17 of the result.

use crate::simd::Vector;

/// Sine and cosine. Angles beyond 1e5 rad, where the reduction would lose digits, and what is not finite go to the standard
/// library one by one.
#[inline(always)]
pub(crate) fn sin_cos<const L: usize, V: Vector<L>>(x: V) -> (V, V) {
    if !x.abs().all_less(V::splat(1e5)) {
        let (mut s, mut c) = (x.array(), x.array());
        for (s, c) in s.iter_mut().zip(&mut c) {
            (*s, *c) = s.sin_cos();
        }
        return (V::load(&s), V::load(&c));
    }
    // x = n pi/2 + r with |r| <= pi/4. The first two parts of pi/2 have 33 bits, so that their products with n are exact.
    let n = round(x * V::splat(std::f64::consts::FRAC_2_PI));
    let r = n.neg_mul_add(V::splat(PI_HALF[0]), x);
    let r = n.neg_mul_add(V::splat(PI_HALF[1]), r);
    let r = n.neg_mul_add(V::splat(PI_HALF[2]), r);
    let r2 = r * r;
    // r - r^3/3! + ... - r^17/17!... and 1 - r^2/2! + ... + r^16/16!, from the highest term down.
    let mut s = V::splat(SINE[0]);
    for c in &SINE[1..] {
        s = s.mul_add(r2, V::splat(*c));
    }
    let s = (s * r2).mul_add(r, r);
    let mut c = V::splat(COSINE[0]);
    for k in &COSINE[1..] {
        c = c.mul_add(r2, V::splat(*k));
    }
    let c = c.mul_add(r2, V::splat(1.0));
    // The quadrant, -2 to 2: odd ones swap, two of each change sign.
    let q = round(n * V::splat(0.25)).neg_mul_add(V::splat(4.0), n);
    let odd = (q.abs() - V::splat(1.0)).abs();
    let (half, one) = (V::splat(0.5), V::splat(1.0));
    let sine = odd.if_less(half, c, s);
    let cosine = odd.if_less(half, s, c);
    (
        (q - half).abs().if_less(one, sine, -sine),
        (q + half).abs().if_less(one, cosine, -cosine),
    )
}

/// Exponential; arguments below -700 give the value at -700.
#[inline(always)]
pub(crate) fn exp<const L: usize, V: Vector<L>>(x: V) -> V {
    let x = x.max(V::splat(-700.0)).min(V::splat(700.0));
    let n = round(x * V::splat(std::f64::consts::LOG2_E));
    let r = n.neg_mul_add(V::splat(LN_2[0]), x);
    let r = n.neg_mul_add(V::splat(LN_2[1]), r);
    let mut p = V::splat(EXPONENTIAL[0]);
    for c in &EXPONENTIAL[1..] {
        p = p.mul_add(r, V::splat(*c));
    }
    p * n.pow2()
}

/// Natural logarithm of positive normal numbers.
#[inline(always)]
pub(crate) fn ln<const L: usize, V: Vector<L>>(x: V) -> V {
    let (m, e) = x.split();
    // Mantissa between 1/sqrt 2 and sqrt 2, so that the series converges fast and ln 1 is exactly 0.
    let root = V::splat(std::f64::consts::SQRT_2);
    let e = m.if_less(root, e, e + V::splat(1.0));
    let m = m.if_less(root, m, m * V::splat(0.5));
    // ln m = 2 artanh s with s = (m - 1) / (m + 1), |s| <= 0.172.
    let s = (m - V::splat(1.0)) / (m + V::splat(1.0));
    let s2 = s * s;
    let mut p = V::splat(2.0 / 21.0);
    for k in [19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
        p = p.mul_add(s2, V::splat(2.0 / k));
    }
    let small = (p * s2).mul_add(s, s + s);
    e.mul_add(V::splat(LN_2[0]), e.mul_add(V::splat(LN_2[1]), small))
}

/// The nearest integer, ties to even, for magnitudes below 2^51.
#[inline(always)]
fn round<const L: usize, V: Vector<L>>(x: V) -> V {
    let magic = V::splat(6_755_399_441_055_744.0);
    (x + magic) - magic
}

/// The largest integer not above, for magnitudes below 2^51.
#[inline(always)]
pub(crate) fn floor<const L: usize, V: Vector<L>>(x: V) -> V {
    let nearest = round(x);
    nearest - x.if_less(nearest, V::splat(1.0), V::zero())
}

/// pi/2 in three parts, the first two of 33 bits.
const PI_HALF: [f64; 3] = [
    f64::from_bits(0x3ff9_21fb_5440_0000),
    f64::from_bits(0x3dd0_b461_1a60_0000),
    f64::from_bits(0x3ba3_198a_2e03_7073),
];
/// ln 2 in two parts, the first of 33 bits.
const LN_2: [f64; 2] = [
    f64::from_bits(0x3fe6_2e42_fef0_0000),
    f64::from_bits(0x3dd4_73de_6af2_78ed),
];

const fn factorial(n: u32) -> f64 {
    let (mut out, mut k) = (1.0, 2);
    while k <= n {
        out *= k as f64;
        k += 1;
    }
    out
}

/// Coefficients of r^17 down to r^3.
const SINE: [f64; 8] = [
    1.0 / factorial(17),
    -1.0 / factorial(15),
    1.0 / factorial(13),
    -1.0 / factorial(11),
    1.0 / factorial(9),
    -1.0 / factorial(7),
    1.0 / factorial(5),
    -1.0 / factorial(3),
];
/// Coefficients of r^18 down to r^2.
const COSINE: [f64; 9] = [
    -1.0 / factorial(18),
    1.0 / factorial(16),
    -1.0 / factorial(14),
    1.0 / factorial(12),
    -1.0 / factorial(10),
    1.0 / factorial(8),
    -1.0 / factorial(6),
    1.0 / factorial(4),
    -1.0 / factorial(2),
];
/// Coefficients of r^13 down to 1.
const EXPONENTIAL: [f64; 14] = [
    1.0 / factorial(13),
    1.0 / factorial(12),
    1.0 / factorial(11),
    1.0 / factorial(10),
    1.0 / factorial(9),
    1.0 / factorial(8),
    1.0 / factorial(7),
    1.0 / factorial(6),
    1.0 / factorial(5),
    1.0 / factorial(4),
    1.0 / factorial(3),
    0.5,
    1.0,
    1.0,
];

#[cfg(test)]
mod tests {
    use super::{exp, ln, sin_cos};
    use crate::simd::{Kernel, Vector, with_every_kind};

    #[derive(Clone)]
    struct Agree;

    impl Kernel for Agree {
        type Output = ();
        #[inline(always)]
        fn run<V: Vector>(self) {
            let mut worst = [0.0f64; 3];
            for i in 0..40_000 {
                let t = f64::from(i) - 20_000.0;
                let angle = t * 0.031 + 1e-7 * t * t;
                let (s, c) = sin_cos(V::splat(angle));
                let (es, ec) = angle.sin_cos();
                worst[0] = worst[0].max((s.array()[1] - es).abs().max((c.array()[2] - ec).abs()));
                let x = t * 0.03;
                worst[1] = worst[1].max((exp(V::splat(x)).array()[0] / x.exp() - 1.0).abs());
                let p = (t * 0.02).exp();
                let off = (ln(V::splat(p)).array()[3] - p.ln()).abs() / (1.0 + p.ln().abs());
                worst[2] = worst[2].max(off);
            }
            assert!(worst.iter().all(|&w| w < 4e-16), "{worst:?}");
            assert_eq!(ln(V::splat(1.0)).array(), [0.0; 8]);
            assert!(sin_cos(V::splat(f64::NAN)).0.array()[0].is_nan());
            assert!((sin_cos(V::splat(1e9)).0.array()[0] - 1e9f64.sin()).abs() < 1e-15);
        }
    }

    #[test]
    fn every_kind_of_vector_agrees_with_the_standard_library() {
        with_every_kind(&Agree);
    }
}
