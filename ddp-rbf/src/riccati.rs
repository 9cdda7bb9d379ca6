//! The backward pass: a Riccati recursion that eliminates the inputs knot by knot, rows as vectors of four.
//!
//! Value function of a knot: `1/2 dx' V dx + v' dx`, held as the rows of `[V | v]`. The zeros of `A - I` and `B` are found
//! first, over all knots at once, so that integrators cost next to nothing.

use crate::cost::Expansion;
use crate::robot::Linear;
use crate::simd::{Kernel, NARROW as LANES, Vector, dispatch};
use nalgebra::{SMatrix, SVector};

/// Blocks of four in a row: at most 31 states and 32 inputs take this path.
const BLOCKS: usize = 8;

/// Four entries of a row, aligned for vector loads.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Block([f64; LANES]);

type Row = [Block; BLOCKS];
const EMPTY: Row = [Block([0.0; LANES]); BLOCKS];

#[inline(always)]
fn at(row: &Row, j: usize) -> f64 {
    row[j / LANES].0[j % LANES]
}

/// What a knot's input should do: `u = u_k + feedforward + feedback dx`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Policy<const NX: usize, const NU: usize> {
    pub(crate) feedforward: SVector<f64, NU>,
    pub(crate) feedback: SMatrix<f64, NU, NX>,
}

/// Linear and quadratic part of the expected change of the objective for a full step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Expected {
    pub(crate) linear: f64,
    pub(crate) quadratic: f64,
}

/// Where `A - I` and `B` are not zero at some knot, and whether inputs and states are coupled in the cost.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pattern {
    a: Vec<(u8, u8)>,
    b: Vec<(u8, u8)>,
    /// (row of A - I, block of columns).
    a_blocks: Vec<(u8, u8)>,
    b_blocks: Vec<(u8, u8)>,
    coupled: bool,
    /// Some state is both a row and a column of A - I.
    crossing: bool,
}

impl Pattern {
    /// Room for every entry, so that no solve allocates.
    pub(crate) fn with_capacity(nx: usize, nu: usize) -> Self {
        Self {
            a: Vec::with_capacity(nx * nx),
            b: Vec::with_capacity(nx * nu),
            a_blocks: Vec::with_capacity(nx * nx.div_ceil(LANES)),
            b_blocks: Vec::with_capacity(nx * nu.div_ceil(LANES)),
            coupled: false,
            crossing: false,
        }
    }

    /// Whether some mixed second derivative was not zero.
    pub(crate) fn coupled(&self) -> bool {
        self.coupled
    }

    /// Looks through all knots.
    pub(crate) fn find<const NX: usize, const NU: usize>(
        &mut self,
        linear: &[Linear<NX, NU>],
        models: &[Expansion<NX, NU>],
    ) {
        let (mut a, mut b) = (
            SMatrix::<u64, NX, NX>::zeros(),
            SMatrix::<u64, NX, NU>::zeros(),
        );
        let mut ux = SMatrix::<u64, NU, NX>::zeros();
        dispatch(Scan {
            linear,
            models,
            a: a.as_mut_slice(),
            b: b.as_mut_slice(),
            ux: ux.as_mut_slice(),
        });
        self.coupled = ux.iter().any(|&v| v != 0);
        collect(&a, &mut self.a, &mut self.a_blocks);
        collect(&b, &mut self.b, &mut self.b_blocks);
        let is_row = |j: u8| self.a.iter().any(|&(i, _)| i == j);
        self.crossing = self.a.iter().any(|&(_, j)| is_row(j));
    }
}

/// Bits that are set at any knot, signs aside, in `A` less those of the identity, in `B` and in mixed second derivatives: none
/// where all are zero.
struct Scan<'a, const NX: usize, const NU: usize> {
    linear: &'a [Linear<NX, NU>],
    models: &'a [Expansion<NX, NU>],
    a: &'a mut [u64],
    b: &'a mut [u64],
    ux: &'a mut [u64],
}

