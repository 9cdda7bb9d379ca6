//! Depth images as FLAP's mapping takes them in: what was touched is occupied, and a fan of rays frees the rest.

use super::set;
use crate::error::Error;
use crate::geometry::{Cell, CellBox, State};
use crate::map::VoxelMap;
use crate::walk::Walk;

/// Rays are followed within so many cells of the map's corner: beyond, cell numbers would overflow.
const FAR: f64 = (1 << 22) as f64;

/// A depth image and the fan of rays that looks through its field of view.
#[derive(Clone, Debug, PartialEq)]
pub struct FanImage<'a> {
    /// Where the camera is, m.
    pub origin: [f64; 3],
    /// Measured points, m; dense, or surfaces keep unknown cells.
    pub points: &'a [[f64; 3]],
    /// Points nearer or farther than this are left out, m.
    pub range: (f64, f64),
    /// Ends of the fan's rays at the range limit, m.
    pub ends: &'a [[f64; 3]],
    /// Let cells that are occupied already stop the rays too. For worlds that are the map itself; elsewhere a cell wrongly
    /// taken for occupied would never be freed again.
    pub stop_at_occupied: bool,
}

impl VoxelMap {
    /// Integrates a depth image in FLAP's order: every point strictly within range touches its cell; then each ray of the
    /// fan frees the cells up to the first touched one, or up to its end, since space without a return is taken as free.
    /// Each cell changes once, with the odds of the sensor model; what lies outside the map is left out, and the map does not
    /// grow. Returns the number of cells updated.
    ///
    /// # Errors
    /// [`Error::Position`] for an origin that is not finite, [`Error::Length`] for a range limit that is not positive and
    /// finite. Points and ends that are not finite are left out.
    pub fn insert_fan(&mut self, image: &FanImage<'_>) -> Result<usize, Error> {
        if !image.origin.iter().all(|v| v.is_finite()) {
            return Err(Error::Position {
                field: "origin",
                value: image.origin,
            });
        }
        let (near, far) = image.range;
        if !(far > 0.0 && far.is_finite() && near < far) {
            return Err(Error::Length {
                field: "range",
                value: far,
            });
        }
        let mut window = std::mem::take(&mut self.scan);
        window.fit(self.free.len());
        let size = self.size;
        let inside = |stored: Cell| (0..3).all(|a| (stored[a] as u32 as usize) < size[a]);
        // Rows count from the map's corner.
        let mut include = |cell: Cell| {
            let rows = &mut window.rows;
            for (a, rows) in rows.iter_mut().enumerate() {
                let at = cell[a + 1] as usize;
                *rows = (rows.0.min(at), rows.1.max(at + 1));
            }
        };
        for point in image.points {
            let range = (0..3)
                .map(|a| (point[a] - image.origin[a]).powi(2))
                .sum::<f64>()
                .sqrt();
            if range > near && range < far {
                let cell = self.stored(self.cell_at(*point));
                if inside(cell) {
                    include(cell);
                    set(&mut window.hit, self.inner(cell));
                }
            }
        }
        let from = self.scaled(image.origin);
        let near_map = |p: [f64; 3]| p.iter().all(|v| v.abs() < FAR);
        for end in image.ends.iter().map(|e| self.scaled(*e)) {
            if !(near_map(from) && near_map(end)) {
                continue;
            }
            let mut walk = Walk::new(from, end);
            loop {
                if inside(walk.cell) {
                    let address = self.inner(walk.cell);
                    let known = image.stop_at_occupied && Self::bit(&self.occupied, address);
                    if known || Self::bit(&window.hit, address) {
                        break;
                    }
                    if set(&mut window.passed, address) {
                        include(walk.cell);
                    }
                }
                if walk.advance().is_none() {
                    break;
                }
            }
        }
        let updated = self.apply(&mut window);
        self.scans += 1;
        self.scan = window;
        Ok(updated)
    }

    /// Forgets the cells of a box, or with `keep_occupied` the free ones alone.
    pub fn reset_cells(&mut self, cells: &CellBox, keep_occupied: bool) {
        let inside = cells.common(&self.bounds());
        for z in inside.low[2]..inside.high[2] {
            for y in inside.low[1]..inside.high[1] {
                for x in inside.low[0]..inside.high[0] {
                    if !(keep_occupied && self.is_occupied([x, y, z])) {
                        self.set_state([x, y, z], State::Unknown);
                    }
                }
            }
        }
    }

    /// Raises a floor plan to walls: the columns over occupied pixels become occupied from the floor (z = 0) up to `height`
    /// (m), and so does the floor's layer of cells over the whole map.
    ///
    /// `occupied[y * width + x]` is the pixel from `origin + (x, y) * pixel` (m) on; a cell is looked up by its centre.
    pub fn extrude(
        &mut self,
        occupied: &[bool],
        width: usize,
        origin: [f64; 2],
        pixel: f64,
        height: f64,
    ) {
        let CellBox {
            low: first,
            high: last,
        } = self.bounds();
        let half = 0.5 * self.cell_size();
        let rows = occupied.len().checked_div(width).unwrap_or(0);
        for y in first[1]..last[1] {
            for x in first[0]..last[0] {
                let c = self.center([x, y, first[2]]);
                let [px, py] = [0, 1].map(|a| ((c[a] - origin[a]) / pixel).floor());
                let inside = px >= 0.0 && py >= 0.0 && px < width as f64 && py < rows as f64;
                let wall = inside && occupied[py as usize * width + px as usize];
                for z in first[2]..last[2] {
                    let low = self.center([x, y, z])[2] - half;
                    let floor = low <= 1e-9 && low + 2.0 * half > 1e-9;
                    if floor || (wall && low > -1e-9 && low < height - 1e-9) {
                        self.set_state([x, y, z], State::Occupied);
                    }
                }
            }
        }
    }
}
