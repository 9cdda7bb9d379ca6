//! A grid over the map: what each cell costs to cross, sampled where it is asked about.

use crate::{Error, Map};

/// Cells around the grid that are always blocked, so that no neighbour needs a bounds test.
const PAD: usize = 2;

/// What a cell costs to cross, by its clearance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pricing {
    /// Cells with less clearance are blocked, m.
    pub(crate) need: f64,
    /// Cells with less clearance than this cost `narrow` more, m.
    pub(crate) fit: f64,
    pub(crate) narrow: f64,
    /// How many times a cell with less than `fit` in its middle is cut in four to see whether `fit` can be had
    /// anywhere in it; with 0 `need` decides alone.
    pub(crate) cuts: u32,
    /// Share added at `fit`, falling to nothing at `fit + comfort`.
    pub(crate) weight: f64,
    pub(crate) comfort: f64,
}

impl Pricing {
    pub(crate) fn factor(&self, clearance: f64) -> f64 {
        if clearance.is_nan() || clearance < self.need {
            return f64::INFINITY;
        }
        let narrow = if clearance < self.fit {
            self.narrow
        } else {
            0.0
        };
        1.0 + narrow + self.proximity(clearance)
    }

    /// The share of time that closeness adds.
    pub(crate) fn proximity(&self, clearance: f64) -> f64 {
        if self.weight <= 0.0 {
            return 0.0;
        }
        let near = (1.0 - (clearance - self.fit) / self.comfort).clamp(0.0, 1.0);
        self.weight * near * near
    }
}

/// A grid over a map's bounds with a factor on distance in every cell; sampled from the map when first asked.
#[derive(Clone, Debug)]
pub(crate) struct Raster {
    pub(crate) low: [f64; 2],
    pub(crate) cell: f64,
    pub(crate) size: [usize; 2],
    pub(crate) stride: usize,
    /// Factor on distance; infinity = blocked, NaN = not sampled yet.
    pub(crate) factor: Vec<f32>,
    pub(crate) pricing: Pricing,
    /// Multiplies the factor of cells sampled from now on.
    pub(crate) remote: f32,
}

impl Raster {
    pub(crate) fn new<M: Map>(map: &M, cell: f64, pricing: Pricing) -> Result<Self, Error> {
        let (low, high) = map.bounds();
        let bad = |must| Error::Bounds {
            low,
            high,
            cell_size: cell,
            must,
        };
        let extent = [high[0] - low[0], high[1] - low[1]];
        if !extent.iter().chain(&low).all(|v| v.is_finite()) || extent[0] <= 0.0 || extent[1] <= 0.0
        {
            return Err(bad("finite, upper corner above the lower one"));
        }
        let cells = extent.map(|e| (e / cell - 1e-6).ceil().max(1.0));
        if cells[0] * cells[1] > 6.0e7 {
            return Err(bad("at most 6e7 cells; take larger cells"));
        }
        let size = [cells[0] as usize, cells[1] as usize];
        let stride = size[0] + 2 * PAD;
        let mut factor = vec![f32::INFINITY; stride * (size[1] + 2 * PAD)];
        for y in 0..size[1] {
            let row = (y + PAD) * stride + PAD;
            factor[row..row + size[0]].fill(f32::NAN);
        }
        Ok(Self {
            low,
            cell,
            size,
            stride,
            factor,
            pricing,
            remote: 1.0,
        })
    }

    /// Multiplies the factor of the cells along the first metres of a way and to its sides (`(length, width)`, m).
    pub(crate) fn make_dear<M: Map>(
        &mut self,
        map: &M,
        way: &[usize],
        (length, width): (f64, f64),
        by: f32,
    ) {
        let count = ((length / self.cell).ceil() as usize).min(way.len());
        let mut cells: Vec<usize> = way[..count]
            .iter()
            .flat_map(|&at| self.within(self.center(at), width))
            .map(|c| c.0)
            .collect();
        cells.sort_unstable();
        cells.dedup();
        for at in cells {
            if self.factor[at].is_nan() {
                self.sample(map, at);
            }
            self.factor[at] *= by;
        }
    }

    /// Multiplies the factor of all cells further than `width` m from the points of a way.
    pub(crate) fn keep_to<M: Map>(&mut self, map: &M, way: &[[f64; 2]], width: f64, by: f32) {
        let mut beside = vec![false; self.factor.len()];
        for &p in way {
            for (at, _) in self.within(p, width) {
                beside[at] = true;
            }
        }
        for (at, beside) in beside.into_iter().enumerate() {
            if !beside {
                self.factor[at] *= by;
            } else if self.factor[at].is_nan() {
                self.sample(map, at);
            }
        }
        self.remote *= by;
    }

    /// The cell and those around it.
    pub(crate) fn around_cell(&self, at: usize) -> [usize; 9] {
        let w = self.stride;
        [
            at,
            at - 1,
            at + 1,
            at - w,
            at + w,
            at - w - 1,
            at - w + 1,
            at + w - 1,
            at + w + 1,
        ]
    }

    /// Lower corner of a cell, m.
    pub(crate) fn corner(&self, at: usize) -> [f64; 2] {
        self.center(at).map(|v| v - 0.5 * self.cell)
    }

