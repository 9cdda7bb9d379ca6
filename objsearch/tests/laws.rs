//! Laws of belief, objective, planners, travel table and loop.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::{plane_tasks, tasks, unreliable_tasks};
use objsearch::{
    Belief, BranchParams, Budget, Dominance, Ended, Goal, GridPaths, LocalParams, Look, Mode,
    Place, Regression, Survey, Task, Times, TravelTable, View, Volume, World, branch_and_bound,
    cell_probability, cell_weight, cluster, greedy, local, probability_of, search,
};
use proptest::prelude::*;

proptest! {
    /// Seeing every cell of a volume finds the target with the volume's probability.
    #[test]
    fn cells_conserve_the_volume_probability(volume in 0.001..0.999f64, cells in 1..100_000usize) {
        let all = cells as f64 * cell_weight(volume, cells).unwrap();
        prop_assert!((probability_of(all) - volume).abs() < 1e-12);
    }

    /// Eq. 1 as printed.
    #[test]
    fn cells_follow_equation_1(volume in 0.001..0.99f64, cells in 1..10_000usize) {
        let printed = 1.0 - (1.0 - volume).powf(1.0 / cells as f64);
        prop_assert!((cell_probability(volume, cells).unwrap() - printed).abs() < 1e-12);
    }

    /// All cells of two volumes, overlapping or not, hold the target with the chance that either holds it.
    #[test]
    fn overlapping_volumes_combine(
        p in 0.01..0.9f64, q in 0.01..0.9f64,
        low in prop::array::uniform3(0..4i32), size in prop::array::uniform3(1..4i32),
    ) {
        let high = [0, 1, 2].map(|a| low[a] + size[a]);
        let volumes = [
            Volume { low: [0; 3], high: [4, 4, 4], probability: p },
            Volume { low, high, probability: q },
        ];
        let belief = Belief::new(&volumes, ([0; 3], [8; 3])).unwrap();
        let all: f64 = belief.cells().map(|(_, weight)| weight).sum();
        prop_assert!((probability_of(all) - (1.0 - (1.0 - p) * (1.0 - q))).abs() < 1e-12);
        let mut cells: Vec<_> = belief.cells().map(|(cell, _)| cell).collect();
        let count = cells.len();
        cells.sort_unstable();
        cells.dedup();
        prop_assert_eq!(cells.len(), count);
    }

    /// Splitting a cell among copies that the same views show changes nothing but the number of cells.
    #[test]
    fn merging_cells_conserves_probability(
        weights in prop::collection::vec(0.01..0.5f64, 6),
        shown in prop::collection::vec(prop::collection::vec(0..6usize, 1..4), 2..6),
        parts in 2..5usize,
    ) {
        let times = |n: usize| Times::new(vec![3.0; n], vec![4.0; n * n]).unwrap();
        let views: Vec<View> = shown.iter().cloned().map(View::new).collect();
        let whole = Task::new(&weights, &views, &times(views.len()), &Goal::default()).unwrap();
        let split: Vec<f64> = weights.iter().flat_map(|w| vec![w / parts as f64; parts]).collect();
        let fine: Vec<View> = shown
            .iter()
            .map(|v| View::new(v.iter().flat_map(|c| (0..parts).map(move |k| c * parts + k))))
            .collect();
        let task = Task::new(&split, &fine, &times(fine.len()), &Goal::default()).unwrap();
        prop_assert_eq!(task.class_count(), whole.class_count());
        prop_assert!((task.total_weight() - whole.total_weight()).abs() < 1e-12);
        let order: Vec<usize> = (0..views.len()).collect();
        let (a, b) = (whole.evaluate(&order), task.evaluate(&order));
        prop_assert!((a.expected_time - b.expected_time).abs() < 1e-9);
        prop_assert!((a.probability - b.probability).abs() < 1e-12);
    }

    /// A longer prefix of a sequence never has a smaller expected time nor a smaller probability.
    #[test]
    fn expected_time_grows_with_the_prefix(task in unreliable_tasks()) {
        let order: Vec<usize> = (0..task.len()).collect();
        let mut before = task.evaluate(&[]);
        for end in 1..=order.len() {
            let value = task.evaluate(&order[..end]);
            prop_assert!(value.expected_time >= before.expected_time);
            prop_assert!(value.probability >= before.probability);
            prop_assert!(value.complete || !before.complete);
            before = value;
        }
        // All views together see all there is.
        prop_assert!(before.complete);
    }

    /// Certain detection is the limit of detection that may miss, and missing looks see less.
    #[test]
    fn looks_that_miss_see_less(weights in prop::collection::vec(0.01..0.5f64, 5), q in 0.1..0.9f64) {
        let views = [View::new([0, 1, 2]), View::new([2, 3]), View::new([0, 3, 4])];
        let times = Times::new(vec![3.0; 3], vec![4.0; 9]).unwrap();
        let task = |detection| Task::new(&weights, &views, &times, &Goal { detection, threshold: 0.001 }).unwrap();
        let (sure, missing, nearly) = (task(1.0), task(q), task(1.0 - 1e-12));
        for order in [vec![0], vec![0, 1], vec![2, 0, 1]] {
            prop_assert!(missing.evaluate(&order).weight <= sure.evaluate(&order).weight + 1e-12);
            prop_assert!((nearly.evaluate(&order).weight - sure.evaluate(&order).weight).abs() < 1e-9);
        }
    }

    /// More branching never costs.
    #[test]
    fn branching_never_hurts(task in tasks()) {
        let mut before = f64::INFINITY;
        for depth_limit in [0, 1, 2, 4, usize::MAX] {
            let params = BranchParams { depth_limit, branch_limit: f64::INFINITY, ..BranchParams::default() };
            let found = branch_and_bound(&task, &params, &mut Budget::unlimited());
            prop_assert!(found.expected_time <= before + 1e-9);
            prop_assert_eq!(task.evaluate(&found.sequence).expected_time, found.expected_time);
            before = found.expected_time;
        }
    }

    /// psi = 0 and phi = 1 are greedy.
    #[test]
    fn no_depth_or_no_breadth_is_greedy(task in tasks()) {
        let plan = |depth_limit, branch_limit| {
            let params = BranchParams { depth_limit, branch_limit, ..BranchParams::default() };
            branch_and_bound(&task, &params, &mut Budget::unlimited()).sequence
        };
        prop_assert_eq!(plan(0, f64::INFINITY), greedy(&task).sequence);
        prop_assert_eq!(plan(usize::MAX, 1.0), greedy(&task).sequence);
    }

    /// Local search is never worse than its start, than greedy, or than FLAP's planner, whatever its budget.
    #[test]
    fn local_search_is_never_worse_than_its_starts(task in unreliable_tasks(), steps in 0..20_000u64, seed: u64) {
        let start: Vec<usize> = (0..task.len()).rev().collect();
        let params = LocalParams { seed, ..LocalParams::default() };
        let found = local(&task, &params, &start, &mut Budget::steps(steps));
        prop_assert!(found.complete);
        prop_assert!(found.expected_time <= task.evaluate(&start).expected_time + 1e-9);
        prop_assert!(found.expected_time <= greedy(&task).expected_time + 1e-9);
        prop_assert!(found.lower_bound <= found.expected_time);
        let again = local(&task, &params, &start, &mut Budget::steps(steps));
        prop_assert_eq!(found, again);
    }

    /// With budget for it, local search is never worse than FLAP's planner.
    #[test]
    fn local_search_is_never_worse_than_branch_and_bound(task in plane_tasks()) {
        let flap = branch_and_bound(&task, &BranchParams::default(), &mut Budget::unlimited());
        let found = local(&task, &LocalParams::default(), &[], &mut Budget::steps(50_000));
        prop_assert!(found.expected_time <= flap.expected_time + 1e-9);
    }

    /// Each point is with its nearest medoid, medoids stand for themselves, and there are no more than asked.
    #[test]
    fn clusters_are_around_their_medoids(
        points in prop::collection::vec(prop::array::uniform2(0.0..10.0f64), 1..40), most in 1..12usize,
    ) {
        let found = cluster(&points, most);
        prop_assert!(found.medoids.len() <= most && !found.medoids.is_empty());
        let away = |i: usize, c: usize| {
            let m = points[found.medoids[c]];
            f64::hypot(points[i][0] - m[0], points[i][1] - m[1])
        };
        for i in 0..points.len() {
            for c in 0..found.medoids.len() {
                prop_assert!(away(i, found.of[i]) <= away(i, c) + 1e-9);
            }
        }
        if most >= points.len() {
            prop_assert!((0..points.len()).all(|i| away(i, found.of[i]) == 0.0));
        }
    }

    /// A table of as many clusters as views is the exact table, and both are symmetric on a grid.
    #[test]
    fn enough_clusters_make_the_exact_table(
        bases in prop::collection::vec(prop::array::uniform2(0.0..3.0f64), 1..9),
        blocked in prop::collection::vec(prop::bool::weighted(0.2), 36),
    ) {
        let mut paths = GridPaths::inflated(&blocked, (6, 6), [0.0; 2], 0.5, 1.0, 2.0).unwrap();
        let places: Vec<Place> = bases.iter().map(|&base| Place { base, height: base[0], ..Place::default() }).collect();
        let exact = TravelTable::exact(&places, &mut paths);
        let many = TravelTable::clustered(&places, places.len(), &mut paths);
        let model = Regression::default();
        for a in 0..places.len() {
            for b in 0..places.len() {
                let there = exact.path_cost(a, b);
                prop_assert_eq!(there, many.path_cost(a, b));
                // Cells of both ends count, so that the way back costs the same.
                prop_assert_eq!(there, exact.path_cost(b, a));
                let seconds = exact.seconds(&model, a, b);
                prop_assert!(seconds > 10.9 && (seconds.is_finite() == there.is_finite()));
            }
        }
    }
}

