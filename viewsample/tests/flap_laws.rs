//! FLAP's sampler and its views: laws and an oracle.
#![allow(missing_docs, clippy::unwrap_used)]

use proptest::prelude::*;
use viewsample::flap::{
    CellState, Fan, FanPose, Haze, Limits, SightGrid, Target, ViewParams, sample_from,
    sample_poses, sample_views,
};
use viewsample::grid::Grid;
use viewsample::{Error, Map};

fn grids() -> impl Strategy<Value = Grid> {
    prop::collection::vec(
        prop_oneof![4 => Just(b'.'), 3 => Just(b'?'), 1 => Just(b'#')],
        12 * 10 * 8,
    )
    .prop_map(|states| {
        let mut grid = Grid::unknown([12, 10, 8], 0.1);
        for (cell, state) in grid.all().zip(states) {
            grid.set(cell, state);
        }
        grid
    })
}

fn poses() -> impl Strategy<Value = FanPose> {
    (
        prop::array::uniform3(-0.3..1.4f64),
        -3.2..3.2f64,
        -1.2..1.2f64,
    )
        .prop_map(|(position, yaw, pitch)| FanPose {
            position,
            yaw,
            pitch,
        })
}

/// The definition: along each ray, every border that it crosses, each cell tested by a point between two borders.
fn by_definition(grid: &Grid, fan: &Fan, pose: &FanPose) -> Vec<[i32; 3]> {
    let h = grid.cell_size();
    let mut shown = Vec::new();
    for d in fan.directions(pose) {
        let mut borders = vec![0.0];
        for a in 0..3 {
            for k in -60..90 {
                let t = (f64::from(k) * h - pose.position[a]) / d[a];
                if t > 0.0 && t < fan.range() + 2.0 * h {
                    borders.push(t);
                }
            }
        }
        borders.sort_by(f64::total_cmp);
        for pair in borders.windows(2) {
            let middle = 0.5 * (pair[0] + pair[1]);
            let cell = grid.cell_at([0, 1, 2].map(|a| pose.position[a] + middle * d[a]));
            // Rays that pass through an edge may graze a third cell or not.
            if pair[1] - pair[0] < 1e-9 {
                continue;
            }
            if grid.is_occupied(cell) || pair[1] >= fan.range() {
                break;
            }
            let (low, high) = grid.bounds();
            let inside = (0..3).all(|a| low[a] <= cell[a] && cell[a] < high[a]);
            if inside && !grid.is_free(cell) {
                shown.push(cell);
            }
        }
    }
    shown.sort_unstable_by_key(|c| [c[2], c[1], c[0]]);
    shown.dedup();
    shown
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// What a view shows is what its rays meet by definition, cell for cell.
    #[test]
    fn views_show_what_the_definition_says(grid in grids(), pose in poses()) {
        let fan = Fan::new(1.1, [0.9, 0.7], 0.09).unwrap();
        let mut sight = SightGrid::new(&grid, grid.bounds(), |_| true);
        let shown: Vec<_> = sight.view(&fan, &pose).to_vec().iter().map(|&i| sight.cell(i)).collect();
        prop_assert_eq!(shown, by_definition(&grid, &fan, &pose));
    }

    /// A cell set anew is as if the map had been so from the start.
    #[test]
    fn set_cells_equal_a_new_copy(grid in grids(), other in grids(), pose in poses()) {
        let fan = Fan::new(1.1, [0.9, 0.7], 0.09).unwrap();
        let mut sight = SightGrid::new(&grid, grid.bounds(), |c| c[0] > 3);
        for cell in other.all() {
            sight.set(cell, if other.is_occupied(cell) { CellState::Occupied } else if other.is_free(cell) { CellState::Free } else { CellState::Unknown });
        }
        let mut anew = SightGrid::new(&other, other.bounds(), |c| c[0] > 3);
        prop_assert_eq!(sight.view(&fan, &pose), anew.view(&fan, &pose));
    }

    /// A cell that no ray comes near changes nothing, whatever it becomes.
    #[test]
    fn cells_beside_the_fan_change_no_view(grid in grids(), pose in poses(), changes in prop::collection::vec((0..12i32, 0..10i32, 0..8i32), 1..40)) {
        let fan = Fan::new(0.8, [0.9, 0.7], 0.09).unwrap();
        let mut sight = SightGrid::new(&grid, grid.bounds(), |_| true);
        let before = sight.view(&fan, &pose).to_vec();
        for (x, y, z) in changes {
            let cell = [x, y, z];
            if !fan.may_meet(&pose, grid.center(cell), 0.0867) {
                sight.set(cell, if grid.is_occupied(cell) { CellState::Unknown } else { CellState::Occupied });
            }
        }
        prop_assert_eq!(sight.view(&fan, &pose), &before[..]);
        // Every cell shown is met.
        let inside = |i: &u32| fan.may_meet(&pose, grid.center(sight.cell(*i)), 0.0867);
        prop_assert!(before.iter().all(inside));
    }

    /// Only unknown cells of interest are shown, and more obstacles never show more.
    #[test]
    fn obstacles_only_hide(grid in grids(), pose in poses(), wall in 0..12i32) {
        let fan = Fan::new(1.1, [0.9, 0.7], 0.05).unwrap();
        let mut sight = SightGrid::new(&grid, grid.bounds(), |c| c[1] != 4);
        let before = sight.view(&fan, &pose).to_vec();
        for &i in &before {
            let cell = sight.cell(i);
            prop_assert!(sight.is_open(i) && cell[1] != 4 && !grid.is_free(cell) && !grid.is_occupied(cell));
        }
        for y in 0..10 {
            for z in 0..8 {
                sight.set([wall, y, z], CellState::Occupied);
            }
        }
        let after = sight.view(&fan, &pose).to_vec();
        prop_assert!(after.iter().all(|i| before.contains(i)));
    }

    /// Without haze all that is shown is shown for certain; with it the same cells, those with nothing unknown before them
    /// for certain, and thicker haze hides more.
    #[test]
    fn haze_hides_what_lies_behind_the_unknown(grid in grids(), pose in poses(), density in 0.1..8.0f64) {
        let fan = Fan::new(1.1, [0.9, 0.7], 0.09).unwrap();
        let mut sight = SightGrid::new(&grid, grid.bounds(), |c| c[2] != 3);
        let shown = sight.view(&fan, &pose).to_vec();
        let clear = sight.view_through(&fan, &pose, Haze::default());
        let haze = Haze { of_interest: density, elsewhere: 0.5 * density };
        let hazy = sight.view_through(&fan, &pose, haze);
        let double = Haze { of_interest: 2.0 * density, elsewhere: density };
        let thick = sight.view_through(&fan, &pose, double);
        prop_assert!(clear.iter().all(|c| c.1 == 1.0));
        for list in [&clear, &hazy, &thick] {
            prop_assert_eq!(&list.iter().map(|c| c.0).collect::<Vec<_>>(), &shown);
        }
        for (hazy, thick) in hazy.iter().zip(&thick) {
            prop_assert!(hazy.1 > 0.0 && hazy.1 <= 1.0);
            // Twice the density along the clearest ray is the square of the chance.
            prop_assert!((thick.1 - hazy.1 * hazy.1).abs() < 1e-5);
        }
    }

    /// Every pose satisfies every constraint towards its target, and targets that can be seen get poses.
    #[test]
    fn sampled_poses_satisfy_every_constraint(
        seed: u64,
        height in 0.0..2.2f64,
        normal in prop::option::of(prop::array::uniform3(-1.0..1.0f64)),
    ) {
        let limits = Limits::default();
        let target = Target { center: [3.0, -2.0, height], normal };
        let mut count = 0;
        let failed = sample_poses(&[target], &limits, seed, 200, &mut |pose, index| {
            assert_eq!(index, 0);
            assert!(limits.allow(&pose, &target), "{pose:?}");
            count += 1;
            true
        }).unwrap();
        // Simple rejection says whether a pose exists at all.
        let exists = rejection(&target, &limits);
        prop_assert!(count > 0 || !exists);
        // Propagation is worth it: most tries succeed where any do.
        prop_assert!(!exists || count * 3 > failed, "{count} poses, {failed} failures");
    }
}

