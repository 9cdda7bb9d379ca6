//! What a search tells its recorder. Nothing here changes the search.

use super::record::FlapResult;
use super::search::Progress;
use super::settings::FlapSettings;
use super::site::Site;
use super::space::{FIELD, RANGE, Seen};
use crate::record::{
    Begin, CellRuns, CellState, Event, GridShape, LookEvent, RECORD_SCHEMA, Recorder, RobotShape,
    View, VolumeShape, round,
};
use crate::scene::Scene;
use std::cell::RefCell;
use viewsample::flap::FanPose;
use voxmap::VoxelMap;

/// Half the edges of a PR2's base, m.
const BASE: [f64; 2] = [0.334, 0.334];

/// Heights between which pictures from above show the map: without floor and ceiling, m.
const SHOWN: [f64; 2] = [0.1, 2.0];

/// The recorder, and the look that is under way.
pub(super) struct Tap<'a>(RefCell<State<'a>>);

struct State<'a> {
    recorder: &'a mut dyn Recorder,
    pending: Option<Pending>,
    time: f64,
}

/// A look whose probability is not known yet.
struct Pending {
    base: [f64; 2],
    camera: View,
    cells: CellRuns,
    count: usize,
}

fn view(pose: &FanPose) -> View {
    let frame = robots::looking(pose.position, pose.yaw, pose.pitch);
    View::new(&frame.rows(), pose.position)
}

fn grid(map: &VoxelMap) -> GridShape {
    GridShape {
        low: map.low(),
        cell_size: map.cell_size(),
        size: map.size(),
    }
}

/// States of cells, given in any order; those outside the map's size are left out.
fn runs(map: &VoxelMap, cells: impl Iterator<Item = [i32; 3]>) -> CellRuns {
    let grid = grid(map);
    let low = map.bounds().low;
    let mut states: Vec<(u32, CellState)> = cells
        .map(|cell| {
            let state = if map.is_free(cell) {
                CellState::Free
            } else if map.is_occupied(cell) {
                CellState::Occupied
            } else {
                CellState::Unknown
            };
            (grid.index([0, 1, 2].map(|a| cell[a] - low[a])), state)
        })
        .collect();
    states.sort_unstable();
    let mut runs = CellRuns::default();
    for (index, state) in states {
        runs.push(index, state as u32);
    }
    runs
}

impl<'a> Tap<'a> {
    pub(super) fn new(recorder: &'a mut dyn Recorder) -> Self {
        Self(RefCell::new(State {
            recorder,
            pending: None,
            time: 0.0,
        }))
    }

    pub(super) fn begin(&self, scene: &Scene, settings: &FlapSettings, site: &Site) {
        let mut state = self.0.borrow_mut();
        if !state.recorder.is_on() {
            return;
        }
        let map = &site.space.map;
        let event = Event::Begin(Box::new(Begin {
            schema: RECORD_SCHEMA.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            system: "flap".to_owned(),
            planner: settings.planner.name().to_owned(),
            sensors: "camera".to_owned(),
            scene: scene.name.clone(),
            seed: settings.seed,
            settings: settings.to_toml(),
            grid: grid(map),
            layers: SHOWN.map(|z| {
                let layer = ((z - map.low()[2]) / map.cell_size()).round();
                (layer.max(0.0) as usize).min(map.size()[2])
            }),
            ground: crate::record::Ground::of(scene),
            robot: RobotShape {
                joints: Vec::new(),
                base: [[-BASE[0], -BASE[1], 0.0], [BASE[0], BASE[1], 0.3]],
                camera: FIELD.map(|f| round((0.5 * f).tan())),
                range: RANGE.1,
            },
            start: site.start.base.map(round),
            volumes: scene
                .target_volumes
                .iter()
                .map(|v| VolumeShape {
                    name: v.name.clone(),
                    low: v.min,
                    high: v.max,
                    probability: v.p,
                })
                .collect(),
        }));
        state.recorder.record(0.0, &event);
        let b = map.bounds();
        let all = (b.low[2]..b.high[2]).flat_map(|z| {
            (b.low[1]..b.high[1]).flat_map(move |y| (b.low[0]..b.high[0]).map(move |x| [x, y, z]))
        });
        let known = runs(map, all.filter(|&c| map.is_known(c)));
        state.recorder.record(0.0, &Event::Cells(known));
        let sampled = site.views.iter().map(|v| view(&v.pose)).collect();
        state.recorder.record(0.0, &Event::Sampled(sampled));
    }

    /// Notes a look that was taken.
    pub(super) fn look(&self, map: &VoxelMap, seen: &Seen, pose: &FanPose, base: [f64; 2]) {
        let mut state = self.0.borrow_mut();
        if state.recorder.is_on() {
            state.pending = Some(Pending {
                base: base.map(round),
                camera: view(pose),
                cells: runs(map, seen.cells.iter().copied()),
                count: seen.cells.len(),
            });
        }
    }

    /// Tells the noted look, now that its time and probability are known.
    pub(super) fn looked(&self, step: &objsearch::Step, now: &Progress) {
        let mut state = self.0.borrow_mut();
        let Some(look) = state.pending.take() else {
            return;
        };
        state.time = round(step.time);
        let time = state.time;
        state.recorder.record(time, &Event::Cells(look.cells));
        let event = Event::Look(LookEvent {
            view: step.view,
            base: look.base,
            camera: look.camera,
            before: step.probability_before,
            probability: step.probability,
            expected_time: round(now.expected_time),
            planned: step.planned,
            planned_time: round(step.planned_time),
            cells: look.count,
        });
        state.recorder.record(time, &event);
    }

    pub(super) fn end(&self, time: f64, result: &FlapResult) {
        let mut state = self.0.borrow_mut();
        if state.recorder.is_on() {
            let time = round(time).max(state.time);
            let text = format!("{}: {}", result.ended, result.reason);
            state.recorder.record(time, &Event::End(text));
        }
    }
}
