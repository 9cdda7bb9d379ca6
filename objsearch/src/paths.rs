//! Least path costs on a grid of cell costs: a 4-connected Dijkstra with a bucket queue.

use crate::Error;

/// What the travel table must know about paths.
pub trait Paths {
    /// Costs of the cheapest paths from one place (m) to others, into `costs` in order; infinite where there is none.
    ///
    /// Law: costs are not negative and not NaN.
    fn from(&mut self, from: [f64; 2], to: &[[f64; 2]], costs: &mut Vec<f64>);
}

impl<P: Paths + ?Sized> Paths for &mut P {
    fn from(&mut self, from: [f64; 2], to: &[[f64; 2]], costs: &mut Vec<f64>) {
        (**self).from(from, to, costs);
    }
}

/// Path costs on a grid, in the units of ROS's `navfn` as FLAP's regression has them: a path costs the sum of its cells,
/// first and last included, moving along x and y only.
///
/// A cell costs 50 + 0.8 times its cost-map value; a metre of free space on 0.05 m cells costs 1000.
#[derive(Clone, Debug)]
pub struct GridPaths {
    width: usize,
    height: usize,
    origin: [f64; 2],
    cell_size: f64,
    /// Cost of each cell, 0 where nothing may pass; with a border of such cells around the grid.
    cells: Vec<u16>,
    distance: Vec<u32>,
    /// Cells whose distance is asked for.
    wanted: Vec<bool>,
    /// Cells by cost modulo the number of buckets.
    buckets: Vec<Vec<u32>>,
}

/// Buckets of the queue: more than the dearest cell costs, and a power of two.
const BUCKETS: usize = 256;

/// Cost-map value from which a cell may not be passed (ROS: inscribed or lethal).
const BLOCKED: u8 = 253;

impl GridPaths {
    /// From a cost map: `values[y * width + x]` from 0 (free) to 252, 253 and more blocked; cell (0, 0) begins at
    /// `origin` (m).
    ///
    /// # Errors
    /// [`Error::TableSize`] if `values` does not hold `width * height`, [`Error::Param`] for a cell size that is not
    /// positive.
    pub fn new(
        values: &[u8],
        (width, height): (usize, usize),
        origin: [f64; 2],
        cell_size: f64,
    ) -> Result<Self, Error> {
        if width.checked_mul(height) != Some(values.len()) {
            return Err(Error::TableSize {
                what: "cost map",
                found: values.len(),
                wanted: width.saturating_mul(height),
            });
        }
        // Without cells one side may still be of any length.
        let (width, height) = if values.is_empty() {
            (0, 0)
        } else {
            (width, height)
        };
        if !(cell_size > 0.0 && cell_size.is_finite()) {
            return Err(Error::Param {
                field: "cell_size",
                value: cell_size,
                wanted: "positive and finite",
            });
        }
        let columns = width + 2;
        let mut cells = vec![0u16; columns * (height + 2)];
        for (row, line) in values.chunks(width.max(1)).enumerate() {
            let from = (row + 1) * columns + 1;
            for (cell, &v) in cells[from..].iter_mut().zip(line) {
                if v < BLOCKED {
                    *cell = 50 + u16::from(v) * 4 / 5;
                }
            }
        }
        Ok(Self {
            width,
            height,
            origin,
            cell_size,
            distance: vec![u32::MAX; cells.len()],
            wanted: vec![false; cells.len()],
            cells,
            buckets: vec![Vec::new(); BUCKETS],
        })
    }

