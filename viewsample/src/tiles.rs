//! LiDAR views shared by all libraries, one for each square of the floor.
//!
//! Neighbouring base poses see almost the same with an all-round LiDAR, and clusters come and go
//! while the robot stays in the same rooms. So the LiDAR looks from the middle of the square its
//! position falls into ([`Params::lidar_grid`](crate::Params::lidar_grid)) and the view outlives the libraries.

use std::sync::OnceLock;

use crate::gain::{self, Sensors, Words};
use crate::world::World;

/// The exploration cells a LiDAR sees.
#[derive(Clone, Debug)]
pub(crate) struct LidarView {
    pub(crate) words: Words,
    pub(crate) count: u32,
    /// Tells this view from an earlier one of the same place.
    pub(crate) stamp: u64,
    /// Update since when the map in range differs.
    pub(crate) stale_since: Option<u64>,
}

impl LidarView {
    pub(crate) fn cast(world: &World, sensors: &Sensors, eye: [f64; 3], stamp: u64) -> Self {
        let words = sensors.lidar_sees(world, eye);
        let count = gain::count(&words);
        Self {
            words,
            count,
            stamp,
            stale_since: None,
        }
    }

    /// Notes that something in range changed, and takes off what is no frontier any more.
    pub(crate) fn touch(&mut self, world: &World, tick: u64) {
        self.stale_since.get_or_insert(tick);
        for (word, mask) in &mut self.words {
            *mask &= world.exploration[*word as usize];
        }
        self.count = gain::count(&self.words);
    }

    /// True if the view is no older than patience allows.
    pub(crate) fn is_good(&self, tick: u64, patience: u32) -> bool {
        self.stale_since
            .is_none_or(|since| tick - since < u64::from(patience))
    }
}

/// The squares over the extent of the map.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tiles {
    side: f64,
    height: f64,
    low: [i64; 2],
    size: [usize; 2],
    slots: Vec<OnceLock<LidarView>>,
}

impl Tiles {
    /// Empty squares over the world; none if the LiDAR is to look from where it is.
    pub(crate) fn over(world: &World, sensors: &Sensors, side: f64) -> Self {
        let Some(lidar) = sensors.lidar.filter(|_| side > 0.0) else {
            return Self::default();
        };
        let edge = |c: i32, a: usize| world.zero[a] + (f64::from(c) - 0.5) * world.cell_size;
        let low = [0, 1].map(|a| (edge(world.low[a], a) / side).floor() as i64);
        let high = [0, 1].map(|a| (edge(world.high()[a], a) / side).floor() as i64 + 1);
        let size = [0, 1].map(|a| (high[a] - low[a]).max(0) as usize);
        // A side much smaller than a cell shares nothing.
        if side < 0.1 * world.cell_size {
            return Self::default();
        }
        Self {
            side,
            height: lidar.offset[2],
            low,
            size,
            slots: vec![OnceLock::new(); size[0] * size[1]],
        }
    }

    /// The square of a LiDAR position and the position in its middle; none if there is no square, or
    /// its middle is not free.
    pub(crate) fn at(
        &self,
        world: &World,
        eye: [f64; 3],
    ) -> Option<(&OnceLock<LidarView>, [f64; 3])> {
        if self.slots.is_empty() {
            return None;
        }
        let n = [0, 1].map(|a| (eye[a] / self.side).floor() as i64);
        let [x, y] = [0, 1].map(|a| {
            usize::try_from(n[a] - self.low[a])
                .ok()
                .filter(|v| *v < self.size[a])
        });
        let slot = self.slots.get(y? * self.size[0] + x?)?;
        let middle = self.middle(n);
        world.is_free_at(middle).then_some((slot, middle))
    }

    fn middle(&self, n: [i64; 2]) -> [f64; 3] {
        [
            (n[0] as f64 + 0.5) * self.side,
            (n[1] as f64 + 0.5) * self.side,
            self.height,
        ]
    }

    /// Marks the views in range of what changed, and drops those that are too old.
    pub(crate) fn invalidate(
        &mut self,
        world: &World,
        sensors: &Sensors,
        tick: u64,
        patience: u32,
    ) {
        for index in 0..self.slots.len() {
            let n = [
                self.low[0] + (index % self.size[0]) as i64,
                self.low[1] + (index / self.size[0]) as i64,
            ];
            let middle = self.middle(n);
            let slot = &mut self.slots[index];
            if let Some(view) = slot.get_mut() {
                let around = sensors.lidar_rectangle(world, middle, 0.0);
                if around.is_some_and(|r| world.is_dirty(r)) {
                    view.touch(world, tick);
                }
                if !view.is_good(tick, patience) {
                    slot.take();
                }
            }
        }
    }
}
