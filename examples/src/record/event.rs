//! What can be recorded of a run: one [`Event`] for each kind of thing that happens.
//!
//! Metres, radians and seconds in the world frame unless a field says otherwise. Lengths and angles are rounded to
//! [`GRAIN`], so that a line of text stays short.

use super::topdown::Ground;
use serde::{Deserialize, Serialize};

/// Value of [`Begin::schema`].
pub const RECORD_SCHEMA: &str = "seekplan-record/1";

/// Lengths and angles are recorded to this, m and rad.
pub const GRAIN: f64 = 1e-4;

/// A value on the recording's grain.
pub fn round(value: f64) -> f64 {
    // Divided by a whole number, so that what is printed is short.
    (value / GRAIN).round() / (1.0 / GRAIN).round()
}

/// An event at a simulated time, s. As JSON: `[12.3, {"pose": {...}}]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry(pub f64, pub Event);

/// Something that happened in a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Event {
    /// The run begins; always the first event.
    Begin(Box<Begin>),
    /// Where the robot is.
    Pose(PoseEvent),
    /// Voxels whose state changed.
    Cells(CellRuns),
    /// Ground cells whose region changed, and where all regions are now.
    Regions(RegionsEvent),
    /// Frontier clusters that came, changed or went.
    Frontiers(FrontiersEvent),
    /// A decision: what it chose among, and what it chose.
    Decision(DecisionEvent),
    /// A whole-body path that will be followed.
    Plan(PlanEvent),
    /// The controller's horizon.
    Horizon(HorizonEvent),
    /// The viewpoint under way was reached.
    Reached(View),
    /// A tag was found.
    Found(FoundEvent),
    /// A place is no longer tried.
    GivenUp(GivenUpEvent),
    /// Points of a scan, thinned.
    Scan(ScanEvent),
    /// How far the search is.
    Progress(ProgressEvent),
    /// Wall times of the planner's stages since the last such event.
    Cycle(CycleEvent),
    /// The views that a FLAP search begins with.
    Sampled(Vec<View>),
    /// A look of a FLAP search.
    Look(LookEvent),
    /// The run ended, in words; always the last event of a run that was not killed.
    End(String),
}

/// What is run, and where.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Begin {
    /// Always [`RECORD_SCHEMA`].
    pub schema: String,
    /// Version of this program.
    pub version: String,
    /// `heats` or `flap`.
    pub system: String,
    /// Name of the planner.
    pub planner: String,
    /// `both` or `camera`.
    pub sensors: String,
    /// Name of the scene.
    pub scene: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Settings as TOML text.
    pub settings: String,
    /// The voxel grid of [`Event::Cells`] and [`Event::Frontiers`].
    pub grid: GridShape,
    /// First layer of cells that a picture from above shows, and the one after the last: floor and ceiling hide the rest.
    pub layers: [usize; 2],
    /// What of the scene a picture shows. The planner does not know it.
    pub ground: Ground,
    /// The robot.
    pub robot: RobotShape,
    /// Where the base begins, m.
    pub start: [f64; 2],
    /// Volumes that may hold the object of a FLAP search.
    pub volumes: Vec<VolumeShape>,
}

/// A grid of voxels. Cell (x, y, z) has the index x + nx (y + ny z).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GridShape {
    /// Lower corner, m.
    pub low: [f64; 3],
    /// Edge of a cell, m.
    pub cell_size: f64,
    /// Cells along each axis.
    pub size: [usize; 3],
}

impl GridShape {
    /// Index of a cell inside the grid.
    pub fn index(&self, cell: [i32; 3]) -> u32 {
        let [x, y, z] = cell.map(|v| v as usize);
        (x + self.size[0] * (y + self.size[1] * z)) as u32
    }

    /// The cell of an index.
    pub fn cell(&self, index: u32) -> [i32; 3] {
        let [nx, ny, _] = self.size.map(|n| n.max(1));
        let i = index as usize;
        [(i % nx) as i32, (i / nx % ny) as i32, (i / nx / ny) as i32]
    }

