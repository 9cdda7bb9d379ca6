//! The reports in a real browser: they draw, follow the slider and the layers, and complain of nothing.
//! Skipped where chromedriver (Debian: `apt-get install chromium chromium-driver`) is not installed.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::print_stderr,
    clippy::disallowed_methods
)]

mod bench_support;
mod browser_support;

use browser_support::Browser;
use seekplan::flap::{self, FlapSettings};
use seekplan::heats::{self, Settings};
use seekplan::record::{self, JsonLines, REPORT_FILE, Recorder};
use seekplan::scene::Scene;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

fn browser() -> Option<Browser> {
    let started = Browser::start(1280, 800);
    if started.is_none() {
        eprintln!("SKIPPED: no chromedriver with a Chromium here, the report was not looked at");
    }
    started
}

fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    path
}

/// Pixels of the map whose r, g and b fulfil a condition.
fn pixels(browser: &Browser, condition: &str) -> f64 {
    browser.number(&format!(
        "const c = document.getElementById('map'), d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
         let n = 0;
         for (let i = 0; i < d.length; i += 4) {{ const [r, g, b] = d.slice(i, i + 3); if ({condition}) n++; }}
         return n;"
    ))
}

/// Waits until what was clicked is drawn.
fn drawn(browser: &Browser) {
    browser.run("return new Promise((r) => requestAnimationFrame(() => requestAnimationFrame(() => r(true))))");
}

const SHOWN: &str = "return Number(document.body.dataset.time)";

fn wait_for(browser: &Browser, time: f64) {
    browser.wait(&format!(
        "return Math.abs(Number(document.body.dataset.time) - {time}) < 0.006"
    ));
}

