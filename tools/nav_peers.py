#!/usr/bin/env python3
"""hybrid-astar against OMPL's RRT-Connect with simplification on the same queries: prints ratios of CPU time and length.

    pip install numpy scipy ompl
    python tools/nav_peers.py DIR [--only NAME] [--seconds 5] [--seed 1] [--json]

Builds and runs `nav_maps` (hybrid-astar/examples) on the folder of maps, then plans the feasible queries with fixed goal
heading in OMPL's Reeds-Shepp space (smallest radius 0.4 m; it cannot turn in place). OMPL's validity check is a look-up in a
table of free poses (5 cm or a cell, 5 degrees; made beforehand and not counted), so that calls from C++ into Python cost
little; paths are then looked at again with the exact footprint. CPU time of one thread.
"""
import argparse
import json
import subprocess
import time
from pathlib import Path

import numpy as np
from scipy.signal import fftconvolve

ROOT = Path(__file__).resolve().parent.parent
HEADINGS = 72
RADIUS = 0.4


def read_map(path):
    """Free cells, row 0 at the lowest y, and the side of a cell."""
    head = path.read_bytes().split(None, 4)
    width, height = int(head[1]), int(head[2])
    grey = np.frombuffer(head[4][: width * height], np.uint8).reshape(height, width)[::-1]
    yaml = dict(line.split(":", 1) for line in path.with_suffix(".yaml").read_text().splitlines() if ":" in line)
    return grey >= 250, float(yaml["resolution"])


def inside(footprint, x, y):
    within = np.ones(np.shape(x), bool)
    for (ax, ay), (bx, by) in zip(footprint, np.roll(footprint, -1, axis=0)):
        within &= (bx - ax) * (y - ay) - (by - ay) * (x - ax) >= 0.0
    return within


def free_poses(free, cell, footprint):
    """free[heading, row, column]: no blocked or outside cell centre in the footprint at the cell's middle."""
    reach = int(np.ceil(np.hypot(*footprint.T).max() / cell)) + 1
    blocked = np.pad((~free).astype(np.float32), reach, constant_values=1.0)
    grid = np.arange(-reach, reach + 1) * cell
    out = np.zeros((HEADINGS, *free.shape), bool)
    for k in range(HEADINGS):
        a = 2 * np.pi * k / HEADINGS
        x, y = np.meshgrid(grid, grid)
        mask = inside(footprint, np.cos(a) * x + np.sin(a) * y, np.cos(a) * y - np.sin(a) * x)
        # Convolution with the mirrored mask counts the blocked cells in it.
        out[k] = fftconvolve(blocked, mask[::-1, ::-1].astype(np.float32), mode="valid") < 0.5
    return out


def violations(free, cell, footprint, path):
    rows, columns = np.nonzero(np.pad(~free, 1, constant_values=True))
    px, py = (columns - 0.5) * cell, (rows - 0.5) * cell
    bad = 0
    for x, y, a in path:
        dx, dy = px - x, py - y
        near = np.hypot(dx, dy) < 1.2
        dx, dy = dx[near], dy[near]
        bad += inside(footprint, np.cos(a) * dx + np.sin(a) * dy, np.cos(a) * dy - np.sin(a) * dx).any()
    return int(bad)


def ompl_plan(table, cell, query, seconds):
    from ompl import base as ob
    from ompl import geometric as og

    _, height, width = table.shape
    space = ob.ReedsSheppStateSpace(RADIUS)
    bounds = ob.RealVectorBounds(2)
    bounds.setLow(0.0)
    bounds.setHigh(0, width * cell)
    bounds.setHigh(1, height * cell)
    space.setBounds(bounds)
    setup = og.SimpleSetup(space)
    cells, scale = table.tolist(), HEADINGS / (2 * np.pi)

    def valid(state):
        u, v = int(state.getX() / cell), int(state.getY() / cell)
        return 0 <= u < width and 0 <= v < height and cells[round(state.getYaw() * scale) % HEADINGS][v][u]

    setup.setStateValidityChecker(valid)
    setup.getSpaceInformation().setStateValidityCheckingResolution(0.05 / space.getMaximumExtent())
    ends = []
    for pose in (query["start"], query["goal"]):
        state = space.allocState()
        state.setX(pose[0])
        state.setY(pose[1])
        state.setYaw(pose[2])
        ends.append(state)
    setup.setStartAndGoalStates(*ends)
    setup.setPlanner(og.RRTConnect(setup.getSpaceInformation()))
    begin = time.process_time()
    solved = setup.solve(seconds)
    if solved and setup.haveExactSolutionPath():
        setup.simplifySolution()
    took = (time.process_time() - begin) * 1e3
    if not (solved and setup.haveExactSolutionPath()):
        return None, took, []
    path = setup.getSolutionPath()
    length = path.length()
    path.interpolate(max(2, int(length / 0.05)))
    return length, took, [(s.getX(), s.getY(), s.getYaw()) for s in path.getStates()]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    try:
        from ompl import util
    except ImportError as error:
        print(f"skipped: python package `ompl` is missing: {error}")
        return
    util.RNG.setSeed(args.seed)
    util.setLogLevel(util.LogLevel.LOG_NONE)
    command = ["cargo", "run", "--release", "-q", "-p", "hybrid-astar", "--example", "nav_maps", "--"]
    ours = subprocess.run(command + [str(args.folder), "--json", "--only", args.only], cwd=ROOT, check=True, capture_output=True)
    ours = {(q["map"], q["id"]): q for q in json.loads(ours.stdout)["queries"] if q["yaw"] == "fixed"}
    rows = []
    for file in sorted(args.folder.glob("*.json")):
        if args.only not in file.stem or not file.with_suffix(".pgm").exists():
            continue
        data = json.loads(file.read_text())
        footprint = np.array(data["footprint"])
        free, cell = read_map(file.with_suffix(".pgm"))
        table = free_poses(free, cell, footprint)
        for query in data["queries"]:
            own = ours.get((file.stem, query["id"]))
            if query["class"] == "infeasible" or own is None:
                continue
            length, took, path = ompl_plan(table, cell, query, args.seconds)
            rows.append({
                "map": file.stem, "id": query["id"], "ours_ms": own["total_ms"], "ompl_ms": took,
                "ours_length": own["length"], "ompl_length": length, "ours_solved": own["solved"],
                "ompl_violations": violations(free, cell, footprint, path),
            })
    both = [r for r in rows if r["ompl_length"] and r["ours_solved"]]
    spread = lambda key: {f"p{q}": round(float(np.percentile([r[key] for r in rows], q)), 3) for q in (50, 95, 99)}
    report = {
        "queries": len(rows), "ours_solved": sum(r["ours_solved"] for r in rows),
        "ompl_solved": sum(r["ompl_length"] is not None for r in rows),
        "ompl_paths_that_touch": sum(r["ompl_violations"] > 0 for r in rows),
        "ours_ms": spread("ours_ms"), "ompl_ms": spread("ompl_ms"),
        "p95_ours_over_ompl": round(spread("ours_ms")["p95"] / spread("ompl_ms")["p95"], 4),
        "length_ours_over_ompl_median": round(float(np.median([r["ours_length"] / r["ompl_length"] for r in both])), 4),
    }
    if args.json:
        report["rows"] = rows
    print(json.dumps(report, indent=1))


if __name__ == "__main__":
    main()
