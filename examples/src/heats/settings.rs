//! Every setting of a HEATS run, with the published value or a founded default.
//!
//! A config file is this struct as TOML; `--set views.motion_decay=0.4` sets one field. Unknown names fail. What a file leaves out
//! has the value of its `planner`.

use super::fault::FaultSettings;
use super::start::StartSettings;
use crate::sim::TagCamera;
use crate::tree::{assign, overlay};
use serde::{Deserialize, Serialize};

/// The published rules, as far as they differ from the defaults.
const PUBLISHED: &str = include_str!("../../presets/published.toml");

/// Which rules a search follows where nothing else is set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Planner {
    /// Ours: the defaults of this module.
    #[default]
    HeatsPlus,
    /// The rules and figures that the HEATS paper gives or implies (`presets/published.toml`).
    Heats,
}

impl Planner {
    /// Both.
    pub const ALL: [Self; 2] = [Self::HeatsPlus, Self::Heats];

    /// Its name on the command line and in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::HeatsPlus => "heats-plus",
            Self::Heats => "heats",
        }
    }
}

/// Which sensors the planner and the map may use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sensors {
    /// LiDAR on the base and RGB-D camera on the end effector.
    #[default]
    Both,
    /// RGB-D camera alone (the paper's ablation without LiDAR).
    Camera,
}

/// What planning costs on the simulated clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PlanningTime {
    /// Operations times calibrated constants: the same on every machine.
    #[default]
    Counted,
    /// Wall time of this machine.
    Measured,
}

/// All settings of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Whose rules these are; results bear its name.
    pub planner: Planner,
    /// Which sensors are used.
    pub sensors: Sensors,
    /// Seed of everything random.
    pub seed: u64,
    /// Overrides the scene's time limit, s.
    pub time_limit: Option<f64>,
    /// What planning costs on the simulated clock.
    pub planning_time: PlanningTime,
    /// Sensing and mapping.
    pub map: MapSettings,
    /// Frontiers.
    pub frontier: FrontierSettings,
    /// Viewpoints.
    pub views: ViewSettings,
    /// The dual-stage decision.
    pub decision: DecisionSettings,
    /// Whole-body paths and control.
    pub motion: MotionSettings,
    /// Where the run begins, if not as ever.
    #[serde(skip_serializing_if = "StartSettings::is_usual")]
    pub start: StartSettings,
    /// What goes wrong on purpose.
    #[serde(skip_serializing_if = "FaultSettings::is_none")]
    pub fault: FaultSettings,
}

/// Sensing and mapping. Defaults: HEATS table I and the sensors' data sheets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MapSettings {
    /// Edge of a voxel, m; the scene's figure when absent (HEATS: 0.15, lab 0.1).
    pub cell_size: Option<f64>,
    /// Largest distance at which a voxel counts as inspected, m; the scene's `d_ins` when absent (HEATS: 4.0).
    pub inspect_range: Option<f64>,
    /// Horizontal and vertical field of view of the RGB camera that inspects and finds tags, degrees: that of a RealSense D435i's
    /// colour sensor. HEATS names none for its simulation; (87, 58) is that of the depth sensor beside it.
    pub rgb_field: (f64, f64),
    /// Height band of surfaces to inspect above the floor, m. Floor and ceiling are left out.
    pub inspect_band: (f64, f64),
    /// Largest angle between a face's normal and the direction to the camera at which the face counts as inspected, degrees.
    /// Each face of a voxel that is open to free space must then be seen from its own side. 90 or more is the published rule:
    /// one sight of a voxel inspects all of it, so that a table top seen from above is never looked at from below.
    pub inspect_incidence: f64,
    /// Half the side of the square around the middle of a face that must be in the image for the face to count as inspected, beyond
    /// half a voxel, m. 0.12 holds any 0.16 m target on the face however it is turned; 0.06 holds one near its middle.
    pub target: f64,
    /// Whether only images sharp enough to read a tag in inspect, two in a row. False is the published rule: every image does.
    pub sharp_only: bool,
    /// Whether faces too narrow to carry a target, of rods and edges and slivers between them, need no inspection.
    pub skip_narrow: bool,
    /// Whether strips one voxel wide between inspected faces need no inspection either. Of a 0.16 m target in the middle of one
    /// the images on both sides may each lack 7 cm with 0.1 m voxels and `target` as it is, and 9.5 cm with 0.15 m, where they show
    /// no more than they must.
    pub skip_strips: bool,
    /// Probabilities of the sensor model: hit and miss.
    pub hit: f64,
    /// See [`hit`](Self::hit).
    pub miss: f64,
    /// Lower and upper clamp of the sensor model. With narrow ones (0.12 and 0.97 are usual) a single return fills a cell that was
    /// seen empty for seconds, and the faces of each cell that turns over must be inspected again.
    pub clamp: (f64, f64),
    /// How far behind its surface a return counts, m: enough for rounding where a surface lies on a border between cells. What
    /// is more takes returns at the edge of a solid for the cell beyond it.
    pub hit_depth: f64,
    /// Whether rays that scrape along a surface are kept from erasing it: each voxel that turns free and occupied again is to be
    /// inspected again.
    pub grazing_guard: bool,
    /// Standard deviation of range noise as a share of the range; 0 is a perfect sensor. With any, `miss` is 0.4 at most, returns
    /// near the floor are the floor's, and those that scatter by more than a quarter of a cell only free what lies before them.
    pub range_noise: f64,
    /// Share of rays that return nothing by chance.
    pub dropout: f64,
    /// Truncation of the distance field, m.
    pub truncation: f64,
}

