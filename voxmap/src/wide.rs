//! Which faces of the surface are wide enough to carry a flat target: not those of rods, edges and single cells that stick out.
//!
//! A face that looks up or down counts inside a square of two by two such faces; an upright one if the same face is open above
//! or below it and beside it. The surface may step by one cell there, as a wall at an angle to the grid does.

use crate::geometry::Cell;
use crate::map::{FACES, VoxelMap};

/// Bits of a row of cells around one word: the last of the word before, the word, the first of the word after.
#[derive(Clone, Copy, Default)]
struct Row {
    before: u64,
    word: u64,
    after: u64,
}

impl Row {
    /// For each cell, the bit of the next lower x.
    fn lower(self) -> u64 {
        self.word << 1 | self.before >> 63
    }
    /// For each cell, the bit of the next higher x.
    fn higher(self) -> u64 {
        self.word >> 1 | self.after << 63
    }
    fn any(self, other: Self) -> Self {
        Self {
            before: self.before | other.before,
            word: self.word | other.word,
            after: self.after | other.after,
        }
    }
    fn all(self, other: Self) -> Self {
        Self {
            before: self.before & other.before,
            word: self.word & other.word,
            after: self.after & other.after,
        }
    }
    /// Cells of which this and a neighbour in x are set, given that both are in `self`.
    fn paired(self) -> u64 {
        self.word & (self.lower() | self.higher())
    }
}

impl VoxelMap {
    /// Cells of a row around word `w` whose face is exposed, and not inspected where strips are left out; none outside the map.
    fn exposed_row(&self, w: usize, y: Option<usize>, z: Option<usize>, face: usize) -> Row {
        let (Some(y), Some(z)) = (y, z) else {
            return Row::default();
        };
        if y >= self.size[1] || z >= self.size[2] {
            return Row::default();
        }
        let at = |w: usize| {
            let exposed = self.occupied[self.word(w, y, z)] & self.free_beside(w, y, z, face);
            if self.skip_strips && exposed != 0 {
                exposed & !self.seen.get(w, y, z).map_or(0, |seen| seen[face])
            } else {
                exposed
            }
        };
        Row {
            before: if w > 0 { at(w - 1) } else { 0 },
            word: at(w),
            after: if w + 1 < self.words { at(w + 1) } else { 0 },
        }
    }

    /// Cells of word `w` of row (y, z) whose face is exposed and wide.
    pub(crate) fn wide_word(&self, w: usize, y: usize, z: usize, face: usize) -> u64 {
        let row = |dy: i32, dz: i32| {
            self.exposed_row(
                w,
                y.checked_add_signed(dy as isize),
                z.checked_add_signed(dz as isize),
                face,
            )
        };
        let here = row(0, 0);
        if here.word == 0 {
            return 0;
        }
        match face / 2 {
            // Up and down: a square in the plane.
            2 => here.all(row(-1, 0)).paired() | here.all(row(1, 0)).paired(),
            // Upright, normal along x: beside it in y, where the surface may step along x; above or below the same.
            0 => {
                let near = |r: Row| r.word | r.lower() | r.higher();
                let beside = near(row(-1, 0).any(row(1, 0)));
                let above = near(row(0, -1).any(row(0, 1)));
                here.word & beside & above
            }
            // Normal along y: beside it in x.
            _ => {
                let around = row(-1, 0).any(here).any(row(1, 0));
                let beside = around.lower() | around.higher();
                let above = [-1, 0, 1]
                    .iter()
                    .fold(0, |bits, &dy| bits | row(dy, -1).word | row(dy, 1).word);
                here.word & beside & above
            }
        }
    }

    /// Those of the exposed faces given that are wide.
    pub(crate) fn wide_faces(&self, cell: Cell, faces: u8) -> u8 {
        (0..6)
            .filter(|face| faces >> face & 1 != 0 && self.is_wide(cell, *face))
            .fold(0, |wide, face| wide | 1 << face)
    }

    fn is_wide(&self, cell: Cell, face: usize) -> bool {
        let exposed = |offset: [i32; 3]| {
            let c = [0, 1, 2].map(|a| cell[a] + offset[a]);
            self.is_occupied(c)
                && self.is_free([0, 1, 2].map(|a| c[a] + FACES[face][a]))
                && !(self.skip_strips && self.seen_faces(c) >> face & 1 != 0)
        };
        let axis = face / 2;
        if axis == 2 {
            return [-1, 1].iter().any(|&y| {
                exposed([0, y, 0])
                    && [-1, 1]
                        .iter()
                        .any(|&x| exposed([x, 0, 0]) && exposed([x, y, 0]))
            });
        }
        let along = 1 - axis;
        let step = |other: usize| {
            [-1, 1].iter().any(|&side| {
                (-1..=1).any(|normal| {
                    let mut offset = [0; 3];
                    offset[other] = side;
                    offset[axis] = normal;
                    exposed(offset)
                })
            })
        };
        step(along) && step(2)
    }
}
