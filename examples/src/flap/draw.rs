//! `topdown.svg` of a FLAP search: the views in the order taken, and the cumulative probability of success over time.

use super::search::Outcome;
use crate::record::{Ground, VolumeShape, escaped};
use crate::scene::TargetVolume;
use std::fmt::Write;
use viewsample::flap::FanPose;

/// Pixels of a metre.
const SCALE: f64 = 64.0;
const BORDER: f64 = 24.0;
/// Height and width of the curve's panel.
const PANEL: f64 = 300.0;
const GAP: f64 = 56.0;
/// Height of the text under all.
const LEGEND: f64 = 72.0;

/// What a picture shows besides the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Picture {
    /// x and y, m, and heading, rad, of all views sampled at first.
    pub(crate) sampled: Vec<[f64; 3]>,
    /// The same of the looks, in order.
    pub(crate) looks: Vec<[f64; 3]>,
    /// Base positions of the looks, the start first, m.
    pub(crate) way: Vec<[f64; 2]>,
    /// Time, s, and probability of success after each look.
    pub(crate) success: Vec<[f64; 2]>,
    /// Expected time until the target is seen or the search ends, s.
    pub(crate) expected_time: f64,
    /// Time of the search, s.
    pub(crate) end: f64,
    /// The line below it.
    pub(crate) caption: String,
}

/// Draws a search.
pub fn draw(ground: &Ground, volumes: &[TargetVolume], outcome: &Outcome) -> String {
    let result = &outcome.result;
    let volumes: Vec<VolumeShape> = volumes
        .iter()
        .map(|v| VolumeShape {
            name: v.name.clone(),
            low: v.min,
            high: v.max,
            probability: v.p,
        })
        .collect();
    let place = |pose: &FanPose| [pose.position[0], pose.position[1], pose.yaw];
    let picture = Picture {
        sampled: outcome.sampled.iter().map(place).collect(),
        looks: outcome.poses.iter().map(place).collect(),
        way: outcome.way.clone(),
        success: result
            .steps
            .iter()
            .map(|s| [s.time_s, s.probability])
            .collect(),
        expected_time: result.expected_time_s,
        end: result.execution_time_s,
        caption: format!(
            "{} planner, {} map, {}, seed {}: expected time {:.1} s, {} sensing actions, success {:.1} %",
            result.planner,
            result.map,
            result.mode,
            result.seed,
            result.expected_time_s,
            result.sensing_actions,
            100.0 * result.probability
        ),
    };
    draw_picture(ground, &volumes, &picture)
}

/// Draws a search, or what of it was done up to a moment.
pub(crate) fn draw_picture(ground: &Ground, volumes: &[VolumeShape], picture: &Picture) -> String {
    let span = [0, 1].map(|a| (ground.high[a] - ground.low[a]) * SCALE);
    let width = (span[0] + 2.0 * BORDER).max(720.0);
    let height = span[1] + PANEL + GAP + LEGEND + 2.0 * BORDER;
    let x = |v: f64| BORDER + (v - ground.low[0]) * SCALE;
    let y = |v: f64| BORDER + span[1] - (v - ground.low[1]) * SCALE;
    let mut svg = String::new();
    let _ = writeln!(
        svg,
        r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0} {height:.0}" width="{width:.0}" height="{height:.0}" font-family="sans-serif">
<rect width="100%" height="100%" fill="#ffffff"/>
<rect x="{BORDER}" y="{BORDER}" width="{:.1}" height="{:.1}" fill="#f8fafc" stroke="#cbd5e1"/>"##,
        span[0], span[1]
    );
    for outline in &ground.outlines {
        let mut points = String::new();
        for p in &outline.corners {
            let _ = write!(points, "{:.1},{:.1} ", x(p[0]), y(p[1]));
        }
        let (fill, opacity) = if outline.band.1 > 2.0 {
            ("#1f2937", 0.95)
        } else {
            ("#92734d", 0.35)
        };
        let _ = writeln!(
            svg,
            r##"<polygon points="{}" fill="{fill}" fill-opacity="{opacity}" stroke="#1f2937" stroke-width="0.6"/>"##,
            points.trim_end()
        );
    }
    for volume in volumes {
        let (low, high) = (volume.low, volume.high);
        let _ = writeln!(
            svg,
            r##"<rect x="{:.1}" y="{:.1}" width="{:.1}" height="{:.1}" fill="#ef4444" fill-opacity="0.15" stroke="#dc2626" stroke-width="1.5"><title>{} P = {}</title></rect>"##,
            x(low[0]),
            y(high[1]),
            (high[0] - low[0]) * SCALE,
            (high[1] - low[1]) * SCALE,
            escaped(&volume.name),
            volume.probability
        );
    }
    views(&mut svg, picture, &x, &y);
    let top = BORDER + span[1] + GAP;
    curve(
        &mut svg,
        picture,
        [BORDER + 44.0, top],
        [width - 2.0 * BORDER - 60.0, PANEL - 40.0],
    );
    let _ = writeln!(
        svg,
        r##"<text x="{BORDER}" y="{:.0}" font-size="15">{}</text>
<text x="{BORDER}" y="{:.0}" font-size="12" fill="#475569">above: sampled views (grey), views taken in order (blue), base moves drawn straight, volumes (red);</text>
<text x="{BORDER}" y="{:.0}" font-size="12" fill="#475569">below: probability of success over time, dashed the expected time</text>
</svg>"##,
        height - LEGEND + 16.0,
        escaped(&picture.caption),
        height - LEGEND + 38.0,
        height - LEGEND + 55.0,
    );
    svg
}

