//! Floor plans: the walls that are known before, the map that paths are searched on, and places to start from.

use crate::scene::Scene;
use objsearch::GridPaths;

/// Pixels of 0.05 m, as FLAP's maps have them.
const PIXEL: f64 = 0.05;
/// Solids that reach higher than this are walls, m.
const WALL: f64 = 2.0;
/// Solids below this are in the way of the base, m; higher ones only if they begin below it.
const BODY: f64 = 1.3;
/// The base's radius beyond which furniture is grown, m; FLAP's map of the race scene has about 0.2 m.
const GROWN: f64 = 0.2;

/// What is wrong with a floor plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// Not a binary grey map.
    #[error("not a binary PGM of 8 bits: {0}")]
    Pgm(&'static str),
    /// Not a list of places.
    #[error("start points: {0}")]
    Starts(String),
    /// The path grid was refused.
    #[error(transparent)]
    Paths(#[from] objsearch::Error),
    /// No place to start from.
    #[error("no place of the floor plan is free to start from")]
    NoStart,
}

/// A map of occupied pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Pixels {
    /// Row by row from the lowest y on.
    pub occupied: Vec<bool>,
    /// Pixels along x and y.
    pub size: (usize, usize),
    /// Lower corner of pixel (0, 0), m.
    pub origin: [f64; 2],
}

/// The plans of a scene.
#[derive(Clone, Debug)]
pub struct FloorPlans {
    /// Walls.
    pub walls: Pixels,
    /// Pixels where the base's centre cannot be.
    pub blocked: Pixels,
    /// Camera positions to start from, m.
    pub starts: Vec<[f64; 2]>,
    /// Height of the camera at the start, m.
    pub start_height: f64,
}

/// Edge of a pixel, m.
pub(super) const fn pixel() -> f64 {
    PIXEL
}

#[derive(serde::Deserialize)]
struct Starts {
    camera_height: f64,
    points: Vec<[f64; 2]>,
}

impl FloorPlans {
    /// The plans of a scene: those of the paper's evaluation for the embedded race scene, else drawn from the solids.
    ///
    /// # Errors
    /// [`PlanError`] if no place is free.
    pub fn of(scene: &Scene) -> Result<Self, PlanError> {
        if scene.name == "race" {
            Self::race()
        } else {
            Self::drawn(scene)
        }
    }

    fn race() -> Result<Self, PlanError> {
        let starts: Starts =
            serde_json::from_str(include_str!("../../scenes/race/start_points.json"))
                .map_err(|e| PlanError::Starts(e.to_string()))?;
        Ok(Self {
            walls: pgm(include_bytes!("../../scenes/race/map_sim.pgm"))?,
            blocked: pgm(include_bytes!(
                "../../scenes/race/race_extended_inflated.pgm"
            ))?,
            starts: starts.points,
            start_height: starts.camera_height,
        })
    }

    fn drawn(scene: &Scene) -> Result<Self, PlanError> {
        let origin = [0, 1].map(|a| (scene.bounds.min[a] / PIXEL).floor() * PIXEL);
        let size = [0, 1].map(|a| ((scene.bounds.max[a] - origin[a]) / PIXEL).ceil() as usize);
        let empty = Pixels {
            occupied: vec![false; size[0] * size[1]],
            size: (size[0], size[1]),
            origin,
        };
        let (mut walls, mut blocked) = (empty.clone(), empty);
        for outline in scene.outlines() {
            if outline.band.1 > WALL {
                walls.fill(&outline.corners, 0.0);
            }
            if outline.band.0 < BODY {
                blocked.fill(&outline.corners, GROWN);
            }
        }
        // Outside the bounds is no place to be.
        for y in 0..size[1] {
            for x in 0..size[0] {
                if x == 0 || y == 0 || x + 1 == size[0] || y + 1 == size[1] {
                    blocked.occupied[y * size[0] + x] = true;
                }
            }
        }
        // Every half metre that is free.
        let starts: Vec<[f64; 2]> = (0..size[1])
            .step_by(10)
            .flat_map(|y| (0..size[0]).step_by(10).map(move |x| (x, y)))
            .filter(|&(x, y)| !blocked.occupied[y * size[0] + x])
            .map(|(x, y)| [x, y].map(|v| (v as f64 + 0.5) * PIXEL))
            .map(|p| [origin[0] + p[0], origin[1] + p[1]])
            .collect();
        if starts.is_empty() {
            return Err(PlanError::NoStart);
        }
        Ok(Self {
            walls,
            blocked,
            starts,
            start_height: 1.5,
        })
    }

    /// Path costs of the base: FLAP's inflation of 0.55 m with a decay of 10 /m.
    ///
    /// # Errors
    /// [`PlanError::Paths`] for a plan of the wrong size, which does not happen.
    pub fn paths(&self) -> Result<GridPaths, PlanError> {
        let Pixels {
            occupied,
            size,
            origin,
        } = &self.blocked;
        Ok(GridPaths::inflated(
            occupied, *size, *origin, PIXEL, 0.55, 10.0,
        )?)
    }
}

