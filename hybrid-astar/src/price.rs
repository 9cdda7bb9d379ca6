//! What a motion costs, in seconds: time, stops, and the wish for room.

use crate::moves::{Motion, Move};
use crate::params::{Params, rest_to_rest};
use crate::raster::Pricing;
use crate::{Limits, Map};

#[derive(Clone, Debug)]
pub(crate) struct Price {
    pub(crate) limits: Limits,
    reverse_factor: f64,
    turn_weight: f64,
    pub(crate) pricing: Pricing,
}

impl Price {
    pub(crate) fn new(params: &Params, pricing: Pricing) -> Self {
        Self {
            limits: params.limits,
            reverse_factor: params.reverse_factor,
            turn_weight: params.turn_weight,
            pricing,
        }
    }

    /// Time at full speed, without starting or stopping, s.
    fn cruise(&self, m: &Move) -> f64 {
        match m.motion {
            Motion::Turn => m.amount.abs() / self.limits.w,
            _ => (m.amount / self.limits.v).max(m.heading_change().abs() / self.limits.w),
        }
    }

    /// What is added to the time of a run: reversing and curving.
    fn extra(&self, m: &Move) -> f64 {
        let bend = self.turn_weight * m.heading_change().abs() / self.limits.w;
        let back = if m.motion == Motion::Reverse {
            (self.reverse_factor - 1.0) * self.cruise(m)
        } else {
            0.0
        };
        bend + back
    }

    /// Price of a move that goes on in a run, without clearance, s.
    pub(crate) fn steady(&self, m: &Move) -> f64 {
        self.cruise(m) + self.extra(m)
    }

    /// Price of beginning a run of this motion after one of another, s.
    pub(crate) fn begin(&self, motion: Motion) -> f64 {
        if motion == Motion::Turn {
            self.limits.turn_stop()
        } else {
            self.limits.drive_stop()
        }
    }

    /// Price of the share of a move that is driven in violation of the margin, s: as much as a way four times as long,
    /// so that the start's violation is left soon.
    pub(crate) fn trouble(&self, m: &Move, share: f64) -> f64 {
        if share > 0.0 {
            3.0 * share * self.steady(m)
        } else {
            0.0
        }
    }

    /// Price of a list of moves after a motion (`None`: any start counts), without clearance; each run is charged
    /// its true trapezoid.
    pub(crate) fn way<'a>(
        &self,
        before: Option<Motion>,
        moves: impl IntoIterator<Item = &'a Move>,
    ) -> f64 {
        let mut total = 0.0;
        let mut run: Option<(Motion, f64, bool)> = None;
        let close = |run: Option<(Motion, f64, bool)>| match run {
            Some((motion, extent, true)) => self.run_overhead(motion, extent),
            _ => 0.0,
        };
        let mut last = before.map(|m| (m, 0.0, false));
        for m in moves {
            total += self.steady(m);
            match &mut last {
                Some((motion, extent, _)) if *motion == m.motion => *extent += m.extent(),
                _ => {
                    total += close(last);
                    last = Some((m.motion, m.extent(), true));
                }
            }
            run = last;
        }
        total + close(run)
    }

    /// Seconds a rest-to-rest run of this extent takes longer than at full speed.
    fn run_overhead(&self, motion: Motion, extent: f64) -> f64 {
        let l = &self.limits;
        let (v, a) = if motion == Motion::Turn {
            (l.w, l.alpha)
        } else {
            (l.v, l.a)
        };
        rest_to_rest(extent, v, a) - extent / v
    }

    /// Price of closeness along a move, s.
    pub(crate) fn closeness<M: Map>(&self, map: &M, from: [f64; 3], m: &Move) -> f64 {
        if self.pricing.weight <= 0.0 || m.motion == Motion::Turn {
            return 0.0;
        }
        let n = (m.amount / 0.2).ceil().max(1.0);
        let mut sum = 0.0;
        for i in 0..n as usize {
            let p = m.pose_at(from, m.amount * (i as f64 + 0.5) / n);
            let c = map.clearance([p[0], p[1]]);
            sum += self
                .pricing
                .proximity(if c.is_nan() { f64::NEG_INFINITY } else { c });
        }
        sum / n * self.cruise(m)
    }
}
