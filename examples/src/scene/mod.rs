//! Scenes: static worlds with tags to find, file format `search-scene/1`.
//!
//! Metres, radians, right-handed frame, z up. Reading is strict: an unknown field, a number that is not finite, a
//! start inside an obstacle or a tag inside a solid is refused with an error that names the field.
//!
//! ```
//! use seekplan::scene::Scene;
//!
//! let closet = Scene::builtin("closet").expect("embedded");
//! assert_eq!(closet.tags.len(), 3);
//! assert!(Scene::from_json(r#"{"schema": "search-scene/1"}"#).is_err()); // bounds and more are missing
//! ```

mod check;
mod format;
mod outline;
mod solid;

pub(crate) use solid::{
    cylinder_pose as parry_cylinder_pose, pose as parry_pose, vec3 as parry_vector,
};

pub use check::Footprint;
pub use format::{
    Bounds, BoxShape, CylinderShape, Limits, MeshShape, Room, Scene, Shape, Start, Tag,
    TargetVolume, Units,
};
pub use outline::PlanOutline;
pub use solid::{Form, Mesh, Solid};

use std::path::{Path, PathBuf};

/// Names of the embedded scenes.
pub const BUILTIN: [&str; 5] = ["office", "maze", "lab", "closet", "race"];

/// What is wrong with a scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file could not be read.
    #[error("cannot read scene {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A scene in a file is wrong.
    #[error("{path}: {error}")]
    InFile {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: Box<SceneError>,
    },
    /// Not JSON, a field missing, unknown or of the wrong type; the message names field, line and column.
    #[error("not a search-scene/1 document: {0}")]
    Syntax(#[from] serde_json::Error),
    /// No embedded scene has this name.
    #[error("no embedded scene is called {name:?}; there are office, maze, lab, closet and race")]
    NoBuiltin {
        /// The name asked for.
        name: String,
    },
    /// A text field has a value this program does not read.
    #[error("{field} = {found:?}, expected {expected:?}")]
    Text {
        /// The field.
        field: &'static str,
        /// Its value.
        found: String,
        /// What this program reads.
        expected: &'static str,
    },
    /// A number is NaN or infinite.
    #[error("{field} = {value} is not finite")]
    NotFinite {
        /// Path of the field.
        field: String,
        /// Its value.
        value: f64,
    },
    /// A size or limit is zero or negative.
    #[error("{field} = {value} must be positive")]
    NotPositive {
        /// Path of the field.
        field: String,
        /// Its value.
        value: f64,
    },
    /// A probability is outside 0..1.
    #[error("{field} = {value} must lie in 0..1")]
    NotAShare {
        /// Path of the field.
        field: String,
        /// Its value.
        value: f64,
    },
    /// Lower end not below upper end.
    #[error("{field}: {low} must be below {high}")]
    EmptyRange {
        /// Path of the field.
        field: String,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// A point lies outside the bounds.
    #[error("{field} = {point:?} lies outside bounds {low:?}..{high:?}")]
    OutsideBounds {
        /// Path of the field.
        field: String,
        /// The point, m.
        point: Vec<f64>,
        /// Lower corner of the bounds, m.
        low: [f64; 3],
        /// Upper corner of the bounds, m.
        high: [f64; 3],
    },
    /// The robot's footprint at the start pose overlaps a shape.
    #[error("start = ({x}, {y}, {yaw}): the base overlaps shape {shape:?}")]
    StartBlocked {
        /// Start x, m.
        x: f64,
        /// Start y, m.
        y: f64,
        /// Start yaw, rad.
        yaw: f64,
        /// The shape in the way.
        shape: String,
    },
    /// A tag lies inside a shape, where nothing can see it.
    #[error("tags[{index}].center = {center:?} (id {id}) lies inside shape {shape:?}")]
    TagInside {
        /// Position in the list.
        index: usize,
        /// The tag's id.
        id: u32,
        /// Its centre, m.
        center: [f64; 3],
        /// The shape around it; `floor` and `ceiling` are the half spaces.
        shape: String,
    },
    /// A direction or quaternion is not of unit length.
    #[error("{field} has length {length}, must be 1")]
    NotUnit {
        /// Path of the field.
        field: String,
        /// Its length.
        length: f64,
    },
    /// A tag's `up` is not in its plane.
    #[error("tags[{index}].up is not orthogonal to normal: their dot product is {dot}")]
    NotOrthogonal {
        /// Position in the list.
        index: usize,
        /// Dot product of up and normal.
        dot: f64,
    },
    /// Two tags share an id.
    #[error("tags[{index}].id = {id} is taken by an earlier tag")]
    DuplicateId {
        /// Position of the second one.
        index: usize,
        /// The id.
        id: u32,
    },
    /// A box has both a yaw and a quaternion.
    #[error("shapes[{index}] {name:?} has both yaw and quat")]
    TwoRotations {
        /// Position in the list.
        index: usize,
        /// Name of the shape.
        name: String,
    },
    /// A mesh has no triangles.
    #[error("shapes[{index}] {name:?} is an empty mesh")]
    EmptyMesh {
        /// Position in the list.
        index: usize,
        /// Name of the shape.
        name: String,
    },
    /// A triangle names a vertex that does not exist.
    #[error("shapes[{index}] {name:?}: triangles[{triangle}] names vertex {vertex} of {vertices}")]
    MeshIndex {
        /// Position in the list.
        index: usize,
        /// Name of the shape.
        name: String,
        /// Position of the triangle.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
}

impl Scene {
    /// An embedded scene by name; see [`BUILTIN`].
    ///
    /// # Errors
    /// [`SceneError::NoBuiltin`] for any other name.
    pub fn builtin(name: &str) -> Result<Self, SceneError> {
        Self::from_json(match name {
            "office" => include_str!("../../scenes/office.json"),
            "maze" => include_str!("../../scenes/maze.json"),
            "lab" => include_str!("../../scenes/lab.json"),
            "closet" => include_str!("../../scenes/closet.json"),
            "race" => include_str!("../../scenes/race.json"),
            _ => {
                return Err(SceneError::NoBuiltin {
                    name: name.to_owned(),
                });
            }
        })
    }

    /// Reads and checks a scene from JSON text.
    ///
    /// # Errors
    /// Whatever is wrong first, by field.
    pub fn from_json(text: &str) -> Result<Self, SceneError> {
        let scene: Self = serde_json::from_str(text)?;
        scene.check(&Footprint::default())?;
        Ok(scene)
    }

    /// Reads and checks a scene file.
    ///
    /// # Errors
    /// As [`from_json`](Self::from_json), with the file's path.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|source| SceneError::Read {
            path: path.to_owned(),
            source,
        })?;
        Self::from_json(&text).map_err(|error| SceneError::InFile {
            path: path.to_owned(),
            error: Box::new(error),
        })
    }

    /// An embedded scene if `name` is one of [`BUILTIN`]; else the file of that path.
    ///
    /// # Errors
    /// [`SceneError::NoBuiltin`] when `name` is neither embedded nor looks like a file; else as
    /// [`load`](Self::load).
    pub fn open(name: &str) -> Result<Self, SceneError> {
        let path = Path::new(name);
        let bare = path.extension().is_none() && path.components().count() == 1 && !path.exists();
        if BUILTIN.contains(&name) || bare {
            Self::builtin(name)
        } else {
            Self::load(path)
        }
    }
}
