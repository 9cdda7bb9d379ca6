//! Recordings: they change nothing, lose nothing, and open after any end.
#![allow(missing_docs, clippy::unwrap_used)]

use seekplan::flap::{self, FlapSettings};
use seekplan::heats::{self, Settings};
use seekplan::record::{
    Both, Entry, Event, GridShape, JsonLines, Memory, RECORD_FILE, ReadError, Recorder,
    ReportError, read, still,
};
use seekplan::scene::Scene;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// An empty folder of this test.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn entries(path: &Path) -> Result<Vec<Entry>, ReadError> {
    let mut all = Vec::new();
    read(path, &mut |entry| all.push(entry))?;
    Ok(all)
}

fn closet(seconds: f64) -> (Scene, Settings) {
    let settings = Settings {
        seed: 1,
        time_limit: Some(seconds),
        ..Settings::default()
    };
    (Scene::builtin("closet").unwrap(), settings)
}

fn recorded(seconds: f64, recorder: &mut dyn Recorder) -> heats::Run {
    let (scene, settings) = closet(seconds);
    let never = AtomicBool::new(false);
    heats::run_recorded(&scene, &settings, &never, &mut |_| {}, recorder).unwrap()
}

fn grid(entries: &[Entry]) -> GridShape {
    match &entries[0].1 {
        Event::Begin(begin) => begin.grid,
        other => panic!("begins with {other:?}"),
    }
}

#[test]
fn recording_changes_no_run() {
    let (scene, settings) = closet(30.0);
    let never = AtomicBool::new(false);
    let plain = heats::run(&scene, &settings, &never, &mut |_| {}).unwrap();
    let watched = recorded(30.0, &mut Memory::default());
    let text = |run: &heats::Run| serde_json::to_string(&run.result.reproducible()).unwrap();
    assert_eq!(text(&plain), text(&watched));
    assert_eq!(plain.trace, watched.trace);

    let scene = Scene::builtin("race").unwrap();
    let settings = FlapSettings {
        samples: 60,
        ..FlapSettings::default()
    };
    let plain = flap::run(&scene, &settings, &never, &mut |_| {}).unwrap();
    let mut memory = Memory::default();
    let watched = flap::run_recorded(&scene, &settings, &never, &mut |_| {}, &mut memory).unwrap();
    assert_eq!(plain.result.reproducible(), watched.result.reproducible());

    // Every look is there, with the cells it changed.
    let looks: Vec<_> = memory
        .entries
        .iter()
        .filter_map(|e| match &e.1 {
            Event::Look(look) => Some((look.view, look.probability)),
            _ => None,
        })
        .collect();
    let wanted: Vec<_> = plain
        .result
        .steps
        .iter()
        .map(|s| (s.view, s.probability))
        .collect();
    assert_eq!(looks, wanted);
    for pair in memory.entries.windows(2) {
        if let Event::Look(look) = &pair[1].1 {
            let Event::Cells(cells) = &pair[0].1 else {
                panic!("no cells before a look")
            };
            assert_eq!(cells.iter().count(), look.cells);
        }
    }
}

#[test]
fn what_is_written_is_what_happened() {
    let out = folder("record-whole");
    let mut recorder = Both(Memory::default(), JsonLines::new(&out));
    let run = recorded(40.0, &mut recorder);
    recorder.finish().unwrap();
    let all = recorder.0.entries;
    assert_eq!(entries(&out.join(RECORD_FILE)).unwrap(), all);

    for pair in all.windows(2) {
        assert!(pair[0].0 <= pair[1].0, "{} after {}", pair[1].0, pair[0].0);
    }
    assert!(matches!(&all[all.len() - 1].1, Event::End(how) if how == "time limit"));

    // Where the robot was, the views it reached, the tags it found, how far it came.
    let pick = |what: &dyn Fn(&Entry) -> bool| all.iter().filter(|e| what(e)).count();
    let poses = pick(&|e| matches!(e.1, Event::Pose(_)));
    assert_eq!(poses, run.trace.samples.len());
    let reached = pick(&|e| matches!(e.1, Event::Reached(_)));
    assert_eq!(reached, run.result.views_reached);
    let decisions = pick(&|e| matches!(e.1, Event::Decision(_)));
    assert_eq!(decisions, run.result.decisions);
    let found: Vec<u32> = all
        .iter()
        .filter_map(|e| match &e.1 {
            Event::Found(tag) => Some(tag.id),
            _ => None,
        })
        .collect();
    let wanted: Vec<u32> = run.result.targets_found.iter().map(|t| t.id).collect();
    assert_eq!(found, wanted);
    assert!(!found.is_empty(), "a tag is found in the first 40 s");

    // The cells add up to the map that the run ended with, seen from above.
    let grid = grid(&all);
    let mut cells = vec![0; grid.len()];
    let mut labels = vec![0; grid.size[0] * grid.size[1]];
    let mut live: BTreeSet<u64> = BTreeSet::new();
    for Entry(_, event) in &all {
        match event {
            Event::Cells(runs) => {
                for (index, value) in runs.iter() {
                    assert_ne!(cells[index as usize], value, "a cell that did not change");
                    cells[index as usize] = value;
                }
            }
            Event::Regions(regions) => {
                for (index, value) in regions.cells.iter() {
                    labels[index as usize] = value;
                }
            }
            Event::Frontiers(f) => {
                for id in &f.gone {
                    assert!(live.remove(id), "cluster {id} was never there");
                }
                live.extend(f.clusters.iter().map(|c| c.id));
                for cluster in &f.clusters {
                    assert!(cluster.cells().all(|i| (i as usize) < grid.len()));
                }
            }
            Event::Decision(d) => {
                assert_eq!(d.chosen.is_some(), d.outcome == "go");
                assert!(d.chosen.is_none_or(|c| c < d.candidates.len()));
            }
            _ => {}
        }
    }
    let map = run.trace.map.unwrap();
    let [nx, ny] = map.size;
    assert_eq!([nx, ny], [grid.size[0], grid.size[1]]);
    let column = |i: usize, state: u32| (0..grid.size[2]).any(|z| cells[i + nx * ny * z] == state);
    for (i, coverage) in map.coverage.iter().enumerate() {
        use seekplan::record::Coverage::{Free, Inspected, Occupied, Unknown};
        match coverage {
            Inspected => assert!(column(i, 4), "column {i}"),
            Occupied => assert!(column(i, 2) || column(i, 3), "column {i}"),
            Free => assert!(column(i, 1), "column {i}"),
            Unknown => {}
        }
    }
}

