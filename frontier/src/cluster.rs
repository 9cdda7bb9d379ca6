//! A cluster of frontier cells.

use crate::Cell;
use crate::map::{FACES, Map};
use crate::params::Side;
use crate::split::sort;

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
        side: Side,
        map: &impl Map,
    ) -> Self {
        sort(&mut cells);
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
        cluster.measure(least, side, map);
        cluster
    }

    /// Recomputes everything that follows from the cells; `side` is that of exploration cells.
    pub(crate) fn measure(&mut self, least: usize, side: Side, map: &impl Map) {
        self.centroid = mean(&self.cells);
        let first = self.cells.first().copied().unwrap_or_default();
        (self.low, self.high) = (first, first);
        // How many cells have which open faces.
        let mut counts = [0u32; 64];
        for &cell in &self.cells {
            for a in 0..3 {
                self.low[a] = self.low[a].min(cell[a]);
                self.high[a] = self.high[a].max(cell[a]);
            }
            let faces = match (self.kind, side) {
                (Kind::Exploration, Side::Free) => map.unknown_faces(cell),
                _ => map.free_faces(cell),
            };
            counts[usize::from(faces & 63)] += 1;
        }
        self.small = self.cells.len() < least;
        // An unknown cell looks away from its free neighbours.
        let sign = match (self.kind, side) {
            (Kind::Exploration, Side::Unknown) => -1.0,
            _ => 1.0,
        };
        let mut sum = [0.0; 3];
        for (faces, &count) in (0..).zip(&counts).filter(|(_, count)| **count > 0) {
            let towards = direction(faces, sign);
            for a in 0..3 {
                sum[a] += f64::from(count) * towards[a];
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

/// Unit direction of a cell with some open faces, as [`Map::free_faces`] has them: mean of the directions across them; zero where
/// they cancel.
pub(crate) fn direction(faces: u8, sign: f64) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (i, face) in FACES.iter().enumerate() {
        if faces >> i & 1 != 0 {
            for a in 0..3 {
                sum[a] += sign * f64::from(face[a]);
            }
        }
    }
    unit(sum)
}
