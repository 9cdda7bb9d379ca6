//! The dual-stage decision: HEATS, Algorithm 1, on indices and costs alone.

use std::cell::Cell;

use crate::cost::FromFn;
use crate::error::Error;
use crate::problem::{Params, Problem};
use crate::solver::Solver;

/// A place whose costs the decision asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Where the robot is.
    Robot,
    /// A candidate viewpoint, by its index.
    Candidate(usize),
    /// The centre of a region, by its index.
    Region(usize),
}

/// What is to be decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decision<'a> {
    /// Region the robot is in (R_c).
    pub current: usize,
    /// Number of regions.
    pub regions: usize,
    /// Region of each candidate (set C).
    pub region_of: &'a [usize],
}

/// What was decided.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The viewpoint to visit next (vp_t).
    pub candidate: usize,
    /// The region to go to after the current one (R_t); `None` when no other region holds a candidate.
    pub target_region: Option<usize>,
    /// Regions in the order of the tour; the first is the current one.
    pub region_order: Vec<usize>,
    /// The candidates of the current region (C_n) in the order of the path; empty when the target was picked from
    /// another region.
    pub viewpoint_order: Vec<usize>,
}

/// Chooses the next viewpoint: an open tour over the regions that hold candidates gives the target region R_t; if the
/// current region holds candidates, the first of the cheapest path from the robot over all of them to the centre of R_t is
/// chosen, otherwise the nearest candidate of R_t.
///
/// Where the algorithm is silent: regions without candidates are not visited; without any R_t the path's end is free;
/// if no arc-finite order exists, or R_t turns out to hold no reachable candidate, the nearest reachable candidate of
/// any region is taken. Ties go to the lower index.
///
/// `seconds` is asked for Robot → Candidate, Candidate → Candidate and Candidate → Region inside the current region, for
/// Robot → Candidate in others, and for Region → Region; infinity means unreachable.
///
/// Returns `None` when no candidate is reachable.
///
/// # Errors
/// [`Error::OutOfRange`] for a region index that is no region, [`Error::BadTime`] for a time that is NaN or negative.
pub fn two_level(
    decision: &Decision<'_>,
    seconds: impl Fn(Place, Place) -> f64,
    params: &Params,
) -> Result<Option<Choice>, Error> {
    two_level_from(&mut Solver::new(), decision, seconds, &[], params)
}

/// [`two_level`] with a solver that keeps its memory, and from an earlier order of candidates, such as the last
/// [`Choice::viewpoint_order`] in today's numbers: those no longer in the current region are passed over, new ones put
/// where they cost least, and the search goes on from there.
///
/// # Errors
/// As [`two_level`].
pub fn two_level_from(
    solver: &mut Solver,
    decision: &Decision<'_>,
    seconds: impl Fn(Place, Place) -> f64,
    earlier: &[usize],
    params: &Params,
) -> Result<Option<Choice>, Error> {
    let Decision {
        current,
        regions,
        region_of,
    } = *decision;
    let in_range = |what, index| {
        if index < regions {
            Ok(())
        } else {
            Err(Error::OutOfRange {
                what,
                index,
                len: regions,
            })
        }
    };
    in_range("current region", current)?;
    for &region in region_of {
        in_range("region of a candidate", region)?;
    }
    // The first bad time is remembered and, while the decision is made on, counts as unreachable.
    let bad = Cell::new(None);
    let checked = |from: Place, to: Place| {
        let time = seconds(from, to);
        if time >= 0.0 {
            return time;
        }
        if bad.get().is_none() {
            bad.set(Some((from, to, time)));
        }
        f64::INFINITY
    };
    let choice = decide(solver, decision, &checked, earlier, params);
    match bad.get() {
        Some((from, to, seconds)) => Err(Error::BadTime { from, to, seconds }),
        None => choice,
    }
}

