//! What a pose would see: HEATS eq. 4.

use crate::geometry::{Held, Risers};
use crate::map::Cell;
use crate::params::Params;
use crate::world::{Eye, World};
use crate::{Frustum, Lidar, Pose};

/// Information gain of a view (HEATS eq. 4).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gain {
    /// Exploration frontier voxels seen by the LiDAR or the depth camera: the size of the union.
    pub exploration: u32,
    /// Inspection frontier voxels seen by the colour camera, those with level faces as often as
    /// [`Params::level_weight`](crate::Params::level_weight) says.
    pub inspection: u32,
    /// G_info: the two counts, weighted.
    pub info: f64,
}

/// The frontier voxels a view would see.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seen {
    /// Exploration frontier voxels seen by the LiDAR or the depth camera, in the order of columns.
    pub exploration: Vec<Cell>,
    /// Inspection frontier voxels seen by the colour camera, in the order of columns.
    pub inspection: Vec<Cell>,
}

/// Cells seen: index of a word and its bits, by ascending index.
pub(crate) type Words = Vec<(u32, u64)>;

/// The sensors, with what is the same for all poses worked out.
#[derive(Clone, Debug)]
pub(crate) struct Sensors {
    pub(crate) lidar: Option<Lidar>,
    pub(crate) depth: Frustum,
    pub(crate) rgb: Frustum,
    pub(crate) allowance: u32,
    /// Cosine of the largest incidence on inspection faces.
    incidence: Option<f64>,
    /// Half the side of a target, m.
    target: Option<f64>,
    exploration_weight: f64,
    inspection_weight: f64,
    cavity_weight: f64,
}

impl Sensors {
    pub(crate) fn new(params: &Params) -> Self {
        Self {
            lidar: params.lidar,
            depth: params.depth,
            rgb: params.rgb,
            allowance: params.unknown_allowance,
            incidence: params.max_incidence.map(f64::cos),
            target: params.target,
            exploration_weight: params.exploration_weight,
            inspection_weight: params.inspection_weight,
            cavity_weight: params.cavity_weight,
        }
    }

    /// The same sensors with other limits on what inspects a face.
    pub(crate) fn limited(&self, target: Option<f64>, max_incidence: Option<f64>) -> Self {
        Self {
            incidence: max_incidence.map(f64::cos),
            target,
            ..self.clone()
        }
    }

    /// Eq. 4 on counts: exploration cells of the LiDAR, those that only a camera sees, inspection cells.
    pub(crate) fn info(&self, lidar: u32, extra: u32, inspection: u32) -> f64 {
        // Without a LiDAR every exploration cell is the camera's.
        let cavity = if self.lidar.is_some() {
            self.cavity_weight
        } else {
            self.exploration_weight
        };
        self.exploration_weight * f64::from(lidar)
            + cavity * f64::from(extra)
            + self.inspection_weight * f64::from(inspection)
    }

    pub(crate) fn gain(&self, lidar: u32, extra: u32, inspection: u32) -> Gain {
        Gain {
            exploration: lidar + extra,
            inspection,
            info: self.info(lidar, extra, inspection),
        }
    }

    /// Columns around what the LiDAR reaches from a position, or one up to `margin` (m) beside it.
    pub(crate) fn lidar_rectangle(
        &self,
        world: &World,
        eye: [f64; 3],
        margin: f64,
    ) -> Option<[i32; 4]> {
        let r = self.lidar.as_ref()?.range + margin;
        world.rectangle([eye[0] - r, eye[1] - r], [eye[0] + r, eye[1] + r])
    }

    /// Columns around what the cameras reach.
    pub(crate) fn camera_rectangle(&self, world: &World, camera: &Pose) -> Option<[i32; 4]> {
        // All rays run between the eye and the frontier cells.
        let ([floor, ceiling], z) = (world.heights(), camera.translation[2]);
        let (floor, ceiling) = (floor.min(z), ceiling.max(z));
        let both = [&self.depth, &self.rgb]
            .into_iter()
            .filter_map(|f| f.footprint(camera, floor, ceiling));
        let (low, high) = both.reduce(|a, b| {
            (
                [0, 1].map(|n| a.0[n].min(b.0[n])),
                [0, 1].map(|n| a.1[n].max(b.1[n])),
            )
        })?;
        // The line to the free cell in front of a face ends one column aside.
        let h = world.cell_size;
        world.rectangle(low.map(|v| v - h), high.map(|v| v + h))
    }

    /// B_e^lidar: exploration cells in sight of the LiDAR at a position.
    pub(crate) fn lidar_sees(&self, world: &World, eye: [f64; 3]) -> Words {
        let mut seen = Vec::new();
        let (Some(lidar), Some(rectangle)) = (&self.lidar, self.lidar_rectangle(world, eye, 0.0))
        else {
            return seen;
        };
        let eye = world.eye(eye);
        let shape = lidar.shape();
        let h = world.cell_size;
        world.each_settled(rectangle, |word, c| {
            let all = world.exploration[word];
            if all == 0 {
                return;
            }
            let d = [0, 1, 2].map(|a| c[a] - eye.world[a]);
            let mask = keep(all, |n| shape.covers([d[0], d[1], d[2] + h * f64::from(n)]));
            if mask == 0 {
                return;
            }
            let mask = world.visible(&eye, word, mask, self.allowance);
            if mask != 0 {
                seen.push((word as u32, mask));
            }
        });
        seen
    }

