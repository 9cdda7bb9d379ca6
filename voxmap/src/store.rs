//! Pages of 64 x 8 x 8 cells: what only observed parts of the map need, shared between clones until written.

use std::sync::Arc;

/// Rows of a page along y and z.
pub(crate) const ROWS: usize = 8;

/// Log-odds of one row of 64 cells.
pub(crate) type LogRow = [i8; 64];
/// Inspected faces of one row of 64 cells, a word a face.
pub(crate) type SeenRow = [u64; 6];

/// Log-odds of a page.
#[derive(Clone, Debug)]
pub(crate) struct LogPage([LogRow; ROWS * ROWS]);
/// Inspected faces of a page.
#[derive(Clone, Debug)]
pub(crate) struct SeenPage([SeenRow; ROWS * ROWS]);

/// A page of rows.
pub(crate) trait Page: Clone {
    type Row;
    fn blank() -> Self;
    fn rows(&self) -> &[Self::Row; ROWS * ROWS];
    fn rows_mut(&mut self) -> &mut [Self::Row; ROWS * ROWS];
}

impl Page for LogPage {
    type Row = LogRow;
    fn blank() -> Self {
        Self([[0; 64]; ROWS * ROWS])
    }
    fn rows(&self) -> &[LogRow; ROWS * ROWS] {
        &self.0
    }
    fn rows_mut(&mut self) -> &mut [LogRow; ROWS * ROWS] {
        &mut self.0
    }
}

impl Page for SeenPage {
    type Row = SeenRow;
    fn blank() -> Self {
        Self([[0; 6]; ROWS * ROWS])
    }
    fn rows(&self) -> &[SeenRow; ROWS * ROWS] {
        &self.0
    }
    fn rows_mut(&mut self) -> &mut [SeenRow; ROWS * ROWS] {
        &mut self.0
    }
}

/// A dense table of pages, most of which may be absent.
#[derive(Clone, Debug)]
pub(crate) struct Pages<P> {
    table: Vec<Option<Arc<P>>>,
    grid: [usize; 3],
}

impl<P: Page> Pages<P> {
    /// No pages, for rows of `words` words and a map of `size` cells.
    pub(crate) fn new(words: usize, size: [usize; 3]) -> Self {
        let grid = [words, size[1].div_ceil(ROWS), size[2].div_ceil(ROWS)];
        Self {
            table: vec![None; grid.iter().product()],
            grid,
        }
    }

    #[inline]
    fn place(&self, w: usize, y: usize, z: usize) -> (usize, usize) {
        let page = (z / ROWS * self.grid[1] + y / ROWS) * self.grid[0] + w;
        (page, z % ROWS * ROWS + y % ROWS)
    }

    /// Row of word `w` of row (y, z), if its page exists.
    #[inline]
    pub(crate) fn get(&self, w: usize, y: usize, z: usize) -> Option<&P::Row> {
        let (page, row) = self.place(w, y, z);
        self.table[page].as_ref().map(|p| &p.rows()[row])
    }

    /// The same to write to, if its page exists.
    #[inline]
    pub(crate) fn get_mut(&mut self, w: usize, y: usize, z: usize) -> Option<&mut P::Row> {
        let (page, row) = self.place(w, y, z);
        self.table[page]
            .as_mut()
            .map(|p| &mut Arc::make_mut(p).rows_mut()[row])
    }

    /// The same; makes the page.
    #[inline]
    pub(crate) fn make(&mut self, w: usize, y: usize, z: usize) -> &mut P::Row {
        let (page, row) = self.place(w, y, z);
        let page = self.table[page].get_or_insert_with(|| Arc::new(P::blank()));
        &mut Arc::make_mut(page).rows_mut()[row]
    }

    /// The same pages in a table of another size, `by` pages further along each axis; pages that fall outside are dropped.
    pub(crate) fn moved(&self, words: usize, size: [usize; 3], by: [isize; 3]) -> Self {
        let mut out = Self::new(words, size);
        for (i, page) in self.table.iter().enumerate() {
            let at = [
                i % self.grid[0],
                i / self.grid[0] % self.grid[1],
                i / self.grid[0] / self.grid[1],
            ];
            let to = [0, 1, 2].map(|a| at[a].wrapping_add_signed(by[a]));
            if page.is_some() && (0..3).all(|a| to[a] < out.grid[a]) {
                out.table[(to[2] * out.grid[1] + to[1]) * out.grid[0] + to[0]].clone_from(page);
            }
        }
        out
    }

    /// Bytes in use.
    pub(crate) fn memory(&self) -> usize {
        // An Arc's two counters stand before its value.
        self.table.capacity() * 8 + self.table.iter().flatten().count() * (size_of::<P>() + 16)
    }
}
