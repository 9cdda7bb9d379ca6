//! The caller's wish to stop, remembered, and put off only while there is no order that can be driven.

use crate::problem::Watch;

/// Steps between two questions: ten to twenty microseconds.
const BETWEEN: usize = 8192;

pub(crate) struct Pace<'a> {
    watch: &'a mut dyn Watch,
    stopped: bool,
    /// An order without forbidden arcs is known.
    has_order: bool,
    /// Steps of work since the caller was last asked.
    work: usize,
    /// Subtracted from the costs that are reported.
    pub(crate) raised: f64,
}

impl<'a> Pace<'a> {
    pub(crate) fn new(watch: &'a mut dyn Watch) -> Self {
        Self {
            watch,
            stopped: false,
            has_order: false,
            work: 0,
            raised: 0.0,
        }
    }

    /// The caller has said stop.
    pub(crate) fn is_late(&mut self) -> bool {
        self.stopped = self.stopped || self.watch.stop();
        self.stopped
    }

    /// [`stop`](Self::stop), asked once in so many steps of about a nanosecond each.
    #[inline]
    pub(crate) fn spend(&mut self, steps: usize) -> bool {
        self.work += steps;
        if self.work < BETWEEN {
            return self.is_stopped();
        }
        self.work = 0;
        self.stop()
    }

    /// To stop now: the caller said so and there is an order to hand back.
    pub(crate) fn stop(&mut self) -> bool {
        self.has_order && self.is_late()
    }

    /// [`stop`](Self::stop) has answered yes.
    pub(crate) fn is_stopped(&self) -> bool {
        self.has_order && self.stopped
    }

    /// A better order without forbidden arcs was found.
    pub(crate) fn improved(&mut self, cost: f64) {
        self.has_order = true;
        self.watch.improved(cost - self.raised);
    }
}
