//! The sampler against the definition by brute force.
#![allow(missing_docs, clippy::unwrap_used)]

mod worlds;

use proptest::prelude::*;
use viewsample::{Cell, Changes, Cluster, Kind, Map, Params, Pose, Sampler};
use worlds::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// The best view of each library is the brute-force argmax of G over G_info >= threshold.
    #[test]
    fn best_views_equal_brute_force(seed in any::<u64>()) {
        let mut dice = Dice::new(seed);
        let map = hall(&mut dice);
        let all = clusters(&map, |c| (c[0] + c[1]) % 7 < 2);
        let params = Params { threshold: [0.2, 2.0, 20.0][dice.below(3)], ..params() };
        let from = ([dice.between(0.5, 7.0), dice.between(0.5, 6.0), 0.3], [1.0, 0.0]);
        let mut sampler = fresh(&map, &all, &params);
        let postures = sampler.postures().to_vec();
        let found = sampler.candidates(&mast(&map), &COSTS, from.0, &from.1).unwrap();
        prop_assert_eq!(found.views.len() + found.without.len(), all.len());
        for cluster in &all {
            let scored = library(&map, &all, cluster, &params, &postures, from);
            let good = scored.iter().filter(|s| s.info >= params.threshold);
            let best = good.max_by(|a, b| a.score.total_cmp(&b.score));
            let view = found.views.iter().find(|v| v.cluster == Some(cluster.id));
            prop_assert_eq!(best.is_some(), view.is_some());
            if let (Some(best), Some(view)) = (best, view) {
                prop_assert!(close(best.score, view.score), "{} {}", best.score, view.score);
                prop_assert!(close(view.score, view.motion * view.gain.info));
                let same = scored.iter().find(|s| s.base == view.base && s.posture == view.posture);
                prop_assert!(same.is_some_and(|s| close(s.info, view.gain.info) && close(s.score, view.score)));
            }
        }
    }

    /// What a view sees, cell by cell, from any pose, free or not.
    #[test]
    fn seen_cells_equal_brute_force(seed in any::<u64>()) {
        let mut dice = Dice::new(seed);
        let map = hall(&mut dice);
        let all = clusters(&map, |_| false);
        for allowance in [0, 2, 9] {
            let params = Params { unknown_allowance: allowance, ..params() };
            let sampler = fresh(&map, &all, &params);
            for _ in 0..4 {
                let base = [dice.between(-1.0, 8.5), dice.between(-1.0, 7.0), dice.between(-3.0, 3.0)];
                let eye = [dice.between(-1.0, 8.5), dice.between(-1.0, 7.0), dice.between(-0.5, 3.0)];
                let camera = Pose::looking(eye, dice.between(-3.0, 3.0), dice.between(-1.5, 1.5));
                let (exploration, inspection) = seen(&map, &all, &params, base, &camera);
                let mut ours = sampler.seen_from(base, &camera).unwrap();
                ours.exploration.sort_unstable();
                ours.inspection.sort_unstable();
                prop_assert_eq!(&ours.exploration, &exploration);
                prop_assert_eq!(&ours.inspection, &inspection);
                let gain = sampler.gain_at(base, &camera).unwrap();
                prop_assert_eq!((gain.exploration as usize, gain.inspection as usize), (exploration.len(), inspection.len()));
            }
        }
    }

    /// After any updates, an exact sampler answers like one that was built anew.
    #[test]
    fn updates_equal_building_anew(seed in any::<u64>(), rounds in 1usize..5) {
        let mut dice = Dice::new(seed);
        let mut map = hall(&mut dice);
        let params = params();
        let mut done: Vec<viewsample::Cell> = Vec::new();
        let mut all = clusters(&map, |_| false);
        let mut sampler = fresh(&map, &all, &params);
        for _ in 0..rounds {
            let from = ([dice.between(0.5, 7.0), dice.between(0.5, 6.0), 0.3], [1.0, 0.0]);
            sampler.candidates(&mast(&map), &COSTS, from.0, &from.1).unwrap();
            let corner = [dice.below(SIZE[0]), dice.below(SIZE[1]), dice.below(5)];
            let extent = [1 + dice.below(6), 1 + dice.below(6), 1 + dice.below(7)];
            fill(&mut map, corner, extent, b".#?"[dice.below(3)]);
            let surface = map.surface();
            let start = dice.below(surface.len());
            done.extend(&surface[start..(start + 40).min(surface.len())]);
            let new = clusters(&map, |c| done.contains(&c));
            let added: Vec<Cluster<'_>> = new.iter().filter(|c| !all.contains(c)).map(OwnedCluster::borrow).collect();
            let removed: Vec<u64> = all.iter().map(|c| c.id).filter(|id| new.iter().all(|c| c.id != *id)).collect();
            let low = corner.map(|v| v as i32);
            let high = [0, 1, 2].map(|a| low[a] + extent[a] as i32);
            let changes = Changes { added: &added, removed: &removed, boxes: &[(low, high)] };
            sampler.update(&map, &changes).unwrap();
            all = new;
            let ours = sampler.candidates(&mast(&map), &COSTS, from.0, &from.1).unwrap();
            let anew = fresh(&map, &all, &params).candidates(&mast(&map), &COSTS, from.0, &from.1).unwrap();
            prop_assert_eq!(&ours.views, &anew.views);
            prop_assert_eq!(ours.without.len(), anew.without.len());
            let ids: Vec<u64> = ours.without.iter().map(|w| w.0).collect();
            let retried = sampler.retry(&ids, &mast(&map), &COSTS, from.0, &from.1).unwrap();
            let afresh = fresh(&map, &all, &params).retry(&ids, &mast(&map), &COSTS, from.0, &from.1).unwrap();
            prop_assert_eq!(&retried.views, &afresh.views);
        }
    }

    /// The near-best list is the brute-force list, best first.
    #[test]
    fn near_best_equals_brute_force(seed in any::<u64>()) {
        let mut dice = Dice::new(seed);
        let map = hall(&mut dice);
        let all = clusters(&map, |_| false);
        let params = params();
        let from = ([dice.between(0.5, 7.0), dice.between(0.5, 6.0), 0.3], [1.0, 0.0]);
        let mut sampler = fresh(&map, &all, &params);
        let postures = sampler.postures().to_vec();
        let cluster = &all[dice.below(all.len())];
        let ours = sampler.near_best(cluster.id, 0.8, usize::MAX, &mast(&map), &COSTS, from.0, &from.1).unwrap();
        let mut scored = library(&map, &all, cluster, &params, &postures, from);
        scored.retain(|s| s.info >= params.threshold);
        scored.sort_by(|a, b| b.score.total_cmp(&a.score));
        let best = scored.first().map_or(0.0, |s| s.score);
        // A hair on either side of the limit may fall either way.
        let at_least = |share: f64| scored.iter().filter(|s| s.score >= share * best).count();
        prop_assert!((at_least(0.8 + 1e-9)..=at_least(0.8 - 1e-9)).contains(&ours.len()));
        for (a, b) in ours.iter().zip(&scored) {
            prop_assert!(close(a.score, b.score));
        }
        let few = sampler.near_best(cluster.id, 0.8, 3, &mast(&map), &COSTS, from.0, &from.1).unwrap();
        prop_assert_eq!(&few[..], &ours[..ours.len().min(3)]);
    }
}

