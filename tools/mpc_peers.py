#!/usr/bin/env python3
"""ddp-rbf against its peers on the whole-body MPC benchmark, in one run on one machine.

    tools/mpc_peers.py --data ../shared/data/mpc --peers ../shared/research/bench_mpc_peers.py [--instances 00,07]
        [--python /path/to/venv/bin/python] [--json FILE]

Runs the example `mobile_manipulator` (built with cargo), then the peers' script with Crocoddyl (pip's wheel, one thread) and
HPIPM (the wheel inside casadi), then the example again, and prints ratios of medians of CPU time. The example is run before
and after the peers so that a machine that slows down in between is seen: the two runs should agree to some 20 %.
The peers need numpy, casadi and crocoddyl in the given Python, and g++.
"""
import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile


def ours(data, folder, build):
    command = ["cargo", "run", "--release", "-q", "-p", "ddp-rbf", "--example", "mobile_manipulator", "--"]
    if build:
        command = [build]
    out = subprocess.run(command + [folder, "--json", "--cells", "0.15"], capture_output=True, text=True)
    if out.returncode:
        sys.exit(f"the example failed: {out.stderr.strip()}")
    return json.loads(out.stdout)


def medians(run):
    """Microseconds per iteration, and to 1e-4 from the reference and from hold."""
    rows = [row["N60"][guess] for row in run["instances"] for guess in ("reference", "hold")]
    out = {"per iteration": statistics.median(r["us_per_iteration"] for r in rows)}
    for guess in ("reference", "hold"):
        out[f"to 1e-4 from {guess}"] = statistics.median(row["N60"][guess]["us_to_1e-4"] for row in run["instances"])
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", required=True, help="folder of problem.json and the instances")
    parser.add_argument("--peers", required=True, help="the script that runs the peers")
    parser.add_argument("--instances", help="two-digit numbers, comma separated; all by default")
    parser.add_argument("--python", default=sys.executable, help="Python that has the peers' packages")
    parser.add_argument("--binary", help="the example, already built")
    parser.add_argument("--json", help="write every figure here")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for name in sorted(os.listdir(asked.data)):
            wanted = asked.instances is None or name[:2] in asked.instances.split(",")
            if name == "problem.json" or (name.endswith(".json") and wanted):
                shutil.copy(os.path.join(asked.data, name), folder)
        first = medians(ours(asked.data, folder, asked.binary))
        rows_file = os.path.join(folder, "peers.out")
        peers = subprocess.run(
            [asked.python, asked.peers, "peers", "--data", folder, "--only", "crocoddyl,hpipm", "--N", "60", "--json", rows_file],
            capture_output=True, text=True)
        if peers.returncode:
            sys.exit(f"the peers failed: {peers.stderr.strip()[-500:]}")
        with open(rows_file) as file:
            rows = json.load(file)
        second = medians(ours(asked.data, folder, asked.binary))
    fddp = [r for r in rows if r["solver"] == "crocoddyl FDDP"]
    theirs = {"per iteration": statistics.median(r["per_iter_us"] for r in fddp)}
    for guess in ("reference", "hold"):
        theirs[f"to 1e-4 from {guess}"] = statistics.median(
            r["time_to_tol_us"] for r in fddp if r["guess"] == guess and r["time_to_tol_us"] > 0)
    print(f"{'N = 60, CPU microseconds':26} {'before':>9} {'after':>9} {'FDDP':>9}  ratio")
    for what in theirs:
        a, b, t = first[what], second[what], theirs[what]
        print(f"{what:26} {a:9.1f} {b:9.1f} {t:9.1f}  {t / a:.1f} to {t / b:.1f}")
    hpipm = [r["per_iter_us"] for r in rows if r["solver"] == "hpipm LQ"]
    if hpipm:
        print(f"HPIPM (wheel), one factorisation and solve of the LQ problem: {hpipm[0]:.1f} us")
    if asked.json:
        with open(asked.json, "w") as file:
            json.dump({"before": first, "after": second, "peers": rows}, file, indent=1)


if __name__ == "__main__":
    main()
