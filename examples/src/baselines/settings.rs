//! Every setting of AEP and WG-NBVP, with the published value unless the field says why it is another.
//!
//! "Published" are the configuration files of the authors' programs, github.com/mseln/aeplanner (`rpl_exploration/config`) and
//! github.com/fkie/fkie-nbv-planner (`config`), which their papers' experiments were run with.

use super::gain::RayParams;
use super::gp::Kernel;
use crate::heats::{self, MapSettings, MotionSettings, PlanningTime, Sensors, SettingsError};
use crate::tree::assign;
use serde::{Deserialize, Serialize};

/// Full view of AEP's published camera (85 by 58 degrees, 0 to 5 m), m3: the measure of its thresholds.
const AEP_FULL_VIEW: f64 = 59.9;

/// The planners of this module.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Baseline {
    /// Autonomous exploration planner (Selin et al., RA-L 2019).
    #[default]
    Aep,
    /// Online next-best-view planner with weighted gains (Naazare et al., RA-L 2022).
    WgNbvp,
}

impl Baseline {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Aep, Self::WgNbvp];

    /// Its name on the command line and in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Aep => "aep",
            Self::WgNbvp => "wg-nbvp",
        }
    }
}

/// All settings of a run. Sensors, map, limits, motion and clock are those of HEATS.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BaselineSettings {
    /// Which planner runs.
    pub planner: Baseline,
    /// Seed of everything random.
    pub seed: u64,
    /// Overrides the scene's time limit, s.
    pub time_limit: Option<f64>,
    /// What planning costs on the simulated clock.
    pub planning_time: PlanningTime,
    /// AEP.
    pub aep: AepSettings,
    /// WG-NBVP.
    pub wg_nbvp: WgNbvpSettings,
    /// How the robot takes up a view.
    pub stand: StandSettings,
    /// Sensing and mapping, as for HEATS.
    pub map: MapSettings,
    /// Base paths, arm paths and control, as for HEATS.
    pub motion: MotionSettings,
}

impl Default for BaselineSettings {
    fn default() -> Self {
        Self {
            planner: Baseline::default(),
            seed: 1,
            time_limit: None,
            planning_time: PlanningTime::default(),
            aep: AepSettings::default(),
            wg_nbvp: WgNbvpSettings::default(),
            stand: StandSettings::default(),
            map: MapSettings::default(),
            motion: MotionSettings::default(),
        }
    }
}

/// The sweep of rays that gains are made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RaySettings {
    /// Volume counts from and to so far from the camera, m. Published: 0 to 5 (AEP) and 0.3 to 1.5 (WG-NBVP), each as far as the
    /// depth camera of its authors maps; ours maps to 4.
    pub range: (f64, f64),
    /// Radial step, m. Published: 0.1, both.
    pub radial_step: f64,
    /// Step of azimuth and elevation, degrees. Published: 10, both.
    pub angle_step: f64,
    /// Elevations at which the camera may be held, degrees. Published: 0 alone, both.
    pub pitches: Vec<f64>,
}

impl RaySettings {
    /// The rays for a camera of this field of view, rad.
    pub fn params(&self, field: [f64; 2]) -> RayParams {
        RayParams {
            field,
            range: self.range,
            radial_step: self.radial_step,
            angle_step: self.angle_step.to_radians(),
            pitches: self.pitches.iter().map(|p| p.to_radians()).collect(),
        }
    }
}

