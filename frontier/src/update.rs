//! Clusters kept up to date while the map changes.

use crate::cluster::{Cluster, Kind, direction};
use crate::detect::word_of;
use crate::map::Map;
use crate::params::{Error, Params};
use crate::split::{halve, kmeans};
use crate::{Cell, CellBox};
use std::collections::{BTreeMap, BTreeSet};

/// What an update did to the clusters. Ids are in ascending order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Update {
    /// New clusters.
    pub added: Vec<u64>,
    /// Clusters that are gone.
    pub removed: Vec<u64>,
    /// Clusters that lost cells and kept their id.
    pub changed: Vec<u64>,
}

/// No cluster.
const NONE: u32 = u32::MAX;

/// Frontier cells of one kind, dense over the map's bounds.
#[derive(Clone, Debug)]
struct Layer {
    kind: Kind,
    low: Cell,
    size: [usize; 3],
    /// Words of a row.
    words: usize,
    bits: Vec<u64>,
    /// Low 32 bits of the owning cluster's id.
    owner: Vec<u32>,
}

impl Layer {
    fn new(kind: Kind, (low, high): CellBox) -> Self {
        let size = [0, 1, 2].map(|a| (high[a] - low[a]).max(0) as usize);
        let words = size[0].div_ceil(64);
        let total = words * size[1] * size[2];
        Self {
            kind,
            low,
            size,
            words,
            bits: vec![0; total],
            owner: vec![NONE; total * 64],
        }
    }

    fn address(&self, cell: Cell) -> Option<usize> {
        let [x, y, z] = [0, 1, 2].map(|a| cell[a].wrapping_sub(self.low[a]) as usize);
        (x < self.size[0] && y < self.size[1] && z < self.size[2])
            .then(|| (z * self.size[1] + y) * self.words * 64 + x)
    }

    fn holds(&self, cell: Cell) -> bool {
        self.address(cell)
            .is_some_and(|a| self.bits[a >> 6] >> (a & 63) & 1 != 0)
    }

    fn owner(&self, cell: Cell) -> u32 {
        self.address(cell).map_or(NONE, |a| self.owner[a])
    }

    fn set_owner(&mut self, cell: Cell, id: u32) {
        if let Some(a) = self.address(cell) {
            self.owner[a] = id;
        }
    }

