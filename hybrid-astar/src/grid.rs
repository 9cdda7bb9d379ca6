//! A built-in map: an occupancy grid with exact distances.

use crate::{Error, Map};

/// An occupancy grid in which every cell is free or blocked, with the distance to the nearest blocked cell.
///
/// Cell (0, 0) has its lower corner at the origin given. Outside counts as blocked.
///
/// ```
/// use hybrid_astar::{Map, grid::Grid};
/// // Rows from the top, `#` blocked; 1 m cells.
/// let map = Grid::parse("...\n..#", 1.0);
/// // From the middle of the top left cell the outside begins half a cell away.
/// assert!((map.clearance([0.5, 1.5]) - 0.5).abs() < 1e-9);
/// assert!(map.clearance([2.5, 0.5]) < 0.0);
/// ```
#[derive(Clone)]
pub struct Grid {
    size: [usize; 2],
    low: [f64; 2],
    cell: f64,
    /// Cells a metre.
    per_metre: f64,
    inset: f64,
    blocked: Vec<bool>,
    /// Blocked cells in the row before each column: `width + 1` entries a row.
    before: Vec<u32>,
    /// Column and row of the nearest blocked cell, `NONE` if there is none.
    nearest: Vec<[u16; 2]>,
    revision: u64,
}

impl Grid {
    /// A grid of `size` cells (x, y) of side `cell` m from the corner `low`; `blocked` row by row from the lowest y.
    /// Cells missing from `blocked` are blocked.
    pub fn new(
        size: [usize; 2],
        cell: f64,
        low: [f64; 2],
        blocked: &[bool],
    ) -> Result<Self, Error> {
        crate::error::positive("cell", cell)?;
        crate::error::finite("low", &low)?;
        let count = size[0]
            .checked_mul(size[1])
            .filter(|&n| n > 0 && n < 1 << 28 && size[0].max(size[1]) <= LONGEST_SIDE);
        let Some(count) = count else {
            let high = [
                low[0] + cell * size[0] as f64,
                low[1] + cell * size[1] as f64,
            ];
            return Err(Error::Bounds {
                low,
                high,
                cell_size: cell,
                must: "from 1 to 2^28 cells, no side longer than 65535",
            });
        };
        let mut cells = blocked[..blocked.len().min(count)].to_vec();
        cells.resize(count, true);
        let mut grid = Self {
            size,
            low,
            cell,
            per_metre: 1.0 / cell,
            inset: 0.5 * cell,
            nearest: nearest_blocked(size, &cells),
            before: Vec::new(),
            blocked: cells,
            revision: 1,
        };
        grid.before = vec![0; (size[0] + 1) * size[1]];
        for y in 0..size[1] {
            for x in 0..size[0] {
                let at = y * (size[0] + 1) + x;
                grid.before[at + 1] = grid.before[at] + u32::from(grid.blocked[y * size[0] + x]);
            }
        }
        Ok(grid)
    }

    /// Reads rows of text from the highest y down, `#` blocked and anything else free. An empty text gives one
    /// blocked cell.
    pub fn parse(rows: &str, cell: f64) -> Self {
        let lines: Vec<&[u8]> = rows
            .lines()
            .map(str::as_bytes)
            .filter(|l| !l.is_empty())
            .collect();
        let (w, h) = (
            lines.iter().map(|l| l.len()).max().unwrap_or(1),
            lines.len().max(1),
        );
        let mut blocked = vec![true; w * h];
        for (y, line) in lines.iter().rev().enumerate() {
            for (x, &c) in line.iter().enumerate() {
                blocked[y * w + x] = c == b'#';
            }
        }
        let cell = if cell > 0.0 && cell.is_finite() {
            cell
        } else {
            1.0
        };
        match Self::new([w, h], cell, [0.0; 2], &blocked) {
            Ok(grid) => grid,
            Err(_) => Self {
                size: [1, 1],
                low: [0.0; 2],
                cell,
                per_metre: 1.0 / cell,
                inset: 0.5 * cell,
                blocked: vec![true],
                before: vec![0, 1],
                nearest: vec![[0; 2]],
                revision: 1,
            },
        }
    }

    /// Sets how far from a blocked cell's centre its matter begins, m. Half a cell at first; 0 makes blocked cells
    /// points, the rule of many navigation benchmarks.
    pub fn with_inset(mut self, inset: f64) -> Self {
        self.inset = inset;
        self
    }

