//! Walls, rooms and doors.

use super::{Blueprint, Dice, Layout, Rect, WALL};

/// Shortest side of a room, m.
const LEAST_SIDE: f64 = 2.8;
/// A room smaller than this is not cut, m2: drawn anew for each.
const ROOM_AREA: (f64, f64) = (14.0, 40.0);
/// Least wall beside a door, m.
const BESIDE_DOOR: f64 = 0.3;
/// Ground before and behind a door that stays free, m.
const BEFORE_DOOR: f64 = 1.2;
/// Distance between the walls of a maze, m.
const PITCH: f64 = 3.0;
/// Share of a maze's inner walls that are taken out again.
const OPENED: f64 = 0.12;
/// Width of the aisles between shelves and of those across, m.
const AISLE: (f64, f64) = (2.4, 2.6);
/// Longest row of shelves, m.
const ROW: f64 = 9.0;

/// An opening in a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Door {
    /// The opening itself.
    pub gap: Rect,
    /// Axis that the wall is normal to.
    axis: usize,
}

impl Door {
    /// The ground that stays free.
    pub(super) fn kept_clear(&self) -> Rect {
        let mut clear = self.gap;
        clear.min[self.axis] -= BEFORE_DOOR;
        clear.max[self.axis] += BEFORE_DOOR;
        clear
    }
}

/// A floor plan.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plan {
    pub walls: Vec<Rect>,
    /// Free rectangles between walls.
    pub rooms: Vec<Rect>,
    pub doors: Vec<Door>,
    /// Where rows of shelves stand.
    pub rows: Vec<Rect>,
    /// The room that was walled up.
    pub closed: Option<usize>,
}

impl Plan {
    /// Draws the walls.
    pub(super) fn draw(blueprint: &Blueprint, dice: &mut Dice) -> Self {
        let [length, width] = blueprint.size;
        let all = Rect::new([0.0; 2], [length, width]);
        let mut plan = Self {
            walls: vec![
                Rect::new([0.0, 0.0], [length, WALL]),
                Rect::new([0.0, width - WALL], [length, width]),
                Rect::new([0.0, WALL], [WALL, width - WALL]),
                Rect::new([length - WALL, WALL], [length, width - WALL]),
            ],
            rooms: Vec::new(),
            doors: Vec::new(),
            rows: Vec::new(),
            closed: None,
        };
        let inside = all.grown(-WALL);
        match blueprint.layout {
            Layout::Rooms => plan.divide(inside, blueprint.door, dice),
            Layout::Maze => plan.maze(blueprint.size, dice),
            Layout::Aisles => plan.aisles(inside),
        }
        plan
    }

    /// Cuts a rectangle into rooms, with a door in every cut. No cut ends in a door.
    fn divide(&mut self, area: Rect, door: f64, dice: &mut Dice) {
        let mut open = vec![area];
        while let Some(area) = open.pop() {
            let axis = usize::from(area.side(1) > area.side(0));
            let most = dice.between(ROOM_AREA.0, ROOM_AREA.1);
            let cut = (area.area() > most)
                .then(|| self.cut(&area, axis, dice))
                .flatten();
            let Some(at) = cut else {
                self.rooms.push(area);
                continue;
            };
            let across = 1 - axis;
            let (low, high) = (area.min[across], area.max[across]);
            let from = dice.between(low + BESIDE_DOOR, high - BESIDE_DOOR - door);
            let part = |from: f64, to: f64| {
                let mut wall = area;
                wall.min[axis] = at - 0.5 * WALL;
                wall.max[axis] = at + 0.5 * WALL;
                wall.min[across] = from;
                wall.max[across] = to;
                wall
            };
            self.walls.push(part(low, from));
            self.walls.push(part(from + door, high));
            self.doors.push(Door {
                gap: part(from, from + door),
                axis,
            });
            let (mut left, mut right) = (area, area);
            left.max[axis] = at - 0.5 * WALL;
            right.min[axis] = at + 0.5 * WALL;
            open.push(right);
            open.push(left);
        }
    }

    /// Where a rectangle can be cut across an axis, if anywhere.
    fn cut(&self, area: &Rect, axis: usize, dice: &mut Dice) -> Option<f64> {
        let room = LEAST_SIDE + 0.5 * WALL;
        let (low, high) = (area.min[axis] + room, area.max[axis] - room);
        if low > high {
            return None;
        }
        (0..20).map(|_| dice.between(low, high)).find(|at| {
            let mut wall = area.grown(2.0 * WALL);
            wall.min[axis] = at - 0.5 * WALL - BESIDE_DOOR;
            wall.max[axis] = at + 0.5 * WALL + BESIDE_DOOR;
            !self.doors.iter().any(|d| d.gap.meets(&wall))
        })
    }