fn decide(
    solver: &mut Solver,
    decision: &Decision<'_>,
    seconds: &impl Fn(Place, Place) -> f64,
    earlier: &[usize],
    params: &Params,
) -> Result<Option<Choice>, Error> {
    let Decision {
        current,
        regions,
        region_of,
    } = *decision;
    // Lines 1-2: the region tour.
    let mut tour = vec![current];
    tour.extend((0..regions).filter(|&r| r != current && region_of.contains(&r)));
    let costs = FromFn::new(tour.len(), |a, b| {
        seconds(Place::Region(tour[a]), Place::Region(tour[b]))
    });
    let region_order: Vec<usize> = match solver.solve(&costs, Problem::Open { start: 0 }, params) {
        Ok(solution) => solution.order.iter().map(|&i| tour[i]).collect(),
        // Some region cannot be reached: go by distance from the current one.
        Err(Error::Infeasible | Error::NotFound | Error::Overflow) => {
            by_distance(current, &tour, seconds)
        }
        Err(error) => return Err(error),
    };
    let target_region = region_order.get(1).copied();

    // Lines 3-9: candidates of the current region, as far as they can be reached.
    let near: Vec<usize> = (0..region_of.len())
        .filter(|&c| region_of[c] == current)
        .filter(|&c| seconds(Place::Robot, Place::Candidate(c)) < f64::INFINITY)
        .collect();
    if !near.is_empty() {
        // Line 13: robot, all of C_n, centre of R_t.
        let viewpoint_order = path(solver, &near, target_region, seconds, earlier, params)?;
        return Ok(Some(Choice {
            candidate: viewpoint_order[0],
            target_region,
            region_order,
            viewpoint_order,
        }));
    }
    // Line 11: the nearest viewpoint of R_t, or of any region where that fails.
    let nearest = |wanted: &dyn Fn(usize) -> bool| {
        let mut best: Option<(f64, usize)> = None;
        for c in (0..region_of.len()).filter(|&c| wanted(region_of[c])) {
            let cost = seconds(Place::Robot, Place::Candidate(c));
            if cost < best.map_or(f64::INFINITY, |b| b.0) {
                best = Some((cost, c));
            }
        }
        best.map(|b| b.1)
    };
    let candidate = target_region
        .and_then(|r| nearest(&|region| region == r))
        .or_else(|| nearest(&|_| true));
    Ok(candidate.map(|candidate| Choice {
        candidate,
        target_region,
        region_order,
        viewpoint_order: Vec::new(),
    }))
}

fn by_distance(
    current: usize,
    tour: &[usize],
    seconds: &impl Fn(Place, Place) -> f64,
) -> Vec<usize> {
    let cost = |r: usize| {
        if r == current {
            -1.0
        } else {
            seconds(Place::Region(current), Place::Region(r))
        }
    };
    let mut order = tour.to_vec();
    order.sort_by(|&a, &b| cost(a).total_cmp(&cost(b)).then(a.cmp(&b)));
    order
}

/// The ViewpointDecider: robot first, all of `near`, then the centre of the target region.
fn path(
    solver: &mut Solver,
    near: &[usize],
    target_region: Option<usize>,
    seconds: &impl Fn(Place, Place) -> f64,
    earlier: &[usize],
    params: &Params,
) -> Result<Vec<usize>, Error> {
    let places: Vec<Place> = std::iter::once(Place::Robot)
        .chain(near.iter().map(|&c| Place::Candidate(c)))
        .chain(target_region.map(Place::Region))
        .collect();
    let end = places.len() - 1;
    let costs = FromFn::new(places.len(), |a, b| match (places[a], places[b]) {
        // Nothing leads back to the robot or out of the end: both are fixed.
        (_, Place::Robot) | (Place::Region(_), _) => 0.0,
        (from, to) => seconds(from, to),
    });
    let problem = match target_region {
        Some(_) => Problem::Path { start: 0, end },
        None => Problem::Open { start: 0 },
    };
    let hint: Vec<usize> = earlier
        .iter()
        .filter_map(|c| near.iter().position(|n| n == c).map(|i| i + 1))
        .collect();
    match solver.solve_from(&costs, problem, &hint, params) {
        Ok(solution) => Ok(solution
            .order
            .iter()
            .filter(|&&i| i >= 1 && i <= near.len())
            .map(|&i| near[i - 1])
            .collect()),
        Err(Error::Infeasible | Error::NotFound | Error::Overflow) => {
            let cost = |c: usize| seconds(Place::Robot, Place::Candidate(c));
            let mut order = near.to_vec();
            order.sort_by(|&a, &b| cost(a).total_cmp(&cost(b)).then(a.cmp(&b)));
            Ok(order)
        }
        Err(error) => Err(error),
    }
}
