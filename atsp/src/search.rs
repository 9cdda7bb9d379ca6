//! Iterated local search: kicks that stay local, descents that look only where something changed, and undo.

use crate::candidates::Candidates;
use crate::closed::Closed;
use crate::pace::Pace;
use crate::rng::Rng;
use crate::tour::Tour;

/// A move must gain this share of the arcs it removes; less is rounding.
pub(crate) const TOLERANCE: f64 = 1e-12;

/// Workspace of the search.
#[derive(Debug, Default)]
pub(crate) struct Search {
    pub(crate) candidates: Candidates,
    tour: Tour,
    /// Nodes whose surroundings changed since they were last looked at.
    queue: Vec<u32>,
    queued: Vec<bool>,
    cost: f64,
    best: Vec<u32>,
    best_cost: f64,
    /// Kicks since the best was found.
    idle: u64,
    /// Kicks yet to be accepted whatever they cost.
    blind: u32,
    /// Times the search stood still.
    standstills: u32,
    mirrors: bool,
    /// Steps of work since the caller was last asked.
    work: u32,
}

/// A move that gains: the segment of `first` nodes at `at`, after a reversal of its first `turned` nodes, changes places
/// with the `second` nodes behind it.
struct Exchange {
    gain: f64,
    at: usize,
    first: usize,
    second: usize,
    turned: usize,
}

/// Nodes looked at between two questions to the caller: ten to twenty microseconds. Reversals take as long again.
const BETWEEN: u32 = 48;
/// Kicks after which a late search without an order that can be driven gives up.
const RESCUE: u64 = 10_000;
/// Longest segment of a kick, nodes.
const KICKED: usize = 20;
/// After so many kicks a node that found nothing better the search stands still.
const PATIENCE: u64 = 5;
/// Kicks accepted blindly after a standstill.
const BLIND: u32 = 50;
/// One in so many standstills ends with an order from scratch instead. On sets that take longest, of 100 to 300 nodes,
/// this is a tenth quicker in the mean; on the others a twentieth slower.
const AFRESH: u32 = 3;
/// Longest segment that is moved and reversed at once.
const TURNED: usize = 3;
/// Reversal moves are tried where the two directions of candidate arcs differ by less than this share.
const NEARLY_SYMMETRIC: f64 = 0.15;

impl Search {
    /// The best tour so far, and its cost.
    pub(crate) fn best(&self) -> (&[u32], f64) {
        (&self.best, self.best_cost)
    }

    /// Forgets the best tour and takes this one.
    pub(crate) fn reset(&mut self, closed: &Closed, tour: &[u32], pace: &mut Pace<'_>) {
        self.best.clear();
        self.best.extend_from_slice(tour);
        self.best_cost = f64::INFINITY;
        self.begin(closed, tour, pace);
    }

    /// Goes on from a tour, with every node to be looked at.
    pub(crate) fn begin(&mut self, closed: &Closed, tour: &[u32], pace: &mut Pace<'_>) {
        let n = tour.len();
        self.tour.set(tour);
        self.cost = closed.along(tour);
        self.note(closed, pace);
        self.queue.clear();
        self.queued.clear();
        self.queued.resize(n, false);
        for k in (0..n).rev() {
            self.wake(tour[k]);
        }
    }

    #[inline]
    fn wake(&mut self, node: u32) {
        if !self.queued[node as usize] {
            self.queued[node as usize] = true;
            self.queue.push(node);
        }
    }

    /// Improves until no move gains or the caller stops; the sum of the gains.
    fn descend(&mut self, closed: &Closed, pace: &mut Pace<'_>) -> f64 {
        let mut sum = 0.0;
        while let Some(node) = self.queue.pop() {
            self.queued[node as usize] = false;
            loop {
                let gain = self.improve(closed, node);
                self.work += 1 + u32::from(self.mirrors);
                if gain <= 0.0 {
                    break;
                }
                sum += gain;
            }
            if self.work >= BETWEEN {
                self.work = 0;
                if pace.stop() {
                    break;
                }
            }
        }
        sum
    }

    /// Applies the first gaining move that opens the arc out of or into the node; its gain, or zero.
    fn improve(&mut self, closed: &Closed, node: u32) -> f64 {
        let found = self
            .open_tail(closed, node)
            .or_else(|| self.open_head(closed, node))
            .or_else(|| {
                if self.mirrors {
                    self.turn(closed, node)
                } else {
                    None
                }
            });
        let Some(found) = found else { return 0.0 };
        self.apply(&found);
        found.gain
    }

