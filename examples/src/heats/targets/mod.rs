//! The target viewpoint planner: frontiers, viewpoint libraries, candidates, decision (HEATS sect. IV).

mod cover;

use crate::clock::{Stage, Stopwatch};
use crate::heats::body::{Joints, Whole};
use crate::heats::decision::{Considered, Stand, Ways, decide};
use crate::heats::failures::Failures;
use crate::heats::glance::Look;
use crate::heats::pace::Pace;
use crate::heats::settings::{Sensors, Settings};
use frontier::{Cell, Frontiers, Kind};
use robots::MobileManipulator;
use std::cell;
use std::collections::BTreeSet;
use viewsample::{
    Aim, Changes, Cluster, CostModel, Frustum, InverseReach, Params, Pose, Posture, Sampler,
    Viewpoint,
};
use voxmap::CellBox;

/// Voxel edge for which thresholds are given, m: smaller voxels ask for as many more.
const REFERENCE_CELL: f64 = 0.15;

/// Half the side of a target of which the last tries want to see all around a face, m: a tag of 16 cm in its middle.
const LAST_TARGET: f64 = 0.02;

/// How much flatter the last tries look at a face than what inspects it, rad: the surface may lie half a voxel behind it.
const LAST_INCIDENCE: f64 = 0.1;

/// Nearest that a camera is aimed at a face, m.
const NEAREST: f64 = 0.3;

/// What a UR5e on its pedestal reaches with the camera, generously: height and radius of a sphere around the base's axis, m.
const REACH: (f64, f64) = (0.66, 1.05);

/// Radius of the disc for which ways are measured: the base's half width with its clearance, m.
fn disc(whole: &Whole<'_>) -> f64 {
    0.5 * whole.robot.base.width + whole.base_clearance
}

/// Where to go next, and what is expected there.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Base pose of the library, yaw towards the cluster.
    pub base: [f64; 3],
    /// Arm posture of the library.
    pub joints: Joints,
    /// Camera pose wanted.
    pub camera: Pose,
    /// Information gain expected.
    pub info: f64,
    /// True for a last try with relaxed limits.
    pub relaxed: bool,
    /// Cells of the cluster it was chosen for.
    pub cells: Vec<Cell>,
}

/// What the planner found.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// Go there.
    Go(Box<Choice>),
    /// Nothing now, but excluded goals will be free again later.
    Wait,
    /// Nothing is left to see.
    Done,
}

/// The cells that a view must see for a cluster: the cells themselves for inspection, their unknown neighbours for exploration.
///
/// A free frontier cell can be in plain sight of where the robot already was, with its unknown side turned away, behind the edge
/// of an occluder; counting it would promise the same gain for ever.
fn to_see(map: &voxmap::VoxelMap, kind: Kind, cells: Vec<Cell>) -> Vec<Cell> {
    if kind == Kind::Inspection {
        return cells;
    }
    let bounds = map.bounds();
    let mut out: Vec<Cell> = cells
        .iter()
        .flat_map(|c| {
            [
                [-1, 0, 0],
                [1, 0, 0],
                [0, -1, 0],
                [0, 1, 0],
                [0, 0, -1],
                [0, 0, 1],
            ]
            .map(|f: Cell| [c[0] + f[0], c[1] + f[1], c[2] + f[2]])
        })
        .filter(|&n| bounds.contains(n) && !map.is_known(n))
        .collect();
    out.sort_unstable();
    out.dedup();
    out
}

/// A cluster as the sampler is told of it.
struct Held {
    id: u64,
    kind: Kind,
    /// What a view must see.
    cells: Vec<Cell>,
    /// Middle in the world, m.
    centroid: [f64; 3],
}

impl Held {
    /// `cells` are those of the cluster that are not given up.
    fn new(map: &voxmap::VoxelMap, cluster: &frontier::Cluster, cells: Vec<Cell>) -> Self {
        let (h, low) = (map.cell_size(), map.low());
        Self {
            id: cluster.id,
            kind: cluster.kind,
            cells: to_see(map, cluster.kind, cells),
            centroid: [0, 1, 2].map(|a| low[a] + cluster.centroid[a] * h),
        }
    }

    fn cluster(&self) -> Cluster<'_> {
        Cluster {
            id: self.id,
            kind: match self.kind {
                Kind::Exploration => viewsample::Kind::Exploration,
                Kind::Inspection => viewsample::Kind::Inspection,
            },
            cells: &self.cells,
            centroid: self.centroid,
        }
    }
}

