//! One case for each thing that goes wrong.
#![allow(missing_docs, clippy::unwrap_used)]

mod worlds;

use viewsample::grid::{Grid, Mast};
use viewsample::{
    Changes, Cluster, CostModel, Error, Frustum, Kind, NoView, Params, Pose, Sampler, View,
    postures,
};
use worlds::*;

const HOME: [f64; 3] = [1.0, 1.5, 0.0];
const LEVEL: [f64; 2] = [1.0, 0.0];

/// A room with an unseen east end, and the cluster in front of it.
fn room() -> (Grid, Vec<viewsample::Cell>) {
    let wall = "#".repeat(22);
    let row = format!("#{}??\n", ".".repeat(19));
    let map = Grid::parse(&format!("{wall}\n{}{wall}", row.repeat(8)), 8, 0.3);
    let cells = map.exploration();
    (map, cells)
}

fn opening(cells: &[viewsample::Cell]) -> Cluster<'_> {
    Cluster {
        id: 7,
        kind: Kind::Exploration,
        cells,
        centroid: [5.85, 1.5, 1.2],
    }
}

fn sampler_of(map: &Grid, params: &Params, clusters: &[Cluster<'_>]) -> Sampler<[f64; 2]> {
    let mut sampler = Sampler::new(params, solved(map, params)).unwrap();
    sampler
        .update(
            map,
            &Changes {
                added: clusters,
                boxes: &[map.bounds()],
                ..Changes::default()
            },
        )
        .unwrap();
    sampler
}

#[test]
fn no_clusters_no_views() {
    let (map, _) = room();
    let mut empty = Sampler::new(&params(), solved(&map, &params())).unwrap();
    let found = empty.candidates(&mast(&map), &COSTS, HOME, &LEVEL).unwrap();
    assert!(found.views.is_empty() && found.without.is_empty() && empty.is_empty());
    assert_eq!(
        empty
            .gain_at(HOME, &Pose::looking([0.0; 3], 0.0, 0.0))
            .unwrap(),
        Default::default()
    );
    assert_eq!(
        empty
            .near_best(1, 0.8, 9, &mast(&map), &COSTS, HOME, &LEVEL)
            .unwrap(),
        []
    );
    let retried = empty
        .retry(&[1, 2], &mast(&map), &COSTS, HOME, &LEVEL)
        .unwrap();
    assert!(retried.views.is_empty() && retried.without.is_empty());
}

#[test]
fn an_empty_cluster_is_too_little() {
    let (map, _) = room();
    let mut sampler = sampler_of(&map, &params(), &[opening(&[])]);
    let found = sampler
        .candidates(&mast(&map), &COSTS, HOME, &LEVEL)
        .unwrap();
    assert_eq!(found.without, [(7, NoView::TooLittleSeen)]);
}

#[test]
fn an_unknown_map_has_no_free_base() {
    let map = Grid::unknown([20, 10, 8], 0.3);
    let cells = [[10, 5, 3]; 1];
    let cluster = Cluster {
        id: 1,
        kind: Kind::Exploration,
        cells: &cells,
        centroid: [3.0, 1.5, 1.0],
    };
    let params = Params {
        threshold: 0.1,
        ..params()
    };
    let mut sampler = sampler_of(&map, &params, &[cluster]);
    let found = sampler
        .candidates(&mast(&map), &COSTS, HOME, &LEVEL)
        .unwrap();
    assert_eq!(found.without, [(1, NoView::NoFreeBase)]);
}

#[test]
fn a_low_ceiling_has_no_free_body() {
    let (mut map, _) = room();
    for c in map.all() {
        if c[2] >= 2 && c[2] < 7 {
            map.set(c, b'#');
        }
    }
    let cells = map.exploration();
    let tall = Params {
        views: vec![View {
            pitch: 0.0,
            height: 1.0,
        }],
        threshold: 0.1,
        ..params()
    };
    let mut sampler = sampler_of(&map, &tall, &[opening(&cells)]);
    let found = sampler
        .candidates(&mast(&map), &COSTS, HOME, &LEVEL)
        .unwrap();
    assert_eq!(found.without, [(7, NoView::NoFreeBody)]);
}

#[test]
fn a_cost_of_never_excludes() {
    struct Never;
    impl CostModel<[f64; 2]> for Never {
        fn seconds(&self, _: (&[f64; 3], &[f64; 2]), to: (&[f64; 3], &[f64; 2])) -> f64 {
            if to.0[1] > 1.5 {
                f64::NAN
            } else {
                f64::INFINITY
            }
        }
    }
    let (map, cells) = room();
    let mut sampler = sampler_of(&map, &params(), &[opening(&cells)]);
    let found = sampler
        .candidates(&mast(&map), &Never, HOME, &LEVEL)
        .unwrap();
    assert_eq!(found.without, [(7, NoView::Unreachable)]);
}

/// G contains exp(-0.5 t): a threshold on it would delete far rooms (checks that it is on G_info).
#[test]
fn a_far_cluster_keeps_its_view() {
    let (map, cells) = room();
    let mut sampler = sampler_of(&map, &params(), &[opening(&cells)]);
    for distance in [0.0, 100.0, 1e4, 1e6] {
        let home = [1.0 - distance, 1.5, 0.0];
        let found = sampler
            .candidates(&mast(&map), &COSTS, home, &LEVEL)
            .unwrap();
        assert_eq!(found.views.len(), 1, "{distance} m away");
        assert!(found.views[0].gain.info >= 2.0);
    }
}

#[test]
fn without_lidar_only_the_camera_counts() {
    let (map, cells) = room();
    let blind = Params {
        lidar: None,
        ..params()
    };
    let (with, without) = (
        sampler_of(&map, &params(), &[opening(&cells)]),
        sampler_of(&map, &blind, &[opening(&cells)]),
    );
    let backwards = Pose::looking([3.0, 1.5, 1.0], std::f64::consts::PI, 0.0);
    assert!(
        with.gain_at([3.0, 1.5, 0.0], &backwards)
            .unwrap()
            .exploration
            > 0
    );
    assert_eq!(
        without
            .gain_at([3.0, 1.5, 0.0], &backwards)
            .unwrap()
            .exploration,
        0
    );
    let forwards = Pose::looking([4.0, 1.5, 1.0], 0.0, 0.0);
    assert!(
        without
            .gain_at([4.0, 1.5, 0.0], &forwards)
            .unwrap()
            .exploration
            > 0
    );
}

#[test]
fn the_last_try_takes_one_voxel_and_wider_rings() {
    let (map, cells) = room();
    let lonely = [cells[20]];
    let cluster = opening(&lonely);
    let mut sampler = sampler_of(&map, &params(), &[cluster]);
    let found = sampler
        .candidates(&mast(&map), &COSTS, HOME, &LEVEL)
        .unwrap();
    assert_eq!(found.without, [(7, NoView::TooLittleSeen)]);
    let retried = sampler
        .retry(&[7, 7, 99], &mast(&map), &COSTS, HOME, &LEVEL)
        .unwrap();
    assert_eq!((retried.views.len(), retried.views[0].own), (1, 1));
}

#[test]
fn a_view_is_gone_when_its_frontier_is() {
    let (mut map, cells) = room();
    let mut sampler = sampler_of(&map, &params(), &[opening(&cells)]);
    let view = sampler
        .candidates(&mast(&map), &COSTS, HOME, &LEVEL)
        .unwrap()
        .views[0]
        .clone();
    assert_eq!(sampler.remaining(Kind::Exploration, &cells), cells.len());
    assert_eq!(sampler.remaining(Kind::Inspection, &cells), 0);
    for c in map.all() {
        if c[0] > 19 {
            map.set(c, b'#');
        }
    }
    sampler
        .update(
            &map,
            &Changes {
                removed: &[7],
                boxes: &[([20, 0, 0], [22, 10, 8])],
                ..Changes::default()
            },
        )
        .unwrap();
    assert_eq!(sampler.gain_at(view.base, &view.camera).unwrap().info, 0.0);
    assert_eq!(sampler.remaining(Kind::Exploration, &cells), 0);
    assert!(sampler.is_empty());
}

/// The robot's own notion of the world may change without the map.
#[test]
fn bodies_are_checked_again_on_demand() {
    let (map, cells) = room();
    let mut sampler = sampler_of(&map, &params(), &[opening(&cells)]);
    let fat = Mast {
        radius: 3.0,
        ..mast(&map)
    };
    assert_eq!(
        sampler
            .candidates(&mast(&map), &COSTS, HOME, &LEVEL)
            .unwrap()
            .views
            .len(),
        1
    );
    sampler.recheck_bodies();
    let found = sampler.candidates(&fat, &COSTS, HOME, &LEVEL).unwrap();
    assert_eq!(found.without, [(7, NoView::NoFreeBase)]);
}

/// Boxes beyond the first one make room; what is inside is read.
#[test]
fn the_map_may_grow() {
    let (map, cells) = room();
    let mut small = Sampler::new(&params(), solved(&map, &params())).unwrap();
    small
        .update(
            &map,
            &Changes {
                boxes: &[([0, 0, 0], [4, 4, 4])],
                ..Changes::default()
            },
        )
        .unwrap();
    small
        .update(
            &map,
            &Changes {
                added: &[opening(&cells)],
                boxes: &[([3, 3, 3], [22, 10, 8])],
                ..Changes::default()
            },
        )
        .unwrap();
    let mut whole = sampler_of(&map, &params(), &[opening(&cells)]);
    let a = small.candidates(&mast(&map), &COSTS, HOME, &LEVEL).unwrap();
    let b = whole.candidates(&mast(&map), &COSTS, HOME, &LEVEL).unwrap();
    assert_eq!(a.views.len(), 1);
    assert!(same_view(&a.views[0], &b.views[0]));
}

/// A map higher than 64 cells takes the slow way to the same answer.
#[test]
fn tall_maps_work() {
    let mut map = Grid::unknown([12, 12, 150], 0.3);
    for c in map.all() {
        map.set(c, if c[0] == 11 { b'#' } else { b'.' });
    }
    let all = [OwnedCluster {
        id: 1,
        kind: Kind::Inspection,
        cells: map.surface(),
    }];
    let sampler = fresh(&map, &all, &params());
    for height in [1.0, 19.0, 19.3, 30.0] {
        let camera = Pose::looking([1.7, 1.8, height], 0.1, 0.2);
        let mut ours = sampler
            .seen_from([0.5, 0.5, 0.0], &camera)
            .unwrap()
            .inspection;
        ours.sort_unstable();
        assert_eq!(
            ours,
            seen(&map, &all, &params(), [0.5, 0.5, 0.0], &camera).1
        );
        assert!(!ours.is_empty());
    }
}

#[test]
fn a_robot_that_reaches_nothing_is_an_error() {
    let (map, _) = room();
    let low = Mast {
        lift: (9.0, 9.5),
        ..mast(&map)
    };
    assert_eq!(postures(&low, &params()), Err(Error::NoPosture(7)));
    assert_eq!(
        Sampler::<[f64; 2]>::new(&params(), vec![]).unwrap_err(),
        Error::NoPosture(7)
    );
    // Views out of reach are left out, the others stay.
    let half = Mast {
        lift: (0.4, 0.9),
        ..mast(&map)
    };
    let views: Vec<usize> = postures(
        &half,
        &Params {
            height_slack: vec![0.0],
            ..params()
        },
    )
    .unwrap()
    .iter()
    .map(|p| p.view)
    .collect();
    assert_eq!(views, [2, 4, 6]);
}

#[test]
fn bad_parameters_are_named() {
    let bad = |change: fn(&mut Params)| {
        let mut params = Params::default();
        change(&mut params);
        match params.validate() {
            Err(Error::Param { field, .. }) => field,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(Params::default().validate(), Ok(()));
    assert_eq!(bad(|p| p.ring_min = -0.1), "ring_min");
    assert_eq!(bad(|p| p.ring_max = 0.5), "ring_max");
    assert_eq!(bad(|p| p.ring_max = f64::INFINITY), "ring_max");
    assert_eq!(bad(|p| p.ring_step = 0.0), "ring_step");
    assert_eq!(bad(|p| p.ring_step = 1e-9), "ring_step");
    assert_eq!(bad(|p| p.bearings = 0), "bearings");
    assert_eq!(bad(|p| p.views.clear()), "views");
    assert_eq!(bad(|p| p.views[1].pitch = 2.0), "views.pitch");
    assert_eq!(bad(|p| p.views[1].height = f64::NAN), "views.height");
    assert_eq!(bad(|p| p.ahead.clear()), "ahead");
    assert_eq!(bad(|p| p.height_slack = vec![f64::NAN]), "height_slack");
    assert_eq!(bad(|p| p.depth.far = f64::NAN), "depth");
    assert_eq!(bad(|p| p.rgb.near = 5.0), "rgb");
    assert_eq!(bad(|p| p.rgb.tan_half_h = 0.0), "rgb");
    assert_eq!(bad(|p| p.motion_decay = f64::NAN), "motion_decay");
    assert_eq!(bad(|p| p.threshold = -1.0), "threshold");
    assert_eq!(bad(|p| p.unknown_allowance = 1000), "unknown_allowance");
    assert_eq!(
        bad(|p| p.lidar.as_mut().unwrap().range = 0.0),
        "lidar.range"
    );
    assert_eq!(bad(|p| p.lidar.as_mut().unwrap().low = 1.0), "lidar.low");
    assert_eq!(bad(|p| p.lidar.as_mut().unwrap().high = 1.6), "lidar.high");
    assert_eq!(bad(|p| p.relaxed.bearings = 0), "relaxed.bearings");
    let message = Params {
        ring_step: 0.0,
        ..Params::default()
    }
    .validate()
    .unwrap_err()
    .to_string();
    assert_eq!(message, "ring_step = 0 must be positive and finite");
}

#[test]
fn bad_input_is_refused_and_changes_nothing() {
    let (map, cells) = room();
    let mut sampler = sampler_of(&map, &params(), &[opening(&cells)]);
    let nan = Cluster {
        id: 8,
        centroid: [0.0, f64::NAN, 0.0],
        ..opening(&cells)
    };
    let refused = sampler.update(
        &map,
        &Changes {
            added: &[nan],
            removed: &[7],
            ..Changes::default()
        },
    );
    assert!(matches!(refused, Err(Error::Centroid { id: 8, .. })));
    assert_eq!(sampler.len(), 1);
    let far = [[i32::MAX, i32::MIN, 0]];
    let wide = Cluster {
        id: 9,
        cells: &far,
        ..opening(&cells)
    };
    let refused = sampler.update(
        &map,
        &Changes {
            added: &[wide],
            ..Changes::default()
        },
    );
    assert!(matches!(refused, Err(Error::TooLarge(_))));
    let flat = Grid::unknown([2, 2, 2], 0.0);
    assert_eq!(
        sampler.update(&flat, &Changes::default()),
        Err(Error::CellSize(0.0))
    );
    let lost = [f64::NAN, 0.0, 0.0];
    assert!(matches!(
        sampler.candidates(&mast(&map), &COSTS, lost, &LEVEL),
        Err(Error::Pose(_))
    ));
    assert!(matches!(
        sampler.gain_at(HOME, &Pose::looking(lost, 0.0, 0.0)),
        Err(Error::Pose(_))
    ));
    let share = sampler.near_best(7, 1.5, 9, &mast(&map), &COSTS, HOME, &LEVEL);
    assert!(matches!(share, Err(Error::Param { field: "share", .. })));
    assert_eq!(
        sampler
            .candidates(&mast(&map), &COSTS, HOME, &LEVEL)
            .unwrap()
            .views
            .len(),
        1
    );
}

#[test]
fn the_defaults_are_the_papers() {
    let params = Params::default();
    assert_eq!(params.radii().len() * params.bearings, 96);
    assert_eq!(params.views.len(), 7);
    assert!((params.radii()[7] - 3.0).abs() < 1e-9);
    let rgb = Frustum::degrees(69.0, 42.0, 0.05, 4.0);
    assert_eq!(params.rgb, rgb);
}

#[cfg(feature = "rayon")]
#[test]
fn threads_do_not_change_the_result() {
    let mut dice = Dice::new(11);
    let map = hall(&mut dice);
    let all = clusters(&map, |_| false);
    let (mut one, mut many) = (fresh(&map, &all, &params()), fresh(&map, &all, &params()));
    let a = one.candidates(&mast(&map), &COSTS, HOME, &LEVEL).unwrap();
    let b = many
        .candidates_parallel(&mast(&map), &COSTS, HOME, &LEVEL)
        .unwrap();
    assert!(!a.views.is_empty());
    assert_eq!((a.views, a.without), (b.views, b.without));
}
