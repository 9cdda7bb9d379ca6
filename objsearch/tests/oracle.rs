//! The planners against exhaustive search, and against stored reference values.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::{Instance, exhaustive, plane_tasks, tasks, unreliable_tasks};
use objsearch::{
    BranchParams, Budget, Dominance, GridPaths, LocalParams, Paths, Plan, STEPS_PER_TENTH_SECOND,
    Status, Task, branch_and_bound, deepen, greedy, local, lower_bound, optimal, prove, widen,
};
use proptest::prelude::*;

fn flap(task: &Task, dominance: Dominance) -> Plan {
    let params = BranchParams {
        dominance,
        ..BranchParams::default()
    };
    branch_and_bound(task, &params, &mut Budget::unlimited())
}

/// What every plan of an instance keeps: complete, no view twice, its figure is the definition's.
fn sound(instance: &Instance, plan: &Plan) {
    let (expected, complete) = instance.expected_time(&plan.sequence);
    assert!(plan.complete && complete);
    assert!(
        (plan.expected_time - expected).abs() < 1e-6,
        "{} {expected}",
        plan.expected_time
    );
    let mut once = plan.sequence.clone();
    once.sort_unstable();
    once.dedup();
    assert_eq!(once.len(), plan.sequence.len());
    assert!(plan.lower_bound <= plan.expected_time);
}

fn meets_its_references(instance: &Instance) {
    let task = &instance.task;
    let (siblings, off) = (flap(task, Dominance::Siblings), flap(task, Dominance::Off));
    for (plan, key) in [
        (greedy(task), "greedy"),
        (off.clone(), "flap_psi2_phi1.3_xi0"),
        (siblings, "flap_psi2_phi1.3_xi1"),
    ] {
        sound(instance, &plan);
        let wanted = instance.reference(key);
        assert!(
            (plan.expected_time - wanted).abs() < 1e-3,
            "{key}: {} {wanted}",
            plan.expected_time
        );
    }
    let found = local(
        task,
        &LocalParams::default(),
        &[],
        &mut Budget::steps(STEPS_PER_TENTH_SECOND),
    );
    sound(instance, &found);
    assert!(found.expected_time <= off.expected_time + 1e-9);
    let share = found.expected_time / instance.best();
    assert!(share < 1.03, "local is {share} of the best known");
    assert!(lower_bound(task) <= instance.best());
}

#[test]
fn the_instance_of_this_crate_meets_its_references() {
    let instance = Instance::parse(include_str!("synth-014.json"));
    meets_its_references(&instance);
    let best = optimal(&instance.task).unwrap();
    sound(&instance, &best);
    assert!((best.expected_time - instance.best()).abs() < 1e-3);
    let proved = prove(&instance.task, &[], &mut Budget::unlimited());
    assert_eq!(proved.status, Status::Optimal);
    assert!((proved.expected_time - best.expected_time).abs() < 1e-9);
    assert_eq!(proved.gap(), 0.0);
}

#[test]
fn the_shared_instances_meet_their_references() {
    let folder = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../shared/data/flap-instances"
    );
    let Ok(entries) = std::fs::read_dir(folder) else {
        eprintln!("skipped: no {folder}");
        return;
    };
    let mut files: Vec<_> = entries.map(|e| e.unwrap().path()).collect();
    files.sort();
    for file in files
        .iter()
        .filter(|f| f.extension().is_some_and(|e| e == "json"))
    {
        eprintln!("{}", file.display());
        meets_its_references(&Instance::parse(&std::fs::read_to_string(file).unwrap()));
    }
}

fn all_planners(task: &Task) -> Vec<Plan> {
    let params = BranchParams {
        dominance: Dominance::All,
        ..BranchParams::default()
    };
    vec![
        greedy(task),
        flap(task, Dominance::Off),
        flap(task, Dominance::Siblings),
        branch_and_bound(task, &params, &mut Budget::unlimited()),
        deepen(task, &BranchParams::default(), &mut Budget::unlimited()),
        widen(task, &BranchParams::default(), &mut Budget::unlimited()),
        local(
            task,
            &LocalParams::default(),
            &[],
            &mut Budget::steps(100_000),
        ),
    ]
}

