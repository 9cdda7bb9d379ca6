//! Clusters kept up to date while the map changes.

use crate::cluster::{Cluster, Kind, direction};
use crate::kmeans::kmeans;
use crate::layer::{Layer, NONE};
use crate::map::Map;
use crate::params::{Error, Params, Split};
use crate::split::halve;
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
        let mut last = NONE;
        for &[x, y, z] in &gained {
            for (dy, dz) in ROWS {
                let held = layer.held([x, y + dy, z + dz]);
                for dx in (-1..=1).filter(|dx| held >> (dx + 1) & 1 != 0) {
                    let owner = layer.owner([x + dx, y + dy, z + dz]);
                    if owner != last && owner != NONE {
                        touched.insert(u64::from(owner), true);
                        last = owner;
                    }
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
        for cells in self.group(map, layer, &loose) {
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

    /// Cuts loose cells (sorted) into clusters: 26-connected components, then k-means or halving, or growth by normals and
    /// halving.
    fn group(&self, map: &impl Map, layer: &mut Layer, loose: &[Cell]) -> Vec<Vec<Cell>> {
        let kind = layer.kind;
        let limit = self.params.normal_angle.cos();
        let mut out = Vec::new();
        layer.loosen(loose);
        for &seed in loose {
            if !layer.take(seed) {
                continue;
            }
            let mut members = vec![seed];
            let mut mean = match kind {
                Kind::Exploration => [0.0; 3],
                Kind::Inspection => direction(map, kind, seed),
            };
            let mut next = 0;
            while next < members.len() {
                let [x, y, z] = members[next];
                next += 1;
                for (dy, dz) in ROWS {
                    let waiting = layer.waiting([x, y + dy, z + dz]);
                    for dx in (-1..=1).filter(|dx| waiting >> (dx + 1) & 1 != 0) {
                        let neighbour = [x + dx, y + dy, z + dz];
                        if kind == Kind::Inspection && !fits(map, neighbour, &mut mean, limit) {
                            continue;
                        }
                        layer.take(neighbour);
                        members.push(neighbour);
                    }
                }
            }
            members.sort_unstable();
            let half = 0.5 * self.params.exploration_extent;
            match (kind, self.params.exploration_split) {
                (Kind::Inspection, _) => halve(members, self.params.inspection_radius, &mut out),
                (_, Split::KMeans) => out.extend(kmeans(&members, &self.params)),
                (_, Split::PrincipalAxis) => halve(members, half, &mut out),
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
fn fits(map: &impl Map, cell: Cell, sum: &mut [f64; 3], limit: f64) -> bool {
    let normal = direction(map, Kind::Inspection, cell);
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
