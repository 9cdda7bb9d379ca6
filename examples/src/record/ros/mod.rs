//! `trace.mcap`: the run as ROS 2 messages, for the tools that people have.

mod cdr;
mod message;
mod schema;

use self::message::{Marker, Shape, nanoseconds};
use super::columns::{ColumnClass, Columns};
use super::event::{
    Begin, CellRuns, CellState, DecisionEvent, Event, FrontierShape, FrontiersEvent, LookEvent,
    PlanEvent, PoseEvent, View,
};
use super::recorder::Recorder;
use super::{WriteError, partial_name};
use mcap::records::MessageHeader;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Name of the file in a run's folder.
pub const TRACE_FILE: &str = "trace.mcap";

/// Time between two occupancy grids, s.
const MAP_PERIOD: f64 = 2.0;

const RED: [f32; 4] = [0.88, 0.11, 0.28, 0.8];
const BLUE: [f32; 4] = [0.15, 0.39, 0.92, 0.8];
const VIOLET: [f32; 4] = [0.49, 0.23, 0.93, 0.8];
const MAGENTA: [f32; 4] = [0.75, 0.15, 0.83, 1.0];
const GREEN: [f32; 4] = [0.09, 0.64, 0.29, 1.0];
const GREY: [f32; 4] = [0.6, 0.64, 0.7, 1.0];

/// A file that is being written.
struct Open {
    writer: mcap::Writer<BufWriter<File>>,
    /// Channel and next sequence number of each topic.
    channels: BTreeMap<&'static str, (u16, u32)>,
    schemas: BTreeMap<&'static str, u16>,
}

impl Open {
    fn message(
        &mut self,
        time: f64,
        topic: &'static str,
        kind: &'static str,
        data: &[u8],
    ) -> mcap::McapResult<()> {
        let (channel, sequence) = match self.channels.get_mut(topic) {
            Some(known) => known,
            None => {
                let schema = match self.schemas.get(kind) {
                    Some(id) => *id,
                    None => {
                        // Readers want the long name: package/msg/Type.
                        let name = kind.replacen('/', "/msg/", 1);
                        let text = schema::definition(kind);
                        let id = self.writer.add_schema(&name, "ros2msg", text.as_bytes())?;
                        self.schemas.insert(kind, id);
                        id
                    }
                };
                let id = self
                    .writer
                    .add_channel(schema, topic, "cdr", &BTreeMap::new())?;
                self.channels.entry(topic).or_insert((id, 0))
            }
        };
        let stamp = nanoseconds(time);
        let header = MessageHeader {
            channel_id: *channel,
            sequence: *sequence,
            log_time: stamp,
            publish_time: stamp,
        };
        *sequence = sequence.wrapping_add(1);
        self.writer.write_to_known_channel(&header, data)
    }
}

/// Writes `trace.mcap`: profile `ros2`, messages as CDR, chunks compressed by zstd (feature `zstd`, on by default). Holds one
/// chunk, the voxel states and the tags.
///
/// | topic | type | what |
/// | --- | --- | --- |
/// | `/tf` | `tf2_msgs/TFMessage` | `base_link` and `camera_optical_frame` in `map` |
/// | `/joint_states` | `sensor_msgs/JointState` | joints |
/// | `/map` | `nav_msgs/OccupancyGrid` | the map from above, every 2 s |
/// | `/voxels` | `sensor_msgs/PointCloud2` | changed voxels, with their state |
/// | `/lidar`, `/depth` | `sensor_msgs/PointCloud2` | thinned scans |
/// | `/plan`, `/camera_plan`, `/horizon` | `nav_msgs/Path` | base path, camera path, MPC horizon |
/// | `/frontiers`, `/viewpoints`, `/tags`, `/volumes` | `visualization_msgs/MarkerArray` | cells, views, tags, search volumes |
/// | `/explored`, `/inspected`, `/success` | `std_msgs/Float32` | shares, 0..1 |
/// | `/tags_found` | `std_msgs/Int32` | tags found |
/// | `/activity` | `std_msgs/String` | what the robot does |
pub struct Trace {
    path: PathBuf,
    open: Option<Open>,
    failure: Option<std::io::Error>,
    begin: Option<Box<Begin>>,
    columns: Columns,
    next_map: f64,
    stale_map: bool,
    last: f64,
    activity: String,
}

