//! The libraries of all clusters, kept up to date.

use std::collections::BTreeMap;

use crate::gain::Sensors;
use crate::library::{Context, Library};
use crate::map::{Cell, Map};
use crate::params::Params;
use crate::posture::Posture;
use crate::robot::{CostModel, Robot};
use crate::tiles::Tiles;
use crate::world::World;
use crate::{Candidates, Changes, Effort, Error, Gain, Kind, Pose, Seen, Viewpoint};

/// The viewpoint state libraries of all clusters (HEATS IV-B), kept up to date.
///
/// [`update`](Self::update) takes in what changed and does no ray casting; [`candidates`](Self::candidates)
/// evaluates as little as it needs to name the best view of each library, and keeps what it evaluated.
#[derive(Clone, Debug)]
pub struct Sampler<S> {
    params: Params,
    relaxed: Params,
    sensors: Sensors,
    postures: Vec<Posture<S>>,
    world: World,
    tiles: Tiles,
    libraries: BTreeMap<u64, Library>,
    /// Libraries with the limits of the last try, made when asked for.
    last_tries: BTreeMap<u64, Library>,
    tick: u64,
}

impl<S: Clone> Sampler<S> {
    /// A sampler without clusters. `postures` are those of [`postures`](crate::postures()).
    ///
    /// # Errors
    /// If a parameter is bad or there is no posture.
    pub fn new(params: &Params, postures: Vec<Posture<S>>) -> Result<Self, Error> {
        params.validate()?;
        if postures.is_empty() {
            return Err(Error::NoPosture(params.views.len()));
        }
        Ok(Self {
            params: params.clone(),
            relaxed: params.relaxed(),
            sensors: Sensors::new(params),
            postures,
            world: World::weighing(params.level_weight),
            tiles: Tiles::default(),
            libraries: BTreeMap::new(),
            last_tries: BTreeMap::new(),
            tick: 0,
        })
    }

    /// The arm states of the libraries.
    pub fn postures(&self) -> &[Posture<S>] {
        &self.postures
    }

    /// The settings.
    pub fn params(&self) -> &Params {
        &self.params
    }

    pub(crate) fn world(&self) -> &World {
        &self.world
    }

    pub(crate) fn sensors(&self) -> &Sensors {
        &self.sensors
    }