/// Time to what can be reached and is not excluded; never for the rest.
struct Costs<'a> {
    pace: &'a Pace,
    ways: &'a Ways,
    failures: &'a Failures,
    now: f64,
    /// The last pair of places and the way between them: postures are asked for base by base.
    last: cell::Cell<Option<([[f64; 2]; 2], f64)>>,
}

impl CostModel<Joints> for Costs<'_> {
    fn seconds(&self, from: (&[f64; 3], &Joints), to: (&[f64; 3], &Joints)) -> f64 {
        let places = [from.0, to.0].map(|base| [base[0], base[1]]);
        let way = match self.last.get() {
            Some((same, way)) if same == places => way,
            _ if self.failures.excludes(places[1], self.now) => f64::INFINITY,
            _ => self.ways.meters(places[0], places[1]),
        };
        self.last.set(Some((places, way)));
        self.pace.seconds(way, from, to)
    }
}

/// Frontier cells in sight of a view; none for poses that are not finite.
fn seen(sampler: &Sampler<Joints>, base: [f64; 3], camera: &Pose) -> Vec<Cell> {
    let seen = sampler.seen_from(base, camera);
    seen.map_or_else(|_| Vec::new(), |s| [s.exploration, s.inspection].concat())
}

/// Information that a view brings for each second of its way, of which no more than `span` s count.
fn rate_of(view: &Viewpoint<Joints>, span: f64) -> f64 {
    view.gain.info / (view.seconds.min(span) + 0.5)
}

/// The planner's state.
pub struct Targets {
    frontiers: Frontiers,
    sampler: Sampler<Joints>,
    pending: Vec<CellBox>,
    first: bool,
    /// Ids that the sampler holds.
    held: BTreeSet<u64>,
    /// Cells of clusters that had their last try.
    tried: BTreeSet<Cell>,
    /// Whether the last choice was a last try.
    trying: bool,
    pace: Pace,
    cover: bool,
    cover_share: f64,
    cover_most: f64,
    rates: Vec<f64>,
    rate_span: f64,
    /// Views aimed at each cluster of the robot's region.
    aimed: usize,
    /// How views are aimed: at first, and in the last tries.
    aims: [Aim; 2],
    /// Where the base stands for a camera pose.
    reach: InverseReach,
    /// Views of the last cover, offered again.
    kept: Vec<Viewpoint<Joints>>,
    /// The views of the last cover that were chosen first, besides the one that is next in the tour.
    pub alternatives: Vec<Choice>,
    decisions: u64,
    /// How many views besides the next one of the tour are planned for.
    others: usize,
    seed: u64,
    /// Operations of the last decision, for the planner's account, s.
    pub counted: f64,
    /// What the last decision chose among, for the record.
    pub considered: Considered,
}

