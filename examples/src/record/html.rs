//! `report.html`: one file that shows a run at any moment, without network or library.

use super::columns::{Columns, FrontierColumns};
use super::document::{document, fill};
use super::event::{Begin, DecisionEvent, Event, LookEvent, PlanEvent, PoseEvent, View};
use super::pack::{Pack, Table};
use super::recorder::Recorder;
use super::write_file;
use super::{WriteError, round};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Name of the file in a run's folder.
pub const REPORT_FILE: &str = "report.html";

const BODY: &str = include_str!("page/report.html");
const STYLE: &str = include_str!("page/page.css");
const SCRIPT: &str = include_str!("page/report.js");
const DECODE: &str = include_str!("page/decode.js");

/// Rows of a table above which every second one goes.
const ROWS: usize = 12_000;
/// Bytes of a list of events above which only every second further one is kept.
const BYTES: usize = 400_000;
/// Knots kept of a horizon.
const KNOTS: usize = 12;

fn milli(v: f64) -> i32 {
    (1000.0 * v).round() as i32
}

fn centi(v: f64) -> i32 {
    (100.0 * v).round() as i32
}

/// Rows that come at equal times: when there are too many, every second one goes, and from then on every second is kept.
#[derive(Debug)]
struct Thinned {
    table: Table,
    stride: usize,
    seen: usize,
}

impl Thinned {
    fn new(columns: usize) -> Self {
        Self {
            table: Table::new(columns),
            stride: 1,
            seen: 0,
        }
    }

    fn row(&mut self, row: impl IntoIterator<Item = i32>) {
        if self.seen.is_multiple_of(self.stride) {
            self.table.row(row);
            if self.table.rows() > ROWS {
                self.table.thin();
                self.stride *= 2;
            }
        }
        self.seen += 1;
    }
}

/// Events of unequal length, each with its time.
#[derive(Debug, Default)]
struct Events {
    pack: Pack,
    before: i64,
    stride: usize,
    seen: usize,
}

impl Events {
    /// The packer of an event, or none if it is to be left out.
    fn at(&mut self, time: f64) -> Option<&mut Pack> {
        self.seen += 1;
        if self.pack.len() > BYTES << self.stride.min(40) {
            self.stride += 1;
        }
        if !self.seen.is_multiple_of(1 << self.stride.min(40)) {
            return None;
        }
        Some(self.always(time))
    }

    fn always(&mut self, time: f64) -> &mut Pack {
        let now = i64::from(milli(time));
        self.pack.int(now - self.before);
        self.before = now;
        &mut self.pack
    }
}

/// Values of cells that changed: gap to the last change, length, value.
fn runs(pack: &mut Pack, changes: impl Iterator<Item = (u32, i64)>) {
    let mut list: Vec<[i64; 3]> = Vec::new();
    for (index, value) in changes {
        let index = i64::from(index);
        match list.last_mut() {
            Some([first, length, same]) if *same == value && *first + *length == index => {
                *length += 1;
            }
            _ => list.push([index, 1, value]),
        }
    }
    pack.int(list.len() as i64);
    let mut end = 0;
    for [first, length, value] in list {
        pack.int(first - end);
        pack.int(length);
        pack.int(value);
        end = first + length;
    }
}

fn view(v: &View) -> [i32; 7] {
    let [x, y, z] = v.p.map(centi);
    // One sign for each orientation, so that neighbours differ little.
    let sign = if v.q[3] < 0.0 { -1.0 } else { 1.0 };
    let [a, b, c, d] = v.q.map(|q| (500.0 * sign * q).round() as i32);
    [x, y, z, a, b, c, d]
}

