//! AEP: a tree near the robot whose branches promise unknown volume, and the cheapest place that still promises much when the tree
//! does not.

use super::gain::Rays;
use super::gp::predict;
use super::planner::{Next, Planner, Sight};
use super::settings::AepSettings;
use super::view::{Room, View, apart};
use crate::heats::Failures;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Goals of the global planner that are offered at a time.
const GOALS: usize = 12;
/// Moves in a row that uncover next to nothing before the tree counts as exhausted.
const IDLE: usize = 4;
/// Visits after which a place whose gain does not fall is no goal any more.
const VISITS: usize = 2;

/// A place whose gain was computed.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cached {
    /// The best view from there.
    pub(super) view: View,
    /// Its gain, m3.
    pub(super) gain: f64,
    /// Simulated time at which it was computed, s.
    pub(super) at: f64,
    visits: usize,
}

/// A node of the tree.
#[derive(Clone, Debug)]
struct Node {
    view: View,
    gain: f64,
    parent: Option<usize>,
    /// Length of the edge from its parent and of the branch from the root, m.
    edge: f64,
    way: f64,
    score: f64,
}

/// An edge that was offered, and the branch that goes on from it.
#[derive(Clone, Debug)]
struct Offer {
    view: View,
    rest: Vec<[f64; 3]>,
}

/// The planner's state from call to call.
pub(super) struct Aep {
    settings: AepSettings,
    rays: Rays,
    /// Published volumes times this are ours.
    scale: f64,
    cache: Vec<Cached>,
    /// What is left of the best branch, from the robot's node on.
    branch: Vec<[f64; 3]>,
    offers: Vec<Offer>,
    /// Part of the published thresholds that applies now.
    share: f64,
    renewed: f64,
    failures: Failures,
    exclusion: f64,
    /// Known volume when edges were last offered, and moves since that uncovered next to nothing.
    known: f64,
    idle: usize,
    rng: ChaCha8Rng,
    lookups: usize,
    samples: usize,
    /// Sum of the cubes of the sizes of regressions.
    regression: usize,
}

impl Aep {
    /// A planner for a camera of a field of view (rad), with an empty cache.
    pub(super) fn new(settings: &AepSettings, field: [f64; 2], exclusion: f64, seed: u64) -> Self {
        let rays = Rays::new(&settings.rays.params(field));
        Self {
            scale: settings.scale(rays.full_view()),
            rays,
            settings: settings.clone(),
            cache: Vec::new(),
            branch: Vec::new(),
            offers: Vec::new(),
            share: 1.0,
            renewed: f64::NEG_INFINITY,
            failures: Failures::default(),
            exclusion,
            known: 0.0,
            idle: 0,
            rng: ChaCha8Rng::seed_from_u64(seed ^ 0xae9),
            lookups: 0,
            samples: 0,
            regression: 0,
        }
    }

