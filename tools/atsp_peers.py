#!/usr/bin/env python3
"""Times LKH (through pip's elkai) and atsp on the same instances in the same run, in CPU time of one thread.

    python3 -m venv /tmp/peers && /tmp/peers/bin/pip install elkai
    cargo build --release -p atsp --example figures
    /tmp/peers/bin/python tools/atsp_peers.py [--reps 5] [--seeds 11] FILE_OR_FOLDER...

Per instance LKH is called with the known optimum and told to stop there (its best case), five seeds, and with a single
trial (its first answer); then `figures --json` runs on the same file. Instances are TSPLIB `.atsp` files (optima.json
beside them) and exploration `.json` files (best.json). Paths become closed tours without big numbers as in the crate: start
and end are one node, or going back to the start costs nothing. LKH takes whole numbers: exploration costs, which are
rounded to 1 ms, are multiplied by 1000 and lose nothing. LKH's licence is academic: it is a measure from outside and is
neither linked nor vendored.
"""
import argparse
import glob
import json
import math
import os
import statistics
import subprocess
import sys
import time


def tsplib(path):
    """Rows of a full matrix."""
    text = open(path).read()
    head, body = text.split("EDGE_WEIGHT_SECTION")
    n = next(int(line.split(":")[1]) for line in head.splitlines() if line.strip().startswith("DIMENSION"))
    numbers = [float(word) for word in body.split()[: n * n]]
    return [numbers[i * n:(i + 1) * n] for i in range(n)]


def closed(path):
    """Rows of a closed tour in whole numbers, and the factor they were multiplied by."""
    if not path.endswith(".json"):
        return [[round(c) for c in row] for row in tsplib(path)], 1
    data = json.load(open(path))
    rows = [[math.inf if c is None else c for c in row] for row in data["cost"]]
    start, end = data["start"], data["end"]
    if data["kind"] == "path":
        keep = [start] + [i for i in range(data["n"]) if i not in (start, end)]
        rows = [[rows[i][end if j == start else j] for j in keep] for i in keep]
    elif data["kind"] == "open":
        rows = [[0.0 if j == start else c for j, c in enumerate(row)] for row in rows]
    finite = [[None if math.isinf(c) else round(1000 * c) for c in row] for row in rows]
    # A forbidden arc costs more than any tour.
    forbidden = 1 + sum(max([c for c in row if c is not None] or [0]) for row in finite)
    return [[forbidden if c is None else c for c in row] for row in finite], 1000


def best_known(path):
    name = os.path.splitext(os.path.basename(path))[0]
    listed = "best.json" if path.endswith(".json") else "optima.json"
    entry = json.load(open(os.path.join(os.path.dirname(path), listed)))[name]
    return entry["cost"] if isinstance(entry, dict) else entry


def lkh(rows, seed, settings):
    """CPU milliseconds and the tour's cost."""
    from elkai import _elkai
    n = len(rows)
    for i in range(n):
        rows[i][i] = 0
    matrix = "\n".join(" ".join(map(str, row)) for row in rows)
    problem = (f"TYPE : ATSP\nDIMENSION : {n}\nEDGE_WEIGHT_TYPE : EXPLICIT\n"
               f"EDGE_WEIGHT_FORMAT : FULL_MATRIX\nEDGE_WEIGHT_SECTION\n{matrix}\n")
    settings = "".join(f"{key} = {value}\n" for key, value in settings.items())
    begin = time.process_time()
    tour = [i - 1 for i in _elkai.solve_problem(f"{settings}SEED = {seed}\nPROBLEM_FILE = :stdin:\n", problem)]
    took = 1e3 * (time.process_time() - begin)
    if sorted(tour) != list(range(n)):
        sys.exit(f"LKH returned no tour of {n} nodes")
    return took, sum(rows[a][b] for a, b in zip(tour, tour[1:] + tour[:1]))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("paths", nargs="+")
    parser.add_argument("--reps", type=int, default=5, help="LKH seeds (5)")
    parser.add_argument("--seeds", type=int, default=11, help="atsp seeds (11)")
    parser.add_argument("--limit", type=float, default=1000, help="atsp: give up after so many ms (1000)")
    parser.add_argument("--figures", default="target/release/examples/figures", help="the built example")
    args = parser.parse_args()
    files = []
    for path in args.paths:
        found = sorted(glob.glob(f"{path}/*.atsp") + glob.glob(f"{path}/*.json")) if os.path.isdir(path) else [path]
        files += [f for f in found if os.path.basename(f) not in ("best.json", "optima.json")]
    print("| instance | n | LKH to the optimum, ms | hits | atsp, ms | hits | ratio | LKH first answer, ms | gap, % "
          "| atsp gap at 1 / 10 / 100 ms, % |\n|---|---|---|---|---|---|---|---|---|---|", flush=True)
    ratios = []
    for path in files:
        rows, factor = closed(path)
        if len(rows) < 3:
            continue
        best = round(best_known(path) * factor)
        stop = {"RUNS": 10, "STOP_AT_OPTIMUM": "YES", "OPTIMUM": best}
        to_best = [lkh(rows, seed, stop) for seed in range(1, args.reps + 1)]
        first = [lkh(rows, seed, {"RUNS": 1, "MAX_TRIALS": 1}) for seed in range(1, args.reps + 1)]
        ours = subprocess.run([args.figures, "--json", "--seeds", str(args.seeds), "--limit", str(args.limit), path],
                              check=True, capture_output=True, text=True).stdout
        ours = json.loads(ours)
        theirs = statistics.median(ms for ms, _ in to_best)
        hits = sum(cost <= best for _, cost in to_best)
        # Where atsp misses in most runs its time is no number, and the ratio none.
        mine = ours["ms_median"]
        ratio = theirs / mine if mine else 0.0
        ratios.append((ratio, ours["family"], ours["n"]))
        first_ms = statistics.median(ms for ms, _ in first)
        first_gap = statistics.median(100 * (cost - best) / best for _, cost in first)
        gaps = " / ".join("-" if ours[k] is None else f"{ours[k]:.3f}" for k in ("gap_1ms", "gap_10ms", "gap_100ms"))
        shown = "-" if mine is None else f"{mine:.3f}"
        print(f"| {ours['name']} | {ours['n']} | {theirs:.2f} | {hits}/{args.reps} | {shown} "
              f"| {ours['hits']}/{ours['seeds']} | {ratio:.1f} | {first_ms:.1f} | {first_gap:.3f} | {gaps} |", flush=True)
    print("\n| group | instances | ratio: least | median | geometric mean |\n|---|---|---|---|---|")
    groups = {"tsplib": lambda r: r[1] == "tsplib", "exploration, n <= 50": lambda r: r[1] != "tsplib" and r[2] <= 50,
              "exploration, n > 50": lambda r: r[1] != "tsplib" and r[2] > 50, "all": lambda r: True}
    for name, chosen in groups.items():
        group = [r[0] for r in ratios if chosen(r)]
        if group:
            mean = math.exp(sum(math.log(max(r, 1e-9)) for r in group) / len(group))
            print(f"| {name} | {len(group)} | {min(group):.1f} | {statistics.median(group):.1f} | {mean:.1f} |")


main()
