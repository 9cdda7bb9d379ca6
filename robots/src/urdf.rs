//! Arms from a URDF file, with spheres, camera and pairs from a small JSON file beside it.
//!
//! ```json
//! {
//!   "base": "base_link", "tip": "tool0",
//!   "camera": { "link": "tool0", "xyz": [0, 0, 0.05], "rpy": [0, 0, 0] },
//!   "spheres": [ { "link": "forearm_link", "center": [0, 0, 0.1], "radius": 0.06 } ],
//!   "ignore": [ ["forearm_link", "wrist_1_link"] ]
//! }
//! ```
//!
//! Only `base` and `tip` are needed. The camera's link is the tip unless another link behind the last joint is named.
//! Spheres of links that no moving joint separates, of neighbouring links and of the pairs in `ignore` are not tested
//! against each other.

use crate::chain::{Chain, ChainJoint, ChainSphere, JointKind};
use crate::error::Error;
use crate::frame::{Frame, norm, scale};
use serde::Deserialize;
use std::path::Path;
use urdf_rs::JointType;

/// The file beside the URDF.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UrdfSide {
    /// Link that the chain starts from.
    pub base: String,
    /// Link that the chain ends with.
    pub tip: String,
    /// The camera, if there is one.
    pub camera: Option<UrdfCamera>,
    /// Balls on links of the chain, or fixed to one.
    #[serde(default)]
    pub spheres: Vec<UrdfSphere>,
    /// Pairs of links whose balls may touch.
    #[serde(default)]
    pub ignore: Vec<(String, String)>,
}

/// Where the camera sits; optical frame: z forward, x right, y down.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UrdfCamera {
    /// Link it is fixed to.
    pub link: String,
    /// Origin in the link's frame, m.
    #[serde(default)]
    pub xyz: [f64; 3],
    /// Roll, pitch, yaw in the link's frame, rad, as in URDF.
    #[serde(default)]
    pub rpy: [f64; 3],
}

/// A ball on a link.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UrdfSphere {
    /// The link.
    pub link: String,
    /// Centre in the link's frame, m.
    pub center: [f64; 3],
    /// m.
    pub radius: f64,
}

impl Chain {
    /// Reads a URDF file and the JSON file beside it.
    ///
    /// # Errors
    /// Files that cannot be read or parsed, links that do not exist or do not hang together, joints that are neither
    /// revolute, continuous, prismatic nor fixed.
    pub fn from_urdf_files(urdf: &Path, side: &Path) -> Result<Self, Error> {
        let read = |path: &Path| {
            std::fs::read_to_string(path).map_err(|e| bad(format!("{}: {e}", path.display())))
        };
        Self::from_urdf(&read(urdf)?, &read(side)?)
    }

    /// The same from the files' contents.
    ///
    /// # Errors
    /// As [`from_urdf_files`](Self::from_urdf_files).
    pub fn from_urdf(urdf: &str, side: &str) -> Result<Self, Error> {
        let robot = urdf_rs::read_from_string(urdf).map_err(|e| bad(format!("URDF: {e}")))?;
        let side: UrdfSide =
            serde_json::from_str(side).map_err(|e| bad(format!("side file: {e}")))?;
        let tree = Tree { robot: &robot };
        let path = tree.path(&side.base, &side.tip)?;
        // Walk from the base; fixed joints are folded into the frame before the next moving one.
        let mut joints = Vec::new();
        let mut ahead = Frame::IDENTITY;
        for joint in &path {
            ahead = ahead.then(&placement(joint.origin.xyz.0, joint.origin.rpy.0));
            if let Some(kind) = kind(joint)? {
                let axis = joint.axis.xyz.0;
                let length = norm(axis);
                if length.is_nan() || length < 1e-9 {
                    return Err(bad(format!(
                        "joint `{}`: its axis has no length",
                        joint.name
                    )));
                }
                let limits = match joint.joint_type {
                    JointType::Continuous => (f64::NEG_INFINITY, f64::INFINITY),
                    _ => (joint.limit.lower, joint.limit.upper),
                };
                joints.push(ChainJoint {
                    name: joint.name.clone(),
                    kind,
                    before: ahead,
                    axis: scale(axis, 1.0 / length),
                    limits,
                    speed: if joint.limit.velocity > 0.0 {
                        joint.limit.velocity
                    } else {
                        f64::INFINITY
                    },
                });
                ahead = Frame::IDENTITY;
            }
        }
        let mut chain = Self::new(joints, ahead)?;
        let place = |link: &str| tree.place(link, &side, &path);
        if let Some(camera) = &side.camera {
            let (count, frame) = place(&camera.link)?;
            if count != chain.len() {
                return Err(bad(format!(
                    "camera: link `{}` is not behind the last joint",
                    camera.link
                )));
            }
            let in_last = frame.then(&placement(camera.xyz, camera.rpy));
            chain.camera = chain.tip.inverse().then(&in_last);
        }
        for s in &side.spheres {
            let (joint, frame) = place(&s.link)?;
            chain.spheres.push(ChainSphere {
                joint,
                center: frame.apply(s.center),
                radius: s.radius,
            });
        }
        for (a, b) in &side.ignore {
            place(a)?;
            place(b)?;
        }
        for i in 0..side.spheres.len() {
            for j in i + 1..side.spheres.len() {
                let apart = chain.spheres[i].joint.abs_diff(chain.spheres[j].joint);
                let (a, b) = (&side.spheres[i].link, &side.spheres[j].link);
                let named = |(x, y): &(String, String)| x == a && y == b || x == b && y == a;
                if apart >= 2 && !side.ignore.iter().any(named) {
                    chain.pairs.push((i, j));
                }
            }
        }
        chain.validate()?;
        Ok(chain)
    }
}

