//! The last look before a command leaves: can the robot still stop without contact?

use nalgebra::SVector;

/// What the guard must know.
#[derive(Clone, Debug, PartialEq)]
pub struct GuardParams<const NU: usize> {
    /// Largest rate of change of each input when following a command, per second.
    pub acceleration: SVector<f64, NU>,
    /// How long a command holds, s.
    pub period: f64,
    /// Time between looks along the motion, s.
    pub look: f64,
    /// Clearance that must be kept, in the unit of the clearance function. Looser than the controller's own margin, or the
    /// robot freezes where the controller still steers.
    pub margin: f64,
}

/// What became of a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// It may leave as it is.
    Accepted,
    /// It may leave at this share of its size.
    Scaled(f64),
    /// It is replaced by braking as hard as allowed.
    Braked,
}

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
    let here = clearance(x);
    let least = params.margin.min(here - 1e-9);
    let is_safe = |command: &SVector<f64, NU>| {
        let (mut x, mut u, mut t) = (*x, *now, 0.0);
        loop {
            let target = if t < params.period - 1e-9 {
                *command
            } else {
                SVector::zeros()
            };
            u = towards(&u, &target, &(params.acceleration * params.look));
            x = step(&x, &u, params.look);
            t += params.look;
            if clearance(&x) < least {
                return false;
            }
            if t >= params.period - 1e-9 && u.iter().all(|&v| v == 0.0) {
                return true;
            }
        }
    };
    let valid = command.iter().all(|v| v.is_finite())
        && params.look > 0.0
        && params.acceleration.iter().all(|&a| a > 0.0);
    if valid {
        for share in [1.0, 0.5, 0.25] {
            let scaled = command * share;
            if is_safe(&scaled) {
                let verdict = if share == 1.0 {
                    Verdict::Accepted
                } else {
                    Verdict::Scaled(share)
                };
                return (scaled, verdict);
            }
        }
    }
    (SVector::zeros(), Verdict::Braked)
}

/// Moves each input towards its target by at most `change`.
fn towards<const NU: usize>(
    from: &SVector<f64, NU>,
    target: &SVector<f64, NU>,
    change: &SVector<f64, NU>,
) -> SVector<f64, NU> {
    SVector::from_fn(|i, _| from[i] + (target[i] - from[i]).clamp(-change[i], change[i]))
}