#[test]
fn a_report_of_heats_follows_slider_and_layers() {
    let Some(browser) = browser() else { return };
    let out = folder("browser-heats");
    let settings = Settings {
        seed: 1,
        time_limit: Some(26.0),
        ..Settings::default()
    };
    let scene = Scene::builtin("closet").unwrap();
    let mut recorder = JsonLines::new(&out);
    let never = AtomicBool::new(false);
    let run = heats::run_recorded(&scene, &settings, &never, &mut |_| {}, &mut recorder).unwrap();
    recorder.finish().unwrap();
    let ground = record::Ground::of(&scene);
    record::write(&out, &run.result, &ground, &run.trace).unwrap();
    record::rebuild(&out).unwrap();
    browser.open(&out.join(REPORT_FILE));

    // It opens at the end, with the figures of the run.
    wait_for(&browser, run.result.search_time_s);
    let text = |id: &str| {
        let value = browser.run(&format!("return document.getElementById('{id}').innerText"));
        value.as_str().unwrap().to_owned()
    };
    let found = run.result.found;
    assert!(found > 0, "a tag is found in the first 26 s");
    assert!(text("title").contains("closet"));
    assert!(text("summary").contains(&format!("{found} of 3 tags")));
    assert!(text("readout").contains(&format!("tags {found} of 3")));
    let below = text("below");
    assert!(below.contains(&format!("{:.1} m", run.result.base_path_m)));
    assert!(below.contains("mpc"), "{below}");
    assert!(
        browser
            .run("return document.querySelector('#below pre').textContent")
            .as_str()
            .unwrap()
            .contains(&run.result.settings)
    );

    // Found tags are green on the map at the end, and not at the beginning.
    let green = "r < 40 && g > 140 && g < 180 && b < 90";
    let late = pixels(&browser, green);
    assert!(late > 60.0, "{late} green pixels");
    browser.type_into("#time", "\u{e011}"); // Home
    wait_for(&browser, 0.0);
    let first = run.result.targets_found[0].time_s;
    assert!(first > 0.0);
    assert!(pixels(&browser, green) < late);
    assert!(text("readout").contains("tags 0 of 3"));

    // Keys: one second, ten with shift, the next decision.
    browser.type_into("#time", "\u{e014}\u{e014}"); // twice to the right
    wait_for(&browser, 2.0);
    browser.type_into("#time", "\u{e008}\u{e014}"); // shift
    wait_for(&browser, 12.0);
    browser.type_into("body", "n");
    browser.wait("return Number(document.body.dataset.time) > 12.01");
    assert!(text("clock").contains("of 26.0 s"), "{}", text("clock"));

    // The slider itself.
    browser.run("const s = document.getElementById('time'); s.value = 20; s.dispatchEvent(new Event('input'));");
    wait_for(&browser, 20.0);

    // A layer that goes takes its colour with it, and brings it back.
    let blue = "b > 150 && b > r + 80 && b > g + 60";
    browser.click("[data-layer=frustum]");
    browser.click("[data-layer=chosen]");
    drawn(&browser);
    let with = pixels(&browser, blue);
    assert!(with > 500.0, "{with} pixels of inspection frontier");
    browser.click("[data-layer=inspect]");
    drawn(&browser);
    let without = pixels(&browser, blue);
    assert!(without < 0.2 * with, "{without} of {with} pixels are left");
    browser.click("[data-layer=inspect]");
    drawn(&browser);
    assert_eq!(pixels(&browser, blue), with);

    // Every canvas has something on it.
    for canvas in ["map", "arm", "plot", "second", "marks"] {
        let colors = browser.number(&format!(
            "const c = document.getElementById('{canvas}'), d = new Uint32Array(c.getContext('2d').getImageData(0, 0, c.width, c.height).data.buffer);
             return new Set(d).size"
        ));
        assert!(colors > 3.0, "{canvas} has {colors} colours");
    }

    // It plays.
    browser.click("#play");
    browser.wait("return Number(document.body.dataset.time) > 20.5");
    browser.type_into("body", " ");
    browser.wait("return document.getElementById('play').getAttribute('aria-label') === 'Play'");

    // A phone: nothing hangs over the side.
    browser.resize(390, 844);
    browser.wait("return innerWidth < 520");
    let over = browser.number(
        "return document.scrollingElement.scrollWidth - document.documentElement.clientWidth",
    );
    assert_eq!(over, 0.0);

    // No network, and not a word in the console.
    assert_eq!(
        browser.number("return performance.getEntriesByType('resource').length"),
        0.0
    );
    assert!(browser.number(SHOWN) > 0.0);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
fn a_report_of_flap_shows_every_look() {
    let Some(browser) = browser() else { return };
    let out = folder("browser-flap");
    let settings = FlapSettings {
        samples: 60,
        ..FlapSettings::default()
    };
    let scene = Scene::builtin("race").unwrap();
    let mut recorder = JsonLines::new(&out);
    let never = AtomicBool::new(false);
    let outcome =
        flap::run_recorded(&scene, &settings, &never, &mut |_| {}, &mut recorder).unwrap();
    recorder.finish().unwrap();
    flap::write(
        &out,
        &outcome,
        &record::Ground::of(&scene),
        &scene.target_volumes,
    )
    .unwrap();
    record::rebuild(&out).unwrap();
    browser.open(&out.join(REPORT_FILE));
    let steps = &outcome.result.steps;
    browser.wait("return document.body.dataset.time !== undefined");
    let rows = browser.number("return document.querySelectorAll('tr[data-time]').length");
    assert_eq!(rows, steps.len() as f64);
    // A row leads to its look.
    browser.click("tr[data-time]");
    wait_for(&browser, (steps[0].time_s * 100.0).round() / 100.0);
    let readout = browser.run("return document.getElementById('readout').textContent");
    let wanted = format!(
        "look 1 of {} · success {:.1} %",
        steps.len(),
        100.0 * steps[0].probability
    );
    assert!(
        readout.as_str().unwrap().starts_with(&wanted),
        "{readout} and not {wanted}"
    );
    // What looks saw is green, and goes with its layer.
    browser.type_into("body", "\u{e010}"); // End
    browser.click("[data-layer=volumes]");
    drawn(&browser);
    let green = "g > r + 25 && g > b + 25";
    let seen = pixels(&browser, green);
    browser.click("[data-layer=seen]");
    drawn(&browser);
    let left = pixels(&browser, green);
    assert!(seen > 100.0 && left < 0.7 * seen, "{left} of {seen}");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
fn the_page_of_a_campaign_leads_to_its_trials() {
    let Some(browser) = browser() else { return };
    let out = folder("browser-bench");
    bench_support::campaign(&out);
    let page = out.join(REPORT_FILE);
    browser.open(&page);
    let count = |what: &str| {
        browser.number(&format!(
            "return document.querySelectorAll('{what}').length"
        ))
    };
    // Eight planners on the known map, twice, and ten with walls alone; ratios of all but greedy.
    let planners = 8.0 + 8.0 + 10.0;
    let seeds = bench_support::SEEDS as f64;
    assert_eq!(count("h2"), 3.0);
    assert_eq!(count("svg rect"), planners + planners - 3.0);
    assert_eq!(count("svg circle"), seeds * (planners + planners - 3.0));
    assert_eq!(count("details td a"), seeds * planners);
    // Names, medians and boxes do not run into each other, nor the labels of an axis, and nothing leaves its plot.
    const CLASHES: &str = "let bad = 0;
         for (const svg of document.querySelectorAll('svg')) {
           const edge = svg.getBoundingClientRect();
           const names = [...svg.querySelectorAll('text[paint-order]')].map((t) => t.getBoundingClientRect());
           for (let k = 0; k < names.length; k += 2) if (names[k].right > names[k + 1].left) bad++;
           const drawn = [...svg.querySelectorAll('circle, rect')].map((e) => e.getBoundingClientRect());
           for (const n of names) for (const d of drawn)
             if (n.left < d.right && d.left < n.right && n.top < d.bottom && d.top < n.bottom) bad++;
           const ticks = [...svg.querySelectorAll('text[text-anchor=middle]')].map((t) => t.getBoundingClientRect());
           for (let k = 1; k < ticks.length; k++) if (ticks[k - 1].right > ticks[k].left) bad++;
           for (const e of svg.querySelectorAll('text, circle, rect')) {
             const r = e.getBoundingClientRect();
             if (r.left < edge.left || r.right > edge.right || r.top < edge.top - 1 || r.bottom > edge.bottom + 1) bad++;
           }
         }
         return bad";
    assert_eq!(browser.number(CLASHES), 0.0);
    // A phone: what is too wide scrolls within its frame.
    browser.resize(390, 844);
    browser.wait("return innerWidth < 520");
    // Its letters are larger.
    assert_eq!(browser.number(CLASHES), 0.0);
    let over = browser.number(
        "return document.scrollingElement.scrollWidth - document.documentElement.clientWidth",
    );
    assert_eq!(over, 0.0);
    assert_eq!(
        browser.number("return performance.getEntriesByType('resource').length"),
        0.0
    );
    // A trial's value opens its result.
    browser.click("summary");
    browser.click("details td a");
    browser.wait("return location.href.endsWith('/trials/offline-known.greedy.seed01.json')");
    assert!(
        browser
            .run("return document.body.innerText")
            .as_str()
            .unwrap()
            .contains("expected_time_s")
    );
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
