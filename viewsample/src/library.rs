//! The viewpoint state library of one cluster and the lazy search for its best view.

use std::collections::BinaryHeap;

use crate::gain::{self, Sensors};
use crate::map::Cell;
use crate::params::Params;
use crate::posture::Posture;
use crate::robot::{CostModel, Robot};
use crate::tiles::{LidarView, Tiles};
use crate::world::World;
use crate::{Cluster, Effort, Gain, Kind, NoView, Pose, Viewpoint};

/// What a check said, if it was made since the map near it changed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Check {
    Open,
    Yes,
    No,
}

#[derive(Clone, Debug)]
struct Base {
    pose: [f64; 3],
    free: Check,
    /// Position of the LiDAR.
    eye: [f64; 3],
    /// Its own view, if it shares none.
    lidar: Option<LidarView>,
    /// Stamp of the LiDAR view that the looks of the candidates go with; 0 is none.
    stamp: u64,
    /// Columns that can touch the body, and columns in reach of the LiDAR.
    body: Option<[i32; 4]>,
    around: Option<[i32; 4]>,
}

#[derive(Clone, Copy, Debug)]
struct Candidate {
    /// Columns in reach of the cameras.
    around: Option<[i32; 4]>,
    free: Check,
    look: Look,
}

/// What is known about the cameras' view: exploration cells the LiDAR does not see, and
/// inspection cells.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Look {
    Open,
    /// At most as many: those inside the frustums, with or without those the LiDAR has.
    Within(u32, u32, bool),
    /// Exactly.
    Seen(u32, u32),
}

/// A library: base poses on rings around the centroid, times the postures of the robot.
#[derive(Clone, Debug)]
pub(crate) struct Library {
    id: u64,
    kind: Kind,
    pub(crate) cells: Vec<Cell>,
    pub(crate) centroid: [f64; 3],
    bases: Vec<Base>,
    candidates: Vec<Candidate>,
    postures: usize,
    /// Index of the view offered last, and its information gain then.
    offered: Option<(u32, f64)>,
}

/// What the search for views needs besides the library.
pub(crate) struct Context<'a, S, R: ?Sized, C: ?Sized> {
    pub(crate) world: &'a World,
    pub(crate) tiles: &'a Tiles,
    pub(crate) sensors: &'a Sensors,
    pub(crate) params: &'a Params,
    pub(crate) postures: &'a [Posture<S>],
    pub(crate) robot: &'a R,
    pub(crate) costs: &'a C,
    pub(crate) from: (&'a [f64; 3], &'a S),
    pub(crate) tick: u64,
}

/// A candidate in the queue: bound (or value) of ln G, index, seconds.
#[derive(Clone, Copy, Debug)]
struct Entry {
    key: f64,
    index: u32,
    seconds: f64,
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Entry {}
impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Entry {
    /// Largest key first, ties to the lower index.
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.key
            .total_cmp(&other.key)
            .then(other.index.cmp(&self.index))
    }
}

impl Library {
    pub(crate) fn new<S>(
        cluster: &Cluster<'_>,
        world: &World,
        sensors: &Sensors,
        params: &Params,
        postures: &[Posture<S>],
    ) -> Self {
        let mut library = Self {
            id: cluster.id,
            kind: cluster.kind,
            cells: cluster.cells.to_vec(),
            centroid: cluster.centroid,
            bases: Vec::new(),
            candidates: Vec::new(),
            postures: postures.len(),
            offered: None,
        };
        library.lay_out(world, sensors, params, postures);
        library
    }

    /// Enumerates the candidates and forgets all that was known about them.
    pub(crate) fn lay_out<S>(
        &mut self,
        world: &World,
        sensors: &Sensors,
        params: &Params,
        postures: &[Posture<S>],
    ) {
        self.bases.clear();
        self.candidates.clear();
        self.offered = None;
        for pose in base_poses(params, self.centroid) {
            let (reach, [x, y, _]) = (params.body_reach, pose);
            let eye = sensors.lidar.map_or([0.0; 3], |lidar| lidar.eye(pose));
            self.bases.push(Base {
                pose,
                free: Check::Open,
                eye,
                lidar: None,
                stamp: 0,
                body: world.rectangle([x - reach, y - reach], [x + reach, y + reach]),
                around: sensors.lidar_rectangle(world, eye, params.lidar_grid),
            });
            self.candidates
                .extend(postures.iter().map(|posture| Candidate {
                    around: sensors.camera_rectangle(world, &posture.camera.on(pose)),
                    free: Check::Open,
                    look: Look::Open,
                }));
        }
    }

