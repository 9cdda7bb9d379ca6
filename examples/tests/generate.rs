//! Scenes made to order: valid, reachable, closed where asked for, the same for the same seed.
#![allow(missing_docs, clippy::unwrap_used)]

use hybrid_astar::grid::Grid;
use hybrid_astar::{GridParams, Space};
use seekplan::generate::{Blueprint, BlueprintError, Layout};
use seekplan::scene::{Scene, Solid};
use seekplan::sim::{GroundTruth, World};

/// Ground cells of 0.1 m that touch what stands lower than 1.2 m.
fn ground(scene: &Scene) -> Grid {
    let size = [0, 1].map(|k| (scene.bounds.max[k] / 0.1).ceil() as usize);
    let mut blocked = vec![false; size[0] * size[1]];
    for solid in scene
        .shapes
        .iter()
        .map(Solid::new)
        .filter(|s| s.low[2] < 1.2)
    {
        let cells = |k: usize| {
            let low = (solid.low[k] / 0.1 + 1e-6).floor() as usize;
            let high = ((solid.high[k] / 0.1 - 1e-6).ceil() as usize).min(size[k]);
            low..high
        };
        for y in cells(1) {
            for x in cells(0) {
                blocked[y * size[0] + x] = true;
            }
        }
    }
    Grid::new(size, 0.1, [0.0; 2], &blocked).unwrap()
}

#[test]
fn every_room_can_be_reached_by_a_base() {
    for layout in Layout::ALL {
        for seed in 1..=4 {
            let blueprint = Blueprint {
                layout,
                size: [21.0 + seed as f64, 14.5],
                seed,
                tags: 4,
                ..Blueprint::default()
            };
            let scene = blueprint.build().unwrap();
            let map = ground(&scene);
            let space = Space::new(&map, 0.35, &GridParams::default()).unwrap();
            let start = [scene.start.x, scene.start.y];
            let ways = space.field(start).unwrap();
            for room in &scene.rooms {
                // Somewhere in each room, and in most of it.
                let points: Vec<[f64; 2]> = (0..400)
                    .map(|i| [i % 20, i / 20].map(|k| (f64::from(k) + 0.5) / 20.0))
                    .map(|s| [0, 1].map(|k| room.min[k] + s[k] * (room.max[k] - room.min[k])))
                    .collect();
                let fits = |p: &&[f64; 2]| hybrid_astar::Map::clearance(&map, **p) > 0.45;
                let free = points.iter().filter(fits).count();
                let reached = points
                    .iter()
                    .filter(fits)
                    .filter(|p| ways.distance_near(**p, 0.15).is_finite())
                    .count();
                assert!(free > 20, "{}: {} has no room", scene.name, room.name);
                assert_eq!(reached, free, "{}: {}", scene.name, room.name);
            }
        }
    }
}

#[test]
fn a_scene_made_to_order_is_valid_and_the_same_again() {
    for layout in Layout::ALL {
        let blueprint = Blueprint {
            layout,
            size: [18.0, 12.0],
            ..Blueprint::default()
        };
        let scene = blueprint.build().unwrap();
        assert_eq!(scene.tags.len(), 8);
        let text = serde_json::to_string(&scene).unwrap();
        assert_eq!(Scene::from_json(&text).unwrap(), scene);
        assert_eq!(blueprint.build().unwrap(), scene);
        let other = Blueprint {
            seed: 2,
            ..blueprint
        };
        assert_ne!(other.build().unwrap().shapes, scene.shapes);
    }
}

#[test]
fn a_closed_room_is_not_entered_and_holds_no_target() {
    for layout in [Layout::Rooms, Layout::Maze] {
        for seed in 1..=3 {
            let blueprint = Blueprint {
                layout,
                size: [18.0, 12.0],
                closed_room: true,
                seed,
                ..Blueprint::default()
            };
            let scene = blueprint.build().unwrap();
            let [name] = &scene.closed_areas[..] else {
                panic!("one room is closed: {:?}", scene.closed_areas);
            };
            let room = scene.rooms.iter().find(|r| &r.name == name).unwrap();
            let truth = GroundTruth::new(&scene, &World::new(&scene), 0.15).unwrap();
            let inside = |p: [f64; 2]| (0..2).all(|k| room.min[k] < p[k] && p[k] < room.max[k]);
            let [nx, ny, nz] = truth.size();
            for i in 0..nx * ny * nz {
                let cell = [i % nx, i / nx % ny, i / nx / ny].map(|v| v as i32);
                let middle = [0, 1].map(|k| (f64::from(cell[k]) + 0.5) * 0.15);
                assert!(!(inside(middle) && truth.is_reachable(cell)), "{cell:?}");
            }
            for tag in &scene.tags {
                assert!(!inside([tag.center[0], tag.center[1]]), "tag {}", tag.id);
            }
        }
    }
}

#[test]
fn what_cannot_be_built_is_refused() {
    let small = Blueprint {
        size: [6.0, 6.0],
        ..Blueprint::default()
    };
    let refused = |blueprint: Blueprint| match blueprint.build() {
        Err(error) => error,
        Ok(scene) => panic!("{} was built", scene.name),
    };
    for (size, field) in [([5.0, 8.0], "size[0]"), ([8.0, f64::NAN], "size[1]")] {
        let error = refused(Blueprint { size, ..small });
        assert!(error.to_string().starts_with(field), "{error}");
    }
    let error = refused(Blueprint { door: 0.5, ..small });
    assert!(error.to_string().contains("between 0.8 and 2 m"), "{error}");
    let hall = Blueprint {
        layout: Layout::Aisles,
        closed_room: true,
        ..small
    };
    assert_eq!(refused(hall), BlueprintError::NoRoomToClose);
    let crowd = Blueprint { tags: 500, ..small };
    let BlueprintError::TooFewPlaces { found, wanted } = refused(crowd) else {
        panic!("too few places");
    };
    assert!(found < wanted);
}

#[test]
fn a_large_building_is_made() {
    let scene = Blueprint {
        size: [200.0, 200.0],
        closed_room: true,
        ..Blueprint::default()
    }
    .build()
    .unwrap();
    assert!(scene.rooms.len() > 1000 && scene.shapes.len() > 10_000);
    assert!(scene.limits.time_limit > 900.0);
}
