//! What a run tells its recorder. Nothing here changes the run; with a recorder that is off nothing is made.

use super::*;
use crate::clock::Stage;
use crate::record::{
    Begin, Candidate, CellRuns, CellState, CycleEvent, DecisionEvent, Event, FoundEvent,
    FrontierShape, FrontiersEvent, GivenUp, GivenUpEvent, GridShape, HorizonEvent, PlanEvent,
    PoseEvent, ProgressEvent, RECORD_SCHEMA, RegionsEvent, RobotShape, ScanEvent, StageCycle, View,
    round,
};
use crate::scene::Tag;
use crate::sim::{CameraPose, Detection, PointScan, State};
use frontier::{Cell, Kind};
use voxmap::CellBox;

/// Edge of the columns in which changed cells are looked for, cells.
const BRICK: usize = 8;
/// Time between recorded scans, s.
const SCAN_PERIOD: f64 = 1.0;
/// Most points of a recorded scan.
const SCAN_POINTS: usize = 400;
/// Time between recorded horizons, s.
const HORIZON_PERIOD: f64 = 0.4;
/// Every how many states of a path are recorded.
const PLAN_STRIDE: usize = 3;

/// The recorder, and what it was told last.
pub(crate) struct Tap<'a> {
    recorder: &'a mut dyn Recorder,
    on: bool,
    grid: GridShape,
    /// Layers in which faces are to be inspected.
    band: std::ops::Range<usize>,
    /// State of each voxel, as recorded.
    cells: Vec<u8>,
    /// Columns of cells in which something may have changed.
    touched: Vec<bool>,
    /// Region of each ground cell plus one, as recorded.
    labels: Vec<u32>,
    /// Cells of each cluster, as recorded.
    clusters: BTreeMap<u64, Vec<Cell>>,
    /// Samples of each stage, tags and given-up places that were recorded.
    laps: [usize; Stage::ALL.len()],
    found: usize,
    given_up: usize,
    next_scan: f64,
    next_horizon: f64,
}

impl<'a> Tap<'a> {
    pub(crate) fn new(
        recorder: &'a mut dyn Recorder,
        scene: &Scene,
        settings: &Settings,
        robot: &MobileManipulator,
        map: (&Mapper, (f64, f64)),
    ) -> Self {
        let title = (settings.planner.name(), settings.to_toml());
        Self::titled(recorder, scene, settings, title, robot, map)
    }

    /// As [`new`](Self::new) for a planner of that name with settings of its own as TOML text.
    pub(crate) fn titled(
        recorder: &'a mut dyn Recorder,
        scene: &Scene,
        settings: &Settings,
        (planner, text): (&str, String),
        robot: &MobileManipulator,
        (mapper, rgb): (&Mapper, (f64, f64)),
    ) -> Self {
        let on = recorder.is_on();
        let grid = GridShape {
            low: mapper.map.low(),
            cell_size: mapper.map.cell_size(),
            size: mapper.map.size(),
        };
        let [nx, ny, nz] = grid.size;
        let kept = |n: usize| if on { n } else { 0 };
        let (low, high) = settings.map.inspect_band;
        let layer = |v: f64| (v / grid.cell_size).clamp(0.0, nz as f64) as usize;
        let band = layer(low + 1e-9)..layer(high + grid.cell_size - 1e-9);
        let mut tap = Self {
            recorder,
            on,
            band,
            cells: vec![0; kept(grid.len())],
            touched: vec![false; kept(nx.div_ceil(BRICK) * ny.div_ceil(BRICK))],
            labels: vec![0; kept(nx * ny)],
            clusters: BTreeMap::new(),
            laps: [0; Stage::ALL.len()],
            found: 0,
            given_up: 0,
            next_scan: 0.0,
            next_horizon: 0.0,
            grid,
        };
        let base = robot.base_box([0.0; 3]);
        let corner = |side: f64| [0, 1, 2].map(|a| round(base.frame.p[a] + side * base.half[a]));
        tap.tell(0.0, || {
            Event::Begin(Box::new(Begin {
                schema: RECORD_SCHEMA.to_owned(),
                version: env!("CARGO_PKG_VERSION").to_owned(),
                system: "heats".to_owned(),
                planner: planner.to_owned(),
                sensors: match settings.sensors {
                    Sensors::Both => "both".to_owned(),
                    Sensors::Camera => "camera".to_owned(),
                },
                scene: scene.name.clone(),
                seed: settings.seed,
                settings: text,
                grid,
                layers: [0, nz],
                ground: crate::record::Ground::of(scene),
                robot: RobotShape {
                    joints: JOINT_NAMES.map(str::to_owned).to_vec(),
                    base: [corner(-1.0), corner(1.0)],
                    camera: [rgb.0, rgb.1],
                    range: mapper.inspect_range,
                },
                start: [scene.start.x, scene.start.y],
                volumes: Vec::new(),
            }))
        });
        tap
    }

