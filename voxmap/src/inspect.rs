//! The inspected layer: which cells of the surface the camera has seen well enough (HEATS sect. IV-A).

use crate::geometry::{Camera, Cell};
use crate::map::VoxelMap;

impl VoxelMap {
    /// Marks what the camera inspects: occupied cells whose centre is inside the image, nearer than `range` m, with no other
    /// occupied cell on the line from the camera to the centre (unknown does not block). Returns how many are new.
    ///
    /// A cell that stops being occupied stops being inspected.
    pub fn mark_inspected(&mut self, camera: &Camera, range: f64) -> usize {
        self.mark(camera, range, |_, _| true)
    }

    /// As [`mark_inspected`](Self::mark_inspected), but a cell counts only if the camera looks at it from outside at no more
    /// than `max_incidence` rad to the normal of its surface: one of its faces towards a free cell, or the mean of those
    /// where it has several, since slanted surfaces are staircases of such cells.
    pub fn mark_inspected_within(
        &mut self,
        camera: &Camera,
        range: f64,
        max_incidence: f64,
    ) -> usize {
        let eye = camera.translation;
        self.mark(camera, range, |map, cell| {
            map.faces(cell, eye, max_incidence)
        })
    }

    fn mark(
        &mut self,
        camera: &Camera,
        range: f64,
        accepts: impl Fn(&Self, Cell) -> bool,
    ) -> usize {
        let eye = camera.translation;
        let finite = camera
            .rotation
            .iter()
            .flatten()
            .chain(&eye)
            .all(|v| v.is_finite());
        if !(range > 0.0 && finite) {
            return 0;
        }
        let (low, high) = camera_box(camera, range);
        let first = self.clamped(self.cell_at(low));
        let last = self.clamped(self.cell_at(high));
        let mut marks: Vec<Cell> = Vec::new();
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for w in first[0] as usize / 64..=last[0] as usize / 64 {
                    let word = self.word(w, y as usize, z as usize);
                    let mut open = self.occupied[word] & !self.inspected[word];
                    while open != 0 {
                        let x = (w * 64) as i32 + open.trailing_zeros() as i32;
                        open &= open - 1;
                        let cell = [x, y, z];
                        let center = self.center(cell);
                        let square: f64 = (0..3).map(|a| (center[a] - eye[a]).powi(2)).sum();
                        if square < range * range
                            && camera.sees(center)
                            && accepts(self, cell)
                            && self.line_of_sight(eye, cell, u32::MAX)
                        {
                            marks.push(cell);
                        }
                    }
                }
            }
        }
        for &cell in &marks {
            let address = self.address(cell);
            self.inspected[address >> 6] |= 1 << (address & 63);
            self.dirty.inspected(cell);
        }
        marks.len()
    }

    /// True if an eye looks at an exposed face of the cell from outside, at no more than `max_incidence` to its normal.
    fn faces(&self, cell: Cell, eye: [f64; 3], max_incidence: f64) -> bool {
        let center = self.center(cell);
        let way = [0, 1, 2].map(|a| eye[a] - center[a]);
        let length = way.iter().map(|v| v * v).sum::<f64>().sqrt();
        let needed = length * max_incidence.cos();
        let (mut mean, mut outside, mut by_face) = ([0.0; 3], false, false);
        for a in 0..3 {
            for side in [-1, 1] {
                let mut beside = cell;
                beside[a] += side;
                if self.is_free(beside) {
                    mean[a] += f64::from(side);
                    let along = f64::from(side) * way[a];
                    // On the outer side of the face's plane, half a cell from the centre.
                    outside |= along > 0.5 * self.cell_size;
                    by_face |= along > 0.5 * self.cell_size && along >= needed;
                }
            }
        }
        let norm = mean.iter().map(|v: &f64| v * v).sum::<f64>().sqrt();
        let along_mean: f64 = (0..3).map(|a| mean[a] * way[a]).sum();
        by_face || (outside && norm > 0.0 && along_mean >= needed * norm)
    }
}

/// Axis-aligned box of the camera's frustum up to `range`, m.
fn camera_box(camera: &Camera, range: f64) -> ([f64; 3], [f64; 3]) {
    let eye = camera.translation;
    let (mut low, mut high) = (eye, eye);
    for (sx, sy) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        let ray = [sx * camera.tan_half_h, sy * camera.tan_half_v, 1.0];
        for a in 0..3 {
            let p = eye[a] + range * (0..3).map(|c| camera.rotation[a][c] * ray[c]).sum::<f64>();
            low[a] = low[a].min(p);
            high[a] = high[a].max(p);
        }
    }
    // Depth is at most the range, so the box of this pyramid holds the frustum; no point is farther than the range either.
    (
        [0, 1, 2].map(|a| low[a].max(eye[a] - range)),
        [0, 1, 2].map(|a| high[a].min(eye[a] + range)),
    )
}