/// Whether any pose of a fine grid of offsets satisfies the constraints with some room.
fn rejection(target: &Target, limits: &Limits) -> bool {
    let tight = Limits {
        range: (limits.range.0 + 0.05, limits.range.1 - 0.05),
        ..limits.clone()
    };
    let mut offsets = Vec::new();
    for i in -30..=30 {
        for j in -30..=30 {
            offsets.push([0.1 * f64::from(i), 0.1 * f64::from(j)]);
        }
    }
    (0..8).any(|k| {
        let z = limits.height.0 + (limits.height.1 - limits.height.0) * f64::from(k) / 7.0;
        offsets.iter().any(|o| {
            let position = [target.center[0] + o[0], target.center[1] + o[1], z];
            let d = [o[0], o[1], z - target.center[2]];
            let r = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            let pitch = (-(d[2] / r).asin()).clamp(limits.pitch.0, limits.pitch.1);
            let pose = FanPose {
                position,
                yaw: (-d[1]).atan2(-d[0]),
                pitch,
            };
            let side = target
                .normal
                .is_none_or(|n| (0..3).map(|a| n[a] * d[a]).sum::<f64>() > 0.05);
            side && tight.allow(&pose, target)
        })
    })
}

#[test]
fn the_flap_fan_has_2520_rays() {
    let fan = Fan::flap(3.0, [0.9934, 0.6855], 0.05).unwrap();
    assert_eq!(fan.rays(), 2520);
}