impl<const NX: usize, const NU: usize> Kernel for Scan<'_, NX, NU> {
    type Output = ();
    #[inline(always)]
    fn run<V: Vector>(self) {
        let one = SMatrix::<f64, NX, NX>::identity();
        for l in self.linear {
            let entries = l.a.as_slice().iter().zip(one.as_slice());
            for (bits, (v, one)) in self.a.iter_mut().zip(entries) {
                *bits |= (v.to_bits() ^ one.to_bits()) << 1;
            }
            for (bits, v) in self.b.iter_mut().zip(l.b.as_slice()) {
                *bits |= v.to_bits() << 1;
            }
        }
        for m in self.models {
            for (bits, v) in self.ux.iter_mut().zip(m.ux.as_slice()) {
                *bits |= v.to_bits() << 1;
            }
        }
    }
}

fn collect<const R: usize, const C: usize>(
    bits: &SMatrix<u64, R, C>,
    entries: &mut Vec<(u8, u8)>,
    blocks: &mut Vec<(u8, u8)>,
) {
    entries.clear();
    blocks.clear();
    for i in 0..R {
        for j in 0..C {
            if bits[(i, j)] != 0 {
                entries.push((i as u8, j as u8));
                let block = (i as u8, (j / LANES) as u8);
                if blocks.last() != Some(&block) {
                    blocks.push(block);
                }
            }
        }
    }
}

/// True for sizes that [`Backward`] can take.
pub(crate) const fn fits(nx: usize, nu: usize) -> bool {
    nx < BLOCKS * LANES && nu <= BLOCKS * LANES
}

/// The whole backward pass; `None` if an input Hessian is not positive definite.
pub(crate) struct Backward<'a, const NX: usize, const NU: usize> {
    pub(crate) linear: &'a [Linear<NX, NU>],
    pub(crate) models: &'a [Expansion<NX, NU>],
    pub(crate) gaps: &'a [SVector<f64, NX>],
    /// False if all gaps are zero.
    pub(crate) open: bool,
    pub(crate) pattern: &'a Pattern,
    pub(crate) regularization: f64,
    pub(crate) policies: &'a mut [Policy<NX, NU>],
}

/// Blocks `4 b .. 4 b + 4` of row `i` of a column-major matrix.
#[inline(always)]
fn row_block<const R: usize, const C: usize>(
    m: &SMatrix<f64, R, C>,
    i: usize,
    b: usize,
) -> [f64; LANES] {
    std::array::from_fn(|l| {
        let j = b * LANES + l;
        if j < C { m[(i, j)] } else { 0.0 }
    })
}

/// to += from * factor over the first `n` blocks.
#[inline(always)]
fn add_scaled<V: Vector<LANES>>(to: &mut Row, from: &Row, factor: f64, first: usize, n: usize) {
    let factor = V::splat(factor);
    for c in first..n {
        let sum = V::load(&from[c].0).mul_add(factor, V::load(&to[c].0));
        sum.store(&mut to[c].0);
    }
}

