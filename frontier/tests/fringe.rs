//! FLAP's frontier cells against their definition.
#![allow(missing_docs, clippy::unwrap_used)]

use frontier::grid::{Grid, State};
use frontier::{Fringe, Map};
use proptest::prelude::*;

const SIZE: [i32; 3] = [7, 6, 5];

fn grids() -> impl Strategy<Value = Grid> {
    let state =
        prop_oneof![2 => Just(State::Unknown), 2 => Just(State::Free), 1 => Just(State::Occupied)];
    prop::collection::vec(state, 7 * 6 * 5).prop_map(|states| {
        let mut grid = Grid::new(SIZE);
        for (cell, state) in all().zip(states) {
            grid.set(cell, state);
        }
        grid
    })
}

fn all() -> impl Iterator<Item = [i32; 3]> {
    (0..SIZE[2]).flat_map(|z| (0..SIZE[1]).flat_map(move |y| (0..SIZE[0]).map(move |x| [x, y, z])))
}

fn beside(c: [i32; 3]) -> [[i32; 3]; 6] {
    let [x, y, z] = c;
    [
        [x - 1, y, z],
        [x + 1, y, z],
        [x, y - 1, z],
        [x, y + 1, z],
        [x, y, z - 1],
        [x, y, z + 1],
    ]
}

proptest! {
    /// The frontier is the unknown cells next to free ones.
    #[test]
    fn frontier_cells_are_unknown_next_to_free(grid in grids()) {
        let fringe = Fringe::new(&grid);
        let wanted: Vec<_> = all()
            .filter(|&c| grid.get(c) == State::Unknown && beside(c).iter().any(|&n| grid.is_free(n)))
            .collect();
        prop_assert_eq!(fringe.cells().collect::<Vec<_>>(), wanted.clone());
        prop_assert_eq!(fringe.len(), wanted.len());
        prop_assert!(wanted.iter().all(|&c| fringe.contains(c)));
    }

    /// Told of the changed cells, it equals a search from scratch.
    #[test]
    fn updates_equal_a_search_from_scratch(grid in grids(), other in grids(), keep in prop::collection::vec(any::<bool>(), 210)) {
        let mut fringe = Fringe::new(&grid);
        let mut now = grid;
        let mut changed = Vec::new();
        for (cell, keep) in all().zip(keep) {
            if !keep {
                now.set(cell, other.get(cell));
                changed.push(cell);
            }
        }
        fringe.update(&now, changed);
        prop_assert_eq!(fringe, Fringe::new(&now));
    }

    /// Targets of a volume: its frontier cells, and unknown cells on its faces with an unknown neighbour outside.
    #[test]
    fn targets_follow_their_definition(grid in grids(), a in prop::array::uniform3(0..5i32), b in prop::array::uniform3(1..4i32)) {
        let high = [0, 1, 2].map(|i| (a[i] + b[i]).min(SIZE[i]));
        let inside = |c: [i32; 3]| (0..3).all(|i| a[i] <= c[i] && c[i] < high[i]);
        let fringe = Fringe::new(&grid);
        let wanted: Vec<_> = all()
            .filter(|&c| inside(c) && grid.get(c) == State::Unknown)
            .filter(|&c| beside(c).iter().any(|&n| grid.is_free(n) || (!inside(n) && grid.get(n) == State::Unknown)))
            .collect();
        prop_assert_eq!(fringe.targets(&grid, (a, high)), wanted);
    }
}

#[test]
fn enclosed_volumes_have_their_faces_as_targets() {
    let map = Grid::new([7, 7, 7]);
    let fringe = Fringe::new(&map);
    assert!(fringe.is_empty());
    // All of a 3 x 3 x 3 box but its middle.
    assert_eq!(fringe.targets(&map, ([2; 3], [5; 3])).len(), 26);
    // Outside the box counts as the side to look from: straight away from a face's middle.
    let inside = |c: [i32; 3]| (0..3).all(|i| (2..5).contains(&c[i]));
    let normal = Fringe::normal(&map, [2, 3, 3], inside).unwrap();
    assert!(normal[0] < 0.0 && normal[1].abs() < 1e-12 && normal[2].abs() < 1e-12);
}

#[test]
fn normals_point_from_unknown_to_free() {
    // Free below y = 3, unknown above, a wall of occupied cells is ignored.
    let mut map = Grid::new([5, 6, 5]);
    for (cell, state) in all_of([5, 6, 5]).map(|c| {
        (
            c,
            if c[1] < 3 {
                State::Free
            } else {
                State::Unknown
            },
        )
    }) {
        map.set(cell, state);
    }
    let normal = Fringe::normal(&map, [2, 3, 2], |_| true).unwrap();
    assert!(normal[1] < -1.0 && normal[0].abs() < 1e-12 && normal[2].abs() < 1e-12);
    map.set([1, 2, 2], State::Occupied);
    let tilted = Fringe::normal(&map, [2, 3, 2], |_| true).unwrap();
    assert!(tilted[0] > 0.0);
    // Nothing outside and nothing free: no side to look from.
    assert_eq!(
        Fringe::normal(&Grid::new([5; 3]), [2, 2, 2], |_| true),
        None
    );
    assert!(Fringe::new(&map).targets(&map, ([3; 3], [1; 3])).is_empty());
}

fn all_of(size: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    (0..size[2])
        .flat_map(move |z| (0..size[1]).flat_map(move |y| (0..size[0]).map(move |x| [x, y, z])))
}

/// Rows longer than a word, at every offset in the fringe's own words.
#[test]
fn wide_rows_equal_their_definition() {
    let size = [131, 5, 3];
    let mut grid = Grid::new(size);
    let mut random = 1u64;
    let cells = || {
        (0..size[2])
            .flat_map(move |z| (0..size[1]).flat_map(move |y| (0..size[0]).map(move |x| [x, y, z])))
    };
    for cell in cells() {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        let state = [State::Free, State::Unknown, State::Occupied][(random >> 33) as usize % 3];
        grid.set(cell, state);
    }
    let fringe = Fringe::new(&grid);
    let wanted: Vec<_> = cells()
        .filter(|&c| grid.get(c) == State::Unknown && beside(c).iter().any(|&n| grid.is_free(n)))
        .collect();
    assert_eq!(fringe.cells().collect::<Vec<_>>(), wanted);
    assert_eq!(fringe.len(), wanted.len());
}
