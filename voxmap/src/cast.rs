//! Ray casts, one or many: whole-number traversal that skips blocks without anything occupied.

use crate::geometry::{Cell, State};
use crate::map::VoxelMap;
use crate::steps::{END, Steps, along};
use crate::walk::{Hit, UnknownPolicy};

/// A ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start in the world frame, m.
    pub origin: [f64; 3],
    /// Direction; need not be unit.
    pub direction: [f64; 3],
}

impl VoxelMap {
    /// Casts a ray until it meets an occupied cell, leaves the map, or has gone `max` m. The direction need not be unit. The
    /// part of the ray before it enters the map is skipped; a ray that misses the map or is not finite ends where it starts.
    /// OctoMap calls this `castRay`.
    pub fn cast(
        &self,
        origin: [f64; 3],
        direction: [f64; 3],
        max: f64,
        unknown: UnknownPolicy,
    ) -> Hit {
        let norm = direction.iter().map(|v| v * v).sum::<f64>().sqrt();
        let mut hit = Hit {
            cell: self.cell_at(origin),
            occupied: false,
            distance: 0.0,
            unknown: 0,
        };
        let start = self.scaled(origin);
        let scale = max / (norm * self.cell_size);
        let way = direction.map(|v| v * scale);
        if !start.iter().chain(&way).all(|v| v.is_finite()) {
            return hit;
        }
        let Some((enter, leave)) = self.crossing(start, way) else {
            return hit;
        };
        // A hair inside, so that it falls into a cell of the map.
        let inside = |t: f64| {
            [0, 1, 2]
                .map(|a| (start[a] + t * way[a]).clamp(0.0, self.size[a] as f64 * (1.0 - 1e-12)))
        };
        let inner = way.map(|v| v * (leave - enter));
        let mut steps = Steps::new(inside(enter), inner, self.size);
        let (stopped, occupied) = match unknown {
            UnknownPolicy::Ignore => {
                let found = self.first_occupied(&mut steps);
                (found, found)
            }
            policy => self.look(&mut steps, policy, &mut hit.unknown),
        };
        let cell = steps.cell;
        hit.cell = [0, 1, 2].map(|a| cell[a] + self.first[a]);
        hit.occupied = occupied;
        hit.distance = if stopped {
            // Where the ray enters the cell.
            let entered = (0..3).fold(enter, |t, a| {
                let near = f64::from(cell[a]) + if way[a] < 0.0 { 1.0 } else { 0.0 };
                if way[a] == 0.0 {
                    t
                } else {
                    t.max((near - start[a]) / way[a])
                }
            });
            entered.min(leave) * max
        } else {
            leave * max
        };
        hit
    }

    /// By how much a step along each axis changes addresses of cells and of blocks.
    fn strides(&self, steps: &Steps) -> ([i64; 3], [i64; 3]) {
        let row = self.words as i64;
        let lines = (self.size[1] as i64, self.size[1].div_ceil(8) as i64);
        let [x, y, z] = steps.step;
        (
            [x, y * row * 64, z * row * 64 * lines.0],
            [x, y * row * 8, z * row * 8 * lines.1],
        )
    }

    /// The stored cell of an address.
    fn cell_of(&self, address: i64) -> Cell {
        // Maps have at most 2^30 cells; short divisions are quicker.
        let (address, row) = (address as u32, self.words as u32 * 64);
        let (line, lines) = (address / row, self.size[1] as u32);
        [address % row, line % lines, line / lines].map(|c| c as i32)
    }

    /// Looks at every cell. Returns whether the ray was stopped, and whether by an occupied cell.
    fn look(&self, steps: &mut Steps, policy: UnknownPolicy, unknown: &mut u32) -> (bool, bool) {
        let (by_cell, _) = self.strides(steps);
        let mut cells = steps.cells;
        let mut address = self.inner(steps.cell) as i64;
        let mut stopped = (false, false);
        for left in (0..=steps.left).rev() {
            let (word, bit) = (address as usize >> 6, address & 63);
            if self.occupied[word] >> bit & 1 != 0 {
                stopped = (true, true);
                break;
            }
            let known = self.free[word] >> bit & 1 != 0;
            *unknown += u32::from(!known);
            if policy == UnknownPolicy::Stop && !known {
                stopped = (true, false);
                break;
            }
            if left > 0 {
                let (_, axis) = cells.first();
                cells.pass(axis);
                address += along(axis, by_cell);
            }
        }
        steps.cell = self.cell_of(address);
        stopped
    }

    /// Goes to the first occupied cell, or to the end if there is none, and tells which. Blocks are crossed at one step each; the
    /// cells of those that hold something are looked at one by one.
    fn first_occupied(&self, steps: &mut Steps) -> bool {
        if steps.tight {
            return self.look(steps, UnknownPolicy::Ignore, &mut 0).1;
        }
        let (by_cell, by_block) = self.strides(steps);
        let mut cells = steps.cells;
        let mut address = self.inner(steps.cell) as i64;
        let mut blocks = steps.blocks();
        let mut block = self.block_of(steps.cell) as i64;
        // Where the ray entered the block, if cells were not followed to there.
        let mut entered = None;
        loop {
            let (leaves, side) = blocks.first();
            if self.blocks[block as usize] != 0 {
                if let Some((time, axis)) = entered.take() {
                    let cell;
                    (cell, cells) = steps.after(time, axis);
                    address = self.inner(cell) as i64;
                }
                loop {
                    let found = Self::bit(&self.occupied, address as usize);
                    let (time, axis) = cells.first();
                    if found || time > END {
                        steps.cell = self.cell_of(address);
                        return found;
                    }
                    cells.pass(axis);
                    address += along(axis, by_cell);
                    if time == leaves && axis == side {
                        break;
                    }
                }
            } else if leaves > END {
                (steps.cell, _) = steps.after(END, [0; 3]);
                return false;
            } else {
                entered = Some((leaves, side));
            }
            blocks.pass(side);
            block += along(side, by_block);
        }
    }

    /// Index of the block of a stored cell.
    fn block_of(&self, cell: Cell) -> usize {
        let [x, y, z] = cell.map(|v| v as usize / 8);
        (z * self.size[1].div_ceil(8) + y) * self.words * 8 + x
    }

    /// [`cast`](Self::cast) for many rays of the same length.
    pub fn cast_all(&self, rays: &[Ray], max: f64, unknown: UnknownPolicy) -> Vec<Hit> {
        rays.iter()
            .map(|ray| self.cast(ray.origin, ray.direction, max, unknown))
            .collect()
    }

    /// State of the cell of each point; unknown outside the map. OctoMap calls the single query `search`.
    pub fn states_at(&self, points: &[[f64; 3]]) -> Vec<State> {
        points
            .iter()
            .map(|&point| self.state(self.cell_at(point)))
            .collect()
    }

    /// Which cells can be seen from a point: [`line_of_sight`](Self::line_of_sight) to each, and nearer than `range` m. Lines
    /// end at the first cell that blocks them.
    pub fn visible(
        &self,
        from: [f64; 3],
        cells: &[Cell],
        range: f64,
        unknown_allowance: u32,
    ) -> Vec<bool> {
        cells
            .iter()
            .map(|&cell| {
                let center = self.center(cell);
                let square: f64 = (0..3).map(|a| (center[a] - from[a]).powi(2)).sum();
                square < range * range && self.line_of_sight(from, cell, unknown_allowance)
            })
            .collect()
    }
}