    pub(crate) fn cluster(&self, id: u64) -> Option<crate::Cluster<'_>> {
        let library = self.libraries.get(&id)?;
        Some(library.cluster()).filter(|c| !c.cells.is_empty())
    }

    pub(crate) fn gain_of(&self, lidar: u32, extra: u32, inspection: u32) -> Gain {
        self.sensors.gain(lidar, extra, inspection)
    }

    /// Number of clusters held.
    pub fn len(&self) -> usize {
        self.libraries.len()
    }

    /// True if there is no cluster.
    pub fn is_empty(&self) -> bool {
        self.libraries.is_empty()
    }

    /// Takes in what changed since the last update. Removals come before additions.
    ///
    /// # Errors
    /// If the map's cell size or a centroid is bad, or the cells span too much; nothing is changed then.
    pub fn update<M: Map + ?Sized>(&mut self, map: &M, changes: &Changes<'_>) -> Result<(), Error> {
        let h = map.cell_size();
        if !(h > 0.0 && h.is_finite()) {
            return Err(Error::CellSize(h));
        }
        for c in changes.added {
            if c.centroid.iter().any(|v| !v.is_finite()) {
                return Err(Error::Centroid {
                    id: c.id,
                    centroid: c.centroid,
                });
            }
        }
        let mut grown = false;
        if let Some((low, high)) = hull(changes) {
            grown = self.world.grow(map, low, high)?;
        }
        self.tick += 1;
        let widened = self
            .world
            .widen(changes.added.iter().flat_map(|c| c.cells).copied());
        if !grown {
            self.world.dirty.clear();
            for (low, high) in changes.boxes {
                self.world.read(map, *low, *high);
            }
        }
        let gone = changes
            .removed
            .iter()
            .copied()
            .chain(changes.added.iter().map(|c| c.id));
        for id in gone {
            if let Some(library) = self.libraries.get(&id) {
                for c in &library.cells {
                    self.world
                        .set_frontier(*c, library.kind() == Kind::Inspection, false);
                }
            }
        }
        for c in changes.added {
            for cell in c.cells {
                self.world
                    .set_frontier(*cell, c.kind == Kind::Inspection, true);
            }
        }
        if self.params.max_incidence.is_some() {
            if grown {
                let (low, high) = (self.world.low, self.world.high());
                self.world.read_faces(map, low, high);
            }
            for (low, high) in changes.boxes {
                self.world.read_faces(map, *low, *high);
            }
            for c in changes.added.iter().filter(|c| c.kind == Kind::Inspection) {
                if let Some((low, high)) = cell_box(c.cells) {
                    self.world.read_faces(map, low, high);
                }
            }
        }
        self.world.close_update();
        for id in changes.removed {
            self.libraries.remove(id);
            self.last_tries.remove(id);
        }
        if grown {
            self.tiles = Tiles::over(&self.world, &self.sensors, self.params.lidar_grid);
        } else {
            self.tiles.invalidate(
                &self.world,
                &self.sensors,
                self.tick,
                self.params.lidar_patience,
            );
        }
        let (world, sensors, postures, tick) =
            (&self.world, &self.sensors, &self.postures, self.tick);
        for (libraries, params) in [
            (&mut self.libraries, &self.params),
            (&mut self.last_tries, &self.relaxed),
        ] {
            for library in libraries.values_mut() {
                if grown || widened {
                    library.lay_out(world, sensors, params, postures);
                } else if !world.dirty.is_empty() {
                    library.invalidate(world, tick);
                }
            }
        }
        for c in changes.added {
            match self.libraries.get_mut(&c.id) {
                Some(library) if library.centroid == c.centroid => {
                    library.replace_cells(c);
                    if let Some(library) = self.last_tries.get_mut(&c.id) {
                        library.replace_cells(c);
                    }
                }
                _ => {
                    self.last_tries.remove(&c.id);
                    self.libraries.insert(
                        c.id,
                        Library::new(c, world, sensors, &self.params, postures),
                    );
                }
            }
        }
        Ok(())
    }

    /// Forgets which bodies are free: for when the robot's own notion of the world changed in a
    /// way the boxes of [`update`](Self::update) did not say.
    pub fn recheck_bodies(&mut self) {
        for library in self
            .libraries
            .values_mut()
            .chain(self.last_tries.values_mut())
        {
            library.forget_bodies();
        }
    }

    /// The candidate set: from each library the view of largest score (eq. 1) among those
    /// whose information gain reaches [`Params::threshold`]. `base` and `state` say where the
    /// robot is.
    ///
    /// # Errors
    /// If the base pose is not finite.
    pub fn candidates<R, C>(
        &mut self,
        robot: &R,
        costs: &C,
        base: [f64; 3],
        state: &S,
    ) -> Result<Candidates<S>, Error>
    where
        R: Robot<State = S> + ?Sized,
        C: CostModel<S> + ?Sized,
    {
        check_pose(base)?;
        let mut set = Candidates {
            views: Vec::new(),
            without: Vec::new(),
            effort: Effort::default(),
        };
        let context = Context {
            world: &self.world,
            tiles: &self.tiles,
            sensors: &self.sensors,
            params: &self.params,
            postures: &self.postures,
            robot,
            costs,
            from: (&base, state),
            tick: self.tick,
        };
        for (id, library) in &mut self.libraries {
            match library.best(&context, &mut set.effort) {
                Ok(view) => set.views.push(view),
                Err(reason) => set.without.push((*id, reason)),
            }
        }
        Ok(set)
    }

    /// The last try for the clusters named: rings wider by [`Relaxed::widen`](crate::Relaxed::widen),
    /// more bearings, and the threshold of one voxel. Unknown ids are passed over.
    ///
    /// # Errors
    /// If the base pose is not finite.
    pub fn retry<R, C>(
        &mut self,
        clusters: &[u64],
        robot: &R,
        costs: &C,
        base: [f64; 3],
        state: &S,
    ) -> Result<Candidates<S>, Error>
    where
        R: Robot<State = S> + ?Sized,
        C: CostModel<S> + ?Sized,
    {
        check_pose(base)?;
        let mut set = Candidates {
            views: Vec::new(),
            without: Vec::new(),
            effort: Effort::default(),
        };
        let context = Context {
            world: &self.world,
            tiles: &self.tiles,
            sensors: &self.sensors,
            params: &self.relaxed,
            postures: &self.postures,
            robot,
            costs,
            from: (&base, state),
            tick: self.tick,
        };
        let mut ids = clusters.to_vec();
        ids.sort_unstable();
        ids.dedup();
        for id in ids {
            let Some(library) = self.libraries.get(&id) else {
                continue;
            };
            let relaxed = self.last_tries.entry(id).or_insert_with(|| {
                Library::new(
                    &library.cluster(),
                    &self.world,
                    &self.sensors,
                    &self.relaxed,
                    &self.postures,
                )
            });
            match relaxed.best(&context, &mut set.effort) {
                Ok(view) => set.views.push(view),
                Err(reason) => set.without.push((id, reason)),
            }
        }
        Ok(set)
    }

    /// Views of one library whose score is at least `share` (0 to 1) of its best, best first, at
    /// most `most`; empty for an unknown cluster.
    ///
    /// # Errors
    /// If the base pose is not finite or `share` is not in [0, 1].
    pub fn near_best<R, C>(
        &mut self,
        cluster: u64,
        share: f64,
        most: usize,
        robot: &R,
        costs: &C,
        base: [f64; 3],
        state: &S,
    ) -> Result<Vec<Viewpoint<S>>, Error>
    where
        R: Robot<State = S> + ?Sized,
        C: CostModel<S> + ?Sized,
    {
        check_pose(base)?;
        if !(0.0..=1.0).contains(&share) {
            return Err(Error::Param {
                field: "share",
                value: share,
                range: "in [0, 1]",
            });
        }
        let context = Context {
            world: &self.world,
            tiles: &self.tiles,
            sensors: &self.sensors,
            params: &self.params,
            postures: &self.postures,
            robot,
            costs,
            from: (&base, state),
            tick: self.tick,
        };
        let Some(library) = self.libraries.get_mut(&cluster) else {
            return Ok(Vec::new());
        };
        Ok(library.near_best(&context, share, most, &mut Effort::default()))
    }

    /// What `ask` returns while [`Params::target`] (m) and [`Params::max_incidence`] (rad) are others: what might be seen of
    /// smaller targets, or of surfaces that lie a little behind the face of their voxel.
    ///
    /// # Errors
    /// [`Error::Param`] if a limit is out of the range that [`Params`] gives.
    pub fn with_limits<T>(
        &mut self,
        target: Option<f64>,
        max_incidence: Option<f64>,
        ask: impl FnOnce(&Self) -> T,
    ) -> Result<T, Error> {
        Params {
            target,
            max_incidence,
            ..self.params.clone()
        }
        .validate()?;
        let usual = self.sensors.limited(target, max_incidence);
        let usual = std::mem::replace(&mut self.sensors, usual);
        let answer = ask(self);
        self.sensors = usual;
        Ok(answer)
    }

    /// What a view would see now, exactly: the base at x, y, yaw for the LiDAR, the camera at
    /// `world_from_camera`. Says whether a target is still worth the way.
    ///
    /// # Errors
    /// If a pose is not finite.
    pub fn gain_at(&self, base: [f64; 3], camera: &Pose) -> Result<Gain, Error> {
        let (mut lidar, mut extra, mut inspection) = (0, 0, 0);
        self.look(base, camera, |word, [l, e, i]| {
            lidar += l.count_ones();
            extra += e.count_ones();
            inspection += self.world.worth(word, i);
        })?;
        Ok(self.sensors.gain(lidar, extra, inspection))
    }

    /// The voxels a view would see now; see [`gain_at`](Self::gain_at).
    ///
    /// # Errors
    /// If a pose is not finite.
    pub fn seen_from(&self, base: [f64; 3], camera: &Pose) -> Result<Seen, Error> {
        let mut words: BTreeMap<usize, (u64, u64)> = BTreeMap::new();
        self.look(base, camera, |word, [l, e, i]| {
            let entry = words.entry(word).or_default();
            *entry = (entry.0 | l | e, entry.1 | i);
        })?;
        let mut seen = Seen::default();
        for (word, (e, i)) in words {
            let low = self.world.cell(word);
            for (cells, mask) in [(&mut seen.exploration, e), (&mut seen.inspection, i)] {
                cells.extend(
                    (0..64)
                        .filter(|n| mask >> n & 1 != 0)
                        .map(|n| [low[0], low[1], low[2] + n]),
                );
            }
        }
        Ok(seen)
    }

    /// Words of a view: exploration cells of the LiDAR, those only a camera sees, inspection cells.
    pub(crate) fn look(
        &self,
        base: [f64; 3],
        camera: &Pose,
        mut visit: impl FnMut(usize, [u64; 3]),
    ) -> Result<(), Error> {
        check_pose(base)?;
        if !camera.is_finite() {
            return Err(Error::Pose(camera.translation));
        }
        if self.world.words == 0 {
            return Ok(());
        }
        let eye = self.sensors.lidar.map(|lidar| lidar.eye(base));
        let lidar = eye.map_or_else(Vec::new, |eye| self.sensors.lidar_sees(&self.world, eye));
        for (word, mask) in &lidar {
            visit(*word as usize, [*mask, 0, 0]);
        }
        self.sensors
            .camera_sees(&self.world, camera, &lidar, |word, e, i| {
                visit(word, [0, e, i]);
            });
        Ok(())
    }

    /// Words of the cameras' view alone: exploration and inspection cells.
    pub(crate) fn look_without_lidar(
        &self,
        base: [f64; 3],
        camera: &Pose,
        visit: impl FnMut(usize, u64, u64),
    ) -> Result<(), Error> {
        check_pose(base)?;
        if !camera.is_finite() {
            return Err(Error::Pose(camera.translation));
        }
        if self.world.words > 0 {
            self.sensors.camera_sees(&self.world, camera, &[], visit);
        }
        Ok(())
    }

    pub(crate) fn has_lidar(&self) -> bool {
        self.sensors.lidar.is_some()
    }

    /// How many of the given voxels are still frontier of their kind: what is left of a target.
    pub fn remaining(&self, kind: Kind, cells: &[Cell]) -> usize {
        let layer = match kind {
            Kind::Exploration => &self.world.exploration,
            Kind::Inspection => &self.world.inspection,
        };
        let held = |c: &&Cell| {
            self.world
                .index(**c)
                .is_some_and(|(word, bit)| layer[word] >> bit & 1 != 0)
        };
        cells.iter().filter(held).count()
    }
}

