//! Ray casts, one or many: whole-number traversal that skips blocks without anything occupied.

use crate::geometry::{Cell, State};
use crate::map::VoxelMap;
use crate::walk::{Hit, UnknownPolicy};

/// Time at which a ray ends. Crossings are times in whole numbers, so that many steps at once give the same bits as one at a
/// time.
const ONE: f64 = (1u64 << 52) as f64;
/// Crossings after it do not count: a billionth of the ray, more than rounding can move a crossing in 2^22 cells. A ray that
/// ends on the border of the map stays inside.
const END: i64 = (1 << 52) - (1 << 22);
/// Cells along the edge of a block.
const BLOCK: i32 = 8;

/// A ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start in the world frame, m.
    pub origin: [f64; 3],
    /// Direction; need not be unit.
    pub direction: [f64; 3],
}

/// Cells of a ray inside the map, in stored cells.
struct Steps {
    cell: Cell,
    /// Time of the next crossing on each axis.
    next: [i64; 3],
    delta: [i64; 3],
    step: Cell,
    /// Steps left.
    left: u32,
}

impl Steps {
    /// From a point inside a map of `size` cells on a way that does not leave it; cell units.
    #[inline]
    fn new(from: [f64; 3], way: [f64; 3], size: [usize; 3]) -> Self {
        let mut steps = Self {
            cell: [0; 3],
            next: [i64::MAX; 3],
            delta: [0; 3],
            step: [0; 3],
            left: 0,
        };
        for a in 0..3 {
            let top = size[a] as i32 - 1;
            let first = (from[a] as i32).min(top);
            steps.cell[a] = first;
            if way[a] == 0.0 {
                continue;
            }
            let up = way[a] > 0.0;
            let behind = from[a] - f64::from(first);
            let (border, room) = if up {
                (1.0 - behind, top - first)
            } else {
                (behind, first)
            };
            let inverse = ONE / way[a].abs();
            // Saturates for ways that are far below a cell.
            let (next, delta) = ((border * inverse + 0.5) as i64, (inverse + 0.5) as i64);
            if next <= END {
                let crossings = (END - next) / delta + 1;
                steps.left += crossings.min(i64::from(room)) as u32;
            }
            steps.next[a] = next;
            steps.delta[a] = delta;
            steps.step[a] = if up { 1 } else { -1 };
        }
        steps
    }

    /// One step; returns its axis. Ties go to the lower axis. Without branches: which axis is next is as good as random.
    #[inline]
    fn advance(&mut self) -> usize {
        let first = self.next[0].min(self.next[1]).min(self.next[2]);
        let x = self.next[0] == first;
        let y = !x & (self.next[1] == first);
        let z = !(x | y);
        for (a, along) in [x, y, z].into_iter().enumerate() {
            self.next[a] = self.next[a].saturating_add(self.delta[a] & -i64::from(along));
            self.cell[a] += self.step[a] & -i32::from(along);
        }
        usize::from(y) + 2 * usize::from(z)
    }

    /// Leaves the block that the ray is in; false if it ends in there.
    #[inline]
    fn leave_block(&mut self) -> bool {
        // Crossings until the block is left, and the time of the last of them.
        let mut count = [0i64; 3];
        let mut exit = [i64::MAX; 3];
        for a in 0..3 {
            if self.step[a] != 0 {
                let inside = i64::from(self.cell[a] & (BLOCK - 1));
                count[a] = if self.step[a] > 0 {
                    i64::from(BLOCK) - inside
                } else {
                    inside + 1
                };
                exit[a] = self.next[a].saturating_add((count[a] - 1).saturating_mul(self.delta[a]));
            }
        }
        let first = exit[0].min(exit[1]).min(exit[2]);
        let axis = if exit[0] == first {
            0
        } else if exit[1] == first {
            1
        } else {
            2
        };
        for a in 0..3 {
            if a != axis {
                // Crossings before that time; at that very time the lower axis goes first.
                let until = first.saturating_sub(i64::from(a > axis));
                count[a] = if self.step[a] == 0 || self.next[a] > until {
                    0
                } else {
                    (until - self.next[a]) / self.delta[a] + 1
                };
            }
        }
        let all = count.iter().sum::<i64>();
        if first == i64::MAX || all > i64::from(self.left) {
            return false;
        }
        self.left -= all as u32;
        for a in 0..3 {
            self.next[a] = self.next[a].saturating_add(count[a].saturating_mul(self.delta[a]));
            self.cell[a] += self.step[a] * count[a] as i32;
        }
        true
    }
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

    /// Looks at every cell. Returns whether the ray was stopped, and whether by an occupied cell.
    fn look(&self, steps: &mut Steps, policy: UnknownPolicy, unknown: &mut u32) -> (bool, bool) {
        loop {
            let address = self.inner(steps.cell);
            if Self::bit(&self.occupied, address) {
                return (true, true);
            }
            if !Self::bit(&self.free, address) {
                *unknown += 1;
                if policy == UnknownPolicy::Stop {
                    return (true, false);
                }
            }
            if steps.left == 0 {
                return (false, false);
            }
            steps.left -= 1;
            steps.advance();
        }
    }

    /// Goes to the first occupied cell, or to the end if there is none, and tells which.
    fn first_occupied(&self, steps: &mut Steps) -> bool {
        let grid = [self.words * 8, self.size[1].div_ceil(8)];
        loop {
            let [x, y, z] = steps.cell.map(|v| v as usize / 8);
            if self.blocks[(z * grid[1] + y) * grid[0] + x] == 0 {
                if steps.leave_block() {
                    continue;
                }
                // It ends in an empty block.
                while steps.left > 0 {
                    steps.left -= 1;
                    steps.advance();
                }
                return false;
            }
            loop {
                if Self::bit(&self.occupied, self.inner(steps.cell)) {
                    return true;
                }
                if steps.left == 0 {
                    return false;
                }
                steps.left -= 1;
                let axis = steps.advance();
                // The first cell of a block, seen from where the ray comes from.
                let entry = if steps.step[axis] > 0 { 0 } else { BLOCK - 1 };
                if steps.cell[axis] & (BLOCK - 1) == entry {
                    break;
                }
            }
        }
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
