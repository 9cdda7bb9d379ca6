//! Plans object-search instances with every planner: `cargo run --release -p objsearch --example instances -- FILE...`
//!
//! Without arguments the instance of this crate's tests. Times are CPU times.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod instance;

use cpu_time::ThreadTime;
use instance::Instance;
use objsearch::{
    BranchParams, Budget, Dominance, LocalParams, Plan, STEPS_PER_TENTH_SECOND, branch_and_bound,
    deepen, greedy, local, prove, widen,
};

fn main() {
    let mut files: Vec<String> = std::env::args().skip(1).collect();
    let limit: f64 = match files.iter().position(|f| f == "--prove") {
        Some(at) => {
            let seconds = files.remove(at + 1).parse().unwrap();
            files.remove(at);
            seconds
        }
        None => 1.0,
    };
    if files.is_empty() {
        files.push(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/synth-014.json").into());
    }
    println!(
        "{:<12} {:<24} {:>9} {:>8} {:>8} {:>9} {:>6}  status",
        "instance", "planner", "E s", "/ best", "/ ref", "CPU ms", "views"
    );
    let mut shares = Vec::new();
    for file in &files {
        let instance = Instance::load(file.as_ref()).unwrap();
        shares.extend(compare(&instance, limit));
    }
    if !shares.is_empty() {
        let worst = shares.iter().copied().fold(0.0, f64::max);
        let mean = shares.iter().sum::<f64>() / shares.len() as f64;
        println!("local 0.1 s / best: mean {mean:.4}, worst {worst:.4}");
    }
}

/// Runs all planners; returns local's expected time over the best known, if that is known.
fn compare(instance: &Instance, limit: f64) -> Option<f64> {
    let task = &instance.task;
    let branch = |dominance| BranchParams {
        dominance,
        ..BranchParams::default()
    };
    let wide = BranchParams {
        branch_limit: 1.5,
        ..branch(Dominance::Siblings)
    };
    let cut = Budget::unlimited;
    let seconds = |s: f64| {
        let start = ThreadTime::now();
        Budget::unlimited().until(move || start.elapsed().as_secs_f64() >= s)
    };
    let mut best_found = Vec::new();
    let mut show = |name: &str, reference: Option<f64>, run: &mut dyn FnMut() -> Plan| {
        let start = ThreadTime::now();
        let plan = run();
        let ms = 1e3 * start.elapsed().as_secs_f64();
        let ratio = |to: Option<f64>| {
            to.map_or(String::from("-"), |t| {
                format!("{:.4}", plan.expected_time / t)
            })
        };
        println!(
            "{:<12} {:<24} {:>9.4} {:>8} {:>8} {:>9.2} {:>6}  {:?}{}",
            instance.name,
            name,
            plan.expected_time,
            ratio(instance.best),
            ratio(reference),
            ms,
            plan.sequence.len(),
            plan.status,
            if plan.lower_bound > 0.0 {
                format!(", bound {:.2}", plan.lower_bound)
            } else {
                String::new()
            },
        );
        assert!(plan.complete, "{name} is incomplete");
        best_found.clone_from(&plan.sequence);
        plan.expected_time
    };
    let known = |key: &str| instance.reference(key);
    show("greedy", known("greedy"), &mut || greedy(task));
    for (name, key, dominance) in [
        (
            "flap psi=2 phi=1.3 xi=0",
            "flap_psi2_phi1.3_xi0",
            Dominance::Off,
        ),
        (
            "flap psi=2 phi=1.3 xi=1",
            "flap_psi2_phi1.3_xi1",
            Dominance::Siblings,
        ),
    ] {
        show(name, known(key), &mut || {
            branch_and_bound(task, &branch(dominance), &mut cut())
        });
    }
    show(
        "iter_psi 1 s phi=1.5",
        known("flap_iterdeep_phi1.5_xi1_1s"),
        &mut || deepen(task, &wide, &mut seconds(1.0)),
    );
    show("iter_phi 0.1 s psi=4", None, &mut || {
        widen(
            task,
            &BranchParams {
                depth_limit: 4,
                ..wide.clone()
            },
            &mut seconds(0.1),
        )
    });
    let params = LocalParams::default();
    show("local descent", known("local_search_descent"), &mut || {
        local(
            task,
            &LocalParams {
                perturbations: 0,
                ..params.clone()
            },
            &[],
            &mut cut(),
        )
    });
    show("local 20 ms", None, &mut || {
        local(task, &params, &[], &mut seconds(0.02))
    });
    let tenth = show("local 0.1 s", known("ils_0.1s"), &mut || {
        local(task, &params, &[], &mut seconds(0.1))
    });
    show("local, steps of 0.1 s", known("ils_0.1s"), &mut || {
        local(
            task,
            &params,
            &[],
            &mut Budget::steps(STEPS_PER_TENTH_SECOND),
        )
    });
    show("local 1 s", known("ils_1s"), &mut || {
        local(task, &params, &[], &mut seconds(1.0))
    });
    let start = local(task, &params, &[], &mut seconds(0.1)).sequence;
    show("prove", instance.best, &mut || {
        prove(task, &start, &mut seconds(limit))
    });
    instance.best.map(|best| tenth / best)
}