fn exact_planners(task: &Task, dominance: Dominance) -> Vec<Plan> {
    let bound = |bound| BranchParams {
        bound,
        dominance,
        ..BranchParams::exhaustive()
    };
    vec![
        optimal(task).unwrap(),
        branch_and_bound(task, &bound(false), &mut Budget::unlimited()),
        branch_and_bound(task, &bound(true), &mut Budget::unlimited()),
        prove(task, &[], &mut Budget::unlimited()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// The subset program, branch and bound without limits, with and without the lower bound, and the proof all equal
    /// exhaustive search; the others are never below it, and the lower bound never above.
    #[test]
    fn exact_planners_are_optimal(task in tasks()) {
        let best = exhaustive(&task);
        for found in exact_planners(&task, Dominance::Off) {
            prop_assert!((found.expected_time - best).abs() < 1e-9, "{} against {best}", found.expected_time);
        }
        for found in all_planners(&task) {
            prop_assert!(found.complete && found.expected_time >= best - 1e-9);
        }
        prop_assert!(lower_bound(&task) <= best + 1e-9);
    }

    /// The same where a look may miss.
    #[test]
    fn exact_planners_are_optimal_with_looks_that_miss(task in unreliable_tasks()) {
        let best = exhaustive(&task);
        for found in exact_planners(&task, Dominance::Off) {
            prop_assert!((found.expected_time - best).abs() < 1e-9, "{} against {best}", found.expected_time);
        }
        for found in all_planners(&task) {
            prop_assert!(found.complete && found.expected_time >= best - 1e-9);
        }
        prop_assert!(lower_bound(&task) <= best + 1e-9);
    }

    /// Safe dominance keeps the optimum where detours are never shorter.
    #[test]
    fn safe_dominance_keeps_the_optimum(task in plane_tasks()) {
        let best = exhaustive(&task);
        for found in exact_planners(&task, Dominance::Safe) {
            prop_assert!((found.expected_time - best).abs() < 1e-9, "{} against {best}", found.expected_time);
        }
    }

    /// The grid's path costs are those of a textbook Dijkstra.
    #[test]
    fn grid_costs_are_dijkstras(
        values in prop::collection::vec(prop_oneof![3 => 0..253u8, 1 => Just(255u8)], 42),
        from in 0..42usize,
    ) {
        let (width, height) = (7usize, 6usize);
        let cost = |i: usize| (values[i] < 253).then(|| 50 + u64::from(values[i]) * 4 / 5);
        let mut distance = vec![u64::MAX; 42];
        if let Some(c) = cost(from) {
            distance[from] = c;
        }
        // Relax until nothing changes (Bellman-Ford).
        for _ in 0..42 {
            for i in 0..42 {
                let (x, y) = (i % width, i / width);
                let beside = [(x > 0, i.wrapping_sub(1)), (x + 1 < width, i + 1), (y > 0, i.wrapping_sub(width)), (y + 1 < height, i + width)];
                for j in beside.iter().filter(|b| b.0).map(|b| b.1) {
                    if let (Some(c), true) = (cost(i), distance[j] != u64::MAX) {
                        distance[i] = distance[i].min(distance[j] + c);
                    }
                }
            }
        }
        let mut grid = GridPaths::new(&values, (width, height), [-1.0, 2.0], 0.5).unwrap();
        let at = |i: usize| [-1.0 + 0.5 * ((i % width) as f64 + 0.5), 2.0 + 0.5 * ((i / width) as f64 + 0.5)];
        let to: Vec<[f64; 2]> = (0..42).map(at).collect();
        let mut costs = Vec::new();
        grid.from(at(from), &to, &mut costs);
        for i in 0..42 {
            let wanted = if distance[i] == u64::MAX { f64::INFINITY } else { distance[i] as f64 };
            prop_assert_eq!(costs[i], wanted);
        }
    }
}
