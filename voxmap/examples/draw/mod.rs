//! Coloured grids as SVG, shared by the examples.

use std::fmt::Write;

/// A grid seen from above, `color` of each cell (x, y) as "#rrggbb" or empty for none; y points up in the picture.
pub(crate) fn svg(size: [usize; 2], pixel: f64, color: impl Fn(usize, usize) -> String) -> String {
    let (w, h) = (size[0] as f64 * pixel, size[1] as f64 * pixel);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" shape-rendering=\"crispEdges\">\n\
         <rect width=\"{w}\" height=\"{h}\" fill=\"#e8e8e8\"/>\n"
    );
    for y in 0..size[1] {
        // Runs of one colour become one rectangle.
        let mut x = 0;
        while x < size[0] {
            let here = color(x, y);
            let start = x;
            while x < size[0] && color(x, y) == here {
                x += 1;
            }
            if !here.is_empty() {
                let _ = writeln!(
                    out,
                    "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{pixel}\" fill=\"{here}\"/>",
                    start as f64 * pixel,
                    (size[1] - 1 - y) as f64 * pixel,
                    (x - start) as f64 * pixel,
                );
            }
        }
    }
    out.push_str("</svg>\n");
    out
}

/// From blue over white to red, for 0..1; NaN is grey.
pub(crate) fn shade(t: f64) -> String {
    if t.is_nan() {
        return "#808080".into();
    }
    let t = t.clamp(0.0, 1.0);
    // 32 steps, so that runs stay long.
    let t = (t * 31.0).round() / 31.0;
    let up = |from: f64, to: f64, t: f64| (from + (to - from) * t).round() as u8;
    let (r, g, b) = if t < 0.5 {
        let s = 2.0 * t;
        (up(40.0, 250.0, s), up(80.0, 250.0, s), up(160.0, 245.0, s))
    } else {
        let s = 2.0 * t - 1.0;
        (up(250.0, 190.0, s), up(250.0, 50.0, s), up(245.0, 40.0, s))
    };
    format!("#{r:02x}{g:02x}{b:02x}")
}