/// The cells of the cluster itself among those seen.
#[test]
fn own_counts_the_cells_of_the_cluster() {
    let mut dice = Dice::new(5);
    let map = hall(&mut dice);
    let all = clusters(&map, |_| false);
    let params = params();
    let mut sampler = fresh(&map, &all, &params);
    let found = sampler
        .candidates(&mast(&map), &COSTS, [3.0, 3.0, 0.0], &[1.0, 0.0])
        .unwrap();
    assert!(!found.views.is_empty());
    for view in found.views {
        let cluster = all.iter().find(|c| Some(c.id) == view.cluster).unwrap();
        let (e, i) = seen(&map, &all, &params, view.base, &view.camera);
        let list = if cluster.kind == Kind::Inspection {
            i
        } else {
            e
        };
        assert_eq!(
            view.own as usize,
            list.iter().filter(|c| cluster.cells.contains(c)).count()
        );
    }
}

/// A grid that says which faces of its cells are open to free space, but for those that need no inspection any more.
struct Faced(viewsample::grid::Grid, u8);

const FACES: [Cell; 6] = [
    [-1, 0, 0],
    [1, 0, 0],
    [0, -1, 0],
    [0, 1, 0],
    [0, 0, -1],
    [0, 0, 1],
];

fn across(cell: Cell, face: usize) -> Cell {
    [0, 1, 2].map(|a| cell[a] + FACES[face][a])
}