#[cfg(feature = "rayon")]
impl<S: Clone + Send + Sync> Sampler<S> {
    /// [`candidates`](Self::candidates) with the libraries shared among threads: the same result.
    ///
    /// # Errors
    /// If the base pose is not finite.
    pub fn candidates_parallel<R, C>(
        &mut self,
        robot: &R,
        costs: &C,
        base: [f64; 3],
        state: &S,
    ) -> Result<Candidates<S>, Error>
    where
        R: Robot<State = S> + Sync + ?Sized,
        C: CostModel<S> + Sync + ?Sized,
    {
        use rayon::prelude::*;
        check_pose(base)?;
        let context = Context {
            world: &self.world,
            tiles: &self.tiles,
            sensors: &self.sensors,
            params: &self.params,
            postures: &self.postures,
            robot,
            costs,
            from: (&base, state),
            tick: self.tick,
        };
        let mut libraries: Vec<(u64, &mut Library)> =
            self.libraries.iter_mut().map(|(id, l)| (*id, l)).collect();
        let best = |(id, library): &mut (u64, &mut Library)| {
            let mut effort = Effort::default();
            let best = library.best(&context, &mut effort);
            (*id, best, effort)
        };
        let found: Vec<_> = libraries.par_iter_mut().map(best).collect();
        let mut set = Candidates {
            views: Vec::new(),
            without: Vec::new(),
            effort: Effort::default(),
        };
        for (id, best, effort) in found {
            set.effort += effort;
            match best {
                Ok(view) => set.views.push(view),
                Err(reason) => set.without.push((id, reason)),
            }
        }
        Ok(set)
    }
}

