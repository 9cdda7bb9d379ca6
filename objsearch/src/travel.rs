//! How long it takes to go from view to view: path costs, a model that turns them into seconds, and the table of both.

use crate::cluster::{Clusters, cluster};
use crate::{CostModel, Error, Paths};

/// Where the robot is, as far as travel times depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    /// Base position, m.
    pub base: [f64; 2],
    /// Base heading, rad.
    pub yaw: f64,
    /// Camera height, m; lifting the torso changes it one to one.
    pub height: f64,
    /// Pitch of the camera, rad.
    pub pitch: f64,
}

/// Seconds that a robot needs from place to place and for looking there.
pub trait TravelModel {
    /// `path`: cost of the base's path in the units of the [`Paths`] used, finite.
    fn seconds(&self, path: f64, from: &Place, to: &Place) -> f64;
}

impl<M: TravelModel + ?Sized> TravelModel for &M {
    fn seconds(&self, path: f64, from: &Place, to: &Place) -> f64 {
        (**self).seconds(path, from, to)
    }
}

/// FLAP's model: driving by linear regression over path costs, plus lifting, plus looking; the head turns meanwhile.
#[derive(Clone, Debug, PartialEq)]
pub struct Regression {
    /// Seconds of each unit of path cost.
    pub per_cost: f64,
    /// Seconds of each drive, also of one that goes nowhere.
    pub per_drive: f64,
    /// Speed of the torso, m/s.
    pub lift_speed: f64,
    /// Time of looking, s.
    pub sensing: f64,
}

impl Default for Regression {
    /// The PR2 of FLAP's experiments.
    fn default() -> Self {
        Self {
            per_cost: 0.001_543_590_409_49,
            per_drive: 5.940_009_212_33,
            lift_speed: 0.01,
            sensing: 5.0,
        }
    }
}

impl Regression {
    /// The TurtleBot of FLAP's program; its camera has one height.
    pub fn turtlebot() -> Self {
        Self {
            per_cost: 0.000_305_329_882_947,
            per_drive: 2.724_223_359_68,
            ..Self::default()
        }
    }
}

impl TravelModel for Regression {
    fn seconds(&self, path: f64, from: &Place, to: &Place) -> f64 {
        path * self.per_cost
            + self.per_drive
            + (to.height - from.height).abs() / self.lift_speed
            + self.sensing
    }
}

/// A model from speeds: the base turns and drives at constant speed while the head moves, then the torso lifts, then the
/// robot looks. A robot that stays where it is moves its head alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Speeds {
    /// Metres of each unit of path cost: 0.001 for [`GridPaths`](crate::GridPaths) on 0.05 m cells, 1 for lengths.
    pub metres_per_cost: f64,
    /// Speed of the base, m/s.
    pub drive: f64,
    /// Turning speed of the base, rad/s.
    pub turn: f64,
    /// Turning speed of the head, rad/s.
    pub head: f64,
    /// Speed of the torso, m/s.
    pub lift: f64,
    /// Time of looking, s.
    pub sensing: f64,
}

impl Default for Speeds {
    /// A PR2 at the speed of FLAP's regression, 0.65 m/s.
    fn default() -> Self {
        Self {
            metres_per_cost: 0.001,
            drive: 0.65,
            turn: 1.0,
            head: std::f64::consts::PI,
            lift: 0.01,
            sensing: 5.0,
        }
    }
}

impl TravelModel for Speeds {
    fn seconds(&self, path: f64, from: &Place, to: &Place) -> f64 {
        let turn = (to.yaw - from.yaw)
            .sin()
            .atan2((to.yaw - from.yaw).cos())
            .abs();
        let head = (to.pitch - from.pitch).abs() / self.head;
        let drive = if from.base == to.base {
            // The head pans as the base would turn.
            head.max(turn / self.head)
        } else {
            (path * self.metres_per_cost / self.drive + turn / self.turn).max(head)
        };
        drive + (to.height - from.height).abs() / self.lift + self.sensing
    }
}

/// Times between views, from path searches.
#[derive(Clone, Debug, PartialEq)]
pub struct TravelTable {
    places: Vec<Place>,
    /// Group of each view; none where no path begins.
    group: Vec<Option<usize>>,
    groups: usize,
    /// Path costs between the middles of groups.
    costs: Vec<f64>,
}

impl TravelTable {
    /// One path search for each view: exact.
    pub fn exact(places: &[Place], paths: &mut impl Paths) -> Self {
        let middles: Vec<[f64; 2]> = places.iter().map(|p| p.base).collect();
        let group = (0..places.len()).map(Some).collect();
        Self::of(places, group, &middles, paths)
    }