    /// Calls `visit(word, exploration, inspection)` with the cells in sight of the depth and the
    /// colour camera; exploration cells in `known` are left out (and not looked for).
    pub(crate) fn camera_sees(
        &self,
        world: &World,
        camera: &Pose,
        known: &[(u32, u64)],
        mut visit: impl FnMut(usize, u64, u64),
    ) {
        let eye = world.eye(camera.translation);
        let held = self.held(world, camera);
        self.camera_covers(world, camera, known, |word, e, i| {
            let (e, i) = if self.incidence.is_some() {
                let e = world.visible(&eye, word, e, self.allowance);
                (
                    e,
                    self.faces_seen(world, camera, held.as_ref(), &eye, word, i),
                )
            } else {
                let mask = world.visible(&eye, word, e | i, self.allowance);
                (e & mask, i & mask)
            };
            if e | i != 0 {
                visit(word, e, i);
            }
        });
    }

    fn held(&self, world: &World, camera: &Pose) -> Option<Held> {
        let half = self.target? + 0.5 * world.cell_size;
        Some(Held::new(&self.rgb, camera, world.cell_size, half))
    }

    /// Those of the inspection cells `mask` of a word of which an open face is in sight, steeply enough.
    fn faces_seen(
        &self,
        world: &World,
        camera: &Pose,
        held: Option<&Held>,
        eye: &Eye,
        word: usize,
        mask: u64,
    ) -> u64 {
        let Some(least) = self.incidence else {
            return world.visible(eye, word, mask, self.allowance);
        };
        let mut by_face = [0u64; 6];
        let way = way(world, camera, word);
        let below = camera.to_camera(world.center(world.cell(word)));
        let mut rest = mask;
        while rest != 0 {
            let bit = rest.trailing_zeros();
            rest &= rest - 1;
            let up = world.cell_size * f64::from(bit);
            let mut faces = world.faces_eye(word, bit, [way[0], way[1], way[2] - up], least);
            if let Some(held) = held {
                let p = [0, 1, 2].map(|a| below[a] + up * camera.rotation[2][a]);
                faces = held.of(p, faces);
            }
            for (face, cells) in by_face.iter_mut().enumerate() {
                *cells |= u64::from(faces >> face & 1) << bit;
            }
        }
        let mut seen = 0;
        for (face, cells) in by_face.into_iter().enumerate() {
            seen |= world.visible_across(eye, word, cells & !seen, face, self.allowance);
        }
        seen
    }

    /// The same without sight: all cells inside the frustums.
    pub(crate) fn camera_covers(
        &self,
        world: &World,
        camera: &Pose,
        known: &[(u32, u64)],
        mut visit: impl FnMut(usize, u64, u64),
    ) {
        let Some(rectangle) = self.camera_rectangle(world, camera) else {
            return;
        };
        let h = world.cell_size;
        let eye = camera.translation;
        // With a hair to spare: a quick test before the exact one.
        let far2 = self.depth.far.max(self.rgb.far).powi(2) * (1.0 + 1e-9);
        let up = camera.rotation[2].map(|v| v * h);
        let (depth, rgb) = (Risers::new(&self.depth, up), Risers::new(&self.rgb, up));
        let held = self.held(world, camera);
        world.each_settled(rectangle, |word, c| {
            let way = [0, 1, 2].map(|a| eye[a] - c[a]);
            if way[0] * way[0] + way[1] * way[1] > far2 {
                return;
            }
            let p = camera.to_camera(c);
            let at = |n: u32| [0, 1, 2].map(|a| p[a] + f64::from(n) * up[a]);
            let mut e = depth.covers(p, world.exploration[word]);
            if e != 0 {
                e &= !mask_of(known, word);
            }
            let mut i = rgb.covers(p, world.inspection[word]);
            if let Some(least) = self.incidence {
                i = keep(i, |n| {
                    let from = [way[0], way[1], way[2] - h * f64::from(n)];
                    let faces = world.faces_eye(word, n, from, least);
                    faces != 0 && held.as_ref().is_none_or(|held| held.of(at(n), faces) != 0)
                });
            }
            if e | i != 0 {
                visit(word, e, i);
            }
        });
    }

    /// True if the cameras see one cell of their kind.
    pub(crate) fn camera_sees_cell(
        &self,
        world: &World,
        camera: &Pose,
        eye: &Eye,
        c: Cell,
        inspection: bool,
    ) -> bool {
        let frustum = if inspection { &self.rgb } else { &self.depth };
        let Some((word, bit)) = world.index(c) else {
            return false;
        };
        frustum.covers(camera.to_camera(world.center(c)))
            && if inspection {
                let held = self.held(world, camera);
                self.faces_seen(world, camera, held.as_ref(), eye, word, 1 << bit) != 0
            } else {
                world.visible(eye, word, 1 << bit, self.allowance) != 0
            }
    }
}

/// The bits of `mask` that pass a test.
#[inline]
fn keep(mask: u64, test: impl Fn(u32) -> bool) -> u64 {
    let (mut rest, mut kept) = (mask, 0);
    while rest != 0 {
        let bit = rest.trailing_zeros();
        rest &= rest - 1;
        kept |= u64::from(test(bit)) << bit;
    }
    kept
}

/// Bits of a word in a list ordered by index.
#[inline]
pub(crate) fn mask_of(words: &[(u32, u64)], word: usize) -> u64 {
    words
        .binary_search_by_key(&(word as u32), |w| w.0)
        .map_or(0, |n| words[n].1)
}

/// Number of cells in a list of words.
pub(crate) fn count(words: &[(u32, u64)]) -> u32 {
    words.iter().map(|w| w.1.count_ones()).sum()
}

/// From the centre of bit 0 of a word to the camera, m.
fn way(world: &World, camera: &Pose, word: usize) -> [f64; 3] {
    let c = world.center(world.cell(word));
    [0, 1, 2].map(|a| camera.translation[a] - c[a])
}
