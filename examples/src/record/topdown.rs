//! `topdown.svg`: one picture of a run, drawn without any dependency.

use super::result::{RunResult, TargetFound};
use super::trace::{Coverage, Trace};
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// A solid seen from above: a closed outline and its height band.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outline {
    /// Corners in world x, y, m.
    pub corners: Vec<[f64; 2]>,
    /// Lowest and highest point above the floor, m.
    pub band: (f64, f64),
}

/// A tag to draw.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mark {
    /// The tag's number.
    pub id: u32,
    /// Its centre in the world frame, m.
    pub center: [f64; 3],
}

/// What of the scene a picture shows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ground {
    /// Lower corner of the task volume, x and y, m.
    pub low: [f64; 2],
    /// Upper corner of the task volume, x and y, m.
    pub high: [f64; 2],
    /// Walls and furniture.
    pub outlines: Vec<Outline>,
    /// All tags.
    pub tags: Vec<Mark>,
}

impl Ground {
    /// What a picture shows of a scene.
    pub fn of(scene: &crate::scene::Scene) -> Self {
        let (low, high) = (scene.bounds.min, scene.bounds.max);
        Self {
            low: [low[0], low[1]],
            high: [high[0], high[1]],
            outlines: scene
                .outlines()
                .into_iter()
                .map(|o| Outline {
                    corners: o.corners,
                    band: o.band,
                })
                .collect(),
            tags: scene
                .tags
                .iter()
                .map(|t| Mark {
                    id: t.id,
                    center: t.center,
                })
                .collect(),
        }
    }
}

/// Pixels of a metre: at least, and in small rooms.
const SCALE: (f64, f64) = (40.0, 120.0);
const BORDER: f64 = 20.0;
const LEGEND: f64 = 84.0;
const LEGEND_WIDTH: f64 = 980.0;

/// Region fills, light enough to lie under everything else.
const REGION_FILLS: [&str; 10] = [
    "#dbeafe", "#dcfce7", "#fef3c7", "#fce7f3", "#ede9fe", "#cffafe", "#ffedd5", "#e2e8f0",
    "#ecfccb", "#fee2e2",
];

/// Draws the run: walls and furniture, coverage, regions, base path coloured by time, camera positions of reached
/// views, and the tags with their time of detection or as missed.
pub fn draw(ground: &Ground, trace: &Trace, result: &RunResult) -> String {
    let caption = format!(
        "{} · {} · {} sensors · seed {}: {} of {} tags, {} after {:.0} s, path {:.0} m, joints {:.0} rad, {} collisions",
        result.scene,
        result.planner,
        result.sensors,
        result.seed,
        result.found,
        result.targets,
        result.ended,
        result.search_time_s,
        result.base_path_m,
        result.joint_rotation_rad,
        result.collisions
    );
    draw_moment(
        ground,
        trace,
        &result.targets_found,
        result.search_time_s,
        &caption,
    )
}

/// The same of a run up to `end`, s, with the tags found by then and a line of text.
pub(super) fn draw_moment(
    ground: &Ground,
    trace: &Trace,
    found: &[TargetFound],
    end: f64,
    caption: &str,
) -> String {
    let extent = [0, 1].map(|a| ground.high[a] - ground.low[a]);
    // The legend needs this much even under a small room.
    let scale = ((LEGEND_WIDTH - 2.0 * BORDER) / extent[0].max(1.6 * extent[1]).max(1e-3))
        .clamp(SCALE.0, SCALE.1);
    let width = (extent[0] * scale + 2.0 * BORDER).max(LEGEND_WIDTH);
    let plan_height = extent[1] * scale;
    let height = plan_height + 2.0 * BORDER + LEGEND;
    let x = |v: f64| BORDER + (v - ground.low[0]) * scale;
    let y = |v: f64| BORDER + plan_height - (v - ground.low[1]) * scale;
    let mut svg = String::new();
    let _ = writeln!(
        svg,
        r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0} {height:.0}" width="{width:.0}" height="{height:.0}" font-family="sans-serif">
<rect width="100%" height="100%" fill="#ffffff"/>
<rect x="{BORDER}" y="{BORDER}" width="{:.1}" height="{plan_height:.1}" fill="#9ca3af"/>"##,
        extent[0] * scale
    );
    coverage(&mut svg, trace, &x, &y);
    for outline in &ground.outlines {
        let tall = outline.band.1 > 2.0;
        let mut points = String::new();
        for p in &outline.corners {
            let _ = write!(points, "{:.1},{:.1} ", x(p[0]), y(p[1]));
        }
        let (fill, opacity) = if tall {
            ("#1f2937", 0.95)
        } else {
            ("#92734d", 0.30)
        };
        let _ = writeln!(
            svg,
            r##"<polygon points="{}" fill="{fill}" fill-opacity="{opacity}" stroke="#1f2937" stroke-width="0.8"/>"##,
            points.trim_end()
        );
    }
    for outline in &trace.intruders {
        let points: Vec<String> = outline
            .corners
            .iter()
            .map(|p| format!("{:.1},{:.1}", x(p[0]), y(p[1])))
            .collect();
        let _ = writeln!(
            svg,
            r##"<polygon points="{}" fill="#f97316" fill-opacity="0.6" stroke="#c2410c" stroke-width="1.5" stroke-dasharray="4 2"/>"##,
            points.join(" ")
        );
    }
    way(&mut svg, trace, end, &x, &y);
    tags(&mut svg, ground, found, &x, &y);
    legend(&mut svg, caption, end, plan_height + 2.0 * BORDER, width);
    svg.push_str("</svg>\n");
    svg
}

