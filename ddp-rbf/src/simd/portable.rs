//! Vectors of plain arrays, and pairs of vectors.

use super::{LANES, NARROW, Vector};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Plain arrays.
#[derive(Clone, Copy)]
pub(crate) struct Portable<const L: usize>([f64; L]);

macro_rules! lanewise {
    ($trait:ident, $name:ident, $op:tt) => {
        impl<const L: usize> $trait for Portable<L> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, o: Self) -> Self {
                Self(std::array::from_fn(|i| self.0[i] $op o.0[i]))
            }
        }
        impl<V: Vector<NARROW>> $trait for Two<V> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, o: Self) -> Self {
                Self(self.0 $op o.0, self.1 $op o.1)
            }
        }
    };
}
lanewise!(Add, add, +);
lanewise!(Sub, sub, -);
lanewise!(Mul, mul, *);
lanewise!(Div, div, /);

impl<const L: usize> Neg for Portable<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|v| -v))
    }
}

impl<const L: usize> Vector<L> for Portable<L> {
    #[inline(always)]
    fn splat(v: f64) -> Self {
        Self([v; L])
    }
    #[inline(always)]
    fn load(v: &[f64; L]) -> Self {
        Self(*v)
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; L]) {
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
    fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }
    #[inline(always)]
    fn with_sign_of(self, o: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i].copysign(o.0[i])))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }
    #[inline(always)]
    fn inverse_sqrt(self) -> Self {
        Self(self.0.map(|v| 1.0 / v.sqrt()))
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
        (0..L).all(|i| self.0[i] < o.0[i])
    }
    #[inline(always)]
    fn pow2(self) -> Self {
        Self(
            self.0
                .map(|k| f64::from_bits((k + POW2_MAGIC).to_bits() << 52)),
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
    #[inline(always)]
    fn transpose(rows: [Self; L]) -> [Self; L] {
        std::array::from_fn(|c| Self(std::array::from_fn(|r| rows[r].0[c])))
    }
}

/// 1.5 * 2^52 + 1023: adding it leaves the biased exponent in the lowest bits.
pub(super) const POW2_MAGIC: f64 = 6_755_399_441_055_744.0 + 1023.0;
/// 2^52 + 1023.
pub(super) const EXPONENT_MAGIC: f64 = 4_503_599_627_370_496.0 + 1023.0;
pub(super) const MANTISSA: u64 = 0x000f_ffff_ffff_ffff;
pub(super) const ONE_BITS: u64 = 0x3ff0_0000_0000_0000;
pub(super) const TWO52_BITS: u64 = 0x4330_0000_0000_0000;

/// Two narrow vectors as a wide one.
#[derive(Clone, Copy)]
pub(crate) struct Two<V>(V, V);

impl<V: Vector<NARROW>> Neg for Two<V> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

/// The halves of an array.
#[inline(always)]
fn halves(v: &[f64; LANES]) -> (&[f64; NARROW], &[f64; NARROW]) {
    const { assert!(LANES == 2 * NARROW) };
    let ([low, high], _) = v.as_chunks::<NARROW>() else {
        unreachable!("an array of two halves");
    };
    (low, high)
}

impl<V: Vector<NARROW>> Vector<LANES> for Two<V> {
    #[inline(always)]
    fn splat(v: f64) -> Self {
        Self(V::splat(v), V::splat(v))
    }
    #[inline(always)]
    fn load(v: &[f64; LANES]) -> Self {
        let (low, high) = halves(v);
        Self(V::load(low), V::load(high))
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; LANES]) {
        if let ([low, high], _) = to.as_chunks_mut::<NARROW>() {
            self.0.store(low);
            self.1.store(high);
        }
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self(self.0.mul_add(b.0, c.0), self.1.mul_add(b.1, c.1))
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        Self(self.0.neg_mul_add(b.0, c.0), self.1.neg_mul_add(b.1, c.1))
    }
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        Self(self.0.max(o.0), self.1.max(o.1))
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        Self(self.0.min(o.0), self.1.min(o.1))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }
    #[inline(always)]
    fn with_sign_of(self, o: Self) -> Self {
        Self(self.0.with_sign_of(o.0), self.1.with_sign_of(o.1))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }
    #[inline(always)]
    fn inverse_sqrt(self) -> Self {
        Self(self.0.inverse_sqrt(), self.1.inverse_sqrt())
    }
    #[inline(always)]
    fn if_less(self, o: Self, yes: Self, no: Self) -> Self {
        Self(
            self.0.if_less(o.0, yes.0, no.0),
            self.1.if_less(o.1, yes.1, no.1),
        )
    }
    #[inline(always)]
    fn all_less(self, o: Self) -> bool {
        self.0.all_less(o.0) && self.1.all_less(o.1)
    }
    #[inline(always)]
    fn pow2(self) -> Self {
        Self(self.0.pow2(), self.1.pow2())
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        let ((m0, e0), (m1, e1)) = (self.0.split(), self.1.split());
        (Self(m0, m1), Self(e0, e1))
    }
    #[inline(always)]
    fn transpose(r: [Self; LANES]) -> [Self; LANES] {
        // Four quarters, the upper right and lower left change places.
        let a = V::transpose([r[0].0, r[1].0, r[2].0, r[3].0]);
        let b = V::transpose([r[0].1, r[1].1, r[2].1, r[3].1]);
        let c = V::transpose([r[4].0, r[5].0, r[6].0, r[7].0]);
        let d = V::transpose([r[4].1, r[5].1, r[6].1, r[7].1]);
        [
            Self(a[0], c[0]),
            Self(a[1], c[1]),
            Self(a[2], c[2]),
            Self(a[3], c[3]),
            Self(b[0], d[0]),
            Self(b[1], d[1]),
            Self(b[2], d[2]),
            Self(b[3], d[3]),
        ]
    }
}
