//! Eight doubles at once: the widest vectors the processor has, found at run time.
//!
//! A [`Kernel`] is written once over a [`Vector`]; [`dispatch`] compiles it for plain arrays and, on x86-64, for pairs of AVX2
//! registers with fused multiply-add and for AVX-512. All give the same values up to the rounding of the fused operation.
//! Where rows are short, kernels of [`NARROW`] lanes waste less ([`dispatch_narrow`]).
//!
//! The module `x86` is the only one of the crate with unsafe code; it says why it is sound.

mod portable;
#[cfg(target_arch = "x86_64")]
mod x86;

use std::ops::{Add, Div, Mul, Neg, Sub};

pub(crate) use portable::Portable;

/// Batches of points and knots come in groups of this many.
pub const LANES: usize = 8;

/// One quantity at [`LANES`] places.
pub type Lanes = [f64; LANES];

/// Lanes of kernels that work along short rows.
pub(crate) const NARROW: usize = 4;

/// A vector of `L` doubles. Comparisons with NaN keep the NaN of the first operand.
pub(crate) trait Vector<const L: usize = LANES>:
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
    fn load(v: &[f64; L]) -> Self;
    /// Into an array.
    fn store(self, to: &mut [f64; L]);
    /// self * b + c.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// c - self * b.
    fn neg_mul_add(self, b: Self, c: Self) -> Self;
    /// The larger in each lane.
    fn max(self, o: Self) -> Self;
    /// The smaller in each lane.
    fn min(self, o: Self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The size of self with the sign of `o`; self must not be negative.
    fn with_sign_of(self, o: Self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// One over the square root of positive normal numbers, to a few units in the last place.
    fn inverse_sqrt(self) -> Self;
    /// `yes` in the lanes where self < o, `no` elsewhere.
    fn if_less(self, o: Self, yes: Self, no: Self) -> Self;
    /// True if self < o in every lane.
    fn all_less(self, o: Self) -> bool;
    /// 2 to the power of each lane, which must hold an integer between -1022 and 1023.
    fn pow2(self) -> Self;
    /// Mantissa in [1, 2) and exponent of positive normal numbers.
    fn split(self) -> (Self, Self);
    /// Rows to columns.
    fn transpose(rows: [Self; L]) -> [Self; L];

    /// All zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }
    /// As an array.
    #[inline(always)]
    fn array(self) -> [f64; L] {
        let mut out = [0.0; L];
        self.store(&mut out);
        out
    }
}

/// A computation over vectors. Mark `run` as always inlined, so that it is compiled for each kind of vector.
pub(crate) trait Kernel<const L: usize = LANES> {
    /// What it returns.
    type Output;
    /// Does it.
    fn run<V: Vector<L>>(self) -> Self::Output;
}

/// Runs a kernel with the widest vectors there are.
#[inline]
pub(crate) fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    match x86::level() {
        x86::Level::Avx512(token) => return x86::wide_avx512(token, kernel),
        x86::Level::Avx2(token) => return x86::wide_avx2(token, kernel),
        x86::Level::None => {}
    }
    kernel.run::<Portable<LANES>>()
}

/// Runs a kernel of [`NARROW`] lanes.
#[inline]
pub(crate) fn dispatch_narrow<K: Kernel<NARROW>>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    match x86::level() {
        x86::Level::Avx512(token) => return x86::narrow_avx512(token, kernel),
        x86::Level::Avx2(token) => return x86::narrow_avx2(token, kernel),
        x86::Level::None => {}
    }
    kernel.run::<Portable<NARROW>>()
}

/// Runs copies of a kernel with every kind of vector that this processor has, plain arrays first.
#[cfg(test)]
pub(crate) fn with_every_kind<K: Kernel + Clone>(kernel: &K) -> Vec<K::Output> {
    let mut out = vec![kernel.clone().run::<Portable<LANES>>()];
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(token) = x86::avx2() {
            out.push(x86::wide_avx2(token, kernel.clone()));
        }
        if let Some(token) = x86::avx512() {
            out.push(x86::wide_avx512(token, kernel.clone()));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::{Kernel, LANES, Lanes, Vector, with_every_kind};

    /// Every operation on three vectors.
    #[derive(Clone)]
    struct All([Lanes; 3]);

    impl Kernel for All {
        type Output = Vec<Lanes>;
        #[inline(always)]
        fn run<V: Vector>(self) -> Vec<Lanes> {
            let [a, b, c] = [
                V::load(&self.0[0]),
                V::load(&self.0[1]),
                V::load(&self.0[2]),
            ];
            let (mantissa, exponent) = (a.abs() + V::splat(0.1)).split();
            let mut out = vec![
                a + b,
                a - b,
                a * b,
                a / b,
                -a,
                a.mul_add(b, c),
                a.neg_mul_add(b, c),
                a.max(b),
                a.min(b),
                a.abs(),
                a.abs().with_sign_of(b),
                a.abs().sqrt(),
                (a.abs() + V::splat(1e-12)).inverse_sqrt(),
                a.if_less(b, b, c),
                V::splat(if a.all_less(a.abs() + V::splat(1.0)) {
                    1.0
                } else {
                    0.0
                }),
                V::splat(if a.all_less(b) { 1.0 } else { 0.0 }),
                V::load(&[-3.0, 0.0, 1.0, 10.0, -1022.0, 1023.0, 5.0, -7.0]).pow2(),
                mantissa,
                exponent,
                V::zero(),
            ];
            let mut rows = [a; LANES];
            for (i, row) in rows.iter_mut().enumerate() {
                *row = a.mul_add(V::splat(i as f64), b);
            }
            out.extend(V::transpose(rows));
            out.into_iter().map(V::array).collect()
        }
    }

    #[test]
    fn every_kind_of_vector_gives_what_arrays_give() {
        let a = [1.5, -2.25, 0.0, 3e5, -1e-9, 7.0, -0.5, 11.0];
        let b = [-1.0, 4.0, 2.0, 3.5, -1e-3, 7.0, 0.25, -8.0];
        let c = [0.5, 1.0, -2.0, 1e3, 9.0, -7.0, 0.125, 1.0];
        let all = with_every_kind(&All([a, b, c]));
        for other in &all[1..] {
            assert_eq!(all[0].len(), other.len());
            for (k, (x, y)) in all[0].iter().zip(other).enumerate() {
                for lane in 0..LANES {
                    let (x, y) = (x[lane], y[lane]);
                    assert!(
                        (x - y).abs() <= 4e-16 * x.abs(),
                        "{k}, lane {lane}: {x} and {y}"
                    );
                }
            }
        }
        // Row i of the transposed was a i + b.
        let columns = &all[0][all[0].len() - LANES..];
        for lane in 0..LANES {
            for i in 0..LANES {
                assert_eq!(columns[lane][i], a[lane] * i as f64 + b[lane]);
            }
        }
    }

    #[test]
    fn what_is_not_a_number_stays_so_in_the_first_operand() {
        #[derive(Clone)]
        struct Run;
        impl Kernel for Run {
            type Output = [Lanes; 3];
            #[inline(always)]
            fn run<V: Vector>(self) -> [Lanes; 3] {
                let (n, one) = (V::splat(f64::NAN), V::splat(1.0));
                [n.max(one).array(), n.min(one).array(), n.abs().array()]
            }
        }
        for found in with_every_kind(&Run) {
            assert!(found.as_flattened().iter().all(|v| v.is_nan()), "{found:?}");
        }
    }
}
