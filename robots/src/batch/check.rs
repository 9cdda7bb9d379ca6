//! Whole-body collision checks of sixteen states at once.

use super::dispatch;
use super::field::BatchField;
use super::lanes::{LANES, Lanes, Lanes3};
use super::model::{BatchBody, NO_SPHERES, SphereLanes, StateBlock, to_world, turns};
use crate::manipulator::BodyState;
use crate::view::SELF_MARGIN;

/// Links up to this one cannot reach the base: as in the scalar check.
const FIXED_LINK: u8 = 1;
/// Added to every distance needed, m: more than single precision loses within a hundred metres of the origin.
const ROUNDING: f32 = 1e-5;

impl BatchBody {
    /// Centres of the arm's spheres in the world, of all sixteen states.
    #[must_use]
    pub fn spheres(&self, states: &StateBlock) -> SphereLanes {
        dispatch::spheres(self, states)
    }

    /// Which of the sixteen states are free: the arm's and camera's spheres keep `margin` (m) from the field's
    /// obstacles and [`SELF_MARGIN`] from the robot itself. Joint limits and the base are not
    /// looked at. A state with a number that is not finite, or an angle beyond 100 rad, is not free.
    ///
    /// Never true where the scalar check in double precision has less than the margin.
    #[must_use]
    pub fn free<F: BatchField>(
        &self,
        states: &StateBlock,
        field: &F,
        margin: f64,
    ) -> [bool; LANES] {
        dispatch::free(self, states, field, margin as f32)
    }

    /// True if every state is free; see [`free`](Self::free).
    #[must_use]
    pub fn all_free<F: BatchField>(&self, states: &[BodyState], field: &F, margin: f64) -> bool {
        states
            .chunks(LANES)
            .all(|part| self.free(&StateBlock::new(part), field, margin) == [true; LANES])
    }

    #[inline(always)]
    pub(super) fn spheres_inline<const FMA: bool>(
        &self,
        states: &StateBlock,
        centers: &mut SphereLanes,
    ) {
        self.in_base::<FMA>(&states.joints, centers);
        let turn = turns::<FMA>(&states.base[2]);
        for c in centers {
            *c = to_world::<FMA>(&turn, &states.base, c);
        }
    }

    #[inline(always)]
    pub(super) fn free_inline<F: BatchField, const FMA: bool>(
        &self,
        states: &StateBlock,
        field: &F,
        margin: f32,
    ) -> [bool; LANES] {
        let mut centers = NO_SPHERES;
        self.in_base::<FMA>(&states.joints, &mut centers);
        let mut free = usable(states);
        let turn = turns::<FMA>(&states.base[2]);
        // The camera end hits first: from the tip to the shoulder, with a look at what is left after each few.
        for (k, (c, s)) in centers.iter().zip(&self.spheres).rev().enumerate() {
            let world = to_world::<FMA>(&turn, &states.base, c);
            let d = field.distances(&world[0], &world[1], &world[2]);
            let need = s.1 + margin + ROUNDING;
            for l in 0..LANES {
                free[l] &= d[l] >= need;
            }
            if k % 8 == 7 && free == [false; LANES] {
                return free;
            }
        }
        if free == [false; LANES] {
            return free;
        }
        self.clear_of_base(&centers, &mut free);
        self.clear_of_itself(&centers, &mut free);
        free
    }

    #[inline(always)]
    fn clear_of_base(&self, centers: &SphereLanes, free: &mut [bool; LANES]) {
        let margin = SELF_MARGIN as f32 + ROUNDING;
        let top = self.base.pedestal[3].max(self.base.lidar[2] + self.base.lidar[3]);
        for (c, s) in centers.iter().zip(&self.spheres) {
            if s.2 <= FIXED_LINK {
                continue;
            }
            let need = s.1 + margin;
            let mut low = false;
            for l in 0..LANES {
                low |= c[2][l] - need <= top;
            }
            if low {
                self.above_base(c, need, free);
            }
        }
    }

    /// Distances to the box, the pedestal and the LiDAR, compared with `need`.
    #[inline(always)]
    fn above_base(&self, c: &Lanes3, need: f32, free: &mut [bool; LANES]) {
        let b = &self.base;
        for l in 0..LANES {
            let (x, y, z) = (c[0][l], c[1][l], c[2][l]);
            let (ox, oy, oz) = (
                (x.abs() - b.half[0]).max(0.0),
                (y.abs() - b.half[1]).max(0.0),
                ((z - b.half[2]).abs() - b.half[2]).max(0.0),
            );
            let square = need * need;
            let cuboid = ox * ox + oy * oy + oz * oz >= square;
            let (dx, dy) = (x - b.pedestal[0], y - b.pedestal[1]);
            let around = ((dx * dx + dy * dy).sqrt() - b.pedestal[2]).max(0.0);
            let above = (z - b.pedestal[3]).max(0.0);
            let pedestal = around * around + above * above >= square;
            let (dx, dy, dz) = (x - b.lidar[0], y - b.lidar[1], z - b.lidar[2]);
            let reach = need + b.lidar[3];
            let lidar = dx * dx + dy * dy + dz * dz >= reach * reach;
            free[l] &= cuboid & pedestal & lidar;
        }
    }

    #[inline(always)]
    fn clear_of_itself(&self, centers: &SphereLanes, free: &mut [bool; LANES]) {
        let margin = SELF_MARGIN as f32 + ROUNDING;
        // Least of (squared distance - squared reach): one comparison at the end.
        let mut least: Lanes = [f32::INFINITY; LANES];
        for &(i, j, radii) in &self.pairs {
            let (a, b) = (&centers[usize::from(i)], &centers[usize::from(j)]);
            let reach = (radii + margin) * (radii + margin);
            for l in 0..LANES {
                let (dx, dy, dz) = (a[0][l] - b[0][l], a[1][l] - b[1][l], a[2][l] - b[2][l]);
                let room = dx * dx + dy * dy + dz * dz - reach;
                least[l] = if room < least[l] { room } else { least[l] };
            }
        }
        for l in 0..LANES {
            free[l] &= least[l] >= 0.0;
        }
    }
}

/// Lanes whose numbers single precision and the sine can work with.
#[inline(always)]
fn usable(states: &StateBlock) -> [bool; LANES] {
    let mut out = [true; LANES];
    let angles = states.joints.iter().chain([&states.base[2]]);
    for values in angles {
        for l in 0..LANES {
            out[l] &= values[l].abs() <= 100.0;
        }
    }
    for values in &states.base[..2] {
        for l in 0..LANES {
            out[l] &= values[l].is_finite();
        }
    }
    out
}
