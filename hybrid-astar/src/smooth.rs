//! Shortcuts on the timed price: long straight stretches, wide curves, few stops.

use crate::Map;
use crate::moves::{Motion, Move};
use crate::search::{Task, merge};
use crate::shot::ways_to_goal;
use crate::steer::{self, Way};

/// A move with its start and the price of its closeness.
#[derive(Clone, Copy)]
struct Piece {
    step: Move,
    from: [f64; 3],
    near: f64,
}

/// Most pieces that one shortcut replaces: longer ones hardly ever succeed.
const LONGEST: usize = 32;

/// Makes the path cheaper where a free shortcut exists. Start, goal and the start's way out of a violation stay.
pub(crate) fn smooth<M: Map>(task: &Task<'_, M>, moves: &[Move]) -> Way {
    let mut pieces = cut(task, moves, 0.4);
    for _ in 0..2 {
        let before = total(task, &pieces);
        let mut gap = pieces.len().min(LONGEST);
        while gap >= 2 {
            let mut i = 0;
            while i + 2 <= pieces.len() {
                let j = (i + gap).min(pieces.len());
                if !shortcut(task, &mut pieces, i, j) {
                    i += (gap / 2).max(1);
                } else {
                    i += 1;
                }
                if j == pieces.len() {
                    break;
                }
            }
            gap = if gap > 3 { gap * 2 / 3 } else { gap - 1 };
        }
        let moves: Way = pieces.iter().map(|p| p.step).collect();
        pieces = cut(task, &merge(&moves), 0.4);
        if total(task, &pieces) > 0.97 * before {
            break;
        }
    }
    let moves: Way = pieces.iter().map(|p| p.step).collect();
    merge(&moves)
}

/// Splits moves into pieces of at most `length` m (turns stay whole).
fn cut<M: Map>(task: &Task<'_, M>, moves: &[Move], length: f64) -> Vec<Piece> {
    let mut from = task.start;
    let mut missing = task.missing;
    let mut pieces = Vec::new();
    for m in moves {
        let n = if m.motion == Motion::Turn {
            1.0
        } else {
            (m.amount / length).ceil().max(1.0)
        };
        for _ in 0..n as usize {
            let step = Move {
                amount: m.amount / n,
                ..*m
            };
            let mut near = task.price.closeness(task.map, from, &step);
            if missing > 0.0 {
                // Driven before in other pieces: a rounding away from the limit it still counts as trouble all along.
                let swept = task.body.sweep(task.map, from, &step, missing, None);
                missing = swept.map_or(missing, |s| s.missing);
                near += task.price.trouble(&step, swept.map_or(1.0, |s| s.share));
            }
            pieces.push(Piece { step, from, near });
            from = step.end(from);
        }
    }
    pieces
}

fn total<M>(task: &Task<'_, M>, pieces: &[Piece]) -> f64 {
    task.price.way(None, pieces.iter().map(|p| &p.step))
        + pieces.iter().map(|p| p.near).sum::<f64>()
}

