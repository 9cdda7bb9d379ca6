//! The relaxed logarithmic barrier (HEATS eq. 9; Feller and Ebenbauer 2017), with an optional end.

use crate::elementary::ln;
use crate::error::{Error, positive};
use crate::simd::Vector;

/// Penalty of `z > 0`: `-mu ln z` above `delta`, its second-order continuation below, so that value, slope and curvature are
/// continuous and a violated constraint still has a gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barrier {
    /// Weight.
    pub mu: f64,
    /// Where the logarithm is relaxed, in the unit of z.
    pub delta: f64,
    /// Beyond this the penalty is zero, in the unit of z; the logarithm is bent so that value, slope and curvature vanish there.
    /// `None` as published: far constraints push too.
    pub cutoff: Option<f64>,
}

impl Default for Barrier {
    /// mu = 1e-3, delta = 3e-4: tracks within a few per cent of the hard-constrained optimum at the same number of iterations
    /// as the published figures; constraints need a margin of a few mm.
    fn default() -> Self {
        Self {
            mu: 1e-3,
            delta: 3e-4,
            cutoff: None,
        }
    }
}

impl Barrier {
    /// The published figures: mu = 1e-2, delta = 1e-3.
    pub fn paper() -> Self {
        Self {
            mu: 1e-2,
            delta: 1e-3,
            cutoff: None,
        }
    }

    /// The same barrier, zero beyond `cutoff`.
    #[must_use]
    pub fn until(self, cutoff: f64) -> Self {
        Self {
            cutoff: Some(cutoff),
            ..self
        }
    }

    /// Checks mu, delta and the cut-off.
    ///
    /// # Errors
    /// The first that is not positive, or a cut-off not above delta.
    pub fn validate(&self) -> Result<(), Error> {
        positive("mu", self.mu)?;
        positive("delta", self.delta)?;
        match self.cutoff {
            Some(cutoff) => positive("cutoff - delta", cutoff - self.delta),
            None => Ok(()),
        }
    }

    /// Value, slope and curvature at `z`.
    #[inline]
    pub fn eval(&self, z: f64) -> (f64, f64, f64) {
        if self.cutoff.is_some_and(|cutoff| z >= cutoff) {
            return (0.0, 0.0, 0.0);
        }
        let c = z.max(self.delta);
        // HEATS eq. 9: t is -1 on the logarithmic branch, so that one formula serves both.
        let t = (z.min(self.delta) - 2.0 * self.delta) / self.delta;
        let value = -c.ln() + 0.5 * (t * t - 1.0);
        let slope = -1.0 / c + (t + 1.0) / self.delta;
        let curvature = 1.0 / (c * c);
        match self.cutoff {
            None => (self.mu * value, self.mu * slope, self.mu * curvature),
            Some(end) => {
                // Less the second-order expansion of -ln at the end.
                let d = (z - end) / end;
                (
                    self.mu * (value + end.ln() + d - 0.5 * d * d),
                    self.mu * (slope + (1.0 - d) / end),
                    self.mu * (curvature - 1.0 / (end * end)),
                )
            }
        }
    }

    /// Value alone.
    #[inline]
    pub fn value(&self, z: f64) -> f64 {
        self.eval(z).0
    }
}

/// A barrier over many lanes that adds up as it goes: slopes and curvatures at once, values as one logarithm of a product.
pub(crate) struct Sum<V> {
    mu: V,
    delta: V,
    inverse_delta: V,
    /// Cut-off and its inverse.
    end: Option<(V, V)>,
    /// Product of the arguments of pending logarithms.
    product: V,
    pending: u32,
    /// What is not logarithms.
    rest: V,
    logarithms: V,
    least: V,
}

/// Logarithms whose arguments are multiplied before one is taken: (1e-12)^20 is still a normal number.
const PENDING: u32 = 20;

impl<V: Vector> Sum<V> {
    /// Of nothing yet, each term weighted by `weight`.
    #[inline(always)]
    pub(crate) fn new(barrier: &Barrier, weight: f64) -> Self {
        Self {
            mu: V::splat(barrier.mu * weight),
            delta: V::splat(barrier.delta),
            inverse_delta: V::splat(1.0 / barrier.delta),
            end: barrier
                .cutoff
                .map(|end| (V::splat(end), V::splat(1.0 / end))),
            product: V::splat(1.0),
            pending: 0,
            rest: V::zero(),
            logarithms: V::zero(),
            least: V::splat(f64::INFINITY),
        }
    }

    /// Adds the barrier at `z`.
    #[inline(always)]
    pub(crate) fn add_value(&mut self, z: V) {
        self.add_parts(z);
    }

    /// Adds the barrier at `z`; returns its slope and curvature.
    #[inline(always)]
    pub(crate) fn add(&mut self, z: V) -> (V, V) {
        let one = V::splat(1.0);
        let (c, t, d) = self.add_parts(z);
        let i = one / c;
        let mut slope = (t + one) * self.inverse_delta - i;
        let mut curvature = i * i;
        if let Some((_, inverse)) = self.end {
            slope = (one - d).mul_add(inverse, slope);
            curvature = inverse.neg_mul_add(inverse, curvature);
        }
        (slope * self.mu, curvature * self.mu)
    }

    /// Adds the barrier at `z`; returns the logarithm's argument, t of HEATS eq. 9, and the way to the cut-off over the cut-off.
    #[inline(always)]
    fn add_parts(&mut self, z: V) -> (V, V, V) {
        self.least = z.min(self.least);
        // Bent so that everything vanishes at the cut-off: clamping z there is all it takes.
        let z = match self.end {
            Some((end, _)) => z.min(end),
            None => z,
        };
        let c = z.max(self.delta);
        let t = (z.min(self.delta) - (self.delta + self.delta)) * self.inverse_delta;
        let mut rest = (t.mul_add(t, -V::splat(1.0))) * V::splat(0.5);
        let mut d = V::zero();
        if let Some((end, inverse)) = self.end {
            d = (z - end) * inverse;
            rest = rest + (d * V::splat(-0.5)).mul_add(d, d);
            self.product = self.product * (c * inverse);
        } else {
            self.product = self.product * c;
        }
        self.rest = self.rest + rest;
        self.pending += 1;
        if self.pending >= PENDING {
            self.flush();
        }
        (c, t, d)
    }

    #[inline(always)]
    fn flush(&mut self) {
        self.logarithms = self.logarithms + ln(self.product);
        self.product = V::splat(1.0);
        self.pending = 0;
    }

    /// Sum of the values in each lane, and the least z.
    #[inline(always)]
    pub(crate) fn finish(mut self) -> (V, V) {
        self.flush();
        ((self.rest - self.logarithms) * self.mu, self.least)
    }
}
