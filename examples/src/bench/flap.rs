//! The three experiments of the FLAP paper (Fig. 6): offline and continual planning on a known map, continual planning with
//! only the walls known.

use super::campaign::{Kept, Left, Order, Suite, Trial};
use super::chart::{Bar, bars};
use super::page::{Mark, Plot, Section, page};
use super::{left, spread};
use crate::flap::{
    FlapResult, FlapSettings, MapKind, PlannerKind, Progress, Site, run_at_recorded,
};
use crate::record::{Html, REPORT_FILE};
use crate::scene::Scene;
use std::fmt::Write;

/// The suite.
#[derive(Clone, Debug)]
pub struct Figure6 {
    seeds: usize,
    rows: Vec<Row>,
}

/// One planner in one experiment.
#[derive(Clone, Debug)]
struct Row {
    experiment: usize,
    name: &'static str,
    settings: FlapSettings,
}

const EXPERIMENTS: [(&str, &str); 3] = [
    ("offline-known", "known map, offline"),
    ("continual-known", "known map, continual"),
    ("continual-walls", "walls known, continual"),
];

/// Density of unknown space for predictions that discount what lies behind it, 1/m: in the volumes and elsewhere.
const HAZE: (f64, f64) = (0.5, 0.0);

impl Figure6 {
    /// The suite with so many seeds for each experiment; the paper: 20.
    pub fn new(seeds: usize) -> Self {
        let mut rows = Vec::new();
        for experiment in 0..EXPERIMENTS.len() {
            let base = FlapSettings {
                offline: experiment == 0,
                map: if experiment == 2 {
                    MapKind::Walls
                } else {
                    MapKind::Known
                },
                ..FlapSettings::default()
            };
            let flap = |depth_limit, branch_limit, prune_dominated| FlapSettings {
                planner: PlannerKind::Flap,
                depth_limit,
                branch_limit,
                prune_dominated,
                ..base.clone()
            };
            let timed = |planner, budget_ms| FlapSettings {
                planner,
                branch_limit: 1.5,
                prune_dominated: true,
                depth_limit: 4,
                budget_ms,
                ..base.clone()
            };
            let local = |budget_ms, hazy| FlapSettings {
                planner: PlannerKind::Local,
                budget_ms,
                haze: if hazy { HAZE.0 } else { 0.0 },
                haze_elsewhere: if hazy { HAZE.1 } else { 0.0 },
                ..base.clone()
            };
            let greedy = FlapSettings {
                planner: PlannerKind::Greedy,
                ..base.clone()
            };
            let mut all = vec![
                ("greedy", greedy.clone()),
                ("flap-psi2-phi1.3-xi0", flap(2, 1.3, false)),
                ("flap-psi2-phi1.3-xi1", flap(2, 1.3, true)),
                ("flap-psi3-phi1.4-xi1", flap(3, 1.4, true)),
                (
                    "iter-psi-100ms-phi1.5-xi1",
                    timed(PlannerKind::IterPsi, 100.0),
                ),
                (
                    "iter-phi-100ms-psi4-xi1",
                    timed(PlannerKind::IterPhi, 100.0),
                ),
                ("local-15ms", local(15.0, false)),
                ("local-100ms", local(100.0, false)),
            ];
            if experiment == 2 {
                let hazy = FlapSettings {
                    haze: HAZE.0,
                    haze_elsewhere: HAZE.1,
                    ..greedy
                };
                all.push(("greedy-haze", hazy));
                all.push(("local-100ms-haze", local(100.0, true)));
            }
            rows.extend(all.into_iter().map(|(name, settings)| Row {
                experiment,
                name,
                settings,
            }));
        }
        Self { seeds, rows }
    }

    /// Rows that share a site: those of one map. Group: map and seed.
    fn group_of(&self, row: usize, seed: usize) -> usize {
        let walls = usize::from(self.rows[row].settings.map == MapKind::Walls);
        walls * self.seeds + seed
    }

    /// Name of a trial.
    fn name(&self, row: usize, seed: usize) -> String {
        let row = &self.rows[row];
        let (key, _) = EXPERIMENTS[row.experiment];
        format!("{key}.{}.seed{:02}", row.name, seed + 1)
    }

    /// One value of each trial of some rows, as a plot.
    fn plot(
        &self,
        title: &str,
        digits: usize,
        reference: Option<f64>,
        rows: &[usize],
        kept: &[Vec<&Kept>],
        value: &dyn Fn(usize, usize) -> f64,
    ) -> Plot {
        let mark = |row: usize, seed: usize| {
            let label = format!("seed {}", seed + 1);
            Mark::new(value(row, seed), label, kept[row][seed])
        };
        let marks = |row| (0..self.seeds).map(|seed| mark(row, seed)).collect();
        Plot {
            title: title.into(),
            digits,
            reference,
            rows: rows
                .iter()
                .map(|&row| (self.rows[row].name.into(), marks(row)))
                .collect(),
        }
    }

