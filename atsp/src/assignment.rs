//! The assignment problem: the cheapest set of cycles through all nodes, a lower bound of every closed tour.
//!
//! Jonker and Volgenant, "A shortest augmenting path algorithm for dense and sparse linear assignment problems",
//! Computing 38 (1987): column reduction, reduction transfer, two passes of augmenting row reduction, then shortest
//! augmenting paths. All four find prices with `costs[i][j] >= u[i] + v[j]` and equality on the assignment.

pub(crate) const FREE: u32 = u32::MAX;

/// Workspace and answer.
#[derive(Debug, Default)]
pub(crate) struct Assignment {
    len: usize,
    /// Successor of each node.
    pub(crate) next: Vec<u32>,
    /// Predecessor of each node.
    pub(crate) previous: Vec<u32>,
    /// Price of leaving each node.
    pub(crate) u: Vec<f64>,
    /// Price of entering each node.
    pub(crate) v: Vec<f64>,
    free: Vec<u32>,
    reach: Vec<f64>,
    from: Vec<u32>,
    columns: Vec<u32>,
}

impl Assignment {
    /// Solves; `None` when `stop`, told of the steps of work since it was last asked, said so. O(n^3).
    ///
    /// `costs` is row-major, `n` by `n`, finite and at least zero; the diagonal holds something prohibitive.
    pub(crate) fn solve(
        &mut self,
        n: usize,
        costs: &[f64],
        stop: &mut dyn FnMut(usize) -> bool,
    ) -> Option<f64> {
        self.len = n;
        if self.reduce_columns(costs, stop) || self.transfer(costs, stop) {
            return None;
        }
        for _ in 0..2 {
            if self.reduce_rows(costs, stop) {
                return None;
            }
        }
        self.reach.clear();
        self.reach.resize(n, 0.0);
        self.from.clear();
        self.from.resize(n, 0);
        let free = std::mem::take(&mut self.free);
        let mut stopped = false;
        for &row in &free {
            let scans = self.augment(costs, row as usize);
            stopped = stop(4 * n * scans);
            if stopped {
                break;
            }
        }
        self.free = free;
        if stopped {
            return None;
        }
        self.u.clear();
        self.u.resize(n, 0.0);
        let mut sum = 0.0;
        for i in 0..n {
            let j = self.next[i] as usize;
            let cost = costs[i * n + j];
            self.u[i] = cost - self.v[j];
            sum += cost;
        }
        Some(sum)
    }

    /// Each column's price is its lowest cost; each row takes one of the columns whose lowest cost it holds.
    fn reduce_columns(&mut self, costs: &[f64], stop: &mut dyn FnMut(usize) -> bool) -> bool {
        let n = self.len;
        self.v.clear();
        self.v.resize(n, f64::INFINITY);
        // `previous` first holds the row of each column's lowest cost.
        self.previous.clear();
        self.previous.resize(n, FREE);
        for i in 0..n {
            let row = &costs[i * n..(i + 1) * n];
            for ((v, lowest), &cost) in self.v.iter_mut().zip(&mut self.previous).zip(row) {
                if cost < *v {
                    *v = cost;
                    *lowest = i as u32;
                }
            }
            if stop(n) {
                return true;
            }
        }
        self.next.clear();
        self.next.resize(n, FREE);
        self.columns.clear();
        self.columns.resize(n, 0);
        // `columns` counts the columns each row could have taken.
        for j in (0..n).rev() {
            let i = self.previous[j] as usize;
            self.columns[i] += 1;
            if self.next[i] == FREE {
                self.next[i] = j as u32;
            } else {
                self.previous[j] = FREE;
            }
        }
        false
    }

    /// A row with one column gives up what it can of that column's price, for the free rows to bid with.
    fn transfer(&mut self, costs: &[f64], stop: &mut dyn FnMut(usize) -> bool) -> bool {
        let n = self.len;
        self.free.clear();
        for i in 0..n {
            let mine = self.next[i];
            if mine == FREE {
                self.free.push(i as u32);
            } else if self.columns[i] == 1 {
                let row = &costs[i * n..(i + 1) * n];
                let mut least = f64::INFINITY;
                for j in 0..n {
                    let reduced = row[j] - self.v[j];
                    if reduced < least && j as u32 != mine {
                        least = reduced;
                    }
                }
                if least < f64::INFINITY {
                    self.v[mine as usize] -= least;
                }
                if stop(n) {
                    return true;
                }
            }
        }
        false
    }

