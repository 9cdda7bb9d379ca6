#![allow(missing_docs, clippy::unwrap_used)]

use hybrid_astar::grid::Grid;
use hybrid_astar::*;

/// 8 m by 6 m, empty.
fn hall() -> Grid {
    Grid::new([80, 60], 0.1, [0.0; 2], &[false; 4800]).unwrap()
}

/// The hall with a wall at x = 4 m and a door of the given width at y = 3 m.
fn two_rooms(door: f64) -> Grid {
    let blocked: Vec<bool> = (0..4800)
        .map(|i| {
            let (x, y) = (i % 80, i / 80);
            (40..42).contains(&x) && ((y as f64 + 0.5) * 0.1 - 3.0).abs() > 0.5 * door
        })
        .collect();
    Grid::new([80, 60], 0.1, [0.0; 2], &blocked).unwrap()
}

fn robot() -> Footprint {
    Footprint::circles(&[
        ([-0.25, 0.0], 0.302),
        ([0.0, 0.0], 0.302),
        ([0.25, 0.0], 0.302),
    ])
}

fn go(map: &Grid, start: [f64; 3], goal: [f64; 2], yaw: &GoalYaw) -> Plan {
    plan(map, &robot(), start, goal, yaw, &Params::default()).unwrap()
}

#[test]
fn straight_ahead_is_one_run_of_the_trapezoid() {
    let p = go(&hall(), [1.0, 3.0, 0.0], [6.0, 3.0], &GoalYaw::Free);
    assert_eq!((p.status, p.segments.len()), (Status::Solved, 1));
    assert!((p.length - 5.0).abs() < 1e-9);
    // 5 m at 0.8 m/s plus one second for speeding up and braking.
    assert!((p.seconds - 7.25).abs() < 0.01, "{}", p.seconds);
}

#[test]
fn a_free_heading_curves_without_a_stop() {
    let p = go(&hall(), [1.5, 1.5, 1.57], [6.0, 3.0], &GoalYaw::Free);
    assert_eq!(p.segments.len(), 1);
    assert_eq!(p.segments[0].motion, Motion::Forward);
}

#[test]
fn start_on_the_goal_is_solved_and_empty() {
    let p = go(&hall(), [1.0, 3.0, 0.4], [1.0, 3.0], &GoalYaw::Free);
    assert_eq!(
        (p.status, p.length, p.seconds, p.segments.len()),
        (Status::Solved, 0.0, 0.0, 0)
    );
    assert_eq!(p.poses(), [[1.0, 3.0, 0.4]]);
    let timed = p.time(&Limits::default(), 0.1).unwrap();
    assert_eq!((timed.poses.len(), timed.seconds()), (1, 0.0));
    let p = go(&hall(), [1.0, 3.0, 0.4], [1.0, 3.0], &GoalYaw::Fixed(-2.0));
    assert_eq!((p.segments.len(), p.segments[0].motion), (1, Motion::Turn));
}

#[test]
fn doors_that_fit_and_that_do_not() {
    let (start, goal) = ([1.0, 1.0, 0.0], [7.0, 5.0]);
    assert_eq!(
        go(&two_rooms(0.9), start, goal, &GoalYaw::Free).status,
        Status::Solved
    );
    let shut = go(&two_rooms(0.0), start, goal, &GoalYaw::Free);
    assert_eq!(shut.status, Status::Disconnected);
    assert_eq!(
        shut.reason.unwrap().to_string(),
        "no connection from start to goal for a disc of 0.322 m, the largest inside the footprint"
    );
    // Open for the wave's generous disc, not for the robot: the reason names the door.
    let tight = go(&two_rooms(0.6), start, goal, &GoalYaw::Free);
    assert!(
        matches!(
            tight.status,
            Status::Exhausted | Status::BudgetExhausted | Status::Disconnected
        ),
        "{:?}",
        tight.status
    );
    if let Some(Reason::NotReached { gap, .. }) = tight.reason {
        let gap = gap.unwrap();
        assert!(
            (gap[0] - 4.1).abs() < 0.5 && (gap[1] - 3.0).abs() < 0.5,
            "{gap:?}"
        );
    }
}