    /// Row and seed of each trial, group by group.
    fn order(&self) -> Vec<(usize, usize)> {
        let mut all: Vec<(usize, usize)> = (0..self.rows.len())
            .flat_map(|row| (0..self.seeds).map(move |seed| (row, seed)))
            .collect();
        all.sort_by_key(|&(row, seed)| (self.group_of(row, seed), row));
        all
    }
}

impl Suite for Figure6 {
    fn trials(&self) -> Vec<Trial> {
        self.order()
            .into_iter()
            .map(|(row, seed)| Trial {
                name: self.name(row, seed),
                group: self.group_of(row, seed),
            })
            .collect()
    }

    fn run_group(
        &self,
        group: usize,
        order: Order<'_>,
        deliver: &mut dyn FnMut(usize, Left) -> bool,
    ) -> Result<(), String> {
        let scene = Scene::builtin("race").map_err(|e| e.to_string())?;
        let mut site: Option<Site> = None;
        for (trial, (row, seed)) in self.order().into_iter().enumerate() {
            if self.group_of(row, seed) != group || !(order.wanted)(trial) {
                continue;
            }
            let settings = FlapSettings {
                seed: seed as u64 + 1,
                ..self.rows[row].settings.clone()
            };
            let ready = match site.take().filter(|s| s.serves(&settings)) {
                Some(site) => site,
                None => Site::new(&scene, &settings).map_err(|e| e.to_string())?,
            };
            let mut recorded = order.reports.then(Html::unwritten);
            let quiet = &mut |_: &Progress| ();
            let outcome =
                run_at_recorded(&ready, &scene, &settings, order.stop, quiet, &mut recorded)
                    .map_err(|e| e.to_string())?;
            site = Some(ready);
            if outcome.result.ended == "interrupted" {
                return Ok(());
            }
            let left = left(&outcome.result, &outcome.result, recorded);
            if !deliver(trial, left.map_err(|e| e.to_string())?) {
                return Ok(());
            }
        }
        Ok(())
    }

