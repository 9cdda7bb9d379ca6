//! A small map in memory, for examples, tests and first steps.

use crate::Cell;
use crate::map::{Map, inside};

/// What a cell of a [`Grid`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Never observed: `?`.
    Unknown,
    /// Observed free: `.`.
    Free,
    /// Observed occupied: `#`.
    Occupied,
    /// Occupied and inspected: `+`.
    Inspected,
}

/// A bounded map with one byte a cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grid {
    size: [i32; 3],
    cells: Vec<State>,
}

impl Grid {
    /// An unknown map of `size` cells, at least one on each axis.
    pub fn new(size: [i32; 3]) -> Self {
        let size = size.map(|n| n.max(1));
        let total = size.iter().map(|&n| n as usize).product();
        Self {
            size,
            cells: vec![State::Unknown; total],
        }
    }

    /// Reads layers separated by blank lines, lowest first; in a layer one line per y from 0 up, one character per x:
    /// `?` unknown, `.` free, `#` occupied, `+` inspected. Short lines are filled up with unknown.
    pub fn parse(text: &str) -> Self {
        let layers: Vec<Vec<&str>> = text
            .split("\n\n")
            .map(|layer| layer.lines().collect())
            .collect();
        let nx = layers.iter().flatten().map(|l| l.len()).max().unwrap_or(1);
        let ny = layers.iter().map(Vec::len).max().unwrap_or(1);
        let mut grid = Self::new([nx as i32, ny as i32, layers.len() as i32]);
        for (z, layer) in layers.iter().enumerate() {
            for (y, line) in layer.iter().enumerate() {
                for (x, c) in line.chars().enumerate() {
                    let state = match c {
                        '.' => State::Free,
                        '#' => State::Occupied,
                        '+' => State::Inspected,
                        _ => State::Unknown,
                    };
                    grid.set([x as i32, y as i32, z as i32], state);
                }
            }
        }
        grid
    }

    fn index(&self, cell: Cell) -> Option<usize> {
        inside(cell, ([0; 3], self.size))
            .then(|| ((cell[2] * self.size[1] + cell[1]) * self.size[0] + cell[0]) as usize)
    }

    /// State of a cell; unknown outside.
    pub fn get(&self, cell: Cell) -> State {
        self.index(cell).map_or(State::Unknown, |i| self.cells[i])
    }

    /// Sets a cell; outside nothing happens.
    pub fn set(&mut self, cell: Cell, state: State) {
        if let Some(i) = self.index(cell) {
            self.cells[i] = state;
        }
    }
}

impl Map for Grid {
    fn bounds(&self) -> (Cell, Cell) {
        ([0; 3], self.size)
    }
    fn is_free(&self, cell: Cell) -> bool {
        self.get(cell) == State::Free
    }
    fn is_occupied(&self, cell: Cell) -> bool {
        matches!(self.get(cell), State::Occupied | State::Inspected)
    }
    fn is_inspected(&self, cell: Cell) -> bool {
        self.get(cell) == State::Inspected
    }
}