    /// Index of the cell that holds `p`, or `None` outside.
    pub(crate) fn index(&self, p: [f64; 2]) -> Option<usize> {
        let u = (p[0] - self.low[0]) / self.cell;
        let v = (p[1] - self.low[1]) / self.cell;
        if u >= 0.0 && v >= 0.0 && u < self.size[0] as f64 && v < self.size[1] as f64 {
            Some((v as usize + PAD) * self.stride + u as usize + PAD)
        } else {
            None
        }
    }

    /// Middle of the cell, m.
    pub(crate) fn center(&self, at: usize) -> [f64; 2] {
        let (x, y) = (
            (at % self.stride) as f64 - PAD as f64,
            (at / self.stride) as f64 - PAD as f64,
        );
        [
            self.low[0] + (x + 0.5) * self.cell,
            self.low[1] + (y + 0.5) * self.cell,
        ]
    }

    /// Factor of a cell sampled before (NaN if not).
    pub(crate) fn sampled(&self, at: usize) -> f32 {
        self.factor[at]
    }

    /// Samples every cell now.
    pub(crate) fn sample_all<M: Map>(&mut self, map: &M) {
        for at in 0..self.factor.len() {
            if self.factor[at].is_nan() {
                self.sample(map, at);
            }
        }
    }

    #[inline(never)]
    fn sample<M: Map>(&mut self, map: &M, at: usize) -> f32 {
        let (center, half) = (self.center(at), 0.5 * self.cell);
        let clearance = map.clearance(center);
        let mut f = self.pricing.factor(clearance) as f32;
        let cuts = self.pricing.cuts;
        if cuts > 0 && f.is_finite() && !self.may_fit(map, center, half, clearance, cuts) {
            f = f32::INFINITY;
        }
        f *= self.remote;
        self.factor[at] = f;
        f
    }

    /// Whether some part of the square with clearance `here` in its middle may hold a point with the clearance to fit.
    fn may_fit<M: Map>(&self, map: &M, middle: [f64; 2], half: f64, here: f64, cuts: u32) -> bool {
        let fit = self.pricing.fit;
        // Clearance grows by no more than the distance.
        if here >= fit || here + half * std::f64::consts::SQRT_2 < fit {
            return here >= fit;
        }
        cuts == 0
            || [(-1.0, -1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0)]
                .into_iter()
                .any(|(x, y)| {
                    let p = [middle[0] + 0.5 * half * x, middle[1] + 0.5 * half * y];
                    self.may_fit(map, p, 0.5 * half, map.clearance(p), cuts - 1)
                })
    }

    /// The four cells whose middles surround `p` and the distance to each middle, m.
    pub(crate) fn around(&self, p: [f64; 2]) -> [(usize, f64); 4] {
        let clamp = |v: f64, n: usize| (v.floor().max(-1.0) as i64).min(n as i64 - 1);
        let x = clamp((p[0] - self.low[0]) / self.cell - 0.5, self.size[0]) + PAD as i64;
        let y = clamp((p[1] - self.low[1]) / self.cell - 0.5, self.size[1]) + PAD as i64;
        let base = y as usize * self.stride + x as usize;
        [base, base + 1, base + self.stride, base + self.stride + 1].map(|at| {
            let c = self.center(at);
            (at, (c[0] - p[0]).hypot(c[1] - p[1]))
        })
    }

    /// Cells no further than `reach` m from `p`, by index, with the distance of their middles.
    pub(crate) fn within(&self, p: [f64; 2], reach: f64) -> Vec<(usize, f64)> {
        let span = |axis: usize| {
            let at = |v: f64| {
                ((v - self.low[axis]) / self.cell - 0.5).clamp(0.0, self.size[axis] as f64 - 1.0)
            };
            (
                at(p[axis] - reach).ceil() as usize,
                at(p[axis] + reach).floor() as usize,
            )
        };
        let ((x0, x1), (y0, y1)) = (span(0), span(1));
        let mut out = Vec::new();
        for y in y0..=y1 {
            for x in x0..=x1 {
                let at = (y + PAD) * self.stride + x + PAD;
                let c = self.center(at);
                let d = (c[0] - p[0]).hypot(c[1] - p[1]);
                if d <= reach {
                    out.push((at, d));
                }
            }
        }
        out
    }

    pub(crate) fn cells(&self) -> usize {
        self.factor.len()
    }
}

/// Where a wave reads its cells.
pub(crate) trait Cells {
    fn raster(&self) -> &Raster;
    /// Factor on distance, infinity if blocked; never NaN.
    fn factor(&mut self, at: usize) -> f32;
}

/// A raster whose every cell is sampled.
impl Cells for &Raster {
    fn raster(&self) -> &Raster {
        self
    }
    #[inline]
    fn factor(&mut self, at: usize) -> f32 {
        self.factor[at]
    }
}

/// A raster that samples the map where the wave comes by.
pub(crate) struct Lazy<'a, M> {
    pub(crate) raster: &'a mut Raster,
    pub(crate) map: &'a M,
}

impl<M: Map> Cells for Lazy<'_, M> {
    fn raster(&self) -> &Raster {
        self.raster
    }
    #[inline]
    fn factor(&mut self, at: usize) -> f32 {
        let f = self.raster.factor[at];
        if f.is_nan() {
            self.raster.sample(self.map, at)
        } else {
            f
        }
    }
}
