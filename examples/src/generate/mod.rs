//! Scenes made to order: floor plans of any size, furnished, with targets, by a seed.
//!
//! Walls are 0.15 m thick. Furniture stands against walls, or 0.9 m and more away from everything, so that a base of 0.7 m gets
//! everywhere; each target is kept only if some collision-free pose of the whole robot, on ground it can reach, shows it to the
//! camera as the simulator's detector wants it.
//!
//! ```
//! use seekplan::generate::{Blueprint, Layout};
//!
//! let blueprint = Blueprint { layout: Layout::Rooms, size: [12.0, 9.0], tags: 3, ..Blueprint::default() };
//! let scene = blueprint.build().expect("large enough");
//! assert_eq!(scene.tags.len(), 3);
//! assert_eq!(blueprint.build().expect("as before"), scene);
//! ```

mod furniture;
mod ground;
mod layout;
mod tags;

use crate::scene::{Bounds, BoxShape, Footprint, Limits, Room, Scene, Shape, Start, Units};
use layout::Plan;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Thickness of walls, m.
const WALL: f64 = 0.15;
/// Height of rooms, m.
const HEIGHT: f64 = 3.0;
/// Ground for which the protocol's 900 s are meant, m2.
const USUAL_AREA: f64 = 600.0;
/// Shortest and longest side of a building, m.
const SIDES: (f64, f64) = (6.0, 300.0);
/// Narrowest and widest door, m.
const DOORS: (f64, f64) = (0.8, 2.0);

/// Which kind of building.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layout {
    /// Rooms cut from the rectangle by walls with one door each.
    #[default]
    Rooms,
    /// A grid maze, with 12 % of the walls that closed it taken out.
    Maze,
    /// Rows of shelves in a hall.
    Aisles,
}

impl Layout {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Rooms, Self::Maze, Self::Aisles];

    /// Its name on the command line and in scenes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rooms => "rooms",
            Self::Maze => "maze",
            Self::Aisles => "aisles",
        }
    }
}

/// What to build.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blueprint {
    /// Kind of building.
    pub layout: Layout,
    /// Length and width inside the bounds, m.
    pub size: [f64; 2],
    /// Width of doors, m.
    pub door: f64,
    /// Number of targets.
    pub tags: usize,
    /// Whether one room is walled up, so that nothing can enter or see it.
    pub closed_room: bool,
    /// Seed of everything drawn.
    pub seed: u64,
}

impl Default for Blueprint {
    fn default() -> Self {
        Self {
            layout: Layout::Rooms,
            size: [24.0, 16.0],
            door: 0.9,
            tags: 8,
            closed_room: false,
            seed: 1,
        }
    }
}

/// What cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BlueprintError {
    /// A number outside its range.
    #[error("{field} = {value} must be between {} and {} m", range.0, range.1)]
    Range {
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
        /// What would be right.
        range: (f64, f64),
    },
    /// No room could be walled up: there is one alone, or each is the way to another.
    #[error("no room can be closed: the building is too small for a second one")]
    NoRoomToClose,
    /// Too few places for targets that the robot can see.
    #[error(
        "only {found} of {wanted} targets found a place where the robot can see them; take a larger building or fewer"
    )]
    TooFewPlaces {
        /// Targets placed.
        found: usize,
        /// Targets asked for.
        wanted: usize,
    },
}

/// A rectangle on the ground, m.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rect {
    min: [f64; 2],
    max: [f64; 2],
}

impl Rect {
    fn new(min: [f64; 2], max: [f64; 2]) -> Self {
        Self { min, max }
    }

    /// A rectangle about a point.
    fn about(center: [f64; 2], half: [f64; 2]) -> Self {
        Self {
            min: [center[0] - half[0], center[1] - half[1]],
            max: [center[0] + half[0], center[1] + half[1]],
        }
    }

    fn side(&self, axis: usize) -> f64 {
        self.max[axis] - self.min[axis]
    }

    fn area(&self) -> f64 {
        self.side(0) * self.side(1)
    }

    fn center(&self) -> [f64; 2] {
        [0, 1].map(|k| 0.5 * (self.min[k] + self.max[k]))
    }

    /// Larger by a margin on every side.
    fn grown(&self, by: f64) -> Self {
        Self {
            min: self.min.map(|v| v - by),
            max: self.max.map(|v| v + by),
        }
    }

    fn meets(&self, other: &Self) -> bool {
        (0..2).all(|k| self.min[k] < other.max[k] && other.min[k] < self.max[k])
    }

    fn contains(&self, other: &Self) -> bool {
        (0..2).all(|k| self.min[k] <= other.min[k] && other.max[k] <= self.max[k])
    }
}

/// What is drawn, each from its own stream.
struct Dice(ChaCha8Rng);