    fn uniform(&mut self) -> f64 {
        (self.rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The best view from a place, by rays.
    fn integrate(&mut self, sight: &Sight<'_>, place: [f64; 3]) -> (View, f64) {
        let map = &sight.whole.mapper.map;
        let best = self.rays.best(map, place, |_| false, &mut self.lookups);
        let view = View {
            place,
            yaw: best.yaw,
            pitch: best.pitch,
        };
        (view, best.volume)
    }

    /// Gain and view of a place: predicted where the cache says enough, else integrated and cached.
    fn gain(&mut self, sight: &Sight<'_>, place: [f64; 3]) -> (View, f64) {
        let reach = self.settings.neighbourhood;
        let near: Vec<usize> = (0..self.cache.len())
            .filter(|&i| {
                let p = &self.cache[i].view.place;
                (0..3).all(|a| (p[a] - place[a]).abs() <= reach)
            })
            .collect();
        let places: Vec<[f64; 3]> = near.iter().map(|&i| self.cache[i].view.place).collect();
        let gains: Vec<f64> = near.iter().map(|&i| self.cache[i].gain).collect();
        self.regression += near.len().pow(3);
        let posterior = predict(&self.settings.kernel(), &places, &gains, place);
        let nearest = near.iter().min_by(|a, b| {
            let d = |i: usize| apart(&self.cache[i].view.place, &place);
            d(**a).total_cmp(&d(**b))
        });
        if let Some(&i) = nearest
            && posterior.variance < self.settings.variance
        {
            let view = View {
                place,
                ..self.cache[i].view
            };
            return (view, posterior.mean.max(0.0));
        }
        let (view, gain) = self.integrate(sight, place);
        self.cache.push(Cached {
            view,
            gain,
            at: sight.now,
            visits: 0,
        });
        (view, gain)
    }

    /// Computes cached gains near the robot anew, every few seconds.
    fn renew(&mut self, sight: &Sight<'_>) {
        if sight.now - self.renewed < self.settings.renew_period {
            return;
        }
        self.renewed = sight.now;
        let reach = 2.0 * self.settings.rays.range.1;
        let above = self.settings.renew_above * self.scale * self.share;
        for i in 0..self.cache.len() {
            let (place, gain) = (self.cache[i].view.place, self.cache[i].gain);
            let near = (0..3).all(|a| (place[a] - sight.camera.place[a]).abs() <= reach);
            if near && gain > above {
                self.renew_one(sight, i);
            }
        }
    }

    fn renew_one(&mut self, sight: &Sight<'_>, i: usize) {
        let (view, gain) = self.integrate(sight, self.cache[i].view.place);
        self.cache[i] = Cached {
            view,
            gain,
            at: sight.now,
            visits: self.cache[i].visits,
        };
    }

    /// A uniform sample of the ball around the robot at a height the arm reaches, inside the map.
    fn sample(&mut self, sight: &Sight<'_>) -> Option<[f64; 3]> {
        let r = self.settings.sampling_radius;
        let (low, high) = self.settings.heights;
        let center = sight.camera.place;
        let (down, up) = ((center[2] - r).max(low), (center[2] + r).min(high));
        for _ in 0..64 {
            let [u, v, w] = [self.uniform(), self.uniform(), self.uniform()];
            let place = [
                center[0] + r * (2.0 * u - 1.0),
                center[1] + r * (2.0 * v - 1.0),
                down + (up - down) * w,
            ];
            let map = &sight.whole.mapper.map;
            if apart(&place, &center) <= r && map.contains(map.cell_at(place)) {
                return Some(place);
            }
        }
        None
    }

    fn grow(&mut self, sight: &Sight<'_>) -> Vec<Node> {
        let s = self.settings.clone();
        let room = Room {
            whole: &sight.whole,
            radius: s.radius,
            heights: s.heights,
            ground: Some(sight.disc),
        };
        let root = sight.camera.place;
        let (view, gain) = self.gain(sight, root);
        let mut tree = vec![Node {
            view,
            gain,
            parent: None,
            edge: 0.0,
            way: 0.0,
            score: gain,
        }];
        // What is left of the last best branch comes first, as far as the map still lets it.
        for place in std::mem::take(&mut self.branch) {
            let parent = tree.len() - 1;
            let from = tree[parent].view.place;
            let far = apart(&from, &place) > s.edge + s.edge_slack;
            if far || !room.holds(place) || !room.connects(from, place) {
                break;
            }
            self.add(sight, &mut tree, parent, place);
        }
        let zero = s.exhausted * self.scale * self.share;
        let mut tries = s.tries;
        while tries > 0 {
            let best = tree.iter().map(|n| n.score).fold(0.0, f64::max);
            let grown = tree.len() - 1;
            if grown >= s.most_nodes || (grown >= s.initial_nodes && best > zero) {
                break;
            }
            tries -= 1;
            self.samples += 1;
            let Some(sample) = self.sample(sight) else {
                continue;
            };
            // The cheapest node near the sample, or the nearest.
            let reach = s.edge + s.edge_slack;
            let d = |i: usize| apart(&tree[i].view.place, &sample);
            let cheapest = (0..tree.len())
                .filter(|&i| d(i) <= reach)
                .min_by(|&a, &b| tree[a].way.total_cmp(&tree[b].way));
            let parent = cheapest
                .or_else(|| (0..tree.len()).min_by(|&a, &b| d(a).total_cmp(&d(b))))
                .unwrap_or(0);
            let (from, length) = (tree[parent].view.place, d(parent));
            let t = (s.edge / length.max(1e-9)).min(1.0);
            let place = [0, 1, 2].map(|a| from[a] + t * (sample[a] - from[a]));
            if self.failures.excludes([place[0], place[1]], sight.now)
                || !room.holds(place)
                || !room.connects(from, place)
            {
                continue;
            }
            self.add(sight, &mut tree, parent, place);
            rewire(&mut tree, reach, &room);
            score(&mut tree, s.decay);
        }
        tree
    }

    fn add(&mut self, sight: &Sight<'_>, tree: &mut Vec<Node>, parent: usize, place: [f64; 3]) {
        let (view, gain) = self.gain(sight, place);
        let edge = apart(&tree[parent].view.place, &place);
        tree.push(Node {
            view,
            gain,
            parent: Some(parent),
            edge,
            way: tree[parent].way + edge,
            score: 0.0,
        });
        score(tree, self.settings.decay);
    }

    /// The first edges of the tree, that of the best branch first.
    fn edges(&self, tree: &[Node]) -> Vec<Offer> {
        // For each child of the root the best node behind it.
        let mut best: Vec<(usize, usize)> = Vec::new();
        for i in 1..tree.len() {
            let mut child = i;
            while let Some(parent) = tree[child].parent.filter(|&p| p != 0) {
                child = parent;
            }
            match best.iter_mut().find(|(c, _)| *c == child) {
                Some((_, b)) => {
                    if tree[i].score > tree[*b].score {
                        *b = i;
                    }
                }
                None => best.push((child, i)),
            }
        }
        best.sort_by(|a, b| tree[b.1].score.total_cmp(&tree[a.1].score));
        best.into_iter()
            .map(|(child, end)| {
                let mut rest = Vec::new();
                let mut node = end;
                while node != child {
                    rest.push(tree[node].view.place);
                    node = tree[node].parent.unwrap_or(child);
                }
                rest.reverse();
                Offer {
                    view: tree[child].view,
                    rest,
                }
            })
            .collect()
    }

    /// Cached places that promise enough, the nearest by the ground first.
    fn goals(&mut self, sight: &Sight<'_>) -> Vec<View> {
        let threshold = self.settings.frontier * self.scale * self.share;
        for i in 0..self.cache.len() {
            if self.cache[i].gain > threshold && self.cache[i].at < sight.now {
                self.renew_one(sight, i);
            }
        }
        let here = [sight.base[0], sight.base[1]];
        let mut goals: Vec<(f64, View)> = self
            .cache
            .iter()
            .filter(|c| c.gain > threshold && c.visits < VISITS)
            .map(|c| (c.view, [c.view.place[0], c.view.place[1]]))
            .filter(|(_, place)| !self.failures.excludes(*place, sight.now))
            .map(|(view, place)| (sight.ways.meters(here, place), view))
            .filter(|(way, _)| way.is_finite())
            .collect();
        goals.sort_by(|a, b| a.0.total_cmp(&b.0));
        goals.into_iter().take(GOALS).map(|g| g.1).collect()
    }

    /// Notes what the last move uncovered.
    fn reckon(&mut self, sight: &Sight<'_>) {
        let counts = sight.whole.mapper.map.counts();
        let volume = sight.whole.mapper.map.cell_size().powi(3);
        let known = counts.known as f64 * volume;
        let least = 0.1 * self.settings.frontier * self.scale * self.share;
        if known - self.known < least {
            self.idle += 1;
        } else {
            self.idle = 0;
        }
        self.known = known;
    }

    /// The cached gains, for tests.
    #[cfg(test)]
    pub(super) fn cached(&self) -> &[Cached] {
        &self.cache
    }
}

/// Hangs nodes near the last one behind it where that makes their branch shorter, and corrects the branches behind them.
fn rewire(tree: &mut [Node], reach: f64, room: &Room<'_>) {
    let last = tree.len() - 1;
    for i in 1..last {
        let edge = apart(&tree[i].view.place, &tree[last].view.place);
        let shorter = tree[last].way + edge + 1e-9 < tree[i].way;
        if edge <= reach && shorter && room.connects(tree[last].view.place, tree[i].view.place) {
            tree[i].parent = Some(last);
            tree[i].edge = edge;
        }
    }
    lengthen(tree);
}

/// Nodes in an order in which parents come first.
fn order(tree: &[Node]) -> Vec<usize> {
    let mut children = vec![Vec::new(); tree.len()];
    for (i, node) in tree.iter().enumerate() {
        if let Some(parent) = node.parent {
            children[parent].push(i);
        }
    }
    let mut order = vec![0];
    let mut next = 0;
    while next < order.len() {
        order.extend_from_slice(&children[order[next]]);
        next += 1;
    }
    order
}

fn lengthen(tree: &mut [Node]) {
    for i in order(tree) {
        if let Some(parent) = tree[i].parent {
            tree[i].way = tree[parent].way + tree[i].edge;
        }
    }
}

/// The score of a node is its parent's and its own gain, decayed with the length of the edge between them.
fn score(tree: &mut [Node], decay: f64) {
    for i in order(tree) {
        if let Some(parent) = tree[i].parent {
            tree[i].score = tree[parent].score + tree[i].gain * (-decay * tree[i].edge).exp();
        }
    }
}

impl Planner for Aep {
    fn next(&mut self, sight: &Sight<'_>) -> Next {
        self.renew(sight);
        self.reckon(sight);
        let tree = self.grow(sight);
        loop {
            let best = tree.iter().map(|n| n.score).fold(0.0, f64::max);
            let zero = self.settings.exhausted * self.scale * self.share;
            self.offers.clear();
            if best > zero && tree.len() > 1 && self.idle < IDLE {
                self.offers = self.edges(&tree);
                return Next::First(self.offers.iter().map(|o| o.view).collect());
            }
            let goals = self.goals(sight);
            if !goals.is_empty() {
                self.idle = 0;
                return Next::First(goals);
            }
            if self.failures.lift(sight.now) {
                continue;
            }
            if self.share * 0.5 < self.settings.least_share {
                return Next::Done;
            }
            self.share *= 0.5;
            self.idle = 0;
        }
    }

    fn set_out(&mut self, view: &View) {
        self.branch = match self.offers.iter().find(|o| o.view == *view) {
            Some(offer) => offer.rest.clone(),
            None => Vec::new(),
        };
    }

    fn reached(&mut self, view: &View) {
        for cached in self.cache.iter_mut().filter(|c| c.view.place == view.place) {
            cached.visits += 1;
        }
    }

    fn failed(&mut self, view: &View, now: f64) {
        self.branch.clear();
        let place = [view.place[0], view.place[1]];
        if self.failures.strike(place, now, self.exclusion) > VISITS as u32 {
            self.reached(view);
        }
    }

    fn counted(&mut self) -> f64 {
        let lookups = std::mem::take(&mut self.lookups);
        let samples = std::mem::take(&mut self.samples);
        let regression = std::mem::take(&mut self.regression);
        8e-9 * lookups as f64 + 2e-6 * samples as f64 + 1e-9 * regression as f64
    }
}