impl Map for Faced {
    fn cell_size(&self) -> f64 {
        self.0.cell_size()
    }
    fn cell_at(&self, point: [f64; 3]) -> Cell {
        self.0.cell_at(point)
    }
    fn center(&self, cell: Cell) -> [f64; 3] {
        self.0.center(cell)
    }
    fn is_free(&self, cell: Cell) -> bool {
        self.0.is_free(cell)
    }
    fn is_occupied(&self, cell: Cell) -> bool {
        self.0.is_occupied(cell)
    }
    fn faces(&self, cell: Cell) -> (u8, u8) {
        let open = (0..6).filter(|&f| self.is_free(across(cell, f)));
        let bits = open.fold(0, |bits, f| bits | 1 << f);
        (bits & !self.1, bits)
    }
}

/// Where level faces weigh more, the best view of a library is still the best of all its views, also when such faces were inspected
/// since while their cells stayed frontiers.
#[test]
fn best_views_by_weight_are_best() {
    let mut dice = Dice::new(5);
    for _ in 0..6 {
        let mut map = Faced(hall(&mut dice), 0);
        let all = clusters(&map.0, |_| false);
        let params = Params {
            max_incidence: Some(1.2),
            level_weight: 2 + dice.below(8) as u32,
            threshold: 0.2,
            ..params()
        };
        let anew = |map: &Faced| {
            let mut sampler = Sampler::new(&params, solved(&map.0, &params)).unwrap();
            let added: Vec<_> = all.iter().map(OwnedCluster::borrow).collect();
            let changes = Changes {
                added: &added,
                boxes: &[map.0.bounds()],
                ..Changes::default()
            };
            sampler.update(map, &changes).unwrap();
            sampler
        };
        let from = ([3.0, 2.0, 0.3], [1.0, 0.0]);
        let mut kept = anew(&map);
        let before = kept
            .candidates(&mast(&map.0), &COSTS, from.0, &from.1)
            .unwrap();
        for done in [0b01_0000, 0b11_0000] {
            map.1 = done;
            let changes = Changes {
                boxes: &[map.0.bounds()],
                ..Changes::default()
            };
            kept.update(&map, &changes).unwrap();
            let mut fresh = anew(&map);
            let robot = mast(&map.0);
            let ours = kept.candidates(&robot, &COSTS, from.0, &from.1).unwrap();
            let found = fresh.candidates(&robot, &COSTS, from.0, &from.1).unwrap();
            assert_eq!(ours.views, found.views);
            for view in &found.views {
                assert_eq!(view.gain, fresh.gain_at(view.base, &view.camera).unwrap());
                let list = fresh
                    .near_best(
                        view.cluster.unwrap(),
                        0.0,
                        10_000,
                        &robot,
                        &COSTS,
                        from.0,
                        &from.1,
                    )
                    .unwrap();
                let most = list.iter().map(|v| v.score).fold(0.0, f64::max);
                assert!(close(view.score, most), "{} {most}", view.score);
            }
            assert_ne!(found.views, before.views, "weights change what is best");
        }
    }
}

