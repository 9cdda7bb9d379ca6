//! What is left to the goal from a pose: the wave's distance and the turns it will take.

use crate::Map;
use crate::moves::wrap;
use crate::raster::{Lazy, Raster};
use crate::search::Task;
use crate::wave::Wave;
use std::f64::consts::PI;

/// Cells of the wave's way that give its direction.
const AHEAD: usize = 4;
/// Share of a turn in place that a wrong heading is thought to cost: the rest is turned while driving.
const TURNING: f64 = 0.5;
/// Nearer to the goal than this many cells the wave's direction says little.
const CLOSE: f64 = 5.0;

/// Estimates, with the wave's direction kept for every cell that was asked about.
pub(crate) struct Outlook<'a, M> {
    task: &'a Task<'a, M>,
    /// Direction of the wave's way to the goal, rad; NaN if not asked yet, infinite if there is none.
    direction: Vec<f32>,
}

impl<'a, M: Map> Outlook<'a, M> {
    pub(crate) fn new(task: &'a Task<'a, M>, raster: &Raster) -> Self {
        Self {
            task,
            direction: vec![f32::NAN; raster.cells()],
        }
    }

    /// Seconds to the goal from a pose: with the turns it will probably take, and without.
    pub(crate) fn seconds(
        &mut self,
        p: [f64; 3],
        missing: f64,
        raster: &mut Raster,
        wave: &mut Wave,
    ) -> (f64, f64) {
        let Some(at) = raster.index([p[0], p[1]]) else {
            return (f64::INFINITY, f64::INFINITY);
        };
        let task = self.task;
        let (map, limits) = (task.map, &task.price.limits);
        let pace = 1.0 / limits.v;
        let mut d = f64::from(wave.settle(&mut Lazy { raster, map }, at));
        if d.is_infinite() && missing > 0.0 {
            // Where the robot is too close to an obstacle the wave may not come: take the nearest cell it reaches.
            for (at, gap) in raster.within([p[0], p[1]], missing + 3.0 * raster.cell) {
                d = d.min(f64::from(wave.settle(&mut Lazy { raster, map }, at)) + gap);
            }
        }
        let low = d * pace;
        if !low.is_finite() {
            return (low, low);
        }
        let last = (task.yaw.nearest(p[2]) - p[2]).abs() / limits.w;
        let mut h = low;
        // Off the wave's cells its neighbours need not be settled yet, so that they say nothing certain.
        if d > CLOSE * raster.cell && wave.distance(at).is_finite() {
            if self.direction[at].is_nan() {
                self.direction[at] = look_ahead(raster, wave, at);
            }
            let off = wrap(f64::from(self.direction[at]) - p[2]).abs();
            if off.is_finite() {
                let back = (task.params.reverse_factor - 1.0) * pace + (PI - off) / limits.w;
                h += TURNING * (off / limits.w).min(back);
            }
        }
        (h.max(last), low)
    }
}

/// Direction from a cell to the one a few steps further on the wave's way.
fn look_ahead(raster: &Raster, wave: &Wave, at: usize) -> f32 {
    let to = wave.ahead(raster, at, AHEAD);
    if to == at {
        return f32::INFINITY;
    }
    let (a, b) = (raster.center(at), raster.center(to));
    (b[1] - a[1]).atan2(b[0] - a[0]) as f32
}
