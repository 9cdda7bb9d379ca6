//! Obstacles that appear during a run, and the larger robot.

use crate::closed::{self, Intruder, Run, Scheme};
use crate::percentile;
use crate::problem::{Instance, Outcome, Problem, X};
use ddp_rbf::{BoxField, Chain, Joint, LinkSphere};
use serde_json::{Value, json};
use std::path::Path;

/// A small generator (splitmix64), so that the cases are the same everywhere.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

/// Two families: a box 0.3 to 0.7 m ahead of a sphere, with inputs that may jump; and one 1.5 m ahead of the base, with
/// limited accelerations, so that the robot must brake along its way.
pub(crate) fn cases(problem: &Problem, instances: &[Instance], count: usize) -> Outcome<Value> {
    let mut out = json!({});
    for (name, limited, ahead) in [
        ("near", false, (0.3, 0.7)),
        ("1.5m_limited", true, (1.5, 1.5)),
    ] {
        let scheme = Scheme {
            limited,
            ..Scheme::standard(0.05)
        };
        let undisturbed = instances
            .iter()
            .map(|i| closed::run(problem, i, &scheme, None))
            .collect::<Outcome<Vec<_>>>()?;
        // Twice as long, since a way around takes longer.
        let scheme = Scheme {
            duration: 2.0 * scheme.duration,
            ..scheme
        };
        let mut random = Random(7);
        let (mut contacts, mut arrived, mut stopped, mut moving) = (0, 0, 0, 0);
        let (mut least, mut braked, mut tried) = (f64::INFINITY, 0, 0);
        // Rooms too small for the distance have no case.
        while arrived + stopped + moving < count && tried < 10 * count {
            let which = tried % instances.len();
            let instance = &instances[which];
            tried += 1;
            let Some(intruder) = place(problem, &undisturbed[which], ahead, &mut random)? else {
                continue;
            };
            let run = closed::run(problem, instance, &scheme, Some(intruder))?;
            contacts += usize::from(run.clearance < 0.0 || run.own < 0.0);
            least = least.min(run.clearance);
            braked += usize::from(run.counts.braked > 0);
            if run.error < closed::ARRIVED {
                arrived += 1;
            } else if run.speed < 0.05 {
                stopped += 1;
            } else {
                moving += 1;
            }
        }
        out[name] = json!({
            "cases": arrived + stopped + moving, "without_room_for_a_box": tried - (arrived + stopped + moving),
            "contacts": contacts, "least_clearance": least, "arrived": arrived, "stopped": stopped,
            "still_moving_at_the_end": moving, "runs_that_braked": braked,
        });
    }
    Ok(out)
}

