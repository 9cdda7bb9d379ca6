//! The safety layer: every command is looked at, if need be projected, and what happened is counted.

use crate::constraint::Constraint;
use crate::error::{Error, positive};
use crate::guard::{GuardParams, Look, Verdict};
use crate::robot::Robot;
use nalgebra::SVector;

/// Limits of the safety layer.
#[derive(Clone, Debug, PartialEq)]
pub struct SafetyParams<const NU: usize> {
    /// How the motion is looked at.
    pub guard: GuardParams<NU>,
    /// Lower limits of the inputs.
    pub low: SVector<f64, NU>,
    /// Upper limits of the inputs.
    pub high: SVector<f64, NU>,
    /// Share of a constraint's room that a projected command may use up per second, 1/s.
    pub decrease: f64,
}

/// What became of all commands so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Left as they were.
    pub accepted: usize,
    /// Replaced by the nearest that keeps the constraints' decrease in bounds.
    pub projected: usize,
    /// Made smaller.
    pub scaled: usize,
    /// Replaced by braking.
    pub braked: usize,
    /// Of all, those whose inputs had to be clamped to their limits.
    pub clamped: usize,
}

/// Why the robot braked, from the last command on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Braking {
    /// Group of the constraint with the least room.
    pub group: &'static str,
    /// Its room, in the unit of the group.
    pub room: f64,
}

/// Looks at every command before it leaves.
///
/// A command is clamped to the limits of the inputs. It may leave if the motion that it starts, up to standing still, keeps
/// the margin; otherwise it is projected (with the feature `clarabel`) onto the commands that keep
/// `h(x + dx) >= (1 - decrease * period) h(x)` for every hard constraint h, then made smaller; and if nothing helps the
/// robot brakes at full deceleration. Whatever leaves has passed the look or is braking.
#[derive(Clone, Debug)]
pub struct SafetyLayer<const NX: usize, const NU: usize> {
    params: SafetyParams<NU>,
    counts: Counts,
    braking: Option<Braking>,
    #[cfg(feature = "clarabel")]
    rows: Vec<crate::projection::Row<NU>>,
}

impl<const NX: usize, const NU: usize> SafetyLayer<NX, NU> {
    /// A layer that has seen no command.
    ///
    /// # Errors
    /// [`Error::Param`] for a time, acceleration or decrease that is not positive, a margin that is not finite, or limits
    /// that leave no input.
    pub fn new(params: SafetyParams<NU>) -> Result<Self, Error> {
        positive("look", params.guard.look)?;
        positive("period", params.guard.period)?;
        positive("decrease", params.decrease)?;
        if !params.guard.margin.is_finite() {
            return Err(Error::Param {
                field: "margin",
                value: params.guard.margin,
            });
        }
        if let Some(&value) = params
            .guard
            .acceleration
            .iter()
            .find(|&&a| a.is_nan() || a <= 0.0)
        {
            return Err(Error::Param {
                field: "acceleration",
                value,
            });
        }
        for i in 0..NU {
            positive(
                "room between the limits of an input",
                params.high[i] - params.low[i],
            )?;
        }
        Ok(Self {
            params,
            counts: Counts::default(),
            braking: None,
            #[cfg(feature = "clarabel")]
            rows: Vec::new(),
        })
    }

    /// What became of all commands so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Why the last command was replaced by braking; `None` if it was not.
    pub fn braking(&self) -> Option<Braking> {
        self.braking
    }

    /// Its parameters.
    pub fn params(&self) -> &SafetyParams<NU> {
        &self.params
    }

    /// The input that may leave for a wanted `command`, from state `x` with the present input `now`. `clearance` is the
    /// room of a state as the margin counts it; `hard` are the constraints that a projection keeps, with their margins in
    /// them.
    pub fn check(
        &mut self,
        robot: &impl Robot<NX, NU>,
        x: &SVector<f64, NX>,
        now: &SVector<f64, NU>,
        command: &SVector<f64, NU>,
        hard: &[&dyn Constraint<NX, NU>],
        clearance: impl Fn(&SVector<f64, NX>) -> f64,
    ) -> (SVector<f64, NU>, Verdict) {
        let params = self.params.clone();
        let wanted = SVector::from_fn(|i, _| {
            if command[i].is_finite() {
                command[i].clamp(params.low[i], params.high[i])
            } else {
                command[i]
            }
        });
        self.counts.clamped +=
            usize::from(wanted != *command && command.iter().all(|v| v.is_finite()));
        let step = |x: &SVector<f64, NX>, u: &SVector<f64, NU>, dt: f64| robot.step(x, u, dt);
        let look = Look::new(x, now, &params.guard, &step, &clearance);
        let (u, verdict) = if look.allows(&wanted) {
            (wanted, Verdict::Accepted)
        } else {
            let projected = self.project(robot, x, now, &wanted, hard);
            match projected {
                Some(u) if look.allows(&u) => (u, Verdict::Projected),
                _ => look.fall_back(&wanted),
            }
        };
        self.braking = None;
        match verdict {
            Verdict::Accepted => self.counts.accepted += 1,
            Verdict::Projected => self.counts.projected += 1,
            Verdict::Scaled(_) => self.counts.scaled += 1,
            Verdict::Braked => {
                self.counts.braked += 1;
                self.braking = Some(tightest(x, hard, clearance(x)));
            }
        }
        (u, verdict)
    }

    #[cfg(feature = "clarabel")]
    fn project(
        &mut self,
        robot: &impl Robot<NX, NU>,
        x: &SVector<f64, NX>,
        now: &SVector<f64, NU>,
        command: &SVector<f64, NU>,
        hard: &[&dyn Constraint<NX, NU>],
    ) -> Option<SVector<f64, NU>> {
        let params = &self.params;
        crate::projection::rows(robot, x, command, params, hard, &mut self.rows);
        // Only what one period of limited acceleration reaches.
        let reach = params.guard.acceleration * params.guard.period;
        let low = SVector::from_fn(|i, _| params.low[i].max(now[i] - reach[i]));
        let high = SVector::from_fn(|i, _| params.high[i].min(now[i] + reach[i]));
        crate::projection::project(command, &self.rows, &low, &high)
    }

    #[cfg(not(feature = "clarabel"))]
    fn project(
        &mut self,
        _: &impl Robot<NX, NU>,
        _: &SVector<f64, NX>,
        _: &SVector<f64, NU>,
        _: &SVector<f64, NU>,
        _: &[&dyn Constraint<NX, NU>],
    ) -> Option<SVector<f64, NU>> {
        None
    }
}

/// The hard constraint with the least room at a state.
fn tightest<const NX: usize, const NU: usize>(
    x: &SVector<f64, NX>,
    hard: &[&dyn Constraint<NX, NU>],
    clearance: f64,
) -> Braking {
    let mut out = Braking {
        group: "clearance",
        room: clearance,
    };
    let mut least = f64::INFINITY;
    for group in hard {
        group.values(1, x, None, &mut |z| {
            if z < least {
                least = z;
                out = Braking {
                    group: group.name(),
                    room: z,
                };
            }
        });
    }
    out
}
