//! Random small worlds, and the definition of the best view by brute force.
#![allow(dead_code, missing_docs, unreachable_pub, clippy::unwrap_used)]

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use viewsample::grid::{Grid, Mast};
use viewsample::{
    Cell, Cluster, CostModel, Frustum, Kind, Lidar, Map, Params, Pose, Posture, Robot, Sampler,
    Straight, Viewpoint, postures,
};

pub const SIZE: [usize; 3] = [26, 22, 8];
pub const H: f64 = 0.3;
pub const COSTS: Straight<2> = Straight {
    base_speed: 0.8,
    joint_speed: [0.5, 0.8],
};

pub struct Dice(ChaCha8Rng);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }
    pub fn below(&mut self, n: usize) -> usize {
        (self.0.next_u64() % n as u64) as usize
    }
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }
    pub fn between(&mut self, a: f64, b: f64) -> f64 {
        a + self.unit() * (b - a)
    }
}

/// A robot with small reach: views at several heights.
pub fn params() -> Params {
    Params {
        ring_min: 0.7,
        ring_max: 2.2,
        ring_step: 0.5,
        bearings: 8,
        ahead: vec![0.1],
        lidar: Some(Lidar {
            offset: [0.15, 0.05, 0.45],
            low: -0.2,
            high: 0.9,
            range: 3.7,
        }),
        // Odd figures: a cell centre exactly on a border may fall either way.
        depth: Frustum::degrees(87.0, 58.0, 0.2917, 2.6031),
        rgb: Frustum::degrees(69.0, 42.0, 0.0513, 2.3057),
        lidar_patience: 0,
        lidar_grid: 0.0,
        ..Params::default()
    }
}

pub fn mast<M: Map>(map: &M) -> Mast<'_, M> {
    Mast {
        map,
        radius: 0.3,
        height: 0.5,
        lift: (0.4, 1.6),
    }
}

/// Walls, boxes and unseen corners in a free hall.
pub fn hall(dice: &mut Dice) -> Grid {
    let mut map = Grid::unknown(SIZE, H);
    for c in map.all() {
        let rim = (0..2).any(|a| c[a] == 0 || c[a] as usize == SIZE[a] - 1);
        map.set(c, if rim { b'#' } else { b'.' });
    }
    for n in 0..5 {
        let state = if n % 2 == 0 { b'#' } else { b'?' };
        let corner = [dice.below(SIZE[0]), dice.below(SIZE[1]), dice.below(4)];
        let extent = [1 + dice.below(8), 1 + dice.below(8), 2 + dice.below(7)];
        fill(&mut map, corner, extent, state);
    }
    map
}

