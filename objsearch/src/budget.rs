//! How much work a planner may do.

/// A planner's budget: a number of steps, and optionally a deadline that the caller watches.
///
/// A step is one look at one cell class, a few nanoseconds; steps make plans repeatable, a deadline does not.
pub struct Budget<'a> {
    steps: u64,
    spent: u64,
    next_poll: u64,
    over: bool,
    deadline: Option<Box<dyn FnMut() -> bool + 'a>>,
}

/// Steps between two questions to the deadline: about 0.1 ms.
const POLL: u64 = 20_000;

impl std::fmt::Debug for Budget<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Budget")
            .field("steps", &self.steps)
            .field("spent", &self.spent)
            .field("deadline", &self.deadline.is_some())
            .finish()
    }
}

impl<'a> Budget<'a> {
    /// At most `steps` steps, within the granularity of one neighbourhood or node.
    pub fn steps(steps: u64) -> Self {
        Self {
            steps,
            spent: 0,
            next_poll: 0,
            over: false,
            deadline: None,
        }
    }

    /// No limit.
    pub fn unlimited() -> Self {
        Self::steps(u64::MAX)
    }

    /// Ends also when `passed` says so; it is asked every 20 000 steps and, once it said so, no more.
    #[must_use]
    pub fn until(self, passed: impl FnMut() -> bool + 'a) -> Self {
        Self {
            deadline: Some(Box::new(passed)),
            ..self
        }
    }

    /// Steps done.
    pub fn spent(&self) -> u64 {
        self.spent
    }

    /// True once the steps are used up or the deadline has passed.
    pub fn is_over(&mut self) -> bool {
        if !self.over {
            self.over = self.spent >= self.steps;
        }
        if !self.over && self.spent >= self.next_poll {
            self.next_poll = self.spent + POLL;
            if let Some(passed) = &mut self.deadline {
                self.over = passed();
            }
        }
        self.over
    }

    pub(crate) fn spend(&mut self, steps: usize) {
        self.spent = self.spent.saturating_add(steps as u64);
    }

    pub(crate) fn left(&self) -> u64 {
        if self.over {
            0
        } else {
            self.steps.saturating_sub(self.spent)
        }
    }

    /// Share of the steps used, 0 to 1; stays near 0 when only a deadline limits.
    pub(crate) fn share(&self) -> f64 {
        (self.spent as f64 / self.steps as f64).min(1.0)
    }
}
