//! The map seen from above, brought up to date by events: what a picture shows of each ground cell.

use super::event::{CellRuns, CellState, FrontiersEvent, GridShape};
use std::collections::{BTreeMap, BTreeSet};

/// What is shown of a column of voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum ColumnClass {
    /// No voxel is known.
    #[default]
    Unknown = 0,
    /// Some voxels are free, the larger part is unknown.
    Partly = 1,
    /// Free where known, and that is at least half of it.
    Free = 2,
    /// Something stands here that needs no inspection.
    Occupied = 3,
    /// Surface that is to be inspected.
    Open = 4,
    /// Some of the surface is inspected.
    PartlyInspected = 5,
    /// All surface is inspected.
    Inspected = 6,
}

/// Columns of a voxel grid.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    grid: GridShape,
    layers: [usize; 2],
    cells: Vec<u8>,
    /// Voxels of each state, for each column.
    counts: Vec<[u16; 5]>,
    changed: BTreeSet<u32>,
}

impl Columns {
    /// Unknown columns of the `layers` from the first to the one before the second.
    pub fn new(grid: GridShape, layers: [usize; 2]) -> Self {
        let high = layers[1].min(grid.size[2]);
        let layers = [layers[0].min(high), high];
        Self {
            grid,
            layers,
            cells: vec![0; grid.len()],
            counts: vec![[(high - layers[0]) as u16, 0, 0, 0, 0]; grid.size[0] * grid.size[1]],
            changed: BTreeSet::new(),
        }
    }

    /// Takes in changed voxels. Those outside the grid are left out.
    pub fn apply(&mut self, runs: &CellRuns) {
        let columns = self.counts.len();
        for (index, value) in runs.iter() {
            let (Some(cell), Some(state)) = (
                self.cells.get_mut(index as usize),
                CellState::from_number(value),
            ) else {
                continue;
            };
            let (layer, column) = (index as usize / columns, index as usize % columns);
            let was = std::mem::replace(cell, state as u8);
            if !(self.layers[0]..self.layers[1]).contains(&layer) {
                continue;
            }
            self.counts[column][usize::from(was)] -= 1;
            self.counts[column][state as usize] += 1;
            self.changed.insert(column as u32);
        }
    }

    /// Columns that were touched since the last call, in rising order.
    pub fn take_changed(&mut self) -> BTreeSet<u32> {
        std::mem::take(&mut self.changed)
    }

    /// What is shown of a column; unknown outside the grid.
    pub fn class(&self, column: u32) -> ColumnClass {
        let Some([unknown, free, occupied, open, inspected]) =
            self.counts.get(column as usize).copied()
        else {
            return ColumnClass::Unknown;
        };
        match (open > 0, inspected > 0) {
            (true, true) => ColumnClass::PartlyInspected,
            (true, false) => ColumnClass::Open,
            (false, true) => ColumnClass::Inspected,
            (false, false) if occupied > 0 => ColumnClass::Occupied,
            (false, false) if free == 0 => ColumnClass::Unknown,
            (false, false) if free < unknown => ColumnClass::Partly,
            (false, false) => ColumnClass::Free,
        }
    }

    /// The grid.
    pub fn grid(&self) -> &GridShape {
        &self.grid
    }

    /// State of every voxel, as [`CellState`] numbers.
    pub fn cells(&self) -> &[u8] {
        &self.cells
    }
}

/// Frontier clusters seen from above.
#[derive(Clone, Debug, Default)]
pub struct FrontierColumns {
    columns: usize,
    /// Cells of each live cluster, and whether it asks for inspection.
    clusters: BTreeMap<u64, (bool, Vec<u32>)>,
    /// Frontier cells of each kind (exploration, inspection), for each column that has some.
    counts: BTreeMap<u32, [u32; 2]>,
    changed: BTreeSet<u32>,
}

impl FrontierColumns {
    /// No frontier.
    pub fn new(grid: &GridShape) -> Self {
        Self {
            columns: (grid.size[0] * grid.size[1]).max(1),
            ..Self::default()
        }
    }

    fn count(&mut self, inspection: bool, cells: &[u32], add: bool) {
        for cell in cells {
            let column = (*cell as usize % self.columns) as u32;
            let counts = self.counts.entry(column).or_default();
            let count = &mut counts[usize::from(inspection)];
            *count = if add { *count + 1 } else { *count - 1 };
            if *counts == [0, 0] {
                self.counts.remove(&column);
            }
            self.changed.insert(column);
        }
    }

