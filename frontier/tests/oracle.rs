//! Detection against the definition, cell by cell.
#![allow(missing_docs, clippy::unwrap_used)]

use frontier::grid::{Grid, State};
use frontier::{Cell, Side, exploration, exploration_on, inspection};
use proptest::prelude::*;

const FACES: [Cell; 6] = [
    [-1, 0, 0],
    [1, 0, 0],
    [0, -1, 0],
    [0, 1, 0],
    [0, 0, -1],
    [0, 0, 1],
];

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn detection_follows_the_definition(states in prop::collection::vec(0..4u8, 9 * 5 * 4)) {
        let size = [9, 5, 4];
        let mut map = Grid::new(size);
        let mut at = states.iter();
        let mut all = Vec::new();
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let state = [State::Unknown, State::Free, State::Occupied, State::Inspected]
                        [usize::from(*at.next().unwrap())];
                    map.set([x, y, z], state);
                    all.push([x, y, z]);
                }
            }
        }
        let inside = |c: Cell| (0..3).all(|a| c[a] >= 0 && c[a] < size[a]);
        let beside = |c: Cell| FACES.map(|f| [c[0] + f[0], c[1] + f[1], c[2] + f[2]]).into_iter().filter(|&n| inside(n));
        let explore: Vec<Cell> = all.iter().copied()
            .filter(|&c| map.get(c) == State::Free && beside(c).any(|n| map.get(n) == State::Unknown))
            .collect();
        let inspect: Vec<Cell> = all.iter().copied()
            .filter(|&c| map.get(c) == State::Occupied && beside(c).any(|n| map.get(n) == State::Free))
            .collect();
        let beyond: Vec<Cell> = all.iter().copied()
            .filter(|&c| map.get(c) == State::Unknown && beside(c).any(|n| map.get(n) == State::Free))
            .collect();
        prop_assert_eq!(exploration(&map), explore);
        prop_assert_eq!(exploration_on(&map, Side::Unknown), beyond);
        prop_assert_eq!(inspection(&map, (i32::MIN, i32::MAX)), inspect);
    }
}
