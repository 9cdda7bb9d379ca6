//! Plans on a nav2 map (map_server YAML and PGM) and draws the plan as SVG.
//!
//! ```text
//! cargo run --release -p hybrid-astar --example draw_plan -- MAP.yaml X Y YAW GOAL_X GOAL_Y [GOAL_YAW] \
//!     [--size LENGTH WIDTH] [--car RADIUS] [--out FILE.svg]
//! ```
#![allow(
    missing_docs,
    unreachable_pub,
    dead_code,
    clippy::print_stdout,
    clippy::disallowed_methods
)]

#[path = "../nav_maps/load.rs"]
mod load;

use hybrid_astar::{Drive, Footprint, GoalYaw, Motion, Params, Plan, plan};
use load::NavMap;
use std::error::Error;
use std::fmt::Write;
use std::path::PathBuf;

struct Ask {
    map: PathBuf,
    numbers: Vec<f64>,
    size: [f64; 2],
    drive: Drive,
    out: PathBuf,
}

fn ask() -> Result<Ask, Box<dyn Error>> {
    let usage = "usage: draw_plan MAP.yaml X Y YAW GOAL_X GOAL_Y [GOAL_YAW] [--size LENGTH WIDTH] [--car RADIUS] [--out FILE.svg]";
    let mut args = std::env::args().skip(1);
    let mut ask = Ask {
        map: args.next().ok_or(usage)?.into(),
        numbers: Vec::new(),
        size: [0.9, 0.6],
        drive: Drive::Differential,
        out: "plan.svg".into(),
    };
    while let Some(arg) = args.next() {
        let mut number =
            || -> Result<f64, Box<dyn Error>> { Ok(args.next().ok_or(usage)?.parse()?) };
        match arg.as_str() {
            "--size" => ask.size = [number()?, number()?],
            "--car" => ask.drive = Drive::ReedsShepp { radius: number()? },
            "--out" => ask.out = args.next().ok_or(usage)?.into(),
            _ => ask.numbers.push(arg.parse()?),
        }
    }
    if !(5..=6).contains(&ask.numbers.len()) {
        return Err(usage.into());
    }
    Ok(ask)
}

fn main() -> Result<(), Box<dyn Error>> {
    let ask = ask()?;
    let map = load::map(&ask.map)?;
    let n = &ask.numbers;
    let (start, goal) = ([n[0], n[1], n[2]], [n[3], n[4]]);
    let yaw = n.get(5).map_or(GoalYaw::Free, |&y| GoalYaw::Fixed(y));
    let (l, w) = (0.5 * ask.size[0], 0.5 * ask.size[1]);
    let outline = [[-l, -w], [l, -w], [l, w], [-l, w]];
    let params = Params {
        cell_size: map.cell.max(0.1),
        drive: ask.drive,
        ..Params::default()
    };
    let robot = Footprint::polygon(&outline);
    let plan = plan(&map.grid, &robot, start, goal, &yaw, &params)?;
    std::fs::write(&ask.out, draw(&map, &outline, start, goal, &plan)?)?;
    match &plan.reason {
        Some(reason) => println!("no path: {reason}"),
        None => println!(
            "{:.2} m, {:.1} s, {} stretches, {} expansions",
            plan.length,
            plan.seconds,
            plan.segments.len(),
            plan.expansions
        ),
    }
    println!("{}", ask.out.display());
    Ok(())
}

/// Runs of blocked cells as rectangles, the footprint along the way, the way coloured by its motion.
fn draw(
    map: &NavMap,
    outline: &[[f64; 2]],
    start: [f64; 3],
    goal: [f64; 2],
    plan: &Plan,
) -> Result<String, std::fmt::Error> {
    let [columns, rows] = map.size;
    let (width, height) = (columns as f64 * map.cell, rows as f64 * map.cell);
    let mut svg = String::new();
    writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.2} {height:.2}\" width=\"1000\">"
    )?;
    writeln!(
        svg,
        "<rect width=\"{width:.2}\" height=\"{height:.2}\" fill=\"white\"/>"
    )?;
    writeln!(svg, "<g fill=\"#444\">")?;
    for y in 0..rows {
        let row = &map.blocked[y * columns..(y + 1) * columns];
        let mut x = 0;
        while x < columns {
            let run = row[x..].iter().take_while(|b| **b).count();
            if run > 0 {
                writeln!(
                    svg,
                    "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{:.2}\"/>",
                    x as f64 * map.cell,
                    (rows - 1 - y) as f64 * map.cell,
                    run as f64 * map.cell,
                    map.cell
                )?;
            }
            x += run.max(1);
        }
    }
    writeln!(svg, "</g>")?;
    let place = |p: [f64; 2]| (p[0] - map.low[0], height - (p[1] - map.low[1]));
    let polygon = |svg: &mut String, pose: [f64; 3], style: &str| -> std::fmt::Result {
        let (sin, cos) = pose[2].sin_cos();
        write!(svg, "<polygon {style} points=\"")?;
        for c in outline {
            let (x, y) = place([
                pose[0] + cos * c[0] - sin * c[1],
                pose[1] + sin * c[0] + cos * c[1],
            ]);
            write!(svg, "{x:.3},{y:.3} ")?;
        }
        writeln!(svg, "\"/>")
    };
    let mut far = f64::INFINITY;
    for pair in plan.poses().windows(2) {
        far += (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1])
            + 0.5 * (pair[1][2] - pair[0][2]).abs();
        if far >= 0.5 {
            polygon(
                &mut svg,
                pair[0],
                "fill=\"#4a90d9\" fill-opacity=\"0.12\" stroke=\"#4a90d9\" stroke-width=\"0.01\"",
            )?;
            far = 0.0;
        }
    }
    for s in &plan.segments {
        let color = match s.motion {
            Motion::Forward => "#1b7837",
            Motion::Reverse => "#c51b7d",
            Motion::Turn => continue,
        };
        write!(
            svg,
            "<polyline fill=\"none\" stroke=\"{color}\" stroke-width=\"0.05\" points=\""
        )?;
        for p in &s.poses {
            let (x, y) = place([p[0], p[1]]);
            write!(svg, "{x:.3},{y:.3} ")?;
        }
        writeln!(svg, "\"/>")?;
    }
    polygon(
        &mut svg,
        start,
        "fill=\"none\" stroke=\"#1b7837\" stroke-width=\"0.04\"",
    )?;
    polygon(
        &mut svg,
        plan.end,
        "fill=\"none\" stroke=\"#b2182b\" stroke-width=\"0.04\"",
    )?;
    let (x, y) = place(goal);
    writeln!(
        svg,
        "<circle cx=\"{x:.3}\" cy=\"{y:.3}\" r=\"0.1\" fill=\"#b2182b\"/>"
    )?;
    writeln!(svg, "</svg>")?;
    Ok(svg)
}
