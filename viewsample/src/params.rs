//! Settings of the libraries and the score.

use crate::{Error, Frustum, Lidar};

/// One camera attitude of the library.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Elevation of the optical axis, rad; up is positive.
    pub pitch: f64,
    /// Height of the optical centre above the floor, m.
    pub height: f64,
}

/// Limits of the last try for clusters that no ordinary view serves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relaxed {
    /// How far the rings reach further in and out, m.
    pub widen: f64,
    /// Base positions on each ring.
    pub bearings: usize,
    /// Least information gain; one exploration voxel with the default weights.
    pub threshold: f64,
}

/// Settings of the libraries and the score.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// Radius of the innermost ring of base positions around a centroid, m.
    pub ring_min: f64,
    /// Largest radius of a ring, m. Below the inspection range.
    pub ring_max: f64,
    /// Step between rings, m (delta R). HEATS table I: 0.3.
    pub ring_step: f64,
    /// Base positions on each ring; HEATS table I: every 30 degrees.
    pub bearings: usize,
    /// Camera attitudes: one level, N_s down, N_s up. HEATS table I: N_s = 3.
    pub views: Vec<View>,
    /// Distances of the camera ahead of the base centre to try, best first, m.
    pub ahead: Vec<f64>,
    /// Changes of the height to try when no distance is within reach, best first, m.
    pub height_slack: Vec<f64>,
    /// LiDAR that sees exploration frontiers; none in the camera-only ablation.
    pub lidar: Option<Lidar>,
    /// Depth camera, for exploration frontiers.
    pub depth: Frustum,
    /// Colour camera, for inspection frontiers; `far` is d_ins, HEATS table I: 4.0.
    pub rgb: Frustum,
    /// Decay of the motion gain, 1/s (lambda_m of eq. 3). HEATS table I: 0.5.
    pub motion_decay: f64,
    /// Worth of an exploration voxel (lambda_e of eq. 4). HEATS table I: 0.2.
    pub exploration_weight: f64,
    /// Worth of an inspection voxel (lambda_i of eq. 4). HEATS table I: 0.8.
    pub inspection_weight: f64,
    /// How many times an inspection voxel counts of which a face that looks down or up is to be inspected: the underside of a
    /// table, the top of a cabinet. 1, all alike, is the published rule. Without `max_incidence` faces are not told apart.
    pub level_weight: u32,
    /// Worth of an exploration voxel that the LiDAR does not see from there but a camera does: the inside of a bin, say. As
    /// published it is `exploration_weight`.
    pub cavity_weight: f64,
    /// Least information gain (not score: that one decays with the way) of a view.
    pub threshold: f64,
    /// Unknown voxels a line of sight may cross.
    pub unknown_allowance: u32,
    /// Largest angle between the normal of an open face of an inspection voxel and the direction to the camera, rad; none
    /// counts every voxel in sight, as published.
    pub max_incidence: Option<f64>,
    /// Half the side of a target, m. With a limit on incidence, a face counts only where the image shows the square around its
    /// middle that holds any target whose own middle lies on the face; none asks for the voxel's centre alone.
    pub target: Option<f64>,
    /// Map changes farther than this from a base position, m in x or y, cannot touch the body.
    pub body_reach: f64,
    /// How many updates a LiDAR count may lag behind the map (frontier cells that are gone are
    /// always taken off). 0 is exact.
    pub lidar_patience: u32,
    /// Side of the squares whose LiDAR positions share one view, taken from the middle, m. 0 is
    /// exact: each base position has its own.
    pub lidar_grid: f64,
    /// Most views that [`candidates`](crate::Sampler::candidates) casts for a library before it names the best of them, those
    /// of highest bound first; none goes on until the best is certain.
    pub most_looks: Option<usize>,
    /// Share of its information gain, in (0, 1], down to which the view that a library offered last is offered again without a
    /// search; `None` searches always. A library far from the robot is searched anew whenever something in its sight changes;
    /// with a share it is searched when that took away what it had to show.
    pub hold_share: Option<f64>,
    /// Limits of the last try.
    pub relaxed: Relaxed,
}

impl Default for Params {
    fn default() -> Self {
        let view = |degrees: f64, height| View {
            pitch: degrees.to_radians(),
            height,
        };
        Self {
            ring_min: 0.9,
            ring_max: 3.0,
            ring_step: 0.3,
            bearings: 12,
            views: vec![
                view(0.0, 1.0),
                view(-25.0, 1.2),
                view(25.0, 0.8),
                view(-50.0, 1.3),
                view(50.0, 0.6),
                view(-75.0, 1.4),
                view(75.0, 0.45),
            ],
            ahead: vec![0.45, 0.55, 0.35, 0.65, 0.25, 0.75],
            height_slack: vec![0.0, -0.1, 0.1, -0.2, 0.2, -0.3, 0.3],
            lidar: Some(Lidar {
                offset: [0.25, 0.0, 0.45],
                low: -7.0_f64.to_radians(),
                high: 52.0_f64.to_radians(),
                range: 8.0,
            }),
            depth: Frustum::degrees(87.0, 58.0, 0.3, 4.0),
            rgb: Frustum::degrees(69.0, 42.0, 0.05, 4.0),
            motion_decay: 0.5,
            exploration_weight: 0.2,
            inspection_weight: 0.8,
            level_weight: 1,
            cavity_weight: 0.2,
            threshold: 2.0,
            unknown_allowance: 2,
            max_incidence: None,
            target: None,
            body_reach: 1.5,
            lidar_patience: 3,
            lidar_grid: 0.5,
            most_looks: None,
            hold_share: None,
            relaxed: Relaxed {
                widen: 0.3,
                bearings: 24,
                threshold: 0.2,
            },
        }
    }
}