/// Makes `report.html` of a recording.
#[derive(Debug)]
pub struct Html {
    /// Folder of the report, if it is to be written.
    path: Option<PathBuf>,
    result: Option<Value>,
    begin: Option<Box<Begin>>,
    columns: Columns,
    shown: Vec<u8>,
    frontier_columns: FrontierColumns,
    frontier_shown: Vec<u8>,
    poses: Option<Thinned>,
    cells: Events,
    /// Columns in which looks of a FLAP search saw something.
    seen: Events,
    frontiers: Events,
    regions: Events,
    decisions: Events,
    plans: Events,
    horizons: Events,
    reached: Table,
    progress: Thinned,
    activities: Vec<String>,
    cycles: BTreeMap<String, Thinned>,
    found: Vec<Value>,
    given_up: Vec<Value>,
    sampled: Vec<View>,
    looks: Vec<Value>,
    /// Known voxels of each volume, and all.
    volumes: Vec<[usize; 2]>,
    volumes_at_start: Vec<f64>,
    ended: Option<String>,
    last: f64,
}

impl Html {
    /// A report in `folder`. `result` is what `result.json` holds, if there is one.
    pub fn new(folder: &Path, result: Option<Value>) -> Self {
        Self {
            path: Some(folder.to_owned()),
            result,
            ..Self::unwritten()
        }
    }

    /// A report that is kept in memory, to be had from [`page`](Self::page).
    pub fn unwritten() -> Self {
        Self {
            path: None,
            result: None,
            begin: None,
            columns: Columns::default(),
            shown: Vec::new(),
            frontier_columns: FrontierColumns::default(),
            frontier_shown: Vec::new(),
            poses: None,
            cells: Events::default(),
            seen: Events::default(),
            frontiers: Events::default(),
            regions: Events::default(),
            decisions: Events::default(),
            plans: Events::default(),
            horizons: Events::default(),
            reached: Table::new(8),
            progress: Thinned::new(5),
            activities: Vec::new(),
            cycles: BTreeMap::new(),
            found: Vec::new(),
            given_up: Vec::new(),
            sampled: Vec::new(),
            looks: Vec::new(),
            volumes: Vec::new(),
            volumes_at_start: Vec::new(),
            ended: None,
            last: 0.0,
        }
    }

    fn pose(&mut self, time: f64, pose: &PoseEvent) {
        let [x, y, yaw] = pose.base;
        let head = [milli(time), centi(x), centi(y), milli(yaw)];
        let arm = pose.arm.iter().flatten().map(|&v| centi(v));
        let row = head.into_iter().chain(view(&pose.camera)).chain(arm);
        let width = 11 + 3 * pose.arm.len();
        self.poses
            .get_or_insert_with(|| Thinned::new(width))
            .row(row);
    }

    fn map(&mut self, time: f64) {
        let mut changed = Vec::new();
        let touched = self.columns.take_changed();
        if time > 0.0 && self.begin.as_ref().is_some_and(|b| b.system == "flap") {
            runs(self.seen.always(time), touched.iter().map(|&c| (c, 1)));
        }
        for column in touched {
            let class = self.columns.class(column) as u8;
            if let Some(was) = self.shown.get_mut(column as usize)
                && std::mem::replace(was, class) != class
            {
                changed.push((column, i64::from(class)));
            }
        }
        if !changed.is_empty() {
            runs(self.cells.always(time), changed.into_iter());
        }
    }

    fn frontier_map(&mut self, time: f64) {
        let mut changed = Vec::new();
        for column in self.frontier_columns.take_changed() {
            let bits = self.frontier_columns.bits(column);
            if let Some(was) = self.frontier_shown.get_mut(column as usize)
                && std::mem::replace(was, bits) != bits
            {
                changed.push((column, i64::from(bits)));
            }
        }
        if !changed.is_empty() {
            runs(self.frontiers.always(time), changed.into_iter());
        }
    }

    fn decision(&mut self, time: f64, event: &DecisionEvent) {
        let Some(pack) = self.decisions.at(time) else {
            return;
        };
        pack.int(match event.outcome.as_str() {
            "go" => 0,
            "wait" => 1,
            _ => 2,
        });
        pack.int(i64::from(event.ahead));
        pack.int(event.chosen.map_or(0, |c| c as i64 + 1));
        let mut rows: Vec<i64> = Vec::new();
        for c in &event.candidates {
            rows.extend(view(&c.view).map(i64::from));
            rows.extend([c.base[0], c.base[1]].map(|v| i64::from(centi(v))));
            rows.extend([c.gain, 10.0 * c.seconds].map(|v| v.round() as i64));
        }
        pack.list(&rows, 11);
        let regions: Vec<i64> = event.regions.iter().map(|&r| i64::from(r)).collect();
        pack.list(&regions, 1);
    }

