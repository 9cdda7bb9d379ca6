//! Where the footprint passes with some heading: a search over boxes of places and headings.
//!
//! The wave of the planner knows only the disc inside the footprint. Where it leads through a gap that the disc fits
//! and the footprint does not, the search would try every pose in front of it. This one works on boxes: a cell and a
//! range of headings, closed if no pose in it is free ([`Stamps`]). Boxes are neighbours where they touch, so that
//! every way of the footprint, whatever it drives like, leads through a chain of open ones, and no chain means no
//! way. A chain through boxes whose middle is not free is doubtful: there the cells are cut finer, and the search
//! asked again (subdivision in the manner of Brooks and Lozano-Perez 1985, with sets of headings as bit masks).

use crate::Map;
use crate::raster::{Cells, Lazy, Raster};
use crate::search::Task;
use crate::stamps::Stamps;
use crate::table::Table;
use crate::wave::Wave;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::TAU;

/// A set of headings: bit k stands for those nearest to k * 2 pi / 128.
type Mask = u128;
const BINS: usize = 128;
const ALL: Mask = Mask::MAX;
/// Headings of an uncut cell come in groups of this many bits.
const GROUP: usize = 4;
/// A cut cell has this many parts along each side.
const CUT: usize = 4;
/// Price of a doubtful box, as a factor on its length.
const DOUBT: f32 = 6.0;
/// Times the cells along a doubtful chain are cut.
const ROUNDS: usize = 8;
/// A chain dearer than the disc's way by more than this factor leads elsewhere.
const LONGER: f32 = 1.15;
/// Boxes that are looked at in all; then the question stays open.
const EFFORT: usize = 60_000;

/// What the search over boxes tells.
pub(crate) enum Verdict {
    /// No chain of open boxes: the footprint cannot pass. Where its way for the disc first leaves what it can reach.
    NoPassage([f64; 2]),
    /// Middles of a chain of boxes from start to goal, and whether it is much dearer than the disc's way.
    Chain(Vec<[f64; 2]>, bool),
    /// Nothing certain.
    Open,
}

struct Cell {
    middle: [f64; 2],
    /// Headings with a pose that may be free; the others are proved closed.
    may: Mask,
    /// Headings that are free in the middle.
    fits: Mask,
    factor: f32,
    cut: bool,
    /// Headings settled, and waiting at a price of at most `price`, in this round.
    done: Mask,
    waiting: Mask,
    price: f32,
}

/// Headings of a cell reached together.
struct Event {
    cell: u32,
    bits: Mask,
    g: f32,
    parent: u32,
}

struct Boxes<'a, 't, M> {
    task: &'a Task<'t, M>,
    /// Shrunk and exact footprints for whole cells and for parts.
    may: [Stamps; 2],
    fits: [Stamps; 2],
    cells: Vec<Cell>,
    /// From a cell's number on the raster, or its part's, to `cells`.
    known: Table,
    looked: usize,
    /// Price of the disc's way.
    least: f32,
}

/// Looks for a chain of open boxes from the start to the goal.
pub(crate) fn look<M: Map>(
    task: &Task<'_, M>,
    raster: &mut Raster,
    wave: &mut Wave,
    stop: &mut dyn FnMut() -> bool,
) -> Verdict {
    let side = raster.cell;
    let coarse = BINS / GROUP;
    let unit = TAU / BINS as f64;
    // A group of four bits around the even one k has its middle half a bit before k.
    let stamps = |bins: usize, half: f64, turn: f64| {
        let first = if bins == BINS { 0.0 } else { -0.5 * unit };
        Stamps::new(task.body, bins, first, half, turn)
    };
    let mut boxes = Boxes {
        task,
        may: [
            stamps(coarse, 0.5 * side, 0.5 * TAU / coarse as f64),
            stamps(BINS, 0.5 * side / CUT as f64, 0.5 * unit),
        ],
        fits: [stamps(coarse, 0.0, 0.0), stamps(BINS, 0.0, 0.0)],
        cells: Vec::new(),
        known: Table::new(),
        looked: 0,
        least: 0.0,
    };
    for _ in 0..ROUNDS {
        match boxes.chain(raster, wave, stop) {
            Found::Nothing if task.missing <= 0.0 => {
                return boxes
                    .gap(raster, wave)
                    .map_or(Verdict::Open, Verdict::NoPassage);
            }
            Found::Nothing | Found::TooMuch => return Verdict::Open,
            Found::Chain(list, price) => {
                if !boxes.cut_along(raster, &list) {
                    let middles = list.iter().map(|e| boxes.cells[e.0 as usize].middle);
                    let detour = price > LONGER * boxes.least + 0.5;
                    return Verdict::Chain(middles.collect(), detour);
                }
            }
        }
    }
    Verdict::Open
}

