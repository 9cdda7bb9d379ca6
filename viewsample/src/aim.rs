//! Views aimed at single faces: for what no view of a library shows, or only together with little else.
//!
//! A library has a few camera attitudes, each pointing away from the base towards a cluster's centroid. The underside of a table,
//! the top of a cabinet, the wall behind a chair are in sight of many poses that an arm can take up and no library has. Here
//! the camera comes first: a place from which a face is in sight, steeply enough; then a roll, then a base from which the arm
//! reaches it.

use crate::cover::SharedLidar;
use crate::rng::Rng;
use crate::robot::{CostModel, Robot};
use crate::sampler::{Sampler, check_pose};
use crate::world::World;
use crate::{Effort, Error, InverseReach, Kind, Pose, Viewpoint};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Share of the image in which a face is shown that is not in its middle.
const IMAGE: f64 = 0.8;

/// How views are aimed.
#[derive(Clone, Debug, PartialEq)]
pub struct Aim {
    /// Distances of the camera from the face, m.
    pub distance: (f64, f64),
    /// Largest angle between the face's normal and the direction to the camera, rad.
    pub tilt: f64,
    /// Heights of the camera, m.
    pub heights: (f64, f64),
    /// The sphere around the base's axis that holds every place of the camera: height of its middle and its radius, m.
    pub reach: (f64, f64),
    /// Views wanted for each cluster.
    pub views: usize,
    /// Camera places tried for each cluster.
    pub tries: usize,
    /// Base poses tried for each camera place.
    pub bases: usize,
    /// Least information gain of a view.
    pub threshold: f64,
    /// Seed of the choices.
    pub seed: u64,
}

impl<S: Clone> Sampler<S> {
    /// Views that show faces of the clusters named, each free and worth at least [`Aim::threshold`], in the order of clusters. Base
    /// places are drawn around the camera, and from `places`, so that several views share one. The same seed, clusters
    /// and map give the same views. [`Viewpoint::posture`] counts beyond the postures of the library. Unknown ids are passed over.
    ///
    /// With a `reach`, base poses are drawn from those that reach the camera, else from all around it: dearer, but it finds the few
    /// poses of a camera at the edge of what the arm can do.
    ///
    /// For maps that inspect whole voxels every face counts as open.
    ///
    /// # Errors
    /// If a pose is not finite or a field of `aim` out of its range.
    pub fn aimed<R, C>(
        &self,
        aim: &Aim,
        clusters: &[u64],
        places: &[[f64; 2]],
        robot: &R,
        costs: &C,
        (base, state): (&[f64; 3], &S),
        mut reach: Option<&mut InverseReach>,
    ) -> Result<(Vec<Viewpoint<S>>, Effort), Error>
    where
        R: Robot<State = S> + ?Sized,
        C: CostModel<S> + ?Sized,
    {
        aim.validate()?;
        check_pose(*base)?;
        for &[x, y] in places {
            check_pose([x, y, 0.0])?;
        }
        let mut effort = Effort::default();
        let mut lidar = SharedLidar::default();
        let mut views = Vec::new();
        for id in clusters {
            let Some(library) = self.cluster(*id) else {
                continue;
            };
            let mut rng = Rng::new(aim.seed ^ id.wrapping_mul(0x9e37_79b9_7f4a_7c15));
            let mut wanted = aim.views;
            let c = library.centroid;
            let near: Vec<[f64; 2]> = places
                .iter()
                .copied()
                .filter(|p| (p[0] - c[0]).hypot(p[1] - c[1]) < aim.reach.1 + aim.distance.1)
                .collect();
            for k in 0..aim.tries {
                if wanted == 0 {
                    break;
                }
                let cell = library.cells[rng.below(library.cells.len())];
                let inspection = library.kind == Kind::Inspection;
                // Every other try asks what the arm can show from a place that is visited anyway.
                let stand = (!near.is_empty() && k % 2 == 0).then(|| near[rng.below(near.len())]);
                let around = (library.centroid, inspection);
                let Some((sight, camera)) = aim.place(self, cell, around, stand, &mut rng) else {
                    continue;
                };
                let eye = camera.translation;
                let mut bases = (0..aim.bases).map_while(|_| match (stand, reach.as_deref_mut()) {
                    (Some([x, y]), _) => Some([x, y, rng.between(0.0, TAU)]),
                    (None, Some(reach)) => reach.base(robot, &camera, rng.between(0.0, 1.0)),
                    (None, None) => {
                        let radius = aim.radius(eye[2]) * rng.between(0.0, 1.0).sqrt();
                        let (s, c) = rng.between(0.0, TAU).sin_cos();
                        let place = [eye[0] + radius * c, eye[1] + radius * s];
                        Some([place[0], place[1], rng.between(0.0, TAU)])
                    }
                });
                let Some(first) = bases.next() else {
                    continue;
                };
                if !sight.is_clear(self) {
                    continue;
                }
                for pose in std::iter::once(first).chain(bases) {
                    effort.base_checks += 1;
                    if !robot.base_is_free(pose) {
                        continue;
                    }
                    effort.body_checks += 1;
                    let Some(joints) = robot.take_up(pose, &camera, state) else {
                        continue;
                    };
                    let seconds = costs.seconds((base, state), (&pose, &joints));
                    if seconds.is_nan() || seconds == f64::INFINITY {
                        break;
                    }
                    effort.camera_views += 1;
                    let gain = self.gain_sharing(&mut lidar, pose, &camera)?;
                    if gain.info >= aim.threshold && gain.info > 0.0 {
                        let seconds = seconds.max(0.0);
                        let motion = (-self.params().motion_decay * seconds).exp();
                        views.push(Viewpoint {
                            cluster: Some(*id),
                            base: pose,
                            posture: self.postures().len(),
                            state: joints,
                            camera,
                            gain,
                            own: 0,
                            seconds,
                            motion,
                            score: motion * gain.info,
                        });
                        wanted -= 1;
                    }
                    break;
                }
            }
        }
        Ok((views, effort))
    }
}

