//! A synthetic office of 30 m x 20 m x 3 m and what a LiDAR and a depth camera measure in it: the workloads of the README's
//! table. Corridor, twelve rooms with doors, tables on legs, bins and cabinets; boxes only, so that the truth of a cell is
//! known.

use crate::files::Scan;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// An axis-aligned box, m.
pub type Solid = ([f64; 3], [f64; 3]);

/// Numbers for noise and places.
pub struct Dice(ChaCha8Rng);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64)
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.between(0.0, n as f64) as usize).min(n - 1)
    }

    /// Standard normal.
    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.between(0.0, 1.0)).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.between(0.0, 1.0)).cos()
    }
}

/// The boxes of the office.
pub fn office(dice: &mut Dice) -> Vec<Solid> {
    const T: f64 = 0.1;
    let mut solids: Vec<Solid> = vec![
        ([0.0, 0.0, -0.1], [30.0, 20.0, 0.02]),
        ([0.0, 0.0, 2.95], [30.0, 20.0, 3.1]),
        ([0.0, 0.0, 0.0], [T, 20.0, 3.0]),
        ([30.0 - T, 0.0, 0.0], [30.0, 20.0, 3.0]),
        ([0.0, 0.0, 0.0], [30.0, T, 3.0]),
        ([0.0, 20.0 - T, 0.0], [30.0, 20.0, 3.0]),
    ];
    for wall in [8.9, 11.0] {
        for room in 0..6 {
            let x = 5.0 * f64::from(room);
            let door = x + 1.0 + dice.between(0.0, 2.5);
            solids.push(([x, wall, 0.0], [door, wall + T, 3.0]));
            solids.push(([door + 1.0, wall, 0.0], [x + 5.0, wall + T, 3.0]));
            solids.push(([door, wall, 2.1], [door + 1.0, wall + T, 3.0]));
        }
    }
    for room in 1..6 {
        let x = 5.0 * f64::from(room);
        solids.push(([x - T / 2.0, 0.0, 0.0], [x + T / 2.0, 8.9, 3.0]));
        solids.push(([x - T / 2.0, 11.1, 0.0], [x + T / 2.0, 20.0, 3.0]));
    }
    for (rx, ry) in rooms() {
        for _ in 0..3 {
            let (x, y) = (rx + dice.between(0.3, 3.2), ry + dice.between(0.8, 7.0));
            let (w, d) = if dice.below(2) == 0 {
                (1.4, 0.7)
            } else {
                (0.7, 1.4)
            };
            solids.push(([x, y, 0.72], [x + w, y + d, 0.76]));
            for (lx, ly) in [
                (0.0, 0.0),
                (w - 0.05, 0.0),
                (0.0, d - 0.05),
                (w - 0.05, d - 0.05),
            ] {
                solids.push(([x + lx, y + ly, 0.0], [x + lx + 0.05, y + ly + 0.05, 0.72]));
            }
            if dice.below(10) < 7 {
                solids.push(([x + 0.1, y + 0.1, 0.0], [x + 0.4, y + 0.4, 0.35]));
            }
        }
        let (x, y) = (rx + dice.between(0.2, 3.8), ry + dice.between(0.2, 8.0));
        solids.push(([x, y, 0.0], [x + 0.9, y + 0.45, 1.8]));
        let (x, y) = (rx + dice.between(0.5, 4.0), ry + dice.between(0.5, 8.0));
        solids.push(([x, y, 0.0], [x + 0.5, y + 0.5, 0.9]));
    }
    solids
}

fn rooms() -> impl Iterator<Item = (f64, f64)> {
    [0.0, 11.1]
        .into_iter()
        .flat_map(|y| (0..6).map(move |room| (5.0 * f64::from(room), y)))
}

