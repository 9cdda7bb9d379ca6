//! Laws of the belief (FLAP eq. 1 and 3).
#![allow(missing_docs, clippy::unwrap_used)]

use objsearch::{cell_probability, cell_weight, probability_of};
use proptest::prelude::*;

proptest! {
    /// Seeing every cell of a volume finds the target with the volume's probability.
    #[test]
    fn cells_conserve_the_volume_probability(volume in 0.0..0.999f64, cells in 1..100_000usize) {
        let all = cells as f64 * cell_weight(volume, cells).unwrap();
        prop_assert!((probability_of(all) - volume).abs() < 1e-12);
    }

    /// Eq. 1 as printed.
    #[test]
    fn cells_follow_equation_1(volume in 0.0..0.99f64, cells in 1..10_000usize) {
        let printed = 1.0 - (1.0 - volume).powf(1.0 / cells as f64);
        prop_assert!((cell_probability(volume, cells).unwrap() - printed).abs() < 1e-12);
    }

    /// Disjoint sets multiply their misses (eq. 3).
    #[test]
    fn weights_add_where_misses_multiply(a in 0.0..5.0f64, b in 0.0..5.0f64) {
        let joint = 1.0 - (1.0 - probability_of(a)) * (1.0 - probability_of(b));
        prop_assert!((probability_of(a + b) - joint).abs() < 1e-12);
    }
}
