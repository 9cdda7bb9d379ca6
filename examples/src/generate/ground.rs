//! Which ground a base can reach.

use super::Rect;
use crate::scene::{Scene, Solid};

/// Side of a cell, m.
const CELL: f64 = 0.1;
/// What stands lower than this is in the way of base and arm, m.
const BAND: f64 = 1.2;

/// The ground on which a disc gets from the start to anywhere.
pub(super) struct Reach {
    size: [usize; 2],
    reached: Vec<bool>,
}

impl Reach {
    /// Floods the ground of a scene from its start, for a disc of `radius` m.
    pub(super) fn of(scene: &Scene, radius: f64) -> Self {
        let size = [0, 1].map(|k| (scene.bounds.max[k] / CELL).ceil().max(1.0) as usize);
        let mut reach = Self {
            size,
            reached: vec![false; size[0] * size[1]],
        };
        let mut blocked = vec![false; size[0] * size[1]];
        for shape in &scene.shapes {
            let solid = Solid::new(shape);
            if solid.low[2] > BAND {
                continue;
            }
            let solid = Rect::new([solid.low[0], solid.low[1]], [solid.high[0], solid.high[1]]);
            let range = |k: usize| {
                let low = ((solid.min[k] - radius) / CELL).floor().max(0.0) as usize;
                let high = ((solid.max[k] + radius) / CELL).ceil().max(0.0) as usize;
                low..high.min(size[k])
            };
            for y in range(1) {
                for x in range(0) {
                    let p = [x, y].map(|c| (c as f64 + 0.5) * CELL);
                    let off =
                        [0, 1].map(|k| (solid.min[k] - p[k]).max(p[k] - solid.max[k]).max(0.0));
                    if off[0].hypot(off[1]) < radius {
                        blocked[y * size[0] + x] = true;
                    }
                }
            }
        }
        let first = [scene.start.x, scene.start.y].map(|v| (v / CELL).max(0.0) as usize);
        let first = first[1].min(size[1] - 1) * size[0] + first[0].min(size[0] - 1);
        let mut open = vec![first];
        reach.reached[first] = !blocked[first];
        while let Some(at) = open.pop() {
            let (x, y) = (at % size[0], at / size[0]);
            let next = [
                (x > 0).then(|| at - 1),
                (x + 1 < size[0]).then(|| at + 1),
                (y > 0).then(|| at - size[0]),
                (y + 1 < size[1]).then(|| at + size[0]),
            ];
            for n in next.into_iter().flatten() {
                if !blocked[n] && !reach.reached[n] {
                    reach.reached[n] = true;
                    open.push(n);
                }
            }
        }
        reach
    }

    /// Whether the disc gets to a point.
    pub(super) fn reaches(&self, p: [f64; 2]) -> bool {
        let c = p.map(|v| (v / CELL).floor());
        if !(0..2).all(|k| c[k] >= 0.0 && c[k] < self.size[k] as f64) {
            return false;
        }
        self.reached[c[1] as usize * self.size[0] + c[0] as usize]
    }
}