/// Autonomous exploration planner. Figures in m3 are those of the published full view of 59.9 m3 and are scaled to ours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AepSettings {
    /// The sweep of rays.
    pub rays: RaySettings,
    /// Decay of a gain with the length of its edge (lambda), 1/m. Published: 0.75.
    pub decay: f64,
    /// Score at which there is nothing more to see nearby (g_zero), m3. Published: 25.
    pub exhausted: f64,
    /// Gain above which a cached place is a goal of the global planner, m3. Published: 16.
    pub frontier: f64,
    /// Thresholds are halved where the published planner declares the exploration complete, down to this share of their value; 1 is
    /// the published rule. With a camera at arm's height in furnished rooms what is left is in pockets far below 16 m3.
    pub least_share: f64,
    /// Variance below which the predicted gain is used (sigma_thresh). Published: 0.2.
    pub variance: f64,
    /// Length of the kernel, m; standard deviations of signal and noise. Published: 1, 1, 0.1.
    pub kernel: (f64, f64, f64),
    /// Cached gains within so far along each axis make a prediction, m. Published: 2.
    pub neighbourhood: f64,
    /// Cached gains near the robot are computed anew after so long, s. Published: 5.
    pub renew_period: f64,
    /// Cached gains above this are computed anew, m3. Published: 2.
    pub renew_above: f64,
    /// Length of an edge of the tree, m. Published: 1.
    pub edge: f64,
    /// What the parent of a node may be farther away than an edge is long, m. Published: 0.5.
    pub edge_slack: f64,
    /// Radius of the ball in which nodes are sampled, m. Published: 10.
    pub sampling_radius: f64,
    /// Nodes always grown. Published: 15.
    pub initial_nodes: usize,
    /// Nodes grown as long as the best score is low. Published: 30.
    pub most_nodes: usize,
    /// Samples drawn for a node before growing ends. Not published: the program tries for ever.
    pub tries: usize,
    /// Free space kept around the camera, m. Published: 0.75, the radius of a multicopter.
    pub radius: f64,
    /// Heights of the camera, m. Published: 0 to 2; these are what the arm reaches, as WG-NBVP has them.
    pub heights: (f64, f64),
}

impl Default for AepSettings {
    fn default() -> Self {
        Self {
            rays: RaySettings::default(),
            decay: 0.75,
            exhausted: 25.0,
            frontier: 16.0,
            least_share: 0.03,
            variance: 0.2,
            kernel: (1.0, 1.0, 0.1),
            neighbourhood: 2.0,
            renew_period: 5.0,
            renew_above: 2.0,
            edge: 1.0,
            edge_slack: 0.5,
            sampling_radius: 10.0,
            initial_nodes: 15,
            most_nodes: 30,
            tries: 300,
            radius: 0.3,
            heights: (0.4, 1.4),
        }
    }
}

impl AepSettings {
    /// The kernel of the process.
    pub fn kernel(&self) -> Kernel {
        let (length, signal, noise) = self.kernel;
        Kernel {
            length,
            signal,
            noise,
        }
    }

    /// What published volumes are multiplied with for a camera whose full view is `full_view` m3.
    pub fn scale(&self, full_view: f64) -> f64 {
        full_view / AEP_FULL_VIEW
    }
}

/// What WG-NBVP measures besides unknown volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Nothing: the published weights of its exploration of free space. The task gives it no radiation or gas to measure.
    #[default]
    FreeSpace,
    /// Surface still to be inspected, in the place of such a reading: the published weights of its measurements.
    Inspection,
}

/// Next-best-view planner with weighted gains: the published files `normal`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WgNbvpSettings {
    /// The sweep of rays.
    pub rays: RaySettings,
    /// What is measured. Published: both kinds.
    pub measure: Measure,
    /// Weights of free space, measurement and visited places, with measurement. Published: 1, 5, 500.
    pub measuring_weights: (f64, f64, f64),
    /// The same for free space alone. Published: 5, 0, 500.
    pub exploring_weights: (f64, f64, f64),
    /// First normaliser of the measurement, voxels; it grows with what is measured, as published (there 500, of a reading).
    pub most_measured: f64,
    /// Surface within so far of the camera is measured, m. Ours; the published reading is that of the camera's cell of 1 m.
    pub measured_radius: f64,
    /// Nodes of the tree. Published: 400.
    pub nodes: usize,
    /// Samples for a node. Published: 50.
    pub tries: usize,
    /// Length of an edge, m. Published: 0.5.
    pub step: f64,
    /// Least distance between nodes, m. Published: 0.4.
    pub spacing: f64,
    /// Free space kept around the camera, m. Published: 0.3.
    pub radius: f64,
    /// Cube of the radius in which nodes are sampled, m3. Published: 30, so 3.1 m.
    pub sampling_volume: f64,
    /// Heights of the camera, m. Published: 0.4 to 1.4.
    pub heights: (f64, f64),
    /// Base moves go farther than this, m. Published: 1.3, the arm's range; what the arm reaches is told by its kinematics here.
    pub reach: f64,
    /// Edge of the cells that are visited once, m. Published: 1.
    pub visited_cell: f64,
    /// Cached views that base moves choose from. Published: 10.
    pub frontiers: usize,
    /// Nodes grown beyond the tree's number towards them. Published: 50.
    pub frontier_tries: usize,
    /// Views kept from one plan to the next. Published: 50.
    pub cached: usize,
    /// Whether the arm stops only at the corners of the convex hull of its views. Published: true.
    pub hull: bool,
}

