//! Searches for tags by several planners: Tables II and III of the HEATS paper, and suites of one's own.

use super::campaign::{BenchError, Flaw, Kept, Left, Order, Suite, Trial};
use super::curves::{Curve, curves};
use super::page::{Mark, Plot, Section, page};
use super::suite_file::{Resolved, SuiteFile, What};
use super::trial_file::{BUILD, Machine, TRIAL_SCHEMA, TrialFile, scene_hash};
use super::{left, spread};
use crate::baselines;
use crate::heats;
use crate::record::{Ended, Html, REPORT_FILE, RunResult};
use std::fmt::Write;

/// The suite of the paper's tables.
const EMBEDDED: &str = include_str!("../../suites/heats-tables.toml");

/// Figures of the paper: scene, row, time and its deviation (s), completeness (%), base path (m), joint rotation (rad). Times of
/// planners that did not finish are absent.
type Published = (
    &'static str,
    &'static str,
    Option<(f64, f64)>,
    f64,
    f64,
    f64,
);

/// HEATS, Tables II and III.
const PUBLISHED: [Published; 8] = [
    ("office", "wg-nbvp", None, 42.5, 154.81, 750.35),
    ("office", "aep", None, 50.0, 198.28, 1102.24),
    (
        "office",
        "heats-camera",
        Some((581.0, 25.0)),
        100.0,
        149.35,
        391.11,
    ),
    (
        "office",
        "heats",
        Some((556.0, 13.0)),
        100.0,
        140.63,
        383.23,
    ),
    ("maze", "wg-nbvp", None, 60.0, 158.13, 910.28),
    ("maze", "aep", None, 85.0, 165.40, 1304.68),
    (
        "maze",
        "heats-camera",
        Some((468.0, 27.0)),
        100.0,
        152.04,
        428.14,
    ),
    ("maze", "heats", Some((420.0, 21.0)), 100.0, 143.72, 415.63),
];

/// A suite of searches for tags.
#[derive(Clone, Debug)]
pub struct HeatsTables {
    resolved: Resolved,
    hashes: Vec<String>,
}

/// A trial by its place in the suite.
#[derive(Clone, Copy)]
struct Place {
    scene: usize,
    row: usize,
    seed: usize,
}

impl HeatsTables {
    /// The suite of a file; `trials`: seeds in place of the file's.
    ///
    /// # Errors
    /// [`BenchError::Suite`] naming the field that is wrong.
    pub fn new(file: &SuiteFile, trials: Option<usize>) -> Result<Self, BenchError> {
        let resolved = file.resolve(trials)?;
        let hashes = resolved.scenes.iter().map(|(_, s)| scene_hash(s)).collect();
        Ok(Self { resolved, hashes })
    }

    /// WG-NBVP, AEP, HEATS without LiDAR, HEATS and heats-plus in office and maze.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn embedded(trials: Option<usize>) -> Result<Self, BenchError> {
        Self::new(&SuiteFile::from_toml(EMBEDDED)?, trials)
    }

    fn places(&self) -> Vec<Place> {
        let r = &self.resolved;
        let mut all = Vec::new();
        for scene in 0..r.scenes.len() {
            for row in 0..r.rows.len() {
                all.extend((0..r.seeds.len()).map(|seed| Place { scene, row, seed }));
            }
        }
        all
    }

    fn name(&self, p: Place) -> String {
        let r = &self.resolved;
        format!(
            "{}.{}.seed{:02}",
            r.scenes[p.scene].0, r.rows[p.row].name, r.seeds[p.seed]
        )
    }

    fn what(&self, p: Place) -> What {
        let r = &self.resolved;
        r.rows[p.row].what.seeded(r.seeds[p.seed])
    }

    /// Runs a trial; none if it was stopped.
    fn trial(&self, p: Place, order: Order<'_>) -> Result<Option<Left>, String> {
        let scene = &self.resolved.scenes[p.scene].1;
        let mut recorded = order.reports.then(Html::unwritten);
        let quiet = &mut |_: &crate::report::Status<'_>| ();
        let run = match self.what(p) {
            What::Heats(s) => heats::run_recorded(scene, &s, order.stop, quiet, &mut recorded),
            What::Baseline(s) => {
                baselines::run_recorded(scene, &s, order.stop, quiet, &mut recorded)
            }
        };
        let result = run.map_err(|e| e.to_string())?.result;
        if result.ended == Ended::Interrupted {
            return Ok(None);
        }
        let [version, sources, rustc] = BUILD.map(str::to_owned);
        let file = TrialFile {
            schema: TRIAL_SCHEMA.to_owned(),
            trial: self.name(p),
            scene_hash: self.hashes[p.scene].clone(),
            version,
            sources,
            rustc,
            result,
            machine: Machine::here(),
        };
        let left = left(&file, &file.result, recorded).map_err(|e| e.to_string())?;
        Ok(Some(left))
    }
}