/// A world that keeps its promises: what the task says is seen is seen.
struct Honest {
    weights: Vec<f64>,
    views: Vec<View>,
    left: Vec<usize>,
    seen: Vec<bool>,
    retained: Vec<Vec<usize>>,
}

impl World for Honest {
    type Error = objsearch::Error;

    fn survey(&mut self, planned: &[usize]) -> Result<Survey, Self::Error> {
        self.retained.push(planned.to_vec());
        let views: Vec<View> = self
            .left
            .iter()
            .map(|&v| {
                View::new(
                    self.views[v]
                        .cells()
                        .iter()
                        .copied()
                        .filter(|&c| !self.seen[c]),
                )
            })
            .collect();
        let n = views.len();
        let times = Times::new(vec![3.0; n], vec![3.0; n * n])?;
        let task = Task::new(&self.weights, &views, &times, &Goal::default())?;
        Ok(Survey {
            task,
            views: self.left.clone(),
        })
    }

    fn look(&mut self, view: usize) -> Result<Look, Self::Error> {
        self.left.retain(|&v| v != view);
        let mut weight = 0.0;
        for &cell in self.views[view].cells() {
            if !std::mem::replace(&mut self.seen[cell], true) {
                weight += self.weights[cell];
            }
        }
        Ok(Look {
            seconds: 3.0,
            weight,
            found: false,
        })
    }
}

