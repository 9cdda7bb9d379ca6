//! AVX2 and AVX-512 registers.
//!
//! Why this is sound: a [`HasAvx2`] or [`HasAvx512`] can only be made by [`avx2`] and [`avx512`], after the processor was asked
//! for the features. The functions that take one are the only ones that run a kernel with [`Avx2`] or [`Avx512`] vectors (the
//! types are private to this module; kernels name them only through the trait), so every intrinsic below is executed on a
//! processor that has it. Loads and stores go through references to arrays of exactly four and eight doubles, with unaligned
//! instructions.
#![allow(unsafe_code)]

use super::portable::{EXPONENT_MAGIC, MANTISSA, ONE_BITS, POW2_MAGIC, TWO52_BITS, Two};
use super::{Kernel, LANES, NARROW, Vector};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Proof that the processor has AVX2 and FMA.
#[derive(Clone, Copy)]
pub(super) struct HasAvx2(());

/// Proof that it also has AVX-512F, DQ and VL.
#[derive(Clone, Copy)]
pub(super) struct HasAvx512(());

/// The widest vectors there are.
pub(super) enum Level {
    Avx512(HasAvx512),
    Avx2(HasAvx2),
    None,
}

#[inline(always)]
pub(super) fn level() -> Level {
    if let Some(token) = avx512() {
        Level::Avx512(token)
    } else if let Some(token) = avx2() {
        Level::Avx2(token)
    } else {
        Level::None
    }
}

#[inline(always)]
pub(super) fn avx2() -> Option<HasAvx2> {
    (is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")).then_some(HasAvx2(()))
}

#[inline(always)]
pub(super) fn avx512() -> Option<HasAvx512> {
    let all = is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
        && avx2().is_some();
    all.then_some(HasAvx512(()))
}

macro_rules! runner {
    ($name:ident, $token:ty, $features:literal, $lanes:expr, $vector:ty) => {
        /// Runs a kernel.
        #[inline]
        pub(super) fn $name<K: Kernel<$lanes>>(_: $token, kernel: K) -> K::Output {
            #[target_feature(enable = $features)]
            fn with_features<K: Kernel<$lanes>>(kernel: K) -> K::Output {
                kernel.run::<$vector>()
            }
            // SAFETY: the token proves that the processor has the features.
            unsafe { with_features(kernel) }
        }
    };
}
runner!(narrow_avx2, HasAvx2, "avx2,fma", NARROW, Avx2);
runner!(wide_avx2, HasAvx2, "avx2,fma", LANES, Two<Avx2>);
runner!(
    narrow_avx512,
    HasAvx512,
    "avx2,fma,avx512f,avx512dq,avx512vl",
    NARROW,
    Avx2
);
runner!(
    wide_avx512,
    HasAvx512,
    "avx2,fma,avx512f,avx512dq,avx512vl",
    LANES,
    Avx512
);

/// One 256-bit register.
#[derive(Clone, Copy)]
struct Avx2(__m256d);

/// One 512-bit register.
#[derive(Clone, Copy)]
struct Avx512(__m512d);

macro_rules! operator {
    ($trait:ident, $name:ident, $narrow:ident, $wide:ident) => {
        impl $trait for Avx2 {
            type Output = Self;
            #[inline(always)]
            fn $name(self, o: Self) -> Self {
                // SAFETY: see the module's proof.
                Self(unsafe { $narrow(self.0, o.0) })
            }
        }
        impl $trait for Avx512 {
            type Output = Self;
            #[inline(always)]
            fn $name(self, o: Self) -> Self {
                // SAFETY: see the module's proof.
                Self(unsafe { $wide(self.0, o.0) })
            }
        }
    };
}
operator!(Add, add, _mm256_add_pd, _mm512_add_pd);
operator!(Sub, sub, _mm256_sub_pd, _mm512_sub_pd);
operator!(Mul, mul, _mm256_mul_pd, _mm512_mul_pd);
operator!(Div, div, _mm256_div_pd, _mm512_div_pd);

impl Neg for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: see the module's proof.
        Self(unsafe { _mm256_xor_pd(self.0, _mm256_set1_pd(-0.0)) })
    }
}

