//! Frontier cells in any rectangle of columns, in constant time: the first upper bound.

/// Sums of exploration cells and of what inspection cells count over rectangles of columns.
#[derive(Clone, Debug, Default)]
pub(crate) struct Totals {
    row: usize,
    sums: Vec<[u32; 2]>,
}

impl Totals {
    pub(crate) fn of(size: [usize; 2], words: usize, count: impl Fn(usize) -> [u32; 2]) -> Self {
        let [nx, ny] = size;
        let row = nx + 1;
        let mut sums = vec![[0; 2]; row * (ny + 1)];
        for y in 0..ny {
            let mut line = [0; 2];
            for x in 0..nx {
                let first = (y * nx + x) * words;
                for w in first..first + words {
                    let [exploration, inspection] = count(w);
                    line[0] += exploration;
                    line[1] += inspection;
                }
                let above = sums[y * row + x + 1];
                sums[(y + 1) * row + x + 1] = [above[0] + line[0], above[1] + line[1]];
            }
        }
        Self { row, sums }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.sums.is_empty()
    }

    /// Exploration and inspection cells in a rectangle, both ends inclusive, counted from the
    /// lowest column stored.
    #[inline]
    pub(crate) fn within(&self, low: [usize; 2], high: [usize; 2]) -> [u32; 2] {
        let at = |x: usize, y: usize| self.sums[y * self.row + x];
        let (a, b) = (at(high[0] + 1, high[1] + 1), at(low[0], low[1]));
        let (c, d) = (at(high[0] + 1, low[1]), at(low[0], high[1] + 1));
        [0, 1].map(|n| a[n] + b[n] - c[n] - d[n])
    }
}
