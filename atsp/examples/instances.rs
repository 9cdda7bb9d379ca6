//! Writes random instances of the kinds a robot meets, with the best costs that long runs find, for `figures` and
//! `tools/atsp_peers.py`.
//!
//! `cargo run --release -p atsp --example instances -- FOLDER [--seed 1] [--runs 8] [--ms 1000] [--nodes 200]`
//!
//! Viewpoints stand in an area of 30 m x 20 m; the robot drives 0.8 m/s and turns 1 rad/s, in place, towards the next
//! viewpoint and to its heading there. Costs are seconds, rounded to 1 ms.
//! - `free`, `clusters`: no obstacles, viewpoints anywhere or in groups;
//! - `office`: shortest ways through ten rooms beside a corridor; `oneway`: the same with a third of the ways forbidden;
//! - `nearsym`: the longer of driving and turning, as a drone flies it; symmetric but for the robot;
//! - `regions`: symmetric, the end free;
//! - `uniform`, `crane`: closed tours over random numbers, and over loads that are carried a little way each.
#![allow(clippy::print_stdout, clippy::print_stderr, missing_docs)]

use std::collections::BinaryHeap;
use std::path::Path;

use atsp::{CostMatrix, Params, Problem, Proof, Solver};
use cpu_time::ThreadTime;
use serde_json::{Map, json};

const SPEED: f64 = 0.8;
const WIDTH: f64 = 30.0;
const HEIGHT: f64 = 20.0;

/// splitmix64.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

/// A viewpoint: metres and radians.
#[derive(Clone, Copy)]
struct Pose {
    x: f64,
    y: f64,
    yaw: f64,
}

/// The angle between two directions, rad.
fn turn(from: f64, to: f64) -> f64 {
    let angle = (to - from).rem_euclid(std::f64::consts::TAU);
    angle.min(std::f64::consts::TAU - angle)
}

/// A way between two viewpoints: its length, m, and the directions at its ends; `None` where there is none.
type Way = Option<(f64, f64, f64)>;

fn straight(a: Pose, b: Pose) -> Way {
    let direction = (b.y - a.y).atan2(b.x - a.x);
    Some(((b.x - a.x).hypot(b.y - a.y), direction, direction))
}

/// Rooms beside a corridor, as cells of 0.25 m.
struct Office {
    wall: Vec<bool>,
}

const CELL: f64 = 0.25;
const COLUMNS: usize = 120;
const ROWS: usize = 80;
/// Cells from the ends of a way at which its direction is taken.
const AHEAD: usize = 4;

impl Office {
    fn new(random: &mut Random) -> Self {
        let mut wall = vec![false; COLUMNS * ROWS];
        for x in 0..COLUMNS {
            for y in 0..ROWS {
                let outer = x == 0 || y == 0 || x + 1 == COLUMNS || y + 1 == ROWS;
                let corridor = y == 35 || y == 44;
                let between = x % 24 == 0 && !(35..=44).contains(&y);
                wall[y * COLUMNS + x] = outer || corridor || between;
            }
        }
        for room in 0..5 {
            for y in [35, 44] {
                let door = 24 * room + 2 + random.between(0.0, 17.0) as usize;
                for x in door..door + 4 {
                    wall[y * COLUMNS + x] = false;
                }
            }
        }
        Self { wall }
    }

    fn cell(pose: Pose) -> usize {
        (pose.y / CELL) as usize * COLUMNS + (pose.x / CELL) as usize
    }

    /// Shortest 8-connected ways from one viewpoint to all others (Dijkstra).
    fn ways(&self, poses: &[Pose], from: usize) -> Vec<Way> {
        let source = Self::cell(poses[from]);
        let mut length = vec![u32::MAX; self.wall.len()];
        let mut before = vec![source; self.wall.len()];
        let mut open = BinaryHeap::from([(std::cmp::Reverse(0u32), source)]);
        length[source] = 0;
        while let Some((std::cmp::Reverse(here), cell)) = open.pop() {
            if here > length[cell] {
                continue;
            }
            for dy in [-1isize, 0, 1] {
                for dx in [-1isize, 0, 1] {
                    let next = cell.wrapping_add_signed(dy * COLUMNS as isize + dx);
                    let beside = cell.wrapping_add_signed(dx);
                    let above = cell.wrapping_add_signed(dy * COLUMNS as isize);
                    if self.wall[next] || self.wall[beside] || self.wall[above] {
                        continue;
                    }
                    let there = here + [0, 250, 354][(dx.abs() + dy.abs()) as usize];
                    if there < length[next] {
                        length[next] = there;
                        before[next] = cell;
                        open.push((std::cmp::Reverse(there), next));
                    }
                }
            }
        }
        let direction = |a: usize, b: usize| {
            let at = |c: usize| ((c % COLUMNS) as f64, (c / COLUMNS) as f64);
            let ((ax, ay), (bx, by)) = (at(a), at(b));
            (by - ay).atan2(bx - ax)
        };
        poses
            .iter()
            .map(|&pose| {
                let target = Self::cell(pose);
                if length[target] == u32::MAX {
                    return None;
                }
                let mut way = vec![target];
                while let Some(&cell) = way.last().filter(|&&c| c != source) {
                    way.push(before[cell]);
                }
                let last = AHEAD.min(way.len() - 1);
                Some((
                    f64::from(length[target]) / 1e3,
                    direction(source, way[way.len() - 1 - last]),
                    direction(way[last], target),
                ))
            })
            .collect()
    }
}

