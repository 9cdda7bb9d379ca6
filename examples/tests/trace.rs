//! `trace.mcap`: whole, readable by the format's own library, and, where they are installed, by three readers in Python.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stderr)]

use seekplan::heats::{self, Settings};
use seekplan::record::{Both, Event, JsonLines, Memory, Recorder, TRACE_FILE, rebuild};
use seekplan::scene::Scene;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;

fn recorded(name: &str) -> (PathBuf, Memory) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    let settings = Settings {
        seed: 1,
        time_limit: Some(12.0),
        ..Settings::default()
    };
    let scene = Scene::builtin("closet").unwrap();
    let mut recorder = Both(Memory::default(), JsonLines::new(&folder));
    let never = AtomicBool::new(false);
    heats::run_recorded(&scene, &settings, &never, &mut |_| {}, &mut recorder).unwrap();
    recorder.finish().unwrap();
    rebuild(&folder).unwrap();
    (folder, recorder.0)
}

#[test]
fn a_trace_holds_a_message_for_each_event() {
    let (folder, memory) = recorded("trace");
    let bytes = std::fs::read(folder.join(TRACE_FILE)).unwrap();
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut before = 0;
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!(schema.encoding, "ros2msg");
        assert!(schema.name.contains("/msg/"), "{}", schema.name);
        assert_eq!(message.channel.message_encoding, "cdr");
        assert_eq!(message.data[..4], [0, 1, 0, 0]);
        let number = counts.entry(message.channel.topic.clone()).or_default();
        assert_eq!(message.sequence as usize, *number);
        *number += 1;
        assert!(message.log_time >= before);
        before = message.log_time;
    }
    let events = |what: fn(&Event) -> bool| memory.entries.iter().filter(|e| what(&e.1)).count();
    for (topic, count) in [
        ("/tf", events(|e| matches!(e, Event::Pose(_)))),
        ("/joint_states", events(|e| matches!(e, Event::Pose(_)))),
        ("/voxels", events(|e| matches!(e, Event::Cells(_)))),
        ("/lidar", events(|e| matches!(e, Event::Scan(_)))),
        ("/plan", events(|e| matches!(e, Event::Plan(_)))),
        ("/horizon", events(|e| matches!(e, Event::Horizon(_)))),
        ("/frontiers", events(|e| matches!(e, Event::Frontiers(_)))),
        ("/viewpoints", events(|e| matches!(e, Event::Decision(_)))),
        ("/tags", 1 + events(|e| matches!(e, Event::Found(_)))),
        ("/explored", events(|e| matches!(e, Event::Progress(_)))),
    ] {
        assert_eq!(counts.get(topic).copied().unwrap_or(0), count, "{topic}");
        assert!(count > 0, "{topic} was never recorded");
    }
    // The index at the end is there, so that players can jump.
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let all: usize = counts.values().sum();
    assert_eq!(summary.stats.unwrap().message_count as usize, all);
    assert!(!folder.join(format!(".{TRACE_FILE}.partial")).exists());
}

#[test]
fn three_readers_find_what_was_recorded() {
    let (folder, _) = recorded("trace-readers");
    let python = std::env::var("SEEKPLAN_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tools/check_trace.py");
    let Ok(output) = Command::new(&python).arg(script).arg(&folder).output() else {
        eprintln!("SKIPPED: no {python} here, the trace was not read by other readers");
        return;
    };
    let text = String::from_utf8_lossy(&output.stdout);
    if output.status.code() == Some(3) {
        eprintln!("SKIPPED: {}", text.trim());
        return;
    }
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}{error}");
    assert_eq!(text.matches("what was recorded").count(), 3, "{text}");

    // The check can fail: a recording that says something else is found out.
    let path = folder.join("record.jsonl");
    let recording = std::fs::read_to_string(&path).unwrap();
    let changed = recording.replacen("\"joints\":[-", "\"joints\":[-1", 1);
    assert_ne!(recording, changed);
    std::fs::write(&path, changed).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tools/check_trace.py");
    let output = Command::new(&python)
        .arg(script)
        .arg(&folder)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(error.contains("/joint_states"), "{error}");
}
