//! Laws of the planners, on a closet that is partly known.

use super::aep::Aep;
use super::planner::{Next, Planner, Sight};
use super::rig::Rig;
use super::settings::{Baseline, BaselineSettings, Measure};
use super::stand::{in_reach, stands};
use super::view::{Room, View, apart};
use super::wg_nbvp::{WgNbvp, corners};
use crate::heats::Ways;
use crate::record::Silent;
use crate::scene::Scene;
use robots::BodyState;

/// Does `test` with a robot in the closet that knows what is within `known` m of the middle of the room.
fn in_the_closet(settings: &BaselineSettings, known: f64, test: &mut dyn FnMut(&mut Rig<'_>)) {
    let scene = Scene::builtin("closet").expect("embedded");
    let mut silent = Silent;
    let mut rig = Rig::new(&scene, settings, &mut silent).expect("a valid start");
    rig.mapper.map.set_free_sphere([2.0, 2.0, 1.0], known);
    let _ = rig.mapper.refresh();
    test(&mut rig);
}

fn look(rig: &Rig<'_>, now: f64, test: &mut dyn FnMut(&Sight<'_>)) {
    let disc = 0.5 * rig.robot.base.width + rig.settings.motion.base_clearance;
    let ways = Ways::new(&rig.mapper, disc).expect("a small map");
    let state = rig.sim.state();
    let camera = rig.sim.camera();
    let sight = Sight {
        whole: rig.whole(),
        ways: &ways,
        params: &rig.params,
        base: state.base,
        joints: state.joints,
        camera: View {
            place: camera.1,
            yaw: 0.0,
            pitch: 0.0,
        },
        turret: [state.base[0], state.base[1], rig.robot.base.pedestal_top],
        band: rig.settings.map.inspect_band,
        disc,
        now,
    };
    test(&sight);
}

#[test]
fn cached_gains_near_the_robot_are_never_older_than_the_period() {
    let settings = BaselineSettings::default();
    in_the_closet(&settings, 1.6, &mut |rig| {
        let mut aep = Aep::new(&settings.aep, rig.field, 20.0, 1);
        for (k, now) in [0.0, 4.0, 5.0, 7.0, 12.0].into_iter().enumerate() {
            // More of the closet becomes known from call to call.
            let low = [0.5 * k as f64, 0.0, 0.0];
            rig.mapper.map.set_free_box(low, [0.5 + low[0], 4.2, 2.4]);
            let _ = rig.mapper.refresh();
            look(rig, now, &mut |sight| {
                let _ = aep.next(sight);
                assert!(!aep.cached().is_empty());
                for cached in aep.cached() {
                    let near = (0..3).all(|a| {
                        (cached.view.place[a] - sight.camera.place[a]).abs()
                            <= 2.0 * settings.aep.rays.range.1
                    });
                    if near && cached.gain > settings.aep.renew_above {
                        assert!(
                            now - cached.at < settings.aep.renew_period,
                            "{cached:?} {now}"
                        );
                    }
                }
            });
        }
    });
}

#[test]
fn what_aep_offers_can_be_flown_to_and_is_an_edge_or_a_cached_place() {
    for (known, seed) in [(1.2, 1), (1.6, 2), (2.2, 3)] {
        let settings = BaselineSettings::default();
        in_the_closet(&settings, known, &mut |rig| {
            let mut aep = Aep::new(&settings.aep, rig.field, 20.0, seed);
            look(rig, 0.0, &mut |sight| {
                let Next::First(views) = aep.next(sight) else {
                    panic!("there is much to see")
                };
                let room = Room {
                    whole: &sight.whole,
                    radius: settings.aep.radius,
                    heights: settings.aep.heights,
                    ground: Some(sight.disc),
                };
                assert!(!views.is_empty());
                for view in views {
                    let edge = apart(&view.place, &sight.camera.place) <= settings.aep.edge + 1e-9;
                    let cached = aep.cached().iter().any(|c| c.view.place == view.place);
                    assert!(edge || cached, "{view:?}");
                    assert!(!edge || room.holds(view.place), "{view:?}");
                }
            });
        });
    }
}

#[test]
fn aep_ends_where_all_is_known_and_not_before() {
    let settings = BaselineSettings::default();
    in_the_closet(&settings, 9.0, &mut |rig| {
        let mut aep = Aep::new(&settings.aep, rig.field, 20.0, 1);
        look(rig, 0.0, &mut |sight| {
            assert_eq!(aep.next(sight), Next::Done)
        });
    });
}

#[test]
fn weighted_gains_are_made_of_shares() {
    for measure in [Measure::FreeSpace, Measure::Inspection] {
        let mut settings = BaselineSettings::of(Baseline::WgNbvp);
        settings.wg_nbvp.measure = measure;
        in_the_closet(&settings, 1.6, &mut |rig| {
            // A wall to inspect.
            for y in 5..20 {
                for z in 2..12 {
                    rig.mapper
                        .map
                        .set_state([20, y, z], voxmap::State::Occupied);
                }
            }
            let _ = rig.mapper.refresh();
            let mut planner = WgNbvp::new(&settings.wg_nbvp, rig.field, 20.0, 1);
            look(rig, 0.0, &mut |sight| {
                let surface = planner.surface(sight);
                assert_eq!(surface.is_empty(), measure == Measure::FreeSpace);
                let tree = planner.grow(sight, &surface, &[]);
                assert!(tree.len() > 10, "{}", tree.len());
                planner.reached(&tree[1].view);
                for node in &tree {
                    let terms = planner.terms(node);
                    assert!(terms.iter().all(|t| (0.0..=1.0).contains(t)), "{terms:?}");
                }
                let visited = planner.terms(&tree[1])[2];
                assert!((visited - 1.0).abs() < 1e-12);
                assert!(tree.iter().any(|n| planner.terms(n)[0] > 0.0));
                let measures = tree.iter().any(|n| planner.terms(n)[1] > 0.0);
                assert_eq!(measures, measure == Measure::Inspection);
            });
        });
    }
}