/// A line of sight from a place to a cell, or to one of its faces.
struct Sight {
    eye: [f64; 3],
    word: usize,
    bit: u32,
    face: Option<usize>,
}

impl Sight {
    fn is_clear<S: Clone>(&self, sampler: &Sampler<S>) -> bool {
        let (world, allowance) = (sampler.world(), sampler.params().unknown_allowance);
        let (eye, mask) = (world.eye(self.eye), 1 << self.bit);
        let seen = match self.face {
            Some(face) => world.visible_across(&eye, self.word, mask, face, allowance),
            None => world.visible(&eye, self.word, mask, allowance),
        };
        seen != 0
    }
}

impl Aim {
    /// Checks every range.
    ///
    /// # Errors
    /// [`Error::Param`] for the first field outside its range.
    pub fn validate(&self) -> Result<(), Error> {
        let check = |ok: bool, field, value, range| {
            if ok {
                Ok(())
            } else {
                Err(Error::Param {
                    field,
                    value,
                    range,
                })
            }
        };
        let (near, far) = self.distance;
        check(near > 0.0, "distance.0", near, "positive")?;
        check(
            far >= near && far.is_finite(),
            "distance.1",
            far,
            "finite, not below distance.0",
        )?;
        let tilts = 0.0..std::f64::consts::FRAC_PI_2;
        check(
            tilts.contains(&self.tilt),
            "tilt",
            self.tilt,
            "in [0, pi/2)",
        )?;
        let (low, high) = self.heights;
        check(low.is_finite(), "heights.0", low, "finite")?;
        check(
            high >= low && high.is_finite(),
            "heights.1",
            high,
            "finite, not below heights.0",
        )?;
        let (middle, radius) = self.reach;
        check(middle.is_finite(), "reach.0", middle, "finite")?;
        check(
            radius > 0.0 && radius.is_finite(),
            "reach.1",
            radius,
            "positive and finite",
        )?;
        check(
            self.threshold >= 0.0,
            "threshold",
            self.threshold,
            "zero or more",
        )
    }

