//! A* over (cell, heading, motion) with the exact pose kept in every node.

use crate::body::{Body, SWING};
use crate::headings::{self, Verdict};
use crate::moves::{Motion, Move};
use crate::outlook::Outlook;
use crate::price::Price;
use crate::raster::{Lazy, Raster};
use crate::shot::shot;
use crate::steer::Way;
use crate::table::Table;
use crate::wave::Wave;
use crate::{GoalYaw, Map, Params};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::TAU;

/// Everything a search reads.
pub(crate) struct Task<'a, M> {
    pub(crate) map: &'a M,
    pub(crate) body: &'a Body,
    pub(crate) price: &'a Price,
    pub(crate) params: &'a Params,
    pub(crate) start: [f64; 3],
    /// How much room is missing at the start, m.
    pub(crate) missing: f64,
    pub(crate) goal: [f64; 2],
    pub(crate) yaw: &'a GoalYaw,
}

/// What a search found.
pub(crate) struct Found {
    pub(crate) moves: Option<Way>,
    pub(crate) expansions: usize,
    /// The open list ran empty: no way at the lattice's resolution.
    pub(crate) exhausted: bool,
    /// Stopped by the caller.
    pub(crate) stopped: bool,
    /// Whether the footprint can pass, if it was asked.
    pub(crate) verdict: Option<Verdict>,
    /// Reached pose nearest to the goal, by the wave.
    pub(crate) nearest: [f64; 3],
}

impl Found {
    fn nothing(nearest: [f64; 3]) -> Self {
        Self {
            moves: None,
            expansions: 0,
            exhausted: false,
            stopped: false,
            verdict: None,
            nearest,
        }
    }
}

struct Node {
    pose: [f64; 3],
    g: f32,
    /// Estimate of what is left, s.
    h: f32,
    missing: f32,
    parent: u32,
    /// Heading of the lattice; for a way to the goal, its number.
    bin: u32,
    /// Index of the primitive that led here; `ROOT` for the start, `GOAL` for a way to the goal.
    by: u8,
}

const ROOT: u8 = 255;
const GOAL: u8 = 254;

