//! The planner against dynamic programming on dense grids of joint angle and time.
#![allow(missing_docs, clippy::unwrap_used)]

use strrt::{Params, Planner, Robot, Status, Variant};

/// Joint speed, rad/s, and time step, s.
const SPEED: f64 = 1.0;
const DT: f64 = 0.1;

/// Bars and discs over time.
struct World<const N: usize, F>(F);

impl<const N: usize, F: Fn(&[f64; N], usize) -> bool> Robot<N> for World<N, F> {
    fn limits(&self) -> [(f64, f64); N] {
        [(-1.0, 1.0); N]
    }
    fn max_speed(&self) -> [f64; N] {
        [SPEED; N]
    }
    fn is_valid(&self, q: &[f64; N], step: usize) -> bool {
        (self.0)(q, step)
    }
    fn is_motion_valid(&self, _: &[f64; N], _: &[f64; N], _: usize, _: usize) -> bool {
        true // as the grid sees it: states at steps
    }
}

/// Least cost over a grid of `cells + 1` angles per joint: an upper bound of the optimum that tends to it.
fn grid<const N: usize>(
    arm: &impl Robot<N>,
    start: [f64; N],
    goal: [f64; N],
    steps: usize,
    cells: i32,
) -> f64 {
    let size = 2.0 / f64::from(cells);
    let count = (cells + 1).pow(N as u32);
    let reach = (SPEED * DT / size + 1e-9).floor() as i32;
    let place = |index: i32| -> [i32; N] {
        let mut rest = index;
        std::array::from_fn(|_| {
            let i = rest % (cells + 1);
            rest /= cells + 1;
            i
        })
    };
    let angle = |at: [i32; N]| at.map(|i| -1.0 + f64::from(i) * size);
    let index_of = |q: [f64; N]| {
        q.iter().rev().fold(0, |index, a| {
            index * (cells + 1) + ((a + 1.0) / size).round() as i32
        })
    };
    let mut costs = vec![f64::INFINITY; count as usize];
    costs[index_of(start) as usize] = 0.0;
    for step in 1..steps {
        let mut next = vec![f64::INFINITY; count as usize];
        for index in 0..count {
            let at = place(index);
            if !arm.is_valid(&angle(at), step) {
                continue;
            }
            let moves = (2 * reach + 1).pow(N as u32);
            for m in 0..moves {
                let mut rest = m;
                let (mut from, mut square, mut inside) = (0, 0.0, true);
                let mut scale = 1;
                for j in 0..N {
                    let d = rest % (2 * reach + 1) - reach;
                    rest /= 2 * reach + 1;
                    let i = at[j] + d;
                    inside &= (0..=cells).contains(&i);
                    from += i * scale;
                    scale *= cells + 1;
                    square += (f64::from(d) * size).powi(2);
                }
                if inside && costs[from as usize].is_finite() {
                    let cost = costs[from as usize] + f64::sqrt(square);
                    next[index as usize] = next[index as usize].min(cost);
                }
            }
        }
        costs = next;
    }
    costs[index_of(goal) as usize]
}

fn best<const N: usize>(
    arm: &impl Robot<N>,
    start: [f64; N],
    goal: [f64; N],
    steps: usize,
    variant: Variant,
    iterations: usize,
) -> f64 {
    let params = Params {
        variant,
        max_wait: 0,
        ..Params::default()
    };
    let mut planner = Planner::new(arm, start, goal, steps, DT, &params, 1).unwrap();
    planner.step(iterations);
    assert_eq!(planner.plan().status, Status::Solved);
    planner.cost()
}

#[test]
fn one_joint_under_and_over_bars() {
    // Up past a bar, down under the next, up again.
    let arm = World(|q: &[f64; 1], step: usize| match step {
        10..14 => q[0] > 0.3,
        22..26 => q[0] < -0.2,
        34..38 => q[0] > 0.5,
        _ => true,
    });
    let exact = grid(&arm, [0.0], [0.0], 50, 200);
    for variant in [Variant::MultiStep, Variant::Bidirectional] {
        let found = best(&arm, [0.0], [0.0], 50, variant, 4000);
        assert!(
            found <= 1.02 * exact,
            "{variant:?}: {found} against {exact}"
        );
        // Bars are open, the grid has cells of 0.01 rad: six corners.
        assert!(found >= exact - 0.06);
    }
}

#[test]
fn two_joints_around_discs() {
    let arm = World(|q: &[f64; 2], step: usize| {
        let near = |c: [f64; 2], r: f64| (q[0] - c[0]).hypot(q[1] - c[1]) <= r;
        !(near([0.0, 0.0], 0.4)
            || (10..20).contains(&step) && near([-0.5, 0.5], 0.4)
            || (15..30).contains(&step) && near([0.4, -0.5], 0.45))
    });
    let exact = grid(&arm, [-0.8, 0.0], [0.8, 0.0], 36, 40);
    for variant in [Variant::MultiStep, Variant::Bidirectional] {
        let found = best(&arm, [-0.8, 0.0], [0.8, 0.0], 36, variant, 6000);
        assert!(
            found <= 1.02 * exact,
            "{variant:?}: {found} against {exact}"
        );
    }
}

#[test]
fn the_published_variant_finds_its_way_too() {
    let arm = World(|q: &[f64; 1], step: usize| !(4..6).contains(&step) || q[0] > 0.2);
    let exact = grid(&arm, [0.0], [0.0], 10, 200);
    let found = best(&arm, [0.0], [0.0], 10, Variant::Published, 20_000);
    assert!(found <= 1.2 * exact, "{found} against {exact}");
}