/// Runs of equal cells along x as one rectangle each, so that the file stays small.
fn coverage(svg: &mut String, trace: &Trace, x: &dyn Fn(f64) -> f64, y: &dyn Fn(f64) -> f64) {
    let Some(map) = &trace.map else { return };
    let [nx, ny] = map.size;
    let fill = |i: usize| -> Option<&'static str> {
        match map.coverage[i] {
            Coverage::Unknown => None,
            Coverage::Free => Some(match map.regions[i] {
                Some(label) => REGION_FILLS[label as usize % REGION_FILLS.len()],
                None => "#ffffff",
            }),
            Coverage::Occupied => Some("#ef4444"),
            Coverage::Inspected => Some("#4b5563"),
        }
    };
    for row in 0..ny {
        let mut column = 0;
        while column < nx {
            let color = fill(row * nx + column);
            let start = column;
            while column < nx && fill(row * nx + column) == color {
                column += 1;
            }
            if let Some(color) = color {
                let left = map.low[0] + start as f64 * map.cell_size;
                let top = map.low[1] + (row + 1) as f64 * map.cell_size;
                let _ = writeln!(
                    svg,
                    r#"<rect x="{:.1}" y="{:.1}" width="{:.1}" height="{:.1}" fill="{color}" shape-rendering="crispEdges"/>"#,
                    x(left),
                    y(top),
                    x((column - start) as f64 * map.cell_size) - x(0.0),
                    x(map.cell_size) - x(0.0)
                );
            }
        }
    }
}

/// Blue at the start, over green and yellow, to red at the end.
fn time_color(share: f64) -> String {
    // Hue 240 to 0 degrees at saturation 0.85, lightness 0.42, written out: not every viewer knows hsl().
    let hue = 4.0 * (1.0 - share.clamp(0.0, 1.0));
    let channel = |offset: f64| {
        let k = (offset + 2.0 * hue) % 12.0;
        let level = 0.42 - 0.85 * 0.42 * (k - 3.0).min(9.0 - k).clamp(-1.0, 1.0);
        (255.0 * level).round() as u8
    };
    format!(
        "#{:02x}{:02x}{:02x}",
        channel(0.0),
        channel(8.0),
        channel(4.0)
    )
}

