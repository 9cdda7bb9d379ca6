//! The map manager: fuses scans and images, and keeps every layer that planning reads up to date.

use super::returns::Returns;
use super::settings::Settings;
use crate::scene::Scene;
use voxmap::{
    Ball, Camera, CellBox, Config, CostMap, CostMapParams, Esdf, EsdfParams, GrazingGuard,
    RegionParams, Regions, Scan, SensorModel, VoxelMap,
};

/// Free area that must have changed before regions are segmented again, m2.
const REGION_AREA: f64 = 1.0;
/// Largest probability of a miss with noisy sensors (OctoMap's): what a stray return filled is free again after nine looks, not 70.
const NOISY_MISS: f64 = 0.4;
/// Shortest time between two segmentations, s.
const REGION_PERIOD: f64 = 2.0;

/// All layers of the map.
pub struct Mapper {
    /// Occupancy and inspection.
    pub map: VoxelMap,
    /// Distance to the nearest surface; unknown counts as occupied.
    pub distance: Esdf,
    /// 2-D cost map for the base.
    pub ground: CostMap,
    /// Regions of the cost map; absent until the first segmentation.
    pub regions: Option<Regions>,
    /// Largest distance at which a voxel counts as inspected, m.
    pub inspect_range: f64,
    /// Largest incidence at which a face counts as inspected, rad; none for the published rule.
    pub inspect_incidence: Option<f64>,
    /// Half the side of a target that an image must show whole, m.
    target: f64,
    grazing_guard: Option<GrazingGuard>,
    hit_depth: f64,
    /// For noisy sensors alone.
    returns: Option<Returns>,
    region_params: RegionParams,
    segmented_at: f64,
    free_cells: usize,
}

impl Mapper {
    /// An unknown map of the scene's task volume.
    ///
    /// # Errors
    /// The map's own message for sizes it cannot hold.
    pub fn new(scene: &Scene, settings: &Settings) -> Result<Self, voxmap::Error> {
        let m = &settings.map;
        let mut map = VoxelMap::new(&Config {
            cell_size: m.cell_size.unwrap_or(scene.limits.voxel),
            low: scene.bounds.min,
            high: scene.bounds.max,
            sensor: SensorModel {
                hit: m.hit,
                miss: if m.range_noise > 0.0 {
                    m.miss.min(NOISY_MISS)
                } else {
                    m.miss
                },
                min: m.clamp.0,
                max: m.clamp.1,
                ..SensorModel::default()
            },
        })?;
        map.skip_narrow_faces(m.skip_narrow);
        map.skip_inspected_strips(m.skip_strips);
        let distance = Esdf::new(
            &map,
            EsdfParams {
                truncation: m.truncation,
                unknown_is_occupied: true,
            },
        )?;
        let ground = CostMap::project(&map, &CostMapParams::default())?;
        Ok(Self {
            distance,
            ground,
            regions: None,
            inspect_range: m.inspect_range.unwrap_or(scene.limits.d_ins),
            inspect_incidence: (m.inspect_incidence < 90.0)
                .then(|| m.inspect_incidence.to_radians()),
            target: m.target,
            grazing_guard: m.grazing_guard.then(GrazingGuard::default),
            hit_depth: m.hit_depth,
            returns: (m.range_noise > 0.0)
                .then(|| Returns::new(m.range_noise, map.cell_size(), scene.floor_z)),
            region_params: RegionParams {
                tau: settings.decision.tau,
                ..RegionParams::default()
            },
            segmented_at: f64::NEG_INFINITY,
            free_cells: 0,
            map,
        })
    }

    /// Marks the space around the robot free: it stands there (G item 9).
    pub fn clear_start(&mut self, body: &[Ball], margin: f64) {
        for ball in body {
            self.map.set_free_sphere(ball.center, ball.radius + margin);
        }
    }

    /// Integrates the points of one scan or depth image.
    ///
    /// # Errors
    /// The map's own message, e.g. for an origin that is not finite.
    pub fn integrate(
        &mut self,
        origin: [f64; 3],
        hits: &[[f32; 3]],
        misses: &[[f32; 3]],
        max_range: f64,
        body: &[Ball],
    ) -> Result<(), voxmap::Error> {
        let (hits, misses) = match &mut self.returns {
            None => (hits, misses),
            Some(returns) => returns.sort(origin, hits, misses),
        };
        self.map.insert(&Scan {
            origin,
            hits,
            misses,
            max_range,
            skip: body,
            grazing_guard: self.grazing_guard,
            hit_depth: self.hit_depth,
            ..Scan::default()
        })?;
        Ok(())
    }

    /// Marks what the camera inspects from where it is now; `before` is the image taken before. Returns how many voxels gained a face.
    pub fn inspect(&mut self, before: &Camera, camera: &Camera) -> usize {
        match self.inspect_incidence {
            Some(limit) => self.map.mark_inspected_twice(
                before,
                camera,
                self.inspect_range,
                limit,
                self.target,
            ),
            None => self.map.mark_inspected(camera, self.inspect_range),
        }
    }

    /// Brings distance field and cost map up to date; returns boxes around what changed since the last call.
    pub fn refresh(&mut self) -> Vec<CellBox> {
        let changes = self.map.take_changes();
        if changes.is_empty() {
            return Vec::new();
        }
        self.distance.update(&self.map, &changes);
        self.ground.update(&self.map, &changes.state_boxes);
        // A change makes faces one cell further narrow or wide.
        let bounds = self.map.bounds();
        let grown = |b: &CellBox| CellBox {
            low: [0, 1, 2].map(|a| (b.low[a] - 1).max(bounds.low[a])),
            high: [0, 1, 2].map(|a| (b.high[a] + 1).min(bounds.high[a])),
        };
        changes.boxes.iter().map(grown).collect()
    }

    /// Segments the regions anew when enough has changed; labels carry over by overlap.
    ///
    /// # Errors
    /// The segmentation's own message.
    pub fn segment(&mut self, now: f64) -> Result<(), voxmap::Error> {
        let free = self.ground.free_count();
        let changed = free.abs_diff(self.free_cells) as f64 * self.map.cell_size().powi(2);
        let due = self.regions.is_none()
            || (now - self.segmented_at >= REGION_PERIOD && changed >= REGION_AREA);
        if due {
            let mut regions = Regions::segment(&self.ground, &self.region_params)?;
            if let Some(previous) = &self.regions {
                regions.carry_labels(previous);
            }
            self.regions = Some(regions);
            self.segmented_at = now;
            self.free_cells = free;
        }
        Ok(())
    }
}