enum Found {
    Nothing,
    TooMuch,
    /// Cells from the start to the goal, the headings in which each is passed, and the price of the whole.
    Chain(Vec<(u32, Mask)>, f32),
}

impl<M: Map> Boxes<'_, '_, M> {
    /// A* from the start, with the wave of the disc as the estimate.
    fn chain(
        &mut self,
        raster: &mut Raster,
        wave: &mut Wave,
        stop: &mut dyn FnMut() -> bool,
    ) -> Found {
        let task = self.task;
        for c in &mut self.cells {
            (c.done, c.waiting, c.price) = (0, 0, f32::INFINITY);
        }
        let (start, goal) = (task.start, task.goal);
        let (Some(from), Some(to)) = (self.at(raster, [start[0], start[1]]), self.at(raster, goal))
        else {
            return Found::TooMuch;
        };
        let unit = TAU / BINS as f64;
        let bin = |yaw: f64| (yaw / unit).round().rem_euclid(BINS as f64) as usize % BINS;
        let wanted = (0..BINS)
            .filter(|&k| {
                let yaw = k as f64 * unit;
                crate::moves::wrap(task.yaw.nearest(yaw) - yaw).abs() <= 0.5 * unit + 1e-9
            })
            .fold(0, |m: Mask, k| m | 1 << k);
        let mut events: Vec<Event> = Vec::new();
        let mut open = BinaryHeap::new();
        // The start's own box, free or not: the robot stands there.
        let first = spread(1 << bin(start[2]), self.cells[from as usize].may) | 1 << bin(start[2]);
        events.push(Event {
            cell: from,
            bits: first,
            g: 0.0,
            parent: 0,
        });
        open.push(Reverse((0u32, Reverse(0u32))));
        let map = task.map;
        if let Some(at) = raster.index([start[0], start[1]]) {
            self.least = wave.settle(&mut Lazy { raster, map }, at);
        }
        while let Some(Reverse((_, Reverse(index)))) = open.pop() {
            let Event { cell, bits, g, .. } = events[index as usize];
            let here = &mut self.cells[cell as usize];
            let bits = bits & !here.done;
            if bits == 0 {
                continue;
            }
            here.done |= bits;
            if cell == to && bits & wanted != 0 {
                return Found::Chain(trace(&events, index), g);
            }
            self.looked += 1;
            if self.looked > EFFORT || self.looked % 256 == 255 && stop() {
                return Found::TooMuch;
            }
            let (middle, factor) = (here.middle, here.factor);
            for to in self.neighbours(raster, cell) {
                let there = &self.cells[to as usize];
                let step = bits & there.may;
                if step & !there.done == 0 {
                    continue;
                }
                let step = spread(step, there.may) & !there.done;
                let length = (there.middle[0] - middle[0]).hypot(there.middle[1] - middle[1]);
                let doubt = if step & there.fits == 0 { DOUBT } else { 1.0 };
                let g = g + doubt * 0.5 * length as f32 * (factor + there.factor);
                if step & !there.waiting == 0 && g >= there.price - 1e-4 {
                    continue;
                }
                let middle = there.middle;
                let Some(at) = raster.index(middle) else {
                    continue;
                };
                let h = wave.settle(&mut Lazy { raster, map }, at);
                if !h.is_finite() {
                    continue;
                }
                let there = &mut self.cells[to as usize];
                there.waiting |= step;
                there.price = there.price.min(g);
                open.push(Reverse(((g + h).to_bits(), Reverse(events.len() as u32))));
                events.push(Event {
                    cell: to,
                    bits: step,
                    g,
                    parent: index,
                });
            }
        }
        Found::Nothing
    }