#[test]
fn blocked_ends_say_by_how_much() {
    let map = two_rooms(0.9);
    let p = go(&map, [4.0, 0.5, 0.0], [7.0, 5.0], &GoalYaw::Free);
    assert_eq!(p.status, Status::StartBlocked);
    let reason = p.reason.unwrap().to_string();
    assert!(
        reason.starts_with("start footprint at (4.00, 0.50, 0.00 rad) overlaps an obstacle at (4."),
        "{reason}"
    );
    let p = go(&map, [3.55, 1.0, 0.0], [7.0, 5.0], &GoalYaw::Free);
    assert!(p.reason.unwrap().to_string().contains("lacks 0."));
    let p = go(&map, [1.0, 1.0, 0.0], [4.1, 0.5], &GoalYaw::Free);
    assert_eq!(p.status, Status::GoalBlocked);
    let reason = p.reason.unwrap().to_string();
    assert!(
        reason.contains("needs at least 0.322 m") && reason.contains("overlaps an obstacle at (4."),
        "{reason}"
    );
    for goal in [[99.0, 0.5], [1.0, -0.01]] {
        let p = go(&map, [1.0, 1.0, 0.0], goal, &GoalYaw::Free);
        assert_eq!(p.status, Status::GoalBlocked);
        assert!(
            p.reason
                .unwrap()
                .to_string()
                .contains("outside the map, which spans (0.00, 0.00) to (8.00, 6.00)")
        );
    }
    let p = go(&map, [-50.0, 1.0, 0.0], [1.0, 1.0], &GoalYaw::Free);
    assert_eq!(p.status, Status::StartBlocked);
    assert!(
        p.reason
            .unwrap()
            .to_string()
            .starts_with("start (-50.00, 1.00) lies outside")
    );
}

#[test]
fn a_blocked_goal_moves_within_its_tolerance() {
    let params = Params {
        goal_tolerance: 0.6,
        ..Params::default()
    };
    let p = plan(
        &two_rooms(0.9),
        &robot(),
        [1.0, 1.0, 0.0],
        [3.8, 1.0],
        &GoalYaw::Free,
        &params,
    )
    .unwrap();
    assert_eq!(p.status, Status::Solved);
    assert!(p.goal_shift > 0.05 && p.goal_shift < 0.6);
}

/// Least room of the robot's circles, m.
fn room(map: &Grid, robot: &Footprint, q: [f64; 3]) -> f64 {
    let (sin, cos) = q[2].sin_cos();
    let at = |o: [f64; 2]| {
        [
            q[0] + cos * o[0] - sin * o[1],
            q[1] + sin * o[0] + cos * o[1],
        ]
    };
    let circles = robot.circles().iter();
    circles
        .map(|c| map.clearance(at(c.0)) - c.1)
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn a_start_too_close_is_left_hardly_closer() {
    // The tail is 5 cm nearer to the lower wall than the margin allows, the nose points away.
    let start = [3.0, 0.27 + 0.25 * 0.6f64.sin(), 0.6];
    let map = hall();
    let p = go(&map, start, [6.0, 4.0], &GoalYaw::Free);
    assert_eq!(p.status, Status::Solved);
    assert!(
        (p.start_violation - 0.052).abs() < 0.01,
        "{}",
        p.start_violation
    );
    let before = room(&map, &robot(), start);
    assert!(
        p.poses()
            .iter()
            .all(|&q| room(&map, &robot(), q) >= before - 0.0105)
    );
    let strict = Params {
        start_tolerance: 0.01,
        ..Params::default()
    };
    assert_eq!(
        plan(&map, &robot(), start, [6.0, 4.0], &GoalYaw::Free, &strict)
            .unwrap()
            .status,
        Status::StartBlocked
    );
}

/// Along a wall any curve away from it swings the tail towards it.
#[test]
fn a_start_along_a_wall_inside_the_margin_is_left_without_touching() {
    let params = Params {
        margin: 0.06,
        ..Params::default()
    };
    let map = hall();
    for yaw in [0.0, std::f64::consts::PI] {
        for short in [0.005, 0.03, 0.055] {
            let start = [4.0, 0.302 + 0.06 - short, yaw];
            let p = plan(&map, &robot(), start, [4.0, 4.0], &GoalYaw::Free, &params).unwrap();
            assert_eq!(p.status, Status::Solved, "{short} m short");
            assert!((p.start_violation - short).abs() < 0.006);
            let poses = p.poses();
            // Checked every 2 mm of way or so there, hence the tolerance.
            assert!(
                poses
                    .iter()
                    .all(|&q| room(&map, &robot(), q) > -0.005 - (short - 0.05).max(0.0))
            );
            // It gets away, not along: after three metres nothing is missing any more.
            let mut far = 0.0;
            for w in poses.windows(2) {
                far += (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]);
                assert!(far < 3.0 || room(&map, &robot(), w[1]) > 0.055);
            }
        }
    }
}

