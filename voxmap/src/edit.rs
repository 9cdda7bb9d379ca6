//! Changes that are no scans: states set by hand, regions reset, forgotten or decayed.

use crate::geometry::{Ball, Cell, State};
use crate::map::VoxelMap;
use crate::sensor::UNIT;

impl VoxelMap {
    /// Log-odds of a cell, 0 for unknown ones.
    pub fn log_odds(&self, cell: Cell) -> f64 {
        if self.contains(cell) {
            f64::from(self.log(cell)) * UNIT
        } else {
            0.0
        }
    }

    /// Log-odds of a cell inside the map, in stored units.
    pub(crate) fn log(&self, cell: Cell) -> i8 {
        let [x, y, z] = self.stored(cell).map(|v| v as usize);
        self.log.get(x / 64, y, z).map_or(0, |row| row[x % 64])
    }

    /// Makes a cell inside the map known with these log-odds.
    pub(crate) fn set_log(&mut self, cell: Cell, log: i8) {
        let occupied = log >= self.odds.occupied;
        self.put(
            cell,
            if occupied {
                State::Occupied
            } else {
                State::Free
            },
            log,
        );
    }

    /// Sets the state of a cell, saturated; outside the map nothing happens.
    pub fn set_state(&mut self, cell: Cell, state: State) {
        if !self.contains(cell) {
            return;
        }
        let log = match state {
            State::Unknown => 0,
            State::Free => self.odds.min,
            State::Occupied => self.odds.max,
        };
        self.put(cell, state, log);
    }

    fn put(&mut self, cell: Cell, state: State, log: i8) {
        let [x, y, z] = self.stored(cell).map(|v| v as usize);
        let (w, bit) = (x / 64, 1u64 << (x % 64));
        if log != 0 {
            self.log.make(w, y, z)[x % 64] = log;
        } else if let Some(row) = self.log.get_mut(w, y, z) {
            row[x % 64] = 0;
        }
        let (mut free, mut occupied) = (0, 0);
        match state {
            State::Unknown => {}
            State::Free => free = bit,
            State::Occupied => occupied = bit,
        }
        self.write(w, y, z, bit, free, occupied);
    }

    /// Sets the free and occupied bits of `which` cells of a word, and everything that follows from them.
    #[inline]
    pub(crate) fn write(
        &mut self,
        w: usize,
        y: usize,
        z: usize,
        which: u64,
        free: u64,
        occupied: u64,
    ) {
        let word = self.word(w, y, z);
        let (was_free, was_occupied) = (self.free[word], self.occupied[word]);
        let free = was_free & !which | free & which;
        let occupied = was_occupied & !which | occupied & which;
        let changed = (free ^ was_free) | (occupied ^ was_occupied);
        if changed == 0 {
            return;
        }
        self.free[word] = free;
        self.occupied[word] = occupied;
        self.dirty.state(word, changed);
        if occupied == was_occupied {
            return;
        }
        let row = (z / 8 * self.size[1].div_ceil(8) + y / 8) * self.words * 8 + w * 8;
        let (before, after) = (was_occupied.to_le_bytes(), occupied.to_le_bytes());
        for (count, (b, a)) in self.blocks[row..row + 8]
            .iter_mut()
            .zip(before.iter().zip(&after))
        {
            *count = *count + a.count_ones() as u16 - b.count_ones() as u16;
        }
        // What stops being occupied stops being inspected.
        if was_occupied & !occupied != 0
            && let Some(seen) = self.seen.get_mut(w, y, z)
        {
            for plane in seen {
                *plane &= occupied;
            }
        }
    }

    /// Sets every cell whose centre lies in the ball free.
    pub fn set_free_sphere(&mut self, center: [f64; 3], radius: f64) {
        let ball = Ball { center, radius };
        self.for_cells_in(&ball, |map, cell| map.set_state(cell, State::Free));
    }

    /// Sets every cell whose centre lies in the box free, m.
    pub fn set_free_box(&mut self, low: [f64; 3], high: [f64; 3]) {
        self.for_words_in(low, high, |map, w, y, z, which| {
            let log = map.odds.min;
            fill(map.log.make(w, y, z), which, log);
            map.write(w, y, z, which, which, 0);
        });
    }

