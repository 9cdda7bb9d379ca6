//! What changed since the last look: bricks of 8 x 8 x 8 cells, handed out as boxes.

use crate::geometry::{Cell, CellBox};
use crate::map::VoxelMap;

/// Edge of a brick, cells.
const BRICK: usize = 8;

/// Marks of changed bricks.
#[derive(Clone, Debug)]
pub(crate) struct Dirty {
    bricks: [usize; 3],
    state: Vec<bool>,
    inspected: Vec<bool>,
    any: bool,
}

impl Dirty {
    pub(crate) fn new(size: [usize; 3]) -> Self {
        let bricks = size.map(|n| n.div_ceil(BRICK));
        let total = bricks.iter().product();
        Self {
            bricks,
            state: vec![false; total],
            inspected: vec![false; total],
            any: false,
        }
    }

    fn brick(&self, cell: Cell) -> usize {
        let [x, y, z] = cell.map(|v| v as usize / BRICK);
        (z * self.bricks[1] + y) * self.bricks[0] + x
    }

    /// Notes a change of free or occupied.
    pub(crate) fn state(&mut self, cell: Cell) {
        let brick = self.brick(cell);
        self.state[brick] = true;
        self.any = true;
    }

    /// Notes a change of inspected.
    pub(crate) fn inspected(&mut self, cell: Cell) {
        let brick = self.brick(cell);
        self.inspected[brick] = true;
        self.any = true;
    }
}

/// Boxes of cells in which something changed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Boxes with any change: free, occupied or inspected. Disjoint, in index order.
    pub boxes: Vec<CellBox>,
    /// Boxes in which free or occupied changed. Disjoint, in index order.
    pub state_boxes: Vec<CellBox>,
}

impl Changes {
    /// True if nothing changed.
    pub fn is_empty(&self) -> bool {
        self.boxes.is_empty()
    }
}

impl VoxelMap {
    /// Everything that changed since the last call.
    pub fn take_changes(&mut self) -> Changes {
        if !self.dirty.any {
            return Changes::default();
        }
        let size = self.size;
        let dirty = &mut self.dirty;
        let any: Vec<bool> = dirty
            .state
            .iter()
            .zip(&dirty.inspected)
            .map(|(&s, &i)| s || i)
            .collect();
        let changes = Changes {
            boxes: boxes(&any, dirty.bricks, size),
            state_boxes: boxes(&dirty.state, dirty.bricks, size),
        };
        dirty.state.fill(false);
        dirty.inspected.fill(false);
        dirty.any = false;
        changes
    }
}

/// Covers the marked bricks by disjoint boxes: runs along x, merged along y and then along z where they are equal.
fn boxes(marks: &[bool], bricks: [usize; 3], size: [usize; 3]) -> Vec<CellBox> {
    // (x range, y range, z range) in bricks
    let mut done: Vec<[[usize; 2]; 3]> = Vec::new();
    let mut below: Vec<[[usize; 2]; 3]> = Vec::new();
    for z in 0..bricks[2] {
        let mut layer: Vec<[[usize; 2]; 3]> = Vec::new();
        for y in 0..bricks[1] {
            let row = &marks[(z * bricks[1] + y) * bricks[0]..][..bricks[0]];
            let mut x = 0;
            while x < bricks[0] {
                let start = x;
                while x < bricks[0] && row[x] {
                    x += 1;
                }
                if x > start {
                    let run = [start, x];
                    match layer.iter_mut().rev().find(|b| b[0] == run && b[1][1] == y) {
                        Some(grown) => grown[1][1] = y + 1,
                        None => layer.push([run, [y, y + 1], [z, z + 1]]),
                    }
                } else {
                    x += 1;
                }
            }
        }
        for block in &mut layer {
            if let Some(i) = below
                .iter()
                .position(|b| b[0] == block[0] && b[1] == block[1])
            {
                block[2][0] = below.swap_remove(i)[2][0];
            }
        }
        done.append(&mut below);
        below = layer;
    }
    done.append(&mut below);
    let mut out: Vec<CellBox> = done
        .into_iter()
        .map(|b| CellBox {
            low: [0, 1, 2].map(|a| (b[a][0] * BRICK) as i32),
            high: [0, 1, 2].map(|a| (b[a][1] * BRICK).min(size[a]) as i32),
        })
        .collect();
    out.sort_unstable();
    out
}
