//! Contour-based segmentation of the cost map into regions: approximate convex decomposition by raster cuts.
//!
//! After Fermin-Leon, Neira and Castellanos (ICRA 2017), which HEATS cites, with the same concavity limit tau and the same
//! weight of a cut, but concavity taken as the plain distance to the hull's bridge and cuts burnt into the raster. Free
//! components are cut at their notches (contour vertices deeper than tau, and holes wider than tau) until no notch has a
//! legal cut.

mod contour;
mod cut;

use crate::costmap::{CostMap, Ground};
use crate::error::Error;
use std::collections::{BTreeMap, VecDeque};

/// Parameters of the segmentation.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionParams {
    /// Concavity that stays uncut, m. 2.5 in the publication, for every map.
    pub tau: f64,
    /// A cut whose ends lie nearer than this times tau along one contour is skinny and not made.
    pub skinny: f64,
    /// Tolerance of contour simplification, m.
    pub simplify: f64,
    /// Smaller regions are dropped, m2.
    pub min_area: f64,
}

impl Default for RegionParams {
    fn default() -> Self {
        Self {
            tau: 2.5,
            skinny: 1.0,
            simplify: 0.10,
            min_area: 0.25,
        }
    }
}

/// A labelling of ground cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Regions {
    cell_size: f64,
    low: [f64; 2],
    size: [usize; 2],
    /// Index into `ids`, `NONE` outside regions.
    labels: Vec<u32>,
    ids: Vec<u32>,
    centers: Vec<[f64; 2]>,
    areas: Vec<f64>,
    next_id: u32,
    /// The cost map's when it was segmented.
    revision: u64,
}

const NONE: u32 = u32::MAX;

