//! What the robot knows of space: the voxel map, and beside it what rays and frontiers need of it.

use super::search::FlapError;
use crate::scene::Scene;
use crate::sim::{DepthCamera, DepthModel, Noise, World};
use frontier::Fringe;
use objsearch::{Belief, Volume, probability_of};
use std::collections::HashMap;
use std::sync::Arc;
use viewsample::flap::{CellState, Fan, FanPose, SightGrid};
use voxmap::{Cell, CellBox, Config, FanImage, SensorModel, State, VoxelMap};

/// Edge of a cell, m.
pub(super) const CELL: f64 = 0.05;
/// Range of the depth camera, m.
pub(super) const RANGE: (f64, f64) = (0.4, 3.0);
/// Field of view, rad.
pub(super) const FIELD: [f64; 2] = [0.9934, 0.6855];
/// Pixels of a depth image: four times as dense as the fan on each axis. Coarser images leave cells of surfaces
/// unknown, which then stay to be looked at for ever.
const PIXELS: [usize; 2] = [240, 168];
/// Height of walls, m.
const WALL: f64 = 2.5;

/// What is known, and what is still to be seen in the volumes.
#[derive(Clone, Debug)]
pub(super) struct Space {
    pub(super) map: VoxelMap,
    pub(super) sight: SightGrid,
    pub(super) fringe: Fringe,
    /// Number in the belief of each cell of the volumes, by its index in `sight`.
    pub(super) number: Arc<HashMap<u32, usize>>,
    /// Weight of each cell of the belief that is not known yet.
    pub(super) weights: Vec<f64>,
    /// Cells of the volumes as boxes of the map.
    pub(super) volumes: Vec<CellBox>,
    detection: f64,
    /// The map's occupied cells are the world's: they stop rays, so that what is predicted is what is seen.
    exact: bool,
}

/// What a look changed.
#[derive(Clone, Debug, Default)]
pub(super) struct Seen {
    /// Weight of what became known.
    pub(super) weight: f64,
    /// Centres of cells that stop rays now and did not before, or the other way round, m.
    pub(super) blocked: Vec<[f64; 3]>,
    /// Centres of all cells whose state changed, m.
    pub(super) changed: Vec<[f64; 3]>,
    /// Those cells.
    pub(super) cells: Vec<Cell>,
}

/// The map of a scene before anything was seen, and the belief about it.
pub(super) fn unknown(scene: &Scene) -> Result<(VoxelMap, Belief), FlapError> {
    // Cell borders are whole multiples of the edge, as in an octree.
    let cells = |v: f64| (v / CELL + 1e-6).floor();
    let (min, max) = (scene.bounds.min, scene.bounds.max);
    let low = min.map(|v| cells(v) * CELL);
    let map = VoxelMap::new(&Config {
        cell_size: CELL,
        low,
        high: max,
        sensor: SensorModel::default(),
    })?;
    let first = min.map(|v| cells(v) as i32);
    let volumes: Vec<Volume> = scene
        .target_volumes
        .iter()
        .map(|v| {
            // A millionth of a cell settles faces that lie on a border, as the octree's keys do.
            let nudged = |p: [f64; 3]| p.map(|x| x + 1e-6 * CELL);
            let volume = Volume::touching(nudged(v.min), nudged(v.max), [0.0; 3], CELL, v.p);
            let shifted = |c: [i32; 3]| [0, 1, 2].map(|a| c[a] - first[a]);
            Volume {
                low: shifted(volume.low),
                high: shifted(volume.high),
                ..volume
            }
        })
        .collect();
    if volumes.is_empty() {
        return Err(FlapError::NoVolumes(scene.name.clone()));
    }
    let bounds = map.bounds();
    let belief = Belief::new(&volumes, (bounds.low, bounds.high))?;
    Ok((map, belief))
}

/// Makes everything known as the solids have it, but what lies in the volumes: there only occupied cells are known.
pub(super) fn know_all(map: &mut VoxelMap, world: &World, volumes: &[CellBox]) {
    let all = map.bounds();
    for z in all.low[2]..all.high[2] {
        for y in all.low[1]..all.high[1] {
            for x in all.low[0]..all.high[0] {
                if !volumes.iter().any(|v| v.contains([x, y, z])) {
                    map.set_state([x, y, z], State::Free);
                }
            }
        }
    }
    // Shrunk by a little, so that cells that only share a face with a solid stay free.
    let half = 0.5 * CELL * (1.0 - 1e-4);
    for solid in world.solids() {
        let first = map.cell_at(solid.low.map(|v| v - CELL));
        let last = map.cell_at(solid.high.map(|v| v + CELL));
        for z in first[2].max(all.low[2])..=last[2].min(all.high[2] - 1) {
            for y in first[1].max(all.low[1])..=last[1].min(all.high[1] - 1) {
                for x in first[0].max(all.low[0])..=last[0].min(all.high[0] - 1) {
                    if solid.meets_cube(map.center([x, y, z]), half) {
                        map.set_state([x, y, z], State::Occupied);
                    }
                }
            }
        }
    }
}