/// The same for an exact outline, which overlaps the wall a little.
#[test]
fn an_outline_along_a_wall_is_left() {
    let map = hall().with_inset(0.0);
    let robot = Footprint::polygon(&[[-0.45, -0.3], [0.45, -0.3], [0.45, 0.3], [-0.45, 0.3]]);
    // The first blocked centres are at y = -0.05: 1 cm inside the outline.
    let start = [4.0, 0.24, 0.0];
    let p = plan(
        &map,
        &robot,
        start,
        [4.0, 4.0],
        &GoalYaw::Free,
        &Params::default(),
    )
    .unwrap();
    assert_eq!(
        p.status,
        Status::Solved,
        "{:?} {}",
        p.reason,
        p.start_violation
    );
    assert!(
        (p.start_violation - 0.03).abs() < 1e-3,
        "{}",
        p.start_violation
    );
    // 20 cm inside is no measuring error.
    let deep = plan(
        &map,
        &robot,
        [4.0, 0.05, 0.0],
        [4.0, 4.0],
        &GoalYaw::Free,
        &Params::default(),
    )
    .unwrap();
    assert_eq!(deep.status, Status::StartBlocked);
}

#[test]
fn budgets_end_the_search() {
    let map = two_rooms(0.9);
    let none = Params {
        max_expansions: 0,
        ..Params::default()
    };
    let p = plan(
        &map,
        &robot(),
        [1.0, 1.0, 0.0],
        [7.0, 5.0],
        &GoalYaw::Free,
        &none,
    )
    .unwrap();
    assert_eq!((p.status, p.expansions), (Status::BudgetExhausted, 0));
    let narrow = two_rooms(0.6);
    let mut planner = Planner::new(Params::default()).unwrap();
    let p = planner
        .plan_until(
            &narrow,
            &robot(),
            [1.0, 1.0, 0.0],
            [7.0, 5.0],
            &GoalYaw::Free,
            &mut || true,
        )
        .unwrap();
    assert!(matches!(
        p.status,
        Status::Stopped | Status::Exhausted | Status::Disconnected
    ));
}

#[test]
fn bad_input_is_an_error_that_names_the_value() {
    let map = hall();
    let ask = |robot: &Footprint, start, goal, yaw: &GoalYaw, params: &Params| {
        plan(&map, robot, start, goal, yaw, params)
            .unwrap_err()
            .to_string()
    };
    let (s, g, p) = ([1.0; 3], [2.0; 2], Params::default());
    assert!(ask(&robot(), [f64::NAN, 1.0, 0.0], g, &GoalYaw::Free, &p).contains("start"));
    assert!(ask(&robot(), s, [f64::INFINITY, 0.0], &GoalYaw::Free, &p).contains("goal"));
    assert!(ask(&robot(), s, g, &GoalYaw::Fixed(f64::NAN), &p).contains("goal yaw"));
    assert!(ask(&robot(), s, g, &GoalYaw::Any(vec![]), &p).contains("at least one"));
    assert!(
        ask(&Footprint::circles(&[]), s, g, &GoalYaw::Free, &p).contains("at least one circle")
    );
    assert!(ask(&Footprint::disc(0.0), s, g, &GoalYaw::Free, &p).contains("positive"));
    assert!(
        ask(
            &robot(),
            s,
            g,
            &GoalYaw::Free,
            &Params {
                cell_size: 0.0,
                ..p.clone()
            }
        )
        .contains("cell_size = 0")
    );
    assert!(
        ask(
            &robot(),
            s,
            g,
            &GoalYaw::Free,
            &Params {
                limits: Limits {
                    v: 0.0,
                    ..Limits::default()
                },
                ..p.clone()
            }
        )
        .contains("v = 0")
    );
    assert!(
        ask(
            &robot(),
            s,
            g,
            &GoalYaw::Free,
            &Params {
                cell_size: 1e-9,
                ..p.clone()
            }
        )
        .contains("larger cells")
    );
    let solved = go(&map, [1.0, 1.0, 0.0], [2.0, 2.0], &GoalYaw::Free);
    assert!(
        solved
            .time(&Limits::default(), 0.0)
            .unwrap_err()
            .to_string()
            .contains("dt = 0")
    );
    assert!(solved.time(&Limits::default(), f64::NAN).is_err());
    assert!(Field::from(&map, -1.0, [1.0, 1.0], &GridParams::default()).is_err());
    assert!(Field::from(&map, 0.3, [f64::NAN, 1.0], &GridParams::default()).is_err());
}