    /// A spanning tree of a grid, and some more ways.
    fn maze(&mut self, size: [f64; 2], dice: &mut Dice) {
        let count = size.map(|s| ((s - WALL) / PITCH).floor().max(1.0) as usize);
        let pitch = [0, 1].map(|k| (size[k] - WALL) / count[k] as f64);
        // Whether the wall on the far side of a cell along each axis is open.
        let cells = count[0] * count[1];
        let mut open = vec![[false; 2]; cells];
        let mut seen = vec![false; cells];
        let mut path = vec![0_usize];
        seen[0] = true;
        while let Some(&at) = path.last() {
            let (x, y) = (at % count[0], at / count[0]);
            let mut next = Vec::with_capacity(4);
            if x + 1 < count[0] {
                next.push((at + 1, at, 0));
            }
            if x > 0 {
                next.push((at - 1, at - 1, 0));
            }
            if y + 1 < count[1] {
                next.push((at + count[0], at, 1));
            }
            if y > 0 {
                next.push((at - count[0], at - count[0], 1));
            }
            next.retain(|n| !seen[n.0]);
            if next.is_empty() {
                path.pop();
                continue;
            }
            let (to, wall, axis) = next[dice.pick(next.len())];
            seen[to] = true;
            open[wall][axis] = true;
            path.push(to);
        }
        for (at, open) in open.iter_mut().enumerate() {
            let last = [at % count[0] + 1 == count[0], at / count[0] + 1 == count[1]];
            for axis in 0..2 {
                let opened = dice.share() < OPENED;
                if last[axis] || open[axis] || opened {
                    open[axis] |= !last[axis];
                    continue;
                }
                // A closed wall, with its posts.
                let cell = [at % count[0], at / count[0]];
                let across = 1 - axis;
                let mut wall = Rect::new([0.0; 2], [0.0; 2]);
                wall.min[axis] = (cell[axis] + 1) as f64 * pitch[axis];
                wall.max[axis] = wall.min[axis] + WALL;
                wall.min[across] = cell[across] as f64 * pitch[across];
                wall.max[across] = wall.min[across] + pitch[across] + WALL;
                self.walls.push(wall);
            }
        }
        for at in 0..cells {
            let cell = [at % count[0], at / count[0]];
            let min = [0, 1].map(|k| cell[k] as f64 * pitch[k] + WALL);
            let max = [0, 1].map(|k| min[k] + pitch[k] - WALL);
            self.rooms.push(Rect::new(min, max));
        }
        // The openings of cells stay free of furniture as doors do.
        for (at, open) in open.iter().enumerate() {
            let room = self.rooms[at];
            for axis in 0..2 {
                if open[axis] {
                    let mut gap = room;
                    gap.min[axis] = room.max[axis];
                    gap.max[axis] = room.max[axis] + WALL;
                    self.doors.push(Door { gap, axis });
                }
            }
        }
    }

    /// Rows of shelves along the longer side.
    fn aisles(&mut self, inside: Rect) {
        let along = usize::from(inside.side(1) > inside.side(0));
        let across = 1 - along;
        let depth = 2.0 * super::furniture::SHELF_DEPTH;
        let rows = ((inside.side(across) - AISLE.0) / (depth + AISLE.0)).floor();
        let spare = inside.side(across) - rows * depth;
        let aisle = spare / (rows + 1.0);
        let length = inside.side(along) - AISLE.1;
        let parts = (length / (ROW + AISLE.1)).ceil().max(1.0);
        let part = length / parts - AISLE.1;
        for row in 0..rows as usize {
            for k in 0..parts as usize {
                let mut place = inside;
                place.min[across] += aisle + row as f64 * (depth + aisle);
                place.max[across] = place.min[across] + depth;
                place.min[along] += AISLE.1 + k as f64 * (part + AISLE.1);
                place.max[along] = place.min[along] + part;
                self.rows.push(place);
            }
        }
        self.rooms.push(inside);
    }

    /// Walls up a room that is not the first and through which no way leads to another. False if there is none.
    pub(super) fn close_one(&mut self, dice: &mut Dice) -> bool {
        // The two rooms of each door.
        let sides: Vec<Vec<usize>> = self
            .doors
            .iter()
            .map(|door| {
                let mut through = door.gap;
                through.min[door.axis] -= WALL;
                through.max[door.axis] += WALL;
                (0..self.rooms.len())
                    .filter(|&i| self.rooms[i].meets(&through))
                    .collect()
            })
            .collect();
        let first = self.first();
        let mut rooms: Vec<usize> = (0..self.rooms.len()).filter(|&i| i != first).collect();
        dice.shuffle(&mut rooms);
        let spared = |closed: usize| {
            let mut seen = vec![false; self.rooms.len()];
            let mut open = vec![first];
            seen[first] = true;
            let mut count = 1;
            while let Some(at) = open.pop() {
                let beside = sides.iter().filter(|s| s.contains(&at)).flatten();
                for &next in beside {
                    if next != closed && !seen[next] {
                        seen[next] = true;
                        count += 1;
                        open.push(next);
                    }
                }
            }
            count + 1 == self.rooms.len()
        };
        let Some(closed) = rooms.into_iter().find(|&room| spared(room)) else {
            return false;
        };
        let (shut, left): (Vec<_>, Vec<_>) = std::mem::take(&mut self.doors)
            .into_iter()
            .zip(&sides)
            .partition(|(_, sides)| sides.contains(&closed));
        self.walls
            .extend(shut.into_iter().map(|(door, _)| door.gap));
        self.doors = left.into_iter().map(|(door, _)| door).collect();
        self.closed = Some(closed);
        true
    }

    /// The room of the start: the one nearest to the origin.
    fn first(&self) -> usize {
        (0..self.rooms.len())
            .min_by(|&a, &b| {
                let off = |i: usize| self.rooms[i].center().iter().sum::<f64>();
                off(a).total_cmp(&off(b))
            })
            .unwrap_or(0)
    }

    /// Where the robot starts, m.
    pub(super) fn start(&self) -> [f64; 2] {
        let round = |v: f64| (v * 1000.0).round() / 1000.0;
        if !self.rows.is_empty() {
            let hall = self.rooms[0];
            return hall.min.map(|v| round(v + 1.2));
        }
        self.rooms[self.first()].center().map(round)
    }
}
