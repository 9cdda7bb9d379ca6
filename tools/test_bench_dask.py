#!/usr/bin/env python3
"""A campaign on Dask that loses a worker gives what one process gives, byte for byte.

    cargo build --release && pip install distributed
    python tools/test_bench_dask.py [PROGRAM]

Starts a scheduler and two workers on the loopback address, kills one worker with SIGKILL once some trials are done, and compares every
result (all but `wall` and `machine`) and the CSV with a run by the program alone. Skipped, and says so, without `distributed`.
"""
import importlib.util
import json
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

TOOLS = Path(__file__).resolve().parent
SUITE = """
planners = ["wg-nbvp", "aep"]
scenes = ["closet"]
seeds = 12
time_limit = 30.0
"""


def results(folder):
    """Results without what belongs to the machine, as text in the order of their keys."""
    all_files = {}
    for path in sorted((folder / "trials").glob("*.json")):
        trial = json.loads(path.read_text())
        del trial["machine"], trial["result"]["wall"]
        all_files[path.name] = json.dumps(trial)
    return all_files


def wait_for(what, seconds, process=None):
    end = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < end, f"nothing after {seconds} s"
        assert process is None or process.poll() is None, "ended too early"
        time.sleep(0.05)


def main():
    if importlib.util.find_spec("distributed") is None:
        print("skipped: no module distributed (pip install distributed)")
        return
    program = sys.argv[1] if len(sys.argv) > 1 else str(TOOLS.parent / "target/release/seekplan")
    with tempfile.TemporaryDirectory() as name:
        folder, started = Path(name), []
        suite, alone, dask = folder / "suite.toml", folder / "alone", folder / "dask"
        suite.write_text(SUITE)
        bench = [program, "bench", "--suite", str(suite), "--quiet", "--out"]
        subprocess.run([*bench, str(alone)], check=True, stdout=subprocess.DEVNULL)
        wanted = results(alone)
        assert len(wanted) == 24

        def start(*words):
            log = open(folder / f"{len(started)}.log", "w")
            started.append(subprocess.Popen([sys.executable, "-m", *words], stdout=log, stderr=log))
            return started[-1]

        try:
            file = folder / "scheduler.json"
            start("dask", "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file))
            wait_for(file.exists, 60)
            address = json.loads(file.read_text())["address"]
            worker = ["dask", "worker", address, "--host", "127.0.0.1", "--nthreads", "1", "--no-nanny", "--no-dashboard"]
            victim, _ = start(*worker), start(*worker)
            driver = [str(TOOLS / "bench_dask.py"), "--suite", str(suite), "--out", str(dask)]
            run = subprocess.Popen([sys.executable, *driver, "--program", program, "--scheduler", address])
            started.append(run)
            wait_for(lambda: len(list((dask / "trials").glob("*.json"))) >= 4, 300, run)
            victim.send_signal(signal.SIGKILL)
            killed_at = len(list((dask / "trials").glob("*.json")))
            assert killed_at < 24, "too late to kill"
            assert run.wait(600) == 0
        finally:
            for process in started:
                process.kill()
                process.wait()
        got = results(dask)
        assert got.keys() == wanted.keys(), sorted(wanted.keys() - got.keys())
        for trial, text in wanted.items():
            assert got[trial] == text, trial
        assert (dask / "trials.csv").read_bytes() == (alone / "trials.csv").read_bytes()
        print(f"one of two workers killed after {killed_at} of 24 trials: all results equal those of one process")


if __name__ == "__main__":
    main()
