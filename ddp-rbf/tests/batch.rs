//! Whole horizons at once give what one knot after the other gives, for every built-in group and field.
#![allow(missing_docs, clippy::unwrap_used)]

use ddp_rbf::nalgebra::{SMatrix, SVector};
use ddp_rbf::{
    Barrier, BoxField, Chain, Constraint, DriveArm, Expansion, Field, GridField, HalfSpaces,
    Horizon, InputBox, Joint, LANES, LinkSphere, PairClearance, PlaneClearance, Robot,
    SphereClearance, StateBox, check_constraint, check_step,
};
use proptest::prelude::*;
use std::f64::consts::FRAC_PI_2;

type X = SVector<f64, 6>;
type U = SVector<f64, 5>;

/// A planar base with three joints of mixed twists.
fn chain(planar: bool) -> Chain {
    let joint = |d, a, alpha| Joint { d, a, alpha };
    let sphere = |link, center, radius| LinkSphere {
        link,
        center,
        radius,
    };
    let (s, c) = 0.7f64.sin_cos();
    Chain::new(
        planar,
        [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]],
        [0.1, -0.05, 0.4],
        vec![
            joint(0.2, 0.0, FRAC_PI_2),
            joint(0.0, -0.4, 0.3),
            joint(0.1, 0.2, -FRAC_PI_2),
        ],
        vec![
            sphere(3, [0.05, 0.02, 0.1], 0.08),
            sphere(0, [0.2, 0.0, 0.2], 0.3),
            sphere(1, [0.0, 0.1, 0.05], 0.1),
            sphere(2, [0.2, 0.0, 0.0], 0.09),
            sphere(0, [-0.2, 0.0, 0.2], 0.3),
        ],
    )
    .unwrap()
}

const BOXES: [[f64; 6]; 2] = [
    [1.5, 0.2, 0.5, 0.2, 0.4, 0.5],
    [-1.0, -1.2, 0.3, 0.5, 0.1, 0.3],
];

fn boxes() -> BoxField {
    BoxField::new(BOXES.to_vec(), Some(0.0), 50.0).unwrap()
}

fn agree<const NX: usize, const NU: usize>(
    group: &dyn Constraint<NX, NU>,
    states: &[SVector<f64, NX>],
    inputs: &[SVector<f64, NU>],
) -> Result<(), TestCaseError> {
    let along = Horizon {
        states,
        inputs,
        weight: 0.1,
    };
    let mut models = vec![Expansion::zeros(); states.len()];
    let found = group.penalize(&along, Some(&mut models));
    let silent = group.penalize(&along, None);
    prop_assert!((found.sum - silent.sum).abs() <= 1e-12 * (1.0 + found.sum.abs()));
    let barrier = group.barrier();
    let (mut sum, mut least) = (0.0, f64::INFINITY);
    for (k, x) in states.iter().enumerate() {
        let mut e = Expansion::<NX, NU>::zeros();
        let w = 0.1;
        group.rows(k, x, inputs.get(k), &mut |z, zx, zu| {
            if k == 0 && zu.iter().all(|&v| v == 0.0) {
                return;
            }
            let (value, slope, curvature) = barrier.eval(z);
            sum += w * value;
            least = least.min(z);
            let zx = if k > 0 { *zx } else { SVector::zeros() };
            e.x += zx * (w * slope);
            e.u += zu * (w * slope);
            e.xx += zx * zx.transpose() * (w * curvature);
            e.uu += zu * zu.transpose() * (w * curvature);
            e.ux += zu * zx.transpose() * (w * curvature);
        });
        let m = &models[k];
        let scale = 1.0 + e.xx.amax() + e.uu.amax();
        prop_assert!((m.x - e.x).amax() < 1e-10 * scale, "{k}: {} {}", m.x, e.x);
        prop_assert!((m.u - e.u).amax() < 1e-10 * scale);
        prop_assert!(
            (m.xx - e.xx).amax() < 1e-10 * scale,
            "{k}: {} {}",
            m.xx,
            e.xx
        );
        prop_assert!((m.uu - e.uu).amax() < 1e-10 * scale);
        prop_assert!((m.ux - e.ux).amax() < 1e-10 * scale);
    }
    prop_assert!(
        (found.sum - sum).abs() < 1e-11 * (1.0 + sum.abs()),
        "{} {sum}",
        found.sum
    );
    // What lies beyond a cut-off need not be told.
    let end = barrier.cutoff.unwrap_or(f64::INFINITY);
    if found.least < end || least < end {
        prop_assert!(
            (found.least - least).abs() < 1e-12,
            "{} {least}",
            found.least
        );
    }
    Ok(())
}

