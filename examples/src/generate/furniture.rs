//! Furniture: what stands in rooms, and the surfaces on it that may carry a target.

use super::layout::Plan;
use super::{Dice, Rect, upright};
use crate::scene::Shape;

/// Room kept around what stands free, and between pieces, m.
const GAP: f64 = 0.9;
/// Room kept free around the start, m.
const START: f64 = 0.8;
/// Pieces a square metre.
const DENSITY: f64 = 0.14;
/// Places that are tried for a piece.
const TRIES: usize = 30;
/// Gap between a wall and what stands against it, m.
const BEHIND: f64 = 0.02;
/// Thickness of boards, m.
const BOARD: f64 = 0.025;
/// Depth of a shelf, m.
pub(super) const SHELF_DEPTH: f64 = 0.4;
/// Width of a shelf of a row, m.
const SHELF_WIDTH: f64 = 1.2;

/// A surface that may carry a target.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spot {
    pub category: &'static str,
    pub center: [f64; 3],
    pub normal: [f64; 3],
    pub up: [f64; 3],
    /// Largest edge of a target, m.
    pub size: f64,
}

/// A piece of furniture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Piece {
    pub name: String,
    /// The ground it takes.
    pub ground: Rect,
    pub shapes: Vec<Shape>,
    pub spots: Vec<Spot>,
}

/// Kinds of furniture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Cabinet,
    Shelf,
    Desk,
    Bin,
    Boxes,
    Table,
}

impl Kind {
    const ALL: [Self; 6] = [
        Self::Cabinet,
        Self::Table,
        Self::Bin,
        Self::Shelf,
        Self::Desk,
        Self::Boxes,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Cabinet => "cabinet",
            Self::Shelf => "shelf",
            Self::Desk => "desk",
            Self::Bin => "bin",
            Self::Boxes => "boxes",
            Self::Table => "table",
        }
    }

    /// Width and depth, m.
    fn size(self) -> [f64; 2] {
        match self {
            Self::Cabinet => [0.9, 0.45],
            Self::Shelf => [1.0, SHELF_DEPTH],
            Self::Desk => [1.4, 0.7],
            Self::Bin => [0.36, 0.36],
            Self::Boxes => [0.6, 0.5],
            Self::Table => [1.5, 0.9],
        }
    }

    /// Whether it stands away from walls.
    fn stands_free(self) -> bool {
        matches!(self, Self::Table | Self::Boxes)
    }
}

/// A piece in its own frame, x along its width, its back towards +y, turned by quarters.
struct Maker {
    name: String,
    center: [f64; 2],
    /// Quarter turns, counter-clockwise.
    turns: usize,
    shapes: Vec<Shape>,
    spots: Vec<Spot>,
}

impl Maker {
    fn turn(&self, v: [f64; 2]) -> [f64; 2] {
        (0..self.turns % 4).fold(v, |[x, y], _| [-y, x])
    }

    fn board(&mut self, part: &str, low: [f64; 3], high: [f64; 3]) {
        let a = self.turn([low[0], low[1]]);
        let b = self.turn([high[0], high[1]]);
        let ground = Rect::new(
            [0, 1].map(|k| self.center[k] + a[k].min(b[k])),
            [0, 1].map(|k| self.center[k] + a[k].max(b[k])),
        );
        let name = format!("{}.{part}", self.name);
        self.shapes.push(upright(name, &ground, (low[2], high[2])));
    }

    /// A surface at a point, its outward normal and the direction of a target's top.
    fn spot(&mut self, category: &'static str, at: [f64; 3], normal: [f64; 3], size: f64) {
        let place = self.turn([at[0], at[1]]);
        let n = self.turn([normal[0], normal[1]]);
        let round = |v: f64| (v * 1e4).round() / 1e4;
        let level = normal[2].abs() > 0.5;
        self.spots.push(Spot {
            category,
            center: [
                round(self.center[0] + place[0]),
                round(self.center[1] + place[1]),
                round(at[2]),
            ],
            // No negative zeros.
            normal: [n[0] + 0.0, n[1] + 0.0, normal[2]],
            up: if level {
                [0.0, 1.0, 0.0]
            } else {
                [0.0, 0.0, 1.0]
            },
            size,
        });
    }

