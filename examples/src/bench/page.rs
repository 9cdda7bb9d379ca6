//! `report.html` of a campaign: tables, and box plots in which every trial is a mark that leads to its report or result. One file without
//! script, library or network; the links are relative, so that the campaign's folder can be moved.

use super::campaign::Kept;
use crate::record::{document, escaped};
use std::fmt::Write;

const STYLE: &str = include_str!("page.css");

/// Width of a plot, pixels; it scales with the page. Letters are half as large again on a phone (page.css), and must not touch there.
const WIDTH: f64 = 560.0;
/// At either side; half the label of a tick at the edge fits in.
const MARGIN: f64 = 28.0;
/// Height of a row: its name, and below it the box.
const ROW: f64 = 48.0;
/// Height of the axis below the rows.
const AXIS: f64 = 26.0;

/// One experiment.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Section {
    pub(super) title: String,
    /// Lines of the table, the headings first.
    pub(super) table: Vec<Vec<String>>,
    /// Pictures between table and plots, as HTML.
    pub(super) figures: Vec<String>,
    /// Its plots; the table of all trials shows the values of the first.
    pub(super) plots: Vec<Plot>,
}

/// The values of some planners.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plot {
    pub(super) title: String,
    /// Digits after the point.
    pub(super) digits: usize,
    /// A value at which a line stands.
    pub(super) reference: Option<f64>,
    pub(super) rows: Vec<(String, Vec<Mark>)>,
}

/// One trial.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mark {
    pub(super) value: f64,
    /// What tells it from the other trials of its row.
    pub(super) label: String,
    /// Its result, from the page's folder.
    pub(super) file: String,
    /// Its report, from the page's folder, if it has one.
    pub(super) report: Option<String>,
}

impl Mark {
    pub(super) fn new(value: f64, label: String, kept: &Kept) -> Self {
        Self {
            value,
            label,
            file: kept.file.clone(),
            report: kept.report.clone(),
        }
    }
}

