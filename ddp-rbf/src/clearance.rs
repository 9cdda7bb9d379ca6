//! Clearance of a robot made of spheres: to a distance field, to half-spaces, and to itself, many knots at a time.

mod batch;

use crate::barrier::Barrier;
use crate::chain::{Chain, MAX_SPHERES, MAX_STATES, Placed, cross};
use crate::constraint::{Constraint, Horizon, Penalty};
use crate::cost::Expansion;
use crate::error::Error;
use crate::field::Field;
use crate::simd::{Lanes, Portable, Vector, dispatch};
use batch::Batch;
use nalgebra::SVector;

/// Every chosen sphere keeps a margin from a field's surface (HEATS eq. 7).
#[derive(Clone, Debug, PartialEq)]
pub struct SphereClearance<'a, F> {
    /// The robot.
    pub chain: &'a Chain,
    /// Distance to obstacles.
    pub field: &'a F,
    /// Indices of the spheres that count.
    pub spheres: &'a [usize],
    /// Room beyond the spheres, m.
    pub margin: f64,
    /// True if the field moves with the robot's base (its own housing, a tray) and is queried in the base frame; false for
    /// fields of the world.
    pub on_base: bool,
    /// Penalty; a cut-off saves most of the work, since most spheres are far from everything.
    pub barrier: Barrier,
    /// Name in reports.
    pub name: &'static str,
}

/// Chosen spheres stay on one side of planes: a floor, a wall, a safety fence.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneClearance<'a> {
    /// The robot.
    pub chain: &'a Chain,
    /// Planes as unit normal (world) and offset, m: `n . p + offset > 0` inside.
    pub planes: &'a [[f64; 4]],
    /// Indices of the spheres that count.
    pub spheres: &'a [usize],
    /// Room beyond the spheres, m.
    pub margin: f64,
    /// Penalty.
    pub barrier: Barrier,
    /// Name in reports.
    pub name: &'static str,
}

/// Pairs of the robot's own spheres keep apart (HEATS eq. 8).
#[derive(Clone, Debug, PartialEq)]
pub struct PairClearance<'a> {
    /// The robot.
    pub chain: &'a Chain,
    /// Pairs of spheres, by index.
    pub pairs: &'a [(usize, usize)],
    /// Room between spheres, m.
    pub margin: f64,
    /// Penalty.
    pub barrier: Barrier,
    /// Name in reports.
    pub name: &'static str,
}

/// The constraints of a group at several knots, one after the other. No closures, for the reason given at [`Chain::place`].
trait Terms {
    /// How many there are.
    fn len(&self) -> usize;
    /// Asks a field about constraints `from` to `from + CHUNK`, if there is one.
    #[inline(always)]
    fn ask<V: Vector, const S: usize>(
        &self,
        _placed: &Placed<V, S>,
        _from: usize,
        _talk: &mut Talk,
    ) {
    }
    /// Asks the field about constraint `i` at one knot.
    fn ask_one(&self, _placed: &Placed<Portable<1>, MAX_SPHERES>, _i: usize) -> [[f64; 1]; 4] {
        [[0.0]; 4]
    }
    /// Constraint `i`, with the field's answer; `None` if it lies beyond the cut-off at all knots.
    fn term<const L: usize, const S: usize, V: Vector<L>>(
        &self,
        placed: &Placed<V, S>,
        i: usize,
        answer: &[[f64; L]; 4],
    ) -> Option<Term<V>>;
    /// Deepest link whose place is needed.
    fn last(&self) -> usize;
    /// Whether places in the world are needed.
    fn world(&self) -> bool;
    fn chain(&self) -> &Chain;
    fn penalty(&self) -> Barrier;
}

/// Constraints whose field is asked at once.
const CHUNK: usize = 16;

/// Room for what a field is asked and for what it answers; what it holds before is arbitrary.
struct Talk {
    points: [[Lanes; 3]; CHUNK],
    answers: [[Lanes; 4]; CHUNK],
}

/// One constraint at several knots.
struct Term<V> {
    z: V,
    /// Gradient of z by the point that moves.
    way: [V; 3],
    point: [V; 3],
    /// Joints `first..last` move the point.
    first: usize,
    last: usize,
    /// Whether the base moves it too.
    base: bool,
}

