//! The inspected layer: which faces of the surface the camera has seen well enough (HEATS sect. IV-A).
//!
//! A cell is inspected when every face that is open to free space is. The published rule inspects all faces at one sight;
//! with a limit on incidence each face must be seen from its own side, so that a table top seen from above is not inspected
//! from below.

use crate::geometry::{Camera, Cell};
use crate::map::{FACES, VoxelMap};

impl VoxelMap {
    /// Marks what the camera inspects: occupied cells open to free space whose centre is inside the image, nearer than `range`
    /// m, with no other occupied cell on the line from the camera to the centre (unknown does not block). One sight inspects
    /// all of a cell's faces. Returns how many cells gained a face.
    ///
    /// A cell that stops being occupied stops being inspected.
    pub fn mark_inspected(&mut self, camera: &Camera, range: f64) -> usize {
        self.mark(camera, None, range, None)
    }

    /// As [`mark_inspected`](Self::mark_inspected), but only the faces that
    /// [`faces_towards`](Self::faces_towards) the camera at no more than `max_incidence` rad are inspected, each if the free
    /// cell in front of it is in sight. (The line to the middle of a cell inside a flat surface runs through its neighbours
    /// once it is flatter than 45 degrees.)
    pub fn mark_inspected_within(
        &mut self,
        camera: &Camera,
        range: f64,
        max_incidence: f64,
    ) -> usize {
        self.mark(camera, None, range, Some(max_incidence))
    }

    /// As [`mark_inspected_within`](Self::mark_inspected_within), for detectors that ask for a whole flat target in two images in
    /// a row: the square around the middle of the face that holds any target of half a side `target` m whose own middle lies on
    /// the face must be inside this image and the one taken before.
    pub fn mark_inspected_twice(
        &mut self,
        before: &Camera,
        camera: &Camera,
        range: f64,
        max_incidence: f64,
        target: f64,
    ) -> usize {
        let half = target + 0.5 * self.cell_size;
        self.mark(camera, Some((before, half)), range, Some(max_incidence))
    }

    fn mark(
        &mut self,
        camera: &Camera,
        twice: Option<(&Camera, f64)>,
        range: f64,
        max_incidence: Option<f64>,
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
        let first = self.stored(self.clamped(self.cell_at(low)));
        let last = self.stored(self.clamped(self.cell_at(high)));
        let mut marks: Vec<(Cell, u8)> = Vec::new();
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for w in first[0] as usize / 64..=last[0] as usize / 64 {
                    let mut open = self.unseen_word(w, y as usize, z as usize, false);
                    while open != 0 {
                        let x = (w * 64) as i32 + open.trailing_zeros() as i32;
                        open &= open - 1;
                        let cell = [0, 1, 2].map(|a| [x, y, z][a] + self.first[a]);
                        let center = self.center(cell);
                        let square: f64 = (0..3).map(|a| (center[a] - eye[a]).powi(2)).sum();
                        if square >= range * range || !camera.sees(center) {
                            continue;
                        }
                        let mut faces = self.exposed_faces(cell) & !self.seen_faces(cell);
                        if let Some(limit) = max_incidence {
                            faces &= self.faces_towards(cell, eye, limit);
                        }
                        if let Some((before, half)) = twice {
                            faces = self.faces_held(center, faces, [before, camera], half);
                        }
                        match max_incidence {
                            None if !self.line_of_sight(eye, cell, u32::MAX) => faces = 0,
                            None => {}
                            Some(_) => faces = self.faces_in_sight(cell, faces, eye),
                        }
                        if faces != 0 {
                            marks.push((cell, faces));
                        }
                    }
                }
            }
        }
        for &(cell, faces) in &marks {
            let [x, y, z] = self.stored(cell).map(|v| v as usize);
            let seen = self.seen.make(x / 64, y, z);
            for (face, plane) in seen.iter_mut().enumerate() {
                *plane |= u64::from(faces >> face & 1) << (x % 64);
            }
            self.dirty.inspected(self.word(x / 64, y, z), 1 << (x % 64));
        }
        marks.len()
    }

    /// Those of the faces given of the cell around `center` whose squares lie inside both images.
    fn faces_held(&self, center: [f64; 3], faces: u8, images: [&Camera; 2], half: f64) -> u8 {
        FACES
            .iter()
            .enumerate()
            .filter(|(face, offset)| {
                let middle =
                    [0, 1, 2].map(|a| center[a] + 0.5 * self.cell_size * f64::from(offset[a]));
                faces >> face & 1 != 0
                    && images
                        .iter()
                        .all(|image| image.sees_square(middle, face / 2, half))
            })
            .fold(0, |held, (face, _)| held | 1 << face)
    }

    /// Those of the exposed faces given whose cell in front is in sight.
    fn faces_in_sight(&self, cell: Cell, faces: u8, eye: [f64; 3]) -> u8 {
        FACES
            .iter()
            .enumerate()
            .filter(|(face, offset)| {
                faces >> face & 1 != 0
                    && self.line_of_sight(eye, [0, 1, 2].map(|a| cell[a] + offset[a]), u32::MAX)
            })
            .fold(0, |seen, (face, _)| seen | 1 << face)
    }

    /// The exposed faces of an occupied cell that an eye looks at from outside, at no more than `max_incidence` rad to the
    /// surface's normal at the middle of the face; bits as [`exposed_faces`](Self::exposed_faces).
    ///
    /// The angle is that in the middle of an upright face, and for tops and undersides that in the middle of the cell: a level plate,
    /// such as a table's top, lies anywhere in its cells. The normal is the face's own. Where a cell has several exposed faces around an upright edge, their mean serves them as
    /// well, since a wall at an angle to the grid is a staircase of such cells. (A table's edge is not: it has a top and an
    /// underside, and each must be looked at from its own side.)
    pub fn faces_towards(&self, cell: Cell, eye: [f64; 3], max_incidence: f64) -> u8 {
        let center = self.center(cell);
        let exposed = self.exposed_faces(cell);
        let way = [0, 1, 2].map(|a| eye[a] - center[a]);
        let square = way.iter().map(|v| v * v).sum::<f64>();
        let cosine = max_incidence.cos();
        let half = 0.5 * self.cell_size;
        let mut mean = [0.0; 2];
        for (face, offset) in FACES.iter().enumerate().take(4) {
            if exposed >> face & 1 != 0 {
                for a in 0..2 {
                    mean[a] += f64::from(offset[a]);
                }
            }
        }
        let norm = mean[0].hypot(mean[1]);
        let by_mean =
            norm > 0.0 && mean[0] * way[0] + mean[1] * way[1] >= cosine * square.sqrt() * norm;
        let mut faces = 0;
        for (face, offset) in FACES.iter().enumerate() {
            let along: f64 = (0..3).map(|a| f64::from(offset[a]) * way[a]).sum();
            // The middle of a face is half a cell nearer than that of the cell.
            let depth = if face < 4 { half } else { 0.0 };
            let above = along - depth;
            let length = (square - depth * (along + above)).max(0.0).sqrt();
            let towards = above >= cosine * length || (face < 4 && by_mean);
            if exposed >> face & 1 != 0 && along > half && towards {
                faces |= 1 << face;
            }
        }
        faces
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
