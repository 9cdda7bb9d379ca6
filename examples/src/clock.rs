//! Time: what planning costs on the simulated clock, and the only place that reads the wall clock.

use std::time::Duration;

/// How planning is charged to the simulated clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Planning {
    /// Operations times constants: the same on every machine.
    #[default]
    Counted,
    /// Wall time of this machine.
    Measured,
}

/// The stages whose time is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Scan and image integration, distance field, cost map.
    MapUpdate,
    /// Frontier update.
    Frontier,
    /// Viewpoint sampling and scoring.
    Viewpoints,
    /// Dual-stage decision.
    Decision,
    /// Base path.
    BasePath,
    /// Arm path.
    ArmPath,
    /// Receding-horizon control.
    Mpc,
    /// The simulator itself: never charged.
    Simulator,
}

impl Stage {
    /// All stages in the order of a report.
    pub const ALL: [Self; 8] = [
        Self::MapUpdate,
        Self::Frontier,
        Self::Viewpoints,
        Self::Decision,
        Self::BasePath,
        Self::ArmPath,
        Self::Mpc,
        Self::Simulator,
    ];

    /// Name in `result.json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::MapUpdate => "map_update_ms",
            Self::Frontier => "frontier_ms",
            Self::Viewpoints => "viewpoints_ms",
            Self::Decision => "decision_ms",
            Self::BasePath => "base_path_ms",
            Self::ArmPath => "arm_path_ms",
            Self::Mpc => "mpc_ms",
            Self::Simulator => "simulator_ms",
        }
    }
}

/// A calibrated model of what a stage costs: a fixed part and a part for each operation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Each call, s.
    pub call: f64,
    /// Each operation, s.
    pub operation: f64,
}

impl Cost {
    /// Time of a call with so many operations, s.
    pub fn seconds(&self, operations: usize) -> f64 {
        self.call + self.operation * operations as f64
    }
}

/// The planner's account on the simulated clock: work that was begun is finished later.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Account {
    planning: Planning,
    busy_until: f64,
    charged: f64,
}

impl Account {
    /// An account with nothing on it.
    pub fn new(planning: Planning) -> Self {
        Self {
            planning,
            ..Self::default()
        }
    }

    /// Charges work begun at `now`: `counted` or `measured` seconds as the mode says, after any work still under
    /// way. Returns the simulated time at which its result is there.
    pub fn charge(&mut self, now: f64, counted: f64, measured: f64) -> f64 {
        let seconds = match self.planning {
            Planning::Counted => counted,
            Planning::Measured => measured,
        };
        let seconds = if seconds.is_finite() {
            seconds.max(0.0)
        } else {
            0.0
        };
        self.charged += seconds;
        self.busy_until = self.busy_until.max(now) + seconds;
        self.busy_until
    }

    /// Whether work is under way.
    pub fn is_busy(&self, now: f64) -> bool {
        now < self.busy_until
    }

    /// Sum of all charges, s.
    pub fn charged(&self) -> f64 {
        self.charged
    }
}

/// A running wall-clock measurement.
#[derive(Clone, Copy, Debug)]
pub struct Lap(std::time::Instant);

impl Lap {
    /// Starts to measure.
    #[allow(clippy::disallowed_methods)] // the one place of the workspace that may read the wall clock
    pub fn start() -> Self {
        Self(std::time::Instant::now())
    }

    /// Wall time since the start.
    pub fn elapsed(&self) -> Duration {
        self.0.elapsed()
    }

    /// Wall time since the start, s.
    pub fn seconds(&self) -> f64 {
        self.elapsed().as_secs_f64()
    }
}

/// Wall-clock statistics of a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Number of samples.
    pub count: usize,
    /// Median, ms.
    pub median: f64,
    /// 95th percentile, ms.
    pub p95: f64,
    /// Maximum, ms.
    pub max: f64,
    /// Sum, s.
    pub total_s: f64,
}

/// Collects wall-clock samples per stage.
#[derive(Clone, Debug, Default)]
pub struct Stopwatch {
    samples: [Vec<f64>; Stage::ALL.len()],
}

impl Stopwatch {
    /// Runs `work` and records its wall time; returns its result and the time, s.
    pub fn time<T>(&mut self, stage: Stage, work: impl FnOnce() -> T) -> (T, f64) {
        let lap = Lap::start();
        let result = work();
        (result, self.stop(stage, lap))
    }

    /// Records a measurement that was begun with [`Lap::start`]; returns its length, s.
    pub fn stop(&mut self, stage: Stage, lap: Lap) -> f64 {
        let seconds = lap.seconds();
        self.record(stage, seconds);
        seconds
    }

    /// Records a sample, s.
    pub fn record(&mut self, stage: Stage, seconds: f64) {
        self.samples[stage as usize].push(seconds);
    }

    /// The samples of a stage from the `first` on, s.
    pub fn since(&self, stage: Stage, first: usize) -> &[f64] {
        self.samples[stage as usize].get(first..).unwrap_or(&[])
    }

    /// Statistics of a stage; all zero when it never ran. Percentiles are of nearest rank.
    pub fn summary(&self, stage: Stage) -> Summary {
        let mut sorted = self.samples[stage as usize].clone();
        sorted.sort_by(f64::total_cmp);
        let rank = |share: f64| {
            let i = (share * sorted.len() as f64).ceil() as usize;
            sorted.get(i.saturating_sub(1)).map_or(0.0, |s| 1e3 * s)
        };
        Summary {
            count: sorted.len(),
            median: rank(0.5),
            p95: rank(0.95),
            max: rank(1.0),
            total_s: sorted.iter().sum(),
        }
    }
}