impl Default for WgNbvpSettings {
    fn default() -> Self {
        Self {
            rays: RaySettings {
                range: (0.3, 4.0),
                ..RaySettings::default()
            },
            measure: Measure::default(),
            measuring_weights: (1.0, 5.0, 500.0),
            exploring_weights: (5.0, 0.0, 500.0),
            most_measured: 100.0,
            measured_radius: 1.5,
            nodes: 400,
            tries: 50,
            step: 0.5,
            spacing: 0.4,
            radius: 0.3,
            sampling_volume: 30.0,
            heights: (0.4, 1.4),
            reach: 1.3,
            visited_cell: 1.0,
            frontiers: 10,
            frontier_tries: 50,
            cached: 50,
            hull: true,
        }
    }
}

impl WgNbvpSettings {
    /// Weights of free space, measurement and visited places.
    pub fn weights(&self) -> (f64, f64, f64) {
        match self.measure {
            Measure::FreeSpace => self.exploring_weights,
            Measure::Inspection => self.measuring_weights,
        }
    }
}

impl Default for RaySettings {
    fn default() -> Self {
        Self {
            range: (0.0, 4.0),
            radial_step: 0.1,
            angle_step: 10.0,
            pitches: vec![0.0],
        }
    }
}

/// How base and arm take up a camera's pose; neither paper has a mobile base with an arm like ours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StandSettings {
    /// Distances of the base's middle behind the camera, m.
    pub distances: Vec<f64>,
    /// Directions around the camera.
    pub bearings: usize,
    /// Yaws of the base at each place, besides those in which it arrives.
    pub yaws: usize,
    /// Ways planned to views before the robot waits and plans anew.
    pub ways: usize,
    /// Clearance of the arm, m.
    pub clearance: f64,
    /// First time a failed view stays excluded, s; doubles with each failure.
    pub exclusion: f64,
}

impl Default for StandSettings {
    fn default() -> Self {
        Self {
            distances: vec![0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8],
            bearings: 36,
            yaws: 12,
            ways: 6,
            clearance: 0.05,
            exclusion: 20.0,
        }
    }
}

impl BaselineSettings {
    /// The published rules of a planner.
    pub fn of(planner: Baseline) -> Self {
        Self {
            planner,
            ..Self::default()
        }
    }

    /// Reads a config file's text.
    ///
    /// # Errors
    /// [`SettingsError::Parse`] for malformed text, unknown fields or wrong types.
    pub fn from_toml(text: &str) -> Result<Self, SettingsError> {
        toml::from_str(text).map_err(|e| SettingsError::Parse(e.to_string()))
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
        Self::from_toml(&text)
    }

    /// Map, motion and clock as HEATS has them, with the camera alone.
    pub(super) fn common(&self) -> heats::Settings {
        heats::Settings {
            sensors: Sensors::Camera,
            seed: self.seed,
            time_limit: self.time_limit,
            planning_time: self.planning_time,
            map: self.map.clone(),
            motion: self.motion.clone(),
            ..heats::Settings::default()
        }
    }

