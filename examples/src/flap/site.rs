//! What several searches of one scene share: what is known before, where the robot starts, the views and their travel
//! times. The paper's experiments share these among planners, so that these can be compared trial by trial.

use super::plans::FloorPlans;
use super::search::FlapError;
use super::settings::{FlapSettings, MapKind, TravelKind};
use super::space::{self, CELL, FIELD, RANGE, Space};
use crate::scene::Scene;
use crate::sim::World;
use cpu_time::ThreadTime;
use frontier::Fringe;
use objsearch::{GridPaths, Paths, Place, Regression, Speeds, TravelModel, TravelTable};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use robots::{LevelCamera, PanCamera};
use viewsample::flap::{Fan, FanPose, FanView, Limits, Target, ViewParams, sample_views};

/// A scene made ready for searches with one seed.
#[derive(Debug)]
pub struct Site {
    /// Name of the scene.
    pub name: String,
    pub(super) world: World,
    pub(super) paths: GridPaths,
    pub(super) space: Space,
    pub(super) robot: PanCamera,
    pub(super) limits: Limits,
    pub(super) fan: Fan,
    /// Where the robot is at first.
    pub(super) start: Place,
    /// Views that can be reached from the start.
    pub(super) views: Vec<FanView>,
    /// Views sampled, reachable or not.
    pub(super) sampled: usize,
    pub(super) table: TravelTable,
    /// CPU time to sample and evaluate the views, ms.
    pub views_ms: f64,
    /// CPU time to make the travel table, ms.
    pub table_ms: f64,
    key: (MapKind, u64, usize, usize, usize, u64),
}

impl Site {
    /// Makes a scene ready.
    ///
    /// # Errors
    /// [`FlapError`] for settings out of range, a scene without volumes or without a free place, or a map too large.
    pub fn new(scene: &Scene, settings: &FlapSettings) -> Result<Self, FlapError> {
        settings.validate()?;
        let world = World::new(scene);
        let plans = FloorPlans::of(scene)?;
        let mut paths = plans.paths()?;
        let (mut map, belief) = space::unknown(scene)?;
        match settings.map {
            MapKind::Known => {
                let volumes: Vec<_> = belief
                    .volumes()
                    .iter()
                    .map(|v| voxmap::CellBox {
                        low: v.low,
                        high: v.high,
                    })
                    .collect();
                space::know_all(&mut map, &world, &volumes);
                // The floor's layer of cells, as on maps raised from a plan.
                map.extrude(&[], 0, [0.0; 2], CELL, 0.0);
            }
            MapKind::Walls => space::know_walls(&mut map, &plans.walls),
        }
        let mut space = Space::new(
            map,
            &belief,
            settings.detection,
            settings.map == MapKind::Known,
        );
        let robot = PanCamera::default();
        let limits = Limits {
            range: RANGE,
            height: robot.heights(),
            pitch: robot.tilt_limits,
            vertical_fov: FIELD[1],
            ..Limits::default()
        };
        let fan = Fan::flap(RANGE.1, FIELD, CELL)?;
        let lap = ThreadTime::now();
        let targets = targets(&space);
        let views = sample(
            &mut space,
            &fan,
            &targets,
            &limits,
            settings,
            settings.seed,
            [0.0; 2],
        )?;
        let views_ms = 1e3 * lap.elapsed().as_secs_f64();
        let sampled = views.len();
        let places: Vec<Place> = views
            .iter()
            .map(|v| place(&robot, &v.pose))
            .collect::<Result<_, _>>()?;
        let start = start(&plans, &mut paths, &places, settings.seed)?;
        let reached = reachable(&start, &places, &mut paths);
        // One that cannot be reached may not stand for a group of those that can.
        let (views, places): (Vec<FanView>, Vec<Place>) = views
            .into_iter()
            .zip(places)
            .zip(reached)
            .filter_map(|(view, reached)| reached.then_some(view))
            .unzip();
        let lap = ThreadTime::now();
        let table = travel_table(&places, settings.clusters, &mut paths);
        let table_ms = 1e3 * lap.elapsed().as_secs_f64();
        Ok(Self {
            name: scene.name.clone(),
            world,
            paths,
            space,
            robot,
            limits,
            fan,
            start,
            views,
            sampled,
            table,
            views_ms,
            table_ms,
            key: key(settings),
        })
    }

    /// Whether a search with these settings can use this site.
    pub fn serves(&self, settings: &FlapSettings) -> bool {
        self.key == key(settings)
    }

    /// Number of sampled views that can be reached.
    pub fn view_count(&self) -> usize {
        self.views.len()
    }
}