fn views(svg: &mut String, picture: &Picture, x: &dyn Fn(f64) -> f64, y: &dyn Fn(f64) -> f64) {
    for &[px, py, yaw] in &picture.sampled {
        let (s, c) = yaw.sin_cos();
        let _ = writeln!(
            svg,
            r##"<path d="M{:.1} {:.1}L{:.1} {:.1}" stroke="#94a3b8" stroke-opacity="0.6"/>"##,
            x(px),
            y(py),
            x(px + 0.15 * c),
            y(py + 0.15 * s)
        );
    }
    let mut way = String::new();
    for p in &picture.way {
        let _ = write!(way, "{:.1},{:.1} ", x(p[0]), y(p[1]));
    }
    let _ = writeln!(
        svg,
        r##"<polyline points="{}" fill="none" stroke="#2563eb" stroke-opacity="0.55" stroke-width="2" stroke-dasharray="6 4"/>"##,
        way.trim_end()
    );
    if let Some(start) = picture.way.first() {
        let _ = writeln!(
            svg,
            r##"<circle cx="{:.1}" cy="{:.1}" r="8" fill="#16a34a"/><text x="{:.1}" y="{:.1}" font-size="13" fill="#166534">start</text>"##,
            x(start[0]),
            y(start[1]),
            x(start[0]) + 11.0,
            y(start[1]) + 5.0
        );
    }
    for (order, &[px, py, yaw]) in picture.looks.iter().enumerate() {
        // A wedge of the horizontal field of view.
        let corner = |turn: f64| {
            let (s, c) = (yaw + turn).sin_cos();
            format!("{:.1} {:.1}", x(px + 0.9 * c), y(py + 0.9 * s))
        };
        let _ = writeln!(
            svg,
            r##"<path d="M{:.1} {:.1}L{}L{}Z" fill="#3b82f6" fill-opacity="0.14" stroke="#3b82f6" stroke-width="0.7"/>
<circle cx="{:.1}" cy="{:.1}" r="10" fill="#1d4ed8"/><text x="{:.1}" y="{:.1}" font-size="12" fill="#ffffff" text-anchor="middle">{}</text>"##,
            x(px),
            y(py),
            corner(0.5),
            corner(-0.5),
            x(px),
            y(py),
            x(px),
            y(py) + 4.0,
            order + 1
        );
    }
}

/// The curve of the paper's Fig. 5: time runs to the right while the robot moves, probability steps up when it looks.
fn curve(svg: &mut String, picture: &Picture, at: [f64; 2], size: [f64; 2]) {
    let end = picture.end.max(picture.expected_time).max(1.0);
    let most = picture.success.last().map_or(0.0, |s| s[1]).max(0.05) * 1.08;
    let x = |t: f64| at[0] + t / end * size[0];
    let y = |p: f64| at[1] + size[1] - p / most * size[1];
    let _ = writeln!(
        svg,
        r##"<rect x="{:.1}" y="{:.1}" width="{:.1}" height="{:.1}" fill="#f8fafc" stroke="#cbd5e1"/>"##,
        at[0], at[1], size[0], size[1]
    );
    let step = nice(end / 8.0);
    let mut t = 0.0;
    while t <= end {
        let _ = writeln!(
            svg,
            r##"<path d="M{0:.1} {1:.1}v5" stroke="#475569"/><text x="{0:.1}" y="{2:.1}" font-size="12" text-anchor="middle" fill="#475569">{t:.0} s</text>"##,
            x(t),
            at[1] + size[1],
            at[1] + size[1] + 19.0
        );
        t += step;
    }
    let step = nice(most / 5.0);
    let mut p = 0.0;
    while p <= most {
        let _ = writeln!(
            svg,
            r##"<path d="M{0:.1} {1:.1}h{2:.1}" stroke="#e2e8f0"/><text x="{3:.1}" y="{4:.1}" font-size="12" text-anchor="end" fill="#475569">{5:.0} %</text>"##,
            at[0],
            y(p),
            size[0],
            at[0] - 6.0,
            y(p) + 4.0,
            100.0 * p
        );
        p += step;
    }
    let mut path = format!("M{:.1} {:.1}", x(0.0), y(0.0));
    for &[time, probability] in &picture.success {
        let _ = write!(path, "H{:.1}V{:.1}", x(time), y(probability));
    }
    let _ = writeln!(
        svg,
        r##"<path d="{path}" fill="none" stroke="#1d4ed8" stroke-width="2"/>
<path d="M{0:.1} {1:.1}v{2:.1}" stroke="#dc2626" stroke-width="1.5" stroke-dasharray="6 4"/>
<text x="{3:.1}" y="{4:.1}" font-size="12" fill="#dc2626">expected {5:.1} s</text>"##,
        x(picture.expected_time),
        at[1],
        size[1],
        x(picture.expected_time) + 6.0,
        at[1] + size[1] - 8.0,
        picture.expected_time
    );
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `v`.
fn nice(v: f64) -> f64 {
    let ten = 10f64.powf(v.max(1e-9).log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|f| f * ten)
        .find(|f| *f >= v * (1.0 - 1e-9))
        .unwrap_or(10.0 * ten)
}
