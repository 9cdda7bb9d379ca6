//! Campaigns of searches for tags: the same results however they are run, and nothing lost but the trial in hand.
#![allow(missing_docs, clippy::unwrap_used)]

use seekplan::bench::{
    self, BenchError, Campaign, HeatsTables, Report, Suite, SuiteError, SuiteFile, TrialFile,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

const SUITE: &str = r#"
planners = ["wg-nbvp", "aep", "heats-plus/camera"]
scenes = ["closet"]
seeds = 2
time_limit = 17.0
"#;

fn suite(text: &str) -> HeatsTables {
    HeatsTables::new(&SuiteFile::from_toml(text).unwrap(), None).unwrap()
}

/// An empty folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let out = std::env::temp_dir().join(format!("seekplan-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&out);
    out
}

/// Runs a suite with what it says.
fn run(text: &str, out: &Path, jobs: usize, resume: bool) -> (Result<Report, BenchError>, String) {
    run_as(text, out, jobs, resume, false)
}

fn run_as(
    text: &str,
    out: &Path,
    jobs: usize,
    resume: bool,
    reports: bool,
) -> (Result<Report, BenchError>, String) {
    let said = Mutex::new(String::new());
    let campaign = Campaign {
        jobs,
        shard: (0, 1),
        resume,
        reports,
        out: out.to_owned(),
    };
    let report = bench::run(&suite(text), &campaign, &AtomicBool::new(false), &|line| {
        *said.lock().unwrap() += &format!("{line}\n");
    });
    (report, said.into_inner().unwrap())
}

/// All results but for what belongs to the machine, as text.
fn results(out: &Path) -> BTreeMap<String, String> {
    std::fs::read_dir(out.join("trials"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "json"))
        .map(|path| {
            let file = TrialFile::from_json(&std::fs::read_to_string(&path).unwrap()).unwrap();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            (name, serde_json::to_string(&file.reproducible()).unwrap())
        })
        .collect()
}

/// Results of the suite, run once for all tests of this file.
fn reference() -> &'static BTreeMap<String, String> {
    static ONCE: std::sync::OnceLock<BTreeMap<String, String>> = std::sync::OnceLock::new();
    ONCE.get_or_init(|| {
        let out = folder("reference");
        run(SUITE, &out, 1, false).0.unwrap();
        let all = results(&out);
        assert_eq!(all.len(), 6);
        std::fs::remove_dir_all(out).unwrap();
        all
    })
}

#[test]
fn two_jobs_give_what_one_gives() {
    let out = folder("jobs");
    let (report, _) = run(SUITE, &out, 2, false);
    let report = report.unwrap();
    assert_eq!(&results(&out), reference());
    let names: Vec<_> = report
        .files
        .iter()
        .map(|f| f.file_name().unwrap().to_owned())
        .collect();
    assert_eq!(names, ["tables.md", "trials.csv", "report.html"]);
    let csv = std::fs::read_to_string(out.join("trials.csv")).unwrap();
    assert_eq!(csv.lines().count(), 7);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    for name in reference().keys() {
        assert!(page.contains(&format!("trials/{name}")), "{name}");
        assert!(csv.contains(name.trim_end_matches(".json")), "{name}");
    }
    assert!(page.contains("explored space over time") && !page.contains("NaN"));
    for row in ["wg-nbvp", "aep", "heats-plus-camera"] {
        assert!(report.table.contains(row), "{row}");
    }
    // Each says what it is a result of.
    let one = std::fs::read_to_string(out.join("trials/closet.aep.seed01.json")).unwrap();
    let one = TrialFile::from_json(&one).unwrap();
    assert_eq!(one.version, env!("CARGO_PKG_VERSION"));
    assert!(one.scene_hash.starts_with("fnv1a64-") && one.rustc.starts_with("rustc"));
    assert!(!one.machine.cpu.is_empty() && one.result.settings.contains("time_limit = 17.0"));
    std::fs::remove_dir_all(out).unwrap();
}

fn program(out: &Path, more: &[&str]) -> Command {
    let file = out.join("suite.toml");
    std::fs::create_dir_all(out).unwrap();
    std::fs::write(&file, SUITE).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_seekplan"));
    command
        .arg("bench")
        .arg("--suite")
        .arg(file)
        .arg("--out")
        .arg(out)
        .args(more);
    command
}

