//! Range noise, drop-outs and outliers.

use super::speckle::keep;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// How far a range sensor is from perfect. The default is perfect.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Standard deviation of the range as a share of the range.
    pub sigma: f64,
    /// Share of rays that return nothing at all, neither hit nor miss.
    pub dropout: f64,
    /// Share of rays that return a range drawn uniformly between the sensor's nearest and farthest. The sensor's driver then drops
    /// returns that no neighbour agrees with.
    pub outliers: f64,
    /// Seed.
    pub seed: u64,
}

/// A stream of disturbed ranges; one per sensor.
#[derive(Clone, Debug)]
pub(crate) struct Disturbance {
    noise: Noise,
    random: ChaCha8Rng,
    /// Outliers have a stream of their own, so that they change no other ray.
    wild: ChaCha8Rng,
    kept: Vec<bool>,
}

impl Disturbance {
    pub(crate) fn new(noise: Noise, sensor: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(noise.seed);
        random.set_stream(sensor);
        let mut wild = random.clone();
        wild.set_stream(sensor + 16);
        Self {
            noise,
            random,
            wild,
            kept: Vec::new(),
        }
    }

    pub(crate) fn is_off(&self) -> bool {
        self.noise.sigma <= 0.0 && self.noise.dropout <= 0.0 && !self.has_outliers()
    }

    /// Whether some returns are outliers; a whole image must then be [falsified](Self::falsify) at once.
    pub(crate) fn has_outliers(&self) -> bool {
        self.noise.outliers > 0.0
    }

    /// The factor by which a range is falsified; `None` when the ray is lost. Always draws the same amount, so
    /// that one ray's outcome does not shift the others.
    pub(crate) fn factor(&mut self) -> Option<f64> {
        let (lost, a, b) = (
            uniform(&mut self.random),
            uniform(&mut self.random),
            uniform(&mut self.random),
        );
        // Box-Muller; 1 - a lies in (0, 1].
        let normal = (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos();
        (lost >= self.noise.dropout).then(|| (1.0 + self.noise.sigma * normal).max(0.0))
    }

    /// Falsifies an image of ranges, rows of `width` (closed to rings if `around`): noise, outliers, and what the driver does
    /// against them. What is lost or dropped is NaN; ranges of `span.1` and more are misses and stay as they are, outliers aside.
    pub(crate) fn falsify(
        &mut self,
        range: &mut [f32],
        span: (f32, f32),
        width: usize,
        around: bool,
    ) {
        let (near, far) = (f64::from(span.0), f64::from(span.1));
        for range in range.iter_mut() {
            let (wild, share) = (uniform(&mut self.wild), uniform(&mut self.wild));
            let factor = self.factor();
            *range = match factor {
                None => f32::NAN,
                Some(_) if wild < self.noise.outliers => (near + share * (far - near)) as f32,
                Some(factor) if *range < span.1 * (1.0 - 1e-6) => *range * factor as f32,
                Some(_) => *range,
            };
        }
        let mut kept = std::mem::take(&mut self.kept);
        keep(range, width, around, self.noise.sigma, &mut kept);
        for (range, kept) in range.iter_mut().zip(&kept) {
            if !kept {
                *range = f32::NAN;
            }
        }
        self.kept = kept;
    }
}

/// Uniform in [0, 1).
fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}