    pub(crate) fn tell(&mut self, now: f64, event: impl FnOnce() -> Event) {
        if self.on {
            self.recorder.record(round(now), &event());
        }
    }

    pub(crate) fn pose(
        &mut self,
        now: f64,
        robot: &MobileManipulator,
        state: &State,
        camera: &CameraPose,
    ) {
        self.tell(now, || {
            let standing = BodyState {
                base: [0.0; 3],
                joints: state.joints,
            };
            let frames = robot.arm_frames(&standing);
            let lens = robot.camera_frame(&standing);
            Event::Pose(PoseEvent {
                base: state.base.map(round),
                joints: state.joints.map(round).to_vec(),
                arm: frames
                    .iter()
                    .chain([&lens])
                    .map(|f| f.p.map(round))
                    .collect(),
                camera: View::new(&camera.0, camera.1),
            })
        });
    }

    pub(crate) fn found(&mut self, now: f64, found: &[Detection], tags: &[Tag]) {
        for detection in found.iter().skip(self.found) {
            let center = tags.iter().find(|t| t.id == detection.id);
            self.tell(now, || {
                Event::Found(FoundEvent {
                    id: detection.id,
                    center: center.map_or([0.0; 3], |t| t.center),
                })
            });
        }
        self.found = found.len();
    }

    pub(crate) fn reached(&mut self, now: f64, camera: &CameraPose) {
        self.tell(now, || Event::Reached(View::new(&camera.0, camera.1)));
    }

    pub(crate) fn scan(&mut self, now: f64, sensor: &str, scan: &PointScan) {
        if !self.on || now < self.next_scan {
            return;
        }
        self.next_scan = now + SCAN_PERIOD - 1e-9;
        let stride = scan.hits.len().div_ceil(SCAN_POINTS).max(1);
        let centimetres = |v: f64| {
            (100.0 * v)
                .round()
                .clamp(f64::from(i16::MIN), f64::from(i16::MAX)) as i16
        };
        let points = scan.hits.iter().step_by(stride);
        self.tell(now, || {
            Event::Scan(ScanEvent {
                sensor: sensor.to_owned(),
                origin: scan.origin.map(round),
                points: points
                    .map(|p| [0, 1, 2].map(|a| centimetres(f64::from(p[a]) - scan.origin[a])))
                    .collect(),
            })
        });
    }

    /// Notes boxes of the map in which something may have changed.
    pub(crate) fn note(&mut self, boxes: &[CellBox]) {
        if !self.on {
            return;
        }
        let across = self.grid.size[0].div_ceil(BRICK);
        for b in boxes {
            let range = |a: usize| {
                let low = b.low[a].max(0) as usize;
                let high = (b.high[a].max(0) as usize).min(self.grid.size[a]);
                low / BRICK..high.div_ceil(BRICK)
            };
            for y in range(1) {
                self.touched[y * across..][range(0)].fill(true);
            }
        }
    }