impl std::fmt::Debug for Trace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Trace")
            .field("path", &self.path)
            .finish_non_exhaustive()
    }
}

impl Trace {
    /// A trace in `folder`. It has its name once it is whole.
    pub fn new(folder: &Path) -> Self {
        Self {
            path: folder.join(TRACE_FILE),
            open: None,
            failure: None,
            begin: None,
            columns: Columns::default(),
            next_map: 0.0,
            stale_map: false,
            last: 0.0,
            activity: String::new(),
        }
    }

    fn begin(&mut self) -> std::io::Result<()> {
        if let Some(folder) = self.path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let file = File::create(partial_name(&self.path))?;
        let options = mcap::WriteOptions::new()
            .profile("ros2")
            .library(concat!("seekplan ", env!("CARGO_PKG_VERSION")))
            .compression(None);
        // One thread: the bytes of a file must not depend on how many cores wrote it.
        #[cfg(feature = "zstd")]
        let options = options
            .compression(Some(mcap::Compression::Zstd))
            .compression_threads(0);
        let writer = options
            .create(BufWriter::new(file))
            .map_err(std::io::Error::other)?;
        self.open = Some(Open {
            writer,
            channels: BTreeMap::new(),
            schemas: BTreeMap::new(),
        });
        Ok(())
    }

    fn message(&mut self, time: f64, topic: &'static str, kind: &'static str, data: &[u8]) {
        if self.failure.is_none()
            && let Some(open) = &mut self.open
        {
            let written = open.message(time, topic, kind, data);
            self.failure = written.err().map(std::io::Error::other);
        }
    }

    fn markers(&mut self, time: f64, topic: &'static str, list: &[Marker]) {
        let data = message::markers(time, list);
        self.message(time, topic, "visualization_msgs/MarkerArray", &data);
    }

    fn path(
        &mut self,
        time: f64,
        topic: &'static str,
        poses: impl ExactSizeIterator<Item = (f64, View)>,
    ) {
        let data = message::path(time, poses);
        self.message(time, topic, "nav_msgs/Path", &data);
    }

    fn float(&mut self, time: f64, topic: &'static str, value: f64) {
        self.message(time, topic, "std_msgs/Float32", &message::float(value));
    }

    fn started(&mut self, time: f64, begin: &Begin) {
        self.failure = self.begin().err();
        self.columns = Columns::new(begin.grid, begin.layers);
        self.begin = Some(Box::new(begin.clone()));
        let tags: Vec<Marker> = begin
            .ground
            .tags
            .iter()
            .map(|tag| tag_marker(tag.id, tag.center, GREY))
            .collect();
        if !tags.is_empty() {
            self.markers(time, "/tags", &tags);
        }
        let volumes: Vec<Marker> = begin
            .volumes
            .iter()
            .enumerate()
            .map(|(i, v)| Marker {
                space: "volumes",
                id: i as i32,
                shape: Shape::Cube,
                delete: false,
                place: [0, 1, 2].map(|a| 0.5 * (v.low[a] + v.high[a])),
                scale: [0, 1, 2].map(|a| v.high[a] - v.low[a]),
                color: [0.86, 0.15, 0.15, 0.25],
                points: Vec::new(),
            })
            .collect();
        if !volumes.is_empty() {
            self.markers(time, "/volumes", &volumes);
        }
    }

