//! Ground truth on a voxel grid: which space can be reached, which surface can be seen (G item 10).

use super::distance::{Plan, Prism};
use super::world::World;
use crate::scene::parry_vector as vec3;
use crate::scene::{Form, Scene, Solid};
use parry3d::math::Pose;
use parry3d::query::intersection_test;
use parry3d::shape::Cuboid;

const SOLID: u8 = 1;
const REACHED: u8 = 2;
const SURFACE: u8 = 4;

/// A grid that cannot be laid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GroundTruthError {
    /// The cell size is not a positive number.
    #[error("cell_size = {0} must be positive and finite")]
    CellSize(f64),
    /// So many cells that they would not fit in memory.
    #[error("{0:?} cells are more than 2^31")]
    TooLarge([usize; 3]),
}

/// The scene in voxels, as a perfect map of it would look.
#[derive(Clone, Debug)]
pub struct GroundTruth {
    cell_size: f64,
    low: [f64; 3],
    size: [usize; 3],
    cells: Vec<u8>,
    reached: usize,
    surface: usize,
}

impl GroundTruth {
    /// Heights above the floor between which surfaces are to be inspected, m (G item 12).
    pub const INSPECTED_BAND: (f64, f64) = (0.15, 2.4);
    /// A solid must reach this far into a voxel to fill it, m. The map bins a hit this far behind the surface.
    pub const DEPTH: f64 = 0.01;

    /// Voxelises a scene within its bounds and floods its free space from the start pose, over faces of voxels.
    ///
    /// # Errors
    /// [`GroundTruthError`] for a cell size that is not positive or a grid too large.
    pub fn new(scene: &Scene, world: &World, cell_size: f64) -> Result<Self, GroundTruthError> {
        if !(cell_size > 0.0 && cell_size.is_finite()) {
            return Err(GroundTruthError::CellSize(cell_size));
        }
        let (low, high) = (scene.bounds.min, scene.bounds.max);
        // A bound that is a whole number of cells must not gain one by rounding.
        let size =
            [0, 1, 2].map(|k| (((high[k] - low[k]) / cell_size - 1e-6).ceil() as usize).max(1));
        let count = size.iter().try_fold(1_usize, |n, &s| n.checked_mul(s));
        let count = count
            .filter(|&n| n < 1 << 31)
            .ok_or(GroundTruthError::TooLarge(size))?;
        let mut truth = Self {
            cell_size,
            low,
            size,
            cells: vec![0; count],
            reached: 0,
            surface: 0,
        };
        for solid in world.solids() {
            truth.fill(solid);
        }
        truth.fill_planes(world);
        truth.flood(scene);
        truth.mark_surface();
        Ok(truth)
    }

    /// Number of voxels along x, y, z.
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// Edge of a voxel, m.
    pub fn cell_size(&self) -> f64 {
        self.cell_size
    }

    fn index(&self, c: [usize; 3]) -> usize {
        (c[2] * self.size[1] + c[1]) * self.size[0] + c[0]
    }

    fn bits(&self, c: [i32; 3]) -> u8 {
        let inside = (0..3).all(|k| c[k] >= 0 && (c[k] as usize) < self.size[k]);
        if inside {
            self.cells[self.index(c.map(|v| v as usize))]
        } else {
            0
        }
    }

    /// Whether a solid fills some of the voxel.
    pub fn is_solid(&self, cell: [i32; 3]) -> bool {
        self.bits(cell) & SOLID != 0
    }

    /// Whether the voxel is free and connected with the start.
    pub fn is_reachable(&self, cell: [i32; 3]) -> bool {
        self.bits(cell) & REACHED != 0
    }

    /// Whether the voxel is solid with a reachable neighbour.
    pub fn is_surface(&self, cell: [i32; 3]) -> bool {
        self.bits(cell) & SURFACE != 0
    }

    /// Numbers of reachable and of surface voxels.
    pub fn counts(&self) -> (usize, usize) {
        (self.reached, self.surface)
    }

