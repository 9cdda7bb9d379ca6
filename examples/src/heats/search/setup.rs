//! A run before its first tick: robot, map, planners, simulator.

use super::*;

/// One arm posture for each attitude: the first on its own, each other one quick to reach from it.
fn camera_postures(
    robot: &MobileManipulator,
    attitudes: &[(f64, f64, f64)],
) -> Result<Vec<robots::Posture>, robots::Error> {
    let view = |&(degrees, height, _): &(f64, f64, f64)| robots::View {
        height,
        pitch: degrees.to_radians(),
    };
    let views: Vec<robots::View> = attitudes.iter().map(view).collect();
    let defaults = robots::PostureWeights::default();
    // The first decides by itself and by the way to the others; where those stretch out is settled after it.
    let mut postures = robot.postures(&views, &defaults)?;
    let Some(home) = postures.first().map(|p| p.joints) else {
        return Ok(postures);
    };
    for ((posture, view), attitude) in postures.iter_mut().zip(&views).zip(attitudes).skip(1) {
        let weights = robots::PostureWeights {
            ahead: [attitude.2, attitude.2.max(1.0), defaults.ahead[2]],
            height: [0.0, 0.0, defaults.height[2]],
            ..defaults.clone()
        };
        let price = |p: &robots::Posture| {
            let way = weights.second * robot.arm_seconds(&home, &p.joints);
            // A way around itself is longer than the straight one.
            let detour = if robot.line_is_free(&home, &p.joints) {
                0.0
            } else {
                weights.second
            };
            p.price + way + detour
        };
        let best = robot
            .posture_candidates(view, &home, &weights)
            .into_iter()
            .map(|p| (price(&p), p))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, best)) = best {
            *posture = best;
        }
    }
    Ok(postures)
}

impl<'a> Search<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        settings: &'a Settings,
        recorder: &'a mut dyn Recorder,
    ) -> Result<Self, HeatsError> {
        let planner = |e: &dyn std::fmt::Display| HeatsError::Planner(e.to_string());
        let mut robot = MobileManipulator::default();
        let l = &scene.limits;
        let (linear, angular, joint) = settings.motion.acceleration;
        robot.limits.speed = l.v_max;
        robot.limits.turn_speed = l.w_max;
        robot.limits.joint_speed = [l.joint_v_max; 6];
        robot.limits.acceleration = linear;
        robot.limits.turn_acceleration = angular;
        robot.limits.joint_acceleration = [joint; 6];
        let limits = MotionLimits {
            a: linear,
            alpha: angular,
            joint_a: [joint; 6],
            ..MotionLimits::for_scene(l)
        };
        let mapper = Mapper::new(scene, settings)?;
        let world = World::new(scene);
        let truth = GroundTruth::new(scene, &world, mapper.map.cell_size())?;
        let v = &settings.views;
        let postures = camera_postures(&robot, &v.attitudes).map_err(|e| planner(&e))?;
        let height = scene.bounds.max[2] - scene.bounds.min[2];
        let share = settings.motion.reference_speed;
        let base = Limits {
            v: share * limits.v,
            w: (share * limits.w).min(settings.motion.turn_speed),
            a: settings.motion.reference_acceleration * limits.a,
            alpha: settings.motion.reference_acceleration * limits.alpha,
        };
        let pace = Pace {
            v: base.v,
            w: base.w,
            a: base.a,
            alpha: base.alpha,
            joint: share * l.joint_v_max,
        };
        let targets = Targets::new(
            settings,
            &robot,
            &pace,
            &postures,
            mapper.map.cell_size(),
            mapper.inspect_range,
            height,
        )
        .map_err(|e| planner(&e))?;
        let base_planner = Planner::new(hybrid_astar::Params {
            limits: base,
            margin: settings.motion.base_clearance,
            start_tolerance: 0.15,
            goal_tolerance: 0.0,
            max_expansions: 20_000,
            reverse_factor: settings.motion.reverse.0,
            reverse_reach: settings.motion.reverse.1,
            ..hybrid_astar::Params::default()
        })
        .map_err(|e| planner(&e))?;
        let motion_params = MotionParams {
            base,
            joint_speed: share * l.joint_v_max,
            joint_range: limits.joint_range,
            arm_iterations: settings.motion.arm_iterations,
        };
        let controller = Controller::new(&settings.motion, &limits).map_err(|e| planner(&e))?;
        let noise = |stream: u64| Noise {
            sigma: settings.map.range_noise,
            dropout: settings.map.dropout,
            outliers: settings.fault.outliers,
            seed: settings.seed.wrapping_mul(2).wrapping_add(stream),
        };
        let lidar = Lidar::new(
            LidarModel {
                offset: robot.base.lidar,
                ..LidarModel::default()
            },
            noise(0),
        );
        let depth = DepthCamera::new(DepthModel::default(), noise(1));
        let tag_camera = settings.map.tag_camera(mapper.inspect_range);
        let rgb = tag_camera.tangents();
        let seen = SurfaceSeen::new(&truth, &tag_camera);
        let detector = TagDetector::new(tag_camera, &scene.tags);
        let start = [scene.start.x, scene.start.y, scene.start.yaw];
        let sim = Simulator::new(
            Exact(robot.clone()),
            world,
            limits,
            (lidar, depth, detector),
            start,
            settings.start.joints.unwrap_or(postures[0].joints),
        )?;
        let planning = match settings.planning_time {
            PlanningTime::Counted => Planning::Counted,
            PlanningTime::Measured => Planning::Measured,
        };
        let tap = Tap::new(recorder, scene, settings, &robot, (&mapper, rgb));
        Ok(Self {
            scene,
            settings,
            sim,
            truth,
            seen,
            mapper,
            targets,
            failures: Failures::default(),
            base_planner,
            motion_params,
            controller,
            account: Account::new(planning),
            watch: Stopwatch::default(),
            motion: Motion::Rest,
            pending: None,
            next_decision: 0.0,
            blocked_at: None,
            arrived: None,
            rgb,
            looked_around: false,
            was_steady: false,
            sharp: false,
            last_image: Camera {
                rotation: [[0.0; 3]; 3],
                translation: [0.0; 3],
                tan_half_h: rgb.0,
                tan_half_v: rgb.1,
            },
            postures: postures.iter().map(|p| p.joints).collect(),
            activity: "looking around",
            trace: Trace::default(),
            progress: Vec::new(),
            decisions: 0,
            views_reached: 0,
            // 50 degrees down: the image reaches from the robot's feet to beyond where the LiDAR first meets the floor.
            camera_down: postures.get(3).map_or(postures[0].joints, |p| p.joints),
            time_limit: settings.time_limit.unwrap_or(l.time_limit),
            tap,
            faults: Faults::new(settings),
            robot,
        })
    }
}