    fn pose(&mut self, time: f64, pose: &PoseEvent) {
        let frames = [
            ("base_link", message::planar(pose.base)),
            ("camera_optical_frame", pose.camera),
        ];
        let data = message::transforms(time, &frames);
        self.message(time, "/tf", "tf2_msgs/TFMessage", &data);
        if let Some(begin) = &self.begin {
            let data = message::joints(time, &begin.robot.joints, &pose.joints);
            self.message(time, "/joint_states", "sensor_msgs/JointState", &data);
        }
    }

    fn cells(&mut self, time: f64, runs: &CellRuns) {
        self.columns.apply(runs);
        self.stale_map |= !self.columns.take_changed().is_empty();
        let grid = *self.columns.grid();
        // Of what was known before a FLAP search, free space would be most of the file.
        let before = time <= 0.0 && self.begin.as_ref().is_some_and(|b| b.system == "flap");
        let inside = |&(index, state): &(u32, u32)| {
            (index as usize) < grid.len() && !(before && state == CellState::Free as u32)
        };
        let (cells, states): (Vec<u32>, Vec<u8>) = runs
            .iter()
            .filter(inside)
            .map(|(index, value)| (index, value as u8))
            .unzip();
        let centers = cells.iter().map(|i| grid.center(grid.cell(*i)));
        let data = message::cloud(time, centers, Some(&states));
        self.message(time, "/voxels", "sensor_msgs/PointCloud2", &data);
    }

    /// The map from above, if it changed and is due.
    fn map(&mut self, time: f64) {
        if !self.stale_map || time < self.next_map {
            return;
        }
        self.stale_map = false;
        self.next_map = time + MAP_PERIOD - 1e-9;
        let grid = *self.columns.grid();
        let size = [grid.size[0], grid.size[1]];
        let cells: Vec<i8> = (0..(size[0] * size[1]) as u32)
            .map(|column| match self.columns.class(column) {
                ColumnClass::Unknown => -1,
                ColumnClass::Partly | ColumnClass::Free => 0,
                _ => 100,
            })
            .collect();
        let data = message::grid(time, grid.cell_size, size, grid.low, &cells);
        self.message(time, "/map", "nav_msgs/OccupancyGrid", &data);
    }

    fn frontiers(&mut self, time: f64, event: &FrontiersEvent) {
        let grid = *self.columns.grid();
        let marker = |id: u64, inspection: bool, shape: Option<&FrontierShape>| Marker {
            space: if inspection {
                "inspection"
            } else {
                "exploration"
            },
            id: id as i32,
            shape: Shape::CubeList,
            delete: shape.is_none(),
            place: [0.0; 3],
            scale: [grid.cell_size; 3],
            color: if inspection { BLUE } else { RED },
            points: shape.map_or(Vec::new(), |s| {
                s.cells().map(|i| grid.center(grid.cell(i))).collect()
            }),
        };
        // A reader that has no marker of that name ignores its deletion, so both kinds are told.
        let gone = event
            .gone
            .iter()
            .flat_map(|id| [marker(*id, false, None), marker(*id, true, None)]);
        let new = event
            .clusters
            .iter()
            .map(|c| marker(c.id, c.inspection, Some(c)));
        let list: Vec<Marker> = gone.chain(new).collect();
        self.markers(time, "/frontiers", &list);
    }

    fn decision(&mut self, time: f64, event: &DecisionEvent) {
        let arrows = |space, color, views: &mut dyn Iterator<Item = &View>| {
            let points: Vec<[f64; 3]> = views
                .flat_map(|v| {
                    let axis = v.axis();
                    [v.p, [0, 1, 2].map(|a| v.p[a] + 0.3 * axis[a])]
                })
                .collect();
            Marker {
                space,
                id: 0,
                shape: Shape::LineList,
                delete: points.is_empty(),
                place: [0.0; 3],
                scale: [0.02, 0.0, 0.0],
                color,
                points,
            }
        };
        let mut all = event.candidates.iter().map(|c| &c.view);
        let chosen = event.chosen.and_then(|c| event.candidates.get(c));
        let list = [
            arrows("candidates", VIOLET, &mut all),
            arrows("chosen", MAGENTA, &mut chosen.iter().map(|c| &c.view)),
        ];
        self.markers(time, "/viewpoints", &list);
    }

