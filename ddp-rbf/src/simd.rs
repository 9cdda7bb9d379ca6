//! Four doubles at once: the widest vectors the processor has, found at run time.
//!
//! A [`Kernel`] is written once over a [`Vector`]; [`dispatch`] compiles it for plain arrays and, on x86-64, for AVX2 with
//! fused multiply-add. Both give the same values up to the rounding of the fused operation.
//!
//! This is the only module of the crate with unsafe code. Its proof: a value of [`Avx2`] can only be made inside a kernel
//! that [`dispatch`] runs after it has asked the processor for AVX2 and FMA (the type is private to the crate and kernels
//! name it only through the trait), so every intrinsic below is executed on a processor that has it; loads and stores go
//! through references to arrays of exactly four doubles, with unaligned instructions.
#![allow(unsafe_code)]

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Batches of points and knots come in groups of this many.
pub const LANES: usize = 4;

/// One quantity at [`LANES`] places.
pub type Lanes = [f64; LANES];

/// A vector of [`LANES`] doubles. Comparisons with NaN keep the NaN of the first operand.
pub(crate) trait Vector:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The same number in every lane.
    fn splat(v: f64) -> Self;
    /// From an array.
    fn load(v: &Lanes) -> Self;
    /// Into an array.
    fn store(self, to: &mut Lanes);
    /// self * b + c.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// c - self * b.
    fn neg_mul_add(self, b: Self, c: Self) -> Self;
    /// The larger in each lane.
    fn max(self, o: Self) -> Self;
    /// The smaller in each lane.
    fn min(self, o: Self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// `yes` in the lanes where self < o, `no` elsewhere.
    fn if_less(self, o: Self, yes: Self, no: Self) -> Self;
    /// True if self < o in every lane.
    fn all_less(self, o: Self) -> bool;
    /// 2 to the power of each lane, which must hold an integer between -1022 and 1023.
    fn pow2(self) -> Self;
    /// Mantissa in [1, 2) and exponent of positive normal numbers.
    fn split(self) -> (Self, Self);

    /// All zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }
    /// As an array.
    #[inline(always)]
    fn array(self) -> Lanes {
        let mut out = [0.0; LANES];
        self.store(&mut out);
        out
    }
    /// Absolute value.
    #[inline(always)]
    fn abs(self) -> Self {
        self.max(-self)
    }
}

/// A computation over vectors. Mark `run` as always inlined, so that it is compiled for each kind of vector.
pub(crate) trait Kernel {
    /// What it returns.
    type Output;
    /// Does it.
    fn run<V: Vector>(self) -> Self::Output;
}

/// Runs a kernel with the widest vectors there are.
#[inline]
pub(crate) fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
        // SAFETY: the processor has both features.
        return unsafe { x86::with_avx2(kernel) };
    }
    kernel.run::<Portable>()
}

/// Plain arrays.
#[derive(Clone, Copy)]
pub(crate) struct Portable(Lanes);

macro_rules! lanewise {
    ($trait:ident, $name:ident, $op:tt) => {
        impl $trait for Portable {
            type Output = Self;
            #[inline(always)]
            fn $name(self, o: Self) -> Self {
                Self(std::array::from_fn(|i| self.0[i] $op o.0[i]))
            }
        }
    };
}
lanewise!(Add, add, +);
lanewise!(Sub, sub, -);
lanewise!(Mul, mul, *);
lanewise!(Div, div, /);

impl Neg for Portable {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|v| -v))
    }
}