    /// Centre of a cell, m.
    pub fn center(&self, cell: [i32; 3]) -> [f64; 3] {
        [0, 1, 2].map(|a| self.low[a] + (f64::from(cell[a]) + 0.5) * self.cell_size)
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.size.iter().product()
    }

    /// True for a grid without cells.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// What a picture shows of the robot besides its pose.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RobotShape {
    /// Names of the joints.
    pub joints: Vec<String>,
    /// Lower and upper corner of the base's box in the base frame, m.
    pub base: [[f64; 3]; 2],
    /// Tangents of half the camera's horizontal and vertical field of view.
    pub camera: [f64; 2],
    /// Distance up to which the camera inspects, m.
    pub range: f64,
}

/// A volume that may hold the object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VolumeShape {
    /// Its name.
    pub name: String,
    /// Lower corner, m.
    pub low: [f64; 3],
    /// Upper corner, m.
    pub high: [f64; 3],
    /// Probability that it holds the object.
    pub probability: f64,
}

/// Pose of a camera: world_from_camera, z forward, x right, y down.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct View {
    /// Position, m.
    pub p: [f64; 3],
    /// Orientation as a unit quaternion x, y, z, w.
    pub q: [f64; 4],
}

impl View {
    /// From the rows of a rotation and a position.
    pub fn new(rotation: &[[f64; 3]; 3], position: [f64; 3]) -> Self {
        Self {
            p: position.map(round),
            q: quaternion(rotation).map(round),
        }
    }

    /// A direction of the camera frame in the world.
    pub fn rotate(&self, v: [f64; 3]) -> [f64; 3] {
        let [x, y, z, w] = self.q;
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [
                a[1] * b[2] - a[2] * b[1],
                a[2] * b[0] - a[0] * b[2],
                a[0] * b[1] - a[1] * b[0],
            ]
        };
        let t = cross([x, y, z], v).map(|c| 2.0 * c);
        let u = cross([x, y, z], t);
        [0, 1, 2].map(|a| v[a] + w * t[a] + u[a])
    }

    /// The optical axis in the world, unit.
    pub fn axis(&self) -> [f64; 3] {
        self.rotate([0.0, 0.0, 1.0])
    }
}

/// Unit quaternion x, y, z, w of a rotation's rows (Shepperd's method: divides by the largest component).
fn quaternion(r: &[[f64; 3]; 3]) -> [f64; 4] {
    let trace = r[0][0] + r[1][1] + r[2][2];
    if trace > 0.0 {
        let s = 2.0 * (1.0 + trace).sqrt();
        return [
            (r[2][1] - r[1][2]) / s,
            (r[0][2] - r[2][0]) / s,
            (r[1][0] - r[0][1]) / s,
            s / 4.0,
        ];
    }
    let i = (0..3).fold(0, |best, a| if r[a][a] > r[best][best] { a } else { best });
    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
    let s = 2.0 * (1.0 + r[i][i] - r[j][j] - r[k][k]).max(0.0).sqrt();
    let mut q = [0.0; 4];
    q[i] = s / 4.0;
    q[j] = (r[i][j] + r[j][i]) / s;
    q[k] = (r[i][k] + r[k][i]) / s;
    q[3] = (r[k][j] - r[j][k]) / s;
    q
}

/// Where the robot is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseEvent {
    /// Base pose x, y, yaw, m and rad; the yaw is not wrapped.
    pub base: [f64; 3],
    /// Joint angles, rad.
    pub joints: Vec<f64>,
    /// Points along the arm in the base frame, from its foot to the camera, m.
    pub arm: Vec<[f64; 3]>,
    /// The camera.
    pub camera: View,
}

/// State of a voxel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum CellState {
    /// Never observed, or no longer.
    #[default]
    Unknown = 0,
    /// Observed, free.
    Free = 1,
    /// Occupied, without a face that is to be inspected.
    Occupied = 2,
    /// Occupied, with faces that are to be inspected.
    Open = 3,
    /// Occupied, all faces that are to be inspected were.
    Inspected = 4,
}