    /// Forgets every cell whose centre lies in the box, m.
    pub fn reset_box(&mut self, low: [f64; 3], high: [f64; 3]) {
        self.for_words_in(low, high, |map, w, y, z, which| {
            if let Some(row) = map.log.get_mut(w, y, z) {
                fill(row, which, 0);
            }
            map.write(w, y, z, which, 0, 0);
        });
    }

    /// Forgets a little of every cell whose centre lies in the box: known log-odds move towards 0 by `by` (at least one
    /// stored unit of 0.05), and a cell that arrives becomes unknown. Called now and then on a region that is out of sight,
    /// it makes the robot look again where things may have moved. Nothing decays by itself.
    pub fn decay_box(&mut self, low: [f64; 3], high: [f64; 3], by: f64) {
        let step = (by / UNIT).round().clamp(1.0, 127.0) as i8;
        self.for_words_in(low, high, |map, w, y, z, which| {
            let word = map.word(w, y, z);
            let mut known = (map.free[word] | map.occupied[word]) & which;
            if known == 0 {
                return;
            }
            let (mut free, mut occupied) = (0, 0);
            let touched = known;
            let limit = map.odds.occupied;
            let row = map.log.make(w, y, z);
            while known != 0 {
                let x = known.trailing_zeros();
                known &= known - 1;
                let log = &mut row[x as usize];
                *log -= log.signum() * step.min(log.saturating_abs());
                if *log >= limit && *log != 0 {
                    occupied |= 1 << x;
                } else if *log != 0 {
                    free |= 1 << x;
                }
            }
            map.write(w, y, z, touched, free, occupied);
        });
    }

    /// Calls `visit` with every word that has cells whose centres lie in a box (m), and those cells.
    fn for_words_in(
        &mut self,
        low: [f64; 3],
        high: [f64; 3],
        mut visit: impl FnMut(&mut Self, usize, usize, usize, u64),
    ) {
        // Limits pass over NaN, which would make the box the whole map.
        if low.iter().chain(&high).any(|v| v.is_nan()) {
            return;
        }
        // The first and last cell with its centre inside, per axis; a thousandth of a cell forgives rounding.
        let mut range = [(0, 0); 3];
        for a in 0..3 {
            let n = self.size[a] as f64;
            let first = ((low[a] - self.low[a]) / self.cell_size - 0.501)
                .ceil()
                .max(0.0);
            let last = ((high[a] - self.low[a]) / self.cell_size - 0.499)
                .floor()
                .min(n - 1.0);
            if first > last {
                return;
            }
            range[a] = (first as usize, last as usize);
        }
        let [(x0, x1), (y0, y1), (z0, z1)] = range;
        for z in z0..=z1 {
            for y in y0..=y1 {
                for w in x0 / 64..=x1 / 64 {
                    let mut which = u64::MAX;
                    if w == x0 / 64 {
                        which &= u64::MAX << (x0 % 64);
                    }
                    if w == x1 / 64 {
                        which &= u64::MAX >> (63 - x1 % 64);
                    }
                    visit(self, w, y, z, which);
                }
            }
        }
    }

    /// The nearest cell inside the map.
    pub(crate) fn clamped(&self, cell: Cell) -> Cell {
        [0, 1, 2].map(|a| cell[a].clamp(self.first[a], self.first[a] + self.size[a] as i32 - 1))
    }

    /// Calls `visit` for every cell inside the map whose centre lies in the ball.
    pub(crate) fn for_cells_in(&mut self, ball: &Ball, mut visit: impl FnMut(&mut Self, Cell)) {
        let Ball { center, radius } = *ball;
        if !(radius >= 0.0 && center.iter().all(|v| v.is_finite())) {
            return;
        }
        let first = self.clamped(self.cell_at(center.map(|v| v - radius)));
        let last = self.clamped(self.cell_at(center.map(|v| v + radius)));
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let c = self.center([x, y, z]);
                    let square: f64 = (0..3).map(|a| (c[a] - center[a]).powi(2)).sum();
                    if square <= radius * radius {
                        visit(self, [x, y, z]);
                    }
                }
            }
        }
    }
}

/// Sets some cells of a row.
fn fill(row: &mut [i8; 64], mut which: u64, log: i8) {
    while which != 0 {
        row[which.trailing_zeros() as usize] = log;
        which &= which - 1;
    }
}