/// Raises the floor plan to walls.
pub(super) fn know_walls(map: &mut VoxelMap, walls: &super::plans::Pixels) {
    let pixel = super::plans::pixel();
    map.extrude(&walls.occupied, walls.size.0, walls.origin, pixel, WALL);
}

/// The depth camera of the simulator.
pub(super) fn camera() -> DepthCamera {
    let model = DepthModel {
        size: PIXELS,
        field: FIELD,
        min_range: RANGE.0,
        max_range: RANGE.1,
        ..DepthModel::default()
    };
    DepthCamera::new(model, Noise::default())
}

impl Space {
    pub(super) fn new(mut map: VoxelMap, belief: &Belief, detection: f64, exact: bool) -> Self {
        map.take_changes();
        let volumes: Vec<CellBox> = belief
            .volumes()
            .iter()
            .map(|v| CellBox {
                low: v.low,
                high: v.high,
            })
            .collect();
        let bounds = map.bounds();
        let inside = |cell: Cell| volumes.iter().any(|v| v.contains(cell));
        let sight = SightGrid::new(&map, (bounds.low, bounds.high), inside);
        let mut number = HashMap::new();
        let mut weights = Vec::new();
        for (cell, weight) in belief.cells() {
            if let Some(index) = sight.index_of(cell) {
                number.insert(index, weights.len());
                weights.push(if map.is_known(cell) { 0.0 } else { weight });
            }
        }
        Self {
            fringe: Fringe::new(&map),
            sight,
            map,
            number: Arc::new(number),
            weights,
            volumes,
            detection,
            exact,
        }
    }

    /// Takes a depth image from a pose and learns from it.
    pub(super) fn look(
        &mut self,
        world: &World,
        camera: &mut DepthCamera,
        fan: &Fan,
        pose: &FanPose,
    ) -> Result<Seen, FlapError> {
        let (ends, origin) = (fan.ends(pose), pose.position);
        let frame = robots::looking(origin, pose.yaw, pose.pitch);
        let scan = camera.scan(world, &(frame.rows(), origin));
        // A little along the ray, so that faces on a border between cells fall into the solid.
        let points: Vec<[f64; 3]> = scan
            .hits
            .iter()
            .map(|p| {
                let p = p.map(f64::from);
                let d = [0, 1, 2].map(|a| p[a] - origin[a]);
                let r = d.iter().map(|v| v * v).sum::<f64>().sqrt();
                [0, 1, 2].map(|a| p[a] + 1e-4 * d[a] / r)
            })
            .collect();
        self.map.insert_fan(&FanImage {
            origin,
            points: &points,
            range: RANGE,
            ends: &ends,
            stop_at_occupied: self.exact,
        })?;
        let cells: Vec<Cell> = self.map.take_changes().cells().collect();
        self.fringe.update(&self.map, cells.iter().copied());
        let mut seen = Seen::default();
        let sure = self.detection >= 1.0;
        for &cell in &cells {
            let center = self.map.center(cell);
            seen.changed.push(center);
            let Some(index) = self.sight.index_of(cell) else {
                continue;
            };
            let occupied = self.map.is_occupied(cell);
            if occupied != self.sight.is_occupied(index) {
                seen.blocked.push(center);
            }
            let number = self.number.get(&index).copied();
            if let Some(n) = number
                && (sure || occupied)
            {
                seen.weight += std::mem::take(&mut self.weights[n]);
            }
            // Where a look may miss the target, a free cell of the volumes stays open to further looks.
            if occupied {
                self.sight.set(cell, CellState::Occupied);
            } else if sure || number.is_none() {
                self.sight.set(cell, CellState::Free);
            } else {
                self.sight.set(cell, CellState::Unknown);
            }
        }
        seen.cells = cells;
        if !sure {
            let looked: Vec<u32> = self.sight.view(fan, pose).to_vec();
            for index in looked {
                if let Some(&n) = self.number.get(&index) {
                    seen.weight += self.miss(n);
                }
            }
        }
        Ok(seen)
    }

    /// The weight that a look covers which did not notice the target in a cell; what is left is the chance that it is there
    /// all the same (Bayes).
    fn miss(&mut self, n: usize) -> f64 {
        let p = probability_of(self.weights[n]);
        let noticed = p * self.detection;
        let left = (p - noticed) / (1.0 - noticed);
        self.weights[n] = -(-left).ln_1p();
        -(-noticed).ln_1p()
    }
}