fn way(svg: &mut String, trace: &Trace, end: f64, x: &dyn Fn(f64) -> f64, y: &dyn Fn(f64) -> f64) {
    for stop in &trace.stops {
        let [cx, cy, _] = stop.camera;
        let (tip_x, tip_y) = (cx + 0.35 * stop.axis[0], cy + 0.35 * stop.axis[1]);
        let _ = writeln!(
            svg,
            r##"<path d="M{:.1} {:.1}L{:.1} {:.1}" stroke="#7c3aed" stroke-width="1.2"/><circle cx="{:.1}" cy="{:.1}" r="2.6" fill="#7c3aed"/>"##,
            x(cx),
            y(cy),
            x(tip_x),
            y(tip_y),
            x(cx),
            y(cy)
        );
    }
    // One polyline per hundredth of the run keeps the colours smooth and the file small.
    let pieces = 100;
    let mut first = 0;
    for piece in 0..pieces {
        let until = end * f64::from(piece + 1) / f64::from(pieces);
        let mut last = first;
        while last + 1 < trace.samples.len() && trace.samples[last].time < until {
            last += 1;
        }
        if last > first {
            let mut points = String::new();
            let mut previous = [f64::NAN; 2];
            for sample in &trace.samples[first..=last] {
                let p = [sample.base[0], sample.base[1]];
                if (p[0] - previous[0]).hypot(p[1] - previous[1]) < 0.02 {
                    continue;
                }
                previous = p;
                let _ = write!(points, "{:.1},{:.1} ", x(p[0]), y(p[1]));
            }
            let _ = writeln!(
                svg,
                r#"<polyline points="{}" fill="none" stroke="{}" stroke-width="2.2" stroke-linejoin="round"/>"#,
                points.trim_end(),
                time_color(f64::from(piece) / f64::from(pieces))
            );
        }
        first = last;
    }
    if let Some(start) = trace.samples.first() {
        let _ = writeln!(
            svg,
            r##"<circle cx="{:.1}" cy="{:.1}" r="6" fill="#ffffff" stroke="#111827" stroke-width="2"/>"##,
            x(start.base[0]),
            y(start.base[1])
        );
    }
}

fn tags(
    svg: &mut String,
    ground: &Ground,
    found: &[TargetFound],
    x: &dyn Fn(f64) -> f64,
    y: &dyn Fn(f64) -> f64,
) {
    for tag in &ground.tags {
        let found = found.iter().find(|t| t.id == tag.id);
        let (color, label) = match found {
            Some(found) => ("#16a34a", format!("{}: {:.0} s", tag.id, found.time_s)),
            None => ("#dc2626", format!("{}: not found", tag.id)),
        };
        let (cx, cy) = (x(tag.center[0]), y(tag.center[1]));
        // Near the right edge the label stands to the left.
        let left = cx > x(ground.high[0]) - 110.0;
        let (tx, ty) = (
            if left {
                cx - 10.0 - 9.0 * label.len() as f64
            } else {
                cx + 9.0
            },
            cy + 5.0,
        );
        let _ = writeln!(
            svg,
            r##"<rect x="{:.1}" y="{:.1}" width="12" height="12" fill="{color}" stroke="#ffffff" stroke-width="1.5"/><text x="{tx:.1}" y="{ty:.1}" font-size="15" font-weight="bold" stroke="#ffffff" stroke-width="3">{label}</text><text x="{tx:.1}" y="{ty:.1}" font-size="15" font-weight="bold" fill="{color}">{label}</text>"##,
            cx - 6.0,
            cy - 6.0,
        );
    }
}

fn legend(svg: &mut String, caption: &str, end: f64, top: f64, width: f64) {
    let _ = writeln!(
        svg,
        r##"<text x="{BORDER}" y="{:.1}" font-size="16" fill="#111827">{}</text>"##,
        top + 14.0,
        super::escaped(caption)
    );
    let bar = (width - 2.0 * BORDER).min(260.0);
    for i in 0..52 {
        let _ = writeln!(
            svg,
            r#"<rect x="{:.1}" y="{:.1}" width="{:.1}" height="10" fill="{}"/>"#,
            BORDER + bar * f64::from(i) / 52.0,
            top + 28.0,
            bar / 52.0 + 0.5,
            time_color(f64::from(i) / 52.0)
        );
    }
    let _ = writeln!(
        svg,
        r##"<text x="{BORDER}" y="{:.1}" font-size="14" fill="#374151">base path: 0 s to {:.0} s</text>"##,
        top + 56.0,
        end
    );
    let items = [
        ("#7c3aed", "camera at a reached view"),
        ("#4b5563", "inspected surface"),
        ("#ef4444", "surface not inspected"),
        ("#9ca3af", "unknown"),
        ("#16a34a", "tag found"),
        ("#dc2626", "tag missed"),
    ];
    let mut left = BORDER + bar + 24.0;
    let mut line = top + 28.0;
    for (color, text) in items {
        let advance = 30.0 + 8.2 * text.len() as f64;
        if left + advance > width {
            left = BORDER + bar + 24.0;
            line += 20.0;
        }
        let _ = writeln!(
            svg,
            r##"<rect x="{left:.1}" y="{line:.1}" width="12" height="12" fill="{color}"/><text x="{:.1}" y="{:.1}" font-size="14" fill="#374151">{text}</text>"##,
            left + 17.0,
            line + 11.0
        );
        left += advance;
    }
}
