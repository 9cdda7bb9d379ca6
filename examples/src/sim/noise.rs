//! Range noise and drop-outs.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// How far a range sensor is from perfect. The default is perfect.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Standard deviation of the range as a share of the range.
    pub sigma: f64,
    /// Share of rays that return nothing at all, neither hit nor miss.
    pub dropout: f64,
    /// Seed.
    pub seed: u64,
}

/// A stream of disturbed ranges; one per sensor.
#[derive(Clone, Debug)]
pub(crate) struct Disturbance {
    noise: Noise,
    random: ChaCha8Rng,
}

impl Disturbance {
    pub(crate) fn new(noise: Noise, sensor: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(noise.seed);
        random.set_stream(sensor);
        Self { noise, random }
    }

    pub(crate) fn is_off(&self) -> bool {
        self.noise.sigma <= 0.0 && self.noise.dropout <= 0.0
    }

    /// Uniform in [0, 1).
    fn uniform(&mut self) -> f64 {
        (self.random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The factor by which a range is falsified; `None` when the ray is lost. Always draws the same amount, so
    /// that one ray's outcome does not shift the others.
    pub(crate) fn factor(&mut self) -> Option<f64> {
        let (lost, a, b) = (self.uniform(), self.uniform(), self.uniform());
        // Box-Muller; 1 - a lies in (0, 1].
        let normal = (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos();
        (lost >= self.noise.dropout).then(|| (1.0 + self.noise.sigma * normal).max(0.0))
    }
}