#[test]
fn a_moving_start_keeps_its_speed() {
    let p = go(&hall(), [1.0, 3.0, 0.0], [6.0, 3.0], &GoalYaw::Free);
    let timed = p.time_from(&Limits::default(), 0.1, 0.8).unwrap();
    assert!(timed.v[0] > 0.78 && timed.seconds() < p.seconds);
    // Backwards is not how this path begins.
    assert_eq!(
        p.time_from(&Limits::default(), 0.1, -0.8).unwrap().v[0],
        0.0
    );
}

#[test]
fn fields_of_blocked_and_outside_points() {
    let map = two_rooms(0.0);
    let f = Field::from(&map, 0.3, [1.0, 1.0], &GridParams::default()).unwrap();
    assert!(
        f.distance([7.0, 5.0]).is_infinite()
            && f.distance([-5.0, 0.0]).is_infinite()
            && f.distance([f64::NAN; 2]).is_infinite()
    );
    assert!(f.path([7.0, 5.0]).is_empty());
    assert!(f.distance([3.8, 1.0]).is_infinite() && f.distance_near([3.8, 1.0], 0.6).is_finite());
    // A source in a wall starts from the nearest open cells.
    let f = Field::from(&map, 0.3, [3.8, 1.0], &GridParams::default()).unwrap();
    assert!((f.distance([1.0, 1.0]) - 2.8).abs() < 0.4);
}

/// Curvature and kind of motion of every stretch.
fn drives_like_a_car(p: &Plan, radius: f64, reverse: bool) {
    for s in &p.segments {
        assert!(s.motion != Motion::Turn && (reverse || s.motion == Motion::Forward));
        for w in s.poses.windows(2) {
            let moved = (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]);
            // The chord is a little shorter than the arc.
            assert!((w[1][2] - w[0][2]).abs() * radius <= moved * 1.01 + 1e-9);
        }
    }
}

#[test]
fn cars_turn_around_without_turning_in_place() {
    let map = hall();
    for (drive, reverse) in [
        (Drive::ReedsShepp { radius: 0.8 }, true),
        (Drive::Dubins { radius: 0.8 }, false),
    ] {
        let params = Params {
            drive,
            smooth: false,
            ..Params::default()
        };
        let yaw = GoalYaw::Fixed(std::f64::consts::PI);
        let p = plan(&map, &robot(), [2.0, 3.0, 0.0], [2.0, 3.6], &yaw, &params).unwrap();
        assert_eq!(p.status, Status::Solved, "{drive:?} {:?}", p.reason);
        drives_like_a_car(&p, 0.8, reverse);
        let smooth = Params {
            smooth: true,
            ..params
        };
        let p = plan(&map, &robot(), [2.0, 3.0, 0.0], [2.0, 3.6], &yaw, &smooth).unwrap();
        assert!(p.is_solved() && p.segments.iter().all(|s| s.motion != Motion::Turn));
        let p = plan(
            &two_rooms(0.9),
            &robot(),
            [1.0, 1.0, 0.5],
            [7.0, 5.0],
            &GoalYaw::Free,
            &smooth,
        )
        .unwrap();
        assert!(p.is_solved(), "{drive:?} {:?}", p.reason);
    }
    let none = Params {
        drive: Drive::Dubins { radius: 0.0 },
        ..Params::default()
    };
    let error = plan(&map, &robot(), [1.0; 3], [2.0; 2], &GoalYaw::Free, &none).unwrap_err();
    assert_eq!(
        error.to_string(),
        "drive.radius = 0 must be positive and finite"
    );
}

/// An outline of 0.7 m by 0.5 m and 2 cm of margin, on a map whose blocked cells are points.
fn outlined(map: Grid, start: [f64; 3], goal: [f64; 2]) -> Plan {
    let robot = Footprint::rectangle(0.7, 0.5, 3);
    let map = map.with_inset(0.0);
    plan(
        &map,
        &robot,
        start,
        goal,
        &GoalYaw::Free,
        &Params::default(),
    )
    .unwrap()
}

