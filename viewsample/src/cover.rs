//! Few views instead of many: views from given places, and greedy cover by what each view adds to those before it.

use std::collections::{BTreeMap, BinaryHeap};

use crate::gain::Words;
use crate::robot::{CostModel, Robot};
use crate::sampler::{Sampler, check_pose};
use crate::{Effort, Error, Gain, Pose, Viewpoint};

/// Cells of a view by word: index, then exploration bits of the LiDAR, those only a camera sees, inspection bits.
pub(crate) type Sight = Vec<(usize, [u64; 3])>;

/// What the views chosen so far cover, by word: exploration bits, inspection bits.
#[derive(Default)]
pub(crate) struct Covered(Vec<(u64, u64)>);

impl Covered {
    pub(crate) fn add(&mut self, sight: &Sight) {
        for &(word, [l, e, i]) in sight {
            if self.0.len() <= word {
                self.0.resize(word + 1, (0, 0));
            }
            self.0[word].0 |= l | e;
            self.0[word].1 |= i;
        }
    }

    /// What a view adds.
    pub(crate) fn added<S: Clone>(&self, sampler: &Sampler<S>, sight: &Sight) -> Gain {
        let (mut lidar, mut extra, mut inspection) = (0, 0, 0);
        for &(word, [l, e, i]) in sight {
            let (known_e, known_i) = self.0.get(word).copied().unwrap_or_default();
            lidar += (l & !known_e).count_ones();
            extra += (e & !known_e).count_ones();
            inspection += sampler.world().worth(word, i & !known_i);
        }
        sampler.gain_of(lidar, extra, inspection)
    }
}

/// Views of the LiDAR, one for all positions in a square of [`Params::lidar_grid`](crate::Params::lidar_grid).
#[derive(Default)]
pub(crate) struct SharedLidar(BTreeMap<[i64; 2], Words>);

impl SharedLidar {
    fn at<S: Clone>(&mut self, sampler: &Sampler<S>, base: [f64; 3]) -> &Words {
        let sensors = sampler.sensors();
        let eye = sensors.lidar.map(|lidar| lidar.eye(base));
        let side = sampler.params().lidar_grid;
        let key = eye.map_or([0; 2], |e| {
            [0, 1].map(|a| {
                if side > 0.0 {
                    (e[a] / side).floor() as i64
                } else {
                    e[a].to_bits() as i64
                }
            })
        });
        self.0.entry(key).or_insert_with(|| {
            eye.map_or_else(Vec::new, |eye| sensors.lidar_sees(sampler.world(), eye))
        })
    }
}

/// A view in the queue under what it added when last looked at.
struct Waiting {
    info: f64,
    index: usize,
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Waiting {}
impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Waiting {
    /// Most information first, ties to the lower index.
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.info
            .total_cmp(&other.info)
            .then(other.index.cmp(&self.index))
    }
}

impl<S: Clone> Sampler<S> {
    /// Views from base positions of the caller's choice, each with as many yaws as a ring has bearings: those that are
    /// free and see at least [`Params::threshold`](crate::Params::threshold), in the order of places, yaws and postures. They
    /// belong to no cluster: [`Viewpoint::cluster`] is `None` and [`Viewpoint::own`] is 0.
    ///
    /// The libraries hold no view from where the robot stands; yet turning there, or moving the arm alone, is often the
    /// cheapest way to see something else.
    ///
    /// # Errors
    /// If a pose is not finite.
    pub fn views_from<R, C>(
        &self,
        places: &[[f64; 2]],
        robot: &R,
        costs: &C,
        base: [f64; 3],
        state: &S,
    ) -> Result<(Vec<Viewpoint<S>>, Effort), Error>
    where
        R: Robot<State = S> + ?Sized,
        C: CostModel<S> + ?Sized,
    {
        check_pose(base)?;
        let mut effort = Effort::default();
        let mut views = Vec::new();
        let yaws = self.params().bearings;
        for &[x, y] in places {
            check_pose([x, y, 0.0])?;
            for k in 0..yaws {
                let pose = [x, y, std::f64::consts::TAU * k as f64 / yaws as f64];
                effort.base_checks += 1;
                if !robot.base_is_free(pose) {
                    continue;
                }
                for (index, posture) in self.postures().iter().enumerate() {
                    let seconds = costs.seconds((&base, state), (&pose, &posture.state));
                    if seconds.is_nan() || seconds == f64::INFINITY {
                        continue;
                    }
                    let seconds = seconds.max(0.0);
                    effort.body_checks += 1;
                    if !robot.is_free(pose, &posture.state) {
                        continue;
                    }
                    effort.camera_views += 1;
                    let camera = posture.camera.on(pose);
                    let gain = self.gain_at(pose, &camera)?;
                    if gain.info < self.params().threshold || gain.info <= 0.0 {
                        continue;
                    }
                    let motion = (-self.params().motion_decay * seconds).exp();
                    views.push(Viewpoint {
                        cluster: None,
                        base: pose,
                        posture: index,
                        state: posture.state.clone(),
                        camera,
                        gain,
                        own: 0,
                        seconds,
                        motion,
                        score: motion * gain.info,
                    });
                }
            }
        }
        Ok((views, effort))
    }

