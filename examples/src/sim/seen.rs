//! Which surface the RGB camera has had in sight: one measure for all planners, whatever their maps call inspected.

use super::body::CameraPose;
use super::detector::TagCamera;
use super::truth::GroundTruth;
use super::world::World;

/// The observable surface, and what of it sharp images have shown: the middle of a face of a voxel towards free space, inside the image,
/// within the range of detection, with nothing in the line of sight (G item 13, judged by exact geometry). How steeply a face is seen,
/// and whether a target on it would be whole in the image, does not count.
#[derive(Clone, Debug)]
pub struct SurfaceSeen {
    lens: TagCamera,
    /// Voxels that no image has shown yet.
    unseen: Vec<Voxel>,
    all: usize,
    /// Half a voxel's edge, m.
    half: f64,
}

/// A voxel of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Voxel {
    /// Its middle, m.
    middle: [f64; 3],
    /// Faces towards free space that can be reached: bit 2 k for the lower one on axis k, bit 2 k + 1 for the upper one.
    faces: u8,
}

impl SurfaceSeen {
    /// The surface of a scene to be inspected ([`GroundTruth::inspectable`]), none of it seen, for the camera that detects tags.
    pub fn new(truth: &GroundTruth, lens: &TagCamera) -> Self {
        let unseen: Vec<Voxel> = truth
            .inspectable()
            .map(|cell| Voxel {
                middle: truth.center(cell.map(|v| v as usize)),
                faces: (0..6).fold(0, |faces, face| {
                    let mut beside = cell;
                    beside[face / 2] += if face % 2 == 0 { -1 } else { 1 };
                    faces | u8::from(truth.is_reachable(beside)) << face
                }),
            })
            .collect();
        Self {
            lens: *lens,
            all: unseen.len(),
            unseen,
            half: 0.5 * truth.cell_size(),
        }
    }

    /// Takes in the image of a camera that turns at `turn` rad/s; blurred ones show nothing. Returns how many voxels it was the first
    /// to show.
    pub fn look(&mut self, world: &World, camera: &CameraPose, turn: f64) -> usize {
        if turn >= self.lens.max_turn {
            return 0;
        }
        let (lens, half) = (self.lens, self.half);
        let reach2 = (lens.max_distance + half).powi(2);
        let before = self.unseen.len();
        self.unseen.retain(|voxel| {
            let near = (0..3)
                .map(|k| (voxel.middle[k] - camera.1[k]).powi(2))
                .sum::<f64>();
            near > reach2
                || !(0..6).any(|face| {
                    voxel.faces >> face & 1 != 0
                        && is_shown(&lens, world, camera, voxel.middle, (face, half))
                })
        });
        before - self.unseen.len()
    }

    /// Share of the surface that was seen, 0..1; 1 when there is none.
    pub fn fraction(&self) -> f64 {
        if self.all == 0 {
            return 1.0;
        }
        (self.all - self.unseen.len()) as f64 / self.all as f64
    }
}

/// Whether an image shows the middle of a voxel's face, `half` m from the voxel's middle.
fn is_shown(
    lens: &TagCamera,
    world: &World,
    camera: &CameraPose,
    middle: [f64; 3],
    (face, half): (usize, f64),
) -> bool {
    let (axis, sign) = (face / 2, if face % 2 == 0 { -1.0 } else { 1.0 });
    let eye = camera.1;
    let mut point = middle;
    point[axis] += sign * half;
    let way = [0, 1, 2].map(|k| point[k] - eye[k]);
    let far = way.iter().map(|v| v * v).sum::<f64>() > lens.max_distance.powi(2);
    if far || sign * way[axis] >= 0.0 || lens.inside(camera, point).is_none() {
        return false;
    }
    // The surface may lie in the plane of the face itself.
    let short = way.map(|v| (1.0 - 1e-6) * v);
    world.cast(eye, short, 1.0).is_none()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    /// World of the closet, its surface, and a camera in its middle that looks along x.
    fn closet() -> (World, SurfaceSeen, CameraPose) {
        let scene = Scene::builtin("closet").expect("embedded");
        let world = World::new(&scene);
        let truth = GroundTruth::new(&scene, &world, 0.15).expect("a small grid");
        let seen = SurfaceSeen::new(&truth, &TagCamera::new(4.0));
        let middle = [0, 1].map(|k| 0.5 * (scene.bounds.min[k] + scene.bounds.max[k]));
        // Columns are the image's right, its down, and ahead.
        let ahead = [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
        (world, seen, (ahead, [middle[0], middle[1], 1.3]))
    }

    #[test]
    fn an_image_shows_what_it_shows_once_and_only_if_sharp() {
        let (world, mut seen, camera) = closet();
        assert_eq!(seen.fraction(), 0.0);
        assert_eq!(seen.look(&world, &camera, 1.0), 0);
        let shown = seen.look(&world, &camera, 0.5);
        assert!(shown > 50, "{shown}");
        assert!((seen.fraction() - shown as f64 / seen.all as f64).abs() < 1e-12);
        assert_eq!(seen.look(&world, &camera, 0.5), 0);
    }

    /// What one image shows is before the camera, inside the image and in sight of it, and what it does not show is not.
    #[test]
    fn all_that_is_in_sight_is_seen_and_nothing_else() {
        let (world, mut seen, camera) = closet();
        let all = seen.unseen.clone();
        seen.look(&world, &camera, 0.0);
        let (across, down) = seen.lens.tangents();
        let mut shown = 0;
        for voxel in &all {
            // The camera looks along x: left of the image is y.
            let in_sight = (0..6)
                .filter(|face| voxel.faces >> face & 1 != 0)
                .any(|face| {
                    let out = if face % 2 == 0 { -1.0 } else { 1.0 };
                    let mut p = voxel.middle;
                    p[face / 2] += out * seen.half;
                    let d = [0, 1, 2].map(|k| p[k] - camera.1[k]);
                    d[0] > 0.0
                        && d[1].abs() <= across * d[0]
                        && d[2].abs() <= down * d[0]
                        && d[0].hypot(d[1]).hypot(d[2]) <= 4.0
                        && out * d[face / 2] < 0.0
                        && world.visible(
                            camera.1,
                            [0, 1, 2].map(|k| camera.1[k] + (1.0 - 1e-6) * d[k]),
                        )
                });
            assert_eq!(in_sight, !seen.unseen.contains(voxel), "{voxel:?}");
            shown += usize::from(in_sight);
        }
        assert!(
            shown > 50 && shown < all.len() / 2,
            "{shown} of {}",
            all.len()
        );
    }
}
