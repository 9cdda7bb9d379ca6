//! Scans of an office of 30 m x 20 m x 3 m, made here: the sensors and numbers of rays of HEATS.
#![allow(missing_docs, clippy::unwrap_used)]

mod scene;

use criterion::{Criterion, criterion_group, criterion_main};
use scene::{Solid, Taken, blank, camera, depth, insert, lidar, office, stations};
use std::hint::black_box;
use voxmap::{Esdf, EsdfParams, State, VoxelMap};

fn insertion(c: &mut Criterion) {
    let solids = office();
    let turns: Vec<Taken> = stations().iter().map(|&at| lidar(&solids, at)).collect();
    let images: Vec<Taken> = stations()
        .iter()
        .flat_map(|&at| (0..4).map(move |k| (at, f64::from(k) * 1.3)))
        .map(|(at, yaw)| depth(&solids, at, yaw))
        .collect();
    let mut group = c.benchmark_group("insert");
    group.sample_size(20);
    for (name, scans) in [("lidar_33k", &turns), ("depth_4k", &images)] {
        for cell in [0.15, 0.05] {
            for (mode, dedupe) in [("all", false), ("one_per_end", true)] {
                let mut map = blank(cell);
                let mut next = 0;
                group.bench_function(format!("{name}/{cell}/{mode}"), |b| {
                    b.iter(|| {
                        insert(&mut map, &scans[next % scans.len()], dedupe);
                        next += 1;
                    });
                });
            }
        }
    }
    group.finish();
}

fn filled(cell: f64) -> (VoxelMap, Vec<Solid>) {
    let solids = office();
    let mut map = blank(cell);
    for at in stations() {
        insert(&mut map, &lidar(&solids, at), false);
        for k in 0..4 {
            insert(&mut map, &depth(&solids, at, f64::from(k) * 1.57), false);
        }
    }
    (map, solids)
}

fn layers(c: &mut Criterion) {
    let mut group = c.benchmark_group("layers");
    group.sample_size(20);
    let (map, solids) = filled(0.15);
    let params = EsdfParams::default();
    group.bench_function("esdf/whole", |b| {
        b.iter(|| Esdf::new(black_box(&map), params.clone()).unwrap());
    });
    for scan in ["steady", "new"] {
        let mut map = map.clone();
        map.take_changes();
        let field = Esdf::new(&map, params.clone()).unwrap();
        if scan == "steady" {
            insert(&mut map, &lidar(&solids, [11.0, 9.6]), false);
        } else {
            map.reset_box([10.0, 8.0, 0.0], [15.0, 12.0, 3.0]);
        }
        let changes = map.take_changes();
        group.bench_function(format!("esdf/update_{scan}"), |b| {
            b.iter_batched_ref(
                || field.clone(),
                |field| field.update(&map, &changes),
                criterion::BatchSize::LargeInput,
            );
        });
    }
    group.bench_function("changes/lidar", |b| {
        b.iter_batched_ref(
            || {
                let mut map = map.clone();
                insert(&mut map, &lidar(&solids, [11.0, 9.6]), false);
                map
            },
            VoxelMap::take_changes,
            criterion::BatchSize::LargeInput,
        );
    });
    let mut seen = map.clone();
    for at in stations() {
        for k in 0..8 {
            seen.mark_inspected(&camera(at, f64::from(k)), 4.0);
        }
    }
    let mut next = 0;
    group.bench_function("inspect/half_seen", |b| {
        b.iter(|| {
            next += 1;
            let at = stations()[next % 22];
            seen.mark_inspected(&camera(at, 0.37 * next as f64), 4.0)
        });
    });
    group.finish();
}

fn queries(c: &mut Criterion) {
    let mut group = c.benchmark_group("queries");
    group.sample_size(20);
    let (map, _) = filled(0.15);
    let field = Esdf::new(&map, EsdfParams::default()).unwrap();
    let spot = |k: u32| {
        let r = |n: u32| f64::from(k.wrapping_mul(n) >> 8) / f64::from(1u32 << 24);
        [
            29.0 * r(2_654_435_761) + 0.5,
            19.0 * r(2_246_822_519) + 0.5,
            2.7 * r(3_266_489_917) + 0.1,
        ]
    };
    let mut k = 0;
    group.bench_function("line_of_sight/3m", |b| {
        b.iter(|| {
            k += 1;
            let from = spot(k);
            let to = map.cell_at([from[0] + 2.6, from[1] + 1.3, from[2] * 0.5]);
            map.line_of_sight(from, to, 2)
        });
    });
    group.bench_function("cast/10m", |b| {
        b.iter(|| {
            k += 1;
            let d = spot(k ^ 0x5555);
            map.cast(
                spot(k),
                [d[0] - 15.0, d[1] - 10.0, d[2] - 1.5],
                10.0,
                voxmap::UnknownPolicy::Pass,
            )
        });
    });
    group.bench_function("ball_is_free/0.12m", |b| {
        b.iter(|| {
            k += 1;
            map.ball_is_free(spot(k), 0.12, true)
        });
    });
    group.bench_function("state", |b| {
        b.iter(|| {
            k += 1;
            map.state(map.cell_at(spot(k))) == State::Free
        });
    });
    group.bench_function("distance_gradient", |b| {
        b.iter(|| {
            k += 1;
            field.distance_gradient(spot(k))
        });
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(std::time::Duration::from_millis(300))
        .measurement_time(std::time::Duration::from_secs(1));
    targets = insertion, layers, queries
}
criterion_main!(benches);
