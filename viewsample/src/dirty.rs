//! Where the map or the frontiers changed in one update, in blocks of columns.

/// Columns on a block's side, as a power of two.
const SHIFT: usize = 2;

/// Blocks of columns that changed, with counts over rectangles in constant time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Dirty {
    size: [usize; 2],
    flags: Vec<bool>,
    sums: Vec<u32>,
}

impl Dirty {
    pub(crate) fn new(columns: [usize; 2]) -> Self {
        let size = columns.map(|n| n.div_ceil(1 << SHIFT));
        Self {
            size,
            flags: vec![false; size[0] * size[1]],
            sums: vec![0; (size[0] + 1) * (size[1] + 1)],
        }
    }

    pub(crate) fn clear(&mut self) {
        self.flags.fill(false);
    }

    pub(crate) fn mark_all(&mut self) {
        self.flags.fill(true);
    }

    #[inline]
    pub(crate) fn mark(&mut self, column: [usize; 2]) {
        self.flags[(column[1] >> SHIFT) * self.size[0] + (column[0] >> SHIFT)] = true;
    }

    /// Sums up after the last mark.
    pub(crate) fn close(&mut self) {
        let (nx, row) = (self.size[0], self.size[0] + 1);
        for y in 0..self.size[1] {
            let mut line = 0;
            for x in 0..nx {
                line += u32::from(self.flags[y * nx + x]);
                self.sums[(y + 1) * row + x + 1] = self.sums[y * row + x + 1] + line;
            }
        }
    }

    /// True if nothing changed.
    pub(crate) fn is_empty(&self) -> bool {
        self.sums.last().is_none_or(|n| *n == 0)
    }

    /// True if something changed in a rectangle of columns, counted from the lowest stored.
    #[inline]
    pub(crate) fn touches(&self, low: [usize; 2], high: [usize; 2]) -> bool {
        let row = self.size[0] + 1;
        let (x0, y0) = (low[0] >> SHIFT, low[1] >> SHIFT);
        let (x1, y1) = ((high[0] >> SHIFT) + 1, (high[1] >> SHIFT) + 1);
        let s = &self.sums;
        s[y1 * row + x1] + s[y0 * row + x0] != s[y0 * row + x1] + s[y1 * row + x0]
    }
}