#[test]
fn a_recording_that_was_cut_off_opens_up_to_its_last_line() {
    let out = folder("record-cut");
    let mut recorder = JsonLines::new(&out);
    recorded(3.0, &mut recorder);
    recorder.finish().unwrap();
    let path = out.join(RECORD_FILE);
    let whole = entries(&path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let first = bytes.iter().position(|&b| b == b'\n').unwrap() + 1;
    let cut = out.join("cut.jsonl");
    let step = bytes.len() / 40;
    for end in (first..bytes.len()).step_by(step) {
        std::fs::write(&cut, &bytes[..end]).unwrap();
        let some = entries(&cut).unwrap();
        assert_eq!(some, whole[..some.len()]);
        let lines = bytes[..end].iter().filter(|&&b| b == b'\n').count();
        assert!(some.len() == lines || some.len() == lines + 1);
    }
    // Without its beginning it says so.
    std::fs::write(&cut, &bytes[..first / 2]).unwrap();
    assert!(matches!(entries(&cut), Err(ReadError::Begin { .. })));
    std::fs::write(&cut, &bytes[first..]).unwrap();
    assert!(matches!(entries(&cut), Err(ReadError::Begin { .. })));
    std::fs::write(&cut, "").unwrap();
    assert!(matches!(entries(&cut), Err(ReadError::Begin { .. })));
    // A line that is wrong, with more behind it.
    let mut wrong = bytes.clone();
    wrong.splice(first..first, b"[0.0,{\"pose\":3}]\n".iter().copied());
    std::fs::write(&cut, &wrong).unwrap();
    assert!(matches!(
        entries(&cut),
        Err(ReadError::Line { line: 2, .. })
    ));
    let absent = out.join("absent.jsonl");
    assert!(matches!(entries(&absent), Err(ReadError::File { .. })));
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_fails_the_recording_and_not_the_run() {
    let out = folder("record-full");
    std::os::unix::fs::symlink("/dev/full", out.join(RECORD_FILE)).unwrap();
    let mut recorder = JsonLines::new(&out);
    let run = recorded(3.0, &mut recorder);
    assert!(run.result.search_time_s >= 3.0 - 1e-9);
    let error = recorder.finish().unwrap_err();
    assert!(error.to_string().contains(RECORD_FILE), "{error}");
}

#[test]
fn stills_show_the_run_at_their_moment() {
    let out = folder("record-still");
    let mut recorder = JsonLines::new(&out);
    let run = recorded(30.0, &mut recorder);
    recorder.finish().unwrap();
    let first = run.result.targets_found[0].time_s;
    let count = |picture: &str| picture.matches(": not found").count();
    let last = still(&out, None).unwrap();
    assert_eq!(count(&last), 2 * (run.result.targets - run.result.found));
    let at = |time| still(&out, Some(time)).unwrap();
    let (before, after) = (at(0.0), at(first + 0.3));
    // Each label is drawn twice, once as its own outline.
    assert_eq!(count(&before), 2 * run.result.targets);
    assert!(count(&after) < count(&before));
    assert!(after.contains(&format!("1 of {} tags after", run.result.targets)));
    for picture in [&before, &after, &last] {
        assert!(picture.starts_with("<svg") && picture.ends_with("</svg>\n"));
    }

    let scene = Scene::builtin("race").unwrap();
    let settings = FlapSettings {
        samples: 40,
        ..FlapSettings::default()
    };
    let mut recorder = JsonLines::new(&out);
    let never = AtomicBool::new(false);
    let outcome =
        flap::run_recorded(&scene, &settings, &never, &mut |_| {}, &mut recorder).unwrap();
    recorder.finish().unwrap();
    let steps = &outcome.result.steps;
    assert!(steps.len() > 2);
    let looks = |picture: &str| picture.matches(r#"r="10""#).count();
    let whole = still(&out, None).unwrap();
    assert_eq!(looks(&whole), steps.len());
    let expected = outcome.result.expected_time_s;
    assert!(whole.contains(&format!("expected time so far {expected:.1} s")));
    // A look counts from the moment it was taken.
    assert_eq!(looks(&still(&out, Some(0.0)).unwrap()), 0);
    let second = still(&out, Some(steps[1].time_s + 0.01)).unwrap();
    assert_eq!(looks(&second), 2);
    let success = 100.0 * steps[1].probability;
    assert!(second.contains(&format!("2 sensing actions, success {success:.1} %")));
    assert!(second.starts_with("<svg") && second.ends_with("</svg>\n"));

    // Of what nobody knows there is no picture.
    let recording = out.join("record.jsonl");
    let text = std::fs::read_to_string(&recording).unwrap();
    let other = text.replacen(r#""system":"flap""#, r#""system":"other""#, 1);
    std::fs::write(&recording, other).unwrap();
    assert!(matches!(
        still(&out, None),
        Err(ReportError::NoStill { system }) if system == "other"
    ));
}
