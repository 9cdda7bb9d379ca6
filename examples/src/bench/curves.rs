//! Curves over simulated time: the mean of some trials, and the band between the least and the most of them.

use super::page::nice;
use crate::record::escaped;
use std::fmt::Write;

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 300.0;
/// Left, top, right, bottom, pixels.
const MARGINS: [f64; 4] = [60.0, 10.0, 24.0, 30.0];
/// Names beside each other, and the distance of their lines, pixels.
const COLUMNS: usize = 2;
const LINE: f64 = 22.0;
/// Colours that are told apart also without red or green (Okabe and Ito).
const COLOURS: [&str; 6] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#374151",
];

/// One planner: its name, and for each trial the times (s) and values (0 to 1), times rising.
pub(super) type Curve = (String, Vec<Vec<(f64, f64)>>);

/// The value of a trial at a time: the last one before it. A trial that is over keeps its last.
fn at(trial: &[(f64, f64)], time: f64) -> f64 {
    let next = trial.partition_point(|&(t, _)| t <= time + 1e-9);
    next.checked_sub(1).map_or(0.0, |i| trial[i].1)
}

/// The picture, as HTML.
pub(super) fn curves(title: &str, curves: &[Curve]) -> String {
    let trials = || curves.iter().flat_map(|(_, trials)| trials);
    let end = trials()
        .filter_map(|t| t.last())
        .map(|&(time, _)| time)
        .fold(1.0, f64::max);
    let [left, top, right, bottom] = MARGINS;
    let x = |t: f64| left + t / end * (WIDTH - left - right);
    let y = |v: f64| HEIGHT - bottom - v * (HEIGHT - top - bottom);
    let legend = LINE * curves.len().div_ceil(COLUMNS) as f64;
    let mut svg = String::new();
    let _ = writeln!(
        svg,
        r##"<figure class="box"><figcaption>{0}</figcaption><svg viewBox="0 0 {WIDTH} {1}" role="img" aria-label="{0}">"##,
        escaped(title),
        HEIGHT + legend
    );
    for k in 0..=5 {
        let v = f64::from(k) / 5.0;
        let _ = writeln!(
            svg,
            r##"<path d="M{left} {0:.1}H{1}" stroke="#e5e7eb"/><text x="{2}" y="{3:.1}" text-anchor="end" fill="#4b5563">{4:.0} %</text>"##,
            y(v),
            WIDTH - right,
            left - 5.0,
            y(v) + 4.0,
            100.0 * v
        );
    }
    let step = nice(end / 7.0);
    for k in 0..=(end / step).floor() as usize {
        let t = k as f64 * step;
        let _ = writeln!(
            svg,
            r##"<text x="{:.1}" y="{}" text-anchor="middle" fill="#4b5563">{t:.0} s</text>"##,
            x(t),
            HEIGHT - bottom + 17.0
        );
    }
    for (k, (name, trials)) in curves.iter().enumerate() {
        let colour = COLOURS[k % COLOURS.len()];
        let dash = if k < COLOURS.len() {
            ""
        } else {
            r#" stroke-dasharray="5 3""#
        };
        let samples: Vec<f64> = (0..=180).map(|i| end * f64::from(i) / 180.0).collect();
        let (mut upper, mut lower, mut mean) = (String::new(), Vec::new(), String::new());
        for (i, &t) in samples.iter().enumerate() {
            let values: Vec<f64> = trials.iter().map(|trial| at(trial, t)).collect();
            let low = values.iter().copied().fold(f64::INFINITY, f64::min);
            let high = values.iter().copied().fold(0.0, f64::max);
            let middle = values.iter().sum::<f64>() / values.len().max(1) as f64;
            let letter = if i == 0 { 'M' } else { 'L' };
            let _ = write!(upper, "{letter}{:.1} {:.1}", x(t), y(high));
            let _ = write!(mean, "{letter}{:.1} {:.1}", x(t), y(middle));
            lower.push(format!("L{:.1} {:.1}", x(t), y(low.min(high))));
        }
        lower.reverse();
        let _ = writeln!(
            svg,
            r##"<path d="{upper}{}Z" fill="{colour}" fill-opacity="0.13"/><path d="{mean}" fill="none" stroke="{colour}" stroke-width="2"{dash}><title>{}</title></path>"##,
            lower.concat(),
            escaped(name)
        );
        let (column, row) = ((k % COLUMNS) as f64, (k / COLUMNS) as f64);
        let (lx, ly) = (left + column * 250.0, HEIGHT + 4.0 + LINE * row);
        let _ = writeln!(
            svg,
            r##"<path d="M{lx} {ly}h22" stroke="{colour}" stroke-width="3"{dash}/><text x="{}" y="{}">{}</text>"##,
            lx + 28.0,
            ly + 4.0,
            escaped(name)
        );
    }
    svg.push_str("</svg></figure>\n");
    svg
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_that_is_over_keeps_its_last_value() {
        let trial = [(0.0, 0.1), (1.0, 0.3), (2.0, 0.9)];
        assert_eq!(
            [-1.0, 0.0, 0.5, 1.0, 50.0].map(|t| at(&trial, t)),
            [0.0, 0.1, 0.1, 0.3, 0.9]
        );
    }

    #[test]
    fn every_planner_has_a_line_a_band_and_a_name() {
        let trial = |v: f64| vec![(0.0, 0.0), (10.0, v)];
        let all = [
            ("a<b".to_owned(), vec![trial(0.5), trial(1.0)]),
            ("empty".to_owned(), vec![Vec::new()]),
        ];
        let text = curves("explored & seen", &all);
        assert_eq!(text.matches("stroke-width=\"2\"").count(), 2);
        assert_eq!(text.matches("fill-opacity").count(), 2);
        assert!(text.contains("a&lt;b") && text.contains("explored &amp; seen"));
        assert!(!text.contains("NaN") && !text.contains("inf"));
    }
}