fn states() -> impl Strategy<Value = (Vec<X>, Vec<U>)> {
    let x = prop::array::uniform6(-2.0..2.0f64);
    let u = prop::array::uniform5(-1.2..1.2f64);
    // Twelve knots after the first: the second group of eight is not full.
    (
        prop::collection::vec(x, 13).prop_map(|v| v.into_iter().map(X::from).collect()),
        prop::collection::vec(u, 12).prop_map(|v| v.into_iter().map(U::from).collect()),
    )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    /// Boxes, half-spaces and clearances, with and without a cut-off, on both sides of delta.
    #[test]
    fn horizons_agree_with_knots((states, inputs) in states(), cutoff in prop::option::of(0.05..0.6f64)) {
        let barrier = Barrier { cutoff, ..Barrier::default() };
        let chain = chain(true);
        let field = boxes();
        let groups: [&dyn Constraint<6, 5>; 7] = [
            &InputBox::new(U::from_element(-1.0), U::from_element(1.0), barrier)
                .reachable_from(U::from_element(0.1), U::from_element(0.3)),
            &StateBox { limits: vec![(1, -1.0, 1.0), (3, -1.5, 1.0), (4, -1.0, 1.5), (5, -3.0, 3.0), (0, -2.0, 2.0)], barrier },
            &HalfSpaces::new(
                vec![(X::from_element(0.2), U::zeros(), 1.0), (X::zeros(), U::from_element(-0.3), 1.0)], barrier).unwrap(),
            &SphereClearance {
                chain: &chain, field: &field, spheres: &[0, 1, 2, 3, 4], margin: 0.02, on_base: false, barrier, name: "field" },
            &SphereClearance {
                chain: &chain, field: &field, spheres: &[3, 0], margin: 0.02, on_base: true, barrier, name: "on base" },
            &PlaneClearance {
                chain: &chain, planes: &[[0.0, 0.0, 1.0, 0.0], [0.6, 0.8, 0.0, 1.0]], spheres: &[0, 2, 3], margin: 0.0, barrier, name: "planes" },
            &PairClearance { chain: &chain, pairs: &[(0, 1), (4, 0), (2, 3), (1, 3), (0, 2)], margin: 0.01, barrier, name: "pairs" },
        ];
        for group in groups {
            agree(group, &states, &inputs)?;
        }
    }

    /// An arm of seven joints, so that the models of a knot do not fit one vector, in a state that is longer still.
    #[test]
    fn long_states_agree(
        states in prop::collection::vec(prop::array::uniform11(-1.5..1.5f64), 11), cutoff in prop::option::of(0.05..0.6f64),
    ) {
        let states: Vec<SVector<f64, 11>> = states.into_iter().map(SVector::from).collect();
        let inputs = vec![SVector::<f64, 10>::zeros(); 10];
        let barrier = Barrier { cutoff, ..Barrier::default() };
        let joints = (0..7).map(|i| Joint { d: 0.1, a: 0.05 * f64::from(i), alpha: FRAC_PI_2 * f64::from(i % 3 - 1) });
        let spheres = (0..=7).map(|link| LinkSphere { link, center: [0.02, 0.01 * link as f64, 0.05], radius: 0.06 });
        let root = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let chain = Chain::new(true, root, [0.1, 0.0, 0.5], joints.collect(), spheres.collect()).unwrap();
        let field = boxes();
        let groups: [&dyn Constraint<11, 10>; 4] = [
            &SphereClearance {
                chain: &chain, field: &field, spheres: &[0, 3, 5, 7], margin: 0.02, on_base: false, barrier, name: "field" },
            &SphereClearance {
                chain: &chain, field: &field, spheres: &[7, 6], margin: 0.02, on_base: true, barrier, name: "on base" },
            &PlaneClearance {
                chain: &chain, planes: &[[0.0, 0.6, 0.8, 1.0]], spheres: &[7, 2], margin: 0.0, barrier, name: "planes" },
            &PairClearance { chain: &chain, pairs: &[(0, 7), (6, 1), (2, 5), (3, 7)], margin: 0.01, barrier, name: "pairs" },
        ];
        for group in groups {
            agree(group, &states, &inputs)?;
        }
    }

    /// The gradients of every group are those of its values; the field is smooth away from medial surfaces.
    #[test]
    fn gradients_match_differences((states, inputs) in states()) {
        let barrier = Barrier::default();
        for planar in [true, false] {
            let chain = chain(planar);
            let planes = PlaneClearance {
                chain: &chain, planes: &[[0.0, 0.0, 1.0, 0.0]], spheres: &[0, 2, 3], margin: 0.0, barrier, name: "planes" };
            let pairs = PairClearance { chain: &chain, pairs: &[(0, 1), (2, 3), (1, 3)], margin: 0.0, barrier, name: "pairs" };
            let groups: [&dyn Constraint<6, 5>; 2] = [&planes, &pairs];
            for group in groups {
                check_constraint(group, 1, &states[1], Some(&inputs[1]), 1e-6).unwrap();
            }
        }
    }

    /// A field of one ball has its gradient everywhere.
    #[test]
    fn sphere_gradients_match_differences((states, _) in states()) {
        struct Ball;
        impl Field for Ball {
            fn distance_gradient(&self, p: [f64; 3]) -> (f64, [f64; 3]) {
                let d = [p[0] - 6.0, p[1] + 5.0, p[2] - 4.0];
                let r = d.iter().map(|v| v * v).sum::<f64>().sqrt();
                (r - 1.0, d.map(|v| v / r))
            }
        }
        for planar in [true, false] {
            let chain = chain(planar);
            let group = SphereClearance {
                chain: &chain, field: &Ball, spheres: &[0, 1, 2, 3, 4], margin: 0.0, on_base: false,
                barrier: Barrier::default(), name: "ball" };
            check_constraint::<6, 5>(&group, 1, &states[1], None, 1e-6).unwrap();
        }
    }

    /// The drive's batch of sensitivities is that of its step.
    #[test]
    fn drives_linearize_exactly((states, inputs) in states()) {
        check_step(&DriveArm, &states[0], &inputs[0], 0.1, 1e-7).unwrap();
        let mut all = vec![ddp_rbf::Linear { a: SMatrix::zeros(), b: SMatrix::zeros() }; 12];
        DriveArm.linearize_all(&states[..12], &inputs, 0.1, &mut all);
        for k in 0..12 {
            let (a, b) = DriveArm.linearize(&states[k], &inputs[k], 0.1);
            prop_assert!((all[k].a - a).amax() < 1e-14 && (all[k].b - b).amax() < 1e-14);
            // The step is the classical Runge-Kutta one.
            let step = ddp_rbf::ode::rk4(&DriveArm, &states[k], &inputs[k], 0.1);
            prop_assert!((step - DriveArm.step(&states[k], &inputs[k], 0.1)).amax() < 1e-14);
        }
    }

    /// The soft minimum lies below the exact one by at most ln(n) / beta, in batches and one by one, and its gradient is
    /// that of its value away from faces that tie.
    #[test]
    fn soft_boxes_are_conservative(p in prop::array::uniform3(-2.0..2.0f64)) {
        let field = boxes();
        let (d, gradient) = field.distance_gradient(p);
        let exact = field.exact(p);
        // The smoothed root adds at most 1e-6.
        prop_assert!(d <= exact + 1e-6 && d >= exact - 3f64.ln() / 50.0 - 1e-9, "{d} {exact}");
        let mut out = [[[0.0; LANES]; 4]; 2];
        field.batch(&[p.map(|v| [v; LANES]), [[0.3; LANES], [0.1; LANES], [1.0; LANES]]], &mut out);
        prop_assert_eq!(out[0][0][2], d);
        for a in 0..3 {
            prop_assert_eq!(out[0][1 + a][1], gradient[a]);
        }
        let h = 1e-6;
        let slopes: [f64; 3] = std::array::from_fn(|a| {
            let (mut high, mut low) = (p, p);
            high[a] += h;
            low[a] -= h;
            (field.distance(high) - field.distance(low)) / (2.0 * h)
        });
        // Next to an edge or a medial surface a difference straddles the kink; rarer than one in a thousand here.
        let off = (0..3).any(|a| (slopes[a] - gradient[a]).abs() > 1e-4);
        let near_kink = BOXES.iter().any(|b| {
            let q = [0, 1, 2].map(|a| (p[a] - b[a]).abs() - b[3 + a]);
            q.iter().any(|v| v.abs() < 1e-4) || q.iter().all(|&v| v < 0.0)
        });
        prop_assert!(!off || near_kink, "{slopes:?} {gradient:?}");
    }

    /// Trilinear values meet the voxels' own, gradients are those of the interpolant, and outside the value falls with the
    /// way to the grid.
    #[test]
    fn grids_interpolate(values in prop::collection::vec(-1.0..2.0f32, 60), p in prop::array::uniform3(-0.5..1.2f64)) {
        let (low, cell, size) = ([0.1, -0.2, 0.0], 0.2, [3, 4, 5]);
        let grid = GridField::new(low, cell, size, values.clone()).unwrap();
        for (i, v) in values.iter().enumerate() {
            let at = [i % 3, (i / 3) % 4, i / 12];
            let center = [0, 1, 2].map(|a| low[a] + at[a] as f64 * cell);
            prop_assert!((grid.distance(center) - f64::from(*v)).abs() < 1e-6);
        }
        let (d, gradient) = grid.distance_gradient(p);
        let inside = [0, 1, 2].map(|a| p[a].clamp(low[a], low[a] + (size[a] - 1) as f64 * cell));
        let way = [0, 1, 2].map(|a| p[a] - inside[a]).iter().map(|v| v * v).sum::<f64>().sqrt();
        prop_assert!((d - (grid.distance(inside) - way)).abs() < 1e-9);
        let h = 1e-7;
        for a in 0..3 {
            let t = (p[a] - low[a]) / cell;
            // At cell faces the slope jumps.
            if (t - t.round()).abs() > 1e-5 {
                let (mut high, mut below) = (p, p);
                high[a] += h;
                below[a] -= h;
                let slope = (grid.distance(high) - grid.distance(below)) / (2.0 * h);
                prop_assert!((slope - gradient[a]).abs() < 1e-5 * (1.0 + slope.abs()), "{slope} {}", gradient[a]);
            }
        }
    }

    /// A batch of a grid gives what single queries give, within the grid and beyond it.
    #[test]
    fn grids_answer_batches(
        values in prop::collection::vec(-1.0..2.0f32, 60),
        points in prop::collection::vec(prop::array::uniform8(-0.6..1.3f64), 3),
    ) {
        let grid = GridField::new([0.1, -0.2, 0.0], 0.2, [3, 4, 5], values).unwrap();
        let mut out = [[[0.0; LANES]; 4]];
        grid.batch(&[[points[0], points[1], points[2]]], &mut out);
        for lane in 0..LANES {
            let (d, g) = grid.distance_gradient([points[0][lane], points[1][lane], points[2][lane]]);
            prop_assert!((out[0][0][lane] - d).abs() < 1e-12);
            for a in 0..3 {
                prop_assert!((out[0][1 + a][lane] - g[a]).abs() < 1e-10, "{} {}", out[0][1 + a][lane], g[a]);
            }
        }
    }
}