impl Suite for HeatsTables {
    fn trials(&self) -> Vec<Trial> {
        let places = self.places().into_iter().enumerate();
        places
            .map(|(group, p)| Trial {
                name: self.name(p),
                group,
            })
            .collect()
    }

    fn run_group(
        &self,
        group: usize,
        order: Order<'_>,
        deliver: &mut dyn FnMut(usize, Left) -> bool,
    ) -> Result<(), String> {
        let places = self.places();
        let Some(&place) = places.get(group).filter(|_| (order.wanted)(group)) else {
            return Ok(());
        };
        if let Some(left) = self.trial(place, order)? {
            deliver(group, left);
        }
        Ok(())
    }

    fn check(&self, trial: usize, json: &str) -> Result<(), Flaw> {
        let place = self.places()[trial];
        let (hash, settings) = (&self.hashes[place.scene], self.what(place).to_toml());
        TrialFile::from_json(json)?.check(&self.name(place), hash, &settings)
    }

    fn report(&self, results: &[Kept]) -> Result<(String, Vec<(String, String)>), String> {
        let files: Vec<TrialFile> = results
            .iter()
            .map(|kept| TrialFile::from_json(&kept.result).map_err(|e| e.to_string()))
            .collect::<Result<_, _>>()?;
        let places = self.places();
        // Trials of a scene and a row, seed by seed.
        let of = |scene: usize, row: usize| -> Vec<(&RunResult, &Kept)> {
            let own = places.iter().zip(files.iter().zip(results));
            own.filter(|(p, _)| p.scene == scene && p.row == row)
                .map(|(_, (file, kept))| (&file.result, kept))
                .collect()
        };
        let mut second = vec![SECOND.map(String::from).to_vec()];
        let mut third = vec![THIRD.map(String::from).to_vec()];
        let mut sections = Vec::new();
        for (scene, (scene_name, _)) in self.resolved.scenes.iter().enumerate() {
            let (mut lines, mut more) = (vec![second[0].clone()], vec![third[0].clone()]);
            for (row, r) in self.resolved.rows.iter().enumerate() {
                let own: Vec<&RunResult> = of(scene, row).iter().map(|(r, _)| *r).collect();
                let (a, b) = summary(scene_name, &r.name, &own);
                lines.push(a);
                more.push(b);
            }
            second.extend(lines[1..].iter().cloned());
            third.extend(more[1..].iter().cloned());
            sections.push(self.section(scene, &lines, &more, &of));
        }
        let (mut table, mut markdown) = (String::new(), String::new());
        for (title, number, lines) in [(SECOND_TITLE, "II", &second), (THIRD_TITLE, "III", &third)]
        {
            let title = if self.is_the_papers() {
                format!("{title} (HEATS, Table {number})")
            } else {
                title.to_owned()
            };
            let lines = self.columns(lines);
            let _ = writeln!(table, "{title}\n{}", plain(&lines));
            let _ = writeln!(markdown, "**{title}**\n\n{}", marked(&lines));
        }
        let [version, sources, rustc] = BUILD;
        let build = format!("seekplan {version} of sources {sources}, {rustc}.");
        let (heading, notes) = if self.is_the_papers() {
            (PAPERS_TITLE, format!("{NOTES}{PAPER_NOTE}"))
        } else {
            (TITLE, format!("{NOTES}."))
        };
        for note in [&notes, &build] {
            let _ = writeln!(table, "{note}");
            let _ = writeln!(markdown, "{note}\n");
        }
        let html = page(heading, &[notes, build, MARKS.into()], &sections);
        Ok((
            table,
            vec![
                ("tables.md".into(), markdown),
                ("trials.csv".into(), csv(&files)),
                (REPORT_FILE.into(), html),
            ],
        ))
    }
}

impl HeatsTables {
    /// Whether the paper has figures of any row.
    fn is_the_papers(&self) -> bool {
        let r = &self.resolved;
        let has = |p: &Published| {
            let scene = r.scenes.iter().any(|(name, _)| name == p.0);
            scene && r.rows.iter().any(|row| row.name == p.1)
        };
        PUBLISHED.iter().any(has)
    }

    /// Lines without the paper's columns where it has nothing to say.
    fn columns(&self, lines: &[Vec<String>]) -> Vec<Vec<String>> {
        let heads = lines.first().cloned().unwrap_or_default();
        let stays = |c: &usize| self.is_the_papers() || heads[*c] != PAPER;
        let kept: Vec<usize> = (0..heads.len()).filter(stays).collect();
        let pick = |line: &Vec<String>| kept.iter().map(|&c| line[c].clone()).collect();
        lines.iter().map(pick).collect()
    }

