//! The invariants of ARCHITECTURE.md that a machine can check.
#![allow(missing_docs, clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::Command;

const ALGORITHMS: [&str; 7] = [
    "voxfrontier",
    "viewsample",
    "hybrid-astar",
    "strrt",
    "ddp-rbf",
    "atsp",
    "objsearch",
];
const PROVIDERS: [&str; 2] = ["voxmap", "mobimanip"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap()
        .to_owned()
}

fn packages() -> Vec<serde_json::Value> {
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--no-deps",
            "--format-version",
            "1",
            "--offline",
        ])
        .current_dir(root())
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    metadata["packages"].as_array().unwrap().clone()
}

fn package<'a>(all: &'a [serde_json::Value], name: &str) -> &'a serde_json::Value {
    all.iter()
        .find(|p| p["name"] == name)
        .unwrap_or_else(|| panic!("no package {name}"))
}

fn is_ours(name: &str) -> bool {
    ALGORITHMS.contains(&name) || PROVIDERS.contains(&name) || name == "seekplan"
}

/// What the README shows of a map, a robot and a planner of one's own is compiled: each block stands in an example.
#[test]
fn the_code_in_the_readme_is_that_of_the_examples() {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let programs: Vec<String> = std::fs::read_dir(root().join("examples/examples"))
        .unwrap()
        .map(|entry| std::fs::read_to_string(entry.unwrap().path()).unwrap())
        .collect();
    let blocks: Vec<&str> = readme
        .split("```rust\n")
        .skip(1)
        .map(|rest| rest.split("\n```").next().unwrap())
        .collect();
    assert_eq!(blocks.len(), 3, "a map, a robot, a planner");
    for block in blocks {
        assert!(programs.iter().any(|p| p.contains(block)), "{block}");
    }
}

#[test]
fn algorithm_crates_know_no_crate_of_the_workspace() {
    let all = packages();
    for name in ALGORITHMS {
        for dependency in package(&all, name)["dependencies"].as_array().unwrap() {
            let other = dependency["name"].as_str().unwrap();
            assert!(!is_ours(other), "{name} depends on {other}");
        }
    }
}

#[test]
fn providers_reach_algorithms_only_through_optional_features() {
    let all = packages();
    for name in PROVIDERS {
        let package = package(&all, name);
        for dependency in package["dependencies"].as_array().unwrap() {
            let other = dependency["name"].as_str().unwrap();
            // Tests and examples of a provider may know its consumers.
            if is_ours(other) && dependency["kind"] != "dev" {
                assert_eq!(dependency["optional"], true, "{name} -> {other}");
                assert!(ALGORITHMS.contains(&other), "{name} -> {other}");
            }
        }
        let default = package["features"]["default"].as_array().unwrap();
        assert!(
            default.is_empty(),
            "{name} has default features {default:?}"
        );
    }
}

/// All Rust files below a folder.
fn sources(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
}

/// Library code of the algorithm and provider crates without comments.
fn library_code() -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    for folder in [
        "voxmap",
        "frontier",
        "viewsample",
        "atsp",
        "hybrid-astar",
        "strrt",
        "ddp-rbf",
        "objsearch",
        "robots",
    ] {
        sources(&root().join(folder).join("src"), &mut files);
    }
    files.sort();
    files
        .into_iter()
        .map(|path| {
            let text = std::fs::read_to_string(&path).unwrap();
            let code: String = text
                .lines()
                .filter(|line| !line.trim_start().starts_with("//"))
                .flat_map(|line| [line, "\n"])
                .collect();
            (path, code)
        })
        .collect()
}

#[test]
fn libraries_read_no_clock_and_start_no_thread() {
    for (path, code) in library_code() {
        for word in [
            "Instant::now",
            "SystemTime",
            "std::thread",
            "println!",
            "eprintln!",
        ] {
            assert!(!code.contains(word), "{} uses {word}", path.display());
        }
    }
}

#[test]
fn libraries_do_io_only_where_it_is_their_purpose() {
    for (path, code) in library_code() {
        let allowed = path.ends_with("voxmap/src/io.rs")
            || path.components().any(|c| c.as_os_str() == "io")
            || path.ends_with("robots/src/urdf.rs");
        if !allowed {
            for word in ["std::fs", "std::net", "std::env"] {
                assert!(!code.contains(word), "{} uses {word}", path.display());
            }
        }
    }
}

#[test]
fn public_signatures_name_no_foreign_math_type() {
    for (path, code) in library_code() {
        let nalgebra_allowed = ["ddp-rbf", "robots"]
            .iter()
            .any(|c| path.components().any(|part| part.as_os_str() == *c));
        for line in code
            .lines()
            .filter(|l| l.trim_start().starts_with("pub fn"))
        {
            for word in ["DVec3", "Vec3A", "parry", "ChaCha", "rand::"] {
                assert!(!line.contains(word), "{}: {line}", path.display());
            }
            if !nalgebra_allowed {
                assert!(!line.contains("nalgebra"), "{}: {line}", path.display());
            }
        }
    }
}

#[test]
fn only_the_simulator_knows_the_ground_truth() {
    let mut files = Vec::new();
    sources(&root().join("examples/src"), &mut files);
    for path in files {
        let text = std::fs::read_to_string(&path).unwrap();
        if text.contains("parry3d") {
            let inside = path
                .components()
                .any(|c| c.as_os_str() == "sim" || c.as_os_str() == "scene");
            assert!(
                inside || path.ends_with("scene.rs"),
                "{} uses exact geometry",
                path.display()
            );
        }
    }
}
