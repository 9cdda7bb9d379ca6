//! Gaussian process regression of gains over place: AEP's potential information gain.
//!
//! Selin et al. (RA-L 2019): zero mean and a squared-exponential kernel over the cached gains nearby.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// The kernel `signal^2 exp(-d^2 / (2 length^2))` and the noise of what is observed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernel {
    /// Length over which gains are alike, m.
    pub length: f64,
    /// Standard deviation of the process (sigma_f).
    pub signal: f64,
    /// Standard deviation of the observations (sigma_n).
    pub noise: f64,
}

impl Kernel {
    fn at(&self, a: &[f64; 3], b: &[f64; 3]) -> f64 {
        let square: f64 = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum();
        self.signal.powi(2) * (-0.5 * square / self.length.powi(2)).exp()
    }
}

/// What is known of a gain that was not computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posterior {
    /// Expected gain.
    pub mean: f64,
    /// Its variance, 0 to `signal^2`.
    pub variance: f64,
}

/// Prediction at a place from gains at others. Without any, or if the matrix cannot be factored, it is the prior: mean 0,
/// variance `signal^2`.
pub fn predict(kernel: &Kernel, places: &[[f64; 3]], gains: &[f64], at: [f64; 3]) -> Posterior {
    let prior = Posterior {
        mean: 0.0,
        variance: kernel.signal.powi(2),
    };
    let n = places.len().min(gains.len());
    if n == 0 {
        return prior;
    }
    let noise = kernel.noise.powi(2);
    let covariance = Mat::from_fn(n, n, |i, j| {
        kernel.at(&places[i], &places[j]) + if i == j { noise } else { 0.0 }
    });
    let Ok(factor) = covariance.llt(Side::Lower) else {
        return prior;
    };
    let cross = Mat::from_fn(n, 1, |i, _| kernel.at(&places[i], &at));
    // (K + noise)^-1 k gives mean and variance with one solve.
    let weights = factor.solve(&cross);
    let (mut mean, mut explained) = (0.0, 0.0);
    for i in 0..n {
        mean += weights[(i, 0)] * gains[i];
        explained += weights[(i, 0)] * cross[(i, 0)];
    }
    Posterior {
        mean,
        variance: (prior.variance - explained).max(0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const KERNEL: Kernel = Kernel {
        length: 1.0,
        signal: 1.0,
        noise: 0.1,
    };

    /// Dense oracle: Gauss-Jordan with partial pivoting on the whole system.
    fn dense(places: &[[f64; 3]], gains: &[f64], at: [f64; 3]) -> Posterior {
        let n = places.len();
        let k = |a: &[f64; 3], b: &[f64; 3]| {
            (-0.5 * (0..3).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum::<f64>()).exp()
        };
        let mut rows: Vec<Vec<f64>> = (0..n)
            .map(|i| {
                let mut row: Vec<f64> = (0..n).map(|j| k(&places[i], &places[j])).collect();
                row[i] += 0.01;
                row.push(k(&places[i], &at));
                row
            })
            .collect();
        for c in 0..n {
            let pivot = (c..n)
                .max_by(|a, b| rows[*a][c].abs().total_cmp(&rows[*b][c].abs()))
                .unwrap_or(c);
            rows.swap(c, pivot);
            let own = rows[c].clone();
            for (r, row) in rows.iter_mut().enumerate() {
                let factor = if r == c {
                    1.0 - 1.0 / own[c]
                } else {
                    row[c] / own[c]
                };
                for (v, o) in row.iter_mut().zip(&own) {
                    *v -= factor * o;
                }
            }
        }
        let weights: Vec<f64> = rows.iter().map(|row| row[n]).collect();
        let mean = weights.iter().zip(gains).map(|(w, g)| w * g).sum();
        let explained: f64 = weights.iter().zip(places).map(|(w, p)| w * k(p, &at)).sum();
        Posterior {
            mean,
            variance: 1.0 - explained,
        }
    }

    #[test]
    fn without_gains_the_prior_is_all_there_is() {
        let p = predict(&KERNEL, &[], &[], [0.0; 3]);
        assert_eq!((p.mean, p.variance), (0.0, 1.0));
    }

    #[test]
    fn a_gain_is_believed_where_it_was_taken_and_forgotten_far_off() {
        let places = [[1.0, 2.0, 1.0]];
        let here = predict(&KERNEL, &places, &[8.0], places[0]);
        assert!((here.mean - 8.0 / 1.01).abs() < 1e-9 && here.variance < 0.01);
        let far = predict(&KERNEL, &places, &[8.0], [9.0, 2.0, 1.0]);
        assert!(far.mean < 1e-9 && far.variance > 1.0 - 1e-9);
    }

    proptest! {
        #[test]
        fn the_posterior_is_that_of_the_dense_system(
            points in prop::collection::vec((prop::array::uniform3(-2.0..2.0f64), 0.0..30.0f64), 1..40),
            at in prop::array::uniform3(-2.5..2.5f64),
        ) {
            let (places, gains): (Vec<_>, Vec<_>) = points.into_iter().unzip();
            let got = predict(&KERNEL, &places, &gains, at);
            let want = dense(&places, &gains, at);
            prop_assert!((got.mean - want.mean).abs() < 1e-6 * (1.0 + want.mean.abs()), "{got:?} {want:?}");
            prop_assert!((got.variance - want.variance).abs() < 1e-8);
            prop_assert!((0.0..=1.0).contains(&got.variance));
        }
    }
}