    /// Cuts the doubtful cells of a chain and those around them; false if there is nothing left to cut.
    fn cut_along(&mut self, raster: &mut Raster, chain: &[(u32, Mask)]) -> bool {
        let mut cut = false;
        for &(cell, bits) in chain {
            let c = &self.cells[cell as usize];
            if c.fits & bits != 0 {
                continue;
            }
            let Some(at) = raster.index(c.middle) else {
                continue;
            };
            for near in raster.around_cell(at) {
                let Some(k) = self.whole(raster, near) else {
                    continue;
                };
                let c = &mut self.cells[k as usize];
                if !c.cut && c.may != 0 && c.fits != ALL {
                    c.cut = true;
                    cut = true;
                }
            }
        }
        cut
    }

    /// The cell or part that holds a point.
    fn at(&mut self, raster: &mut Raster, p: [f64; 2]) -> Option<u32> {
        let at = raster.index(p)?;
        let whole = self.whole(raster, at)?;
        if !self.cells[whole as usize].cut {
            return Some(whole);
        }
        let (low, part) = (raster.corner(at), raster.cell / CUT as f64);
        let k = [0, 1].map(|a| (((p[a] - low[a]) / part) as usize).min(CUT - 1));
        Some(self.part(raster, at, whole, k))
    }

    /// A whole cell by its number on the raster.
    fn whole(&mut self, raster: &mut Raster, at: usize) -> Option<u32> {
        let key = (at * (CUT * CUT + 1)) as u64;
        if let Some(k) = self.known.get(key) {
            return Some(k);
        }
        let map = self.task.map;
        let factor = Lazy { raster, map }.factor(at);
        if !factor.is_finite() {
            return None;
        }
        let cell = self.masks(raster.center(at), 0.5 * raster.cell, factor, ALL, 0);
        Some(self.add(key, cell))
    }

    /// A part of a cut cell.
    fn part(&mut self, raster: &Raster, at: usize, whole: u32, k: [usize; 2]) -> u32 {
        let key = (at * (CUT * CUT + 1) + 1 + k[1] * CUT + k[0]) as u64;
        if let Some(k) = self.known.get(key) {
            return k;
        }
        let (low, side) = (raster.corner(at), raster.cell / CUT as f64);
        let middle = [0, 1].map(|a| low[a] + (k[a] as f64 + 0.5) * side);
        let Cell { may, factor, .. } = self.cells[whole as usize];
        let cell = self.masks(middle, 0.5 * side, factor, may, 1);
        self.add(key, cell)
    }

    fn add(&mut self, key: u64, cell: Cell) -> u32 {
        let k = self.cells.len() as u32;
        self.cells.push(cell);
        self.known.set(key, k);
        k
    }

    /// Tests the headings of `within`.
    fn masks(&self, middle: [f64; 2], half: f64, factor: f32, within: Mask, level: usize) -> Cell {
        let Task { map, body, .. } = *self.task;
        let group = if level == 0 { GROUP } else { 1 };
        let clearance = map.clearance(middle);
        let (mut may, mut fits) = (0, 0);
        if clearance >= body.circumscribed {
            (may, fits) = (within, within);
        } else if clearance + half * std::f64::consts::SQRT_2 >= body.inscribed {
            // A group's bits lie around its middle one.
            let own = ((1 << group) - 1 as Mask).rotate_right(group as u32 / 2);
            let symmetric = self.may[level].symmetric();
            for k in 0..BINS / group / if symmetric { 2 } else { 1 } {
                let mut bits = own.rotate_left((k * group) as u32);
                if symmetric {
                    bits |= bits.rotate_left(BINS as u32 / 2);
                }
                if bits & within == 0 {
                    continue;
                }
                // What is free in the middle needs no look at what the box has in common.
                if clearance >= body.inscribed && self.fits[level].free(map, middle, k) {
                    fits |= bits;
                    may |= bits;
                } else if self.may[level].free(map, middle, k) {
                    may |= bits;
                }
            }
            may &= within;
        }
        Cell {
            middle,
            may,
            fits: fits & may,
            factor,
            cut: false,
            done: 0,
            waiting: 0,
            price: f32::INFINITY,
        }
    }