    fn apply(&mut self, x: &Exchange) {
        let n = self.tour.len();
        if x.turned > 0 {
            self.tour.reverse(x.at, x.turned);
        }
        let wrap = |i: usize| if i >= n { i - n } else { i };
        let b = wrap(x.at + x.first);
        let c = wrap(x.at + x.first + x.second);
        let before = |i: usize| if i == 0 { n - 1 } else { i - 1 };
        for i in [before(x.at), x.at, before(b), b, before(c), c] {
            self.wake(self.tour.at(i));
        }
        self.tour.exchange(x.at, x.first, x.second);
    }

    /// Moves that give `a` a better successor: with `a -> a2`, `b -> b2`, `c -> c2` in this order around the tour,
    /// `a -> b2`, `c -> a2` and `b -> c2` take their place.
    fn open_tail(&self, closed: &Closed, a: u32) -> Option<Exchange> {
        let tour = &self.tour;
        let a2 = tour.next(a);
        let at = tour.place(a2);
        let removed = closed.cost(a as usize, a2 as usize);
        for arc in self.candidates.heads(a) {
            let g1 = removed - arc.cost;
            if g1 <= 0.0 {
                break;
            }
            let b2 = arc.node;
            let first = tour.offset(at, b2);
            let b = tour.previous(b2);
            let cut = closed.cost(b as usize, b2 as usize);
            let g1 = g1 + cut;
            for arc in self.candidates.heads(b) {
                let g2 = g1 - arc.cost;
                if g2 <= 0.0 {
                    break;
                }
                let c2 = arc.node;
                let second = tour.offset(at, c2);
                if second <= first {
                    continue;
                }
                let c = tour.previous(c2);
                let last = closed.cost(c as usize, c2 as usize);
                let gain = g2 + last - closed.cost(c as usize, a2 as usize);
                if gain > TOLERANCE * (removed + cut + last) {
                    return Some(Exchange {
                        gain,
                        at,
                        first,
                        second: second - first,
                        turned: 0,
                    });
                }
            }
            for arc in self.candidates.tails(a2) {
                let g2 = g1 - arc.cost;
                if g2 <= 0.0 {
                    break;
                }
                let c = arc.node;
                let second = tour.offset(at, c) + 1;
                if second <= first || c == a {
                    continue;
                }
                let c2 = tour.next(c);
                let last = closed.cost(c as usize, c2 as usize);
                let gain = g2 + last - closed.cost(b as usize, c2 as usize);
                if gain > TOLERANCE * (removed + cut + last) {
                    return Some(Exchange {
                        gain,
                        at,
                        first,
                        second: second - first,
                        turned: 0,
                    });
                }
            }
        }
        None
    }

    /// The same moves, found from the node that gets a better predecessor: `c -> a2` first.
    fn open_head(&self, closed: &Closed, a2: u32) -> Option<Exchange> {
        let tour = &self.tour;
        let a = tour.previous(a2);
        let at = tour.place(a2);
        let removed = closed.cost(a as usize, a2 as usize);
        for arc in self.candidates.tails(a2) {
            let g1 = removed - arc.cost;
            if g1 <= 0.0 {
                break;
            }
            let c = arc.node;
            let second = tour.offset(at, c) + 1;
            let c2 = tour.next(c);
            let cut = closed.cost(c as usize, c2 as usize);
            let g1 = g1 + cut;
            for arc in self.candidates.tails(c2) {
                let g2 = g1 - arc.cost;
                if g2 <= 0.0 {
                    break;
                }
                let b = arc.node;
                let first = tour.offset(at, b) + 1;
                if first >= second {
                    continue;
                }
                let b2 = tour.next(b);
                let last = closed.cost(b as usize, b2 as usize);
                let gain = g2 + last - closed.cost(a as usize, b2 as usize);
                if gain > TOLERANCE * (removed + cut + last) {
                    return Some(Exchange {
                        gain,
                        at,
                        first,
                        second: second - first,
                        turned: 0,
                    });
                }
            }
            for arc in self.candidates.heads(a) {
                let g2 = g1 - arc.cost;
                if g2 <= 0.0 {
                    break;
                }
                let b2 = arc.node;
                let first = tour.offset(at, b2);
                if first == 0 || first >= second {
                    continue;
                }
                let b = tour.previous(b2);
                let last = closed.cost(b as usize, b2 as usize);
                let gain = g2 + last - closed.cost(b as usize, c2 as usize);
                if gain > TOLERANCE * (removed + cut + last) {
                    return Some(Exchange {
                        gain,
                        at,
                        first,
                        second: second - first,
                        turned: 0,
                    });
                }
            }
        }
        None
    }

