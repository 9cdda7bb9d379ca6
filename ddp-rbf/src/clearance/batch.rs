//! The penalty of a group of clearances along a whole horizon, as many knots at a time as there are lanes.

use super::{CHUNK, Talk, Terms, row};
use crate::barrier::Sum;
use crate::chain::{MAX_STATES, Placed};
use crate::constraint::{Horizon, Penalty};
use crate::cost::Expansion;
use crate::simd::{Kernel, LANES, Vector};

/// The penalty of all knots after the first; the chain has at most `S` spheres.
pub(super) struct Batch<'a, 'm, T, const NX: usize, const NU: usize, const S: usize> {
    pub(super) terms: &'a T,
    pub(super) along: &'a Horizon<'a, NX, NU>,
    pub(super) models: Option<&'m mut [Expansion<NX, NU>]>,
}

impl<T: Terms, const NX: usize, const NU: usize, const S: usize> Kernel
    for Batch<'_, '_, T, NX, NU, S>
{
    type Output = Penalty;
    #[inline(always)]
    fn run<V: Vector>(self) -> Penalty {
        let Self {
            terms,
            along,
            mut models,
        } = self;
        let chain = terms.chain();
        let (last, world, barrier) = (terms.last(), terms.world(), terms.penalty());
        let base_states = chain.base_states();
        let states = base_states + last;
        let n = along.inputs.len();
        let count = terms.len();
        let mut total = Penalty {
            sum: 0.0,
            least: f64::INFINITY,
        };
        let end = V::splat(barrier.cutoff.unwrap_or(f64::INFINITY));
        let mut placed: Placed<V, S> = Placed::new();
        let mut talk = Talk {
            points: [[[0.0; LANES]; 3]; CHUNK],
            answers: [[[0.0; LANES]; 4]; CHUNK],
        };
        let mut at = [V::zero(); MAX_STATES];
        let mut slopes = [V::zero(); MAX_STATES];
        let mut gradient = [V::zero(); NX];
        let mut hessian = [[V::zero(); NX]; NX];
        let mut k = 1;
        while k <= n {
            let lanes = LANES.min(n + 1 - k);
            for i in 0..states {
                let mut row = [0.0; LANES];
                for lane in 0..LANES {
                    // A group that is not full repeats its last knot.
                    row[lane] = along.states[k + lane.min(lanes - 1)][i];
                }
                at[i] = V::load(&row);
                gradient[i] = V::zero();
                for j in 0..=i {
                    hessian[i][j] = V::zero();
                }
            }
            chain.place(&at, last, world, &mut placed);
            let mut sum: Sum<V> = Sum::new(&barrier, along.weight);
            let mut from = MAX_STATES;
            for i in 0..count {
                if i % CHUNK == 0 {
                    terms.ask(&placed, i, &mut talk);
                }
                let Some(term) = terms.term(&placed, i, &talk.answers[i % CHUNK]) else {
                    continue;
                };
                if models.is_none() || end.all_less(term.z) {
                    sum.add_value(term.z);
                    continue;
                }
                let (slope, curvature) = sum.add(term.z);
                let start = row(&term, &placed, base_states, &mut slopes);
                from = from.min(start);
                for j in start..base_states + term.last {
                    gradient[j] = slope.mul_add(slopes[j], gradient[j]);
                    let bent = curvature * slopes[j];
                    for i in start..=j {
                        hessian[j][i] = bent.mul_add(slopes[i], hessian[j][i]);
                    }
                }
            }
            let (value, least) = sum.finish();
            let (value, least) = (value.array(), least.array());
            for lane in 0..lanes {
                total.sum += value[lane];
                total.least = total.least.min(least[lane]);
            }
            if let Some(models) = &mut models
                && from < states
            {
                let models = &mut models[k..k + lanes];
                add_models(&gradient, &hessian, from, states, models);
            }
            k += LANES;
        }
        total
    }
}

/// Adds gradients and Hessians (lower triangles) of the states `from..states`, lanes to knots.
#[inline(always)]
fn add_models<V: Vector, const NX: usize, const NU: usize>(
    gradient: &[V; NX],
    hessian: &[[V; NX]; NX],
    from: usize,
    states: usize,
    models: &mut [Expansion<NX, NU>],
) {
    let mut rest = from;
    if NX >= LANES {
        // As many states as there are lanes at a time: after a transposition each knot's share is contiguous. The block may
        // take in states before `from`, to which it adds zero.
        let start = from.min(NX - LANES);
        rest = states.min(start + LANES);
        let mut rows = [V::zero(); LANES];
        rows[from - start..rest - start].copy_from_slice(&gradient[from..rest]);
        let rows = V::transpose(rows);
        for (model, row) in models.iter_mut().zip(rows) {
            add_to(&mut model.x.as_mut_slice()[start..], row);
        }
        for j in from..states {
            let mut rows = [V::zero(); LANES];
            for i in from..rest {
                rows[i - start] = hessian[j.max(i)][j.min(i)];
            }
            let rows = V::transpose(rows);
            for (model, row) in models.iter_mut().zip(rows) {
                add_to(&mut model.xx.as_mut_slice()[j * NX + start..], row);
            }
        }
    }
    for i in rest..states {
        let slopes = gradient[i].array();
        for (model, slope) in models.iter_mut().zip(slopes) {
            model.x[i] += slope;
        }
        for j in from..states {
            let bends = hessian[j.max(i)][j.min(i)].array();
            for (model, bend) in models.iter_mut().zip(bends) {
                model.xx[(i, j)] += bend;
            }
        }
    }
}

/// Adds to the first [`LANES`] entries.
#[inline(always)]
fn add_to<V: Vector>(entries: &mut [f64], row: V) {
    if let Some(to) = entries.first_chunk_mut::<LANES>() {
        (V::load(to) + row).store(to);
    }
}