fn poses(n: usize, groups: usize, random: &mut Random) -> Vec<Pose> {
    let centres: Vec<(f64, f64)> = (0..groups)
        .map(|_| {
            (
                random.between(2.0, WIDTH - 2.0),
                random.between(2.0, HEIGHT - 2.0),
            )
        })
        .collect();
    (0..n)
        .map(|i| {
            let (x, y) = match centres.get(i % groups.max(1)) {
                // Three uniform numbers are bell-shaped enough.
                Some(&(x, y)) => {
                    let mut near = || (0..3).map(|_| random.between(-1.0, 1.0)).sum::<f64>();
                    (
                        (x + near()).clamp(0.3, WIDTH - 0.3),
                        (y + near()).clamp(0.3, HEIGHT - 0.3),
                    )
                }
                None => (
                    random.between(0.3, WIDTH - 0.3),
                    random.between(0.3, HEIGHT - 0.3),
                ),
            };
            let yaw = random.between(-std::f64::consts::PI, std::f64::consts::PI);
            Pose { x, y, yaw }
        })
        .collect()
}

/// Turn, drive, turn, s; nothing is asked of the heading at the last node.
fn drive(poses: &[Pose], from: usize, to: usize, way: Way) -> f64 {
    let Some((length, first, last)) = way else {
        return f64::INFINITY;
    };
    let arrive = if to + 1 == poses.len() {
        0.0
    } else {
        turn(last, poses[to].yaw)
    };
    length / SPEED + turn(poses[from].yaw, first) + arrive
}

/// The costs of a family, and its kind.
fn costs(family: &str, n: usize, random: &mut Random) -> (Vec<Vec<f64>>, &'static str) {
    let rows = |cost: &mut dyn FnMut(usize, usize) -> f64| -> Vec<Vec<f64>> {
        (0..n)
            .map(|a| {
                (0..n)
                    .map(|b| if a == b { 0.0 } else { cost(a, b) })
                    .collect()
            })
            .collect()
    };
    match family {
        "free" | "clusters" => {
            let at = poses(n, if family == "free" { 0 } else { 1 + n / 12 }, random);
            (
                rows(&mut |a, b| drive(&at, a, b, straight(at[a], at[b]))),
                "path",
            )
        }
        "office" | "oneway" => {
            let office = Office::new(random);
            let mut at = Vec::new();
            while at.len() < n {
                let pose = poses(1, 0, random)[0];
                if !office.wall[Office::cell(pose)] {
                    at.push(pose);
                }
            }
            let ways: Vec<Vec<Way>> = (0..n).map(|from| office.ways(&at, from)).collect();
            let mut costs = rows(&mut |a, b| drive(&at, a, b, ways[a][b]));
            if family == "oneway" {
                // One path stays: from the first node through a random order to the last.
                let mut order: Vec<usize> = (1..n - 1).collect();
                for i in (1..order.len()).rev() {
                    order.swap(i, (random.unit() * (i + 1) as f64) as usize);
                }
                order.insert(0, 0);
                order.push(n - 1);
                let mut stays = vec![false; n * n];
                for arc in order.windows(2) {
                    stays[arc[0] * n + arc[1]] = true;
                }
                for a in 0..n {
                    for b in 0..n {
                        if a != b && !stays[a * n + b] && random.unit() < 0.35 {
                            costs[a][b] = f64::INFINITY;
                        }
                    }
                }
            }
            (costs, "path")
        }
        "nearsym" => {
            let at = poses(n, 1 + n / 12, random);
            (
                rows(&mut |a, b| {
                    let (length, first, _) = straight(at[a], at[b]).unwrap_or_default();
                    let away = if a == 0 { turn(at[0].yaw, first) } else { 0.0 };
                    (length / SPEED).max(turn(at[a].yaw, at[b].yaw)) + away
                }),
                "path",
            )
        }
        "regions" => {
            let at = poses(n, 0, random);
            (
                rows(&mut |a, b| (at[a].x - at[b].x).hypot(at[a].y - at[b].y) / SPEED),
                "open",
            )
        }
        "crane" => {
            let from = poses(n, 0, random);
            let to: Vec<(f64, f64)> = from
                .iter()
                .map(|p| {
                    (
                        p.x + random.between(-3.0, 3.0),
                        p.y + random.between(-3.0, 3.0),
                    )
                })
                .collect();
            (
                rows(&mut |a, b| (from[b].x - to[a].0).hypot(from[b].y - to[a].1) / SPEED),
                "closed",
            )
        }
        _ => (rows(&mut |_, _| random.between(0.0, 100.0)), "closed"),
    }
}