impl Targets {
    /// A planner that knows nothing yet. `postures` are the robot's camera postures.
    ///
    /// # Errors
    /// The crates' own messages for bad settings.
    pub fn new(
        settings: &Settings,
        robot: &MobileManipulator,
        pace: &Pace,
        postures: &[robots::Posture],
        cell_size: f64,
        inspect_range: f64,
        height: f64,
    ) -> Result<Self, String> {
        let f = &settings.frontier;
        let band = |(low, high): (f64, f64)| {
            (
                (low / cell_size + 1e-9).floor() as i32,
                (high.min(height) / cell_size - 1e-9).ceil() as i32,
            )
        };
        let frontiers = Frontiers::new(frontier::Params {
            exploration_size: f.exploration_size,
            exploration_extent: f.exploration_extent / cell_size,
            min_exploration: f.min_exploration,
            min_inspection: f.min_inspection,
            exploration_band: band(f.exploration_band),
            inspection_band: band(settings.map.inspect_band),
            normal_angle: f.normal_angle.to_radians(),
            inspection_radius: f.inspection_radius / cell_size,
            ..frontier::Params::default()
        })
        .map_err(|e| e.to_string())?;
        let v = &settings.views;
        let defaults = Params::default();
        let per_area = (REFERENCE_CELL / cell_size).powi(2);
        let params = Params {
            ring_min: v.ring_min,
            ring_max: v.ring_max.min(inspect_range - 0.5),
            lidar: defaults
                .lidar
                .filter(|_| settings.sensors == Sensors::Both)
                .map(|l| viewsample::Lidar {
                    offset: robot.base.lidar,
                    range: v.lidar_range,
                    ..l
                }),
            depth: Frustum {
                far: 4.0,
                ..defaults.depth
            },
            rgb: {
                let (across, down) = settings.map.rgb_field;
                Frustum::degrees(across, down, defaults.rgb.near, inspect_range)
            },
            target: Some(settings.map.target),
            motion_decay: v.motion_decay,
            exploration_weight: v.exploration_weight,
            inspection_weight: v.inspection_weight,
            level_weight: v.level_weight,
            cavity_weight: v.cavity_weight,
            threshold: v.threshold * per_area,
            // What is counted of an exploration frontier is its unknown side, so that nothing may block the way to it.
            unknown_allowance: 0,
            max_incidence: (settings.map.inspect_incidence < 90.0)
                .then(|| settings.map.inspect_incidence.to_radians()),
            most_looks: (v.most_looks > 0).then_some(v.most_looks),
            hold_share: (v.hold_share > 0.0).then_some(v.hold_share),
            relaxed: viewsample::Relaxed {
                threshold: v.relaxed_threshold * per_area,
                ..defaults.relaxed
            },
            ..defaults
        };
        let postures = postures
            .iter()
            .enumerate()
            .map(|(view, p)| Posture {
                view,
                camera: Pose {
                    rotation: p.camera.rows(),
                    translation: p.camera.p,
                },
                state: p.joints,
            })
            .collect();
        let sampler = Sampler::new(&params, postures).map_err(|e| e.to_string())?;
        Ok(Self {
            frontiers,
            sampler,
            pending: Vec::new(),
            first: true,
            held: BTreeSet::new(),
            tried: BTreeSet::new(),
            trying: false,
            pace: *pace,
            cover: settings.decision.cover,
            cover_share: settings.decision.cover_share,
            cover_most: settings.decision.cover_most * per_area,
            rates: settings
                .decision
                .rates
                .iter()
                .map(|r| r * per_area)
                .collect(),
            rate_span: settings.decision.rate_span,
            aimed: v.aimed,
            aims: [
                (v.aimed, v.threshold, 80, 3, 4.0_f64.to_radians()),
                (6, v.relaxed_threshold, 6000, 6, 0.02 - LAST_INCIDENCE),
            ]
            .map(|(views, threshold, tries, bases, slack)| Aim {
                // From where the arm can just hold a camera to where a target still fills enough of the image.
                distance: (NEAREST, (inspect_range - 0.3).clamp(NEAREST, 2.5)),
                // A little steeper than what counts, for the controller's sake.
                tilt: (settings.map.inspect_incidence.to_radians() - slack).clamp(0.02, 1.3),
                heights: (0.15, 1.7),
                reach: REACH,
                views,
                tries,
                bases,
                threshold: threshold * per_area,
                seed: settings.seed,
            }),
            reach: InverseReach::new(REACH.1),
            kept: Vec::new(),
            alternatives: Vec::new(),
            decisions: 0,
            others: settings.decision.others,
            seed: settings.seed,
            counted: 0.0,
            considered: Considered::default(),
        })
    }

    /// Notes boxes of the map that changed.
    pub fn note(&mut self, boxes: Vec<CellBox>) {
        self.pending.extend(boxes);
    }

    /// Brings frontiers and libraries up to date with the map.
    ///
    /// # Errors
    /// The sampler's own message.
    pub fn update(
        &mut self,
        whole: &Whole<'_>,
        failures: &Failures,
        watch: &mut Stopwatch,
    ) -> Result<(), String> {
        let map = &whole.mapper.map;
        let mut boxes = std::mem::take(&mut self.pending);
        if self.first {
            boxes = vec![map.bounds()];
            self.first = false;
        }
        boxes.sort_unstable();
        boxes.dedup();
        let boxes: Vec<(Cell, Cell)> = boxes.into_iter().map(|b| (b.low, b.high)).collect();
        let (update, _) = watch.time(Stage::Frontier, || self.frontiers.update(map, &boxes));
        let (result, _) = watch.time(Stage::Viewpoints, || {
            // Given-up cells are no frontier for the sampler.
            let mut kept: Vec<Held> = Vec::new();
            let mut gone: Vec<u64> = update
                .removed
                .iter()
                .copied()
                .filter(|id| self.held.remove(id))
                .collect();
            for id in update.added.iter().chain(&update.changed) {
                let Some(c) = self.frontiers.get(*id) else {
                    continue;
                };
                let cells: Vec<Cell> = c
                    .cells
                    .iter()
                    .copied()
                    .filter(|&c| !failures.is_given_up(c))
                    .collect();
                if c.small || cells.len() * 2 < c.cells.len().min(6) {
                    if self.held.remove(id) {
                        gone.push(*id);
                    }
                    continue;
                }
                self.held.insert(*id);
                kept.push(Held::new(map, c, cells));
            }
            gone.sort_unstable();
            gone.dedup();
            let added: Vec<Cluster<'_>> = kept.iter().map(Held::cluster).collect();
            self.sampler.update(
                map,
                &Changes {
                    added: &added,
                    removed: &gone,
                    boxes: &boxes,
                },
            )
        });
        result.map_err(|e| e.to_string())
    }

