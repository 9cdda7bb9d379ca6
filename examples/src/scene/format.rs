//! The scene document as it stands in a file.

use serde::{Deserialize, Serialize};

/// A static world with tags to find.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Format and version, always `search-scene/1`.
    pub schema: String,
    /// Name of the scene.
    pub name: String,
    /// One sentence.
    #[serde(default)]
    pub description: String,
    /// SPDX expression, or words where none fits.
    pub license: String,
    /// Free form: where geometry and tags come from.
    #[serde(default)]
    pub origin: serde_json::Value,
    /// Units, always metres and radians.
    pub units: Units,
    /// The frame in words.
    #[serde(default)]
    pub frame: String,
    /// The task volume V: planners map and search inside it only; shapes may stick out.
    pub bounds: Bounds,
    /// Solid half space below this height, m; it stops rays and is no surface to inspect.
    pub floor_z: f64,
    /// Solid half space above this height, m; open above when absent.
    #[serde(default)]
    pub ceiling_z: Option<f64>,
    /// Base pose at the start.
    pub start: Start,
    /// Figures of the run protocol.
    #[serde(default)]
    pub limits: Limits,
    /// The targets.
    pub tags: Vec<Tag>,
    /// Ground truth for region segmentation.
    #[serde(default)]
    pub rooms: Vec<Room>,
    /// Names of rooms no base can enter.
    #[serde(default)]
    pub closed_areas: Vec<String>,
    /// Search volumes with a prior probability, for object search.
    #[serde(default)]
    pub target_volumes: Vec<TargetVolume>,
    /// Walls and furniture.
    pub shapes: Vec<Shape>,
}

/// Units of a scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Units {
    /// Always `m`.
    pub length: String,
    /// Always `rad`.
    pub angle: String,
}

/// An axis-aligned box in the world frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// Lower corner, m.
    pub min: [f64; 3],
    /// Upper corner, m.
    pub max: [f64; 3],
}

/// A planar base pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// World x, m.
    pub x: f64,
    /// World y, m.
    pub y: f64,
    /// Heading, rad, 0 along world x.
    pub yaw: f64,
}

/// Figures of the run protocol. Defaults: HEATS sect. VI-B.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Limits {
    /// Largest speed of the base, m/s.
    pub v_max: f64,
    /// Largest turn rate of the base, rad/s.
    pub w_max: f64,
    /// Largest speed of each joint, rad/s.
    pub joint_v_max: f64,
    /// Largest distance at which a surface counts as inspected and a tag can be detected, m.
    pub d_ins: f64,
    /// Edge of a voxel, m.
    pub voxel: f64,
    /// Simulated time after which a run ends, s.
    pub time_limit: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            v_max: 0.8,
            w_max: 1.5,
            joint_v_max: 0.8,
            d_ins: 4.0,
            voxel: 0.15,
            time_limit: 900.0,
        }
    }
}

/// A square target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tag {
    /// Its number, unique in the scene.
    pub id: u32,
    /// Centre in the world frame, m.
    pub center: [f64; 3],
    /// Unit vector out of the printed face.
    pub normal: [f64; 3],
    /// Unit vector in the tag plane; the tag's image x axis is up × normal.
    pub up: [f64; 3],
    /// Edge of the black square, m.
    pub size: f64,
    /// Object it is fixed to: the part of a shape name before the first dot, or `wall`.
    #[serde(default)]
    pub attached_to: String,
    /// Kind of place.
    #[serde(default)]
    pub category: String,
}

impl Tag {
    /// The four corners in the world frame, in order around the square, m.
    pub fn corners(&self) -> [[f64; 3]; 4] {
        let (u, n, h) = (self.up, self.normal, 0.5 * self.size);
        let x = [
            u[1] * n[2] - u[2] * n[1],
            u[2] * n[0] - u[0] * n[2],
            u[0] * n[1] - u[1] * n[0],
        ];
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(a, b)| [0, 1, 2].map(|k| self.center[k] + h * (a * x[k] + b * u[k])))
    }
}

/// A room, for judging region segmentation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Room {
    /// Its name.
    pub name: String,
    /// Lower corner, m.
    pub min: [f64; 2],
    /// Upper corner, m.
    pub max: [f64; 2],
}

/// A box that may hold the sought object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetVolume {
    /// Its name.
    pub name: String,
    /// Lower corner, m.
    pub min: [f64; 3],
    /// Upper corner, m.
    pub max: [f64; 3],
    /// Prior probability.
    pub p: f64,
}

/// A solid of the world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum Shape {
    /// A box, upright or turned.
    Box(BoxShape),
    /// A cylinder, its axis along local z.
    Cylinder(CylinderShape),
    /// A triangle mesh in the world frame.
    Mesh(MeshShape),
}

impl Shape {
    /// `object.part`.
    pub fn name(&self) -> &str {
        match self {
            Self::Box(s) => &s.name,
            Self::Cylinder(s) => &s.name,
            Self::Mesh(s) => &s.name,
        }
    }
}

/// A box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxShape {
    /// `object.part`.
    pub name: String,
    /// Centre in the world frame, m.
    pub center: [f64; 3],
    /// Half the edges, m.
    pub half_extents: [f64; 3],
    /// Rotation about z, rad; excludes `quat`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw: Option<f64>,
    /// Unit quaternion w, x, y, z; excludes `yaw`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quat: Option<[f64; 4]>,
}

/// A cylinder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CylinderShape {
    /// `object.part`.
    pub name: String,
    /// Centre in the world frame, m.
    pub center: [f64; 3],
    /// Radius, m.
    pub radius: f64,
    /// Half the length along the axis, m.
    pub half_height: f64,
    /// Unit quaternion w, x, y, z that turns local z into the axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quat: Option<[f64; 4]>,
}

/// A triangle mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshShape {
    /// `object.part`.
    pub name: String,
    /// Corners in the world frame, m.
    pub vertices: Vec<[f64; 3]>,
    /// Three indices into `vertices` each.
    pub triangles: Vec<[u32; 3]>,
}