impl Regions {
    /// Segments the free cells of a cost map. Labels count from 0 in index order.
    ///
    /// # Errors
    /// [`Error::Length`] for a tau, tolerance or area that is not positive.
    pub fn segment(grid: &CostMap, params: &RegionParams) -> Result<Self, Error> {
        for (field, value) in [
            ("tau", params.tau),
            ("skinny", params.skinny),
            ("simplify", params.simplify),
            ("min_area", params.min_area),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Error::Length { field, value });
            }
        }
        let size = grid.size();
        let image = cleaned(grid);
        let mut parts = components(&image, size);
        let mut done: Vec<Vec<usize>> = Vec::new();
        let h = grid.cell_size();
        let least = (params.min_area / (h * h)).ceil() as usize;
        // Each cut leaves smaller parts, so this ends.
        while let Some(part) = parts.pop() {
            if part.len() < least {
                continue;
            }
            match cut::split(&part, size, h, params) {
                Some(pieces) => parts.extend(pieces),
                None => done.push(part),
            }
        }
        for part in &mut done {
            part.sort_unstable();
        }
        done.sort_unstable();
        let mut labels = vec![NONE; image.len()];
        for (label, part) in done.iter().enumerate() {
            for &cell in part {
                labels[cell] = label as u32;
            }
        }
        spread(&mut labels, &image, size);
        let mut regions = Self {
            cell_size: h,
            low: grid.low(),
            size,
            labels,
            ids: (0..done.len() as u32).collect(),
            centers: Vec::new(),
            areas: Vec::new(),
            next_id: done.len() as u32,
            revision: grid.revision(),
        };
        regions.measure();
        Ok(regions)
    }

    /// Centres (the region's cell nearest to its centroid) and areas.
    fn measure(&mut self) {
        let n = self.ids.len();
        let mut sums = vec![([0.0; 2], 0usize); n];
        let center = |i: usize| {
            [
                (i % self.size[0]) as f64 + 0.5,
                (i / self.size[0]) as f64 + 0.5,
            ]
        };
        for (i, &label) in self.labels.iter().enumerate() {
            if label != NONE {
                let c = center(i);
                let sum = &mut sums[label as usize];
                sum.0[0] += c[0];
                sum.0[1] += c[1];
                sum.1 += 1;
            }
        }
        let mut best = vec![(f64::INFINITY, [0.0; 2]); n];
        for (i, &label) in self.labels.iter().enumerate() {
            if label != NONE {
                let (sum, count) = sums[label as usize];
                let c = center(i);
                let d = (0..2).map(|a| (c[a] - sum[a] / count as f64).powi(2)).sum();
                let slot = &mut best[label as usize];
                if d < slot.0 {
                    *slot = (d, c);
                }
            }
        }
        let h = self.cell_size;
        self.centers = best
            .iter()
            .map(|b| [0, 1].map(|a| self.low[a] + b.1[a] * h))
            .collect();
        self.areas = sums.iter().map(|s| s.1 as f64 * h * h).collect();
    }

    /// Number of regions.
    pub fn count(&self) -> usize {
        self.ids.len()
    }

    /// Ids of the regions, in index order of their first cells.
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// Id of the region of a cell.
    pub fn label(&self, [x, y]: [i32; 2]) -> Option<u32> {
        let inside = x >= 0 && y >= 0 && (x as usize) < self.size[0] && (y as usize) < self.size[1];
        let label = *self.labels.get(if inside {
            y as usize * self.size[0] + x as usize
        } else {
            usize::MAX
        })?;
        self.ids.get(label as usize).copied()
    }

    /// Id of the region of the labelled cell nearest to a point (king's steps, then index order); `None` without regions.
    pub fn nearest_label(&self, point: [f64; 2]) -> Option<u32> {
        if self.ids.is_empty() || !point.iter().all(|v| v.is_finite()) {
            return None;
        }
        let at = [0, 1].map(|a| {
            (((point[a] - self.low[a]) / self.cell_size).floor() as i32)
                .clamp(0, self.size[a] as i32 - 1)
        });
        for r in 0..self.size[0].max(self.size[1]) as i32 {
            for y in at[1] - r..=at[1] + r {
                let edge = y == at[1] - r || y == at[1] + r;
                let step = if edge || r == 0 { 1 } else { 2 * r as usize };
                for x in (at[0] - r..=at[0] + r).step_by(step) {
                    if let Some(id) = self.label([x, y]) {
                        return Some(id);
                    }
                }
            }
        }
        None
    }

    fn index_of(&self, id: u32) -> Option<usize> {
        self.ids.iter().position(|&i| i == id)
    }

    /// Centre of a region: its cell nearest to its centroid, m.
    pub fn center(&self, id: u32) -> Option<[f64; 2]> {
        self.index_of(id).map(|i| self.centers[i])
    }

    /// Area of a region, m2.
    pub fn area(&self, id: u32) -> Option<f64> {
        self.index_of(id).map(|i| self.areas[i])
    }

    /// Pairs of ids whose regions touch across a cell border, smaller id first, sorted.
    pub fn adjacency(&self) -> Vec<(u32, u32)> {
        let mut pairs = Vec::new();
        for i in 0..self.labels.len() {
            for j in [i + 1, i + self.size[0]] {
                let wraps = j == i + 1 && (i + 1) % self.size[0] == 0;
                let (Some(&a), Some(&b)) = (self.labels.get(i), self.labels.get(j)) else {
                    continue;
                };
                if !wraps && a != b && a != NONE && b != NONE {
                    let (a, b) = (self.ids[a as usize], self.ids[b as usize]);
                    pairs.push((a.min(b), a.max(b)));
                }
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// Segments anew if the cost map has changed since, and carries the labels over. Returns whether it did.
    ///
    /// # Errors
    /// As [`segment`](Self::segment); the regions then stay as they were.
    pub fn update(&mut self, grid: &CostMap, params: &RegionParams) -> Result<bool, Error> {
        if (grid.revision(), grid.low(), grid.size()) == (self.revision, self.low, self.size) {
            return Ok(false);
        }
        let mut regions = Self::segment(grid, params)?;
        regions.carry_labels(self);
        *self = regions;
        Ok(true)
    }

    /// Gives each region the id of the earlier region it overlaps most, each earlier id once; others get new ids. The earlier
    /// regions may be of other bounds, but of cells of the same size; otherwise all ids are new.
    pub fn carry_labels(&mut self, previous: &Self) {
        let mut overlap: BTreeMap<(u32, u32), usize> = BTreeMap::new();
        let shift = [0, 1].map(|a| ((self.low[a] - previous.low[a]) / self.cell_size).round());
        if self.cell_size == previous.cell_size {
            for (i, &now) in self.labels.iter().enumerate() {
                if now == NONE {
                    continue;
                }
                let at = [i % self.size[0], i / self.size[0]];
                let [x, y] = [0, 1].map(|a| at[a] as f64 + shift[a]);
                if x < 0.0
                    || y < 0.0
                    || x >= previous.size[0] as f64
                    || y >= previous.size[1] as f64
                {
                    continue;
                }
                let before = previous.labels[y as usize * previous.size[0] + x as usize];
                if before != NONE {
                    *overlap.entry((now, before)).or_default() += 1;
                }
            }
        }
        let mut pairs: Vec<(usize, u32, u32)> =
            overlap.into_iter().map(|((n, b), c)| (c, n, b)).collect();
        pairs.sort_unstable_by(|a, b| b.0.cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut ids = vec![NONE; self.ids.len()];
        let mut taken = vec![false; previous.ids.len()];
        for (_, now, before) in pairs {
            if ids[now as usize] == NONE && !taken[before as usize] {
                ids[now as usize] = previous.ids[before as usize];
                taken[before as usize] = true;
            }
        }
        self.next_id = previous.next_id;
        for id in &mut ids {
            if *id == NONE {
                *id = self.next_id;
                self.next_id += 1;
            }
        }
        self.ids = ids;
    }
}

/// Free cells, closed over specks of unknown, without the cells beside obstacles.
fn cleaned(grid: &CostMap) -> Vec<bool> {
    let [nx, ny] = grid.size();
    let mut image = vec![false; nx * ny];
    for y in 0..ny as i32 {
        for x in 0..nx as i32 {
            let mut free = 0;
            let mut obstacle = false;
            for dy in -1..=1 {
                for dx in -1..=1 {
                    match grid.ground([x + dx, y + dy]) {
                        Ground::Free => free += 1,
                        Ground::Obstacle => obstacle = true,
                        Ground::Unknown => {}
                    }
                }
            }
            let here = grid.ground([x, y]) == Ground::Free;
            image[y as usize * nx + x as usize] = !obstacle && (here || free >= 5);
        }
    }
    image
}

/// The 4-connected components, as sorted cell indices, in order of their first cells.
pub(crate) fn components(image: &[bool], size: [usize; 2]) -> Vec<Vec<usize>> {
    let mut seen: Vec<bool> = image.iter().map(|&free| !free).collect();
    let mut out = Vec::new();
    for first in 0..image.len() {
        if seen[first] {
            continue;
        }
        seen[first] = true;
        let mut part = vec![first];
        let mut next = 0;
        while next < part.len() {
            for j in beside(part[next], size) {
                if !seen[j] {
                    seen[j] = true;
                    part.push(j);
                }
            }
            next += 1;
        }
        part.sort_unstable();
        out.push(part);
    }
    out
}

/// The up to four neighbours of a cell index.
pub(crate) fn beside(i: usize, [nx, ny]: [usize; 2]) -> impl Iterator<Item = usize> {
    let (x, y) = (i % nx, i / nx);
    [
        (x > 0).then(|| i - 1),
        (x + 1 < nx).then(|| i + 1),
        (y > 0).then(|| i - nx),
        (y + 1 < ny).then(|| i + nx),
    ]
    .into_iter()
    .flatten()
}

/// Gives cells of the image without a label (burnt by a cut, or in dropped slivers) that of the nearest labelled cell.
fn spread(labels: &mut [u32], image: &[bool], size: [usize; 2]) {
    let mut queue: VecDeque<usize> = (0..labels.len()).filter(|&i| labels[i] != NONE).collect();
    while let Some(i) = queue.pop_front() {
        for j in beside(i, size) {
            if image[j] && labels[j] == NONE {
                labels[j] = labels[i];
                queue.push_back(j);
            }
        }
    }
}