proptest! {
    /// In a world that keeps its promises, greedy replanned is greedy planned once, and the record's expected time is the
    /// plan's; the rest of each plan is handed back.
    #[test]
    fn honest_worlds_give_what_was_planned(
        weights in prop::collection::vec(0.05..0.5f64, 8),
        shown in prop::collection::vec(prop::collection::vec(0..8usize, 1..4), 1..7),
    ) {
        let world = || Honest {
            weights: weights.clone(),
            views: shown.iter().cloned().map(View::new).collect(),
            left: (0..shown.len()).collect(),
            seen: vec![false; 8],
            retained: Vec::new(),
        };
        let mut first_plan = None;
        let (mut once, mut again) = (world(), world());
        let mut plan = |task: &Task, _: &[usize]| {
            let plan = greedy(task);
            first_plan.get_or_insert_with(|| plan.clone());
            plan
        };
        let offline = search(&mut once, Mode::Offline, 100, &mut plan, &mut |_| true).unwrap();
        let continual = search(&mut again, Mode::Continual, 100, &mut plan, &mut |_| true).unwrap();
        let first = first_plan.unwrap();
        prop_assert!((offline.expected_time - first.expected_time).abs() < 1e-9);
        prop_assert!((offline.probability - first.probability).abs() < 1e-12);
        prop_assert!(offline.ended == Ended::PlanDone || offline.ended == Ended::Exhausted);
        prop_assert_eq!(continual.ended, Ended::Exhausted);
        prop_assert!((continual.expected_time - offline.expected_time).abs() < 1e-9);
        for (step, rest) in continual.steps.iter().zip(&again.retained[1..]) {
            prop_assert_eq!(step.planned, rest.len() + 1);
        }
    }

    /// Dominance among siblings only drops plans, so that greedy's value still bounds it.
    #[test]
    fn dominance_stays_below_greedy(task in tasks()) {
        for dominance in [Dominance::Siblings, Dominance::All, Dominance::Safe] {
            let params = BranchParams { dominance, ..BranchParams::default() };
            let found = branch_and_bound(&task, &params, &mut Budget::unlimited());
            prop_assert!(found.complete);
            if dominance == Dominance::Siblings {
                prop_assert!(found.expected_time <= greedy(&task).expected_time + 1e-9);
            }
        }
    }
}
