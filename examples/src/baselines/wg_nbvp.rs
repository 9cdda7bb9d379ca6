//! WG-NBVP: a tree of camera poses around the arm with a weighted gain each; the arm takes up what it reaches of the best branch, and
//! the base moves only when there is nothing.

use super::gain::{Rays, best_window};
use super::planner::{Next, Planner, Sight};
use super::settings::WgNbvpSettings;
use super::stand::in_reach;
use super::view::{Room, View, apart};
use crate::heats::Failures;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};

/// Columns of azimuth in which surface is counted.
const COLUMNS: usize = 36;

/// A camera pose of the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    pub(super) view: View,
    pub(super) parent: Option<usize>,
    /// Unknown volume, m3.
    volume: f64,
    /// Voxels of surface to inspect.
    measured: f64,
    pub(super) gain: f64,
}

/// The planner's state from call to call.
pub(super) struct WgNbvp {
    settings: WgNbvpSettings,
    rays: Rays,
    half_field: f64,
    cache: Vec<Node>,
    /// Gain of the worst view kept: what a view must exceed.
    least: f64,
    /// Running maxima that normalise volume and measurement.
    most: (f64, f64),
    visited: BTreeSet<[i64; 2]>,
    /// Views of the last answer that the base moves to.
    moves: Vec<View>,
    failures: Failures,
    exclusion: f64,
    rng: ChaCha8Rng,
    lookups: usize,
    samples: usize,
    distances: usize,
}

impl WgNbvp {
    /// A planner for a camera of a field of view (rad), with an empty cache.
    pub(super) fn new(
        settings: &WgNbvpSettings,
        field: [f64; 2],
        exclusion: f64,
        seed: u64,
    ) -> Self {
        let rays = Rays::new(&settings.rays.params(field));
        Self {
            most: (rays.full_view(), settings.most_measured),
            rays,
            half_field: 0.5 * field[0],
            settings: settings.clone(),
            cache: Vec::new(),
            least: -1000.0,
            visited: BTreeSet::new(),
            moves: Vec::new(),
            failures: Failures::default(),
            exclusion,
            rng: ChaCha8Rng::seed_from_u64(seed ^ 0x3b4),
            lookups: 0,
            samples: 0,
            distances: 0,
        }
    }