impl CellState {
    /// The state of a number, if it is one.
    pub fn from_number(number: u32) -> Option<Self> {
        Some(match number {
            0 => Self::Unknown,
            1 => Self::Free,
            2 => Self::Occupied,
            3 => Self::Open,
            4 => Self::Inspected,
            _ => return None,
        })
    }
}

/// Runs of cells that got the same value: index of the first, number of cells, value.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct CellRuns(pub Vec<[u32; 3]>);

impl CellRuns {
    /// Adds a cell; indices of one list come in rising order.
    pub fn push(&mut self, index: u32, value: u32) {
        match self.0.last_mut() {
            Some([first, length, same]) if *same == value && *first + *length == index => {
                *length += 1;
            }
            _ => self.0.push([index, 1, value]),
        }
    }

    /// Each cell's index and value.
    pub fn iter(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.0.iter().flat_map(|&[first, length, value]| {
            (first..first.saturating_add(length)).map(move |i| (i, value))
        })
    }

    /// True if no cell changed.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Regions of the ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RegionsEvent {
    /// Ground cells (index x + nx y) that changed: 0 for no region, else its number plus one.
    pub cells: CellRuns,
    /// Numbers and centres of all regions.
    pub centers: Vec<(u32, [f64; 2])>,
}

/// Frontier clusters.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FrontiersEvent {
    /// Clusters that are no more.
    pub gone: Vec<u64>,
    /// Clusters that are new or have other cells.
    pub clusters: Vec<FrontierShape>,
}

/// A frontier cluster.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FrontierShape {
    /// Its number.
    pub id: u64,
    /// True for a cluster of occupied cells to inspect, false for one of free cells to explore from.
    pub inspection: bool,
    /// Indices of its cells in rising order, the first as it is and each other as its distance from the one before.
    pub steps: Vec<u32>,
}

impl FrontierShape {
    /// A cluster of cells given by their indices.
    pub fn new(id: u64, inspection: bool, mut indices: Vec<u32>) -> Self {
        indices.sort_unstable();
        let mut before = 0;
        for index in &mut indices {
            let step = *index - before;
            before = std::mem::replace(index, step);
        }
        Self {
            id,
            inspection,
            steps: indices,
        }
    }

    /// Indices of its cells.
    pub fn cells(&self) -> impl Iterator<Item = u32> + '_ {
        self.steps.iter().scan(0_u32, |at, step| {
            *at = at.wrapping_add(*step);
            Some(*at)
        })
    }
}

/// A viewpoint that could be chosen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Base pose, m and rad.
    pub base: [f64; 3],
    /// Camera.
    pub view: View,
    /// Information gain.
    pub gain: f64,
    /// Time to get there, s.
    pub seconds: f64,
}

/// A decision.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DecisionEvent {
    /// What came of it: `go`, `wait` or `done`.
    pub outcome: String,
    /// True if it was taken before the path under way was at its end.
    pub ahead: bool,
    /// What it chose among.
    pub candidates: Vec<Candidate>,
    /// Index of the chosen one.
    pub chosen: Option<usize>,
    /// Numbers of the regions in the order in which they are to be visited.
    pub regions: Vec<u32>,
}

/// A whole-body path, at equal times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanEvent {
    /// Simulated time at which it is there, s.
    pub ready: f64,
    /// Time between its states, s.
    pub step: f64,
    /// Base poses, m and rad.
    pub base: Vec<[f64; 3]>,
    /// Joints, rad.
    pub joints: Vec<Vec<f64>>,
    /// Camera positions, m.
    pub camera: Vec<[f64; 3]>,
    /// Camera at its end.
    pub goal: View,
}

/// The controller's horizon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HorizonEvent {
    /// Base poses from now on, m and rad.
    pub base: Vec<[f64; 3]>,
}

/// A tag that was found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FoundEvent {
    /// The tag's number.
    pub id: u32,
    /// Its centre, m.
    pub center: [f64; 3],
}