    /// Each free row takes its cheapest column and pushes the column's price down to its second cheapest.
    fn reduce_rows(&mut self, costs: &[f64], stop: &mut dyn FnMut(usize) -> bool) -> bool {
        let n = self.len;
        let count = self.free.len();
        let (mut k, mut kept) = (0, 0);
        // Rounding may let two rows bid for ever; what is left is the augmenting paths' work.
        let mut bids = n;
        while k < count {
            let i = self.free[k] as usize;
            k += 1;
            if stop(n) {
                return true;
            }
            let row = &costs[i * n..(i + 1) * n];
            let (mut first, mut second) = (f64::INFINITY, f64::INFINITY);
            let (mut j1, mut j2) = (0, 0);
            for (j, (&cost, &v)) in row.iter().zip(&self.v).enumerate() {
                let reduced = cost - v;
                if reduced < second {
                    if reduced < first {
                        (second, j2) = (first, j1);
                        (first, j1) = (reduced, j);
                    } else {
                        (second, j2) = (reduced, j);
                    }
                }
            }
            let mut column = j1;
            let mut owner = self.previous[column];
            let gap = second - first;
            if gap > 0.0 && gap < f64::INFINITY {
                self.v[j1] -= gap;
            } else if owner != FREE && second < f64::INFINITY {
                column = j2;
                owner = self.previous[column];
            }
            self.next[i] = column as u32;
            self.previous[column] = i as u32;
            if owner != FREE {
                self.next[owner as usize] = FREE;
                bids = bids.saturating_sub(1);
                if gap > 0.0 && bids > 0 {
                    k -= 1;
                    self.free[k] = owner;
                } else {
                    self.free[kept] = owner;
                    kept += 1;
                }
            }
        }
        self.free.truncate(kept);
        false
    }

    /// Dijkstra over reduced costs from a free row to the nearest free column; the number of rows scanned.
    ///
    /// `columns` is split into: prices final `[..ready]`, all of the current distance, not yet scanned `[ready..low]`,
    /// the rest.
    pub(crate) fn augment(&mut self, costs: &[f64], root: usize) -> usize {
        let n = self.len;
        let row = &costs[root * n..(root + 1) * n];
        for j in 0..n {
            self.reach[j] = row[j] - self.v[j];
            self.from[j] = root as u32;
            self.columns[j] = j as u32;
        }
        let (mut low, mut scanned, mut last) = (0, 0, 0);
        let mut distance = 0.0;
        let mut scans = 1;
        let sink = 'search: loop {
            if scanned == low {
                // The next distance: all columns that have it go to the front.
                last = low;
                distance = self.reach[self.columns[low] as usize];
                low += 1;
                let rest = low;
                for k in rest..n {
                    let j = self.columns[k] as usize;
                    let reach = self.reach[j];
                    if reach <= distance {
                        if reach < distance {
                            low = last;
                            distance = reach;
                        }
                        self.columns.swap(k, low);
                        low += 1;
                    }
                }
                for k in last..low {
                    let j = self.columns[k] as usize;
                    if self.previous[j] == FREE {
                        break 'search j;
                    }
                }
            }
            let j1 = self.columns[scanned] as usize;
            scanned += 1;
            let i = self.previous[j1] as usize;
            scans += 1;
            let row = &costs[i * n..(i + 1) * n];
            let base = row[j1] - self.v[j1] - distance;
            let rest = low;
            for k in rest..n {
                let j = self.columns[k] as usize;
                let reach = row[j] - self.v[j] - base;
                if reach < self.reach[j] {
                    self.from[j] = i as u32;
                    if reach <= distance {
                        if self.previous[j] == FREE {
                            self.reach[j] = reach;
                            break 'search j;
                        }
                        self.columns.swap(k, low);
                        low += 1;
                    }
                    self.reach[j] = reach;
                }
            }
        };
        for k in 0..last {
            let j = self.columns[k] as usize;
            self.v[j] += self.reach[j] - distance;
        }
        let mut j = sink;
        loop {
            let i = self.from[j] as usize;
            self.previous[j] = i as u32;
            let before = self.next[i];
            self.next[i] = j as u32;
            if i == root {
                return scans;
            }
            j = before as usize;
        }
    }
}
