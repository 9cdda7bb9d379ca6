//! Still pictures of a recorded run at a moment.

use super::columns::{ColumnClass, Columns};
use super::event::{Begin, Event, View};
use super::recorder::Recorder;
use super::replay::{ReportError, replay};
use super::result::TargetFound;
use super::topdown::draw_moment;
use super::trace::{Coverage, MapLayer, Sample, Stop, Trace};
use crate::flap::{Picture, draw_picture};
use std::path::Path;

/// What is known of a run up to a moment.
struct Moment {
    until: f64,
    begin: Option<Box<Begin>>,
    columns: Columns,
    labels: Vec<u32>,
    trace: Trace,
    found: Vec<TargetFound>,
    end: f64,
    shares: (f64, f64),
    /// What a picture of a FLAP search shows.
    search: Picture,
}

impl Recorder for Moment {
    fn record(&mut self, time: f64, event: &Event) {
        if time > self.until {
            return;
        }
        self.end = self.end.max(time);
        match event {
            Event::Begin(begin) => {
                self.columns = Columns::new(begin.grid, begin.layers);
                self.labels = vec![0; begin.grid.size[0] * begin.grid.size[1]];
                self.search.way.push(begin.start);
                self.begin = Some(begin.clone());
            }
            Event::Pose(pose) => self.trace.samples.push(Sample {
                time,
                base: pose.base,
                camera: pose.camera.p,
            }),
            Event::Cells(cells) => self.columns.apply(cells),
            Event::Regions(regions) => {
                for (index, label) in regions.cells.iter() {
                    if let Some(was) = self.labels.get_mut(index as usize) {
                        *was = label;
                    }
                }
            }
            Event::Reached(view) => self.trace.stops.push(Stop {
                time,
                camera: view.p,
                axis: view.axis(),
            }),
            Event::Found(tag) => self.found.push(TargetFound {
                id: tag.id,
                time_s: time,
            }),
            Event::Progress(p) => self.shares = (p.explored, p.inspected),
            Event::Sampled(views) => self.search.sampled = views.iter().map(heading).collect(),
            Event::Look(look) => {
                self.search.looks.push(heading(&look.camera));
                self.search.way.push(look.base);
                self.search.success.push([time, look.probability]);
                self.search.expected_time = look.expected_time;
            }
            _ => {}
        }
    }
}

/// x and y, m, and direction seen from above, rad.
fn heading(view: &View) -> [f64; 3] {
    let [x, y, _] = view.axis();
    [view.p[0], view.p[1], y.atan2(x)]
}

impl Moment {
    /// The picture of a FLAP search. Until it ends, the expected time is that of the looks so far.
    fn search(mut self, begin: &Begin) -> String {
        self.search.end = self.end;
        self.search.caption = format!(
            "{} · {} planner · seed {}: after {:.0} s {} sensing actions, success {:.1} %, expected time so far {:.1} s",
            begin.scene,
            begin.planner,
            begin.seed,
            self.end,
            self.search.looks.len(),
            100.0 * self.search.success.last().map_or(0.0, |s| s[1]),
            self.search.expected_time
        );
        draw_picture(&begin.ground, &begin.volumes, &self.search)
    }

    fn layer(&self, begin: &Begin) -> MapLayer {
        let grid = &begin.grid;
        let size = [grid.size[0], grid.size[1]];
        let coverage = |column| match self.columns.class(column) {
            ColumnClass::Unknown => Coverage::Unknown,
            ColumnClass::Partly | ColumnClass::Free => Coverage::Free,
            ColumnClass::Occupied | ColumnClass::Open => Coverage::Occupied,
            ColumnClass::PartlyInspected | ColumnClass::Inspected => Coverage::Inspected,
        };
        MapLayer {
            cell_size: grid.cell_size,
            low: [grid.low[0], grid.low[1]],
            size,
            coverage: (0..(size[0] * size[1]) as u32).map(coverage).collect(),
            regions: self.labels.iter().map(|l| l.checked_sub(1)).collect(),
        }
    }
}

/// The run in `folder` as it stood at `time` (s; the end when none), as an SVG picture from above.
///
/// # Errors
/// [`ReportError`]; a recording of another system than `heats` and `flap` is [`ReportError::NoStill`].
pub fn still(folder: &Path, time: Option<f64>) -> Result<String, ReportError> {
    let mut moment = Moment {
        until: time.unwrap_or(f64::INFINITY).max(0.0),
        begin: None,
        columns: Columns::default(),
        labels: Vec::new(),
        trace: Trace::default(),
        found: Vec::new(),
        end: 0.0,
        shares: (0.0, 0.0),
        search: Picture::default(),
    };
    replay(folder, &mut moment)?;
    let begin = match moment.begin.take() {
        Some(begin) if begin.system == "heats" => begin,
        Some(begin) if begin.system == "flap" => return Ok(moment.search(&begin)),
        other => {
            let system = other.map_or(String::new(), |b| b.system);
            return Err(ReportError::NoStill { system });
        }
    };
    moment.trace.map = Some(moment.layer(&begin));
    let caption = format!(
        "{} · {} · {} sensors · seed {}: {} of {} tags after {:.0} s, {:.0} % explored, {:.0} % of the surface inspected",
        begin.scene,
        begin.planner,
        begin.sensors,
        begin.seed,
        moment.found.len(),
        begin.ground.tags.len(),
        moment.end,
        100.0 * moment.shares.0,
        100.0 * moment.shares.1
    );
    Ok(draw_moment(
        &begin.ground,
        &moment.trace,
        &moment.found,
        moment.end,
        &caption,
    ))
}