    /// The cells and parts that touch one.
    fn neighbours(&mut self, raster: &mut Raster, cell: u32) -> Vec<u32> {
        let side = raster.cell;
        let part = side / CUT as f64;
        let middle = self.cells[cell as usize].middle;
        let mut out = Vec::with_capacity(8);
        let Some(own) = raster.index(middle) else {
            return out;
        };
        let cut = match self.whole(raster, own) {
            Some(whole) => self.cells[whole as usize].cut,
            None => false,
        };
        if cut {
            for (x, y) in AROUND {
                let p = [middle[0] + x * part, middle[1] + y * part];
                if let Some(k) = self.at(raster, p)
                    && !out.contains(&k)
                {
                    out.push(k);
                }
            }
            return out;
        }
        for (x, y) in AROUND {
            let Some(at) = raster.index([middle[0] + x * side, middle[1] + y * side]) else {
                continue;
            };
            let Some(whole) = self.whole(raster, at) else {
                continue;
            };
            if !self.cells[whole as usize].cut {
                out.push(whole);
                continue;
            }
            // The parts along the common border.
            let range = |v: f64| match v {
                v if v > 0.5 => 0..1,
                v if v < -0.5 => CUT - 1..CUT,
                _ => 0..CUT,
            };
            for i in range(x) {
                for j in range(y) {
                    out.push(self.part(raster, at, whole, [i, j]));
                }
            }
        }
        out
    }

    /// Where the disc's way from the start leaves the cells that the footprint reached.
    fn gap(&mut self, raster: &mut Raster, wave: &mut Wave) -> Option<[f64; 2]> {
        let task = self.task;
        let at = raster.index([task.start[0], task.start[1]])?;
        let map = task.map;
        wave.settle(&mut Lazy { raster, map }, at);
        let way = wave.descend(raster, at);
        let reached = |boxes: &mut Self, raster: &mut Raster, at: usize| {
            let Some(whole) = boxes.whole(raster, at) else {
                return false;
            };
            if !boxes.cells[whole as usize].cut {
                return boxes.cells[whole as usize].done != 0;
            }
            (0..CUT * CUT).any(|k| {
                let part = boxes.part(raster, at, whole, [k % CUT, k / CUT]);
                boxes.cells[part as usize].done != 0
            })
        };
        let mut last = [task.goal[0], task.goal[1]];
        for at in way.into_iter().rev() {
            if reached(self, raster, at) {
                return Some(last);
            }
            last = raster.center(at);
        }
        Some(last)
    }
}

const AROUND: [(f64, f64); 8] = [
    (1.0, 0.0),
    (-1.0, 0.0),
    (0.0, 1.0),
    (0.0, -1.0),
    (1.0, 1.0),
    (1.0, -1.0),
    (-1.0, 1.0),
    (-1.0, -1.0),
];

/// The headings of `open` that can be reached from some of `bits` by turning in place.
fn spread(bits: Mask, open: Mask) -> Mask {
    if open == ALL {
        return if bits == 0 { 0 } else { ALL };
    }
    let mut set = bits & open;
    loop {
        let next = (set | set.rotate_left(1) | set.rotate_right(1)) & open;
        if next == set {
            return set;
        }
        set = next;
    }
}

fn trace(events: &[Event], last: u32) -> Vec<(u32, Mask)> {
    let mut list = Vec::new();
    let mut at = last;
    loop {
        let e = &events[at as usize];
        list.push((e.cell, e.bits));
        if at == 0 {
            list.reverse();
            return list;
        }
        at = e.parent;
    }
}

#[cfg(test)]
mod tests;