    /// A scene's part of the page.
    fn section<'a>(
        &self,
        scene: usize,
        second: &[Vec<String>],
        third: &[Vec<String>],
        of: &dyn Fn(usize, usize) -> Vec<(&'a RunResult, &'a Kept)>,
    ) -> Section {
        let rows = &self.resolved.rows;
        let plot = |title: &str, digits, value: &dyn Fn(&RunResult) -> f64| Plot {
            title: title.into(),
            digits,
            reference: None,
            rows: (0..rows.len())
                .map(|row| {
                    let own = of(scene, row);
                    let mark = |(result, kept): &(&RunResult, &Kept)| {
                        Mark::new(value(result), format!("seed {}", result.seed), kept)
                    };
                    (rows[row].name.clone(), own.iter().map(mark).collect())
                })
                .collect(),
        };
        let over_time = |title: &str, value: &dyn Fn(&RunResult, usize) -> f64| {
            let curve = |row: usize| -> Curve {
                let trials = of(scene, row).into_iter().map(|(result, _)| {
                    let samples = result.progress.iter().enumerate();
                    samples.map(|(k, p)| (p.time_s, value(result, k))).collect()
                });
                (rows[row].name.clone(), trials.collect())
            };
            curves(title, &(0..rows.len()).map(curve).collect::<Vec<_>>())
        };
        // Both tables side by side: the second's first two columns say the same.
        let table = second
            .iter()
            .zip(third)
            .map(|(a, b)| a.iter().chain(&b[2..]).cloned().collect())
            .collect::<Vec<Vec<String>>>();
        let table = self.columns(&table);
        Section {
            title: self.resolved.scenes[scene].0.clone(),
            table,
            figures: vec![
                over_time("explored space over time", &|r, k| r.progress[k].explored),
                over_time("inspected surface over time", &|r, k| {
                    r.progress[k].inspected
                }),
                over_time("tags found over time", &|r, k| {
                    r.progress[k].found as f64 / (r.targets as f64).max(1.0)
                }),
            ],
            plots: vec![
                plot("search time, s", 0, &|r| r.search_time_s),
                plot("completeness, %", 1, &|r| 100.0 * r.completeness),
                plot("base path, m", 1, &|r| r.base_path_m),
                plot("joint rotation, rad", 1, &|r| r.joint_rotation_rad),
            ],
        }
    }
}

const TITLE: &str = "Searches for tags";
const PAPERS_TITLE: &str = "HEATS, Tables II and III";
const SECOND_TITLE: &str = "Search time and completeness";
const THIRD_TITLE: &str = "Base path and joint rotation";
/// Heading of the paper's figures.
const PAPER: &str = "paper";
const SECOND: [&str; 10] = [
    "scene",
    "planner",
    "time, s",
    PAPER,
    "at the limit",
    "completeness, %",
    PAPER,
    "last tag, s",
    "inspected, %",
    "seen, %",
];
const THIRD: [&str; 6] = [
    "scene",
    "planner",
    "base path, m",
    PAPER,
    "joint rotation, rad",
    PAPER,
];
const NOTES: &str = "Mean ± standard deviation over seeds; at the limit: trials that the time limit ended; last tag: when the last one found was found; inspected: by the rules of the planner itself; seen: in sight once in a sharp image, by exact geometry and the same for all";
const PAPER_NOTE: &str = "; paper: what the HEATS paper reports for its own simulator, scenes of the same size and tags of its own.";
const MARKS: &str = "Curves: mean over seeds, and the band between the least and the most. Boxes: median and quartiles, with whiskers to \
    the farthest trial within 1.5 of the box's width. Every mark is a trial and opens its report, or its result where the campaign was run without --reports. The settings in a \
    result, saved as a TOML file, repeat the trial: seekplan heats --scene SCENE --config FILE --out DIR.";

/// A row of both tables.
fn summary(scene: &str, row: &str, results: &[&RunResult]) -> (Vec<String>, Vec<String>) {
    let of = |f: &dyn Fn(&RunResult) -> f64, digits: usize| {
        let (mean, deviation) = spread(results.iter().map(|r| f(r)));
        format!("{mean:.digits$} ± {deviation:.digits$}")
    };
    let limited = results.iter().filter(|r| r.ended == Ended::TimeLimit);
    let published = PUBLISHED.iter().find(|p| p.0 == scene && p.1 == row);
    let paper = |f: &dyn Fn(&Published) -> String| published.map_or("-".into(), f);
    let names = || [scene.to_owned(), row.to_owned()];
    let time = paper(&|p| match p.2 {
        Some((mean, deviation)) => format!("{mean:.0} ± {deviation:.0}"),
        None => "> 900".into(),
    });
    let second = [
        of(&|r| r.search_time_s, 0),
        time,
        format!("{} of {}", limited.count(), results.len()),
        of(&|r| 100.0 * r.completeness, 1),
        paper(&|p| format!("{:.1}", p.3)),
        of(&|r| r.last_target_time_s, 0),
        of(&|r| 100.0 * r.inspected_fraction, 1),
        of(&|r| 100.0 * r.seen_fraction, 1),
    ];
    let third = [
        of(&|r| r.base_path_m, 1),
        paper(&|p| format!("{:.1}", p.4)),
        of(&|r| r.joint_rotation_rad, 1),
        paper(&|p| format!("{:.1}", p.5)),
    ];
    (
        names().into_iter().chain(second).collect(),
        names().into_iter().chain(third).collect(),
    )
}

