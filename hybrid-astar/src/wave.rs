//! Shortest distances over a grid from one point, as a wave that runs as far as it is asked to.

use crate::raster::{Cells, Raster};

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
        let longest = if sixteen { 5f64.sqrt() } else { 2f64.sqrt() }
            * (1.0 + p.narrow + p.weight)
            * f64::from(cells.raster().remote);
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

    /// Whether no way leads from the cell to the source, found out early if the cell lies in a small pocket: beside the
    /// wave a flood runs from the cell, at a small part of the wave's effort.
    pub(crate) fn closed_off<C: Cells>(&mut self, cells: &mut C, at: usize) -> bool {
        if !cells.factor(at).is_finite() {
            return false;
        }
        const SHARE: usize = 8;
        let (mut seen, mut flood) = (vec![0u64; self.dist.len().div_ceil(64)], vec![at]);
        let mut effort = 0;
        while self.waiting > 0 && self.dist[at] >= self.current as f32 * self.width {
            effort += self.turn(cells);
            while effort >= SHARE {
                effort -= SHARE;
                let Some(here) = flood.pop() else {
                    return true;
                };
                if self.dist[here].is_finite() {
                    return false;
                }
                for k in 0..8 {
                    let to = here.wrapping_add_signed(self.steps.straight[k].0);
                    let (word, bit) = (to / 64, 1u64 << (to % 64));
                    if seen[word] & bit == 0 {
                        seen[word] |= bit;
                        if cells.factor(to).is_finite() {
                            flood.push(to);
                        }
                    }
                }
            }
        }
        self.dist[at].is_infinite()
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

    /// Settles one bucket; returns the number of cells in it.
    fn turn<C: Cells>(&mut self, cells: &mut C) -> usize {
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
        let count = list.len();
        list.clear();
        self.buckets[slot] = list;
        count
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