    /// The cells of a view, the LiDAR's from near it.
    pub(crate) fn sight_sharing(
        &self,
        shared: &mut SharedLidar,
        base: [f64; 3],
        camera: &Pose,
    ) -> Result<Sight, Error> {
        check_pose(base)?;
        if !camera.is_finite() {
            return Err(Error::Pose(camera.translation));
        }
        if self.world().words == 0 {
            return Ok(Sight::new());
        }
        let lidar = shared.at(self, base);
        let mut sight: Sight = lidar
            .iter()
            .map(|&(word, mask)| (word as usize, [mask, 0, 0]))
            .collect();
        self.sensors()
            .camera_sees(self.world(), camera, lidar, |word, e, i| {
                sight.push((word, [0, e, i]));
            });
        Ok(sight)
    }

    /// What a view would see now, the LiDAR from near it.
    pub(crate) fn gain_sharing(
        &self,
        shared: &mut SharedLidar,
        base: [f64; 3],
        camera: &Pose,
    ) -> Result<Gain, Error> {
        let (mut lidar, mut extra, mut inspection) = (0, 0, 0);
        for (word, [l, e, i]) in self.sight_sharing(shared, base, camera)? {
            lidar += l.count_ones();
            extra += e.count_ones();
            inspection += self.world().worth(word, i);
        }
        Ok(self.gain_of(lidar, extra, inspection))
    }

    /// The cells of a view.
    pub(crate) fn sight(&self, base: [f64; 3], camera: &Pose) -> Result<Sight, Error> {
        let mut sight = Sight::new();
        self.look(base, camera, |word, cells| sight.push((word, cells)))?;
        Ok(sight)
    }

    /// What the cameras see on the way through the given base and camera poses, each cell counted once. With a LiDAR only
    /// inspection cells count: what the LiDAR sees on a way does not depend on the arm.
    ///
    /// # Errors
    /// If a pose is not finite.
    pub fn gain_along(&self, way: &[([f64; 3], Pose)]) -> Result<Gain, Error> {
        let mut seen: BTreeMap<usize, [u64; 2]> = BTreeMap::new();
        let with_lidar = self.has_lidar();
        for (base, camera) in way {
            self.look_without_lidar(*base, camera, |word, e, i| {
                let cells = seen.entry(word).or_default();
                cells[0] |= if with_lidar { 0 } else { e };
                cells[1] |= i;
            })?;
        }
        let (mut exploration, mut inspection) = (0, 0);
        for (word, [e, i]) in seen {
            exploration += e.count_ones();
            inspection += self.world().worth(word, i);
        }
        Ok(self.gain_of(exploration, 0, inspection))
    }

    /// Greedy cover: of the views given, the one of most information, then again and again the one that adds most to those
    /// chosen, as long as it adds at least `least`. Returns indices and what each adds, in the order of choice.
    ///
    /// Greedy choice sees at least 1 - 1/e of what the best set of as many views sees (Nemhauser, Wolsey and Fisher 1978).
    ///
    /// # Errors
    /// If a pose is not finite.
    pub fn cover(
        &self,
        views: &[Viewpoint<S>],
        least: f64,
    ) -> Result<(Vec<(usize, Gain)>, Effort), Error> {
        let mut effort = Effort::default();
        let mut sights: Vec<Option<Sight>> = vec![None; views.len()];
        let mut covered = Covered::default();
        let mut queue: BinaryHeap<Waiting> = (0..views.len())
            .map(|index| Waiting {
                info: f64::INFINITY,
                index,
            })
            .collect();
        let mut chosen = Vec::new();
        while let Some(Waiting { info, index }) = queue.pop() {
            if info < least {
                break;
            }
            let view = &views[index];
            let slot = &mut sights[index];
            let sight = match slot {
                Some(sight) => sight,
                None => {
                    effort.camera_views += 1;
                    slot.insert(self.sight(view.base, &view.camera)?)
                }
            };
            let gain = covered.added(self, sight);
            // Gains only shrink, so a view that still leads the queue adds most.
            if queue.peek().is_some_and(|next| {
                Waiting {
                    info: gain.info,
                    index,
                } < *next
            }) {
                queue.push(Waiting {
                    info: gain.info,
                    index,
                });
                continue;
            }
            if gain.info < least || gain.info <= 0.0 {
                break;
            }
            covered.add(sight);
            chosen.push((index, gain));
        }
        Ok((chosen, effort))
    }
}
