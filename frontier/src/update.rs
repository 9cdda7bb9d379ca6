//! Clusters kept up to date while the map changes.

use crate::cluster::{Cluster, Kind, direction};
use crate::kmeans::kmeans;
use crate::layer::Layer;
use crate::map::Map;
use crate::params::{Error, Params, Split};
use crate::split::{halve, sort};
use crate::{Cell, CellBox};
use std::collections::BTreeMap;

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
            _ => [Kind::Exploration, Kind::Inspection]
                .map(|kind| Layer::new(kind, self.params.exploration_side, bounds)),
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
        let changes = layer.refresh(map, boxes, band);
        let mut touched: BTreeMap<u64, bool> = BTreeMap::new(); // id -> must be made anew
        // Words with cells that wait for a cluster.
        let mut waiting = Vec::new();
        for change in &changes {
            layer.disown(change.word, change.lost, |id| {
                touched.entry(u64::from(id)).or_insert(false);
            });
            if change.gained != 0 {
                layer.loose[change.word] |= change.gained;
                waiting.push(change.word);
            }
        }
        for change in changes.iter().filter(|change| change.gained != 0) {
            layer.owners_beside(change.word, change.gained, |id| {
                touched.insert(u64::from(id), true);
            });
        }
        let least = self.least(layer.kind);
        for (id, anew) in touched {
            if !anew && let Some(cluster) = self.clusters.get_mut(&id) {
                cluster.cells.retain(|&c| layer.holds(c));
                let left = cluster.cells.len();
                if left > 0 && left as f64 >= (1.0 - self.params.shrink_share) * cluster.born as f64
                {
                    cluster.measure(least, layer.side, map);
                    update.changed.push(id);
                    continue;
                }
            }
            if let Some(cluster) = self.clusters.remove(&id) {
                for cell in cluster.cells {
                    if let Some(word) = layer.release(cell)
                        && waiting.last() != Some(&word)
                    {
                        waiting.push(word);
                    }
                }
                update.removed.push(id);
            }
        }
        let parts = match layer.kind {
            Kind::Exploration => self.explore(layer, &waiting),
            Kind::Inspection => self.inspect(map, layer, waiting),
        };
        for cells in parts {
            let id = self.next;
            self.next += 1;
            for &cell in &cells {
                layer.set_owner(cell, id as u32);
            }
            let cluster = Cluster::new(id, layer.kind, cells, least, layer.side, map);
            self.clusters.insert(id, cluster);
            update.added.push(id);
        }
    }

    /// Cuts the waiting cells of some words into clusters: 26-connected sets in the order of their first cells, each by k-means
    /// or halving.
    fn explore(&self, layer: &mut Layer, waiting: &[usize]) -> Vec<Vec<Cell>> {
        let mut sets = Vec::new();
        for &word in waiting {
            while layer.loose[word] != 0 {
                let cells = layer.flood(word);
                sets.push((cells.iter().copied().min(), cells));
            }
        }
        sets.sort_unstable_by_key(|(first, _)| *first);
        let mut out = Vec::new();
        for (_, mut cells) in sets {
            match self.params.exploration_split {
                Split::KMeans => {
                    sort(&mut cells);
                    out.extend(kmeans(&cells, &self.params));
                }
                Split::PrincipalAxis => {
                    halve(cells, 0.5 * self.params.exploration_extent, &mut out);
                }
            }
        }
        out
    }

    /// Cuts the waiting cells of some words into clusters: grown from the first cells on by normals, then halved.
    fn inspect(
        &self,
        map: &impl Map,
        layer: &mut Layer,
        mut waiting: Vec<usize>,
    ) -> Vec<Vec<Cell>> {
        let limit = self.params.normal_angle.cos();
        waiting.sort_unstable();
        waiting.dedup();
        let mut seeds = Vec::new();
        for word in waiting {
            layer.append(word, layer.loose[word], &mut seeds);
        }
        sort(&mut seeds);
        let mut out = Vec::new();
        for seed in seeds {
            if !layer.take(seed) {
                continue;
            }
            let mut members = vec![seed];
            let mut sum = direction(map.free_faces(seed), 1.0);
            let mut next = 0;
            while next < members.len() {
                let [x, y, z] = members[next];
                next += 1;
                for (dy, dz) in ROWS {
                    let waiting = layer.waiting([x, y + dy, z + dz]);
                    for dx in (-1..=1).filter(|dx| waiting >> (dx + 1) & 1 != 0) {
                        let neighbour = [x + dx, y + dy, z + dz];
                        if fits(direction(map.free_faces(neighbour), 1.0), &mut sum, limit) {
                            layer.take(neighbour);
                            members.push(neighbour);
                        }
                    }
                }
            }
            halve(members, self.params.inspection_radius, &mut out);
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

/// Rows of the 26 neighbours beside a cell's own, along y and z.
const ROWS: [(i32, i32); 9] = [
    (-1, -1),
    (0, -1),
    (1, -1),
    (-1, 0),
    (0, 0),
    (1, 0),
    (-1, 1),
    (0, 1),
    (1, 1),
];

/// True if an inspection cell's normal fits a growing cluster's sum of normals, which it then joins. Cells whose directions
/// cancel, like a thin board's, fit any cluster.
fn fits(normal: [f64; 3], sum: &mut [f64; 3], limit: f64) -> bool {
    let dot: f64 = (0..3).map(|a| sum[a] * normal[a]).sum();
    let norm = sum.iter().map(|v| v * v).sum::<f64>().sqrt();
    let flat = normal == [0.0; 3] || norm == 0.0;
    if !flat && dot < limit * norm {
        return false;
    }
    for a in 0..3 {
        sum[a] += normal[a];
    }
    true
}
