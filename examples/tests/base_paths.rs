//! The base gets from anywhere to anywhere: ways across the whole of a scene, with the planner as the search uses it.

use hybrid_astar::grid::Grid;
use hybrid_astar::{Footprint, GoalYaw, Limits, Map, Params, Planner, Status};
use robots::MobileManipulator;
use seekplan::generate::Blueprint;
use seekplan::scene::Scene;
use seekplan::sim::{GroundTruth, World};

/// What stands in the base's way, seen from above.
fn ground(scene: &Scene) -> Grid {
    let truth = GroundTruth::new(scene, &World::new(scene), scene.limits.voxel).expect("fits");
    let [nx, ny, _] = truth.size();
    let blocked: Vec<bool> = (0..nx * ny)
        .map(|i| (1..10).any(|z| truth.is_solid([(i % nx) as i32, (i / nx) as i32, z])))
        .collect();
    let low = [scene.bounds.min[0], scene.bounds.min[1]];
    Grid::new([nx, ny], truth.cell_size(), low, &blocked).expect("a grid")
}

/// The planner as the search sets it up.
fn planner() -> Planner {
    let params = Params {
        limits: Limits {
            v: 0.76,
            w: 0.9,
            a: 0.72,
            alpha: 1.8,
        },
        margin: 0.04,
        max_expansions: 20_000,
        reverse_factor: 1.05,
        reverse_reach: 6.0,
        ..Params::default()
    };
    Planner::new(params).expect("good settings")
}

/// Places spread evenly, with room to turn.
fn places(map: &Grid, count: u32) -> Vec<[f64; 2]> {
    let (low, high) = map.bounds();
    (1..count)
        .map(|i| {
            let share = [0.754_877_666, 0.569_840_291].map(|s: f64| (f64::from(i) * s).fract());
            [0, 1].map(|k| low[k] + share[k] * (high[k] - low[k]))
        })
        .filter(|&p| map.clearance(p) >= 0.6)
        .collect()
}

/// Plans from place to place, from both ends of the list to its middle.
fn all_are_joined(name: &str, map: &Grid, places: &[[f64; 2]]) {
    let robot = MobileManipulator::default();
    let footprint = Footprint::circles(robot.base_circles());
    let mut planner = planner();
    for (i, (from, to)) in places.iter().zip(places.iter().rev()).enumerate().take(40) {
        let start = [from[0], from[1], i as f64];
        let p = planner
            .plan(map, &footprint, start, *to, &GoalYaw::Free)
            .expect("good input");
        let reason = p.reason.as_ref().map(ToString::to_string);
        assert_eq!(
            p.status,
            Status::Solved,
            "{name}: {start:?} to {to:?}: {reason:?}"
        );
    }
}

#[test]
fn no_way_across_a_scene_is_too_long() {
    for name in ["maze", "office"] {
        let scene = Scene::builtin(name).expect("embedded");
        let map = ground(&scene);
        all_are_joined(name, &map, &places(&map, 400));
    }
}

/// Of 0.9 m the voxels leave 0.75 m, wherever the door lies on their grid; the base is 0.55 m wide.
#[test]
fn doors_of_0_9_m_are_passed() {
    for seed in 1..=5 {
        let scene = Blueprint {
            size: [15.0, 11.0],
            tags: 0,
            seed,
            ..Blueprint::default()
        }
        .build()
        .expect("large enough");
        let map = ground(&scene);
        all_are_joined(&scene.name, &map, &places(&map, 200));
    }
}