    /// Cells along x and y.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Side of a cell, m.
    pub fn cell_size(&self) -> f64 {
        self.cell
    }

    /// Whether the cell is blocked; outside is.
    pub fn is_blocked(&self, cell: [i32; 2]) -> bool {
        let [x, y] = cell;
        x < 0
            || y < 0
            || x as usize >= self.size[0]
            || y as usize >= self.size[1]
            || self.blocked[y as usize * self.size[0] + x as usize]
    }

    fn blocked_between(&self, y: usize, x0: usize, x1: usize) -> bool {
        let row = y * (self.size[0] + 1);
        self.before[row + x1] != self.before[row + x0]
    }
}

/// As rows of text, highest y first, as [`Grid::parse`] reads them.
impl std::fmt::Debug for Grid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(
            f,
            "Grid {} x {} cells of {} m from {:?}",
            self.size[0], self.size[1], self.cell, self.low
        )?;
        for row in self.blocked.chunks(self.size[0]).rev() {
            writeln!(
                f,
                "{}",
                row.iter()
                    .map(|&b| if b { '#' } else { '.' })
                    .collect::<String>()
            )?;
        }
        Ok(())
    }
}

impl Map for Grid {
    fn clearance(&self, p: [f64; 2]) -> f64 {
        let (w, h) = (self.size[0] as f64, self.size[1] as f64);
        // Cell units, cell centres at whole numbers.
        let (u, v) = (
            (p[0] - self.low[0]) * self.per_metre - 0.5,
            (p[1] - self.low[1]) * self.per_metre - 0.5,
        );
        if !(u.is_finite() && v.is_finite()) {
            return f64::NEG_INFINITY;
        }
        // The cells just outside are blocked: their centres lie at -1 and at the size.
        let border = (u + 1.0).min(w - u).min(v + 1.0).min(h - v);
        if border <= 0.0 {
            return border * self.cell - self.inset;
        }
        // Between -1 and the size: the conversion rounds down and turns what is negative to 0.
        let x0 = (u as usize).min(self.size[0] - 1);
        let y0 = (v as usize).min(self.size[1] - 1);
        let (x1, y1) = (
            (x0 + 1).min(self.size[0] - 1),
            (y0 + 1).min(self.size[1] - 1),
        );
        let mut best = f64::INFINITY;
        for at in [
            y0 * self.size[0] + x0,
            y0 * self.size[0] + x1,
            y1 * self.size[0] + x0,
            y1 * self.size[0] + x1,
        ] {
            let n = self.nearest[at];
            if n != NONE {
                let (dx, dy) = (u - f64::from(n[0]), v - f64::from(n[1]));
                best = best.min(dx * dx + dy * dy);
            }
        }
        best.sqrt().min(border) * self.cell - self.inset
    }

    fn bounds(&self) -> ([f64; 2], [f64; 2]) {
        let high = [
            self.low[0] + self.cell * self.size[0] as f64,
            self.low[1] + self.cell * self.size[1] as f64,
        ];
        (self.low, high)
    }

    fn revision(&self) -> u64 {
        self.revision
    }

    /// A blocked (or outside) cell is hit when its centre lies in the closed polygon.
    fn outline_is_free(&self, corners: &[[f64; 2]]) -> Option<bool> {
        let scale = self.per_metre;
        let n = corners.len();
        if !(3..=16).contains(&n) {
            return None;
        }
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut c = [[0.0f64; 2]; 16];
        for (to, from) in c.iter_mut().zip(corners) {
            *to = [
                (from[0] - self.low[0]) * scale - 0.5,
                (from[1] - self.low[1]) * scale - 0.5,
            ];
            low = low.min(to[1]);
            high = high.max(to[1]);
        }
        // Beyond any grid, and NaN.
        if !(low > -1e8 && high < 1e8) {
            return Some(false);
        }
        let mut edges = [Edge::default(); 16];
        for i in 0..n {
            edges[i] = Edge::new(c[i], c[(i + 1) % n]);
        }
        let (width, height) = (self.size[0] as i64, self.size[1] as i64);
        for row in up(low - 1e-9)..=down(high + 1e-9) {
            let y = row as f64;
            // The row's chord: crossings of the line with the edges.
            let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
            for e in &edges[..n] {
                if e.low - 1e-9 <= y && y <= e.high + 1e-9 {
                    let x = e.x + (y.clamp(e.low, e.high) - e.low) * e.slope;
                    left = left.min(x).min(x + e.flat);
                    right = right.max(x).max(x + e.flat);
                }
            }
            if !(left > -1e8 && right < 1e8) {
                // No crossing, or beyond any grid.
                if left > right {
                    continue;
                }
                return Some(false);
            }
            let (x0, x1) = (up(left - 1e-9), down(right + 1e-9));
            if x0 <= x1 {
                let outside = x0 < 0 || row < 0 || x1 >= width || row >= height;
                if outside || self.blocked_between(row as usize, x0 as usize, x1 as usize + 1) {
                    return Some(false);
                }
            }
        }
        Some(true)
    }
}