    /// A camera turned to a face of the cell from where it may be in sight, steeply enough; none if the place drawn is not.
    fn place<S: Clone>(
        &self,
        sampler: &Sampler<S>,
        cell: [i32; 3],
        (centroid, inspection): ([f64; 3], bool),
        stand: Option<[f64; 2]>,
        rng: &mut Rng,
    ) -> Option<(Sight, Pose)> {
        let world: &World = sampler.world();
        let (word, bit) = world.index(cell)?;
        let open = if inspection {
            world.open_faces(word, bit)
        } else {
            0b11_1111
        };
        if open == 0 {
            return None;
        }
        let face = {
            let mut left = rng.below(open.count_ones() as usize);
            (0..6).find(|f| {
                let is = open >> f & 1 != 0;
                let hit = is && left == 0;
                left = left.saturating_sub(usize::from(is));
                hit
            })?
        };
        let (axis, sign) = (face / 2, if face % 2 == 0 { -1.0 } else { 1.0 });
        let mut middle = world.center(cell);
        middle[axis] += 0.5 * sign * world.cell_size;
        let eye = match stand {
            Some([x, y]) => {
                let (s, c) = rng.between(0.0, TAU).sin_cos();
                let height = rng.between(self.heights.0, self.heights.1);
                let radius = self.radius(height) * rng.between(0.0, 1.0).sqrt();
                [x + radius * c, y + radius * s, height]
            }
            None => self.around(middle, axis, sign, rng),
        };
        let way = [0, 1, 2].map(|a| eye[a] - middle[a]);
        let length = way.iter().map(|v| v * v).sum::<f64>().sqrt();
        let steep = !inspection || sign * way[axis] >= self.tilt.cos() * length;
        if !(self.distance.0..=self.distance.1).contains(&length) || !steep {
            return None;
        }
        if !world.is_free_at(eye) {
            return None;
        }
        // Towards the face, or what is left around it; or the face anywhere in the image, since the arm reaches some places only
        // with the camera looking elsewhere.
        let roll = match rng.below(4) {
            0 => 0.0,
            1 => FRAC_PI_2,
            2 => -FRAC_PI_2,
            _ => rng.between(0.0, TAU),
        };
        let t = rng.between(0.0, 1.0);
        let aside = rng.below(2) == 0;
        let to = if aside {
            middle
        } else {
            [0, 1, 2].map(|a| middle[a] + t * (centroid[a] - middle[a]))
        };
        let to = [0, 1, 2].map(|a| to[a] - eye[a]);
        let yaw = to[1].atan2(to[0]);
        let pitch = to[2].atan2(to[0].hypot(to[1]));
        let camera = Pose::looking(eye, yaw, pitch).rolled(roll);
        let rgb = &sampler.params().rgb;
        let camera = if aside {
            camera.showing_ahead_at([
                rng.between(-IMAGE, IMAGE) * rgb.tan_half_h,
                rng.between(-IMAGE, IMAGE) * rgb.tan_half_v,
            ])
        } else {
            camera
        };
        let sight = Sight {
            eye,
            word,
            bit,
            face: inspection.then_some(face),
        };
        Some((sight, camera))
    }

    /// Largest horizontal distance from the base's axis of a camera at a height, m.
    fn radius(&self, height: f64) -> f64 {
        let (middle, radius) = self.reach;
        (radius.powi(2) - (height - middle).powi(2)).max(0.0).sqrt()
    }

    /// A place in the cone in front of a face.
    fn around(&self, middle: [f64; 3], axis: usize, sign: f64, rng: &mut Rng) -> [f64; 3] {
        let along: f64 = rng.between(self.tilt.cos(), 1.0);
        let (s, c) = rng.between(0.0, TAU).sin_cos();
        let across = (1.0 - along * along).sqrt();
        let mut out = [0.0; 3];
        out[axis] = sign * along;
        out[(axis + 1) % 3] = across * c;
        out[(axis + 2) % 3] = across * s;
        // Even in the logarithm: near ones have fewer poses, and are as likely to be what it takes.
        let r = self.distance.0 * (self.distance.1 / self.distance.0).powf(rng.between(0.0, 1.0));
        [0, 1, 2].map(|a| middle[a] + r * out[a])
    }
}
