//! Properties that hold for any input.
#![allow(missing_docs, clippy::unwrap_used)]

mod worlds;

use proptest::prelude::*;
use viewsample::{
    Aim, Cell, Changes, Cluster, CostModel, Frustum, InverseReach, Lidar, Map, Params, Pose,
    Posture, Robot, Sampler, conformance,
};
use worlds::*;

/// Holds its camera anywhere above its base, looking anywhere: the state is base_from_camera.
struct Crane<'a, M>(viewsample::grid::Mast<'a, M>);

impl<M: Map> Robot for Crane<'_, M> {
    type State = Pose;
    fn reach(&self, camera: &Pose) -> Option<Pose> {
        let [x, y, z] = camera.translation;
        (x.hypot(y) < 0.9 && z < 1.9).then_some(*camera)
    }
    fn is_free(&self, base: [f64; 3], camera: &Pose) -> bool {
        let map = self.0.map;
        self.base_is_free(base) && map.is_free(map.cell_at(camera.on(base).translation))
    }
    fn base_is_free(&self, base: [f64; 3]) -> bool {
        self.0.base_is_free(base)
    }
}

/// Any move takes a second.
struct Waits;

impl CostModel<Pose> for Waits {
    fn seconds(&self, _: (&[f64; 3], &Pose), _: (&[f64; 3], &Pose)) -> f64 {
        1.0
    }
}