impl<F: Field> Terms for SphereClearance<'_, F> {
    fn len(&self) -> usize {
        self.spheres.len()
    }
    #[inline(always)]
    fn ask<V: Vector, const S: usize>(&self, placed: &Placed<V, S>, from: usize, talk: &mut Talk) {
        let Talk { points, answers } = talk;
        let n = CHUNK.min(self.spheres.len() - from);
        for i in 0..n {
            let center = &placed.centers[self.spheres[from + i]];
            for a in 0..3 {
                center[a].store(&mut points[i][a]);
            }
        }
        self.field.batch(&points[..n], &mut answers[..n]);
    }
    fn ask_one(&self, placed: &Placed<Portable<1>, MAX_SPHERES>, i: usize) -> [[f64; 1]; 4] {
        let center = &placed.centers[self.spheres[i]];
        let (distance, [x, y, z]) = self.field.distance_gradient(center.map(|v| v.array()[0]));
        [[distance], [x], [y], [z]]
    }
    #[inline(always)]
    fn term<const L: usize, const S: usize, V: Vector<L>>(
        &self,
        placed: &Placed<V, S>,
        i: usize,
        answer: &[[f64; L]; 4],
    ) -> Option<Term<V>> {
        let i = self.spheres[i];
        let sphere = &self.chain.spheres()[i];
        Some(Term {
            z: V::load(&answer[0]) - V::splat(sphere.radius + self.margin),
            way: [
                V::load(&answer[1]),
                V::load(&answer[2]),
                V::load(&answer[3]),
            ],
            point: placed.centers[i],
            first: 0,
            last: sphere.link,
            base: self.chain.is_planar() && !self.on_base,
        })
    }
    fn last(&self) -> usize {
        deepest(self.chain, self.spheres.iter().copied())
    }
    fn world(&self) -> bool {
        !self.on_base
    }
    fn chain(&self) -> &Chain {
        self.chain
    }
    fn penalty(&self) -> Barrier {
        self.barrier
    }
}

impl Terms for PlaneClearance<'_> {
    fn len(&self) -> usize {
        self.spheres.len() * self.planes.len()
    }
    #[inline(always)]
    fn term<const L: usize, const S: usize, V: Vector<L>>(
        &self,
        placed: &Placed<V, S>,
        i: usize,
        _: &[[f64; L]; 4],
    ) -> Option<Term<V>> {
        let (s, plane) = (i / self.planes.len(), i % self.planes.len());
        let (i, [x, y, z, offset]) = (self.spheres[s], self.planes[plane]);
        let sphere = &self.chain.spheres()[i];
        let c = placed.centers[i];
        let way = [V::splat(x), V::splat(y), V::splat(z)];
        let height = way[0].mul_add(c[0], way[1].mul_add(c[1], way[2] * c[2]));
        Some(Term {
            z: height + V::splat(offset - sphere.radius - self.margin),
            way,
            point: c,
            first: 0,
            last: sphere.link,
            base: self.chain.is_planar(),
        })
    }
    fn last(&self) -> usize {
        deepest(self.chain, self.spheres.iter().copied())
    }
    fn world(&self) -> bool {
        true
    }
    fn chain(&self) -> &Chain {
        self.chain
    }
    fn penalty(&self) -> Barrier {
        self.barrier
    }
}

impl Terms for PairClearance<'_> {
    fn len(&self) -> usize {
        self.pairs.len()
    }
    #[inline(always)]
    fn term<const L: usize, const S: usize, V: Vector<L>>(
        &self,
        placed: &Placed<V, S>,
        i: usize,
        _: &[[f64; L]; 4],
    ) -> Option<Term<V>> {
        let all = self.chain.spheres();
        let (i, j) = self.pairs[i];
        let (near, far) = if all[i].link <= all[j].link {
            (i, j)
        } else {
            (j, i)
        };
        let (a, b) = (&placed.centers[near], &placed.centers[far]);
        let d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
        let square = d[0].mul_add(d[0], d[1].mul_add(d[1], d[2] * d[2]));
        let needs = all[i].radius + all[j].radius + self.margin;
        // Beyond the cut-off a squared distance is enough to know that nothing pushes.
        if let Some(end) = self.barrier.cutoff {
            let far = (needs + end).max(0.0);
            if V::splat(far * far).all_less(square) {
                return None;
            }
        }
        // The least square keeps the direction finite where centres meet.
        let inverse = square.max(V::splat(1e-18)).inverse_sqrt();
        let length = square * inverse;
        // A push along the line through both centres lifts only the joints between the two links.
        Some(Term {
            z: length - V::splat(needs),
            way: [d[0] * inverse, d[1] * inverse, d[2] * inverse],
            point: *b,
            first: all[near].link,
            last: all[far].link,
            base: false,
        })
    }
    fn last(&self) -> usize {
        deepest(self.chain, self.pairs.iter().flat_map(|&(i, j)| [i, j]))
    }
    fn world(&self) -> bool {
        false
    }
    fn chain(&self) -> &Chain {
        self.chain
    }
    fn penalty(&self) -> Barrier {
        self.barrier
    }
}