    fn plan(&mut self, time: f64, event: &PlanEvent) {
        let Some(pack) = self.plans.at(time) else {
            return;
        };
        pack.int(i64::from(milli(event.ready - time)));
        pack.int(i64::from(milli(event.step)));
        let mut rows: Vec<i64> = Vec::new();
        for (base, camera) in event.base.iter().zip(&event.camera) {
            rows.extend([base[0], base[1]].map(|v| i64::from(centi(v))));
            rows.extend(camera.map(|v| i64::from(centi(v))));
        }
        pack.list(&rows, 5);
        for v in view(&event.goal) {
            pack.int(i64::from(v));
        }
    }

    fn look(&mut self, time: f64, look: &LookEvent) {
        let shares = self.shares();
        self.looks.push(json!({
            "t": time, "view": look.view, "base": look.base, "camera": look.camera, "before": look.before,
            "probability": look.probability, "expected": look.expected_time, "planned": look.planned,
            "plannedTime": look.planned_time, "cells": look.cells, "seen": shares,
        }));
    }

    /// Known share of each volume.
    fn shares(&self) -> Vec<f64> {
        let share = |[known, all]: &[usize; 2]| round(*known as f64 / (*all).max(1) as f64);
        self.volumes.iter().map(share).collect()
    }

    /// Counts what is known of each volume.
    fn count_volumes(&mut self) {
        let Some(begin) = &self.begin else { return };
        let grid = self.columns.grid();
        let cells = self.columns.cells();
        self.volumes = begin
            .volumes
            .iter()
            .map(|volume| {
                let range = |a: usize| {
                    // Cells whose centre lies inside.
                    let index = |v: f64| ((v - grid.low[a]) / grid.cell_size + 0.5).floor();
                    let size = grid.size[a] as f64;
                    index(volume.low[a]).clamp(0.0, size) as usize
                        ..index(volume.high[a]).clamp(0.0, size) as usize
                };
                let mut count = [0, 0];
                for z in range(2) {
                    for y in range(1) {
                        for x in range(0) {
                            let index = x + grid.size[0] * (y + grid.size[1] * z);
                            count[0] += usize::from(cells[index] != 0);
                            count[1] += 1;
                        }
                    }
                }
                count
            })
            .collect();
    }

    /// What the page is made of, or none if nothing was recorded.
    fn data(&self) -> Option<Value> {
        let begin = self.begin.as_ref()?;
        let stages: BTreeMap<&String, String> = self
            .cycles
            .iter()
            .map(|(name, table)| (name, table.table.text()))
            .collect();
        let sampled: Vec<i64> = self
            .sampled
            .iter()
            .flat_map(|v| view(v).map(i64::from))
            .collect();
        let mut views = Pack::default();
        views.list(&sampled, 7);
        Some(json!({
            "begin": begin,
            "ended": self.ended,
            "last": self.last,
            "result": self.result,
            "poses": self.poses.as_ref().map(|p| p.table.text()),
            "cells": self.cells.pack.text(),
            "seen": self.seen.pack.text(),
            "volumesAtStart": self.volumes_at_start,
            "frontiers": self.frontiers.pack.text(),
            "regions": self.regions.pack.text(),
            "decisions": self.decisions.pack.text(),
            "plans": self.plans.pack.text(),
            "horizons": self.horizons.pack.text(),
            "reached": self.reached.text(),
            "progress": self.progress.table.text(),
            "activities": self.activities,
            "stages": stages,
            "found": self.found,
            "givenUp": self.given_up,
            "sampled": views.text(),
            "looks": self.looks,
        }))
    }

    /// Takes in what `result.json` holds.
    pub fn set_result(&mut self, result: Value) {
        self.result = Some(result);
    }