    fn remove(&mut self, id: u64) {
        if let Some((inspection, cells)) = self.clusters.remove(&id) {
            self.count(inspection, &cells, false);
        }
    }

    /// Takes in changed clusters.
    pub fn apply(&mut self, event: &FrontiersEvent) {
        for id in &event.gone {
            self.remove(*id);
        }
        for cluster in &event.clusters {
            self.remove(cluster.id);
            let cells: Vec<u32> = cluster.cells().collect();
            self.count(cluster.inspection, &cells, true);
            self.clusters
                .insert(cluster.id, (cluster.inspection, cells));
        }
    }

    /// Columns that were touched since the last call, in rising order.
    pub fn take_changed(&mut self) -> BTreeSet<u32> {
        std::mem::take(&mut self.changed)
    }

    /// 1 for a column with exploration frontier, 2 with inspection frontier, 3 with both, 0 with none.
    pub fn bits(&self, column: u32) -> u8 {
        let [exploration, inspection] = self.counts.get(&column).copied().unwrap_or_default();
        u8::from(exploration > 0) | u8::from(inspection > 0) << 1
    }

    /// Live clusters in order of their ids: id, whether it asks for inspection, cells.
    pub fn clusters(&self) -> impl Iterator<Item = (u64, bool, &[u32])> {
        self.clusters
            .iter()
            .map(|(id, (inspection, cells))| (*id, *inspection, cells.as_slice()))
    }
}

#[cfg(test)]
mod tests {
    use super::super::event::FrontierShape;
    use super::*;

    fn grid() -> GridShape {
        GridShape {
            low: [0.0; 3],
            cell_size: 0.1,
            size: [4, 2, 3],
        }
    }

    #[test]
    fn a_column_shows_what_stands_in_it() {
        let mut columns = Columns::new(grid(), [0, 3]);
        assert_eq!(columns.class(5), ColumnClass::Unknown);
        let set = |columns: &mut Columns, z: u32, state: CellState| {
            columns.apply(&CellRuns(vec![[5 + 8 * z, 1, state as u32]]));
        };
        set(&mut columns, 0, CellState::Free);
        assert_eq!(columns.class(5), ColumnClass::Partly);
        set(&mut columns, 1, CellState::Free);
        assert_eq!(columns.class(5), ColumnClass::Free);
        set(&mut columns, 2, CellState::Occupied);
        assert_eq!(columns.class(5), ColumnClass::Occupied);
        set(&mut columns, 1, CellState::Open);
        assert_eq!(columns.class(5), ColumnClass::Open);
        set(&mut columns, 0, CellState::Inspected);
        assert_eq!(columns.class(5), ColumnClass::PartlyInspected);
        set(&mut columns, 1, CellState::Inspected);
        assert_eq!(columns.class(5), ColumnClass::Inspected);
        assert_eq!(columns.take_changed().into_iter().collect::<Vec<_>>(), [5]);
        // Above the picture's layers nothing shows.
        let mut low = Columns::new(grid(), [0, 2]);
        set(&mut low, 2, CellState::Open);
        assert_eq!(low.class(5), ColumnClass::Unknown);
        assert!(low.take_changed().is_empty());
        // What a broken file may hold changes nothing.
        columns.apply(&CellRuns(vec![[9999, 2, 1], [0, 1, 77]]));
        assert!(columns.take_changed().is_empty());
    }

    #[test]
    fn clusters_leave_nothing_behind() {
        let mut frontiers = FrontierColumns::new(&grid());
        frontiers.apply(&FrontiersEvent {
            gone: vec![],
            clusters: vec![
                FrontierShape::new(1, false, vec![2, 10, 3]),
                FrontierShape::new(2, true, vec![18]),
            ],
        });
        assert_eq!([1, 2, 3].map(|c| frontiers.bits(c)), [0, 3, 1]);
        frontiers.apply(&FrontiersEvent {
            gone: vec![2],
            clusters: vec![FrontierShape::new(1, false, vec![1])],
        });
        assert_eq!([1, 2, 3].map(|c| frontiers.bits(c)), [1, 0, 0]);
        frontiers.apply(&FrontiersEvent {
            gone: vec![1],
            clusters: vec![],
        });
        assert!(frontiers.counts.is_empty());
        assert_eq!(frontiers.clusters().count(), 0);
    }
}