    /// Least information gain of a view.
    pub fn threshold(&self) -> f64 {
        self.sampler.params().threshold
    }

    /// Information gain that is left at a view.
    pub fn gain_at(&self, base: [f64; 3], camera: &Pose) -> f64 {
        self.sampler.gain_at(base, camera).map_or(0.0, |g| g.info)
    }

    /// Information gain of what the cameras see along a way.
    pub fn gain_along(&self, way: &[([f64; 3], Pose)]) -> f64 {
        self.sampler.gain_along(way).map_or(0.0, |g| g.info)
    }

    /// Frontier cells in sight of a view.
    pub fn seen_from(&self, base: [f64; 3], camera: &Pose) -> Vec<Cell> {
        seen(&self.sampler, base, camera)
    }

    /// Takes given-up cells out of the libraries.
    ///
    /// # Errors
    /// The sampler's own message.
    pub fn drop_given_up(&mut self, whole: &Whole<'_>, failures: &Failures) -> Result<(), String> {
        let map = &whole.mapper.map;
        let mut kept: Vec<Held> = Vec::new();
        let mut gone = Vec::new();
        for c in self.frontiers.clusters() {
            if !self.held.contains(&c.id) || !c.cells.iter().any(|&c| failures.is_given_up(c)) {
                continue;
            }
            let cells: Vec<Cell> = c
                .cells
                .iter()
                .copied()
                .filter(|&c| !failures.is_given_up(c))
                .collect();
            if cells.len() < 3 {
                gone.push(c.id);
            } else {
                kept.push(Held::new(map, c, cells));
            }
        }
        for id in &gone {
            self.held.remove(id);
        }
        let added: Vec<Cluster<'_>> = kept.iter().map(Held::cluster).collect();
        self.sampler
            .update(
                map,
                &Changes {
                    added: &added,
                    removed: &gone,
                    boxes: &[],
                },
            )
            .map_err(|e| e.to_string())
    }