struct Tree<'a> {
    robot: &'a urdf_rs::Robot,
}

impl<'a> Tree<'a> {
    fn known(&self, link: &str) -> Result<(), Error> {
        match self.robot.links.iter().any(|l| l.name == link) {
            true => Ok(()),
            false => Err(bad(format!("no link `{link}` in the URDF"))),
        }
    }

    /// Joints from one link down to another.
    fn path(&self, from: &str, to: &str) -> Result<Vec<&'a urdf_rs::Joint>, Error> {
        self.known(from)?;
        self.known(to)?;
        let mut path = Vec::new();
        let mut at = to;
        while at != from {
            let above = self.robot.joints.iter().find(|j| j.child.link == at);
            // A loop of joints would be followed for ever.
            let Some(joint) = above.filter(|_| path.len() <= self.robot.joints.len()) else {
                return Err(bad(format!("link `{to}` does not hang below `{from}`")));
            };
            path.push(joint);
            at = &joint.parent.link;
        }
        path.reverse();
        Ok(path)
    }

    /// Number of moving joints before a link, and its pose in the frame after the last of them.
    fn place(
        &self,
        link: &str,
        side: &UrdfSide,
        chain: &[&urdf_rs::Joint],
    ) -> Result<(usize, Frame), Error> {
        let (mut count, mut frame) = (0, Frame::IDENTITY);
        for joint in self.path(&side.base, link)? {
            let on_chain = chain.iter().any(|j| std::ptr::eq(*j, joint));
            frame = frame.then(&placement(joint.origin.xyz.0, joint.origin.rpy.0));
            if kind(joint)?.is_some() {
                if !on_chain {
                    let name = &joint.name;
                    return Err(bad(format!(
                        "link `{link}` moves with joint `{name}`, which is not on the way to the tip"
                    )));
                }
                count += 1;
                frame = Frame::IDENTITY;
            }
        }
        Ok((count, frame))
    }
}

/// How a joint moves; `None` for a fixed one.
fn kind(joint: &urdf_rs::Joint) -> Result<Option<JointKind>, Error> {
    match joint.joint_type {
        JointType::Fixed => Ok(None),
        JointType::Revolute | JointType::Continuous => Ok(Some(JointKind::Revolute)),
        JointType::Prismatic => Ok(Some(JointKind::Prismatic)),
        _ => Err(bad(format!(
            "joint `{}` is {:?}; a chain knows revolute, continuous, prismatic and fixed ones",
            joint.name, joint.joint_type
        ))),
    }
}

/// Frame at `xyz` turned by roll, pitch and yaw about the fixed axes x, y, z (URDF's order).
fn placement(xyz: [f64; 3], rpy: [f64; 3]) -> Frame {
    let ((sr, cr), (sp, cp), (sy, cy)) = (rpy[0].sin_cos(), rpy[1].sin_cos(), rpy[2].sin_cos());
    Frame {
        x: [cy * cp, sy * cp, -sp],
        y: [cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr],
        z: [cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr],
        p: xyz,
    }
}

fn bad(what: String) -> Error {
    Error::Chain { what }
}
