//! One-to-all distances for a disc: costs of tours, reachability, straight paths.

use crate::error::{at_least, finite, positive};
use crate::raster::{Pricing, Raster};
use crate::wave::Wave;
use crate::{Error, Map};
use std::sync::Arc;

/// How many neighbours a grid path may step to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Neighbours {
    /// Straight and diagonal: up to 8.2 % longer than the straight line.
    #[default]
    Eight,
    /// Knight's moves too: up to 2.8 % longer, about twice the work.
    Sixteen,
}

/// Settings of a [`Field`].
#[derive(Clone, Debug, PartialEq)]
pub struct GridParams {
    /// Side of a cell, m.
    pub cell_size: f64,
    /// Neighbourhood.
    pub neighbours: Neighbours,
    /// Whether a cell counts as passable when the disc fits anywhere near its middle (half a diagonal less clearance
    /// than the radius). Then no passage is lost to the grid, and some too narrow ones stay open.
    pub admissible: bool,
    /// Share that distance grows by where the disc only just fits; 0 = plain metres.
    pub clearance_weight: f64,
    /// Distance beyond the radius at which clearance stops to matter, m.
    pub comfort: f64,
    /// If the source is blocked, how far away the wave may start instead, m.
    pub source_reach: f64,
}

impl Default for GridParams {
    fn default() -> Self {
        Self {
            cell_size: 0.15,
            neighbours: Neighbours::Eight,
            admissible: true,
            clearance_weight: 0.0,
            comfort: 0.4,
            source_reach: 0.6,
        }
    }
}

impl GridParams {
    /// Checks every field.
    pub fn validate(&self) -> Result<(), Error> {
        positive("cell_size", self.cell_size)?;
        at_least(
            "clearance_weight",
            self.clearance_weight,
            0.0,
            "finite and not negative",
        )?;
        at_least(
            "source_reach",
            self.source_reach,
            0.0,
            "finite and not negative",
        )?;
        positive("comfort", self.comfort)
    }
}

/// The cells a disc can occupy; made once a map revision, it makes each further [`Field`] cheaper.
#[derive(Clone, Debug)]
pub struct Space {
    raster: Arc<Raster>,
    params: GridParams,
}

impl Space {
    /// Samples the map's clearance at every cell for a disc of `radius` m.
    pub fn new<M: Map>(map: &M, radius: f64, params: &GridParams) -> Result<Self, Error> {
        params.validate()?;
        at_least("radius", radius, 0.0, "finite and not negative")?;
        let slack = if params.admissible {
            params.cell_size * std::f64::consts::FRAC_1_SQRT_2
        } else {
            0.0
        };
        let pricing = Pricing {
            need: radius - slack,
            fit: radius,
            narrow: 0.0,
            cuts: 0,
            weight: params.clearance_weight,
            comfort: params.comfort,
        };
        let mut raster = Raster::new(map, params.cell_size, pricing)?;
        raster.sample_all(map);
        Ok(Self {
            raster: Arc::new(raster),
            params: params.clone(),
        })
    }

    /// Distances from `source` (world, m) to every cell.
    pub fn field(&self, source: [f64; 2]) -> Result<Field, Error> {
        finite("source", &source)?;
        let sixteen = self.params.neighbours == Neighbours::Sixteen;
        let mut cells: &Raster = &self.raster;
        let mut wave = Wave::new(&mut cells, source, self.params.source_reach, sixteen);
        wave.settle_all(&mut cells);
        Ok(Field {
            raster: Arc::clone(&self.raster),
            wave,
            source,
        })
    }
}

/// Shortest distances of a disc's centre from one source to everywhere.
///
/// ```
/// use hybrid_astar::{Field, GridParams, grid::Grid};
/// let map = Grid::parse("#######\n#.....#\n#.###.#\n#.....#\n#######", 1.0);
/// let params = GridParams { cell_size: 1.0, admissible: false, ..GridParams::default() };
/// let field = Field::from(&map, 0.3, [1.5, 1.5], &params)?;
/// assert_eq!(field.distance([5.5, 1.5]), 4.0);
/// assert_eq!(field.distance([3.5, 2.5]), f64::INFINITY);
/// # Ok::<(), hybrid_astar::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Field {
    raster: Arc<Raster>,
    wave: Wave,
    source: [f64; 2],
}

impl Field {
    /// Distances of a disc of `radius` m from `source` (world, m) on `map`. For many sources make a [`Space`] once.
    pub fn from<M: Map>(
        map: &M,
        radius: f64,
        source: [f64; 2],
        params: &GridParams,
    ) -> Result<Self, Error> {
        finite("source", &source)?;
        Space::new(map, radius, params)?.field(source)
    }

    /// Where the distances start, m.
    pub fn source(&self) -> [f64; 2] {
        self.source
    }

    /// Metres (times the clearance factor, if one was asked for) from the source to `p`; infinite if unreachable,
    /// outside or not finite.
    pub fn distance(&self, p: [f64; 2]) -> f64 {
        match self.raster.index(p) {
            Some(at) if self.raster.sampled(at).is_finite() => self.nearest(p).1,
            _ => f64::INFINITY,
        }
    }

    /// Like [`distance`](Self::distance), but for a point that may itself be blocked: the way to the nearest reached
    /// cell within `reach` m, plus the gap.
    pub fn distance_near(&self, p: [f64; 2], reach: f64) -> f64 {
        let here = self.distance(p);
        if here.is_finite() || !reach.is_finite() || !p.iter().all(|v| v.is_finite()) {
            return here;
        }
        let gap = |&(at, d): &(usize, f64)| self.wave.distance(at) as f64 + d;
        self.raster
            .within(p, reach)
            .iter()
            .map(gap)
            .fold(f64::INFINITY, f64::min)
    }

    /// A way from the source to `p` over the grid, m, ends included; empty if there is none.
    pub fn path(&self, p: [f64; 2]) -> Vec<[f64; 2]> {
        if !self.distance(p).is_finite() {
            return Vec::new();
        }
        let (at, _) = self.nearest(p);
        let mut path = vec![p];
        path.extend(
            self.wave
                .descend(&self.raster, at)
                .into_iter()
                .map(|c| self.raster.center(c)),
        );
        path.push(self.source);
        path.reverse();
        path.dedup_by(|a, b| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9);
        path
    }

    /// The best of the cells around `p` and the distance through it.
    fn nearest(&self, p: [f64; 2]) -> (usize, f64) {
        let direct = (p[0] - self.source[0]).hypot(p[1] - self.source[1]);
        let mut best = (0, f64::INFINITY);
        for (at, d) in self.raster.around(p) {
            let total = self.wave.distance(at) as f64
                + d * f64::from(self.raster.sampled(at).min(f32::MAX));
            if d < 1e-6 * self.raster.cell && total.is_finite() {
                return (at, total);
            }
            if total < best.1 {
                best = (at, total);
            }
        }
        // Two points between the same middles: no detour over one.
        if direct < self.raster.cell && best.1.is_finite() {
            best.1 = best.1.min(direct * f64::from(self.raster.sampled(best.0)));
        }
        best
    }
}
