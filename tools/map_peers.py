#!/usr/bin/env python3
"""Our map against OctoMap and edt on the very same scans, in one run: prints ratios of CPU time.

    pip install numpy edt octomap-python
    python tools/map_peers.py [DIR] [--scans 8] [--workloads L15,L05,D15,D05] [--json]

Builds and runs `bench_scans` (voxmap/examples), which times our side and dumps its scans and obstacle grids; then inserts the
same scans with octomap-python (C++ OctoMap; every ray, and discretised) and transforms the same grids with edt. DIR holds real
scans (see voxmap/examples/bench_scans/files.rs). CPU time (ours and OctoMap of one thread, edt with parallel=1), medians; peers and ours take turns by workload.
Peers that are not installed are left out; ratios marked ~ are to peers measured elsewhere, by way of OctoMap (`THEN`).
"""
import argparse
import json
import os
import struct
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

# Peers that cannot be installed from a registry, ms per scan on the same kind of workload, measured once beside OctoMap's
# insertion of every ray (C++, all built with -O3 -march=native): OctoMap, Bonxai (deduped), FUEL's insertion and frontier search,
# ROG-Map. Their ratios to OctoMap stand for them here: ours / theirs = (OctoMap now / ours now) / (OctoMap then / theirs then).
THEN = {
    "L15": {"octomap": 45, "bonxai": 1.65, "fuel": 4.7, "fuel_frontiers": 4.1, "rog_map": 12.2},
    "L05": {"octomap": 984, "bonxai": 15.7, "fuel": 59, "fuel_frontiers": 193, "rog_map": 97},
    "D15": {"octomap": 9.3, "bonxai": 0.44, "fuel": 0.87, "fuel_frontiers": 1.3, "rog_map": 6.1},
    "D05": {"octomap": 202, "bonxai": 5.6, "fuel": 15.7, "fuel_frontiers": 40, "rog_map": 34},
}

ROOT = Path(__file__).resolve().parent.parent


def read_scans(path):
    """Origins and points of a dump: int32 n; per scan 3 x f32, int32 n, n x 3 x f32."""
    data = path.read_bytes()
    (n,), at, out = struct.unpack_from("<i", data), 4, []
    for _ in range(n):
        x, y, z, m = struct.unpack_from("<3fi", data, at)
        points = np.frombuffer(data, "<f4", 3 * m, at + 16).reshape(-1, 3).astype(float)
        out.append((np.array([x, y, z], float), points))
        at += 16 + 12 * m
    return out


def median_ms(times):
    return float(np.median(times) * 1e3)


def timed(call):
    # Of the whole process: edt computes in a thread of its own.
    start = time.process_time()
    result = call()
    return result, time.process_time() - start


def octomap_figures(workload, scans):
    import octomap

    out = {}
    for name, discrete in (("all", False), ("discrete", True)):
        tree, times = octomap.OcTree(workload["cell_size"]), []
        for origin, points in scans:
            times.append(timed(lambda: tree.insertPointCloud(points, origin, workload["max_range"], False, discrete))[1])
        out[f"insert_{name}_ms"] = median_ms(times)
        if name == "all":
            out["memory_mib"] = tree.memoryUsage() / 2**20
            rng, end = np.random.default_rng(3), np.zeros(3)
            n = 2000
            rays = [(scans[k % len(scans)][0], rng.uniform(-1, 1, 3)) for k in range(n)]
            cast = lambda: [tree.castRay(o, d, end, True, 10.0) for o, d in rays]
            out["cast_us"] = timed(cast)[1] / n * 1e6
    return out


def edt_figures(path):
    import edt

    nx, ny, nz = struct.unpack_from("<3i", path.read_bytes()[:12])
    grid = np.frombuffer(path.read_bytes(), np.uint8, offset=12).reshape(nz, ny, nx)
    forms = [grid.astype(bool), np.ascontiguousarray(grid), np.asfortranarray(grid)]
    best = min(median_ms([timed(lambda: edt.edtsq(form, parallel=1))[1] for _ in range(5)]) for form in forms)
    return {"edt_ms": best, "edt_ns_per_cell": best * 1e6 / grid.size}


def indirect(workload, octomap_ms):
    """Ratios to the peers of `THEN`, by way of OctoMap."""
    then, frontiers = THEN.get(workload["name"]), workload["frontiers"]
    if not then:
        return {}
    ours = {
        "bonxai": workload["insert_dedupe_ms"],
        "fuel": workload["insert_all_ms"],
        "rog_map": workload["insert_all_ms"],
        "fuel_frontiers": frontiers["clusters_like_fuel_update_ms"],
    }
    return {f"~{peer}": octomap_ms / ms * then[peer] / then["octomap"] for peer, ms in ours.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", help="real scans")
    parser.add_argument("--scans", type=int, default=8, help="scans per workload (0: all)")
    parser.add_argument("--workloads", default="", help="names, comma-separated; default all")
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    build = ["cargo", "build", "--release", "-q", "-p", "voxmap", "--example", "bench_scans"]
    subprocess.run(build, cwd=ROOT, check=True)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    rows = []
    with tempfile.TemporaryDirectory() as dump:
        command = [target / "release/examples/bench_scans", "--json", "--dump", dump, "--scans", str(args.scans)]
        command += ["--only", args.workloads] if args.workloads else []
        command += [args.folder] if args.folder else []
        ours = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout)
        for workload in ours["workloads"]:
            scans_file = Path(dump) / f"{workload['name']}.bin"
            if "insert_all_ms" not in workload or not scans_file.exists():
                continue
            row = {"name": workload["name"], "ours": workload, "octomap": {}, "edt": {}, "ratio": {}}
            try:
                row["octomap"] = o = octomap_figures(workload, read_scans(scans_file))
                row["ratio"]["insert_all"] = o["insert_all_ms"] / workload["insert_all_ms"]
                row["ratio"]["insert_dedupe"] = o["insert_discrete_ms"] / workload["insert_dedupe_ms"]
                row["ratio"]["insert_dedupe_to_all"] = o["insert_all_ms"] / workload["insert_dedupe_ms"]
                row["ratio"]["cast"] = o["cast_us"] / workload["queries"]["cast_us"]
                row["ratio"]["memory"] = o["memory_mib"] / workload["memory_mib"]
                row["ratio"].update(indirect(workload, o["insert_all_ms"]))
            except ImportError:
                pass
            grid_file = Path(dump) / f"{workload['name']}.occ"
            try:
                row["edt"] = e = edt_figures(grid_file)
                row["ratio"]["esdf"] = e["edt_ms"] / workload["esdf"]["whole_ms"]
            except ImportError:
                pass
            rows.append(row)
    if args.json:
        print(json.dumps({"calibration_ns_per_add": ours["calibration_ns_per_add"], "rows": rows}, indent=1))
        return
    print(f"calibration {ours['calibration_ns_per_add']:.2f} ns per dependent add")
    for row in rows:
        ratios = "  ".join(f"{k} {v:.1f}" for k, v in row["ratio"].items())
        print(f"{row['name']:>16}  {ratios}")


if __name__ == "__main__":
    main()