/// An edge of a polygon, in cells.
#[derive(Clone, Copy, Default)]
struct Edge {
    low: f64,
    high: f64,
    /// At the lower end.
    x: f64,
    slope: f64,
    /// How far an edge along the row reaches.
    flat: f64,
}

impl Edge {
    fn new(a: [f64; 2], b: [f64; 2]) -> Self {
        let (lo, hi) = if a[1] < b[1] { (a, b) } else { (b, a) };
        let (rise, run) = (hi[1] - lo[1], hi[0] - lo[0]);
        let level = rise < 1e-9;
        Self {
            low: lo[1],
            high: hi[1],
            x: lo[0],
            slope: if level { 0.0 } else { run / rise },
            flat: if level { run } else { 0.0 },
        }
    }
}

/// Next whole number up; the conversion alone rounds towards zero, and calling `ceil` costs more than the rest.
#[inline]
fn up(v: f64) -> i64 {
    let t = v as i64;
    t + i64::from((t as f64) < v)
}

#[inline]
fn down(v: f64) -> i64 {
    let t = v as i64;
    t - i64::from((t as f64) > v)
}

/// Sides are limited so that a cell's column and row fit into 16 bits each, with one value to spare.
const LONGEST_SIDE: usize = 65535;
const NONE: [u16; 2] = [u16::MAX; 2];

/// Exact Euclidean nearest-site transform: columns first, then the lower envelope of parabolas along each row.
fn nearest_blocked(size: [usize; 2], blocked: &[bool]) -> Vec<[u16; 2]> {
    let [w, h] = size;
    const NO_ROW: u16 = u16::MAX;
    // Row of the nearest blocked cell in the same column.
    let mut row_of = vec![NO_ROW; w * h];
    for y in 0..h {
        for x in 0..w {
            let at = y * w + x;
            row_of[at] = if blocked[at] {
                y as u16
            } else if y > 0 {
                row_of[at - w]
            } else {
                NO_ROW
            };
        }
    }
    for y in (0..h.saturating_sub(1)).rev() {
        for x in 0..w {
            let (at, below) = (y * w + x, row_of[(y + 1) * w + x]);
            let here = row_of[at];
            if below != NO_ROW
                && (here == NO_ROW || below as usize > y && below as usize - y < y - here as usize)
            {
                row_of[at] = below;
            }
        }
    }
    let mut nearest = vec![NONE; w * h];
    let mut sites: Vec<(usize, f64, f64)> = Vec::with_capacity(w); // column, squared offset, first x it wins
    for y in 0..h {
        sites.clear();
        for x in 0..w {
            let r = row_of[y * w + x];
            if r == NO_ROW {
                continue;
            }
            let f = (f64::from(r) - y as f64).powi(2);
            let mut from = f64::NEG_INFINITY;
            while let Some(&(q, fq, start)) = sites.last() {
                from = ((f + (x * x) as f64) - (fq + (q * q) as f64)) / (2.0 * (x - q) as f64);
                if from > start {
                    break;
                }
                sites.pop();
                from = f64::NEG_INFINITY;
            }
            sites.push((x, f, from));
        }
        let mut k = 0;
        for x in 0..w {
            while k + 1 < sites.len() && sites[k + 1].2 <= x as f64 {
                k += 1;
            }
            if let Some(&(q, ..)) = sites.get(k) {
                nearest[y * w + x] = [q as u16, row_of[y * w + q]];
            }
        }
    }
    nearest
}
