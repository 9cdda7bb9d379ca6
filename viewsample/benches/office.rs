//! A half-explored office of 30 m x 20 m x 3 m at 0.15 m: what one decision costs.
//!
//! `decision` is one second of a run: the robot drove on and scanned, the clusters whose voxels
//! changed come in anew, the candidate set is asked for. `exact` is the same with no patience for late LiDAR
//! counts, `cold` a sampler that never evaluated anything.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stderr)]

use std::hint::black_box;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use viewsample::grid::{Grid, Mast};
use viewsample::{
    Cell, Changes, Cluster, Kind, Lidar, Map, Params, Pose, Sampler, Straight, postures,
};

const H: f64 = 0.15;
const SIZE: [usize; 3] = [200, 134, 20];
const COSTS: Straight<2> = Straight {
    base_speed: 0.8,
    joint_speed: [0.5, 0.8],
};
const HOME: [f64; 3] = [15.0, 10.0, 0.0];

/// Ten rooms with doors on both sides of a corridor, tables and cabinets inside.
fn office() -> Grid {
    let mut map = Grid::unknown(SIZE, H);
    for c in map.all() {
        map.set(c, b'.');
    }
    let mut fill = |low: [f64; 3], high: [f64; 3], state: u8| {
        let (a, b) = (map.cell_at(low), map.cell_at(high));
        for z in a[2]..b[2] {
            for y in a[1]..b[1] {
                for x in a[0]..b[0] {
                    map.set([x, y, z], state);
                }
            }
        }
    };
    let top = 3.01;
    for (a, b) in [
        ([0.0, 0.0], [30.0, 0.15]),
        ([0.0, 19.8], [30.0, 20.1]),
        ([0.0, 0.0], [0.15, 20.0]),
        ([29.85, 0.0], [30.0, 20.0]),
    ] {
        fill([a[0], a[1], 0.0], [b[0], b[1], top], b'#');
    }
    for (wall, room) in [(8.55, 0.15), (11.25, 11.4)] {
        fill([0.0, wall, 0.0], [30.0, wall + 0.15, top], b'#');
        for n in 0..5 {
            let x = 6.0 * f64::from(n);
            fill([x, room, 0.0], [x + 0.15, room + 8.4, top], b'#');
            fill([x + 2.4, wall, 0.0], [x + 3.6, wall + 0.15, 2.1], b'.');
            // A table on legs, a cabinet, a shelf.
            fill(
                [x + 1.5, room + 3.0, 0.6],
                [x + 3.3, room + 4.2, 0.75],
                b'#',
            );
            fill(
                [x + 1.5, room + 3.0, 0.0],
                [x + 1.65, room + 3.15, 0.6],
                b'#',
            );
            fill([x + 4.8, room + 1.0, 0.0], [x + 5.7, room + 2.4, 1.8], b'#');
            fill(
                [x + 0.3, room + 6.0, 0.0],
                [x + 0.75, room + 7.8, 1.2],
                b'#',
            );
        }
    }
    map
}

/// A run up to some point: what was seen and inspected so far.
#[derive(Clone)]
struct Run {
    truth: Grid,
    seen: Grid,
    inspected: Vec<bool>,
}

fn number(c: Cell) -> usize {
    (c[2] as usize * SIZE[1] + c[1] as usize) * SIZE[0] + c[0] as usize
}

impl Run {
    /// One LiDAR turn and one image from a pose.
    fn scan(&mut self, base: [f64; 3], pitch: f64) {
        let params = Params::default();
        let lidar = Lidar {
            range: 10.0,
            ..params.lidar.unwrap()
        };
        let camera = Pose::looking([0.45, 0.0, 1.1], 0.0, pitch).on(base);
        let eye = lidar.eye(base);
        for c in self.truth.all() {
            let p = self.truth.center(c);
            let d = [0, 1, 2].map(|a| p[a] - eye[a]);
            let depth = params.depth.covers(camera.to_camera(p))
                && self.truth.line_of_sight(camera.translation, c, 0);
            if depth || (lidar.covers(d) && self.truth.line_of_sight(eye, c, 0)) {
                self.seen.set(
                    c,
                    if self.truth.is_occupied(c) {
                        b'#'
                    } else {
                        b'.'
                    },
                );
            }
            if depth && self.truth.is_occupied(c) && params.rgb.covers(camera.to_camera(p)) {
                self.inspected[number(c)] = true;
            }
        }
    }

    /// Clusters by a raster of 3 m; ids by place.
    fn clusters(&self) -> Vec<(u64, Kind, Vec<Cell>)> {
        let mut cells = vec![Vec::new(); 2 * 16 * 16];
        for c in self.seen.exploration() {
            cells[(c[0] / 20 * 16 + c[1] / 20) as usize * 2].push(c);
        }
        for c in self
            .seen
            .surface()
            .into_iter()
            .filter(|c| c[2] > 0 && c[2] < 16 && !self.inspected[number(*c)])
        {
            cells[(c[0] / 20 * 16 + c[1] / 20) as usize * 2 + 1].push(c);
        }
        let kind = |n: usize| {
            if n.is_multiple_of(2) {
                Kind::Exploration
            } else {
                Kind::Inspection
            }
        };
        let all = cells
            .into_iter()
            .enumerate()
            .filter(|(_, cells)| !cells.is_empty());
        all.map(|(n, cells)| (n as u64, kind(n), cells)).collect()
    }
}