impl Pixels {
    /// Sets the pixels whose centre is within `by` (m) of a convex outline.
    fn fill(&mut self, corners: &[[f64; 2]], by: f64) {
        let n = corners.len();
        let Some(first) = corners.first() else {
            return;
        };
        let (mut low, mut high) = (*first, *first);
        for c in corners {
            for a in 0..2 {
                low[a] = low[a].min(c[a]);
                high[a] = high[a].max(c[a]);
            }
        }
        // Half a pixel more, so that thin walls are not lost between centres.
        let by = by + 0.5 * PIXEL;
        let index = |v: f64, a: usize| ((v - self.origin[a]) / PIXEL).floor().max(0.0) as usize;
        for y in index(low[1] - by, 1)..(index(high[1] + by, 1) + 1).min(self.size.1) {
            for x in index(low[0] - by, 0)..(index(high[0] + by, 0) + 1).min(self.size.0) {
                let p = [
                    self.origin[0] + (x as f64 + 0.5) * PIXEL,
                    self.origin[1] + (y as f64 + 0.5) * PIXEL,
                ];
                let (mut inside, mut nearest) = (false, f64::INFINITY);
                for i in 0..n {
                    let (a, b) = (corners[i], corners[(i + 1) % n]);
                    if (a[1] > p[1]) != (b[1] > p[1])
                        && p[0] < (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]) + a[0]
                    {
                        inside = !inside;
                    }
                    nearest = nearest.min(to_segment(p, a, b));
                }
                if inside || nearest <= by {
                    self.occupied[y * self.size.0 + x] = true;
                }
            }
        }
    }
}

fn to_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length = dx * dx + dy * dy;
    let t = if length > 0.0 {
        (((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (p[0] - a[0] - t * dx).hypot(p[1] - a[1] - t * dy)
}

/// Reads a binary PGM as a ROS map: dark pixels (occupancy above 65 of 100) are occupied, the file's last row is y = 0.
fn pgm(bytes: &[u8]) -> Result<Pixels, PlanError> {
    let mut rest = bytes;
    let mut word = || -> Result<String, PlanError> {
        loop {
            let start = rest
                .iter()
                .position(|b| !b.is_ascii_whitespace())
                .ok_or(PlanError::Pgm("the header ends early"))?;
            rest = &rest[start..];
            if rest[0] != b'#' {
                break;
            }
            let end = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            rest = &rest[end..];
        }
        let end = rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .ok_or(PlanError::Pgm("the header ends early"))?;
        let text = String::from_utf8_lossy(&rest[..end]).into_owned();
        rest = &rest[end..];
        Ok(text)
    };
    if word()? != "P5" {
        return Err(PlanError::Pgm("it does not begin with P5"));
    }
    let mut number = || -> Result<usize, PlanError> {
        word()?
            .parse()
            .map_err(|_| PlanError::Pgm("a header field is no number"))
    };
    let (width, height, most) = (number()?, number()?, number()?);
    let pixels = rest.get(1..).unwrap_or_default();
    if most != 255 || pixels.len() < width * height {
        return Err(PlanError::Pgm("it is cut off or not of 8 bits"));
    }
    let occupied = (0..height)
        .flat_map(|y| pixels[(height - 1 - y) * width..][..width].iter())
        // Occupancy is (255 - value) / 255.
        .map(|&value| f64::from(255 - value) / 255.0 > 0.65)
        .collect();
    Ok(Pixels {
        occupied,
        size: (width, height),
        origin: [0.0; 2],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_race_plans_are_read() {
        let plans = FloorPlans::of(&Scene::builtin("race").unwrap()).unwrap();
        assert_eq!(plans.walls.size, (289, 342));
        assert_eq!(plans.starts.len(), 191);
        let count = |p: &Pixels| p.occupied.iter().filter(|o| **o).count();
        assert!(count(&plans.walls) > 1000 && count(&plans.blocked) > 2 * count(&plans.walls));
        // Five of the starts are not reachable on the navigation map; a few more stand on a blocked pixel with their base.
        let paths = plans.paths().unwrap();
        let good = plans
            .starts
            .iter()
            .filter(|s| paths.is_passable(**s))
            .count();
        assert!(good >= 180, "{good}");
    }

    #[test]
    fn bad_maps_are_refused() {
        for bytes in [
            &b""[..],
            b"P2 1 1 255 0",
            b"P5 2 2 255 ab",
            b"P5 2 x 255 abcd",
            b"P5 1 1 65535 ab",
        ] {
            assert!(matches!(pgm(bytes), Err(PlanError::Pgm(_))), "{bytes:?}");
        }
        let good = pgm(b"P5 # a comment\n2 1\n255\n\x00\xff").unwrap();
        assert_eq!(good.occupied, [true, false]);
    }

    #[test]
    fn other_scenes_are_drawn_from_their_solids() {
        let plans = FloorPlans::of(&Scene::builtin("office").unwrap()).unwrap();
        let count = |p: &Pixels| p.occupied.iter().filter(|o| **o).count();
        assert!(count(&plans.walls) > 0 && count(&plans.blocked) > count(&plans.walls));
        assert!(!plans.starts.is_empty());
    }
}