    /// Looks at the boxes again; appends the cells that became frontier and that ceased to be.
    fn refresh(
        &mut self,
        map: &impl Map,
        boxes: &[CellBox],
        band: (i32, i32),
        gained: &mut Vec<Cell>,
        lost: &mut Vec<Cell>,
    ) {
        for (low, high) in boxes {
            // A cell's kind depends on its neighbours, so the box grows by one.
            let from = [0, 1, 2].map(|a| (low[a].saturating_sub(1)).max(self.low[a]));
            let to = [0, 1, 2]
                .map(|a| (high[a].saturating_add(1)).min(self.low[a] + self.size[a] as i32));
            if (0..3).any(|a| from[a] >= to[a]) {
                continue;
            }
            let first_word = (from[0] - self.low[0]) as usize / 64;
            let last_word = (to[0] - 1 - self.low[0]) as usize / 64;
            for z in from[2].max(band.0)..to[2].min(band.1) {
                for y in from[1]..to[1] {
                    let row = ((z - self.low[2]) as usize * self.size[1]
                        + (y - self.low[1]) as usize)
                        * self.words;
                    for w in first_word..=last_word {
                        let x = self.low[0] + (w * 64) as i32;
                        let now = word_of(map, self.kind, [x, y, z]);
                        let before = std::mem::replace(&mut self.bits[row + w], now);
                        for (mut bits, list) in
                            [(now & !before, &mut *gained), (before & !now, &mut *lost)]
                        {
                            while bits != 0 {
                                list.push([x + bits.trailing_zeros() as i32, y, z]);
                                bits &= bits - 1;
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Exploration and inspection frontiers of one map, in clusters.
#[derive(Clone, Debug)]
pub struct Frontiers {
    params: Params,
    layers: Option<[Layer; 2]>,
    clusters: BTreeMap<u64, Cluster>,
    next: u64,
}

impl Frontiers {
    /// No frontiers yet.
    ///
    /// # Errors
    /// The first parameter that is wrong.
    pub fn new(params: Params) -> Result<Self, Error> {
        params.validate()?;
        Ok(Self {
            params,
            layers: None,
            clusters: BTreeMap::new(),
            next: 0,
        })
    }

    /// Looks again at `boxes`, which must hold every cell whose state changed since the last call, and at the clusters they
    /// touch. The first call looks at the whole map; so does a call after the bounds changed.
    pub fn update(&mut self, map: &impl Map, boxes: &[CellBox]) -> Update {
        let bounds = map.bounds();
        let fresh = self.layers.as_ref().is_none_or(|[first, _]| {
            let high = [0, 1, 2].map(|a| first.low[a] + first.size[a] as i32);
            (first.low, high) != bounds
        });
        let mut update = Update::default();
        if fresh {
            update.removed = self.clusters.keys().copied().collect();
            self.clusters.clear();
        }
        let mut layers = match self.layers.take() {
            Some(layers) if !fresh => layers,
            _ => [Kind::Exploration, Kind::Inspection].map(|kind| Layer::new(kind, bounds)),
        };
        let whole = [bounds];
        let boxes = if fresh { &whole[..] } else { boxes };
        for layer in &mut layers {
            self.update_layer(map, layer, boxes, &mut update);
        }
        self.layers = Some(layers);
        update.removed.sort_unstable();
        update.changed.sort_unstable();
        update
    }

    fn least(&self, kind: Kind) -> usize {
        match kind {
            Kind::Exploration => self.params.min_exploration,
            Kind::Inspection => self.params.min_inspection,
        }
    }

    fn update_layer(
        &mut self,
        map: &impl Map,
        layer: &mut Layer,
        boxes: &[CellBox],
        update: &mut Update,
    ) {
        let band = match layer.kind {
            Kind::Exploration => self.params.exploration_band,
            Kind::Inspection => self.params.inspection_band,
        };
        let (mut gained, mut lost) = (Vec::new(), Vec::new());
        layer.refresh(map, boxes, band, &mut gained, &mut lost);
        // Overlapping boxes may report a cell twice in opposite directions only if the map changed meanwhile; it cannot.
        gained.sort_unstable();
        lost.sort_unstable();

        let mut touched: BTreeMap<u64, bool> = BTreeMap::new(); // id -> must be made anew
        for &cell in &lost {
            let owner = layer.owner(cell);
            layer.set_owner(cell, NONE);
            if owner != NONE {
                touched.entry(u64::from(owner)).or_insert(false);
            }
        }
        for &cell in &gained {
            for neighbour in around(cell) {
                let owner = layer.owner(neighbour);
                if owner != NONE {
                    touched.insert(u64::from(owner), true);
                }
            }
        }
        let least = self.least(layer.kind);
        let mut loose = gained;
        for (id, anew) in touched {
            let Some(cluster) = self.clusters.get_mut(&id) else {
                continue;
            };
            cluster.cells.retain(|&c| layer.holds(c));
            let left = cluster.cells.len();
            let shrunk = left as f64 >= (1.0 - self.params.shrink_share) * cluster.born as f64;
            if !anew && left > 0 && shrunk {
                cluster.measure(least, map);
                update.changed.push(id);
            } else if let Some(cluster) = self.clusters.remove(&id) {
                for &cell in &cluster.cells {
                    layer.set_owner(cell, NONE);
                }
                loose.extend(cluster.cells);
                update.removed.push(id);
            }
        }
        loose.sort_unstable();
        for cells in self.group(map, layer.kind, &loose) {
            let id = self.next;
            self.next += 1;
            for &cell in &cells {
                layer.set_owner(cell, id as u32);
            }
            self.clusters
                .insert(id, Cluster::new(id, layer.kind, cells, least, map));
            update.added.push(id);
        }
    }

    /// Cuts loose cells (sorted) into clusters: 26-connected components, then k-means, or growth by normals and halving.
    fn group(&self, map: &impl Map, kind: Kind, loose: &[Cell]) -> Vec<Vec<Cell>> {
        let mut left: BTreeSet<usize> = (0..loose.len()).collect();
        let normals: Vec<[f64; 3]> = match kind {
            Kind::Exploration => Vec::new(),
            Kind::Inspection => loose.iter().map(|&c| direction(map, kind, c)).collect(),
        };
        let limit = self.params.normal_angle.cos();
        let mut out = Vec::new();
        while let Some(seed) = left.pop_first() {
            let mut members = vec![seed];
            let mut mean = normals.get(seed).copied().unwrap_or_default();
            let mut next = 0;
            while next < members.len() {
                let cell = loose[members[next]];
                next += 1;
                for neighbour in around(cell) {
                    let Ok(i) = loose.binary_search(&neighbour) else {
                        continue;
                    };
                    if !left.contains(&i) {
                        continue;
                    }
                    if kind == Kind::Inspection {
                        let normal = normals[i];
                        let dot: f64 = (0..3).map(|a| mean[a] * normal[a]).sum();
                        let norm = mean.iter().map(|v| v * v).sum::<f64>().sqrt();
                        // Cells whose directions cancel, like a thin board's, fit any cluster.
                        let flat = normal == [0.0; 3] || norm == 0.0;
                        if !flat && dot < limit * norm {
                            continue;
                        }
                        for a in 0..3 {
                            mean[a] += normal[a];
                        }
                    }
                    left.remove(&i);
                    members.push(i);
                }
            }
            members.sort_unstable();
            let cells: Vec<Cell> = members.iter().map(|&i| loose[i]).collect();
            match kind {
                Kind::Exploration => out.extend(kmeans(&cells, &self.params)),
                Kind::Inspection => halve(cells, self.params.inspection_radius, &mut out),
            }
        }
        out
    }

    /// The clusters in order of their ids.
    pub fn clusters(&self) -> impl Iterator<Item = &Cluster> {
        self.clusters.values()
    }

    /// The cluster of that id, while it lives.
    pub fn get(&self, id: u64) -> Option<&Cluster> {
        self.clusters.get(&id)
    }

    /// Kind of a frontier cell, `None` for other cells.
    pub fn is_frontier(&self, cell: Cell) -> Option<Kind> {
        let layers = self.layers.as_ref()?;
        layers.iter().find(|l| l.holds(cell)).map(|l| l.kind)
    }
}

/// The 26 neighbours.
fn around(cell: Cell) -> impl Iterator<Item = Cell> {
    (-1..=1).flat_map(move |dz| {
        (-1..=1).flat_map(move |dy| {
            (-1..=1).filter_map(move |dx| {
                ((dx, dy, dz) != (0, 0, 0)).then_some([cell[0] + dx, cell[1] + dy, cell[2] + dz])
            })
        })
    })
}
