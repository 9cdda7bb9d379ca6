//! Shared by the test files: small maps and exact geometry.
#![allow(dead_code, unreachable_pub)]

use voxmap::{Cell, Config, SensorModel, State, VoxelMap};

pub fn map(cell_size: f64, size: [f64; 3]) -> VoxelMap {
    let low = [-1.0, 0.5, 0.0];
    let high = [0, 1, 2].map(|a| low[a] + cell_size * size[a]);
    VoxelMap::new(&Config {
        cell_size,
        low,
        high,
        sensor: SensorModel::default(),
    })
    .unwrap()
}

/// A deterministic sequence of numbers in 0..1.
pub struct Numbers(pub u64);

impl Numbers {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }

    /// A point around a map: mostly inside, sometimes outside.
    pub fn point(&mut self, map: &VoxelMap) -> [f64; 3] {
        let h = map.cell_size();
        [0, 1, 2].map(|a| {
            let n = map.size()[a] as f64;
            map.low()[a] + h * (self.next() * (n + 6.0) - 3.0)
        })
    }

    pub fn cell(&mut self, map: &VoxelMap) -> Cell {
        [0, 1, 2].map(|a| self.below(map.size()[a]) as i32)
    }
}

pub fn cells(map: &VoxelMap) -> impl Iterator<Item = Cell> + use<> {
    let [nx, ny, nz] = map.size().map(|n| n as i32);
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

/// Each cell free, occupied or unknown with the given chances.
pub fn random_map(seed: u64, size: [f64; 3], free: f64, occupied: f64) -> VoxelMap {
    let mut map = map(0.25, size);
    let mut numbers = Numbers(seed);
    for cell in cells(&map) {
        let r = numbers.next();
        if r < free {
            map.set_state(cell, State::Free);
        } else if r < free + occupied {
            map.set_state(cell, State::Occupied);
        }
    }
    map
}

/// Parameters of the segment inside the cell's cube grown by `grow` m; empty if entry is behind exit.
pub fn overlap(map: &VoxelMap, cell: Cell, from: [f64; 3], to: [f64; 3], grow: f64) -> (f64, f64) {
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    let h = map.cell_size();
    for a in 0..3 {
        let low = map.low()[a] + f64::from(cell[a]) * h - grow;
        let high = low + h + 2.0 * grow;
        let way = to[a] - from[a];
        if way == 0.0 {
            if from[a] < low || from[a] > high {
                return (1.0, 0.0);
            }
        } else {
            let (t0, t1) = ((low - from[a]) / way, (high - from[a]) / way);
            enter = enter.max(t0.min(t1));
            leave = leave.min(t0.max(t1));
        }
    }
    (enter, leave)
}