impl<const NX: usize, const NU: usize> Kernel<LANES> for Backward<'_, NX, NU> {
    type Output = Option<Expected>;

    #[inline(always)]
    fn run<V: Vector<LANES>>(self) -> Option<Expected> {
        let (nb, mb) = (
            const { (NX + 1).div_ceil(LANES) },
            const { NU.div_ceil(LANES) },
        );
        let n = self.linear.len();
        let mut expected = Expected {
            linear: 0.0,
            quadratic: 0.0,
        };
        // Rows [V | v] of the value function; column NX is the gradient.
        let mut value = [EMPTY; NX];
        let last = &self.models[n];
        for i in 0..NX {
            for j in 0..NX {
                value[i][j / LANES].0[j % LANES] = last.xx[(j, i)];
            }
            value[i][NX / LANES].0[NX % LANES] = last.x[i];
        }
        let mut mixed = [EMPTY; NU];
        let mut inputs = [EMPTY; NU];
        let (mut before, mut before_mixed) = ([EMPTY; NX], [EMPTY; NU]);
        let crossing = self.pattern.crossing;
        for k in (0..n).rev() {
            let (linear, model) = (&self.linear[k], &self.models[k]);
            if self.open {
                // The gap shifts where the next knot's model is looked at.
                let gap = &self.gaps[k];
                let mut shift = [0.0; NX];
                for i in 0..NX {
                    expected.linear += at(&value[i], NX) * gap[i];
                    for j in 0..NX {
                        shift[i] += at(&value[i], j) * gap[j];
                    }
                    expected.quadratic += shift[i] * gap[i];
                }
                for i in 0..NX {
                    value[i][NX / LANES].0[NX % LANES] += shift[i];
                }
            }
            // [B' V | B' v], then times A: [Qux | qu].
            for row in &mut mixed {
                row[..nb].fill(Block([0.0; LANES]));
            }
            for &(i, j) in &self.pattern.b {
                let (i, j) = (usize::from(i), usize::from(j));
                add_scaled::<V>(&mut mixed[j], &value[i], linear.b[(i, j)], 0, nb);
            }
            // Quu = Luu + B'V B, before A changes the rows.
            for j in 0..NU {
                for c in 0..mb {
                    inputs[j][c] = Block(row_block(&model.uu, j, c));
                }
                inputs[j][j / LANES].0[j % LANES] += self.regularization;
            }
            for &(i, c) in &self.pattern.b_blocks {
                let (i, c) = (usize::from(i), usize::from(c));
                let row = V::load(&row_block(&linear.b, i, c));
                // Only what the elimination reads: from the diagonal to the right.
                for j in 0..NU.min((c + 1) * LANES) {
                    let to = &mut inputs[j][c].0;
                    V::splat(at(&mixed[j], i))
                        .mul_add(row, V::load(to))
                        .store(to);
                }
            }
            // V <- A' V, with its gradient, then both times A. In place, unless A - I feeds a state that it also reads.
            if crossing {
                before = value;
            }
            for &(i, j) in &self.pattern.a {
                let (i, j) = (usize::from(i), usize::from(j));
                let factor = linear.a[(i, j)] - f64::from(u8::from(i == j));
                let row = if crossing { before[i] } else { value[i] };
                add_scaled::<V>(&mut value[j], &row, factor, 0, nb);
            }
            if crossing {
                (before, before_mixed) = (value, mixed);
            }
            for &(i, c) in &self.pattern.a_blocks {
                let (i, c) = (usize::from(i), usize::from(c));
                let mut entries = row_block(&linear.a, i, c);
                if i / LANES == c {
                    entries[i % LANES] -= 1.0;
                }
                let row = V::load(&entries);
                for r in 0..NX {
                    let factor = at(if crossing { &before[r] } else { &value[r] }, i);
                    let to = &mut value[r][c].0;
                    V::splat(factor).mul_add(row, V::load(to)).store(to);
                }
                for r in 0..NU {
                    let factor = at(
                        if crossing {
                            &before_mixed[r]
                        } else {
                            &mixed[r]
                        },
                        i,
                    );
                    let to = &mut mixed[r][c].0;
                    V::splat(factor).mul_add(row, V::load(to)).store(to);
                }
            }
            // Costs of this knot.
            for i in 0..NX {
                for c in 0..NX / LANES {
                    let entries: &[f64; LANES] =
                        &std::array::from_fn(|l| model.xx[(c * LANES + l, i)]);
                    let to = &mut value[i][c].0;
                    (V::load(entries) + V::load(to)).store(to);
                }
                let c = NX / LANES;
                let entries: &[f64; LANES] = &std::array::from_fn(|l| {
                    let j = c * LANES + l;
                    if j < NX {
                        model.xx[(j, i)]
                    } else if j == NX {
                        model.x[i]
                    } else {
                        0.0
                    }
                });
                let to = &mut value[i][c].0;
                (V::load(entries) + V::load(to)).store(to);
            }
            for j in 0..NU {
                if self.pattern.coupled {
                    for i in 0..NX {
                        mixed[j][i / LANES].0[i % LANES] += model.ux[(j, i)];
                    }
                }
                mixed[j][NX / LANES].0[NX % LANES] += model.u[j];
            }
            // Right-looking elimination of [Quu | Qux qu]; the rows stay as D L' and its right-hand sides.
            let mut inverse = [0.0; NU];
            for p in 0..NU {
                let pivot = at(&inputs[p], p);
                if !(pivot > 0.0 && pivot.is_finite()) {
                    return None;
                }
                inverse[p] = 1.0 / pivot;
                let (head, tail) = inputs.split_at_mut(p + 1);
                let (mixed_head, mixed_tail) = mixed.split_at_mut(p + 1);
                let (pivot_row, pivot_mixed) = (&head[p], &mixed_head[p]);
                for (j, (row, right)) in tail.iter_mut().zip(mixed_tail).enumerate() {
                    let j = p + 1 + j;
                    let factor = -at(pivot_row, j) * inverse[p];
                    add_scaled::<V>(row, pivot_row, factor, j / LANES, mb);
                    add_scaled::<V>(right, pivot_mixed, factor, 0, nb);
                }
            }
            // V <- Qxx - Y' D^-1 Y with its gradient.
            for i in 0..NX {
                let mut sums = [V::zero(); BLOCKS];
                for c in 0..nb {
                    sums[c] = V::load(&value[i][c].0);
                }
                for p in 0..NU {
                    let factor = V::splat(at(&mixed[p], i) * inverse[p]);
                    for c in 0..nb {
                        sums[c] = factor.neg_mul_add(V::load(&mixed[p][c].0), sums[c]);
                    }
                }
                for c in 0..nb {
                    sums[c].store(&mut value[i][c].0);
                }
            }
            let mut gained = 0.0;
            for p in 0..NU {
                let y = at(&mixed[p], NX);
                gained += y * y * inverse[p];
            }
            if !gained.is_finite() {
                return None;
            }
            expected.linear -= gained;
            expected.quadratic += gained;
            // Back substitution: K = -L'^-1 D^-1 [Y | y].
            for p in (0..NU).rev() {
                let scale = V::splat(-inverse[p]);
                let mut sums = [V::zero(); BLOCKS];
                for c in 0..nb {
                    sums[c] = V::load(&mixed[p][c].0) * scale;
                }
                for j in p + 1..NU {
                    let factor = V::splat(at(&inputs[p], j) * -inverse[p]);
                    for c in 0..nb {
                        sums[c] = factor.mul_add(V::load(&mixed[j][c].0), sums[c]);
                    }
                }
                for c in 0..nb {
                    sums[c].store(&mut mixed[p][c].0);
                }
            }
            let policy = &mut self.policies[k];
            for i in 0..NX {
                for j in 0..NU {
                    policy.feedback[(j, i)] = at(&mixed[j], i);
                }
            }
            for j in 0..NU {
                policy.feedforward[j] = at(&mixed[j], NX);
            }
        }
        Some(expected)
    }
}