/// Replaces pieces `i..j` by a cheaper free way, if there is one.
fn shortcut<M: Map>(task: &Task<'_, M>, pieces: &mut Vec<Piece>, i: usize, j: usize) -> bool {
    let from = pieces[i].from;
    let goal = j == pieces.len();
    let mut candidates = Vec::new();
    // A turn that follows can take up any heading.
    let turn_after = !goal && pieces[j].step.motion == Motion::Turn;
    let j = if turn_after { j + 1 } else { j };
    let to = if j == pieces.len() {
        None
    } else {
        Some(pieces[j].from)
    };
    // No way is quicker than the straight line or the turn alone: where little is to be gained none is tried.
    let cost = task.price.way(None, pieces[i..j].iter().map(|p| &p.step))
        + pieces[i..j].iter().map(|p| p.near).sum::<f64>();
    let limits = &task.price.limits;
    let target = to.unwrap_or([task.goal[0], task.goal[1], f64::NAN]);
    let turn = if target[2].is_nan() {
        0.0
    } else {
        crate::moves::wrap(target[2] - from[2]).abs() / limits.w
    };
    let least = ((target[0] - from[0]).hypot(target[1] - from[1]) / limits.v).max(turn);
    if cost - least < 0.01 + 0.02 * cost {
        return false;
    }
    if let Some(to) = to {
        let radii = task.radii();
        let toward = |yaw: f64| yaw + crate::moves::wrap(to[2] - yaw);
        candidates.push(steer::rotate_line(
            from,
            [to[0], to[1]],
            Motion::Forward,
            toward,
        ));
        let far = (to[0] - from[0]).hypot(to[1] - from[1]);
        if far <= task.params.reverse_reach {
            candidates.push(steer::rotate_line(
                from,
                [to[0], to[1]],
                Motion::Reverse,
                toward,
            ));
            steer::dubins(from, to, radii[0], Motion::Reverse, |way| {
                candidates.push(way)
            });
        }
        steer::between(from, to, &radii, task.params.drive, &mut candidates);
        candidates.retain(|way| way.iter().all(|m| task.params.drive.allows(m)));
    } else {
        candidates = ways_to_goal(task, from);
    }
    // The context that may merge into the runs at both ends: the whole neighbouring runs.
    let mut a = i;
    while a > 0 && pieces[a - 1].step.motion == pieces[i - 1].step.motion {
        a -= 1;
    }
    let mut b = j;
    while b < pieces.len() && pieces[b].step.motion == pieces[j].step.motion {
        b += 1;
    }
    // Their pieces stay; only how long each run is matters.
    let joined = |r: &[Piece]| -> Option<Move> {
        let extent = r.iter().map(|p| p.step.extent()).sum();
        r.first().map(|p| Move {
            amount: extent,
            curvature: 0.0,
            ..p.step
        })
    };
    let (head, tail) = (joined(&pieces[a..i]), joined(&pieces[j..b]));
    let with_context = |way: &[Move]| -> f64 {
        let steps = head.iter().chain(way).chain(&tail);
        task.price.way(None, steps)
    };
    let present: Way = pieces[i..j].iter().map(|p| p.step).collect();
    let old_near: f64 = pieces[i..j].iter().map(|p| p.near).sum();
    let old = with_context(&present) + old_near;
    let mut ranked: Vec<(f64, Way)> = Vec::new();
    // What the ways at both ends could save by merging.
    let stops = limits.drive_stop() + limits.turn_stop();
    for way in candidates {
        if way.iter().map(|m| task.price.steady(m)).sum::<f64>() >= cost + stops {
            continue;
        }
        let cost = with_context(&way);
        if cost < old - 1e-3 {
            ranked.push((cost, way));
        }
    }
    ranked.sort_by(|x, y| x.0.total_cmp(&y.0));
    let missing = if i == 0 { task.missing } else { 0.0 };
    for (cost, way) in ranked.into_iter().take(3) {
        let fresh = cut_from(task, from, &way, missing, old - 1e-3 - cost);
        if let Some(fresh) = fresh {
            pieces.splice(i..j, fresh);
            // What follows starts where the new way ends: the same pose up to rounding.
            for k in i.max(1)..pieces.len() {
                let at = pieces[k - 1].step.end(pieces[k - 1].from);
                if at == pieces[k].from {
                    break;
                }
                pieces[k].from = at;
            }
            return true;
        }
    }
    false
}

/// Checks a way and cuts it to pieces; `None` if it collides or its closeness costs more than `room`.
fn cut_from<M: Map>(
    task: &Task<'_, M>,
    from: [f64; 3],
    way: &[Move],
    missing: f64,
    room: f64,
) -> Option<Vec<Piece>> {
    let mut p = from;
    let mut missing = missing;
    let mut near = 0.0;
    let mut out = Vec::new();
    let mut beside = None;
    for m in way {
        let swept = task.body.sweep(task.map, p, m, missing, beside)?;
        missing = swept.missing;
        beside = Some(swept.room);
        let n = if m.motion == Motion::Turn {
            1.0
        } else {
            (m.amount / 0.4).ceil().max(1.0)
        };
        for _ in 0..n as usize {
            let step = Move {
                amount: m.amount / n,
                ..*m
            };
            let piece = Piece {
                step,
                from: p,
                near: task.price.closeness(task.map, p, &step)
                    + task.price.trouble(&step, swept.share),
            };
            near += piece.near;
            out.push(piece);
            p = step.end(p);
        }
    }
    (missing <= 0.0 && near < room).then_some(out)
}
