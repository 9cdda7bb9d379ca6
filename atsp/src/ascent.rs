//! Held and Karp's bound for the asymmetric problem: prices for leaving each node, raised until the cheapest
//! 1-arborescence leaves every node about once.
//!
//! Subgradient ascent from the assignment's prices, so the bound begins at the assignment's; its limit is the bound of the
//! linear program with all subtour inequalities.

use crate::arborescence::Arborescence;
use crate::closed::Closed;

/// Workspace and answer.
#[derive(Debug, Default)]
pub(crate) struct Ascent {
    tree: Arborescence,
    price: Vec<f64>,
    best: Vec<f64>,
    push: Vec<f64>,
}

impl Ascent {
    /// Raises the bound for so many steps, or until it is within `slack` of `target`, the cost of a known tour, or `stop`.
    /// The bound.
    pub(crate) fn run(
        &mut self,
        closed: &Closed,
        prices: &[f64],
        steps: u32,
        target: f64,
        slack: f64,
        stop: &mut dyn FnMut() -> bool,
    ) -> f64 {
        let n = closed.n;
        self.price.clear();
        self.price.extend_from_slice(prices);
        self.best.clear();
        self.best.extend_from_slice(prices);
        self.push.clear();
        self.push.resize(n, 0.0);
        let mut best = f64::NEG_INFINITY;
        let mut stride = 1.0;
        let mut since = 0;
        for _ in 0..steps.max(1) {
            let bound =
                self.tree.solve(n, &closed.costs, &self.price) + self.price.iter().sum::<f64>();
            if bound > best {
                best = bound;
                self.best.copy_from_slice(&self.price);
                since = 0;
            } else {
                since += 1;
                if since >= 8 {
                    since = 0;
                    stride *= 0.6;
                    self.price.copy_from_slice(&self.best);
                }
            }
            if best >= target - slack || stop() {
                break;
            }
            // Most of the last directions damps the zigzag.
            let mut square = 0.0;
            for (push, &degree) in self.push.iter_mut().zip(&self.tree.degree) {
                *push = 0.3 * (1.0 - f64::from(degree)) + 0.7 * *push;
                square += *push * *push;
            }
            if square < 1e-12 {
                break;
            }
            let step = stride * (target - bound).max(slack) / square;
            for (price, push) in self.price.iter_mut().zip(&self.push) {
                *price += step * push;
            }
        }
        best
    }

    /// Writes what the best prices leave of each cost; the bound again, with the same rounding as what is left.
    pub(crate) fn residual(&mut self, closed: &Closed, left: &mut [f64]) -> f64 {
        let tree = self.tree.solve(closed.n, &closed.costs, &self.best);
        self.tree.residual(&closed.costs, &self.best, left);
        tree + self.best.iter().sum::<f64>()
    }
}