    fn make(&mut self, kind: Kind) {
        let [w, d] = kind.size().map(|v| 0.5 * v);
        match kind {
            Kind::Cabinet => {
                let top = 1.15;
                self.board("body", [-w, -d, 0.0], [w, d, top]);
                self.spot("cabinet_top", [0.0, 0.0, top], [0.0, 0.0, 1.0], 0.2);
                self.spot("cabinet_side", [0.0, -d, 0.7], [0.0, -1.0, 0.0], 0.2);
                self.spot("cabinet_side", [w, 0.0, 0.7], [1.0, 0.0, 0.0], 0.2);
            }
            Kind::Shelf => self.shelf(w, d, 1.8),
            Kind::Desk => {
                let top = 0.74;
                self.board("top", [-w, -d, top - BOARD], [w, d, top]);
                self.board("side_l", [-w, -d, 0.0], [-w + BOARD, d, top - BOARD]);
                self.board("side_r", [w - BOARD, -d, 0.0], [w, d, top - BOARD]);
                self.board(
                    "panel",
                    [-w + BOARD, d - BOARD, 0.2],
                    [w - BOARD, d, top - BOARD],
                );
                self.spot(
                    "under_table",
                    [0.0, -0.1, top - BOARD],
                    [0.0, 0.0, -1.0],
                    0.2,
                );
                self.spot("table_top", [0.2, 0.0, top], [0.0, 0.0, 1.0], 0.2);
            }
            Kind::Bin => {
                let top = 0.4;
                self.board("bottom", [-w, -d, 0.0], [w, d, 0.02]);
                self.board("front", [-w, -d, 0.02], [w, -d + BOARD, top]);
                self.board("back", [-w, d - BOARD, 0.02], [w, d, top]);
                self.board("left", [-w, -d + BOARD, 0.02], [-w + BOARD, d - BOARD, top]);
                self.board("right", [w - BOARD, -d + BOARD, 0.02], [w, d - BOARD, top]);
                self.spot("bin", [0.0, 0.0, 0.02], [0.0, 0.0, 1.0], 0.16);
                self.spot("bin_side", [0.0, -d, 0.21], [0.0, -1.0, 0.0], 0.16);
            }
            Kind::Boxes => {
                self.board("large", [-w, -d, 0.0], [w, d, 0.45]);
                self.board("small", [-0.6 * w, -0.6 * d, 0.45], [0.5 * w, 0.7 * d, 0.8]);
                self.spot("box_side", [-0.1, -d, 0.25], [0.0, -1.0, 0.0], 0.16);
                self.spot("box_side", [w, 0.0, 0.25], [1.0, 0.0, 0.0], 0.16);
            }
            Kind::Table => {
                let top = 0.74;
                self.board("top", [-w, -d, top - 0.03], [w, d, top]);
                for (i, [x, y]) in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                    .into_iter()
                    .enumerate()
                {
                    let at = [x * (w - 0.05), y * (d - 0.05)];
                    let part = format!("leg{i}");
                    self.board(
                        &part,
                        [at[0] - 0.025, at[1] - 0.025, 0.0],
                        [at[0] + 0.025, at[1] + 0.025, top - 0.03],
                    );
                }
                self.spot("under_table", [0.3, 0.0, top - 0.03], [0.0, 0.0, -1.0], 0.2);
                self.spot("table_top", [-0.3, 0.1, top], [0.0, 0.0, 1.0], 0.2);
            }
        }
    }

    /// Sides, back and four boards.
    fn shelf(&mut self, w: f64, d: f64, top: f64) {
        self.board("l", [-w, -d, 0.0], [-w + BOARD, d, top]);
        self.board("r", [w - BOARD, -d, 0.0], [w, d, top]);
        self.board("back", [-w + BOARD, d - BOARD, 0.0], [w - BOARD, d, top]);
        for i in 0..4 {
            let low = 0.1 + 0.45 * f64::from(i);
            let part = format!("s{}", i + 1);
            self.board(
                &part,
                [-w + BOARD, -d, low],
                [w - BOARD, d - BOARD, low + BOARD],
            );
        }
        self.spot("shelf", [0.0, d - BOARD, 0.8], [0.0, -1.0, 0.0], 0.2);
        self.spot("shelf", [0.0, d - BOARD, 1.25], [0.0, -1.0, 0.0], 0.2);
    }
}

