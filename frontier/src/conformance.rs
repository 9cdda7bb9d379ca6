//! The laws of [`Map`] as a function that every implementor's tests call.

use crate::Cell;
use crate::map::{Map, inside, neighbours};

/// Checks the laws over the whole map and one cell around it.
///
/// # Panics
/// With the law and the cell, when one does not hold. Meant for tests.
pub fn check(map: &impl Map) {
    let bounds = map.bounds();
    let (low, high) = bounds;
    for z in low[2] - 1..=high[2] {
        for y in low[1] - 1..=high[1] {
            for x in low[0] - 1..=high[0] {
                let cell = [x, y, z];
                let (free, occupied) = (map.is_free(cell), map.is_occupied(cell));
                assert!(!(free && occupied), "{cell:?} is both free and occupied");
                if !inside(cell, bounds) {
                    assert!(!free && !occupied, "{cell:?} is outside but known");
                }
                for (i, n) in neighbours(cell).enumerate() {
                    let (free, occupied) = (map.is_free(n), map.is_occupied(n));
                    let bit = |faces: u8| faces >> i & 1 != 0;
                    let faces = map.free_faces(cell);
                    assert_eq!(bit(faces), free, "free face {i} of {cell:?}");
                    let faces = map.unknown_faces(cell);
                    assert_eq!(
                        bit(faces),
                        !free && !occupied,
                        "unknown face {i} of {cell:?}"
                    );
                }
            }
            // Rows that begin before, at and within the map, and end within and beyond it.
            for start in [-70, -1, 0, 1, 37, 64] {
                for words in 1..4 {
                    check_rows(map, [low[0] + start, y, z], words, 1);
                }
            }
        }
        // Several rows at once: all, and some that begin or end beyond the map.
        let all = (high[1] - low[1]) as usize;
        let words = ((high[0] - low[0]) as usize).div_ceil(64);
        for (start, y, words, rows) in [
            (0, 0, words, all),
            (0, -1, words, all + 2),
            (0, 1, words, all),
            (0, 0, words + 1, all),
            (5, 0, words, all),
        ] {
            check_rows(map, [low[0] + start, low[1] + y, z], words, rows);
        }
    }
}

/// The word methods against the single-cell ones.
fn check_rows(map: &impl Map, first: Cell, row: usize, rows: usize) {
    let bounds = map.bounds();
    let free = |n| map.is_free(n);
    let unknown = |n| inside(n, bounds) && !map.is_free(n) && !map.is_occupied(n);
    // What the words hold before must not matter.
    let mut found = [u64::MAX, 0x5555, 0].map(|word| vec![word; row * rows]);
    let [explore, beyond, inspect] = &mut found;
    map.exploration_words(first, row, explore);
    map.unknown_words(first, row, beyond);
    map.inspection_words(first, row, inspect);
    for i in 0..row * rows * 64 {
        let (x, y) = (i % (row * 64), i / (row * 64));
        let cell = [first[0] + x as i32, first[1] + y as i32, first[2]];
        let is = [
            free(cell) && neighbours(cell).any(unknown),
            unknown(cell) && neighbours(cell).any(free),
            map.is_occupied(cell) && !map.is_inspected(cell) && neighbours(cell).any(free),
        ];
        for (name, (found, is)) in ["exploration", "unknown", "inspection"]
            .iter()
            .zip(found.iter().zip(is))
        {
            let bit = found[i / 64] >> (i % 64) & 1 != 0;
            assert_eq!(
                bit, is,
                "{name} words, {row} a row from {first:?}, at {cell:?}"
            );
        }
    }
}
