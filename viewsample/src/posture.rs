//! The arm states of the library, solved once per robot.

use crate::{Error, Params, Pose, Robot};

/// One arm state of the library: a camera attitude the robot can hold wherever its base stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Posture<S> {
    /// Index into [`Params::views`].
    pub view: usize,
    /// base_from_camera.
    pub camera: Pose,
    /// Everything but the base.
    pub state: S,
}

/// Solves each view of [`Params::views`] by inverse kinematics in the base frame, so that none
/// is needed while planning.
///
/// The camera looks straight ahead of the base, without roll. For each view the heights of
/// [`Params::height_slack`] are tried in order, for each height the distances of
/// [`Params::ahead`]; the first within reach is taken. A view out of reach is left out.
///
/// # Errors
/// If a parameter is bad, or no view is within reach.
pub fn postures<R: Robot + ?Sized>(
    robot: &R,
    params: &Params,
) -> Result<Vec<Posture<R::State>>, Error> {
    params.validate()?;
    let mut found = Vec::new();
    for (index, view) in params.views.iter().enumerate() {
        let tries = params
            .height_slack
            .iter()
            .flat_map(|dz| params.ahead.iter().map(move |x| (x, dz)));
        let posture = tries.into_iter().find_map(|(x, dz)| {
            let camera = Pose::looking([*x, 0.0, view.height + dz], 0.0, view.pitch);
            let state = robot.reach(&camera)?;
            Some(Posture {
                view: index,
                camera,
                state,
            })
        });
        found.extend(posture);
    }
    if found.is_empty() {
        Err(Error::NoPosture(params.views.len()))
    } else {
        Ok(found)
    }
}