impl Dice {
    fn new(seed: u64, stream: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        Self(random)
    }

    /// Evenly in 0..1.
    fn share(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Evenly between two numbers, in whole millimetres.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        ((low + self.share() * (high - low).max(0.0)) * 1000.0).round() / 1000.0
    }

    /// One of so many; 0 for none.
    fn pick(&mut self, count: usize) -> usize {
        ((self.share() * count as f64) as usize).min(count.saturating_sub(1))
    }

    fn shuffle<T>(&mut self, list: &mut [T]) {
        for i in (1..list.len()).rev() {
            list.swap(i, self.pick(i + 1));
        }
    }
}

/// An upright box between two heights.
fn upright(name: String, ground: &Rect, (low, high): (f64, f64)) -> Shape {
    let round = |v: f64| (v * 1e4).round() / 1e4;
    let c = ground.center();
    Shape::Box(BoxShape {
        name,
        center: [round(c[0]), round(c[1]), round(0.5 * (low + high))],
        half_extents: [
            round(0.5 * ground.side(0)),
            round(0.5 * ground.side(1)),
            round(0.5 * (high - low)),
        ],
        yaw: None,
        quat: None,
    })
}

impl Blueprint {
    fn validate(&self) -> Result<(), BlueprintError> {
        let checks = [
            ("size[0]", self.size[0], SIDES),
            ("size[1]", self.size[1], SIDES),
            ("door", self.door, DOORS),
        ];
        for (field, value, range) in checks {
            if !(range.0..=range.1).contains(&value) {
                return Err(BlueprintError::Range {
                    field,
                    value,
                    range,
                });
            }
        }
        Ok(())
    }

    /// Builds the scene; the same blueprint gives the same one.
    ///
    /// # Errors
    /// [`BlueprintError`] for sizes out of range, and where what is asked for finds no place.
    pub fn build(&self) -> Result<Scene, BlueprintError> {
        self.validate()?;
        let mut plan = Plan::draw(self, &mut Dice::new(self.seed, 0));
        if self.closed_room && !plan.close_one(&mut Dice::new(self.seed, 1)) {
            return Err(BlueprintError::NoRoomToClose);
        }
        let start = plan.start();
        let pieces = furniture::furnish(&plan, start, &mut Dice::new(self.seed, 2));
        let mut shapes: Vec<Shape> = plan
            .walls
            .iter()
            .enumerate()
            .map(|(i, wall)| upright(format!("wall_{i:03}.w"), wall, (0.0, HEIGHT)))
            .collect();
        shapes.extend(pieces.iter().flat_map(|p| p.shapes.iter().cloned()));
        let [length, width] = self.size;
        let name = format!(
            "{}_{length}x{width}_{}{}",
            self.layout.name(),
            self.seed,
            if self.closed_room { "_closed" } else { "" }
        );
        let closed = plan.closed.map(|i| format!("room_{i:03}"));
        let mut scene = Scene {
            schema: "search-scene/1".into(),
            name,
            description: format!(
                "Generated: {} of {length} m by {width} m, doors of {} m.",
                self.layout.name(),
                self.door
            ),
            license: "CC0-1.0".into(),
            origin: serde_json::json!({
                "generator": concat!("seekplan ", env!("CARGO_PKG_VERSION")),
                "layout": self.layout.name(),
                "size": self.size,
                "door": self.door,
                "seed": self.seed,
            }),
            units: Units {
                length: "m".into(),
                angle: "rad".into(),
            },
            frame: "x east, y north, z up; right-handed".into(),
            bounds: Bounds {
                min: [0.0; 3],
                max: [length, width, HEIGHT],
            },
            floor_z: 0.0,
            ceiling_z: Some(HEIGHT),
            start: Start {
                x: start[0],
                y: start[1],
                yaw: 0.0,
            },
            limits: Limits {
                time_limit: (900.0 * (length * width / USUAL_AREA).max(1.0)).round(),
                ..Limits::default()
            },
            tags: Vec::new(),
            rooms: plan
                .rooms
                .iter()
                .enumerate()
                .map(|(i, room)| Room {
                    name: format!("room_{i:03}"),
                    min: room.min,
                    max: room.max,
                })
                .collect(),
            closed_areas: closed.into_iter().collect(),
            target_volumes: Vec::new(),
            shapes,
        };
        let tags = tags::place(&scene, &plan, &pieces, self, &mut Dice::new(self.seed, 3));
        if tags.len() < self.tags {
            return Err(BlueprintError::TooFewPlaces {
                found: tags.len(),
                wanted: self.tags,
            });
        }
        scene.tags = tags;
        debug_assert!(scene.check(&Footprint::default()).is_ok());
        Ok(scene)
    }
}