/// Furnishes the rooms, but not the one that is closed.
pub(super) fn furnish(plan: &Plan, start: [f64; 2], dice: &mut Dice) -> Vec<Piece> {
    let mut clear: Vec<Rect> = plan
        .doors
        .iter()
        .map(super::layout::Door::kept_clear)
        .collect();
    clear.push(Rect::about(start, [START; 2]));
    let mut pieces = Vec::new();
    for row in &plan.rows {
        shelve(row, &mut pieces);
    }
    for (i, room) in plan.rooms.iter().enumerate() {
        // Only what lies in the room or beside it can be in the way.
        let near = room.grown(2.0);
        let clear: Vec<Rect> = clear.iter().copied().filter(|c| c.meets(&near)).collect();
        if plan.closed == Some(i) {
            continue;
        }
        let count = (DENSITY * room.area() * (0.6 + 0.8 * dice.share())).round() as usize;
        let mut taken: Vec<Rect> = plan
            .rows
            .iter()
            .copied()
            .filter(|r| r.meets(&near))
            .collect();
        for _ in 0..count {
            let kind = Kind::ALL[dice.pick(Kind::ALL.len())];
            let Some((ground, turns)) = place(kind, room, (&clear, &taken), dice) else {
                continue;
            };
            taken.push(ground);
            let mut maker = Maker {
                name: format!("{}_{:03}", kind.name(), pieces.len()),
                center: ground.center(),
                turns,
                shapes: Vec::new(),
                spots: Vec::new(),
            };
            maker.make(kind);
            pieces.push(Piece {
                name: maker.name,
                ground,
                shapes: maker.shapes,
                spots: maker.spots,
            });
        }
    }
    pieces
}

/// A place for a piece in a room: its ground and its quarter turns.
fn place(
    kind: Kind,
    room: &Rect,
    (clear, taken): (&[Rect], &[Rect]),
    dice: &mut Dice,
) -> Option<(Rect, usize)> {
    let size = kind.size();
    for _ in 0..TRIES {
        let turns = dice.pick(4);
        let half = if turns.is_multiple_of(2) {
            [0.5 * size[0], 0.5 * size[1]]
        } else {
            [0.5 * size[1], 0.5 * size[0]]
        };
        let margin = if kind.stands_free() { GAP } else { BEHIND };
        let inner = [0, 1].map(|k| {
            (
                room.min[k] + half[k] + margin,
                room.max[k] - half[k] - margin,
            )
        });
        if inner.iter().any(|r| r.0 > r.1) {
            continue;
        }
        let mut center = inner.map(|r| dice.between(r.0, r.1));
        if !kind.stands_free() {
            // Its back, which points to +y before the turns, is at a wall.
            match turns {
                0 => center[1] = inner[1].1,
                1 => center[0] = inner[0].0,
                2 => center[1] = inner[1].0,
                _ => center[0] = inner[0].1,
            }
        }
        let ground = Rect::about(center, half);
        let free = !clear.iter().any(|c| c.meets(&ground))
            && !taken.iter().any(|t| t.meets(&ground.grown(GAP)));
        // Across a narrow room the base must still get past.
        let passes = kind.stands_free() || {
            let axis = usize::from(turns.is_multiple_of(2));
            room.side(axis) - 2.0 * half[axis] > GAP
        };
        if free && passes {
            return Some((ground, turns));
        }
    }
    None
}

/// Fills a row with shelves back to back.
fn shelve(row: &Rect, pieces: &mut Vec<Piece>) {
    let along = usize::from(row.side(1) > row.side(0));
    let count = (row.side(along) / SHELF_WIDTH).floor().max(1.0);
    let width = row.side(along) / count;
    for k in 0..count as usize {
        for side in 0..2 {
            let mut ground = *row;
            ground.min[along] += k as f64 * width;
            ground.max[along] = ground.min[along] + width;
            let across = 1 - along;
            let middle = 0.5 * (row.min[across] + row.max[across]);
            // Backs meet in the middle.
            let turns = match (along, side) {
                (0, 0) => 0,
                (0, _) => 2,
                (_, 0) => 3,
                _ => 1,
            };
            if side == 0 {
                ground.max[across] = middle;
            } else {
                ground.min[across] = middle;
            }
            let mut maker = Maker {
                name: format!("shelf_{:03}", pieces.len()),
                center: ground.center(),
                turns,
                shapes: Vec::new(),
                spots: Vec::new(),
            };
            maker.shelf(0.5 * width, 0.5 * SHELF_DEPTH, 1.8);
            pieces.push(Piece {
                name: maker.name,
                ground,
                shapes: maker.shapes,
                spots: maker.spots,
            });
        }
    }
}