pub(crate) fn check_pose(base: [f64; 3]) -> Result<(), Error> {
    if base.iter().all(|v| v.is_finite()) {
        Ok(())
    } else {
        Err(Error::Pose(base))
    }
}

/// Half-open box around all cells of the changes; boxes without volume count for nothing.
fn hull(changes: &Changes<'_>) -> Option<(Cell, Cell)> {
    let mut hull: Option<(Cell, Cell)> = None;
    let mut add = |low: Cell, high: Cell| {
        hull = Some(match hull {
            None => (low, high),
            Some((a, b)) => (
                [0, 1, 2].map(|n| a[n].min(low[n])),
                [0, 1, 2].map(|n| b[n].max(high[n])),
            ),
        });
    };
    for (low, high) in changes.boxes {
        if (0..3).all(|a| low[a] < high[a]) {
            add(*low, *high);
        }
    }
    for c in changes.added.iter().flat_map(|c| c.cells) {
        add(*c, c.map(|v| v.saturating_add(1)));
    }
    hull
}

/// Half-open box around cells.
fn cell_box(cells: &[Cell]) -> Option<(Cell, Cell)> {
    let first = *cells.first()?;
    Some(
        cells
            .iter()
            .fold((first, first.map(|v| v + 1)), |(low, high), c| {
                (
                    [0, 1, 2].map(|a| low[a].min(c[a])),
                    [0, 1, 2].map(|a| high[a].max(c[a] + 1)),
                )
            }),
    )
}