    /// What the reversal of the segment of `len` nodes at position `at` gains inside it.
    fn turned(&self, closed: &Closed, at: usize, len: usize) -> f64 {
        let mut gain = 0.0;
        let mut from = self.tour.at(at) as usize;
        for k in 1..len {
            let to = self.tour.at(at + k) as usize;
            gain += closed.cost(from, to) - closed.cost(to, from);
            from = to;
        }
        gain
    }

    /// Moves that reverse: 2-opt, and segments of at most [`TURNED`] nodes put elsewhere backwards.
    fn turn(&self, closed: &Closed, node: u32) -> Option<Exchange> {
        let tour = &self.tour;
        let n = tour.len();
        let cost = |a: u32, b: u32| closed.cost(a as usize, b as usize);
        // Towards its successor, then its predecessor.
        let (p, q) = (node, tour.next(node));
        let removed = cost(p, q);
        for arc in self.candidates.heads(p) {
            let g1 = removed - arc.cost;
            if g1 <= 0.0 {
                break;
            }
            // p -> b, q -> b2 with q..b reversed.
            let b = arc.node;
            let b2 = tour.next(b);
            let cut = cost(b, b2);
            let gain = g1 + cut - cost(q, b2);
            if gain > TOLERANCE * (removed + cut) && b2 != p {
                let (at, len) = (tour.place(q), tour.offset(tour.place(q), b) + 1);
                let gain = gain + self.turned(closed, at, len);
                if gain > TOLERANCE * (removed + cut) {
                    return Some(Exchange {
                        gain,
                        at,
                        first: len,
                        second: 0,
                        turned: len,
                    });
                }
            }
            // Segment s..b goes between p and q backwards.
            let mut s = b;
            for len in 2..=TURNED.min(n - 3) {
                s = tour.previous(s);
                if s == p || s == q {
                    break;
                }
                let x = tour.previous(s);
                let away = cost(x, s) + cut;
                let gain = g1 + away - cost(s, q) - cost(x, b2);
                if x != p && b2 != p && gain > TOLERANCE * (removed + away) {
                    let at = tour.place(s);
                    let gain = gain + self.turned(closed, at, len);
                    if gain > TOLERANCE * (removed + away) {
                        let second = tour.offset(tour.place(b2), p) + 1;
                        return Some(Exchange {
                            gain,
                            at,
                            first: len,
                            second,
                            turned: len,
                        });
                    }
                }
            }
        }
        let (p, q) = (tour.previous(node), node);
        let removed = cost(p, q);
        for arc in self.candidates.tails(q) {
            let g1 = removed - arc.cost;
            if g1 <= 0.0 {
                break;
            }
            // a -> p, s -> q with s..p reversed.
            let s = arc.node;
            let a = tour.previous(s);
            let cut = cost(a, s);
            let gain = g1 + cut - cost(a, p);
            if gain > TOLERANCE * (removed + cut) && a != q {
                let (at, len) = (tour.place(s), tour.offset(tour.place(s), p) + 1);
                let gain = gain + self.turned(closed, at, len);
                if gain > TOLERANCE * (removed + cut) {
                    return Some(Exchange {
                        gain,
                        at,
                        first: len,
                        second: 0,
                        turned: len,
                    });
                }
            }
            // Segment s..e goes between p and q backwards.
            let mut e = s;
            for len in 2..=TURNED.min(n - 3) {
                e = tour.next(e);
                if e == q || e == p {
                    break;
                }
                let y = tour.next(e);
                let away = cost(e, y) + cut;
                let gain = g1 + away - cost(p, e) - cost(a, y);
                if y != p && a != p && a != q && y != q && gain > TOLERANCE * (removed + away) {
                    let at = tour.place(s);
                    let gain = gain + self.turned(closed, at, len);
                    if gain > TOLERANCE * (removed + away) {
                        let second = tour.offset(tour.place(y), p) + 1;
                        return Some(Exchange {
                            gain,
                            at,
                            first: len,
                            second,
                            turned: len,
                        });
                    }
                }
            }
        }
        None
    }

    /// Goes back to the best tour.
    pub(crate) fn back(&mut self) {
        self.tour.set(&self.best);
        self.cost = self.best_cost;
    }

    /// Descends from where it stands; reports each better order.
    pub(crate) fn settle(&mut self, closed: &Closed, pace: &mut Pace<'_>) {
        self.mirrors = self.candidates.asymmetry(closed) < NEARLY_SYMMETRIC;
        self.work = 0;
        self.descend(closed, pace);
        self.tour.commit();
        self.cost = closed.along(self.tour.order());
        self.note(closed, pace);
        self.idle = 0;
        self.blind = 0;
        self.standstills = 0;
    }

