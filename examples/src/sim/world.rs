//! The world as exact geometry.

use super::tree::{Tree, entry};
use crate::scene::{Scene, Solid};
use rayon::prelude::*;

/// Rays handed to one worker at a time.
const CHUNK: usize = 256;

/// All solids of a scene, its floor and its ceiling.
#[derive(Clone, Debug)]
pub struct World {
    pub(crate) solids: Vec<Solid>,
    pub(crate) tree: Tree,
    /// Solid half space below, m.
    pub(crate) floor: f64,
    /// Solid half space above, m; infinite when the scene is open.
    pub(crate) ceiling: f64,
}

impl World {
    /// The geometry of a scene that passed its check.
    pub fn new(scene: &Scene) -> Self {
        let solids: Vec<Solid> = scene.shapes.iter().map(Solid::new).collect();
        let tree = Tree::new(&solids.iter().map(|s| (s.low, s.high)).collect::<Vec<_>>());
        Self {
            solids,
            tree,
            floor: scene.floor_z,
            ceiling: scene.ceiling_z.unwrap_or(f64::INFINITY),
        }
    }

    /// All solids, in the scene's order.
    pub fn solids(&self) -> &[Solid] {
        &self.solids
    }

    /// Distance along a ray to floor or ceiling, infinite if it meets neither.
    pub(crate) fn cast_planes(&self, z: f64, dz: f64) -> f64 {
        if dz < 0.0 {
            ((self.floor - z) / dz).max(0.0)
        } else if dz > 0.0 && self.ceiling.is_finite() {
            ((self.ceiling - z) / dz).max(0.0)
        } else {
            f64::INFINITY
        }
    }

    /// Where a ray first meets the world, in units of `direction`'s length; `None` beyond `max`, or when an
    /// argument is not finite.
    pub fn cast(&self, origin: [f64; 3], direction: [f64; 3], max: f64) -> Option<f64> {
        if !origin.iter().chain(&direction).all(|v| v.is_finite()) {
            return None;
        }
        let plane = self.cast_planes(origin[2], direction[2]);
        let mut best = max;
        let mut hit = None;
        if plane <= best {
            best = plane;
            hit = Some(plane);
        }
        let inverse = direction.map(|d| 1.0 / d);
        self.tree.descend(
            best,
            |low, high| entry(low, high, &origin, &inverse) - 1e-9,
            |i, best| match self.solids[i].cast(origin, direction, best) {
                Some(t) => {
                    hit = Some(t);
                    t
                }
                None => best,
            },
        );
        hit
    }

    /// Casts many rays from one origin, in parallel; `out[i]` is the result of `directions[i]`, infinite for a
    /// miss. The result does not depend on the number of threads.
    pub fn cast_many(
        &self,
        origin: [f64; 3],
        directions: &[[f64; 3]],
        max: f64,
        out: &mut Vec<f64>,
    ) {
        out.clear();
        out.resize(directions.len(), f64::INFINITY);
        out.par_chunks_mut(CHUNK)
            .zip(directions.par_chunks(CHUNK))
            .for_each(|(out, directions)| {
                for (t, &d) in out.iter_mut().zip(directions) {
                    *t = self.cast(origin, d, max).unwrap_or(f64::INFINITY);
                }
            });
    }

    /// Whether nothing stands between two points.
    pub fn visible(&self, from: [f64; 3], to: [f64; 3]) -> bool {
        let d = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
        self.cast(from, d, 1.0).is_none()
    }
}
