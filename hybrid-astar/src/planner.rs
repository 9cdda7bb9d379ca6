//! Planning a base path, and what is worth keeping between plans.

use crate::body::Body;
use crate::error::finite;
use crate::headings::Verdict;
use crate::moves::wrap;
use crate::plan::{Plan, Reason, Status};
use crate::price::Price;
use crate::raster::{Lazy, Pricing, Raster};
use crate::search::{Task, search};
use crate::wave::Wave;
use crate::{Error, GoalYaw, Map, Params, Robot, smooth, time, trace};
use std::f64::consts::TAU;

/// Plans a path for `robot` on `map` from the pose `start` [x, y, yaw] to the point `goal` [x, y], m and rad.
///
/// "No path" is an `Ok` plan with another status than `Solved` and a reason. For many plans on one map keep a
/// [`Planner`].
pub fn plan<M: Map, R: Robot>(
    map: &M,
    robot: &R,
    start: [f64; 3],
    goal: [f64; 2],
    yaw: &GoalYaw,
    params: &Params,
) -> Result<Plan, Error> {
    Planner::new(params.clone())?.plan(map, robot, start, goal, yaw)
}

/// How many goals' waves are kept.
const KEPT: usize = 8;

/// Keeps the grid and the waves of the last goals for as long as the map's revision stays.
///
/// Use one planner for one map and one robot; [`clear`](Self::clear) it before another.
#[derive(Clone, Debug)]
pub struct Planner {
    params: Params,
    revision: u64,
    pricing: Option<Pricing>,
    raster: Option<Raster>,
    waves: Vec<([f64; 2], Wave)>,
}

impl Planner {
    /// Checks the settings.
    pub fn new(params: Params) -> Result<Self, Error> {
        params.validate()?;
        Ok(Self {
            params,
            revision: 0,
            pricing: None,
            raster: None,
            waves: Vec::new(),
        })
    }

    /// The settings.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// Forgets the map.
    pub fn clear(&mut self) {
        self.raster = None;
        self.waves.clear();
    }

    /// See [`plan`].
    pub fn plan<M: Map, R: Robot>(
        &mut self,
        map: &M,
        robot: &R,
        start: [f64; 3],
        goal: [f64; 2],
        yaw: &GoalYaw,
    ) -> Result<Plan, Error> {
        self.plan_until(map, robot, start, goal, yaw, &mut || false)
    }

    /// Like [`plan`](Self::plan), ended early when `stop` returns true; it is asked every few hundred expansions.
    pub fn plan_until<M: Map, R: Robot>(
        &mut self,
        map: &M,
        robot: &R,
        start: [f64; 3],
        goal: [f64; 2],
        yaw: &GoalYaw,
        stop: &mut dyn FnMut() -> bool,
    ) -> Result<Plan, Error> {
        finite("start", &start)?;
        finite("goal", &goal)?;
        yaw.validate()?;
        let mut body = Body::new(map, robot, self.params.margin, self.params.check_step)?;
        self.prepare(map, &body)?;
        let params = &self.params;
        let Some(raster) = self.raster.as_mut() else {
            return Err(Error::Footprint("unreachable: the grid was just made"));
        };

        let missing = body.depth(map, start);
        body.begin(missing);
        let (low, high) = map.bounds();
        let outside = |what, point: [f64; 2]| Reason::Outside {
            what,
            point,
            low,
            high,
        };
        if raster.index([start[0], start[1]]).is_none() {
            let reason = outside("start", [start[0], start[1]]);
            return Ok(Plan::failed(Status::StartBlocked, start, 0, reason));
        }
        if missing > params.start_tolerance {
            let reason = Reason::StartBlocked {
                pose: start,
                clearance: map.clearance([start[0], start[1]]),
                missing,
                tolerance: params.start_tolerance,
                at: body.worst_place(map, start),
            };
            return Ok(Plan::failed(Status::StartBlocked, start, 0, reason));
        }
        let Some(place) = free_goal(map, &body, raster, params, goal, yaw) else {
            let reason = if raster.index(goal).is_none() {
                outside("goal", goal)
            } else {
                goal_reason(map, &body, params, goal, yaw)
            };
            return Ok(Plan::failed(Status::GoalBlocked, start, 0, reason));
        };

        let pricing = raster_pricing(&body, params);
        let price = Price::new(params, pricing);
        let at = match self.waves.iter().position(|(g, _)| *g == place) {
            Some(at) => at,
            None => {
                if self.waves.len() >= KEPT {
                    self.waves.remove(0);
                }
                let wave = Wave::new(
                    &mut Lazy { raster, map },
                    place,
                    2.0 * params.cell_size,
                    false,
                );
                self.waves.push((place, wave));
                self.waves.len() - 1
            }
        };
        let wave = &mut self.waves[at].1;
        let task = Task {
            map,
            body: &body,
            price: &price,
            params,
            start,
            missing,
            goal: place,
            yaw,
        };
        let found = search(&task, raster, wave, params.max_expansions, stop);

        let Some(moves) = found.moves else {
            let disconnected = found.exhausted && found.expansions == 0;
            let (status, reason) = if let Some(Verdict::NoPassage(at)) = found.verdict {
                let (radius, need) = (body.inscribed, body.circumscribed);
                let clearance = map.clearance(at);
                let reason = Reason::NoPassage {
                    at,
                    clearance,
                    radius,
                    need,
                };
                (Status::NoPassage, reason)
            } else if disconnected {
                (
                    Status::Disconnected,
                    Reason::Disconnected {
                        radius: body.inscribed,
                    },
                )
            } else {
                let status = match (found.exhausted, found.stopped) {
                    (true, _) => Status::Exhausted,
                    (_, true) => Status::Stopped,
                    _ => Status::BudgetExhausted,
                };
                let (nearest, expansions, exhausted) =
                    (found.nearest, found.expansions, found.exhausted);
                let gap = first_gap(&task, raster, wave, nearest);
                (
                    status,
                    Reason::NotReached {
                        nearest,
                        expansions,
                        exhausted,
                        gap,
                    },
                )
            };
            let mut plan = Plan::failed(status, start, found.expansions, reason);
            plan.start_violation = missing;
            return Ok(plan);
        };
        let moves = if params.smooth {
            smooth::smooth(&task, &moves)
        } else {
            moves
        };
        let mut cost = price.way(None, &moves);
        let mut from = start;
        for m in &moves {
            cost += price.closeness(map, from, m);
            from = m.end(from);
        }
        let mut segments =
            trace::segments(map, &body, &params.limits, start, &moves, params.smooth);
        // Close the rounding of the last arc.
        if let Some(end) = segments.last_mut().and_then(|s| s.poses.last_mut()) {
            let exact = yaw.nearest(end[2]);
            *end = [
                place[0],
                place[1],
                if (exact - end[2]).abs() < 1e-5 {
                    exact
                } else {
                    end[2]
                },
            ];
        }
        Ok(Plan {
            status: Status::Solved,
            length: segments.iter().map(trace::Segment::length).sum(),
            seconds: time::seconds(&segments, &params.limits),
            cost,
            expansions: found.expansions,
            start_violation: missing,
            end: segments
                .last()
                .and_then(|s| s.poses.last())
                .copied()
                .unwrap_or(start),
            goal_shift: (place[0] - goal[0]).hypot(place[1] - goal[1]),
            reason: None,
            segments,
        })
    }