fn deepest(chain: &Chain, spheres: impl Iterator<Item = usize>) -> usize {
    spheres.map(|i| chain.spheres()[i].link).max().unwrap_or(0)
}

/// Gradient of a term by the states that move spheres, into `out` from the returned index to `base_states + term.last`.
#[inline(always)]
fn row<const L: usize, const S: usize, V: Vector<L>>(
    term: &Term<V>,
    placed: &Placed<V, S>,
    base_states: usize,
    out: &mut [V; MAX_STATES],
) -> usize {
    let torque = cross(term.point, term.way);
    for j in term.first..term.last {
        out[base_states + j] = placed.lift(j, &term.way, &torque);
    }
    if !term.base {
        return base_states + term.first;
    }
    let ([x, y], n) = (placed.base, &term.way);
    out[0] = n[0];
    out[1] = n[1];
    // Turning about the base's place.
    out[2] = x.neg_mul_add(n[1], y.mul_add(n[0], torque[2]));
    0
}

/// Spheres of a small robot, which are placed in less room: making room for [`MAX_SPHERES`] takes time.
const FEW: usize = 16;

/// The same terms at one knot, one by one.
fn visit_rows<const NX: usize>(
    terms: &impl Terms,
    x: &SVector<f64, NX>,
    visit: &mut dyn FnMut(f64, &SVector<f64, NX>),
) {
    let chain = terms.chain();
    let base_states = chain.base_states();
    let mut at = [Portable::<1>::zero(); MAX_STATES];
    for (to, from) in at.iter_mut().zip(x.iter()) {
        *to = Portable::splat(*from);
    }
    let mut placed = Placed::new();
    chain.place(&at, terms.last(), terms.world(), &mut placed);
    for i in 0..terms.len() {
        let Some(term) = terms.term(&placed, i, &terms.ask_one(&placed, i)) else {
            continue;
        };
        let mut slopes = [Portable::<1>::zero(); MAX_STATES];
        let start = row(&term, &placed, base_states, &mut slopes);
        let end = base_states + term.last;
        let row = SVector::from_fn(|i, _| {
            if (start..end).contains(&i) || (term.base && i < base_states) {
                slopes[i].array()[0]
            } else {
                0.0
            }
        });
        visit(term.z.array()[0], &row);
    }
}

/// Checks that a chain fits a state and that indices name spheres.
fn fits<const NX: usize>(
    chain: &Chain,
    mut spheres: impl Iterator<Item = usize>,
) -> Result<(), Error> {
    if chain.states() > NX {
        return Err(Error::Chain {
            what: "the state is shorter than the base and the joints",
            index: NX,
        });
    }
    match spheres.find(|&i| i >= chain.spheres().len()) {
        Some(index) => Err(Error::Chain {
            what: "there is no sphere of this index",
            index,
        }),
        None => Ok(()),
    }
}

macro_rules! clearance {
    ([$($generic:tt)*] $type:ty, |$me:ident| $indices:expr) => {
        impl<$($generic)* const NX: usize, const NU: usize> Constraint<NX, NU> for $type {
            fn name(&self) -> &'static str {
                self.name
            }
            fn barrier(&self) -> Barrier {
                self.barrier
            }
            fn validate(&self) -> Result<(), Error> {
                let $me = self;
                self.barrier.validate()?;
                fits::<NX>(self.chain, $indices)
            }
            fn values(
                &self,
                _: usize,
                x: &SVector<f64, NX>,
                _: Option<&SVector<f64, NU>>,
                visit: &mut dyn FnMut(f64),
            ) {
                visit_rows(self, x, &mut |z, _| visit(z));
            }
            fn rows(
                &self,
                _: usize,
                x: &SVector<f64, NX>,
                _: Option<&SVector<f64, NU>>,
                visit: &mut dyn FnMut(f64, &SVector<f64, NX>, &SVector<f64, NU>),
            ) {
                let none = SVector::zeros();
                visit_rows(self, x, &mut |z, row| visit(z, row, &none));
            }
            fn penalize(
                &self,
                along: &Horizon<'_, NX, NU>,
                models: Option<&mut [Expansion<NX, NU>]>,
            ) -> Penalty {
                if self.chain.spheres().len() <= FEW {
                    dispatch(Batch::<_, NX, NU, FEW> { terms: self, along, models })
                } else {
                    dispatch(Batch::<_, NX, NU, MAX_SPHERES> { terms: self, along, models })
                }
            }
        }
    };
}

clearance!([F: Field,] SphereClearance<'_, F>, |me| me.spheres.iter().copied());
clearance!([] PlaneClearance<'_>, |me| me.spheres.iter().copied());
clearance!([] PairClearance<'_>, |me| me.pairs.iter().flat_map(|&(i, j)| [i, j]));