impl Vector for Portable {
    #[inline(always)]
    fn splat(v: f64) -> Self {
        Self([v; LANES])
    }
    #[inline(always)]
    fn load(v: &Lanes) -> Self {
        Self(*v)
    }
    #[inline(always)]
    fn store(self, to: &mut Lanes) {
        *to = self.0;
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self * b + c
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        c - self * b
    }
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        Self(std::array::from_fn(|i| {
            if self.0[i] < o.0[i] {
                o.0[i]
            } else {
                self.0[i]
            }
        }))
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        Self(std::array::from_fn(|i| {
            if o.0[i] < self.0[i] {
                o.0[i]
            } else {
                self.0[i]
            }
        }))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }
    #[inline(always)]
    fn if_less(self, o: Self, yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|i| {
            if self.0[i] < o.0[i] {
                yes.0[i]
            } else {
                no.0[i]
            }
        }))
    }
    #[inline(always)]
    fn all_less(self, o: Self) -> bool {
        (0..LANES).all(|i| self.0[i] < o.0[i])
    }
    #[inline(always)]
    fn pow2(self) -> Self {
        Self(
            self.0
                .map(|k| f64::from_bits(((k + POW2_MAGIC).to_bits()) << 52)),
        )
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        (
            Self(
                self.0
                    .map(|v| f64::from_bits(v.to_bits() & MANTISSA | ONE_BITS)),
            ),
            Self(
                self.0
                    .map(|v| f64::from_bits((v.to_bits() >> 52) | TWO52_BITS) - EXPONENT_MAGIC),
            ),
        )
    }
}

/// 1.5 * 2^52 + 1023: adding it leaves the biased exponent in the lowest bits.
const POW2_MAGIC: f64 = 6_755_399_441_055_744.0 + 1023.0;
/// 2^52 + 1023.
const EXPONENT_MAGIC: f64 = 4_503_599_627_370_496.0 + 1023.0;
const MANTISSA: u64 = 0x000f_ffff_ffff_ffff;
const ONE_BITS: u64 = 0x3ff0_0000_0000_0000;
const TWO52_BITS: u64 = 0x4330_0000_0000_0000;

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{
        EXPONENT_MAGIC, Kernel, Lanes, MANTISSA, ONE_BITS, POW2_MAGIC, TWO52_BITS, Vector,
    };
    use std::arch::x86_64::*;
    use std::ops::{Add, Div, Mul, Neg, Sub};

    /// One 256-bit register.
    #[derive(Clone, Copy)]
    pub(crate) struct Avx2(__m256d);

    /// SAFETY for the caller: the processor must have AVX2 and FMA.
    #[target_feature(enable = "avx2,fma")]
    pub(super) unsafe fn with_avx2<K: Kernel>(kernel: K) -> K::Output {
        kernel.run::<Avx2>()
    }

    macro_rules! operator {
        ($trait:ident, $name:ident, $intrinsic:ident) => {
            impl $trait for Avx2 {
                type Output = Self;
                #[inline(always)]
                fn $name(self, o: Self) -> Self {
                    // SAFETY: see the module's proof.
                    Self(unsafe { $intrinsic(self.0, o.0) })
                }
            }
        };
    }
    operator!(Add, add, _mm256_add_pd);
    operator!(Sub, sub, _mm256_sub_pd);
    operator!(Mul, mul, _mm256_mul_pd);
    operator!(Div, div, _mm256_div_pd);

    impl Neg for Avx2 {
        type Output = Self;
        #[inline(always)]
        fn neg(self) -> Self {
            // SAFETY: see the module's proof.
            Self(unsafe { _mm256_xor_pd(self.0, _mm256_set1_pd(-0.0)) })
        }
    }

    // SAFETY of every block below: see the module's proof.
    impl Vector for Avx2 {
        #[inline(always)]
        fn splat(v: f64) -> Self {
            Self(unsafe { _mm256_set1_pd(v) })
        }
        #[inline(always)]
        fn load(v: &Lanes) -> Self {
            Self(unsafe { _mm256_loadu_pd(v.as_ptr()) })
        }
        #[inline(always)]
        fn store(self, to: &mut Lanes) {
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
        fn sqrt(self) -> Self {
            Self(unsafe { _mm256_sqrt_pd(self.0) })
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
                    Self(_mm256_sub_pd(
                        _mm256_castsi256_pd(exponent),
                        _mm256_set1_pd(EXPONENT_MAGIC),
                    )),
                )
            }
        }
    }
}
