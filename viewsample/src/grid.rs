//! A small map and a small robot, for examples and tests.

use crate::map::{Cell, Map};
use crate::{Pose, Robot};

/// A dense voxel map with its lowest corner at the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    size: [usize; 3],
    cell_size: f64,
    cells: Vec<u8>,
}

impl Grid {
    /// All cells unknown; size in cells, `cell_size` in m.
    pub fn unknown(size: [usize; 3], cell_size: f64) -> Self {
        Self {
            size,
            cell_size,
            cells: vec![b'?'; size.iter().product()],
        }
    }

    /// A drawing of the floor plan, the first line at the largest y: `.` free, `#` occupied,
    /// anything else unknown; each column `height` cells high.
    pub fn parse(plan: &str, height: usize, cell_size: f64) -> Self {
        let rows: Vec<&[u8]> = plan
            .lines()
            .map(str::trim)
            .filter(|l| !l.is_empty())
            .map(str::as_bytes)
            .collect();
        let width = rows.iter().map(|r| r.len()).max().unwrap_or(0);
        let mut grid = Self::unknown([width, rows.len(), height], cell_size);
        for (y, row) in rows.iter().rev().enumerate() {
            for (x, state) in row.iter().enumerate() {
                for z in 0..height {
                    grid.set([x as i32, y as i32, z as i32], *state);
                }
            }
        }
        grid
    }

    /// Size in cells.
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// Half-open box of all cells.
    pub fn bounds(&self) -> (Cell, Cell) {
        ([0; 3], self.size.map(|n| n as i32))
    }

    /// Sets a cell to `.` free, `#` occupied, or anything else for unknown; outside nothing happens.
    pub fn set(&mut self, cell: Cell, state: u8) {
        if let Some(index) = self.index(cell) {
            self.cells[index] = state;
        }
    }

    /// All free cells with an unknown one among their six neighbours in the grid.
    pub fn exploration(&self) -> Vec<Cell> {
        self.all()
            .filter(|c| self.is_free(*c) && self.near(*c).any(|n| self.at(n) == Some(b'?')))
            .collect()
    }

    /// All occupied cells with a free one among their six neighbours.
    pub fn surface(&self) -> Vec<Cell> {
        self.all()
            .filter(|c| self.is_occupied(*c) && self.near(*c).any(|n| self.is_free(n)))
            .collect()
    }

    /// All cells in index order.
    pub fn all(&self) -> impl Iterator<Item = Cell> + use<> {
        let [nx, ny, nz] = self.size.map(|n| n as i32);
        (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
    }

    fn near(&self, c: Cell) -> impl Iterator<Item = Cell> {
        (0..6).map(move |n| {
            let mut d = c;
            d[n / 2] += if n % 2 == 0 { 1 } else { -1 };
            d
        })
    }

    fn at(&self, c: Cell) -> Option<u8> {
        self.index(c).map(|i| match self.cells[i] {
            state @ (b'.' | b'#') => state,
            _ => b'?',
        })
    }

    fn index(&self, c: Cell) -> Option<usize> {
        let [x, y, z] = [0, 1, 2].map(|a| usize::try_from(c[a]).ok().filter(|v| *v < self.size[a]));
        Some((z? * self.size[1] + y?) * self.size[0] + x?)
    }
}

impl Map for Grid {
    fn cell_size(&self) -> f64 {
        self.cell_size
    }
    fn cell_at(&self, point: [f64; 3]) -> Cell {
        point.map(|v| (v / self.cell_size).floor() as i32)
    }
    fn center(&self, cell: Cell) -> [f64; 3] {
        cell.map(|v| (f64::from(v) + 0.5) * self.cell_size)
    }
    fn is_free(&self, cell: Cell) -> bool {
        self.at(cell) == Some(b'.')
    }
    fn is_occupied(&self, cell: Cell) -> bool {
        self.at(cell) == Some(b'#')
    }
}

/// A camera on a mast that lifts and tilts, on a round base: state = [height m, tilt rad].
#[derive(Clone, Debug)]
pub struct Mast<'a, M> {
    /// Where it stands.
    pub map: &'a M,
    /// Radius of the base, m.
    pub radius: f64,
    /// Height of the base, m.
    pub height: f64,
    /// Lowest and highest camera, m.
    pub lift: (f64, f64),
}

impl<M: Map> Mast<'_, M> {
    fn disc_is_free(&self, base: [f64; 3], radius: f64, height: f64) -> bool {
        if !base.iter().all(|v| v.is_finite()) {
            return false;
        }
        let h = self.map.cell_size();
        let low = self
            .map
            .cell_at([base[0] - radius, base[1] - radius, 0.5 * h]);
        let high = self
            .map
            .cell_at([base[0] + radius, base[1] + radius, height]);
        (low[0]..=high[0]).all(|i| {
            (low[1]..=high[1]).all(|j| {
                let c = self.map.center([i, j, low[2]]);
                let beside = (0..2)
                    .map(|a| ((base[a] - c[a]).abs() - 0.5 * h).max(0.0).powi(2))
                    .sum::<f64>();
                beside > radius * radius || (low[2]..=high[2]).all(|k| self.map.is_free([i, j, k]))
            })
        })
    }
}

impl<M: Map> Robot for Mast<'_, M> {
    type State = [f64; 2];

    fn reach(&self, camera: &Pose) -> Option<[f64; 2]> {
        let [f, z] = [camera.forward(), camera.translation];
        // Looking ahead, anywhere over the base.
        let level = (f[0] * f[0] + f[1] * f[1]).sqrt();
        let good = f[1].abs() < 1e-9
            && z[0].hypot(z[1]) <= self.radius
            && (self.lift.0..=self.lift.1).contains(&z[2]);
        good.then(|| [z[2], f[2].atan2(level)])
    }
    fn is_free(&self, base: [f64; 3], state: &[f64; 2]) -> bool {
        self.base_is_free(base) && self.disc_is_free(base, 0.5 * self.radius, state[0])
    }
    fn base_is_free(&self, base: [f64; 3]) -> bool {
        self.disc_is_free(base, self.radius, self.height)
    }
}