    /// Checks every range.
    ///
    /// # Errors
    /// [`SettingsError::Range`] for the first field outside its range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        self.common().validate()?;
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
        let positive =
            |field, v: f64| check(v > 0.0 && v.is_finite(), field, v, "positive and finite");
        let not_negative = |field, v: f64| {
            check(
                v >= 0.0 && v.is_finite(),
                field,
                v,
                "zero or more and finite",
            )
        };
        let band = |field, (low, high): (f64, f64)| {
            let fine = low < high && low.is_finite() && high.is_finite();
            check(fine, field, low, "below the upper end of its band")
        };
        let count = |field, n: usize, most: usize, wanted| {
            check((1..=most).contains(&n), field, n as f64, wanted)
        };
        for (rays, range, radial, angle, pitches) in [
            (
                &self.aep.rays,
                "aep.rays.range",
                "aep.rays.radial_step",
                "aep.rays.angle_step",
                "aep.rays.pitches",
            ),
            (
                &self.wg_nbvp.rays,
                "wg_nbvp.rays.range",
                "wg_nbvp.rays.radial_step",
                "wg_nbvp.rays.angle_step",
                "wg_nbvp.rays.pitches",
            ),
        ] {
            band(range, rays.range)?;
            not_negative(range, rays.range.0)?;
            check(rays.range.1 <= 50.0, range, rays.range.1, "at most 50 m")?;
            let step = rays.radial_step;
            check(
                (0.01..=1.0).contains(&step),
                radial,
                step,
                "between 0.01 and 1 m",
            )?;
            let step = rays.angle_step;
            check(
                (1.0..=45.0).contains(&step),
                angle,
                step,
                "between 1 and 45 degrees",
            )?;
            count(pitches, rays.pitches.len(), 19, "1 to 19 elevations")?;
            for &pitch in &rays.pitches {
                check(
                    pitch.abs() <= 60.0,
                    pitches,
                    pitch,
                    "between -60 and 60 degrees",
                )?;
            }
        }
        let a = &self.aep;
        not_negative("aep.decay", a.decay)?;
        positive("aep.exhausted", a.exhausted)?;
        positive("aep.frontier", a.frontier)?;
        check(
            a.least_share > 0.0 && a.least_share <= 1.0,
            "aep.least_share",
            a.least_share,
            "above 0 and at most 1",
        )?;
        not_negative("aep.variance", a.variance)?;
        positive("aep.kernel[0]", a.kernel.0)?;
        positive("aep.kernel[1]", a.kernel.1)?;
        positive("aep.kernel[2]", a.kernel.2)?;
        not_negative("aep.neighbourhood", a.neighbourhood)?;
        not_negative("aep.renew_period", a.renew_period)?;
        not_negative("aep.renew_above", a.renew_above)?;
        positive("aep.edge", a.edge)?;
        not_negative("aep.edge_slack", a.edge_slack)?;
        positive("aep.sampling_radius", a.sampling_radius)?;
        count("aep.initial_nodes", a.initial_nodes, 10_000, "1 to 10000")?;
        check(
            (a.initial_nodes..=10_000).contains(&a.most_nodes),
            "aep.most_nodes",
            a.most_nodes as f64,
            "at least aep.initial_nodes and at most 10000",
        )?;
        count("aep.tries", a.tries, 1_000_000, "1 to 1000000")?;
        not_negative("aep.radius", a.radius)?;
        band("aep.heights", a.heights)?;
        let w = &self.wg_nbvp;
        for (f, m, v) in [w.measuring_weights, w.exploring_weights] {
            not_negative("wg_nbvp weights", f)?;
            not_negative("wg_nbvp weights", m)?;
            not_negative("wg_nbvp weights", v)?;
        }
        positive("wg_nbvp.most_measured", w.most_measured)?;
        positive("wg_nbvp.measured_radius", w.measured_radius)?;
        count("wg_nbvp.nodes", w.nodes, 10_000, "1 to 10000")?;
        count("wg_nbvp.tries", w.tries, 10_000, "1 to 10000")?;
        positive("wg_nbvp.step", w.step)?;
        positive("wg_nbvp.spacing", w.spacing)?;
        not_negative("wg_nbvp.radius", w.radius)?;
        positive("wg_nbvp.sampling_volume", w.sampling_volume)?;
        band("wg_nbvp.heights", w.heights)?;
        positive("wg_nbvp.reach", w.reach)?;
        positive("wg_nbvp.visited_cell", w.visited_cell)?;
        count("wg_nbvp.frontiers", w.frontiers, 10_000, "1 to 10000")?;
        count("wg_nbvp.cached", w.cached, 10_000, "1 to 10000")?;
        let s = &self.stand;
        count(
            "stand.distances",
            s.distances.len(),
            100,
            "1 to 100 distances",
        )?;
        for &d in &s.distances {
            not_negative("stand.distances", d)?;
        }
        count("stand.bearings", s.bearings, 360, "1 to 360")?;
        count("stand.yaws", s.yaws, 360, "1 to 360")?;
        count("stand.ways", s.ways, 100, "1 to 100")?;
        not_negative("stand.clearance", s.clearance)?;
        positive("stand.exclusion", s.exclusion)
    }
}
