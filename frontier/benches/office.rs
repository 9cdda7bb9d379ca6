//! Frontiers of a half explored office, 30 m x 20 m x 3 m at 0.15 m.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use frontier::grid::{Grid, State};
use frontier::{Frontiers, Params, exploration};

fn office() -> Grid {
    let size = [200, 134, 20];
    let mut map = Grid::new(size);
    for z in 0..size[2] {
        for y in 0..size[1] {
            for x in 0..120 {
                let wall = x % 40 == 0 || y % 44 == 0;
                map.set([x, y, z], if wall { State::Occupied } else { State::Free });
            }
        }
    }
    map
}

fn bench(c: &mut Criterion) {
    let mut map = office();
    c.bench_function("exploration/office", |b| b.iter(|| exploration(&map)));
    let mut frontiers = Frontiers::new(Params::default()).unwrap();
    frontiers.update(&map, &[]);
    let mut free = false;
    c.bench_function("update/one brick", |b| {
        b.iter(|| {
            free = !free;
            let state = if free { State::Free } else { State::Unknown };
            for z in 0..8 {
                for y in 60..68 {
                    for x in 120..128 {
                        map.set([x, y, z], state);
                    }
                }
            }
            frontiers.update(&map, &[([120, 60, 0], [128, 68, 8])])
        });
    });
}

criterion_group!(benches, bench);
criterion_main!(benches);
