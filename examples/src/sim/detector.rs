//! Tag detection in the RGB image, judged by exact geometry (G item 45 of the HEATS defaults).

use super::body::CameraPose;
use super::world::World;
use crate::scene::Tag;

/// Sight lines end this far in front of the tag, m, so that the surface it is fixed to does not hide it.
const OFFSET: f64 = 0.002;

/// The RGB camera and what a detection takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TagCamera {
    /// Pixels across and down.
    pub size: [f64; 2],
    /// Horizontal and vertical field of view, rad.
    pub field: [f64; 2],
    /// Largest distance from camera to tag centre, m.
    pub max_distance: f64,
    /// Largest angle between sight line and tag normal, rad.
    pub max_incidence: f64,
    /// Smallest apparent side, px: the square root of the tag's area in the image.
    pub min_side: f64,
    /// Images taken while the camera turns faster than this are blurred, rad/s.
    pub max_turn: f64,
    /// Consecutive images a detection takes.
    pub frames: u32,
    /// Images a second.
    pub rate: f64,
}

impl TagCamera {
    /// The defaults for a scene's `d_ins`, m.
    pub fn new(max_distance: f64) -> Self {
        Self {
            size: [1280.0, 720.0],
            field: [69.0_f64.to_radians(), 42.0_f64.to_radians()],
            max_distance,
            max_incidence: 65.0_f64.to_radians(),
            min_side: 24.0,
            max_turn: 1.0,
            frames: 2,
            rate: 10.0,
        }
    }

    /// Tangents of half the field of view, across and down.
    pub fn tangents(&self) -> (f64, f64) {
        let [across, down] = self.field.map(|angle| (0.5 * angle).tan());
        (across, down)
    }

    /// A world point in the camera frame (m), if it is inside the image.
    pub(super) fn inside(&self, (rotation, origin): &CameraPose, p: [f64; 3]) -> Option<[f64; 3]> {
        let tangent = <[f64; 2]>::from(self.tangents());
        let d = [0, 1, 2].map(|k| p[k] - origin[k]);
        let c = [0, 1, 2].map(|j| (0..3).map(|k| rotation[k][j] * d[k]).sum::<f64>());
        let inside = c[2] > 0.0 && (0..2).all(|k| c[k].abs() <= tangent[k] * c[2]);
        inside.then_some(c)
    }

    /// Whether one image of a camera at rest shows the tag well enough.
    pub fn sees(&self, world: &World, pose: &CameraPose, tag: &Tag) -> bool {
        let origin = &pose.1;
        let tangent = <[f64; 2]>::from(self.tangents());
        let focal = [0, 1].map(|k| 0.5 * self.size[k] / tangent[k]);
        let away = [0, 1, 2].map(|k| origin[k] - tag.center[k]);
        let distance = away.iter().map(|v| v * v).sum::<f64>().sqrt();
        let facing: f64 = (0..3).map(|k| away[k] * tag.normal[k]).sum();
        if distance > self.max_distance || facing < distance * self.max_incidence.cos() {
            return false;
        }
        let project = |p: [f64; 3]| {
            let c = self.inside(pose, p)?;
            Some([0, 1].map(|k| focal[k] * c[k] / c[2]))
        };
        let corners = tag.corners();
        let mut image = [[0.0; 2]; 4];
        for (pixel, corner) in image.iter_mut().zip(corners) {
            let Some(p) = project(corner) else {
                return false;
            };
            *pixel = p;
        }
        let area = (0..4)
            .map(|i| {
                let (a, b) = (image[i], image[(i + 1) % 4]);
                0.5 * (a[0] * b[1] - b[0] * a[1])
            })
            .sum::<f64>()
            .abs();
        if area.sqrt() < self.min_side || project(tag.center).is_none() {
            return false;
        }
        let front = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] + OFFSET * tag.normal[k]);
        std::iter::once(tag.center)
            .chain(corners)
            .all(|p| world.visible(*origin, front(p)))
    }
}

/// A tag that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// The tag's id.
    pub id: u32,
    /// Simulated time, s.
    pub time: f64,
}

/// Finds the tags of a scene, each once.
#[derive(Clone, Debug)]
pub struct TagDetector {
    camera: TagCamera,
    tags: Vec<Tag>,
    /// Consecutive images that showed each tag.
    streak: Vec<u32>,
    found: Vec<Detection>,
}

impl TagDetector {
    /// A detector that has seen nothing yet.
    pub fn new(camera: TagCamera, tags: &[Tag]) -> Self {
        Self {
            camera,
            tags: tags.to_vec(),
            streak: vec![0; tags.len()],
            found: Vec::new(),
        }
    }

    /// The camera it was made with.
    pub fn camera(&self) -> &TagCamera {
        &self.camera
    }

    /// Looks at one image taken at `time` by a camera turning at `turn` rad/s; returns the tags found by it.
    pub fn frame(
        &mut self,
        world: &World,
        pose: &CameraPose,
        turn: f64,
        time: f64,
    ) -> &[Detection] {
        let before = self.found.len();
        for (i, tag) in self.tags.iter().enumerate() {
            if self.streak[i] >= self.camera.frames {
                continue;
            }
            let sharp = turn < self.camera.max_turn;
            self.streak[i] = if sharp && self.camera.sees(world, pose, tag) {
                self.streak[i] + 1
            } else {
                0
            };
            if self.streak[i] >= self.camera.frames {
                self.found.push(Detection { id: tag.id, time });
            }
        }
        &self.found[before..]
    }

    /// Notes that images were missed: what the last one showed does not count as the first of two in a row.
    pub fn interrupt(&mut self) {
        for streak in &mut self.streak {
            if *streak < self.camera.frames {
                *streak = 0;
            }
        }
    }

    /// Everything found so far, in order of detection.
    pub fn found(&self) -> &[Detection] {
        &self.found
    }
}