    fn uniform(&mut self) -> f64 {
        (self.rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn cell(&self, place: &[f64; 3]) -> [i64; 2] {
        [0, 1].map(|a| (place[a] / self.settings.visited_cell).floor() as i64)
    }

    /// Shares of free space, measurement and visited places in a gain, each 0 to 1: the normalised values times weights that
    /// do not depend on the node.
    pub(super) fn terms(&self, node: &Node) -> [f64; 3] {
        let visited = self.visited.contains(&self.cell(&node.view.place));
        [
            node.volume / self.most.0,
            node.measured / self.most.1,
            f64::from(u8::from(visited)),
        ]
    }

    fn weigh(&self, node: &mut Node) {
        let (free, measured, visited) = self.settings.weights();
        let [f, m, v] = self.terms(node);
        node.gain = free * f + measured * m - visited * v;
    }

    /// Gain and view of a place; `surface` is what is left to inspect around it.
    fn node(
        &mut self,
        sight: &Sight<'_>,
        surface: &[[f64; 3]],
        place: [f64; 3],
        parent: Option<usize>,
    ) -> Node {
        let map = &sight.whole.mapper.map;
        let own = |p: [f64; 3]| sight.is_own(p);
        let best = self.rays.best(map, place, own, &mut self.lookups);
        let mut view = View {
            place,
            yaw: best.yaw,
            pitch: best.pitch,
        };
        let mut measured = 0.0;
        if self.settings.weights().1 > 0.0 {
            let mut columns = [0.0; COLUMNS];
            self.distances += surface.len();
            for p in surface {
                if apart(p, &place) <= self.settings.measured_radius {
                    let azimuth = (p[1] - place[1]).atan2(p[0] - place[0]);
                    let column = (azimuth + PI) / TAU * COLUMNS as f64;
                    columns[(column as usize).min(COLUMNS - 1)] += 1.0;
                    measured += 1.0;
                }
            }
            // Towards where the measurement rises most: there the surface is.
            if measured > 0.0 {
                view.yaw = best_window(&columns, self.half_field).0;
            }
        }
        let mut node = Node {
            view,
            parent,
            volume: best.volume,
            measured,
            gain: 0.0,
        };
        self.most.0 = self.most.0.max(node.volume);
        self.most.1 = self.most.1.max(node.measured);
        self.weigh(&mut node);
        node
    }

    /// Voxels with a face to inspect, m.
    pub(super) fn surface(&self, sight: &Sight<'_>) -> Vec<[f64; 3]> {
        if self.settings.weights().1 <= 0.0 {
            return Vec::new();
        }
        let map = &sight.whole.mapper.map;
        let bounds = map.bounds();
        let mut found = Vec::new();
        for z in bounds.low[2]..bounds.high[2] {
            for y in bounds.low[1]..bounds.high[1] {
                for x in bounds.low[0]..bounds.high[0] {
                    let cell = [x, y, z];
                    if map.is_occupied(cell) && map.open_faces(cell) != 0 {
                        let p = map.center(cell);
                        if (sight.band.0..=sight.band.1).contains(&p[2]) {
                            found.push(p);
                        }
                    }
                }
            }
        }
        found
    }

    /// A sample of the ball around the point below the arm, at a height the arm reaches.
    fn sample(&mut self, sight: &Sight<'_>) -> [f64; 3] {
        let (low, high) = self.settings.heights;
        let most = self.settings.sampling_volume;
        for _ in 0..64 {
            let r = (most * self.uniform()).cbrt();
            let (up, turn) = (2.0 * self.uniform() - 1.0, TAU * self.uniform());
            let flat = (1.0 - up * up).max(0.0).sqrt();
            let z = r * up;
            if (low..=high).contains(&z) {
                return [
                    sight.turret[0] + r * flat * turn.cos(),
                    sight.turret[1] + r * flat * turn.sin(),
                    z,
                ];
            }
        }
        // A ball that does not reach the band: straight above the arm.
        [sight.turret[0], sight.turret[1], low]
    }

    /// Weighs the cache anew, with gains computed anew where `surface` is told, and keeps the best.
    fn prune(&mut self, sight: &Sight<'_>, surface: Option<&[[f64; 3]]>) {
        let mut cache = std::mem::take(&mut self.cache);
        for node in &mut cache {
            match surface {
                Some(surface) => *node = self.node(sight, surface, node.view.place, None),
                None => self.weigh(node),
            }
        }
        cache.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        cache.truncate(self.settings.cached);
        if let Some(worst) = cache.last() {
            self.least = worst.gain;
        }
        self.cache = cache;
    }

    /// The tree around the arm. The root is where the camera is.
    pub(super) fn grow(
        &mut self,
        sight: &Sight<'_>,
        surface: &[[f64; 3]],
        frontiers: &[Node],
    ) -> Vec<Node> {
        let s = self.settings.clone();
        let room = Room {
            whole: &sight.whole,
            radius: s.radius,
            heights: s.heights,
            ground: None,
        };
        let mut tree = vec![self.node(sight, surface, sight.camera.place, None)];
        let worst = frontiers.last().map_or(self.least, |f| f.gain);
        let (mut grown, mut beyond) = (0, 0);
        while grown < s.nodes {
            // Growing towards a frontier, while nothing in the tree is as good, is not counted.
            let best = tree.iter().skip(1).map(|n| n.gain).fold(f64::MIN, f64::max);
            let reaches = || {
                frontiers.iter().any(|f| {
                    tree.iter()
                        .any(|n| apart(&n.view.place, &f.view.place) <= 0.5)
                })
            };
            if beyond < s.frontier_tries && best < worst && !reaches() {
                beyond += 1;
            } else {
                grown += 1;
            }
            let mut added = false;
            for _ in 0..s.tries {
                self.samples += 1;
                let sample = self.sample(sight);
                let d = |i: usize| apart(&tree[i].view.place, &sample);
                let parent = (0..tree.len()).min_by(|&a, &b| d(a).total_cmp(&d(b)));
                let parent = parent.unwrap_or(0);
                let (from, length) = (tree[parent].view.place, d(parent));
                let t = (s.step / length.max(1e-9)).min(1.0);
                let place = [0, 1, 2].map(|a| from[a] + t * (sample[a] - from[a]));
                let crowded = tree
                    .iter()
                    .any(|n| apart(&n.view.place, &place) < s.spacing - 1e-9);
                if crowded
                    || sight.is_own(place)
                    || !room.holds(place)
                    || !room.connects(from, place)
                {
                    continue;
                }
                let node = self.node(sight, surface, place, Some(parent));
                self.cache.push(Node {
                    parent: None,
                    ..node
                });
                tree.push(node);
                added = true;
                break;
            }
            // The ball is full: further samples add nothing either.
            if !added && tree.len() > 1 {
                break;
            }
            if !added {
                grown += s.nodes / 8;
            }
        }
        tree
    }

    /// Cached views beyond the arm's reach, the nearest by the ground first.
    fn frontiers_to_move_to(&self, sight: &Sight<'_>, frontiers: &[Node]) -> Vec<View> {
        let here = [sight.base[0], sight.base[1]];
        let mut goals: Vec<(f64, View)> = frontiers
            .iter()
            .filter(|f| {
                let p = &f.view.place;
                (p[0] - sight.turret[0]).hypot(p[1] - sight.turret[1]) > self.settings.reach
                    && !self.failures.excludes([p[0], p[1]], sight.now)
            })
            .map(|f| {
                let place = [f.view.place[0], f.view.place[1]];
                (sight.ways.meters(here, place), f.view)
            })
            .collect();
        goals.sort_by(|a, b| a.0.total_cmp(&b.0));
        goals.into_iter().map(|g| g.1).collect()
    }
}

impl Planner for WgNbvp {
    fn next(&mut self, sight: &Sight<'_>) -> Next {
        let s = self.settings.clone();
        let surface = self.surface(sight);
        self.prune(sight, Some(&surface));
        let mut frontiers: Vec<Node> = self.cache.iter().take(s.frontiers).copied().collect();
        let reach = s.sampling_volume.cbrt() + s.measured_radius;
        let near: Vec<[f64; 3]> = surface
            .into_iter()
            .filter(|p| (p[0] - sight.turret[0]).hypot(p[1] - sight.turret[1]) <= reach)
            .collect();
        let tree = self.grow(sight, &near, &frontiers);
        let best = (1..tree.len()).max_by(|&a, &b| tree[a].gain.total_cmp(&tree[b].gain));
        let mut sweep: Vec<View> = Vec::new();
        let mut node = best.filter(|&b| tree[b].gain > self.least);
        while let Some(i) = node {
            let view = tree[i].view;
            let from = (sight.base, sight.joints);
            if tree[i].parent.is_some()
                && tree[i].gain > self.least
                && in_reach(&sight.whole, sight.params, from, &view).is_some()
            {
                sweep.push(view);
            }
            node = tree[i].parent;
        }
        sweep.reverse();
        if s.hull {
            sweep = corners(&sweep);
        }
        self.moves.clear();
        if !sweep.is_empty() {
            self.prune(sight, None);
            return Next::Sweep(sweep);
        }
        if frontiers.is_empty() {
            // The first call: what the tree found is all there is.
            self.prune(sight, None);
            frontiers = self.cache.iter().take(s.frontiers).copied().collect();
        }
        self.moves = self.frontiers_to_move_to(sight, &frontiers);
        // Where the ten best lead nowhere, the others may.
        if self.moves.is_empty() {
            self.prune(sight, None);
            let all = self.cache.clone();
            self.moves = self.frontiers_to_move_to(sight, &all);
        }
        self.prune(sight, None);
        if self.moves.is_empty() {
            return Next::Done;
        }
        Next::First(self.moves.clone())
    }

    fn set_out(&mut self, view: &View) {
        if self.moves.contains(view) {
            self.visited.insert(self.cell(&view.place));
            self.cache.retain(|n| n.view.place != view.place);
        }
    }

    fn reached(&mut self, view: &View) {
        self.visited.insert(self.cell(&view.place));
        self.cache.retain(|n| n.view.place != view.place);
    }

    fn failed(&mut self, view: &View, now: f64) {
        let place = [view.place[0], view.place[1]];
        self.failures.strike(place, now, self.exclusion);
        self.cache.retain(|n| n.view.place != view.place);
    }

    fn counted(&mut self) -> f64 {
        let lookups = std::mem::take(&mut self.lookups);
        let samples = std::mem::take(&mut self.samples);
        let distances = std::mem::take(&mut self.distances);
        8e-9 * lookups as f64 + 2e-6 * samples as f64 + 2e-9 * distances as f64
    }
}

/// The views at the corners of the convex hull of all, from above, in their order; the last where there are no corners.
pub(super) fn corners(views: &[View]) -> Vec<View> {
    if views.len() < 3 {
        return views.to_vec();
    }
    let turns = |a: usize, b: usize, c: usize| {
        let [p, q, r] = [a, b, c].map(|i| views[i].place);
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    let mut sorted: Vec<usize> = (0..views.len()).collect();
    let key = |i: usize| views[i].place;
    sorted.sort_by(|&a, &b| {
        let (p, q) = (key(a), key(b));
        p[0].total_cmp(&q[0])
            .then(p[1].total_cmp(&q[1]))
            .then(a.cmp(&b))
    });
    // Andrew's monotone chain, each half.
    let mut kept = BTreeSet::new();
    for backwards in [false, true] {
        let mut chain: Vec<usize> = Vec::new();
        for k in 0..sorted.len() {
            let i = sorted[if backwards { sorted.len() - 1 - k } else { k }];
            while chain.len() >= 2
                && turns(chain[chain.len() - 2], chain[chain.len() - 1], i) <= 1e-12
            {
                chain.pop();
            }
            chain.push(i);
        }
        kept.extend(chain);
    }
    (0..views.len())
        .filter(|i| kept.contains(i))
        .map(|i| views[i])
        .collect()
}