    fn report(&self, results: &[Kept]) -> Result<(String, Vec<(String, String)>), String> {
        // results[row][seed]
        let mut by_row: Vec<Vec<FlapResult>> = vec![Vec::new(); self.rows.len()];
        let mut kept: Vec<Vec<&Kept>> = vec![Vec::new(); self.rows.len()];
        for ((row, _), own) in self.order().into_iter().zip(results) {
            by_row[row].push(serde_json::from_str(&own.result).map_err(|e| e.to_string())?);
            kept[row].push(own);
        }
        let (mut table, mut markdown) = (String::new(), String::new());
        let mut csv = String::from(
            "experiment,planner,seed,ended,expected_time_s,expected_planning_s,ratio_to_greedy,execution_time_s,sensing_actions,probability,plan_ms_median,first_plan_s\n",
        );
        let (mut groups, mut sections) = (Vec::new(), Vec::new());
        for (experiment, (key, title)) in EXPERIMENTS.iter().enumerate() {
            let mut lines = vec![HEADINGS.map(String::from)];
            let rows: Vec<usize> = (0..self.rows.len())
                .filter(|&r| self.rows[r].experiment == experiment)
                .collect();
            let total = |r: &FlapResult| r.expected_time_s + r.wall.expected_planning_s;
            let mut chart = Vec::new();
            for &row in &rows {
                let own = &by_row[row];
                let greedy = &by_row[rows[0]];
                let ratios: Vec<f64> = own
                    .iter()
                    .zip(greedy)
                    .map(|(a, g)| total(a) / total(g))
                    .collect();
                let of = |f: &dyn Fn(&FlapResult) -> f64| spread(own.iter().map(f));
                let (time, sd) = of(&|r| r.expected_time_s);
                let (planning, planning_sd) = of(&|r| r.wall.expected_planning_s);
                let (ratio, ratio_sd) = spread(ratios.iter().copied());
                let worse = ratios.iter().filter(|r| **r > 1.0).count();
                let median = median(own.iter().map(|r| r.wall.plan_ms.median));
                lines.push([
                    self.rows[row].name.into(),
                    format!("{time:.1} ± {sd:.1}"),
                    format!("{planning:.2} ± {planning_sd:.2}"),
                    format!("{ratio:.3} ± {ratio_sd:.3}"),
                    worse.to_string(),
                    format!("{:.1}", of(&|r| r.sensing_actions as f64).0),
                    format!("{median:.2}"),
                    format!("{:.1}", of(&|r| r.first_plan_time_s).0),
                ]);
                for (r, ratio) in own.iter().zip(&ratios) {
                    let _ = writeln!(
                        csv,
                        "{key},{},{},{},{:.4},{:.6},{:.5},{:.4},{},{:.6},{:.4},{:.4}",
                        self.rows[row].name,
                        r.seed,
                        r.ended,
                        r.expected_time_s,
                        r.wall.expected_planning_s,
                        ratio,
                        r.execution_time_s,
                        r.sensing_actions,
                        r.probability,
                        r.wall.plan_ms.median,
                        r.first_plan_time_s
                    );
                }
                chart.push(Bar {
                    label: self.rows[row].name.into(),
                    dark: time,
                    bright: planning,
                    spread: sd,
                });
            }
            let heading = format!("{title} ({} trials)", self.seeds);
            let _ = writeln!(table, "{heading}\n{}", plain(&lines));
            let _ = writeln!(markdown, "**{heading}**\n\n{}", marked(&lines));
            groups.push((String::from(*title), chart));
            let seconds = |row: usize, seed: usize| total(&by_row[row][seed]);
            let ratio = |row, seed| seconds(row, seed) / seconds(rows[0], seed);
            sections.push(Section {
                figures: Vec::new(),
                title: heading,
                table: lines.iter().map(|line| line.to_vec()).collect(),
                plots: vec![
                    self.plot(
                        "expected execution and planning, s",
                        1,
                        None,
                        &rows,
                        &kept,
                        &seconds,
                    ),
                    self.plot(
                        "the same over greedy's, trial by trial",
                        3,
                        Some(1.0),
                        &rows[1..],
                        &kept,
                        &ratio,
                    ),
                ],
            });
        }
        let once: Vec<&Vec<FlapResult>> = [MapKind::Known, MapKind::Walls]
            .iter()
            .filter_map(|map| self.rows.iter().position(|r| r.settings.map == *map))
            .map(|row| &by_row[row])
            .collect();
        let medians: Vec<String> = once
            .iter()
            .map(|own| {
                let of = |f: &dyn Fn(&FlapResult) -> f64| median(own.iter().map(f));
                format!(
                    "{:.0} ms and {:.0} ms",
                    of(&|r| r.wall.views_ms),
                    of(&|r| r.wall.table_ms)
                )
            })
            .collect();
        let notes = format!(
            "/ greedy: (execution + planning) over greedy's, trial by trial; worse: trials above 1; plan: median CPU time of a plan; \
             first: expected time that the first plan predicts.\n\
             Sampling 200 views and the travel table, median CPU time: {} (known map), {} (walls).\n",
            medians.first().map_or("-", String::as_str),
            medians.get(1).map_or("-", String::as_str),
        );
        table.push_str(&notes);
        markdown.push_str(&notes);
        let svg = bars(TITLE, &groups);
        let mut paragraphs: Vec<String> = notes.lines().map(String::from).collect();
        paragraphs.push(MARKS.into());
        let html = page(TITLE, &paragraphs, &sections);
        Ok((
            table.clone(),
            vec![
                ("table.md".into(), markdown),
                ("trials.csv".into(), csv),
                ("figure6.svg".into(), svg),
                (REPORT_FILE.into(), html),
            ],
        ))
    }
}

const TITLE: &str = "FLAP, figure 6: expected time of search";

/// How to read the page's plots.
const MARKS: &str = "Boxes: median and quartiles, with whiskers to the farthest trial within 1.5 of the box's width. Every mark is \
    a trial and opens its report, or its result where the campaign was run without --reports. The settings in a result, saved as \
    a TOML file, repeat the trial: seekplan flap --config FILE --out DIR.";

const HEADINGS: [&str; 8] = [
    "planner",
    "execution, s",
    "planning, s",
    "/ greedy",
    "worse",
    "actions",
    "plan, ms",
    "first, s",
];

/// Columns of equal width: the first to the left, the others to the right.
fn plain(lines: &[[String; 8]]) -> String {
    let width = |c: usize| lines.iter().map(|l| l[c].chars().count()).max();
    let widths: Vec<usize> = (0..8).map(|c| width(c).unwrap_or(0)).collect();
    let mut text = String::new();
    for line in lines {
        let _ = write!(text, "  {:<1$}", line[0], widths[0]);
        for c in 1..8 {
            let _ = write!(text, "  {:>1$}", line[c], widths[c]);
        }
        text.push('\n');
    }
    text
}

/// A Markdown table.
fn marked(lines: &[[String; 8]]) -> String {
    let mut text = String::new();
    for (row, line) in lines.iter().enumerate() {
        let _ = writeln!(text, "| {} |", line.join(" | "));
        if row == 0 {
            let _ = writeln!(text, "| --- |{}", " ---: |".repeat(7));
        }
    }
    text
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
