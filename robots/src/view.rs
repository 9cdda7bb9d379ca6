//! Whole-body inverse kinematics of the camera, and compensation of a base that came to stand differently.

use crate::error::Error;
use crate::frame::Frame;
use crate::ik::{IkSolutions, Singular, wrap};
use crate::manipulator::{BodyState, MobileManipulator};
use nalgebra::Isometry3;

/// A joint vector that holds the camera where it was asked for, inside the limits and free of self-collision.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraSolution {
    /// Joint angles, rad, in the copy nearest to the seed.
    pub joints: [f64; 6],
    /// Time of the slowest joint from the seed at full speed, s.
    pub seconds: f64,
    /// Self-clearance, m.
    pub clearance: f64,
    /// |det J| of the arm, m^3.
    pub manipulability: f64,
    /// Branch number of the closed form.
    pub branch: u8,
    /// Singular sets near this solution.
    pub singular: Singular,
}

/// Up to eight [`CameraSolution`]s, the quickest to reach from the seed first; ties in the order of branches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraSolutions {
    all: [CameraSolution; 8],
    len: usize,
}

impl CameraSolutions {
    /// The solutions, quickest first.
    #[must_use]
    pub fn as_slice(&self) -> &[CameraSolution] {
        &self.all[..self.len]
    }
    /// The quickest solution.
    #[must_use]
    pub fn best(&self) -> Option<&CameraSolution> {
        self.as_slice().first()
    }
}

/// Joints for a base that stands elsewhere than planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compensation {
    /// Joint angles, rad.
    pub joints: [f64; 6],
    /// Distance of the camera from where it should be, m.
    pub position_error: f64,
    /// Angle between the camera's attitude and the wanted one, rad.
    pub angle_error: f64,
    /// Self-clearance of `joints`, m; negative means that they must not be used.
    pub clearance: f64,
    /// True if inverse kinematics reached the pose; false if only the shoulder pan was turned.
    pub exact: bool,
}

/// Least self-clearance (m) of the solutions offered.
pub const SELF_MARGIN: f64 = 0.005;

impl MobileManipulator {
    /// All joint vectors that bring the camera to `world_from_camera` with the base at `base`, inside the joint
    /// limits and with a self-clearance of at least [`SELF_MARGIN`], the quickest from `seed` first.
    ///
    /// Whole turns are added per joint to come nearest to the seed. Empty if the pose is out of reach or a number
    /// is not finite.
    #[must_use]
    pub fn ik_camera(
        &self,
        base: [f64; 3],
        world_from_camera: &Isometry3<f64>,
        seed: &[f64; 6],
    ) -> CameraSolutions {
        self.ik_camera_frame(base, &Frame::from(world_from_camera), seed)
    }

    /// [`ik_camera`](Self::ik_camera) with the pose as plain arrays.
    #[must_use]
    pub fn ik_camera_frame(
        &self,
        base: [f64; 3],
        world_from_camera: &Frame,
        seed: &[f64; 6],
    ) -> CameraSolutions {
        let mut out = CameraSolutions::default();
        if seed.iter().any(|q| !q.is_finite()) {
            return out;
        }
        let camera_from_flange = Frame::from(&self.camera.flange_from_camera).inverse();
        let target = self
            .arm_root(base)
            .inverse()
            .then(world_from_camera)
            .then(&camera_from_flange);
        let mut raw = IkSolutions::default();
        self.arm.ik_near(&target, seed[5], &mut raw);
        for s in raw.as_slice() {
            let Some(joints) = self.arm.nearest_copy(&s.joints, seed) else {
                continue;
            };
            if !self.self_is_free(&joints, SELF_MARGIN) {
                continue;
            }
            let solution = CameraSolution {
                joints,
                seconds: self.arm_seconds(seed, &joints),
                clearance: self.self_clearance(&joints),
                manipulability: self.arm.manipulability(&joints),
                branch: s.branch,
                singular: s.singular,
            };
            // Insertion sort: stable, at most eight.
            let mut at = out.len;
            while at > 0 && out.all[at - 1].seconds > solution.seconds {
                out.all[at] = out.all[at - 1];
                at -= 1;
            }
            out.all[at] = solution;
            out.len += 1;
        }
        out
    }

    /// Joints that keep the camera where `goal` wanted it although the base stands at `base`.
    ///
    /// Inverse kinematics at the true base pose first, on the branch quickest to reach from `seed` (often
    /// `goal.joints`). Where that has no solution the shoulder pan is turned by the yaw difference (HEATS section
    /// V-A), which keeps the camera's attitude but moves it, because the arm does not stand on the turning axis;
    /// what is left is reported.
    ///
    /// # Errors
    /// If a number is not finite.
    pub fn compensate_yaw(
        &self,
        goal: &BodyState,
        base: [f64; 3],
        seed: &[f64; 6],
    ) -> Result<Compensation, Error> {
        check(goal, base, seed)?;
        let wanted = self.camera_frame(goal);
        match self.ik_camera_frame(base, &wanted, seed).best() {
            Some(best) => Ok(self.compensation(base, best.joints, &wanted, true)),
            None => self.compensate_pan(goal, base, seed),
        }
    }

    /// Only turns the shoulder pan by the yaw difference, as published (HEATS section V-A): often quicker to reach
    /// than another branch, at the price of the position error reported.
    ///
    /// # Errors
    /// If a number is not finite.
    pub fn compensate_pan(
        &self,
        goal: &BodyState,
        base: [f64; 3],
        seed: &[f64; 6],
    ) -> Result<Compensation, Error> {
        check(goal, base, seed)?;
        let mut joints = goal.joints;
        joints[0] += wrap(goal.base[2] - base[2]);
        // Joint limits narrower than a turn may leave no copy: then the arm stays as it is, and the error says so.
        let joints = self.arm.nearest_copy(&joints, seed).unwrap_or(goal.joints);
        Ok(self.compensation(base, joints, &self.camera_frame(goal), false))
    }

    fn compensation(
        &self,
        base: [f64; 3],
        joints: [f64; 6],
        wanted: &Frame,
        exact: bool,
    ) -> Compensation {
        let reached = self.camera_frame(&BodyState { base, joints });
        let (position_error, angle_error) = reached.error_to(wanted);
        Compensation {
            joints,
            position_error,
            angle_error,
            clearance: self.self_clearance(&joints),
            exact,
        }
    }
}

fn check(goal: &BodyState, base: [f64; 3], seed: &[f64; 6]) -> Result<(), Error> {
    let finite = |field, v: &[f64]| match v.iter().all(|x| x.is_finite()) {
        true => Ok(()),
        false => Err(Error::NotFinite { field }),
    };
    finite("goal.base", &goal.base)?;
    finite("goal.joints", &goal.joints)?;
    finite("base", &base)?;
    finite("seed", seed)
}