/// With a limit on incidence a surface cell counts if one of its open faces looks at the camera steeply enough, alone or by the
/// mean of all of them (a top or an underside as if it lay in the middle of its cell), and the free cell in front of that face is in sight.
#[test]
fn seen_faces_equal_their_definition() {
    let mut dice = Dice::new(77);
    for _ in 0..12 {
        let map = Faced(hall(&mut dice), 0);
        let all = clusters(&map.0, |_| false);
        let limit = dice.between(0.5, 1.4);
        let target = (dice.below(2) == 0).then(|| dice.between(0.0, 0.2));
        let level_weight = 1 + dice.below(6) as u32;
        let params = Params {
            max_incidence: Some(limit),
            target,
            level_weight,
            ..params()
        };
        let mut sampler = Sampler::new(&params, solved(&map.0, &params)).unwrap();
        let added: Vec<_> = all.iter().map(OwnedCluster::borrow).collect();
        let changes = Changes {
            added: &added,
            boxes: &[map.0.bounds()],
            ..Changes::default()
        };
        sampler.update(&map, &changes).unwrap();
        let others = Params {
            max_incidence: Some(0.8),
            target: Some(0.1),
            ..params.clone()
        };
        let mut other = Sampler::new(&others, solved(&map.0, &others)).unwrap();
        other.update(&map, &changes).unwrap();
        for _ in 0..10 {
            let eye = [
                dice.between(0.5, 7.0),
                dice.between(0.5, 6.0),
                dice.between(0.3, 2.0),
            ];
            let camera = Pose::looking(eye, dice.between(-3.0, 3.0), dice.between(-1.0, 1.0));
            let counts = |cell: Cell| {
                let p = map.center(cell);
                let way = [0, 1, 2].map(|a| eye[a] - p[a]);
                let length = way.iter().map(|v| v * v).sum::<f64>().sqrt();
                let dot = |n: [f64; 3]| (0..3).map(|a| n[a] * way[a]).sum::<f64>();
                let open: Vec<usize> = (0..6).filter(|&f| map.is_free(across(cell, f))).collect();
                let upright = open.iter().filter(|&&f| f < 4);
                let mean = [0, 1].map(|a| {
                    upright
                        .clone()
                        .map(|&f| f64::from(FACES[f][a]))
                        .sum::<f64>()
                });
                let norm = mean[0].hypot(mean[1]);
                let by_mean =
                    norm > 0.0 && dot([mean[0], mean[1], 0.0]) >= limit.cos() * length * norm;
                // The four corners of the square around a face.
                let held = |f: usize, middle: [f64; 3]| {
                    let half = target.map(|t| t + 0.5 * H);
                    half.is_none_or(|half| {
                        [(-half, -half), (-half, half), (half, -half), (half, half)]
                            .into_iter()
                            .all(|(a, b)| {
                                let mut corner = middle;
                                corner[(f / 2 + 1) % 3] += a;
                                corner[(f / 2 + 2) % 3] += b;
                                let c = camera.to_camera(corner);
                                c[2] > 0.0
                                    && c[0].abs() <= params.rgb.tan_half_h * c[2]
                                    && c[1].abs() <= params.rgb.tan_half_v * c[2]
                            })
                    })
                };
                params.rgb.covers(camera.to_camera(p))
                    && open.iter().any(|&f| {
                        let normal = FACES[f].map(f64::from);
                        let middle = [0, 1, 2].map(|a| p[a] + 0.5 * H * normal[a]);
                        let outside = (0..3)
                            .map(|a| normal[a] * (eye[a] - middle[a]))
                            .sum::<f64>();
                        let at = if f < 4 { middle } else { p };
                        let from = [0, 1, 2].map(|a| eye[a] - at[a]);
                        let above = (0..3).map(|a| normal[a] * from[a]).sum::<f64>();
                        let far = from.iter().map(|v| v * v).sum::<f64>().sqrt();
                        outside > 0.0
                            && (above >= limit.cos() * far || (f < 4 && by_mean))
                            && held(f, middle)
                            && map.line_of_sight(eye, across(cell, f), params.unknown_allowance)
                    })
            };
            let mut expected: Vec<Cell> = all
                .iter()
                .filter(|k| k.kind == Kind::Inspection)
                .flat_map(|k| &k.cells)
                .copied()
                .filter(|&c| counts(c))
                .collect();
            expected.sort_unstable();
            let mut seen = sampler
                .seen_from([eye[0], eye[1], 0.0], &camera)
                .unwrap()
                .inspection;
            seen.sort_unstable();
            assert_eq!(seen, expected);
            let is_level = |c: &&Cell| (4..6).any(|f| map.is_free(across(**c, f)));
            let level = expected.iter().filter(is_level).count() as u32;
            let worth = expected.len() as u32 + (level_weight - 1) * level;
            let base = [eye[0], eye[1], 0.0];
            assert_eq!(sampler.gain_at(base, &camera).unwrap().inspection, worth);
            let along = sampler.gain_along(&[(base, camera), (base, camera)]);
            assert_eq!(along.unwrap().inspection, worth);
            // Asked with these limits, a sampler that has others answers the same, and as before when asked again.
            let before = other.seen_from(base, &camera).unwrap();
            let ask = |s: &Sampler<_>| s.seen_from(base, &camera).unwrap().inspection;
            let mut asked = other.with_limits(target, Some(limit), ask).unwrap();
            asked.sort_unstable();
            assert_eq!(asked, expected);
            assert_eq!(other.seen_from(base, &camera).unwrap(), before);
            let refused = other.with_limits(Some(f64::NAN), Some(limit), |_| ());
            assert!(matches!(refused, Err(viewsample::Error::Param { .. })));
        }
    }
}