    /// One path search for each of at most `clusters` groups of close-by views; the path between two groups' middles
    /// stands for all paths between them. FLAP: 50.
    ///
    /// Views where no path begins are in no group: as the middle of one they would cut off all of it. Views that can be
    /// stood at but not reached should be left out beforehand for the same reason.
    pub fn clustered(places: &[Place], clusters: usize, paths: &mut impl Paths) -> Self {
        let mut row = Vec::new();
        let mut stands = |at: [f64; 2]| {
            paths.from(at, &[at], &mut row);
            row.first().is_some_and(|cost| cost.is_finite())
        };
        let good: Vec<usize> = (0..places.len())
            .filter(|&v| stands(places[v].base))
            .collect();
        let points: Vec<[f64; 2]> = good.iter().map(|&v| places[v].base).collect();
        let Clusters { medoids, of } = cluster(&points, clusters.max(1));
        let middles: Vec<[f64; 2]> = medoids.iter().map(|&m| points[m]).collect();
        let mut group = vec![None; places.len()];
        for (&v, &of) in good.iter().zip(&of) {
            group[v] = Some(of);
        }
        Self::of(places, group, &middles, paths)
    }

    fn of(
        places: &[Place],
        group: Vec<Option<usize>>,
        middles: &[[f64; 2]],
        paths: &mut impl Paths,
    ) -> Self {
        let mut costs = Vec::with_capacity(middles.len() * middles.len());
        let mut row = Vec::new();
        for &from in middles {
            paths.from(from, middles, &mut row);
            costs.extend_from_slice(&row);
        }
        Self {
            places: places.to_vec(),
            group,
            groups: middles.len(),
            costs,
        }
    }

    /// Number of views.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// True if there is no view.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Cost of the path between two views' groups.
    ///
    /// # Panics
    /// If an index is no view.
    pub fn path_cost(&self, from: usize, to: usize) -> f64 {
        match (self.group[from], self.group[to]) {
            (Some(from), Some(to)) => self.costs[from * self.groups + to],
            _ => f64::INFINITY,
        }
    }

    /// The views' places.
    pub fn places(&self) -> &[Place] {
        &self.places
    }

    /// Seconds from one view to another; infinite where there is no path.
    ///
    /// # Panics
    /// If an index is no view.
    pub fn seconds(&self, model: &impl TravelModel, from: usize, to: usize) -> f64 {
        timed(
            model,
            self.path_cost(from, to),
            &self.places[from],
            &self.places[to],
        )
    }

    /// Costs for the views `chosen` (indices of this table) from a state of the robot, with one more path search.
    ///
    /// # Errors
    /// [`Error::TableSize`] if a chosen index is no view.
    pub fn from_state<M: TravelModel>(
        &self,
        model: M,
        state: &Place,
        chosen: &[usize],
        paths: &mut impl Paths,
    ) -> Result<FromState<'_, M>, Error> {
        if let Some(&wrong) = chosen.iter().find(|&&v| v >= self.len()) {
            return Err(Error::TableSize {
                what: "travel table",
                found: self.len(),
                wanted: wrong + 1,
            });
        }
        let to: Vec<[f64; 2]> = chosen.iter().map(|&v| self.places[v].base).collect();
        let mut costs = Vec::new();
        paths.from(state.base, &to, &mut costs);
        let first = costs
            .iter()
            .zip(chosen)
            .map(|(&cost, &v)| timed(&model, cost, state, &self.places[v]))
            .collect();
        Ok(FromState {
            table: self,
            model,
            chosen: chosen.to_vec(),
            first,
        })
    }
}

fn timed(model: &impl TravelModel, cost: f64, from: &Place, to: &Place) -> f64 {
    if cost.is_finite() {
        model.seconds(cost, from, to)
    } else {
        f64::INFINITY
    }
}

/// A travel table with a state of the robot: the [`CostModel`] of a task.
#[derive(Clone, Debug, PartialEq)]
pub struct FromState<'a, M> {
    table: &'a TravelTable,
    model: M,
    chosen: Vec<usize>,
    first: Vec<f64>,
}

impl<M: TravelModel> CostModel for FromState<'_, M> {
    fn first(&self, view: usize) -> f64 {
        self.first[view]
    }
    fn between(&self, from: usize, to: usize) -> f64 {
        self.table
            .seconds(&self.model, self.chosen[from], self.chosen[to])
    }
}
