//! The laws of [`Map`] as a function that every implementor's tests call.

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
                    continue;
                }
                let bit = |word: u64| word & 1 != 0;
                let explore = free
                    && neighbours(cell)
                        .any(|n| inside(n, bounds) && !map.is_free(n) && !map.is_occupied(n));
                assert_eq!(
                    bit(map.exploration_word(cell)),
                    explore,
                    "exploration word at {cell:?}"
                );
                let beside = !free && !occupied && neighbours(cell).any(|n| map.is_free(n));
                assert_eq!(
                    bit(map.unknown_word(cell)),
                    beside,
                    "unknown word at {cell:?}"
                );
                let inspect =
                    occupied && !map.is_inspected(cell) && neighbours(cell).any(|n| map.is_free(n));
                assert_eq!(
                    bit(map.inspection_word(cell)),
                    inspect,
                    "inspection word at {cell:?}"
                );
            }
        }
    }
}