    /// Chooses the next viewpoint (sect. IV-B and IV-C).
    /// `robot` is where it is, or will be when it has taken the looks `before`; `rest` where it would come to rest.
    ///
    /// # Errors
    /// The crates' own messages.
    pub fn choose(
        &mut self,
        whole: &Whole<'_>,
        failures: &mut Failures,
        robot: ([f64; 3], Joints),
        (rest, before): ([f64; 2], &[Look]),
        now: f64,
        watch: &mut Stopwatch,
    ) -> Result<Outcome, String> {
        self.considered = Considered::default();
        self.alternatives.clear();
        self.decisions += 1;
        let ways = Ways::new(whole.mapper, disc(whole)).map_err(|e| e.to_string())?;
        let pace = self.pace;
        let mut relaxed = false;
        let (found, _) = watch.time(Stage::Viewpoints, || {
            let costs = Costs {
                pace: &pace,
                ways: &ways,
                failures,
                now,
                last: cell::Cell::default(),
            };
            self.sampler.candidates(whole, &costs, robot.0, &robot.1)
        });
        let found = found.map_err(|e| e.to_string())?;
        let mut effort = found.effort;
        let mut views = found.views;
        if !self.cover {
            let rate = self.round(&views);
            views.retain(|v| rate_of(v, self.rate_span) >= rate);
        }
        if self.cover && (self.aimed > 0 || !views.is_empty()) {
            let costs = Costs {
                pace: &pace,
                ways: &ways,
                failures,
                now,
                last: cell::Cell::default(),
            };
            let (covered, _) = watch.time(Stage::Viewpoints, || {
                self.fewest(
                    whole,
                    &costs,
                    &robot,
                    (rest, before),
                    views.clone(),
                    &mut effort,
                )
            });
            let covered = covered?;
            if !covered.is_empty() || !before.is_empty() {
                views = covered;
            }
        }
        if views.is_empty() {
            // Ahead of arrival only a last try leads to another: before the first, all is asked again from where the robot is.
            if (before.is_empty() && failures.lift(now)) || (!before.is_empty() && !self.trying) {
                return Ok(Outcome::Wait);
            }
            let costs = Costs {
                pace: &pace,
                ways: &ways,
                failures,
                now,
                last: cell::Cell::default(),
            };
            let ids: Vec<u64> = found.without.iter().map(|w| w.0).collect();
            let (last, _) = watch.time(Stage::Viewpoints, || {
                if self.aimed > 0 {
                    self.last_tries(&ids, whole, &costs, &robot, (rest, before))
                } else if before.is_empty() {
                    self.retry(&ids, whole, &costs, &robot)
                } else {
                    Ok(Default::default())
                }
            });
            let (last, spent) = last?;
            effort += spent;
            views = last;
            relaxed = true;
            // What is left here is not known before the looks are taken.
            if views.is_empty() && !before.is_empty() {
                return Ok(Outcome::Wait);
            }
        }
        self.counted = 0.005
            + 15e-6 * effort.camera_views as f64
            + 100e-6 * effort.lidar_views as f64
            + 2e-6 * effort.body_checks as f64;
        if views.is_empty() {
            return Ok(Outcome::Done);
        }
        let stands: Vec<Stand> = views
            .iter()
            .map(|v| Stand {
                base: v.base,
                joints: v.state,
            })
            .collect();
        let params = atsp::Params {
            kicks: 300,
            seed: self.seed,
            ..atsp::Params::default()
        };
        let (choice, _) = watch.time(Stage::Decision, || {
            decide(whole.mapper, &ways, &pace, robot, &stands, &params)
        });
        self.counted += 1e-3 * ways.count() as f64 + 20e-6 * stands.len() as f64;
        let Some(choice) = choice.map_err(|e| e.to_string())? else {
            return Ok(Outcome::Done);
        };
        let Some(view) = views.get(choice.candidate) else {
            return Ok(Outcome::Done);
        };
        let next = self.choice_of(view, relaxed);
        let others: Vec<_> = self
            .kept
            .iter()
            .filter(|v| (v.base, &v.camera) != (view.base, &view.camera))
            .take(self.others)
            .cloned()
            .collect();
        self.alternatives = others.iter().map(|v| self.choice_of(v, relaxed)).collect();
        self.trying = relaxed;
        self.considered = Considered {
            views,
            chosen: Some(choice.candidate),
            regions: choice.region_order,
        };
        Ok(Outcome::Go(Box::new(next)))
    }

    /// Notes that a view is gone to, or cannot be: a last try is made once.
    pub fn set_out(&mut self, choice: &Choice) {
        if choice.relaxed {
            self.tried.extend(choice.cells.iter().copied());
        }
    }

    fn choice_of(&mut self, view: &Viewpoint<Joints>, relaxed: bool) -> Choice {
        let cells = match view.cluster.and_then(|id| self.frontiers.get(id)) {
            Some(cluster) if self.aimed == 0 => cluster.cells.clone(),
            _ if relaxed => {
                let incidence = self.last_incidence();
                let (base, camera) = (view.base, &view.camera);
                self.sampler
                    .with_limits(Some(LAST_TARGET), incidence, |s| seen(s, base, camera))
                    .unwrap_or_default()
            }
            _ => self.seen_from(view.base, &view.camera),
        };
        Choice {
            base: view.base,
            joints: view.state,
            camera: view.camera,
            info: view.gain.info,
            relaxed,
            cells,
        }
    }

    /// The inspection clusters that are left, as centre (m) and cells.
    pub fn leftovers(&self, whole: &Whole<'_>) -> Vec<([f64; 3], Vec<Cell>)> {
        let map = &whole.mapper.map;
        self.frontiers
            .clusters()
            .filter(|c| c.kind == Kind::Inspection && !c.small)
            .map(|c| {
                (
                    [0, 1, 2].map(|a| map.low()[a] + c.centroid[a] * map.cell_size()),
                    c.cells.clone(),
                )
            })
            .collect()
    }

    /// The frontiers, for the record.
    pub fn frontiers(&self) -> &Frontiers {
        &self.frontiers
    }

    /// Clusters held, for the record.
    pub fn len(&self) -> usize {
        self.sampler.len()
    }

    /// True if no cluster is held.
    pub fn is_empty(&self) -> bool {
        self.sampler.is_empty()
    }
}