/// Numbers of nodes of each family; 110 for `figures`, which leaves a tenth out for its earlier orders.
const FAMILIES: [(&str, &[usize]); 8] = [
    (
        "free",
        &[3, 5, 8, 12, 14, 20, 35, 50, 75, 100, 110, 150, 200, 300],
    ),
    ("clusters", &[4, 10, 14, 25, 50, 100, 110, 200]),
    ("office", &[5, 10, 14, 20, 50, 100, 110, 200, 300]),
    ("nearsym", &[5, 11, 14, 20, 35, 50, 100, 110, 200, 300]),
    ("oneway", &[6, 10, 20, 50, 100, 200]),
    ("regions", &[3, 7, 13, 20]),
    ("uniform", &[5, 12, 20, 50, 100, 200]),
    ("crane", &[12, 50, 100, 200]),
];

const USAGE: &str = "usage: instances FOLDER [--seed N] [--runs N] [--ms N] [--nodes N]";

fn main() -> std::process::ExitCode {
    match write() {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            std::process::ExitCode::from(2)
        }
    }
}

fn write() -> Result<(), String> {
    let mut folder = None;
    let (mut seed, mut runs, mut ms, mut nodes) = (1u64, 8u64, 1000u64, 200usize);
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut number = || {
            let text = args.next().unwrap_or_default();
            text.parse::<u64>()
                .map_err(|_| format!("{arg} needs a whole number, not {text:?}"))
        };
        match arg.as_str() {
            "--seed" => seed = number()?,
            "--runs" => runs = number()?,
            "--ms" => ms = number()?,
            "--nodes" => nodes = number()? as usize,
            _ if arg.starts_with('-') => return Err(format!("unknown option {arg}\n{USAGE}")),
            _ => folder = Some(arg),
        }
    }
    let folder = folder.ok_or(USAGE)?;
    let folder = Path::new(&folder);
    let at = |e: std::io::Error| format!("{}: {e}", folder.display());
    std::fs::create_dir_all(folder).map_err(at)?;
    let mut best = Map::new();
    for (k, (family, sizes)) in FAMILIES.iter().enumerate() {
        for &n in sizes.iter().filter(|&&n| n <= nodes) {
            let mut random = Random(seed.wrapping_mul(1_000_003) ^ (k * 1009 + n) as u64);
            let (mut rows, kind) = costs(family, n, &mut random);
            rows.iter_mut()
                .flatten()
                .for_each(|c| *c = (*c * 1e3).round() / 1e3);
            let end = if kind == "path" { n - 1 } else { 0 };
            let name = format!("{family}-n{n:03}-s{seed}");
            let text = json!({
                "name": name, "family": family, "n": n, "kind": kind, "start": 0, "end": end, "unit": "s", "cost": rows,
            });
            std::fs::write(folder.join(format!("{name}.json")), text.to_string()).map_err(at)?;
            let problem = match kind {
                "path" => Problem::Path { start: 0, end },
                "open" => Problem::Open { start: 0 },
                _ => Problem::Closed,
            };
            let (cost, proven) =
                long_runs(&rows, problem, runs, ms).map_err(|e| format!("{name}: {e}"))?;
            println!("{name}: {cost:.3}{}", if proven { ", proved" } else { "" });
            best.insert(name, json!({ "cost": cost, "proven": proven }));
        }
    }
    let text = serde_json::Value::Object(best).to_string();
    std::fs::write(folder.join("best.json"), text).map_err(at)
}

/// The least cost of so many runs, and whether one of them proved it.
fn long_runs(
    rows: &[Vec<f64>],
    problem: Problem,
    runs: u64,
    ms: u64,
) -> Result<(f64, bool), atsp::Error> {
    let costs = CostMatrix::from_rows(rows)?;
    let (mut best, mut proven) = (f64::INFINITY, false);
    for run in 0..runs {
        let params = Params {
            kicks: u64::MAX,
            seed: 1_000_000 + run,
            proof: Proof::Effort {
                steps: 300,
                branches: 2000,
            },
            ..Params::default()
        };
        let begin = ThreadTime::now();
        let mut late = || begin.elapsed().as_millis() as u64 >= ms;
        let found = Solver::new().solve_watched(&costs, problem, &[], &params, &mut late)?;
        best = best.min(found.cost);
        if found.optimal {
            proven = true;
            break;
        }
    }
    Ok((best, proven))
}