    /// From a map of occupied cells: each one is blocked, and cells up to `radius` (m) around cost
    /// `252 exp(-scale d)` at distance d. FLAP: radius 0.55 m, scale 10 /m.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn inflated(
        blocked: &[bool],
        (width, height): (usize, usize),
        origin: [f64; 2],
        cell_size: f64,
        radius: f64,
        scale: f64,
    ) -> Result<Self, Error> {
        let mut values = vec![0u8; blocked.len()];
        if width.checked_mul(height) != Some(blocked.len()) {
            return Self::new(&values, (width, height), origin, cell_size); // says what is wrong
        }
        let reach = if cell_size > 0.0 {
            (radius / cell_size).floor().clamp(0.0, 1e6) as isize
        } else {
            0
        };
        let mut ring = Vec::new();
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let d = ((dx * dx + dy * dy) as f64).sqrt() * cell_size;
                if d <= radius {
                    ring.push((dx, dy, (252.0 * f64::exp(-scale * d)) as u8));
                }
            }
        }
        for (i, _) in blocked.iter().enumerate().filter(|(_, b)| **b) {
            let (x, y) = ((i % width) as isize, (i / width) as isize);
            for &(dx, dy, value) in &ring {
                let (px, py) = (x + dx, y + dy);
                if (0..width as isize).contains(&px) && (0..height as isize).contains(&py) {
                    let at = &mut values[py as usize * width + px as usize];
                    *at = value.max(*at);
                }
            }
        }
        for (value, _) in values.iter_mut().zip(blocked).filter(|(_, b)| **b) {
            *value = u8::MAX;
        }
        Self::new(&values, (width, height), origin, cell_size)
    }

    /// Index of the cell that holds a place; none outside the grid or where nothing may pass.
    fn index(&self, at: [f64; 2]) -> Option<usize> {
        let [x, y] = [0, 1].map(|a| ((at[a] - self.origin[a]) / self.cell_size).floor());
        if !(x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64) {
            return None;
        }
        let i = (y as usize + 1) * (self.width + 2) + x as usize + 1;
        (self.cells[i] != 0).then_some(i)
    }

    /// Whether a robot may stand at a place.
    pub fn is_passable(&self, at: [f64; 2]) -> bool {
        self.index(at).is_some()
    }

    /// Distances from one cell to all, or until all of `wanted` are final.
    fn spread(&mut self, from: usize, wanted: &[usize]) {
        self.distance.fill(u32::MAX);
        let mut missing = 0;
        for &cell in wanted {
            missing += usize::from(!std::mem::replace(&mut self.wanted[cell], true));
        }
        let columns = self.width + 2;
        let start = u32::from(self.cells[from]);
        self.distance[from] = start;
        self.buckets[start as usize % BUCKETS].push(from as u32);
        let (mut here, mut queued) = (start, 1usize);
        while queued > 0 && missing > 0 {
            let slot = here as usize % BUCKETS;
            while let Some(cell) = self.buckets[slot].pop() {
                queued -= 1;
                let cell = cell as usize;
                if self.distance[cell] != here {
                    continue; // reached cheaper since
                }
                if self.wanted[cell] {
                    self.wanted[cell] = false;
                    missing -= 1;
                }
                for to in [cell - 1, cell + 1, cell - columns, cell + columns] {
                    let cost = self.cells[to];
                    let then = here + u32::from(cost);
                    if cost != 0 && then < self.distance[to] {
                        self.distance[to] = then;
                        self.buckets[then as usize % BUCKETS].push(to as u32);
                        queued += 1;
                    }
                }
            }
            here += 1;
        }
        for &cell in wanted {
            self.wanted[cell] = false;
        }
        self.buckets.iter_mut().for_each(Vec::clear);
    }
}

impl Paths for GridPaths {
    fn from(&mut self, from: [f64; 2], to: &[[f64; 2]], costs: &mut Vec<f64>) {
        costs.clear();
        let goals: Vec<Option<usize>> = to.iter().map(|&p| self.index(p)).collect();
        let Some(start) = self.index(from) else {
            costs.resize(to.len(), f64::INFINITY);
            return;
        };
        let wanted: Vec<usize> = goals.iter().copied().flatten().collect();
        self.spread(start, &wanted);
        costs.extend(
            goals
                .iter()
                .map(|goal| match goal.map(|g| self.distance[g]) {
                    Some(cost) if cost != u32::MAX => f64::from(cost),
                    _ => f64::INFINITY,
                }),
        );
    }
}