impl Neg for Avx512 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: see the module's proof.
        Self(unsafe { _mm512_xor_pd(self.0, _mm512_set1_pd(-0.0)) })
    }
}

// SAFETY of every block below: see the module's proof.
impl Vector<NARROW> for Avx2 {
    #[inline(always)]
    fn splat(v: f64) -> Self {
        Self(unsafe { _mm256_set1_pd(v) })
    }
    #[inline(always)]
    fn load(v: &[f64; NARROW]) -> Self {
        Self(unsafe { _mm256_loadu_pd(v.as_ptr()) })
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; NARROW]) {
        unsafe { _mm256_storeu_pd(to.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self(unsafe { _mm256_fmadd_pd(self.0, b.0, c.0) })
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        Self(unsafe { _mm256_fnmadd_pd(self.0, b.0, c.0) })
    }
    // The instructions return their second operand where one is NaN.
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        Self(unsafe { _mm256_max_pd(o.0, self.0) })
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        Self(unsafe { _mm256_min_pd(o.0, self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }
    #[inline(always)]
    fn with_sign_of(self, o: Self) -> Self {
        Self(unsafe { _mm256_or_pd(self.0, _mm256_and_pd(_mm256_set1_pd(-0.0), o.0)) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(unsafe { _mm256_sqrt_pd(self.0) })
    }
    #[inline(always)]
    fn inverse_sqrt(self) -> Self {
        Self::splat(1.0) / self.sqrt()
    }
    #[inline(always)]
    fn if_less(self, o: Self, yes: Self, no: Self) -> Self {
        Self(unsafe { _mm256_blendv_pd(no.0, yes.0, _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, o.0)) })
    }
    #[inline(always)]
    fn all_less(self, o: Self) -> bool {
        unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(self.0, o.0)) == 0b1111 }
    }
    #[inline(always)]
    fn pow2(self) -> Self {
        Self(unsafe {
            let biased = _mm256_add_pd(self.0, _mm256_set1_pd(POW2_MAGIC));
            _mm256_castsi256_pd(_mm256_slli_epi64::<52>(_mm256_castpd_si256(biased)))
        })
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        unsafe {
            let bits = _mm256_castpd_si256(self.0);
            let mantissa = _mm256_or_si256(
                _mm256_and_si256(bits, _mm256_set1_epi64x(MANTISSA as i64)),
                _mm256_set1_epi64x(ONE_BITS as i64),
            );
            let exponent = _mm256_or_si256(
                _mm256_srli_epi64::<52>(bits),
                _mm256_set1_epi64x(TWO52_BITS as i64),
            );
            (
                Self(_mm256_castsi256_pd(mantissa)),
                Self(_mm256_castsi256_pd(exponent)) - Self::splat(EXPONENT_MAGIC),
            )
        }
    }
    #[inline(always)]
    fn transpose(r: [Self; NARROW]) -> [Self; NARROW] {
        unsafe {
            let (a, b) = (
                _mm256_unpacklo_pd(r[0].0, r[1].0),
                _mm256_unpackhi_pd(r[0].0, r[1].0),
            );
            let (c, d) = (
                _mm256_unpacklo_pd(r[2].0, r[3].0),
                _mm256_unpackhi_pd(r[2].0, r[3].0),
            );
            [
                Self(_mm256_permute2f128_pd::<0x20>(a, c)),
                Self(_mm256_permute2f128_pd::<0x20>(b, d)),
                Self(_mm256_permute2f128_pd::<0x31>(a, c)),
                Self(_mm256_permute2f128_pd::<0x31>(b, d)),
            ]
        }
    }
}

// SAFETY of every block below: see the module's proof.
impl Vector<LANES> for Avx512 {
    #[inline(always)]
    fn splat(v: f64) -> Self {
        Self(unsafe { _mm512_set1_pd(v) })
    }
    #[inline(always)]
    fn load(v: &[f64; LANES]) -> Self {
        Self(unsafe { _mm512_loadu_pd(v.as_ptr()) })
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; LANES]) {
        unsafe { _mm512_storeu_pd(to.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self(unsafe { _mm512_fmadd_pd(self.0, b.0, c.0) })
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        Self(unsafe { _mm512_fnmadd_pd(self.0, b.0, c.0) })
    }
    // The instructions return their second operand where one is NaN.
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        Self(unsafe { _mm512_max_pd(o.0, self.0) })
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        Self(unsafe { _mm512_min_pd(o.0, self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm512_andnot_pd(_mm512_set1_pd(-0.0), self.0) })
    }
    #[inline(always)]
    fn with_sign_of(self, o: Self) -> Self {
        Self(unsafe { _mm512_or_pd(self.0, _mm512_and_pd(_mm512_set1_pd(-0.0), o.0)) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(unsafe { _mm512_sqrt_pd(self.0) })
    }
    #[inline(always)]
    fn inverse_sqrt(self) -> Self {
        // 14 bits, then twice the double by Newton's method: much shorter than a root and a division.
        let mut y = Self(unsafe { _mm512_rsqrt14_pd(self.0) });
        let half = self * Self::splat(0.5);
        for _ in 0..2 {
            let miss = (half * y).neg_mul_add(y, Self::splat(0.5));
            y = miss.mul_add(y, y);
        }
        y
    }
    #[inline(always)]
    fn if_less(self, o: Self, yes: Self, no: Self) -> Self {
        Self(unsafe {
            _mm512_mask_blend_pd(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, o.0), no.0, yes.0)
        })
    }
    #[inline(always)]
    fn all_less(self, o: Self) -> bool {
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, o.0) == 0xff }
    }
    #[inline(always)]
    fn pow2(self) -> Self {
        Self(unsafe {
            let biased = _mm512_add_pd(self.0, _mm512_set1_pd(POW2_MAGIC));
            _mm512_castsi512_pd(_mm512_slli_epi64::<52>(_mm512_castpd_si512(biased)))
        })
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        unsafe {
            let bits = _mm512_castpd_si512(self.0);
            let mantissa = _mm512_or_si512(
                _mm512_and_si512(bits, _mm512_set1_epi64(MANTISSA as i64)),
                _mm512_set1_epi64(ONE_BITS as i64),
            );
            let exponent = _mm512_or_si512(
                _mm512_srli_epi64::<52>(bits),
                _mm512_set1_epi64(TWO52_BITS as i64),
            );
            (
                Self(_mm512_castsi512_pd(mantissa)),
                Self(_mm512_castsi512_pd(exponent)) - Self::splat(EXPONENT_MAGIC),
            )
        }
    }
    #[inline(always)]
    fn transpose(r: [Self; LANES]) -> [Self; LANES] {
        unsafe {
            // Pairs of rows, then pairs of pairs, of even and of odd columns.
            let even = [
                _mm512_unpacklo_pd(r[0].0, r[1].0),
                _mm512_unpacklo_pd(r[2].0, r[3].0),
                _mm512_unpacklo_pd(r[4].0, r[5].0),
                _mm512_unpacklo_pd(r[6].0, r[7].0),
            ];
            let odd = [
                _mm512_unpackhi_pd(r[0].0, r[1].0),
                _mm512_unpackhi_pd(r[2].0, r[3].0),
                _mm512_unpackhi_pd(r[4].0, r[5].0),
                _mm512_unpackhi_pd(r[6].0, r[7].0),
            ];
            let mut out = [r[0]; LANES];
            for (c, t) in [even, odd].into_iter().enumerate() {
                let a = _mm512_shuffle_f64x2::<0x88>(t[0], t[1]);
                let b = _mm512_shuffle_f64x2::<0xdd>(t[0], t[1]);
                let d = _mm512_shuffle_f64x2::<0x88>(t[2], t[3]);
                let e = _mm512_shuffle_f64x2::<0xdd>(t[2], t[3]);
                out[c] = Self(_mm512_shuffle_f64x2::<0x88>(a, d));
                out[c + 2] = Self(_mm512_shuffle_f64x2::<0x88>(b, e));
                out[c + 4] = Self(_mm512_shuffle_f64x2::<0xdd>(a, d));
                out[c + 6] = Self(_mm512_shuffle_f64x2::<0xdd>(b, e));
            }
            out
        }
    }
}
