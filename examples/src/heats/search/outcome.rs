//! What a run leaves behind: samples, progress, the map's layer, the result.

use super::*;

impl Search<'_> {
    pub(super) fn sample(&mut self, now: f64) {
        let state = self.sim.state();
        self.tap.pose(now, &self.robot, state, self.sim.camera());
        self.tap.found(now, self.sim.found(), &self.scene.tags);
        self.trace.samples.push(Sample {
            time: now,
            base: state.base,
            camera: self.sim.camera().1,
        });
    }

    pub(super) fn shares(&self) -> (f64, f64) {
        let map = &self.mapper.map;
        (
            self.truth.explored_fraction(|c| map.is_known(c)),
            self.truth.inspected_fraction(|c| map.is_inspected(c)),
        )
    }

    pub(super) fn tell(&mut self, now: f64, progress: &mut dyn FnMut(&Status<'_>)) {
        let (explored, inspected) = self.shares();
        let found = self.sim.found().len();
        self.progress.push(Progress {
            time_s: now,
            explored,
            inspected,
            found,
        });
        self.tap
            .progress(now, (explored, inspected, found), self.activity);
        self.record_state(now);
        progress(&Status {
            time: now,
            found,
            targets: self.scene.tags.len(),
            explored,
            inspected,
            activity: self.activity,
        });
    }

    pub(super) fn finish(mut self, ended: Ended, lap: Lap) -> Run {
        let now = self.sim.time();
        self.sample(now);
        if ended == Ended::Complete {
            for (place, cells) in self.targets.leftovers(&self.whole()) {
                self.failures
                    .give_up(&cells, place, "no free view sees enough of it", now);
            }
        }
        let (explored_fraction, inspected_fraction) = self.shares();
        let tally = *self.sim.tally();
        let found: Vec<TargetFound> = self
            .sim
            .found()
            .iter()
            .map(|d| TargetFound {
                id: d.id,
                time_s: d.time,
            })
            .collect();
        let targets = self.scene.tags.len();
        self.record_state(now);
        self.tap.end(now, ended);
        let total_s = lap.seconds();
        let stages: BTreeMap<String, StageMs> = Stage::ALL
            .iter()
            .map(|&stage| {
                let s = self.watch.summary(stage);
                (
                    stage.name().to_owned(),
                    StageMs {
                        count: s.count,
                        median: s.median,
                        p95: s.p95,
                        max: s.max,
                    },
                )
            })
            .collect();
        let result = RunResult {
            schema: SCHEMA.to_owned(),
            system: "heats".to_owned(),
            planner: self.settings.planner.name().to_owned(),
            sensors: match self.settings.sensors {
                Sensors::Both => "both".to_owned(),
                Sensors::Camera => "camera".to_owned(),
            },
            scene: self.scene.name.clone(),
            seed: self.settings.seed,
            ended,
            targets,
            found: found.len(),
            completeness: if targets == 0 {
                1.0
            } else {
                found.len() as f64 / targets as f64
            },
            last_target_time_s: found.iter().map(|t| t.time_s).fold(0.0, f64::max),
            targets_found: found,
            search_time_s: now,
            base_path_m: tally.base_path,
            joint_rotation_rad: tally.joint_rotation,
            explored_fraction,
            inspected_fraction,
            seen_fraction: self.seen.fraction(),
            given_up: std::mem::take(&mut self.failures.given_up),
            collisions: tally.collisions,
            min_clearance_m: tally.min_clearance,
            limit_violations: tally.limit_violations,
            decisions: self.decisions,
            views_reached: self.views_reached,
            brakes: self.controller.brakes,
            planning_time_s: self.account.charged(),
            faults: std::mem::take(&mut self.faults.notes),
            progress: std::mem::take(&mut self.progress),
            settings: self.settings.to_toml(),
            wall: Wall {
                total_s,
                real_time_factor: now / total_s.max(1e-9),
                stages,
            },
        };
        self.trace.map = Some(map_layer(&self.mapper));
        Run {
            result,
            trace: std::mem::take(&mut self.trace),
        }
    }
}

/// The map seen from above.
pub(crate) fn map_layer(mapper: &Mapper) -> MapLayer {
    let ground = &mapper.ground;
    let map = &mapper.map;
    let [nx, ny] = ground.size();
    let mut coverage = Vec::with_capacity(nx * ny);
    let mut regions = Vec::with_capacity(nx * ny);
    for y in 0..ny as i32 {
        for x in 0..nx as i32 {
            let column = |test: &dyn Fn([i32; 3]) -> bool| {
                (0..map.size()[2] as i32).any(|z| test([x, y, z]))
            };
            coverage.push(if column(&|c| map.is_inspected(c)) {
                Coverage::Inspected
            } else if column(&|c| map.is_occupied(c)) {
                Coverage::Occupied
            } else if ground.ground([x, y]) == Ground::Free {
                Coverage::Free
            } else {
                Coverage::Unknown
            });
            regions.push(mapper.regions.as_ref().and_then(|r| r.label([x, y])));
        }
    }
    MapLayer {
        cell_size: ground.cell_size(),
        low: ground.low(),
        size: [nx, ny],
        coverage,
        regions,
    }
}