    fn plan(&mut self, time: f64, event: &PlanEvent) {
        let due = |k: usize| event.ready + event.step * k as f64;
        let base = event.base.iter().enumerate();
        self.path(
            time,
            "/plan",
            base.map(|(k, p)| (due(k), message::planar(*p))),
        );
        let camera = event.camera.iter().enumerate();
        self.path(
            time,
            "/camera_plan",
            camera.map(|(k, p)| (due(k), message::upright(*p))),
        );
    }

    fn look(&mut self, time: f64, look: &LookEvent) {
        let base = [look.base[0], look.base[1], 0.0];
        let frames = [
            ("base_link", message::planar(base)),
            ("camera_optical_frame", look.camera),
        ];
        let data = message::transforms(time, &frames);
        self.message(time, "/tf", "tf2_msgs/TFMessage", &data);
        self.float(time, "/success", look.probability);
    }

    fn close(&mut self) -> std::io::Result<()> {
        if let Some(failure) = self.failure.take() {
            return Err(failure);
        }
        self.next_map = 0.0;
        self.map(self.last);
        if let Some(mut open) = self.open.take() {
            open.writer.finish().map_err(std::io::Error::other)?;
            let file = open.writer.into_inner();
            file.into_inner().map_err(|e| e.into_error())?;
            std::fs::rename(partial_name(&self.path), &self.path)?;
        }
        Ok(())
    }
}

fn tag_marker(id: u32, place: [f64; 3], color: [f32; 4]) -> Marker {
    Marker {
        space: "tags",
        id: id as i32,
        shape: Shape::Cube,
        delete: false,
        place,
        scale: [0.2; 3],
        color,
        points: Vec::new(),
    }
}

impl Recorder for Trace {
    fn record(&mut self, time: f64, event: &Event) {
        self.last = self.last.max(time);
        match event {
            Event::Begin(begin) => self.started(time, begin),
            Event::Pose(pose) => self.pose(time, pose),
            Event::Cells(runs) => self.cells(time, runs),
            Event::Frontiers(event) => self.frontiers(time, event),
            Event::Decision(event) => self.decision(time, event),
            Event::Plan(event) => self.plan(time, event),
            Event::Horizon(event) => {
                let poses = event.base.iter();
                self.path(time, "/horizon", poses.map(|p| (time, message::planar(*p))));
            }
            Event::Found(tag) => {
                self.markers(time, "/tags", &[tag_marker(tag.id, tag.center, GREEN)]);
            }
            Event::Scan(scan) => {
                let topic = if scan.sensor == "depth" {
                    "/depth"
                } else {
                    "/lidar"
                };
                let place =
                    |p: &[i16; 3]| [0, 1, 2].map(|a| scan.origin[a] + 0.01 * f64::from(p[a]));
                let data = message::cloud(time, scan.points.iter().map(place), None);
                self.message(time, topic, "sensor_msgs/PointCloud2", &data);
            }
            Event::Progress(p) => {
                self.float(time, "/explored", p.explored);
                self.float(time, "/inspected", p.inspected);
                let found = message::integer(p.found as i32);
                self.message(time, "/tags_found", "std_msgs/Int32", &found);
                if self.activity != p.activity {
                    self.activity.clone_from(&p.activity);
                    let text = message::text(&p.activity);
                    self.message(time, "/activity", "std_msgs/String", &text);
                }
            }
            Event::Look(look) => self.look(time, look),
            Event::Regions(_)
            | Event::Reached(_)
            | Event::GivenUp(_)
            | Event::Cycle(_)
            | Event::Sampled(_)
            | Event::End(_) => {}
        }
        self.map(time);
    }

    fn finish(&mut self) -> Result<(), WriteError> {
        self.close().map_err(|source| WriteError {
            path: self.path.clone(),
            source,
        })
    }
}