/// A box in the way of the undisturbed run at about 60 % of it. `None` if 200 tries find no place that leaves the robot the
/// asked distance.
fn place(
    problem: &Problem,
    free: &Run,
    ahead: (f64, f64),
    random: &mut Random,
) -> Outcome<Option<Intruder>> {
    // When 60 % of the way is driven.
    let way: Vec<f64> = free
        .states
        .windows(2)
        .scan(0.0, |sum, pair| {
            *sum += (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
            Some(*sum)
        })
        .collect();
    let total = way.last().copied().unwrap_or(0.0);
    let share = if ahead.0 > 1.0 { 0.2 } else { 0.6 };
    let at = way.iter().position(|&s| s >= share * total).unwrap_or(0);
    let time = (at as f64 * 0.01 / 0.05).floor() * 0.05;
    let at = (time / 0.01).round() as usize;
    let x: X = free.states[at];
    let centers = problem.chain.centers(x.as_slice())?;
    let spheres = problem.chain.spheres();
    for _ in 0..200 {
        let distance = random.within(ahead.0, ahead.1);
        let half = [
            random.within(0.06, 0.16),
            random.within(0.06, 0.16),
            random.within(0.1, 0.5),
        ];
        // Where the run leads, for the base; along a random near-level direction for a sphere of the arm.
        let shape = if ahead.0 > 1.0 {
            let from = way[at.min(way.len() - 1)];
            let Some(there) = way.iter().position(|&s| s >= from + distance + 0.5) else {
                return Ok(None);
            };
            let p = free.states[there];
            [p[0], p[1], half[2], half[0], half[1], half[2]]
        } else {
            let pick = random.within(0.0, (problem.base.len() + problem.arm.len()) as f64) as usize;
            let all: Vec<usize> = problem.base.iter().chain(&problem.arm).copied().collect();
            let i = all[pick.min(all.len() - 1)];
            let next = problem
                .chain
                .centers(free.states[(at + 30).min(free.states.len() - 1)].as_slice())?;
            let mut d = [0, 1, 2].map(|a| next[i][a] - centers[i][a]);
            let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            if length < 1e-3 {
                continue;
            }
            d = d.map(|v| v / length);
            let reach =
                spheres[i].radius + distance + (0..3).map(|a| d[a].abs() * half[a]).sum::<f64>();
            let c = [0, 1, 2].map(|a| centers[i][a] + d[a] * reach);
            [c[0], c[1], c[2].max(half[2]), half[0], half[1], half[2]]
        };
        let alone = BoxField::new(vec![shape], None, problem.beta)?;
        let room = problem
            .base
            .iter()
            .chain(&problem.arm)
            .map(|&i| alone.exact(centers[i]) - spheres[i].radius)
            .fold(f64::INFINITY, f64::min);
        if room >= ahead.0.min(1.2) {
            return Ok(Some(Intruder { time, shape }));
        }
    }
    Ok(None)
}

/// The benchmark's rooms with an arm of 25 spheres and 129 pairs (and the two spheres of the base): CPU time of control
/// steps. The arm stands otherwise than the references mean it, so only times are told.
pub(crate) fn large_robot(
    problem: &Problem,
    instances: &[Instance],
    path: &Path,
) -> Outcome<Value> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let all: Value = serde_json::from_str(&text)?;
    let number = |v: &Value| v.as_f64().ok_or("a number is missing");
    let mut joints = Vec::new();
    for j in all["dh"].as_array().ok_or("dh is missing")? {
        joints.push(Joint {
            d: number(&j["d"])?,
            a: number(&j["a"])?,
            alpha: number(&j["alpha_over_pi"])? * std::f64::consts::PI,
        });
    }
    let mut spheres: Vec<LinkSphere> = problem
        .base
        .iter()
        .map(|&i| problem.chain.spheres()[i])
        .collect();
    let base: Vec<usize> = (0..spheres.len()).collect();
    let first = spheres.len();
    let mut links = Vec::new();
    for s in all["spheres"].as_array().ok_or("spheres are missing")? {
        spheres.push(LinkSphere {
            link: number(&s[0])? as usize,
            center: [number(&s[1])?, number(&s[2])?, number(&s[3])?],
            radius: number(&s[4])?,
        });
        links.push(number(&s[5])? as i64);
    }
    let mut pairs = Vec::new();
    for i in 0..links.len() {
        for j in i + 1..links.len() {
            let (a, b) = (links[i], links[j]);
            if a < 4 && b - a >= 2 && (a, b) != (3, 5) {
                pairs.push((first + i, first + j));
            }
        }
    }
    let mount = &all["arm_mount_xyz"];
    let root = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let origin = [number(&mount[0])?, number(&mount[1])?, number(&mount[2])?];
    let arm: Vec<usize> = (first..spheres.len()).collect();
    let large = Problem {
        chain: Chain::new(true, root, origin, joints, spheres)?,
        base,
        arm,
        pairs,
        ..problem.clone()
    };
    let (mut small_times, mut large_times) = (Vec::new(), Vec::new());
    for instance in instances {
        for (robot, times) in [(problem, &mut small_times), (&large, &mut large_times)] {
            // Without a guard: it would stop the larger robot where it starts in contact.
            let scheme = Scheme {
                guard: false,
                ..Scheme::standard(0.05)
            };
            times.extend(closed::run(robot, instance, &scheme, None)?.times);
        }
    }
    let (a, b) = (percentile(&small_times, 0.5), percentile(&large_times, 0.5));
    Ok(json!({
        "spheres": large.chain.spheres().len(), "pairs": large.pairs.len(),
        "us_per_step_median": b, "us_per_step_p99": percentile(&large_times, 0.99),
        "benchmark_robot_us_per_step_median": a,
        "ratio": b.zip(a).map(|(b, a)| b / a),
    }))
}
