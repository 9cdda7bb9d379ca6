//! Which viewpoint next: the dual-stage decision with costs measured along the cost map.

use super::body::Joints;
use super::mapping::Mapper;
use super::pace::Pace;
use atsp::{Choice, Decision, Params, Place, two_level};
use hybrid_astar::{Field, GridParams, Space};
use std::cell::RefCell;
use std::collections::BTreeMap;
use viewsample::Viewpoint;

/// Cost of a way between regions that no known path connects: this and the straight line (G item 36), m.
const UNREACHABLE: f64 = 1000.0;

/// A candidate viewpoint as the decision sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stand {
    /// Base pose, m and rad.
    pub base: [f64; 3],
    /// Arm posture, rad.
    pub joints: Joints,
}

/// What the last decision chose among.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Considered {
    /// The candidates.
    pub views: Vec<Viewpoint<Joints>>,
    /// Index of the chosen one.
    pub chosen: Option<usize>,
    /// Regions in the order in which they are to be visited, as positions in the map's list of regions.
    pub regions: Vec<usize>,
}

/// One-to-all distances over the ground as it is now, made when asked for.
pub struct Ways {
    space: Space,
    fields: RefCell<BTreeMap<[i32; 2], Option<Field>>>,
    cell_size: f64,
}

impl Ways {
    /// Ways of a disc of `radius` m.
    ///
    /// # Errors
    /// The grid's own message.
    pub fn new(mapper: &Mapper, radius: f64) -> Result<Self, hybrid_astar::Error> {
        let cell_size = mapper.map.cell_size();
        let params = GridParams {
            cell_size,
            ..GridParams::default()
        };
        Ok(Self {
            space: Space::new(&mapper.ground, radius, &params)?,
            fields: RefCell::default(),
            cell_size,
        })
    }

    /// Metres from one place to another; infinite if no known way leads there.
    pub fn meters(&self, from: [f64; 2], to: [f64; 2]) -> f64 {
        let key = from.map(|v| (v / self.cell_size).floor() as i32);
        let mut fields = self.fields.borrow_mut();
        let field = fields
            .entry(key)
            .or_insert_with(|| self.space.field(from).ok());
        field
            .as_ref()
            .map_or(f64::INFINITY, |f| f.distance_near(to, 0.3))
    }

    /// Fields made so far.
    pub fn count(&self) -> usize {
        self.fields.borrow().len()
    }
}

/// Chooses among candidates (HEATS, Algorithm 1). `None` if none can be reached.
///
/// # Errors
/// The solver's own message.
pub fn decide(
    mapper: &Mapper,
    ways: &Ways,
    pace: &Pace,
    robot: ([f64; 3], Joints),
    stands: &[Stand],
    params: &Params,
) -> Result<Option<Choice>, atsp::Error> {
    let Some(regions) = &mapper.regions else {
        return Ok(None);
    };
    let ids = regions.ids();
    let index = |p: [f64; 2]| {
        let id = regions.nearest_label(p);
        ids.iter().position(|&i| Some(i) == id).unwrap_or(0)
    };
    if ids.is_empty() {
        return Ok(None);
    }
    let place = |base: &[f64; 3]| [base[0], base[1]];
    let here = place(&robot.0);
    let region_of: Vec<usize> = stands.iter().map(|s| index(place(&s.base))).collect();
    let center = |r: usize| regions.center(ids[r]).unwrap_or(here);
    let seconds = |from: Place, to: Place| match (from, to) {
        (Place::Robot, Place::Candidate(c)) => {
            let stand = &stands[c];
            let way = ways.meters(here, place(&stand.base));
            pace.seconds(way, (&robot.0, &robot.1), (&stand.base, &stand.joints))
        }
        (Place::Candidate(a), Place::Candidate(b)) => {
            // From the later one, so that each pair asks for one field.
            let (low, high) = (a.min(b), a.max(b));
            let way = ways.meters(place(&stands[low].base), place(&stands[high].base));
            let (a, b) = (&stands[a], &stands[b]);
            pace.seconds(way, (&a.base, &a.joints), (&b.base, &b.joints))
        }
        (Place::Candidate(c), Place::Region(r)) => {
            let (from, to) = (place(&stands[c].base), center(r));
            let way = ways.meters(to, from);
            let way = if way.is_finite() {
                way
            } else {
                UNREACHABLE + straight(from, to)
            };
            way / pace.v
        }
        (Place::Region(a), Place::Region(b)) => {
            let (from, to) = (center(a), center(b));
            let way = ways.meters(from, to);
            let way = if way.is_finite() {
                way
            } else {
                UNREACHABLE + straight(from, to)
            };
            way / pace.v
        }
        _ => f64::INFINITY,
    };
    let decision = Decision {
        current: index(here),
        regions: ids.len(),
        region_of: &region_of,
    };
    two_level(&decision, seconds, params)
}

fn straight(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
