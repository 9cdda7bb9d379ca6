//! Arc costs: what the solver must know, a matrix, and an adapter for closures.

use crate::Error;

/// Costs between the nodes `0..len`.
///
/// Laws: [`cost`](Self::cost) depends on its arguments alone and is never NaN. `+infinity` forbids the arc; the
/// diagonal is ignored. The cost from `a` to `b` may differ from the cost back.
pub trait CostModel {
    /// Number of nodes.
    fn len(&self) -> usize;
    /// True if there is no node.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Cost of going from node `from` to node `to`, in any unit, e.g. seconds.
    fn cost(&self, from: usize, to: usize) -> f64;
}

impl<C: CostModel + ?Sized> CostModel for &C {
    fn len(&self) -> usize {
        (**self).len()
    }
    fn cost(&self, from: usize, to: usize) -> f64 {
        (**self).cost(from, to)
    }
}

/// A square matrix of costs, row = tail, column = head.
#[derive(Clone, Debug, PartialEq)]
pub struct CostMatrix {
    len: usize,
    values: Vec<f64>,
}

impl CostMatrix {
    /// Copies rows of equal length.
    ///
    /// # Errors
    /// [`Error::NotSquare`] for a row of another length, [`Error::BadCost`] for NaN or `-infinity` off the diagonal.
    pub fn from_rows<R: AsRef<[f64]>>(rows: &[R]) -> Result<Self, Error> {
        let len = rows.len();
        let mut values = Vec::with_capacity(len * len);
        for (row, costs) in rows.iter().enumerate() {
            let costs = costs.as_ref();
            if costs.len() != len {
                return Err(Error::NotSquare {
                    row,
                    len: costs.len(),
                    nodes: len,
                });
            }
            values.extend_from_slice(costs);
        }
        Self { len, values }.checked()
    }

    /// Copies any cost model.
    ///
    /// # Errors
    /// [`Error::BadCost`] for NaN or `-infinity` off the diagonal.
    pub fn copy_of(model: &impl CostModel) -> Result<Self, Error> {
        let len = model.len();
        let mut values = vec![0.0; len * len];
        for from in 0..len {
            for to in 0..len {
                if from != to {
                    values[from * len + to] = model.cost(from, to);
                }
            }
        }
        Self { len, values }.checked()
    }

    fn checked(mut self) -> Result<Self, Error> {
        for from in 0..self.len {
            for to in 0..self.len {
                let cost = &mut self.values[from * self.len + to];
                if from == to {
                    *cost = 0.0;
                } else if cost.is_nan() || *cost == f64::NEG_INFINITY {
                    return Err(Error::BadCost {
                        from,
                        to,
                        cost: *cost,
                    });
                }
            }
        }
        Ok(self)
    }

    /// Takes `len * len` finite values, row by row.
    #[cfg(feature = "tsplib")]
    pub(crate) fn from_finite(len: usize, mut values: Vec<f64>) -> Self {
        for i in 0..len {
            values[i * len + i] = 0.0;
        }
        Self { len, values }
    }

    /// Sum of the arcs along an order, in order.
    pub fn along(&self, order: &[usize]) -> f64 {
        order.windows(2).map(|arc| self.cost(arc[0], arc[1])).sum()
    }
}

impl CostModel for CostMatrix {
    fn len(&self) -> usize {
        self.len
    }
    #[inline]
    fn cost(&self, from: usize, to: usize) -> f64 {
        self.values[from * self.len + to]
    }
}

/// A closure as a cost model.
#[derive(Clone, Copy, Debug)]
pub struct FromFn<F> {
    len: usize,
    cost: F,
}

impl<F: Fn(usize, usize) -> f64> FromFn<F> {
    /// `cost(from, to)` over the nodes `0..len`.
    pub fn new(len: usize, cost: F) -> Self {
        Self { len, cost }
    }
}

impl<F: Fn(usize, usize) -> f64> CostModel for FromFn<F> {
    fn len(&self) -> usize {
        self.len
    }
    fn cost(&self, from: usize, to: usize) -> f64 {
        (self.cost)(from, to)
    }
}