    /// All voxels with any of the given bits, in index order.
    fn with(&self, mask: u8) -> impl Iterator<Item = [i32; 3]> + '_ {
        let [nx, ny, _] = self.size;
        let chosen = self
            .cells
            .iter()
            .enumerate()
            .filter(move |(_, b)| **b & mask != 0);
        chosen.map(move |(i, _)| [i % nx, i / nx % ny, i / (nx * ny)].map(|v| v as i32))
    }

    /// All surface voxels, in index order.
    pub fn surface(&self) -> impl Iterator<Item = [i32; 3]> + '_ {
        self.with(SURFACE)
    }

    /// Share of the observable space, reachable free voxels and surface, that is known; 1 when there is none.
    pub fn explored_fraction(&self, is_known: impl Fn([i32; 3]) -> bool) -> f64 {
        share(self.with(REACHED | SURFACE), is_known)
    }

    /// Share of the surface voxels in [`INSPECTED_BAND`](Self::INSPECTED_BAND) that are inspected; 1 when there
    /// are none.
    pub fn inspected_fraction(&self, is_inspected: impl Fn([i32; 3]) -> bool) -> f64 {
        share(self.inspectable(), is_inspected)
    }

    /// Surface voxels whose centre lies in [`INSPECTED_BAND`](Self::INSPECTED_BAND), in index order.
    pub fn inspectable(&self) -> impl Iterator<Item = [i32; 3]> + '_ {
        let (low, high) = Self::INSPECTED_BAND;
        let center = move |c: [i32; 3]| (f64::from(c[2]) + 0.5) * self.cell_size;
        self.surface()
            .filter(move |&c| center(c) >= low && center(c) <= high)
    }

    pub(super) fn center(&self, c: [usize; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| self.low[k] + (c[k] as f64 + 0.5) * self.cell_size)
    }

    fn fill(&mut self, solid: &Solid) {
        let h = self.cell_size;
        let depth = Self::DEPTH.min(0.25 * h);
        let first = [0, 1, 2].map(|k| {
            ((solid.low[k] - self.low[k] + depth) / h)
                .floor()
                .clamp(0.0, self.size[k] as f64) as usize
        });
        let past = [0, 1, 2].map(|k| {
            ((solid.high[k] - self.low[k] - depth) / h)
                .ceil()
                .clamp(0.0, self.size[k] as f64) as usize
        });
        // The part of a voxel that must be met; two-sided, so that a thin plate still fills the voxel it lies in.
        let half = 0.5 * h - depth;
        let probe = Cuboid::new(vec3([half; 3]));
        let straight = matches!(solid.form, Form::Box(_))
            && solid.upright
            && solid.axes[0].iter().any(|v| v.abs() > 1.0 - 1e-12);
        let prism = Prism::of(solid);
        let (shape, at) = solid.parry();
        for z in first[2]..past[2] {
            for y in first[1]..past[1] {
                for x in first[0]..past[0] {
                    let center = self.center([x, y, z]);
                    let meets = if straight {
                        (0..3).all(|k| {
                            center[k] + half > solid.low[k] && center[k] - half < solid.high[k]
                        })
                    } else if let Some(prism) = &prism {
                        // Exact, where parry's f32 GJK is not on round shapes.
                        let plan = Plan::Rectangle([center[0], center[1]], [1.0, 0.0], [half; 2]);
                        let (low, high) = (center[2] - half, center[2] + half);
                        prism.distance(&Prism { plan, low, high }) <= 0.0
                    } else {
                        let cell = Pose::from_translation(vec3(center));
                        intersection_test(&cell, &probe, at, shape.as_ref())
                            .is_ok_and(|meets| meets.intersecting)
                    };
                    if meets {
                        let i = self.index([x, y, z]);
                        self.cells[i] |= SOLID;
                    }
                }
            }
        }
    }

    fn fill_planes(&mut self, world: &World) {
        let layer = self.size[0] * self.size[1];
        for z in 0..self.size[2] {
            let low = self.low[2] + z as f64 * self.cell_size;
            let below = world.floor > low + Self::DEPTH;
            let above = world.ceiling < low + self.cell_size - Self::DEPTH;
            if below || above {
                self.cells[z * layer..(z + 1) * layer]
                    .iter_mut()
                    .for_each(|b| *b |= SOLID);
            }
        }
    }

    fn flood(&mut self, scene: &Scene) {
        let column = [scene.start.x, scene.start.y];
        let start = [0, 1].map(|k| {
            let cell = ((column[k] - self.low[k]) / self.cell_size).floor();
            cell.clamp(0.0, (self.size[k] - 1) as f64) as usize
        });
        let seed = (0..self.size[2]).map(|z| [start[0], start[1], z]);
        let Some(seed) = seed
            .into_iter()
            .find(|&c| self.cells[self.index(c)] & SOLID == 0)
        else {
            return;
        };
        let mut stack = vec![seed];
        let i = self.index(seed);
        self.cells[i] |= REACHED;
        while let Some(c) = stack.pop() {
            self.reached += 1;
            for n in neighbours(c, self.size) {
                let i = self.index(n);
                if self.cells[i] & (SOLID | REACHED) == 0 {
                    self.cells[i] |= REACHED;
                    stack.push(n);
                }
            }
        }
    }

    fn mark_surface(&mut self) {
        let all: Vec<[i32; 3]> = self.with(SOLID).collect();
        for c in all {
            let c = c.map(|v| v as usize);
            if neighbours(c, self.size).any(|n| self.cells[self.index(n)] & REACHED != 0) {
                let i = self.index(c);
                self.cells[i] |= SURFACE;
                self.surface += 1;
            }
        }
    }
}

/// The neighbours over faces that exist.
fn neighbours(c: [usize; 3], size: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..6).filter_map(move |i| {
        let (axis, up) = (i / 2, i % 2 == 1);
        let mut n = c;
        n[axis] = if up {
            c[axis] + 1
        } else {
            c[axis].checked_sub(1)?
        };
        (n[axis] < size[axis]).then_some(n)
    })
}

fn share(cells: impl Iterator<Item = [i32; 3]>, test: impl Fn([i32; 3]) -> bool) -> f64 {
    let (mut all, mut passed) = (0_usize, 0_usize);
    for cell in cells {
        all += 1;
        passed += usize::from(test(cell));
    }
    if all == 0 {
        1.0
    } else {
        passed as f64 / all as f64
    }
}
