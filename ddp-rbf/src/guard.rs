//! The last look before a command leaves: can the robot still stop without contact?

use nalgebra::SVector;

/// What the guard must know.
#[derive(Clone, Debug, PartialEq)]
pub struct GuardParams<const NU: usize> {
    /// Largest rate of change of each input when following a command, per second. Infinite for inputs that may jump.
    pub acceleration: SVector<f64, NU>,
    /// How long a command holds, s.
    pub period: f64,
    /// Time between looks along the motion, s.
    pub look: f64,
    /// Clearance that must be kept, in the unit of the clearance function. Looser than the controller's own margin, or the
    /// robot freezes where the controller still steers: with a voxel map of cell h about half to two thirds of h, the
    /// controller keeping h.
    pub margin: f64,
}

/// What became of a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// It may leave as it is.
    Accepted,
    /// It is replaced by the nearest one that keeps the constraints' decrease in bounds.
    Projected,
    /// It may leave at this share of its size.
    Scaled(f64),
    /// It is replaced by braking as hard as allowed.
    Braked,
}

/// Shares of a command that are tried when it may not leave whole.
const SHARES: [f64; 2] = [0.5, 0.25];

/// Looks at the motion that a command starts: `period` seconds towards the command at limited acceleration, then braking to
/// rest. The command may leave if the clearance stays at or above the margin all along, or, where the present state is already
/// below it, does not fall further. Otherwise smaller commands along the same direction are tried, and last braking.
///
/// By induction, a robot that starts at rest and obeys the returned input always has a braking motion that keeps the margin, in
/// a world that does not change.
pub fn guard<const NX: usize, const NU: usize>(
    x: &SVector<f64, NX>,
    now: &SVector<f64, NU>,
    command: &SVector<f64, NU>,
    params: &GuardParams<NU>,
    step: impl Fn(&SVector<f64, NX>, &SVector<f64, NU>, f64) -> SVector<f64, NX>,
    clearance: impl Fn(&SVector<f64, NX>) -> f64,
) -> (SVector<f64, NU>, Verdict) {
    let look = Look::new(x, now, params, &step, &clearance);
    if look.allows(command) {
        return (*command, Verdict::Accepted);
    }
    look.fall_back(command)
}

/// One state from which commands are looked at.
pub(crate) struct Look<'a, S, C, const NX: usize, const NU: usize> {
    x: &'a SVector<f64, NX>,
    now: &'a SVector<f64, NU>,
    params: &'a GuardParams<NU>,
    step: &'a S,
    clearance: &'a C,
    /// Clearance that must be kept from here on.
    least: f64,
    valid: bool,
}

impl<'a, S, C, const NX: usize, const NU: usize> Look<'a, S, C, NX, NU>
where
    S: Fn(&SVector<f64, NX>, &SVector<f64, NU>, f64) -> SVector<f64, NX>,
    C: Fn(&SVector<f64, NX>) -> f64,
{
    pub(crate) fn new(
        x: &'a SVector<f64, NX>,
        now: &'a SVector<f64, NU>,
        params: &'a GuardParams<NU>,
        step: &'a S,
        clearance: &'a C,
    ) -> Self {
        Self {
            x,
            now,
            params,
            step,
            clearance,
            least: params.margin.min(clearance(x) - 1e-9),
            valid: params.look > 0.0
                && params.look.is_finite()
                && params.period.is_finite()
                && params.acceleration.iter().all(|&a| a > 0.0)
                && x.iter().chain(now.iter()).all(|v| v.is_finite()),
        }
    }

    /// Whether a command may leave as it is.
    pub(crate) fn allows(&self, command: &SVector<f64, NU>) -> bool {
        if !(self.valid && command.iter().all(|v| v.is_finite())) {
            return false;
        }
        let params = self.params;
        let change = params.acceleration * params.look;
        let (mut x, mut u, mut t) = (*self.x, *self.now, 0.0);
        loop {
            let target = if t < params.period - 1e-9 {
                *command
            } else {
                SVector::zeros()
            };
            u = towards(&u, &target, &change);
            x = (self.step)(&x, &u, params.look);
            t += params.look;
            // A clearance that is not a number is none.
            let room = (self.clearance)(&x);
            if room.is_nan() || room < self.least {
                return false;
            }
            if t >= params.period - 1e-9 && u.iter().all(|&v| v == 0.0) {
                return true;
            }
        }
    }

    /// Smaller commands along the same direction, else braking.
    pub(crate) fn fall_back(&self, command: &SVector<f64, NU>) -> (SVector<f64, NU>, Verdict) {
        for share in SHARES {
            let scaled = command * share;
            if self.allows(&scaled) {
                return (scaled, Verdict::Scaled(share));
            }
        }
        (SVector::zeros(), Verdict::Braked)
    }
}

/// Moves each input towards its target by at most `change`.
fn towards<const NU: usize>(
    from: &SVector<f64, NU>,
    target: &SVector<f64, NU>,
    change: &SVector<f64, NU>,
) -> SVector<f64, NU> {
    SVector::from_fn(|i, _| from[i] + (target[i] - from[i]).clamp(-change[i], change[i]))
}