    /// Keeps the current tour if it is the best.
    fn note(&mut self, closed: &Closed, pace: &mut Pace<'_>) {
        if self.cost < self.best_cost {
            self.best_cost = self.cost;
            self.best.copy_from_slice(self.tour.order());
            self.idle = 0;
            if closed.is_allowed(self.cost) {
                pace.improved(self.cost);
            }
        }
    }

    /// Kicks and descends so many times, until the cost is down to `bound`, or until the caller stops; the kicks done.
    pub(crate) fn kicks(
        &mut self,
        closed: &Closed,
        kicks: u64,
        bound: f64,
        rng: &mut Rng,
        pace: &mut Pace<'_>,
    ) -> u64 {
        let n = closed.n;
        let goal = bound + TOLERANCE * bound.abs();
        let mut done = 0;
        while done < kicks && self.best_cost > goal && n >= 8 {
            if pace.is_stopped() || (done > RESCUE && done % 64 == 0 && pace.is_late()) {
                break;
            }
            done += 1;
            self.idle += 1;
            let change = self.kick(closed, rng) - self.descend(closed, pace);
            if change > TOLERANCE * self.cost && self.blind == 0 {
                self.tour.undo();
            } else {
                self.tour.commit();
                self.blind = self.blind.saturating_sub(1);
                if change.abs() > TOLERANCE * self.cost {
                    self.cost += change;
                    if self.cost < self.best_cost - TOLERANCE * self.best_cost {
                        self.cost = closed.along(self.tour.order());
                        self.note(closed, pace);
                    }
                }
            }
            if self.idle > PATIENCE * n as u64 && self.queue.is_empty() {
                self.idle = 0;
                self.standstills += 1;
                if self.standstills.is_multiple_of(AFRESH) {
                    self.start_afresh(closed, rng, pace);
                } else {
                    // From the best on, accept a number of kicks whatever they cost.
                    self.back();
                    self.blind = BLIND;
                }
            }
        }
        while let Some(node) = self.queue.pop() {
            self.queued[node as usize] = false;
        }
        done
    }

    /// Descends from the order that begins at a random node and goes on to the nearest candidate not yet visited, or to
    /// the nearest node where all candidates were.
    fn start_afresh(&mut self, closed: &Closed, rng: &mut Rng, pace: &mut Pace<'_>) {
        let n = closed.n;
        // The flags of the queue, empty now, mark visited nodes: at the end all are to be looked at.
        let mut here = rng.below(n) as u32;
        self.queued[here as usize] = true;
        self.queue.push(here);
        while self.queue.len() < n {
            let is_new = |node: u32| !self.queued[node as usize];
            let near = self.candidates.heads(here).iter();
            here = match near.map(|arc| arc.node).find(|&node| is_new(node)) {
                Some(node) => node,
                None => {
                    let (mut nearest, mut least) = (here, f64::INFINITY);
                    for (node, &cost) in closed.row(here as usize).iter().enumerate() {
                        if cost < least && is_new(node as u32) {
                            (nearest, least) = (node as u32, cost);
                        }
                    }
                    nearest
                }
            };
            self.queued[here as usize] = true;
            self.queue.push(here);
        }
        self.tour.set(&self.queue);
        self.blind = 0;
        self.descend(closed, pace);
        self.tour.commit();
        self.cost = closed.along(self.tour.order());
        self.note(closed, pace);
    }

    /// A double bridge on three short neighbouring segments, A B C to C B A; what it adds to the cost.
    fn kick(&mut self, closed: &Closed, rng: &mut Rng) -> f64 {
        let n = self.tour.len();
        let longest = KICKED.min((n - 2) / 3);
        let at = rng.below(n);
        let [x, y, z] = [0; 3].map(|_| 1 + rng.below(longest));
        let node = |k: usize| self.tour.at(at + k);
        let before = self.tour.at(at + n - 1);
        let ends = [
            before,
            node(0),
            node(x - 1),
            node(x),
            node(x + y - 1),
            node(x + y),
            node(x + y + z - 1),
            node(x + y + z),
        ];
        let [p, a, a2, b, b2, c, c2, q] = ends.map(|e| e as usize);
        for end in ends {
            self.wake(end);
        }
        let change =
            closed.cost(p, c) + closed.cost(c2, b) + closed.cost(b2, a) + closed.cost(a2, q)
                - closed.cost(p, a)
                - closed.cost(a2, b)
                - closed.cost(b2, c)
                - closed.cost(c2, q);
        self.tour.exchange(at, x + y, z);
        let at = self.tour.place(a as u32);
        self.tour.exchange(at, x, y);
        change
    }
}
