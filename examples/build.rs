//! Tells the program which compiler built it, and of which sources: campaigns do not mix results of several.

use std::path::{Path, PathBuf};

/// The crates that make a result, and what the program embeds.
const SOURCES: [&str; 12] = [
    "../atsp/src",
    "../ddp-rbf/src",
    "../frontier/src",
    "../hybrid-astar/src",
    "../objsearch/src",
    "../robots/src",
    "../strrt/src",
    "../viewsample/src",
    "../voxmap/src",
    "presets",
    "src",
    "../Cargo.lock",
];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=RUSTC");
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let version = std::process::Command::new(rustc)
        .arg("--version")
        .output()
        .map(|o| String::from_utf8_lossy(&o.stdout).trim().to_owned())
        .unwrap_or_default();
    println!("cargo:rustc-env=SEEKPLAN_RUSTC={version}");
    let mut files = Vec::new();
    // What is not there, as in a package without its workspace, is another version of itself anyway.
    for source in SOURCES.map(Path::new).into_iter().filter(|p| p.exists()) {
        println!("cargo:rerun-if-changed={}", source.display());
        collect(source, &mut files);
    }
    files.sort();
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for file in &files {
        let name = file.to_string_lossy().replace('\\', "/");
        let text = std::fs::read(file).unwrap_or_default();
        // Line ends are the checkout's.
        let text = text.into_iter().filter(|&byte| byte != b'\r');
        for byte in name.bytes().chain([0]).chain(text).chain([0]) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
    }
    println!("cargo:rustc-env=SEEKPLAN_SOURCES=fnv1a64-{hash:016x}");
}

/// All files at or below a path.
fn collect(path: &Path, files: &mut Vec<PathBuf>) {
    match std::fs::read_dir(path) {
        Ok(entries) => {
            for entry in entries.flatten() {
                collect(&entry.path(), files);
            }
        }
        Err(_) => files.push(path.to_owned()),
    }
}
