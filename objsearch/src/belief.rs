//! Where the target may be: volumes with probabilities, cells, and sets of cells (FLAP eq. 1 and 3).

use crate::Error;

/// `-ln(1 - p)` of one cell of a volume of `cells` cells that holds the target with `probability` (FLAP eq. 1).
///
/// Weights of cells add where the misses of FLAP eq. 3 multiply, without rounding loss.
///
/// # Errors
/// [`Error::Probability`] for `probability` outside (0, 1), [`Error::NoCells`] for no cells.
pub fn cell_weight(probability: f64, cells: usize) -> Result<f64, Error> {
    inside_unit("volume probability", probability)?;
    if cells == 0 {
        return Err(Error::NoCells);
    }
    Ok(-(-probability).ln_1p() / cells as f64)
}

/// Probability that one cell shows the target, `1 - (1 - P)^(1/N)` (FLAP eq. 1).
///
/// # Errors
/// As [`cell_weight`].
pub fn cell_probability(probability: f64, cells: usize) -> Result<f64, Error> {
    Ok(probability_of(cell_weight(probability, cells)?))
}

/// Probability to see the target in cells whose weights add up to `weight` (FLAP eq. 3): `1 - exp(-weight)`.
pub fn probability_of(weight: f64) -> f64 {
    -(-weight).exp_m1()
}

pub(crate) fn inside_unit(what: &'static str, value: f64) -> Result<(), Error> {
    if value > 0.0 && value < 1.0 {
        Ok(())
    } else {
        Err(Error::Probability {
            what,
            value,
            wanted: "above 0 and below 1",
        })
    }
}

/// A box of cells that holds at least one target with some probability.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// First cell.
    pub low: [i32; 3],
    /// First cell beyond.
    pub high: [i32; 3],
    /// Probability that the box holds the target (P_i).
    pub probability: f64,
}

impl Volume {
    /// The cells that an axis-aligned box from `low` to `high` (m) touches, in a grid whose cell [0, 0, 0] begins at
    /// `origin`. Both end cells count, as FLAP's key ranges do: a side of 0.8 m may touch 17 cells of 0.05 m.
    pub fn touching(
        low: [f64; 3],
        high: [f64; 3],
        origin: [f64; 3],
        cell_size: f64,
        probability: f64,
    ) -> Self {
        let cell = |p: [f64; 3]| [0, 1, 2].map(|a| ((p[a] - origin[a]) / cell_size).floor() as i32);
        Self {
            low: cell(low),
            high: cell(high).map(|c| c.saturating_add(1)),
            probability,
        }
    }

    /// Number of cells (N_i), free and occupied ones too.
    pub fn cells(&self) -> usize {
        (0..3)
            .map(|a| usize::try_from(i64::from(self.high[a]) - i64::from(self.low[a])).unwrap_or(0))
            .product()
    }

    /// True for a cell of the box.
    pub fn contains(&self, cell: [i32; 3]) -> bool {
        (0..3).all(|a| self.low[a] <= cell[a] && cell[a] < self.high[a])
    }
}

/// What is believed about the target's place.
#[derive(Clone, Debug, PartialEq)]
pub struct Belief {
    volumes: Vec<Volume>,
    weights: Vec<f64>,
}

impl Belief {
    /// Volumes in a map of the cells from `low` to below `high`.
    ///
    /// # Errors
    /// [`Error::Probability`], [`Error::EmptyVolume`] or [`Error::OutsideMap`] of the first volume that is wrong.
    pub fn new(volumes: &[Volume], (low, high): ([i32; 3], [i32; 3])) -> Result<Self, Error> {
        let mut weights = Vec::with_capacity(volumes.len());
        for (index, volume) in volumes.iter().enumerate() {
            if volume.cells() == 0 {
                return Err(Error::EmptyVolume {
                    volume: index,
                    low: volume.low,
                    high: volume.high,
                });
            }
            if (0..3).any(|a| volume.low[a] < low[a] || volume.high[a] > high[a]) {
                return Err(Error::OutsideMap {
                    volume: index,
                    low: volume.low,
                    high: volume.high,
                    map_low: low,
                    map_high: high,
                });
            }
            weights.push(cell_weight(volume.probability, volume.cells())?);
        }
        Ok(Self {
            volumes: volumes.to_vec(),
            weights,
        })
    }

    /// The volumes.
    pub fn volumes(&self) -> &[Volume] {
        &self.volumes
    }

    /// `-ln(1 - p)` of an unknown cell; 0 outside all volumes. Where volumes overlap their chances are independent, so
    /// p is `1 - prod(1 - p_i)` and the weights add.
    pub fn weight(&self, cell: [i32; 3]) -> f64 {
        self.volumes
            .iter()
            .zip(&self.weights)
            .filter(|(volume, _)| volume.contains(cell))
            .map(|(_, weight)| weight)
            .sum()
    }

    /// Every cell of the volumes once, with its weight, volume by volume, x fastest.
    pub fn cells(&self) -> impl Iterator<Item = ([i32; 3], f64)> + '_ {
        self.volumes.iter().enumerate().flat_map(move |(index, v)| {
            (v.low[2]..v.high[2])
                .flat_map(move |z| (v.low[1]..v.high[1]).map(move |y| [y, z]))
                .flat_map(move |[y, z]| (v.low[0]..v.high[0]).map(move |x| [x, y, z]))
                // A cell that an earlier volume holds was listed there.
                .filter(move |&cell| !self.volumes[..index].iter().any(|e| e.contains(cell)))
                .map(move |cell| (cell, self.weight(cell)))
        })
    }
}