/// Distance to the first box along a unit direction.
fn range(solids: &[Solid], o: [f64; 3], d: [f64; 3]) -> f64 {
    let mut best = f64::INFINITY;
    for (low, high) in solids {
        let (mut enter, mut leave) = (1e-6f64, best);
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

/// A place with nothing within 0.15 m: every third in the corridor, the others in rooms.
fn place(solids: &[Solid], dice: &mut Dice, k: usize, height: (f64, f64)) -> [f64; 3] {
    loop {
        let (x, y) = if k.is_multiple_of(3) {
            (dice.between(1.0, 29.0), dice.between(9.4, 10.6))
        } else {
            let (rx, ry) = rooms().nth(dice.below(12)).unwrap_or_default();
            (rx + dice.between(0.5, 4.5), ry + dice.between(0.6, 8.2))
        };
        let p = [x, y, dice.between(height.0, height.1)];
        let near =
            |(low, high): &Solid| (0..3).all(|a| p[a] > low[a] - 0.15 && p[a] < high[a] + 0.15);
        if !solids.iter().any(near) {
            return p;
        }
    }
}

fn take(
    solids: &[Solid],
    origin: [f64; 3],
    rays: &[[f64; 3]],
    mut noise: impl FnMut(f64) -> f64,
) -> Scan {
    let mut points = Vec::new();
    for d in rays {
        let r = range(solids, origin, *d);
        let r = r + noise(r);
        if r.is_finite() && r > 0.2 {
            points.push([0, 1, 2].map(|a| (origin[a] + r * d[a]) as f32));
        }
    }
    Scan { origin, points }
}

/// Turns of a LiDAR: 360 x 59 rays, -7 to 52 degrees, 1 cm of noise.
pub fn lidar(solids: &[Solid], n: usize, dice: &mut Dice) -> Vec<Scan> {
    (0..n)
        .map(|k| {
            let at = place(solids, dice, k, (0.6, 0.6));
            let yaw = dice.between(0.0, std::f64::consts::TAU);
            let mut rays = Vec::new();
            for i in 0..59 {
                let (se, ce) = (f64::from(i) * 59.0 / 58.0 - 7.0).to_radians().sin_cos();
                for j in 0..360 {
                    let (s, c) = ((f64::from(j) + 0.5).to_radians() + yaw).sin_cos();
                    rays.push([ce * c, ce * s, se]);
                }
            }
            take(solids, at, &rays, |_| 0.01 * dice.normal())
        })
        .collect()
}

/// Images of a depth camera: 160 x 120 rays of 640 x 480 at f = 380, noise 0.0015 z^2.
pub fn depth(solids: &[Solid], n: usize, dice: &mut Dice) -> Vec<Scan> {
    (0..n)
        .map(|k| {
            let at = place(solids, dice, k, (0.7, 1.6));
            let (s, c) = dice.between(0.0, std::f64::consts::TAU).sin_cos();
            let (sp, cp) = dice.between(-0.5, 0.2).sin_cos();
            let (forward, left) = ([cp * c, cp * s, sp], [-s, c, 0.0]);
            let up = [
                forward[1] * left[2] - forward[2] * left[1],
                forward[2] * left[0] - forward[0] * left[2],
                forward[0] * left[1] - forward[1] * left[0],
            ];
            let mut rays = Vec::new();
            for i in 0..120 {
                let v = (f64::from(i) * 4.0 + 2.0 - 240.0) / 380.0;
                for j in 0..160 {
                    let u = (f64::from(j) * 4.0 + 2.0 - 320.0) / 380.0;
                    let d = [0, 1, 2].map(|a| forward[a] - u * left[a] - v * up[a]);
                    let norm = d.iter().map(|x| x * x).sum::<f64>().sqrt();
                    rays.push(d.map(|x| x / norm));
                }
            }
            take(solids, at, &rays, |r| 0.0015 * r * r * dice.normal())
        })
        .collect()
}

/// True if a solid reaches into the cube from `low` with edge `h` by more than a hair.
pub fn is_solid(solids: &[Solid], low: [f64; 3], h: f64) -> bool {
    let hair = 1e-6;
    solids
        .iter()
        .any(|(l, t)| (0..3).all(|a| l[a] < low[a] + h - hair && t[a] > low[a] + hair))
}
