//! What view planning must know about a robot, and what moving costs.

use crate::Pose;

/// What view planning must know about a robot that carries a camera on a moving base.
///
/// Laws: [`reach`](Self::reach) gives a state without self-collision whose camera stands at the
/// pose asked for; [`is_free`](Self::is_free) implies [`base_is_free`](Self::base_is_free); both
/// depend only on the map within [`Params::body_reach`](crate::Params::body_reach) of the base.
pub trait Robot {
    /// Everything but the base: the joints of the arm, say.
    type State: Clone;
    /// A state that brings the camera to `base_from_camera`, by inverse kinematics; none if out
    /// of reach. Called once per view and robot, not while planning.
    fn reach(&self, base_from_camera: &Pose) -> Option<Self::State>;
    /// A state with which the whole body is clear and the camera stands at `world_from_camera`, with the base at x, y, yaw (m,
    /// rad); of several the one soonest taken up from `near`. Robots with more than one solution override this.
    fn take_up(
        &self,
        base: [f64; 3],
        world_from_camera: &Pose,
        _near: &Self::State,
    ) -> Option<Self::State> {
        let state = self.reach(&world_from_camera.seen_from(base))?;
        self.is_free(base, &state).then_some(state)
    }
    /// True if the whole body is clear of the map with the base at x, y, yaw (m, rad).
    fn is_free(&self, base: [f64; 3], state: &Self::State) -> bool;
    /// [`is_free`](Self::is_free) of a base pose that [`base_is_free`](Self::base_is_free) has accepted. Robots that need not
    /// look at the base again override this: it is asked for every posture of a base.
    fn is_free_on_base(&self, base: [f64; 3], state: &Self::State) -> bool {
        self.is_free(base, state)
    }
    /// True if the base alone is clear: the cheap test made first.
    fn base_is_free(&self, base: [f64; 3]) -> bool;
}

impl<R: Robot + ?Sized> Robot for &R {
    type State = R::State;
    fn reach(&self, base_from_camera: &Pose) -> Option<Self::State> {
        (**self).reach(base_from_camera)
    }
    fn take_up(
        &self,
        base: [f64; 3],
        world_from_camera: &Pose,
        near: &Self::State,
    ) -> Option<Self::State> {
        (**self).take_up(base, world_from_camera, near)
    }
    fn is_free(&self, base: [f64; 3], state: &Self::State) -> bool {
        (**self).is_free(base, state)
    }
    fn is_free_on_base(&self, base: [f64; 3], state: &Self::State) -> bool {
        (**self).is_free_on_base(base, state)
    }
    fn base_is_free(&self, base: [f64; 3]) -> bool {
        (**self).base_is_free(base)
    }
}

/// Time to move between two whole-body states.
pub trait CostModel<S> {
    /// Seconds from one base pose and state to another; not negative. Infinite (or NaN) means
    /// "never": such a view is not offered, which is also how a caller excludes a goal for a while.
    fn seconds(&self, from: (&[f64; 3], &S), to: (&[f64; 3], &S)) -> f64;
}

impl<S, C: CostModel<S> + ?Sized> CostModel<S> for &C {
    fn seconds(&self, from: (&[f64; 3], &S), to: (&[f64; 3], &S)) -> f64 {
        (**self).seconds(from, to)
    }
}

/// HEATS eq. 2: the longer of the straight base distance at top speed and the slowest joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Straight<const N: usize> {
    /// Top speed of the base, m/s.
    pub base_speed: f64,
    /// Top speed of each joint, rad/s (or m/s).
    pub joint_speed: [f64; N],
}

impl<const N: usize> CostModel<[f64; N]> for Straight<N> {
    fn seconds(&self, from: (&[f64; 3], &[f64; N]), to: (&[f64; 3], &[f64; N])) -> f64 {
        let (dx, dy) = (to.0[0] - from.0[0], to.0[1] - from.0[1]);
        let mut t = (dx * dx + dy * dy).sqrt() / self.base_speed;
        for j in 0..N {
            t = t.max((to.1[j] - from.1[j]).abs() / self.joint_speed[j]);
        }
        t
    }
}