impl MapSettings {
    /// The RGB camera, with its reach in m.
    pub fn tag_camera(&self, reach: f64) -> TagCamera {
        let (across, down) = self.rgb_field;
        TagCamera {
            field: [across, down].map(f64::to_radians),
            ..TagCamera::new(reach)
        }
    }
}

impl Default for MapSettings {
    fn default() -> Self {
        Self {
            cell_size: None,
            inspect_range: None,
            rgb_field: (69.0, 42.0),
            inspect_band: (0.0, 2.4),
            inspect_incidence: 64.0,
            target: 0.06,
            sharp_only: true,
            skip_narrow: true,
            skip_strips: true,
            hit: 0.97,
            miss: 0.49,
            clamp: (0.004, 0.998),
            hit_depth: 2e-5,
            grazing_guard: true,
            range_noise: 0.0,
            dropout: 0.0,
            truncation: 1.0,
        }
    }
}

/// Frontier clusters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FrontierSettings {
    /// Wanted voxels of an exploration cluster (K of k-means is at least n over this).
    pub exploration_size: f64,
    /// Wanted extent of an exploration cluster, m.
    pub exploration_extent: f64,
    /// Smallest exploration cluster, voxels.
    pub min_exploration: usize,
    /// Smallest inspection cluster, voxels.
    pub min_inspection: usize,
    /// Largest deviation of normals inside an inspection cluster, degrees.
    pub normal_angle: f64,
    /// Radius above which an inspection cluster is split, m.
    pub inspection_radius: f64,
    /// Height band of exploration frontiers, m.
    pub exploration_band: (f64, f64),
}

impl Default for FrontierSettings {
    fn default() -> Self {
        Self {
            exploration_size: 60.0,
            exploration_extent: 2.0,
            min_exploration: 1,
            min_inspection: 2,
            normal_angle: 30.0,
            inspection_radius: 1.2,
            exploration_band: (0.0, 2.4),
        }
    }
}