struct Entry {
    f: f32,
    node: u32,
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Entry {}
impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Entry {
    /// Least f first, then the younger node, which is further on its way.
    fn cmp(&self, other: &Self) -> Ordering {
        other.f.total_cmp(&self.f).then(self.node.cmp(&other.node))
    }
}

/// The lattice's moves: forward and backward, straight and along two curvatures to each side, and single turns; of
/// them those that the base can do.
fn primitives(params: &Params, split: usize) -> Vec<Move> {
    let unit = TAU / (split * params.headings) as f64;
    let cell = params.cell_size / split as f64;
    let mut list = Vec::new();
    match params.drive.radius() {
        None => {
            let step = 2.0 * cell;
            for motion in [Motion::Forward, Motion::Reverse] {
                for bins in [0.0, 1.0, -1.0, 2.0, -2.0] {
                    list.push(Move::drive(motion, step, bins * unit / step));
                }
            }
            list.push(Move::turn(unit));
            list.push(Move::turn(-unit));
        }
        Some(radius) => {
            // The tightest curve must lead to another heading of the lattice.
            let step = (2.0 * cell).max(1.05 * unit * radius);
            for motion in [Motion::Forward, Motion::Reverse] {
                for bend in [0.0, 1.0, -1.0, 0.5, -0.5] {
                    list.push(Move::drive(motion, step, bend / radius));
                }
            }
        }
    }
    list.retain(|m| params.drive.allows(m));
    list
}

/// Long, gentle curves for the way out of a violation.
///
/// The tail of a body along a wall swings towards it by `curvature * tail^2 / 2` when the body curves away.
fn gentle(params: &Params, body: &Body) -> Vec<Move> {
    let unit = TAU / params.headings as f64;
    let step = 6.0 * params.cell_size;
    let tail = body.circumscribed;
    let tightest = params.drive.radius().map_or(f64::INFINITY, |r| 1.0 / r);
    let curvature = (unit / step).min(1.5 * SWING / (tail * tail)).min(tightest);
    let mut list = Vec::new();
    for motion in [Motion::Forward, Motion::Reverse] {
        for side in [1.0, -1.0] {
            list.push(Move::drive(motion, step, side * curvature));
        }
    }
    list.retain(|m| params.drive.allows(m));
    list
}

/// Expansions after which the search becomes greedier; then again after twice as many, and so on. Most searches end
/// before; of the rest it bounds the tail.
const PATIENCE: usize = 1500;
/// How much greedier each time.
const GREEDIER: f64 = 1.5;
/// After a way to the goal is known, the search goes on for this many expansions and a quarter of those so far: a
/// short way is worth a look at its alternatives.
const REFINE: usize = 48;

/// Expansions on the given lattice, and then on one twice as fine, before something else is tried: a passage hardly
/// wider than the footprint asks for the right place to a centimetre.
const SHARES: [usize; 2] = [1200, 2400];
/// Length of a way for which they are meant, m; a longer one passes more corners, each of which takes its part.
const USUAL: f64 = 10.0;
/// How many times as many they become at most.
const LONGEST: f64 = 8.0;
/// Expansions before it is asked whether the footprint can pass at all.
const LOOK: usize = 400;
/// Half the width of the strip to which the wave is then led, m.
const BESIDE: f64 = 0.6;
/// Ways round that are tried when the wave leads where the footprint does not fit.
const DETOURS: usize = 5;
/// Length of the wave's way ahead of the nearest pose that becomes dear, m, and the width to each side.
const DEAR: (f64, f64) = (1.0, 0.3);
/// How dear.
const DEARER: f32 = 6.0;

/// Searches the given lattice; on the way it looks whether the footprint can pass at all and along which cells. If it
/// can, and the first search did not end well, searches the lattice and a finer one along those, again and again where
/// the wave is kept away from the places at which they got no further; at last the finer one with all that is left.
pub(crate) fn search<M: Map>(
    task: &Task<'_, M>,
    raster: &mut Raster,
    wave: &mut Wave,
    budget: usize,
    stop: &mut dyn FnMut() -> bool,
) -> Found {
    let map = task.map;
    let mut lazy = Lazy { raster, map };
    if let Some(at) = lazy.raster.index([task.start[0], task.start[1]])
        && wave.closed_off(&mut lazy, at)
    {
        return Found {
            exhausted: true,
            ..Found::nothing(task.start)
        };
    }
    let length = match lazy.raster.index([task.start[0], task.start[1]]) {
        Some(at) => f64::from(wave.settle(&mut lazy, at)),
        None => 0.0,
    };
    // From a start that the wave does not reach it says nothing.
    let longer = if length.is_finite() {
        (length / USUAL).clamp(1.0, LONGEST)
    } else {
        1.0
    };
    let shares = SHARES.map(|share| (longer * share as f64) as usize);
    let share = shares[0].min(budget);
    let mut found = attempt(task, raster, wave, 1, share, Some(LOOK), stop);
    let mut spent = found.expansions;
    let hopeless = found.exhausted && spent == 0;
    let refuted = matches!(found.verdict, Some(Verdict::NoPassage(_)));
    if found.moves.is_some() || found.stopped || hopeless || refuted || spent >= budget {
        return found;
    }
    let reach = 2.0 * task.params.cell_size;
    let verdict = match found.verdict.take() {
        Some(verdict) => verdict,
        None => headings::look(task, raster, wave, stop),
    };
    let mut dear = match verdict {
        Verdict::NoPassage(_) => {
            found.verdict = Some(verdict);
            return found;
        }
        Verdict::Chain(way, _) => {
            let mut r = raster.clone();
            r.keep_to(map, &way, BESIDE, DEARER);
            let mut lazy = Lazy {
                raster: &mut r,
                map,
            };
            let w = Wave::new(&mut lazy, task.goal, reach, false);
            (r, w)
        }
        Verdict::Open => (raster.clone(), wave.clone()),
    };
    for _ in 0..=DETOURS {
        let (r, w) = &mut dear;
        for (split, share) in [(1, shares[0]), (2, shares[1])] {
            found = attempt(task, r, w, split, share.min(budget - spent), None, stop);
            let hopeless = found.exhausted && split == 2;
            spent += found.expansions;
            found.expansions = spent;
            if found.moves.is_some() || found.stopped || hopeless || spent >= budget {
                return found;
            }
        }
        if let Some(at) = r.index([found.nearest[0], found.nearest[1]]) {
            w.settle(&mut Lazy { raster: r, map }, at);
            let way = w.descend(r, at);
            r.make_dear(map, &way, DEAR, DEARER);
        }
        *w = Wave::new(&mut Lazy { raster: r, map }, task.goal, reach, false);
    }
    let mut found = attempt(task, raster, wave, 2, budget - spent, None, stop);
    found.expansions += spent;
    found
}

/// One search; after `look` expansions it asks whether the footprint can pass, and ends if that leads elsewhere.
fn attempt<M: Map>(
    task: &Task<'_, M>,
    raster: &mut Raster,
    wave: &mut Wave,
    split: usize,
    budget: usize,
    look: Option<usize>,
    stop: &mut dyn FnMut() -> bool,
) -> Found {
    let Task {
        map,
        body,
        price,
        params,
        start,
        ..
    } = *task;
    let bins = (split * params.headings) as i32;
    let mut prims = primitives(params, split);
    let usual = prims.len();
    prims.extend(gentle(params, body));
    let unit = TAU / f64::from(bins);
    // While room is missing, headings that the gentle curves tell apart are different states.
    let fine = prims[usual].heading_change().abs();
    let steady: Vec<f64> = prims.iter().map(|m| price.steady(m)).collect();
    let pace = 1.0 / price.limits.v;
    let mut greed = params.greed;
    let mut patience = PATIENCE;
    let mut nodes: Vec<Node> = Vec::new();
    let mut ways: Vec<Way> = Vec::new();
    let mut table = Table::new();
    let mut open = BinaryHeap::new();
    let mut outlook = Outlook::new(task, raster);
    let (h0, _) = outlook.seconds(start, task.missing.max(1e-9), raster, wave);
    let mut found = Found::nothing(start);
    if h0.is_infinite() {
        found.exhausted = true;
        return found;
    }
    let mut nearest_h = h0;
    nodes.push(Node {
        pose: start,
        g: 0.0,
        h: h0 as f32,
        missing: task.missing as f32,
        parent: 0,
        bin: 0,
        by: ROOT,
    });
    open.push(Entry {
        f: (greed * h0) as f32,
        node: 0,
    });
    // Cost of the best way to the goal, its node, and when to be content with it.
    let mut best_goal = f64::INFINITY;
    let (mut best_node, mut finish) = (0, usize::MAX);
    let mut since_shot = usize::MAX;
    let motion_of = |by: u8| (by < GOAL).then(|| prims[by as usize].motion);
    // Where starting and stopping cost nothing, the motion that led to a state does not matter.
    let charges = [Motion::Forward, Motion::Turn].map(|m| price.begin(m));
    let dear = charges[0].max(charges[1]);
    let (low, part) = (raster.low, split as f64 / raster.cell);
    let key = |at: usize, bin: i32, motion: Motion, missing: f64, p: [f64; 3]| {
        let motion = if dear > 1e-9 { motion as u64 } else { 0 };
        // Which part of the cell, on a finer lattice.
        let side = |axis: usize| ((p[axis] - low[axis]) * part) as usize % split;
        let at = (at * split + side(0)) * split + side(1);
        if missing > 0.0 {
            let bin = ((p[2] - start[2]) / fine).round().rem_euclid(4096.0);
            (1 << 62) | ((at as u64 * 4096 + bin as u64) * 3 + motion)
        } else {
            (at as u64 * bins as u64 + bin as u64) * 3 + motion
        }
    };

    while let Some(Entry { node: index, .. }) = open.pop() {
        let here = &nodes[index as usize];
        let (pose, g, missing, bin, by) = (
            here.pose,
            f64::from(here.g),
            f64::from(here.missing),
            here.bin as i32,
            here.by,
        );
        if by == GOAL || found.expansions >= finish {
            found.moves = Some(trace(&nodes, &ways, &prims, best_node));
            return found;
        }
        let motion = motion_of(by);
        if let (Some(motion), Some(at)) = (motion, raster.index([pose[0], pose[1]]))
            && table.get(key(at, bin, motion, missing, pose)) != Some(index)
        {
            continue;
        }
        let out_of_budget = found.expansions >= budget;
        if out_of_budget || found.expansions % 256 == 255 && stop() {
            found.stopped = !out_of_budget;
            // What is known by then is an answer, too.
            if best_goal.is_finite() {
                found.moves = Some(trace(&nodes, &ways, &prims, best_node));
            }
            return found;
        }
        found.expansions += 1;
        if look == Some(found.expansions) && best_goal.is_infinite() {
            let verdict = headings::look(task, raster, wave, stop);
            let elsewhere = matches!(verdict, Verdict::NoPassage(_) | Verdict::Chain(_, true));
            found.verdict = Some(verdict);
            if elsewhere {
                return found;
            }
        }
        if found.expansions >= patience {
            patience *= 2;
            greed *= GREEDIER;
            let list: Vec<Entry> = open.into_vec();
            let again = list.into_iter().map(|e| {
                let n = &nodes[e.node as usize];
                Entry {
                    f: (f64::from(n.g) + greed * f64::from(n.h)) as f32,
                    node: e.node,
                }
            });
            open = again.collect();
        }
        let (h, low) = outlook.seconds(pose, missing, raster, wave);
        if h < nearest_h {
            nearest_h = h;
            found.nearest = pose;
        }
        // A straight shot is worth a try when the wave goes about straight, too; far away not from every node.
        let straight = (task.goal[0] - pose[0]).hypot(task.goal[1] - pose[1]);
        since_shot = since_shot.saturating_add(1);
        if since_shot as f64 > 3.0 + 4.0 * straight
            && low <= (straight * (1.0 + params.clearance_weight) * 1.1 + 0.3) * pace
        {
            since_shot = 0;
            if let Some((way, cost)) = shot(task, pose, motion, missing, best_goal - g) {
                best_goal = g + cost;
                ways.push(way);
                best_node = nodes.len() as u32;
                if finish == usize::MAX {
                    finish = found.expansions + REFINE + found.expansions / 4;
                }
                nodes.push(Node {
                    pose,
                    g: best_goal as f32,
                    h: 0.0,
                    missing: 0.0,
                    parent: index,
                    bin: ways.len() as u32 - 1,
                    by: GOAL,
                });
                open.push(Entry {
                    f: best_goal as f32,
                    node: best_node,
                });
            }
        }
        let count = if missing > 0.0 { prims.len() } else { usual };
        let mut here_room = None;
        for (k, step) in prims[..count].iter().enumerate() {
            // Turning back and forth gains nothing.
            if step.motion == Motion::Turn && by < GOAL {
                let before = &prims[by as usize];
                if before.motion == Motion::Turn && before.amount * step.amount < 0.0 {
                    continue;
                }
            }
            let charge = if motion == Some(step.motion) {
                0.0
            } else {
                price.begin(step.motion)
            };
            let end = step.end(pose);
            let Some(at) = raster.index([end[0], end[1]]) else {
                continue;
            };
            let next_bin = (((end[2] - start[2]) / unit).round() as i32).rem_euclid(bins);
            let cost = g + charge + steady[k];
            let mut next_key = key(at, next_bin, step.motion, missing, end);
            let beaten = |key: u64, cost: f64, table: &Table, nodes: &[Node]| {
                table
                    .get(key)
                    .is_some_and(|n| f64::from(nodes[n as usize].g) <= cost + 1e-6)
            };
            if beaten(next_key, cost, &table, &nodes) {
                continue;
            }
            // The same place reached by another motion, cheaper by more than a stop costs.
            if dear > 1e-9
                && [Motion::Forward, Motion::Reverse, Motion::Turn]
                    .into_iter()
                    .any(|m| {
                        let key = key(at, next_bin, m, missing, end);
                        beaten(key, cost - dear, &table, &nodes)
                    })
            {
                continue;
            }
            let (h, low) = outlook.seconds(end, missing, raster, wave);
            if h.is_infinite() || cost + low >= best_goal {
                continue;
            }
            let room = *here_room.get_or_insert_with(|| body.room(map, pose));
            let Some(swept) = body.sweep(map, pose, step, missing, Some(room)) else {
                continue;
            };
            if missing > 0.0 && swept.missing <= 0.0 {
                next_key = key(at, next_bin, step.motion, 0.0, end);
            }
            let cost = cost + price.closeness(map, pose, step) + price.trouble(step, swept.share);
            if beaten(next_key, cost, &table, &nodes) {
                continue;
            }
            let node = nodes.len() as u32;
            nodes.push(Node {
                pose: end,
                g: cost as f32,
                h: h as f32,
                missing: swept.missing as f32,
                parent: index,
                bin: next_bin as u32,
                by: k as u8,
            });
            table.set(next_key, node);
            open.push(Entry {
                f: (cost + greed * h) as f32,
                node,
            });
        }
    }
    if best_goal.is_finite() {
        found.moves = Some(trace(&nodes, &ways, &prims, best_node));
    }
    found.exhausted = found.moves.is_none();
    found
}

fn trace(nodes: &[Node], ways: &[Way], prims: &[Move], goal: u32) -> Way {
    let last = &nodes[goal as usize];
    let mut tail: Way = ways[last.bin as usize].iter().rev().copied().collect();
    let mut at = last.parent as usize;
    while nodes[at].by != ROOT {
        tail.push(prims[nodes[at].by as usize]);
        at = nodes[at].parent as usize;
    }
    tail.reverse();
    merge(&tail)
}

/// Joins moves that are one motion at one curvature.
pub(crate) fn merge(moves: &[Move]) -> Way {
    let mut out = Way::with_capacity(moves.len());
    for m in moves {
        match out.last_mut() {
            Some(l) if l.motion == m.motion && m.motion == Motion::Turn => l.amount += m.amount,
            Some(l) if l.motion == m.motion && (l.curvature - m.curvature).abs() < 1e-9 => {
                l.amount += m.amount
            }
            _ => out.push(*m),
        }
        if out.last().is_some_and(|l| l.amount.abs() < 1e-12) {
            out.pop();
        }
    }
    out
}
