//! A cluster of frontier cells.

use crate::Cell;
use crate::map::{Map, neighbours};

/// The two kinds of frontier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Free next to unknown, or the other way round: [`Side`](crate::Side).
    Exploration,
    /// Occupied next to free, not inspected.
    Inspection,
}

/// A cluster of frontier cells of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Cluster {
    /// Number that stays while the cluster lives and is never used again.
    pub id: u64,
    /// Kind of its cells.
    pub kind: Kind,
    /// Its cells, sorted.
    pub cells: Vec<Cell>,
    /// Mean of the cells' centres in cell units (the centre of cell c is c + 0.5).
    pub centroid: [f64; 3],
    /// Mean direction from the cells towards free space (inspection) or unknown space (exploration), unit; zero where the
    /// directions cancel.
    pub normal: [f64; 3],
    /// Lowest cell index on each axis.
    pub low: Cell,
    /// Highest cell index on each axis, itself inside.
    pub high: Cell,
    /// Below the minimum size of its kind.
    pub small: bool,
    /// Cells when it was made.
    pub(crate) born: usize,
}

impl Cluster {
    pub(crate) fn new(
        id: u64,
        kind: Kind,
        mut cells: Vec<Cell>,
        least: usize,
        map: &impl Map,
    ) -> Self {
        cells.sort_unstable();
        let born = cells.len();
        let mut cluster = Self {
            id,
            kind,
            cells,
            centroid: [0.0; 3],
            normal: [0.0; 3],
            low: [0; 3],
            high: [0; 3],
            small: false,
            born,
        };
        cluster.measure(least, map);
        cluster
    }

    /// Recomputes everything that follows from the cells.
    pub(crate) fn measure(&mut self, least: usize, map: &impl Map) {
        self.centroid = mean(&self.cells);
        self.low = [0, 1, 2].map(|a| self.cells.iter().map(|c| c[a]).min().unwrap_or(0));
        self.high = [0, 1, 2].map(|a| self.cells.iter().map(|c| c[a]).max().unwrap_or(0));
        self.small = self.cells.len() < least;
        let mut sum = [0.0; 3];
        for &cell in &self.cells {
            let n = direction(map, self.kind, cell);
            for a in 0..3 {
                sum[a] += n[a];
            }
        }
        self.normal = unit(sum);
    }
}

/// Mean of the cells' centres.
pub(crate) fn mean(cells: &[Cell]) -> [f64; 3] {
    let n = cells.len().max(1) as f64;
    [0, 1, 2].map(|a| cells.iter().map(|c| f64::from(c[a]) + 0.5).sum::<f64>() / n)
}

pub(crate) fn unit(v: [f64; 3]) -> [f64; 3] {
    let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    if norm > 1e-9 {
        v.map(|x| x / norm)
    } else {
        [0.0; 3]
    }
}

/// Unit direction of one cell: mean of the directions to neighbours that are free (inspection) or unknown (exploration). An
/// unknown cell looks away from its free neighbours.
pub(crate) fn direction(map: &impl Map, kind: Kind, cell: Cell) -> [f64; 3] {
    let mut sum = [0.0; 3];
    let is_unknown = |c: Cell| !map.is_free(c) && !map.is_occupied(c);
    let side = match kind {
        Kind::Exploration if is_unknown(cell) => -1.0,
        _ => 1.0,
    };
    for n in neighbours(cell) {
        let counts = match kind {
            Kind::Inspection => map.is_free(n),
            Kind::Exploration if side < 0.0 => map.is_free(n),
            Kind::Exploration => is_unknown(n),
        };
        if counts {
            for a in 0..3 {
                sum[a] += side * f64::from(n[a] - cell[a]);
            }
        }
    }
    unit(sum)
}