/// Viewpoint libraries and scores. Defaults: HEATS table I where it names them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ViewSettings {
    /// Decay of the motion gain, 1/s (lambda_m, eq. 3). HEATS table I has 0.5, with which a view 1.4 s nearer may see half as much;
    /// a search then makes many stops that each see little.
    pub motion_decay: f64,
    /// Weight of exploration (lambda_e, eq. 4).
    pub exploration_weight: f64,
    /// Weight of inspection (lambda_i, eq. 4).
    pub inspection_weight: f64,
    /// How many times a voxel counts of which a face that looks down or up is to be inspected. There are few of them, in
    /// furniture, so that they come last where all count alike; 1 is the published rule.
    pub level_weight: u32,
    /// Weight of unknown voxels that only the camera sees, such as the inside of a bin, behind which lie several faces to inspect.
    /// As published it is `exploration_weight`.
    pub cavity_weight: f64,
    /// Least information gain of a candidate (at 0.15 m voxels); a whole target spans four voxels at most.
    pub threshold: f64,
    /// Least information gain of the last tries, once nothing above the threshold is left: with wider rings as published, or with
    /// aimed views that show smaller targets and flatter faces than what inspects them.
    pub relaxed_threshold: f64,
    /// Elevation (degrees, up is positive), height (m) and least distance ahead of the base's middle (m) of the camera in each view
    /// of the library; the first is the posture to start with. The paper's seven attitudes, where an image covers most
    /// of what such a view is for: walls, table tops and cabinet tops from above, undersides from a low camera stretched out beneath
    /// them.
    pub attitudes: Vec<(f64, f64, f64)>,
    /// Views aimed at single faces of each cluster of the robot's region, besides those of its library; 0 is the published rule.
    pub aimed: usize,
    /// Radii of the innermost and outermost ring of base positions around a cluster, m.
    pub ring_min: f64,
    /// See [`ring_min`](Self::ring_min).
    pub ring_max: f64,
    /// Range at which LiDAR coverage of frontiers is counted, m.
    pub lidar_range: f64,
    /// Clearance that a viewpoint's spheres keep, m.
    pub clearance: f64,
    /// Most views cast for a cluster before the best of them is its candidate; 0 goes on until the best is certain.
    pub most_looks: usize,
    /// Share of its information gain down to which a cluster's last candidate stays its candidate without a search; 0 searches
    /// always.
    pub hold_share: f64,
    /// Whether the arm is led through a posture that sees what is left along the base's path. False is the published rule.
    pub on_the_way: bool,
    /// Information gain that each second by which such a posture delays the path must bring (at 0.15 m voxels).
    pub delay_price: f64,
}

impl Default for ViewSettings {
    fn default() -> Self {
        Self {
            motion_decay: 0.03,
            exploration_weight: 0.2,
            inspection_weight: 0.8,
            level_weight: 6,
            cavity_weight: 2.5,
            threshold: 4.0,
            relaxed_threshold: 2.4,
            attitudes: vec![
                (0.0, 1.2, 0.1),
                (-15.0, 1.5, 0.4),
                (32.0, 0.2, 0.8),
                (-50.0, 1.38, 0.55),
                (48.0, 0.2, 0.75),
                (-75.0, 1.1, 0.75),
                (-32.0, 1.42, 0.5),
            ],
            aimed: 12,
            ring_min: 0.6,
            ring_max: 3.0,
            lidar_range: 8.0,
            clearance: 0.05,
            most_looks: 8,
            hold_share: 0.8,
            on_the_way: true,
            delay_price: 45.0,
        }
    }
}

/// The dual-stage decision and its replanning rules.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DecisionSettings {
    /// Concavity above which a region is cut, m.
    pub tau: f64,
    /// Whether the candidates of the robot's region, and views from where it stands, are thinned to those that soonest cover what
    /// all of them see before the order is chosen. False is the published rule: one view for each cluster, however small,
    /// visited one after another.
    pub cover: bool,
    /// Views of the cover that add less than this share of what the first adds wait for a later decision: first the views that see
    /// much, then the leftovers of the region.
    pub cover_share: f64,
    /// A view that adds this much never waits (information gain at 0.15 m voxels).
    pub cover_most: f64,
    /// Least information gain a second of the way to a view (at 0.15 m voxels), one figure for each round through the
    /// building; what pays less waits for a later round, and in the last one everything counts. A patch is left when it pays less than
    /// the rest of the building does (the marginal value theorem of foraging, Charnov 1976).
    pub rates: Vec<f64>,
    /// Ways longer than this count as this long when rates are taken, s.
    pub rate_span: f64,
    /// Views of the cover, besides the next one of the tour, to which ways are planned as well: the one is taken whose way shows most
    /// for its time, looks on the way included. 0 is the published rule.
    pub others: usize,
    /// Period of re-decisions while driving, s.
    pub period: f64,
    /// Share of the target's gain that must be left to keep going there.
    pub keep_share: f64,
    /// Position tolerance of a reached viewpoint, m.
    pub reached_position: f64,
    /// Angle tolerance of a reached viewpoint, degrees.
    pub reached_angle: f64,
    /// Failures after which a place is given up.
    pub strikes: u32,
    /// First time a failed goal stays excluded, s; doubles with each failure.
    pub exclusion: f64,
}