#[test]
fn bad_fans_and_limits_are_refused() {
    for (range, fov, step) in [
        (0.0, [1.0, 1.0], 0.1),
        (f64::NAN, [1.0, 1.0], 0.1),
        (1.0, [-1.0, 1.0], 0.1),
        (1.0, [1.0, 7.0], 0.1),
        (1.0, [1.0, 1.0], 0.0),
    ] {
        assert!(matches!(
            Fan::new(range, fov, step),
            Err(Error::Param { .. })
        ));
    }
    let good = Limits::default();
    for limits in [
        Limits {
            range: (3.0, 0.4),
            ..good.clone()
        },
        Limits {
            range: (0.4, f64::NAN),
            ..good.clone()
        },
        Limits {
            height: (2.0, 1.0),
            ..good.clone()
        },
        Limits {
            pitch: (-2.0, 0.0),
            ..good.clone()
        },
        Limits {
            vertical_fov: -0.1,
            ..good.clone()
        },
        Limits {
            range_tolerance: 5.0,
            ..good.clone()
        },
    ] {
        let found = sample_poses(&[], &limits, 0, 10, &mut |_, _| true);
        assert!(matches!(found, Err(Error::Param { .. })), "{limits:?}");
    }
}

#[test]
fn targets_out_of_reach_give_no_pose_and_an_end() {
    let targets = [
        Target {
            center: [0.0, 0.0, 9.0],
            normal: None,
        },
        Target {
            center: [f64::NAN; 3],
            normal: None,
        },
        // Must be looked at from below, but the camera is always above.
        Target {
            center: [0.0, 0.0, 0.2],
            normal: Some([0.0, 0.0, -1.0]),
        },
    ];
    let failed = sample_poses(
        &targets,
        &Limits::default(),
        1,
        usize::MAX,
        &mut |pose, _| panic!("{pose:?}"),
    );
    assert_eq!(failed, Ok(0));
}

#[test]
fn sampling_stops_when_told() {
    let map = Grid::unknown([20, 20, 20], 0.1);
    let mut sight = SightGrid::new(&map, map.bounds(), |_| true);
    let fan = Fan::new(3.0, [0.5, 0.5], 0.1).unwrap();
    let targets = [Target {
        center: [1.0, 1.0, 0.8],
        normal: None,
    }];
    let params = ViewParams {
        count: 30,
        local_count: 4,
        ..ViewParams::default()
    };
    let mut run = |limit: usize| {
        let mut asked = 0;
        let mut stop = || {
            asked += 1;
            asked > limit
        };
        let limits = Limits::default();
        sample_views(
            &mut sight,
            &fan,
            &targets,
            &limits,
            &params,
            [1.0, 1.0],
            &mut |_| true,
            &mut stop,
        )
        .unwrap()
    };
    assert_eq!(run(0).len(), 0);
    assert_eq!(run(usize::MAX).len(), 34);
    let some = run(50).len();
    assert!(some > 0 && some < 34, "{some}");
    let here = sample_from([1.0, 2.0], Some(1.6), &Limits::default(), 3, 5).unwrap();
    assert!(here.iter().all(|p| p.position == [1.0, 2.0, 1.6]));
}

#[test]
fn poses_that_are_not_finite_show_nothing() {
    let map = Grid::unknown([4, 4, 4], 0.1);
    let mut sight = SightGrid::new(&map, map.bounds(), |_| true);
    let fan = Fan::new(1.0, [0.5, 0.5], 0.1).unwrap();
    for pose in [
        FanPose {
            position: [f64::NAN, 0.0, 0.0],
            ..FanPose::default()
        },
        FanPose {
            yaw: f64::INFINITY,
            ..FanPose::default()
        },
    ] {
        assert!(sight.view(&fan, &pose).is_empty());
    }
    let mut none = SightGrid::new(&map, ([0; 3], [0; 3]), |_| true);
    assert!(none.is_empty() && none.view(&fan, &FanPose::default()).is_empty());
}