impl Params {
    /// Checks every field once, so that the sampler itself can assume good values.
    pub fn validate(&self) -> Result<(), Error> {
        let check = |good: bool, field, value, range| match good {
            true => Ok(()),
            false => Err(Error::Param {
                field,
                value,
                range,
            }),
        };
        let positive =
            |field, v: f64| check(v > 0.0 && v.is_finite(), field, v, "positive and finite");
        let natural =
            |field, v: f64| check(v >= 0.0 && v.is_finite(), field, v, "at least 0 and finite");
        let count = |field, n: usize, range| check((1..=1000).contains(&n), field, n as f64, range);
        natural("ring_min", self.ring_min)?;
        check(
            self.ring_max >= self.ring_min && self.ring_max.is_finite(),
            "ring_max",
            self.ring_max,
            "finite and at least ring_min",
        )?;
        positive("ring_step", self.ring_step)?;
        let rings = (self.ring_max - self.ring_min) / self.ring_step;
        check(
            rings < 1000.0,
            "ring_step",
            self.ring_step,
            "large enough for at most 1000 rings",
        )?;
        count("bearings", self.bearings, "1 to 1000")?;
        count("views", self.views.len(), "1 to 1000 in number")?;
        count("ahead", self.ahead.len(), "1 to 1000 in number")?;
        count(
            "height_slack",
            self.height_slack.len(),
            "1 to 1000 in number",
        )?;
        for v in &self.views {
            check(
                v.pitch.abs() <= std::f64::consts::FRAC_PI_2,
                "views.pitch",
                v.pitch,
                "within pi/2",
            )?;
            check(v.height.is_finite(), "views.height", v.height, "finite")?;
        }
        for &v in &self.ahead {
            check(v.is_finite(), "ahead", v, "finite")?;
        }
        for &v in &self.height_slack {
            check(v.is_finite(), "height_slack", v, "finite")?;
        }
        if let Some(lidar) = &self.lidar {
            lidar.validate()?;
        }
        self.depth.validate("depth")?;
        self.rgb.validate("rgb")?;
        natural("motion_decay", self.motion_decay)?;
        natural("exploration_weight", self.exploration_weight)?;
        natural("inspection_weight", self.inspection_weight)?;
        count("level_weight", self.level_weight as usize, "1 to 1000")?;
        natural("cavity_weight", self.cavity_weight)?;
        natural("threshold", self.threshold)?;
        check(
            self.unknown_allowance <= 200,
            "unknown_allowance",
            f64::from(self.unknown_allowance),
            "at most 200",
        )?;
        if let Some(angle) = self.max_incidence {
            positive("max_incidence", angle)?;
        }
        if let Some(half) = self.target {
            natural("target", half)?;
        }
        natural("body_reach", self.body_reach)?;
        natural("lidar_grid", self.lidar_grid)?;
        if let Some(most) = self.most_looks {
            count("most_looks", most, "1 or more")?;
        }
        if let Some(share) = self.hold_share {
            check(
                share > 0.0 && share <= 1.0,
                "hold_share",
                share,
                "in (0, 1]",
            )?;
        }
        natural("relaxed.widen", self.relaxed.widen)?;
        count("relaxed.bearings", self.relaxed.bearings, "1 to 1000")?;
        natural("relaxed.threshold", self.relaxed.threshold)
    }

    /// Radii of the rings, m.
    pub fn radii(&self) -> Vec<f64> {
        let last = ((self.ring_max - self.ring_min) / self.ring_step + 1e-9).floor() as usize;
        (0..=last)
            .map(|n| self.ring_min + n as f64 * self.ring_step)
            .collect()
    }

    /// The same settings with the limits of the last try.
    pub(crate) fn relaxed(&self) -> Self {
        let inner = self.ring_min - self.relaxed.widen;
        Self {
            // A ring of radius 0 or less would be one point many times.
            ring_min: if inner > 0.0 { inner } else { self.ring_min },
            ring_max: self.ring_max + self.relaxed.widen,
            bearings: self.relaxed.bearings,
            threshold: self.relaxed.threshold,
            ..self.clone()
        }
    }
}
