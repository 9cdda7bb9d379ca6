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

/// Frontier cells in rows of words, as [`Map::exploration_words`] has them.
pub(crate) fn words_of(
    map: &impl Map,
    kind: Kind,
    side: Side,
    first: Cell,
    row: usize,
    words: &mut [u64],
) {
    match (kind, side) {
        (Kind::Exploration, Side::Free) => map.exploration_words(first, row, words),
        (Kind::Exploration, Side::Unknown) => map.unknown_words(first, row, words),
        (Kind::Inspection, _) => map.inspection_words(first, row, words),
    }
}

fn scan(map: &impl Map, kind: Kind, side: Side, band: (i32, i32)) -> Vec<Cell> {
    let (low, high) = map.bounds();
    let mut cells = Vec::new();
    let [nx, ny] = [0, 1].map(|a| (high[a] - low[a]).max(0) as usize);
    let row = nx.div_ceil(64);
    let mut words = vec![0; row * ny];
    for z in low[2].max(band.0)..high[2].min(band.1) {
        words_of(map, kind, side, [low[0], low[1], z], row, &mut words);
        for (i, &word) in words.iter().enumerate() {
            let mut bits = word;
            while bits != 0 {
                let x = i % row * 64 + bits.trailing_zeros() as usize;
                cells.push([low[0] + x as i32, low[1] + (i / row) as i32, z]);
                bits &= bits - 1;
            }
        }
    }
    cells
}