/// The same with dense matrices, for sizes beyond [`fits`].
#[cfg(not(feature = "faer"))]
pub(crate) fn backward_dense<const NX: usize, const NU: usize>(
    linear: &[Linear<NX, NU>],
    models: &[Expansion<NX, NU>],
    gaps: &[SVector<f64, NX>],
    regularization: f64,
    policies: &mut [Policy<NX, NU>],
) -> Option<Expected> {
    let n = linear.len();
    let (mut vx, mut vxx) = (models[n].x, models[n].xx);
    let mut expected = Expected {
        linear: 0.0,
        quadratic: 0.0,
    };
    for k in (0..n).rev() {
        let (l, model, gap) = (&linear[k], &models[k], &gaps[k]);
        let pull = vxx * gap;
        let shifted = vx + pull;
        expected.linear += vx.dot(gap);
        expected.quadratic += gap.dot(&pull);
        let pa = vxx * l.a;
        let pb = vxx * l.b;
        let qx = model.x + l.a.tr_mul(&shifted);
        let qu = model.u + l.b.tr_mul(&shifted);
        let qxx = model.xx + l.a.tr_mul(&pa);
        let qux = model.ux + l.b.tr_mul(&pa);
        let mut quu = model.uu + l.b.tr_mul(&pb);
        for i in 0..NU {
            quu[(i, i)] += regularization;
        }
        let factor = quu.cholesky()?;
        let policy = &mut policies[k];
        policy.feedforward = -factor.solve(&qu);
        policy.feedback = -factor.solve(&qux);
        let gained = -qu.dot(&policy.feedforward);
        if !gained.is_finite() {
            return None;
        }
        expected.linear -= gained;
        expected.quadratic += gained;
        vx = qx + qux.tr_mul(&policy.feedforward);
        vxx = qxx + qux.tr_mul(&policy.feedback);
        vxx = (vxx + vxx.transpose()) * 0.5;
    }
    Some(expected)
}
