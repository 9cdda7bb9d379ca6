//! Shortest distances over a grid from one point, as a wave that runs as far as it is asked to.

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
    stride: usize,
    /// Factor on distance; infinity = blocked, NaN = not sampled yet.
    factor: Vec<f32>,
    pricing: Pricing,
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
        let f = self.pricing.factor(map.clearance(self.center(at))) as f32;
        self.factor[at] = f;
        f
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

/// Offsets of one neighbourhood: index offset, length in cells, the two cells a knight's move passes.
#[derive(Clone, Debug)]
struct Steps {
    straight: [(isize, f32); 8],
    knight: Vec<(isize, f32, isize, isize)>,
}

impl Steps {
    fn new(stride: usize, sixteen: bool) -> Self {
        let w = stride as isize;
        let d = std::f32::consts::SQRT_2;
        let straight = [
            (1, 1.0),
            (-1, 1.0),
            (w, 1.0),
            (-w, 1.0),
            (w + 1, d),
            (w - 1, d),
            (1 - w, d),
            (-w - 1, d),
        ];
        let mut knight = Vec::new();
        if sixteen {
            for (x, y) in [
                (2, 1),
                (1, 2),
                (-1, 2),
                (-2, 1),
                (-2, -1),
                (-1, -2),
                (1, -2),
                (2, -1),
            ] {
                let (x, y): (isize, isize) = (x, y);
                let long = if x.abs() == 2 {
                    x.signum()
                } else {
                    y.signum() * w
                };
                knight.push((y * w + x, 5f32.sqrt(), long, y.signum() * w + x.signum()));
            }
        }
        Self { straight, knight }
    }
}

/// Distances (cells times factor, in m) from one point, settled in order.
#[derive(Clone, Debug)]
pub(crate) struct Wave {
    dist: Vec<f32>,
    buckets: Vec<Vec<u32>>,
    /// Bucket in work, counted without wrapping.
    current: usize,
    waiting: usize,
    width: f32,
    steps: Steps,
    cell: f32,
}

impl Wave {
    /// Starts at `source`; if its cells are blocked, at every passable cell within `reach` m of it.
    pub(crate) fn new<C: Cells>(
        cells: &mut C,
        source: [f64; 2],
        reach: f64,
        sixteen: bool,
    ) -> Self {
        let cell = cells.raster().cell as f32;
        let p = cells.raster().pricing;
        // No edge is shorter than a bucket is wide, so a bucket's cells never improve one another.
        let longest = if sixteen { 5f64.sqrt() } else { 2f64.sqrt() } * (1.0 + p.narrow + p.weight);
        let mut wave = Self {
            dist: vec![f32::INFINITY; cells.raster().cells()],
            buckets: vec![Vec::new(); longest.ceil() as usize + 3],
            current: 0,
            waiting: 0,
            width: cell,
            steps: Steps::new(cells.raster().stride, sixteen),
            cell,
        };
        let mut seeds: Vec<(usize, f64)> = Vec::new();
        for (at, d) in cells.raster().around(source) {
            if cells.factor(at).is_finite() {
                seeds.push((at, d));
            }
        }
        // A source inside a blocked cell is blocked, even if a passable one is nearer than its own middle.
        let own = cells.raster().index(source);
        if own.is_none_or(|at| !cells.factor(at).is_finite()) {
            seeds.clear();
        }
        // On a middle, that cell is the source.
        if let Some(&one) = seeds.iter().find(|s| s.1 < 1e-6 * f64::from(cell)) {
            seeds = vec![one];
        }
        if seeds.is_empty() && reach > 0.0 {
            seeds = cells.raster().within(source, reach);
            seeds.retain(|&(at, _)| cells.factor(at).is_finite());
            // Only the nearest ones: the rest follow.
            let nearest = seeds.iter().map(|s| s.1).fold(f64::INFINITY, f64::min);
            seeds.retain(|s| s.1 <= nearest + 1.5 * cell as f64);
            let offset = (nearest / cell as f64).floor();
            if offset.is_finite() {
                wave.current = offset as usize;
            }
        }
        for (at, d) in seeds {
            let d = d as f32 * cells.factor(at);
            wave.offer(at, d.max(wave.current as f32 * wave.width));
        }
        wave
    }

    #[inline]
    fn offer(&mut self, at: usize, d: f32) {
        self.dist[at] = d;
        let n = self.buckets.len();
        let bucket = ((d / self.width) as usize).clamp(self.current, self.current + n - 2);
        self.buckets[bucket % n].push(at as u32);
        self.waiting += 1;
    }

