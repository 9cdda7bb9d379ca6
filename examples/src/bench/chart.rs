//! Horizontal bars as SVG.

use std::fmt::Write;

/// One bar: what stands for the dark part is followed by what stands for the bright part.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bar {
    pub(super) label: String,
    pub(super) dark: f64,
    pub(super) bright: f64,
    /// Half the width of the whisker at the end of the dark part.
    pub(super) spread: f64,
}

/// Groups of bars with a title each, in seconds.
pub(super) fn bars(title: &str, groups: &[(String, Vec<Bar>)]) -> String {
    const LEFT: f64 = 250.0;
    const WIDTH: f64 = 560.0;
    const ROW: f64 = 24.0;
    let rows: usize = groups.iter().map(|(_, bars)| bars.len() + 2).sum();
    let height = 60.0 + rows as f64 * ROW + 30.0;
    let all = groups.iter().flat_map(|(_, bars)| bars);
    let most = all
        .map(|b| b.dark + b.bright + b.spread)
        .fold(1.0, f64::max)
        * 1.05;
    let mut svg = String::new();
    let _ = writeln!(
        svg,
        r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0:.0} {height:.0}" width="{0:.0}" height="{height:.0}" font-family="sans-serif">
<rect width="100%" height="100%" fill="#ffffff"/>
<text x="16" y="28" font-size="17">{title}</text>
<text x="16" y="46" font-size="12" fill="#475569">mean over trials, s: expected execution time (dark, with standard deviation), expected planning time (bright)</text>"##,
        LEFT + WIDTH + 90.0
    );
    let x = |v: f64| LEFT + v / most * WIDTH;
    let mut y = 60.0;
    for (name, bars) in groups {
        let _ = writeln!(
            svg,
            r##"<text x="16" y="{:.0}" font-size="14" font-weight="bold">{name}</text>"##,
            y + ROW - 7.0
        );
        y += ROW;
        for bar in bars {
            let (dark, total, middle) =
                (x(bar.dark), x(bar.dark + bar.bright), y + 0.5 * ROW - 2.0);
            let _ = writeln!(
                svg,
                r##"<text x="{:.0}" y="{:.1}" font-size="12" text-anchor="end">{}</text>
<rect x="{LEFT}" y="{:.1}" width="{:.1}" height="{:.1}" fill="#1d4ed8"/>
<rect x="{dark:.1}" y="{:.1}" width="{:.1}" height="{:.1}" fill="#93c5fd"/>
<path d="M{:.1} {middle:.1}H{:.1}" stroke="#0f172a"/>
<text x="{:.1}" y="{:.1}" font-size="12">{:.1} + {:.2}</text>"##,
                LEFT - 8.0,
                middle + 4.0,
                bar.label,
                y,
                dark - LEFT,
                ROW - 5.0,
                y,
                (total - dark).max(0.0),
                ROW - 5.0,
                x(bar.dark - bar.spread),
                x(bar.dark + bar.spread),
                x(bar.dark + bar.bright + bar.spread) + 8.0,
                middle + 4.0,
                bar.dark,
                bar.bright
            );
            y += ROW;
        }
        y += ROW;
    }
    svg.push_str("</svg>\n");
    svg
}