    pub(crate) fn kind(&self) -> Kind {
        self.kind
    }

    pub(crate) fn cluster(&self) -> Cluster<'_> {
        Cluster {
            id: self.id,
            kind: self.kind,
            cells: &self.cells,
            centroid: self.centroid,
        }
    }

    /// Replaces the cells when the cluster stays where it was.
    pub(crate) fn replace_cells(&mut self, cluster: &Cluster<'_>) {
        self.cells = cluster.cells.to_vec();
        self.kind = cluster.kind;
    }

    /// Forgets what the last update may have changed.
    pub(crate) fn invalidate(&mut self, world: &World, tick: u64) {
        let touched = |r: Option<[i32; 4]>| {
            r.is_some_and(|r| {
                let [low, high] = corners(world, r);
                world.dirty.touches(low, high)
            })
        };
        for (base, candidates) in self
            .bases
            .iter_mut()
            .zip(self.candidates.chunks_mut(self.postures))
        {
            let body = touched(base.body);
            if body {
                base.free = Check::Open;
            }
            if let Some(lidar) = &mut base.lidar
                && touched(base.around)
            {
                lidar.touch(world, tick);
            }
            for c in candidates {
                if body {
                    c.free = Check::Open;
                }
                if c.look != Look::Open && touched(c.around) {
                    c.look = Look::Open;
                }
            }
        }
    }

    /// Forgets which bodies are free.
    pub(crate) fn forget_bodies(&mut self) {
        for base in &mut self.bases {
            base.free = Check::Open;
        }
        for c in &mut self.candidates {
            c.free = Check::Open;
        }
    }

    /// The view with the largest score, or the one offered last if it still has its share of gain.
    pub(crate) fn best<S, R, C>(
        &mut self,
        context: &Context<'_, S, R, C>,
        effort: &mut Effort,
    ) -> Result<Viewpoint<S>, NoView>
    where
        S: Clone,
        R: Robot<State = S> + ?Sized,
        C: CostModel<S> + ?Sized,
    {
        let held = self.held(context, effort);
        if let Some(entry) = held {
            return Ok(self.viewpoint(context, entry));
        }
        let mut found = None;
        let most = context.params.most_looks.unwrap_or(usize::MAX);
        let reason = self.ranked(context, most, effort, |entry| {
            found = Some(entry);
            false
        });
        match found {
            Some(entry) => {
                let view = self.viewpoint(context, entry);
                self.offered = Some((entry.index, view.gain.info));
                Ok(view)
            }
            None => {
                self.offered = None;
                Err(reason)
            }
        }
    }

    /// The view offered last, if it can be taken up and has its share of gain.
    fn held<S, R, C>(
        &mut self,
        context: &Context<'_, S, R, C>,
        effort: &mut Effort,
    ) -> Option<Entry>
    where
        R: Robot<State = S> + ?Sized,
        C: CostModel<S> + ?Sized,
    {
        let (offered, info) = self.offered?;
        let least = context
            .params
            .threshold
            .max(context.params.hold_share? * info);
        let (b, index) = (offered as usize / self.postures, offered as usize);
        let state = &context.postures[index % self.postures].state;
        let seconds = context
            .costs
            .seconds(context.from, (&self.bases[b].pose, state));
        if !seconds.is_finite() || !self.body_is_free(context, index, effort) {
            return None;
        }
        self.settle(context, b);
        loop {
            if !worth(self.bound(context, index), least) {
                return None;
            }
            if self.is_exact(context, index) {
                return Some(Entry {
                    key: 0.0,
                    index: offered,
                    seconds: seconds.max(0.0),
                });
            }
            self.refine(context, index, effort);
        }
    }

    /// The views whose score is at least `share` of the best one's, best first.
    pub(crate) fn near_best<S, R, C>(
        &mut self,
        context: &Context<'_, S, R, C>,
        share: f64,
        most: usize,
        effort: &mut Effort,
    ) -> Vec<Viewpoint<S>>
    where
        S: Clone,
        R: Robot<State = S> + ?Sized,
        C: CostModel<S> + ?Sized,
    {
        let mut found: Vec<Entry> = Vec::new();
        self.ranked(context, usize::MAX, effort, |entry| {
            let good = found
                .first()
                .is_none_or(|best| entry.key >= best.key + share.ln());
            if good && found.len() < most {
                found.push(entry);
            }
            good && found.len() < most
        });
        found
            .into_iter()
            .map(|entry| self.viewpoint(context, entry))
            .collect()
    }

    /// Calls `take` with the feasible candidates whose gain reaches the threshold, by falling
    /// score, until it returns false. Returns why there was none, if there was none.
    ///
    /// After `most` new looks that reach the threshold, the best of these is taken and that is all.
    ///
    /// Each candidate waits in a queue under an upper bound of its score; the first in the queue is
    /// either exact, and then the best of the rest, or gets one step more exact and queues again.
    fn ranked<S, R, C>(
        &mut self,
        context: &Context<'_, S, R, C>,
        most: usize,
        effort: &mut Effort,
        mut take: impl FnMut(Entry) -> bool,
    ) -> NoView
    where
        R: Robot<State = S> + ?Sized,
        C: CostModel<S> + ?Sized,
    {
        let params = context.params;
        let mut dropped = Dropped::default();
        let mut waiting = Vec::with_capacity(self.candidates.len());
        for b in 0..self.bases.len() {
            self.settle(context, b);
            let base = &self.bases[b];
            if base.free == Check::No {
                continue;
            }
            for (p, posture) in context.postures.iter().enumerate() {
                let index = b * self.postures + p;
                if self.candidates[index].free == Check::No {
                    dropped.body = true;
                    continue;
                }
                let info = self.bound(context, index);
                if !worth(info, params.threshold) {
                    dropped.gain = true;
                    continue;
                }
                let seconds = context
                    .costs
                    .seconds(context.from, (&base.pose, &posture.state));
                if seconds.is_nan() || seconds == f64::INFINITY {
                    dropped.cost = true;
                    continue;
                }
                let seconds = seconds.max(0.0);
                let key = info.ln() - params.motion_decay * seconds;
                waiting.push(Entry {
                    key,
                    index: index as u32,
                    seconds,
                });
            }
        }
        let mut queue = BinaryHeap::from(waiting);
        let mut any = false;
        let (mut best, mut looks): (Option<Entry>, usize) = (None, 0);
        while let Some(entry) = queue.pop() {
            let (b, index) = (entry.index as usize / self.postures, entry.index as usize);
            if !self.body_is_free(context, index, effort) {
                dropped.body |= self.bases[b].free == Check::Yes;
                continue;
            }
            self.settle(context, b);
            let info = self.bound(context, index);
            if !worth(info, params.threshold) {
                dropped.gain = true;
                continue;
            }
            let key = info.ln() - params.motion_decay * entry.seconds;
            if key < entry.key {
                queue.push(Entry { key, ..entry });
            } else if self.is_exact(context, index) {
                any = true;
                if !take(entry) {
                    break;
                }
            } else {
                self.refine(context, index, effort);
                queue.push(entry);
                let info = self.bound(context, index);
                if self.is_exact(context, index) && worth(info, params.threshold) {
                    let key = info.ln() - params.motion_decay * entry.seconds;
                    let entry = Entry { key, ..entry };
                    best = best.max(Some(entry));
                    looks += 1;
                    if looks >= most {
                        break;
                    }
                }
            }
        }
        if let Some(best) = best.filter(|_| looks >= most) {
            any = true;
            take(best);
        }
        if any {
            NoView::TooLittleSeen
        } else {
            dropped.reason()
        }
    }

    fn body_is_free<S, R, C>(
        &mut self,
        context: &Context<'_, S, R, C>,
        index: usize,
        effort: &mut Effort,
    ) -> bool
    where
        R: Robot<State = S> + ?Sized,
        C: ?Sized,
    {
        let answer = |free| if free { Check::Yes } else { Check::No };
        let base = &mut self.bases[index / self.postures];
        if base.free == Check::Open {
            effort.base_checks += 1;
            base.free = answer(context.robot.base_is_free(base.pose));
        }
        if base.free == Check::No {
            return false;
        }
        let candidate = &mut self.candidates[index];
        if candidate.free == Check::Open {
            effort.body_checks += 1;
            let state = &context.postures[index % self.postures].state;
            candidate.free = answer(context.robot.is_free_on_base(base.pose, state));
        }
        candidate.free == Check::Yes
    }

    /// The LiDAR view of a base, shared or its own, if it is good.
    fn lidar<'a, S, R: ?Sized, C: ?Sized>(
        &'a self,
        context: &Context<'a, S, R, C>,
        b: usize,
    ) -> Option<&'a LidarView> {
        let base = &self.bases[b];
        match context.tiles.at(context.world, base.eye) {
            Some((slot, _)) => slot.get(),
            None => base
                .lidar
                .as_ref()
                .filter(|l| l.is_good(context.tick, context.params.lidar_patience)),
        }
    }

    /// Takes notice of a new LiDAR view: what the cameras add to it is open again.
    fn settle<S, R: ?Sized, C: ?Sized>(&mut self, context: &Context<'_, S, R, C>, b: usize) {
        let Some(stamp) = self.lidar(context, b).map(|l| l.stamp) else {
            return;
        };
        if stamp == self.bases[b].stamp {
            return;
        }
        self.bases[b].stamp = stamp;
        for c in &mut self.candidates[b * self.postures..(b + 1) * self.postures] {
            if !matches!(c.look, Look::Within(_, _, false)) {
                c.look = Look::Open;
            }
        }
    }

    /// What the LiDAR sees, if it is known and [settled](Self::settle).
    fn known<'a, S, R: ?Sized, C: ?Sized>(
        &'a self,
        context: &Context<'a, S, R, C>,
        b: usize,
    ) -> Option<(u32, &'a [(u32, u64)])> {
        if context.sensors.lidar.is_none() {
            return Some((0, &[]));
        }
        let view = self
            .lidar(context, b)
            .filter(|l| l.stamp == self.bases[b].stamp)?;
        Some((view.count, &view.words))
    }

    /// G_info if it is known, else an upper bound.
    fn bound<S, R: ?Sized, C: ?Sized>(&self, context: &Context<'_, S, R, C>, index: usize) -> f64 {
        let base = &self.bases[index / self.postures];
        let candidate = &self.candidates[index];
        let count = |r: Option<[i32; 4]>| {
            r.map_or([0, 0], |r| {
                let [low, high] = corners(context.world, r);
                context.world.totals.within(low, high)
            })
        };
        let lidar = match self.known(context, index / self.postures) {
            Some((count, _)) => count,
            None => count(base.around)[0],
        };
        let (extra, inspection) = match candidate.look {
            Look::Open => count(candidate.around).into(),
            Look::Within(e, i, _) | Look::Seen(e, i) => (e, i),
        };
        context.sensors.info(lidar, extra, inspection)
    }

    fn is_exact<S, R: ?Sized, C: ?Sized>(
        &self,
        context: &Context<'_, S, R, C>,
        index: usize,
    ) -> bool {
        matches!(self.candidates[index].look, Look::Seen(..))
            && self.known(context, index / self.postures).is_some()
    }

    /// Makes a bound one step more exact: cells inside the frustums, the LiDAR's view (which
    /// all postures of the base share), the cameras' view.
    fn refine<S, R: ?Sized, C: ?Sized>(
        &mut self,
        context: &Context<'_, S, R, C>,
        index: usize,
        effort: &mut Effort,
    ) {
        let (world, sensors) = (context.world, context.sensors);
        let (b, p) = (index / self.postures, index % self.postures);
        let camera = context.postures[p].camera.on(self.bases[b].pose);
        let known = self.known(context, b);
        let (has_lidar, known) = (known.is_some(), known.map_or(&[][..], |k| k.1));
        let (mut extra, mut inspection) = (0, 0);
        let add = |word, e: u64, i: u64| {
            extra += e.count_ones();
            inspection += world.worth(word, i);
        };
        let look = self.candidates[index].look;
        if look == Look::Open {
            effort.camera_bounds += 1;
            sensors.camera_covers(world, &camera, known, add);
            self.candidates[index].look = Look::Within(extra, inspection, has_lidar);
        } else if has_lidar {
            effort.camera_views += 1;
            sensors.camera_sees(world, &camera, known, add);
            self.candidates[index].look = Look::Seen(extra, inspection);
        } else {
            // Shared views and own ones never have the same stamp.
            let mut cast = |eye, own| {
                effort.lidar_views += 1;
                LidarView::cast(world, sensors, eye, 2 * context.tick + own)
            };
            match context.tiles.at(world, self.bases[b].eye) {
                Some((slot, middle)) => {
                    slot.get_or_init(|| cast(middle, 0));
                }
                None => self.bases[b].lidar = Some(cast(self.bases[b].eye, 1)),
            }
            self.settle(context, b);
        }
    }

    fn counts(&self, index: usize) -> (u32, u32) {
        match self.candidates[index].look {
            Look::Open => (0, 0),
            Look::Within(e, i, _) | Look::Seen(e, i) => (e, i),
        }
    }

    fn viewpoint<S: Clone, R: ?Sized, C: ?Sized>(
        &self,
        context: &Context<'_, S, R, C>,
        entry: Entry,
    ) -> Viewpoint<S> {
        let index = entry.index as usize;
        let (base, posture) = (
            &self.bases[index / self.postures],
            &context.postures[index % self.postures],
        );
        let camera = posture.camera.on(base.pose);
        let (count, words) = self
            .known(context, index / self.postures)
            .unwrap_or((0, &[]));
        let (extra, inspection) = self.counts(index);
        let gain: Gain = context.sensors.gain(count, extra, inspection);
        let motion = (-context.params.motion_decay * entry.seconds).exp();
        Viewpoint {
            cluster: Some(self.id),
            base: base.pose,
            posture: index % self.postures,
            state: posture.state.clone(),
            own: self.own(context, words, &camera),
            camera,
            gain,
            seconds: entry.seconds,
            motion,
            score: motion * gain.info,
        }
    }

    /// How many cells of the cluster itself are in sight.
    fn own<S, R: ?Sized, C: ?Sized>(
        &self,
        context: &Context<'_, S, R, C>,
        lidar: &[(u32, u64)],
        camera: &Pose,
    ) -> u32 {
        let world = context.world;
        let inspection = self.kind == Kind::Inspection;
        let eye = world.eye(camera.translation);
        let seen = self.cells.iter().filter(|c| {
            let by_lidar = !inspection
                && world
                    .index(**c)
                    .is_some_and(|(word, bit)| gain::mask_of(lidar, word) >> bit & 1 != 0);
            by_lidar
                || context
                    .sensors
                    .camera_sees_cell(world, camera, &eye, **c, inspection)
        });
        seen.count() as u32
    }
}

