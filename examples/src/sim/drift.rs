//! The error of localisation: the pose that the robot believes wanders slowly about the true one.

use super::PointScan;
use super::body::CameraPose;
use super::step::{State, TICK};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// How far off localisation is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriftModel {
    /// Standard deviation of x and of y, m.
    pub position: f64,
    /// Standard deviation of the yaw, rad.
    pub heading: f64,
    /// Time over which an error keeps 1/e of itself, s.
    pub correlation: f64,
    /// Seed.
    pub seed: u64,
}

/// A first-order Gauss-Markov process for each of x, y and yaw, zero at the start: the map's frame is that of the start.
#[derive(Clone, Debug)]
pub struct Drift {
    model: DriftModel,
    random: ChaCha8Rng,
    /// Believed minus true x, y (m, world) and yaw (rad).
    error: [f64; 3],
    moved: PointScan,
}

impl Drift {
    /// No error yet.
    pub fn new(model: DriftModel) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(model.seed);
        random.set_stream(7);
        Self {
            model,
            random,
            error: [0.0; 3],
            moved: PointScan::default(),
        }
    }

    /// Believed minus true x, y (m) and yaw (rad).
    pub fn error(&self) -> [f64; 3] {
        self.error
    }

    fn normal(&mut self) -> f64 {
        let mut uniform = || (self.random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let (a, b) = (uniform(), uniform());
        // Box-Muller; 1 - a lies in (0, 1].
        (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }

    /// One tick on.
    pub fn advance(&mut self) {
        let keep = (-TICK / self.model.correlation).exp();
        let fresh = (1.0 - keep * keep).sqrt();
        let sizes = [self.model.position, self.model.position, self.model.heading];
        for (k, sigma) in sizes.into_iter().enumerate() {
            self.error[k] = keep * self.error[k] + fresh * sigma * self.normal();
        }
    }

    /// The state with the pose that is believed.
    pub fn state(&self, truth: &State) -> State {
        State {
            base: [0, 1, 2].map(|k| truth.base[k] + self.error[k]),
            ..*truth
        }
    }

    /// A world point as it is measured from a robot at the true base pose and put where the believed one is.
    fn point(&self, base: &[f64; 3], p: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = self.error[2].sin_cos();
        let d = [p[0] - base[0], p[1] - base[1]];
        [
            base[0] + self.error[0] + cos * d[0] - sin * d[1],
            base[1] + self.error[1] + sin * d[0] + cos * d[1],
            p[2],
        ]
    }

    /// The camera pose that is believed.
    pub fn camera(&self, base: &[f64; 3], (rotation, at): &CameraPose) -> CameraPose {
        let (sin, cos) = self.error[2].sin_cos();
        let turned = [
            [0, 1, 2].map(|k| cos * rotation[0][k] - sin * rotation[1][k]),
            [0, 1, 2].map(|k| sin * rotation[0][k] + cos * rotation[1][k]),
            rotation[2],
        ];
        (turned, self.point(base, *at))
    }

    /// A scan taken from the true base pose, as it is believed to lie.
    pub fn scan(&mut self, base: &[f64; 3], scan: &PointScan) -> &PointScan {
        let mut moved = std::mem::take(&mut self.moved);
        moved.origin = self.point(base, scan.origin);
        moved.max_range = scan.max_range;
        for (out, points) in [
            (&mut moved.hits, &scan.hits),
            (&mut moved.misses, &scan.misses),
        ] {
            out.clear();
            out.extend(
                points
                    .iter()
                    .map(|p| self.point(base, p.map(f64::from)).map(|v| v as f32)),
            );
        }
        self.moved = moved;
        &self.moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: DriftModel = DriftModel {
        position: 0.02,
        heading: 0.01,
        correlation: 5.0,
        seed: 3,
    };

    #[test]
    fn the_error_has_its_size_and_is_slow() {
        let mut drift = Drift::new(MODEL);
        let (mut squares, mut jump) = ([0.0; 3], 0.0_f64);
        let n = 500_000;
        for _ in 0..n {
            let before = drift.error();
            drift.advance();
            for k in 0..3 {
                squares[k] += drift.error()[k].powi(2);
            }
            jump = jump.max((drift.error()[0] - before[0]).abs());
        }
        for (k, sigma) in [0.02, 0.02, 0.01].into_iter().enumerate() {
            // 500000 ticks are 2000 correlation times: the deviation is known to about 2 %.
            let ratio = (squares[k] / f64::from(n)).sqrt() / sigma;
            assert!((ratio - 1.0).abs() < 0.1, "{k}: {ratio}");
        }
        // sigma sqrt(2 TICK / correlation) is 1.8 mm; 6 of it in half a million draws are rare enough.
        assert!(jump < 0.011, "{jump}");
    }

    #[test]
    fn a_scan_moves_with_the_robot() {
        let mut drift = Drift::new(MODEL);
        for _ in 0..1000 {
            drift.advance();
        }
        let truth = State {
            base: [1.0, -2.0, 0.7],
            joints: [0.0; 6],
            v: 0.0,
            w: 0.0,
            qd: [0.0; 6],
        };
        let believed = drift.state(&truth);
        let local = |base: [f64; 3], p: [f64; 3]| {
            let (s, c) = base[2].sin_cos();
            let d = [p[0] - base[0], p[1] - base[1]];
            [c * d[0] + s * d[1], c * d[1] - s * d[0], p[2]]
        };
        let scan = PointScan {
            origin: [1.2, -2.1, 0.4],
            hits: vec![[4.0, 1.0, 0.5]],
            misses: vec![[-3.0, 2.0, 1.5]],
            max_range: 10.0,
        };
        let moved = drift.scan(&truth.base, &scan).clone();
        assert!(moved != scan);
        let pairs = [
            (scan.origin, moved.origin),
            (scan.hits[0].map(f64::from), moved.hits[0].map(f64::from)),
            (
                scan.misses[0].map(f64::from),
                moved.misses[0].map(f64::from),
            ),
        ];
        for (from, to) in pairs {
            let (a, b) = (local(truth.base, from), local(believed.base, to));
            for k in 0..3 {
                // f32 points.
                assert!((a[k] - b[k]).abs() < 1e-5, "{a:?} {b:?}");
            }
        }
    }
}