/// One line for each trial. Nothing in it depends on the machine.
fn csv(files: &[TrialFile]) -> String {
    let mut text = String::from(
        "trial,scene,scene_hash,planner,sensors,seed,ended,targets,found,completeness,search_time_s,last_target_time_s,base_path_m,\
         joint_rotation_rad,explored_fraction,inspected_fraction,seen_fraction,collisions,min_clearance_m,limit_violations,decisions,views_reached,\
         planning_time_s,version,sources\n",
    );
    for f in files {
        let r = &f.result;
        let ended = match r.ended {
            Ended::Complete => "complete",
            Ended::TimeLimit => "time_limit",
            Ended::Interrupted => "interrupted",
        };
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{ended},{},{},{:.4},{:.2},{:.2},{:.3},{:.3},{:.5},{:.5},{:.5},{},{:.4},{},{},{},{:.4},{},{}",
            f.trial,
            r.scene,
            f.scene_hash,
            r.planner,
            r.sensors,
            r.seed,
            r.targets,
            r.found,
            r.completeness,
            r.search_time_s,
            r.last_target_time_s,
            r.base_path_m,
            r.joint_rotation_rad,
            r.explored_fraction,
            r.inspected_fraction,
            r.seen_fraction,
            r.collisions,
            r.min_clearance_m,
            r.limit_violations,
            r.decisions,
            r.views_reached,
            r.planning_time_s,
            f.version,
            f.sources,
        );
    }
    text
}

/// Columns of equal width: the first two to the left, the others to the right.
fn plain(lines: &[Vec<String>]) -> String {
    let columns = lines.first().map_or(0, Vec::len);
    let width = |c: usize| lines.iter().map(|l| l[c].chars().count()).max();
    let mut text = String::new();
    for line in lines {
        for c in 0..columns {
            let wide = width(c).unwrap_or(0);
            let _ = if c < 2 {
                write!(text, "  {:<wide$}", line[c])
            } else {
                write!(text, "  {:>wide$}", line[c])
            };
        }
        text.push('\n');
    }
    text
}

/// A Markdown table.
fn marked(lines: &[Vec<String>]) -> String {
    let mut text = String::new();
    for (row, line) in lines.iter().enumerate() {
        let _ = writeln!(text, "| {} |", line.join(" | "));
        if row == 0 {
            let _ = writeln!(text, "| --- | --- |{}", " ---: |".repeat(line.len() - 2));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stand_beside_the_papers_figures() {
        let suite = HeatsTables::embedded(Some(1)).expect("embedded");
        assert!(suite.is_the_papers());
        let (second, third) = summary("office", "aep", &[]);
        assert_eq!((second[3].as_str(), second[6].as_str()), ("> 900", "50.0"));
        assert_eq!((third[3].as_str(), third[5].as_str()), ("198.3", "1102.2"));
        let (second, _) = summary("maze", "heats-camera", &[]);
        assert_eq!(
            (second[3].as_str(), second[6].as_str()),
            ("468 ± 27", "100.0")
        );
        let (second, third) = summary("maze", "heats-plus", &[]);
        assert_eq!((second[3].as_str(), third[5].as_str()), ("-", "-"));
        // Every figure of the paper has its row in the suite.
        for p in PUBLISHED {
            assert!(suite.resolved.scenes.iter().any(|(name, _)| name == p.0));
            assert!(
                suite.resolved.rows.iter().any(|row| row.name == p.1),
                "{}",
                p.1
            );
        }
        assert_eq!(
            suite.columns(&[SECOND.map(String::from).to_vec()])[0].len(),
            10
        );
        let text = EMBEDDED.replace("\"office\", \"maze\"", "\"closet\"");
        let file = SuiteFile::from_toml(&text).expect("valid");
        let own = HeatsTables::new(&file, None).expect("valid");
        assert_eq!(
            own.columns(&[SECOND.map(String::from).to_vec()])[0].len(),
            8
        );
    }
}
