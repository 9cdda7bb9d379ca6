//! What a plan is.

use crate::Error;
use crate::params::Limits;
use crate::time::{TimedPath, profile};
use crate::trace::Segment;
use std::fmt;

/// How planning ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Status {
    /// A path from the start to the goal.
    Solved,
    /// The start is in collision by more than the tolerance, or outside the map.
    StartBlocked,
    /// No free pose with an allowed heading within the goal's tolerance.
    GoalBlocked,
    /// Not even the disc inside the footprint can pass. Proved by the grid wave.
    Disconnected,
    /// The disc can pass, but the footprint cannot, however it is turned. Proved by a search over boxes of poses.
    NoPassage,
    /// The footprint does not pass, at the lattice's resolution.
    Exhausted,
    /// The expansion budget ran out.
    BudgetExhausted,
    /// The caller's stop function ended the search.
    Stopped,
}

/// Why there is no path, with the numbers.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Reason {
    /// See [`Status::StartBlocked`].
    StartBlocked {
        /// The start, world frame.
        pose: [f64; 3],
        /// Clearance at the turning centre, m.
        clearance: f64,
        /// How much the footprint and margin lack, m; infinite if the turning centre itself is inside an obstacle.
        missing: f64,
        /// The tolerance, m.
        tolerance: f64,
        /// Place of the footprint nearest to an obstacle or deepest in it, world frame, m.
        at: [f64; 2],
    },
    /// The start or the goal is not on the map: [`Status::StartBlocked`] or [`Status::GoalBlocked`].
    Outside {
        /// "start" or "goal".
        what: &'static str,
        /// The point, world frame, m.
        point: [f64; 2],
        /// Lower corner of the map, m.
        low: [f64; 2],
        /// Upper corner of the map, m.
        high: [f64; 2],
    },
    /// See [`Status::GoalBlocked`].
    GoalBlocked {
        /// The goal, world frame, m.
        goal: [f64; 2],
        /// Clearance there, m.
        clearance: f64,
        /// Least clearance any heading needs, m.
        needs: f64,
        /// The tolerance, m.
        tolerance: f64,
        /// The allowed heading that fits best, rad.
        yaw: f64,
        /// Place of the footprint, so turned, nearest to an obstacle or deepest in it, world frame, m.
        at: [f64; 2],
    },
    /// See [`Status::Disconnected`].
    Disconnected {
        /// Radius of the disc, margin included, m.
        radius: f64,
    },
    /// See [`Status::NoPassage`].
    NoPassage {
        /// Where the disc's shortest way leaves what the footprint can reach from the start, world frame, m.
        at: [f64; 2],
        /// Clearance there, m.
        clearance: f64,
        /// Radius of the disc inside the footprint, margin included: the clearance that would be needed at least, m.
        radius: f64,
        /// Radius of the disc around the footprint, margin included: the clearance that would always do, m.
        need: f64,
    },
    /// See [`Status::Exhausted`], [`Status::BudgetExhausted`] and [`Status::Stopped`].
    NotReached {
        /// The reached pose with the least way left.
        nearest: [f64; 3],
        /// Expanded nodes.
        expansions: usize,
        /// True if every reachable lattice state was tried.
        exhausted: bool,
        /// First place on the shortest way from there for the inscribed disc where the footprint fits with no heading
        /// at all, world frame, m.
        gap: Option<[f64; 2]>,
    },
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StartBlocked {
                pose: [x, y, yaw],
                clearance,
                missing,
                tolerance,
                at,
            } => {
                write!(
                    f,
                    "start footprint at ({x:.2}, {y:.2}, {yaw:.2} rad) overlaps "
                )?;
                write!(f, "an obstacle at ({:.2}, {:.2}): ", at[0], at[1])?;
                if missing.is_finite() {
                    write!(f, "it lacks {missing:.3} m of room")?;
                } else {
                    write!(f, "its centre is inside")?;
                }
                write!(
                    f,
                    " (clearance of its centre {clearance:.3} m, tolerance {tolerance:.3} m)"
                )
            }
            Self::Outside {
                what,
                point,
                low,
                high,
            } => write!(
                f,
                "{what} ({:.2}, {:.2}) lies outside the map, which spans ({:.2}, {:.2}) to ({:.2}, {:.2})",
                point[0], point[1], low[0], low[1], high[0], high[1]
            ),
            Self::GoalBlocked {
                goal,
                clearance,
                needs,
                tolerance,
                yaw,
                at,
            } => write!(
                f,
                "goal footprint at ({:.2}, {:.2}) overlaps an obstacle at ({:.2}, {:.2}) even with the best allowed heading, {yaw:.2} rad (clearance {clearance:.3} m, needs at least {needs:.3} m), and no pose within {tolerance:.2} m of it is free",
                goal[0], goal[1], at[0], at[1]
            ),
            Self::Disconnected { radius } => {
                write!(
                    f,
                    "no connection from start to goal for a disc of {radius:.3} m, the largest inside the footprint"
                )
            }
            Self::NoPassage {
                at: [x, y],
                clearance,
                radius,
                need,
            } => write!(
                f,
                "a connection exists for the inscribed disc, but the footprint does not fit through at ({x:.2}, {y:.2}) with any heading (clearance {clearance:.3} m, its discs inside and around have {radius:.3} m and {need:.3} m)"
            ),
            Self::NotReached {
                nearest: [x, y, yaw],
                expansions,
                exhausted,
                gap,
            } => {
                let how = if *exhausted {
                    "the footprint does not fit further than"
                } else {
                    "the search was cut off near"
                };
                write!(
                    f,
                    "a connection exists for the inscribed disc, but {how} ({x:.2}, {y:.2}, {yaw:.2} rad) after {expansions} expansions"
                )?;
                match gap {
                    Some([x, y]) => {
                        write!(
                            f,
                            "; it fits with no heading at ({x:.2}, {y:.2}) on the way"
                        )
                    }
                    None => Ok(()),
                }
            }
        }
    }
}

