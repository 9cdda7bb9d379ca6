//! Depth images: against a scene that is known, and what goes wrong.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::{Numbers, map};
use proptest::prelude::*;
use voxmap::{DepthImage, Error, Scan, State};

/// A rotation by yaw and pitch of a camera that looks along x, its image's x to the right, y down.
fn looking(yaw: f64, pitch: f64) -> [[f64; 3]; 3] {
    let ((s, c), (sp, cp)) = (yaw.sin_cos(), pitch.sin_cos());
    let (forward, right) = ([cp * c, cp * s, sp], [s, -c, 0.0]);
    let down = [sp * c, sp * s, -cp];
    [0, 1, 2].map(|a| [right[a], down[a], forward[a]])
}

fn image(depth: &[f32]) -> DepthImage<'_> {
    DepthImage {
        depth,
        width: 8,
        focal: [10.0, 12.0],
        center: [3.5, 2.5],
        rotation: looking(0.0, 0.0),
        translation: [0.0, 0.0, 1.0],
        stride: 1,
        nearest: 0.3,
        free_without_return: None,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Depths of a plane give points on the plane, each on its pixel's ray; pixels without a return give ends at the free depth.
    #[test]
    fn points_lie_where_the_pixels_look(
        seed: u64, yaw in -3.0..3.0f64, pitch in -1.0..1.0f64, stride in 1usize..4, wall in 0.5..5.0f64,
    ) {
        let mut numbers = Numbers(seed);
        let depth: Vec<f32> = (0..48)
            .map(|_| [wall as f32, 0.0, f32::NAN, f32::INFINITY, -1.0, 0.1][numbers.below(6)])
            .collect();
        let camera = DepthImage {
            rotation: looking(yaw, pitch),
            translation: [1.0, -2.0, 0.5],
            stride,
            free_without_return: Some(2.0),
            ..image(&depth)
        };
        let points = camera.points().unwrap();
        let pixels: Vec<(usize, usize)> = (stride / 2..6).step_by(stride)
            .flat_map(|v| (stride / 2..8).step_by(stride).map(move |u| (u, v)))
            .collect();
        let has = |d: f32| d > 0.0 && d.is_finite();
        let near = pixels.iter().filter(|(u, v)| depth[v * 8 + u] == 0.1).count();
        prop_assert_eq!(points.hits.len() + points.misses.len() + near, pixels.len());
        for (found, far, returned) in [(&points.hits, wall, true), (&points.misses, 2.0, false)] {
            let kept = pixels.iter().filter(|(u, v)| {
                let d = depth[v * 8 + u];
                has(d) == returned && d != 0.1
            });
            for (point, (u, v)) in found.iter().zip(kept) {
                let d = [0, 1, 2].map(|a| f64::from(point[a]) - camera.translation[a]);
                let along = |axis: usize| (0..3).map(|row| camera.rotation[row][axis] * d[row]).sum::<f64>();
                prop_assert!((along(2) - far).abs() < 1e-5);
                prop_assert!((along(0) / along(2) * 10.0 + 3.5 - *u as f64).abs() < 1e-4);
                prop_assert!((along(1) / along(2) * 12.0 + 2.5 - *v as f64).abs() < 1e-4);
            }
        }
    }
}

#[test]
fn an_image_frees_what_it_looks_through() {
    let mut map = map(0.1, [40.0, 20.0, 20.0]);
    let depth = [2.04f32; 48];
    let camera = DepthImage {
        // One pixel looks straight ahead.
        center: [3.0, 2.0],
        translation: map.center([5, 10, 10]),
        ..image(&depth)
    };
    let points = camera.points().unwrap();
    assert_eq!((points.hits.len(), points.misses.len()), (48, 0));
    map.insert(&Scan {
        origin: camera.translation,
        hits: &points.hits,
        ..Scan::default()
    })
    .unwrap();
    let ahead = |x: i32| map.state([x, 10, 10]);
    assert_eq!([5, 15, 24].map(ahead), [State::Free; 3]);
    assert_eq!(map.counts().occupied, 48);
    assert_eq!(ahead(27), State::Unknown);
}

#[test]
fn images_name_their_faults() {
    let depth = [1.0f32; 48];
    let good = image(&depth);
    let error = |bad: DepthImage<'_>| bad.points().unwrap_err();
    let (pixels, width) = (48, 7);
    assert_eq!(
        error(DepthImage { width, ..good }),
        Error::Image { pixels, width }
    );
    let width = 0;
    assert_eq!(
        error(DepthImage { width, ..good }),
        Error::Image { pixels, width }
    );
    let (field, value) = ("focal[1]", -1.0);
    assert_eq!(
        error(DepthImage {
            focal: [1.0, -1.0],
            ..good
        }),
        Error::Length { field, value }
    );
    let (field, value) = ("stride", 0.0);
    assert_eq!(
        error(DepthImage { stride: 0, ..good }),
        Error::Length { field, value }
    );
    let nearest = f64::INFINITY;
    let (field, value) = ("nearest", nearest);
    assert_eq!(
        error(DepthImage { nearest, ..good }),
        Error::Length { field, value }
    );
    let all = DepthImage {
        nearest: 0.0,
        ..good
    };
    assert!(all.points().is_ok());
    let (field, value) = ("free_without_return", f64::INFINITY);
    let free_without_return = Some(value);
    assert_eq!(
        error(DepthImage {
            free_without_return,
            ..good
        }),
        Error::Length { field, value }
    );
    let nowhere = [f64::NAN, 0.0, 0.0];
    for bad in [
        DepthImage {
            translation: nowhere,
            ..good
        },
        DepthImage {
            rotation: [nowhere; 3],
            ..good
        },
        DepthImage {
            center: [f64::NAN; 2],
            ..good
        },
    ] {
        assert!(matches!(error(bad), Error::Position { .. }));
    }
    // No pixels are no points.
    assert!(image(&[]).points().unwrap().hits.is_empty());
}
