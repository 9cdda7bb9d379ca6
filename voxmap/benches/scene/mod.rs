//! An office of 30 m x 20 m x 3 m and the scans of a round through it, with HEATS's sensors.

#![allow(unreachable_pub)]

use voxmap::{Camera, Config, Scan, SensorModel, VoxelMap};

pub type Solid = ([f64; 3], [f64; 3]);

/// Corridor along x, rooms on both sides with doors, tables on legs and cabinets, floor and ceiling.
pub fn office() -> Vec<Solid> {
    let mut solids = vec![
        ([-1.0, -1.0, -1.0], [31.0, 21.0, 0.0]),
        ([-1.0, -1.0, 2.9], [31.0, 21.0, 4.0]),
        ([-1.0, -1.0, 0.0], [0.1, 21.0, 3.0]),
        ([29.9, -1.0, 0.0], [31.0, 21.0, 3.0]),
        ([-1.0, -1.0, 0.0], [31.0, 0.1, 3.0]),
        ([-1.0, 19.9, 0.0], [31.0, 21.0, 3.0]),
    ];
    for room in 0..6 {
        let x = 5.0 * f64::from(room);
        for (wall, y0, y1) in [(8.8, 0.1, 8.8), (11.2, 11.3, 19.9)] {
            solids.push(([x, wall, 0.0], [x + 2.0, wall + 0.1, 3.0]));
            solids.push(([x + 3.0, wall, 0.0], [x + 5.0, wall + 0.1, 3.0]));
            solids.push(([x - 0.05, y0, 0.0], [x + 0.05, y1, 3.0]));
            for k in 0..3 {
                let (tx, ty) = (
                    x + 0.8 + 1.2 * f64::from(k % 2),
                    y0 + 1.5 + 2.2 * f64::from(k),
                );
                solids.push(([tx, ty, 0.70], [tx + 1.0, ty + 0.6, 0.74]));
                for (lx, ly) in [(0.0, 0.0), (0.95, 0.0), (0.0, 0.55), (0.95, 0.55)] {
                    let leg = [tx + lx, ty + ly];
                    solids.push(([leg[0], leg[1], 0.0], [leg[0] + 0.05, leg[1] + 0.05, 0.7]));
                }
            }
            solids.push(([x + 4.4, y0 + 1.0, 0.0], [x + 4.8, y0 + 2.5, 1.8]));
        }
    }
    solids
}

pub fn range(solids: &[Solid], o: [f64; 3], d: [f64; 3]) -> f64 {
    let mut best = f64::INFINITY;
    for (low, high) in solids {
        let (mut enter, mut leave) = (0.0f64, best);
        for a in 0..3 {
            let (t0, t1) = ((low[a] - o[a]) / d[a], (high[a] - o[a]) / d[a]);
            enter = enter.max(t0.min(t1));
            leave = leave.min(t0.max(t1));
        }
        if enter < leave {
            best = enter;
        }
    }
    best
}

pub struct Taken {
    pub origin: [f64; 3],
    pub range: f64,
    pub hits: Vec<[f32; 3]>,
    pub misses: Vec<[f32; 3]>,
}

pub fn take(
    solids: &[Solid],
    origin: [f64; 3],
    far: f64,
    rays: impl Iterator<Item = [f64; 3]>,
) -> Taken {
    let mut scan = Taken {
        origin,
        range: far,
        hits: vec![],
        misses: vec![],
    };
    for d in rays {
        let r = range(solids, origin, d);
        let end = |r: f64| [0, 1, 2].map(|a| (origin[a] + r * d[a]) as f32);
        if r < far {
            scan.hits.push(end(r));
        } else {
            scan.misses.push(end(far));
        }
    }
    scan
}

/// 450 x 74 rays, -7 to 52 degrees.
pub fn lidar(solids: &[Solid], at: [f64; 2]) -> Taken {
    let rays = (0..74).flat_map(|i| {
        let pitch = (-7.0 + 59.0 * (f64::from(i) + 0.5) / 74.0).to_radians();
        (0..450).map(move |j| {
            let yaw = (0.8 * f64::from(j) + 0.0137).to_radians();
            [
                pitch.cos() * yaw.cos(),
                pitch.cos() * yaw.sin(),
                pitch.sin(),
            ]
        })
    });
    take(solids, [at[0], at[1], 0.45], 10.0, rays)
}

pub fn camera(at: [f64; 2], yaw: f64) -> Camera {
    let (s, c) = yaw.sin_cos();
    Camera {
        rotation: [[s, 0.0, c], [-c, 0.0, s], [0.0, -1.0, 0.0]],
        translation: [at[0], at[1], 1.1],
        tan_half_h: 34.5f64.to_radians().tan(),
        tan_half_v: 21.0f64.to_radians().tan(),
    }
}

/// 80 x 48 rays of 87 x 58 degrees.
pub fn depth(solids: &[Solid], at: [f64; 2], yaw: f64) -> Taken {
    let c = camera(at, yaw);
    let rays = (0..48).flat_map(|i| {
        (0..80).map(move |j| {
            let p = [
                (f64::from(j) - 39.5) / 40.0 * 0.949,
                (f64::from(i) - 23.5) / 24.0 * 0.554,
                1.0,
            ];
            let n = (p[0] * p[0] + p[1] * p[1] + 1.0f64).sqrt();
            [0, 1, 2].map(|a| (0..3).map(|k| c.rotation[a][k] * p[k]).sum::<f64>() / n)
        })
    });
    take(solids, c.translation, 4.0, rays)
}

pub fn blank(cell_size: f64) -> VoxelMap {
    let (low, high) = ([0.0; 3], [30.0, 20.0, 3.0]);
    VoxelMap::new(&Config {
        cell_size,
        low,
        high,
        sensor: SensorModel::default(),
    })
    .unwrap()
}

/// A round through the office: corridor and some rooms.
pub fn stations() -> Vec<[f64; 2]> {
    let mut at: Vec<[f64; 2]> = (0..10).map(|i| [1.5 + 3.0 * f64::from(i), 10.0]).collect();
    at.extend((0..6).map(|i| [2.5 + 5.0 * f64::from(i), 7.6]));
    at.extend((0..6).map(|i| [2.5 + 5.0 * f64::from(i), 12.4]));
    at
}

pub fn insert(map: &mut VoxelMap, scan: &Taken, dedupe: bool) {
    let scan = Scan {
        origin: scan.origin,
        hits: &scan.hits,
        misses: &scan.misses,
        max_range: scan.range,
        one_ray_per_end_voxel: dedupe,
        ..Scan::default()
    };
    map.insert(&scan).unwrap();
}