/// The page. `notes` are paragraphs above the first experiment.
pub(super) fn page(title: &str, notes: &[String], sections: &[Section]) -> String {
    let mut body = format!("<h1>{}</h1>\n", escaped(title));
    for note in notes {
        let _ = writeln!(body, "<p>{}</p>", escaped(note));
    }
    body.push_str("<nav>");
    for (k, section) in sections.iter().enumerate() {
        let _ = writeln!(body, r##"<a href="#s{k}">{}</a>"##, escaped(&section.title));
    }
    body.push_str("</nav>\n");
    for (k, section) in sections.iter().enumerate() {
        let _ = writeln!(body, r#"<h2 id="s{k}">{}</h2>"#, escaped(&section.title));
        table(&mut body, &section.table);
        body.push_str("<div class=\"plots\">\n");
        section.figures.iter().for_each(|f| body.push_str(f));
        section.plots.iter().for_each(|p| plot(&mut body, p));
        body.push_str("</div>\n");
        if let Some(first) = section.plots.first() {
            trials(&mut body, first);
        }
    }
    document(title, STYLE, &body)
}

fn table(body: &mut String, lines: &[Vec<String>]) {
    body.push_str("<div class=\"box\"><table>\n");
    for (row, line) in lines.iter().enumerate() {
        let tag = if row == 0 { "th" } else { "td" };
        body.push_str("<tr>");
        for cell in line {
            let _ = write!(body, "<{tag}>{}</{tag}>", escaped(cell));
        }
        body.push_str("</tr>\n");
    }
    body.push_str("</table></div>\n");
}

/// All values of a plot, each a link to the result, and behind it one to the report.
fn trials(body: &mut String, plot: &Plot) {
    let _ = writeln!(
        body,
        r#"<details class="box"><summary>Every trial: {}</summary><table>"#,
        escaped(&plot.title)
    );
    for (name, marks) in &plot.rows {
        let _ = write!(body, "<tr><td>{}</td>", escaped(name));
        for mark in marks {
            let _ = write!(
                body,
                r#"<td><a href="{}" title="{}, result">{:.*}</a>"#,
                escaped(&mark.file),
                escaped(&mark.label),
                plot.digits,
                mark.value
            );
            if let Some(report) = &mark.report {
                let (report, label) = (escaped(report), escaped(&mark.label));
                let _ = write!(
                    body,
                    r#" <a href="{report}" title="{label}, report" aria-label="{label}, report">&#9654;</a>"#
                );
            }
            body.push_str("</td>");
        }
        body.push_str("</tr>\n");
    }
    body.push_str("</table></details>\n");
}

/// A box for each row: quartiles, whiskers to the farthest values within 1.5 of their distance, and all values as marks.
fn plot(body: &mut String, plot: &Plot) {
    let marks = || plot.rows.iter().flat_map(|(_, marks)| marks);
    let all = marks().map(|m| m.value).chain(plot.reference);
    let (low, high) = all
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
    if low > high {
        return;
    }
    // Something to divide by where all values are the same, and no finer than they are shown.
    let pad = (0.04 * (high - low)).max(3.0 * 0.1f64.powi(plot.digits as i32));
    let (low, high) = (low - pad, high + pad);
    let x = |v: f64| MARGIN + (v - low) / (high - low) * (WIDTH - 2.0 * MARGIN);
    let bottom = plot.rows.len() as f64 * ROW + 4.0;
    let _ = writeln!(
        body,
        r##"<figure class="box"><figcaption>{0}</figcaption><svg viewBox="0 0 {WIDTH} {1}" role="group" aria-label="{0}">"##,
        escaped(&plot.title),
        bottom + AXIS
    );
    let step = nice((high - low) / 7.0);
    let digits = (-step.log10().floor()).max(0.0) as usize;
    for k in (low / step).ceil() as i64..=(high / step).floor() as i64 {
        let value = k as f64 * step;
        let _ = writeln!(
            body,
            r##"<path d="M{0:.1} 0V{bottom}" stroke="#e5e7eb"/><text x="{0:.1}" y="{1}" text-anchor="middle" fill="#4b5563">{value:.digits$}</text>"##,
            x(value),
            bottom + 17.0
        );
    }
    if let Some(reference) = plot.reference {
        let _ = writeln!(
            body,
            r##"<path d="M{:.1} 0V{bottom}" stroke="#dc2626" stroke-dasharray="5 4"/>"##,
            x(reference)
        );
    }
    for (row, (name, marks)) in plot.rows.iter().enumerate() {
        let top = row as f64 * ROW;
        let middle = top + 32.0;
        let values = marks.iter().map(|m| m.value);
        let Some(five) = Five::of(values) else {
            continue;
        };
        let [least, lower, median, upper, most] =
            [five.low, five.lower, five.median, five.upper, five.high].map(x);
        // A white edge keeps the name readable where a line passes behind it.
        let _ = writeln!(
            body,
            r##"<text x="{MARGIN}" y="{0:.1}" paint-order="stroke" stroke="#ffffff" stroke-width="4">{1}</text><text x="{2:.1}" y="{0:.1}" text-anchor="end" fill="#4b5563" paint-order="stroke" stroke="#ffffff" stroke-width="4">median {3:.4$}</text>
<path d="M{least:.1} {middle}H{lower:.1}M{upper:.1} {middle}H{most:.1}M{least:.1} {5:.1}v8M{most:.1} {5:.1}v8" stroke="#0f172a"/>
<rect x="{lower:.1}" y="{6:.1}" width="{7:.1}" height="16" fill="#dbeafe" stroke="#1d4ed8"/>
<path d="M{median:.1} {6:.1}v16" stroke="#1d4ed8" stroke-width="2.5"/>"##,
            top + 16.0,
            escaped(name),
            WIDTH - MARGIN,
            five.median,
            plot.digits,
            middle - 4.0,
            middle - 8.0,
            upper - lower,
        );
        for (k, mark) in marks
            .iter()
            .enumerate()
            .filter(|(_, m)| m.value.is_finite())
        {
            // Neighbours stand at different heights, so that equal values can be told apart.
            let height = middle + 2.5 * ((k * 2 % 5) as f64 - 2.0);
            let _ = writeln!(
                body,
                r##"<a href="{}"><circle cx="{:.1}" cy="{height:.1}" r="3.2" fill="#0f172a" fill-opacity="0.5"><title>{}, {}: {:.*}</title></circle></a>"##,
                escaped(mark.report.as_ref().unwrap_or(&mark.file)),
                x(mark.value),
                escaped(name),
                escaped(&mark.label),
                plot.digits,
                mark.value
            );
        }
    }
    body.push_str("</svg></figure>\n");
}

/// The five numbers of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Five {
    low: f64,
    lower: f64,
    median: f64,
    upper: f64,
    high: f64,
}

impl Five {
    /// Quartiles interpolated between the sorted values; whiskers as Tukey draws them. None without a finite value.
    fn of(values: impl Iterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.filter(|v| v.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().checked_sub(1)?;
        let quantile = |share: f64| {
            let place = share * last as f64;
            let below = place.floor() as usize;
            let above = (below + 1).min(last);
            sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
        };
        let [lower, median, upper] = [0.25, 0.5, 0.75].map(quantile);
        let reach = 1.5 * (upper - lower);
        let inside = |v: &&f64| **v >= lower - reach && **v <= upper + reach;
        let (low, high) = (
            sorted.iter().find(inside).copied(),
            sorted.iter().rev().find(inside).copied(),
        );
        Some(Self {
            // Between two values a quartile may lie beyond the farthest value inside; a whisker never points inwards.
            low: low.map_or(lower, |v| v.min(lower)),
            lower,
            median,
            upper,
            high: high.map_or(upper, |v| v.max(upper)),
        })
    }
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `v`.
pub(super) fn nice(v: f64) -> f64 {
    let ten = 10f64.powf(v.log10().floor());
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|f| f * ten)
        .find(|f| *f >= v)
        .unwrap_or(10.0 * ten)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quartiles as numpy's default and R's type 7 have them; 30 lies beyond 6 + 1.5 * 3.25.
    #[test]
    fn boxes_hold_half_of_the_values() {
        let five = |values: &[f64]| Five::of(values.iter().copied());
        // Sorted: 1, 2.5, 3, 5, 5, 7, 30.
        assert_eq!(
            five(&[30.0, 1.0, 5.0, 3.0, 5.0, 7.0, 2.5]),
            Some(Five {
                low: 1.0,
                lower: 2.75,
                median: 5.0,
                upper: 6.0,
                high: 7.0,
            })
        );
        assert_eq!(five(&[]), None);
        assert_eq!(
            five(&[f64::NAN, 2.0]).map(|f| (f.low, f.high)),
            Some((2.0, 2.0))
        );
    }

    #[test]
    fn a_plot_has_every_trial_and_no_foreign_markup() {
        let mark = |value, label: &str| Mark {
            value,
            label: label.into(),
            file: format!("trials/{label}.json"),
            report: (label == "one").then(|| "trials/one.html".into()),
        };
        let rows = vec![
            ("a<b".into(), vec![mark(1.0, "one"), mark(3.0, "two")]),
            ("same".into(), vec![mark(2.0, "three"), mark(2.0, "four\"")]),
        ];
        let plot = Plot {
            title: "time, s".into(),
            digits: 1,
            reference: Some(2.0),
            rows,
        };
        let section = Section {
            figures: Vec::new(),
            title: "known & unknown".into(),
            table: vec![vec!["planner".into()], vec!["<i>".into()]],
            plots: vec![plot.clone()],
        };
        let text = page("A campaign", &["of two planners".into()], &[section]);
        for label in ["one", "two", "three", "four&quot;"] {
            let link = format!(r#"<a href="trials/{label}.json""#);
            let links = text.matches(&link).count();
            assert_eq!(
                links,
                if label == "one" { 1 } else { 2 },
                "{label}: a mark and a cell"
            );
        }
        // Where there is a report, the mark leads to it, and the cell to both.
        assert_eq!(text.matches(r#"<a href="trials/one.html""#).count(), 2);
        assert!(text.contains("a&lt;b, two: 3.0") && text.contains("known &amp; unknown"));
        assert!(!text.contains("a<b") && !text.contains("<i>") && !text.contains("{{"));
        assert!(!text.contains("NaN") && !text.contains("inf"));
        // Nothing to draw is no plot.
        let mut none = String::new();
        super::plot(
            &mut none,
            &Plot {
                rows: Vec::new(),
                reference: None,
                ..plot
            },
        );
        assert_eq!(none, "");
    }
}