    /// Voxels whose state is not what was recorded.
    fn cells(&mut self, now: f64, mapper: &Mapper) {
        let [nx, ny, nz] = self.grid.size;
        let across = nx.div_ceil(BRICK);
        let map = &mapper.map;
        let mut runs = CellRuns::default();
        for z in 0..nz {
            for y in 0..ny {
                let row = &self.touched[y / BRICK * across..][..across];
                for (brick, _) in row.iter().enumerate().filter(|(_, touched)| **touched) {
                    for x in brick * BRICK..((brick + 1) * BRICK).min(nx) {
                        let cell = [x as i32, y as i32, z as i32];
                        let state = if map.is_free(cell) {
                            CellState::Free
                        } else if !map.is_occupied(cell) {
                            CellState::Unknown
                        } else if self.band.contains(&z) && map.open_faces(cell) != 0 {
                            CellState::Open
                        } else if map.is_inspected(cell) {
                            CellState::Inspected
                        } else {
                            CellState::Occupied
                        } as u8;
                        let index = x + nx * (y + ny * z);
                        if std::mem::replace(&mut self.cells[index], state) != state {
                            runs.push(index as u32, u32::from(state));
                        }
                    }
                }
            }
        }
        self.touched.fill(false);
        if !runs.is_empty() {
            self.tell(now, || Event::Cells(runs));
        }
    }

    fn regions(&mut self, now: f64, mapper: &Mapper) {
        let Some(regions) = &mapper.regions else {
            return;
        };
        let [nx, ny, _] = self.grid.size;
        let mut cells = CellRuns::default();
        for y in 0..ny {
            for x in 0..nx {
                let label = regions.label([x as i32, y as i32]).map_or(0, |l| l + 1);
                let index = x + nx * y;
                if std::mem::replace(&mut self.labels[index], label) != label {
                    cells.push(index as u32, label);
                }
            }
        }
        if !cells.is_empty() {
            let center = |&id: &u32| regions.center(id).map(|c| (id, c.map(round)));
            let centers = regions.ids().iter().filter_map(center).collect();
            self.tell(now, || Event::Regions(RegionsEvent { cells, centers }));
        }
    }

    /// Clusters that are not what was recorded. Small ones ask for no view and are left out.
    fn frontiers(&mut self, now: f64, targets: &Targets) {
        let mut event = FrontiersEvent::default();
        let frontiers = targets.frontiers();
        let lives = |id: &u64| frontiers.get(*id).is_some_and(|c| !c.small);
        event
            .gone
            .extend(self.clusters.keys().filter(|id| !lives(id)));
        for id in &event.gone {
            self.clusters.remove(id);
        }
        for cluster in frontiers.clusters().filter(|c| !c.small) {
            if self.clusters.get(&cluster.id) != Some(&cluster.cells) {
                let cells = cluster.cells.iter().map(|&c| self.grid.index(c)).collect();
                event.clusters.push(FrontierShape::new(
                    cluster.id,
                    cluster.kind == Kind::Inspection,
                    cells,
                ));
                self.clusters.insert(cluster.id, cluster.cells.clone());
            }
        }
        if !event.gone.is_empty() || !event.clusters.is_empty() {
            self.tell(now, || Event::Frontiers(event));
        }
    }

    pub(crate) fn plan(
        &mut self,
        (now, ready): (f64, f64),
        robot: &MobileManipulator,
        path: &BodyPath,
        goal: &Pose,
    ) {
        self.tell(now, || {
            let last = path.base.len().saturating_sub(1);
            let kept = || {
                let states = path.base.iter().zip(&path.joints).enumerate();
                states.filter(|(i, _)| i % PLAN_STRIDE == 0 || *i == last)
            };
            let camera = |(_, (base, joints)): (usize, (&[f64; 3], &Joints))| {
                camera_at(robot, *base, joints).translation.map(round)
            };
            Event::Plan(PlanEvent {
                ready: round(ready),
                step: STEP * PLAN_STRIDE as f64,
                base: kept().map(|(_, (b, _))| b.map(round)).collect(),
                joints: kept().map(|(_, (_, j))| j.map(round).to_vec()).collect(),
                camera: kept().map(camera).collect(),
                goal: View::new(&goal.rotation, goal.translation),
            })
        });
    }