/// A room, and a corridor of `wide` cells from it that turns a corner.
fn bend(wide: usize) -> Grid {
    let blocked: Vec<bool> = (0..160 * 120)
        .map(|i| {
            let (x, y) = (i % 160, i / 160);
            let room = (5..50).contains(&x) && (5..50).contains(&y);
            let along = (5..130).contains(&x) && (60..60 + wide).contains(&y);
            let up = (130 - wide..130).contains(&x) && (60..115).contains(&y);
            let from_room = (20..20 + wide).contains(&x) && (40..65).contains(&y);
            !(room || along || up || from_room)
        })
        .collect();
    Grid::new([160, 120], 0.05, [0.0; 2], &blocked).unwrap()
}

#[test]
fn a_corner_too_tight_for_the_footprint_is_refused_with_its_place() {
    let (start, goal) = ([3.0, 3.3, 0.0], [6.2, 5.3]);
    // A box of length L and width W turns a square corner of width w if L + 2 W <= 2 sqrt(2) w: with the margin,
    // 0.74 and 0.54 m, from 0.644 m on. The centres of the cells at the sides of n free ones are n + 1 cells apart.
    let wide = outlined(bend(20), start, goal);
    assert_eq!(wide.status, Status::Solved, "{:?}", wide.reason);
    let tight = outlined(bend(11), start, goal);
    assert_eq!(tight.status, Status::NoPassage, "{:?}", tight.reason);
    let Some(Reason::NoPassage {
        at,
        clearance,
        radius,
        need,
    }) = tight.reason.clone()
    else {
        panic!("{:?}", tight.reason);
    };
    assert!((at[0] - 6.2).hypot(at[1] - 3.3) < 1.0, "{at:?}");
    assert!((radius - 0.27).abs() < 1e-9 && (need - 0.37f64.hypot(0.27)).abs() < 1e-9);
    assert!(clearance < need);
    let text = tight.reason.unwrap().to_string();
    assert!(
        text.contains("does not fit through at (") && text.contains("0.270 m"),
        "{text}"
    );
    assert!(tight.expansions < 2000, "{}", tight.expansions);
}

#[test]
fn narrow_doors_are_refused_by_proof_and_wide_ones_passed() {
    let door = |cells: usize| {
        let blocked: Vec<bool> = (0..160 * 120)
            .map(|i| {
                let (x, y) = (i % 160, i / 160);
                (80..83).contains(&x) && !(50..50 + cells).contains(&y)
            })
            .collect();
        Grid::new([160, 120], 0.05, [0.0; 2], &blocked).unwrap()
    };
    let (start, goal) = ([1.0, 1.0, 0.0], [7.0, 5.0]);
    // The centres of the cells at the jambs of a gap of n cells are n + 1 cells apart; 0.54 m are needed.
    for (cells, open) in [(11, true), (10, true), (9, false), (7, false), (5, false)] {
        let found = outlined(door(cells), start, goal);
        if open {
            assert_eq!(found.status, Status::Solved, "{cells}: {:?}", found.reason);
        } else {
            let proved = matches!(found.status, Status::NoPassage | Status::Disconnected);
            assert!(proved, "{cells}: {:?}", found.reason);
        }
    }
}

/// Tests run in debug and in release: both must find these very numbers.
#[test]
fn debug_and_release_plan_the_same() {
    let map = two_rooms(0.9);
    let mut seen = Vec::new();
    for (start, goal, yaw) in [
        ([1.0, 1.0, 0.0], [7.0, 5.0], GoalYaw::Free),
        ([1.0, 5.0, 2.0], [6.5, 0.8], GoalYaw::Fixed(-1.0)),
        ([3.0, 3.0, 3.1], [5.2, 3.1], GoalYaw::Fixed(3.1)),
    ] {
        let p = go(&map, start, goal, &yaw);
        let sum: f64 = p
            .poses()
            .iter()
            .map(|q| q[0] + 2.0 * q[1] + 3.0 * q[2])
            .sum();
        seen.push((p.expansions, (sum * 1e6).round() / 1e6));
    }
    assert_eq!(
        seen,
        [(33, 2136.962669), (4388, 5500.095626), (21, 1122.365247)]
    );
}