    /// Drops what belongs to another map revision or footprint.
    fn prepare<M: Map>(&mut self, map: &M, body: &Body) -> Result<(), Error> {
        let pricing = raster_pricing(body, &self.params);
        let same = self.raster.is_some()
            && self.revision == map.revision()
            && self.pricing == Some(pricing);
        if !same {
            self.clear();
            self.raster = Some(Raster::new(map, self.params.cell_size, pricing)?);
            self.revision = map.revision();
            self.pricing = Some(pricing);
        }
        Ok(())
    }
}

/// The wave may pass wherever the inscribed disc fits near a cell's middle; where it does not fit in the middle
/// itself, at a price, so that the search looks at better places first.
pub(crate) fn raster_pricing(body: &Body, params: &Params) -> Pricing {
    Pricing {
        need: body.inscribed - params.cell_size * std::f64::consts::FRAC_1_SQRT_2,
        fit: body.inscribed,
        narrow: 1.0,
        cuts: 2,
        weight: params.clearance_weight,
        comfort: params.comfort,
    }
}

/// The headings at the goal that are tried: the allowed ones, or samples of an allowed range.
fn goal_headings(params: &Params, yaw: &GoalYaw) -> Vec<f64> {
    match yaw {
        GoalYaw::Fixed(y) => vec![*y],
        GoalYaw::Any(list) => list.clone(),
        _ => {
            let unit = TAU / params.headings as f64;
            let all = (0..params.headings).map(|k| yaw.nearest(k as f64 * unit));
            all.map(wrap).collect()
        }
    }
}

fn goal_reason<M: Map>(
    map: &M,
    body: &Body,
    params: &Params,
    goal: [f64; 2],
    yaw: &GoalYaw,
) -> Reason {
    let depth = |h: f64| body.depth(map, [goal[0], goal[1], h]);
    let headings = goal_headings(params, yaw);
    let best = headings.iter().map(|&h| (depth(h), h));
    let best = best.min_by(|a, b| a.0.total_cmp(&b.0));
    let yaw = best.map_or(0.0, |b| b.1);
    Reason::GoalBlocked {
        goal,
        clearance: map.clearance(goal),
        needs: body.inscribed,
        tolerance: params.goal_tolerance,
        yaw,
        at: body.worst_place(map, [goal[0], goal[1], yaw]),
    }
}

/// The first place on the wave's way from a pose to the goal where the footprint fits with no heading.
fn first_gap<M: Map>(
    task: &Task<'_, M>,
    raster: &mut Raster,
    wave: &mut Wave,
    from: [f64; 3],
) -> Option<[f64; 2]> {
    let at = raster.index([from[0], from[1]])?;
    let map = task.map;
    if !wave.settle(&mut Lazy { raster, map }, at).is_finite() {
        return None;
    }
    let unit = TAU / task.params.headings as f64;
    let fits = |p: [f64; 2]| {
        (0..task.params.headings)
            .any(|k| task.body.room(task.map, [p[0], p[1], k as f64 * unit]) >= 0.0)
    };
    let way = wave.descend(raster, at);
    way.into_iter()
        .skip(1)
        .map(|c| raster.center(c))
        .find(|&p| !fits(p))
}

/// The goal, or the nearest point within the tolerance at which an allowed heading is free.
fn free_goal<M: Map>(
    map: &M,
    body: &Body,
    raster: &Raster,
    params: &Params,
    goal: [f64; 2],
    yaw: &GoalYaw,
) -> Option<[f64; 2]> {
    let headings = goal_headings(params, yaw);
    let fits = |p: [f64; 2]| {
        raster.index(p).is_some()
            && headings
                .iter()
                .any(|&h| body.room(map, [p[0], p[1], h]) >= 0.0)
    };
    if fits(goal) {
        return Some(goal);
    }
    if params.goal_tolerance <= 0.0 {
        return None;
    }
    let mut near = raster.within(goal, params.goal_tolerance);
    near.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    near.into_iter()
        .map(|(at, _)| raster.center(at))
        .find(|&p| fits(p))
}