    pub(crate) fn horizon(&mut self, now: f64, controller: &Controller) {
        if self.on && now >= self.next_horizon {
            self.next_horizon = now + HORIZON_PERIOD - 1e-9;
            let base = controller.horizon().map(|p| p.map(round)).collect();
            self.tell(now, || Event::Horizon(HorizonEvent { base }));
        }
    }

    pub(crate) fn progress(
        &mut self,
        now: f64,
        (explored, inspected, found): (f64, f64, usize),
        activity: &str,
    ) {
        self.tell(now, || {
            Event::Progress(ProgressEvent {
                explored: round(explored),
                inspected: round(inspected),
                found,
                activity: activity.to_owned(),
            })
        });
    }

    fn cycle(&mut self, now: f64, watch: &Stopwatch) {
        let mut event = CycleEvent::default();
        for (stage, seen) in Stage::ALL.iter().zip(&mut self.laps) {
            let laps = watch.since(*stage, *seen);
            *seen += laps.len();
            if !laps.is_empty() {
                event.stages.push(StageCycle {
                    stage: stage.name().to_owned(),
                    calls: laps.len(),
                    total_ms: round(1e3 * laps.iter().sum::<f64>()),
                    max_ms: round(1e3 * laps.iter().copied().fold(0.0, f64::max)),
                });
            }
        }
        self.tell(now, || Event::Cycle(event));
    }

    /// Tells what of the map, the given-up places and the clock changed since the last call.
    pub(crate) fn state(
        &mut self,
        now: f64,
        mapper: &Mapper,
        given_up: &[GivenUp],
        watch: &Stopwatch,
    ) {
        if self.on {
            self.cells(now, mapper);
            self.given_up(now, given_up);
            self.cycle(now, watch);
        }
    }

    fn given_up(&mut self, now: f64, given_up: &[GivenUp]) {
        for place in given_up.iter().skip(self.given_up) {
            self.tell(now, || {
                Event::GivenUp(GivenUpEvent {
                    place: place.place.map(round),
                    voxels: place.voxels,
                    reason: place.reason.clone(),
                })
            });
        }
        self.given_up = given_up.len();
    }

    pub(crate) fn end(&mut self, now: f64, ended: Ended) {
        self.tell(now, || Event::End(ended.to_string()));
    }
}

/// Joints of the arm, as ROS drivers name them.
const JOINT_NAMES: [&str; 6] = [
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
];

impl Search<'_> {
    /// Tells what of the map and the clock changed since the last call.
    pub(crate) fn record_state(&mut self, now: f64) {
        let given_up = &self.failures.given_up;
        self.tap.state(now, &self.mapper, given_up, &self.watch);
    }

    pub(crate) fn record_decision(&mut self, now: f64, outcome: &Outcome, ahead: bool) {
        if !self.tap.on {
            return;
        }
        self.tap.regions(now, &self.mapper);
        self.tap.frontiers(now, &self.targets);
        let considered = &self.targets.considered;
        let regions = self.mapper.regions.as_ref();
        let candidate = |v: &viewsample::Viewpoint<Joints>| Candidate {
            base: v.base.map(round),
            view: View::new(&v.camera.rotation, v.camera.translation),
            gain: round(v.gain.info),
            seconds: round(v.seconds),
        };
        self.tap.tell(now, || {
            Event::Decision(DecisionEvent {
                outcome: match outcome {
                    Outcome::Go(_) => "go",
                    Outcome::Wait => "wait",
                    Outcome::Done => "done",
                }
                .to_owned(),
                ahead,
                candidates: considered.views.iter().map(candidate).collect(),
                chosen: considered.chosen,
                regions: considered
                    .regions
                    .iter()
                    .filter_map(|&r| regions?.ids().get(r).copied())
                    .collect(),
            })
        });
    }
}