    /// Runs until the cell's distance is final (or nothing is left), and returns it.
    #[inline]
    pub(crate) fn settle<C: Cells>(&mut self, cells: &mut C, at: usize) -> f32 {
        while self.waiting > 0 && self.dist[at] >= self.current as f32 * self.width {
            self.turn(cells);
        }
        self.dist[at]
    }

    pub(crate) fn settle_all<C: Cells>(&mut self, cells: &mut C) {
        while self.waiting > 0 {
            self.turn(cells);
        }
        self.buckets = Vec::new();
    }

    pub(crate) fn distance(&self, at: usize) -> f32 {
        self.dist[at]
    }

    /// Settles one bucket.
    fn turn<C: Cells>(&mut self, cells: &mut C) {
        let n = self.buckets.len();
        let slot = self.current % n;
        let mut list = std::mem::take(&mut self.buckets[slot]);
        self.waiting -= list.len();
        // Rounding adds up along a way and may put a cell below its bucket; one settled twice does no harm, one passed over
        // would cut off all behind it.
        let floor = (self.current as f32 - 0.25) * self.width;
        // Whatever is offered now goes to a later bucket: this one's list is taken out.
        self.current += 1;
        let half = 0.5 * self.cell;
        for &at in &list {
            let at = at as usize;
            let d = self.dist[at];
            // Reached again at a lower price since, and settled then.
            if d < floor {
                continue;
            }
            let here = cells.factor(at);
            for k in 0..8 {
                let (offset, length) = self.steps.straight[k];
                let to = at.wrapping_add_signed(offset);
                // A neighbour no edge could improve needs no sample.
                if self.dist[to] <= d {
                    continue;
                }
                let next = d + half * length * (here + cells.factor(to));
                if next < self.dist[to] {
                    self.offer(to, next);
                }
            }
            for k in 0..self.steps.knight.len() {
                let (offset, length, a, b) = self.steps.knight[k];
                let to = at.wrapping_add_signed(offset);
                if self.dist[to] <= d {
                    continue;
                }
                // The two cells on the way pay too: they close the step when blocked.
                let (a, b) = (
                    cells.factor(at.wrapping_add_signed(a)),
                    cells.factor(at.wrapping_add_signed(b)),
                );
                let next = d + 0.5 * half * length * (here + a + b + cells.factor(to));
                if next < self.dist[to] {
                    self.offer(to, next);
                }
            }
        }
        list.clear();
        self.buckets[slot] = list;
    }

    /// The cell up to `steps` straight or diagonal steps further down; neighbours that are not settled yet are no
    /// nearer to the source and never taken.
    pub(crate) fn ahead(&self, raster: &Raster, at: usize, steps: usize) -> usize {
        let half = 0.5 * self.cell;
        let mut here = at;
        for _ in 0..steps {
            let mut best = (f32::INFINITY, here);
            for &(offset, length) in &self.steps.straight {
                let to = here.wrapping_add_signed(offset);
                if self.dist[to] < self.dist[here] {
                    let cost =
                        self.dist[to] + half * length * (raster.factor[here] + raster.factor[to]);
                    if cost < best.0 {
                        best = (cost, to);
                    }
                }
            }
            here = best.1;
        }
        here
    }

    /// Cells from `at` down to the source, each the best next step.
    pub(crate) fn descend(&self, raster: &Raster, at: usize) -> Vec<usize> {
        let mut path = vec![at];
        let mut here = at;
        while self.dist[here].is_finite() {
            let mut best = (f32::INFINITY, here);
            let mut consider = |to: usize, cost: f32| {
                if self.dist[to] < self.dist[here] && self.dist[to] + cost < best.0 {
                    best = (self.dist[to] + cost, to);
                }
            };
            let half = 0.5 * self.cell;
            for &(offset, length) in &self.steps.straight {
                let to = here.wrapping_add_signed(offset);
                consider(
                    to,
                    half * length * (raster.factor[here] + raster.factor[to]),
                );
            }
            for &(offset, length, a, b) in &self.steps.knight {
                let to = here.wrapping_add_signed(offset);
                let side = raster.factor[here.wrapping_add_signed(a)]
                    + raster.factor[here.wrapping_add_signed(b)];
                consider(
                    to,
                    0.5 * half * length * (raster.factor[here] + side + raster.factor[to]),
                );
            }
            if best.1 == here {
                break;
            }
            here = best.1;
            path.push(here);
        }
        path
    }
}