/// The outcome of [`plan`](crate::plan).
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// How it ended; anything but `Solved` has no segments.
    pub status: Status,
    /// The path, split at every stop. Empty if there is none, or if the start is the goal.
    pub segments: Vec<Segment>,
    /// Metres driven.
    pub length: f64,
    /// Seconds from rest to rest with the limits planned with; infinite without a path.
    pub seconds: f64,
    /// Price of the path, s: with the extra charges for reverse, curves and closeness. Infinite without a path.
    pub cost: f64,
    /// Expanded lattice nodes.
    pub expansions: usize,
    /// How much room the start lacked, m; 0 for a free start.
    pub start_violation: f64,
    /// Where the path ends (the start if there is none).
    pub end: [f64; 3],
    /// Distance from the goal asked for to the one reached, m; more than 0 only if that was blocked.
    pub goal_shift: f64,
    /// Why there is no path.
    pub reason: Option<Reason>,
}

impl Plan {
    pub(crate) fn failed(
        status: Status,
        start: [f64; 3],
        expansions: usize,
        reason: Reason,
    ) -> Self {
        Self {
            status,
            segments: Vec::new(),
            length: 0.0,
            seconds: f64::INFINITY,
            cost: f64::INFINITY,
            expansions,
            start_violation: 0.0,
            end: start,
            goal_shift: 0.0,
            reason: Some(reason),
        }
    }

    /// Whether there is a path.
    pub fn is_solved(&self) -> bool {
        self.status == Status::Solved
    }

    /// All poses in order, without doubles at the borders of segments.
    pub fn poses(&self) -> Vec<[f64; 3]> {
        let mut out: Vec<[f64; 3]> = Vec::new();
        for s in &self.segments {
            let skip = usize::from(!out.is_empty());
            out.extend(s.poses.iter().skip(skip));
        }
        if out.is_empty() && self.is_solved() {
            out.push(self.end);
        }
        out
    }

    /// Poses at equal times `dt` s, from rest to rest, stopping wherever the motion changes.
    ///
    /// Speed, turning rate and acceleration stay within the limits; the whole is slowed by less than `dt` so that it
    /// ends on a sample. Without a path the result is empty.
    pub fn time(&self, limits: &Limits, dt: f64) -> Result<TimedPath, Error> {
        self.time_from(limits, dt, 0.0)
    }

    /// Like [`time`](Self::time), for a base that already drives at `speed` m/s (negative backwards). If the path
    /// does not begin in that direction, or the limits do not allow the speed, it begins with what they allow.
    pub fn time_from(&self, limits: &Limits, dt: f64, speed: f64) -> Result<TimedPath, Error> {
        let mut timed = profile(&self.segments, limits, dt, speed)?;
        if timed.poses.is_empty() && self.is_solved() {
            timed.poses.push(self.end);
            timed.v.push(0.0);
            timed.w.push(0.0);
        }
        Ok(timed)
    }
}