pub fn fill(map: &mut Grid, corner: [usize; 3], extent: [usize; 3], state: u8) {
    for c in map.all() {
        if (0..3).all(|a| (corner[a]..corner[a] + extent[a]).contains(&(c[a] as usize))) {
            map.set(c, state);
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct OwnedCluster {
    pub id: u64,
    pub kind: Kind,
    pub cells: Vec<Cell>,
}

impl OwnedCluster {
    pub fn borrow(&self) -> Cluster<'_> {
        let mut centroid = [0.0; 3];
        for c in &self.cells {
            for a in 0..3 {
                centroid[a] += (f64::from(c[a]) + 0.5) * H / self.cells.len() as f64;
            }
        }
        Cluster {
            id: self.id,
            kind: self.kind,
            cells: &self.cells,
            centroid,
        }
    }
}

/// Frontier cells cut into clusters by a coarse raster; `inspected` says which surface is done.
pub fn clusters(map: &Grid, inspected: impl Fn(Cell) -> bool) -> Vec<OwnedCluster> {
    let mut found: Vec<OwnedCluster> = Vec::new();
    let surface = map
        .surface()
        .into_iter()
        .filter(|c| !inspected(*c))
        .map(|c| (Kind::Inspection, c));
    let exploration = map
        .exploration()
        .into_iter()
        .map(|c| (Kind::Exploration, c));
    for (kind, c) in exploration.chain(surface) {
        let id = (c[0] / 9 * 100 + c[1] / 9) as u64 * 2 + u64::from(kind == Kind::Inspection);
        match found.iter_mut().find(|k| k.id == id) {
            Some(cluster) => cluster.cells.push(c),
            None => found.push(OwnedCluster {
                id,
                kind,
                cells: vec![c],
            }),
        }
    }
    found
}

/// Exploration and inspection cells seen, by definition.
pub fn seen(
    map: &Grid,
    clusters: &[OwnedCluster],
    params: &Params,
    base: [f64; 3],
    camera: &Pose,
) -> (Vec<Cell>, Vec<Cell>) {
    let sight = |from, c| map.line_of_sight(from, c, params.unknown_allowance);
    let in_frustum =
        |f: &Frustum, c| f.covers(camera.to_camera(map.center(c))) && sight(camera.translation, c);
    let by_lidar = |c| {
        params.lidar.is_some_and(|lidar| {
            let (eye, p) = (lidar.eye(base), map.center(c));
            lidar.covers([0, 1, 2].map(|a| p[a] - eye[a])) && sight(eye, c)
        })
    };
    let cells = |kind| {
        clusters
            .iter()
            .filter(move |k| k.kind == kind)
            .flat_map(|k| &k.cells)
            .copied()
    };
    let mut e: Vec<Cell> = cells(Kind::Exploration)
        .filter(|c| by_lidar(*c) || in_frustum(&params.depth, *c))
        .collect();
    let mut i: Vec<Cell> = cells(Kind::Inspection)
        .filter(|c| in_frustum(&params.rgb, *c))
        .collect();
    e.sort_unstable();
    i.sort_unstable();
    (e, i)
}

/// One candidate of a library, by definition.
pub struct Scored {
    pub base: [f64; 3],
    pub posture: usize,
    pub info: f64,
    pub score: f64,
}

/// All feasible candidates of a cluster with their scores, in index order.
pub fn library(
    map: &Grid,
    all: &[OwnedCluster],
    cluster: &OwnedCluster,
    params: &Params,
    postures: &[Posture<[f64; 2]>],
    from: ([f64; 3], [f64; 2]),
) -> Vec<Scored> {
    let robot = mast(map);
    let centroid = cluster.borrow().centroid;
    let mut scored = Vec::new();
    for radius in params.radii() {
        for n in 0..params.bearings {
            let (s, c) = (std::f64::consts::TAU * n as f64 / params.bearings as f64).sin_cos();
            let base = [
                centroid[0] + radius * c,
                centroid[1] + radius * s,
                (-radius * s).atan2(-radius * c),
            ];
            for (p, posture) in postures.iter().enumerate() {
                if !robot.is_free(base, &posture.state) {
                    continue;
                }
                let (e, i) = seen(map, all, params, base, &posture.camera.on(base));
                let info = params.exploration_weight * e.len() as f64
                    + params.inspection_weight * i.len() as f64;
                let t = COSTS.seconds((&from.0, &from.1), (&base, &posture.state));
                let score = (-params.motion_decay * t).exp() * info;
                scored.push(Scored {
                    base,
                    posture: p,
                    info,
                    score,
                });
            }
        }
    }
    scored
}

pub fn solved(map: &Grid, params: &Params) -> Vec<Posture<[f64; 2]>> {
    postures(&mast(map), params).unwrap()
}

/// A sampler that has taken in a whole world at once.
pub fn fresh(map: &Grid, all: &[OwnedCluster], params: &Params) -> Sampler<[f64; 2]> {
    let mut sampler = Sampler::new(params, solved(map, params)).unwrap();
    let added: Vec<Cluster<'_>> = all.iter().map(OwnedCluster::borrow).collect();
    let changes = viewsample::Changes {
        added: &added,
        boxes: &[map.bounds()],
        ..Default::default()
    };
    sampler.update(map, &changes).unwrap();
    sampler
}

pub fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * (1.0 + a.abs().max(b.abs()))
}

pub fn same_view(a: &Viewpoint<[f64; 2]>, b: &Viewpoint<[f64; 2]>) -> bool {
    a.cluster == b.cluster
        && a.base == b.base
        && a.posture == b.posture
        && a.gain == b.gain
        && a.own == b.own
}
