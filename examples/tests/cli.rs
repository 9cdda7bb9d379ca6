//! The command line: what it refuses, and with which words and exit status.
#![allow(missing_docs, clippy::unwrap_used)]

use std::process::{Command, Output};

fn seekplan(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_seekplan"))
        .args(args)
        .output()
        .unwrap()
}

fn refused(args: &[&str], words: &[&str]) {
    let output = seekplan(args);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {stderr}");
    for word in words {
        assert!(stderr.contains(word), "{args:?}: {stderr} lacks {word}");
    }
}

#[test]
fn unknown_planners_are_refused_with_the_list_of_what_exists() {
    refused(
        &["heats", "--planner", "magic"],
        &["magic", "heats-plus", "heats", "aep", "wg-nbvp"],
    );
    refused(
        &["heats", "--planner", "aep", "--sensors", "both"],
        &["aep", "camera alone"],
    );
    refused(
        &["heats", "--planner", "aep", "--set", "views.threshold=3"],
        &["views"],
    );
    refused(
        &["heats", "--planner", "wg-nbvp", "--set", "wg_nbvp.step=-1"],
        &["wg_nbvp.step", "-1"],
    );
}

#[test]
fn buildings_that_cannot_be_made_are_refused_by_field() {
    let no = |option: &str, value: &str, words: &[&str]| {
        let args = ["scene", "generate", "--out", "none.json", option, value];
        refused(&args, words);
        assert!(!std::path::Path::new("none.json").exists());
    };
    for size in ["40", "40x30x2", "40xwide"] {
        no("--size", size, &["--size", size, "40x30"]);
    }
    no("--size", "3x9", &["size[0] = 3", "between 6 and 300 m"]);
    no("--door", "0.5", &["door = 0.5", "between 0.8 and 2 m"]);
}

#[test]
fn the_published_rules_are_embedded() {
    let folder = std::env::temp_dir().join(format!("seekplan-preset-{}", std::process::id()));
    let result = |args: &[&str]| -> serde_json::Value {
        let out = folder.to_string_lossy().into_owned();
        let fixed = ["heats", "--scene=closet", "--time-limit=0", "--no-record"];
        let run = seekplan(&[&fixed, args, &["--quiet", "--out", &out]].concat());
        assert!(run.status.success(), "{args:?}");
        serde_json::from_str(&std::fs::read_to_string(folder.join("result.json")).unwrap()).unwrap()
    };
    let settings = |result: &serde_json::Value| -> toml::Table {
        toml::from_str(result["settings"].as_str().unwrap()).unwrap()
    };
    let decay = |result| {
        settings(result)["views"]["motion_decay"]
            .as_float()
            .unwrap()
    };
    let ours = result(&[]);
    assert_eq!(ours["planner"], "heats-plus");
    assert!(decay(&ours) < 0.5);
    let published = result(&["--planner", "heats", "--set", "views.threshold=3"]);
    assert_eq!(published["planner"], "heats");
    assert!((decay(&published) - 0.5).abs() < 1e-12);
    let threshold = &settings(&published)["views"]["threshold"];
    assert!((threshold.as_float().unwrap() - 3.0).abs() < 1e-12);
    // A file on top of the preset; the planner it names is overruled by the command line's.
    std::fs::write(
        folder.join("own.toml"),
        "planner = \"heats-plus\"\n[views]\nthreshold = 5.0",
    )
    .unwrap();
    let own = folder.join("own.toml").to_string_lossy().into_owned();
    let both = result(&["--planner", "heats", "--config", &own]);
    assert_eq!(both["planner"], "heats");
    assert!((decay(&both) - 0.5).abs() < 1e-12);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn unknown_settings_are_refused_by_name() {
    refused(
        &["heats", "--set", "views.motion_dekay=0.4"],
        &["motion_dekay"],
    );
    refused(&["heats", "--set", "views.motion_decay"], &["key=value"]);
    refused(
        &["heats", "--set", "views.motion_decay=-1"],
        &["views.motion_decay", "-1"],
    );
    refused(&["heats", "--set", "map.cell_size=nan"], &["cell_size"]);
    refused(
        &["heats", "--config", "/nowhere/a.toml"],
        &["/nowhere/a.toml"],
    );
}

#[test]
fn unknown_scenes_are_refused_by_name() {
    refused(
        &["heats", "--scene", "/nowhere/s.json"],
        &["/nowhere/s.json"],
    );
    refused(&["scene", "check", "atlantis"], &["atlantis"]);
}

#[test]
fn wrong_searches_of_flap_and_wrong_suites_are_refused_by_name() {
    refused(
        &["flap", "--scene", "closet"],
        &["closet", "target_volumes"],
    );
    refused(&["flap", "--planner", "magic"], &["magic"]);
    refused(&["flap", "--set", "threshold=1"], &["threshold", "below 1"]);
    refused(&["flap", "--set", "budget_ms=-1"], &["budget_ms", "-1"]);
    refused(
        &["flap", "--set", "haze=nan"],
        &["haze", "NaN", "zero or more"],
    );
    refused(&["bench", "--suite", "figure7"], &["figure7"]);
    refused(&["bench", "--shard", "3/2"], &["3/2"]);
}

#[test]
fn reports_without_a_recording_are_refused() {
    refused(&["report", "/nonexistent"], &["/nonexistent/record.jsonl"]);
    refused(
        &["report", "/nonexistent", "--at=-1"],
        &["--at", "zero or more"],
    );
}

#[test]
fn unknown_flags_exit_with_two() {
    assert_eq!(seekplan(&["heats", "--fast"]).status.code(), Some(2));
}

#[test]
fn embedded_scenes_are_valid() {
    for scene in ["office", "maze", "lab", "closet"] {
        let output = seekplan(&["scene", "check", scene]);
        assert!(
            output.status.success(),
            "{scene}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
}

#[test]
fn a_zero_time_limit_still_leaves_a_result() {
    let folder = std::env::temp_dir().join(format!("seekplan-zero-{}", std::process::id()));
    let out = folder.to_string_lossy().into_owned();
    let output = seekplan(&[
        "heats",
        "--scene",
        "closet",
        "--time-limit",
        "0",
        "--out",
        &out,
        "--quiet",
    ]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let text = std::fs::read_to_string(folder.join("result.json")).unwrap();
    let result: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(result["ended"], "time_limit");
    assert_eq!(result["schema"], "seekplan-result/1");
    assert!(
        std::fs::read_to_string(folder.join("topdown.svg"))
            .unwrap()
            .ends_with("</svg>\n")
    );
    std::fs::remove_dir_all(folder).unwrap();
}