fn coordinate() -> impl Strategy<Value = f64> {
    -20.0..20.0f64
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Camera axes are orthonormal and right-handed, level to the right, and look where they should.
    #[test]
    fn poses_are_rotations(yaw in -7.0..7.0f64, pitch in -1.5..1.5f64, base_yaw in -7.0..7.0f64) {
        let camera = Pose::looking([0.3, -0.2, 1.1], yaw, pitch);
        for pose in [camera, camera.on([1.0, 2.0, base_yaw])] {
            let column = |j: usize| [0, 1, 2].map(|i: usize| pose.rotation[i][j]);
            let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            let (x, y, z) = (column(0), column(1), column(2));
            let cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
            prop_assert!((dot(cross, z) - 1.0).abs() < 1e-12 && dot(x, y).abs() < 1e-12);
            prop_assert!(x[2].abs() < 1e-12 && y[2] < 1e-12, "no roll: right is level, down is down");
            prop_assert!((pose.forward()[2] - pitch.sin()).abs() < 1e-12);
        }
        let moved = camera.on([1.0, 2.0, base_yaw]);
        prop_assert!((moved.forward()[0] - pitch.cos() * (yaw + base_yaw).cos()).abs() < 1e-12);
    }

    /// What a frustum covers lies in its box; what a LiDAR covers lies in its range.
    #[test]
    fn covered_points_lie_in_the_bounds(
        p in prop::array::uniform3(-5.0..5.0f64), yaw in -7.0..7.0f64, pitch in -1.5..1.5f64,
    ) {
        let frustum = Frustum::degrees(87.0, 58.0, 0.3, 4.0);
        let pose = Pose::looking([0.5, 0.1, 1.0], yaw, pitch);
        if frustum.covers(pose.to_camera(p)) {
            let (low, high) = frustum.bounds(&pose);
            for a in 0..3 {
                prop_assert!(low[a] - 1e-9 <= p[a] && p[a] <= high[a] + 1e-9);
            }
        }
        let lidar = Lidar { offset: [0.0; 3], low: -0.1, high: 0.9, range: 3.0 };
        if lidar.covers(p) {
            let r = p[0].hypot(p[1]);
            prop_assert!(r.hypot(p[2]) <= 3.0 + 1e-9 && (-0.1 - 1e-9..=0.9 + 1e-9).contains(&p[2].atan2(r)));
        }
    }

    /// The grid, the mast and eq. 2 obey the laws; a reference to each does too.
    #[test]
    fn built_in_types_conform(seed in any::<u64>()) {
        let mut dice = Dice::new(seed);
        let map = hall(&mut dice);
        let any_cell = |dice: &mut Dice| [dice.below(30) as i32 - 2, dice.below(26) as i32 - 2, dice.below(12) as i32 - 2];
        let cells: Vec<_> = (0..30).map(|_| any_cell(&mut dice)).collect();
        let rays: Vec<_> = (0..30).map(|_| {
            let from = [dice.between(-1.0, 9.0), dice.between(-1.0, 8.0), dice.between(-1.0, 3.0)];
            (from, any_cell(&mut dice))
        }).collect();
        prop_assert_eq!(conformance::check_map(&map, &cells, &rays), Ok(()));
        prop_assert_eq!(conformance::check_map(&&map, &cells, &rays), Ok(()));
        let bases: Vec<_> = (0..20).map(|_| [dice.between(-1.0, 9.0), dice.between(-1.0, 8.0), 0.0]).collect();
        let postures = solved(&map, &params());
        prop_assert_eq!(conformance::check_robot(&mast(&map), &postures, &bases), Ok(()));
        let places: Vec<_> = bases.iter().map(|b| (*b, [dice.unit(), dice.unit()])).collect();
        prop_assert_eq!(conformance::check_costs(&COSTS, &places), Ok(()));
        prop_assert_eq!(conformance::check_costs(&&COSTS, &places), Ok(()));
    }

    /// Sight does not improve when a free cell is taken by an obstacle, and more allowance never hurts.
    #[test]
    fn sight_is_monotone(seed in any::<u64>()) {
        let mut dice = Dice::new(seed);
        let map = hall(&mut dice);
        let mut denser = map.clone();
        let corner = [dice.below(SIZE[0]), dice.below(SIZE[1]), dice.below(5)];
        fill(&mut denser, corner, [4, 4, 4], b'#');
        for _ in 0..50 {
            let from = [dice.between(0.1, 7.7), dice.between(0.1, 6.5), dice.between(0.1, 2.3)];
            let to = [dice.below(SIZE[0]) as i32, dice.below(SIZE[1]) as i32, dice.below(SIZE[2]) as i32];
            let sight = [0, 1, 2, 20].map(|n| map.line_of_sight(from, to, n));
            prop_assert!(sight.is_sorted());
            prop_assert!(!denser.line_of_sight(from, to, 2) || map.line_of_sight(from, to, 2));
            // Within one voxel, and to a neighbour, nothing is between.
            prop_assert!(map.line_of_sight(map.center(to), to, 0));
        }
    }

    /// Offered views are feasible, reach the threshold, and their figures are those of their pose.
    #[test]
    fn views_are_what_they_say(seed in any::<u64>(), patience in 0u32..4) {
        let mut dice = Dice::new(seed);
        let map = hall(&mut dice);
        let all = clusters(&map, |c| c[2] < 2);
        let params = Params { lidar_patience: patience, ..params() };
        let (base, state) = ([dice.between(0.5, 7.0), dice.between(0.5, 6.0), 0.3], [1.0, 0.0]);
        let mut sampler = fresh(&map, &all, &params);
        let found = sampler.candidates(&mast(&map), &COSTS, base, &state).unwrap();
        for view in &found.views {
            prop_assert!(mast(&map).is_free(view.base, &view.state));
            prop_assert!(view.gain.info >= params.threshold);
            prop_assert_eq!(sampler.gain_at(view.base, &view.camera).unwrap(), view.gain);
            let seconds = COSTS.seconds((&base, &state), (&view.base, &view.state));
            prop_assert_eq!(view.seconds, seconds);
            prop_assert!((view.score - (-0.5 * seconds).exp() * view.gain.info).abs() < 1e-12);
            prop_assert!(view.own <= view.gain.exploration + view.gain.inspection);
            // The camera stands over a base that faces the cluster.
            let centroid = all.iter().find(|c| Some(c.id) == view.cluster).unwrap().borrow().centroid;
            let bearing = (centroid[1] - view.base[1]).atan2(centroid[0] - view.base[0]);
            prop_assert!((bearing - view.base[2]).sin().abs() < 1e-9);
        }
        // Asking again casts nothing and answers the same.
        let again = sampler.candidates(&mast(&map), &COSTS, base, &state).unwrap();
        prop_assert_eq!(&again.views, &found.views);
        prop_assert_eq!(again.effort, viewsample::Effort::default());
        // The nearer robot has the better score.
        prop_assert!(found.views.iter().all(|v| v.score <= v.gain.info));
    }

    /// With shared LiDAR views, the gain is that of the LiDAR in the middle of its square (or where
    /// it is, if that is not free), and asking again answers the same.
    #[test]
    fn shared_lidar_views_look_from_the_middle(seed in any::<u64>(), side in 0.2..0.9f64) {
        let mut dice = Dice::new(seed);
        let map = hall(&mut dice);
        let all = clusters(&map, |c| c[2] < 2);
        let params = Params { lidar_grid: side, ..params() };
        let lidar = params.lidar.unwrap();
        let (base, state) = ([dice.between(0.5, 7.0), dice.between(0.5, 6.0), 0.3], [1.0, 0.0]);
        let mut sampler = fresh(&map, &all, &params);
        let found = sampler.candidates(&mast(&map), &COSTS, base, &state).unwrap();
        for view in &found.views {
            let eye = lidar.eye(view.base);
            let mut middle = [0, 1].map(|a: usize| ((eye[a] / side).floor() + 0.5) * side).to_vec();
            middle.push(eye[2]);
            let at = if map.is_free(map.cell_at([middle[0], middle[1], eye[2]])) { middle } else { eye.to_vec() };
            // The base whose LiDAR is there.
            let there = [at[0] - lidar.offset[0], at[1] - lidar.offset[1], 0.0];
            prop_assert_eq!(sampler.gain_at(there, &view.camera).unwrap(), view.gain);
        }
        let again = sampler.candidates(&mast(&map), &COSTS, base, &state).unwrap();
        prop_assert_eq!(&again.views, &found.views);
    }

    /// Shared and late LiDAR views settle: without further changes, patience runs out and
    /// the answer is that of a sampler built anew.
    #[test]
    fn late_views_catch_up(seed in any::<u64>()) {
        let mut dice = Dice::new(seed);
        let mut map = hall(&mut dice);
        let params = Params { lidar_grid: 0.5, lidar_patience: 2, ..params() };
        let (base, state) = ([3.0, 3.0, 0.3], [1.0, 0.0]);
        let old = clusters(&map, |_| false);
        let mut sampler = fresh(&map, &old, &params);
        sampler.candidates(&mast(&map), &COSTS, base, &state).unwrap();
        fill(&mut map, [dice.below(20), dice.below(16), 0], [5, 5, 8], b".#"[dice.below(2)]);
        let all = clusters(&map, |_| false);
        let added: Vec<Cluster<'_>> = all.iter().map(OwnedCluster::borrow).collect();
        let removed: Vec<u64> = old.iter().map(|c| c.id).filter(|id| all.iter().all(|c| c.id != *id)).collect();
        let (low, high) = map.bounds();
        sampler.update(&map, &Changes { added: &added, removed: &removed, boxes: &[(low, high)] }).unwrap();
        for _ in 0..2 {
            sampler.candidates(&mast(&map), &COSTS, base, &state).unwrap();
            sampler.update(&map, &Changes::default()).unwrap();
        }
        let late = sampler.candidates(&mast(&map), &COSTS, base, &state).unwrap();
        let anew = fresh(&map, &all, &params).candidates(&mast(&map), &COSTS, base, &state).unwrap();
        prop_assert_eq!(&late.views, &anew.views);
    }

    /// With patience, counts never include cells that are no frontier any more.
    #[test]
    fn late_counts_never_count_what_is_gone(seed in any::<u64>()) {
        let mut dice = Dice::new(seed);
        let map = hall(&mut dice);
        let all = clusters(&map, |_| false);
        let params = Params { lidar_patience: 9, threshold: 0.2, ..params() };
        let mut sampler = fresh(&map, &all, &params);
        let (base, state) = ([3.0, 3.0, 0.3], [1.0, 0.0]);
        sampler.candidates(&mast(&map), &COSTS, base, &state).unwrap();
        // Half of the clusters go.
        let removed: Vec<u64> = all.iter().map(|c| c.id).filter(|_| dice.below(2) == 0).collect();
        sampler.update(&map, &Changes { removed: &removed, ..Changes::default() }).unwrap();
        let found = sampler.candidates(&mast(&map), &COSTS, base, &state).unwrap();
        for view in &found.views {
            prop_assert!(view.cluster.is_some_and(|id| !removed.contains(&id)));
            prop_assert_eq!(sampler.gain_at(view.base, &view.camera).unwrap(), view.gain);
        }
    }

    /// Any finite cluster anywhere is taken or refused with an error, never a panic.
    #[test]
    fn odd_clusters_do_no_harm(
        p in prop::array::uniform3(coordinate()), cell in prop::array::uniform3(-300..300i32), centroid in any::<[f64; 3]>(),
    ) {
        let map = hall(&mut Dice::new(1));
        let mut sampler = fresh(&map, &[], &params());
        let cells = [cell];
        let odd = Cluster { id: 3, kind: viewsample::Kind::Exploration, cells: &cells, centroid: p };
        let odder = Cluster { id: 4, centroid, ..odd };
        sampler.update(&map, &Changes { added: &[odd], ..Changes::default() }).unwrap();
        let finite = centroid.iter().all(|v| v.is_finite());
        prop_assert_eq!(sampler.update(&map, &Changes { added: &[odder], ..Changes::default() }).is_ok(), finite);
        let found = sampler.candidates(&mast(&map), &COSTS, [2.0, 2.0, 0.0], &[1.0, 0.0]).unwrap();
        prop_assert_eq!(found.views.len() + found.without.len(), sampler.len());
        sampler.retry(&[3, 4], &mast(&map), &COSTS, [2.0, 2.0, 0.0], &[1.0, 0.0]).unwrap();
        sampler.gain_at(p, &Pose::looking(p, 0.0, 0.0)).unwrap();
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// A cover's gains fall, reach the least asked for, add up to what the chosen views see together, and nothing that
    /// was left out would have added as much.
    #[test]
    fn covers_add_up(seed in any::<u64>(), least in 0.3..6.0f64) {
        let mut dice = Dice::new(seed);
        let map = hall(&mut dice);
        let all = clusters(&map, |_| false);
        let mut sampler = fresh(&map, &all, &params());
        let (base, state) = ([3.0, 3.0, 0.3], [1.0, 0.0]);
        let mut views = sampler.candidates(&mast(&map), &COSTS, base, &state).unwrap().views;
        let here = [dice.between(1.0, 6.5), dice.between(1.0, 5.5)];
        let (turns, _) = sampler.views_from(&[here], &mast(&map), &COSTS, base, &state).unwrap();
        for view in &turns {
            prop_assert!([view.base[0], view.base[1]] == here && view.cluster.is_none());
            prop_assert!(view.gain.info >= params().threshold && mast(&map).is_free(view.base, &view.state));
            prop_assert_eq!(sampler.gain_at(view.base, &view.camera).unwrap(), view.gain);
        }
        views.extend(turns);
        let (chosen, _) = sampler.cover(&views, least).unwrap();
        let sight = |n: usize| {
            let seen = sampler.seen_from(views[n].base, &views[n].camera).unwrap();
            (seen.exploration, seen.inspection)
        };
        let worth = |covered: &(Vec<Cell>, Vec<Cell>), (e, i): &(Vec<Cell>, Vec<Cell>)| {
            let new = |list: &[Cell], of: &[Cell]| of.iter().filter(|c| !list.contains(c)).count();
            0.2 * new(&covered.0, e) as f64 + 0.8 * new(&covered.1, i) as f64
        };
        let mut covered = (Vec::new(), Vec::new());
        let mut last = f64::INFINITY;
        for (n, gain) in &chosen {
            let seen = sight(*n);
            prop_assert!((gain.info - worth(&covered, &seen)).abs() < 1e-9);
            prop_assert!(gain.info <= last + 1e-9 && gain.info >= least);
            last = gain.info;
            covered.0.extend(seen.0);
            covered.1.extend(seen.1);
        }
        for n in 0..views.len() {
            prop_assert!(worth(&covered, &sight(n)) < least + 1e-9);
        }
    }

    /// A cover by rate adds up and leaves nothing out as well; with equal times it is the plain cover, its first view pays most
    /// for its way, and what is looked at before or never reached is not chosen.
    #[test]
    fn covers_by_rate_add_up(seed in any::<u64>(), least in 0.3..6.0f64, stay in 0.1..2.0f64) {
        let mut dice = Dice::new(seed);
        let map = hall(&mut dice);
        let all = clusters(&map, |_| false);
        let mut sampler = fresh(&map, &all, &params());
        let (base, state) = ([3.0, 3.0, 0.3], [1.0, 0.0]);
        let mut views = sampler.candidates(&mast(&map), &COSTS, base, &state).unwrap().views;
        let here = [dice.between(1.0, 6.5), dice.between(1.0, 5.5)];
        views.extend(sampler.views_from(&[here], &mast(&map), &COSTS, base, &state).unwrap().0);
        let seconds = |from: Option<usize>, to: usize| {
            let from = from.map_or((&base, &state), |n| (&views[n].base, &views[n].state));
            COSTS.seconds(from, (&views[to].base, &views[to].state))
        };
        let (chosen, _) = sampler.cover_by_rate(&[], &views, usize::MAX, least, stay, seconds).unwrap();
        if let Some((first, gain)) = chosen.first() {
            let rate = |n: usize| views[n].gain.info / (seconds(None, n) + stay);
            prop_assert_eq!(*gain, views[*first].gain);
            prop_assert!((0..views.len()).all(|n| rate(n) <= rate(*first) + 1e-9));
        }
        let taken: Vec<_> = chosen.iter().map(|(n, _)| (views[*n].base, views[*n].camera)).collect();
        for (k, (n, gain)) in chosen.iter().enumerate() {
            prop_assert!(gain.info >= least);
            prop_assert!(chosen[..k].iter().all(|(earlier, _)| earlier != n));
        }
        // Together the views see what their gains add up to, and nothing is left that adds as much as asked for.
        let (mut e, mut i) = (std::collections::BTreeSet::new(), std::collections::BTreeSet::new());
        for (base, camera) in &taken {
            let seen = sampler.seen_from(*base, camera).unwrap();
            e.extend(seen.exploration);
            i.extend(seen.inspection);
        }
        let sum: f64 = chosen.iter().map(|c| c.1.info).sum();
        prop_assert!((sum - 0.2 * e.len() as f64 - 0.8 * i.len() as f64).abs() < 1e-6);
        prop_assert!(sampler.cover_by_rate(&taken, &views, usize::MAX, least, stay, seconds).unwrap().0.is_empty());
        // Equal times: the fewest views.
        let (even, _) = sampler.cover_by_rate(&[], &views, usize::MAX, least, stay, |_, _| 0.0).unwrap();
        let (plain, _) = sampler.cover(&views, least).unwrap();
        prop_assert_eq!(even, plain);
        let (few, _) = sampler.cover_by_rate(&[], &views, 2, least, stay, seconds).unwrap();
        prop_assert_eq!(&few[..], &chosen[..chosen.len().min(2)]);
        let (none, _) = sampler.cover_by_rate(&[], &views, usize::MAX, least, stay, |_, _| f64::INFINITY).unwrap();
        prop_assert!(none.is_empty());
        prop_assert!(sampler.cover_by_rate(&[], &views, usize::MAX, least, 0.0, seconds).is_err());
    }

    /// Aimed views are free, reach the threshold, stand where they may, and show what is said; the same seed aims the same.
    #[test]
    fn aimed_views_hold_what_they_promise(seed in any::<u64>(), threshold in 0.1..4.0f64, wanted in 1..4usize, drawn in any::<bool>()) {
        let mut dice = Dice::new(seed);
        let map = hall(&mut dice);
        let all = clusters(&map, |_| false);
        let crane = Crane(mast(&map));
        let (base, state) = ([3.0, 3.0, 0.3], Pose::looking([0.0, 0.0, 1.0], 0.0, 0.0));
        let posture = Posture { view: 0, camera: state, state };
        let mut sampler = Sampler::new(&params(), vec![posture]).unwrap();
        let added: Vec<Cluster<'_>> = all.iter().map(OwnedCluster::borrow).collect();
        let boxes = [map.bounds()];
        sampler.update(&map, &Changes { added: &added, removed: &[], boxes: &boxes }).unwrap();
        let ids: Vec<u64> = all.iter().map(|c| c.id).chain([u64::MAX]).collect();
        let aim = Aim {
            distance: (0.3, 2.0),
            heights: (0.3, 2.0),
            tilt: 1.0,
            reach: (1.0, 1.0),
            views: wanted,
            tries: 60,
            bases: 3,
            threshold,
            seed,
        };
        let place = [dice.between(1.0, 6.5), dice.between(1.0, 5.5)];
        let ask = || sampler.aimed(&aim, &ids, &[place], &crane, &Waits, (&base, &state), drawn.then(|| InverseReach::new(1.0)).as_mut()).unwrap().0;
        let views = ask();
        for view in &views {
            prop_assert!(crane.is_free(view.base, &view.state));
            prop_assert_eq!(view.gain, sampler.gain_at(view.base, &view.camera).unwrap());
            prop_assert!(view.gain.info >= threshold && view.gain.info > 0.0);
            let eye = view.camera.translation;
            prop_assert!((eye[0] - view.base[0]).hypot(eye[1] - view.base[1]) <= 1.0 + 1e-9);
            prop_assert!(ids.contains(&view.cluster.unwrap()));
        }
        for id in &ids {
            prop_assert!(views.iter().filter(|v| v.cluster == Some(*id)).count() <= wanted);
        }
        prop_assert_eq!(views, ask());
        // What is out of range is named.
        let bad = [
            (Aim { distance: (0.0, 1.0), ..aim.clone() }, "distance.0"),
            (Aim { distance: (0.5, f64::NAN), ..aim.clone() }, "distance.1"),
            (Aim { tilt: 1.6, ..aim.clone() }, "tilt"),
            (Aim { heights: (1.0, 0.5), ..aim.clone() }, "heights.1"),
            (Aim { reach: (0.5, -1.0), ..aim.clone() }, "reach.1"),
            (Aim { threshold: f64::NAN, ..aim.clone() }, "threshold"),
        ];
        for (aim, name) in bad {
            let told = sampler.aimed(&aim, &ids, &[], &crane, &Waits, (&base, &state), None);
            let named = matches!(told, Err(viewsample::Error::Param { field, .. }) if field == name);
            prop_assert!(named, "{}", name);
        }
    }

    /// A camera seen from a base and put back on it is the same; turned aside it shows at the place asked for what was straight
    /// ahead; rolled it looks the same way.
    #[test]
    fn cameras_turn_as_told(
        yaw in -7.0..7.0f64, pitch in -1.5..1.5f64, base in prop::array::uniform3(-4.0..4.0f64), roll in -7.0..7.0f64,
        at in prop::array::uniform2(-1.2..1.2f64),
    ) {
        let camera = Pose::looking([0.3, -0.2, 1.1], yaw, pitch).rolled(roll);
        let again = camera.seen_from(base).on(base);
        let ahead = [0, 1, 2].map(|a| camera.translation[a] + 2.0 * camera.forward()[a]);
        let seen = camera.showing_ahead_at(at).to_camera(ahead);
        prop_assert!((seen[0] / seen[2] - at[0]).abs() < 1e-9 && (seen[1] / seen[2] - at[1]).abs() < 1e-9);
        for i in 0..3 {
            prop_assert!((again.translation[i] - camera.translation[i]).abs() < 1e-12);
            for j in 0..3 {
                prop_assert!((again.rotation[i][j] - camera.rotation[i][j]).abs() < 1e-12);
            }
        }
        let straight = Pose::looking([0.3, -0.2, 1.1], yaw, pitch);
        let below = [0, 1, 2].map(|a| straight.translation[a] + straight.rotation[a][1]);
        let turned = straight.rolled(std::f64::consts::FRAC_PI_2).to_camera(below);
        prop_assert!((turned[0] - 1.0).abs() < 1e-12 && turned[1].abs() < 1e-12);
        prop_assert!((0..3).all(|a| (straight.forward()[a] - camera.forward()[a]).abs() < 1e-12));
        let column = |pose: &Pose, j: usize| [0, 1, 2].map(|i: usize| pose.rotation[i][j]);
        let (turned, dot) = (camera.showing_ahead_at(at), |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| a[i] * b[i]).sum::<f64>());
        for j in 0..3 {
            for k in 0..3 {
                let expected = f64::from(u8::from(j == k));
                prop_assert!((dot(column(&turned, j), column(&turned, k)) - expected).abs() < 1e-12);
            }
        }
    }

    /// A limit on looks names views that are what they say, none better than the best; a limit never reached changes nothing.
    #[test]
    fn few_looks_name_true_views(seed in any::<u64>(), most in 1usize..6) {
        let mut dice = Dice::new(seed);
        let map = hall(&mut dice);
        let all = clusters(&map, |_| false);
        let (base, state) = ([3.0, 3.0, 0.3], [1.0, 0.0]);
        let with = |most_looks| {
            let mut sampler = fresh(&map, &all, &Params { most_looks, ..params() });
            let found = sampler.candidates(&mast(&map), &COSTS, base, &state).unwrap();
            (sampler, found)
        };
        let (_, exact) = with(None);
        let (sampler, few) = with(Some(most));
        prop_assert_eq!(&with(Some(1000)).1.views, &exact.views);
        prop_assert!(few.effort.camera_views <= exact.effort.camera_views);
        prop_assert_eq!(few.views.len(), exact.views.len());
        for (view, best) in few.views.iter().zip(&exact.views) {
            prop_assert_eq!(view.cluster, best.cluster);
            prop_assert!(view.score <= best.score + 1e-12);
            prop_assert!(view.gain.info >= params().threshold && mast(&map).is_free(view.base, &view.state));
            prop_assert_eq!(sampler.gain_at(view.base, &view.camera).unwrap(), view.gain);
        }
    }

    /// With a share, a library goes on offering its view until that lost more, cannot be taken up or falls below the threshold;
    /// then it offers what a search finds.
    #[test]
    fn views_are_held_until_they_lost_their_share(seed in any::<u64>(), share in prop_oneof![Just(1.0), 0.2..1.0f64]) {
        let mut dice = Dice::new(seed);
        let map = hall(&mut dice);
        let all = clusters(&map, |_| false);
        let params = Params { hold_share: Some(share), ..params() };
        let (base, state) = ([3.0, 3.0, 0.3], [1.0, 0.0]);
        let mut sampler = fresh(&map, &all, &params);
        let first = sampler.candidates(&mast(&map), &COSTS, base, &state).unwrap().views;
        prop_assert_eq!(&first, &fresh(&map, &all, &Params { hold_share: None, ..params.clone() })
            .candidates(&mast(&map), &COSTS, base, &state).unwrap().views);
        // Some cells are seen, and the robot goes elsewhere.
        let seen: Vec<Cell> = all.iter().flat_map(|c| c.cells.clone()).filter(|_| dice.below(3) == 0).collect();
        let left: Vec<OwnedCluster> = all.iter().map(|c| OwnedCluster {
            cells: c.cells.iter().copied().filter(|c| !seen.contains(c)).collect(),
            ..c.clone()
        }).collect();
        let changed: Vec<Cluster<'_>> = left.iter().zip(&all)
            .map(|(left, all)| Cluster { centroid: all.borrow().centroid, ..left.borrow() })
            .collect();
        let boxes: Vec<(Cell, Cell)> = seen.iter().map(|c| (*c, c.map(|v| v + 1))).collect();
        sampler.update(&map, &Changes { added: &changed, removed: &[], boxes: &boxes }).unwrap();
        let elsewhere = [5.0, 2.0, -1.0];
        let then = sampler.candidates(&mast(&map), &COSTS, elsewhere, &state).unwrap().views;
        let mut anew = Sampler::new(&Params { hold_share: None, ..params.clone() }, solved(&map, &params)).unwrap();
        anew.update(&map, &Changes { added: &changed, removed: &[], boxes: &[map.bounds()] }).unwrap();
        let searched = anew.candidates(&mast(&map), &COSTS, elsewhere, &state).unwrap().views;
        for view in &then {
            prop_assert_eq!(sampler.gain_at(view.base, &view.camera).unwrap(), view.gain);
            prop_assert!(view.gain.info >= params.threshold && mast(&map).is_free(view.base, &view.state));
            let before = first.iter().find(|v| v.cluster == view.cluster);
            let is_held = before.is_some_and(|v| (v.base, v.posture) == (view.base, view.posture) && view.gain.info >= share * v.gain.info);
            prop_assert!(is_held || searched.contains(view), "{view:?}");
        }
        prop_assert_eq!(then.len(), searched.len());
    }

    /// What a way shows is what its looks show together, each cell once; with a LiDAR only inspection counts.
    #[test]
    fn ways_show_what_their_looks_show(seed in any::<u64>()) {
        let mut dice = Dice::new(seed);
        let map = hall(&mut dice);
        let all = clusters(&map, |_| false);
        let sampler = fresh(&map, &all, &params());
        let way: Vec<_> = (0..6).map(|_| {
            let base = [dice.between(1.0, 6.5), dice.between(1.0, 5.5), dice.between(-3.0, 3.0)];
            let eye = [base[0], base[1], dice.between(0.3, 1.5)];
            (base, Pose::looking(eye, dice.between(-3.0, 3.0), dice.between(-0.6, 0.6)))
        }).collect();
        let mut seen: Vec<Cell> = way.iter().flat_map(|(base, camera)| sampler.seen_from(*base, camera).unwrap().inspection).collect();
        seen.sort_unstable();
        seen.dedup();
        let gain = sampler.gain_along(&way).unwrap();
        prop_assert_eq!(gain.inspection as usize, seen.len());
        if params().lidar.is_some() {
            prop_assert_eq!(gain.exploration, 0);
        }
        // More looks never show less.
        let less = sampler.gain_along(&way[..3]).unwrap();
        prop_assert!(less.info <= gain.info);
        let twice = sampler.gain_along(&[&way[..], &way[..]].concat()).unwrap();
        prop_assert_eq!(twice, gain);
    }
}
