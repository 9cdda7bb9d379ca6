//! A* over (cell, heading, motion) with the exact pose kept in every node.

use crate::body::{Body, SWING};
use crate::moves::{Motion, Move};
use crate::price::Price;
use crate::steer::{self, Way};
use crate::table::Table;
use crate::wave::{Lazy, Raster, Wave};
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
    /// Reached pose nearest to the goal, by the wave.
    pub(crate) nearest: [f64; 3],
}

struct Node {
    pose: [f64; 3],
    g: f32,
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

/// The lattice's moves: forward and backward, straight and along two curvatures to each side, and single turns.
pub(crate) fn primitives(params: &Params) -> Vec<(Move, i32)> {
    let unit = TAU / params.headings as f64;
    let step = 2.0 * params.cell_size;
    let mut list = Vec::new();
    for motion in [Motion::Forward, Motion::Reverse] {
        for bins in [0, 1, -1, 2, -2] {
            list.push((
                Move::drive(motion, step, f64::from(bins) * unit / step),
                bins,
            ));
        }
    }
    list.push((Move::turn(unit), 1));
    list.push((Move::turn(-unit), -1));
    list
}

/// Long, gentle curves for the way out of a violation.
///
/// The tail of a body along a wall swings towards it by `curvature * tail^2 / 2` when the body curves away.
fn gentle(params: &Params, body: &Body) -> Vec<Move> {
    let unit = TAU / params.headings as f64;
    let step = 6.0 * params.cell_size;
    let tail = body.circumscribed;
    let curvature = (unit / step).min(1.5 * SWING / (tail * tail));
    let mut list = Vec::new();
    for motion in [Motion::Forward, Motion::Reverse] {
        for side in [1.0, -1.0] {
            list.push(Move::drive(motion, step, side * curvature));
        }
    }
    list
}

pub(crate) fn search<M: Map>(
    task: &Task<'_, M>,
    raster: &mut Raster,
    wave: &mut Wave,
    budget: usize,
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
    let bins = params.headings as i32;
    let mut prims = primitives(params);
    let usual = prims.len();
    prims.extend(gentle(params, body).into_iter().map(|m| (m, 0)));
    let unit = TAU / f64::from(bins);
    // While room is missing, headings that the gentle curves tell apart are different states.
    let fine = prims[usual].0.heading_change().abs();
    let steady: Vec<f64> = prims.iter().map(|(m, _)| price.steady(m)).collect();
    let pace = 1.0 / price.limits.v;
    let greed = params.greed;
    let mut nodes: Vec<Node> = Vec::new();
    let mut ways: Vec<Way> = Vec::new();
    let mut table = Table::new();
    let mut open = BinaryHeap::new();
    let mut to_go = |p: [f64; 3], missing: f64, raster: &mut Raster| -> f64 {
        let Some(at) = raster.index([p[0], p[1]]) else {
            return f64::INFINITY;
        };
        let d = f64::from(wave.settle(&mut Lazy { raster, map }, at));
        if d.is_finite() || missing <= 0.0 {
            return d * pace;
        }
        // Where the robot is too close to an obstacle the wave may not come: take the nearest cell it reaches.
        let around = raster.within([p[0], p[1]], missing + 3.0 * params.cell_size);
        let mut best = f64::INFINITY;
        for (at, gap) in around {
            best = best.min(f64::from(wave.settle(&mut Lazy { raster, map }, at)) + gap);
        }
        best * pace
    };
    let h0 = to_go(start, task.missing.max(1e-9), raster);
    let mut found = Found {
        moves: None,
        expansions: 0,
        exhausted: false,
        stopped: false,
        nearest: start,
    };
    if h0.is_infinite() {
        found.exhausted = true;
        return found;
    }
    let mut nearest_h = h0;
    nodes.push(Node {
        pose: start,
        g: 0.0,
        missing: task.missing as f32,
        parent: 0,
        bin: 0,
        by: ROOT,
    });
    open.push(Entry {
        f: (greed * h0) as f32,
        node: 0,
    });
    let mut best_goal = f64::INFINITY;
    let motion_of = |by: u8| {
        if by < GOAL {
            Some(prims[by as usize].0.motion)
        } else {
            None
        }
    };
    let key = |at: usize, bin: i32, motion: Motion, missing: f64, yaw: f64| {
        if missing > 0.0 {
            let bin = ((yaw - start[2]) / fine).round().rem_euclid(4096.0);
            (1 << 62) | ((at as u64 * 4096 + bin as u64) * 3 + motion as u64)
        } else {
            (at as u64 * bins as u64 + bin as u64) * 3 + motion as u64
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
        if by == GOAL {
            found.moves = Some(trace(&nodes, &ways, &prims, index));
            return found;
        }
        let motion = motion_of(by);
        if let (Some(motion), Some(at)) = (motion, raster.index([pose[0], pose[1]]))
            && table.get(key(at, bin, motion, missing, pose[2])) != Some(index)
        {
            continue;
        }
        if found.expansions >= budget {
            return found;
        }
        if found.expansions % 256 == 255 && stop() {
            found.stopped = true;
            return found;
        }
        found.expansions += 1;
        let h = to_go(pose, missing, raster);
        if h < nearest_h {
            nearest_h = h;
            found.nearest = pose;
        }
        // A straight shot is worth a try when the wave goes about straight, too.
        let straight = (task.goal[0] - pose[0]).hypot(task.goal[1] - pose[1]);
        if h <= (straight * (1.0 + params.clearance_weight) * 1.1 + 0.3) * pace
            && let Some((way, cost)) = shot(task, pose, motion, missing, best_goal - g)
        {
            best_goal = g + cost;
            ways.push(way);
            let node = nodes.len() as u32;
            nodes.push(Node {
                pose,
                g: best_goal as f32,
                missing: 0.0,
                parent: index,
                bin: ways.len() as u32 - 1,
                by: GOAL,
            });
            open.push(Entry {
                f: best_goal as f32,
                node,
            });
        }
        let count = if missing > 0.0 { prims.len() } else { usual };
        for (k, (step, turn)) in prims[..count].iter().enumerate() {
            // Turning back and forth, or reversing at once, gains nothing.
            if step.motion == Motion::Turn && by < GOAL {
                let (before, turned) = &prims[by as usize];
                if before.motion == Motion::Turn && *turned != *turn {
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
            let next_bin = if k < usual {
                bin + turn
            } else {
                ((end[2] - start[2]) / unit).round() as i32
            };
            let next_bin = next_bin.rem_euclid(bins);
            let cost = g + charge + steady[k];
            let mut next_key = key(at, next_bin, step.motion, missing, end[2]);
            let mut known = table.get(next_key);
            if known.is_some_and(|n| f64::from(nodes[n as usize].g) <= cost + 1e-6) {
                continue;
            }
            let h = to_go(end, missing, raster);
            if h.is_infinite() || cost + h >= best_goal {
                continue;
            }
            let Some(swept) = body.sweep(map, pose, step, missing) else {
                continue;
            };
            if missing > 0.0 && swept.missing <= 0.0 {
                next_key = key(at, next_bin, step.motion, 0.0, end[2]);
                known = table.get(next_key);
            }
            let cost = cost + price.closeness(map, pose, step) + price.trouble(step, swept.share);
            if known.is_some_and(|n| f64::from(nodes[n as usize].g) <= cost + 1e-6) {
                continue;
            }
            let node = nodes.len() as u32;
            nodes.push(Node {
                pose: end,
                g: cost as f32,
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
    found.exhausted = true;
    found
}

/// The cheapest free way straight to the goal, if it costs less than `limit`.
fn shot<M: Map>(
    task: &Task<'_, M>,
    pose: [f64; 3],
    motion: Option<Motion>,
    missing: f64,
    limit: f64,
) -> Option<(Way, f64)> {
    let mut list: Vec<(f64, Way)> = Vec::new();
    for way in ways_to_goal(task, pose) {
        let cost = task.price.way(motion, &way);
        if cost < limit {
            list.push((cost, way));
        }
    }
    list.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (cost, way) in list.into_iter().take(4) {
        let mut p = pose;
        let mut short = Some(missing);
        let mut near = 0.0;
        for m in &way {
            let swept = short.and_then(|s| task.body.sweep(task.map, p, m, s));
            short = swept.map(|s| s.missing);
            let Some(swept) = swept else {
                break;
            };
            near += task.price.closeness(task.map, p, m) + task.price.trouble(m, swept.share);
            p = m.end(p);
        }
        if short == Some(0.0) && cost + near < limit {
            return Some((way, cost + near));
        }
    }
    None
}

/// Radii tried for curves, as multiples of the smallest one driven at full speed.
pub(crate) const RADII: [f64; 3] = [1.02, 1.8, 3.2];

/// All the ways from a pose to the goal that ignore obstacles.
pub(crate) fn ways_to_goal<M>(task: &Task<'_, M>, pose: [f64; 3]) -> Vec<Way> {
    let tight = task.price.limits.v / task.price.limits.w;
    let settle = |yaw: f64| task.yaw.nearest(yaw);
    let mut list = vec![steer::rotate_line(pose, task.goal, Motion::Forward, settle)];
    let far = (task.goal[0] - pose[0]).hypot(task.goal[1] - pose[1]);
    if far <= task.params.reverse_reach {
        list.push(steer::rotate_line(pose, task.goal, Motion::Reverse, settle));
    }
    let targets = task.yaw.targets();
    if targets.is_empty() || matches!(task.yaw, GoalYaw::Within { .. }) {
        let mut add = |way: Option<Way>| {
            if let Some(mut way) = way {
                let end = steer::end(pose, &way);
                let last = settle(end[2]) - end[2];
                if last.abs() > 1e-9 {
                    way.push(Move::turn(last));
                }
                list.push(way);
            }
        };
        let arc = steer::single_arc(pose, task.goal, Motion::Forward);
        add(arc
            .filter(|a| a.curvature.abs() * tight <= 1.0)
            .map(|a| vec![a]));
        for r in RADII {
            for side in [1.0, -1.0] {
                add(steer::arc_line(
                    pose,
                    task.goal,
                    r * tight,
                    side,
                    Motion::Forward,
                ));
            }
        }
    }
    for yaw in targets {
        for r in RADII {
            steer::dubins(
                pose,
                [task.goal[0], task.goal[1], yaw],
                r * tight,
                Motion::Forward,
                |way| list.push(way),
            );
        }
    }
    list
}

fn trace(nodes: &[Node], ways: &[Way], prims: &[(Move, i32)], goal: u32) -> Way {
    let last = &nodes[goal as usize];
    let mut tail: Way = ways[last.bin as usize].iter().rev().copied().collect();
    let mut at = last.parent as usize;
    while nodes[at].by != ROOT {
        tail.push(prims[nodes[at].by as usize].0);
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