/// Base poses on the rings around a point, facing it: ring by ring, bearing by bearing.
pub(crate) fn base_poses(params: &Params, centroid: [f64; 3]) -> Vec<[f64; 3]> {
    let mut poses = Vec::new();
    for radius in params.radii() {
        for n in 0..params.bearings {
            let bearing = std::f64::consts::TAU * n as f64 / params.bearings as f64;
            let (s, c) = bearing.sin_cos();
            let (dx, dy) = (radius * c, radius * s);
            poses.push([centroid[0] + dx, centroid[1] + dy, (-dy).atan2(-dx)]);
        }
    }
    poses
}

/// At or above the threshold, and not nothing.
fn worth(info: f64, threshold: f64) -> bool {
    info > 0.0 && info >= threshold
}

/// A clipped rectangle counted from the lowest column.
#[inline]
fn corners(world: &World, [x0, y0, x1, y1]: [i32; 4]) -> [[usize; 2]; 2] {
    let [a, b, _] = world.low;
    [
        [(x0 - a) as usize, (y0 - b) as usize],
        [(x1 - a) as usize, (y1 - b) as usize],
    ]
}

/// Why candidates were dropped.
#[derive(Default)]
struct Dropped {
    body: bool,
    gain: bool,
    cost: bool,
}

impl Dropped {
    fn reason(&self) -> NoView {
        match self {
            Self { cost: true, .. } => NoView::Unreachable,
            Self { gain: true, .. } => NoView::TooLittleSeen,
            Self { body: true, .. } => NoView::NoFreeBody,
            _ => NoView::NoFreeBase,
        }
    }
}
