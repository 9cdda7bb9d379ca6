//! The collision model of the arm: the table of spheres fixed to its links, and the pairs that can touch.

use crate::camera::Camera;
use crate::shapes::{CAMERA_LINK, CAPSULES, Capsule, LinkSizes, Sphere, cover_capsule};
use crate::ur5e::Ur5e;

/// Spheres on the arm and the camera.
pub const ARM_SPHERES: usize = 25;
/// Spheres that cover each capsule, in the order of [`LinkSizes::capsules`]; two more cover the camera.
pub const SPHERES_PER_CAPSULE: [usize; CAPSULES] = [2, 2, 6, 2, 6, 2, 2, 1];

/// The arm's solids and the spheres that contain them, each in the DH frame of its link.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmBody {
    /// The links as capsules, in DH frame `link`.
    pub capsules: [Capsule; CAPSULES],
    /// Spheres that contain the capsules and the camera's box, in DH frame `min(link, 6)`.
    pub spheres: [Sphere; ARM_SPHERES],
    /// Pairs of spheres (lower index first) that are tested against each other: those of [`LINK_PAIRS`].
    pub pairs: Vec<(u8, u8)>,
}

/// Pairs of links that can touch.
///
/// Left out: neighbours, and links that the offsets of the wrist keep apart at every joint angle (forearm and
/// second wrist housing: 0.126 m between axes, 0.085 m of radii; first and third wrist housing: 0.0997 m and
/// 0.090 m; camera and the first two wrist housings: its box cannot cross the planes between them).
pub const LINK_PAIRS: [(u8, u8); 11] = [
    (1, 3),
    (1, 4),
    (1, 5),
    (1, 6),
    (1, 7),
    (2, 4),
    (2, 5),
    (2, 6),
    (2, 7),
    (3, 6),
    (3, 7),
];

impl ArmBody {
    /// The collision model of an arm with a camera on its flange.
    #[must_use]
    pub fn new(arm: &Ur5e, sizes: &LinkSizes, camera: &Camera) -> Self {
        let capsules = sizes.capsules(arm);
        let mut spheres = [Sphere::default(); ARM_SPHERES];
        let mut n = 0;
        for (capsule, count) in capsules.iter().zip(SPHERES_PER_CAPSULE) {
            cover_capsule(capsule, count, |s| {
                spheres[n] = s;
                n += 1;
            });
        }
        // The camera's box is cut across its longest edge into two; each half gets its circumscribed sphere.
        let (cuboid, half) = (camera.body(), camera.half);
        let long = if half[0] >= half[1] && half[0] >= half[2] {
            0
        } else if half[1] >= half[2] {
            1
        } else {
            2
        };
        let mut part = half;
        part[long] *= 0.5;
        let radius = part.iter().map(|v| v * v).sum::<f64>().sqrt() + 1e-9;
        for side in [-1.0, 1.0] {
            let mut center = [0.0; 3];
            center[long] = side * part[long];
            spheres[n] = Sphere {
                center: cuboid.frame.apply(center),
                radius,
                link: CAMERA_LINK,
            };
            n += 1;
        }
        debug_assert_eq!(n, ARM_SPHERES);
        let mut pairs = Vec::new();
        for i in 0..ARM_SPHERES {
            for j in i + 1..ARM_SPHERES {
                if LINK_PAIRS.contains(&(spheres[i].link, spheres[j].link)) {
                    pairs.push((i as u8, j as u8));
                }
            }
        }
        Self {
            capsules,
            spheres,
            pairs,
        }
    }
}