#[test]
fn a_campaign_that_was_killed_goes_on_where_it_was() {
    let out = folder("killed");
    let mut child = program(&out, &["--jobs", "2"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let trials = out.join("trials");
    let count = || {
        let names = std::fs::read_dir(&trials).into_iter().flatten();
        names
            .filter(|e| {
                e.as_ref()
                    .unwrap()
                    .path()
                    .extension()
                    .is_some_and(|x| x == "json")
            })
            .count()
    };
    for _ in 0..6000 {
        if count() >= 2 {
            break;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    // SIGKILL.
    child.kill().unwrap();
    child.wait().unwrap();
    let before = results(&out);
    assert!((2..6).contains(&before.len()), "{}", before.len());
    let stamp = |name: &String| {
        std::fs::metadata(trials.join(name))
            .unwrap()
            .modified()
            .unwrap()
    };
    let stamps: Vec<_> = before.keys().map(stamp).collect();
    assert!(
        program(&out, &["--resume", "--quiet"])
            .status()
            .unwrap()
            .success()
    );
    assert_eq!(&results(&out), reference());
    assert_eq!(
        stamps,
        before.keys().map(stamp).collect::<Vec<_>>(),
        "repeated without need"
    );
    std::fs::remove_dir_all(out).unwrap();
}

/// Every file of the trials, with the time at which it was written.
fn stamps(out: &Path) -> BTreeMap<String, std::time::SystemTime> {
    std::fs::read_dir(out.join("trials"))
        .unwrap()
        .map(|entry| {
            let entry = entry.unwrap();
            let name = entry.file_name().to_string_lossy().into_owned();
            (name, entry.metadata().unwrap().modified().unwrap())
        })
        .collect()
}

#[test]
fn trials_leave_reports_when_asked_and_keep_them() {
    let text = SUITE.replace("\"wg-nbvp\", \"aep\", ", "\"wg-nbvp\", ");
    let out = folder("reports");
    let (first, said) = run_as(&text, &out, 2, false, true);
    let page = |report: Report| std::fs::read_to_string(&report.files[2]).unwrap();
    let first = page(first.unwrap());
    assert!(said.contains("[4/4]"), "{said}");
    // Recording changes no result, and leaves one page a trial and nothing half done.
    let all = results(&out);
    assert_eq!(all.len(), 4);
    assert!(all.iter().all(|(name, text)| &reference()[name] == text));
    let before = stamps(&out);
    assert_eq!(before.len(), 8, "{before:?}");
    for name in all.keys() {
        let link = format!("trials/{}", name.replace(".json", ".html"));
        // A mark in each of four plots, and the table of the first; the table leads to the result as well.
        assert_eq!(
            first.matches(&format!("<a href=\"{link}\"")).count(),
            5,
            "{link}"
        );
        assert_eq!(
            first.matches(&format!("<a href=\"trials/{name}\"")).count(),
            1
        );
        // What is linked is that very trial's report, with the figures of the result beside it.
        let report = std::fs::read_to_string(out.join(&link)).unwrap();
        let data = report.split_once(r#"<script type="application/json" id="data">"#);
        let data = data.unwrap().1.split_once("</script>").unwrap().0;
        let data: serde_json::Value = serde_json::from_str(data).unwrap();
        let kept = std::fs::read_to_string(out.join("trials").join(name)).unwrap();
        let kept: serde_json::Value = serde_json::from_str(&kept).unwrap();
        assert_eq!(data["result"], kept["result"], "{name}");
        assert_eq!(data["begin"]["seed"], kept["result"]["seed"]);
        assert_eq!(data["begin"]["settings"], kept["result"]["settings"]);
        assert!(data["poses"].as_str().unwrap().len() > 100);
    }
    // What is there stays as it is, with reports or without.
    for reports in [true, false] {
        let (report, said) = run_as(&text, &out, 1, true, reports);
        assert_eq!((page(report.unwrap()), said.as_str()), (first.clone(), ""));
        assert_eq!(stamps(&out), before);
    }
    // A report that is missed is made anew, with its trial alone.
    let name = "closet.wg-nbvp.seed01";
    let lost = out.join(format!("trials/{name}.html"));
    std::fs::remove_file(&lost).unwrap();
    let (report, said) = run_as(&text, &out, 1, true, false);
    assert!(said.is_empty() && !page(report.unwrap()).contains(&format!("{name}.html")));
    let (report, said) = run_as(&text, &out, 1, true, true);
    assert_eq!(
        (page(report.unwrap()), said.trim()),
        (first, format!("[1/1] {name}").as_str())
    );
    let after = stamps(&out);
    let changed: Vec<_> = after.keys().filter(|k| after[*k] != before[*k]).collect();
    assert_eq!(changed, [&format!("{name}.html"), &format!("{name}.json")]);
    assert_eq!(results(&out), all);
    // A trial that is run anew without a report does not keep the old one.
    run(&text, &out, 2, false).0.unwrap();
    assert!(stamps(&out).keys().all(|k| k.ends_with(".json")));
    std::fs::remove_dir_all(out).unwrap();
}

#[test]
fn broken_results_are_named_and_repeated() {
    let out = folder("broken");
    run(SUITE, &out, 2, false).0.unwrap();
    let path = |name: &str| out.join(format!("trials/closet.{name}.json"));
    let whole = std::fs::read(path("aep.seed01")).unwrap();
    std::fs::write(path("aep.seed01"), &whole[..whole.len() / 2]).unwrap();
    std::fs::write(path("aep.seed02"), b"").unwrap();
    std::fs::write(path("wg-nbvp.seed01"), [0xff, 0x00, 0x80]).unwrap();
    std::fs::write(path("wg-nbvp.seed02"), "{\"schema\": \"other\"}").unwrap();
    // Nothing is made of them.
    assert!(matches!(
        bench::collect(&suite(SUITE), &out),
        Err(BenchError::Unfit { .. })
    ));
    let (report, said) = run(SUITE, &out, 1, true);
    report.unwrap();
    for name in [
        "aep.seed01",
        "aep.seed02",
        "wg-nbvp.seed01",
        "wg-nbvp.seed02",
    ] {
        let line = said
            .lines()
            .find(|l| l.starts_with(&format!("closet.{name}:")));
        let line = line.unwrap_or_else(|| panic!("{said} lacks {name}"));
        assert!(
            line.contains("broken result") && line.contains("repeated"),
            "{line}"
        );
    }
    assert!(said.contains("[4/4]"), "{said}");
    assert_eq!(&results(&out), reference());
    std::fs::remove_dir_all(out).unwrap();
}

#[test]
fn versions_and_settings_are_not_mixed_and_missing_trials_are_named() {
    let out = folder("mixed");
    run(SUITE, &out, 2, false).0.unwrap();
    let path = out.join("trials/closet.aep.seed02.json");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    let error = bench::collect(&suite(SUITE), &out).unwrap_err().to_string();
    assert!(
        error.contains("1 of 6") && error.contains("closet.aep.seed02"),
        "{error}"
    );
    for (from, to, word) in [
        ("\"version\": \"", "\"version\": \"9.", "version"),
        ("\"sources\": \"", "\"sources\": \"other ", "sources"),
        ("\"rustc\": \"", "\"rustc\": \"other ", "rustc"),
        ("fnv1a64-", "fnv1a64-0", "scene_hash"),
        (
            "time_limit = 17.0",
            "time_limit = 19.0",
            "time_limit = 19.0",
        ),
        ("closet.aep.seed02", "closet.aep.seed01", "trial"),
    ] {
        std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let refused = [
            bench::collect(&suite(SUITE), &out).unwrap_err().to_string(),
            run(SUITE, &out, 1, true).0.unwrap_err().to_string(),
        ];
        for error in refused {
            let named = error.contains("closet.aep.seed02.json") && error.contains(word);
            assert!(named, "{word}: {error}");
        }
        // What is refused is left as it was.
        assert_eq!(
            std::fs::read_to_string(&path).unwrap(),
            text.replacen(from, to, 1)
        );
    }
    std::fs::write(&path, &text).unwrap();
    let other = SUITE.replace("time_limit = 17.0", "time_limit = 17.5");
    let error = bench::collect(&suite(&other), &out)
        .unwrap_err()
        .to_string();
    assert!(error.contains("settings"), "{error}");
    assert!(bench::collect(&suite(SUITE), &out).is_ok());
    std::fs::remove_dir_all(out).unwrap();
}

/// A file-size limit stands for a full disk: writing fails, and the process lives to tell.
#[cfg(unix)]
#[test]
fn a_full_disk_loses_the_trial_in_hand_and_says_so() {
    let out = folder("full");
    let whole = program(&out, &["--jobs", "1"]);
    let words: Vec<String> = std::iter::once(whole.get_program())
        .chain(whole.get_args())
        .map(|w| format!("'{}'", w.to_string_lossy()))
        .collect();
    let full = Command::new("bash")
        .arg("-c")
        .arg(format!(
            "trap '' XFSZ; ulimit -f 4; exec {}",
            words.join(" ")
        ))
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&full.stderr);
    assert_eq!(full.status.code(), Some(2), "{stderr}");
    assert!(
        stderr.contains("cannot write") && stderr.contains("closet."),
        "{stderr}"
    );
    // Neither a half result nor what was to become one.
    assert_eq!(std::fs::read_dir(out.join("trials")).unwrap().count(), 0);
    assert!(
        program(&out, &["--resume", "--quiet"])
            .status()
            .unwrap()
            .success()
    );
    assert_eq!(&results(&out), reference());
    std::fs::remove_dir_all(out).unwrap();
}

#[test]
fn shards_cover_the_list() {
    let out = folder("list");
    let list = program(&out, &["--list"]).output().unwrap();
    let names: Vec<String> = String::from_utf8(list.stdout)
        .unwrap()
        .lines()
        .map(str::to_owned)
        .collect();
    assert_eq!(names.len(), 6);
    assert!(
        program(&out, &["--shard", "3/6", "--quiet"])
            .status()
            .unwrap()
            .success()
    );
    let own: Vec<String> = results(&out).into_keys().collect();
    assert_eq!(own, [format!("{}.json", names[2])]);
    let collect = program(&out, &["--collect"]).output().unwrap();
    assert_eq!(collect.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&collect.stderr).contains(&names[0]));
    std::fs::remove_dir_all(out).unwrap();
}

#[test]
fn the_tables_of_the_paper_are_a_hundred_trials() {
    let suite = bench::suite("heats-tables", None).unwrap();
    let trials = suite.trials();
    assert_eq!(trials.len(), 100);
    for row in ["wg-nbvp", "aep", "heats-camera", "heats", "heats-plus"] {
        for scene in ["office", "maze"] {
            let name = format!("{scene}.{row}.seed10");
            assert!(trials.iter().any(|t| t.name == name), "{name}");
        }
    }
    // The suite that comes as an example is valid.
    let example = bench::suite("suites/closet.toml", None).unwrap();
    assert_eq!(example.trials().len(), 4);
    assert_eq!(
        bench::suite("heats-tables", Some(3))
            .unwrap()
            .trials()
            .len(),
        30
    );
}

#[test]
fn wrong_suites_are_refused_by_field() {
    let error = |text: &str| {
        let made = SuiteFile::from_toml(text).map_err(BenchError::from);
        let made = made.and_then(|file| HeatsTables::new(&file, None));
        match made.unwrap_err() {
            BenchError::Suite(error) => error,
            other => panic!("{other}"),
        }
    };
    let with = |from: &str, to: &str| error(&SUITE.replace(from, to));
    type Test = fn(&SuiteError) -> bool;
    let wrong: [(&str, &str, Test, &str); 13] = [
        (
            "\"aep\"",
            "\"magic\"",
            |e| matches!(e, SuiteError::Planner { .. }),
            "planners[1] = \"magic\"",
        ),
        (
            "\"closet\"",
            "\"atlantis\"",
            |e| matches!(e, SuiteError::Scene { .. }),
            "scenes[0] = \"atlantis\"",
        ),
        (
            "\"closet\"",
            "\"/nowhere/a.json\"",
            |e| matches!(e, SuiteError::Scene { .. }),
            "/nowhere/a.json",
        ),
        (
            "seeds = 2",
            "seeds = 0",
            |e| matches!(e, SuiteError::Empty { .. }),
            "seeds must name at least one seed",
        ),
        (
            "seeds = 2",
            "seeds = []",
            |e| matches!(e, SuiteError::Empty { .. }),
            "seeds",
        ),
        (
            "seeds = 2",
            "seeds = [3, 3]",
            |e| matches!(e, SuiteError::Twice { .. }),
            "3",
        ),
        (
            "seeds = 2",
            "seeds = -1",
            |e| matches!(e, SuiteError::Parse(_)),
            "seeds",
        ),
        (
            "seeds = 2",
            "",
            |e| matches!(e, SuiteError::Parse(_)),
            "seeds",
        ),
        (
            "seeds",
            "sseeds",
            |e| matches!(e, SuiteError::Parse(_)),
            "sseeds",
        ),
        (
            "\"aep\"",
            "\"aep/both\"",
            |e| matches!(e, SuiteError::Sensors { .. }),
            "aep/both",
        ),
        (
            "/camera",
            "/sonar",
            |e| matches!(e, SuiteError::Sensors { .. }),
            "sonar",
        ),
        (
            "\"aep\"",
            "\"wg-nbvp\"",
            |e| matches!(e, SuiteError::Twice { .. }),
            "wg-nbvp",
        ),
        (
            "time_limit = 17.0",
            "time_limit = -1.0",
            |e| matches!(e, SuiteError::Settings { .. }),
            "time_limit",
        ),
    ];
    for (from, to, is, word) in wrong {
        let error = with(from, to);
        assert!(
            is(&error) && error.to_string().contains(word),
            "{to}: {error:?} {error}"
        );
    }
    let set = format!("{SUITE}[set]\naep = [\"aep.decay=-1\"]\n");
    assert!(error(&set).to_string().contains("aep.decay"));
    let set = format!("{SUITE}[set]\nheats = [\"seed=1\"]\n");
    assert!(error(&set).to_string().contains("set.heats"));
    assert!(matches!(
        bench::suite("heats-tables", Some(0)),
        Err(BenchError::Suite(SuiteError::Empty { .. }))
    ));
    assert!(matches!(
        bench::suite("/nowhere/a.toml", None),
        Err(BenchError::Suite(SuiteError::Read { .. }))
    ));
}

#[test]
fn variants_are_rows_with_settings_of_their_own() {
    let text = "planners = [\"heats-plus\", \"heats-plus:straight\", \"heats-plus:straight/camera\"]\nscenes = [\"closet\"]\nseeds = 1\n\
        [set]\n\"heats-plus:straight\" = [\"views.on_the_way=false\"]\n";
    let names =
        |text: &str| -> Vec<String> { suite(text).trials().into_iter().map(|t| t.name).collect() };
    assert_eq!(
        names(text),
        [
            "closet.heats-plus.seed01",
            "closet.heats-plus-straight.seed01",
            "closet.heats-plus-straight-camera.seed01",
        ]
    );
    let error = |text: &str| match SuiteFile::from_toml(text)
        .map_err(BenchError::from)
        .and_then(|f| HeatsTables::new(&f, None))
    {
        Err(BenchError::Suite(error)) => error.to_string(),
        other => panic!("{other:?}"),
    };
    for (from, to, word) in [
        (
            "heats-plus:straight\" =",
            "heats-plus:bent\" =",
            "set.heats-plus:bent",
        ),
        (
            "heats-plus:straight/camera",
            "heats-plus:/camera",
            "small letters",
        ),
        (
            "heats-plus:straight/camera",
            "heats-plus:A b",
            "small letters",
        ),
        ("heats-plus:straight/camera", "magic:straight", "magic"),
        ("heats-plus:straight/camera", "heats-plus:straight", "twice"),
        (
            "views.on_the_way=false",
            "views.on_the_way=maybe",
            "on_the_way",
        ),
    ] {
        let error = error(&text.replace(from, to));
        assert!(error.contains(word), "{to}: {error}");
    }
}

/// Suites that come with the program name planners, scenes and settings that exist.
#[test]
fn suites_that_come_along_can_be_run() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("suites");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let suite = bench::suite(path.to_str().unwrap(), Some(1));
        assert!(!suite.unwrap().trials().is_empty(), "{}", path.display());
        seen += 1;
    }
    assert!(seen >= 3, "{seen} suites");
}