/// A place that is no longer tried.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GivenUpEvent {
    /// Its centre, m.
    pub place: [f64; 3],
    /// Frontier voxels it held.
    pub voxels: usize,
    /// Why.
    pub reason: String,
}

/// Points of a scan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScanEvent {
    /// `lidar` or `depth`.
    pub sensor: String,
    /// Where the rays start, m.
    pub origin: [f64; 3],
    /// Hits relative to the origin in the axes of the world, in whole centimetres.
    pub points: Vec<[i16; 3]>,
}

/// How far the search is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProgressEvent {
    /// Share of the reachable free space that is known, 0..1.
    pub explored: f64,
    /// Share of the observable surface that was inspected, 0..1.
    pub inspected: f64,
    /// Tags found.
    pub found: usize,
    /// What the robot is doing.
    pub activity: String,
}

/// Wall times of the stages.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CycleEvent {
    /// Stages that ran.
    pub stages: Vec<StageCycle>,
}

/// Wall time of one stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageCycle {
    /// Name as in `result.json`.
    pub stage: String,
    /// Calls.
    pub calls: usize,
    /// All calls together, ms.
    pub total_ms: f64,
    /// The longest, ms.
    pub max_ms: f64,
}

/// A look of a FLAP search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LookEvent {
    /// Number of the view.
    pub view: usize,
    /// Base position, m.
    pub base: [f64; 2],
    /// Camera.
    pub camera: View,
    /// Probability to have seen the object before the look.
    pub before: f64,
    /// Probability to have seen it after the look.
    pub probability: f64,
    /// Expected time until now, s.
    pub expected_time: f64,
    /// Views of the plan that the look began.
    pub planned: usize,
    /// Expected time of that plan, s.
    pub planned_time: f64,
    /// Cells whose state it changed; the [`Event::Cells`] before it has them.
    pub cells: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_give_the_cells_back() {
        let shape = FrontierShape::new(3, true, vec![40, 7, 9, 8, 100]);
        assert_eq!(shape.steps, [7, 1, 1, 31, 60]);
        assert_eq!(shape.cells().collect::<Vec<_>>(), [7, 8, 9, 40, 100]);
    }

    #[test]
    fn runs_join_neighbours_of_equal_value() {
        let mut runs = CellRuns::default();
        for (index, value) in [(4, 1), (5, 1), (6, 2), (9, 2)] {
            runs.push(index, value);
        }
        assert_eq!(runs.0, [[4, 2, 1], [6, 1, 2], [9, 1, 2]]);
        let cells: Vec<_> = runs.iter().collect();
        assert_eq!(cells, [(4, 1), (5, 1), (6, 2), (9, 2)]);
    }

    #[test]
    fn cells_and_indices_agree() {
        let grid = GridShape {
            low: [-1.0, 0.0, 0.5],
            cell_size: 0.5,
            size: [3, 4, 5],
        };
        for index in 0..grid.len() as u32 {
            assert_eq!(grid.index(grid.cell(index)), index);
        }
        assert_eq!(grid.center([1, 0, 2]), [-0.25, 0.25, 1.75]);
    }

    #[test]
    fn views_turn_as_their_rotations_do() {
        // One rotation for each branch: none, and half turns around x, y and z; and a skew one.
        let (s, c) = 0.7_f64.sin_cos();
        let rotations = [
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
            [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]],
            [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]],
            [[0.0, -s, c], [-1.0, 0.0, 0.0], [0.0, -c, -s]],
        ];
        for r in rotations {
            let view = View::new(&r, [0.0; 3]);
            for v in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
                let turned = view.rotate(v);
                for a in 0..3 {
                    let wanted: f64 = (0..3).map(|k| r[a][k] * v[k]).sum();
                    // Two roundings of the quaternion to 1e-4 each.
                    assert!((turned[a] - wanted).abs() < 4e-4, "{r:?} {v:?}");
                }
            }
        }
    }
}
