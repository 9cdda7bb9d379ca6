//! Probabilities of cells and sets of cells: FLAP eq. 1, 3.

use crate::Error;

/// Probability that one unknown cell shows the target, when its volume of `cells` cells holds at least one with
/// `volume` (FLAP eq. 1): `1 - (1 - P)^(1/N)`.
///
/// # Errors
/// [`Error::Probability`] for `volume` outside [0, 1), [`Error::NoCells`] for no cells.
pub fn cell_probability(volume: f64, cells: usize) -> Result<f64, Error> {
    Ok(probability_of(cell_weight(volume, cells)?))
}

/// `-ln(1 - p)` of one cell. Weights of cells add where probabilities of FLAP eq. 3 multiply, without rounding loss.
///
/// # Errors
/// As [`cell_probability`].
pub fn cell_weight(volume: f64, cells: usize) -> Result<f64, Error> {
    if !(0.0..1.0).contains(&volume) {
        return Err(Error::Probability {
            what: "volume probability",
            value: volume,
        });
    }
    if cells == 0 {
        return Err(Error::NoCells);
    }
    Ok(-(-volume).ln_1p() / cells as f64)
}

/// Probability to see the target in cells whose weights add up to `weight` (FLAP eq. 3): `1 - exp(-weight)`.
pub fn probability_of(weight: f64) -> f64 {
    -(-weight).exp_m1()
}