impl Default for DecisionSettings {
    fn default() -> Self {
        Self {
            tau: 2.5,
            cover: true,
            cover_share: 0.35,
            cover_most: 25.0,
            rates: vec![12.0, 4.0],
            rate_span: 6.0,
            others: 5,
            period: 1.0,
            keep_share: 0.35,
            reached_position: 0.15,
            reached_angle: 5.0,
            strikes: 3,
            exclusion: 10.0,
        }
    }
}

/// Whole-body paths, model predictive control, safety.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MotionSettings {
    /// Acceleration limits: base m/s2, base rad/s2, joints rad/s2.
    pub acceleration: (f64, f64, f64),
    /// Share of the speed limits that reference paths use; the rest is the controller's.
    pub reference_speed: f64,
    /// Share of the base's acceleration limits that reference paths use.
    pub reference_acceleration: f64,
    /// Price of driving backwards, as a factor on time, and the longest straight stretch driven so, m.
    pub reverse: (f64, f64),
    /// Turning speed of the base that reference paths use, rad/s: a little below what still gives sharp images (1 rad/s), so
    /// that turns inspect as well.
    pub turn_speed: f64,
    /// Horizon of the controller, s (t_f, HEATS table I).
    pub horizon: f64,
    /// Knots of the horizon.
    pub knots: usize,
    /// Iterations per control step.
    pub iterations: usize,
    /// Control period, s.
    pub control_period: f64,
    /// Margin of the controller to the mapped surface, m.
    pub margin: f64,
    /// Margin below which a command is replaced, m; smaller than `margin`, or the robot freezes.
    pub guard_margin: f64,
    /// Clearance of the base footprint along base paths, m.
    pub base_clearance: f64,
    /// Barrier weight and relaxation of the controller (mu and delta, eq. 9).
    pub barrier: (f64, f64),
    /// Iterations of the arm planner.
    pub arm_iterations: usize,
}

impl Default for MotionSettings {
    fn default() -> Self {
        Self {
            acceleration: (0.8, 2.0, 2.0),
            reference_speed: 0.95,
            reference_acceleration: 0.9,
            reverse: (1.05, 6.0),
            turn_speed: 0.9,
            horizon: 3.0,
            knots: 30,
            iterations: 3,
            control_period: 0.04,
            margin: 0.06,
            guard_margin: 0.02,
            base_clearance: 0.04,
            barrier: (1e-3, 3e-4),
            arm_iterations: 2000,
        }
    }
}

/// What is wrong with a setting.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// The text is no TOML, or names an unknown field, or gives a wrong type.
    #[error("settings: {0}")]
    Parse(String),
    /// `--set` without `=`.
    #[error("--set {0}: write key=value, e.g. views.motion_decay=0.4")]
    Assignment(String),
    /// A value outside its range.
    #[error("settings: {field} = {value} must be {wanted}")]
    Range {
        /// Dotted name of the field.
        field: &'static str,
        /// The value given.
        value: f64,
        /// What would be right.
        wanted: &'static str,
    },
}

impl Settings {
    /// The rules of a planner, with seed 0.
    ///
    /// # Errors
    /// [`SettingsError::Parse`] if the preset in this build were broken, which a test rules out.
    pub fn of(planner: Planner) -> Result<Self, SettingsError> {
        match planner {
            Planner::HeatsPlus => Ok(Self::default()),
            Planner::Heats => Self::default().overlaid(PUBLISHED),
        }
    }

    /// Reads a config file's text; what it does not name has the value of its `planner`.
    ///
    /// # Errors
    /// [`SettingsError::Parse`] for malformed text, unknown fields or wrong types.
    pub fn from_toml(text: &str) -> Result<Self, SettingsError> {
        /// The planner alone, whatever else the text holds.
        #[derive(Default, Deserialize)]
        #[serde(default)]
        struct Head {
            planner: Planner,
        }
        let head: Head = toml::from_str(text).map_err(|e| SettingsError::Parse(e.to_string()))?;
        Self::of(head.planner)?.overlaid(text)
    }

    /// These settings with what a config file's text names in place of their own.
    ///
    /// # Errors
    /// [`SettingsError::Parse`] for malformed text, unknown fields or wrong types.
    pub fn overlaid(&self, text: &str) -> Result<Self, SettingsError> {
        let parse = |e: toml::de::Error| SettingsError::Parse(e.to_string());
        // By itself first: its errors then name line and column.
        let _: Self = toml::from_str(text).map_err(parse)?;
        let mut tree: toml::Table = toml::from_str(&self.to_toml()).map_err(parse)?;
        overlay(&mut tree, toml::from_str(text).map_err(parse)?);
        tree.try_into().map_err(parse)
    }