fn borrow((id, kind, cells): &(u64, Kind, Vec<Cell>)) -> Cluster<'_> {
    let mut centroid = [0.0; 3];
    for c in cells {
        for a in 0..3 {
            centroid[a] += (f64::from(c[a]) + 0.5) * H / cells.len() as f64;
        }
    }
    Cluster {
        id: *id,
        kind: *kind,
        cells,
        centroid,
    }
}

fn robot(map: &Grid) -> Mast<'_, Grid> {
    Mast {
        map,
        radius: 0.4,
        height: 0.5,
        lift: (0.4, 1.5),
    }
}

fn bench(c: &mut Criterion) {
    let truth = office();
    let mut run = Run {
        seen: Grid::unknown(SIZE, H),
        inspected: vec![false; SIZE.iter().product()],
        truth,
    };
    for (x, y, yaw, pitch) in [
        (5.0, 10.0, 0.0, 0.0),
        (9.0, 10.0, 0.0, 0.4),
        (9.0, 9.5, -1.6, 0.0),
        (9.0, 7.0, -1.6, -0.4),
        (9.5, 5.5, -2.0, 0.0),
        (9.0, 12.5, 1.6, 0.4),
        (12.0, 10.0, 0.0, 0.0),
        (3.0, 7.5, -1.6, 0.0),
        (3.0, 12.5, 1.6, -0.4),
        (14.2, 10.0, 0.0, 0.0),
    ] {
        run.scan([x, y, yaw], pitch);
    }
    let (before, old) = (run.seen.clone(), run.clusters());
    run.scan(HOME, -0.4);
    let (after, new) = (run.seen.clone(), run.clusters());
    let changed: Vec<_> = new.iter().filter(|k| !old.contains(k)).cloned().collect();
    let removed: Vec<u64> = old
        .iter()
        .map(|k| k.0)
        .filter(|id| new.iter().all(|k| k.0 != *id))
        .collect();
    // Touched bricks of 8 cells a side, as a map would report them.
    let mut boxes: Vec<(Cell, Cell)> = Vec::new();
    for c in before.all().filter(|c| {
        before.is_free(*c) != after.is_free(*c) || before.is_occupied(*c) != after.is_occupied(*c)
    }) {
        let low = c.map(|v| v / 8 * 8);
        if !boxes.iter().any(|b| b.0 == low) {
            boxes.push((low, low.map(|v| v + 8)));
        }
    }

    let cells: usize = old.iter().map(|k| k.2.len()).sum();
    eprintln!(
        "{} clusters, {cells} frontier voxels; {} clusters change, {} boxes",
        old.len(),
        changed.len(),
        boxes.len()
    );

    let all: Vec<Cluster<'_>> = old.iter().map(borrow).collect();
    let added: Vec<Cluster<'_>> = changed.iter().map(borrow).collect();
    let first = Changes {
        added: &all,
        boxes: &[before.bounds()],
        ..Changes::default()
    };
    let next = Changes {
        added: &added,
        removed: &removed,
        boxes: &boxes,
    };
    let start = |params: &Params| {
        let mut sampler = Sampler::new(params, postures(&robot(&before), params).unwrap()).unwrap();
        sampler.update(&before, &first).unwrap();
        sampler
    };
    let ask = |sampler: &mut Sampler<[f64; 2]>, map: &Grid, base| {
        sampler
            .candidates(&robot(map), &COSTS, base, &[1.0, 0.0])
            .unwrap()
    };
    let mut group = c.benchmark_group("office");
    group.sample_size(20);
    let base_params = Params {
        ahead: vec![0.3],
        ..Params::default()
    };
    let ours = Params {
        ..base_params.clone()
    };
    let exact = Params {
        lidar_patience: 0,
        lidar_grid: 0.0,
        ..base_params.clone()
    };
    let mut cold = start(&exact);
    group.bench_function("cold", |b| {
        b.iter_batched_ref(
            || cold.clone(),
            |s| black_box(ask(s, &before, HOME)),
            BatchSize::LargeInput,
        );
    });
    let found = ask(&mut cold, &before, HOME);
    eprintln!(
        "cold: {} views, {} without; {:?}",
        found.views.len(),
        found.without.len(),
        found.effort
    );
    for (name, params) in [("decision", &ours), ("exact", &exact)] {
        let mut warm = start(params);
        ask(&mut warm, &before, [14.2, 10.0, 0.0]);
        let step = |s: &mut Sampler<[f64; 2]>| {
            s.update(&after, &next).unwrap();
            ask(s, &after, HOME)
        };
        let found = step(&mut warm.clone());
        eprintln!(
            "{name}: {} views, {} without; {:?}",
            found.views.len(),
            found.without.len(),
            found.effort
        );
        group.bench_function(name, |b| {
            b.iter_batched_ref(
                || warm.clone(),
                |s| black_box(step(s)),
                BatchSize::LargeInput,
            )
        });
    }
    let mut warm = start(&ours);
    group.bench_function("update", |b| {
        b.iter_batched_ref(
            || warm.clone(),
            |s| s.update(&after, &next).unwrap(),
            BatchSize::LargeInput,
        );
    });
    let view = ask(&mut warm, &before, HOME).views[0].clone();
    group.bench_function("one_view", |b| {
        b.iter(|| warm.gain_at(black_box(view.base), &view.camera).unwrap())
    });
    #[cfg(feature = "rayon")]
    group.bench_function("cold_parallel", |b| {
        let cold = start(&exact);
        let ask = |s: &mut Sampler<[f64; 2]>| {
            s.candidates_parallel(&robot(&before), &COSTS, HOME, &[1.0, 0.0])
                .unwrap()
        };
        b.iter_batched_ref(
            || cold.clone(),
            |s| black_box(ask(s)),
            BatchSize::LargeInput,
        );
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