#[test]
fn the_tree_keeps_its_limits_and_what_is_chosen_is_free() {
    let settings = BaselineSettings::of(Baseline::WgNbvp);
    let s = &settings.wg_nbvp;
    for seed in 1..4 {
        in_the_closet(&settings, 1.8, &mut |rig| {
            let mut planner = WgNbvp::new(s, rig.field, 20.0, seed);
            look(rig, 0.0, &mut |sight| {
                let room = Room {
                    whole: &sight.whole,
                    radius: s.radius,
                    heights: s.heights,
                    ground: None,
                };
                let tree = planner.grow(sight, &[], &[]);
                for (i, node) in tree.iter().enumerate().skip(1) {
                    let p = node.view.place;
                    let parent = tree[node.parent.expect("not the root")].view.place;
                    assert!(room.holds(p) && room.connects(parent, p), "{p:?}");
                    assert!((s.heights.0..=s.heights.1).contains(&p[2]));
                    assert!(apart(&p, &parent) <= s.step + 1e-9);
                    assert!(
                        tree[..i]
                            .iter()
                            .all(|n| apart(&n.view.place, &p) >= s.spacing - 1e-6)
                    );
                }
                let from = (sight.base, sight.joints);
                match planner.next(sight) {
                    Next::Done => panic!("there is much to see"),
                    Next::Sweep(views) => {
                        for view in views {
                            let stand = in_reach(&sight.whole, sight.params, from, &view);
                            let stand = stand.expect("in the arm's reach");
                            assert!(sight.whole.arm_is_free(sight.base, &stand.joints));
                        }
                    }
                    Next::First(views) => {
                        for view in views {
                            assert!(apart(&view.place, &sight.turret) > 0.0);
                        }
                    }
                }
            });
        });
    }
}

#[test]
fn stands_show_the_view_free_of_collision_the_quickest_first() {
    let settings = BaselineSettings::default();
    in_the_closet(&settings, 2.1, &mut |rig| {
        look(rig, 0.0, &mut |sight| {
            let mut found_any = false;
            for (x, y, yaw) in [
                (2.0, 2.2, 0.3),
                (2.4, 2.0, 2.0),
                (1.8, 1.6, -1.2),
                (2.0, 2.0, 0.0),
            ] {
                let view = View {
                    place: [x, y, 1.1],
                    yaw,
                    pitch: 0.0,
                };
                let from = (sight.base, sight.joints);
                let (whole, settings) = (&sight.whole, &settings.stand);
                let found = stands(
                    whole,
                    sight.ways,
                    sight.params,
                    settings,
                    from,
                    &view,
                    &mut 0,
                );
                assert!(found.windows(2).all(|p| p[0].seconds <= p[1].seconds));
                found_any |= !found.is_empty();
                for stand in found {
                    assert!(whole.base_room(stand.base) >= 0.0);
                    assert!(whole.arm_is_free(stand.base, &stand.joints));
                    let frame = whole.robot.camera_frame(&BodyState {
                        base: stand.base,
                        joints: stand.joints,
                    });
                    let (off, turned) = frame.error_to(&view.frame());
                    assert!(off < 1e-6 && turned < 1e-6, "{off} {turned}");
                }
            }
            assert!(found_any);
        });
    });
}

#[test]
fn the_arm_stops_at_the_corners_of_its_views() {
    let view = |x: f64, y: f64| View {
        place: [x, y, 1.0],
        yaw: 0.0,
        pitch: 0.0,
    };
    let views = [
        view(0.0, 0.0),
        view(1.0, 1.0),
        view(2.0, 0.0),
        view(1.0, 0.5),
        view(1.0, 3.0),
    ];
    assert_eq!(corners(&views), [views[0], views[2], views[4]]);
    // Few views and views in a line lose at most what lies between.
    assert_eq!(corners(&views[..2]), views[..2]);
    let line = [view(0.0, 0.0), view(1.0, 1.0), view(2.0, 2.0)];
    assert_eq!(corners(&line), [line[0], line[2]]);
}

#[test]
fn settings_are_checked_by_name_and_read_back() {
    let settings = BaselineSettings::of(Baseline::WgNbvp);
    assert_eq!(
        BaselineSettings::from_toml(&settings.to_toml()),
        Ok(settings.clone())
    );
    for (wrong, name) in [
        ("aep.decay=-1", "aep.decay"),
        ("aep.rays.pitches=[]", "aep.rays.pitches"),
        ("aep.rays.pitches=[80]", "aep.rays.pitches"),
        ("aep.rays.range=[4.0, 1.0]", "aep.rays.range"),
        ("wg_nbvp.nodes=0", "wg_nbvp.nodes"),
        ("wg_nbvp.rays.angle_step=0", "wg_nbvp.rays.angle_step"),
        ("stand.distances=[]", "stand.distances"),
        ("motion.guard_margin=1", "motion.guard_margin"),
    ] {
        let settings = BaselineSettings::default().with([wrong]).expect(wrong);
        let error = settings.validate().expect_err(wrong).to_string();
        assert!(error.contains(name), "{error}");
    }
    assert!(BaselineSettings::default().with(["aep.magic=1"]).is_err());
}