    /// The page as text, or none if nothing was recorded.
    pub fn page(&self) -> Option<String> {
        let begin = self.begin.as_ref()?;
        let title = format!("{} · {} · seed {}", begin.system, begin.scene, begin.seed);
        // Inside a script element nothing but `<` can end it.
        let data = self.data()?.to_string().replace('<', "\\u003c");
        let parts = [("data", data), ("script", [DECODE, SCRIPT].concat())];
        Some(document(&title, STYLE, &fill(BODY, &parts)))
    }
}

impl Recorder for Html {
    fn record(&mut self, time: f64, event: &Event) {
        self.last = self.last.max(time);
        match event {
            Event::Begin(begin) => {
                self.columns = Columns::new(begin.grid, begin.layers);
                self.frontier_columns = FrontierColumns::new(&begin.grid);
                let columns = begin.grid.size[0] * begin.grid.size[1];
                self.shown = vec![0; columns];
                self.frontier_shown = vec![0; columns];
                self.begin = Some(begin.clone());
            }
            Event::Pose(pose) => self.pose(time, pose),
            Event::Cells(cells) => {
                self.columns.apply(cells);
                self.map(time);
                self.count_volumes();
                if time <= 0.0 {
                    self.volumes_at_start = self.shares();
                }
            }
            Event::Regions(regions) => {
                let pack = self.regions.always(time);
                let cells = regions.cells.iter();
                runs(pack, cells.map(|(i, v)| (i, i64::from(v))));
                let centers: Vec<i64> = regions
                    .centers
                    .iter()
                    .flat_map(|(id, c)| {
                        [
                            i64::from(*id),
                            i64::from(centi(c[0])),
                            i64::from(centi(c[1])),
                        ]
                    })
                    .collect();
                pack.list(&centers, 3);
            }
            Event::Frontiers(event) => {
                self.frontier_columns.apply(event);
                self.frontier_map(time);
            }
            Event::Decision(event) => self.decision(time, event),
            Event::Plan(event) => self.plan(time, event),
            Event::Horizon(event) => {
                if let Some(pack) = self.horizons.at(time) {
                    let stride = event.base.len().div_ceil(KNOTS).max(1);
                    let last = event.base.len().saturating_sub(1);
                    let kept = event.base.iter().enumerate();
                    let rows: Vec<i64> = kept
                        .filter(|(i, _)| i % stride == 0 || *i == last)
                        .flat_map(|(_, p)| [p[0], p[1]].map(|v| i64::from(centi(v))))
                        .collect();
                    pack.list(&rows, 2);
                }
            }
            Event::Reached(v) => {
                self.reached.row([milli(time)].into_iter().chain(view(v)));
            }
            Event::Found(tag) => {
                self.found
                    .push(json!({"t": time, "id": tag.id, "center": tag.center}));
            }
            Event::GivenUp(place) => self.given_up.push(json!({
                "t": time, "place": place.place, "voxels": place.voxels, "reason": place.reason,
            })),
            Event::Scan(_) => {}
            Event::Progress(p) => {
                let activity = self.activities.iter().position(|a| *a == p.activity);
                let activity = activity.unwrap_or_else(|| {
                    self.activities.push(p.activity.clone());
                    self.activities.len() - 1
                });
                let share = |v: f64| (1e4 * v).round() as i32;
                self.progress.row([
                    milli(time),
                    share(p.explored),
                    share(p.inspected),
                    p.found as i32,
                    activity as i32,
                ]);
            }
            Event::Cycle(cycle) => {
                for stage in &cycle.stages {
                    let table = self.cycles.entry(stage.stage.clone());
                    let micro = |ms: f64| (1e3 * ms).round() as i32;
                    table.or_insert_with(|| Thinned::new(4)).row([
                        milli(time),
                        stage.calls as i32,
                        micro(stage.total_ms),
                        micro(stage.max_ms),
                    ]);
                }
            }
            Event::Sampled(views) => self.sampled = views.clone(),
            Event::Look(look) => self.look(time, look),
            Event::End(how) => self.ended = Some(how.clone()),
        }
    }

    fn finish(&mut self) -> Result<(), WriteError> {
        match (&self.path, self.page()) {
            (Some(path), Some(page)) => write_file(path, REPORT_FILE, &page).map(|_| ()),
            _ => Ok(()),
        }
    }
}