    /// The settings as TOML text that [`from_toml`](Self::from_toml) reads back.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// Applies `section.field=value` assignments in order.
    ///
    /// # Errors
    /// [`SettingsError`] naming the assignment that is wrong.
    pub fn with<'a>(
        self,
        assignments: impl IntoIterator<Item = &'a str>,
    ) -> Result<Self, SettingsError> {
        let mut tree: toml::Table =
            toml::from_str(&self.to_toml()).map_err(|e| SettingsError::Parse(e.to_string()))?;
        for assignment in assignments {
            assign(&mut tree, assignment)?;
        }
        let text = toml::to_string(&tree).map_err(|e| SettingsError::Parse(e.to_string()))?;
        toml::from_str(&text).map_err(|e| SettingsError::Parse(e.to_string()))
    }

    /// Checks every range.
    ///
    /// # Errors
    /// [`SettingsError::Range`] for the first field outside its range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let check = |ok: bool, field, value, wanted| {
            if ok {
                Ok(())
            } else {
                Err(SettingsError::Range {
                    field,
                    value,
                    wanted,
                })
            }
        };
        let positive = |field, value: f64| {
            check(
                value > 0.0 && value.is_finite(),
                field,
                value,
                "positive and finite",
            )
        };
        let not_negative = |field, value: f64| {
            check(
                value >= 0.0 && value.is_finite(),
                field,
                value,
                "zero or more and finite",
            )
        };
        let share = |field, value: f64| {
            check(
                (0.0..=1.0).contains(&value),
                field,
                value,
                "between 0 and 1",
            )
        };
        let band = |field, (low, high): (f64, f64)| {
            check(low < high, field, low, "below the upper end of its band")
        };
        self.start.validate()?;
        self.fault.validate()?;
        if let Some(limit) = self.time_limit {
            not_negative("time_limit", limit)?;
        }
        if let Some(size) = self.map.cell_size {
            check(
                (0.02..=1.0).contains(&size),
                "map.cell_size",
                size,
                "between 0.02 and 1 m",
            )?;
        }
        if let Some(range) = self.map.inspect_range {
            positive("map.inspect_range", range)?;
        }
        for (field, angle) in [
            ("map.rgb_field[0]", self.map.rgb_field.0),
            ("map.rgb_field[1]", self.map.rgb_field.1),
        ] {
            let ok = (1.0..=150.0).contains(&angle);
            check(ok, field, angle, "between 1 and 150 degrees")?;
        }
        band("map.inspect_band", self.map.inspect_band)?;
        positive("map.inspect_incidence", self.map.inspect_incidence)?;
        not_negative("map.target", self.map.target)?;
        share("map.hit", self.map.hit)?;
        share("map.miss", self.map.miss)?;
        share("map.clamp", self.map.clamp.0)?;
        share("map.clamp", self.map.clamp.1)?;
        band("map.clamp", self.map.clamp)?;
        not_negative("map.hit_depth", self.map.hit_depth)?;
        check(
            self.map.miss < self.map.hit,
            "map.miss",
            self.map.miss,
            "below map.hit",
        )?;
        not_negative("map.range_noise", self.map.range_noise)?;
        share("map.dropout", self.map.dropout)?;
        positive("map.truncation", self.map.truncation)?;
        positive("frontier.exploration_size", self.frontier.exploration_size)?;
        positive(
            "frontier.exploration_extent",
            self.frontier.exploration_extent,
        )?;
        positive("frontier.normal_angle", self.frontier.normal_angle)?;
        positive(
            "frontier.inspection_radius",
            self.frontier.inspection_radius,
        )?;
        band("frontier.exploration_band", self.frontier.exploration_band)?;
        not_negative("views.motion_decay", self.views.motion_decay)?;
        not_negative("views.exploration_weight", self.views.exploration_weight)?;
        not_negative("views.inspection_weight", self.views.inspection_weight)?;
        check(
            (1..=1000).contains(&self.views.level_weight),
            "views.level_weight",
            f64::from(self.views.level_weight),
            "1 to 1000",
        )?;
        not_negative("views.threshold", self.views.threshold)?;
        not_negative("views.relaxed_threshold", self.views.relaxed_threshold)?;
        positive("views.ring_min", self.views.ring_min)?;
        check(
            self.views.ring_max >= self.views.ring_min,
            "views.ring_max",
            self.views.ring_max,
            "at least views.ring_min",
        )?;
        positive("views.lidar_range", self.views.lidar_range)?;
        not_negative("views.clearance", self.views.clearance)?;
        positive("decision.tau", self.decision.tau)?;
        positive("decision.period", self.decision.period)?;
        share("decision.keep_share", self.decision.keep_share)?;
        positive("decision.reached_position", self.decision.reached_position)?;
        positive("decision.reached_angle", self.decision.reached_angle)?;
        positive("decision.exclusion", self.decision.exclusion)?;
        let (linear, angular, joint) = self.motion.acceleration;
        positive("motion.acceleration[0]", linear)?;
        positive("motion.acceleration[1]", angular)?;
        positive("motion.acceleration[2]", joint)?;
        check(
            self.motion.reference_speed > 0.0 && self.motion.reference_speed <= 1.0,
            "motion.reference_speed",
            self.motion.reference_speed,
            "above 0 and at most 1",
        )?;
        positive("motion.horizon", self.motion.horizon)?;
        check(
            (2..=400).contains(&self.motion.knots),
            "motion.knots",
            self.motion.knots as f64,
            "between 2 and 400",
        )?;
        share("views.hold_share", self.views.hold_share)?;
        share("decision.cover_share", self.decision.cover_share)?;
        share(
            "motion.reference_acceleration",
            self.motion.reference_acceleration,
        )?;
        not_negative("views.cavity_weight", self.views.cavity_weight)?;
        positive("decision.cover_most", self.decision.cover_most)?;
        for &rate in &self.decision.rates {
            not_negative("decision.rates", rate)?;
        }
        positive("decision.rate_span", self.decision.rate_span)?;
        not_negative("views.delay_price", self.views.delay_price)?;
        positive("motion.turn_speed", self.motion.turn_speed)?;
        positive("motion.reverse[0]", self.motion.reverse.0)?;
        not_negative("motion.reverse[1]", self.motion.reverse.1)?;
        positive("motion.control_period", self.motion.control_period)?;
        not_negative("motion.margin", self.motion.margin)?;
        check(
            self.motion.guard_margin < self.motion.margin,
            "motion.guard_margin",
            self.motion.guard_margin,
            "below motion.margin, or the robot freezes",
        )?;
        not_negative("motion.base_clearance", self.motion.base_clearance)?;
        positive("motion.barrier[0]", self.motion.barrier.0)?;
        positive("motion.barrier[1]", self.motion.barrier.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_preset_is_read_and_is_not_the_default() {
        let heats = Settings::of(Planner::Heats).expect("embedded");
        assert_eq!(heats.validate(), Ok(()));
        assert_eq!(heats.planner, Planner::Heats);
        assert!((heats.views.motion_decay - 0.5).abs() < 1e-12);
        assert_eq!(heats.motion.knots, Settings::default().motion.knots);
        assert_eq!(Settings::from_toml(PUBLISHED), Ok(heats));
    }

    #[test]
    fn a_file_overlays_the_planner_it_names() {
        let text = "planner = \"heats\"\nseed = 3\n[views]\nthreshold = 3.0";
        let settings = Settings::from_toml(text).expect("valid");
        let mut wanted = Settings::of(Planner::Heats).expect("embedded");
        wanted.seed = 3;
        wanted.views.threshold = 3.0;
        assert_eq!(settings, wanted);
        assert_eq!(Settings::from_toml(&wanted.to_toml()), Ok(wanted));
        assert!(Settings::from_toml("planner = \"magic\"").is_err());
        assert!(Settings::from_toml("[views]\nthreshhold = 3.0").is_err());
    }

    #[test]
    fn assignments_reach_every_depth() {
        let set = |text| Settings::default().with([text]);
        assert_eq!(set("seed=7").map(|s| s.seed), Ok(7));
        assert_eq!(set("views.threshold=3").map(|s| s.views.threshold), Ok(3.0));
        assert_eq!(set("planner=heats").map(|s| s.planner), Ok(Planner::Heats));
        for wrong in ["views", "seed.x=1", "views.x=1", "seed=-1"] {
            assert!(set(wrong).is_err(), "{wrong}");
        }
    }
}
