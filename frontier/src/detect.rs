//! Frontier cells by definition, from scratch.

use crate::Cell;
use crate::cluster::Kind;
use crate::map::Map;
use crate::params::Side;

/// All exploration frontier cells of the free side, in index order (x fastest).
pub fn exploration(map: &impl Map) -> Vec<Cell> {
    exploration_on(map, Side::Free)
}

/// All exploration frontier cells of one side, in index order (x fastest).
pub fn exploration_on(map: &impl Map, side: Side) -> Vec<Cell> {
    scan(map, Kind::Exploration, side, (i32::MIN, i32::MAX))
}

/// All inspection frontier cells with `band.0 <= z < band.1`, in index order (x fastest).
pub fn inspection(map: &impl Map, band: (i32, i32)) -> Vec<Cell> {
    scan(map, Kind::Inspection, Side::Free, band)
}

pub(crate) fn word_of(map: &impl Map, kind: Kind, side: Side, first: Cell) -> u64 {
    match (kind, side) {
        (Kind::Exploration, Side::Free) => map.exploration_word(first),
        (Kind::Exploration, Side::Unknown) => map.unknown_word(first),
        (Kind::Inspection, _) => map.inspection_word(first),
    }
}

fn scan(map: &impl Map, kind: Kind, side: Side, band: (i32, i32)) -> Vec<Cell> {
    let (low, high) = map.bounds();
    let mut cells = Vec::new();
    for z in low[2].max(band.0)..high[2].min(band.1) {
        for y in low[1]..high[1] {
            for x in (low[0]..high[0]).step_by(64) {
                let mut word = word_of(map, kind, side, [x, y, z]);
                while word != 0 {
                    cells.push([x + word.trailing_zeros() as i32, y, z]);
                    word &= word - 1;
                }
            }
        }
    }
    cells
}