fn key(s: &FlapSettings) -> (MapKind, u64, usize, usize, usize, u64) {
    (
        s.map,
        s.seed,
        s.samples,
        s.local_samples,
        s.clusters,
        s.detection.to_bits(),
    )
}

/// Cells to look at, with the side to look from.
pub(super) fn targets(space: &Space) -> Vec<Target> {
    let mut found = Vec::new();
    let inside = |cell| space.volumes.iter().any(|v| v.contains(cell));
    for volume in &space.volumes {
        for cell in space.fringe.targets(&space.map, (volume.low, volume.high)) {
            found.push(Target {
                center: space.map.center(cell),
                normal: Fringe::normal(&space.map, cell, inside),
            });
        }
    }
    found
}

/// Samples views; those that show nothing are kept, since the rest of the trial counts on their number.
pub(super) fn sample(
    space: &mut Space,
    fan: &Fan,
    targets: &[Target],
    limits: &Limits,
    settings: &FlapSettings,
    seed: u64,
    robot: [f64; 2],
) -> Result<Vec<FanView>, FlapError> {
    let params = ViewParams {
        count: settings.samples,
        local_count: settings.local_samples,
        keep_blind: true,
        seed,
    };
    let map = &space.map;
    let mut free = |pose: &FanPose| !map.is_occupied(map.cell_at(pose.position));
    let sight = &mut space.sight;
    Ok(sample_views(
        sight,
        fan,
        targets,
        limits,
        &params,
        robot,
        &mut free,
        &mut || false,
    )?)
}

/// Where the robot is when its camera is at a pose.
pub(super) fn place(robot: &PanCamera, pose: &FanPose) -> Result<Place, FlapError> {
    let camera = LevelCamera {
        position: pose.position,
        yaw: pose.yaw,
        pitch: pose.pitch,
    };
    let state = robot
        .reach(&camera)?
        .ok_or(FlapError::Unreachable(pose.position))?;
    Ok(Place {
        base: [state.base[0], state.base[1]],
        yaw: state.base[2],
        height: pose.position[2],
        pitch: state.tilt,
    })
}

pub(super) fn travel_table(
    places: &[Place],
    clusters: usize,
    paths: &mut GridPaths,
) -> TravelTable {
    if clusters == 0 {
        TravelTable::exact(places, paths)
    } else {
        TravelTable::clustered(places, clusters, paths)
    }
}

/// A start from which some view can be reached, drawn at random: the camera looks nowhere, the base stands ahead of it.
fn start(
    plans: &FloorPlans,
    paths: &mut GridPaths,
    views: &[Place],
    seed: u64,
) -> Result<Place, FlapError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let to: Vec<[f64; 2]> = views.iter().map(|v| v.base).collect();
    let mut costs = Vec::new();
    for _ in 0..100 {
        let draw = |n: usize, rng: &mut ChaCha8Rng| (rng.next_u64() % n.max(1) as u64) as usize;
        let [x, y] = plans.starts[draw(plans.starts.len(), &mut rng)];
        let place = Place {
            base: [x + PanCamera::default().base_ahead, y],
            height: plans.start_height,
            ..Place::default()
        };
        paths.from(place.base, &to, &mut costs);
        // With no view at all any place will do: the search then ends at once.
        if paths.is_passable(place.base) && (to.is_empty() || costs.iter().any(|c| c.is_finite())) {
            return Ok(place);
        }
    }
    Err(FlapError::Plans(super::plans::PlanError::NoStart))
}

/// Whether there is a way from `here` to each place.
pub(super) fn reachable(here: &Place, places: &[Place], paths: &mut GridPaths) -> Vec<bool> {
    let to: Vec<[f64; 2]> = places.iter().map(|p| p.base).collect();
    let mut costs = Vec::new();
    paths.from(here.base, &to, &mut costs);
    costs.iter().map(|cost| cost.is_finite()).collect()
}

/// The travel model of the settings.
#[derive(Clone, Debug)]
pub(super) enum Travel {
    Flap(Regression),
    Speeds(Speeds),
}

impl Travel {
    pub(super) fn of(settings: &FlapSettings) -> Self {
        match settings.travel {
            TravelKind::Flap => Self::Flap(Regression::default()),
            TravelKind::Speeds => Self::Speeds(Speeds::default()),
        }
    }
}

impl TravelModel for Travel {
    fn seconds(&self, path: f64, from: &Place, to: &Place) -> f64 {
        match self {
            Self::Flap(model) => model.seconds(path, from, to),
            Self::Speeds(model) => model.seconds(path, from, to),
        }
    }
}
